//! Same input, same bits.

use std::collections::BTreeMap;
use std::path::Path;

use crate::common;
use crate::common::scene;
use rayon::prelude::*;
use tumblenet::assets::Kind;
use tumblenet::case::Case;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::summary::Summary;
use tumblenet::report::results;
use tumblenet::run::Run;
use tumblenet::study::ensemble::{self, EnsembleRequest, Member};

/// Half a second past the first contact of a tumbling Cubesat.
fn capture() -> Case {
    scene("cubesat-spin-x-0.5", &["duration_s=1.3"])
}

/// The bytes of a result file of a fresh run.
fn written(case: &Case, name: &str) -> Vec<u8> {
    let run: Run = common::run(case);
    let curves = Curves::of(case, &run);
    let folder = tempfile::tempdir().unwrap();
    let summary = Summary::of(case, &run, &curves);
    results::write(folder.path(), case, &run, &curves, &summary).unwrap();
    assert!(run.work.contacts > 1000, "{:?}", run.work);
    std::fs::read(folder.path().join(name)).unwrap()
}

#[test]
fn the_same_scene_twice_writes_the_same_trajectory() {
    let case = capture();
    let (first, second) = (written(&case, "trajectory.npz"), written(&case, "trajectory.npz"));
    assert!(first.len() > 100_000);
    assert_eq!(first, second);
}

/// What a member says, without what the machine adds: wall time and its shares.
fn timeless(members: Vec<Member>) -> Vec<Member> {
    let strip = |mut member: Member| {
        if let Ok(summary) = &mut member.outcome {
            summary.wall_s = 0.0;
            summary.time_shares.clear();
        }
        member
    };
    members.into_iter().map(strip).collect()
}

#[test]
fn an_ensemble_does_not_depend_on_the_number_of_threads() {
    let case = capture();
    let request = EnsembleRequest { members: 4, perturb_m: 1e-6, seed: 7, at_most_s: None };
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        timeless(pool.install(|| ensemble::run(&case, &request, Vec::new(), |_| {})))
    };
    assert_eq!(with_threads(1), with_threads(2));
}

/// A member is the same whatever the size of the ensemble, and members differ from each other.
#[test]
fn a_member_depends_on_its_number_and_seed_only() {
    let case = capture();
    let folded = |members, seed, member| {
        ensemble::perturbed(
            &case,
            &EnsembleRequest { members, perturb_m: 1e-6, seed, at_most_s: None },
            member,
        )
        .net()
        .folded
        .clone()
    };
    assert_eq!(folded(4, 1, 3), folded(100, 1, 3));
    assert_ne!(folded(4, 1, 3), folded(4, 1, 2));
    assert_ne!(folded(4, 1, 3), folded(4, 2, 3));
    let moved =
        folded(4, 1, 3).iter().zip(&case.net().folded).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
    assert!((0.5e-6..=1e-6 + 1e-15).contains(&moved), "{moved}");
}

/// Hashes of last states, as committed.
const HASHES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/state_hashes.json");

/// Runs whose last state is hashed: every built-in scene for 0.3 s, and some past the first contact,
/// one for each method and width of numbers, and with all that touches.
fn hashed() -> Vec<(&'static str, String)> {
    let short = Kind::Scene.names().into_iter().map(|name| (name, "duration_s=0.3".to_owned()));
    let tube = ("cubesat-spin-x-2.0-tube", "duration_s=1.5".to_owned());
    let others = [
        "cables=explicit contact=impulse",
        "cables=explicit contact=penalty",
        "cables=joints contact=impulse",
        "flight=explicit substeps=4",
        "precision=f32",
    ];
    let past_contact = others.map(|solver| {
        let changes: Vec<_> = solver.split(' ').map(|change| format!("solver.{change}")).collect();
        ("cubesat-free", format!("duration_s=0.9 {}", changes.join(" ")))
    });
    // Everything that touches at once.
    let effects = r#"effects.cable_contact={} effects.self_contact={} effects.friction={"coefficient":0.3}"#;
    let touching = ["explicit+impulse", "explicit+penalty"].map(|pair| {
        let changes = format!("duration_s=1.2 {} {effects}", common::changes_of(pair).join(" "));
        ("cubesat-spin-x-2.0-tube", changes)
    });
    // Elements take short steps: a small net, shot onto a target close by.
    let elements = ["impulse", "penalty"].map(|contact| {
        let solver = format!("solver.cables=ancf solver.contact={contact}");
        let near = "duration_s=0.08 capture.hold_s=0 net.meshes=[3,3] target.distance_m=0.15";
        ("cubesat-spin-x-2.0-tube", format!(r#"{near} {solver} effects.friction={{"coefficient":0.3}}"#))
    });
    // Steps that resolve cables of the engine.
    let resolved = ("deployment-kevlar", "duration_s=0.08 solver.step_s=1e-5".to_owned());
    short.chain([tube, resolved]).chain(touching).chain(elements).chain(past_contact).collect()
}

/// A change of method changes hashes, and nothing else may: not the threads, not the profile, not
/// the day. `RENEW=1 cargo test --test suite determinism::` writes them anew; say in the commit why.
///
/// The mathematics of the platform (sines, roots) enters, so they are those of Linux on x86-64.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn last_states_have_the_hashes_that_were_committed() {
    let with_threads = |threads: usize, runs: &[(&'static str, String)]| -> BTreeMap<String, String> {
        let hash = |(name, changes): &(&str, String)| {
            let changes: Vec<&str> = changes.split(' ').collect();
            (format!("{name} {}", changes.join(" ")), common::run(&scene(name, &changes)).state_hash)
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| runs.par_iter().map(hash).collect())
    };
    let runs = hashed();
    let found = with_threads(3, &runs);
    let alone = with_threads(1, &runs[runs.len() - 6..]);
    assert!(alone.iter().all(|(run, hash)| found[run] == *hash), "one thread: {alone:#?}, three: {found:#?}");
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(Path::new(HASHES), serde_json::to_string_pretty(&found).unwrap() + "\n").unwrap();
    }
    let known: BTreeMap<String, String> =
        serde_json::from_str(&std::fs::read_to_string(HASHES).unwrap()).unwrap();
    let changed: Vec<_> = found.iter().filter(|(run, hash)| known.get(*run) != Some(hash)).collect();
    assert!(
        changed.is_empty(),
        "RENEW=1 cargo test --test suite determinism::, if the method changed: {changed:#?}"
    );
    assert_eq!(known.len(), found.len(), "hashes of runs that are no more");
}
