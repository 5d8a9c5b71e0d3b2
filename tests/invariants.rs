//! What holds for every net, whatever its size, cables, launch and target.

use crate::common;

use nalgebra::Vector3;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::metrics::conservation::Conservation;
use tumblenet::run::Run;
use tumblenet::solver::{CableModel, Integrator};

/// A random net of `meshes`, folded and shot, without a target.
///
/// It is as hard as the source's nets, not harder: bullets of up to 500 knot masses, and a step of at
/// most 5 / ω of the light knots. Beyond, the rows of a taut net do not converge within their sweeps
/// and stretch turns up as energy; `heavy_bullets_do_not_stretch_a_chain_of_light_knots` holds how far.
fn nets(meshes: std::ops::RangeInclusive<u32>) -> impl Strategy<Value = Value> {
    let material = prop_oneof![Just("nylon"), Just("kevlar"), Just("zylon"), Just("spectra")];
    let cable = (material, 0.0003..0.003f64, 0.0..0.5f64);
    let launch = (0.5..10.0f64, 20.0..80.0f64);
    let size = (meshes.clone(), meshes, 0.05..0.5f64, 0..=1u32, 10.0..500.0f64, 0.05..0.8f64);
    (size, cable, launch).prop_map(|(size, (material, diameter, damping), (speed, angle))| {
        let (rows, columns, mesh, middle, mass_ratio, fold) = size;
        let mut scene = json!({
            "title": "random net", "duration_s": 1.0,
            "net": { "meshes": [rows, columns], "mesh_length_m": mesh, "middle_knots": middle,
                     "bullet_mass_kg": 1.0, "fold": { "scheme": "scaled", "ratio": fold },
                     "cable": { "material": material, "diameter_m": diameter, "damping_ratio": damping } },
            "launch": { "speed_m_s": speed, "angle_deg": angle }
        });
        let net = common::case_of(scene.clone()).net().clone();
        let lightest = net.mass.iter().copied().fold(f64::INFINITY, f64::min);
        scene["net"]["bullet_mass_kg"] = json!(mass_ratio * lightest);
        let net = common::case_of(scene.clone()).net().clone();
        let fastest = net.cables.iter().map(|cable| cable.natural_frequency()).fold(0.0, f64::max);
        let step = (5.0 / fastest).min(5e-4);
        // Twice the way across the net: it opens and falls back. At most 4000 steps.
        let duration = 2.0 * mesh * f64::from(rows.max(columns)) / speed;
        scene["duration_s"] = json!(duration.min(4000.0 * step));
        scene["solver"] = json!({ "step_s": step });
        scene["output"] = json!({ "sample_s": step });
        scene
    })
}

/// The same with a box in its way, free or fixed, with or without friction.
fn captures() -> impl Strategy<Value = Value> {
    let target = (
        prop_oneof![Just("free"), Just("fixed")],
        // In units of the way the bullets go in half of the run.
        [0.1..1.0f64, 0.1..1.0f64, 0.1..1.0f64],
        (0.9..1.5f64, -0.3..0.3f64, -0.3..0.3f64),
        [-180.0..180.0f64, -90.0..90.0f64, -180.0..180.0f64],
        [-2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64],
        0.05..50.0f64,
    );
    let friction = proptest::option::of(0.0..1.0f64);
    let net = nets(2..=6);
    (net, target, friction, 0.0..1.0f64).prop_map(|(mut scene, target, friction, restitution)| {
        let (motion, sides, (beyond, y, z), attitude, spin, mass) = target;
        // As far as the net comes in half of the run, whatever its scale.
        let speed = scene["launch"]["speed_m_s"].as_f64().unwrap();
        let way = 0.5 * speed * scene["duration_s"].as_f64().unwrap();
        let [sides, [beyond, y, z]] = [sides, [beyond, y, z]].map(|lengths| lengths.map(|l| l * way));
        scene["target"] = json!({
            "shape": { "parts": [{ "cuboid": sides }] }, "motion": motion, "mass_kg": mass,
            "distance_m": beyond, "offset_m": [y, z], "attitude_deg": attitude, "spin_rad_s": spin
        });
        scene["solver"]["restitution"] = json!(restitution);
        scene["capture"] = json!({ "hold_s": 0.0 });
        if let Some(coefficient) = friction {
            scene["effects"] = json!({ "friction": { "coefficient": coefficient } });
        }
        scene
    })
}

