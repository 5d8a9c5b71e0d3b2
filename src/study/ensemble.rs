//! Copies of a case that differ in the last digits, or in what is uncertain: what is chance, and what is not.
//!
//! After contact a run is chaotic; one verdict is a coin. An ensemble moves every knot of the fold
//! by up to `perturb` metres along each axis, seeded per member, and counts. What the scene calls uncertain is drawn
//! anew for each member.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};
use statrs::statistics::{Data, OrderStatistics};

use super::settle;
use super::survival::Survival;
use crate::cable::Cable;
use crate::case::Case;
use crate::metrics::retention::{Retention, Trial};
use crate::metrics::summary::Summary;
use crate::metrics::verdict::Verdict;
use crate::problems::Problems;

/// What an ensemble is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EnsembleRequest {
    /// Number of members.
    pub members: usize,
    /// Largest displacement of a knot along each axis [m].
    pub perturb_m: f64,
    /// Seed of the perturbations.
    pub seed: u64,
    /// For how long at most a member goes on until its verdict is decided [s]; absent: to the scene's end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most_s: Option<f64>,
}

/// One member's outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Member {
    /// Its number, from 0.
    pub member: usize,
    /// Its summary, or why it failed.
    pub outcome: Result<Summary, String>,
}

/// Quartiles of a number over the members.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quartiles {
    /// Least.
    pub min: f64,
    /// Lower quartile.
    pub lower: f64,
    /// Median.
    pub median: f64,
    /// Upper quartile.
    pub upper: f64,
    /// Largest.
    pub max: f64,
    /// Members that have this number.
    pub count: usize,
}

/// Share captured or held, with its Clopper–Pearson interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Share {
    /// Members captured, or that held.
    pub captured: usize,
    /// Members with a verdict.
    pub of: usize,
    /// Share [-].
    pub share: f64,
    /// 95 % confidence interval [-].
    pub interval_95: [f64; 2],
}

/// `ensemble.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ensemble {
    /// The scene's title.
    pub title: String,
    /// Hash of scene and target.
    pub scene_hash: String,
    /// What was asked for.
    pub request: EnsembleRequest,
    /// Share captured; absent without a target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub captured: Option<Share>,
    /// How often each reason was given.
    pub reasons: BTreeMap<String, usize>,
    /// How often each verdict was given.
    #[serde(default)]
    pub verdict_counts: BTreeMap<String, usize>,
    /// Share still held over time; absent when no member was ever held.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub survival: Option<Survival>,
    /// How each member ended: `run SCENE --member N` runs it again.
    #[serde(default)]
    pub verdicts: Vec<Ended>,
    /// Share that held the target over one period of its tumbling, of those decided (`retention.turn`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_turn: Option<Share>,
    /// Share that held the target while an effect put the capture to the test, of those decided (`retention.tug`).
    #[serde(default, rename = "held_tug", skip_serializing_if = "Option::is_none")]
    pub held_trial: Option<Share>,
    /// What was drawn for each member; absent where nothing is uncertain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn: Option<Drawn>,
    /// Members that failed, and why.
    pub failures: BTreeMap<usize, String>,
    /// Quartiles of every number of the summaries.
    pub scalars: BTreeMap<String, Quartiles>,
}

/// What was drawn of what is uncertain in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Drawn {
    /// Paths in the scene.
    pub columns: Vec<String>,
    /// For each member what it has, a text for each column.
    pub members: Vec<Vec<String>>,
}

impl Drawn {
    /// What `request` draws for all its members.
    pub fn of(case: &Case, request: &EnsembleRequest) -> Option<Drawn> {
        let uncertain = case.uncertain()?;
        let shown = |member: usize| {
            uncertain.draw(request.seed, member as u64).into_iter().flat_map(|pick| pick.shown).collect()
        };
        let members = (0..request.members).map(shown).collect();
        Some(Drawn { columns: uncertain.columns(), members })
    }
}

/// Largest energy that a perturbation may put into the cables, over the launch energy [-]: more is another shot.
const MOST_ENERGY: f64 = 1e-2;

