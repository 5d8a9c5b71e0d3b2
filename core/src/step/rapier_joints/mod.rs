//! A step with cables as joints of the engine, and contact by the engine or by a response of our own.

mod books;
pub mod cables;
mod mean_motion;
mod own_contact;
mod snaps;
mod ties;

use nalgebra::Vector3;

use crate::contact::ContactManager;
use crate::contact::row::MarkedKnots;
use crate::failure::{self, Cuts, Failure};
use crate::interaction::{Fared, Interactions};
use crate::limits::Limit;
use crate::options::{BuildContext, TimeStep};
use crate::solver::{ContactModel, Flight, JOINTS_STEP, Solver};
use crate::state::{Body, State, TARGET};
use crate::step::adaptive::{AdaptiveSubstep, MOST_PARTS, StepEnergy};
use crate::step::iterations::SolverIterations;
use crate::step::limits::{Demands, StepLimits};
use crate::step::mass_spring::MassSpring;
use crate::step::mass_spring::stability::{RESOLVES, SAFE, stable_step};
use crate::step::stepper::{CableLoss, Method, StepReport, Stepper};
use crate::step::together::SharedContacts;
use crate::work::{Clock, Work};
use crate::world::{Census, Setup, World};
use books::StepBooks;
use cables::{Beside, CableJoints};
use ties::KnotTies;

/// Cables as joints of the engine.
pub struct Joints;

impl Method for Joints {
    fn limits(&self, demands: &Demands<'_>) -> StepLimits {
        let Demands { solver, net, .. } = *demands;
        let stable = demands.stable_contact_step();
        let takes_turns = demands.has_contact_force() || demands.options.has_constraints;
        let safe = (if takes_turns { RESOLVES } else { SAFE } * stable).min(demands.resolving_contact_step());
        let step = match solver.step_s {
            Some(step) => step.0,
            None if solver.contact != ContactModel::Penalty => {
                demands.in_frames(JOINTS_STEP.min(demands.thin_step()).min(demands.pulled_step()))
            }
            // The engine's cables and a force of our own take turns, so neither feels the other
            // within a step: a knot that contact holds lets its neighbour stretch the cable. Energy
            // gained on the free-floating Cubesat, over the launch energy: 3 at 0.5 ms, 0.2 at 0.2 ms,
            // 0.02 at 0.1 ms, 2e-3 at 0.05 ms, where a step resolves the cables. Rises above a minimum on a small
            // capture: 4e-2 at 0.1 ms, 3e-3 at 0.05 ms, less than 1e-3 at half of that.
            None => {
                let found = demands.thin_step().min(demands.pulled_step());
                let found = found.min(demands.throwing_step());
                demands.in_frames(JOINTS_STEP.min(found).min(safe).min(0.5 * RESOLVES * stable_step(net)))
            }
        };
        StepLimits { stable, safe, chosen: TimeStep { step, substeps: solver.substeps }, written: step }
    }

    fn acts_in_substeps(&self) -> bool {
        false
    }

    /// A step is cut where a snap asks for it, the longer the oftener, down to about half a millisecond; six
    /// iterations a sub-step, and three cables of five have a row in it.
    fn forecast(&self, n_cables: usize, n_steps: u64, time_step: TimeStep) -> Work {
        let cut = (n_steps as f64 * time_step.step / 4.5e-4) as u64;
        let substeps = cut.max(n_steps * u64::from(time_step.substeps));
        Work {
            steps: n_steps,
            substeps,
            detections: substeps,
            sweeps: 6 * substeps,
            cable_rows: 3 * n_cables as u64 * substeps / 5,
            ..Work::default()
        }
    }

    /// 20 ns a cable and iteration, 400 ns a row made, 200 ns a knot moved; 3 µs a sub-step, whatever the net.
    fn price(&self, _solver: &Solver, n_knots: usize, n_cables: usize, work: &Work) -> f64 {
        2e-8 * n_cables as f64 * work.sweeps as f64
            + 4e-7 * work.cable_rows as f64
            + (2e-7 * n_knots as f64 + 3e-6) * work.substeps as f64
    }

    fn build(&self, context: &BuildContext<'_>) -> Box<dyn Stepper> {
        Box::new(RapierJoints::new(context))
    }
}

