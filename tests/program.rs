//! The program as a user meets it: exit status, standard output and error, files.

use crate::common;

use std::io::Write as _;
use std::path::Path;
use std::process::Command;

use crate::common::program::{self, err, out, tumblenet, write_json};
use serde_json::{Value, json};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// The same around a thinner box, of which a run warns.
fn small_capture() -> Value {
    let mut scene = program::small_capture();
    scene["target"]["shape"]["parts"][0]["cuboid"][0] = json!(0.08);
    scene
}

/// Writes the scene to `scene.json` in a new folder.
fn with_scene(scene: &Value) -> tempfile::TempDir {
    let folder = folder();
    write_json(folder.path(), "scene.json", scene);
    folder
}

/// Runs a bad scene: status 2, nothing on standard output, nothing written, and every one of
/// `faults` on standard error.
fn refused(folder: &Path, scene: &str, faults: &[&str]) {
    let files = |folder: &Path| std::fs::read_dir(folder).unwrap().count();
    let before = files(folder);
    let output = tumblenet(folder, &["run", scene, "--out", "results"]);
    let told = err(&output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert_eq!(out(&output), "");
    assert_eq!(files(folder), before, "an output folder");
    for fault in faults {
        assert!(told.contains(fault), "{fault:?} not in {told}");
    }
    assert!(!told.contains("panicked"), "{told}");
}

/// The small capture with `value` at `pointer` is refused for `faults`.
fn refused_with(pointer: &str, value: Value, faults: &[&str]) {
    let mut scene = small_capture();
    let (above, key) = pointer.rsplit_once('/').unwrap();
    let place = if above.is_empty() { &mut scene } else { scene.pointer_mut(above).unwrap() };
    match (place, key.parse::<usize>()) {
        (Value::Array(list), Ok(index)) => list[index] = value,
        (place, _) => place[key] = value,
    }
    let folder = with_scene(&scene);
    refused(folder.path(), "scene.json", faults);
}

#[test]
fn a_bad_value_is_named_with_its_place_and_what_is_allowed() {
    refused_with("/duration_s", json!("three"), &["duration_s: found \"three\"; allowed: a number"]);
    refused_with("/colour", json!(1), &["colour: found an unknown key"]);
    refused_with("/target/colour", json!(1), &["target.colour: found an unknown key", "distance_m"]);
    refused_with("/target/mass_kg", json!(-1), &["target.mass_kg: found -1; allowed: a number above 0"]);
    refused_with(
        "/net/bullet_mass_kg",
        json!(0),
        &["net.bullet_mass_kg: found 0; allowed: a number above 0"],
    );
    refused_with("/net/meshes/0", json!(0), &["net.meshes[0]: found 0; allowed: a number of at least 1"]);
    refused_with("/net/meshes", json!([3]), &["net.meshes: found [3]"]);
    refused_with("/net/cable/material", json!("wood"), &["net.cable.material: found \"wood\"", "kevlar"]);
    refused_with("/target/shape", json!("moon"), &["target.shape", "moon", "cubesat-3u"]);
    refused_with("/effects", json!({ "wind": {} }), &["effects.wind: found an unknown key", "friction"]);
    refused_with("/solver", json!({ "cables": "rubber" }), &["solver.cables: found \"rubber\"", "joints"]);
    refused_with(
        "/launch/angle_deg",
        json!(95),
        &["launch.angle_deg: found 95; allowed: a number of at most 90"],
    );
}

#[test]
fn what_sections_do_not_allow_together_is_named() {
    refused_with("/solver", json!({ "step_s": 0.1 }), &["solver.step_s", "half the thinnest part"]);
    // Left out, the step is chosen for the spin; a given one must do.
    let mut fast = small_capture();
    fast["target"]["spin_rad_s"] = json!([9e3, 0, 0]);
    fast["solver"] = json!({ "step_s": 5e-4 });
    refused(with_scene(&fast).path(), "scene.json", &["target.spin_rad_s", "rad a step"]);
    refused_with("/target/spin_rad_s", json!([1e13, 0, 0]), &["duration_s", "--limit steps=N raises it"]);
    refused_with("/expect", json!({ "within": { "no.such": [0, 1] } }), &["expect.within.no.such"]);
    refused_with("/capture", json!({ "hold_s": 9.0 }), &["capture.hold_s: found 9"]);
    let mut net = small_capture()["net"].clone();
    net["meshes"] = json!([200, 200]);
    net["middle_knots"] = json!(3);
    refused_with("/net", net, &["net.meshes: found a net of 281601 knots; allowed: at most 250000"]);
}

#[test]
fn an_implausible_inertia_is_refused() {
    let given = json!({ "parts": [{ "cuboid": [0.1, 0.2, 0.1] }],
        "inertia_kg_m2": [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 5e-3]] });
    refused_with("/target/shape", given, &["inertia_kg_m2", "none exceeds the sum of the other two"]);
}

