//! `tumblenet sweep`: one scene at many points of its parameters.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use clap::{Args, Subcommand};
use tumblenet::problems::Problems;
use tumblenet::report::files;
use tumblenet::report::rows::{KeptRows, RowKeeper};
use tumblenet::report::sweep::{self as report, SweepResult};
use tumblenet::report::table;
use tumblenet::study::ensemble::Share;
use tumblenet::study::sweep::{Row, Shard, Sweep, SweepPlan};

use super::fingerprint::fingerprint;
use super::reading::Reading;
use super::terminal::{Progress, remark, stage};
use super::{Error, Format, array_job, interrupt, json, print, run, say};

/// Arguments of `sweep`.
#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Arguments {
    #[command(subcommand)]
    task: Option<Task>,
    /// Study file, or name of a built-in study.
    #[arg(required = true)]
    study: Option<String>,
    /// Folder for the results; left out: results/NAME.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Runs a part of it alone, every N-th member; `sweep merge` puts the parts together.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Runs one member and writes all its results, to be watched: the same bits as in the table.
    #[arg(long, value_name = "N", conflicts_with = "shard")]
    member: Option<u64>,
    #[command(flatten)]
    reading: Reading,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What is done with rows that are there.
#[derive(Subcommand)]
enum Task {
    /// Says how far a sweep is.
    Status(Place),
    /// Prints the members that have no row yet, as `3,7-9`.
    Missing {
        #[command(flatten)]
        place: Place,
        /// Prints the shards of so many that have a missing member: what an array job is to run again.
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
        shards: Option<u64>,
    },
    /// Prints a script that runs a sweep as an array job of a cluster's scheduler.
    Template(array_job::Arguments),
    /// Writes the table of all rows.
    Merge {
        #[command(flatten)]
        place: Place,
        /// Also where rows are missing.
        #[arg(long)]
        partial: bool,
    },
}

/// Where a sweep's results are.
#[derive(Args)]
struct Place {
    /// Folder of the results.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Runs the study of the arguments, or does what they say with its rows.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    match &arguments.task {
        Some(Task::Status(place)) => {
            let (plan, kept) = kept(&place.folder)?;
            tell(&SweepResult::of(&plan, &kept), place.format, None)
        }
        Some(Task::Missing { place, shards }) => {
            let (plan, kept) = kept(&place.folder)?;
            print(&report::missing(&plan, &kept, *shards))
        }
        Some(Task::Merge { place, partial }) => {
            let (plan, kept) = kept(&place.folder)?;
            let missing = report::missing(&plan, &kept, None);
            if !missing.is_empty() && !partial {
                return Err(Error::Expectation(format!(
                    "no rows of members {missing} (--partial merges the others)"
                )));
            }
            let result = report::merge(&place.folder, &plan, &kept)?;
            tell(&result, place.format, Some(&place.folder))
        }
        Some(Task::Template(arguments)) => array_job::main(arguments),
        None => begin(arguments),
    }
}

/// The plan and the rows in the folder of a sweep's results.
pub(super) fn kept(folder: &Path) -> Result<(SweepPlan, KeptRows), Error> {
    files::recover(folder);
    let plan = report::read_plan(folder).map_err(|why| {
        let mut problems = Problems::new(folder.display().to_string());
        problems.add("study.json", why, "the folder of a sweep's results");
        problems
    })?;
    let kept = KeptRows::read(folder, &plan);
    Ok((plan, kept))
}

fn tell(result: &SweepResult, format: Format, merged: Option<&Path>) -> Result<(), Error> {
    match format {
        Format::Json => print(&json(result)),
        Format::Text => {
            say(&report::words(result))?;
            merged.map_or(Ok(()), |out| say(&format!("Results: {}", report::table(out).display())))
        }
    }
}

