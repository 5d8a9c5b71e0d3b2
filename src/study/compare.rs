//! One scene in several variants, or several scenes, side by side: do two methods, or two mechanisms, tell the same story?
//!
//! Every variant is run as the same small ensemble, so that member i has the same perturbation in
//! all of them. Variants are compared with the first one that can be run, the base, member by
//! member. After contact a net is chaotic: two runs of one method drift apart from a difference in
//! the last digits. The members of the base among themselves show that drift, and a difference
//! between methods means something only where it exceeds it ([`Against::over_chaos`]).
//!
//! The source compares its impulse and penalty methods so (Section 4.5.1, Fig. 4.18 to 4.20), with one run each.

pub mod difference;
pub mod track;
pub mod variants;

use std::collections::BTreeMap;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ensemble::{self, Ended, Quartiles, Share};
use super::settle;
use super::survival::Survival;
use crate::case::Case;
use crate::metrics::summary::Summary;
use crate::provenance::Provenance;
use crate::solver::Solver;
use difference::{Path, Separation};
use track::{Bands, Track, TrackMember};
use variants::Variant;

/// Default trust distance of `case` [m]: 1 % of the net's side.
pub fn trust_distance(case: &Case) -> f64 {
    0.01 * case.net().designed_area.sqrt()
}

/// What a comparison is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CompareRequest {
    /// The ensemble that each variant is run as.
    pub ensemble: ensemble::EnsembleRequest,
    /// Runs agree while their largest bullet difference is below this [m].
    pub trust_distance_m: f64,
    /// Whether runs go one after another, so that wall times are not those of a shared machine.
    pub serial: bool,
}

impl CompareRequest {
    /// Runs that go at once.
    pub fn at_once(&self) -> usize {
        if self.serial { 1 } else { rayon::current_num_threads() }
    }
}

/// `compare.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// The scene's title.
    pub title: String,
    /// What was asked for.
    pub request: CompareRequest,
    /// Label of the variant that the others are compared with.
    pub base: String,
    /// Most runs that shared the machine: above 1, wall times are longer than those of a run alone.
    pub runs_at_once: usize,
    /// The variants, in the order they were named.
    pub variants: Vec<Compared>,
    /// What made these numbers.
    pub provenance: Provenance,
}

/// One variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Compared {
    /// Its name: `joints+impulse`, `solver.sweeps=4`.
    pub label: String,
    /// What it changes in the scene.
    pub changes: Vec<String>,
    /// The command that runs a member again, but for its number; empty where no program asked.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub again: String,
    /// Why the checks refuse it; empty for one that ran.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<String>,
    /// Members that failed, and why.
    pub failures: BTreeMap<usize, String>,
    /// What it did; absent when no member was finished.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outcome: Option<Outcome>,
}

/// What a variant did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The method.
    pub solver: Solver,
    /// Hash of scene and target.
    pub scene_hash: String,
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
    /// How each member ended.
    #[serde(default)]
    pub verdicts: Vec<Ended>,
    /// Share that held the target over one period of its tumbling, of those decided (`retention.turn`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_turn: Option<Share>,
    /// Share that held the target while an effect put the capture to the test, of those decided (`retention.tug`).
    #[serde(default, rename = "held_tug", skip_serializing_if = "Option::is_none")]
    pub held_trial: Option<Share>,
    /// Quartiles of every number of the summaries.
    pub scalars: BTreeMap<String, Quartiles>,
    /// Difference between its own members: chaos. Absent with fewer than two.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own: Option<Separation>,
    /// Difference from the base; absent for the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against_base: Option<Against>,
    /// Its curves.
    pub curves: Bands,
}

/// A variant against the base, member by member.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Against {
    /// The bullets' differences.
    pub separation: Separation,
    /// Mean bullet difference over that of the base's members among themselves [-]: about 1 is chaos alone, well
    /// above it a difference of the variants. Null when the base's members are one, or alike to the bit.
    pub over_chaos: Option<f64>,
    /// First contact, variant less base [s]; absent where either has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_contact_s: Option<Quartiles>,
    /// Push (displacement of the target along X), variant over base less one [%]; absent where the base pushes nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub push_percent: Option<Quartiles>,
    /// Median wall time over that of the base [-].
    pub wall_over_base: f64,
}

