//! Contacts answered by a force that grows with the overlap (Section 4.2).
//!
//! | law (Table 4.1) | force |
//! |---|---|
//! | spring-dashpot | k δ + d δ̇ |
//! | hertz | k δⁿ |
//! | hunt-crossley | k δⁿ + d δⁿ δ̇, d = 3 α k / 2 (Eq. 4.5) |
//!
//! δ is the overlap and δ̇ its rate. The print of Table 4.1 gives the last law as k δⁿ + d δ̇ⁿ; the
//! factor δⁿ of Hunt and Crossley, which makes the force start from zero as the text says it does,
//! was lost there. The force never pulls.
//!
//! Hertz stiffness of a ball of radius r on a plane (Eq. 4.3, 4.4):
//! k = 4 √r / (3 π (h₁ + h₂)), hᵢ = (1 − νᵢ²) / (π Eᵢ)   [N/m^1.5]
//!
//! The force is explicit over a (sub-)step h, which must resolve the contact: h below 2 / ω with
//! ω² = n k δⁿ⁻¹ / m at the deepest overlap that a knot reaches at a given speed.

use super::row::ContactRow;
use crate::net::Net;
use crate::solver;
use crate::solver::PenaltyLaw;

/// Step that resolves the bounce of a knot that is all of the net, over its stable step [-]. Semi-implicit Euler makes
/// energy of a bounce by the square of the step: four bullets that are all of their net make 0.16 of it at 0.6 of their
/// stable step, 1.8e-2 at 0.2, 4.5e-3 at 0.1, which is this for each of four (Hertz, nothing damped).
const BOUNCE: f64 = 0.05;

/// The force of a penalty.
#[derive(Clone, Debug, PartialEq)]
pub struct PenaltyForce {
    law: PenaltyLaw,
    /// k of each knot [N/m^n].
    stiffness: Vec<f64>,
    /// Of each knot [1/kg].
    inverse_mass: Vec<f64>,
    exponent: f64,
    /// d over k for Hunt and Crossley [s/m]; d itself for the spring-dashpot [N s/m].
    damping: f64,
}

impl PenaltyForce {
    /// That of contacts of `net`.
    pub fn new(net: &Net, parameters: &solver::Penalty) -> PenaltyForce {
        let linear = parameters.law == PenaltyLaw::SpringDashpot;
        let stiffness = |knot: usize| match parameters.stiffness {
            Some(stiffness) => stiffness.0,
            None => hertz(
                net.radius[knot],
                [net.young_modulus[knot], parameters.target_young_modulus_pa.0],
                parameters.poisson_ratios,
            ),
        };
        PenaltyForce {
            law: parameters.law,
            stiffness: (0..net.n_knots()).map(stiffness).collect(),
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            exponent: if linear { 1.0 } else { parameters.exponent },
            damping: match parameters.law {
                PenaltyLaw::SpringDashpot => parameters.damping_n_s_m,
                PenaltyLaw::Hertz => 0.0,
                PenaltyLaw::HuntCrossley => 1.5 * parameters.alpha_s_m,
            },
        }
    }

    /// A spring of the same stiffness at each of `n_knots` of 1 kg [N/m].
    #[cfg(test)]
    pub(super) fn spring(n_knots: usize, stiffness: f64) -> PenaltyForce {
        PenaltyForce {
            law: PenaltyLaw::SpringDashpot,
            stiffness: vec![stiffness; n_knots],
            inverse_mass: vec![1.0; n_knots],
            exponent: 1.0,
            damping: 0.0,
        }
    }

    /// Writes the impulse of each row within a step of `step` seconds [N s]; with a `speed` [m/s] the force grows no more beyond
    /// the overlap of a hit at that speed.
    pub fn solve(&self, rows: &mut [ContactRow], step: f64, speed: Option<f64>) {
        for row in rows {
            let (knot, overlap) = (self.softer(row.weights.all()), -row.gap);
            let depth = speed.map_or(overlap, |speed| {
                // By the mass of a cable's first knot, the cable between a bullet and a light knot was pressed in at this with a
                // force made for the bullet, and shot off.
                overlap.min(self.depth_of_hit(knot, 1.0 / row.inverse_mass, speed))
            });
            let impulse = step * self.force(knot, depth, -row.speed);
            let most = (row.wanted_speed - row.speed).max(0.0) / row.inverse_mass;
            row.impulse = impulse.min(most);
        }
    }

