//! Files that a scene or a shape names.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::problems::Problems;

/// Longest file read; a longer one is a mistake, and reading it would stall the machine.
const MAX_BYTES: u64 = 64 << 20;

/// Bytes and path of the file called `name`, relative to `folder`. A fault at `place` where there
/// is no folder (a built-in input has none) or the file cannot be read.
pub fn read(
    name: &str,
    folder: Option<&Path>,
    place: &str,
    problems: &mut Problems,
) -> Option<(Vec<u8>, PathBuf)> {
    let Some(folder) = folder else {
        problems.add(place, format!("the file {name:?}"), "no files: a built-in input has no folder");
        return None;
    };
    let path = folder.join(name);
    match read_bytes(&path) {
        Ok(bytes) if bytes.len() as u64 <= MAX_BYTES => Some((bytes, path)),
        Ok(_) => {
            problems.add(place, format!("{name:?}, longer than 64 MiB"), "a file of at most 64 MiB");
            None
        }
        Err(error) => {
            let allowed = "a readable file, its path relative to the file that names it";
            problems.add(place, format!("{name:?} ({error})"), allowed);
            None
        }
    }
}

/// Up to one byte more than allowed.
fn read_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    // Opening a pipe would wait for a writer, reading a device might never end.
    if !fs::metadata(path)?.is_file() {
        return Err(std::io::Error::other("not a plain file"));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}
