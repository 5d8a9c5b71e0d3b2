//! A scene without effects pays for none, counted in instructions of the processor.
//!
//! The count is callgrind's, the same on every run but for what hangs on
//! addresses: seeds of hash maps, and loops that check whether their arrays overlap (up to 3e-3 where the net is
//! explicit). Where valgrind is not installed the count is skipped, but not under `.ci/run`; that both loops do
//! the same is tested everywhere.

#[path = "common/bare.rs"]
mod bare;
mod common;

use std::process::Command;

use bare::Bare;
use common::{FAST_PAIRS, below, case_of, small_scene};
use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::simulation::Simulation;

/// A net as small as nets get, so that a call too many shows: 16 knots around a box.
fn case(solver: &str, effects: Value) -> Case {
    let mut scene = small_scene();
    scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [0.08, 0.25, 0.15] }] }, "distance_m": 0.3, "mass_kg": 1.0 });
    scene["effects"] = effects;
    let (cables, contact) = solver.split_once('+').unwrap();
    scene["solver"] = json!({ "cables": cables, "contact": contact });
    case_of(scene)
}

/// Steps that are counted; the net meets the box within them.
const STEPS: usize = 400;

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
    for solver in FAST_PAIRS {
        let case = case(solver, json!({}));
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
    let of = |name: &str| std::env::var(name).expect("set by the test below");
    let effects: Value = serde_json::from_str(&of("TUMBLENET_EFFECTS")).unwrap();
    let solver = of("TUMBLENET_SOLVER");
    counted_without_hooks(&mut Bare::new(&case(&solver, json!({}))));
    counted_with_hooks(&mut Simulation::new(&case(&solver, effects)));
}

/// Instructions a step without hooks and, with `effects`, with them.
fn instructions(solver: &str, effects: &Value) -> [f64; 2] {
    let folder = tempfile::tempdir().unwrap();
    let counts = folder.path().join("counts");
    let output = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg(format!("--callgrind-out-file={}", counts.display()))
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "workload", "--ignored", "--test-threads=1"])
        .env("TUMBLENET_SOLVER", solver)
        .env("TUMBLENET_EFFECTS", effects.to_string())
        .output()
        .expect("valgrind starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let counts = std::fs::read_to_string(counts).unwrap();
    ["counted_without_hooks", "counted_with_hooks"]
        .map(|function| inclusive(&counts, function) / STEPS as f64)
}

/// Instructions of the one call of `function` with all it calls, in callgrind's format: `(7) name` where a
/// name is first met and `(7)` from then on; below `cfn=(7)` a line on the call, then one that ends with the
/// count.
fn inclusive(counts: &str, function: &str) -> f64 {
    let named = counts.lines().find(|line| line.ends_with(function)).expect("the function");
    let number = &named[named.find('(').unwrap()..=named.find(')').unwrap()];
    let mut lines = counts.lines().skip_while(|line| !line.starts_with(&format!("cfn={number}")));
    let count = lines.nth(2).and_then(|line| line.split(' ').next_back()).expect("a count");
    count.parse().unwrap()
}

#[test]
fn hooks_of_effects_cost_a_scene_without_effects_less_than_a_percent() {
    let valgrind = Command::new("valgrind").arg("--version").output().ok();
    if common::tool("valgrind", valgrind).is_none() {
        return;
    }
    for solver in FAST_PAIRS {
        // The least of two runs: see above.
        let [one, other] = [(); 2].map(|()| instructions(solver, &json!({})));
        let (without, with) = (one[0].min(other[0]), one[1].min(other[1]));
        println!("{solver}: {without:.0} instructions a step without hooks, {with:.0} with");
        below(solver, (with / without - 1.0).abs(), 0.01); // measured 5e-4 and 3e-3
    }
    // The count does see an effect: two kicks a step on 16 knots.
    let [none, orbit] = instructions(FAST_PAIRS[1], &json!({ "orbit": { "altitude_m": 7e5 } }));
    println!("{}: {none:.0} instructions a step, {orbit:.0} on an orbit", FAST_PAIRS[1]);
    assert!(orbit > 1.02 * none);
}
