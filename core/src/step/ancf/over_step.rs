//! The law of an element over a whole step, from both of its ends: what an implicit step asks for.
//!
//! The mean force is the difference of stored energy (Gonzalez, Simo): with ε₀ and ε₁ at a point of the quadrature before
//! and after a step, W = ½ max(0, ε)², and ρ̄ the mean of ρ = ∂r/∂ξ,
//!
//! −(E A / l) ∫ N̄ Sᵢ′ ρ̄ dξ,  N̄ = (W(ε₁) − W(ε₀)) / (ε₁ − ε₀).
//!
//! ε is quadratic, so ε₁ − ε₀ = ρ̄ · (ρ₁ − ρ₀) / l², and the work of that force over the step is what the elements store, to
//! rounding, whatever the step and wherever in it a point goes taut or slack; it acts along ρ̄, so angular momentum is kept.
//! With pᵢ = max(0, εᵢ) and φ the share of the step that a steady change of ε spends above 0, N̄ = ½ (p₀ + p₁) φ.
//!
//! The dashpot acts for the share of the step in which the chord is longer than its length, likewise, and with the mean of
//! the chord's spring it never pushes.

use nalgebra::Vector3;

use super::element::{COORDINATES, GaussPoint};
use super::law::ElementLaw;
use super::motion::{LANES, Lanes, apart, lanes};

/// Pairs of r₁ − r₀, σ₀ and σ₁.
pub(super) const PAIRS: [[usize; 2]; 6] = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];

/// Pairs of axes of a symmetric matrix.
pub(super) const AXES: [[usize; 2]; 6] = [[0, 0], [1, 0], [1, 1], [2, 0], [2, 1], [2, 2]];

/// Shorter than any chord [m].
const SHORT: f64 = 1e-100;

/// Coordinates of elements of cables.
pub(super) type Nodes = [[Lanes; 3]; COORDINATES];

/// On r₁ − r₀, σ₀ and σ₁.
#[derive(Default)]
pub(super) struct OverStep {
    /// Mean force that it answers with, negative [N].
    pub(super) force: [[Lanes; 3]; 3],
    /// How that grows with the coordinates after the step [N/m], for [`PAIRS`] and [`AXES`]: made symmetric, since ρ̄ and ρ₁
    /// are nearly the same.
    pub(super) stiffness: [[Lanes; 6]; 6],
}

/// Share φ of a step above 0, what is above it on average, and how that average grows with the second value.
#[inline(always)]
fn above(before: f64, after: f64) -> [f64; 3] {
    let part = before.max(0.0) + after.max(0.0);
    let between = (after - before).abs();
    let is_part = before.min(after) < 0.0;
    let share = if is_part { part / between } else { 1.0 };
    let growth = if after > 0.0 { share * (1.0 - 0.5 * share) } else { 0.5 * share * share };
    let is_below = before.max(after) <= 0.0;
    let share = if is_below { 0.0 } else { share };
    [share, 0.5 * part * share, if is_below { 0.0 } else { growth }]
}

#[inline(always)]
fn square(v: &[Lanes; 3], i: usize) -> f64 {
    v[0][i] * v[0][i] + v[1][i] * v[1][i] + v[2][i] * v[2][i]
}

/// r₁ − r₀, σ₀ and σ₁.
#[inline(always)]
fn reduced(nodes: &Nodes) -> [[Lanes; 3]; 3] {
    [apart(&nodes[2], &nodes[0]), nodes[1], nodes[3]]
}

/// ρ = ∂r/∂ξ.
#[inline(always)]
fn tangent(factors: &[f64; 3], of: &[[Lanes; 3]; 3]) -> [Lanes; 3] {
    let mut rho = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for i in 0..LANES {
            rho[axis][i] =
                factors[0] * of[0][axis][i] + factors[1] * of[1][axis][i] + factors[2] * of[2][axis][i];
        }
    }
    rho
}

impl OverStep {
    /// Of the elements of cables from `at` on that have `before` and `after`, over a step of `step` seconds.
    #[inline(always)]
    pub(super) fn of(law: &ElementLaw, at: usize, before: &Nodes, after: &Nodes, step: f64) -> OverStep {
        let [before, after] = [reduced(before), reduced(after)];
        let mut all = OverStep::default();
        let axial = lanes(&law.axial, at);
        let inverse_square = lanes(&law.inverse_square, at);
        for point in &law.points {
            all.stretch(point, &before, &after, &axial, &inverse_square);
        }
        if law.damped {
            let (pull, gain) = dashpot(law, at, [&before[0], &after[0]], step);
            all.damp(&before[0], &after[0], &pull, &gain);
        }
        all
    }

