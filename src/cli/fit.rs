//! `tumblenet fit`: which parameters make a scene meet measured tracks.

use std::path::{Path, PathBuf};

use clap::Args;
use tumblenet::report::files;
use tumblenet::report::fit as report;
use tumblenet::study::experiment::checked::FitStudy;

use super::reading::Reading;
use super::reported::Told;
use super::terminal::{Progress, stage};
use super::{Error, interrupt};

/// Arguments of `fit`.
#[derive(Args)]
pub struct Arguments {
    /// Fit file: its keys are those of `schema fit`.
    #[arg(value_name = "FIT")]
    study: String,
    #[command(flatten)]
    reading: Reading,
    /// Folder for the result; left out: results/NAME.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    told: Told,
}

/// Runs the fit of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let limits = arguments.reading.limits()?;
    let study = FitStudy::load(&arguments.study, limits)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join(study.name()));
    // Before the flights, not after: an unwritable folder should cost none.
    files::make_folder(&out)?;
    interrupt::leaves("nothing of this fit was written");
    stage("flying");
    let bar = Progress::new(study.spec.most_flights, study.name());
    let fit = study
        .find(&|| bar.one_more())
        .map_err(|why| Error::Expectation(format!("{}: {why}", study.name())))?;
    drop(bar);
    stage("writing");
    report::write(&out, &fit)?;
    arguments.told.tell(&fit, &report::text(&fit), &out.join("fit.html"))
}
