//! The simulation: everything a case calls for, and the step.

use std::time::{Duration, Instant};

use crate::cables::joints::Joints;
use crate::case::Case;
use crate::contact;
use crate::effects::Effect;
use crate::ledger::Bookkeeper;
use crate::state::State;
use crate::world::sweeps::Sweeps;
use crate::world::{Census, Plan, World};

/// A run under way.
pub struct Simulation {
    /// The state after the last step.
    pub state: State,
    /// Energy and momenta.
    pub books: Bookkeeper,
    /// Work done so far.
    pub work: Work,
    before: State,
    world: World,
    cables: Joints,
    effects: Vec<Box<dyn Effect>>,
    any_effect_acts: bool,
    sweeps: Sweeps,
    launch_energy: f64,
    substeps: u32,
    step: f64,
}

/// Work done, in counts and in wall time by stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Work {
    /// Steps.
    pub steps: u64,
    /// Steps in which the engine looked for contacts.
    pub detections: u64,
    /// Contacts, summed over the steps.
    pub contacts: u64,
    /// Cable rows given to the engine, summed over the steps.
    pub cable_rows: u64,
    /// Cables that snapped.
    pub snaps: u64,
    /// Sweeps over all rows, summed over the sub-steps.
    pub sweeps: u64,
    /// Wall time of the stages.
    pub stages: Stages,
    /// Wall time of each effect, in the order of the list.
    pub effects: Vec<Duration>,
}

/// Wall time by stage of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stages {
    /// Forces of effects.
    pub effects: Duration,
    /// Snaps and rest of cables, and their tension.
    pub cables: Duration,
    /// The engine: detection, contact and cable rows, motion.
    pub world: Duration,
    /// Reading contacts.
    pub contact: Duration,
    /// Energy ledger.
    pub observe: Duration,
}

/// A run that cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// A knot's position or velocity is not a number.
    #[error("at {time:.6} s knot {knot} is not a number after stage `{stage}`")]
    Knot {
        /// Simulated time [s].
        time: f64,
        /// The knot.
        knot: usize,
        /// The stage after which it was found.
        stage: &'static str,
    },
    /// The target's pose or motion is not a number.
    #[error("at {time:.6} s the target is not a number after stage `{stage}`")]
    Target {
        /// Simulated time [s].
        time: f64,
        /// The stage after which it was found.
        stage: &'static str,
    },
    /// The engine set a body aside.
    #[error("at {time:.6} s the engine set a body aside whose state is not a number (stage `world`)")]
    Quarantine {
        /// Simulated time [s].
        time: f64,
    },
}

impl Simulation {
    /// Builds what `case` calls for, and nothing else.
    pub fn new(case: &Case) -> Simulation {
        let solver = &case.scene.solver;
        let effects = case.scene.effects.build();
        let mut plan = Plan {
            step: solver.step_s.0,
            substeps: solver.substeps,
            restitution: solver.restitution,
            friction: 0.0,
        };
        for effect in &effects {
            effect.install(&mut plan);
        }
        let mut world = World::new(&case.net, case.target.as_ref(), &plan);
        let cables = Joints::install(&case.net, solver, &mut world);
        let mut state = State::default();
        world.read(&mut state);
        state.tension = vec![0.0; case.net.cables.len()];
        Simulation {
            before: state.clone(),
            books: Bookkeeper::open(&case.net, case.target.as_ref(), &effects, &state),
            work: Work { effects: vec![Duration::ZERO; effects.len()], ..Work::default() },
            any_effect_acts: effects.iter().any(|effect| effect.acts()),
            sweeps: Sweeps::new(solver.sweeps, solver.sweeps_max),
            launch_energy: case.net.launch_energy().max(f64::MIN_POSITIVE),
            substeps: solver.substeps,
            step: solver.step_s.0,
            state,
            world,
            cables,
            effects,
        }
    }

    /// One step.
    ///
    /// # Errors
    /// A state that is not a number.
    pub fn step(&mut self) -> Result<(), Failure> {
        let mut clock = Clock::start();
        self.before.clone_from(&self.state);

        // Forces first: they are frozen over the step.
        self.apply_effects();
        clock.lap(&mut self.work.stages.effects);

        // Snaps before the world moves: its implicit rows would swallow them.
        self.cables.prepare(&mut self.state, &mut self.world);
        self.check("cables")?;
        clock.lap(&mut self.work.stages.cables);

        // Detection, contact rows, cable rows and motion, sub-step by sub-step.
        self.work.sweeps += u64::from(self.sweeps.now() * self.substeps);
        self.world.advance(&mut self.state, self.sweeps.now());
        self.state.step += 1;
        // From the count, not by adding: a million steps must not drift.
        self.state.time = self.state.step as f64 * self.step;
        self.check("world")?;
        clock.lap(&mut self.work.stages.world);

        contact::rapier::observe(&self.world, &mut self.state);
        clock.lap(&mut self.work.stages.contact);

        self.cables.observe(&mut self.state);
        clock.lap(&mut self.work.stages.cables);

        let energy = self.books.ledger.own();
        self.books.book(&self.before, &self.state, &mut self.effects, self.step);
        self.sweeps.hear((self.books.ledger.own() - energy) / self.launch_energy);
        self.count();
        clock.lap(&mut self.work.stages.observe);
        Ok(())
    }

    fn apply_effects(&mut self) {
        if !self.any_effect_acts {
            return;
        }
        self.state.loads.clear(self.state.knots.position.len());
        for (effect, time) in self.effects.iter_mut().zip(&mut self.work.effects) {
            if effect.acts() {
                let mut clock = Clock::start();
                effect.act(&self.before, &mut self.state.loads);
                clock.lap(time);
            }
        }
        self.world.apply(&self.state.loads);
    }

    fn check(&self, stage: &'static str) -> Result<(), Failure> {
        let time = self.state.time;
        if self.world.has_quarantined() {
            return Err(Failure::Quarantine { time });
        }
        if let Some(knot) = self.state.first_bad_knot() {
            return Err(Failure::Knot { time, knot, stage });
        }
        if !self.state.target_is_sound() {
            return Err(Failure::Target { time, stage });
        }
        Ok(())
    }

    fn count(&mut self) {
        self.work.steps += 1;
        self.work.detections += u64::from(self.world.detecting());
        self.work.contacts += self.state.contacts.len() as u64;
        self.work.cable_rows = self.cables.n_rows;
        self.work.snaps = self.cables.n_snaps;
    }

    /// What the world consists of.
    pub fn census(&self) -> Census {
        self.world.census()
    }

    /// What each active effect installed, in words.
    pub fn effect_installs(&self) -> Vec<(&'static str, String)> {
        self.effects.iter().map(|effect| (effect.name(), effect.installs())).collect()
    }

    /// Names of the active effects, in the order of the list.
    pub fn effect_names(&self) -> Vec<&'static str> {
        self.effects.iter().map(|effect| effect.name()).collect()
    }
}

/// Wall time from lap to lap.
struct Clock(Instant);

impl Clock {
    fn start() -> Self {
        Clock(Instant::now())
    }

    fn lap(&mut self, total: &mut Duration) {
        let now = Instant::now();
        *total += now - self.0;
        self.0 = now;
    }
}