/// Runs every member of every variant that is not in `known`; `done` hears of each as it ends.
///
/// `known` and the result have a list a variant, in the order of `variants`; a refused one has none.
pub fn run(
    variants: &[Variant],
    request: &CompareRequest,
    known: Vec<Vec<TrackMember>>,
    done: impl Fn(usize, &TrackMember) + Sync,
) -> Vec<Vec<TrackMember>> {
    // Member by member, not variant by variant: what else the machine does then falls on all variants alike.
    let missing: Vec<(usize, usize, &Case)> = (0..request.ensemble.members)
        .flat_map(|member| {
            let cases = variants.iter().enumerate();
            cases.filter_map(move |(v, variant)| Some((member, v, variant.case.as_ref().ok()?)))
        })
        .filter(|&(member, v, _)| known[v].iter().all(|known| known.member != member))
        .collect();
    let at_once = request.at_once().min(missing.len());
    let one = |&(member, v, case): &(usize, usize, &Case)| {
        let outcome = ensemble::member(case, &request.ensemble, member)
            .map_err(|problems| problems.in_a_line())
            .and_then(|case| {
                let run = settle::run(&case, request.ensemble.at_most_s, |_| {});
                run.map(|(run, curves)| Track::of(&case, &run, curves)).map_err(|failure| failure.to_string())
            });
        let member = TrackMember { member, at_once, outcome };
        done(v, &member);
        (v, member)
    };
    let new: Vec<(usize, TrackMember)> = if request.serial {
        missing.iter().map(one).collect()
    } else {
        // One at a time to each thread, in order: the default would deal each thread a block of variants.
        missing.par_iter().with_max_len(1).map(one).collect()
    };
    let mut all = known;
    for (v, member) in new {
        all[v].push(member);
    }
    for members in &mut all {
        members.sort_by_key(|member| member.member);
    }
    all
}

impl Comparison {
    /// Sets `variants` side by side, whose runs are `members`.
    pub fn of(
        title: &str,
        variants: &[Variant],
        request: &CompareRequest,
        members: &[Vec<TrackMember>],
    ) -> Comparison {
        let base = members.iter().position(|members| members.iter().any(|member| member.outcome.is_ok()));
        let base = base.or_else(|| variants.iter().position(|variant| variant.case.is_ok())).unwrap_or(0);
        let mut compared: Vec<Compared> = variants
            .iter()
            .zip(members)
            .map(|(variant, members)| Compared::alone(variant, members, request))
            .collect();
        let base_outcome = compared[base].outcome.clone();
        for (v, compared) in compared.iter_mut().enumerate().filter(|(v, _)| *v != base) {
            if let (Some(outcome), Some(base_outcome)) = (&mut compared.outcome, &base_outcome) {
                outcome.against_base =
                    Against::of(outcome, &members[v], base_outcome, &members[base], request);
            }
        }
        Comparison {
            title: title.to_owned(),
            request: *request,
            base: variants[base].label.clone(),
            runs_at_once: members.iter().flatten().map(|member| member.at_once).max().unwrap_or(0),
            variants: compared,
            provenance: Provenance::here(),
        }
    }

    /// The base's own outcome; nothing when every run failed.
    pub fn base(&self) -> Option<&Outcome> {
        self.variants.iter().find(|variant| variant.label == self.base)?.outcome.as_ref()
    }

    /// The variants that did something, with their place in the list.
    pub fn ran(&self) -> impl Iterator<Item = (usize, &Compared, &Outcome)> {
        let numbered = self.variants.iter().enumerate();
        numbered.filter_map(|(number, variant)| Some((number, variant, variant.outcome.as_ref()?)))
    }
}

impl Compared {
    fn alone(variant: &Variant, members: &[TrackMember], request: &CompareRequest) -> Compared {
        let failure = |member: &TrackMember| Some((member.member, member.outcome.as_ref().err()?.clone()));
        Compared {
            label: variant.label.clone(),
            changes: variant.changes.clone(),
            again: String::new(),
            refused: variant.case.as_ref().err().map_or(Vec::new(), |problems| {
                let words = |p: &crate::problems::Problem| {
                    format!("{}: found {}; allowed: {}", p.place, p.found, p.allowed)
                };
                problems.list.iter().map(words).collect()
            }),
            failures: members.iter().filter_map(failure).collect(),
            outcome: variant.case.as_ref().ok().and_then(|case| Outcome::of(case, members, request)),
        }
    }
}

