//! The program as a user starts it, in a folder of its own.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::{Value, json};

/// The program with `arguments` in `folder`, whatever the width of the terminal that the tests run in.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tumblenet"));
    command.args(arguments).current_dir(folder).env_remove("COLUMNS");
    command
}

/// Runs it to its end.
pub fn tumblenet(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the program starts")
}

/// What it printed.
pub fn out(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// What it told on standard error.
pub fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// What it printed, where it must have ended well.
#[track_caller]
pub fn printed(folder: &Path, arguments: &[&str]) -> String {
    let output = tumblenet(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", err(&output));
    out(&output)
}

/// The smallest capture: a net of 2 x 2 meshes that meets a box within a few steps.
pub fn tiny_capture() -> Value {
    let mut scene = super::small_scene();
    scene["duration_s"] = json!(0.12);
    scene["net"]["meshes"] = json!([2, 2]);
    scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [0.11, 0.25, 0.15] }] },
        "distance_m": 0.15, "mass_kg": 1.0, "spin_rad_s": [0.5, 0.2, 0.0] });
    scene["capture"] = json!({ "hold_s": 0.02 });
    scene
}

/// A folder with each of `files`, JSON by its name.
pub fn folder_with(files: &[(&str, &Value)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, value) in files {
        write_json(folder.path(), name, value);
    }
    folder
}

/// Writes `value` to the file `name` in `folder`.
pub fn write_json(folder: &Path, name: &str, value: &Value) {
    std::fs::write(folder.join(name), value.to_string()).unwrap();
}

/// A capture that takes a blink: a net of 3 x 3 meshes around a box thicker than a mesh is wide, so that a run has
/// nothing to warn of.
pub fn small_capture() -> Value {
    let mut scene = super::small_scene();
    scene["duration_s"] = json!(0.3);
    scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [0.11, 0.25, 0.15] }] },
        "distance_m": 0.2, "mass_kg": 1.0, "spin_rad_s": [0.5, 0.2, 0.0] });
    scene["capture"] = json!({ "hold_s": 0.1 });
    scene
}

/// Writes [`small_capture`], changed by `change`, to `scene.json` in `folder`.
pub fn write_scene(folder: &Path, change: impl FnOnce(&mut Value)) {
    let mut scene = small_capture();
    change(&mut scene);
    write_json(folder, "scene.json", &scene);
}

/// The same in a new folder.
pub fn with_scene(change: impl FnOnce(&mut Value)) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_scene(folder.path(), change);
    folder
}

/// Names and bytes of all files below `folder`. A file that goes while this looks is passed over.
pub fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    let Ok(entries) = std::fs::read_dir(folder) else { return all };
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        if path.is_dir() {
            all.extend(files(&path));
        } else if let Ok(bytes) = std::fs::read(&path) {
            all.insert(path, bytes);
        }
    }
    all
}