impl EnsembleRequest {
    /// Checks that the perturbation leaves `case` what it is.
    ///
    /// # Errors
    /// A fault of `--perturb`: knots moved by more than the shortest cable, or cables so stretched that they
    /// would throw the net.
    pub fn check(&self, case: &Case) -> Result<(), Problems> {
        let mut problems = Problems::new("--perturb");
        let shortest = case.net().cables.iter().map(|cable| cable.rest_length).fold(f64::INFINITY, f64::min);
        let moved = perturbed(case, self, 0);
        let stretched = |positions: &[Vector3<f64>]| -> f64 {
            let energy = |cable: &Cable| {
                let stretch = (positions[cable.b] - positions[cable.a]).norm() - cable.rest_length;
                0.5 * cable.stiffness * stretch.max(0.0).powi(2)
            };
            case.net().cables.iter().map(energy).sum()
        };
        let (put_in, launch) =
            (stretched(&moved.net().folded) - stretched(&case.net().folded), case.net().launch_energy());
        if self.perturb_m > shortest {
            problems.add(
                "",
                format!("{} m", self.perturb_m),
                format!("at most the shortest cable, {shortest} m"),
            );
        } else if launch > 0.0 && put_in > MOST_ENERGY * launch {
            let found = format!("{} m, which stretches cables by {put_in:.1e} J", self.perturb_m);
            problems.add("", found, format!("at most {MOST_ENERGY} of the launch energy, {launch:.1e} J"));
        }
        problems.into_result(Some(()))
    }
}

/// How one member ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ended {
    /// Its number, from 0.
    pub member: usize,
    /// Its verdict.
    pub verdict: Verdict,
    /// When it was first held [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub enclosed_at_s: Option<f64>,
    /// When it was lost last [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lost_at_s: Option<f64>,
    /// When it was settled [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settled_at_s: Option<f64>,
    /// Its end [s].
    pub simulated_s: f64,
}

impl Ended {
    /// How the member with the number `member` ended; nothing without a target.
    pub fn of(member: usize, summary: &Summary) -> Option<Ended> {
        let capture = summary.capture?;
        Some(Ended {
            member,
            verdict: capture.verdict,
            enclosed_at_s: capture.enclosed_at_s,
            lost_at_s: capture.lost_at_s,
            settled_at_s: capture.settled_at_s,
            simulated_s: summary.simulated_s,
        })
    }

    /// How often each verdict was given.
    pub fn counts(all: &[Ended]) -> BTreeMap<String, usize> {
        let mut counts = BTreeMap::new();
        for ended in all {
            *counts.entry(ended.verdict.name().to_owned()).or_insert(0) += 1;
        }
        counts
    }
}

/// A copy of `case` whose folded knots are moved by up to `request.perturb_m` along each axis, and
/// whose shots deviate anew where the scene disperses them.
pub fn perturbed(case: &Case, request: &EnsembleRequest, member: usize) -> Case {
    case.member(member as u64, shifts(request, member))
}

/// The same with bullets shot as in `case` itself, and not as they deviate in that member.
pub fn moved(case: &Case, request: &EnsembleRequest, member: usize) -> Case {
    case.member(0, shifts(request, member))
}

/// By what the folded knots of `member` are moved, one after another [m].
fn shifts(request: &EnsembleRequest, member: usize) -> impl FnMut() -> Vector3<f64> {
    // A stream a member: the same perturbation whatever the number of members or threads.
    let mut random = ChaCha8Rng::seed_from_u64(request.seed);
    random.set_stream(member as u64);
    let most = request.perturb_m;
    move || {
        let mut shift = || most * random.random_range(-1.0..=1.0);
        Vector3::new(shift(), shift(), shift())
    }
}

/// The copy of `case` that is `member`: with what is drawn for it where the scene is uncertain, and perturbed.
///
/// # Errors
/// What was drawn makes no scene: faults that the ends of nothing alone have.
pub fn member(case: &Case, request: &EnsembleRequest, member: usize) -> Result<Case, Problems> {
    let Some(uncertain) = case.uncertain() else { return Ok(perturbed(case, request, member)) };
    let drawn = uncertain.with(&uncertain.draw(request.seed, member as u64))?;
    Ok(perturbed(&drawn, request, member))
}

/// The command that runs members of `request` again, without their number.
pub fn again<'a>(
    scene: &str,
    changes: impl IntoIterator<Item = &'a String>,
    request: &EnsembleRequest,
) -> String {
    let mut command = format!("tumblenet run {scene}");
    for change in changes {
        command.push_str(&format!(" --set '{change}'"));
    }
    if let Some(at_most) = request.at_most_s {
        command.push_str(&format!(" --until settled --at-most {at_most}"));
    }
    command + &format!(" --perturb {:e} --seed {}", request.perturb_m, request.seed)
}

