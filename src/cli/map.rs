//! `tumblenet map`: the probability of capture, or of another outcome, over inputs of a sweep.

use clap::Args;
use tumblenet::report::map::{self as report, MapRequest};
use tumblenet::study::sweep::outcome::MapOutcome;

use super::Error;
use super::reported::Reported;

/// Arguments of `map`.
#[derive(Args)]
pub struct Arguments {
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
    #[command(flatten)]
    reported: Reported,
}

/// Draws the map of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let n_boxes = arguments.boxes.unwrap_or(if arguments.over.len() > 2 { 3 } else { 6 }).into();
    let request = MapRequest { over: arguments.over.clone(), outcome: arguments.outcome, n_boxes };
    let (plan, kept) = arguments.reported.rows()?;
    let (map, samples) = request.fill(&plan, &kept)?;
    report::write(arguments.reported.out(), &map, &samples, n_boxes, plan.study.seed)?;
    arguments.reported.tell(&map, &format!("{}\n{}", map.title, report::words(&map)), "map.html")
}
