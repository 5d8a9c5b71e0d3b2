//! After contact paths are chaotic: what a setting is worth there is a distribution.
//!
//! Each setting is run as an ensemble, member i perturbed alike in all of them, and set against the
//! ensemble of the finest: share captured with its exact interval, quartiles of the capture quality
//! index with intervals that assume nothing about its distribution (order statistics). How long it holds is a
//! [`Survival`] curve, and whether two of them differ says [`log_rank`], adjusted for all settings of the study.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Binomial, DiscreteCDF};

use super::Store;
use super::budget::forecast;
use super::dials::{AS_WRITTEN, DialKind, DialSetting};
use super::errors::Ending;
use super::timing::timed;
use crate::case::Case;
use crate::metrics::verdict::Capture;
use crate::scene::Source;
use crate::study::ensemble::{self, EnsembleRequest, Share};
use crate::study::log_rank::{self, LogRank};
use crate::study::survival::Survival;
use crate::work::Work;

/// Perturbation of an ensemble [m], as that of `run --ensemble`.
const PERTURB: f64 = 1e-6;

/// Settings of the engine's cables that are run beside the scene's own.
const COARSE: [&str; 2] = ["joints 2 ms", "joints 1 ms"];

/// Families that may matter after contact.
const FAMILIES: [&str; 4] = [AS_WRITTEN, "joints, precision", "joints, flight explicit", "other cables"];

/// Most members: more tell no more than a person can use.
const MAX_MEMBERS: usize = 100;

/// Fewest members: with less a median has no interval (see [`Quantile`]).
const MIN_MEMBERS: usize = 6;

/// One member's end, and what it cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictMember {
    /// Its number, from 0.
    pub member: usize,
    /// Processor time per simulated second [s/s], with another run beside it.
    pub cost: f64,
    /// How it ended, or why it failed.
    pub outcome: Result<Ending, String>,
}

/// A quantile with its 95 % interval; an end of it is absent where the members are too few to tell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quantile {
    /// Probability [-].
    pub at: f64,
    /// Its value.
    pub value: f64,
    /// The interval.
    pub interval_95: [Option<f64>; 2],
}

/// The distribution of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdicts {
    /// The setting.
    pub label: String,
    /// Share captured.
    pub captured: Share,
    /// Capture quality index: quartiles.
    pub cqi: [Quantile; 3],
    /// Deepest overlap of all members [m].
    pub max_penetration_m: f64,
    /// Cables through the target at the end, mean over the members.
    pub through_mean: f64,
    /// Members that failed.
    pub failed: usize,
    /// Processor time per simulated second, median over the members [s/s].
    pub cost: f64,
    /// Whether it is told apart from the reference ensemble, by share captured and quality.
    pub agreement: Agreement,
    /// How long it holds; absent where no member was ever held, or nothing touched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub survival: Option<Survival>,
    /// Whether that is told apart from the reference ensemble's curve; absent for that itself, and where in no setting
    /// anything touched or was held.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holding: Option<LogRank>,
}

/// Whether a distribution is told apart from that of the reference ensemble.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// It is the reference ensemble.
    Finest,
    /// Its intervals overlap.
    Agrees,
    /// They do not, or members failed.
    Differs,
    /// So few members have intervals that say nothing.
    TooFew,
}

/// What the distributions are asked for.
pub struct Asked<'a> {
    /// Seed of the perturbations.
    pub seed: u64,
    /// What they may cost (see [`super::budget`]) [s].
    pub seconds: f64,
    /// Work of the scene as written, for the forecast of the finest.
    pub work: &'a Work,
    /// What a run of each setting costs [s]; infinite where it was ended for that.
    pub prices: &'a [f64],
}