#[test]
fn a_mesh_file_of_garbage_is_refused() {
    for (name, bytes) in [
        ("garbage.obj", &b"\x00\xff\x80 no mesh"[..]),
        ("garbage.stl", b"solid nothing at all"),
        ("empty.obj", b""),
        ("point.obj", b"v 0 0 0\n"),
        ("nan.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("index.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
    ] {
        let mut scene = small_capture();
        scene["target"]["shape"] = json!({ "parts": [{ "mesh": { "file": name } }] });
        let folder = with_scene(&scene);
        std::fs::write(folder.path().join(name), bytes).unwrap();
        refused(folder.path(), "scene.json", &["target.shape.parts[0].mesh", name]);
    }
    let mut scene = small_capture();
    scene["target"]["shape"] = json!({ "parts": [{ "mesh": { "file": "nowhere.obj" } }] });
    let folder = with_scene(&scene);
    refused(folder.path(), "scene.json", &["target.shape.parts[0].mesh", "nowhere.obj"]);
}

#[test]
fn ten_faults_are_named_at_once() {
    let mut scene = small_capture();
    scene["duration_s"] = json!(-1);
    scene["net"]["meshes"] = json!([0, 2.5]);
    scene["net"]["cable"]["diameter_m"] = json!(0);
    scene["net"]["cable"]["damping_ratio"] = json!("some");
    scene["launch"]["angle_deg"] = json!(-5);
    scene["target"]["offset_m"] = json!([0]);
    scene["target"]["motion"] = json!("dancing");
    scene["solver"] = json!({ "substeps": 0 });
    scene["capture"]["mouth_max"] = json!(-0.1);
    let folder = with_scene(&scene);
    refused(
        folder.path(),
        "scene.json",
        &[
            "10 faults",
            "duration_s: found -1",
            "net.meshes[0]: found 0",
            "net.meshes[1]: found 2.5",
            "net.cable.diameter_m: found 0",
            "net.cable.damping_ratio: found \"some\"",
            "launch.angle_deg: found -5",
            "target.offset_m: found [0]",
            "target.motion: found \"dancing\"",
            "solver.substeps: found 0",
            "capture.mouth_max: found -0.1",
        ],
    );
}

#[test]
fn what_is_no_scene_at_all_is_refused() {
    let folder = folder();
    for (name, bytes) in [
        ("no.json", &b"{ \"title\": "[..]),
        ("list.json", b"[]"),
        ("empty.json", b""),
        ("bytes.json", b"\xff"),
    ] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        refused(folder.path(), name, &[name, "fault"]);
    }
    // A built-in name is named when nothing else fits.
    refused(folder.path(), "nowhere.json", &["nowhere.json", "cubesat-free"]);
    refused(folder.path(), ".", &["no file"]);
}

