//! `tumblenet cost`: what accuracy costs in time.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::Args;
use serde::Serialize;
use serde::de::DeserializeOwned;
use tumblenet::case::Case;
use tumblenet::report::cost as report;
use tumblenet::report::files::{self, WriteError};
use tumblenet::scene::Source;
use tumblenet::study::cost::{self, Store, StudyRequest};
use tumblenet::study::ensemble;

use super::members::Kept;
use super::reading::{Reading, time};
use super::run::duration;
use super::terminal::{Progress, stage};
use super::{Error, Format, json, print, say};

/// Arguments of `cost`.
#[derive(Args)]
pub struct Arguments {
    /// Scene file, or name of a built-in scene.
    scene: String,
    /// What the study may spend: `90s`, `5min` of processor time of a quiet core, counted in work, so that a busy
    /// machine measures the same and takes longer.
    #[arg(long, value_name = "TIME", default_value = "90s", value_parser = budget)]
    budget: f64,
    /// Time up to which errors are quoted [s]; left out: as far as chaos lets them mean something.
    #[arg(long, allow_hyphen_values = true, value_name = "SECONDS", value_parser = duration)]
    at: Option<f64>,
    /// Changes a value of the scene first, as `run` does.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    changes: Vec<String>,
    #[command(flatten)]
    reading: Reading,
    /// Seed of the perturbations.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Folder for the results; left out: results/NAME/cost.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// A time with its unit [s].
fn budget(text: &str) -> Result<f64, String> {
    let parsed = time(text).ok().map(|time| time.as_secs_f64());
    match parsed {
        Some(seconds) if (1.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("a time of at least 1 s, as in 60s, 5min or 1h".to_owned()),
    }
}

/// Runs the study and writes its report.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let mut source = Source::find_within(&arguments.scene, arguments.reading.limits()?)?;
    source.change(&arguments.changes)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join(&source.name).join("cost"));
    // Checked before the folder is made, and the folder before the runs.
    Case::build(&source)?;
    files::make_folder(&out)?;
    let request = StudyRequest { budget_s: arguments.budget, seed: arguments.seed, at_s: arguments.at };
    let folder = Folder { out: &out, seed: arguments.seed, unwritten: Mutex::new(None) };
    stage("measuring");
    let bar = Progress::new(1000, &source.name);
    let study = cost::run(&source, &request, &folder, |what, share| {
        bar.name(format!("{}: {what}", source.name));
        bar.set((1000.0 * share.min(1.0)) as u64);
    })?;
    drop(bar);
    stage("writing");
    folder.finish()?;
    report::write(&out, &study)?;
    match arguments.format {
        Format::Json => print(&json(&study)),
        Format::Text => {
            say(&report::text(&study))?;
            say(&format!("Results: {}", out.join("cost.html").display()))
        }
    }
}

/// The folder where measurements are kept as they end.
struct Folder<'a> {
    out: &'a Path,
    seed: u64,
    unwritten: Mutex<Option<WriteError>>,
}

impl Folder<'_> {
    fn open(&self, case: &Case, kind: &str) -> Result<Kept, WriteError> {
        let request =
            ensemble::EnsembleRequest { members: 0, perturb_m: 0.0, seed: self.seed, at_most_s: None };
        Kept::open(self.out, kind, case, &request)
    }

    fn finish(self) -> Result<(), WriteError> {
        self.unwritten.into_inner().unwrap_or_else(|poison| poison.into_inner()).map_or(Ok(()), Err)
    }
}

impl Store for Folder<'_> {
    fn known<T: DeserializeOwned>(&self, case: &Case, kind: &str, number: usize) -> Option<T> {
        self.open(case, kind).ok()?.one(number)
    }

    fn keep<T: Serialize>(&self, case: &Case, kind: &str, number: usize, value: &T) {
        let kept = self.open(case, kind).and_then(|kept| {
            kept.keep(number, value);
            kept.finish()
        });
        if let Err(error) = kept {
            self.unwritten.lock().unwrap_or_else(|poison| poison.into_inner()).get_or_insert(error);
        }
    }
}
