//! How well a least-squares fit knows what it found.
//!
//! C = f σ² (Jᵀ J)⁻¹,  f = (1 + ρ) / (1 − ρ)
//!
//! J holds the derivatives of what is left at the least, clock and frame fitted anew at each point, so that what they do not
//! know is in it. σ is the noise of a coordinate: known, or what is left over its degrees of freedom. ρ is the correlation of
//! what is left of a marker along an axis from one sighting to the next. Assumed: it dies away as ρⁿ, markers and axes
//! are independent, the model is linear within the interval, and right. f then is by how much fewer independent sightings
//! there are; a model that is not right shows by ρ, and f does not make up for that.
//!
//! Intervals of 95 % are C's, with Student's t where σ was estimated.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::tracks::Paired;
use crate::study::Z;

/// Most correlation that is reckoned with: a hundred and ninety-nine times fewer sightings.
const MOST: f64 = 0.99;

/// What a fit knows of what it found.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// Covariance of the parameters, in shares of their ranges; none where they cannot be told apart.
    pub covariance: Option<DMatrix<f64>>,
    /// Half an interval of 95 % in standard errors.
    pub reach: f64,
    /// Standard deviation of a coordinate, from what is left [m].
    pub noise: f64,
    /// ρ.
    pub correlation: f64,
    /// f.
    pub fewer: f64,
}

impl Uncertainty {
    /// Of `left`, the coordinates that are left of `seen` [m], whose derivatives are `jacobian`'s columns; `n_fitted`
    /// numbers were fitted in all. The noise is `known`, or not.
    pub fn of(
        left: &[f64],
        seen: &[Paired],
        jacobian: &[Vec<f64>],
        n_fitted: usize,
        known: Option<f64>,
    ) -> Uncertainty {
        let freedom = (left.len() - n_fitted) as f64;
        let noise = (left.iter().map(|r| r * r).sum::<f64>() / freedom).sqrt();
        let correlation = correlation(left, seen);
        let fewer = (1.0 + correlation) / (1.0 - correlation);
        let columns: Vec<DVector<f64>> = jacobian.iter().map(|column| column.clone().into()).collect();
        let jacobian = DMatrix::from_columns(&columns);
        let inverse = (jacobian.transpose() * jacobian).cholesky().map(|cholesky| cholesky.inverse());
        let scale = fewer * known.unwrap_or(noise).powi(2);
        // Degrees of freedom above 0 always make a distribution.
        let students =
            StudentsT::new(0.0, 1.0, (freedom / fewer).max(1.0)).map_or(Z, |t| t.inverse_cdf(0.975));
        Uncertainty {
            covariance: inverse
                .map(|inverse| scale * inverse)
                .filter(|all| all.iter().all(|entry| entry.is_finite())),
            reach: if known.is_some() { Z } else { students },
            noise,
            correlation,
            fewer,
        }
    }

    /// Standard error of parameter `number`, as a share of its range.
    pub fn error(&self, number: usize) -> Option<f64> {
        self.covariance.as_ref().map(|all| all[(number, number)].sqrt())
    }

    /// Correlations of the parameters; none where nothing is left over, so that each is known exactly.
    pub fn correlations(&self) -> Option<Vec<Vec<f64>>> {
        let all = self.covariance.as_ref().filter(|all| all.diagonal().iter().all(|square| *square > 0.0))?;
        let of = |i: usize, j: usize| all[(i, j)] / (all[(i, i)] * all[(j, j)]).sqrt();
        Some((0..all.nrows()).map(|i| (0..all.ncols()).map(|j| of(i, j)).collect()).collect())
    }
}

/// ρ: correlation from one sighting of a marker to the next, over all markers and axes; at least 0.
fn correlation(left: &[f64], seen: &[Paired]) -> f64 {
    let squares: f64 = left.iter().map(|r| r * r).sum();
    let next = |i: usize| {
        let is_same = seen[i].marker == seen[i + 1].marker;
        let products = (0..3).map(|axis| left[3 * i + axis] * left[3 * i + 3 + axis]);
        if is_same { products.sum() } else { 0.0 }
    };
    let products: f64 = (0..seen.len().saturating_sub(1)).map(next).sum();
    if squares > 0.0 { (products / squares).clamp(0.0, MOST) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use statrs::distribution::Normal;

    use super::super::tracks::Sighting;
    use super::*;

    fn seen(n: usize) -> Vec<Paired> {
        let sighting = |time: usize| Sighting { time: time as f64, position: Vector3::zeros() };
        (0..n).map(|time| Paired { marker: 0, knot: 0, seen: sighting(time) }).collect()
    }

    /// Noise of standard deviation 1 along three axes, each next value ρ of the one before.
    fn noise(n: usize, rho: f64, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::standard();
        let mut unit = || (rand::Rng::next_u64(&mut random) >> 11) as f64 / (1_u64 << 53) as f64;
        let mut last = [0.0; 3];
        let mut all = Vec::new();
        for i in 0..n {
            for value in &mut last {
                let fresh = normal.inverse_cdf(unit());
                *value = if i == 0 { fresh } else { rho * *value + (1.0 - rho * rho).sqrt() * fresh };
                all.push(*value);
            }
        }
        all
    }

    /// The mean of n coordinates is known to σ / √n; of correlated ones, to that of fewer.
    #[test]
    fn the_error_of_a_mean_is_that_of_the_textbook() {
        let n = 4000;
        let ones = vec![vec![1.0; 3 * n]];
        for (rho, fewer) in [(0.0, 1.0), (0.6, 4.0)] {
            let found = Uncertainty::of(&noise(n, rho, 7), &seen(n), &ones, 1, None);
            assert!((found.noise - 1.0).abs() < 0.05, "{found:?}");
            assert!((found.fewer / fewer - 1.0).abs() < 0.2, "{found:?}");
            let expected = (fewer / (3 * n) as f64).sqrt();
            assert!((found.error(0).unwrap() / expected - 1.0).abs() < 0.15, "{found:?}");
        }
        let known = Uncertainty::of(&noise(n, 0.0, 7), &seen(n), &ones, 1, Some(2.0));
        assert!((known.error(0).unwrap() / (2.0 / (3.0 * n as f64).sqrt()) - 1.0).abs() < 0.05, "{known:?}");
    }

    /// By simulation: an interval holds what is true in 19 of 20, of correlated noise too.
    #[test]
    fn intervals_hold_what_is_true_as_often_as_they_say() {
        let (n, tries) = (100, 1000);
        for rho in [0.0, 0.5] {
            let holds = |seed: u64| {
                let noise = noise(n, rho, seed);
                let mean = noise.iter().sum::<f64>() / noise.len() as f64;
                let left: Vec<f64> = noise.iter().map(|value| value - mean).collect();
                let found = Uncertainty::of(&left, &seen(n), &[vec![1.0; 3 * n]], 1, None);
                mean.abs() < found.reach * found.error(0).unwrap()
            };
            let share = (0..tries).filter(|seed| holds(*seed)).count() as f64 / tries as f64;
            // Four standard errors of a share of so many tries.
            assert!((share - 0.95).abs() < 0.028, "{rho}: {share}");
        }
    }

    #[test]
    fn parameters_that_do_the_same_are_not_told_apart() {
        let column: Vec<f64> = (0..30).map(f64::from).collect();
        let found = Uncertainty::of(&noise(10, 0.0, 1), &seen(10), &[column.clone(), column], 2, None);
        assert_eq!((found.covariance.is_none(), found.error(0)), (true, None), "{found:?}");
    }
}
