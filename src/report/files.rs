//! Result files appear whole or not at all, and those that belong together as a set.
//!
//! Each is written beside its place under a name that begins with `.unfinished-`, then renamed. Of a set the
//! last file says that the rest is there: the old one goes before the first of the others is renamed, the new
//! one comes after the last. What is to be renamed is first written down, whole, in the file `.switching`: a program
//! that is killed before has changed nothing, and what one that is killed after leaves to be done is done by the next
//! that begins to write or read there. Two programs that write to one folder wait for each other while they rename,
//! by a lock on the folder, and who writes holds a lock on each unfinished file: one without has been left by
//! a program that was killed, and goes when the next begins to write there. Where the system locks no folders
//! the rest holds without.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use crate::limits;

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

/// Name of the file that says what of a set is to be renamed.
const SWITCHING: &str = ".switching";

/// Most bytes of that file; those of the largest sets have some hundred.
const MOST_SWITCHING: u64 = 1 << 20;

/// The change from one set to the next, by names within their folder.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Switch {
    /// Files of the set before that the new one does not have.
    gone: Vec<String>,
    /// Unfinished files and the names that they are to have, the last one last.
    renamed: Vec<(String, String)>,
}

impl Switch {
    /// The one that was begun in `folder`, if there is one.
    fn begun(folder: &Path) -> Option<Switch> {
        let bytes = limits::read_file(&folder.join(SWITCHING), MOST_SWITCHING).ok()?;
        let switch: Switch = serde_json::from_slice(&bytes).ok()?;
        // Written by somebody else: no file but one of this folder is touched, and none in the place of another kind.
        let plain = |name: &String| Path::new(name).file_name().is_some_and(|own| own == name.as_str());
        let ours =
            switch.renamed.iter().all(|(from, to)| from.starts_with(UNFINISHED) && plain(from) && plain(to));
        (ours && switch.gone.iter().all(plain)).then_some(switch)
    }

    /// Does what is left to be done of it. `folder` is locked.
    fn finish(&self, folder: &Path) -> Result<(), WriteError> {
        let Some((last_from, last)) = self.renamed.last() else { return Ok(()) };
        // Once the last file is there, all is done but to forget it.
        if folder.join(last_from).exists() {
            for name in self.gone.iter().chain([last]) {
                remove(&folder.join(name))?;
            }
            for (from, to) in &self.renamed {
                let to = folder.join(to);
                match std::fs::rename(folder.join(from), &to) {
                    Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                        return Err(WriteError::new(&to, error));
                    }
                    // Done before.
                    _ => {}
                }
            }
        }
        remove(&folder.join(SWITCHING))
    }
}

/// Removes a file that may not be there.
fn remove(path: &Path) -> Result<(), WriteError> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(WriteError::new(path, error)),
        _ => Ok(()),
    }
}

/// Ends what a program that was killed had begun to rename in `folder`: for who only reads there. What cannot be
/// ended, where nothing may be written say, stays as it is.
pub fn recover(folder: &Path) {
    if folder.join(SWITCHING).exists()
        && let Some(_alone) = lock(folder)
        && let Some(switch) = Switch::begun(folder)
    {
        switch.finish(folder).ok();
    }
}