impl Outcome {
    fn of(case: &Case, members: &[TrackMember], request: &CompareRequest) -> Option<Outcome> {
        let tracks: Vec<&Track> = tracks(members).map(|(_, track)| track).collect();
        let summaries: Vec<&Summary> = tracks.iter().map(|track| &track.summary).collect();
        let verdicts: Vec<_> = summaries.iter().filter_map(|summary| summary.capture).collect();
        let mut reasons = BTreeMap::new();
        for verdict in &verdicts {
            *reasons.entry(format!("{:?}", verdict.reason).to_lowercase()).or_insert(0) += 1;
        }
        let ended = self::tracks(members).filter_map(|(member, track)| Ended::of(member, &track.summary));
        let ended: Vec<Ended> = ended.collect();
        let mut values: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        for (name, value) in summaries.iter().flat_map(|summary| summary.scalars()) {
            values.entry(name).or_default().push(value);
        }
        let paths: Vec<&Path> = tracks.iter().map(|track| &track.path).collect();
        let pairs: Vec<(&Path, &Path)> = paths
            .iter()
            .enumerate()
            .flat_map(|(i, &one)| paths[..i].iter().map(move |&other| (one, other)))
            .collect();
        (!tracks.is_empty()).then(|| Outcome {
            solver: case.scene().solver,
            scene_hash: case.hash().to_owned(),
            captured: (!verdicts.is_empty())
                .then(|| Share::of(verdicts.iter().filter(|v| v.captured).count(), verdicts.len())),
            reasons,
            verdict_counts: Ended::counts(&ended),
            survival: Survival::of(&summaries),
            verdicts: ended,
            held_turn: Share::held(&summaries, |retention| retention.turn),
            held_trial: Share::held(&summaries, |retention| retention.trial),
            scalars: values.into_iter().map(|(name, values)| (name, Quartiles::of(values))).collect(),
            own: Separation::of(&pairs, request.trust_distance_m),
            against_base: None,
            curves: Bands::of(&tracks),
        })
    }

    /// Median of a number of the summary, where the variant has it.
    pub fn median(&self, name: &str) -> Option<f64> {
        self.scalars.get(name).map(|quartiles| quartiles.median)
    }
}

impl Against {
    fn of(
        outcome: &Outcome,
        members: &[TrackMember],
        base: &Outcome,
        base_members: &[TrackMember],
        request: &CompareRequest,
    ) -> Option<Against> {
        // The same member of both: the same perturbation.
        let both: Vec<(&Track, &Track)> = tracks(base_members)
            .filter_map(|(number, base)| {
                tracks(members).find(|(other, _)| *other == number).map(|(_, track)| (base, track))
            })
            .collect();
        let paths: Vec<(&Path, &Path)> = both.iter().map(|(base, track)| (&base.path, &track.path)).collect();
        let separation = Separation::of(&paths, request.trust_distance_m)?;
        let quartiles = |of: fn(&Summary, &Summary) -> Option<f64>| {
            let values: Vec<f64> =
                both.iter().filter_map(|(base, track)| of(&base.summary, &track.summary)).collect();
            (!values.is_empty()).then(|| Quartiles::of(values))
        };
        let chaos = base.own.as_ref().map(|own| own.whole.all_m.mean).filter(|&mean| mean > 0.0);
        let wall = |outcome: &Outcome| outcome.median("wall_s").unwrap_or(f64::NAN);
        Some(Against {
            over_chaos: chaos.map(|chaos| separation.whole.all_m.mean / chaos),
            first_contact_s: quartiles(|base, variant| {
                Some(variant.contact?.first_contact_s? - base.contact?.first_contact_s?)
            }),
            push_percent: quartiles(|base, variant| {
                let push = |summary: &Summary| Some(summary.target?.displacement_m[0]);
                let (from, to) = (push(base)?, push(variant)?);
                (from != 0.0).then(|| 100.0 * (to / from - 1.0))
            }),
            wall_over_base: wall(outcome) / wall(base),
            separation,
        })
    }
}

fn tracks(members: &[TrackMember]) -> impl Iterator<Item = (usize, &Track)> {
    members.iter().filter_map(|member| Some((member.member, member.outcome.as_ref().ok()?)))
}