/// The distributions of the settings that may make a difference after contact, as many members of each
/// as `asked.seconds` pay for; the reference ensemble first. Where they do not pay for enough members of all,
/// the dearest settings are left out.
///
/// That is the scene's own method with half its step: contact responses differ in what they model, so
/// none is the truth for the others.
pub fn distributions(
    source: &Source,
    base: &Case,
    settings: &[DialSetting],
    asked: &Asked<'_>,
    store: &impl Store,
    tell: &mut impl FnMut(&str),
) -> Vec<Verdicts> {
    let half = base.scene().solver.step_s.map_or(base.time_step().step, |step| step.0) / 2.0;
    let mut finer = source.clone();
    let finer = finer.set(&[format!("solver.step_s={half:e}")]).and_then(|()| Case::build(&finer));
    let finest = finer.as_ref().map(|case| ("as written, half the step", case, forecast(case, asked.work)));
    let matters = |setting: &DialSetting| {
        setting.kind != DialKind::Method
            || FAMILIES.contains(&setting.family)
            || COARSE.contains(&setting.label.as_str())
    };
    let others =
        settings.iter().zip(asked.prices).filter(|(setting, price)| matters(setting) && price.is_finite());
    let others = others
        .filter_map(|(setting, price)| Some((setting.label.as_str(), setting.case.as_ref().ok()?, *price)));
    let (cases, members) = affordable(finest.into_iter().chain(others).collect(), asked.seconds);

    let request = EnsembleRequest { members, perturb_m: PERTURB, seed: asked.seed, at_most_s: None };
    let mut round = 0;
    let members = run(&cases, &request, store, || {
        round += 1;
        tell(&format!("ensembles, member {round}"));
    });
    let found = cases.iter().zip(&members);
    let mut verdicts: Vec<Verdicts> =
        found.filter_map(|((label, _), members)| Verdicts::of(label, members)).collect();
    if let Some((finest, others)) = verdicts.split_first_mut() {
        for other in others {
            other.agreement = other.against(finest);
        }
    }
    compare_curves(&mut verdicts, &members, asked.seed);
    verdicts
}

/// Sets every curve against the first; silent where nothing touched, or was ever held.
fn compare_curves(verdicts: &mut [Verdicts], members: &[Vec<VerdictMember>], seed: u64) {
    let endings = || members.iter().flatten().filter_map(|member| member.outcome.as_ref().ok());
    if !endings().any(|end| end.first_contact_s.is_some())
        || !endings().any(|end| end.capture.enclosed_at_s.is_some())
    {
        return;
    }
    let judged = members.iter().map(|members| judged(members)).filter(|judged| !judged.is_empty());
    let judged: Vec<Vec<(Capture, f64)>> = judged.collect();
    for (verdicts, judged_here) in verdicts.iter_mut().zip(&judged) {
        verdicts.survival = Survival::of_captures(judged_here);
        let is_finest = verdicts.agreement == Agreement::Finest;
        verdicts.holding = (!is_finest).then(|| LogRank::of(judged_here, &judged[0], seed));
    }
    let mut tests: Vec<&mut LogRank> = verdicts.iter_mut().filter_map(|one| one.holding.as_mut()).collect();
    log_rank::adjust(&mut tests);
}

/// Verdicts of the members that were finished, each with the end of its run [s].
fn judged(members: &[VerdictMember]) -> Vec<(Capture, f64)> {
    let ends = members.iter().filter_map(|member| member.outcome.as_ref().ok());
    ends.map(|end| (end.capture, end.end_s)).collect()
}

/// The cases and the number of members of each that `seconds` pay for, by the price of each: of all cases, or of those that are
/// left when the dearest, but never the first, are taken out until there are [`MIN_MEMBERS`]; of two at least two, or nothing at all.
fn affordable<'a>(
    mut cases: Vec<(&'a str, &'a Case, f64)>,
    seconds: f64,
) -> (Vec<(&'a str, &'a Case)>, usize) {
    loop {
        let members = (seconds / cases.iter().map(|(.., price)| price).sum::<f64>()) as usize;
        let dearest = (1..cases.len()).max_by(|&a, &b| cases[a].2.total_cmp(&cases[b].2));
        match dearest {
            Some(dearest) if members < MIN_MEMBERS && cases.len() > 2 => {
                cases.remove(dearest);
            }
            _ if members < 2 => return (Vec::new(), 0),
            _ => {
                let cases = cases.into_iter().map(|(label, case, _)| (label, case)).collect();
                return (cases, members.min(MAX_MEMBERS));
            }
        }
    }
}

/// Runs the members of all `cases` in turn; a list a case.
fn run(
    cases: &[(&str, &Case)],
    request: &EnsembleRequest,
    store: &impl Store,
    mut progress: impl FnMut(),
) -> Vec<Vec<VerdictMember>> {
    let mut all: Vec<Vec<VerdictMember>> = vec![Vec::new(); cases.len()];
    for number in 0..request.members {
        let round: Vec<VerdictMember> = cases
            .par_iter()
            .with_max_len(1)
            .map(|(_, case)| {
                if let Some(known) = store.known(case, "members", number) {
                    return known;
                }
                let member = member(case, request, number);
                store.keep(case, "members", number, &member);
                member
            })
            .collect();
        for (members, member) in all.iter_mut().zip(round) {
            members.push(member);
        }
        progress();
    }
    all
}

