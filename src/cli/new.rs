//! `tumblenet new`: a scene to begin with.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use tumblenet::problems::Problems;
use tumblenet::report::files::WriteError;

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
    if file.exists() {
        return Err(taken(file).into());
    }
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let cannot = |error: std::io::Error| WriteError::new(file, error);
    let mut beside = tempfile::NamedTempFile::new_in(folder).map_err(cannot)?;
    beside.write_all(SCENE.as_bytes()).map_err(cannot)?;
    readable_by_all(beside.as_file()).map_err(cannot)?;
    match beside.persist_noclobber(file) {
        Ok(_) => {}
        Err(error) if error.error.kind() == std::io::ErrorKind::AlreadyExists => {
            return Err(taken(file).into());
        }
        Err(error) => return Err(cannot(error.error).into()),
    }
    let name = file.display();
    say(&format!(
        "Wrote {name}, a capture with notes on what may be changed. Next:\n  tumblenet check {name}\n  tumblenet run {name}"
    ))
}

fn taken(file: &Path) -> Problems {
    let mut problems = Problems::new(file.display().to_string());
    problems.add("", "a file that is there already", "a name that is free: nothing is overwritten");
    problems
}

#[cfg(unix)]
fn readable_by_all(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable_by_all(_file: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}
