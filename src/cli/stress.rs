//! `tumblenet stress`: the catalogue of hard cases.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use clap::Args;
use tumblenet::problems::{Problems, nearest};
use tumblenet::report::files::WriteError;
use tumblenet::report::{files, stress as report};
use tumblenet::study::ensemble::EnsembleRequest;
use tumblenet::study::stress::hard::StressCase;
use tumblenet::study::stress::{self, Job, Stress, catalogue};

use super::members::Kept;
use super::terminal::{Progress, stage};
use super::{Error, Format, interrupt, json, print, say};

/// Arguments of `stress`.
#[derive(Args)]
pub struct Arguments {
    /// Cases, or themes, or beginnings of either; left out: all.
    cases: Vec<String>,
    /// Pairs of cables and contact, `joints+rapier,joints+impulse`; left out: all but those with `ancf` cables.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    pairs: Option<Vec<String>>,
    /// How often each case is run: after contact one run is a coin. The first is the case itself, of the others the
    /// folded knots are moved by a millionth of a cable; the worst of each number counts.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    members: u32,
    /// Lists the cases and why each is hard.
    #[arg(long)]
    list: bool,
    /// Folder for the results; left out: results/stress.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Runs the cases and writes what they came to.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let mut problems = Problems::new("stress");
    let cases = cases(&arguments.cases, &mut problems);
    let pairs = pairs(arguments.pairs.as_deref(), &mut problems);
    let (cases, pairs) = problems.into_result(Some((cases, pairs)))?;
    if arguments.list {
        return print(&report::list(&cases));
    }
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join("stress"));
    // Before the runs, not after: an unwritable folder should cost no run.
    files::make_folder(&out)?;

    stage("running");
    let members = arguments.members as usize;
    let bar = Progress::new(stress::n_runs(&cases, &pairs, members) as u64, "stress");
    interrupt::leaves(format!(
        "finished runs are kept in {}; the same command goes on from them",
        out.display()
    ));
    let unwritten = Mutex::new(None);
    let stress = stress::run(
        &cases,
        &pairs,
        members,
        |job| kept(&out, job).ok()?.one(0),
        |job, measured| {
            let written = kept(&out, job).and_then(|kept| {
                kept.keep(0, measured);
                kept.finish()
            });
            if let Err(error) = written {
                unwritten.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            }
            bar.one_more();
        },
    );
    drop(bar);
    stage("writing");
    unwritten.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)?;
    report::write(&out, &stress)?;
    match arguments.format {
        Format::Json => print(&json(&stress))?,
        Format::Text => {
            say(&report::text(&stress))?;
            say(&format!("Results: {}", out.join("stress.csv").display()))?;
        }
    }
    all_held(&stress)
}

/// The place of what a run came to.
fn kept(out: &Path, job: &Job) -> Result<Kept, WriteError> {
    let request = EnsembleRequest { members: 0, perturb_m: 0.0, seed: 0, at_most_s: None };
    Kept::open(&out.join("runs"), &job.name, &job.case, &request)
}

/// The cases whose name or theme begins with one of `named`; all without any.
fn cases(named: &[String], problems: &mut Problems) -> Vec<StressCase> {
    let all = catalogue::all();
    let begins =
        |case: &StressCase, name: &str| case.name.starts_with(name) || case.theme.title().starts_with(name);
    for name in named {
        if name.is_empty() || !all.iter().any(|case| begins(case, name)) {
            let names: Vec<&str> = all.iter().map(|case| case.name).collect();
            let meant = nearest(name, names.iter().copied());
            let allowed = meant.map_or_else(
                || names.join(", "),
                |meant| format!("did you mean {meant}? (`tumblenet stress --list` names all)"),
            );
            problems.add("CASE", name, allowed);
        }
    }
    all.into_iter().filter(|case| named.is_empty() || named.iter().any(|name| begins(case, name))).collect()
}

fn pairs(named: Option<&[String]>, problems: &mut Problems) -> Vec<&'static str> {
    let Some(named) = named else { return stress::pairs() };
    let all = stress::all_pairs();
    for name in named {
        if !all.contains(&name.as_str()) {
            problems.add("--pairs", format!("{name:?}"), all.join(", "));
        }
    }
    all.into_iter().filter(|pair| named.iter().any(|name| name == pair)).collect()
}

fn all_held(stress: &Stress) -> Result<(), Error> {
    let broken: Vec<String> = stress.broken().map(|row| format!("{} under {}", row.case, row.pair)).collect();
    if broken.is_empty() {
        return Ok(());
    }
    Err(Error::Expectation(format!("{} broken: {}", broken.len(), broken.join(", "))))
}
