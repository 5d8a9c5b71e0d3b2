//! `tumblenet report`: results of many kinds in one page, what was found before everything else.

use std::path::Path;

use crate::common::program::{err, folder_with, printed, tiny_capture, tumblenet, with_scene, write_json};
use serde_json::{Value, json};

/// A folder with a run, an ensemble, a comparison and a sweep of the smallest capture.
fn results() -> tempfile::TempDir {
    let study = json!({ "title": "rates & masses", "scene": "scene.json", "solver": "explicit+impulse",
        "parameters": [{ "path": "target.mass_kg", "values": [0.5, 1] }], "design": { "kind": "grid" } });
    let folder = folder_with(&[("scene.json", &tiny_capture()), ("study.json", &study)]);
    let pair = ["--set", "solver.cables=explicit", "--set", "solver.contact=impulse"];
    let with = |arguments: &[&str]| {
        printed(folder.path(), &[arguments, &pair].concat());
    };
    with(&["run", "scene.json", "--out", "all/a run"]);
    for (mass, out) in [("target.mass_kg=5", "all/b"), ("target.mass_kg=8", "all/c")] {
        let held = ["--set", "duration_s=1.4", "--set", "expect=null", "--set", mass];
        with(&[&["run", "cubesat-spin-x-2.0-tube", "--ensemble", "2", "--out", out], &held[..]].concat());
    }
    printed(
        folder.path(),
        &["compare", "scene.json", "--solvers", "explicit+impulse", "--members", "2", "--out", "all/d"],
    );
    printed(folder.path(), &["sweep", "study.json", "--out", "all/deep/e"]);
    printed(folder.path(), &["stress", "one-point", "--pairs", "explicit+impulse", "--out", "all/deep/f"]);
    folder
}

fn page(folder: &Path, place: &str) -> String {
    std::fs::read_to_string(folder.join(place)).unwrap()
}

/// Values of an attribute in `page`.
fn attributes<'a>(page: &'a str, name: &str) -> Vec<&'a str> {
    let open = format!("{name}=\"");
    page.split(open.as_str()).skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

#[test]
fn a_report_has_every_result_and_its_verdict_first() {
    let folder = results();
    let told = printed(folder.path(), &["report", "all", "--out", "pages/one", "--title", "What <came>"]);
    assert!(
        told.starts_with("1 run, 2 ensembles, 1 comparison, 1 sweep, 1 catalogue of hard cases."),
        "{told}"
    );
    let page = page(folder.path(), "pages/one/report.html");
    let summary: Value = serde_json::from_str(&self::page(folder.path(), "all/a run/summary.json")).unwrap();
    assert_eq!(summary["capture"]["captured"], false);
    assert!(page.contains("<h1>What &lt;came&gt;</h1>") && page.contains("rates &amp; masses"));
    // In the order of the page: the verdict, survival of both ensembles, then each result with what made it.
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text}"));
    let order =
        ["CAPTURED", "id=\"survival\"", "id=\"result-1\"", "id=\"result-1-strip\"", "id=\"result-6\""];
    assert!(order.map(place).is_sorted(), "{order:?}");
    let commands = page.matches("run scene.json --out").count();
    assert!(commands >= 1 && page.matches("<footer>").count() == 7, "{commands}");
    // Places are no two the same, and every link leads to one or to a file.
    let mut places = attributes(&page, " id");
    let n_places = places.len();
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), n_places);
    let links = attributes(&page, "<a href");
    assert!(links.contains(&"../../all/a%20run/replay.html"), "{links:?}");
    for link in links {
        match link.strip_prefix('#') {
            Some(place) => assert!(places.contains(&place), "{link}"),
            None => {
                let file = folder.path().join("pages/one").join(link.replace("%20", " "));
                assert!(file.is_file(), "{link}");
            }
        }
    }
}

#[test]
fn a_report_takes_one_result_and_refuses_what_is_none() {
    let folder = with_scene(|scene| {
        scene.as_object_mut().unwrap().remove("target");
        scene["duration_s"] = json!(0.05);
    });
    let folder = folder.path();
    printed(folder, &["run", "scene.json", "--out", "open"]);
    assert!(printed(folder, &["report", "open"]).starts_with("1 run."));
    // Another folder between two names of one.
    let twice = ["report", "open", "second", "./open", "--out", "twice"];
    printed(folder, &["run", "scene.json", "--out", "second"]);
    assert!(printed(folder, &twice).starts_with("2 runs."), "a folder that is named twice stands once");
    let page = page(folder, "results/report/report.html");
    assert!(page.contains("id=\"result-1-deployment\"") && !page.contains("id=\"survival\""));
    // All faults at once, and nothing is written.
    std::fs::create_dir_all(folder.join("empty/inner")).unwrap();
    std::fs::create_dir(folder.join("broken")).unwrap();
    write_json(folder, "broken/compare.json", &json!({}));
    std::fs::write(folder.join("broken/compare.html"), "<p>not ours</p>").unwrap();
    let output = tumblenet(folder, &["report", "open", "empty", "missing", "broken", "--out", "none"]);
    let told = err(&output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    for fault in ["empty", "missing", "broken.compare.html", "a page of another kind"] {
        assert!(told.contains(fault), "no {fault}: {told}");
    }
    assert!(!folder.join("none").exists());
}