    #[inline(always)]
    fn stretch(
        &mut self,
        point: &GaussPoint,
        before: &[[Lanes; 3]; 3],
        after: &[[Lanes; 3]; 3],
        axial: &Lanes,
        inverse_square: &Lanes,
    ) {
        let factors = [point.chord, point.slopes[0], point.slopes[1]];
        let [first, second] = [tangent(&factors, before), tangent(&factors, after)];
        let mut mean = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for i in 0..LANES {
                mean[axis][i] = 0.5 * (first[axis][i] + second[axis][i]);
            }
        }
        let (mut pull, mut growth) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let strain = |rho: &[Lanes; 3]| 0.5 * (square(rho, i) * inverse_square[i] - 1.0);
            let [_, strain, grows] = above(strain(&first), strain(&second));
            pull[i] = point.weight * axial[i] * strain;
            growth[i] = point.weight * axial[i] * grows * inverse_square[i];
        }
        for (on, factor) in self.force.iter_mut().zip(factors) {
            for axis in 0..3 {
                for i in 0..LANES {
                    on[axis][i] += factor * pull[i] * mean[axis][i];
                }
            }
        }
        let mut matrix = [[0.0; LANES]; 6];
        for (entry, [a, b]) in matrix.iter_mut().zip(AXES) {
            for i in 0..LANES {
                let along = growth[i] * mean[a][i] * mean[b][i];
                entry[i] = if a == b { along + 0.5 * pull[i] } else { along };
            }
        }
        for (sum, [one, other]) in self.stiffness.iter_mut().zip(PAIRS) {
            let factor = factors[one] * factors[other];
            for (sum, entry) in sum.iter_mut().zip(&matrix) {
                for i in 0..LANES {
                    sum[i] += factor * entry[i];
                }
            }
        }
    }

    #[inline(always)]
    fn damp(&mut self, before: &[Lanes; 3], after: &[Lanes; 3], pull: &Lanes, gain: &Lanes) {
        let mut mean = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for i in 0..LANES {
                mean[axis][i] = 0.5 * (before[axis][i] + after[axis][i]);
                self.force[0][axis][i] += pull[i] * mean[axis][i];
            }
        }
        for (sum, [a, b]) in self.stiffness[0].iter_mut().zip(AXES) {
            for i in 0..LANES {
                let along = gain[i] * mean[a][i] * mean[b][i];
                sum[i] += if a == b { along + 0.5 * pull[i].max(0.0) } else { along };
            }
        }
    }
}

/// What the dashpot gives over the mean chord [N/m], and how it grows with the square of that [N/m³]: c ṙ φ, with the spring
/// of the chord never pushing.
#[inline(always)]
fn dashpot(law: &ElementLaw, at: usize, [before, after]: [&[Lanes; 3]; 2], step: f64) -> (Lanes, Lanes) {
    let [axial, length, damping] = [&law.axial, &law.length, &law.damping].map(|values| lanes(values, at));
    let (mut pull, mut gain) = ([0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        let [first, second] = [before, after].map(|chord| square(chord, i).sqrt() - length[i]);
        let mut mean = 0.0;
        for axis in 0..3 {
            let chord = 0.5 * (before[axis][i] + after[axis][i]);
            mean += chord * chord;
        }
        let [share, stretch, _] = above(first, second);
        let wanted = damping[i] * share * (second - first) / step;
        let least = -axial[i] * stretch;
        let inverse = 1.0 / mean.sqrt().max(SHORT);
        let given = if wanted > least { wanted } else { least };
        let grows = if second > 0.0 && wanted > least { damping[i] / step } else { 0.0 };
        pull[i] = given * inverse;
        gain[i] = grows * inverse * inverse;
    }
    (pull, gain)
}

/// What the dashpots of those elements took within the step [J], and their largest stress times area over the length, at the
/// end of it or what the dashpot gave [N/m].
#[inline(always)]
pub(super) fn account(law: &ElementLaw, at: usize, before: &Nodes, after: &Nodes, step: f64) -> [Lanes; 2] {
    let [before, after] = [reduced(before), reduced(after)];
    let (mut taken, mut largest) = ([0.0; LANES], [0.0; LANES]);
    let inverse_square = lanes(&law.inverse_square, at);
    for point in &law.points {
        for i in 0..LANES {
            let rho = Vector3::from_fn(|axis, _| {
                point.chord * after[0][axis][i]
                    + point.slopes[0] * after[1][axis][i]
                    + point.slopes[1] * after[2][axis][i]
            });
            let strain = 0.5 * (rho.norm_squared() * inverse_square[i] - 1.0);
            largest[i] = if strain > largest[i] { strain } else { largest[i] };
        }
    }
    let axial = lanes(&law.axial, at);
    for i in 0..LANES {
        largest[i] *= axial[i];
    }
    if law.damped {
        let (pull, _) = dashpot(law, at, [&before[0], &after[0]], step);
        for i in 0..LANES {
            let grown = 0.5 * (square(&after[0], i) - square(&before[0], i));
            taken[i] = pull[i] * grown;
            largest[i] += pull[i];
        }
    }
    [taken, largest]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is above 0 on average over a steady change, times that change, is the difference of half the squares; and it grows
    /// as said.
    #[test]
    fn the_mean_of_what_is_taut_is_the_difference_of_its_energy() {
        let energy = |x: f64| 0.5 * x.max(0.0) * x.max(0.0);
        for (before, after) in
            [(0.2, 0.5), (-0.3, 0.4), (0.3, -0.1), (-0.2, -0.1), (0.0, 0.3), (0.1, 0.0), (0.0, 0.0)]
        {
            let [share, mean, growth] = above(before, after);
            assert!((0.0..=1.0).contains(&share));
            assert!((mean * (after - before) - (energy(after) - energy(before))).abs() < 1e-16);
            let step = 1e-6;
            let slope = (above(before, after + step)[1] - above(before, after - step)[1]) / (2.0 * step);
            let kink = before <= 0.0 && after == 0.0;
            assert!((slope - growth).abs() < 1e-5 || kink, "{before} {after}: {slope} {growth}");
        }
    }
}
