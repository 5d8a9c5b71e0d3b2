//! The verdict in time, as a user meets it: run on until it is decided, warned before, watched after.

use crate::common;

use crate::common::program::{tumblenet, write_json};
use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::metrics::verdict::Verdict;
use tumblenet::metrics::warnings;
use tumblenet::study::settle;

fn load(scene: &str, changes: &[&str]) -> Case {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    Case::load(scene, &changes).unwrap_or_else(|problems| panic!("{problems}"))
}

const EXPLICIT: [&str; 3] = ["solver.cables=explicit", "solver.contact=impulse", "expect=null"];

/// A closing thread settles; how soon is chance, and that it does before ten times the source's duration is not:
/// every run with a thread that was looked at settled within 12 s.
#[test]
fn a_closed_net_is_run_on_until_it_settles_and_stays_bounded() {
    let case = load("cubesat-spin-x-2.0-tube", &EXPLICIT);
    let (run, curves) = settle::run(&case, Some(30.0), |_| {}).unwrap();
    let summary = tumblenet::metrics::summary::Summary::of(&case, &run, &curves);
    let capture = summary.capture.unwrap();
    assert_eq!(capture.verdict, Verdict::HeldSettled, "{capture:?}");
    assert!(capture.captured && capture.gather < 0.2, "{capture:?}"); // measured 0.05
    let settled = capture.settled_at_s.unwrap();
    assert!(settled > capture.captured_at_s.unwrap() && settled < 30.0);
    // It went on for no longer than that, or than its own end.
    assert!(summary.simulated_s <= settled.max(3.0) + 0.1, "{} {settled}", summary.simulated_s);
    assert!(run.frames.time.len() <= 301 + 1500);
}

/// The same verdict from a run that was asked for more: the frames beyond the scene's end do not depend on
/// whether they decide.
#[test]
fn without_until_a_run_ends_where_its_scene_does() {
    let case = load("cubesat-spin-x-2.0-tube", &[&EXPLICIT[..], &["duration_s=1.2"]].concat());
    let summary = common::summary(&case);
    assert!((summary.simulated_s - 1.2).abs() < 1e-6);
    let capture = summary.capture.unwrap();
    assert!(capture.verdict != Verdict::HeldSettled && capture.settled_at_s.is_none(), "{capture:?}");
}

#[test]
fn the_panel_satellite_is_warned_of_before_it_runs_and_not_with_contact_of_cables() {
    let warned = warnings::before(&load("panel-satellite", &[]));
    assert_eq!(warned.len(), 1, "{warned:?}");
    assert!(warned[0].contains("effects.cable_contact") && warned[0].contains("0.020 m thick"), "{warned:?}");
    assert!(warnings::before(&load("panel-satellite", &["effects.cable_contact={}"])).is_empty());
    let folder = tempfile::tempdir().unwrap();
    let checked = tumblenet(folder.path(), &["check", "panel-satellite"]);
    assert!(checked.status.success());
    assert!(String::from_utf8_lossy(&checked.stderr).contains("warning: panel-satellite: knots are up to"));
}

#[test]
fn millimetres_read_as_metres_are_told_with_the_box() {
    let shape = r#"target.shape={"parts":[{"cuboid":[100,300,100]}]}"#;
    let warned = warnings::before(&load("cubesat-free", &[shape, "target.distance_m=400"]));
    let told = warned.iter().any(|warning| warning.contains("100.0000 x 300.0000 x 100.0000 m"));
    assert!(told, "{warned:?}");
    assert!(warnings::before(&load("cubesat-free", &[])).is_empty());
}

#[test]
fn frames_that_steps_are_too_long_for_are_told() {
    let finer = ["output.sample_s=1e-4", "duration_s=0.1"];
    for cables in ["joints", "explicit"] {
        let cables = [format!("solver.cables={cables}"), "solver.contact=impulse".to_owned()];
        let set: Vec<&str> =
            cables.iter().map(String::as_str).chain(finer).chain(["net.meshes=[1,1]"]).collect();
        let warned = warnings::before(&load("deployment-kevlar", &set));
        assert!(
            warned.iter().any(|warning| warning.contains("output.sample_s asks for a frame every")),
            "{warned:?}"
        );
        let named = [&set[..], &["solver.step_s=1e-4"]].concat();
        assert_eq!(warnings::before(&load("deployment-kevlar", &named)), [""; 0]);
    }
}

/// A member that is run alone has the bits it has in its ensemble.
#[test]
fn a_member_is_run_again_to_the_bit_and_the_pages_say_how() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = common::small_scene();
    scene["duration_s"] = json!(0.3);
    scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [0.08, 0.25, 0.15] }] },
        "distance_m": 0.2, "mass_kg": 1.0, "spin_rad_s": [0.5, 0.2, 0.0] });
    scene["capture"] = json!({ "hold_s": 0.1 });
    write_json(folder.path(), "scene.json", &scene);
    let all = tumblenet(
        folder.path(),
        &["run", "scene.json", "--ensemble", "3", "--out", "e", "--replay", "first-missed"],
    );
    assert!(all.status.success(), "{}", String::from_utf8_lossy(&all.stderr));
    let page = std::fs::read_to_string(folder.path().join("e/ensemble.html")).unwrap();
    assert!(page.contains("tumblenet run scene.json --perturb 1e-6 --seed 1 --member N"), "how to watch one");

    let kept = std::fs::read_dir(folder.path().join("e/members")).unwrap().next().unwrap().unwrap().path();
    let kept: Value = serde_json::from_slice(&std::fs::read(kept.join("000002.json")).unwrap()).unwrap();
    let one = tumblenet(folder.path(), &["run", "scene.json", "--member", "2", "--format", "json"]);
    let one: Value = serde_json::from_slice(&one.stdout).unwrap();
    assert_eq!(one["state_hash"], kept["outcome"]["Ok"]["state_hash"]);
    assert!(folder.path().join("results/scene/member-2/replay.html").exists());
}

#[test]
fn scenes_are_set_side_by_side_with_captured_and_survival_first() {
    let folder = tempfile::tempdir().unwrap();
    let arguments =
        ["compare", "cubesat-free", "cubesat-spin-x-2.0", "--members", "1", "--set", "duration_s=0.3"];
    let more = ["--set", "expect=null", "--set", "solver.cables=explicit", "--set", "solver.contact=impulse"];
    let done = tumblenet(folder.path(), &[&arguments[..], &more[..]].concat());
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = std::fs::read(folder.path().join("results/compare/compare.json")).unwrap();
    let comparison: Value = serde_json::from_slice(&text).unwrap();
    let labels: Vec<&Value> =
        comparison["variants"].as_array().unwrap().iter().map(|v| &v["label"]).collect();
    assert_eq!(labels, ["cubesat-free", "cubesat-spin-x-2.0"]);
    let page = std::fs::read_to_string(folder.path().join("results/compare/compare.html")).unwrap();
    assert!(page.find("id=\"verdicts\"").unwrap() < page.find("id=\"bullet-differences\"").unwrap());
}
