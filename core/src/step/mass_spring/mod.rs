//! A step with the explicit net: sub-steps of cables and contact, the engine asked for contacts only.

pub mod dopri5;
pub mod kernel;
pub mod secant;
pub mod stability;

use nalgebra::Vector3;

use crate::contact::row::MarkedKnots;
use crate::contact::{ContactManager, NetMotion};
use crate::failure::{self, Cuts, Failure};
use crate::interaction::Interactions;
use crate::limits::Limit;
use crate::options::{BuildContext, TimeStep};
use crate::solver::{Integrator, JOINTS_STEP, Solver};
use crate::state::State;
use crate::step::limits::{Demands, StepLimits};
use crate::step::stepper::{CableLoss, Method, StepReport, Stepper};
use crate::step::together::SharedContacts;
use crate::work::{Clock, Work};
use crate::world::Census;
use kernel::ExplicitNet;
use stability::{DRAWN, RESOLVES, SAFE, parts_in_contact, stable_step};

/// Cables as an explicit net.
pub struct Explicit;

impl Method for Explicit {
    fn limits(&self, demands: &Demands<'_>) -> StepLimits {
        let stable = stable_step(demands.net).min(demands.stable_contact_step());
        // A field errs by (Ω h)² of what it does to taut cables: a ring at 5 rad/s that might take 4 ms loses 12 % of its
        // angular momentum in 6 s with that, 0.02 % with 0.5 ms.
        let of_fields = if demands.options.has_fields { JOINTS_STEP } else { f64::INFINITY };
        let safe = (if demands.has_contact_force() { RESOLVES } else { SAFE } * stable).min(of_fields);
        let safe = safe.min(demands.resolving_contact_step());
        let own = safe.min(demands.pulled_step()).min(demands.throwing_step()).min(demands.strand_step());
        let own = if demands.options.is_drawn_along { DRAWN * own } else { own };
        let substep = demands.solver.step_s.map_or(own, |step| step.0);
        // Contacts are found once a step: no knot may come from beyond the margin within it, nor
        // one at twice the speed after a snap.
        // Without a target there is nothing to find: a tenth of the steps sufficed for Table 3.2.
        let found = demands.target.map_or(f64::INFINITY, |_| {
            0.5 * demands.contact_margin() / demands.fastest().max(f64::MIN_POSITIVE)
        });
        let found = found.min(demands.thin_step()).min(demands.pulled_step());
        let step = demands.in_frames(JOINTS_STEP.min(demands.sample).min(found).max(substep));
        let chosen = TimeStep { step, substeps: (step / substep).ceil().max(1.0) as u32 };
        StepLimits { stable, safe, chosen, written: chosen.step / f64::from(chosen.substeps) }
    }

    fn acts_in_substeps(&self) -> bool {
        true
    }

    /// Contacts are looked for every few steps.
    fn forecast(&self, _n_cables: usize, n_steps: u64, time_step: TimeStep) -> Work {
        Work {
            steps: n_steps,
            substeps: n_steps * u64::from(time_step.substeps),
            detections: n_steps / 5,
            ..Work::default()
        }
    }

    /// 4 ns a cable and sub-step, with the motion of its knots; 0.1 µs a sub-step, whatever the net: of a net of twelve knots
    /// that is most of it.
    fn price(&self, solver: &Solver, _n_knots: usize, n_cables: usize, work: &Work) -> f64 {
        let evaluations = match solver.integrator {
            // Two passes over the cables for one.
            Integrator::Secant => 2.0,
            Integrator::Symplectic | Integrator::Auto | Integrator::Implicit => 1.0,
            Integrator::Rk4 => 5.0,
            Integrator::Located => 50.0,
        };
        (4e-9 * n_cables as f64 + 1e-7) * evaluations * work.substeps as f64
    }

    fn build(&self, context: &BuildContext<'_>) -> Box<dyn Stepper> {
        let settings = context.contact_settings();
        Box::new(MassSpring {
            contacts: ContactManager::new(settings.as_ref()),
            shared: SharedContacts::new(context),
            ..MassSpring::new(context, context.time_step)
        })
    }
}

