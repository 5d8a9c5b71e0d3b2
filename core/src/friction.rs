//! Friction laws (Section 4.2.2): the coefficient at a sliding speed.

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
    /// Whether it is not zero at every speed.
    pub fn acts(&self) -> bool {
        match *self {
            Law::Coulomb { coefficient } => coefficient > 0.0,
            Law::Hollars { kinetic, static_, .. } => kinetic > 0.0 || static_ > 0.0,
        }
    }

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
}
