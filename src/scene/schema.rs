//! The scene as a user writes it: JSON, SI units, a unit in every key, unknown keys refused.
//!
//! These types are the only description of the format. The JSON Schema that
//! `tumblenet schema` prints is generated from them, and the same schema checks every scene
//! (`scene::read`), so a limit stands once: at its field. What several fields allow together
//! is in `scene::checks`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::effects::Effects;
use crate::net::spec::{Launch, NetSpec};
use crate::quantity::Positive;
use crate::solver::Solver;
use crate::target::spec::TargetSpec;

/// One run: a net, how it is shot, what it meets, and how the meeting is simulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "tumblenet scene")]
pub struct Scene {
    /// What the scene shows, in a line.
    pub title: String,
    /// Where its numbers come from: chapter, table, figure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Simulated time [s].
    pub duration_s: Positive,
    /// The net and how it is folded.
    pub net: NetSpec,
    /// How the bullets are shot.
    pub launch: Launch,
    /// What is to be captured; absent: deployment only, and no collider exists.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<TargetSpec>,
    /// What is simulated beside cables and contact; an effect that is not named is absent.
    #[serde(default)]
    pub effects: Effects,
    /// Numerical method; every member may be left out.
    #[serde(default)]
    pub solver: Solver,
    /// When a target counts as captured.
    #[serde(default)]
    pub capture: CaptureRule,
    /// What is recorded.
    #[serde(default)]
    pub output: Output,
    /// What the run is expected to show; a run that does not ends with status 1.
    #[serde(default)]
    pub expect: Expect,
}

/// When a target counts as captured (see `metrics::capture`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CaptureRule {
    /// Least share of the target's volume inside the convex hull of the knots [-].
    #[schemars(range(min = 0, max = 1))]
    pub enclosed_min: f64,
    /// Largest mouth as a share of the designed area [-].
    #[schemars(range(min = 0))]
    pub mouth_max: f64,
    /// For how long both must hold, up to the end of the run [s].
    #[schemars(range(min = 0))]
    pub hold_s: f64,
    /// Weights of volume, surface and distance in the capture quality index [-].
    #[schemars(inner(range(min = 0)))]
    pub cqi_weights: [f64; 3],
}

impl Default for CaptureRule {
    fn default() -> Self {
        // Enclosed 0.5: corners of a target poke out between knots; in a probe a wrapped
        // Cubesat read 0.70 to 0.97, a lost one 0.0, its mouth 0.01 to 0.07 and 0.1 to 0.4.
        CaptureRule { enclosed_min: 0.5, mouth_max: 0.2, hold_s: 0.3, cqi_weights: [0.1, 0.1, 0.8] }
    }
}

/// What is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Time between two recorded frames [s]; rounded to whole steps.
    pub sample_s: Positive,
}

impl Default for Output {
    fn default() -> Self {
        Output { sample_s: Positive(0.01) }
    }
}

/// What a run is expected to show.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// The verdict.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub captured: Option<bool>,
    /// Bands for numbers of the summary: `"contact.first_contact_s": [0.74, 0.80]`.
    #[serde(default, skip_serializing_if = "std::collections::BTreeMap::is_empty")]
    pub within: std::collections::BTreeMap<String, [f64; 2]>,
}
