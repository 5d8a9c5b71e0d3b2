//! `tumblenet dependency`: how strongly results depend on each parameter of a sweep.

use std::path::PathBuf;

use clap::Args;
use tumblenet::report::dependency as report;
use tumblenet::study::sweep::dependency::Dependencies;

use super::terminal::stage;
use super::{Error, Format, json, print, say, sweep};

/// Arguments of `dependency`.
#[derive(Args)]
pub struct Arguments {
    /// Folder of the results of a sweep with the design `one-at-a-time`; all rows that are there count.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Columns of its table; left out: largest area, deployment time, travelling distance, effective period.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    of: Option<Vec<String>>,
    /// Folder for the tables and plots; left out: that of the sweep.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Works out the dependencies of the arguments.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading the rows");
    let (plan, mut kept) = sweep::kept(&arguments.folder)?;
    let names = report::columns(&plan, arguments.of.as_deref())?;
    let observed = report::observed(&plan, &mut kept, &names)?;
    let all = Dependencies::of(&plan, &names, &observed)?;
    stage("writing");
    let out = arguments.out.as_ref().unwrap_or(&arguments.folder);
    report::write(out, &all, plan.study.seed)?;
    match arguments.format {
        Format::Json => print(&json(&all)),
        Format::Text => {
            say(&report::text(&all))?;
            say(&format!("Results: {}", out.join("dependency.html").display()))
        }
    }
}
