//! What a scene demands of a step, and what a method makes of that.

use crate::contact::penalty::PenaltyForce;
use crate::net::Net;
use crate::options::{BuildOptions, TimeStep};
use crate::solver::{ContactModel, Solver};
use crate::target::Target;
use crate::target::spec::Motion;

/// Steps that suit a method on a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimits {
    /// Largest step at which its explicit parts are stable [s]; infinite without any.
    pub stable: f64,
    /// Step at which they are stable together [s]; infinite without any.
    pub safe: f64,
    /// The steps that it takes: those that the scene asks for, or its own.
    pub chosen: TimeStep,
    /// What `solver.step_s` says of them [s].
    pub written: f64,
}

/// Share of the speed of contact to which a thread may throw a knot within a part of a step [-]: what it throws, cables
/// and contacts catch with what iterations they have. Energy made on the Cubesat with its tube at 1, 5 and 20 N, over
/// the launch energy and the winches' work: 3e-3, 8e-2 and 5e-2 with whole steps (and knots 19 mm deep), 3e-3, 7e-4 and
/// 2e-3 with 1, some 1e-4 to 8e-4 with this.
pub const THROW: f64 = 0.5;

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
    /// What effects ask for.
    pub options: BuildOptions,
}

impl Demands<'_> {
    /// The longest step of at most `longest` [s] that meets every frame; as it is where it is longer than they are apart.
    ///
    /// A step that follows from how thick or how fast something is meets none: of Envisat frames came 20.086 ms apart for 20,
    /// and a run of another method, or a finer one, had none at the same times to be compared with.
    pub fn in_frames(&self, longest: f64) -> f64 {
        let steps = self.sample / longest;
        let meets = (steps - steps.round()).abs() < 1e-9 * steps;
        if steps < 1.0 || meets { longest } else { self.sample / steps.ceil() }
    }

    /// Speed of the fastest that is to meet: bullets, and the target's farthest point [m/s].
    pub fn fastest(&self) -> f64 {
        self.launch_speed + self.rim_speed() + self.target_speed()
    }

    /// Speed of a contact, at most: a snap can double a knot's speed, and a net falls onto a target that is held
    /// against the field [m/s]; 0 without a target.
    pub fn contact_speed(&self) -> f64 {
        let Some(target) = self.target else { return 0.0 };
        let shot = 2.0 * self.launch_speed;
        let falls = self.options.gravity > 0.0 && target.motion != Motion::Free;
        let net = if falls {
            let way = target.position.norm() + target.bounding_radius + self.net.designed_area.sqrt();
            (shot * shot + 2.0 * self.options.gravity * way).sqrt()
        } else {
            shot
        };
        net + self.rim_speed() + self.target_speed()
    }

    fn target_speed(&self) -> f64 {
        self.target.map_or(0.0, |target| target.velocity.norm())
    }

    fn rim_speed(&self) -> f64 {
        self.target.map_or(0.0, |target| target.spin.norm() * target.bounding_radius)
    }

    /// Largest step within which no knot crosses half of the target's thinnest part [s]: past the middle
    /// of a part a knot is pushed out on its far side. Infinite without a target.
    pub fn thin_step(&self) -> f64 {
        self.target.map_or(f64::INFINITY, |target| 0.5 * target.thinnest / self.fastest())
    }

    /// Largest step within which the pull of a thread moves no knot by half of the target's thinnest part [s]: where
    /// solvers of our own look for contacts once a step, a knot would be beyond the middle before it is looked at. A
    /// thread that turns back at a knot pulls twice. Infinite without.
    pub fn pulled_step(&self) -> f64 {
        let lightest = self.net.mass.iter().copied().fold(f64::INFINITY, f64::min);
        match self.target {
            Some(target) if self.options.pull > 0.0 && self.solver.contact != ContactModel::Rapier => {
                (0.5 * target.thinnest * lightest / self.options.pull).sqrt()
            }
            _ => f64::INFINITY,
        }
    }

    /// Step that suits the pull of threads where they act once in each [s]: the lightest knot is thrown no faster than
    /// what others catch (see [`THROW`]). Infinite without a target.
    pub fn throwing_step(&self) -> f64 {
        let lightest = self.net.mass.iter().copied().fold(f64::INFINITY, f64::min);
        let pulls = self.target.is_some() && self.options.pull > 0.0;
        if pulls { THROW * self.contact_speed() * lightest / self.options.pull } else { f64::INFINITY }
    }

    /// Step in which strands that touch come no farther than a sixth of what they are thick [s]; infinite where they do not. With bullets of 0.2 kg at
    /// 8 m/s around a cube that is held 212 pairs of strands of 1 mm went through each other in eight members at the cables' own step, 0.8 of what they are
    /// thick (with four times as many passes a third of them); a Cubesat's strands come 0.13 far, and none goes through.
    pub fn strand_step(&self) -> f64 {
        if self.options.strands_touch.is_none() || self.target.is_none() {
            return f64::INFINITY;
        }
        let radii = (0..self.net.cables.len()).map(|cable| self.net.cable_radius(cable));
        radii.fold(f64::INFINITY, f64::min) / (3.0 * self.fastest().max(f64::MIN_POSITIVE))
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
        let force = PenaltyForce::new(self.net, &self.solver.penalty);
        force.stable_step(self.net, &self.net.mass, self.contact_speed(), 2.0 * self.options.pull)
    }

    /// Largest step at which that force makes little of the energy of bullets that bounce off it [s]; infinite without it.
    pub fn resolving_contact_step(&self) -> f64 {
        if !self.has_contact_force() {
            return f64::INFINITY;
        }
        let force = PenaltyForce::new(self.net, &self.solver.penalty);
        force.resolving_step(self.net, self.contact_speed(), 2.0 * self.options.pull)
    }
}
