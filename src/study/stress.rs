//! Hard cases that must stay numerically stable, each under every pair of cables and contact.
//!
//! [`catalogue`] lists them, [`hard`] says what a case is, [`measure`] runs one and measures it. Here the
//! numbers meet their bounds. The verdict of a case under a pair:
//!
//! - **holds**: every bound is kept, at the case's step and, where the case asks for it, at half of it;
//! - **refused**: the checks refuse it, at the place that the case names;
//! - **holds from**: a bound is broken, as the case foretells with a reason and a band of numbers, and kept with
//!   the settings that the case names as the limit;
//! - **does not hold**: a bound is broken, within the band that the case foretells; no limit was found;
//! - **not run**: it would take too long, as the case says;
//! - **breaks**: anything else, a limit that is no longer needed among it. A promise is broken.

pub mod catalogue;
pub mod hard;

#[doc(inline)]
pub use tumblenet_core::study::stress::measure;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ensemble::{EnsembleRequest, perturbed};
use crate::case::Case;
use crate::limits::Limits;
use crate::provenance::Provenance;
use crate::scene::Source;
use crate::solver;
use hard::{KnownFailure, StressCase};
use measure::{Measured, Numbers};

/// `stress.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stress {
    /// Every case under every pair, case by case.
    pub rows: Vec<StressRow>,
    /// What made these numbers.
    pub provenance: Provenance,
}

/// A case under a pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StressRow {
    /// The case.
    pub case: String,
    /// What it is an example of.
    pub theme: String,
    /// The pair of cables and contact.
    pub pair: String,
    /// What became of it.
    pub verdict: StressVerdict,
    /// Why it is not simply "holds": the broken bounds, the refusal, the reason that the case gives.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// What must hold; a number that is absent is not asked for.
    pub bounds: Numbers,
    /// What was measured; absent where nothing ran.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured: Option<Measured>,
    /// The same of further members, whose folded knots are moved a little.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<Measured>,
    /// The same at half the step, where the case asks for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub halved: Option<Measured>,
    /// The same at the limit from which the pair holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_limit: Option<Measured>,
}

/// What became of a case under a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StressVerdict {
    /// Every bound is kept.
    Holds,
    /// The checks refuse it, as they should.
    Refused,
    /// Kept from a limit on.
    HoldsFrom,
    /// Not kept, with a known reason.
    DoesNotHold,
    /// Not run, with a reason.
    NotRun,
    /// A promise is broken.
    Breaks,
}

impl StressRow {
    /// Its run and those of its further members.
    pub fn as_it_is(&self) -> impl Iterator<Item = &Measured> {
        self.measured.iter().chain(&self.members)
    }

    /// Wall time of its runs [s].
    pub fn wall(&self) -> f64 {
        self.as_it_is().chain(&self.halved).chain(&self.at_limit).map(|m| m.wall_s).sum()
    }
}

impl Stress {
    /// The rows whose promise is broken.
    pub fn broken(&self) -> impl Iterator<Item = &StressRow> {
        self.rows.iter().filter(|row| row.verdict == StressVerdict::Breaks)
    }
}

/// One run: of a case under a pair, as it is, at half its step, or at its limit.
pub struct Job {
    /// Its row of the result.
    row: usize,
    variant: RunVariant,
    /// What is run.
    pub case: Case,
    /// Name of the case and the pair, and which of the runs it is: that of no other run.
    pub name: String,
}

