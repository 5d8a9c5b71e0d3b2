//! Test oracles and helpers, independent of the code they test.

#![allow(dead_code)] // each test binary uses its own part

pub mod program;

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use serde_json::{Value, json};
use tumblenet::cable::Cable;
use tumblenet::case::{Built, Case};
use tumblenet::limits::Limits;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::summary::Summary;
use tumblenet::net::Net;
use tumblenet::run::Run;
use tumblenet::scene::Source;
use tumblenet::solver::PAIRS;
use tumblenet::study::ensemble::{self, EnsembleRequest};

/// Asserts `value` < `bound`; `cargo test -- --nocapture` prints what was measured.
#[track_caller]
pub fn below(what: &str, value: f64, bound: f64) {
    println!("{what}: {value:.4e}, bound {bound:e}");
    assert!(value < bound, "{what}: {value:e}, bound {bound:e}");
}

/// A tool that a test needs beside Rust, if it is there. Without it the test is skipped with a word, but not
/// where `.ci/run` has installed it: a test that is always skipped tests nothing.
pub fn tool<T>(name: &str, found: Option<T>) -> Option<T> {
    if found.is_none() {
        assert!(std::env::var_os("CI").is_none(), "{name} is missing: `.ci/run` installs it");
        eprintln!("SKIPPED: {name} is not installed");
    }
    found
}

/// Asserts that `value` lies in a band; prints what was measured.
#[track_caller]
pub fn within(what: &str, value: f64, band: [f64; 2]) {
    println!("{what}: {value:.6}, band {band:?}");
    assert!((band[0]..=band[1]).contains(&value), "{what}: {value}, band {band:?}");
}

/// A built-in scene with `changes` as for `--set`, without what it expects.
pub fn scene(name: &str, changes: &[&str]) -> Case {
    let changes: Vec<String> =
        ["expect=null"].iter().chain(changes).map(|change| (*change).to_owned()).collect();
    Case::load(name, &changes).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Names of all pairs of cables and contact: a test that asks pairs asks these.
pub fn pairs() -> impl Iterator<Item = &'static str> {
    PAIRS.iter().map(|(_, _, name)| *name)
}

/// The pairs with which a whole capture takes a second, for tests of many captures: the engine's own and the
/// source's.
pub const FAST_PAIRS: [&str; 2] = ["joints+rapier", "explicit+impulse"];

/// A pair as changes for `--set`.
pub fn changes_of(pair: &str) -> [String; 2] {
    let (cables, contact) = pair.split_once('+').unwrap();
    [format!("solver.cables={cables}"), format!("solver.contact={contact}")]
}

/// A pair as a scene's `solver`.
pub fn solver_of(pair: &str) -> Value {
    let (cables, contact) = pair.split_once('+').unwrap();
    json!({ "cables": cables, "contact": contact })
}

/// A case from JSON.
pub fn case_of(json: Value) -> Case {
    Case::build(&source_of(json)).unwrap_or_else(|problems| panic!("{problems}"))
}

/// A scene that is not checked yet.
pub fn source_of(json: Value) -> Source {
    Source { name: "test".into(), input: "test".into(), folder: None, json, limits: Limits::default() }
}

/// A small net of 3 x 3 meshes, shot at 2 m/s; add a target, effects, a solver.
pub fn small_scene() -> Value {
    json!({
        "title": "small", "duration_s": 0.5,
        "net": { "meshes": [3, 3], "mesh_length_m": 0.1, "bullet_mass_kg": 0.03,
                 "cable": { "material": "nylon", "diameter_m": 0.001 } },
        "launch": { "speed_m_s": 2.0, "angle_deg": 25.0 }
    })
}

/// A run of `case` that must succeed.
pub fn run(case: &Case) -> Run {
    Run::of(case, |_| {}).unwrap_or_else(|failure| panic!("{}: {failure}", case.name()))
}

/// Largest energy that the books do not close by, whatever the method made or destroyed, over the launch energy [-].
pub fn unbooked(case: &Case, run: &Run) -> f64 {
    let unbooked = run.frames.ledger.iter().map(|ledger| ledger.unbooked().abs());
    unbooked.fold(0.0, f64::max) / case.net().launch_energy()
}

/// The summary of a run of `case`.
pub fn summary(case: &Case) -> Summary {
    let run = run(case);
    Summary::of(case, &run, &Curves::of(case, &run))
}

/// Summaries of `members` copies of `case`, perturbed by 1e-6 m as `tumblenet run --ensemble` does.
pub fn ensemble(case: &Case, members: usize) -> Vec<Summary> {
    let request = EnsembleRequest { members, perturb_m: 1e-6, seed: 1, at_most_s: None };
    let members = ensemble::run(case, &request, Vec::new(), |_| {});
    members.into_iter().map(|m| m.outcome.unwrap_or_else(|why| panic!("{}: {why}", case.name()))).collect()
}

/// How many of an ensemble are captured.
pub fn captured(members: &[Summary]) -> usize {
    members.iter().filter(|summary| summary.capture.is_some_and(|capture| capture.captured)).count()
}

/// Least, median and largest of a number of the summaries, named as in `expect.within`.
pub fn spread(members: &[Summary], name: &str) -> [f64; 3] {
    let mut values = values(members, name);
    values.sort_by(f64::total_cmp);
    [values[0], values[values.len() / 2], values[values.len() - 1]]
}