/// Cables as joints of the engine, at work.
pub struct RapierJoints {
    /// Iterations over all rows in a sub-step.
    iterations: SolverIterations,
    world: World,
    cables: CableJoints,
    ties: KnotTies,
    contacts: ContactManager,
    /// The explicit net that flies until the boxes meet.
    flight: Option<MassSpring>,
    inverse_mass: Vec<f64>,
    launch_energy: f64,
    /// Where the engine's contacts need parts that are short enough.
    near: Option<NearTarget>,
    /// Into how many parts a step is cut.
    substep: AdaptiveSubstep,
    /// Whether net and target are out of reach of each other.
    is_apart: bool,
    /// Whether they have ever come within it.
    has_met: bool,
    /// Parts at most where contacts of effects act.
    most_with_contacts: u32,
    cuts: Cuts,
    /// Contacts of effects that bring rows, and of knots where these do.
    shared: SharedContacts,
    /// What effects gave within the step.
    books: StepBooks,
    /// The step's and a part's start; kept for their memory.
    starts: [State; 2],
    /// Velocities that contacts of effects left when they were last answered, and at the start of the step [m/s]; kept
    /// where these bounce.
    answered: Vec<Vector3<f64>>,
    answered_before: Vec<Vector3<f64>>,
    /// Knots whose velocity an effect changed, and the velocities before [m/s].
    touched: Vec<bool>,
    untouched: Vec<Vector3<f64>>,
    /// The bodies before contacts of effects; kept for its memory.
    unpushed: Vec<Body>,
    /// The start of a part with what contacts of effects gave; kept for its memory.
    answered_start: State,
    /// Bodies from which the world moved in the last part of a step.
    moved_from: Vec<Body>,
    step: f64,
}

/// Around a target whose contacts the engine solves.
struct NearTarget {
    /// Distance from its centre from which a knot is near [m].
    around: f64,
    /// Farthest way of a knot within a part of a step [m].
    way: f64,
}

impl RapierJoints {
    fn new(context: &BuildContext<'_>) -> RapierJoints {
        let BuildContext { net, target, solver, time_step, options, .. } = *context;
        let by_engine = solver.contact == ContactModel::Rapier;
        let by_force = solver.contact == ContactModel::Penalty;
        let setup = Setup {
            step: time_step.step,
            friction: options.friction,
            has_contacts: by_engine,
            precision: solver.precision,
        };
        let mut world = World::new(net, target, &setup);
        let cables = CableJoints::install(net, solver.snap_passes, time_step.step, &mut world);
        let most_for_rows = (time_step.step / cables.shortest_part()).ceil() as u32;
        RapierJoints {
            iterations: SolverIterations::new(solver.sweeps, solver.sweeps_max),
            cables,
            ties: KnotTies::new(time_step.step),
            contacts: ContactManager::new(context.contact_settings().as_ref()),
            flight: (solver.flight == Flight::Explicit).then(|| MassSpring::flight(context)),
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            near: target.filter(|_| !by_force).map(|target| NearTarget {
                around: target.bounding_radius + world.look_ahead(),
                way: world.look_ahead().min(0.5 * target.thinnest),
            }),
            launch_energy: net.launch_energy().max(f64::MIN_POSITIVE),
            substep: AdaptiveSubstep::new(
                time_step.substeps,
                most_parts(context, FINEST),
                most_for_rows,
                solver.loss_tolerance.0,
            ),
            is_apart: false,
            has_met: false,
            most_with_contacts: most_parts(context, 1.0),
            shared: SharedContacts::new(context),
            books: StepBooks::default(),
            cuts: Cuts::new(context.limits.of(Limit::Cuts)),
            starts: Default::default(),
            answered: Vec::new(),
            answered_before: Vec::new(),
            touched: vec![false; net.n_knots()],
            untouched: Vec::new(),
            unpushed: Vec::new(),
            answered_start: State::default(),
            moved_from: Vec::new(),
            step: time_step.step,
            world,
        }
    }

