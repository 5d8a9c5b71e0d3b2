//! The study as a user writes it: a scene, what varies in it and how, and how many members are run.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::parameter::spec::Varied;
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
    /// What varies, beside what is uncertain in the scene.
    #[serde(default)]
    #[schemars(length(max = 64))]
    pub parameters: Vec<Varied>,
    /// At which points.
    pub design: Design,
    /// Members at each point: they differ in the last digits of the folded net, and in what is uncertain.
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
    /// Numbers of others that `dependency` sets beside those of this study.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub published: Vec<Published>,
    /// How captures of others ended at single points of the inputs: drawn into a map.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub published_outcomes: Vec<PublishedOutcome>,
}

/// How a capture of others ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedOutcome {
    /// Where it stands: `Section 5.3.1`.
    pub source: String,
    /// Its inputs, by columns of the table: `{"input.target.mass_kg": 4}`.
    pub at: BTreeMap<String, f64>,
    /// Whether it was captured, in the words of that source.
    pub captured: bool,
}

/// What others found of one parameter of a `one-at-a-time` study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Where it stands: `Table 3.3`.
    pub source: String,
    /// Path of the parameter.
    pub path: String,
    /// Its starting value; absent: the first one of the study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// The value it was changed to; absent: the last one of the study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// For which values of `crossed` parameters it holds, as the table shows them, by path; absent: for all.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub at: BTreeMap<String, String>,
    /// Dependency (Eq. 3.17) [%] by the name of a number of the summary.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub dependency_percent: BTreeMap<String, f64>,
    /// Largest difference (Eq. 3.19) [%] from the first value of the only `crossed` parameter, by the same names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub difference_percent: BTreeMap<String, f64>,
}

impl SweepSpec {
    fn one() -> u64 {
        1
    }

    fn micrometre() -> f64 {
        1e-6
    }
}

/// At which points a study is run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Design {
    /// The scene as it is, then every value of one parameter after the other, the rest as the scene has it; all of
    /// it for every value of the parameters that are `crossed`.
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
    /// Two independent Sobol points A and B for every one of so many blocks, and A with one input after the other taken
    /// from B: what `tumblenet sensitivity` is computed from. What is uncertain in the scene is among the inputs.
    Saltelli {
        /// How many blocks, each of two points more than there are inputs; more may be added later.
        #[schemars(range(min = 1, max = 65_536))]
        base: u64,
    },
}
