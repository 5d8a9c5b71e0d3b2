//! The closing mechanism: what its thread, winches, triggers and layouts must show in whole runs, and whether
//! it holds. Unit tests of the constraint stand in `core/src/closing`.

use crate::common;

use std::sync::OnceLock;

use crate::common::{FAST_PAIRS, below, captured, changes_of, ensemble, scene, unbooked, within};
use nalgebra::{Vector3, vector};
use rayon::prelude::*;
use tumblenet::case::Case;
use tumblenet::closing::layouts::Route;
use tumblenet::closing::thread::{Ends, Node};
use tumblenet::closing::winch::Drive;
use tumblenet::closing::{Line, Mechanism};
use tumblenet::effects::closing::ClosingSummary;
use tumblenet::interaction::SubstepConstraint;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::summary::Summary;
use tumblenet::run::Run;
use tumblenet::solver::CableModel;
use tumblenet::state::Knots;

const LAYOUTS: [&str; 4] = ["tube", "interlaced", "free", "cinch"];

/// A run with its summary.
struct Done {
    name: String,
    case: Case,
    run: Run,
    summary: Summary,
}

impl Done {
    fn of(name: &str, changes: &[&str]) -> Done {
        let case = scene(name, changes);
        let run = common::run(&case);
        let summary = Summary::of(&case, &run, &Curves::of(&case, &run));
        Done { name: format!("{name} {changes:?}"), case, run, summary }
    }

    fn closing(&self) -> ClosingSummary {
        self.summary.effect_blocks.get("closing").unwrap().expect("the scene has a closing mechanism")
    }

    fn limit(&self) -> f64 {
        self.case.scene().effects.closing.expect("the scene has a closing mechanism").max_tension_n.0
    }

    /// A reading of every thread.
    fn threads(&self, reading: &str) -> Vec<Vec<f64>> {
        let n_threads: usize = self.run.reports.iter().map(|(_, report)| report.threads.len()).sum();
        (1..=n_threads).map(|n| self.run.reading(&format!("thread_{n}_{reading}"))).collect()
    }
}

/// The Cubesat about x with every layout under both pairs: 1.6 s cover contact, closing and the jerk
/// of the bullets when they meet.
fn closings() -> &'static [Done] {
    static SHARED: OnceLock<Vec<Done>> = OnceLock::new();
    SHARED.get_or_init(|| {
        let all: Vec<_> = LAYOUTS.iter().flat_map(|layout| FAST_PAIRS.map(|pair| (*layout, pair))).collect();
        let one = |(layout, pair): (&str, &str)| {
            let layout = format!("effects.closing.layout={layout}");
            let [cables, contact] = changes_of(pair);
            Done::of("cubesat-spin-x-2.0-tube", &["duration_s=1.6", &layout, &cables, &contact])
        };
        all.into_par_iter().map(one).collect()
    })
}

/// n free knots in a row on one thread between two winches: the thread's tension is the same all
/// along, so that the knots between feel nothing and both ends close alike. Up to the reel speed v the
/// ends move at T t / m, from then on at v; the winches' work is T times the length wound in.
#[test]
fn a_row_of_free_knots_closes_as_the_closed_form_says() {
    let (mass, gap, speed, tension, step) = (0.2, 0.05, 0.5, 0.4, 1e-4);
    for n in [2, 5, 40] {
        let position: Vec<Vector3<f64>> = (0..n).map(|i| vector![0.0, gap * i as f64, 0.0]).collect();
        let full_length = gap * (n - 1) as f64;
        let route =
            Route { nodes: (0..n).map(Node::Knot).collect(), ends: Ends::Both, winches: 2, full_length };
        let drive = Drive { winches: 2.0, speed, tension, reel_mass: 0.0, stop_share: 0.0 };
        let mut mechanism = Mechanism::new(vec![Line::new(&route, drive, 0.0, 0.0)], None, &vec![mass; n]);
        let mut knots = Knots { velocity: vec![Vector3::zeros(); n], position };
        mechanism.start(&knots);
        let ramp = mass * speed / tension; // 0.25 s; the ends meet their neighbours later than this
        let n_steps = if n == 2 { 300 } else { 500 };
        let mut wound_before = 0.0;
        for i in 1..=n_steps {
            mechanism.solve(&mut knots, step, &mut vec![false; n]);
            for (x, v) in knots.position.iter_mut().zip(&knots.velocity) {
                *x += step * v;
            }
            let _ = mechanism.account(&knots);
            let time = step * f64::from(i);
            let expected = (tension * time / mass).min(speed);
            assert!(time < ramp, "the closed form below is that of the ramp");
            assert!((knots.velocity[0].y - expected).abs() < 1e-9, "{n} knots at {time} s");
            assert!((knots.velocity[n - 1].y + expected).abs() < 1e-9);
            assert!(knots.velocity[1..n - 1].iter().all(|v| v.norm() < 1e-12), "equal tension");
            let momentum: Vector3<f64> = knots.velocity.iter().sum();
            assert!(momentum.norm() < 1e-12);
            let wound = full_length - mechanism.length();
            assert!(wound >= wound_before, "it never pays out");
            wound_before = wound;
        }
        // Over n steps of a ramp: Σ T · 2 (T h / m) i h = T² h² n (n + 1) / m.
        let steps = f64::from(n_steps);
        let work = tension * tension * step * step * steps * (steps + 1.0) / mass;
        assert!((mechanism.tally().work / work - 1.0).abs() < 1e-9, "{}", mechanism.tally().work);
        assert!((wound_before * tension / work - 1.0).abs() < 1e-9);
    }
}