    /// Parts in which no knot near the target comes farther, as seen from it, than the engine looks ahead, and
    /// through no more than half of a thin part. What the speed of the shot asks for is in the step already: this
    /// is for what falls, is pulled or thrown.
    fn parts_of_motion(&self, state: &State) -> u32 {
        let (Some(near), Some(body)) = (&self.near, state.target()) else { return 1 };
        let mut farthest = 0.0;
        for (position, velocity) in state.knots.position.iter().zip(&state.knots.velocity) {
            let way = self.step * (velocity - body.velocity_at(*position)).norm();
            if way > farthest && (position - body.position).norm() < near.around + way {
                farthest = way;
            }
        }
        (farthest / near.way).ceil().max(1.0) as u32
    }

    /// The step in so many parts that cables make no energy and constraints hold; how often it was cut.
    fn cut_as_needed(
        &mut self,
        before: &State,
        state: &mut State,
        with: &mut Interactions,
        work: &mut Work,
        clock: &mut Clock,
    ) -> Result<u32, Failure> {
        let energy = self.cables.energy(&state.knots);
        self.substep.start(energy);
        self.is_apart = self.world.apart(state);
        if !self.is_apart && !self.has_met {
            self.has_met = true;
            self.substep.meet();
        }
        if with.touch() {
            // What is left there is not of the cables, and shorter parts do not take it: they cost up to half of the run. (Of knots alone
            // they do: one of 13 runs of `stress coincident-knots` under joints+impulse made 1.5e-3, none more than 2.2e-4 so.)
            self.substep.for_energy_at_most(self.most_with_contacts);
        }
        let may_cut = self.substep.may_cut();
        if may_cut && with.touch() {
            let parts = with.parts_of_contacts(&state.knots, self.step);
            self.substep.at_least(parts.min(self.most_with_contacts));
        }
        self.substep.at_least(self.parts_of_motion(state));
        if with.constrain() {
            let needs = with.checkpoint(self.step);
            if !self.contacts.is_by_force() {
                self.substep.at_least(needs.parts);
            }
            state.ties.extend_from_slice(&needs.ties);
            self.shared.tie(&state.ties);
            self.ties.add(needs.ties, &mut self.world);
            self.ties.follow(&state.knots, &mut self.world);
        }
        self.starts[0].clone_from(state);
        self.answered_before.clone_from(&self.answered);
        self.cuts.begin();
        let mut cuts = 0;
        loop {
            self.cuts.count(u64::from(self.substep.now()), state.time)?;
            let put_in = self.in_parts(before, state, with, work, clock)?;
            let mut constraints = if may_cut { with.fared(&state.knots) } else { Fared::default() };
            constraints.is_violated |= self.ties.give_way(&self.starts[0].knots, &state.knots);
            let made = self.step_energy(energy, put_in, state, with);
            if self.substep.accept(made, constraints) {
                return Ok(cuts);
            }
            // Cables or contacts made energy, rows took it, or threads are too long: back to the start, and on in more parts.
            state.clone_from(&self.starts[0]);
            self.answered.clone_from(&self.answered_before);
            self.world.write(state);
            self.contacts.rollback();
            with.rollback();
            cuts += 1;
        }
    }

    /// What the step did with energy that brought the net from `energy` and `put_in` [J] to `state`.
    fn step_energy(&self, energy: f64, put_in: f64, state: &State, with: &Interactions) -> StepEnergy {
        let now = self.cables.energy(&state.knots);
        let by_cables = now - put_in - energy;
        // What a contact takes from light knots and cables give them back at once is no gain of the cables, so what
        // both make is looked for in their sum.
        let rise = match with.touch() || !self.contacts.is_by_force() {
            true => self.books.rise(now - energy, &self.starts[0], state),
            false => f64::NEG_INFINITY,
        };
        let taken_by_rows = match self.books.gave {
            // What contacts took at the kick and rows gave back would count as taken by rows.
            true => 0.0,
            false => -by_cables - self.cables.taken_by_law(),
        };
        // In this order what is not a number stays so.
        let made = if rise > by_cables { rise } else { by_cables };
        StepEnergy { at_end: energy + by_cables, made, taken_by_rows }
    }

