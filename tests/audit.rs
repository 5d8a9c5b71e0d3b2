//! An auditor that shares no code with the program: `tests/audit.py` sums up energy, momenta, depths and knots behind
//! plates from `trajectory.npz` and the scene alone.
//!
//! It needs Python with numpy. Without them it is skipped with a word, but not under `.ci/run`, which installs them.

use crate::common;

use std::process::{Command, Output};

const AUDITOR: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/audit.py");
const PROGRAM: &str = env!("CARGO_BIN_EXE_tumblenet");

/// What the auditor says; nothing where it cannot run.
fn audit(arguments: &[&str]) -> Option<Output> {
    // The first in the path may not be the system's, which packages bring numpy to.
    let has_numpy = |python: &&str| {
        let found = Command::new(python).args(["-c", "import numpy"]).output();
        found.is_ok_and(|output| output.status.success())
    };
    let python = ["python3", "/usr/bin/python3"].into_iter().find(has_numpy);
    let python = common::tool("python3 with numpy", python)?;
    let output = Command::new(python).arg(AUDITOR).args(arguments).output().expect("the auditor starts");
    println!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    Some(output)
}

/// Twenty scenes under every pair, with coarse nets started near their targets.
#[test]
fn an_auditor_that_shares_no_code_finds_nothing() {
    if let Some(output) = audit(&["all", PROGRAM]) {
        let told = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{told}");
        assert!(told.contains("100 runs, 0 with a fault"), "{told}");
        // What touches nothing shows nothing of contact: 18 scenes of 20 have a target.
        let touched = told.lines().filter(|line| line.contains("touched ") && !line.contains("touched 0"));
        assert!(touched.count() >= 80, "{told}");
    }
}

/// Undamped cables and semi-implicit Euler at its own step make a tenth of the launch energy.
#[test]
fn the_auditor_finds_energy_that_was_created() {
    let mut scene = common::small_scene();
    scene["net"]["cable"]["damping_ratio"] = 0.0.into();
    scene["solver"] =
        serde_json::json!({ "cables": "explicit", "contact": "impulse", "integrator": "symplectic" });
    let folder = tempfile::tempdir().unwrap();
    let [file, out] = ["scene.json", "out"].map(|name| folder.path().join(name));
    std::fs::write(&file, scene.to_string()).unwrap();
    let run = Command::new(PROGRAM).arg("run").arg(&file).arg("--out").arg(&out).output().unwrap();
    assert_eq!(run.status.code(), Some(1), "the program says so itself");
    if let Some(output) = audit(&["check", file.to_str().unwrap(), out.to_str().unwrap()]) {
        assert_eq!(output.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&output.stdout).contains("FAULT: energy rises"));
    }
}