fn begin(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let limits = arguments.reading.limits()?;
    let sweep = Sweep::load(arguments.study.as_deref().unwrap_or_default(), limits)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join(sweep.name()));
    if let Some(member) = arguments.member {
        return watch(&sweep, member, &out);
    }
    let shard = arguments.shard.unwrap_or(Shard::ALL);
    let (plan, done) = run_in(&sweep, |member| shard.has(member), &out)?;
    stage("writing");
    let kept = KeptRows::read(&out, &plan);
    let is_whole = kept.rows.len() as u64 == plan.members;
    if arguments.shard.is_none() && is_whole {
        let result = report::merge(&out, &plan, &kept)?;
        tell(&result, arguments.format, Some(&out))?;
        return any_finished(&result);
    }
    tell(&SweepResult::of(&plan, &kept), arguments.format, None)?;
    remark(&format!("{done} members more; when all are finished: tumblenet sweep merge {}", out.display()));
    Ok(())
}

/// Runs what has no row yet in the folder `out` of the members that are wanted: the plan, and how many that were.
pub(super) fn run_in(
    sweep: &Sweep,
    is_wanted: impl Fn(u64) -> bool,
    out: &Path,
) -> Result<(SweepPlan, usize), Error> {
    let plan = sweep.plan(fingerprint()?);
    report::write_plan(out, &plan)?;
    let keeper = Arc::new(RowKeeper::open(out, &plan)?);
    let done = go_on(sweep, &plan, &keeper, is_wanted, out)?;
    Ok((plan, done))
}

/// Runs the wanted members that have no row yet, and says how many.
fn go_on(
    sweep: &Sweep,
    plan: &SweepPlan,
    keeper: &Arc<RowKeeper>,
    is_wanted: impl Fn(u64) -> bool,
    out: &Path,
) -> Result<usize, Error> {
    let kept = KeptRows::read(out, plan);
    for path in &kept.damaged {
        remark(&format!("warning: {} is damaged, its members run again", path.display()));
    }
    let missing: Vec<u64> = kept.missing(plan).into_iter().filter(|member| is_wanted(*member)).collect();
    let n_missing = missing.len();
    let place = out.display();
    interrupt::leaves(format!("finished members are kept in {place}; the same command goes on from them"));
    let unsaved = Arc::clone(keeper);
    // A fault would be told by the next command, as missing rows.
    interrupt::saves(move || drop(unsaved.close()));
    stage("running the members");
    let ends: Vec<bool> = kept.rows.values().filter_map(|row| row.captured).collect();
    let counts = Mutex::new((ends.iter().filter(|is_captured| **is_captured).count(), ends.len()));
    let bar = Progress::new((kept.rows.len() + n_missing) as u64, sweep.name());
    bar.set(kept.rows.len() as u64);
    sweep.run_all(missing, |row: Row| {
        keeper.keep(&row);
        let mut counts = counts.lock().unwrap_or_else(PoisonError::into_inner);
        counts.0 += usize::from(row.captured == Some(true));
        counts.1 += usize::from(row.captured.is_some());
        let (captured, of) = *counts;
        if of > 0 {
            bar.name(format!(
                "{}, {}",
                sweep.name(),
                report::share_words("captured", &Share::of(captured, of))
            ));
        }
        bar.one_more();
    });
    drop(bar);
    keeper.close()?;
    Ok(n_missing)
}

/// Runs one member and writes all its results.
fn watch(sweep: &Sweep, member: u64, out: &Path) -> Result<(), Error> {
    if member >= sweep.n_members() {
        let mut problems = Problems::new("--member");
        problems.add("", member, format!("a number below {}, the members of this study", sweep.n_members()));
        return Err(problems.into());
    }
    let out = out.join(format!("member-{member}"));
    let summary = run::one(&sweep.member(member)?, sweep.at_most_s(), &out, &[])?;
    say(&table::summary(&summary))?;
    say(&format!("Results: {}", out.display()))
}

/// A sweep of which no member was finished is a failed one.
fn any_finished(result: &SweepResult) -> Result<(), Error> {
    if result.failed < result.members {
        return Ok(());
    }
    Err(Error::Expectation("every member failed: the column `failure` of the table says why".to_owned()))
}
