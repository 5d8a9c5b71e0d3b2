//! Friction laws (Section 4.2.2): the coefficient at a sliding speed.

use nalgebra::Vector3;

use super::{Mobility, Row};

/// A friction law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// One coefficient for sticking and sliding.
    Coulomb {
        /// μ [-]
        coefficient: f64,
    },
    /// Hollars' law, Eq. 4.6: rises to its largest near the transition speed, falls to μ_k beyond.
    Hollars {
        /// μ_k [-]
        kinetic: f64,
        /// μ_s [-]
        static_: f64,
        /// v_t0 [m/s]
        transition_speed: f64,
    },
}

impl Law {
    /// f_t / f_n at `speed` [m/s].
    pub fn coefficient(&self, speed: f64) -> f64 {
        match *self {
            Law::Coulomb { coefficient } => coefficient,
            // min(v / v_t0, 1) (μ_k + 2 (μ_s − μ_k) / (1 + (v / v_t0)²))
            Law::Hollars { kinetic, static_, transition_speed } => {
                let ratio = speed / transition_speed;
                ratio.min(1.0) * (kinetic + 2.0 * (static_ - kinetic) / (1.0 + ratio * ratio))
            }
        }
    }

    /// Friction impulse on the knot for a normal impulse (Eq. 4.10) [N s]: against the slip, and at
    /// most what stops it.
    pub fn impulse(&self, row: &Row, mobility: &Mobility, normal_impulse: f64) -> Vector3<f64> {
        let slip = row.slip();
        let speed = slip.norm();
        if speed <= 0.0 || normal_impulse <= 0.0 {
            return Vector3::zeros();
        }
        let direction = slip / speed;
        let stopping = speed / (row.inverse_mass + mobility.along(&direction, &row.arm));
        -(self.coefficient(speed) * normal_impulse).min(stopping) * direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hollars_peaks_at_the_static_coefficient() {
        let law = Law::Hollars { kinetic: 0.2, static_: 0.3, transition_speed: 0.01 };
        assert_eq!(law.coefficient(0.0), 0.0);
        assert!((law.coefficient(0.01) - 0.3).abs() < 1e-12);
        assert!((law.coefficient(10.0) - 0.2).abs() < 1e-6);
    }

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
        let impulse = law.impulse(&row, &Mobility::default(), 0.2);
        assert!((impulse - Vector3::new(0.0, -0.06, -0.08)).norm() < 1e-15, "{impulse}");
        let stopped = law.impulse(&row, &Mobility::default(), 1e3);
        assert!((row.slip() + row.inverse_mass * stopped).norm() < 1e-12);
    }
}
