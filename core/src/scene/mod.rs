//! A scene: what a user writes, where it is found, and what its parts allow together.
//!
//! `read`: text to [`schema::Scene`], every fault at once. [`checks`]: faults that no single value
//! shows. [`estimate`]: what a run will take.

pub mod checks;
mod clear;
pub mod estimate;
mod repair;
pub mod schema;

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::assets::Kind;
use crate::json;
use crate::limits::{self, Limit, Limits, Unread};
use crate::parameter::Own;
use crate::problems::{Problems, visible};
use crate::read;
use crate::spelling;
use schema::Scene;

/// The scene that runs when no other is named.
pub const DEFAULT: &str = "cubesat-spin-x-2.0-tube-settled";

/// A scene as found: its name, its JSON, and the folder its paths are relative to.
#[derive(Clone, Debug)]
pub struct Source {
    /// Name for results and messages: the file's name without its ending.
    pub name: String,
    /// What was read, as a file or built-in, for error messages.
    pub input: String,
    /// Folder of the file; a built-in scene has none.
    pub folder: Option<PathBuf>,
    /// Its JSON, before it is checked.
    pub json: Value,
    /// How much it may ask for.
    pub limits: Limits,
}

impl Source {
    /// Finds `scene`: the name of a built-in one, or a file.
    ///
    /// # Errors
    /// Faults that name the input: no such file or name, unreadable, no JSON.
    pub fn find(scene: &str) -> Result<Source, Problems> {
        Source::find_within(scene, Limits::default())
    }

    /// The same, with other limits.
    ///
    /// # Errors
    /// As [`Source::find`].
    pub fn find_within(scene: &str, limits: Limits) -> Result<Source, Problems> {
        let mut problems = Problems::new(scene);
        if let Some(text) = Kind::Scene.text(scene) {
            let json = json::parse(text, "", &mut problems);
            let source = json.map(|json| Source {
                name: scene.to_owned(),
                input: scene.to_owned(),
                folder: None,
                json,
                limits,
            });
            return problems.into_result(source);
        }
        let path = Path::new(scene);
        let known =
            || format!("the path of a scene file, or a built-in scene: {}", Kind::Scene.instead_of(scene));
        let json = read_text(path, &limits, known, &mut problems)
            .and_then(|text| json::parse(&text, "", &mut problems));
        let name = name_of(path);
        let folder = path.parent().map(Path::to_path_buf);
        problems.into_result(json.map(|json| Source { name, input: scene.to_owned(), folder, json, limits }))
    }

    /// The same as [`Source::set`], for a user who makes another scene of this one: what it was expected to show
    /// is then no longer expected, unless the changes say so.
    ///
    /// # Errors
    /// As [`Source::set`].
    pub fn change(&mut self, changes: &[String]) -> Result<(), Problems> {
        if !changes.is_empty()
            && let Some(map) = self.json.as_object_mut()
        {
            map.shift_remove("expect");
        }
        self.set(changes)
    }

