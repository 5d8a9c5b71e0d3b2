//! A step with cables as joints of the engine, and contact by the engine or by a response of our own.

use nalgebra::{UnitQuaternion, Vector3};

use super::Pull;
use super::explicit::ExplicitMethod;
use crate::cables::joints::Joints;
use crate::case::Case;
use crate::contact::rapier;
use crate::contact::watch::{Movable, Watch};
use crate::failure::{self, Failure};
use crate::plan::Plan;
use crate::solver::Flight;
use crate::state::{Body, Knots, State};
use crate::work::{Clock, Work};
use crate::world::sweeps::Sweeps;
use crate::world::{Census, World};

/// Cables as joints of the engine.
pub struct JointsMethod {
    /// Sweeps over all rows in a sub-step.
    pub sweeps: Sweeps,
    world: World,
    cables: Joints,
    watch: Option<Watch>,
    /// The explicit net that flies until the boxes meet.
    flight: Option<ExplicitMethod>,
    inverse_mass: Vec<f64>,
    /// Knots whose velocity an effect changed in this step.
    touched: Vec<bool>,
    step: f64,
    substeps: u32,
}

impl JointsMethod {
    /// The method for `case`.
    pub fn new(case: &Case, plan: &Plan) -> JointsMethod {
        let mut world = World::new(&case.net, case.target.as_ref(), &plan.setup());
        JointsMethod {
            sweeps: Sweeps::new(case.scene.solver.sweeps, case.scene.solver.sweeps_max),
            cables: Joints::install(&case.net, case.scene.solver.snap_passes, plan.step, &mut world),
            watch: super::watch(case, plan),
            flight: (case.scene.solver.flight == Flight::Explicit).then(|| ExplicitMethod::flight(case)),
            inverse_mass: case.net.mass.iter().map(|mass| 1.0 / mass).collect(),
            touched: vec![false; case.net.n_knots()],
            step: plan.step,
            substeps: plan.substeps,
            world,
        }
    }

    /// One step.
    pub fn advance(
        &mut self,
        before: &State,
        state: &mut State,
        work: &mut Work,
        pull: &mut dyn Pull,
    ) -> Result<(), Failure> {
        if let Some(flight) = &mut self.flight {
            if self.world.apart(state) {
                return flight.advance(before, state, work, pull);
            }
            // The engine takes over what the explicit net has flown to.
            self.world.write(state);
            self.flight = None;
        }
        let mut clock = Clock::start();

        if let (Some(watch), Some(body)) = (&mut self.watch, &state.target) {
            watch.look(state, body, self.step);
        }
        clock.lap(&mut work.stages.contact);

        // Snaps before the world moves: its implicit rows would swallow them.
        self.cables.prepare(state, &mut self.world);
        // Threads last before the world moves: nothing but its rows then spoils their length.
        self.pull(state, pull);
        failure::check(state, "cables")?;
        clock.lap(&mut work.stages.cables);

        // Detection, contact rows, cable rows and motion, sub-step by sub-step.
        self.world.apply(&state.loads);
        self.world.advance(state, self.sweeps.now());
        self.check_world(state)?;
        clock.lap(&mut work.stages.world);

        match &mut self.watch {
            None => rapier::observe(&self.world, before, state, |contacts, after| {
                pull.report(&before.knots, after, contacts);
            }),
            Some(watch) => {
                answer(watch, &mut self.world, before, state, &self.inverse_mass, self.step);
                pull.report(&before.knots, &state.knots, &mut state.contacts);
            }
        }
        failure::check(state, "contact")?;
        clock.lap(&mut work.stages.contact);

        self.cables.observe(state);
        clock.lap(&mut work.stages.cables);
        self.count(work);
        Ok(())
    }

    /// Takes over velocities that effects changed since the last step.
    pub fn take_velocities(&mut self, state: &State) {
        // Until the boxes meet the explicit net flies, and the engine takes over what it has flown to.
        if self.flight.is_none() {
            self.world.write_velocities(state);
        }
    }

    fn pull(&mut self, state: &mut State, pull: &mut dyn Pull) {
        if !pull.any() {
            return;
        }
        let target = state.target;
        pull.pull(&mut state.knots, &mut state.target, self.step, &mut self.touched);
        for (knot, touched) in self.touched.iter_mut().enumerate() {
            if std::mem::take(touched) {
                self.world.set_velocity(knot, &state.knots.velocity[knot]);
            }
        }
        if let Some(body) = state.target.filter(|body| target != Some(*body)) {
            self.world.set_target(&body);
        }
    }

    fn check_world(&self, state: &State) -> Result<(), Failure> {
        if self.world.has_quarantined() {
            return Err(Failure::Quarantine { time: state.time });
        }
        failure::check(state, "world")
    }

    fn count(&self, work: &mut Work) {
        work.substeps += u64::from(self.substeps);
        work.sweeps += u64::from(self.sweeps.now() * self.substeps);
        work.detections = match &self.watch {
            None => work.detections + u64::from(self.world.detecting()),
            Some(watch) => watch.n_detections,
        };
        work.cable_rows = self.cables.n_rows;
        work.snaps = self.cables.n_snaps;
    }

    /// What the engine consists of.
    pub fn census(&self) -> Census {
        let mut census = self.world.census();
        census.colliders += self.watch.as_ref().map_or(0, Watch::n_colliders);
        census
    }
}

/// Contacts answered after the engine has moved net and target without them: the impulse acts at
/// the start of the step, where the planes are, so it changes velocity by Δv and position by Δv h.
fn answer(
    watch: &mut Watch,
    world: &mut World,
    before: &State,
    state: &mut State,
    inverse_mass: &[f64],
    step: f64,
) {
    let (Some(start), Some(end)) = (&before.target, &mut state.target) else { return };
    // The pose of the start with the velocities of the end.
    let mut body = Body { velocity: end.velocity, rate: end.rate, ..*start };
    let mut knots = MovedKnots { start: &before.knots, end: &mut state.knots, inverse_mass, step };
    let mut touched = Vec::new();
    watch.answer(&mut knots, &mut body, step, |knot| touched.push(knot));
    for knot in touched {
        world.set_velocity(knot, &state.knots.velocity[knot]);
        world.set_position(knot, &state.knots.position[knot]);
    }
    if body.velocity != end.velocity || body.rate != end.rate {
        end.position += step * (body.velocity - end.velocity);
        end.attitude = UnitQuaternion::from_scaled_axis(step * (body.rate - end.rate)) * end.attitude;
        end.velocity = body.velocity;
        end.rate = body.rate;
        world.set_target(end);
    }
    watch.report(&before.knots, &state.knots, &mut state.contacts);
}

/// Knots at the positions of the start of the step, with the velocities of its end.
struct MovedKnots<'a> {
    start: &'a Knots,
    end: &'a mut Knots,
    inverse_mass: &'a [f64],
    step: f64,
}

impl Movable for MovedKnots<'_> {
    fn position(&self, knot: usize) -> Vector3<f64> {
        self.start.position[knot]
    }

    fn velocity(&self, knot: usize) -> Vector3<f64> {
        self.end.velocity[knot]
    }

    fn inverse_mass(&self, knot: usize) -> f64 {
        self.inverse_mass[knot]
    }

    fn push(&mut self, knot: usize, impulse: &Vector3<f64>) {
        let change = impulse * self.inverse_mass[knot];
        self.end.velocity[knot] += change;
        self.end.position[knot] += change * self.step;
    }
}