/// A scalar of every member.
pub fn values(members: &[Summary], name: &str) -> Vec<f64> {
    let of = |summary: &Summary| {
        let scalars = summary.scalars();
        scalars.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no {name}")).1
    };
    members.iter().map(of).collect()
}

/// `case` with what `change` makes of its net, target and step.
pub fn changed(case: Case, change: impl FnOnce(&mut Built)) -> Case {
    case.changed(change).unwrap_or_else(|problems| panic!("{problems}"))
}

/// The same case with everything turned about the origin.
pub fn in_turned_frame(case: &Case, turn: &Rotation3<f64>) -> Case {
    changed(case.clone(), |built| {
        for vector in built.net.folded.iter_mut().chain(&mut built.net.launch_velocity) {
            *vector = turn * *vector;
        }
        if let Some(target) = &mut built.target {
            target.position = turn * target.position;
            target.attitude = UnitQuaternion::from_rotation_matrix(turn) * target.attitude;
        }
    })
}

/// Free knots without cables: (mass [kg], position [m], velocity [m/s]), of radius 0.5 mm.
pub fn knots(knots: &[(f64, [f64; 3], [f64; 3])]) -> Net {
    Net {
        grid: [knots.len(), 1],
        mass: knots.iter().map(|knot| knot.0).collect(),
        young_modulus: vec![4.456e8; knots.len()],
        radius: vec![5e-4; knots.len()],
        cables: [].into(),
        bullets: [0; 4],
        perimeter: vec![0],
        designed_area: 1.0,
        folded: knots.iter().map(|knot| knot.1.into()).collect(),
        folded_inwards: false,
        launch_velocity: knots.iter().map(|knot| knot.2.into()).collect(),
        delay: [0.0; 4],
    }
}

/// Ties two knots of `net` by a cable of natural frequency `omega` [rad/s] and damping ratio `zeta`.
pub fn tie(net: &mut Net, [a, b]: [usize; 2], rest_length: f64, omega: f64, zeta: f64) {
    let reduced_mass = net.mass[a] * net.mass[b] / (net.mass[a] + net.mass[b]);
    let cable = Cable {
        a,
        b,
        rest_length,
        stiffness: reduced_mass * omega * omega,
        damping: 2.0 * zeta * reduced_mass * omega,
        mass: 0.0,
        reduced_mass,
        breaking_tension: f64::INFINITY,
    };
    net.cables = net.cables.iter().copied().chain([cable]).collect();
}

/// The net of `net` as Eq. 3.1 to 3.5 state it, integrated by classical RK4 with a fixed step.
///
/// Written from the equations, sharing no code with the solvers: the tension law, the assembly and
/// the integration are its own. Returns positions of all knots at each of `times` [s].
///
/// Eq. 3.3 jumps by c ṙ where a cable goes taut, so the method is of first order across a switch;
/// at 5 us its bullets agree with those at 2.5 us to 1e-5 m at 0.5 s on the Table 3.2 net.
pub fn rk4_net(net: &Net, step: f64, times: &[f64]) -> Vec<Vec<Vector3<f64>>> {
    let n = net.n_knots();
    let mut x = net.folded.clone();
    let mut v = net.launch_velocity.clone();
    let mut frames = Vec::new();
    let mut k: Vec<[Vec<Vector3<f64>>; 2]> = vec![[vec![Vector3::zeros(); n], vec![Vector3::zeros(); n]]; 4];
    let (mut xs, mut vs) = (x.clone(), v.clone());
    let n_steps = (times.last().copied().unwrap_or(0.0) / step).round() as u64;
    for i in 0..=n_steps {
        if times.iter().any(|t| (t / step).round() as u64 == i) {
            frames.push(x.clone());
        }
        for stage in 0..4 {
            if stage == 0 {
                xs.clone_from(&x);
                vs.clone_from(&v);
            } else {
                let h = if stage == 3 { step } else { 0.5 * step };
                for j in 0..n {
                    xs[j] = x[j] + h * k[stage - 1][0][j];
                    vs[j] = v[j] + h * k[stage - 1][1][j];
                }
            }
            k[stage][0].clone_from(&vs);
            accelerations(net, &xs, &vs, &mut k[stage][1]);
        }
        for j in 0..n {
            let sum = |d: usize| k[0][d][j] + 2.0 * k[1][d][j] + 2.0 * k[2][d][j] + k[3][d][j];
            x[j] += step / 6.0 * sum(0);
            v[j] += step / 6.0 * sum(1);
        }
    }
    frames
}

fn accelerations(net: &Net, x: &[Vector3<f64>], v: &[Vector3<f64>], a: &mut [Vector3<f64>]) {
    a.iter_mut().for_each(|a| *a = Vector3::zeros());
    for c in net.cables.iter() {
        let d = x[c.b] - x[c.a];
        let r = d.norm();
        if r > c.rest_length {
            let n = d / r;
            let f = c.stiffness * (r - c.rest_length) + c.damping * n.dot(&(v[c.b] - v[c.a]));
            if f > 0.0 {
                a[c.a] += n * (f / net.mass[c.a]);
                a[c.b] -= n * (f / net.mass[c.b]);
            }
        }
    }
}
