//! `tumblenet optimise`: rounds that are kept, a gain in pairs, faults at once.

use std::path::Path;

use crate::common::program::{folder_with, printed, tiny_capture, tumblenet};
use serde_json::{Value, json};

/// A study of a tiny net whose bullets and target are uncertain, in a folder of its own.
fn folder(change: impl FnOnce(&mut Value)) -> tempfile::TempDir {
    let mut scene = tiny_capture();
    scene["uncertain"] = json!([{ "path": "target.spin_rad_s", "direction": { "length": [0, 3] } }]);
    let mut study = json!({
        "title": "a small search", "scene": "scene.json", "solver": "explicit+impulse",
        "parameters": [
            { "path": "launch.speed_m_s", "uniform": [1.5, 3] },
            { "path": "target.mass_kg", "log_uniform": [0.1, 10] }
        ],
        "design": { "kind": "sobol", "points": 8 }, "seed": 5
    });
    change(&mut study);
    folder_with(&[("scene.json", &scene), ("study.json", &study)])
}

const SEARCH: [&str; 7] =
    ["optimise", "study.json", "--outcome=captured", "--rounds=3", "--confirm=6", "--out", "o"];

fn found(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("o/optimised.json")).unwrap()).unwrap()
}

fn column(folder: &Path, out: &str, name: &str) -> Vec<String> {
    printed(folder, &["sweep", "merge", out]);
    let mut table = csv::Reader::from_path(folder.join(out).join("table.csv")).unwrap();
    let column = table.headers().unwrap().iter().position(|known| known == name).unwrap();
    table.records().map(|row| row.unwrap()[column].to_owned()).collect()
}

#[test]
fn a_search_goes_on_where_it_stopped_and_ends_the_same() {
    let folder = folder(|_| {});
    let folder = folder.path();
    printed(folder, &SEARCH);
    let first = found(folder);
    for (number, round) in first["rounds"].as_array().unwrap().iter().enumerate() {
        let [speed, mass] =
            [0, 1].map(|axis| -> [f64; 2] { serde_json::from_value(round["within"][axis].clone()).unwrap() });
        let narrower = 0.5_f64.powi(number as i32);
        assert!((speed[1] - speed[0] - 1.5 * narrower).abs() < 1e-9, "{round}");
        assert!(((mass[1] / mass[0]).ln() - 100_f64.ln() * narrower).abs() < 1e-9, "{round}");
        let name = format!("o/round-{}", number + 1);
        let inside = |[low, high]: [f64; 2], path: &str| {
            let at = column(folder, &name, path).into_iter().map(|text| text.parse::<f64>().unwrap());
            at.into_iter().all(|at| (low..=high).contains(&at))
        };
        assert!(inside(speed, "input.launch.speed_m_s") && inside(mass, "input.target.mass_kg"), "{round}");
    }
    // What was confirmed: the last best point, and the scene, with the same draws.
    let best = &first["rounds"][2]["best"];
    assert_eq!(best[0], first["parameters"][0]["best"]);
    let confirmed: f64 = column(folder, "o/best", "input.launch.speed_m_s")[0].parse().unwrap();
    assert_eq!(confirmed, best[0].as_f64().unwrap());
    let drawn = ["scene", "best"].map(|of| column(folder, &format!("o/{of}"), "drawn.target.spin_rad_s.0"));
    assert_eq!(drawn[0], drawn[1]);
    assert_eq!(drawn[0].iter().collect::<std::collections::BTreeSet<_>>().len(), 6, "{drawn:?}");
    let captured = column(folder, "o/scene", "captured").iter().filter(|text| *text == "true").count();
    assert_eq!(first["of_scene"]["captured"], captured);

    // A round that was lost comes again, and with it everything.
    std::fs::remove_dir_all(folder.join("o/round-2")).unwrap();
    printed(folder, &SEARCH);
    assert_eq!(found(folder), first);
    let page = std::fs::read_to_string(folder.join("o/optimised.html")).unwrap();
    assert!(page.contains("launch.<wbr>speed_<wbr>m_<wbr>s") && page.contains("<svg"), "{page}");
}

#[test]
fn what_cannot_be_looked_for_is_told_at_once() {
    let folder = folder(|study| {
        study["design"] = json!({ "kind": "grid" });
        study["parameters"] = json!([
            { "path": "launch.speed_m_s", "values": [1.5, 2] },
            { "path": "net.middle_knots", "values": [0, 1] }
        ]);
    });
    let output = tumblenet(folder.path(), &SEARCH);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    for part in
        ["design.kind", "\"sobol\"", "parameters[0]", "parameters[1]", "\"uniform\" or \"log_uniform\""]
    {
        assert!(said.contains(part), "{said}");
    }
    assert!(!folder.path().join("o").exists());
}
