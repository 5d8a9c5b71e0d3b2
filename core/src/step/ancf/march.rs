//! A step with cable elements: sub-steps of cables, threads and contact.

use std::sync::Arc;

use nalgebra::Vector3;

use super::implicit::ImplicitStep;
use super::kernel::{AncfNet, element_net};
use super::points::{PointsInContact, TouchPoints, point_net};
use crate::cable::Cable;
use crate::contact::{ContactManager, ContactSettings};
use crate::failure::{self, Failure};
use crate::interaction::Interactions;
use crate::net::Net;
use crate::options::BuildContext;
use crate::solver::{Ancf, Integrator};
use crate::state::elements::ElementNet;
use crate::state::{Body, Knots, NetTotals, State};
use crate::step::stepper::{CableLoss, StepReport, Stepper};
use crate::work::{Clock, Work};
use crate::world::Census;

/// Cables as elements, at work.
pub struct AncfMarch {
    net: AncfNet,
    elements: Arc<ElementNet>,
    /// The cables' own coordinates before the shot.
    in_container: Knots,
    touch: Option<Touch>,
    implicit: Option<Box<ImplicitStep>>,
    /// Knots that threads may pull in this step, and whether one was in this sub-step.
    reached: Vec<usize>,
    touched: Vec<bool>,
    substep: f64,
    n_substeps: u32,
}

/// Contact with the target.
struct Touch {
    manager: ContactManager,
    points: TouchPoints,
    /// The points as a state without a net; what they were at the start of the step.
    at: State,
    before: Knots,
    /// Velocities of the points before the cables pulled in this sub-step [m/s]; kept where contacts may act.
    unkicked: Knots,
}

/// What a scene with elements is refused for, where it comes from elsewhere than a scene.
fn refusal(with: &Interactions) -> Option<&'static str> {
    let all = [
        (with.kick_only_knots(), "an effect that kicks knots and no elements"),
        (with.touch(), "an effect that answers contacts of its own"),
    ];
    all.into_iter().find(|(is_there, _)| *is_there).map(|(_, what)| what)
}

/// Where what hangs between two ends so far `across` from each other falls to [-]: along −X, as far as that is across their line. One with an end at a
/// bullet that is shot later would have one leg longer than the other, and be stretched before the shot.
fn hanging(across: &Vector3<f64>) -> Vector3<f64> {
    let square = across.norm_squared();
    let across_it = |axis: Vector3<f64>| match square > 0.0 {
        true => axis - axis.dot(across) / square * across,
        false => axis,
    };
    let falls = across_it(-Vector3::x());
    // Ends straight behind each other: to any side.
    let falls = if falls.norm() > 1e-6 { falls } else { across_it(Vector3::y()) };
    falls.normalize()
}

/// How cables lie in the container, and move with the shot.
fn in_container(net: &Net, elements: &ElementNet) -> Knots {
    let knots = Knots { position: net.folded.clone(), velocity: net.launch_velocity.clone() };
    if !net.folded_inwards {
        return elements.straight(&knots);
    }
    let fall = |cable: &Cable| {
        let (apart, length) = ((net.folded[cable.b] - net.folded[cable.a]).norm(), cable.rest_length);
        // A piece without a fold has its length, but for rounding.
        let is_straight = apart > (1.0 - 1e-9) * length;
        let deep = if is_straight { 0.0 } else { (length * length - apart * apart).sqrt() };
        deep / elements.layout.elements as f64 * hanging(&(net.folded[cable.b] - net.folded[cable.a]))
    };
    elements.folded(&knots, &net.cables.iter().map(fall).collect::<Vec<_>>())
}

impl AncfMarch {
    /// For the scene of `context`.
    pub fn new(context: &BuildContext<'_>) -> AncfMarch {
        let BuildContext { net, solver, time_step, .. } = *context;
        let ancf = solver.ancf.unwrap_or_default();
        let elements = element_net(net, &ancf);
        let moving = AncfNet::new(net, &ancf);
        let is_implicit = solver.integrator == Integrator::Implicit;
        AncfMarch {
            implicit: is_implicit.then(|| Box::new(ImplicitStep::new(net, &moving))),
            net: moving,
            in_container: in_container(net, &elements),
            elements: Arc::new(elements),
            touch: context.contact_settings().map(|settings| Touch::new(&settings, net, &ancf)),
            reached: Vec::new(),
            touched: vec![false; net.n_knots()],
            substep: time_step.step / f64::from(time_step.substeps),
            n_substeps: time_step.substeps,
        }
    }

    /// Threads pull at knots, whose cables answer; whether any pulled.
    fn constrain(&mut self, state: &mut State, with: &mut Interactions) -> bool {
        let knots = &mut state.knots;
        for &knot in &self.reached {
            [knots.position[knot], knots.velocity[knot]] = self.net.knots.get(knot);
        }
        with.solve_constraints(knots, self.substep, &mut self.touched);
        let mut any = false;
        for &knot in &self.reached {
            if !std::mem::take(&mut self.touched[knot]) {
                continue;
            }
            if !any {
                self.net.begin_impulses();
                any = true;
            }
            // The thread took the knot for one that answers alone.
            let change = knots.velocity[knot] - self.net.knots.get(knot)[1];
            self.net.add_impulse(knot, &(self.elements.answering_mass[knot] * change));
        }
        if any {
            self.net.answer_impulses();
        }
        any
    }

    /// Whether the coming step is implicit: nothing can touch within it, and no thread acts.
    fn is_alone(&self) -> bool {
        let touches = |touch: &Touch| touch.manager.watched().next().is_some();
        self.implicit.is_some() && self.reached.is_empty() && !self.touch.as_ref().is_some_and(touches)
    }

