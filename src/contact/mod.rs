//! How a contact between net and target is answered.
//!
//! One file a response: [`rapier`] is the engine's own; [`impulse`] and [`penalty`] are the source's,
//! pure functions from [`Row`]s to impulses. [`watch`] finds their contacts and carries each as a
//! plane with the moving target; [`friction`] holds the laws.

pub mod friction;
pub mod impulse;
pub mod penalty;
pub mod rapier;
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
    /// Where impulses act: the knot's centre, from the target's centre of mass [m].
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
    /// Inverse of its inertia about the centre of mass, local frame unless said [1/(kg m^2)].
    pub inverse_inertia: Matrix3<f64>,
}

impl Mobility {
    /// That of `target`, in the body frame.
    pub fn of(target: &Target) -> Mobility {
        match target.motion {
            Motion::Free => Mobility {
                inverse_mass: 1.0 / target.mass,
                // A checked inertia is positive definite.
                inverse_inertia: target.inertia.try_inverse().unwrap_or_default(),
            },
            Motion::Fixed | Motion::Spinning => Mobility::default(),
        }
    }

    /// The same in the local frame, from the body frame of `body`.
    pub fn at(&self, body: &Body) -> Mobility {
        let turn = body.attitude.to_rotation_matrix();
        let inverse_inertia = turn.matrix() * self.inverse_inertia * turn.matrix().transpose();
        Mobility { inverse_inertia, ..*self }
    }

    /// Change of the surface's velocity along `direction` by a unit impulse along it at `arm` [1/kg].
    pub fn along(&self, direction: &Vector3<f64>, arm: &Vector3<f64>) -> f64 {
        let turn = arm.cross(direction);
        self.inverse_mass * direction.norm_squared() + turn.dot(&(self.inverse_inertia * turn))
    }
}
