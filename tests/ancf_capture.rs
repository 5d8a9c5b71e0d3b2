//! Cables as elements that meet a target, and threads that pull at them.

use crate::common;

use crate::common::{below, case_of};
use nalgebra::Vector3;
use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::contact::NetMotion;
use tumblenet::json;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::conservation::Conservation;
use tumblenet::run::Run;
use tumblenet::state::Knots;
use tumblenet::step::ancf::kernel::{AncfNet, element_net};
use tumblenet::step::ancf::points::{PointsInContact, TouchPoints};

/// A net of 4 x 4 meshes meets a free box that tumbles, off its centre, and wraps it.
fn capture(changes: Value) -> Case {
    let mut scene = json!({
        "title": "capture", "duration_s": 0.12,
        "net": { "meshes": [4, 4], "mesh_length_m": 0.1, "bullet_mass_kg": 0.03,
                 "cable": { "material": "nylon", "diameter_m": 0.001 }, "fold": { "scheme": "scaled", "ratio": 0.3 } },
        "launch": { "speed_m_s": 5.0, "angle_deg": 25.0 },
        "target": { "shape": { "parts": [{ "cuboid": [0.1, 0.16, 0.1] }] }, "distance_m": 0.3, "mass_kg": 0.5,
                    "offset_m": [0.01, 0.02], "spin_rad_s": [0.5, 0.2, 1.0] },
        "capture": { "hold_s": 0.0 },
        "solver": { "cables": "ancf", "contact": "impulse" }
    });
    json::merge(&mut scene, changes);
    case_of(scene)
}

/// Runs `case`, and asks what must hold of every capture.
fn kept(what: &str, case: &Case, overlap: f64) -> Run {
    let run = common::run(case);
    let found = Conservation::of(case, &run);
    println!("{what}: {found:?}, {:?}", run.work);
    assert!(run.work.contacts > 50, "{what} hardly touched");
    // Measured over the tests of this file: 1.1e-13, 1.3e-13, 2e-4, 2e-4.
    below(&format!("{what}: momentum"), found.momentum_residual, 1e-9);
    below(&format!("{what}: angular momentum"), found.angular_momentum_residual, 1e-9);
    below(&format!("{what}: energy created"), found.energy_created, 1e-3);
    below(&format!("{what}: energy residual"), found.energy_residual, 2e-3);
    let radius = case.net().radius[0];
    below(&format!("{what}: overlap over the radius"), run.extremes.penetration / radius, overlap);
    run
}

#[test]
fn impulses_keep_momentum_make_no_energy_and_leave_nothing_inside() {
    kept("impulse", &capture(json!({})), 0.5);
    let undamped = capture(json!({ "net": { "cable": { "damping_ratio": 0.0 } } }));
    // Eight perturbed ones: 1.5e-4 in the middle, 2.5e-4 at most.
    kept("undamped", &undamped, 0.5);
    let rubbed =
        json!({ "effects": { "friction": { "coefficient": 0.3 } }, "solver": { "restitution": 0.5 } });
    kept("friction and restitution", &capture(rubbed), 0.5);
}

/// Implicit steps until something may touch, explicit sub-steps from then on.
#[test]
fn implicit_flight_gives_way_to_contact() {
    let implicit = json!({ "solver": { "integrator": "implicit" } });
    let flown = kept("implicit", &capture(implicit), 0.5);
    let explicit = kept("explicit", &capture(json!({})), 0.5);
    let share = flown.work.substeps as f64 / explicit.work.substeps as f64;
    below("sub-steps over those of an explicit flight", share, 0.9); // measured 0.47
    assert!(flown.work.sweeps > 0);
}

#[test]
fn forces_keep_momentum_and_make_no_energy() {
    let rubbed =
        json!({ "effects": { "friction": { "coefficient": 0.3 } }, "solver": { "contact": "penalty" } });
    kept("penalty and friction", &capture(rubbed), 1.0); // measured 0.23
}