    /// Changes values, each given as `path.to.key=value` or `path.0=value` for an entry of a list.
    ///
    /// The value is JSON, or a text where it is not; `null` removes the key. A list that is left out has the
    /// entries of its default.
    ///
    /// # Errors
    /// A fault for every change without `=` and every path that leads nowhere.
    pub fn set(&mut self, changes: &[String]) -> Result<(), Problems> {
        let mut problems = Problems::new(format!("{} --set", self.input));
        for change in changes {
            match change.split_once('=') {
                Some((path, text)) if !path.is_empty() => {
                    let value = serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.to_owned()));
                    self.fill_in(path);
                    if let Err(place) = set_at(&mut self.json, path, value) {
                        problems.add(path, place, "a path of keys and list positions, as in net.meshes.0");
                    }
                }
                _ => problems.add(change.clone(), "no `=`", "PATH=VALUE, as in solver.step_s=0.0005"),
            }
        }
        problems.into_result(Some(()))
    }

    /// Writes out the default of a list that is left out and whose entry `path` is to change, and what stands there
    /// in another way of writing in that of `path`, which replaces it.
    fn fill_in(&mut self, path: &str) {
        if path.split('.').count() > MOST_LEVELS {
            return;
        }
        let (list, is_entry) = match path.rsplit_once('.') {
            Some((list, entry)) if entry.parse::<usize>().is_ok() => (list, true),
            _ => (path, false),
        };
        let (above, key) = list.rsplit_once('.').unwrap_or(("", list));
        if let Some(map) = self.json.pointer_mut(&pointer(above)).and_then(Value::as_object_mut) {
            spelling::respell(map, key);
        }
        if !is_entry || self.json.pointer(&pointer(list)).is_some() {
            return;
        }
        let scene: Option<Scene> = read::typed(&self.json, "", &mut Problems::new(&self.input));
        let filled = scene.map(|scene| scene.written_out());
        let mut section = filled.and_then(|filled| filled.pointer(&pointer(above)).cloned());
        let Some(map) = section.as_mut().and_then(Value::as_object_mut) else { return };
        spelling::respell(map, key);
        if let Some(default) = map.get(key) {
            // A path that leads nowhere is told when it is set.
            set_at(&mut self.json, list, default.clone()).ok();
        }
    }

    /// What stands at `path`, which is in the user's way of writing: rates in degrees, say.
    pub fn own(&self, path: &str) -> Own {
        let mut source = self.clone();
        source.fill_in(path);
        let found = source.json.pointer(&pointer(path)).cloned();
        found.map_or(Own::Nothing, Own::Value)
    }

    /// Reads the JSON as a scene; faults go to `problems`, with those that `check` finds in what can be read
    /// where not all can: it hears whether all that the step is chosen by can.
    pub fn scene(
        &self,
        problems: &mut Problems,
        check: impl FnOnce(Scene, bool, &mut Problems),
    ) -> Option<Scene> {
        let scene = read::typed(&self.json, "", problems);
        // More would not be kept.
        if scene.is_none()
            && !problems.is_full()
            && let Some(repaired) = repair::repaired(&self.json, &problems.list)
        {
            let mut meant = Problems::new(&self.input);
            check(repaired.scene.clone(), repaired.is_stepped_as_written(), &mut meant);
            for problem in meant.list.into_iter().filter(|problem| repaired.is_genuine(&problem.place)) {
                problems.add(problem.place, problem.found, problem.allowed);
            }
        }
        scene
    }
}

/// Name of the scene in the file `path`: the file's without its ending. It becomes that of a folder, which `..`
/// is not (the stem of `...json`).
pub fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    match stem.trim_matches('.') {
        "" => "scene".to_owned(),
        _ => visible(&stem, false).replace('\\', "_"),
    }
}

/// What was read of the input at `place` as text; none where it is no UTF-8, which `problems` then say.
pub fn as_text(bytes: Vec<u8>, place: &str, problems: &mut Problems) -> Option<String> {
    String::from_utf8(bytes)
        .map_err(|error| problems.add(place, format!("no UTF-8 text ({error})"), "JSON in UTF-8"))
        .ok()
}

/// Text of the input file `path`, or none and why in `problems`; what `known` says may stand in its place where there is none.
pub fn read_text(
    path: &Path,
    limits: &Limits,
    known: impl Fn() -> String,
    problems: &mut Problems,
) -> Option<String> {
    match limits::read_file(path, limits.of(Limit::Text)) {
        Ok(bytes) => return as_text(bytes, "", problems),
        Err(Unread::NoFile) => problems.add("", "no file", known()),
        Err(Unread::TooLong(length)) => {
            problems.add("", format!("{length} bytes"), limits.allowed(Limit::Text));
        }
        Err(error) => problems.add("", format!("no readable file ({error})"), known()),
    }
    None
}

/// `target.spin_rad_s.0` as `/target/spin_rad_s/0`.
pub fn pointer(path: &str) -> String {
    match path {
        "" => String::new(),
        _ => format!("/{}", path.replace('.', "/")),
    }
}

/// Most levels of a path: more than any key of a scene has, and few enough to walk through.
const MOST_LEVELS: usize = 64;

