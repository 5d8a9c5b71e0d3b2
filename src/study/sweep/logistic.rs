//! Logistic regression by iteratively reweighted least squares.
//!
//! The probability of a yes at the features x is p = 1 / (1 + exp(−x·β)). The coefficients β maximise
//!
//! Σ (y ln p + (1 − y) ln(1 − p)) − λ β·β / 2
//!
//! by Newton steps, (Xᵀ W X + λ I) Δβ = Xᵀ (y − p) − λ β with W = p (1 − p). The last term keeps β finite where a plane
//! parts all yes from all no; with λ = 0.01 it is a normal prior of standard deviation 10, and features of size 1 hardly
//! feel it. The inverse of the same matrix is the covariance of β.

use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::study::Z;

/// λ.
pub const RIDGE: f64 = 0.01;

/// Newton steps, at most; six or seven are usual.
const MOST_STEPS: usize = 100;

/// Halvings of a step that would make things worse, at most.
const MOST_HALVINGS: usize = 30;

/// A fitted regression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LogisticFit {
    /// β, one for each feature.
    pub coefficients: Vec<f64>,
    /// Covariance of β.
    pub covariance: Vec<Vec<f64>>,
}

/// A probability with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Probability {
    /// The most likely [-].
    pub value: f64,
    /// 95 % confidence interval [-].
    pub interval_95: [f64; 2],
}

impl LogisticFit {
    /// The regression of the answers on `features`, a row of them for each; none where there are no rows or the
    /// numbers are none.
    pub fn of(features: &[Vec<f64>], yes: &[bool], ridge: f64) -> Option<LogisticFit> {
        let n_features = features.first()?.len();
        let x = DMatrix::from_fn(features.len(), n_features, |row, column| features[row][column]);
        let y = DVector::from_iterator(yes.len(), yes.iter().map(|yes| f64::from(u8::from(*yes))));
        let mut beta = DVector::zeros(n_features);
        let mut best = objective(&x, &y, &beta, ridge);
        for _ in 0..MOST_STEPS {
            let p = (&x * &beta).map(logistic);
            let gradient = x.transpose() * (&y - &p) - ridge * &beta;
            let step = information(&x, &p, ridge).cholesky()?.solve(&gradient);
            let mut share = 1.0;
            let better = (0..MOST_HALVINGS).find_map(|_| {
                let tried = &beta + share * &step;
                let value = objective(&x, &y, &tried, ridge);
                share *= 0.5;
                (value >= best).then_some((tried, value))
            });
            // No step upward is left within rounding.
            let Some((tried, value)) = better else { break };
            let gain = gradient.dot(&step);
            (beta, best) = (tried, value);
            if gain < 1e-12 {
                break;
            }
        }
        let p = (&x * &beta).map(logistic);
        let covariance = information(&x, &p, ridge).try_inverse()?;
        let rows = covariance.row_iter().map(|row| row.iter().copied().collect()).collect();
        let is_sound = beta.iter().chain(covariance.iter()).all(|number| number.is_finite());
        is_sound.then(|| LogisticFit { coefficients: beta.iter().copied().collect(), covariance: rows })
    }

    /// The probability at `features`.
    pub fn at(&self, features: &[f64]) -> Probability {
        let dot = |row: &[f64]| row.iter().zip(features).map(|(a, b)| a * b).sum::<f64>();
        let logit = dot(&self.coefficients);
        let variance: f64 =
            self.covariance.iter().zip(features).map(|(row, feature)| feature * dot(row)).sum();
        let either = Z * variance.max(0.0).sqrt();
        Probability {
            value: logistic(logit),
            interval_95: [logistic(logit - either), logistic(logit + either)],
        }
    }
}

fn logistic(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}

/// Xᵀ W X + λ I.
fn information(x: &DMatrix<f64>, p: &DVector<f64>, ridge: f64) -> DMatrix<f64> {
    let mut weighted = x.clone();
    for (mut row, p) in weighted.row_iter_mut().zip(p.iter()) {
        row *= p * (1.0 - p);
    }
    x.transpose() * weighted + ridge * DMatrix::identity(x.ncols(), x.ncols())
}