fn member(case: &Case, request: &EnsembleRequest, number: usize) -> VerdictMember {
    let case = match ensemble::member(case, request, number) {
        Ok(case) => case,
        Err(problems) => {
            return VerdictMember { member: number, cost: 0.0, outcome: Err(problems.in_a_line()) };
        }
    };
    let (run, seconds) = timed(&case);
    let outcome = run
        .map_err(|failure| failure.to_string())
        .and_then(|run| Ending::of(&case, &run).ok_or_else(|| "no target".to_owned()));
    VerdictMember { member: number, cost: seconds / case.scene().duration_s.0, outcome }
}

impl Verdicts {
    /// The distribution of `members`; nothing when none was finished.
    pub fn of(label: &str, members: &[VerdictMember]) -> Option<Verdicts> {
        let ends: Vec<&Ending> = members.iter().filter_map(|member| member.outcome.as_ref().ok()).collect();
        if ends.is_empty() {
            return None;
        }
        let mut cqi: Vec<f64> = ends.iter().map(|end| end.capture.cqi).collect();
        cqi.sort_by(f64::total_cmp);
        let mut costs: Vec<f64> = members.iter().map(|member| member.cost).collect();
        costs.sort_by(f64::total_cmp);
        Some(Verdicts {
            label: label.to_owned(),
            captured: Share::of(ends.iter().filter(|end| end.capture.captured).count(), ends.len()),
            cqi: [0.25, 0.5, 0.75].map(|at| Quantile::of(&cqi, at)),
            max_penetration_m: ends.iter().map(|end| end.max_penetration_m).fold(0.0, f64::max),
            through_mean: ends.iter().map(|end| end.through as f64).sum::<f64>() / ends.len() as f64,
            failed: members.len() - ends.len(),
            cost: costs[costs.len() / 2],
            agreement: Agreement::Finest,
            survival: None,
            holding: None,
        })
    }

    /// Whether it is told apart from `other`, by the share captured and the median quality index.
    fn against(&self, other: &Verdicts) -> Agreement {
        let overlap = |a: [f64; 2], b: [f64; 2]| a[0] <= b[1] && b[0] <= a[1];
        let both = |quantile: &Quantile| match quantile.interval_95 {
            [Some(low), Some(high)] => Some([low, high]),
            _ => None,
        };
        let (Some(own), Some(others)) = (both(&self.cqi[1]), both(&other.cqi[1])) else {
            return Agreement::TooFew;
        };
        let alike = overlap(self.captured.interval_95, other.captured.interval_95) && overlap(own, others);
        if alike && self.failed == 0 { Agreement::Agrees } else { Agreement::Differs }
    }
}

impl Quantile {
    /// The quantile `at` of `sorted` values, of which there is at least one.
    ///
    /// The number of values below the true quantile is binomial, so the interval runs between order
    /// statistics: from number l to number u with P(X < l) and P(X ≥ u) at most 2.5 % each.
    pub fn of(sorted: &[f64], at: f64) -> Quantile {
        let n = sorted.len();
        let value = sorted[((at * n as f64).ceil() as usize).clamp(1, n) - 1];
        let Ok(below) = Binomial::new(at, n as u64) else {
            return Quantile { at, value, interval_95: [None, None] };
        };
        // Numbers from 1, as in the books.
        let lower = (1..=n).rev().find(|l| below.cdf(*l as u64 - 1) <= 0.025);
        let upper = (1..=n).find(|u| 1.0 - below.cdf(*u as u64 - 1) <= 0.025);
        Quantile { at, value, interval_95: [lower.map(|l| sorted[l - 1]), upper.map(|u| sorted[u - 1])] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Conover, Practical Nonparametric Statistics: the median of 10 lies between the 2nd and the 9th
    /// with 97.9 %; of 5 no two order statistics enclose it with 95 %.
    #[test]
    fn intervals_of_a_median_are_those_of_the_books() {
        let values: Vec<f64> = (1..=10).map(f64::from).collect();
        assert_eq!(Quantile::of(&values, 0.5).interval_95, [Some(2.0), Some(9.0)]);
        assert_eq!(Quantile::of(&values[..5], 0.5).interval_95, [None, None]);
        assert_eq!(Quantile::of(&values, 0.25).interval_95[0], None);
        assert_eq!(Quantile::of(&[3.0], 0.5).value, 3.0);
    }
}