/// Cables as an explicit net, at work.
pub struct MassSpring {
    net: ExplicitNet,
    contacts: ContactManager,
    /// Those of knots and of effects, where these bring rows.
    shared: SharedContacts,
    /// Inverse mass of each knot [1/kg].
    inverse_mass: Vec<f64>,
    /// Knots that effects may change in this step, and whether one changed their velocity in this sub-step.
    reached: Vec<usize>,
    touched: Vec<bool>,
    /// Velocities before the cables pulled in this sub-step [m/s]; kept where contacts may act.
    unkicked: Vec<Vector3<f64>>,
    /// Whether velocities are those of the time of the positions, where a field acts: not where a method lets them lag.
    in_time: bool,
    /// Whether contacts or constraints have acted on the net, and it has not flown away from them since.
    has_met: bool,
    /// Whether velocities were behind positions before the sub-step, by the integrator.
    lagged: bool,
    substep: f64,
    n_substeps: u32,
    /// Into how many these are cut when a contact ends the flight.
    parts_in_contact: u32,
    cuts: Cuts,
}

impl MassSpring {
    /// The explicit net that flies a run with joints until the boxes meet: no contact.
    pub fn flight(context: &BuildContext<'_>) -> MassSpring {
        let step = context.time_step.step;
        let substeps = (step / (SAFE * stable_step(context.net))).ceil().max(1.0) as u32;
        MassSpring::new(context, TimeStep { step, substeps })
    }

    fn new(context: &BuildContext<'_>, time_step: TimeStep) -> MassSpring {
        let BuildContext { net, solver, options, .. } = *context;
        let substep = time_step.step / f64::from(time_step.substeps);
        let explicit = ExplicitNet::new(net, solver.integrator, solver.tolerance_m.0);
        MassSpring {
            lagged: explicit.lags(),
            net: explicit,
            parts_in_contact: parts_in_contact(
                solver.integrator,
                net,
                solver.restitution,
                options.strands_touch,
                substep,
            ),
            contacts: ContactManager::Absent,
            shared: SharedContacts::default(),
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            reached: Vec::new(),
            touched: vec![false; net.n_knots()],
            unkicked: Vec::new(),
            in_time: false,
            has_met: false,
            substep,
            n_substeps: time_step.substeps,
            cuts: Cuts::new(context.limits.of(Limit::Cuts)),
        }
    }

    /// Takes the shorter sub-steps of contact from now on; how many there are for one of before.
    fn refine(&mut self) -> u32 {
        let parts = self.parts_in_contact;
        self.substep /= f64::from(parts);
        self.n_substeps *= parts;
        parts
    }

    /// A net that has come away from its target, and that nothing else touches, flies again as before it met it. Semi-implicit Euler lets the
    /// energy of undamped cables wander for as long as they thrash: 29 drawn nets with little damping or none made within 6 s up to 3.8e-3 of the
    /// energy at hand, three of them more than 1e-3; so 8.5e-4 at most, in half the time.
    fn fly_again(&mut self) {
        if !self.net.has_landed() || !self.reached.is_empty() || !self.contacts.is_separated() {
            return;
        }
        self.has_met = false;
        self.net.fly_again(if self.in_time { 0.0 } else { 0.5 * self.substep });
        self.substep *= f64::from(self.parts_in_contact);
        self.n_substeps /= self.parts_in_contact;
    }

    /// A flight ends where a contact may act within the step, not with it: what bounced off the target went back for the whole of that
    /// sub-step, against cables that it had not met. With a restitution of 1 that gave 1.5e-3 of the launch energy at the first contact.
    fn land(&mut self) {
        if !self.contacts.is_asleep() && self.net.land() {
            self.refine();
        }
    }

    /// For so much of a sub-step forces of effects act where knots are now.
    fn act_at(&self, state: &mut State, substeps: f64) {
        let positions = (0..state.knots.position.len()).map(|knot| self.net.position(knot));
        state.forces.act_at(positions, substeps / f64::from(self.n_substeps));
    }

    /// What cables took in the step.
    fn cable_loss(&mut self) -> CableLoss {
        let taken = self.net.take_dissipated();
        if self.has_met { CableLoss::BesideContact(taken) } else { CableLoss::ByLaw(taken) }
    }