impl Job {
    fn new(row: usize, hard: &StressCase, pair: &str, variant: RunVariant, case: Case) -> Job {
        let name = format!("{}-{pair}-{}", hard.name, variant.word());
        Job { row, variant, case, name }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum RunVariant {
    AsItIs,
    /// The same, its folded knots moved a little: after contact one run is a coin.
    Member(usize),
    Halved,
    AtLimit,
}

impl RunVariant {
    fn word(self) -> String {
        match self {
            RunVariant::AsItIs => "as-it-is".to_owned(),
            RunVariant::Member(number) => format!("member-{number}"),
            RunVariant::Halved => "halved".to_owned(),
            RunVariant::AtLimit => "at-limit".to_owned(),
        }
    }
}

/// Largest displacement of a member's knots along each axis, over the shortest cable [-].
const MEMBERS_MOVED: f64 = 1e-6;

/// The copy of `case` that is `member`.
fn moved(case: &Case, member: usize) -> Case {
    let shortest = case.net().cables.iter().map(|cable| cable.rest_length).fold(f64::INFINITY, f64::min);
    let perturb_m = MEMBERS_MOVED * shortest;
    perturbed(case, &EnsembleRequest { members: 1, perturb_m, seed: 0, at_most_s: None }, member)
}

/// Runs `cases` under `pairs`, in parallel, but for those whose numbers are `known`; `done` hears of each run as
/// it ends. Of `members` of a case, the first is the case itself, and the worst of each number counts.
///
/// The result does not depend on the number of threads, but for wall times.
pub fn run(
    cases: &[StressCase],
    pairs: &[&str],
    members: usize,
    known: impl Fn(&Job) -> Option<Measured> + Sync,
    done: impl Fn(&Job, &Measured) + Sync,
) -> Stress {
    let asked: Vec<(&StressCase, &str)> =
        cases.iter().flat_map(|case| pairs.iter().map(move |pair| (case, *pair))).collect();
    let mut rows = Vec::with_capacity(asked.len());
    let mut jobs = Vec::new();
    for (number, (hard, pair)) in asked.iter().enumerate() {
        let (row, new) = prepare(hard, pair, members, number);
        rows.push(row);
        jobs.extend(new);
    }
    // The longest first: none is left for the end while the other threads have nothing to do.
    jobs.sort_by_key(|job| std::cmp::Reverse(work(&job.case)));
    let measured: Vec<(usize, RunVariant, Measured)> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|job| {
            let measured = known(job).unwrap_or_else(|| Measured::of(&job.case));
            done(job, &measured);
            (job.row, job.variant, measured)
        })
        .collect();
    for (row, variant, measured) in measured {
        let row = &mut rows[row];
        match variant {
            RunVariant::AsItIs => row.measured = Some(measured),
            RunVariant::Member(_) => row.members.push(measured),
            RunVariant::Halved => row.halved = Some(measured),
            RunVariant::AtLimit => row.at_limit = Some(measured),
        }
    }
    for (row, (hard, pair)) in rows.iter_mut().zip(&asked) {
        judge(row, hard.limit(pair));
    }
    Stress { rows, provenance: Provenance::here() }
}

/// Number of runs that [`run`] would do at most.
pub fn n_runs(cases: &[StressCase], pairs: &[&str], members: usize) -> usize {
    let of = |hard: &StressCase, pair: &str| prepare(hard, pair, members, 0).1.len();
    cases.iter().map(|hard| pairs.iter().map(|pair| of(hard, pair)).sum::<usize>()).sum()
}

/// Steps of knots: about what a run costs.
fn work(case: &Case) -> u64 {
    case.n_steps() * u64::from(case.time_step().substeps) * case.net().n_knots() as u64
}

/// The row of a case before anything ran, and the runs it needs.
fn prepare(hard: &StressCase, pair: &str, members: usize, number: usize) -> (StressRow, Vec<Job>) {
    let mut row = StressRow {
        case: hard.name.to_owned(),
        theme: hard.theme.title().to_owned(),
        pair: pair.to_owned(),
        verdict: StressVerdict::Holds,
        notes: Vec::new(),
        bounds: hard.bounds.under(pair),
        measured: None,
        members: Vec::new(),
        halved: None,
        at_limit: None,
    };
    let limit = hard.limit(pair);
    if let Some(limit) = limit {
        row.notes.push(limit.why.to_owned());
        if limit.not_run {
            row.verdict = StressVerdict::NotRun;
            return (row, Vec::new());
        }
    }
    let mut jobs = Vec::new();
    match hard.build(pair, &[], 1.0) {
        Ok(case) => {
            if hard.halves && limit.is_none() {
                // What holds may not be refused at half its step: `build` says so where it is.
                match hard.build(pair, &[], 0.5) {
                    Ok(case) => jobs.push(Job::new(number, hard, pair, RunVariant::Halved, case)),
                    Err(refusal) => refused(&mut row, hard, &refusal),
                }
            }
            let member = |member| (RunVariant::Member(member), moved(&case, member));
            let members: Vec<_> = (1..members).map(member).collect();
            jobs.push(Job::new(number, hard, pair, RunVariant::AsItIs, case));
            jobs.extend(
                members.into_iter().map(|(variant, case)| Job::new(number, hard, pair, variant, case)),
            );
            if let Some(changes) = limit.map(|limit| &limit.from).filter(|changes| !changes.is_empty()) {
                match hard.build(pair, changes, 1.0 / hard.times_step) {
                    Ok(case) => jobs.push(Job::new(number, hard, pair, RunVariant::AtLimit, case)),
                    Err(refusal) => refused(&mut row, hard, &refusal),
                }
            }
        }
        Err(refusal) => refused(&mut row, hard, &refusal),
    }
    (row, jobs)
}

/// A refusal is right where the case names its place.
fn refused(row: &mut StressRow, hard: &StressCase, refusal: &crate::problems::Problems) {
    let expected = |place: &str| hard.refusals.contains(&place);
    let right = refusal.list.iter().all(|problem| expected(&problem.place));
    row.verdict = if right { StressVerdict::Refused } else { StressVerdict::Breaks };
    row.notes.extend(
        refusal.list.iter().map(|problem| {
            format!("{}: found {}; allowed: {}", problem.place, problem.found, problem.allowed)
        }),
    );
}

/// Sets what was measured against the bounds.
fn judge(row: &mut StressRow, limit: Option<&KnownFailure>) {
    let Some(measured) = row.as_it_is().cloned().reduce(Measured::worst) else { return };
    let broken = measured.broken(&row.bounds);
    let halved = row.halved.as_ref().map(|halved| halved.broken(&row.bounds)).unwrap_or_default();
    row.notes.extend(broken.iter().cloned());
    row.notes.extend(halved.iter().map(|broken| format!("at half the step: {broken}")));
    if row.verdict == StressVerdict::Breaks {
        return;
    }
    let Some(limit) = limit else {
        row.verdict =
            if broken.is_empty() && halved.is_empty() { StressVerdict::Holds } else { StressVerdict::Breaks };
        return;
    };
    let contradicted = limit.contradicted(&measured.numbers, &row.bounds);
    let at_limit = row.at_limit.as_ref().map(|at_limit| at_limit.broken(&row.bounds));
    let words = limit.words();
    let against_it = at_limit.iter().flatten().map(|broken| format!("with {words}: {broken}"));
    row.notes.extend(contradicted.iter().cloned().chain(against_it));
    let is_true = contradicted.is_empty() && measured.failure.is_none();
    row.verdict = match at_limit {
        _ if !is_true => StressVerdict::Breaks,
        Some(broken) if !broken.is_empty() => StressVerdict::Breaks,
        _ if broken.is_empty() => StressVerdict::Holds,
        Some(_) => {
            row.notes.push(format!("holds from {words}"));
            StressVerdict::HoldsFrom
        }
        None => StressVerdict::DoesNotHold,
    };
}

/// Names of the pairs that run where none is named, the default first.
pub fn pairs() -> Vec<&'static str> {
    solver::PAIRS.iter().map(|pair| pair.2).collect()
}