#[test]
fn no_thread_pays_out_and_no_winch_exceeds_its_limit() {
    for done in closings() {
        let started = done.closing().triggered_s.unwrap();
        let from = done.run.frames.time.iter().position(|&t| t >= started).unwrap();
        for off in done.threads("off_reels_m") {
            assert!(off[from..].is_sorted_by(|a, b| a >= b), "{}: pays out", done.name);
            assert!(off[off.len() - 1] < off[from], "{}: nothing is wound in", done.name);
        }
        for tension in done.threads("tension_n") {
            let most = tension.iter().copied().fold(0.0, f64::max);
            assert!(most <= done.limit() * (1.0 + 1e-12), "{}: {most} N", done.name);
        }
        assert!(done.closing().max_tension_n <= done.limit() * (1.0 + 1e-12));
    }
}

#[test]
fn momentum_and_energy_close_with_the_winch_on() {
    for done in closings() {
        let kept = done.summary.conservation;
        below(&format!("{}: momentum", done.name), kept.momentum_residual, 4e-13); // measured 4e-14
        // Measured 8e-6 and 1e-12: threads of explicit cables act in every sub-step.
        let is_explicit = done.case.scene().solver.cables == CableModel::Explicit;
        let residual = if is_explicit { 1e-11 } else { 8e-5 };
        below(&format!("{}: energy", done.name), unbooked(&done.case, &done.run), residual);
        // Nothing with explicit cables. With joints the threads' share in a step that throws light knots about
        // is known to some 1e-3 of the launch energy, which the next steps give back.
        below(&format!("{}: energy created", done.name), kept.energy_created, 4e-4); // measured 4e-5
        let closing = done.closing();
        assert!(closing.winch_work_j > 0.0, "{}", done.name);
    }
}

/// A target that fills the net: the mouth cannot shut.
struct Jam {
    scene: &'static str,
    changes: &'static [&'static str],
    /// Deepest penetration allowed [m].
    penetration: f64,
    /// When every winch is at its limit [s].
    from: f64,
}

/// Pair, target of [`JAMS`], and how long the winches reel at their limit [s]. A minute of it under every pair stands in
/// the catalogue (`winch-at-its-limit`).
const JAMMED: [(&str, usize, f64); 3] =
    [("joints+rapier", 0, 2.5), ("explicit+impulse", 0, 10.0), ("explicit+impulse", 1, 10.0)];

/// The targets of Table 5.1 are too slender: their nets shut behind them and the threads come to
/// their end. So the Cubesat is as thick as two, and the stage's net is of 18.5 m instead of 30 m.
const JAMS: [Jam; 2] = [
    Jam {
        scene: "cubesat-spin-x-2.0-tube",
        changes: &[
            r#"target.shape={"parts":[{"cuboid":[0.2,0.34,0.2]}]}"#,
            "target.spin_rad_s=[0,0,0]",
            "effects.closing.stop_share=0",
        ],
        penetration: 1e-3,
        from: 2.0,
    },
    Jam {
        scene: "stage-spin-x-1.1-tube",
        changes: &[
            "net.meshes=[10,10]",
            "net.mesh_length_m=1.85",
            "target.distance_m=22",
            "target.spin_rad_s=[0,0,0]",
            "effects.closing.stop_share=0",
        ],
        penetration: 5e-3,
        from: 4.0,
    },
];