    /// The end of a step that `began_in_time`, in which contacts or constraints `acted`, or did not.
    ///
    /// Semi-implicit Euler's velocities are those of half a sub-step before. A field that turns what moves would
    /// turn the wrong ones: with it they are brought to the time of the positions at both ends of the step. But not
    /// where contacts or threads acted: they answer a whole kick, and what cables press onto them in this half would
    /// count as energy, and whole cables that bounce with 0.7 would bounce of it, 0.26 of the energy at hand.
    fn end(&mut self, state: &mut State, with: &Interactions, began_in_time: bool, acted: bool) {
        self.in_time = with.kick_knots() && !(self.lagged && acted);
        let ends_in_time = self.lagged && self.in_time;
        if ends_in_time {
            self.net.kick(0.5 * self.substep);
        }
        if !with.push() {
            return;
        }
        if began_in_time != ends_in_time {
            // What is held over a step acts for all of it, and no longer.
            self.net.push_for(if began_in_time { 0.5 } else { -0.5 } * self.substep);
        }
        if began_in_time {
            self.act_at(state, 0.5);
        }
    }

    /// A sub-step: forces, then constraints and contacts, then motion. Whether constraints or contacts acted.
    fn advance(&mut self, state: &mut State, with: &mut Interactions, kick: SubstepKick) -> bool {
        let (pushes, mut acted) = (with.push(), false);
        // Cables alone, as in most of a flight: their kick and the drift are one pass.
        if kick == SubstepKick::Whole && !pushes && self.reached.is_empty() && self.contacts.is_asleep() {
            state.drift_bodies(true, self.substep);
            self.net.fly(self.substep);
            return false;
        }
        if !self.contacts.is_asleep() || with.touch() {
            self.unkicked.clear();
            self.unkicked.extend((0..state.knots.position.len()).map(|knot| self.net.velocity(knot)));
        }
        if pushes {
            // A method that does not lag has it act all along its way.
            self.act_at(state, if kick == SubstepKick::Half || !self.lagged { 0.5 } else { 1.0 });
        }
        self.net.kick(if kick == SubstepKick::Whole { self.substep } else { 0.5 * self.substep });
        if pushes && kick == SubstepKick::HalfOfCables {
            self.net.push_for(0.5 * self.substep);
        }
        // Forces first: rows are solved at the velocities that all of them leave.
        let is_shared = with.share_rows();
        if is_shared && self.contacts.row_source().is_none() {
            acted |= self.answer(state);
        }
        if !self.reached.is_empty() {
            acted |= self.interact(state, with);
        }
        if !is_shared {
            acted |= self.answer(state);
        }
        state.drift_bodies(true, self.substep);
        self.net.drift(self.substep);
        if pushes && !self.lagged {
            self.act_at(state, 0.5);
        }
        acted
    }

    /// Contacts of knots act by themselves. Whether any did.
    fn answer(&mut self, state: &mut State) -> bool {
        let mut net = Kicked { net: &mut self.net, before: &self.unkicked, pushed: false };
        self.contacts.solve(&mut net, &mut state.bodies, self.substep);
        net.pushed
    }

    /// Constraints and contacts of effects act sub-step by sub-step. As impulses of two sub-steps at a time
    /// threads put 8 to 10 % of the launch energy into the cables, of ten 64 %; as forces held over ten they
    /// turn with their segments too late, and a quarter of the angular momentum is lost.
    ///
    /// Whether any did.
    fn interact(&mut self, state: &mut State, with: &mut Interactions) -> bool {
        self.net.store_some(&mut state.knots, self.reached.iter().copied());
        if with.constrain() {
            with.solve_constraints(&mut state.knots, self.substep, &mut self.touched);
        }
        if with.touch() {
            let State { knots, bodies, .. } = state;
            let (before, touched) = (self.unkicked.as_slice(), self.touched.as_mut_slice());
            with.solve_contacts(knots, before, bodies, self.substep, touched);
            if with.share_rows() {
                let mut net = MarkedKnots { knots, before, inverse_mass: &self.inverse_mass, touched };
                self.shared.solve(&mut self.contacts, with, &mut net, bodies, self.substep, false);
            }
        }
        let mut acted = false;
        for &knot in &self.reached {
            if std::mem::take(&mut self.touched[knot]) {
                self.net.set_velocity(knot, &state.knots.velocity[knot]);
                acted = true;
            }
        }
        acted
    }
}

/// Each of `knots` once and in order: by a mark on each, for those of cables are named by several planes. No mark is left.
fn each_once(knots: &mut Vec<usize>, marks: &mut [bool]) {
    if knots.is_empty() {
        return;
    }
    for knot in knots.drain(..) {
        marks[knot] = true;
    }
    knots.extend((0..marks.len()).filter(|&knot| std::mem::take(&mut marks[knot])));
}

