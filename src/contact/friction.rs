//! The impulse of friction at a contact (Section 4.2.2).

use nalgebra::Vector3;

use super::{Mobility, Row};
use crate::friction::Law;

/// Friction impulse on the net for a normal impulse (Eq. 4.10) [N s]: against the slip, and at most
/// what stops it.
pub fn slowing_impulse(law: &Law, row: &Row, mobility: &Mobility, normal_impulse: f64) -> Vector3<f64> {
    let slip = row.slip();
    let speed = slip.norm();
    if speed <= 0.0 || normal_impulse <= 0.0 {
        return Vector3::zeros();
    }
    let direction = slip / speed;
    let stopping = speed / (row.inverse_mass + mobility.along(&direction, &row.arm));
    -(law.coefficient(speed) * normal_impulse).min(stopping) * direction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_slows_and_never_turns_the_slip() {
        let row = Row {
            knot: 0,
            inverse_mass: 2.0,
            radius: 1e-3,
            normal: Vector3::x(),
            arm: Vector3::zeros(),
            gap: 0.0,
            velocity: Vector3::new(-1.0, 3.0, 4.0),
        };
        let law = Law::Coulomb { coefficient: 0.5 };
        let impulse = slowing_impulse(&law, &row, &Mobility::default(), 0.2);
        assert!((impulse - Vector3::new(0.0, -0.06, -0.08)).norm() < 1e-15, "{impulse}");
        let stopped = slowing_impulse(&law, &row, &Mobility::default(), 1e3);
        assert!((row.slip() + row.inverse_mass * stopped).norm() < 1e-12);
    }
}
