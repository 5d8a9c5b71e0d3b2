//! `tumblenet dependency`: how strongly results depend on each parameter of a sweep of the design `one-at-a-time`.

use clap::Args;
use tumblenet::report::dependency as report;
use tumblenet::study::sweep::dependency::Dependencies;

use super::Error;
use super::reported::Reported;

/// Arguments of `dependency`.
#[derive(Args)]
pub struct Arguments {
    /// Columns of its table; left out: largest area, deployment time, travelling distance, effective period.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    of: Option<Vec<String>>,
    #[command(flatten)]
    reported: Reported,
}

/// Works out the dependencies of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let (plan, kept) = arguments.reported.rows()?;
    let names = report::names(arguments.of.as_deref());
    let observed = report::observed(&plan, &kept, &names)?;
    let all = Dependencies::of(&plan, &names, &observed)?;
    report::write(arguments.reported.out(), &all, plan.study.seed)?;
    arguments.reported.tell(&all, &report::text(&all), "dependency.html")
}
