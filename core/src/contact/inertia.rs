//! How a body answers an impulse.

use nalgebra::{Matrix3, Vector3};

use crate::state::{Body, BodyModel};

/// Inverse spatial inertia of a body; all zero for one that is held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InverseInertia {
    /// One over its mass [1/kg].
    pub inverse_mass: f64,
    /// Inverse of its inertia about the centre of mass, local frame unless said [1/(kg m^2)].
    pub inverse_inertia: Matrix3<f64>,
}

impl InverseInertia {
    /// That of `model`, in the body frame.
    pub fn of(model: &BodyModel) -> InverseInertia {
        if !model.is_free() {
            return InverseInertia::default();
        }
        InverseInertia {
            inverse_mass: 1.0 / model.mass,
            // A checked inertia is positive definite.
            inverse_inertia: model.inertia().try_inverse().unwrap_or_default(),
        }
    }

    /// The same in the local frame, from the body frame of `body`.
    pub fn at(&self, body: &Body) -> InverseInertia {
        let turn = body.attitude.to_rotation_matrix();
        let inverse_inertia = turn.matrix() * self.inverse_inertia * turn.matrix().transpose();
        InverseInertia { inverse_inertia, ..*self }
    }

    /// Takes an `impulse` [N s] and its `moment` about the centre of mass [N m s] from `body`, whose this is in the local frame.
    #[inline(always)]
    pub fn take(&self, body: &mut Body, impulse: &Vector3<f64>, moment: &Vector3<f64>) {
        body.velocity -= self.inverse_mass * impulse;
        body.rate -= self.inverse_inertia * moment;
    }

    /// Change of the surface's velocity along `direction` by a unit impulse along it at `arm` [1/kg].
    pub fn inverse_mass_along(&self, direction: &Vector3<f64>, arm: &Vector3<f64>) -> f64 {
        let turn = arm.cross(direction);
        self.inverse_mass * direction.norm_squared() + turn.dot(&(self.inverse_inertia * turn))
    }
}
