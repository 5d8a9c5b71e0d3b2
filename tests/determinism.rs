//! Same input, same bits.

mod common;

use common::scene;
use tumblenet::case::Case;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::summary::Summary;
use tumblenet::report::results;
use tumblenet::run::Run;
use tumblenet::study::ensemble::{self, Member, Request};

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
    let request = Request { members: 4, perturb_m: 1e-6, seed: 7 };
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
        ensemble::perturbed(&case, &Request { members, perturb_m: 1e-6, seed }, member).net.folded
    };
    assert_eq!(folded(4, 1, 3), folded(100, 1, 3));
    assert_ne!(folded(4, 1, 3), folded(4, 1, 2));
    assert_ne!(folded(4, 1, 3), folded(4, 2, 3));
    let moved = folded(4, 1, 3).iter().zip(&case.net.folded).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
    assert!((0.5e-6..=1e-6 + 1e-15).contains(&moved), "{moved}");
}