/// Makes the folder `path` and those above it, ends what a killed program had begun to rename in it, and removes what
/// one left unfinished.
///
/// # Errors
/// It cannot be made, or is a file.
pub fn make_folder(path: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(path).map_err(|error| WriteError::new(path, error))?;
    if let Some(_alone) = lock(path)
        && Switch::begun(path).is_none_or(|switch| switch.finish(path).is_ok())
    {
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
    gone: Vec<PathBuf>,
    /// After the files: they are gone before somebody may end the program.
    _writing: RwLockReadGuard<'static, ()>,
}

impl Together {
    /// None yet.
    pub fn begin() -> Together {
        Together { written: Vec::new(), gone: Vec::new(), _writing: writing() }
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

    /// The set has no file `path`, which an earlier one may have had.
    pub fn without(&mut self, path: &Path) {
        self.gone.push(path.to_owned());
    }

    /// Renames all files to their places, in the order they were written.
    ///
    /// # Errors
    /// A file cannot be renamed. Where a folder is in the place of one, all old ones are as they were.
    pub fn appear(mut self) -> Result<(), WriteError> {
        let Some((_, last)) = self.written.last() else { return Ok(()) };
        let folder = folder_of(last).to_owned();
        let place = folder.join(SWITCHING);
        let is_set = self.written.len() > 1 || !self.gone.is_empty();
        let switch = self.as_switch();
        let told = is_set.then(|| beside(&place, |file| serde_json::to_writer(file, &switch))).transpose()?;

        let _alone = lock(&folder);
        if let Some(switch) = Switch::begun(&folder) {
            switch.finish(&folder)?;
        }
        self.written.iter().map(|(_, path)| path).chain(&self.gone).try_for_each(|path| is_free(path))?;
        let Some(told) = told else {
            return self.written.drain(..).try_for_each(|(file, path)| put(file, &path));
        };
        put(told, &place)?;
        // From here on the files are the switch's: whoever is killed, or cannot go on, leaves them to the next.
        for (file, path) in self.written.drain(..) {
            file.keep().map_err(|error| WriteError::new(&path, error.error))?;
        }
        switch.finish(&folder)
    }

    fn as_switch(&self) -> Switch {
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Switch {
            gone: self.gone.iter().map(|path| name(path)).collect(),
            renamed: self.written.iter().map(|(file, path)| (name(file.path()), name(path))).collect(),
        }
    }
}

fn put(file: NamedTempFile, path: &Path) -> Result<(), WriteError> {
    file.persist(path).map(drop).map_err(|error| WriteError::new(path, error.error))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes what is to become the file `path`, which must not be there yet; whether it was free.
///
/// # Errors
/// The file cannot be written.
pub fn write_new(path: &Path, bytes: &[u8]) -> Result<bool, WriteError> {
    let _writing = writing();
    match beside(path, |file| file.write_all(bytes))?.persist_noclobber(path) {
        Ok(_) => Ok(true),
        Err(error) if error.error.kind() == std::io::ErrorKind::AlreadyExists => Ok(false),
        Err(error) => Err(WriteError::new(path, error.error)),
    }
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

    /// A set of two files and no third, half of it renamed: after `n_done` of the renames, or before them.
    fn killed_after(n_done: usize) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["one", "last", "figure"] {
            std::fs::write(at(name), "old").unwrap();
        }
        let renamed =
            [(".unfinished-1", "one"), (".unfinished-2", "last")].map(|(a, b)| (a.into(), b.into()));
        let switch = Switch { gone: vec!["figure".into()], renamed: renamed.into() };
        std::fs::write(at(SWITCHING), serde_json::to_vec(&switch).unwrap()).unwrap();
        for (from, _) in &switch.renamed {
            std::fs::write(at(from), "new").unwrap();
        }
        if n_done > 0 {
            ["figure", "last"].iter().for_each(|name| std::fs::remove_file(at(name)).unwrap());
        }
        for (from, to) in &switch.renamed[..n_done] {
            std::fs::rename(at(from), at(to)).unwrap();
        }
        folder
    }

    #[cfg(unix)]
    #[test]
    fn a_kill_between_the_renames_leaves_no_set_without_its_last_file() {
        for n_done in 0..=2 {
            for ends in [recover as fn(&Path), |folder| make_folder(folder).unwrap()] {
                let folder = killed_after(n_done);
                ends(folder.path());
                assert_eq!(names(folder.path()), ["last", "one"], "after {n_done} renames");
                for name in ["one", "last"] {
                    assert_eq!(
                        std::fs::read(folder.path().join(name)).unwrap(),
                        b"new",
                        "after {n_done} renames"
                    );
                }
            }
            let folder = killed_after(n_done);
            write(&folder.path().join("other"), |file| file.write_all(b"x")).unwrap();
            assert_eq!(names(folder.path()), ["last", "one", "other"], "by who writes there next");
        }
    }

    #[test]
    fn a_switch_that_is_none_of_ours_touches_nothing() {
        for text in [
            "",
            "{",
            r#"{"gone":["../a"],"renamed":[[".unfinished-1","one"]]}"#,
            r#"{"gone":[],"renamed":[["one","two"]]}"#,
            r#"{"gone":[],"renamed":[[".unfinished-1/../../a","two"]]}"#,
            r#"{"gone":[".."],"renamed":[[".unfinished-1","two"]]}"#,
        ] {
            let folder = tempfile::tempdir().unwrap();
            std::fs::write(folder.path().join(SWITCHING), text).unwrap();
            assert!(Switch::begun(folder.path()).is_none(), "{text}");
        }
    }

    #[test]
    fn a_set_leaves_no_figure_of_the_one_before() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("figure"), "old").unwrap();
        let mut files = Together::begin();
        files.without(&at("figure"));
        files.without(&at("never"));
        files.write(&at("last"), |file| file.write_all(b"new")).unwrap();
        files.appear().unwrap();
        assert_eq!(names(folder.path()), ["last"]);
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
