//! The one place that finds contacts of knots with the target, has them solved, and writes `State::contacts`.
//!
//! Who solves them is the scene's choice (`solver.contact`): a solver of ours on rows, within every
//! (sub-)step or part of a step of the engine, or the engine, which is read after its step. Contacts of another kind come as [`SurfaceContacts`]
//! of cables and as [`super::strands`], which effects bring.
//!
//! A step in order: [`begin`](ContactManager::begin), [`update`](ContactManager::update) (detection, where it is
//! due), [`solve`](ContactManager::solve) in every sub-step or [`read_engine`](ContactManager::read_engine),
//! [`report`](ContactManager::report).

use super::cable_planes::CablePlanes;
use super::engine::EngineContacts;
use super::gauss_seidel::IterationLimits;
use super::lookahead::Lookahead;
use super::penalty::PenaltyForce;
use super::row::{NetMotion, OfParting, Parting, PushOut, RowSource};
use super::solver::{ContactSolver, NormalSolver};
use super::surface::{Feature, SurfaceContacts};
use super::woodbury::{self, Woodbury};
use crate::friction::Law;
use crate::net::Net;
use crate::solver::{ContactModel, Solver};
use crate::state::{Body, Contact, Knots, State, TARGET};
use crate::target::Target;
use crate::world::World;

/// Speed that the engine's cables may give a place on a cable, or a knot, within a step [m/s]: nearer than that, it has a row. Where knots have none
/// they are drawn in until [`RowSource::lacks`] tells: with 1 m/s one knot of `stress e-6` came 8.4 of its radius deep, with 3, 10 and
/// 30 m/s none deeper than a tenth of it.
const DRAWN_IN: f64 = 1.0;
const DRAWN_IN_KNOTS: f64 = 10.0;

/// What contacts of a scene are made of.
#[derive(Clone, Copy)]
pub struct ContactSettings<'a> {
    /// The net.
    pub net: &'a Net,
    /// The target.
    pub target: &'a Target,
    /// The numerical method.
    pub solver: &'a Solver,
    /// Friction, where an effect asks for it.
    pub friction: Option<Law>,
    /// Contact margin: distance from which planes are looked for [m].
    pub margin: f64,
    /// Speed of contact that steps are chosen for [m/s].
    pub speed: f64,
    /// Whether contacts take turns with what moves the cables, and are not answered in every sub-step of it.
    pub in_turn: bool,
    /// Whether more of the net touches than its knots, and presses these in.
    pub more_touches: bool,
    /// Whether an impulse on a knot moves others at once, as one on a coordinate of elements moves all that shares a cable
    /// with it: rows of different knots then act on each other all the same.
    pub coupled: bool,
}

impl ContactSettings<'_> {
    /// Contacts of the knots, by a solver of ours; none where the engine solves them.
    pub fn of_knots(&self) -> Option<SurfaceContacts> {
        let by_impulse = self.solver.contact == ContactModel::Impulse;
        // Those that act before the engine share one problem with what it is about to do.
        let ahead = self.in_turn && by_impulse;
        let coupled = self.coupled || ahead;
        let normal = match self.solver.contact {
            ContactModel::Rapier => return None,
            ContactModel::Impulse if coupled => NormalSolver::GaussSeidel { lookahead: None },
            ContactModel::Impulse => NormalSolver::Woodbury(Woodbury::default()),
            ContactModel::Penalty => NormalSolver::Penalty {
                force: PenaltyForce::new(self.net, &self.solver.penalty),
                speed: self.speed,
                of_cables: false,
                in_turn: false,
            },
        };
        let solver = ContactSolver { normal, friction: self.friction, coupled };
        // What others press in is not to be pushed out against all their tension: at a metre a second a free Cubesat's net whose
        // strands touch made 2e-3 to 4e-3 of the energy at hand at once, in 2 of 32 members.
        let push_out = if ahead {
            PushOut::of_knots_ahead(self.net.launch_energy())
        } else if self.more_touches {
            PushOut::of_pressed_knots(self.net.launch_energy())
        } else {
            PushOut::Speed(woodbury::PUSH_OUT)
        };
        let parting = Parting {
            restitution: self.solver.restitution,
            push_out,
            in_turn: ahead,
            of_parting: OfParting::Held,
        };
        let feature = Feature::knots(self.net, self.target, self.solver.precision);
        let drawn_in = ahead.then_some(DRAWN_IN_KNOTS);
        let contacts = SurfaceContacts::new(feature, self.target, self.margin, solver, parting, drawn_in);
        // Elements move half a step, are kicked, and move half a step.
        Some(if self.coupled { contacts.in_time() } else { contacts })
    }

    /// Contacts of the cables. The engine has no row for two knots and a target: where it solves the knots'
    /// contacts, those of cables are solved by impulses of ours.
    pub fn of_cables(&self) -> SurfaceContacts {
        let ContactSettings { net, target, solver, in_turn, .. } = *self;
        let by_force = solver.contact == ContactModel::Penalty;
        // Of 40 drawn nets 3 made more than 1e-3 where forces on places that slide take turns with the engine's cables (4.7e-3 at most),
        // for none; and of 16 with friction 1 on both sides of a panel 4 (1.1e-2), for none.
        let slides = !by_force || !in_turn && self.friction.is_none();
        let normal = if by_force {
            let force = PenaltyForce::new(net, &solver.penalty);
            NormalSolver::Penalty { force, speed: self.speed, of_cables: true, in_turn }
        } else {
            NormalSolver::GaussSeidel {
                lookahead: in_turn.then(|| Lookahead::new(net, IterationLimits::AHEAD)),
            }
        };
        SurfaceContacts::new(
            Feature::Cables(CablePlanes::new(net, target, solver.precision, by_force, slides)),
            target,
            self.margin,
            ContactSolver { normal, friction: self.friction, coupled: true },
            Parting {
                restitution: if by_force { 0.0 } else { solver.restitution },
                push_out: PushOut::of_cables(in_turn, net.launch_energy()),
                in_turn,
                of_parting: OfParting::Held,
            },
            in_turn.then_some(DRAWN_IN),
        )
    }
}

