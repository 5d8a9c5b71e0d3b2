//! The distribution of a number.

use statrs::distribution::{ContinuousCDF, Normal};

use super::spec::{CutNormal, Varied};
use super::{Factor, Own};
use crate::problems::{Problems, join};

/// A distribution whose numbers are all known.
#[derive(Clone, Copy, Debug)]
pub enum NumberLaw {
    /// All as likely between two.
    Uniform([f64; 2]),
    /// The same for the logarithm.
    LogUniform([f64; 2]),
    /// Normal, with nothing beyond so many standard deviations.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation before it is cut.
        sigma: f64,
        /// Standard deviations.
        cut: f64,
    },
}

impl NumberLaw {
    /// The number below which the share `unit` of all lies.
    pub fn at(self, unit: f64) -> f64 {
        let between = |[low, high]: [f64; 2]| low + unit * (high - low);
        match self {
            NumberLaw::Uniform(ends) => between(ends),
            NumberLaw::LogUniform(ends) => between(ends.map(f64::ln)).exp().clamp(ends[0], ends[1]),
            NumberLaw::Normal { mean, sigma, cut } => {
                let normal = Normal::standard();
                let ends = [normal.cdf(-cut), normal.cdf(cut)];
                mean + sigma * normal.inverse_cdf(between(ends)).clamp(-cut, cut)
            }
        }
    }

    /// Its least and its largest number.
    pub fn ends(self) -> [f64; 2] {
        match self {
            NumberLaw::Uniform(ends) | NumberLaw::LogUniform(ends) => ends,
            NumberLaw::Normal { mean, sigma, cut } => [mean - cut * sigma, mean + cut * sigma],
        }
    }
}

/// `ends`, which stand at `place`, the least first.
pub fn ordered(ends: [f64; 2], place: &str, problems: &mut Problems) -> [f64; 2] {
    let [low, high] = ends;
    if low > high {
        problems.add(place, format!("[{low}, {high}]"), "the least first, then the largest");
    }
    ends
}

/// The distributions of numbers that `varied`, which stands at `place`, has.
pub fn numbers(varied: &Varied, own: &Own, place: &str, problems: &mut Problems) -> Vec<Factor> {
    let is_list = own.is_list();
    let n = if is_list { own.numbers().map_or(1, |numbers| numbers.len()) } else { 1 };
    let mut factors = Vec::new();
    if let Some(ends) = varied.uniform {
        let law = NumberLaw::Uniform(ordered(ends, &join(place, "uniform"), problems));
        factors.push(Factor::Numbers { laws: vec![law; n], key: "uniform", is_list });
    }
    if let Some(ends) = varied.log_uniform {
        let law =
            NumberLaw::LogUniform(ordered(ends.map(|end| end.0), &join(place, "log_uniform"), problems));
        factors.push(Factor::Numbers { laws: vec![law; n], key: "log_uniform", is_list });
    }
    if let Some(normal) = varied.normal {
        let laws = normals(normal, own, n, &join(place, "normal"), problems);
        factors.extend(laws.map(|laws| Factor::Numbers { laws, key: "normal", is_list }));
    }
    factors
}

fn normals(
    normal: CutNormal,
    own: &Own,
    n: usize,
    place: &str,
    problems: &mut Problems,
) -> Option<Vec<NumberLaw>> {
    if normal.sigma.is_some() == normal.relative.is_some() {
        let found = if normal.sigma.is_some() { "sigma and relative" } else { "neither sigma nor relative" };
        problems.add(place, found, "one of them");
    }
    let means = match normal.mean {
        Some(mean) => vec![mean; n],
        None => {
            let means = own.numbers();
            if means.is_none() && !matches!(own, Own::Unknown) {
                problems.add(join(place, "mean"), "nothing, and no number in the scene", "a mean");
            }
            means?
        }
    };
    if normal.relative.is_some() && means.contains(&0.0) {
        problems.add(join(place, "relative"), "a share of a mean of 0", "sigma, in the unit of the path");
    }
    let law = |mean: f64| NumberLaw::Normal { mean, sigma: normal.sigma_about(mean), cut: normal.cut.0 };
    Some(means.into_iter().map(law).collect())
}
