//! `tumblenet map`: the probability of capture, or of another outcome, over inputs of a sweep.

use std::path::PathBuf;

use clap::Args;
use tumblenet::report::map::{self as report, MapRequest};
use tumblenet::study::sweep::outcome::MapOutcome;

use super::terminal::stage;
use super::{Error, Format, json, print, say, sweep};

/// Arguments of `map`.
#[derive(Args)]
pub struct Arguments {
    /// Folder of a sweep's results; all rows that are there count.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// One to four columns of its table; more than two are drawn in slices.
    #[arg(long, value_name = "A,B", value_delimiter = ',', required = true)]
    over: Vec<String>,
    /// The probability of what: captured at a run's end, settled, or held@T, first held by then and not lost until the
    /// time T [s].
    #[arg(long, value_name = "WHAT", default_value = "captured")]
    outcome: MapOutcome,
    /// Boxes along each input, for the raw shares; left out: 6, or 3 of more than two inputs.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=100))]
    boxes: Option<u16>,
    /// Folder for the map; left out: that of the sweep.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Draws the map of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading the rows and fitting");
    let n_boxes = arguments.boxes.unwrap_or(if arguments.over.len() > 2 { 3 } else { 6 }).into();
    let request = MapRequest { over: arguments.over.clone(), outcome: arguments.outcome, n_boxes };
    let (plan, mut kept) = sweep::kept(&arguments.folder)?;
    let (map, samples) = request.fill(&plan, &mut kept)?;
    stage("writing");
    let out = arguments.out.as_ref().unwrap_or(&arguments.folder);
    report::write(out, &map, &samples, n_boxes, plan.study.seed)?;
    match arguments.format {
        Format::Json => print(&json(&map)),
        Format::Text => {
            say(&format!("{}\n{}", map.title, report::words(&map)))?;
            say(&format!("Results: {}", out.join("map.html").display()))
        }
    }
}
