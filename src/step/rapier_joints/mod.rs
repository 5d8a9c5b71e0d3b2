//! A step with cables as joints of the engine, and contact by the engine or by a response of our own.

pub mod cables;

use nalgebra::{UnitQuaternion, Vector3};

use crate::case::Case;
use crate::contact::rapier::Rapier;
use crate::contact::watch::{Movable, Watch};
use crate::failure::{self, Cuts, Failure};
use crate::limits::Limit;
use crate::options::BuildOptions;
use crate::solver::{ContactModel, Flight};
use crate::state::{Body, Knots, State};
use crate::step::Pull;
use crate::step::adaptive::AdaptiveSubstep;
use crate::step::iterations::SolverIterations;
use crate::step::mass_spring::MassSpring;
use crate::work::{Clock, Work};
use crate::world::{Census, World};
use cables::Joints;

/// Cables as joints of the engine.
pub struct RapierJoints {
    /// SolverIterations over all rows in a sub-step.
    pub iterations: SolverIterations,
    world: World,
    cables: Joints,
    /// The engine's answer to contacts, or one of ours; neither without a target.
    rapier: Option<Rapier>,
    watch: Option<Watch>,
    /// The explicit net that flies until the boxes meet.
    flight: Option<MassSpring>,
    inverse_mass: Vec<f64>,
    /// Parts of a step.
    substep: AdaptiveSubstep,
    cuts: Cuts,
    pressed: Pressed,
    /// The step's and a part's start; kept for their memory.
    starts: [State; 2],
    /// Knots whose velocity an effect changed, and the velocities before [m/s].
    touched: Vec<bool>,
    unpulled: Vec<Vector3<f64>>,
    step: f64,
    substeps: u32,
}

/// What contacts of effects changed in a step.
#[derive(Default)]
struct Pressed {
    is_known: bool,
    /// Knot and change of velocity [m/s].
    knots: Vec<(usize, Vector3<f64>)>,
    /// Changes of the target's velocity [m/s] and rate [rad/s], if it was changed.
    target: Option<(Vector3<f64>, Vector3<f64>)>,
}

