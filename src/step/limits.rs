//! What a scene demands of a step, and what a method makes of that.

use crate::contact::penalty::PenaltyForce;
use crate::net::Net;
use crate::options::TimeStep;
use crate::solver::{ContactModel, Solver};
use crate::target::Target;

/// Steps that suit a method on a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimits {
    /// Largest step at which its explicit parts are stable [s]; infinite without any.
    pub stable: f64,
    /// Step at which they are stable together [s]; infinite without any.
    pub safe: f64,
    /// The steps that it takes: those that the scene asks for, or its own.
    pub chosen: TimeStep,
}

/// What a scene demands of a step.
#[derive(Clone, Copy)]
pub struct Demands<'a> {
    /// The numerical method.
    pub solver: &'a Solver,
    /// The net.
    pub net: &'a Net,
    /// The target, where the scene has one.
    pub target: Option<&'a Target>,
    /// Speed of the bullets at launch [m/s].
    pub launch_speed: f64,
    /// Time between two frames [s].
    pub sample: f64,
    /// Whether something holds knots within a step.
    pub has_constraints: bool,
}

impl Demands<'_> {
    /// Speed of the fastest that is to meet: bullets, and the target's farthest point [m/s].
    pub fn fastest(&self) -> f64 {
        self.launch_speed + self.rim_speed()
    }

    /// Speed of a contact, at most: a snap can double a knot's speed [m/s]; 0 without a target.
    pub fn contact_speed(&self) -> f64 {
        if self.target.is_some() { 2.0 * self.launch_speed + self.rim_speed() } else { 0.0 }
    }

    fn rim_speed(&self) -> f64 {
        self.target.map_or(0.0, |target| target.spin.norm() * target.bounding_radius)
    }

    /// Largest step within which no knot crosses half of the target's thinnest part [s]: past the middle
    /// of a part a knot is pushed out on its far side. Infinite without a target.
    pub fn thin_step(&self) -> f64 {
        self.target.map_or(f64::INFINITY, |target| 0.5 * target.thinnest / self.fastest())
    }

    /// Distance from which solvers of our own look for contacts [m].
    pub fn contact_margin(&self) -> f64 {
        let thinnest = self.target.map_or(0.0, |target| target.thinnest);
        let thickest = self.net.radius.iter().copied().fold(0.0, f64::max);
        self.solver.reach_m.map_or((0.04 * thinnest).max(2.0 * thickest), |reach| reach.0)
    }

    /// Whether contact is a force, which has a stable step of its own.
    pub fn has_contact_force(&self) -> bool {
        self.solver.contact == ContactModel::Penalty && self.target.is_some()
    }

    /// Largest stable step of that force [s]; infinite without it.
    pub fn stable_contact_step(&self) -> f64 {
        if !self.has_contact_force() {
            return f64::INFINITY;
        }
        PenaltyForce::new(self.net, &self.solver.penalty).stable_step(self.net, self.contact_speed())
    }
}