/// Reeling for long at the tension limit: the net comes to rest, and nothing gains energy.
#[test]
fn a_jammed_winch_is_steady_and_gains_no_energy() {
    let one = |(pair, number, seconds): (&str, usize, f64)| {
        let (jam, [cables, contact]) = (&JAMS[number], changes_of(pair));
        let to = jam.from + seconds;
        let duration = format!("duration_s={to}");
        (jam, to, Done::of(jam.scene, &[jam.changes, &[&cables, &contact, &duration]].concat()))
    };
    let jams: Vec<(&Jam, f64, Done)> = JAMMED.into_par_iter().map(one).collect();
    for (jam, to, done) in &jams {
        let name = format!("{}, {:?} cables", jam.scene, done.case.scene().solver.cables);
        let frames = &done.run.frames;
        let at = |time: f64| frames.time.iter().position(|&t| t >= time - 1e-9).unwrap();
        let (from, to) = (at(jam.from), at(*to));

        let tensions = done.threads("tension_n");
        let at_limit = |tension: &Vec<f64>| {
            let frames = &tension[from..=to];
            frames.iter().filter(|&&t| t >= done.limit() * (1.0 - 1e-9)).count() as f64 / frames.len() as f64
        };
        // Measured 0.98 to 1.
        let least = tensions.iter().map(at_limit).fold(1.0, f64::min);
        within(&format!("{name}: frames at the limit"), least, [0.9, 1.0]);

        let penetration = done.summary.contact.unwrap().max_penetration_m;
        below(&format!("{name}: penetration, m"), penetration, jam.penetration);
        // Measured 0.01 to 0.1.
        let kinetic = |frame: usize| frames.ledger[frame].kinetic_net;
        let quarter = (to - from) / 4;
        let early = (from..from + quarter).map(kinetic).fold(0.0, f64::max);
        let late = (to - quarter..=to).map(kinetic).fold(0.0, f64::max);
        below(&format!("{name}: energy of motion, late over early"), late / early, 0.5);
        // What the winches put in is no gain: less that, energy may only fall.
        let own = |frame: usize| frames.ledger[frame].own();
        let gain = (own(to) - own(from)) / frames.ledger[0].start;
        below(&format!("{name}: energy gained, of the launch"), gain, 0.0);
    }
}

/// While a winch has tension to spare its thread is no longer than what is off the reels. At the limit
/// knots that pull harder drag it out: that is counted apart, as `max_limit_overshoot`.
///
/// Wanted 1e-3. Measured 1e-8 to 7e-4, but for `tube` with joints: 1.4e-3.
#[test]
fn no_thread_is_longer_than_what_is_off_its_reels() {
    for done in closings() {
        below(&format!("{}: excess of the full length", done.name), done.closing().max_excess, 1e-3);
    }
}

/// Each starts when it should: at the step after its event, and after its delay.
#[test]
fn every_trigger_fires_at_its_event() {
    let short = "duration_s=1.0";
    let trigger = |json: &str| format!("effects.closing.trigger={json}");
    let run =
        |json: &str| Done::of("cubesat-spin-x-2.0-tube", &[short, "output.sample_s=0.0005", &trigger(json)]);
    let jsons = [
        r#"{"on":"contact","delay_s":0.05}"#,
        r#"{"on":"time","at_s":0.6}"#,
        r#"{"on":"mouth","below":0.5}"#,
        r#"{"on":"past","distance_m":0.1}"#,
    ];
    let done: Vec<Done> = jsons.par_iter().map(|json| run(json)).collect();
    let fired: Vec<f64> = done.iter().map(|done| done.closing().triggered_s.unwrap()).collect();
    let step = done[0].case.time_step().step;
    let contact = done[0].summary.contact.unwrap().first_contact_s.unwrap();
    within("contact, 0.05 s after it", fired[0] - contact, [0.05 - 1e-9, 0.05 + 1.5 * step]);
    within("time", fired[1], [0.6 - 1e-9, 0.6 + 1e-9]);
    let frame = |done: &Done, time: f64| done.run.frames.time.iter().position(|&t| t >= time - 1e-9).unwrap();
    let mouth = Curves::of(&done[2].case, &done[2].run).mouth;
    let at = frame(&done[2], fired[2]);
    assert!(mouth[at] < 0.5 && mouth[at - 1] >= 0.5, "{:?}", &mouth[at - 2..at + 1]);
    let past = |frame: usize| {
        let frames = &done[3].run.frames;
        let line = frames.target[frame].position.x + 0.1;
        done[3].case.net().bullets.iter().all(|&bullet| frames.knots[frame][bullet].x > line)
    };
    let at = frame(&done[3], fired[3]);
    assert!(past(at) && !past(at - 1));
}