#[test]
fn bad_arguments_end_with_status_2() {
    let folder = folder();
    for arguments in [
        &["fly"][..],
        &["run"],
        &["run", "cubesat-free", "--ensemble", "0"],
        &["run", "cubesat-free", "--ensemble", "2", "--perturb", "-1e-6"],
        &["run", "cubesat-free", "--ensemble", "2", "--perturb=-1e-6"],
        &["run", "cubesat-free", "--ensemble", "2", "--perturb", "NaN"],
        &["run", "cubesat-free", "--ensemble", "2", "--perturb", "inf"],
        &["run", "cubesat-free", "--perturb", "1e-6"],
        &["run", "cubesat-free", "--format", "xml"],
        &["run", "cubesat-free", "--set", "duration_s"],
        &["run", "cubesat-free", "--set", "net.meshes.7=1"],
        &["run", "cubesat-free", "--set", "net.colour=1"],
        &["check"],
        &["show"],
        &["show", "nowhere"],
    ] {
        let output = tumblenet(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", err(&output));
        assert_eq!(out(&output), "", "{arguments:?}");
        assert!(!err(&output).is_empty(), "{arguments:?}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
}

#[test]
fn a_run_writes_its_results_and_prints_them() {
    let folder = with_scene(&small_capture());
    let output = tumblenet(folder.path(), &["run", "scene.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let told = err(&output);
    assert!(
        told.lines().all(|line| line.starts_with("warning: knots are up to")),
        "no progress in a pipe: {told}"
    );
    let results = folder.path().join("results/scene");
    assert!(out(&output).contains("results/scene"), "{}", out(&output));
    let mut names: Vec<String> = std::fs::read_dir(&results)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["replay.html", "series.csv", "summary.json", "trajectory.npz"]);

    let summary: Value =
        serde_json::from_slice(&std::fs::read(results.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["simulated_s"], json!(0.3));
    assert!(summary["contact"]["contacts"].as_u64().unwrap() > 0);
    let rows = std::fs::read_to_string(results.join("series.csv")).unwrap();
    let width = rows.lines().next().unwrap().split(',').count();
    assert_eq!(rows.lines().count(), 32); // a head and a row at 0, 0.01 ... 0.3 s
    assert!(rows.lines().all(|row| row.split(',').count() == width && !row.contains("NaN")));
    let page = std::fs::read_to_string(results.join("replay.html")).unwrap();
    let outside = ["src=\"http", "href=\"http", "@import", "url(http"];
    assert!(outside.iter().all(|word| !page.contains(word)), "one self-contained file");
}

#[test]
fn json_on_standard_output_is_the_summary_that_is_written() {
    let folder = with_scene(&small_capture());
    let output = tumblenet(folder.path(), &["run", "scene.json", "--out", "deep/er", "--format", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let written = std::fs::read(folder.path().join("deep/er/summary.json")).unwrap();
    assert_eq!(printed, serde_json::from_slice::<Value>(&written).unwrap());
}

#[test]
fn set_changes_values_and_removes_keys() {
    let folder = with_scene(&small_capture());
    let output = tumblenet(
        folder.path(),
        &[
            "run",
            "scene.json",
            "--format=json",
            "--set",
            "duration_s=0.1",
            "--set",
            "target=null",
            "--set",
            "solver.restitution=0.5",
            "--set",
            "title=a title = two words",
        ],
    );
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["simulated_s"], json!(0.1));
    assert_eq!(summary["solver"]["restitution"], json!(0.5));
    assert_eq!(summary["title"], json!("a title = two words"));
    assert_eq!(summary["work"]["colliders"], json!(0));
    assert!(summary.get("capture").is_none() && summary.get("contact").is_none());
}

/// Made by what every net flew with before: undamped cables and semi-implicit Euler at its own step, 0.09 of the launch
/// energy; copies that differ in the last digits make less, by chance.
#[test]
fn a_run_that_creates_energy_ends_with_status_1_and_says_so() {
    let mut scene = common::small_scene();
    scene["net"]["cable"]["damping_ratio"] = json!(0.0);
    scene["solver"] = json!({ "cables": "explicit", "contact": "impulse", "integrator": "symplectic" });
    let folder = with_scene(&scene);
    for arguments in [
        &["run", "scene.json", "--out", "one"][..],
        &["run", "scene.json", "--out", "many", "--ensemble", "2", "--perturb", "0"],
        &["compare", "scene.json", "--out", "c", "--perturb", "0", "--solvers", "explicit+impulse"],
    ] {
        let output = tumblenet(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {}", err(&output));
        assert!(err(&output).contains("not to be believed"), "{}", err(&output));
    }
    // What it came to is written all the same.
    assert!(folder.path().join("one/summary.json").exists());
    // Left to itself the program chooses an integrator that keeps it.
    scene["solver"]["integrator"] = json!("auto");
    write_json(folder.path(), "scene.json", &scene);
    let output = tumblenet(folder.path(), &["run", "scene.json", "--out", "two"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
}

#[test]
fn a_run_that_is_not_what_it_expects_ends_with_status_1_and_says_why() {
    let mut scene = small_capture();
    scene["expect"] = json!({ "within": { "contact.first_contact_s": [10, 20] } });
    let folder = with_scene(&scene);
    let output = tumblenet(folder.path(), &["run", "scene.json"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        err(&output).contains("contact.first_contact_s: expected 10 to 20, found 0."),
        "{}",
        err(&output)
    );
    assert!(folder.path().join("results/scene/summary.json").exists(), "results are there to look at");
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = with_scene(&small_capture());
    std::fs::write(folder.path().join("taken"), "a file").unwrap();
    for arguments in [
        &["run", "scene.json", "--out", "taken"][..],
        &["run", "scene.json", "--out", "taken/below"],
        &["run", "scene.json", "--out", "taken", "--ensemble", "2"],
    ] {
        let output = tumblenet(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let last = err(&output).lines().last().unwrap_or_default().to_owned();
        assert!(last.starts_with("error: cannot write taken"), "{}", err(&output));
        assert_eq!(out(&output), "", "{arguments:?}");
    }
    assert_eq!(std::fs::read_to_string(folder.path().join("taken")).unwrap(), "a file");
}

#[test]
fn an_interrupted_ensemble_goes_on_where_it_was() {
    let folder = with_scene(&small_capture());
    let arguments = ["run", "scene.json", "--out", "e", "--ensemble", "3", "--format", "json"];
    let first = tumblenet(folder.path(), &arguments);
    assert_eq!(first.status.code(), Some(0), "{}", err(&first));
    let ensemble: Value = serde_json::from_slice(&first.stdout).unwrap();
    assert_eq!(ensemble["captured"]["of"], json!(3));
    assert_eq!(ensemble["scalars"]["contact.first_contact_s"]["count"], json!(3));

    let members = std::fs::read_dir(folder.path().join("e/members")).unwrap().next().unwrap().unwrap().path();
    let [kept, lost, broken] =
        ["000000", "000001", "000002"].map(|name| members.join(name).with_extension("json"));
    let before = std::fs::read(&kept).unwrap();
    std::fs::remove_file(folder.path().join("e/ensemble.json")).unwrap();
    std::fs::remove_file(&lost).unwrap();
    std::fs::write(&broken, "{ half a fi").unwrap();

    let again = tumblenet(folder.path(), &arguments);
    assert_eq!(again.status.code(), Some(0), "{}", err(&again));
    assert_eq!(std::fs::read(&kept).unwrap(), before, "a finished member does not run again");
    assert_eq!(timeless(&again.stdout), timeless(&first.stdout));
    assert!(folder.path().join("e/ensemble.json").exists() && lost.exists());

    // More members go on from those that are there; another perturbation starts anew.
    let more = tumblenet(folder.path(), &["run", "scene.json", "--out", "e", "--ensemble", "4"]);
    assert_eq!(more.status.code(), Some(0), "{}", err(&more));
    assert_eq!(std::fs::read(&kept).unwrap(), before);
    let other = ["run", "scene.json", "--out", "e", "--ensemble", "1", "--perturb", "1e-4"];
    assert_eq!(tumblenet(folder.path(), &other).status.code(), Some(0));
    assert_eq!(std::fs::read_dir(folder.path().join("e/members")).unwrap().count(), 2);
}

/// Sources that are not committed have the same version and commit, and a copy may have the same date.
#[test]
fn members_of_another_build_are_not_taken_for_this_ones() {
    let folder = with_scene(&small_capture());
    let arguments = ["run", "scene.json", "--out", "e", "--ensemble", "1"];
    let kept = || std::fs::read_dir(folder.path().join("e/members")).unwrap().count();
    let this = Path::new(env!("CARGO_BIN_EXE_tumblenet"));
    let [copy, build] = ["copy", "build"].map(|name| folder.path().join(name));
    std::fs::copy(this, &copy).unwrap();
    std::fs::copy(this, &build).unwrap();
    let mut file = std::fs::OpenOptions::new().append(true).open(&build).unwrap();
    // Behind the end of a program nothing is read.
    file.write_all(b"another").unwrap();
    file.set_modified(this.metadata().unwrap().modified().unwrap()).unwrap();
    drop(file);
    for (program, count) in [(this, 1), (copy.as_path(), 1), (build.as_path(), 2)] {
        let output = Command::new(program).args(arguments).current_dir(folder.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        assert_eq!(kept(), count, "{}", program.display());
    }
}

/// An ensemble without what the machine adds.
fn timeless(printed: &[u8]) -> Value {
    let mut ensemble: Value = serde_json::from_slice(printed).unwrap();
    let scalars = ensemble["scalars"].as_object_mut().unwrap();
    scalars.retain(|name, _| name != "wall_s" && !name.starts_with("time_shares"));
    ensemble
}

#[test]
fn check_names_the_faults_of_all_scenes_and_runs_nothing() {
    let folder = with_scene(&small_capture());
    let mut bad = small_capture();
    bad["duration_s"] = json!(0);
    std::fs::write(folder.path().join("bad.json"), bad.to_string()).unwrap();
    let output = tumblenet(folder.path(), &["check", "scene.json", "bad.json", "nowhere", "cubesat-free"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(out(&output).contains("scene.json: ok") && out(&output).contains("cubesat-free: ok"));
    assert!(err(&output).contains("bad.json: 1 fault") && err(&output).contains("nowhere: 1 fault"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    assert_eq!(tumblenet(folder.path(), &["check", "scene.json"]).status.code(), Some(0));
}

#[test]
fn list_names_what_is_built_in() {
    let output = tumblenet(folder().path(), &["list"]);
    assert_eq!(output.status.code(), Some(0));
    for name in ["deployment-kevlar", "cubesat-free", "envisat-mockup", "zylon"] {
        assert!(out(&output).contains(name), "{name}");
    }
}

#[test]
fn show_prints_the_whole_scene_and_what_the_engine_gets() {
    let folder = folder();
    let output =
        tumblenet(folder.path(), &["show", "cubesat-free", "--set", "effects.friction.coefficient=0.3"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let text = out(&output);
    // Defaults are filled in, and the scene on top can be read again.
    let end = text.find("\n}").unwrap() + 2;
    let scene: Value = serde_json::from_str(&text[..end]).unwrap();
    assert_eq!(scene["solver"]["cables"], json!("joints"));
    assert_eq!(scene["capture"]["hold_s"], json!(0.3));
    for (fact, value) in
        [("bodies", "122"), ("colliders", "122"), ("cable joints", "220"), ("friction", "coefficient 0.3")]
    {
        let row = text[end..].lines().find(|line| line.contains(fact)).unwrap_or_else(|| panic!("no {fact}"));
        assert!(row.contains(value), "{row}");
    }
    let plain = out(&tumblenet(folder.path(), &["show", "deployment-kevlar"]));
    assert!(plain.contains("none: no collider, no detection"), "{plain}");
}

#[test]
fn the_published_schema_accepts_scenes_and_refuses_unknown_keys() {
    let output = tumblenet(folder().path(), &["schema"]);
    assert_eq!(output.status.code(), Some(0));
    let schema: Value = serde_json::from_slice(&output.stdout).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    assert!(validator.is_valid(&small_capture()));
    let mut unknown = small_capture();
    unknown["net"]["cable"]["colour"] = json!("red");
    assert!(!validator.is_valid(&unknown));
}

/// `cargo run --release` of the README: a real capture, a table, and where to look.
#[test]
fn without_arguments_a_capture_runs() {
    let folder = folder();
    let output = tumblenet(folder.path(), &[]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let text = out(&output);
    for word in ["tumbling", "CAPTURED", "replay.html", "tumblenet list"] {
        assert!(text.contains(word), "{word:?} not in {text}");
    }
    // One file that is sent by mail: 1.2 MB.
    let run = std::fs::read_dir(folder.path().join("results")).unwrap().next().unwrap().unwrap();
    let page = run.path().join("replay.html").metadata().unwrap().len();
    assert!((100_000..2_000_000).contains(&page), "{page} bytes");
}

/// A changed scene is another: what it was expected to show is no longer expected.
#[test]
fn the_first_example_of_the_readme_does_not_fail() {
    let mut scene = small_capture();
    scene["expect"] = json!({ "within": { "contact.first_contact_s": [10, 20] } });
    let folder = with_scene(&scene);
    let run = |arguments: &[&str]| tumblenet(folder.path(), &[&["run", "scene.json"], arguments].concat());
    assert_eq!(run(&[]).status.code(), Some(1));
    let changed = run(&["--set", "target.mass_kg=5"]);
    assert_eq!(changed.status.code(), Some(0), "{}", err(&changed));
    let expected = run(&["--set", "target.mass_kg=5", "--set", "expect.within={\"simulated_s\":[5,6]}"]);
    assert_eq!(expected.status.code(), Some(1), "what the changes themselves expect");
}

#[test]
fn the_example_of_the_help_changes_a_list_that_is_left_out() {
    let mut scene = small_capture();
    scene["target"].as_object_mut().unwrap().remove("spin_rad_s");
    let folder = with_scene(&scene);
    let output =
        tumblenet(folder.path(), &["show", "scene.json", "--json", "--set", "target.spin_rad_s.0=2"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let shown: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(shown["target"]["spin_rad_s"], json!([2.0, 0.0, 0.0]));
}

#[test]
fn what_show_prints_as_json_can_be_read_back() {
    let folder = folder();
    let shown = tumblenet(folder.path(), &["show", "cubesat-spin-x-2.0-tube", "--json"]);
    assert_eq!(shown.status.code(), Some(0), "{}", err(&shown));
    std::fs::write(folder.path().join("my.json"), &shown.stdout).unwrap();
    let again = tumblenet(folder.path(), &["show", "my.json", "--json"]);
    assert_eq!(out(&again), out(&shown));
}

#[test]
fn a_scene_may_name_its_schema() {
    let folder = with_scene(&small_capture());
    let hash = || {
        let output = tumblenet(folder.path(), &["run", "scene.json", "--format", "json"]);
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
        summary["scene_hash"].clone()
    };
    let plain = hash();
    let mut scene = small_capture();
    scene["$schema"] = json!("scene.schema.json");
    write_json(folder.path(), "scene.json", &scene);
    assert_eq!(hash(), plain, "the same scene");
}