    /// The step in as many parts as are asked for; the work of contacts and effects on the net within it [J].
    fn in_parts(
        &mut self,
        before: &State,
        state: &mut State,
        with: &mut Interactions,
        work: &mut Work,
        clock: &mut Clock,
    ) -> Result<f64, Failure> {
        let n_parts = self.substep.now();
        let step = self.step / f64::from(n_parts);
        let mut put_in = 0.0;
        self.books.begin();
        self.cables.begin();
        self.contacts.begin(state);
        state.tension.fill(0.0);
        state.forces.acted_at.clear();
        for part in 0..n_parts {
            if with.constrain() {
                self.books.begin_part(&state.knots.velocity);
            }
            if with.push() {
                self.kick(state, step, n_parts);
            }
            // Snaps before the world moves: its implicit rows would swallow them.
            self.cables.prepare(state, step, self.beside(with), &mut self.world);
            if part > 0 {
                self.starts[1].clone_from(state);
            }
            put_in += self.act(state, step, with);
            failure::check(state, "cables")?;
            clock.lap(&mut work.stages.cables);

            put_in += self.advance(state, step, with, work);
            self.check_world(state)?;
            if with.constrain() {
                put_in += self.books.work_of_constraints(&state.knots.velocity);
            }
            clock.lap(&mut work.stages.world);

            if self.contacts.is_of_engine() {
                // What the engine's contacts do to the target begins after what effects did to it, the second time too.
                let is_pushed = part == 0 && self.moved_from != before.bodies;
                if is_pushed {
                    self.starts[1].clone_from(before);
                }
                if part > 0 || is_pushed {
                    self.starts[1].bodies.clone_from(&self.moved_from);
                }
                let start = if part == 0 && !is_pushed { before } else { &self.starts[1] };
                put_in += self.contacts.read_engine(&mut self.world, start, state, step);
                failure::check(state, "contact")?;
                clock.lap(&mut work.stages.contact);
            }
            if !self.contacts.is_by_force() {
                self.cables.observe(state);
                clock.lap(&mut work.stages.cables);
            }
        }
        Ok(put_in + self.books.work_of_forces(&state.forces.on_knots, &before.knots, &state.knots))
    }

    /// Forces of effects act first in every part, so that snaps, threads and contacts, which are answered before the engine, look at what these leave: a net
    /// of 0.5 mm that a stream of 100 kg/m³ pressed on a satellite at 3 m/s came 45 mm in where contacts did not, and made 2.4e-3 of the energy at
    /// hand; 4 mm and 1.6e-4 so.
    fn kick(&mut self, state: &mut State, step: f64, n_parts: u32) {
        let State { knots, forces, .. } = state;
        forces.act_at(knots.position.iter().copied(), 1.0 / f64::from(n_parts));
        for ((velocity, force), inverse_mass) in
            knots.velocity.iter_mut().zip(&forces.on_knots).zip(&self.inverse_mass)
        {
            *velocity += step * inverse_mass * force;
        }
        self.world.write_velocities(state);
    }

    /// Whether contacts are answered before the engine moves the net: those of effects, and of knots where impulses of ours do.
    fn answers(&self, with: &Interactions) -> bool {
        with.touch() || self.contacts.is_by_impulse()
    }

    /// What acts at the net beside its cables.
    fn beside(&self, with: &Interactions) -> Beside {
        match with.constrain() {
            false if self.is_apart && !with.touch() => Beside::Nothing,
            _ if self.answers(with) => Beside::Contacts,
            true => Beside::Constraints,
            false => Beside::Target,
        }
    }

    /// Detection, contact rows, cable rows and motion, sub-step by sub-step; again where what is answered before finds that it gave too
    /// little. The work of what it adds on the net [J].
    fn advance(&mut self, state: &mut State, step: f64, with: &mut Interactions, work: &mut Work) -> f64 {
        let mut added = 0.0;
        let answers = self.answers(with);
        for repeat in 0..=REPEATS {
            if answers {
                self.answered_start.clone_from(state);
            }
            let target = state.target().copied().filter(|_| self.contacts.is_own());
            self.moved_from.clone_from(&state.bodies);
            self.cables.mark(&state.knots);
            self.world.advance(state, step, self.iterations.now());
            self.cables.correct(&mut state.knots, step, &mut self.world);
            if let Some(mut body) = target {
                // To the engine it touches nothing, and is turned to first order in the step.
                state.body_models[TARGET].drift(&mut body, step);
                state.bodies[TARGET] = body;
                self.world.set_target(&body);
            }
            work.substeps += 1;
            work.sweeps += u64::from(self.iterations.now());
            work.detections += u64::from(self.world.detecting());
            let may_correct = answers && repeat < REPEATS;
            match may_correct.then(|| self.correct(state, step, with)).flatten() {
                Some(by_contacts) => added += by_contacts,
                None => break,
            }
        }
        self.cables.book(&state.knots, step);
        added
    }