/// Names of all pairs.
pub fn all_pairs() -> Vec<&'static str> {
    solver::PAIRS.iter().chain(&solver::ELEMENT_PAIRS).map(|pair| pair.2).collect()
}

impl StressCase {
    /// The checked case under `pair`, with further `changes`, at `share` of its step.
    ///
    /// A limit is at the pair's own step, or at the one that its changes name.
    ///
    /// # Errors
    /// What the checks refuse.
    pub fn build(&self, pair: &str, changes: &[&str], share: f64) -> Result<Case, crate::problems::Problems> {
        let mut source = Source {
            name: self.name.into(),
            input: self.name.into(),
            folder: None,
            json: self.scene.clone(),
            limits: Limits::default(),
        };
        let (cables, contact) = pair.split_once('+').unwrap_or((pair, ""));
        let mut all = vec![format!("solver.cables={cables}"), format!("solver.contact={contact}")];
        all.extend(changes.iter().map(|&change| change.to_owned()));
        source.set(&all)?;
        let mut case = Case::build(&source)?;
        let factor = share * self.times_step;
        if factor != 1.0 {
            // The pair's own step is known only now.
            let step = case.scene().solver.step_s.map_or(case.time_step().step, |step| step.0);
            source.set(&[format!("solver.step_s={:e}", factor * step)])?;
            case = Case::build(&source)?;
        }
        if let Some(start) = self.start {
            case = case.changed(start)?;
        }
        Ok(case)
    }
}
