//! The scene as a user writes it: JSON, SI units, a unit in every key, unknown keys refused.
//!
//! These types are the only description of the format. The JSON Schema that
//! `tumblenet schema` prints is generated from them, and the same schema checks every scene
//! (`scene::read`), so a limit stands once: at its field. What several fields allow together
//! is in `scene::checks`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::effects::Effects;
use crate::net::spec::{Launch, NetSpec};
use crate::parameter::spec::Varied;
use crate::quantity::Positive;
use crate::solver::Solver;
use crate::target::spec::TargetSpec;

/// One run: a net, how it is shot, what it meets, and how the meeting is simulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "tumblenet scene")]
pub struct Scene {
    /// Where its JSON Schema is, for an editor that completes; nothing else comes of it.
    #[serde(default, rename = "$schema", skip_serializing)]
    pub schema: Option<String>,
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
    /// What is not known for sure: drawn anew for every member of an ensemble or a sweep. A single run has what
    /// stands in the scene.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 64))]
    pub uncertain: Vec<Varied>,
    /// What the run is expected to show; a run that does not ends with status 1.
    #[serde(default)]
    pub expect: Expect,
}

impl Scene {
    /// The scene as JSON with every default, those too that say nothing and are left out elsewhere.
    pub fn written_out(&self) -> Value {
        // A scene is plain data: it always becomes JSON.
        let mut json = serde_json::to_value(self).unwrap_or_default();
        json["launch"]["bullets"] = json!(self.launch.bullets);
        json["launch"]["bullets"]["delay_s"] = json!(self.launch.bullets.delay_s);
        if let Some(target) = &self.target {
            json["target"]["velocity_m_s"] = json!(target.velocity_m_s);
        }
        json
    }
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
    /// Settled: largest mean distance of the bullets from their centre, as a share of the net's side [-].
    #[schemars(range(min = 0))]
    pub settled_gather: f64,
    /// Settled: largest planar hull of the perimeter, as a share of the designed area [-].
    #[schemars(range(min = 0))]
    pub settled_hull: f64,
    /// Settled: largest kinetic energy of the net relative to the target, as a share of the launch energy [-].
    #[schemars(range(min = 0))]
    pub settled_energy: f64,
    /// Settled: least turns of a target that tumbles while all of this is so [-].
    #[schemars(range(min = 0))]
    pub settled_turns: f64,
    /// Settled: least time for which all of this is so, in crossing times: side of the net over launch speed [-].
    #[schemars(range(min = 0))]
    pub settled_crossings: f64,
    /// Weights of volume, surface and distance in the capture quality index [-].
    #[schemars(inner(range(min = 0)))]
    pub cqi_weights: [f64; 3],
}

impl Default for CaptureRule {
    fn default() -> Self {
        // Enclosed 0.5: corners of a target poke out between knots; in a probe a wrapped
        // Cubesat read 0.70 to 0.97, a lost one 0.0, its mouth 0.01 to 0.07 and 0.1 to 0.4.
        // Settled: measured on long runs, see `docs/verdict.md`.
        CaptureRule {
            enclosed_min: 0.5,
            mouth_max: 0.2,
            hold_s: 0.3,
            settled_gather: 0.2,
            settled_hull: 0.1,
            settled_energy: 0.2,
            settled_turns: 0.5,
            settled_crossings: 5.0,
            cqi_weights: [0.1, 0.1, 0.8],
        }
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
    /// Whether the target is held at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub captured: Option<bool>,
    /// The verdict in time, to the word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// Bands for numbers of the summary: `"contact.first_contact_s": [0.74, 0.80]`.
    #[serde(default, skip_serializing_if = "std::collections::BTreeMap::is_empty")]
    pub within: std::collections::BTreeMap<String, [f64; 2]>,
}

/// What became of the capture, as far as the run went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Net and target never touched.
    NeverMet,
    /// They met, but the target was never held.
    Missed,
    /// Held, and lost.
    Lost,
    /// Held to the end; not decided.
    HeldSoFar,
    /// Held, and settled.
    HeldSettled,
}

impl Verdict {
    /// Whether the target is held.
    pub fn is_held(self) -> bool {
        matches!(self, Verdict::HeldSoFar | Verdict::HeldSettled)
    }

    /// As in `summary.json`.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::NeverMet => "never_met",
            Verdict::Missed => "missed",
            Verdict::Lost => "lost",
            Verdict::HeldSoFar => "held_so_far",
            Verdict::HeldSettled => "held_settled",
        }
    }

    /// For a person.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::NeverMet => "never met",
            Verdict::Missed => "missed",
            Verdict::Lost => "lost",
            Verdict::HeldSoFar => "held so far",
            Verdict::HeldSettled => "held, settled",
        }
    }
}
