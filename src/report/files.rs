//! Result files appear whole or not at all, and those that belong together as a set.
//!
//! Each is written beside its place under a name that begins with `.unfinished-`, then renamed. Of a set the
//! last file says that the rest is there: the old one goes before the first of the others is renamed, the new
//! one comes after the last. Two programs that write to one folder wait for each other while they rename,
//! by a lock on the folder, and who writes holds a lock on each unfinished file: one without has been left by
//! a program that was killed, and goes when the next begins to write there. Where the system locks no folders
//! the rest holds without.

use std::fs::File;
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

/// How the name of a file begins that is being written.
const UNFINISHED: &str = ".unfinished-";

/// Makes the folder `path` and those above it, and removes from it what a killed program left unfinished.
///
/// # Errors
/// It cannot be made, or is a file.
pub fn make_folder(path: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(path).map_err(|error| WriteError::new(path, error))?;
    if let Some(_alone) = lock(path) {
        remove_stale(path);
    }
    Ok(())
}

/// Says whether a file can take its place at `path`: no folder has it.
///
/// # Errors
/// A folder is there.
pub fn is_free(path: &Path) -> Result<(), WriteError> {
    match path.is_dir() {
        true => Err(WriteError::new(path, "a folder has that name")),
        false => Ok(()),
    }
}

/// Locks a folder against other programs until what is returned is dropped; none where that is not possible.
fn lock(folder: &Path) -> Option<File> {
    let folder = File::open(folder).ok()?;
    folder.lock().ok()?;
    Some(folder)
}

/// Removes unfinished files that nobody writes any more. The folder is locked: none has just been made.
fn remove_stale(folder: &Path) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(UNFINISHED)) {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok()) {
            // What cannot be removed harms nobody.
            std::fs::remove_file(entry.path()).ok();
        }
    }
}

/// Writes the file `path` through `fill`.
///
/// # Errors
/// Folder or file cannot be written; `path` is then as it was.
pub fn write<E: std::fmt::Display>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>,
) -> Result<(), WriteError> {
    let mut files = Together::begin();
    files.write(path, fill)?;
    files.appear()
}

/// Files of one folder that belong together, the last of which says that the others are there.
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
        fill: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>,
    ) -> Result<(), WriteError> {
        self.written.push((beside(path, fill)?, path.to_owned()));
        Ok(())
    }

    /// Renames all files to their places, in the order they were written.
    ///
    /// # Errors
    /// A file cannot be renamed. Where a folder is in the place of one, all old ones are as they were.
    pub fn appear(self) -> Result<(), WriteError> {
        let Some((_, last)) = self.written.last() else { return Ok(()) };
        let _alone = lock(folder_of(last));
        self.written.iter().try_for_each(|(_, path)| is_free(path))?;
        if self.written.len() > 1 {
            match std::fs::remove_file(last) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(WriteError::new(last, error));
                }
                _ => {}
            }
        }
        for (file, path) in self.written {
            file.persist(&path).map_err(|error| WriteError::new(&path, error.error))?;
        }
        Ok(())
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file beside `path`, filled.
fn beside<E: std::fmt::Display>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>,
) -> Result<NamedTempFile, WriteError> {
    let beside = locked_beside(path).map_err(|error| WriteError::new(path, error))?;
    let mut writer = BufWriter::new(beside.as_file());
    fill(&mut writer).map_err(|error| WriteError::new(path, error))?;
    writer.flush().map_err(|error| WriteError::new(path, error))?;
    drop(writer);
    readable_by_all(beside.as_file()).map_err(|error| WriteError::new(path, error))?;
    Ok(beside)
}

/// An empty unfinished file, locked before anybody can take it for stale.
fn locked_beside(path: &Path) -> std::io::Result<NamedTempFile> {
    let folder = folder_of(path);
    let _alone = lock(folder);
    let file = tempfile::Builder::new().prefix(UNFINISHED).tempfile_in(folder)?;
    // Where there are no locks nobody looks for stale files either.
    file.as_file().try_lock().ok();
    Ok(file)
}

/// A temporary file is its owner's alone; a result is like any other file.
#[cfg(unix)]
fn readable_by_all(file: &File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable_by_all(_file: &File) -> std::io::Result<()> {
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

    /// What is in `folder`, sorted.
    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_in_the_place_of_one_file_leaves_the_whole_old_set() {
        let folder = tempfile::tempdir().unwrap();
        let [one, other, last] = ["one", "other", "last"].map(|name| folder.path().join(name));
        let write_all = |text: &str| {
            let mut files = Together::begin();
            for path in [&one, &other, &last] {
                files.write(path, |file| file.write_all(text.as_bytes()))?;
            }
            files.appear()
        };
        write_all("old").unwrap();
        std::fs::remove_file(&other).unwrap();
        std::fs::create_dir(&other).unwrap();
        assert!(write_all("new").unwrap_err().to_string().contains("other: a folder has that name"));
        assert_eq!(std::fs::read(&one).unwrap(), b"old");
        assert_eq!(std::fs::read(&last).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["last", "one", "other"]);
    }

    #[cfg(unix)]
    #[test]
    fn what_a_killed_program_left_unfinished_goes_and_what_is_being_written_stays() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(".unfinished-killed"), "half").unwrap();
        std::fs::write(folder.path().join(".tmp-of-somebody-else"), "whole").unwrap();
        std::fs::create_dir(folder.path().join(".unfinished-folder")).unwrap();
        let mut files = Together::begin();
        files.write(&folder.path().join("result"), |file| file.write_all(b"new")).unwrap();
        make_folder(folder.path()).unwrap();
        files.appear().unwrap();
        assert_eq!(names(folder.path()), [".tmp-of-somebody-else", ".unfinished-folder", "result"]);
    }

    /// Of a set that two writers write at the same time, one is there at the end: a hundred times.
    #[test]
    fn two_writers_of_one_folder_do_not_mix() {
        let folder = tempfile::tempdir().unwrap();
        let set = |text: String| {
            let mut files = Together::begin();
            for name in ["a", "b", "c", "d"] {
                files.write(&folder.path().join(name), |file| file.write_all(text.as_bytes())).unwrap();
            }
            files.appear().unwrap();
        };
        for round in 0..100 {
            std::thread::scope(|scope| {
                for writer in 0..2 {
                    scope.spawn(move || set(format!("{round} {writer}")));
                }
            });
            let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
            assert!(["b", "c", "d"].iter().all(|name| read(name) == read("a")), "round {round}");
        }
    }
}
