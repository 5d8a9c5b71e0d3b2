//! Cables: stiffness, masses, snaps.

use nalgebra::Vector3;
use serde_json::json;

use super::{OVERLAPS, SOFT, TOO_LONG, material, net, small_capture, with, with_target};
use crate::study::stress::hard::{StressCase, Theme};

/// Why undamped elements rise above an earlier minimum, and how far. Measured: 6.4e-3.
const SWINGS: &str =
    "leap-frog keeps another energy than this one, which swings about it in the fastest modes of elements";
const SWING: [(&str, f64, f64); 1] = [("energy", 1e-3, 6e-2)];

/// Names of the ladder: one a stiffness and step.
const LADDER: [(f64, [&str; 4]); 4] = [
    (4.456e8, ["e-0.4", "e-0.4-step-x2", "e-0.4-step-x5", "e-0.4-step-x10"]),
    (6e9, ["e-6", "e-6-step-x2", "e-6-step-x5", "e-6-step-x10"]),
    (7e10, ["e-70", "e-70-step-x2", "e-70-step-x5", "e-70-step-x10"]),
    (2.3e11, ["e-230", "e-230-step-x2", "e-230-step-x5", "e-230-step-x10"]),
];

/// The cases.
pub fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (modulus, names) in LADDER {
        for (name, times) in names.into_iter().zip([1.0, 2.0, 5.0, 10.0]) {
            let scene =
                with(small_capture(), json!({ "net": { "cable": { "material": material(modulus) } } }));
            let why = "stiff cables ring far faster than a step, and a step hides what they do";
            let hard = StressCase::new(Theme::Stiffness, name, why, scene)
                .at_times_step(times)
                .may_be_refused_at(&["solver.step_s"]);
            cases.push(limits_of_a_rung(hard, modulus, times));
        }
    }
    cases.extend(masses());
    cases.extend(snaps());
    cases
}

/// The engine's cables and a force of our own take turns, so neither feels the other within a step.
fn limits_of_a_rung(hard: StressCase, modulus: f64, times: f64) -> StressCase {
    if times == 1.0 {
        return if modulus > 5e9 { hard.not_run("joints+penalty", TOO_LONG) } else { hard };
    }
    // The steps halve one another; that which it takes by itself is the first of the ladder, and not run again.
    hard.once()
}

fn masses() -> [StressCase; 3] {
    // 0.1 g a knot: 2 rho A l0 of 56 mm of 1 mm nylon.
    let light = |bullet_mass| net(6, 0.056, bullet_mass, 5.0, 0.25);
    let cube = |side: f64| json!({ "cuboid": [side, side, side] });
    [
        StressCase::new(
            Theme::MassRatio,
            "bullets-1-kg",
            "a bullet pulls through cables of knots ten thousand times lighter",
            light(1.0),
        ),
        StressCase::new(
            Theme::MassRatio,
            "target-8226-kg",
            "a knot of 0.1 g is all that tells 8 t of debris that it was touched",
            with_target(
                light(0.03),
                cube(0.12),
                0.2,
                json!({ "mass_kg": 8226.0, "spin_rad_s": [0.1, 0.2, 0.3] }),
            ),
        )
        .limited("joints+penalty", SOFT, &["solver.penalty.stiffness=1e8"], &OVERLAPS)
        .limited("explicit+penalty", SOFT, &["solver.penalty.stiffness=1e8"], &OVERLAPS),
        StressCase::new(
            Theme::MassRatio,
            "target-10-g",
            "bullets a hundred times heavier than the target throw it about",
            with_target(
                light(1.0),
                cube(0.1),
                0.2,
                json!({ "mass_kg": 0.01, "spin_rad_s": [0.1, 0.2, 0.3] }),
            ),
        ),
    ]
}

fn snaps() -> [StressCase; 3] {
    let chatter = with(net(4, 0.07, 0.03, 0.0, 10.0), json!({ "net": { "fold": { "ratio": 1.0 } } }));
    [
        StressCase::new(
            Theme::Snap,
            "bullets-100-m-s",
            "fully slack cables go taut all at once, two meshes within a step",
            net(6, 0.07, 0.03, 100.0, 0.05),
        ),
        StressCase::new(
            Theme::Snap,
            "bullets-100-m-s-undamped",
            "the same with nothing in the cables that takes the energy away",
            with(net(6, 0.07, 0.03, 100.0, 0.05), json!({ "net": { "cable": { "damping_ratio": 0.0 } } })),
        )
        .limited("ancf+impulse", SWINGS, &[], &SWING)
        .limited("ancf+penalty", SWINGS, &[], &SWING),
        StressCase::new(
            Theme::Snap,
            "chatter",
            "every cable at exactly its unstretched length for 10 s, its knots trembling at 1 cm/s",
            chatter,
        )
        .starting(|built| {
            // Neighbours against each other, out of the plane and in it.
            let [rows, columns] = built.net.grid;
            for row in 0..rows {
                for column in 0..columns {
                    let sign = if (row + column) % 2 == 0 { 0.01 } else { -0.01 };
                    built.net.launch_velocity[row * columns + column] = sign * Vector3::new(0.1, 1.0, 0.3);
                }
            }
        }),
    ]
}
