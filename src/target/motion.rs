//! A rigid body between impulses, where the engine does not move it.
//!
//! Free: no force acts, so momentum and angular momentum L are constant and ω = I⁻¹ L follows the
//! attitude. The turn over a step uses ω at its middle, R(t+h) = exp(h ω(t + h/2)) R(t): second
//! order, with L kept to rounding.

use nalgebra::{Matrix3, UnitQuaternion};

use super::Target;
use super::spec::Motion;
use crate::state::Body;

/// Moves a target.
#[derive(Clone, Copy, Debug)]
pub struct RigidMotion {
    motion: Motion,
    inertia: Matrix3<f64>,
    inverse_inertia: Matrix3<f64>,
}

impl RigidMotion {
    /// The motion of `target`.
    pub fn of(target: &Target) -> RigidMotion {
        RigidMotion::new(target.motion, target.inertia)
    }

    /// The motion of a body of `inertia` in its own frame [kg m^2], positive definite.
    pub fn new(motion: Motion, inertia: Matrix3<f64>) -> RigidMotion {
        RigidMotion { motion, inertia, inverse_inertia: inertia.try_inverse().unwrap_or_default() }
    }

    /// `body` after `step` seconds.
    pub fn drift(&self, body: &mut Body, step: f64) {
        if self.motion == Motion::Fixed {
            return;
        }
        body.position += step * body.velocity;
        if body.rate.norm_squared() == 0.0 {
            return;
        }
        if self.motion == Motion::Spinning {
            body.attitude = UnitQuaternion::from_scaled_axis(step * body.rate) * body.attitude;
            return;
        }
        let momentum = body.angular_momentum(&self.inertia);
        let rate_at = |attitude: &UnitQuaternion<f64>| {
            attitude * (self.inverse_inertia * attitude.inverse_transform_vector(&momentum))
        };
        let middle = UnitQuaternion::from_scaled_axis(0.5 * step * body.rate) * body.attitude;
        let turned = UnitQuaternion::from_scaled_axis(step * rate_at(&middle)) * body.attitude;
        body.attitude = UnitQuaternion::new_normalize(turned.into_inner());
        body.rate = rate_at(&body.attitude);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// A body tumbling about its middle axis flips, with momentum to rounding and energy to the step's order.
    #[test]
    fn a_body_tumbling_about_its_middle_axis_flips() {
        let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0));
        let motion = RigidMotion::new(Motion::Free, inertia);
        let mut body = Body {
            position: Vector3::zeros(),
            attitude: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            rate: Vector3::new(1e-3, 1.0, 0.0),
        };
        let (momentum, energy) = (body.angular_momentum(&inertia), body.kinetic_energy(1.0, &inertia));
        let mut flipped = false;
        for _ in 0..300_000 {
            motion.drift(&mut body, 1e-3);
            flipped |= body.spin().y < -0.9;
        }
        assert!(flipped);
        let drift = (body.angular_momentum(&inertia) - momentum).norm() / momentum.norm();
        assert!(drift < 1e-9, "{drift:e}"); // measured 1.2e-10, rounding of 300 000 steps
        let gain = (body.kinetic_energy(1.0, &inertia) / energy - 1.0).abs();
        assert!(gain < 1e-5, "{gain:e}");
    }
}
