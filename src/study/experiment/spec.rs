//! A fit as a user writes it: a scene, what was measured, and what may be changed to meet it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::align::Align;
use super::tracks::Matching;
use crate::parameter::spec::Varied;
use crate::quantity::Positive;
use crate::study::compare::variants::PAIRS;

/// A fit: which parameters make a scene meet measured tracks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "tumblenet fit")]
pub struct FitSpec {
    /// Where its JSON Schema is, for an editor that completes; nothing else comes of it.
    #[serde(default, rename = "$schema", skip_serializing)]
    pub schema: Option<String>,
    /// What the fit asks, in a line.
    pub title: String,
    /// Name of a built-in scene, or path of a scene file relative to the study.
    pub scene: String,
    /// Changes to the scene before anything is fitted, by path: `{"target.mass_kg": 5}`; null removes a key.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub set: Map<String, Value>,
    /// Cables and contact; absent: the scene's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = PAIRS))]
    pub solver: Option<String>,
    /// What was measured: path of a CSV file relative to the study, under the heading `time_s,marker,x_m,y_m,z_m`.
    pub track: String,
    /// How markers find their knots.
    #[serde(default)]
    pub matching: Matching,
    /// What of the experiment's clock and frame is fitted too.
    #[serde(default)]
    pub align: Align,
    /// What is fitted: each a path to a number of the scene with its least and largest value, `uniform` or
    /// `log_uniform` (for one that is known to its order of magnitude only).
    #[schemars(length(min = 1, max = 6))]
    pub parameters: Vec<Varied>,
    /// Standard deviation of a coordinate of a marker [m]; absent: estimated from what is left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_m: Option<Positive>,
    /// Flights at points that fill the ranges, before the descent begins at the best of them and the scene as it is.
    #[serde(default = "FitSpec::fifteen")]
    #[schemars(range(max = 10_000))]
    pub scan: u32,
    /// Flights at most.
    #[serde(default = "FitSpec::two_hundred")]
    #[schemars(range(min = 1, max = 100_000))]
    pub most_flights: u64,
}

impl FitSpec {
    fn fifteen() -> u32 {
        15
    }

    fn two_hundred() -> u64 {
        200
    }
}
