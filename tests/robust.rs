//! What goes wrong around a run: too much is asked for, files outside, a full disk, an end before
//! its time. Each ends in words, and nothing that was finished is lost.

mod common;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tumblenet"));
    command.args(arguments).current_dir(folder);
    command
}

fn tumblenet(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the program starts")
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with the small net of `scene.json` around a box, changed by `change`.
fn with_scene(change: impl FnOnce(&mut Value)) -> tempfile::TempDir {
    let mut scene = common::small_scene();
    scene["duration_s"] = json!(0.3);
    scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [0.08, 0.25, 0.15] }] },
        "distance_m": 0.2, "mass_kg": 1.0, "spin_rad_s": [0.5, 0.2, 0.0] });
    scene["capture"] = json!({ "hold_s": 0.1 });
    change(&mut scene);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.json"), scene.to_string()).unwrap();
    folder
}

/// Names and bytes of all files below `folder`.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    let Ok(entries) = std::fs::read_dir(folder) else { return all };
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            all.extend(files(&path));
        } else {
            all.insert(path.clone(), std::fs::read(path).unwrap());
        }
    }
    all
}

#[test]
fn every_limit_is_told_with_its_name_and_can_be_changed() {
    let points: Vec<_> =
        (0..20).map(|i| [f64::from(i % 2), f64::from(i / 2 % 2), 0.01 * f64::from(i)]).collect();
    let folder = with_scene(|scene| {
        scene["target"]["shape"]["parts"] = json!([{ "convex": { "points_m": points } },
            { "mesh": { "file": "mesh.obj" }, "position_m": [2, 0, 0] }]);
    });
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::fs::write(folder.path().join("mesh.obj"), mesh).unwrap();
    let sound = tumblenet(folder.path(), &["check", "scene.json"]);
    assert_eq!(sound.status.code(), Some(0), "{}", err(&sound));
    for (limit, place) in [
        ("text", "(top level)"),
        ("mesh", "target.shape.parts[1].mesh.file"),
        ("knots", "net.meshes"),
        ("steps", "duration_s"),
        ("positions", "output.sample_s"),
        ("parts", "target.shape.parts"),
        ("points", "target.shape.parts[0].convex"),
        ("triangles", "target.shape.parts[1].mesh.file"),
    ] {
        let lowered = tumblenet(folder.path(), &["check", "scene.json", "--limit", &format!("{limit}=1")]);
        assert_eq!(lowered.status.code(), Some(2), "{limit}");
        let told = err(&lowered);
        assert!(told.contains(&format!("--limit {limit}=N raises it")), "{limit}: {told}");
        assert!(told.contains(&format!("  {place}: found")), "{limit}: {told}");
    }
    let members = ["run", "scene.json", "--ensemble", "3", "--limit", "members=2"];
    let refused = tumblenet(folder.path(), &members);
    assert_eq!(refused.status.code(), Some(2));
    assert!(err(&refused).contains("at most 2 members (--limit members=N raises it)"), "{}", err(&refused));
    let unknown = tumblenet(folder.path(), &["check", "scene.json", "--limit", "wishes=3"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(err(&unknown).contains("knots=250000"), "{}", err(&unknown));
    assert_eq!(files(folder.path()).len(), 2, "nothing was written");
}

#[test]
fn a_scene_reads_outside_of_its_folder_only_when_the_user_says_so() {
    let folder = with_scene(|scene| scene["target"]["shape"] = json!("../shape.json"));
    let below = folder.path().join("below");
    std::fs::create_dir(&below).unwrap();
    std::fs::rename(folder.path().join("scene.json"), below.join("scene.json")).unwrap();
    let shape = json!({ "parts": [{ "cuboid": [0.08, 0.25, 0.15] }] });
    std::fs::write(folder.path().join("shape.json"), shape.to_string()).unwrap();
    for (folder, scene) in [(folder.path(), "below/scene.json"), (&below, "scene.json")] {
        let refused = tumblenet(folder, &["check", scene]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(
            err(&refused).contains("target.shape: found \"../shape.json\", outside"),
            "{}",
            err(&refused)
        );
        let read = tumblenet(folder, &["check", scene, "--allow-outside"]);
        assert_eq!(read.status.code(), Some(0), "{}", err(&read));
    }
}

#[test]
fn a_second_run_replaces_the_first_and_says_so() {
    let folder = with_scene(|_| {});
    let printed = |changes: &[&str]| {
        let output = tumblenet(folder.path(), &[&["run", "scene.json"], changes].concat());
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(!printed(&[]).contains("in place of"));
    let first = files(&folder.path().join("results"));
    assert!(printed(&["--set", "duration_s=0.2"]).contains("in place of an earlier run's"));
    let second = files(&folder.path().join("results"));
    assert!(first.keys().eq(second.keys()));
    assert!(first.values().zip(second.values()).all(|(one, other)| one != other), "all files are new");
}

/// Linux tells a full disk through this file.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_told() {
    let folder = with_scene(|_| {});
    let full = || Stdio::from(std::fs::File::options().write(true).open("/dev/full").unwrap());
    for arguments in [&["schema"][..], &["list"], &["check", "scene.json"], &["run", "scene.json"]] {
        let output = command(folder.path(), arguments).stdout(full()).stderr(Stdio::piped()).spawn().unwrap();
        let output = output.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(err(&output).contains("cannot write standard output: No space left"), "{}", err(&output));
    }
}

/// A limit on the size of files stands for a disk that fills up while a file is written.
#[cfg(unix)]
#[test]
fn a_disk_that_fills_up_leaves_the_earlier_results_whole() {
    let folder = with_scene(|_| {});
    assert_eq!(tumblenet(folder.path(), &["run", "scene.json"]).status.code(), Some(0));
    let before = files(folder.path());
    let script = format!(
        "trap '' XFSZ; ulimit -f 16; exec '{}' run scene.json --set duration_s=0.25",
        env!("CARGO_BIN_EXE_tumblenet")
    );
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", err(&output));
    assert!(err(&output).starts_with("error: cannot write results/scene/"), "{}", err(&output));
    assert_eq!(output.stdout, b"");
    assert_eq!(files(folder.path()), before, "whole, and nothing half-written beside");
}

/// Starts the program and waits until `ready`.
#[cfg(unix)]
fn start(folder: &Path, arguments: &[&str], ready: impl Fn() -> bool) -> Child {
    let mut child = command(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !ready() {
        assert_eq!(child.try_wait().unwrap(), None, "ended before its time");
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

#[cfg(unix)]
fn signal(child: Child, name: &str) -> Output {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_writes_nothing_and_says_so() {
    for name in ["-INT", "-TERM"] {
        let folder = with_scene(|scene| scene["duration_s"] = json!(5000.0));
        let results = folder.path().join("results/scene");
        let arguments = ["run", "scene.json", "--set", "output.sample_s=1"];
        let output = signal(start(folder.path(), &arguments, || results.exists()), name);
        assert_eq!(output.status.code(), Some(130), "{}", err(&output));
        assert_eq!(err(&output), "interrupted: nothing of this run was written\n");
        assert_eq!(files(&results), BTreeMap::new());
    }
}

/// Interrupted or killed: what was finished is kept, whole, and is not run again.
#[cfg(unix)]
#[test]
fn an_ensemble_that_ends_before_its_time_keeps_what_was_finished() {
    for name in ["-INT", "-KILL"] {
        let folder = with_scene(|_| {});
        let kept = || files(&folder.path().join("results/scene/members"));
        let arguments = ["run", "scene.json", "--ensemble", "100000"];
        let output = signal(start(folder.path(), &arguments, || kept().len() >= 3), name);
        if name == "-INT" {
            assert_eq!(output.status.code(), Some(130), "{}", err(&output));
            let told = "interrupted: finished members are kept in results/scene; the same command goes on";
            assert!(err(&output).starts_with(told), "{}", err(&output));
        }
        let mut members = kept();
        if name == "-KILL" {
            // What was being written has no name yet that a member has.
            members.retain(|path, _| path.extension().is_some_and(|ending| ending == "json"));
        }
        assert!(members.len() >= 3);
        for (path, bytes) in &members {
            let member: Value = serde_json::from_slice(bytes).unwrap_or_else(|why| panic!("{path:?}: {why}"));
            assert!(member["outcome"]["Ok"]["capture"].is_object(), "{path:?}");
        }
        let again = tumblenet(folder.path(), &["run", "scene.json", "--ensemble", "3", "--format", "json"]);
        assert_eq!(again.status.code(), Some(0), "{}", err(&again));
        let ensemble: Value = serde_json::from_slice(&again.stdout).unwrap();
        assert_eq!(ensemble["captured"]["of"], json!(3));
        let after = kept();
        assert!(members.iter().all(|(path, bytes)| after[path] == *bytes), "a finished member ran again");
    }
}
