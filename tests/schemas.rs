//! Every file of results is what its published schema says.

use std::path::Path;

use serde_json::{Value, json};
use tumblenet::report::recorded::RecordedRun;

use crate::common::program::{folder_with, printed, small_capture, tiny_capture, write_json};
use crate::common::small_scene;

/// The file `path` below `folder` is what `tumblenet schema kind` says, and knows no key that the schema does not.
#[track_caller]
fn is_as_published(folder: &Path, kind: &str, path: &str) {
    let schema: Value = serde_json::from_str(&printed(folder, &["schema", kind])).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap_or_else(|error| panic!("{kind}: {error}"));
    let file: Value = serde_json::from_slice(&std::fs::read(folder.join(path)).unwrap()).unwrap();
    let faults: Vec<String> =
        validator.iter_errors(&file).map(|error| format!("{}: {error}", error.instance_path())).collect();
    assert!(faults.is_empty(), "{path}: {faults:#?}");
    let known = schema["properties"].as_object().unwrap();
    for key in file.as_object().unwrap().keys() {
        assert!(known.contains_key(key), "{path}: {key} is in no schema");
    }
    // It is no schema that lets everything pass.
    for key in schema["required"].as_array().unwrap() {
        let mut broken = file.clone();
        broken.as_object_mut().unwrap().remove(key.as_str().unwrap());
        assert!(!validator.is_valid(&broken), "{path} without {key}");
    }
}

#[test]
fn files_of_runs_ensembles_comparisons_costs_and_hard_cases_are_as_published() {
    let folder = folder_with(&[("scene.json", &small_capture())]);
    let at = folder.path();
    printed(at, &["run", "scene.json", "--out", "a"]);
    is_as_published(at, "summary", "a/summary.json");
    printed(at, &["run", "cubesat-spin-x-2.0-tube", "--set", "duration_s=0.9", "--out", "tube"]);
    is_as_published(at, "summary", "tube/summary.json");
    printed(at, &["run", "scene.json", "--ensemble", "2", "--out", "e"]);
    is_as_published(at, "ensemble", "e/ensemble.json");
    let pairs = "joints+rapier,explicit+impulse";
    printed(at, &["compare", "scene.json", "--members", "2", "--solvers", pairs, "--out", "c"]);
    is_as_published(at, "compare", "c/compare.json");
    printed(at, &["cost", "scene.json", "--budget", "1s", "--out", "k"]);
    is_as_published(at, "cost", "k/cost.json");
    printed(at, &["stress", "e-0.4", "--pairs", "explicit+impulse", "--out", "s"]);
    is_as_published(at, "stress", "s/stress.json");
    printed(at, &["run", "scene.json", "--set", "launch.speed_m_s=2.1", "--out", "b"]);
    printed(at, &["residual", "a", "b", "--out", "r"]);
    is_as_published(at, "residual", "r/residual.json");
}

#[test]
fn files_of_sweeps_are_as_published() {
    let study = json!({ "title": "what matters", "scene": "scene.json", "solver": "explicit+impulse",
        "parameters": [{ "path": "launch.speed_m_s", "uniform": [1.8, 2.2] },
                       { "path": "target.mass_kg", "uniform": [0.5, 2] }],
        "design": { "kind": "saltelli", "base": 8 } });
    let steps = json!({ "title": "steps", "scene": "scene.json", "solver": "explicit+impulse",
        "parameters": [{ "path": "launch.speed_m_s", "values": [1.8, 2.0, 2.2] }],
        "design": { "kind": "one-at-a-time" }, "members": 2 });
    let search = json!({ "title": "best", "scene": "scene.json", "solver": "explicit+impulse",
        "parameters": [{ "path": "launch.speed_m_s", "uniform": [1.8, 2.2] }],
        "design": { "kind": "sobol", "points": 4 } });
    let files = [
        ("scene.json", &tiny_capture()),
        ("study.json", &study),
        ("steps.json", &steps),
        ("search.json", &search),
    ];
    let folder = folder_with(&files);
    let at = folder.path();
    is_as_published(at, "study", "study.json");
    printed(at, &["sweep", "study.json", "--out", "o"]);
    is_as_published(at, "plan", "o/study.json");
    is_as_published(at, "sweep", "o/sweep.json");
    printed(at, &["map", "o", "--over", "input.launch.speed_m_s,input.target.mass_kg"]);
    is_as_published(at, "map", "o/map.json");
    printed(at, &["sensitivity", "o"]);
    is_as_published(at, "sensitivity", "o/sensitivity.json");
    printed(at, &["optimise", "search.json", "--rounds", "2", "--confirm", "2", "--out", "best"]);
    is_as_published(at, "optimised", "best/optimised.json");
    printed(at, &["sweep", "steps.json", "--out", "d"]);
    printed(at, &["dependency", "d"]);
    is_as_published(at, "dependency", "d/dependency.json");
}

#[test]
fn what_a_fit_found_is_as_published() {
    let mut scene = small_scene();
    scene["duration_s"] = json!(0.12);
    let folder = folder_with(&[("scene.json", &scene)]);
    let at = folder.path();
    printed(at, &["run", "scene.json", "--out", "a"]);
    let run = RecordedRun::read(&at.join("a")).unwrap();
    let mut tracks = "time_s,marker,x_m,y_m,z_m\n".to_owned();
    for (number, &knot) in run.net.bullets.iter().enumerate() {
        for time in [0.03, 0.06, 0.09] {
            let seen = run.paths.at(knot, time).position;
            tracks += &format!("{time},bullet-{},{},{},{}\n", number + 1, seen.x, seen.y, seen.z);
        }
    }
    std::fs::write(at.join("track.csv"), tracks).unwrap();
    let fit = json!({ "title": "the shot", "scene": "scene.json", "track": "track.csv", "align": "none", "scan": 3,
        "parameters": [{ "path": "launch.speed_m_s", "uniform": [1.5, 2.5] }] });
    write_json(at, "fit.json", &fit);
    is_as_published(at, "fit", "fit.json");
    printed(at, &["fit", "fit.json", "--out", "o"]);
    is_as_published(at, "found", "o/fit.json");
}
