//! Cables against the target, and strands of the net against each other.

use crate::common;

use crate::common::{
    FAST_PAIRS, below, case_of, changed, changes_of, knots, pairs, scene, small_scene, solver_of, spread, tie,
};
use nalgebra::Vector3;
use serde_json::json;
use tumblenet::case::Case;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::summary::Summary;
use tumblenet::simulation::Simulation;

/// Knots alone let most cables of a captured Cubesat cut through it; cables that touch do not.
#[test]
fn no_cable_is_left_inside_a_captured_target() {
    for pair in pairs() {
        // The engine's cables with contact of ours take short steps, six times as many.
        let is_slow = pair.starts_with("joints") && !pair.ends_with("rapier");
        let (members, duration) = if is_slow { (1, "duration_s=1.2") } else { (2, "duration_s=1.8") };
        let solver = changes_of(pair);
        let of = |effects: &str| {
            let changes = [effects, &solver[0], &solver[1], duration];
            common::ensemble(&scene("cubesat-free", &changes), members)
        };
        let [without, with] = ["effects={}", r#"effects={"cable_contact":{}}"#].map(of);
        let inside = |members: &[Summary]| spread(members, "contact.cables_inside");
        // Measured 50 to 70 without; with it 0 in every run, at most 2 in any frame.
        println!("{pair}: {:?} without, {:?} with", inside(&without), inside(&with));
        assert!(inside(&without)[0] > 10.0, "{:?}", inside(&without));
        assert_eq!(inside(&with)[1], 0.0, "{:?}", inside(&with));
        let most = spread(&with, "contact.max_cables_inside")[2];
        below(&format!("{pair}: cables inside in any frame"), most, 8.0);
        let created = spread(&with, "conservation.energy_created")[2];
        below(&format!("{pair}: energy created"), created, 1e-3);
        let momentum = spread(&with, "conservation.momentum_residual")[2];
        below(&format!("{pair}: momentum residual"), momentum, 1e-9);
    }
}

/// The rim of the stage's end: a knot that rests on the end beside it leaves its cable to cut into it.
#[test]
fn no_cable_is_left_inside_a_captured_stage() {
    let changes = [r#"effects={"cable_contact":{}}"#, "solver.cables=explicit", "solver.contact=impulse"];
    let members = common::ensemble(&scene("stage-free", &changes), 2);
    assert_eq!(common::captured(&members), 2);
    // Measured 0 in 10 runs, up to 4 before such places were taken; 80 without the effect.
    below("stage: cables inside", spread(&members, "contact.cables_inside")[2], 1.0 + 1e-9);
    below("stage: energy created", spread(&members, "conservation.energy_created")[2], 1e-3);
}

/// A taut strand along y, at rest, and one along z that is thrown at it along x.
fn crossing(pair: &str, effects: serde_json::Value) -> Case {
    let mut net = knots(&[
        (1e-3, [0.0, -0.1, 0.0], [0.0; 3]),
        (1e-3, [0.0, 0.1, 0.0], [0.0; 3]),
        (1e-3, [-0.05, 0.01, -0.1], [3.0, 0.0, 0.0]),
        (1e-3, [-0.05, 0.01, 0.1], [3.0, 0.0, 0.0]),
    ]);
    tie(&mut net, [0, 1], 0.2, 2000.0, 0.1);
    tie(&mut net, [2, 3], 0.2, 2000.0, 0.1);
    let mut scene = small_scene();
    scene["solver"] = solver_of(pair);
    scene["effects"] = effects;
    changed(case_of(scene), |built| built.net = net)
}

#[test]
fn two_strands_thrown_crosswise_do_not_pass() {
    for pair in pairs() {
        for (effects, passes) in
            [(json!({}), true), (json!({ "self_contact": { "bullet_radius_m": 5e-4 } }), false)]
        {
            let case = crossing(pair, effects);
            let mut simulation = Simulation::new(&case);
            let momentum = simulation.audit.momentum(&simulation.state);
            let angular = simulation.audit.angular_momentum(&simulation.state);
            let mut furthest = f64::NEG_INFINITY;
            while simulation.state.time < 0.1 {
                simulation.step().unwrap();
                let x = &simulation.state.knots.position;
                // At the crossing: the middle of the one, 0.55 of the way along the other.
                let ahead = 0.5 * (x[2].x + x[3].x) - (0.45 * x[0].x + 0.55 * x[1].x);
                furthest = furthest.max(ahead);
            }
            println!("{pair}: furthest {furthest:e} m");
            assert_eq!(furthest > 0.0, passes, "{pair}: {furthest}");
            let scale = 6e-3; // kg m/s
            let drift = simulation.audit.momentum(&simulation.state) - momentum;
            below("momentum", drift.norm() / scale, 1e-12);
            let drift = simulation.audit.angular_momentum(&simulation.state) - angular;
            // The engine turns its cables by the step.
            below("angular momentum", drift.norm() / (scale * 0.1), 1e-3);
        }
    }
}

/// A net of 11 x 11 knots thrown together into a wad: bounded, and no energy from nowhere.
#[test]
fn a_wad_of_a_net_stays_bounded() {
    for pair in FAST_PAIRS {
        let [cables, contact] = changes_of(pair);
        let changes = [
            "target=null",
            "duration_s=0.3",
            "net.fold.ratio=0.5",
            "effects={\"self_contact\":{}}",
            &cables,
            &contact,
        ];
        let case = scene("cubesat-free", &changes);
        let middle = case.net().folded.iter().sum::<Vector3<f64>>() / case.net().n_knots() as f64;
        let bow = |x: &Vector3<f64>| 0.05 * Vector3::x() * (30.0 * x.y).sin() * (25.0 * x.z).cos();
        let case = changed(case, |built| {
            for (x, v) in built.net.folded.iter_mut().zip(&mut built.net.launch_velocity) {
                *x += bow(x);
                *v = -10.0 * (*x - middle);
            }
        });
        let start = case.net().folded.iter().map(|x| (x - middle).norm()).fold(0.0, f64::max);
        let run = common::run(&case);
        let summary = Summary::of(&case, &run, &Curves::of(&case, &run));
        let last = run.frames.knots.last().unwrap();
        let end = last.iter().map(|x| (x - middle).norm()).fold(0.0, f64::max);
        println!("{pair}: {start} m, {end} m, {:?}, {:?}", run.effects, summary.conservation);
        assert!(run.effects[0].1 > 1000, "{:?}", run.effects);
        // Knots at 10 / s towards the middle are thrown through at most as far on the other side,
        // where cables hold them.
        below(&format!("{pair}: size"), end / start, 2.5);
        below(&format!("{pair}: energy created"), summary.conservation.energy_created, 1e-2);
        let momentum = &run.frames.momentum;
        let drift = (momentum.last().unwrap() - momentum[0]).norm();
        let scale: f64 =
            case.net().mass.iter().zip(&case.net().launch_velocity).map(|(m, v)| m * v.norm()).sum();
        below(&format!("{pair}: momentum"), drift / scale, 1e-12);
    }
}

/// Strands that bullets draw tight over a held cube. One kind of contact after the other, what the target kept out went into strands that
/// had been answered: with explicit cables these came up to 2.4 mm into each other, where 1 mm is through, and made up to 1.1e-2 of the energy;
/// under joints a member had 40 to 145 pairs that went through.
#[test]
fn strands_drawn_tight_over_a_target_do_not_go_through_each_other() {
    let (strands, both) =
        ("effects={\"self_contact\":{}}", "effects={\"self_contact\":{},\"cable_contact\":{}}");
    // (most pairs that went through in four members, deepest [m], created in the middle and at most); measured: 0, 2.8e-4, 4e-5 and 0, 8e-4,
    // 2.0e-4; with whole cables, answered after strands that were to keep apart, 19 in eight and 16 mm, and in one problem 0, 6e-4, and of 64
    // members 2.0e-4 in the middle, two above 1e-3, the largest 5.2e-3: a strand is thrown, and caught by the next step. (With cables that
    // the engine looked for it was six, 2.9e-2.)
    for (pair, effects, most_through, deepest, [in_the_middle, at_most]) in [
        ("explicit+impulse", strands, 0.0, 7e-4, [4e-4, 7e-4]),
        ("joints+rapier", strands, 8.0, 3e-3, [1e-3, 2.6e-3]),
        ("joints+rapier", both, 0.0, 3e-3, [1e-3, 2.9e-2]),
    ] {
        let [cables, contact] = changes_of(pair);
        let case = scene("cube-fixed", &[effects, &cables, &contact]);
        let members = common::ensemble(&case, 4);
        let [_, _, through] = spread(&members, "self_contact.went_through");
        let [_, _, depth] = spread(&members, "self_contact.deepest_m");
        let [_, middle, largest] = spread(&members, "conservation.energy_created");
        println!("{pair}: {through} through, {depth:.1e} m, {middle:.1e}, {largest:.1e}");
        assert!(through <= most_through, "{pair}: {through} pairs went through");
        below(&format!("{pair}: depth"), depth, deepest);
        below(&format!("{pair}: energy created, in the middle"), middle, in_the_middle);
        below(&format!("{pair}: energy created, at most"), largest, at_most);
    }
}

/// Heavy bullets draw thin strands around a cube that is held at 8 m/s, eight times their thickness in a step of joints and 0.8 of it in one of explicit
/// cables: at steps that the cables alone liked, 246 and 212 pairs went through each other.
#[test]
fn strands_shot_fast_around_a_target_are_not_outrun() {
    let under_joints = json!({
        "title": "a wide net of thin strands", "duration_s": 1.0,
        "net": { "meshes": [6, 8], "mesh_length_m": 0.1, "bullet_mass_kg": 0.2,
                 "cable": { "material": "zylon", "diameter_m": 5e-4, "damping_ratio": 0.03 },
                 "fold": { "scheme": "scaled", "ratio": 0.95 } },
        "launch": { "speed_m_s": 8, "angle_deg": 40 },
        "target": { "shape": "cube-0.16", "distance_m": 0.8, "offset_m": [0.013, 0.035], "attitude_deg": [-86.8, -50.7, -17.4],
                    "mass_kg": 3.5, "motion": "fixed" },
        "effects": { "self_contact": {}, "friction": { "coefficient": 0.2, "static_coefficient": 0.5, "transition_speed_m_s": 0.05 } },
        "solver": solver_of("joints+rapier")
    });
    let explicit = json!({
        "title": "a narrow net", "duration_s": 1.0,
        "net": { "meshes": [7, 6], "mesh_length_m": 0.114, "bullet_mass_kg": 0.2,
                 "cable": { "material": "nylon", "diameter_m": 1e-3, "damping_ratio": 0.1 }, "edge_cable": { "diameter_m": 5e-4 },
                 "fold": { "scheme": "scaled", "ratio": 0.2 } },
        "launch": { "speed_m_s": 8, "angle_deg": 15 },
        "target": { "shape": "cube-0.16", "distance_m": 1.2, "offset_m": [-0.075, 0.149], "attitude_deg": [-86.7, 80.8, 87.6],
                    "mass_kg": 3.5, "motion": "fixed" },
        "effects": { "self_contact": {} }, "solver": solver_of("explicit+impulse")
    });
    // Measured 32 and 38, 41 and 45 of eight.
    for (scene, most) in [(under_joints, 62.0), (explicit, 56.0)] {
        let members = common::ensemble(&case_of(scene), 5);
        let through = common::values(&members, "self_contact.went_through");
        println!("{through:?}");
        below("pairs that went through in five members", through.iter().sum(), most);
        below("momentum residual", spread(&members, "conservation.momentum_residual")[2], 1e-9);
    }
}
