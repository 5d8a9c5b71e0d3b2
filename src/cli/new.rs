//! `tumblenet new`: a scene to begin with.

use std::path::PathBuf;

use clap::Args;
use tumblenet::problems::Problems;
use tumblenet::report::files;

use super::{Error, say};

/// The scene that is written; its notes explain it.
const SCENE: &str = include_str!("new-scene.json");

/// Arguments of `new`.
#[derive(Args)]
pub struct Arguments {
    /// The file to write; one that is there stays as it is.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

/// Writes the scene.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    let file = &arguments.file;
    // Asked first: in a folder that cannot be written to, a name that is taken is the fault to tell.
    if file.exists() || !files::write_new(file, SCENE.as_bytes())? {
        let mut problems = Problems::new(file.display().to_string());
        problems.add("", "a file that is there already", "a name that is free: nothing is overwritten");
        return Err(problems.into());
    }
    let name = file.display();
    say(&format!(
        "Wrote {name}, a capture with notes on what may be changed. Next:\n  tumblenet check {name}\n  tumblenet run {name}"
    ))
}
