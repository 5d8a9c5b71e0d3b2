//! Scenes that nobody has thought of: net, material, damping, shot, target, spin and effects drawn at random.
//!
//! What comes after contact is chaotic, so a single number says little: momenta are to be kept in each, and energy in all but
//! a few. Every fault of methods that these scenes have shown so far had passed all other tests (docs/energy.md).

use crate::common::source_of;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::metrics::conservation::Conservation;
use tumblenet::run::Run;

/// Pairs that take a second or so a scene.
const PAIRS: [(&str, &str); 3] = [("joints", "rapier"), ("explicit", "impulse"), ("explicit", "penalty")];

fn one_of<T: Clone>(random: &mut impl Rng, of: &[T]) -> T {
    of[random.random_range(0..of.len())].clone()
}

/// The target of a scene: built-in shapes, and bodies with a panel or a disc of 20 mm.
fn target(random: &mut impl Rng) -> Value {
    let panel = json!({ "parts": [{ "cuboid": [0.2, 0.2, 0.2], "mass_kg": 3.0 },
        { "cuboid": [0.02, 0.5, 0.2], "position_m": [0.0, 0.34, 0.0], "mass_kg": 0.3 }] });
    let disc = json!({ "parts": [{ "cylinder": { "radius_m": 0.1, "length_m": 0.3 }, "mass_kg": 3.0 },
        { "cylinder": { "radius_m": 0.2, "length_m": 0.02 }, "position_m": [0.0, 0.18, 0.0], "mass_kg": 0.3 }] });
    let shape = one_of(random, &[json!("cubesat-3u"), json!("ball-0.12"), json!("cube-0.16"), panel, disc]);
    let mut target = json!({ "distance_m": one_of(random, &[0.8, 1.2]) });
    if shape.is_string() {
        target["mass_kg"] = json!(one_of(random, &[0.5, 3.5, 20.0]));
    }
    target["shape"] = shape;
    let mut numbers = |n: usize, most: f64| -> Vec<f64> {
        (0..n).map(|_| (1e3 * random.random_range(-most..most)).round() / 1e3).collect()
    };
    target["spin_rad_s"] = json!(numbers(3, 2.5));
    target["offset_m"] = json!(numbers(2, 0.15));
    target["attitude_deg"] = json!(numbers(3, 90.0));
    target
}

fn effects(random: &mut impl Rng) -> Value {
    let mut effects = json!({});
    let mut with = |share: f64, name: &str, parameters: &dyn Fn(&mut ChaCha8Rng) -> Value| {
        let (is_named, mut own) = (random.random_bool(share), ChaCha8Rng::seed_from_u64(random.next_u64()));
        if is_named {
            effects[name] = parameters(&mut own);
        }
    };
    with(0.4, "friction", &|r| json!({ "coefficient": one_of(r, &[0.1, 0.3, 1.0]) }));
    with(0.5, "cable_contact", &|_| json!({}));
    with(0.15, "self_contact", &|r| json!({ "restitution": one_of(r, &[0.0, 0.5]) }));
    with(0.4, "closing", &|r| {
        json!({ "layout": one_of(r, &["tube", "interlaced", "free", "cinch"]), "trigger": { "on": "contact", "delay_s": 0.05 },
                "reel_speed_m_s": one_of(r, &[0.5, 2.0]), "max_tension_n": one_of(r, &[0.5, 2.0, 8.0]) })
    });
    with(0.15, "orbit", &|_| json!({ "altitude_m": 6e5 }));
    with(0.15, "chaser", &|_| json!({ "mass_kg": 50.0, "inertia_kg_m2": [5.0, 6.0, 7.0] }));
    with(0.2, "drag", &|r| {
        json!({ "density_kg_m3": one_of(r, &[1.2, 100.0]), "wind_m_s": [one_of(r, &[0.0, 3.0]), 0.0, 0.0],
                "target_drag_area_m2": one_of(r, &[0.0, 0.05]) })
    });
    effects
}

/// The scene of `seed`.
fn scene(seed: u64) -> Value {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let meshes = [random.random_range(3..8), random.random_range(3..8)];
    let side = one_of(random, &[0.8, 1.2]) / f64::from(meshes[0].max(meshes[1]));
    let material = one_of(random, &["kevlar", "nylon", "spectra", "zylon", "carbon-fiber"]);
    let (cables, contact) = one_of(random, &PAIRS);
    let mut solver = json!({ "cables": cables, "contact": contact });
    if contact != "penalty" && random.random_bool(0.2) {
        solver["restitution"] = json!(one_of(random, &[0.3, 1.0]));
    }
    json!({
        "title": format!("drawn, {seed}"), "duration_s": 1.2,
        "net": { "meshes": meshes, "mesh_length_m": (1e3 * side).round() / 1e3,
                 "bullet_mass_kg": one_of(random, &[0.02, 0.05, 0.2]),
                 "cable": { "material": material, "diameter_m": one_of(random, &[5e-4, 1e-3, 2e-3]),
                            "damping_ratio": one_of(random, &[0.003, 0.03, 0.1, 0.1, 0.5, 1.0]) },
                 "fold": { "scheme": "scaled", "ratio": one_of(random, &[0.1, 0.3, 0.5]) } },
        "launch": { "speed_m_s": one_of(random, &[1.0, 2.0, 4.0]), "angle_deg": one_of(random, &[15, 25, 40]) },
        "target": target(random), "effects": effects(random), "solver": solver
    })
}

#[test]
fn what_is_drawn_keeps_momentum_and_most_of_it_energy() {
    let mut created = Vec::new();
    for seed in 0..48 {
        let scene = scene(seed);
        let case = match Case::build(&source_of(scene.clone())) {
            Ok(case) => case,
            Err(faults) => {
                println!("{seed}: refused: {faults}");
                continue;
            }
        };
        let run = Run::of(&case, |_| {}).unwrap_or_else(|failure| panic!("{seed}: {failure}\n{scene}"));
        let kept = Conservation::of(&case, &run);
        let named: Vec<&str> = case.scene().effects.named().collect();
        println!(
            "{seed}: created {:.1e}, momentum {:.1e}, angular {:.1e}, {} contacts, {} {named:?}",
            kept.energy_created,
            kept.momentum_residual,
            kept.angular_momentum_residual,
            run.work.contacts,
            scene["solver"]
        );
        assert!(
            kept.momentum_residual < 1e-9 && kept.angular_momentum_residual < 1e-4,
            "{seed}: {kept:?}\n{scene}"
        );
        created.push(kept.energy_created);
    }
    created.sort_by(f64::total_cmp);
    let share = |bound: f64| created.iter().filter(|one| **one > bound).count() as f64 / created.len() as f64;
    println!(
        "{} ran; median {:.1e}; above 1e-3: {:.3}",
        created.len(),
        created[created.len() / 2],
        share(1e-3)
    );
    assert!(created.len() >= 40, "most can be run: {}", created.len());
    // Measured 7.1e-6, and none; of 60 once 1.6e-5 and 0.067.
    assert!(created[created.len() / 2] < 7e-5 && share(1e-3) < 0.05, "{created:?}");
}
