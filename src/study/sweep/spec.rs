//! The study as a user writes it: a scene, what varies in it and how, and how many members are run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::quantity::Positive;
use crate::study::compare::variants::PAIRS;

/// A sweep: one scene run at many points of its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "tumblenet study")]
pub struct SweepSpec {
    /// Where its JSON Schema is, for an editor that completes; nothing else comes of it.
    #[serde(default, rename = "$schema", skip_serializing)]
    pub schema: Option<String>,
    /// What the study asks, in a line.
    pub title: String,
    /// Name of a built-in scene, or path of a scene file relative to the study.
    pub scene: String,
    /// Changes to the scene before anything varies, by path: `{"target.mass_kg": 5}`; null removes a key.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub set: Map<String, Value>,
    /// Cables and contact; absent: the scene's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = PAIRS))]
    pub solver: Option<String>,
    /// What varies.
    #[schemars(length(min = 1, max = 64))]
    pub parameters: Vec<Varied>,
    /// At which points.
    pub design: Design,
    /// Members at each point: they differ in the last digits of the folded net.
    #[serde(default = "SweepSpec::one")]
    #[schemars(range(min = 1))]
    pub members: u64,
    /// Largest displacement of a knot of the folded net along each axis [m].
    #[serde(default = "SweepSpec::micrometre")]
    #[schemars(range(min = 0))]
    pub perturb_m: f64,
    /// Seed of everything that is drawn.
    #[serde(default = "SweepSpec::one")]
    pub seed: u64,
    /// For how long at most a member goes on until its verdict is decided [s]; absent: to the scene's end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most_s: Option<Positive>,
    /// Numbers of the summary that the table has, by name or by block (`capture`, `contact.first_contact_s`); absent: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub collect: Option<Vec<String>>,
}

impl SweepSpec {
    fn one() -> u64 {
        1
    }

    fn micrometre() -> f64 {
        1e-6
    }
}

/// A parameter that varies: exactly one of `values`, `range`, `uniform`, `log_uniform`, `normal`, `direction`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Varied {
    /// Its path in the scene, as for `--set`: `target.spin_rad_s.0`.
    pub path: String,
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
    /// A vector of three numbers whose direction is anywhere on the sphere, all as likely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Directions>,
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

/// A normal distribution without its tails.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CutNormal {
    /// Mean.
    pub mean: f64,
    /// Standard deviation before it is cut.
    pub sigma: Positive,
    /// Standard deviations from the mean beyond which nothing lies.
    #[serde(default = "CutNormal::three")]
    #[schemars(range(max = 8))]
    pub cut: Positive,
}

impl CutNormal {
    fn three() -> Positive {
        Positive(3.0)
    }
}

/// Vectors in any direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Directions {
    /// Least and largest length, in the unit of the path; all between are as likely.
    pub length: [f64; 2],
}

/// At which points a study is run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Design {
    /// The scene as it is, then every value of one parameter after the other, the rest as the scene has it.
    /// Distributions are drawn anew for every member.
    OneAtATime {},
    /// Every value of each with every value of the others. Distributions are drawn anew for every member.
    Grid {},
    /// So many points of a scrambled Sobol sequence: they fill the space evenly, and more may be added later.
    Sobol {
        /// How many; a power of two fills it best.
        #[schemars(range(min = 1, max = 65_536))]
        points: u64,
    },
    /// So many points at random; more may be added later.
    Random {
        /// How many.
        #[schemars(range(min = 1))]
        points: u64,
    },
}
