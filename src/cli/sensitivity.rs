//! `tumblenet sensitivity`: which input of a sweep of the design `saltelli` the spread of its numbers comes from.

use clap::Args;
use tumblenet::report::sensitivity as report;
use tumblenet::study::sweep::outcome::MapOutcome;

use super::Error;
use super::reported::Reported;

/// Arguments of `sensitivity`.
#[derive(Args)]
pub struct Arguments {
    /// What is asked of members first: captured at a run's end, settled, or held@T, first held by then and not lost
    /// until the time T [s].
    #[arg(long, value_name = "WHAT", default_value = "captured")]
    outcome: MapOutcome,
    #[command(flatten)]
    reported: Reported,
}

/// Finds what matters in the sweep of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let (plan, kept) = arguments.reported.rows()?;
    let sensitivity = report::find(&plan, &kept, arguments.outcome)?;
    report::write(arguments.reported.out(), &sensitivity, plan.study.seed)?;
    arguments.reported.tell(&sensitivity, &report::text(&sensitivity), "sensitivity.html")
}
