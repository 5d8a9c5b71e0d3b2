//! The impulse of friction at a contact (Section 4.2.2).

use nalgebra::Vector3;

use super::InverseInertia;
use super::row::ContactRow;
use crate::friction::Law;

/// Friction impulse on the net for a normal impulse (Eq. 4.10) [N s], where the net slides at `velocity`
/// relative to the target [m/s]: against the slip, and at most what stops it.
pub fn slowing_impulse(
    law: &Law,
    row: &ContactRow,
    velocity: &Vector3<f64>,
    target: &InverseInertia,
) -> Vector3<f64> {
    let slip = velocity - row.normal.dot(velocity) * row.normal;
    let speed = slip.norm();
    if speed <= 0.0 || row.impulse <= 0.0 {
        return Vector3::zeros();
    }
    let direction = slip / speed;
    let stopping = speed / row.inverse_mass_along(&direction, target);
    -(law.coefficient(speed) * row.impulse).min(stopping) * direction
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::row::JacobianWeights;

    #[test]
    fn friction_slows_and_never_turns_the_slip() {
        let row = ContactRow {
            velocity: Vector3::new(-1.0, 3.0, 4.0),
            speed: -1.0,
            impulse: 0.2,
            ..ContactRow::held(JacobianWeights::of_knot(0), 2.0, Vector3::x(), Some(Vector3::zeros()))
        };
        let law = Law::Coulomb { coefficient: 0.5 };
        let slowed = |impulse| {
            slowing_impulse(&law, &ContactRow { impulse, ..row }, &row.velocity, &InverseInertia::default())
        };
        assert!((slowed(0.2) - Vector3::new(0.0, -0.06, -0.08)).norm() < 1e-15, "{}", slowed(0.2));
        let left = Vector3::new(0.0, 3.0, 4.0) + row.inverse_mass * slowed(1e3);
        assert!(left.norm() < 1e-12, "{left}");
        assert_eq!(slowed(0.0), Vector3::zeros());
    }
}