    /// The knot whose stiffness the place of some `bearers` has: a cable beside a bullet is no harder than elsewhere.
    fn softer(&self, bearers: &[(usize, f64)]) -> usize {
        let knots = bearers.iter().map(|(knot, _)| *knot);
        knots.min_by(|a, b| self.stiffness[*a].total_cmp(&self.stiffness[*b])).unwrap_or_default()
    }

    /// Normal force on a knot at overlap `depth` [m] that grows at `rate` [m/s]   [N].
    pub fn force(&self, knot: usize, depth: f64, rate: f64) -> f64 {
        if depth <= 0.0 {
            return 0.0;
        }
        let elastic = self.stiffness[knot] * depth.powf(self.exponent);
        let force = match self.law {
            PenaltyLaw::SpringDashpot => elastic + self.damping * rate,
            PenaltyLaw::Hertz => elastic,
            PenaltyLaw::HuntCrossley => elastic * (1.0 + self.damping * rate),
        };
        force.max(0.0)
    }

    /// Energy that its elastic part holds at overlap `depth` [m]   [J].
    pub fn energy(&self, knot: usize, depth: f64) -> f64 {
        let above = self.exponent + 1.0;
        self.stiffness[knot] * depth.max(0.0).powf(above) / above
    }

    /// Energy that the elastic part holds where the place of some `bearers` is pressed in by `depth` [m], and grows no more beyond the
    /// overlap of a hit at `speed` [m/s]   [J].
    pub fn energy_of(&self, bearers: &[(usize, f64)], depth: f64, speed: f64) -> f64 {
        let knot = self.softer(bearers);
        let inverse_mass: f64 = bearers.iter().map(|(knot, w)| w * w * self.inverse_mass[*knot]).sum();
        let deepest = self.depth_of_hit(knot, 1.0 / inverse_mass, speed);
        let beyond = (depth - deepest).max(0.0);
        self.energy(knot, depth - beyond) + beyond * self.force(knot, deepest, 0.0)
    }

    /// Deepest overlap of a `mass` [kg] with the stiffness of a knot that meets the target at `speed` [m/s], by energy:
    /// m v² / 2 = k δⁿ⁺¹ / (n + 1)   [m].
    fn depth_of_hit(&self, knot: usize, mass: f64, speed: f64) -> f64 {
        let n = self.exponent;
        (0.5 * mass * speed * speed * (n + 1.0) / self.stiffness[knot]).powf(1.0 / (n + 1.0))
    }

    /// Deepest overlap of the same knot that is pressed in with `pull` [N] beside:
    /// m v² / 2 + F δ = k δⁿ⁺¹ / (n + 1)   [m].
    fn deepest_pulled(&self, net: &Net, knot: usize, speed: f64, pull: f64) -> f64 {
        let unpulled = self.depth_of_hit(knot, net.mass[knot], speed);
        if pull == 0.0 {
            return unpulled;
        }
        // Newton from above, where the energy left over is convex: it falls to the root.
        let mut depth =
            unpulled + ((self.exponent + 1.0) * pull / self.stiffness[knot]).powf(1.0 / self.exponent);
        let moving = 0.5 * net.mass[knot] * speed * speed;
        for _ in 0..8 {
            let left = self.energy(knot, depth) - pull * depth - moving;
            depth -= left / (self.force(knot, depth, 0.0) - pull);
        }
        depth
    }

    /// Largest step at which knots that meet the target at `speed` [m/s], and are pressed in with `pull` [N], are
    /// stable [s]; `answering`: mass with which each answers an impulse [kg].
    pub fn stable_step(&self, net: &Net, answering: &[f64], speed: f64, pull: f64) -> f64 {
        let limit = |knot: usize| self.stable_step_of(net, knot, answering[knot], speed, pull);
        (0..net.n_knots()).map(limit).fold(f64::INFINITY, f64::min)
    }

    /// Largest step at which knots that bounce as in [`stable_step`](Self::stable_step) make at most some 5e-3 of the
    /// energy of `net` [s]: the heavier a knot, the finer it has to be resolved.
    pub fn resolving_step(&self, net: &Net, speed: f64, pull: f64) -> f64 {
        let total: f64 = net.mass.iter().sum();
        let limit = |knot: usize| {
            let mass = net.mass[knot];
            BOUNCE / (mass / total).sqrt() * self.stable_step_of(net, knot, mass, speed, pull)
        };
        (0..net.n_knots()).map(limit).fold(f64::INFINITY, f64::min)
    }