/// Runs the members that are not in `known` in parallel; `done` hears of each as it ends.
///
/// Returns all members in their order.
pub fn run(
    case: &Case,
    request: &EnsembleRequest,
    known: Vec<Member>,
    done: impl Fn(&Member) + Sync,
) -> Vec<Member> {
    let missing: Vec<usize> =
        (0..request.members).filter(|&member| known.iter().all(|k| k.member != member)).collect();
    let new: Vec<Member> = missing
        .into_par_iter()
        .map(|member| {
            let member = Member { member, outcome: outcome(case, request, member) };
            done(&member);
            member
        })
        .collect();
    let mut all: Vec<Member> = known.into_iter().chain(new).collect();
    all.sort_by_key(|member| member.member);
    all
}

fn outcome(case: &Case, request: &EnsembleRequest, number: usize) -> Result<Summary, String> {
    let case = member(case, request, number).map_err(|problems| problems.in_a_line())?;
    let (run, curves) =
        settle::run(&case, request.at_most_s, |_| {}).map_err(|failure| failure.to_string())?;
    Summary::of(&case, &run, &curves).sound()
}

impl Ensemble {
    /// What `members` have in common and where they differ.
    pub fn of(case: &Case, request: &EnsembleRequest, members: &[Member]) -> Ensemble {
        let summaries: Vec<&Summary> = members.iter().filter_map(|m| m.outcome.as_ref().ok()).collect();
        let verdicts: Vec<_> = summaries.iter().filter_map(|summary| summary.capture).collect();
        let mut reasons = BTreeMap::new();
        for verdict in &verdicts {
            *reasons.entry(format!("{:?}", verdict.reason).to_lowercase()).or_insert(0) += 1;
        }
        let ended = members.iter().filter_map(|m| Ended::of(m.member, m.outcome.as_ref().ok()?));
        let ended: Vec<Ended> = ended.collect();
        let mut values: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        for (name, value) in summaries.iter().flat_map(|summary| summary.scalars()) {
            values.entry(name).or_default().push(value);
        }
        Ensemble {
            title: case.scene().title.clone(),
            scene_hash: case.hash().to_owned(),
            request: *request,
            captured: (!verdicts.is_empty())
                .then(|| Share::of(verdicts.iter().filter(|v| v.captured).count(), verdicts.len())),
            reasons,
            verdict_counts: Ended::counts(&ended),
            survival: Survival::of(&summaries),
            verdicts: ended,
            held_turn: Share::held(&summaries, |retention| retention.turn),
            held_trial: Share::held(&summaries, |retention| retention.trial),
            drawn: Drawn::of(case, request),
            failures: members
                .iter()
                .filter_map(|m| Some((m.member, m.outcome.as_ref().err()?.clone())))
                .collect(),
            scalars: values.into_iter().map(|(name, values)| (name, Quartiles::of(values))).collect(),
        }
    }
}

impl Share {
    /// `captured` out of `of`.
    pub fn of(captured: usize, of: usize) -> Share {
        let (k, n) = (captured as f64, of as f64);
        // The exact interval: quantiles of Beta(k, n − k + 1) and Beta(k + 1, n − k).
        let bound = |a: f64, b: f64, p: f64| Beta::new(a, b).map(|beta| beta.inverse_cdf(p));
        let low = bound(k, n - k + 1.0, 0.025).unwrap_or(0.0);
        let high = bound(k + 1.0, n - k, 0.975).unwrap_or(1.0);
        Share { captured, of, share: k / n, interval_95: [low, high] }
    }

    /// Share of the runs that stood a trial, of those that were decided; nothing when none was.
    pub fn held(summaries: &[&Summary], trial: fn(Retention) -> Option<Trial>) -> Option<Share> {
        let decided: Vec<bool> =
            summaries.iter().filter_map(|summary| trial(summary.retention?)?.held).collect();
        let n_held = decided.iter().filter(|held| **held).count();
        (!decided.is_empty()).then(|| Share::of(n_held, decided.len()))
    }
}

impl Quartiles {
    /// Those of `values`, of which there is at least one.
    pub fn of(values: Vec<f64>) -> Quartiles {
        let count = values.len();
        let mut data = Data::new(values);
        Quartiles {
            min: data.quantile(0.0),
            lower: data.lower_quartile(),
            median: data.median(),
            upper: data.upper_quartile(),
            max: data.quantile(1.0),
            count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published values of the Clopper–Pearson interval.
    #[test]
    fn shares_carry_the_exact_interval() {
        let share = Share::of(9, 10);
        assert!((share.interval_95[0] - 0.5550).abs() < 1e-4, "{share:?}");
        assert!((share.interval_95[1] - 0.9975).abs() < 1e-4, "{share:?}");
        assert_eq!(Share::of(0, 10).interval_95[0], 0.0);
        assert_eq!(Share::of(10, 10).interval_95[1], 1.0);
    }
}
