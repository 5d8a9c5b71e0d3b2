//! Result files appear whole or not at all: each is written beside its place, then renamed.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use tempfile::NamedTempFile;

/// Held for reading while a file is written, for writing by who ends the program.
static WRITING: RwLock<()> = RwLock::new(());

/// Waits until no file is being written; none begins to be while what is returned is held.
pub fn when_idle() -> RwLockWriteGuard<'static, ()> {
    WRITING.write().unwrap_or_else(PoisonError::into_inner)
}

fn writing() -> RwLockReadGuard<'static, ()> {
    WRITING.read().unwrap_or_else(PoisonError::into_inner)
}

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
    let mut files = Together::begin();
    files.write(path, fill)?;
    files.appear()
}

/// Files that belong together: written beside their places, then renamed one right after the other.
/// What fails or is dropped before leaves the old ones as they were.
pub struct Together {
    written: Vec<(NamedTempFile, PathBuf)>,
    /// After the files: they are gone before somebody may end the program.
    _writing: RwLockReadGuard<'static, ()>,
}

impl Together {
    /// None yet.
    pub fn begin() -> Together {
        Together { written: Vec::new(), _writing: writing() }
    }

    /// Writes what is to become the file `path` through `fill`.
    ///
    /// # Errors
    /// Folder or file cannot be written.
    pub fn write<E: std::fmt::Display>(
        &mut self,
        path: &Path,
        fill: impl FnOnce(&mut BufWriter<&std::fs::File>) -> Result<(), E>,
    ) -> Result<(), WriteError> {
        self.written.push((beside(path, fill)?, path.to_owned()));
        Ok(())
    }

    /// Renames all files to their places, in the order they were written.
    ///
    /// # Errors
    /// A file cannot be renamed.
    pub fn appear(self) -> Result<(), WriteError> {
        for (file, path) in self.written {
            file.persist(&path).map_err(|error| WriteError::new(&path, error.error))?;
        }
        Ok(())
    }
}

/// A file beside `path`, filled.
fn beside<E: std::fmt::Display>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&std::fs::File>) -> Result<(), E>,
) -> Result<NamedTempFile, WriteError> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = NamedTempFile::new_in(folder).map_err(|error| WriteError::new(path, error))?;
    let mut writer = BufWriter::new(beside.as_file());
    fill(&mut writer).map_err(|error| WriteError::new(path, error))?;
    writer.flush().map_err(|error| WriteError::new(path, error))?;
    drop(writer);
    readable_by_all(beside.as_file()).map_err(|error| WriteError::new(path, error))?;
    Ok(beside)
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