impl RapierJoints {
    /// The method for `case`.
    pub fn new(case: &Case, plan: &BuildOptions) -> RapierJoints {
        let mut world = World::new(&case.net, case.target.as_ref(), &plan.setup());
        RapierJoints {
            iterations: SolverIterations::new(case.scene.solver.sweeps, case.scene.solver.sweeps_max),
            cables: Joints::install(&case.net, case.scene.solver.snap_passes, &mut world),
            rapier: engine_contact(case, plan),
            watch: crate::step::watch(case, plan),
            flight: (case.scene.solver.flight == Flight::Explicit).then(|| MassSpring::flight(case)),
            inverse_mass: case.net.mass.iter().map(|mass| 1.0 / mass).collect(),
            substep: AdaptiveSubstep::new(most_parts(case, plan)),
            cuts: Cuts::new(case.limits.of(Limit::Cuts)),
            pressed: Pressed::default(),
            starts: Default::default(),
            touched: vec![false; case.net.n_knots()],
            unpulled: Vec::new(),
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

        self.starts[0].clone_from(state);
        let energy = self.cables.energy(&state.knots);
        self.substep.start(energy);
        self.pressed.is_known = false;
        let may_cut = self.substep.may_cut();
        if may_cut {
            pull.keep();
        }
        self.cuts.begin();
        loop {
            self.cuts.count(u64::from(self.substep.now()), state.time)?;
            let gain = self.in_parts(before, state, work, pull, &mut clock)? - energy;
            let overran = may_cut && pull.overran(&state.knots);
            if self.substep.accept(gain, energy + gain, overran) {
                break;
            }
            // Cables made energy, or threads are too long: back to the start, and on in more parts.
            state.clone_from(&self.starts[0]);
            self.world.write(state);
            pull.take_back();
        }
        if let Some(watch) = &mut self.watch {
            answer(watch, &mut self.world, before, state, &self.inverse_mass, self.step);
            failure::check(state, "contact")?;
            clock.lap(&mut work.stages.contact);
            self.cables.observe(state);
            clock.lap(&mut work.stages.cables);
        }
        pull.report(&before.knots, &state.knots, &mut state.contacts);
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

    /// The step in as many parts as are asked for; the energy of the net at its end, without the work
    /// of contacts and effects within it [J].
    fn in_parts(
        &mut self,
        before: &State,
        state: &mut State,
        work: &mut Work,
        pull: &mut dyn Pull,
        clock: &mut Clock,
    ) -> Result<f64, Failure> {
        let n_parts = self.substep.now();
        let step = self.step / f64::from(n_parts);
        let mut put_in = 0.0;
        state.contacts.clear();
        state.tension.fill(0.0);
        for part in 0..n_parts {
            // Snaps before the world moves: its implicit rows would swallow them.
            self.cables.prepare(state, step, &mut self.world);
            if part > 0 {
                self.starts[1].clone_from(state);
            }
            // Threads last before the world moves: nothing but its rows then spoils their length.
            if pull.pulls() {
                put_in += self.pull(state, step, pull);
            }
            if part == 0 && pull.presses() {
                put_in += self.press(state, pull);
                if self.pressed.target.is_some() {
                    // What the engine's contacts do to the target begins after that.
                    self.starts[1].clone_from(before);
                    self.starts[1].target = state.target;
                }
            }
            failure::check(state, "cables")?;
            clock.lap(&mut work.stages.cables);

            // Detection, contact rows, cable rows and motion, sub-step by sub-step.
            self.world.apply(&state.loads);
            self.world.advance(state, step, self.iterations.now());
            work.substeps += u64::from(self.substeps);
            work.sweeps += u64::from(self.iterations.now() * self.substeps);
            work.detections += u64::from(self.world.detecting());
            self.check_world(state)?;
            clock.lap(&mut work.stages.world);

            if let Some(rapier) = &mut self.rapier {
                let n_before = state.contacts.len();
                let is_before = part == 0 && self.pressed.target.is_none();
                let start = if is_before { before } else { &self.starts[1] };
                rapier.observe(&mut self.world, start, state, step);
                put_in += state.contacts[n_before..].iter().map(|contact| contact.work_on_knot).sum::<f64>();
                failure::check(state, "contact")?;
                clock.lap(&mut work.stages.contact);
            }
            if self.watch.is_none() {
                self.cables.observe(state);
                clock.lap(&mut work.stages.cables);
            }
        }
        let moved = before.knots.position.iter().zip(&state.knots.position);
        let loads = state.loads.on_knots.iter().zip(moved);
        put_in += loads.map(|(force, (from, to))| force.dot(&(to - from))).sum::<f64>();
        Ok(self.cables.energy(&state.knots) - put_in)
    }

    /// Threads pull in every part. Their work [J].
    fn pull(&mut self, state: &mut State, step: f64, pull: &mut dyn Pull) -> f64 {
        self.unpulled.clone_from(&state.knots.velocity);
        pull.pull(&mut state.knots, step, &mut self.touched);
        let mut work = 0.0;
        for (knot, touched) in self.touched.iter_mut().enumerate() {
            if std::mem::take(touched) {
                let (old, new) = (&self.unpulled[knot], &state.knots.velocity[knot]);
                work += 0.5 * (new - old).dot(&(old + new)) / self.inverse_mass[knot];
                self.world.set_velocity(knot, new);
            }
        }
        work
    }

    /// Contacts of effects press once a step: when it is done again, by as much. Their work [J].
    fn press(&mut self, state: &mut State, pull: &mut dyn Pull) -> f64 {
        if !self.pressed.is_known {
            // No part has begun: the memory of its start is free.
            let (knots, mut target) = (&mut self.starts[1].knots, state.target);
            knots.clone_from(&state.knots);
            pull.press(knots, &mut target, self.step, &mut self.touched);
            self.pressed.is_known = true;
            self.pressed.knots.clear();
            for (knot, touched) in self.touched.iter_mut().enumerate() {
                if std::mem::take(touched) {
                    self.pressed.knots.push((knot, knots.velocity[knot] - state.knots.velocity[knot]));
                }
            }
            self.pressed.target = match (state.target, target) {
                (Some(old), Some(new)) if old != new => {
                    Some((new.velocity - old.velocity, new.rate - old.rate))
                }
                _ => None,
            };
        }
        let mut work = 0.0;
        for &(knot, change) in &self.pressed.knots {
            let velocity = &mut state.knots.velocity[knot];
            work += change.dot(&(*velocity + 0.5 * change)) / self.inverse_mass[knot];
            *velocity += change;
            self.world.set_velocity(knot, velocity);
        }
        if let (Some(body), Some((velocity, rate))) = (&mut state.target, self.pressed.target) {
            body.velocity += velocity;
            body.rate += rate;
            self.world.set_target(body);
        }
        work
    }

    fn check_world(&self, state: &State) -> Result<(), Failure> {
        if self.world.has_quarantined() {
            return Err(Failure::Quarantine { time: state.time });
        }
        failure::check(state, "world")
    }

    fn count(&self, work: &mut Work) {
        if let Some(watch) = &self.watch {
            work.detections = watch.n_detections;
        }
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

/// The engine's answer to contacts, where the case asks for it.
fn engine_contact(case: &Case, plan: &BuildOptions) -> Option<Rapier> {
    let target = case.target.as_ref().filter(|_| plan.contact_by_engine)?;
    Some(Rapier::new(&case.net, target, plan.restitution))
}

/// Parts as short as the sub-steps of an explicit net. A response of our own acts once a step, so a
/// step with it and a target has one part.
fn most_parts(case: &Case, plan: &BuildOptions) -> u32 {
    if case.target.is_some() && case.scene.solver.contact != ContactModel::Rapier {
        return 1;
    }
    (plan.step / case.resolving_step()).ceil().clamp(1.0, 4096.0) as u32
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
