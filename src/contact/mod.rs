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
pub mod preview;
pub mod rapier;
pub mod sequential;
pub mod watch;

use nalgebra::{Matrix3, Vector3};

use crate::state::{Body, Contact, Knots};
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

/// Impulses of a contact within a step, and the work of the target's surface against them.
///
/// Work on the net is impulse times the mean of a knot's velocity before and after the step: with all
/// impulses of the step so weighed, cables' among them, it is exactly the change of kinetic energy.
/// Over single kicks it would count as lost whatever cables press into a contact at rest. The target,
/// which contacts alone move, is weighed kick by kick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Along the normals [N s].
    along: Vector3<f64>,
    /// Across them [N s].
    across: Vector3<f64>,
    /// Work of both that the surface gives [J].
    from_surface: [f64; 2],
}

impl Tally {
    /// Adds impulses on the net along and across the normal, while the surface has the mean velocity
    /// `surface` [m/s].
    pub fn add(&mut self, along: &Vector3<f64>, across: &Vector3<f64>, surface: &Vector3<f64>) {
        self.along += along;
        self.across += across;
        self.from_surface[0] += along.dot(surface);
        self.from_surface[1] += across.dot(surface);
    }

    /// Work and losses within a step from `before` to `after`.
    pub fn weigh(&self, contact: &mut Contact, before: &Knots, after: &Knots) {
        let mean = 0.5 * (contact.at_place(&before.velocity) + contact.at_place(&after.velocity));
        contact.work_on_knot = (self.along + self.across).dot(&mean);
        contact.loss = self.from_surface[0] - self.along.dot(&mean);
        contact.friction_loss = self.from_surface[1] - self.across.dot(&mean);
    }
}
