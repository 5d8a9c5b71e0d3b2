//! What the engine's narrow numbers cost (`solver.precision: "f32"`), and that everything else is
//! as in 64 bits.

use crate::common;
use crate::common::{below, case_of, changed, scene, small_scene, within};
use serde_json::json;
use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::summary::Summary;
use tumblenet::run::Run;
use tumblenet::simulation::Simulation;
use tumblenet::study::cost::errors::Evaluation;

/// A torque-free stage of 8 t that tumbles about its middle axis. The engine's own turning lost 9 % of its
/// energy in 300 s with narrow numbers; a body is now turned by our side, so it keeps it in either.
#[test]
fn in_f32_a_tumbling_stage_keeps_energy_and_angular_momentum() {
    let mut scene = small_scene();
    scene["net"]["meshes"] = json!([1, 1]);
    scene["launch"]["speed_m_s"] = json!(0.0);
    scene["solver"] = json!({ "step_s": 0.001, "precision": "f32" });
    scene["target"] = json!({ "shape": { "parts": [{ "cuboid": [2.5, 10.0, 5.0] }] },
        "mass_kg": 8000.0, "distance_m": 100.0, "spin_rad_s": [0.001, 0.0, 0.2] });
    let case = case_of(scene);
    let inertia = case.target().unwrap().inertia;
    let mut simulation = Simulation::new(&case);
    let start = *simulation.state.target().unwrap();
    let (energy, momentum) = (start.kinetic_energy(8000.0, &inertia), start.angular_momentum(&inertia));
    let (mut energy_error, mut momentum_error) = (0.0_f64, 0.0_f64);
    for _ in 0..100_000 {
        simulation.step().unwrap();
        let body = simulation.state.target().unwrap();
        energy_error = energy_error.max((body.kinetic_energy(8000.0, &inertia) / energy - 1.0).abs());
        let turned = body.angular_momentum(&inertia) - momentum;
        momentum_error = momentum_error.max(turned.norm() / momentum.norm());
    }
    below("energy", energy_error, 1e-6); // measured 2e-9 over 300 s
    below("angular momentum", momentum_error, 1e-6);
}

/// Where narrow numbers fail: a net that flies slowly far from the origin. At 1 km a number of 32 bits
/// ends at 6e-5 m; a step of 0.5 ms at 0.05 m/s is 2.5e-5 m, which is lost.
#[test]
fn in_f32_a_slow_net_far_from_the_origin_stands_still() {
    let travelled = |precision: &str| {
        let mut scene = small_scene();
        scene["launch"] = json!({ "speed_m_s": 0.05, "angle_deg": 0.0 });
        scene["solver"] = json!({ "step_s": 0.0005, "precision": precision });
        let case =
            changed(case_of(scene), |built| built.net.folded.iter_mut().for_each(|place| place.x += 1000.0));
        let mut simulation = Simulation::new(&case);
        let bullet = case.net().bullets[0];
        let from = simulation.state.knots.position[bullet];
        for _ in 0..200 {
            simulation.step().unwrap();
        }
        (simulation.state.knots.position[bullet] - from).norm()
    };
    within("f64, m", travelled("f64"), [0.0045, 0.0051]);
    below("f32, m", travelled("f32"), 0.002);
}

/// The first third of a second in which a net wraps a Cubesat: narrow numbers lose the last digits
/// of momentum where the engine moves the knots. With explicit cables it only finds the contacts, so
/// nothing is lost.
#[test]
fn in_f32_a_capture_keeps_momentum_to_single_precision() {
    let kept = |cables: &str, contact: &str, precision: &str| {
        let changes = [
            "duration_s=1.1".to_owned(),
            format!("solver.cables={cables}"),
            format!("solver.contact={contact}"),
            format!("solver.precision={precision}"),
        ];
        let case = scene("cubesat-free", &changes.each_ref().map(String::as_str));
        let run = common::run(&case);
        let summary = Summary::of(&case, &run, &Curves::of(&case, &run));
        let contact = summary.contact.unwrap();
        assert!(contact.contacts > 5000, "{contact:?}");
        within("first contact, s", contact.first_contact_s.unwrap(), [0.75, 0.78]);
        below("penetration, m", contact.max_penetration_m, 1e-5); // measured 4e-8, 2e-7 in f32
        below("energy nowhere in the ledger", common::unbooked(&case, &run), 1e-5);
        summary.conservation.momentum_residual
    };
    below("joints+rapier, f64", kept("joints", "rapier", "f64"), 1e-12); // measured 9e-15
    within("joints+rapier, f32", kept("joints", "rapier", "f32"), [1e-8, 1e-3]); // measured 6e-6
    below("explicit+impulse, f32", kept("explicit", "impulse", "f32"), 1e-12); // measured 1e-14
}

/// A dial turned the wrong way is said to be: momentum residuals of 1e-6 and 3e-15.
#[test]
fn what_32_bits_lose_is_warned_of() {
    for (precision, warned) in [("f32", true), ("f64", false)] {
        let case = scene("deployment-kevlar", &[&format!("solver.precision={precision}")]);
        let run = Run::of(&case, |_| {}).unwrap();
        let warnings = Evaluation::of(&case, &run, None).warnings(case.net().radius[0]);
        assert_eq!(warnings.iter().any(|words| words.contains("loses momentum")), warned, "{warnings:?}");
    }
}
