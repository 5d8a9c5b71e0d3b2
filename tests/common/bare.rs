//! A step as it would be had nobody thought of effects: the method, the books, and nothing between.

#![allow(dead_code)] // each of its users uses its own part

use nalgebra::Vector3;
use tumblenet::audit::EnergyAudit;
use tumblenet::case::Case;
use tumblenet::simulation::Simulation;
use tumblenet::state::{Body, Contact, Knots, State};
use tumblenet::step::{Method, Pull};
use tumblenet::work::{Clock, Work};

/// A run without any hook of effects.
pub struct Bare {
    /// The state after the last step.
    pub state: State,
    before: State,
    method: Method,
    audit: EnergyAudit,
    work: Work,
    launch_energy: f64,
    step: f64,
}

/// Nothing to pull.
struct Nothing;

impl Pull for Nothing {
    fn pulls(&self) -> bool {
        false
    }

    fn reach(&self, _knots: &mut Vec<usize>) {}

    fn pull(&mut self, _knots: &mut Knots, _step: f64, _touched: &mut [bool]) {}

    fn keep(&mut self) {}

    fn overran(&mut self, _knots: &Knots) -> bool {
        false
    }

    fn take_back(&mut self) {}

    fn presses(&self) -> bool {
        false
    }

    fn press(&mut self, _knots: &mut Knots, _target: &mut Option<Body>, _step: f64, _touched: &mut [bool]) {}

    fn report(&self, _before: &Knots, _after: &Knots, _contacts: &mut Vec<Contact>) {}
}

impl Bare {
    /// The start of `case`, which names no effect.
    pub fn new(case: &Case) -> Bare {
        let plan = case.plan();
        let state = Simulation::new(case).state;
        Bare {
            before: state.clone(),
            method: Method::new(case, &plan),
            audit: EnergyAudit::start(&case.net, case.target.as_ref(), &[], &state),
            work: Work::default(),
            launch_energy: case.net.launch_energy(),
            step: plan.step,
            state,
        }
    }

    /// One step.
    pub fn step(&mut self) {
        self.before.clone_from(&self.state);
        self.method.advance(&self.before, &mut self.state, &mut self.work, &mut Nothing).expect("numbers");
        self.state.step += 1;
        self.state.time = self.state.step as f64 * self.step;
        let mut clock = Clock::start();
        let energy = self.audit.ledger.own();
        self.audit.record(&self.before, &self.state, &mut [], &mut []);
        self.method.hear_gain((self.audit.ledger.own() - energy) / self.launch_energy);
        self.work.steps += 1;
        self.work.contacts += self.state.contacts.len() as u64;
        clock.lap(&mut self.work.stages.observe);
    }

    /// Positions of the knots.
    pub fn knots(&self) -> &[Vector3<f64>] {
        &self.state.knots.position
    }
}
