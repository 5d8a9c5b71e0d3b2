//! Result files appear whole or not at all: each is written beside its place, then renamed.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A result that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {reason}")]
pub struct WriteError {
    /// The file or folder.
    pub path: PathBuf,
    /// Why.
    pub reason: String,
}

impl WriteError {
    /// `path` could not be written because of `reason`.
    pub fn new(path: &Path, reason: impl std::fmt::Display) -> Self {
        WriteError { path: path.to_owned(), reason: reason.to_string() }
    }
}

/// Makes the folder `path` and those above it.
///
/// # Errors
/// It cannot be made, or is a file.
pub fn make_folder(path: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(path).map_err(|error| WriteError::new(path, error))
}

/// Writes the file `path` through `fill`.
///
/// # Errors
/// Folder or file cannot be written; `path` is then as it was.
pub fn write<E: std::fmt::Display>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&std::fs::File>) -> Result<(), E>,
) -> Result<(), WriteError> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = tempfile::NamedTempFile::new_in(folder).map_err(|error| WriteError::new(path, error))?;
    let mut writer = BufWriter::new(beside.as_file());
    fill(&mut writer).map_err(|error| WriteError::new(path, error))?;
    writer.flush().map_err(|error| WriteError::new(path, error))?;
    drop(writer);
    readable_by_all(beside.as_file()).map_err(|error| WriteError::new(path, error))?;
    beside.persist(path).map_err(|error| WriteError::new(path, error.error))?;
    Ok(())
}

/// A temporary file is its owner's alone; a result is like any other file.
#[cfg(unix)]
fn readable_by_all(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable_by_all(_file: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result");
        write(&path, |file| file.write_all(b"old")).unwrap();
        let failed = write(&path, |file| {
            file.write_all(b"half")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().contains("disk full"));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing half-written is left");
    }
}