    /// Goes back to before the world moved with what contacts lacked, if they did. Their work on the net [J].
    fn correct(&mut self, state: &mut State, step: f64, with: &mut Interactions) -> Option<f64> {
        self.untouched.clone_from(&state.knots.velocity);
        let mut net = MarkedKnots {
            knots: &mut state.knots,
            before: &[],
            inverse_mass: &self.inverse_mass,
            touched: &mut self.touched,
        };
        with.correct_contacts(&mut net, step);
        let mut added = None;
        for (knot, touched) in self.touched.iter_mut().enumerate() {
            if std::mem::take(touched) {
                let change = state.knots.velocity[knot] - self.untouched[knot];
                let start = &mut self.answered_start;
                let impulse = change / self.inverse_mass[knot];
                *added.get_or_insert(0.0) += impulse.dot(&(start.knots.velocity[knot] + 0.5 * change));
                start.knots.velocity[knot] += change;
                self.books.give(knot, impulse, &start.knots.position[knot], &start.bodies);
            }
        }
        let lacks = self.shared.lack(&mut self.contacts, with, [&self.answered_start, state], step);
        if added.is_some() || lacks {
            state.clone_from(&self.answered_start);
            self.world.write(state);
        }
        if lacks {
            *added.get_or_insert(0.0) += self.touch(state, step, with, true);
        }
        added
    }

    /// What effects do before the world moves. The contacts' work on the net [J].
    fn act(&mut self, state: &mut State, step: f64, with: &mut Interactions) -> f64 {
        // Constraints last but for contacts: nothing but the world's rows then spoils them.
        if with.constrain() {
            self.constrain(state, step, with);
        }
        if self.answers(with) { self.touch(state, step, with, false) } else { 0.0 }
    }

    /// Constraints act in every part.
    fn constrain(&mut self, state: &mut State, step: f64, with: &mut Interactions) {
        self.untouched.clone_from(&state.knots.velocity);
        with.solve_constraints(&mut state.knots, step, &mut self.touched);
        for (knot, touched) in self.touched.iter_mut().enumerate() {
            if std::mem::take(touched) {
                let (old, new) = (&self.untouched[knot], &state.knots.velocity[knot]);
                self.books.pull(knot, (new - old) / self.inverse_mass[knot]);
                self.world.set_velocity(knot, new);
            }
        }
    }

    /// Contacts of effects are answered in every part, for a part: an impulse for the whole step at its start, with cables
    /// and threads that pull on in the parts after it, made 3e-2 of the energy of a closing Cubesat's net. What cables did
    /// since the last answer is no hit: strands that bounced of it made 91 times the launch energy. Their work on
    /// the net [J]. Those that share rows may be answered `again`.
    fn touch(&mut self, state: &mut State, step: f64, with: &mut Interactions, again: bool) -> f64 {
        self.untouched.clone_from(&state.knots.velocity);
        self.unpushed.clone_from(&state.bodies);
        let energy = state.energy_of_bodies(true);
        let State { knots, bodies, .. } = state;
        let before = self.answered.as_slice();
        if !again {
            with.solve_contacts(knots, before, bodies, step, &mut self.touched);
        }
        if with.share_rows() || self.contacts.is_by_impulse() {
            let (inverse_mass, touched) = (self.inverse_mass.as_slice(), self.touched.as_mut_slice());
            let mut net = MarkedKnots { knots, before, inverse_mass, touched };
            self.shared.solve(&mut self.contacts, with, &mut net, bodies, step, again);
        }
        if !again && (with.bounce() || self.contacts.bounce()) {
            self.answered.clone_from(&state.knots.velocity);
        }
        let mut work = 0.0;
        for (knot, touched) in self.touched.iter_mut().enumerate() {
            if std::mem::take(touched) {
                let (old, new) = (&self.untouched[knot], &state.knots.velocity[knot]);
                let impulse = (new - old) / self.inverse_mass[knot];
                work += 0.5 * impulse.dot(&(old + new));
                self.books.give(knot, impulse, &state.knots.position[knot], &self.unpushed);
                self.world.set_velocity(knot, new);
            }
        }
        if let Some(body) = state.target().filter(|_| state.bodies != self.unpushed) {
            self.world.set_target(body);
            self.books.give_to_target(state.energy_of_bodies(true) - energy);
        }
        work
    }

