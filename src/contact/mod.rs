//! How a contact between net and target is answered.
//!
//! One file a response: [`rapier`] is the engine's own; [`impulse`] and [`penalty`] are the source's,
//! pure functions from [`Row`]s to impulses. [`watch`] finds their contacts and carries each as a
//! plane with the moving target; [`friction`] holds the laws.

pub mod approach;
pub mod cables;
pub mod friction;
pub mod impulse;
pub mod pairs;
pub mod penalty;
pub mod rapier;
pub mod sequential;
pub mod watch;

use nalgebra::{Matrix3, Vector3};

use crate::state::Body;
use crate::target::Target;
use crate::target::spec::Motion;

/// A contact as a response sees it, within one (sub-)step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The knot.
    pub knot: usize,
    /// One over the knot's mass [1/kg].
    pub inverse_mass: f64,
    /// Ball radius of the knot [m].
    pub radius: f64,
    /// Unit normal, from the target to the net.
    pub normal: Vector3<f64>,
    /// Where they touch, from the target's centre of mass [m].
    pub arm: Vector3<f64>,
    /// Gap at the start of the step; negative when they overlap [m].
    pub gap: f64,
    /// Velocity of the knot relative to the surface [m/s].
    pub velocity: Vector3<f64>,
}

impl Row {
    /// Speed of parting along the normal [m/s]; negative when they approach.
    pub fn speed(&self) -> f64 {
        self.normal.dot(&self.velocity)
    }

    /// Velocity across the normal [m/s].
    pub fn slip(&self) -> Vector3<f64> {
        self.velocity - self.speed() * self.normal
    }
}

/// How a target answers an impulse; all zero for one that is held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mobility {
    /// One over its mass [1/kg].
    pub inverse_mass: f64,
    /// Inverse of its inertia about the centre of mass, local frame [1/(kg m^2)].
    pub inverse_inertia: Matrix3<f64>,
}

impl Mobility {
    /// Change of the surface's velocity along `direction` by a unit impulse along it at `arm` [1/kg].
    pub fn along(&self, direction: &Vector3<f64>, arm: &Vector3<f64>) -> f64 {
        let turn = arm.cross(direction);
        self.inverse_mass * direction.norm_squared() + turn.dot(&(self.inverse_inertia * turn))
    }
}

/// A target's mass and inertia, in the body frame; zero mobility when it is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetMobility {
    inverse_mass: f64,
    inverse_inertia: Matrix3<f64>,
}

impl TargetMobility {
    /// Of `target`.
    pub fn of(target: &Target) -> TargetMobility {
        let free = target.motion == Motion::Free;
        TargetMobility {
            inverse_mass: if free { 1.0 / target.mass } else { 0.0 },
            inverse_inertia: target.inertia.try_inverse().filter(|_| free).unwrap_or_default(),
        }
    }

    /// As it lies now.
    pub fn at(&self, body: &Body) -> Mobility {
        let turn = body.attitude.to_rotation_matrix();
        Mobility {
            inverse_mass: self.inverse_mass,
            inverse_inertia: turn.matrix() * self.inverse_inertia * turn.matrix().transpose(),
        }
    }
}