fn objective(x: &DMatrix<f64>, y: &DVector<f64>, beta: &DVector<f64>, ridge: f64) -> f64 {
    let logits = x * beta;
    // ln(1 + exp(η)), of a large η without overflow.
    let softplus = |logit: f64| logit.max(0.0) + (-logit.abs()).exp().ln_1p();
    let likelihood: f64 = logits.iter().zip(y.iter()).map(|(&logit, y)| y * logit - softplus(logit)).sum();
    likelihood - 0.5 * ridge * beta.norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Of two groups the coefficients are the logarithms of their odds, and the variances sums of 1 / count.
    #[test]
    fn two_groups_have_their_odds() {
        let group = |x: f64, yes: usize, of: usize| (0..of).map(move |i| (vec![1.0, x], i < yes));
        let (features, yes): (Vec<_>, Vec<_>) = group(0.0, 5, 20).chain(group(1.0, 15, 20)).unzip();
        let fit = LogisticFit::of(&features, &yes, 0.0).unwrap();
        assert!((fit.coefficients[0] + 3_f64.ln()).abs() < 1e-9, "{fit:?}");
        assert!((fit.coefficients[1] - 2.0 * 3_f64.ln()).abs() < 1e-9, "{fit:?}");
        assert!((fit.covariance[0][0] - (1.0 / 5.0 + 1.0 / 15.0)).abs() < 1e-9, "{fit:?}");
        let at = fit.at(&[1.0, 1.0]);
        assert!((at.value - 0.75).abs() < 1e-9, "{at:?}");
        // logit ± 1.96 √(1/15 + 1/5)
        let either = 1.959_963_984_540_054 * (1.0 / 15.0 + 1.0 / 5.0_f64).sqrt();
        assert!((at.interval_95[0] - 1.0 / (1.0 + (either - 3_f64.ln()).exp())).abs() < 1e-9, "{at:?}");
    }

    #[test]
    fn what_a_plane_parts_stays_finite() {
        let features: Vec<Vec<f64>> = (0..20).map(|i| vec![1.0, f64::from(i) / 10.0 - 1.0]).collect();
        let yes: Vec<bool> = (0..20).map(|i| i >= 10).collect();
        let fit = LogisticFit::of(&features, &yes, RIDGE).unwrap();
        assert!(fit.at(&[1.0, 1.0]).value > 0.99 && fit.at(&[1.0, -1.0]).value < 0.01, "{fit:?}");
        let all = LogisticFit::of(&features, &[true; 20], RIDGE).unwrap();
        assert!(all.at(&[1.0, 0.0]).value > 0.95 && all.at(&[1.0, 0.0]).interval_95[0] < 0.9, "{all:?}");
        assert!(LogisticFit::of(&[], &[], RIDGE).is_none());
    }

    /// Of 200 draws from a known law, 95 % intervals hold the law's probability about as often as they say.
    #[test]
    fn intervals_hold_as_often_as_they_say() {
        let law = |x: f64| 1.0 / (1.0 + (-(0.5 - 1.5 * x + x * x)).exp());
        let features = |x: f64| vec![1.0, x, x * x];
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut held = 0;
        for _ in 0..200 {
            let x: Vec<f64> = (0..200).map(|_| random.random_range(-1.0..1.0)).collect();
            let yes: Vec<bool> = x.iter().map(|&x| random.random_bool(law(x))).collect();
            let rows: Vec<Vec<f64>> = x.iter().map(|&x| features(x)).collect();
            let [low, high] = LogisticFit::of(&rows, &yes, RIDGE).unwrap().at(&features(0.3)).interval_95;
            held += usize::from((low..=high).contains(&law(0.3)));
        }
        // 190 expected with a deviation of 3.
        println!("held {held} of 200");
        assert!((178..=200).contains(&held), "{held} of 200");
    }
}