    /// Whether the explicit net flies on; the engine takes over what it has flown to.
    fn flies(&mut self, state: &State) -> bool {
        if self.flight.is_none() {
            return false;
        }
        let flies = self.world.apart(state);
        if !flies {
            self.world.write(state);
            self.flight = None;
        }
        flies
    }

    fn check_world(&self, state: &State) -> Result<(), Failure> {
        if self.world.has_quarantined() {
            return Err(Failure::Quarantine { time: state.time });
        }
        failure::check(state, "world")
    }

    fn count(&self, work: &mut Work) {
        work.detections = self.contacts.n_detections().unwrap_or(work.detections);
        work.cable_rows = self.cables.n_rows;
        work.snaps = self.cables.n_snaps();
    }
}

impl Stepper for RapierJoints {
    fn step(
        &mut self,
        before: &State,
        state: &mut State,
        with: &mut Interactions,
        work: &mut Work,
    ) -> Result<StepReport, Failure> {
        let start = self.cables.energy(&state.knots) + state.energy_of_bodies(true);
        if with.act_within() || self.contacts.is_by_impulse() {
            self.books.open(self.inverse_mass.len());
        }
        let mut report = StepReport::default();
        if self.flies(state) {
            self.books.begin();
            if let Some(flight) = &mut self.flight {
                report = flight.step(before, state, with, work)?;
            }
        } else {
            let mut clock = Clock::start();
            self.contacts.update(state, self.step);
            clock.lap(&mut work.stages.contact);
            if with.share_rows() && self.contacts.is_of_engine() {
                self.shared.update(before);
            }
            report.cuts = self.cut_as_needed(before, state, with, work, &mut clock)?;
            report.cable_loss = CableLoss::WithRows(self.cables.taken_by_law());
            if self.contacts.is_by_force() {
                let Self { contacts, world, inverse_mass, step, .. } = self;
                own_contact::solve(contacts, world, inverse_mass, *step, before, state);
                failure::check(state, "contact")?;
                clock.lap(&mut work.stages.contact);
                self.cables.observe(state);
                clock.lap(&mut work.stages.cables);
            }
            self.contacts.report(&before.knots, state, |from, to, list| with.report_contacts(from, to, list));
            self.count(work);
        }
        let gain = self.cables.energy(&state.knots) + state.energy_of_bodies(true) - start;
        let energy_error = self.books.error(gain, before, state, self.contacts.is_by_impulse());
        self.iterations.adapt(energy_error / self.launch_energy);
        Ok(StepReport { energy_error: Some(energy_error), ..report })
    }

    fn take_velocities(&mut self, state: &State) {
        // Until the boxes meet the explicit net flies, and the engine takes over what it has flown to.
        if self.flight.is_none() {
            self.world.write_velocities(state);
        }
    }

    fn census(&self) -> Census {
        let mut census = self.world.census();
        census.colliders += self.contacts.n_colliders();
        census
    }
}

/// How often a part of a step is done again at most, where contacts of effects find that they gave too little.
const REPEATS: u32 = 3;

/// How much shorter than the sub-steps of an explicit net parts of a step may be. Cables that all pull at once made 8.7e-4 of the
/// energy at hand in parts as short as these (`stress bullets-in-each-other`, 24 members; 1.3e-3 at half the step), 2.2e-4 and 5.3e-4 in half of
/// that, 2.0e-4 and 2.9e-4 in a quarter. Where they are not needed none are taken.
const FINEST: f64 = 4.0;

/// Parts as short as the sub-steps of an explicit net, or so many times shorter. A force of our own acts once a step, so a
/// step with it and a target has one part.
fn most_parts(context: &BuildContext<'_>, finer: f64) -> u32 {
    if context.target.is_some() && context.solver.contact == ContactModel::Penalty {
        return 1;
    }
    let resolving = RESOLVES * stable_step(context.net);
    (finer * context.time_step.step / resolving).ceil().clamp(1.0, f64::from(MOST_PARTS)) as u32
}
