//! A value that varies, as a user writes it: in a study, or among what is uncertain in a scene.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::quantity::Positive;

/// A parameter that varies: exactly one of `values`, `range`, `uniform`, `log_uniform`, `normal`, `direction`, `attitude`.
/// Where the scene has a list of numbers, `uniform`, `log_uniform` and `normal` draw each of them by itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Varied {
    /// Its path in the scene, as for `--set`: `target.spin_rad_s.0`.
    pub path: String,
    /// Whether a `one-at-a-time` study is repeated for each of its values.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub crossed: bool,
    /// These values, of any kind; null removes the key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub values: Option<Vec<Value>>,
    /// With `values`: what the table says in place of each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<Vec<String>>,
    /// Values at equal distances.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<Steps>,
    /// Any number between two, all as likely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uniform: Option<[f64; 2]>,
    /// Any number between two above zero, whose logarithm is as likely everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log_uniform: Option<[Positive; 2]>,
    /// A normal distribution, cut.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<CutNormal>,
    /// A vector of three numbers whose direction is anywhere on the sphere or near the scene's own, all as likely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Directions>,
    /// Turns about three axes [deg]: any attitude or one near the scene's own, all as likely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attitude: Option<Attitudes>,
}

impl Varied {
    /// How many kinds of values it has: one, where it is written as it should be.
    pub fn n_kinds(&self) -> usize {
        let kinds = [
            self.values.is_some(),
            self.range.is_some(),
            self.uniform.is_some(),
            self.log_uniform.is_some(),
            self.normal.is_some(),
            self.direction.is_some(),
            self.attitude.is_some(),
        ];
        kinds.into_iter().filter(|is_there| *is_there).count()
    }
}

/// Values at equal distances, with both ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// How many values.
    #[schemars(range(min = 2, max = 100_000))]
    pub steps: u32,
}

/// A normal distribution without its tails: exactly one of `sigma` and `relative`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CutNormal {
    /// Mean; absent: what the scene says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean: Option<f64>,
    /// Standard deviation before it is cut, in the unit of the path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma: Option<Positive>,
    /// The same as a share of the mean [-]: 0.05 for 5 %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative: Option<Positive>,
    /// Standard deviations from the mean beyond which nothing lies.
    #[serde(default = "CutNormal::three")]
    #[schemars(range(max = 8))]
    pub cut: Positive,
}

impl CutNormal {
    fn three() -> Positive {
        Positive(3.0)
    }

    /// The standard deviation about `mean`, before the distribution is cut.
    pub fn sigma_about(&self, mean: f64) -> f64 {
        match (self.sigma, self.relative) {
            (Some(sigma), _) => sigma.0,
            (None, relative) => relative.map_or(0.0, |relative| relative.0 * mean.abs()),
        }
    }
}

/// Vectors in any direction, or in one near the scene's own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Directions {
    /// Least and largest length, in the unit of the path, all between as likely; absent: that of the scene's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<[f64; 2]>,
    /// Largest angle from the scene's own direction [deg]; absent: anywhere on the sphere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = 180), extend("exclusiveMinimum" = 0))]
    pub within_deg: Option<f64>,
}

/// Attitudes of any kind, or near the scene's own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Attitudes {
    /// Largest turn from the scene's own attitude, about an axis anywhere [deg]; absent: any attitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = 180), extend("exclusiveMinimum" = 0))]
    pub within_deg: Option<f64>,
}
