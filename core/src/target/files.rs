//! Files that a scene or a shape names.
//!
//! A scene may name files in its own folder and below, and nothing else: neither by an absolute
//! path, nor by `..`, nor through a link that leads out. A scene from elsewhere could otherwise have
//! any file of the user's read. `--allow-outside` lifts this.

use std::borrow::Cow;
use std::cell::Cell;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use crate::limits::{self, Limit, Limits, Unread};
use crate::problems::Problems;

/// Where the files that an input names are, and what may be read of them.
#[derive(Clone, Debug)]
pub struct Files<'a> {
    /// Folder of the scene; none for one that is no file.
    root: Option<&'a Path>,
    /// Folder of the file that names others.
    folder: Option<Cow<'a, Path>>,
    /// How much may be read.
    pub limits: &'a Limits,
    /// How much of it all meshes have taken so far.
    pub spent: Rc<Spent>,
}

/// What the meshes of a scene have taken so far.
#[derive(Debug, Default)]
pub struct Spent {
    /// Bytes of their files.
    pub bytes: Cell<u64>,
    /// Their triangles.
    pub triangles: Cell<u64>,
    /// Those that were split into convex parts.
    pub splits: Cell<u64>,
}

impl<'a> Files<'a> {
    /// Files of a scene in `folder`, if it is a file.
    pub fn of(folder: Option<&'a Path>, limits: &'a Limits) -> Files<'a> {
        Files { root: folder, folder: folder.map(Cow::Borrowed), limits, spent: Rc::default() }
    }

    /// Files that are named by the file `path`; none by one that is built in.
    pub fn named_by(&self, path: Option<&Path>) -> Files<'a> {
        let folder = path.and_then(Path::parent).map(|folder| Cow::Owned(folder.to_path_buf()));
        Files { folder, ..self.clone() }
    }

    /// Bytes and path of the file called `name`, at most as many as `limit` allows. A fault at
    /// `place` where there is no folder (a built-in input has none), the file lies outside of the
    /// scene's folder, or it cannot be read.
    pub fn read(
        &self,
        name: &str,
        limit: Limit,
        place: &str,
        problems: &mut Problems,
    ) -> Option<(Vec<u8>, PathBuf)> {
        let (Some(root), Some(folder)) = (self.root, &self.folder) else {
            problems.add(place, format!("the file {name:?}"), "no files: a built-in input has no folder");
            return None;
        };
        let path = folder.join(name);
        // By its name first: whether a file outside is there is nobody's business either.
        if !self.limits.allow_outside && (leaves(root, &path) || leads_out(root, &path)) {
            let found = format!("{name:?}, outside of the scene's folder");
            problems.add(place, found, "a file in that folder or below (--allow-outside lifts this)");
            return None;
        }
        let before = if limit == Limit::Mesh { self.spent.bytes.get() } else { 0 };
        match limits::read_file(&path, self.limits.of(limit).saturating_sub(before)) {
            Ok(bytes) => {
                self.spent.bytes.set(before + bytes.len() as u64);
                Some((bytes, path))
            }
            Err(Unread::TooLong(length)) => {
                problems.add(
                    place,
                    format!("{name:?} of {length} bytes{}", after(before)),
                    self.limits.allowed(limit),
                );
                None
            }
            Err(error) => {
                let allowed = "a readable file, its path relative to the file that names it";
                problems.add(place, format!("{name:?} ({error})"), allowed);
                None
            }
        }
    }
}

/// What others have taken before, for a fault.
pub(super) fn after(before: u64) -> String {
    if before == 0 { String::new() } else { format!(", after {before} of others") }
}

/// Whether the words of `path` lead out of `root`, which it starts with unless it is absolute.
fn leaves(root: &Path, path: &Path) -> bool {
    let Ok(below) = path.strip_prefix(root) else { return true };
    let mut depth = 0_i64;
    below.components().any(|component| {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth -= 1,
            Component::RootDir | Component::Prefix(_) => return true,
        }
        depth < 0
    })
}

/// Whether links lead `path` out of `root`; a file that is not there leads nowhere.
fn leads_out(root: &Path, path: &Path) -> bool {
    let here = if root.as_os_str().is_empty() { Path::new(".") } else { root };
    match (here.canonicalize(), path.canonicalize()) {
        (Ok(root), Ok(path)) => !path.starts_with(root),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn read(root: &Path, name: &str, limits: &Limits) -> Result<Vec<u8>, String> {
        let mut problems = Problems::new("test");
        let read = Files::of(Some(root), limits).read(name, Limit::Mesh, "file", &mut problems);
        read.map(|(bytes, _)| bytes).ok_or_else(|| problems.to_string())
    }

    #[test]
    fn a_scene_reads_no_file_outside_of_its_folder() {
        let above = tempfile::tempdir().unwrap();
        let root = above.path().join("scene");
        fs::create_dir_all(root.join("below")).unwrap();
        fs::write(above.path().join("secret"), "s").unwrap();
        fs::write(root.join("below/shape"), "b").unwrap();
        let absolute = above.path().join("secret").to_string_lossy().into_owned();
        let limits = Limits::default();
        let outside = ["../secret", "below/../../secret", "../nowhere", "/etc/passwd", &absolute];
        for name in outside {
            let fault = read(&root, name, &limits).unwrap_err();
            assert!(fault.contains("outside of the scene's folder"), "{name}: {fault}");
        }
        let inside = root.join("below/shape").to_string_lossy().into_owned();
        for name in ["below/shape", "below/../below/./shape", &inside] {
            assert_eq!(read(&root, name, &limits).unwrap(), b"b", "{name}");
        }
        let allowing = limits.allowing_outside(true);
        assert_eq!(read(&root, "../secret", &allowing).unwrap(), b"s");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_does_not_lead_out_of_the_folder() {
        let above = tempfile::tempdir().unwrap();
        let root = above.path().join("scene");
        fs::create_dir(&root).unwrap();
        fs::write(above.path().join("secret"), "s").unwrap();
        std::os::unix::fs::symlink("../secret", root.join("file")).unwrap();
        std::os::unix::fs::symlink("..", root.join("folder")).unwrap();
        for name in ["file", "folder/secret"] {
            let fault = read(&root, name, &Limits::default()).unwrap_err();
            assert!(fault.contains("outside of the scene's folder"), "{name}: {fault}");
        }
    }

    #[test]
    fn a_shape_below_may_name_what_lies_above_it_in_the_scenes_folder() {
        let root = tempfile::tempdir().unwrap();
        fs::create_dir(root.path().join("shapes")).unwrap();
        fs::write(root.path().join("body.obj"), "o").unwrap();
        let (limits, mut problems) = (Limits::default(), Problems::new("test"));
        let shape = root.path().join("shapes/mine.json");
        let files = Files::of(Some(root.path()), &limits).named_by(Some(&shape));
        assert!(files.read("../body.obj", Limit::Mesh, "file", &mut problems).is_some(), "{problems}");
        assert!(files.read("../../body.obj", Limit::Mesh, "file", &mut problems).is_none());
    }
}
