//! What the commands that read a sweep's rows share: its folder, where their result goes, and how it is told.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use tumblenet::report::rows::KeptRows;
use tumblenet::study::sweep::SweepPlan;

use super::terminal::stage;
use super::{Error, Format, json, print, say, sweep};

/// Arguments of all of them.
#[derive(Args)]
pub struct Reported {
    /// Folder of a sweep's results; all rows that are there count.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Folder for the result; left out: that of the sweep.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    told: Told,
}

/// How a result is told.
#[derive(Args)]
pub struct Told {
    /// How the result is printed.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

impl Told {
    /// Prints a result: `value`, or in words `text` and where its `page` is.
    pub fn tell(&self, value: &impl Serialize, text: &str, page: &Path) -> Result<(), Error> {
        match self.format {
            Format::Json => print(&json(value)),
            Format::Text => {
                say(text)?;
                say(&format!("Results: {}", page.display()))
            }
        }
    }
}

impl Reported {
    /// The sweep, and its rows that are there.
    pub fn rows(&self) -> Result<(SweepPlan, KeptRows), Error> {
        stage("reading the rows");
        sweep::kept(&self.folder)
    }

    /// Where the result is written to.
    pub fn out(&self) -> &Path {
        stage("writing");
        self.out.as_deref().unwrap_or(&self.folder)
    }

    /// Prints the result: `value`, or in words `text` and where its `page` is.
    pub fn tell(&self, value: &impl Serialize, text: &str, page: &str) -> Result<(), Error> {
        self.told.tell(value, text, &self.out.as_ref().unwrap_or(&self.folder).join(page))
    }
}