    /// An implicit step.
    fn fly(&mut self, state: &mut State, work: &mut Work) -> Result<(), Failure> {
        let step = self.substep * f64::from(self.n_substeps);
        if let Some(implicit) = &mut self.implicit {
            let before = implicit.n_corrections;
            if !implicit.advance(&mut self.net, step) {
                return Err(Failure::Implicit { time: state.time, step });
            }
            work.sweeps += implicit.n_corrections - before;
        }
        state.drift_bodies(true, step);
        work.substeps += 1;
        Ok(())
    }

    /// Explicit sub-steps; whether any contact or thread acted.
    fn march(&mut self, state: &mut State, with: &mut Interactions, work: &mut Work) -> bool {
        let mut any = false;
        self.drift(state, 0.5 * self.substep);
        for left in (0..self.n_substeps).rev() {
            if let Some(touch) = &mut self.touch {
                touch.before_kick(&self.net);
            }
            if with.push() {
                let knots = (0..state.knots.position.len()).map(|knot| self.net.knots.get(knot)[0]);
                state.forces.act_at(knots, 1.0 / f64::from(self.n_substeps));
            }
            self.net.kick(self.substep);
            if !self.reached.is_empty() {
                any |= self.constrain(state, with);
            }
            if let Some(touch) = &mut self.touch {
                any |= touch.solve(&mut self.net, &mut state.bodies, self.substep);
            }
            self.drift(state, if left == 0 { 0.5 } else { 1.0 } * self.substep);
        }
        work.substeps += u64::from(self.n_substeps);
        any
    }

    fn drift(&mut self, state: &mut State, step: f64) {
        self.net.drift(step);
        state.drift_bodies(true, step);
    }

    fn totals(&self, state: &State) -> NetTotals {
        let elastic = self.net.elastic();
        NetTotals { elastic, ..self.elements.motion(&state.knots, &state.inner) }
    }
}

impl Stepper for AncfMarch {
    fn start(&mut self, state: &mut State) {
        state.inner.clone_from(&self.in_container);
        state.elements = Some(Arc::clone(&self.elements));
        self.net.load(&state.knots, &state.inner, &[]);
        state.totals = Some(self.totals(state));
    }

    fn step(
        &mut self,
        _before: &State,
        state: &mut State,
        with: &mut Interactions,
        work: &mut Work,
    ) -> Result<StepReport, Failure> {
        if let Some(what) = refusal(with) {
            return Err(Failure::Refused { what });
        }
        let mut clock = Clock::start();
        self.net.load(&state.knots, &state.inner, &state.forces.on_knots);
        if let Some(touch) = &mut self.touch {
            touch.begin(&mut self.net, state, self.substep * f64::from(self.n_substeps));
        }
        clock.lap(&mut work.stages.contact);

        with.constrained_knots(&mut self.reached);
        let any = if self.is_alone() {
            self.fly(state, work)?;
            false
        } else {
            self.march(state, with, work)
        };
        self.net.store(&mut state.knots, &mut state.inner);
        self.net.take_tension(&mut state.tension);
        state.totals = Some(self.totals(state));
        failure::check(state, "cables")?;
        clock.lap(&mut work.stages.cables);

        if let Some(touch) = &mut self.touch {
            touch.report(&self.net, state);
            work.detections = touch.manager.n_detections().unwrap_or(work.detections);
        }
        clock.lap(&mut work.stages.contact);
        let dissipated = self.net.take_dissipated();
        let cable_loss =
            if any { CableLoss::BesideContact(dissipated) } else { CableLoss::ByLaw(dissipated) };
        Ok(StepReport { cable_loss, ..StepReport::default() })
    }

    /// No body, no joint, and colliders where there is a target.
    fn census(&self) -> Census {
        let colliders = self.touch.as_ref().map_or(0, |touch| touch.manager.n_colliders());
        Census { colliders, ..Census::default() }
    }
}

impl Touch {
    fn new(settings: &ContactSettings<'_>, net: &Net, ancf: &Ancf) -> Touch {
        let points = point_net(net, ancf);
        Touch {
            manager: ContactManager::new(Some(&ContactSettings { net: &points, coupled: true, ..*settings })),
            points: TouchPoints::new(net, ancf),
            at: State::default(),
            before: Knots::default(),
            unkicked: Knots::default(),
        }
    }

    /// Before a step of `step` seconds: finds what is near anew where it is stale.
    fn begin(&mut self, net: &mut AncfNet, state: &State, step: f64) {
        self.points.place(net, &mut self.at.knots);
        self.before.clone_from(&self.at.knots);
        self.at.bodies.clone_from(&state.bodies);
        self.manager.begin(&mut self.at);
        self.manager.update(&self.at, step);
        self.points.watch(net, self.manager.watched());
    }

    fn before_kick(&mut self, net: &AncfNet) {
        if !self.manager.is_asleep() {
            self.points.place(net, &mut self.unkicked);
        }
    }

    /// Solves the contacts of a sub-step; whether any acted.
    fn solve(&mut self, net: &mut AncfNet, bodies: &mut [Body], step: f64) -> bool {
        let before: &[Vector3<f64>] = &self.unkicked.velocity;
        let mut touching = PointsInContact { net, points: &mut self.points, before };
        self.manager.solve(&mut touching, bodies, step);
        self.points.release(net)
    }

    /// Writes the contacts of the step.
    fn report(&mut self, net: &AncfNet, state: &mut State) {
        self.points.place(net, &mut self.at.knots);
        self.at.bodies.clone_from(&state.bodies);
        self.manager.report(&self.before, &mut self.at, |_, _, _| {});
        state.contacts.clear();
        state.contacts.extend(self.at.contacts.iter().map(|contact| self.points.named(contact)));
    }
}