/// A thread through the perimeter closes the mouth, and its winches' work is in the books.
#[test]
fn threads_close_a_net_of_elements() {
    let closing = json!({ "closing": { "layout": "tube", "trigger": { "on": "time", "at_s": 0.08 },
                          "reel_speed_m_s": 1.0, "max_tension_n": 2.0, "lock": true } });
    let case = capture(json!({ "effects": closing, "duration_s": 0.2 }));
    let closed = kept("tube", &case, 0.5);
    let mouth = |run: &Run| Curves::of(&case, run).mouth_hull.last().copied().unwrap();
    let open = common::run(&capture(json!({ "duration_s": 0.2 })));
    below("mouth with a thread over that without", mouth(&closed) / mouth(&open), 0.9); // measured 0.61
    let tension = closed
        .reports
        .iter()
        .flat_map(|(_, report)| &report.numbers)
        .find_map(|numbers| numbers["max_tension_n"].as_f64());
    let tension = tension.unwrap();
    below("largest tension over the limit", (tension / 2.0 - 1.0).abs(), 1e-9);
}

/// The chaser takes the recoil of all that moves, and feels the tether: together they have no momentum.
#[test]
fn a_chaser_and_its_net_of_elements_have_no_momentum_together() {
    let chaser = json!({ "chaser": { "mass_kg": 20.0, "inertia_kg_m2": [1.0, 1.0, 1.0] } });
    let case = capture(json!({ "effects": chaser, "target": { "spin_rad_s": [0.0, 0.0, 0.0] } }));
    let run = kept("chaser", &case, 0.5);
    let shot = case.net().launch_momentum().norm();
    for momentum in run.frames.momentum {
        assert!(momentum.norm() < 1e-9 * shot, "{momentum} of {shot}");
    }
}

/// Impulses on knots and spheres that share cables: velocities that the solver of contacts foresees are those that the
/// mass matrix gives, and momentum and angular momentum are those of the impulses.
#[test]
fn what_impulses_do_is_foreseen_and_keeps_momentum() {
    let case = capture(json!({}));
    let (net, ancf) = (case.net(), case.scene().solver.ancf.unwrap_or_default());
    let elements = element_net(net, &ancf);
    let knots = Knots { position: net.folded.clone(), velocity: net.launch_velocity.clone() };
    let mut inner = elements.straight(&knots);
    let mut moving = AncfNet::new(net, &ancf);
    moving.load(&knots, &inner, &[]);
    let mut points = TouchPoints::new(net, &ancf);
    let mut before = Knots::default();
    points.place(&moving, &mut before);
    let n = before.position.len();
    assert_eq!(n, 25 + 3 * 40);
    points.watch(&mut moving, 0..n);
    let impulse = |point: usize| {
        let phase = point as f64;
        1e-3 * Vector3::new(phase.sin(), (1.7 * phase).cos(), (2.3 * phase).sin())
    };
    let pushed: Vec<usize> = (0..n).step_by(3).collect();
    let mut touching = PointsInContact { net: &moving, points: &mut points, before: &[] };
    pushed.iter().for_each(|&point| touching.push(point, &impulse(point), 1.0));
    let foreseen: Vec<Vector3<f64>> = (0..n).map(|point| touching.velocity(point)).collect();
    assert!(points.release(&mut moving));

    let (mut after, mut moved) = (Knots::default(), knots.clone());
    points.place(&moving, &mut after);
    let change = |point: usize| (after.velocity[point] - before.velocity[point]).norm();
    let largest = (0..n).map(change).fold(0.0, f64::max);
    let missed = (0..n).map(|point| (foreseen[point] - after.velocity[point]).norm()).fold(0.0, f64::max);
    below("what was not foreseen", missed / largest, 1e-5);
    let start = elements.motion(&knots, &inner);
    moving.store(&mut moved, &mut inner);
    let end = elements.motion(&moved, &inner);
    let sum: Vector3<f64> = pushed.iter().map(|&point| impulse(point)).sum();
    let moment: Vector3<f64> =
        pushed.iter().map(|&point| before.position[point].cross(&impulse(point))).sum();
    below("momentum", (end.momentum - start.momentum - sum).norm() / sum.norm(), 1e-12);
    let turned = end.angular_momentum - start.angular_momentum - moment;
    below("angular momentum", turned.norm() / moment.norm(), 1e-12);
    // Work: impulses times the mean velocities of their points.
    let mean = |point: usize| 0.5 * (before.velocity[point] + after.velocity[point]);
    let work: f64 = pushed.iter().map(|&point| impulse(point).dot(&mean(point))).sum();
    below("work", ((end.kinetic - start.kinetic) / work - 1.0).abs(), 1e-12);
}