/// Section 5.4.2, Fig. 5.17 and 5.18; the stage and Envisat stand in `scenes.rs`.
#[test]
fn a_fast_cubesat_is_captured_with_a_closing_thread_under_both_solvers() {
    for name in ["cubesat-spin-x-2.0-tube", "cubesat-spin-z-2.0-tube"] {
        for pair in FAST_PAIRS {
            let [cables, contact] = changes_of(pair);
            let members = ensemble(&scene(name, &["duration_s=2.0", &cables, &contact]), 3);
            // Measured 10 of 10 each, about x 0 of 10 without a thread.
            assert_eq!(captured(&members), members.len(), "{name} {pair}");
        }
    }
}

/// With a thread the mouth stays shut when the chaser pulls; without one the target is lost.
#[test]
fn a_closed_net_holds_its_target_when_it_is_tugged_at() {
    let tug =
        r#"effects.tug={"start":{"on":"time","at_s":1.6},"time_s":0.6,"direction":[-1,0,0],"force_n":0.1}"#;
    let held = |name: &str| {
        let done = Done::of(name, &["duration_s=2.3", tug]);
        let trial = done.summary.retention.and_then(|retention| retention.trial).expect("it was tugged at");
        within("start of the tug, s", trial.from_s, [1.6 - 1e-9, 1.6 + 1e-9]);
        trial.held
    };
    assert_eq!(held("cubesat-spin-x-2.0-tube"), Some(true));
    assert_eq!(held("cubesat-spin-x-2.0"), Some(false));
}

/// A target that weighs less than the net is driven off by the first touch, at half a metre a second: the
/// net flies with it, and the thread closes behind it all the same.
#[test]
fn a_net_closes_around_a_target_that_moves_away() {
    for pair in FAST_PAIRS {
        let [cables, contact] = changes_of(pair);
        let changes = ["duration_s=2.0", "target.mass_kg=0.1", &cables, &contact];
        let done = Done::of("cubesat-spin-x-2.0-tube", &changes);
        let away = done.summary.target.as_ref().unwrap().displacement_m[0];
        within(&format!("{pair}: driven off by, m"), away, [0.7, 1.1]); // measured 0.89 and 0.90
        assert!(done.summary.capture.unwrap().captured, "{pair}: {:?}", done.summary.capture);
        let closing = done.closing();
        below(&format!("{pair}: excess"), closing.max_excess, 5e-3); // measured 7e-4 and 1e-4
        let kept = done.summary.conservation;
        below(&format!("{pair}: momentum"), kept.momentum_residual, 1e-13); // measured 5e-15
        // Measured 2.8e-4 and 2e-13, of energies as in the closings above.
        let residual = if cables.ends_with("explicit") { 2e-12 } else { 3e-3 };
        below(&format!("{pair}: energy"), unbooked(&done.case, &done.run), residual);
        below(&format!("{pair}: energy created"), kept.energy_created, 4e-4); // measured 4e-5
    }
}

/// A period of 2π / 2 s from the closing on, at about 1 s.
#[test]
fn a_closed_net_holds_its_target_over_a_turn() {
    let turn = |duration: &str| {
        let done = Done::of("cubesat-spin-x-2.0-tube", &[duration]);
        done.summary.retention.and_then(|retention| retention.turn).expect("the target tumbles")
    };
    let whole = turn("duration_s=4.4");
    assert_eq!(whole.held, Some(true), "{whole:?}");
    within(
        "window, s",
        whole.to_s - whole.from_s,
        [std::f64::consts::PI - 1e-9, std::f64::consts::PI + 1e-9],
    );
    assert_eq!(turn("duration_s=2.0").held, None, "too short to tell");
}

/// Latches that the engine holds draw cables in that contacts pushed out, where these do not know of them: 8.4 mm in the middle of four and
/// 21 mm at most. Measured 0.6 and 0.8 mm.
#[test]
fn latched_cables_stay_outside_under_joints() {
    let latches =
        ["effects.closing.lock=true", "effects.cable_contact={}", "solver.contact=impulse", "duration_s=2"];
    let members = common::ensemble(&common::scene("cubesat-spin-x-2.0-tube", &latches), 2);
    let [_, _, deepest] = common::spread(&members, "contact.max_penetration_m");
    below("cables inside, m", deepest, 3e-3);
}
