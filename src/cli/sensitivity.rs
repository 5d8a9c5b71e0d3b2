//! `tumblenet sensitivity`: which input of a sweep the spread of its numbers comes from.

use std::path::PathBuf;

use clap::Args;
use tumblenet::report::sensitivity as report;
use tumblenet::study::sweep::outcome::MapOutcome;

use super::terminal::stage;
use super::{Error, Format, json, print, say, sweep};

/// Arguments of `sensitivity`.
#[derive(Args)]
pub struct Arguments {
    /// Folder of the results of a sweep of the design `saltelli`; all blocks that are finished count.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// What is asked of members first: captured at a run's end, settled, or held@T, first held by then and not lost
    /// until the time T [s].
    #[arg(long, value_name = "WHAT", default_value = "captured")]
    outcome: MapOutcome,
    /// Folder for the result; left out: that of the sweep.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Finds what matters in the sweep of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading the rows");
    let (plan, mut kept) = sweep::kept(&arguments.folder)?;
    let sensitivity = report::find(&plan, &mut kept, arguments.outcome)?;
    stage("writing");
    let out = arguments.out.as_ref().unwrap_or(&arguments.folder);
    report::write(out, &sensitivity, plan.study.seed)?;
    match arguments.format {
        Format::Json => print(&json(&sensitivity)),
        Format::Text => {
            say(&report::text(&sensitivity))?;
            say(&format!("Results: {}", out.join("sensitivity.html").display()))
        }
    }
}
