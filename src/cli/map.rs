//! `tumblenet map`: the probability of capture over inputs of a sweep.

use std::path::PathBuf;

use clap::Args;
use tumblenet::problems::Problems;
use tumblenet::report::map as report;
use tumblenet::study::sweep::map::CaptureMap;

use super::terminal::stage;
use super::{Error, Format, json, print, say, sweep};

/// Arguments of `map`.
#[derive(Args)]
pub struct Arguments {
    /// Folder of a sweep's results; all rows that are there count.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// One or two columns of its table.
    #[arg(long, value_name = "A,B", value_delimiter = ',', required = true)]
    over: Vec<String>,
    /// Boxes along each input, for the raw shares.
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=100))]
    boxes: u16,
    /// Folder for the map; left out: that of the sweep.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Draws the map of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading the rows");
    if arguments.over.len() > 2 {
        let mut problems = Problems::new("--over");
        problems.add("", arguments.over.join(","), "one or two columns");
        return Err(problems.into());
    }
    let (plan, mut kept) = sweep::kept(&arguments.folder)?;
    let samples = report::samples(&plan, &mut kept, &arguments.over)?;
    stage("fitting");
    let map = CaptureMap::of(&plan.title, &arguments.over, &samples, arguments.boxes.into());
    let map = map.ok_or_else(|| {
        Error::Expectation("no regression: the numbers are too large or too small".to_owned())
    })?;
    stage("writing");
    let out = arguments.out.as_ref().unwrap_or(&arguments.folder);
    report::write(out, &map, &samples, plan.study.seed)?;
    match arguments.format {
        Format::Json => print(&json(&map)),
        Format::Text => {
            say(&format!("{}\n{}", map.title, report::words(&map)))?;
            say(&format!("Results: {}", out.join("map.html").display()))
        }
    }
}
