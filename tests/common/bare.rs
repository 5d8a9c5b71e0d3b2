//! A step as it would be had nobody thought of effects: the method, the books, and nothing between.

#![allow(dead_code)] // each of its users uses its own part

use nalgebra::Vector3;
use tumblenet::audit::EnergyAudit;
use tumblenet::case::Case;
use tumblenet::failure;
use tumblenet::interaction::Interactions;
use tumblenet::simulation::Simulation;
use tumblenet::state::State;
use tumblenet::step;
use tumblenet::step::stepper::Stepper;
use tumblenet::work::{Clock, Work};

/// A run without any hook of effects.
pub struct Bare {
    /// The state after the last step.
    pub state: State,
    before: State,
    stepper: Box<dyn Stepper>,
    audit: EnergyAudit,
    nothing: Interactions,
    work: Work,
    step: f64,
}

impl Bare {
    /// The start of `case`, which names no effect.
    pub fn new(case: &Case) -> Bare {
        let state = Simulation::new(case).state;
        let mut nothing = Interactions::default();
        Bare {
            before: state.clone(),
            stepper: step::method(&case.scene().solver).build(&case.context()),
            audit: EnergyAudit::start(case.net(), &mut nothing, &state),
            nothing,
            work: Work::default(),
            step: case.time_step().step,
            state,
        }
    }

    /// One step.
    pub fn step(&mut self) {
        self.before.clone_from(&self.state);
        let Bare { state, stepper, nothing, work, .. } = self;
        let report = stepper.step(&self.before, state, nothing, work).expect("numbers");
        self.state.step += 1;
        self.state.time = self.state.step as f64 * self.step;
        let mut clock = Clock::start();
        self.audit.record(&self.before, &self.state, self.step, &mut self.nothing, &report);
        self.work.steps += 1;
        self.work.contacts += self.state.contacts.len() as u64;
        clock.lap(&mut self.work.stages.observe);
        let created = self.audit.look_for_rise(0.0) / self.audit.energy_scale();
        failure::check_bounds(&self.state, self.audit.strained, created).expect("within bounds");
    }

    /// Positions of the knots.
    pub fn knots(&self) -> &[Vector3<f64>] {
        &self.state.knots.position
    }
}