    /// The stable step of `knot` alone, which answers with `mass` [s].
    fn stable_step_of(&self, net: &Net, knot: usize, mass: f64, speed: f64, pull: f64) -> f64 {
        let (n, k) = (self.exponent, self.stiffness[knot]);
        let depth = self.deepest_pulled(net, knot, speed, pull);
        let frequency = (n * k * depth.powf(n - 1.0) / mass).sqrt();
        let damping = match self.law {
            PenaltyLaw::SpringDashpot => self.damping,
            _ => self.damping * k * depth.powf(n),
        };
        let ratio = 0.5 * damping / (mass * frequency);
        2.0 * ((1.0 + ratio * ratio).sqrt() - ratio) / frequency
    }
}

/// Hertz stiffness of a ball on a plane, Eq. 4.3 and 4.4 [N/m^1.5].
pub fn hertz(radius: f64, young_moduli: [f64; 2], poisson_ratios: [f64; 2]) -> f64 {
    let compliance =
        |i: usize| (1.0 - poisson_ratios[i] * poisson_ratios[i]) / (std::f64::consts::PI * young_moduli[i]);
    4.0 * radius.sqrt() / (3.0 * std::f64::consts::PI * (compliance(0) + compliance(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn penalty(law: PenaltyLaw) -> PenaltyForce {
        let linear = law == PenaltyLaw::SpringDashpot;
        PenaltyForce {
            law,
            stiffness: vec![1e6],
            inverse_mass: vec![1e4],
            exponent: if linear { 1.0 } else { 1.5 },
            damping: if linear { 5.0 } else { 0.3 },
        }
    }

    #[test]
    fn hertz_stiffness_of_two_equal_bodies() {
        // h₁ = h₂ = (1 − ν²) / (π E), so k = 2 E √r / (3 (1 − ν²)).
        let k = hertz(4e-4, [1e9, 1e9], [0.3, 0.3]);
        assert!((k - 2.0 * 1e9 * 0.02 / (3.0 * 0.91)).abs() < 1e-3, "{k}");
    }

    #[test]
    fn forces_follow_table_4_1_and_never_pull() {
        for law in [PenaltyLaw::SpringDashpot, PenaltyLaw::Hertz, PenaltyLaw::HuntCrossley] {
            let penalty = penalty(law);
            assert_eq!(penalty.force(0, -1e-6, 1.0), 0.0);
            assert!(penalty.force(0, 1e-9, -1e3) >= 0.0);
        }
        assert!((penalty(PenaltyLaw::SpringDashpot).force(0, 1e-4, 2.0) - 110.0).abs() < 1e-9);
        assert!((penalty(PenaltyLaw::Hertz).force(0, 1e-4, 2.0) - 1.0).abs() < 1e-9);
        assert!((penalty(PenaltyLaw::HuntCrossley).force(0, 1e-4, 2.0) - 1.6).abs() < 1e-9);
    }

    #[test]
    fn the_elastic_force_is_the_slope_of_its_energy() {
        for law in [PenaltyLaw::SpringDashpot, PenaltyLaw::Hertz, PenaltyLaw::HuntCrossley] {
            let (penalty, depth, h) = (penalty(law), 1e-4, 1e-8);
            let slope = (penalty.energy(0, depth + h) - penalty.energy(0, depth - h)) / (2.0 * h);
            assert!((slope / penalty.force(0, depth, 0.0) - 1.0).abs() < 1e-6, "{law:?}: {slope}");
            assert_eq!(penalty.energy(0, -depth), 0.0);
        }
    }

    /// A knot against a wall: Hertz gives its speed back, Hunt and Crossley less, 1 − α v to first order.
    #[test]
    fn bounce_keeps_or_loses_energy_as_the_law_says() {
        for (law, expected, within) in
            [(PenaltyLaw::Hertz, 1.0, 1e-3), (PenaltyLaw::HuntCrossley, 1.0 - 0.2 * 0.5, 0.02)]
        {
            let (penalty, mass, h) = (penalty(law), 1e-4, 1e-7);
            let (mut depth, mut rate) = (0.0_f64, 0.5_f64);
            while depth >= 0.0 {
                rate -= h * penalty.force(0, depth, rate) / mass;
                depth += h * rate;
            }
            assert!((-rate / 0.5 - expected).abs() < within, "{law:?}: {}", -rate / 0.5);
        }
    }
}
