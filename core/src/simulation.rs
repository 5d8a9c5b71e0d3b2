//! The simulation: everything a case calls for, and the step.

use std::time::Duration;

use crate::audit::EnergyAudit;
use crate::case::Case;
use crate::failure::{self, Failure};
use crate::interaction::{Half, Interaction, Interactions, Report};
use crate::state::{Knots, State};
use crate::step;
use crate::step::stepper::{StepReport, Stepper};
use crate::work::{Clock, Work};
use crate::world::Census;

/// A run under way.
pub struct Simulation {
    /// The state after the last step.
    pub state: State,
    /// Energy and momenta.
    pub audit: EnergyAudit,
    /// Work done so far.
    pub work: Work,
    /// What the last step said of itself.
    pub report: StepReport,
    before: State,
    stepper: Box<dyn Stepper>,
    effects: Interactions,
    step: f64,
    /// Why it cannot begin.
    unfit: Option<Failure>,
}

impl Simulation {
    /// Builds what `case` calls for, and nothing else.
    pub fn new(case: &Case) -> Simulation {
        Simulation::with(case, Vec::new())
    }

    /// The same with effects that the scene does not know. Each effect and each body has a name of its own: two of one
    /// name end the first step.
    pub fn with(case: &Case, more: Vec<Interaction>) -> Simulation {
        let context = case.context();
        let stepper = step::method(context.solver).build(&context);
        Simulation::stepped_by(case, stepper, more)
    }

    /// The same with a method that the scene does not know.
    pub fn stepped_by(case: &Case, mut stepper: Box<dyn Stepper>, more: Vec<Interaction>) -> Simulation {
        let mut list = case.scene().effects.build(&case.context());
        list.extend(more);
        let mut effects = Interactions::new(list);
        let mut state = start(case, &effects);
        stepper.start(&mut state);
        Simulation {
            unfit: named_twice(&state, &effects),
            before: state.clone(),
            audit: EnergyAudit::start(case.net(), &mut effects, &state),
            work: Work::default(),
            report: StepReport::default(),
            stepper,
            step: case.time_step().step,
            state,
            effects,
        }
    }

    /// One step.
    ///
    /// # Errors
    /// A state that is not a number; two effects or bodies of one name, at the first step.
    pub fn step(&mut self) -> Result<(), Failure> {
        self.unfit.take().map_or(Ok(()), Err)?;
        self.effects.begin_step(&self.state);
        // Fields kick first: the rest of the step is then as if there were none.
        self.half_kick(Half::First);
        // What nothing touches moves on before all that pulls at it looks where it is.
        self.state.drift_bodies(false, self.step);
        self.before.clone_from(&self.state);

        // Forces next: they are frozen over the step.
        self.apply_forces();

        // Detection, contact, cables and motion, as the method orders them.
        self.effects.start_of_step(&self.before);
        self.report = self.stepper.step(&self.before, &mut self.state, &mut self.effects, &mut self.work)?;
        self.state.step += 1;
        // From the count, not by adding: a million steps must not drift.
        self.state.time = self.state.step as f64 * self.step;

        self.record();

        // The other half of the kick, where the knots are now.
        self.half_kick(Half::Second);
        self.look_at_bounds()
    }

    /// # Errors
    /// A run that has left all bounds.
    fn look_at_bounds(&mut self) -> Result<(), Failure> {
        let created = self.audit.look_for_rise(self.effects.may_hold());
        failure::check_bounds(&self.state, self.audit.strained, created / self.audit.energy_scale())
    }

    fn half_kick(&mut self, half: Half) {
        if !self.effects.kick() {
            return;
        }
        let audit = &mut self.audit;
        self.effects.half_kick(&mut self.state, self.step, half, |index, work| audit.add(index, work));
        if half == Half::First {
            self.stepper.take_velocities(&self.state);
        }
        self.audit.book_kick(&self.state);
        if half == Half::Second {
            self.audit.measure_kicked(&self.state, &mut self.effects);
        }
    }

    fn apply_forces(&mut self) {
        if !self.effects.push() {
            return;
        }
        self.effects.apply_forces(&mut self.state, self.step);
        self.stepper.take_velocities(&self.state);
    }

    fn record(&mut self) {
        let mut clock = Clock::start();
        self.audit.record(&self.before, &self.state, self.step, &mut self.effects, &self.report);
        self.work.steps += 1;
        self.work.contacts += self.state.contacts.len() as u64;
        clock.lap(&mut self.work.stages.observe);
    }

    /// What the engine consists of.
    pub fn census(&mut self) -> Census {
        let mut census = self.stepper.census();
        census.colliders += self.effects.n_colliders();
        census
    }

    /// Wall time of each active effect so far.
    pub fn effect_times(&self) -> &[Duration] {
        self.effects.times()
    }

    /// What each active effect installed, in words.
    pub fn effect_installs(&self) -> Vec<(&'static str, String)> {
        self.effects.list().iter().map(|effect| (effect.name, effect.about.clone())).collect()
    }

    /// Names of what the effects have to say in every frame.
    pub fn columns(&mut self) -> Vec<String> {
        self.effects.columns()
    }

    /// Their values now.
    pub fn values(&mut self) -> Vec<f64> {
        self.effects.values(&self.state)
    }

    /// What each effect has to say at the end, by name.
    pub fn reports(&mut self) -> Vec<(&'static str, Report)> {
        self.effects.reports(&self.state)
    }

    /// Names of the active effects, in the order of the list.
    pub fn effect_names(&self) -> Vec<&'static str> {
        self.effects.list().iter().map(|effect| effect.name).collect()
    }
}

/// What is found by its name alone is to be there once.
fn named_twice(state: &State, effects: &Interactions) -> Option<Failure> {
    let twice = |what, names: Vec<&str>| {
        let again = names.iter().enumerate().find(|(index, name)| names[..*index].contains(name));
        again.map(|(_, name)| Failure::NamedTwice { what, name: (*name).to_owned() })
    };
    let effects = effects.list().iter().map(|effect| effect.name).collect();
    let bodies = state.body_models.iter().map(|model| model.name.as_str()).collect();
    twice("effects", effects).or_else(|| twice("bodies", bodies))
}

/// Net in its container, just shot; target as placed, and bodies of `effects` as they bring them.
fn start(case: &Case, effects: &Interactions) -> State {
    let knots = Knots { position: case.net().folded.clone(), velocity: case.net().launch_velocity.clone() };
    let target = case.target().map(|target| (target.model(), target.start()));
    let brought = effects.list().iter().flat_map(|effect| effect.bodies.iter().cloned());
    let state = State { knots, tension: vec![0.0; case.net().cables.len()], ..State::default() };
    state.with_bodies(target.into_iter().chain(brought))
}