/// Sets the value at `path` of `root`, making objects on the way; says where the path ends if it
/// cannot go on.
fn set_at(root: &mut Value, path: &str, value: Value) -> Result<(), String> {
    let depth = path.bytes().filter(|byte| *byte == b'.').count() + 1;
    if depth > MOST_LEVELS {
        return Err(format!("a path of {depth} levels, of at most {MOST_LEVELS}"));
    }
    let (above, last) = path.rsplit_once('.').unwrap_or(("", path));
    let mut place = root;
    for key in above.split('.').filter(|key| !key.is_empty()) {
        place = match place {
            Value::Object(map) => map.entry(key).or_insert_with(|| Value::Object(serde_json::Map::new())),
            Value::Array(list) => {
                let length = list.len();
                let entry = key.parse::<usize>().ok().and_then(|index| list.get_mut(index));
                entry.ok_or_else(|| format!("no entry {key} in a list of {length}"))?
            }
            other => return Err(format!("{other} before .{key}")),
        };
    }
    match place {
        Value::Object(map) if value.is_null() => {
            map.remove(last);
        }
        Value::Object(map) => {
            map.insert(last.to_owned(), value);
        }
        Value::Array(list) => {
            let length = list.len();
            let entry = last.parse::<usize>().ok().and_then(|index| list.get_mut(index));
            *entry.ok_or_else(|| format!("no entry {last} in a list of {length}"))? = value;
        }
        other => return Err(format!("{other} before .{last}")),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn source() -> Source {
        let json = json!({ "net": { "meshes": [2, 3] }, "effects": { "friction": {} } });
        Source { name: "t".into(), input: "t".into(), folder: None, json, limits: Limits::default() }
    }

    #[test]
    fn set_changes_makes_and_removes() {
        let mut source = source();
        let changes = ["net.meshes.1=7", "solver.step_s=1e-4", "effects.friction=null", "title=a = b"];
        source.set(&changes.map(str::to_owned)).unwrap();
        assert_eq!(
            source.json,
            json!({ "net": { "meshes": [2, 7] }, "effects": {}, "solver": { "step_s": 1e-4 }, "title": "a = b" })
        );
    }

    #[test]
    fn an_entry_of_a_list_that_is_left_out_changes_its_default() {
        let mut source = Source::find("cubesat-free").unwrap();
        source.json["target"].as_object_mut().unwrap().remove("spin_rad_s");
        source.set(&["target.spin_rad_s.0=2".to_owned()]).unwrap();
        assert_eq!(source.json["target"]["spin_rad_s"], json!([2, 0.0, 0.0]));
        assert!(source.set(&["target.spin_rad_s.3=2".to_owned()]).is_err());
        // These too, which a scene without them says nothing of.
        source.set(&["target.velocity_m_s.1=3", "launch.bullets.speed_m_s.3=1"].map(str::to_owned)).unwrap();
        assert_eq!(source.json["target"]["velocity_m_s"], json!([0.0, 3, 0.0]));
        assert_eq!(source.json["launch"]["bullets"], json!({ "speed_m_s": [0.0, 0.0, 0.0, 1] }));
        assert!(source.json.get("expect").is_some());
        source.change(&[]).unwrap();
        assert!(source.json.get("expect").is_some(), "nothing was changed");
        source.change(&["target.mass_kg=5".to_owned()]).unwrap();
        assert!(source.json.get("expect").is_none());
        source.change(&["target.mass_kg=6".to_owned(), "expect.captured=false".to_owned()]).unwrap();
        assert_eq!(source.json["expect"], json!({ "captured": false }));
    }

    #[test]
    fn what_is_set_in_degrees_replaces_what_stands_there_in_radians() {
        let mut source = Source::find("cubesat-spin-x-2.0").unwrap();
        source.set(&["target.spin_deg_s.1=90".to_owned()]).unwrap();
        assert_eq!(source.json["target"]["spin_deg_s"], json!([2f64.to_degrees(), 90, 0.0]));
        assert!(source.json["target"].get("spin_rad_s").is_none());
        source.set(&["target.spin_rad_s=[1,0,0]".to_owned()]).unwrap();
        assert!(source.json["target"].get("spin_deg_s").is_none());
        source.json["target"].as_object_mut().unwrap().remove("spin_rad_s");
        source.set(&["target.spin_deg_s.2=5".to_owned()]).unwrap();
        assert_eq!(source.json["target"]["spin_deg_s"], json!([0.0, 0.0, 5]));
    }

    #[test]
    fn set_names_every_path_that_leads_nowhere() {
        let changes = ["net.meshes.2=1", "net.meshes.0.x=1", "step"];
        let problems = source().set(&changes.map(str::to_owned)).unwrap_err();
        assert_eq!(problems.list.len(), 3, "{problems}");
    }
}