/// Momentum and energy, every step.
fn kept(case: &Case, run: &Run) -> Result<(), TestCaseError> {
    let found = Conservation::of(case, run);
    prop_assert!(found.momentum_residual < 1e-9, "{found:?}"); // measured 7e-15
    // Measured on 384 random nets with joints and 21 with explicit cables.
    prop_assert!(found.angular_momentum_residual < 1e-4, "{found:?}"); // measured 4.4e-5
    prop_assert!(common::unbooked(case, run) < 1e-3, "{found:?}"); // measured 6.6e-5
    // What semi-implicit Euler makes of an undamped flight is in no row.
    if case.scene().solver.integrator != Integrator::Symplectic {
        prop_assert!(found.energy_residual < 1e-3, "{found:?}");
    }
    // Joints measured 6.8e-4. The symplectic method of an undamped net keeps another energy than this one,
    // which swings about it: measured 0.017.
    let rise = if case.scene().solver.cables == CableModel::Joints { 2e-3 } else { 0.05 };
    prop_assert!(found.energy_created < rise, "{found:?}");
    prop_assert!(found.energy_end_j <= found.energy_start_j * 1.001, "{found:?}");
    Ok(())
}

fn config(cases: u32) -> ProptestConfig {
    // Fixed seed: a test that fails does so for everybody. No file of failures beside the sources.
    ProptestConfig {
        cases,
        rng_seed: proptest::test_runner::RngSeed::Fixed(5),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn a_net_on_its_own_keeps_momentum_and_gains_no_energy(scene in nets(1..=6)) {
        let case = common::case_of(scene);
        let run = common::run(&case);
        kept(&case, &run)?;
        prop_assert_eq!(run.work.detections, 0);
    }

    #[test]
    fn a_capture_keeps_momentum_and_gains_no_energy(scene in captures()) {
        let case = common::case_of(scene);
        kept(&case, &common::run(&case))?;
    }

    /// Both halves do the same, until the trembling of the last digits has grown.
    #[test]
    fn a_symmetric_net_stays_symmetric(scene in nets(2..=5)) {
        let case = resolved(scene);
        let run = common::run(&case);
        let [rows, columns] = case.net().grid;
        let frame = early(&case, &run);
        let knots = &run.frames.knots[frame];
        for row in 0..rows {
            for column in 0..columns {
                let [here, there] =
                    [row * columns + column, (rows - 1 - row) * columns + column].map(|knot| knots[knot]);
                let mirrored = Vector3::new(there.x, -there.y, there.z);
                let error = (here - mirrored).norm() / size(&case); // measured at most 3.1e-5
                prop_assert!(error < 2e-4, "{row} {column}: {here} {there}");
            }
        }
    }

    /// A square net turned by 90 degrees about X is itself: the answer must turn with it.
    #[test]
    fn a_square_net_answers_alike_along_y_and_z(scene in nets(2..=5)) {
        let mut scene = scene;
        scene["net"]["meshes"][1] = scene["net"]["meshes"][0].clone();
        let case = resolved(scene);
        let run = common::run(&case);
        let side = case.net().grid[0];
        let knots = &run.frames.knots[early(&case, &run)];
        for row in 0..side {
            for column in 0..side {
                let [here, there] = [row * side + column, column * side + (side - 1 - row)].map(|knot| knots[knot]);
                // (y, z) at (row, column) goes to (z, -y) at (column, last − row).
                let turned = Vector3::new(here.x, here.z, -here.y);
                let error = (there - turned).norm() / size(&case); // measured at most 3.6e-5
                prop_assert!(error < 2e-4, "{row} {column}: {here} {there}");
            }
        }
    }
}

proptest! {
    #![proptest_config(config(8))]

    /// The source's solver, at a step that it chooses itself.
    ///
    /// Known to be wrong: at the step chosen for it the penalty force can gain energy, once 1e5 times
    /// the launch energy on a box of 1 cm, since snaps drive light knots deeper than its stable step
    /// counts on. `energy_created` says so; of `penalty` only the balance is asserted.
    #[test]
    fn a_capture_by_the_sources_solver_keeps_momentum_and_gains_no_energy(
        scene in captures(), contact in prop_oneof![Just("impulse"), Just("penalty")]
    ) {
        let mut scene = scene;
        // The source's integrator: beside the law of its cables what is missing is its own, so that the ledger closes to rounding.
        let solver = json!({ "cables": "explicit", "contact": contact, "integrator": "symplectic" });
        scene["solver"] = solver;
        // Stiff cables of light knots ask for steps of a microsecond.
        scene["net"]["cable"]["material"] = soft();
        let case = common::case_of(scene);
        let run = common::run(&case);
        let found = Conservation::of(&case, &run);
        if contact == "impulse" {
            kept(&case, &run)?;
        }
        prop_assert!(found.momentum_residual < 1e-9, "{found:?}");
        // Friction acts on the surface of a knot, which is a point and does not turn.
        let bound = if case.scene().effects.friction.is_some() { 1e-3 } else { 1e-9 };
        prop_assert!(found.angular_momentum_residual < bound, "{found:?}"); // measured 2e-4 and 2e-15
        let unbooked = common::unbooked(&case, &run);
        prop_assert!(unbooked < 1e-6 * (1.0 + found.energy_created), "{unbooked} {found:?}");
    }

    /// Net and target turned by 90 degrees about X: they meet at the same time, and what they do to
    /// each other is turned.
    #[test]
    fn a_turned_target_is_met_alike(scene in captures()) {
        let mut scene = scene;
        scene["net"]["meshes"][1] = scene["net"]["meshes"][0].clone();
        let mut turned = scene.clone();
        let numbers = |value: &Value| -> Vec<f64> { serde_json::from_value(value.clone()).unwrap() };
        let offset = numbers(&scene["target"]["offset_m"]);
        let attitude = numbers(&scene["target"]["attitude_deg"]);
        turned["target"]["offset_m"] = json!([-offset[1], offset[0]]);
        // Turns are about x first, so one about X before all others adds to it.
        turned["target"]["attitude_deg"] = json!([attitude[0] + 90.0, attitude[1], attitude[2]]);
        let [(case, run), (_, other)] = [scene, turned].map(|scene| {
            let case = resolved(scene);
            let run = common::run(&case);
            (case, run)
        });
        let frame = early(&case, &run);
        let [here, there] = [&run, &other].map(|run| run.frames.target[frame]);
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        let error = (turn * here.position - there.position).norm() / size(&case);
        prop_assert!(error < 2e-4, "{here:?} {there:?}");
        let scale = here.rate.norm() + 1e-3;
        prop_assert!((turn * here.rate - there.rate).norm() < 1e-3 * scale, "{here:?} {there:?}");
        let [first, second] = [&run, &other].map(|run| run.extremes.first_contact);
        let until = run.frames.time[frame];
        match (first.filter(|t| *t < until), second.filter(|t| *t < until)) {
            (Some(a), Some(b)) => prop_assert!((a - b).abs() < 2.5 * run.step, "{a} {b}"),
            (a, b) => prop_assert_eq!(a, b),
        }
    }
}

/// Finer steps converge: over random nets the difference that a quarter of the step makes falls with
/// the step. Of one net alone it need not: which cable snaps first is a matter of the last digits.
#[test]
fn a_quarter_of_the_step_comes_nearer() {
    let mut runner = TestRunner::new(config(1));
    for (cables, contact) in [("joints", "rapier"), ("explicit", "impulse")] {
        let mut ratios: Vec<f64> = (0..12)
            .map(|_| {
                let case = resolved(nets(2..=4).new_tree(&mut runner).unwrap().current());
                let mut scene = serde_json::to_value(case.scene()).unwrap();
                let run = common::run(&case);
                scene["duration_s"] = json!(run.frames.time[early(&case, &run)]);
                scene["solver"]["cables"] = json!(cables);
                scene["solver"]["contact"] = json!(contact);
                scene["output"]["sample_s"] = json!(case.time_step().step);
                let [coarse, middle, fine] = [1.0, 0.25, 0.0625].map(|share| {
                    scene["solver"]["step_s"] = json!(share * case.time_step().step);
                    let run = common::run(&common::case_of(scene.clone()));
                    run.frames.knots.last().unwrap().clone()
                });
                let apart = |a: &[Vector3<f64>], b: &[Vector3<f64>]| {
                    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
                };
                apart(&middle, &fine) / apart(&coarse, &middle)
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        println!("{cables}: {ratios:.3?}");
        common::below(&format!("{cables}, median"), 0.5 * (ratios[5] + ratios[6]), 0.6);
    }
}

/// The same net of a softer material, with a step that resolves its cables.
///
/// Where the step does not, snaps follow one another in the order of the cables, and a bullet that
/// is hardly heavier than its knots feels the order: mirror images of random nets came to differ by
/// up to a tenth of the net. The source's bullets (240 to 440 knots) keep theirs to 5e-7 m.
fn resolved(mut scene: Value) -> Case {
    scene["net"]["cable"]["material"] = soft();
    let net = common::case_of(scene.clone()).net().clone();
    let fastest = net.cables.iter().map(|cable| cable.natural_frequency()).fold(0.0, f64::max);
    // A half cycle of more than the 30 steps from which a cable no longer snaps.
    scene["solver"]["step_s"] = json!(0.1 / fastest);
    scene["output"]["sample_s"] = json!(1.0 / fastest);
    common::case_of(scene)
}

/// A material of a hundredth of nylon's stiffness.
fn soft() -> Value {
    json!({ "young_modulus_pa": 1e7, "density_kg_m3": 1000.0, "tensile_strength_pa": 1e9,
        "elongation_at_break": 0.1 })
}

/// The frame half-way to where the bullets would have opened the net had nothing held them: cables
/// have gone taut, the trembling of the last digits has not grown yet.
fn early(case: &Case, run: &Run) -> usize {
    let launch = &case.scene().launch;
    let ratio = case.scene().net.fold.ratio;
    let half_diagonal = (case.net().folded[case.net().bullets[0]]).norm() / ratio;
    let outward = launch.speed_m_s * launch.angle_deg.to_radians().sin();
    let time = 0.5 * (1.0 - ratio) * half_diagonal / outward;
    run.frames.time.partition_point(|&t| t <= time) - 1
}

/// Side of the deployed net [m].
fn size(case: &Case) -> f64 {
    case.net().designed_area.sqrt()
}
