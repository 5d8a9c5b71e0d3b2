//! What a run is worth: its distance from the reference while there is one, and what it must keep
//! to its end.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::reference::{Reference, at_times, bullets_apart};
use crate::case::Case;
use crate::metrics::capture::Curves;
use crate::metrics::conservation::Conservation;
use crate::metrics::deployment::Deployment;
use crate::metrics::verdict::Capture;
use crate::run::Run;
use crate::work::Work;

/// Energy created from which a setting is warned of [-].
const CREATED: f64 = 1e-3;
/// The same of the share of energy that is nowhere in the ledger.
const RESIDUAL: f64 = 2e-2;
/// The same of the angular momentum.
const ANGULAR: f64 = 1e-3;
/// The same of the momentum.
const MOMENTUM: f64 = 1e-9;

/// Points along a cable at which it is looked for within the target.
const POINTS: usize = 8;

/// How far knots are from the reference, over the frames of a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Distance {
    /// Root mean square over knots and frames [m].
    pub rms_m: f64,
    /// Largest [m].
    pub max_m: f64,
}

/// How far a run is from the reference within a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Apart {
    /// The bullets.
    pub bullets: Distance,
    /// All knots of the grid.
    pub knots: Distance,
}

/// What one run is worth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Evaluation {
    /// How far it is from the reference, window by window; null where its frames do not meet.
    pub apart: Vec<Option<Apart>>,
    /// Largest distance of a bullet, frame by frame of the reference [m].
    pub curve_m: Vec<f64>,
    /// How the net opened.
    pub deployment: Deployment,
    /// Largest tension of a cable [N].
    pub max_tension_n: f64,
    /// What was kept.
    pub conservation: Conservation,
    /// How it ended; absent without a target, and of a run that ends before contact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ending: Option<Ending>,
    /// Work done: exact.
    pub counts: Counts,
}

/// How a run with a target ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ending {
    /// The verdict and its numbers.
    pub capture: Capture,
    /// First contact [s]; null without any.
    pub first_contact_s: Option<f64>,
    /// Deepest overlap of a knot and a part [m].
    pub max_penetration_m: f64,
    /// Cables that pass through the target at the end.
    pub through: usize,
    /// When the run ended [s].
    pub end_s: f64,
}

/// Work done, in counts that are the same on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Counts {
    /// Steps.
    pub steps: u64,
    /// Sub-steps.
    pub substeps: u64,
    /// SolverIterations over all rows, summed over the sub-steps.
    pub sweeps: u64,
    /// Cable rows, summed over the steps.
    pub rows: u64,
    /// Cables that snapped taut within a step.
    pub snaps: u64,
    /// Times contacts were looked for.
    pub detections: u64,
    /// Contacts, summed over the steps.
    pub contacts: u64,
}

impl Counts {
    /// Those of `work`.
    pub fn of(work: &Work) -> Counts {
        Counts {
            steps: work.steps,
            substeps: work.substeps,
            sweeps: work.sweeps,
            rows: work.cable_rows,
            snaps: work.snaps,
            detections: work.detections,
            contacts: work.contacts,
        }
    }

    /// The same as work.
    pub fn work(&self) -> Work {
        Work {
            steps: self.steps,
            substeps: self.substeps,
            sweeps: self.sweeps,
            cable_rows: self.rows,
            snaps: self.snaps,
            detections: self.detections,
            contacts: self.contacts,
            ..Work::default()
        }
    }
}

impl Evaluation {
    /// What `run` of `case` is worth, against `reference` where there is one.
    pub fn of(case: &Case, run: &Run, reference: Option<&Reference>) -> Evaluation {
        let (apart, curve_m) = reference.map_or((Vec::new(), Vec::new()), |reference| {
            // Middle knots come after those of the grid, so the first ones are alike in all nets.
            let grid: Vec<usize> = (0..case.net().grid[0] * case.net().grid[1]).collect();
            let found = at_times(run, &reference.times);
            let apart = reference.window_frames().into_iter().map(|frames| {
                let of = |knots: &[usize]| distance(&found, reference, knots, frames);
                Some(Apart { bullets: of(&reference.bullets)?, knots: of(&grid)? })
            });
            (apart.collect(), bullets_apart(run, &reference.times, &reference.knots, &reference.bullets))
        });
        Evaluation {
            apart,
            curve_m,
            deployment: Deployment::of(case, run),
            max_tension_n: run.extremes.tension,
            conservation: Conservation::of(case, run),
            ending: Ending::of(case, run),
            counts: Counts::of(&run.work),
        }
    }

    /// What is wrong with the run, in words; nothing when it may be trusted.
    pub fn warnings(&self, knot_radius: f64) -> Vec<String> {
        let kept = &self.conservation;
        let mut warnings = Vec::new();
        let mut over = |what: &str, value: f64, limit: f64, unit: &str| {
            if value > limit || value.is_nan() {
                warnings.push(format!("{what} {value:.1e} {unit}"));
            }
        };
        over("creates energy:", kept.energy_created, CREATED, "of the launch energy and the work put in");
        over("energy nowhere in the ledger:", kept.energy_residual, RESIDUAL, "of the launch energy");
        over("loses momentum:", kept.momentum_residual, MOMENTUM, "of the launch momentum");
        over("loses angular momentum:", kept.angular_momentum_residual, ANGULAR, "of scale");
        if let Some(ending) = &self.ending {
            over("a knot sinks in by", ending.max_penetration_m, knot_radius, "m, more than its radius");
        }
        warnings
    }
}

/// How far `knots` are from the reference within its first `frames`; nothing when the run misses one.
fn distance(
    found: &[Vec<nalgebra::Vector3<f64>>],
    reference: &Reference,
    knots: &[usize],
    frames: usize,
) -> Option<Distance> {
    if found.len() < frames {
        return None;
    }
    let (mut sum, mut count, mut max) = (0.0, 0.0, 0.0_f64);
    for (found, there) in found.iter().zip(&reference.knots).take(frames) {
        for &knot in knots {
            let far = (found[knot] - there[knot]).norm_squared();
            (sum, count, max) = (sum + far, count + 1.0, max.max(far));
        }
    }
    Some(Distance { rms_m: f64::sqrt(sum / count), max_m: max.sqrt() })
}

impl Ending {
    /// How `run` ended; nothing without a target.
    pub fn of(case: &Case, run: &Run) -> Option<Ending> {
        let curves = Curves::of(case, run);
        Some(Ending {
            capture: Capture::of(case, run.extremes.first_contact.is_some(), &run.frames.time, &curves)?,
            first_contact_s: run.extremes.first_contact,
            max_penetration_m: run.extremes.penetration,
            through: through(case, run),
            end_s: run.frames.time.last().copied().unwrap_or(0.0),
        })
    }
}

/// Cables of the last frame with a point within the target, deeper than rounding.
fn through(case: &Case, run: &Run) -> usize {
    let (Some(target), Some(body), Some(knots)) =
        (case.target(), run.frames.target.last(), run.frames.knots.last())
    else {
        return 0;
    };
    let in_body = |point: &nalgebra::Vector3<f64>| body.attitude.inverse() * (point - body.position);
    let inside = |point: &nalgebra::Vector3<f64>| target.parts.iter().any(|part| part.contains(point));
    let crosses = |cable: &&crate::cable::Cable| {
        let (a, b) = (in_body(&knots[cable.a]), in_body(&knots[cable.b]));
        // Not the ends: a knot at rest on a surface is no cable through it.
        (1..POINTS).any(|i| inside(&a.lerp(&b, i as f64 / POINTS as f64)))
    };
    case.net().cables.iter().filter(crosses).count()
}
