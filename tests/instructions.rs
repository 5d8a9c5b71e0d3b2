//! A scene without effects pays for none, counted in instructions of the processor.
//!
//! The count is callgrind's: exact and the same on every run, as times are not. Where valgrind is not
//! installed the count is skipped; that both loops do the same is tested everywhere.

#[path = "common/bare.rs"]
mod bare;
mod common;

use std::process::Command;

use bare::Bare;
use common::{below, case_of, small_scene};
use serde_json::json;
use tumblenet::case::Case;
use tumblenet::simulation::Simulation;

/// A net as small as nets get, so that a call too many shows: 16 knots around a box.
fn case(solver: &str) -> Case {
    let mut scene = small_scene();
    scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [0.08, 0.25, 0.15] }] }, "distance_m": 0.3, "mass_kg": 1.0 });
    let (cables, contact) = solver.split_once('+').unwrap();
    scene["solver"] = json!({ "cables": cables, "contact": contact });
    case_of(scene)
}

const SOLVERS: [&str; 2] = ["joints+rapier", "explicit+impulse"];

/// Steps that are counted; the net meets the box within them.
const STEPS: usize = 600;

#[inline(never)]
fn counted_without_hooks(bare: &mut Bare) {
    for _ in 0..STEPS {
        bare.step();
    }
}

#[inline(never)]
fn counted_with_hooks(simulation: &mut Simulation) {
    for _ in 0..STEPS {
        simulation.step().expect("numbers");
    }
}

#[test]
fn both_loops_do_the_same() {
    for solver in SOLVERS {
        let case = case(solver);
        let (mut bare, mut simulation) = (Bare::new(&case), Simulation::new(&case));
        counted_without_hooks(&mut bare);
        counted_with_hooks(&mut simulation);
        assert_eq!(bare.knots(), simulation.state.knots.position, "{solver}");
        assert!(simulation.work.contacts > 0, "{solver}");
    }
}

/// What is counted: run under callgrind by the test below.
#[test]
#[ignore = "a workload, not a test"]
fn workload() {
    let solver = std::env::var("TUMBLENET_WORKLOAD").expect("the solver");
    let case = case(&solver);
    counted_without_hooks(&mut Bare::new(&case));
    counted_with_hooks(&mut Simulation::new(&case));
}

/// Instructions within the functions whose names contain `function`.
fn instructions(function: &str, solver: &str) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let counts = folder.path().join("counts");
    let output = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg(format!("--callgrind-out-file={}", counts.display()))
        .arg(format!("--toggle-collect=*{function}*"))
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "workload", "--ignored", "--test-threads=1"])
        .env("TUMBLENET_WORKLOAD", solver)
        .output()
        .expect("valgrind starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let counts = std::fs::read_to_string(counts).unwrap();
    let totals = counts.lines().find_map(|line| line.strip_prefix("totals: ")).expect("a total");
    totals.trim().parse().unwrap()
}

#[test]
fn hooks_of_effects_cost_a_scene_without_effects_less_than_a_percent() {
    if Command::new("valgrind").arg("--version").output().is_err() {
        eprintln!("SKIPPED: valgrind is not installed, so instructions cannot be counted");
        return;
    }
    for solver in SOLVERS {
        let without = instructions("counted_without_hooks", solver);
        let with = instructions("counted_with_hooks", solver);
        println!(
            "{solver}: {:.0} instructions a step without hooks, {:.0} with",
            without / STEPS as f64,
            with / STEPS as f64
        );
        assert!(without > 1e6, "{solver}: {without} instructions counted");
        below(solver, (with / without - 1.0).abs(), 0.01);
    }
}