impl Stepper for MassSpring {
    fn step(
        &mut self,
        before: &State,
        state: &mut State,
        with: &mut Interactions,
        work: &mut Work,
    ) -> Result<StepReport, Failure> {
        let mut clock = Clock::start();
        let step = self.substep * f64::from(self.n_substeps);
        self.contacts.begin(state);
        self.contacts.update(state, step);
        clock.lap(&mut work.stages.contact);

        with.reached_knots(state.knots.position.len(), &mut self.reached);
        if with.share_rows() {
            self.reached.extend(self.contacts.bearers());
        }
        each_once(&mut self.reached, &mut self.touched);
        self.net.load(&state.knots, &state.forces.on_knots);
        // One more than may be: those end it.
        let tried = self.net.tried();
        self.net.allow(self.cuts.begin().saturating_add(1));
        self.fly_again();
        self.land();
        if state.step == 0 {
            self.in_time = with.kick_knots();
        }
        // What pushes the net ends a flight that does not lag: in one of the sub-steps below, in the last of the step before, or now.
        let flew = self.net.lags() && !self.lagged;
        self.lagged = self.net.lags();
        let (began_in_time, mut acted) = (self.lagged && self.in_time, false);
        let (mut left, mut kick) = (self.n_substeps, SubstepKick::first(began_in_time, flew));
        while left > 0 {
            acted |= self.advance(state, with, std::mem::take(&mut kick));
            left -= 1;
            if self.net.lags() && !self.lagged {
                left *= self.refine();
                self.lagged = left > 0;
                kick = SubstepKick::HalfOfCables;
            }
        }
        self.end(state, with, began_in_time, acted);
        self.net.store(&mut state.knots);
        self.net.take_tension(&mut state.tension);
        self.cuts.count(self.net.tried() - tried, state.time)?;
        failure::check(state, "cables")?;
        clock.lap(&mut work.stages.cables);

        self.contacts.report(&before.knots, state, |from, to, list| with.report_contacts(from, to, list));
        let own = self.contacts.n_detections();
        if own.is_some() || with.touch() {
            work.detections = own.unwrap_or(0) + with.n_detections();
        }
        work.substeps += u64::from(self.n_substeps);
        clock.lap(&mut work.stages.contact);
        let velocity_lag = if self.lagged && !self.in_time { 0.5 * self.substep } else { 0.0 };
        self.has_met |= acted;
        let cable_loss = self.cable_loss();
        Ok(StepReport { cable_loss, velocity_lag, ..StepReport::default() })
    }

    /// No body, no joint, and colliders where there is a target.
    fn census(&self) -> Census {
        Census { colliders: self.contacts.n_colliders(), ..Census::default() }
    }
}

/// What forces do in a sub-step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum SubstepKick {
    /// They act for all of it.
    #[default]
    Whole,
    /// For half of it: velocities were brought to the time of the positions.
    Half,
    /// Cables for half of it: a flight ended, whose velocities are of the time of the positions. Those to come are of half a sub-step
    /// before. A whole kick made 4e-3 of the energy at hand of the undamped net of `cube-fixed`, whatever the steps in contact.
    HalfOfCables,
}

impl SubstepKick {
    /// That of the first sub-step of a step.
    fn first(began_in_time: bool, flew: bool) -> SubstepKick {
        match (began_in_time, flew) {
            (true, _) => SubstepKick::Half,
            (false, true) => SubstepKick::HalfOfCables,
            (false, false) => SubstepKick::Whole,
        }
    }
}

/// The net after its cables pulled within a sub-step, and what it was before.
struct Kicked<'a> {
    net: &'a mut ExplicitNet,
    before: &'a [Vector3<f64>],
    /// Whether a contact changed a velocity.
    pushed: bool,
}

impl NetMotion for Kicked<'_> {
    #[inline]
    fn position(&self, knot: usize) -> Vector3<f64> {
        self.net.position(knot)
    }

    #[inline]
    fn velocity(&self, knot: usize) -> Vector3<f64> {
        self.net.velocity(knot)
    }

    #[inline]
    fn velocity_before(&self, knot: usize) -> Vector3<f64> {
        self.before.get(knot).copied().unwrap_or_else(|| self.net.velocity(knot))
    }

    #[inline]
    fn inverse_mass(&self, knot: usize) -> f64 {
        self.net.inverse_mass(knot)
    }

    #[inline]
    fn push(&mut self, knot: usize, impulse: &Vector3<f64>, weight: f64) {
        self.net.push(knot, &(weight * impulse));
        self.pushed = true;
    }
}
