//! `tumblenet check`: reads and checks, runs nothing.

use clap::Args;
use tumblenet::case::Case;
use tumblenet::metrics::warnings;
use tumblenet::problems::{Problems, visible};

use super::reading::Reading;
use super::terminal::{remark, stage};
use super::{Error, say, tell};

/// Arguments of `check`.
#[derive(Args)]
pub struct Arguments {
    /// Scene files, or names of built-in scenes.
    #[arg(required = true)]
    scenes: Vec<String>,
    /// Changes a value of each scene first: `solver.step_s=0.0005`, `target.spin_rad_s.0=2`; `null` removes a key.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    changes: Vec<String>,
    #[command(flatten)]
    reading: Reading,
}

/// Checks every scene and reports all faults of all of them.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let limits = arguments.reading.limits()?;
    let mut bad: Vec<Problems> = Vec::new();
    for scene in &arguments.scenes {
        match Case::load_within(scene, &arguments.changes, limits) {
            Ok(case) => {
                say(&format!("{scene}: ok, {}", visible(&case.scene().title, false)))?;
                for warning in warnings::before(&case) {
                    remark(&format!("warning: {scene}: {warning}"));
                }
            }
            Err(problems) => bad.push(problems),
        }
    }
    let Some(last) = bad.pop() else { return Ok(()) };
    for problems in bad {
        tell(&format!("error: {problems}"));
    }
    Err(last.into())
}