/// Contacts of the knots with the target.
pub enum ContactManager {
    /// There is nothing to touch.
    Absent,
    /// Solved here.
    Own(Box<SurfaceContacts>),
    /// Solved by the engine.
    Engine(Box<EngineContacts>),
}

impl ContactManager {
    /// The contacts of `settings`, of none where there is no target.
    pub fn new(settings: Option<&ContactSettings<'_>>) -> ContactManager {
        let Some(settings) = settings else { return ContactManager::Absent };
        match settings.of_knots() {
            Some(own) => ContactManager::Own(Box::new(own)),
            None => {
                let ContactSettings { net, target, solver, .. } = *settings;
                ContactManager::Engine(Box::new(EngineContacts::new(net, target, solver.restitution)))
            }
        }
    }

    /// Whether a solver of ours answers.
    pub fn is_own(&self) -> bool {
        matches!(self, ContactManager::Own(_))
    }

    /// Whether the engine answers.
    pub fn is_of_engine(&self) -> bool {
        matches!(self, ContactManager::Engine(_))
    }

    /// Whether impulses of ours answer, with restitution.
    pub fn bounce(&self) -> bool {
        self.own().is_some_and(SurfaceContacts::bounce)
    }

    /// Whether impulses of ours answer.
    pub fn is_by_impulse(&self) -> bool {
        self.own().is_some_and(|own| !own.is_force())
    }

    /// Whether forces of ours answer.
    pub fn is_by_force(&self) -> bool {
        self.own().is_some_and(SurfaceContacts::is_force)
    }

    /// Forgets the contacts of the step before, or of one that is done again.
    pub fn begin(&self, state: &mut State) {
        state.contacts.clear();
    }

    /// Forgets what was answered since the start of the step, which is done again.
    pub fn rollback(&mut self) {
        if let ContactManager::Own(own) = self {
            own.forget();
        }
    }

    /// Before a step of `step` seconds from `state`: finds the planes anew where they are stale.
    pub fn update(&mut self, state: &State, step: f64) {
        if let ContactManager::Own(own) = self {
            own.update(state, &state.bodies[TARGET], step);
        }
    }

    /// Solves the contacts of a (sub-)step of `step` seconds: changes velocities of `net` and `bodies`.
    pub fn solve(&mut self, net: &mut impl NetMotion, bodies: &mut [Body], step: f64) {
        if let ContactManager::Own(own) = self {
            own.solve(net, &mut bodies[TARGET], step);
        }
    }

    /// Rows of the knots, where impulses of ours answer them.
    pub fn row_source(&mut self) -> Option<&mut dyn RowSource> {
        self.by_impulse().map(|own| own as &mut dyn RowSource)
    }

    /// A solver of ours that answers by impulses.
    fn by_impulse(&mut self) -> Option<&mut SurfaceContacts> {
        match self {
            ContactManager::Own(own) if !own.is_force() => Some(own),
            _ => None,
        }
    }

    /// After the engine moved from `before` to `state` in `step` seconds: what it did at each contact, added to
    /// what happened before within the step. The work of that on the knots [J].
    pub fn read_engine(&mut self, world: &mut World, before: &State, state: &mut State, step: f64) -> f64 {
        let ContactManager::Engine(engine) = self else { return 0.0 };
        let n_before = state.contacts.len();
        engine.observe(world, before, state, step);
        state.contacts[n_before..].iter().map(|contact| contact.work_on_knot).sum()
    }

    /// At the end of a step that began at `before`: writes the contacts within it, and after them those of
    /// `others`, which are given knots before and after.
    pub fn report(
        &mut self,
        before: &Knots,
        state: &mut State,
        others: impl FnOnce(&Knots, &Knots, &mut Vec<Contact>),
    ) {
        let State { knots, bodies, contacts, .. } = state;
        if let ContactManager::Own(own) = self {
            own.report(before, knots, bodies.get(TARGET), contacts);
        }
        others(before, knots, contacts);
    }

    /// A solver of ours.
    fn own(&self) -> Option<&SurfaceContacts> {
        match self {
            ContactManager::Own(own) => Some(own),
            _ => None,
        }
    }

    /// Whether a solver of ours has nothing to do in the sub-steps of this step.
    pub fn is_asleep(&self) -> bool {
        self.own().is_none_or(SurfaceContacts::is_asleep)
    }

    /// Whether net and target are apart, or there is no target to a solver of ours.
    pub fn is_separated(&self) -> bool {
        self.own().is_none_or(SurfaceContacts::is_separated)
    }

    /// Knots that a solver of ours watches now.
    pub fn watched(&self) -> impl Iterator<Item = usize> {
        self.own().into_iter().flat_map(SurfaceContacts::watched)
    }

    /// Knots that a solver of ours may answer within the step.
    pub fn bearers(&self) -> impl Iterator<Item = usize> {
        self.own().into_iter().flat_map(SurfaceContacts::bearers)
    }

    /// Times a solver of ours had the engine look for contacts; none where the engine looks itself.
    pub fn n_detections(&self) -> Option<u64> {
        self.own().map(|own| own.n_detections)
    }

    /// Number of colliders of a detector of ours.
    pub fn n_colliders(&self) -> usize {
        self.own().map_or(0, SurfaceContacts::n_colliders)
    }
}
