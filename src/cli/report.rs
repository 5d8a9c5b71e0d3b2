//! `tumblenet report`: results of many kinds in one page.

use std::path::{Path, PathBuf};

use clap::Args;
use tumblenet::report::collected;

use super::terminal::stage;
use super::{Error, say};

/// Arguments of `report`.
#[derive(Args)]
pub struct Arguments {
    /// Folders of results: runs, ensembles, comparisons, sweeps, maps, cost, hard cases; of a folder without any, the folders in it.
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Title of the page.
    #[arg(long, value_name = "TEXT", default_value = "Results")]
    title: String,
    /// Folder for the page; left out: results/report.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Makes the page.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join("report"));
    stage("reading");
    let parts = collected::collect(&arguments.folders, &out)?;
    stage("writing");
    collected::write(&out, &arguments.title, &parts)?;
    say(&collected::lead(&parts))?;
    say(&format!("Results: {}", out.join("report.html").display()))
}
