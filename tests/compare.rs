//! `tumblenet compare` as a user runs it.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn compare(out: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_tumblenet");
    Command::new(program).arg("compare").args(arguments).arg("--out").arg(out).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn read(out: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(out.join("compare.json")).unwrap()).unwrap()
}

/// Up to just after first contact, which is at 0.77 s.
const SHORT: [&str; 7] =
    ["cubesat-free", "--set", "duration_s=0.85", "--members", "2", "--vary", "solver.sweeps=2,12"];

#[test]
fn two_variants_are_compared_written_and_kept() {
    let out = tempfile::tempdir().unwrap();
    let done = compare(out.path(), &SHORT);
    assert!(done.status.success(), "{}", said(&done));
    let text = String::from_utf8(done.stdout).unwrap();
    assert!(text.contains("solver.sweeps=12") && text.contains("trusted"), "{text}");

    let first = read(out.path());
    assert_eq!(first["base"], "solver.sweeps=2");
    let (base, other) = (&first["variants"][0]["outcome"], &first["variants"][1]["outcome"]);
    assert_eq!(base["own"]["pairs"], 1);
    assert!(base.get("against_base").is_none(), "the base is not compared with itself");
    let against = &other["against_base"];
    assert_eq!(against["separation"]["pairs"], 2);
    // Measured 1.2 mm: more sweeps, the same physics.
    let mean = against["separation"]["whole"]["all_m"]["mean"].as_f64().unwrap();
    assert!(mean > 0.0 && mean < 0.01, "{mean}");
    // Measured 0.5 ms.
    assert!(against["first_contact_s"]["median"].as_f64().unwrap().abs() < 0.005);
    assert!(against["over_chaos"].as_f64().unwrap() > 0.0);
    assert_eq!(base["captured"]["of"], 2);
    let frames = base["curves"]["time_s"].as_array().unwrap().len();
    assert_eq!(frames, 86);
    assert_eq!(base["curves"]["impulse_n_s"]["max"].as_array().unwrap().len(), frames);

    let page = std::fs::read_to_string(out.path().join("compare.html")).unwrap();
    for name in ["bullet-differences", "difference-over-time", "capture", "contact-response", "energy"]
        .into_iter()
        .chain(["momentum", "verdicts", "wall-time"])
    {
        let svg = std::fs::read_to_string(out.path().join(name).with_extension("svg")).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        assert!(page.contains(&svg), "{name} stands in the page");
    }
    assert!(!page.contains("{{") && !page.contains("http://www.w3.org/1999"), "no gap is left");

    // Nothing is run twice: the same command tells the same wall times.
    assert!(compare(out.path(), &SHORT).status.success());
    let again = read(out.path());
    assert_eq!(again["variants"][1]["outcome"]["scalars"], other["scalars"]);
    assert_eq!(again["variants"][1]["outcome"]["against_base"], *against);
}

/// What does not apply is left out, and does not end the comparison.
#[test]
fn a_deployment_of_one_member_is_compared_without_target_and_chaos() {
    let out = tempfile::tempdir().unwrap();
    let short = ["deployment-kevlar", "--set", "duration_s=0.1", "--members", "1", "--serial"];
    let done = compare(out.path(), &[&short[..], &["--vary", "solver.step_s=0.0005,0.001"]].concat());
    assert!(done.status.success(), "{}", said(&done));
    let json = read(out.path());
    assert_eq!(json["runs_at_once"], 1);
    let (base, other) = (&json["variants"][0]["outcome"], &json["variants"][1]["outcome"]);
    assert!(base.get("own").is_none() && base.get("captured").is_none());
    assert!(other["against_base"]["over_chaos"].is_null());
    assert!(!out.path().join("verdicts.svg").exists() && out.path().join("capture.svg").exists());
    // A table of free flights, with what a sub-step of twice the length costs beside one of the base.
    let text = String::from_utf8(done.stdout.clone()).unwrap();
    assert!(text.contains("travelling") && text.contains("sub-steps"), "{text}");
}

#[test]
fn bad_arguments_end_with_status_2_and_say_what_is_allowed() {
    let out = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &str); 8] = [
        (&["nowhere"], "a built-in scene"),
        (&["cubesat-free", "--solvers", "joints+magic"], "pairs out of joints+rapier"),
        (&["cubesat-free", "--solvers", ""], "pairs out of joints+rapier"),
        (&["cubesat-free", "--vary", "solver.sweep=1,2"], "solver.sweep: found an unknown key"),
        (&["cubesat-free", "--vary", "net.meshes.9=1,2"], "no entry 9"),
        (&["cubesat-free", "--vary", "solver.sweeps="], "where a value is empty"),
        (&["cubesat-free", "--members", "0"], "--members"),
        (&["cubesat-free", "--trust-distance", "-1"], "a number of metres"),
    ];
    for (arguments, words) in cases {
        let done = compare(out.path(), arguments);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}");
        assert!(said(&done).contains(words), "{words:?} not in {:?}", said(&done));
    }
    assert_eq!(std::fs::read_dir(out.path()).unwrap().count(), 0, "nothing is written");
}
