//! The ends of the range: scales, steps that are too large, size.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::{MANY_PASSES, TOO_LONG, net, small_capture, with, with_target};
use crate::study::stress::hard::{StressCase, Theme};
use crate::study::stress::measure::Numbers;

/// The cases.
pub fn cases() -> Vec<StressCase> {
    [scales().to_vec(), large_steps().to_vec(), vec![ten_thousand_knots()]].concat()
}

/// Where a program without the feature `f32` refuses it.
const F32: &[&str] = &["solver.precision"];

/// Numbers of 32 bits have seven digits: they promise as much, and no more.
fn in_f32(numbers: &mut Numbers) {
    numbers.energy = Some(1e-2);
    numbers.momentum = Some(1e-4);
    numbers.angular_momentum = Some(1e-2);
}

fn scales() -> [StressCase; 5] {
    let tiny = with(
        net(6, 0.002, 1e-5, 0.2, 0.2),
        json!({ "net": { "cable": { "diameter_m": 5e-5 }, "fold": { "ratio": 0.3 } } }),
    );
    [
        StressCase::new(
            Theme::Scale,
            "millimetre-net",
            "meshes of 2 mm around a cube of 1 cm: everything is below usual tolerances",
            with_target(tiny, json!({ "cuboid": [0.01, 0.01, 0.01] }), 0.012, json!({ "mass_kg": 0.001 })),
        )
        .not_run("joints+penalty", TOO_LONG),
        StressCase::new(Theme::Scale, "300-m-net", "a net of 300 m around a target of 50 m", huge_capture())
            .not_run("joints+penalty", TOO_LONG),
        StressCase::new(
            Theme::Scale,
            "f32",
            "numbers of 32 bits keep seven digits, a net meets its target within tenths of a millimetre",
            with(small_capture(), json!({ "solver": { "precision": "f32" } })),
        )
        .may_be_refused_at(F32)
        .bounded(in_f32),
        StressCase::new(
            Theme::Scale,
            "f32-300-m-net",
            "the same where a millimetre is the seventh digit",
            with(huge_capture(), json!({ "solver": { "precision": "f32" } })),
        )
        .may_be_refused_at(F32)
        .bounded(in_f32)
        .not_run("joints+penalty", TOO_LONG),
        StressCase::new(
            Theme::Scale,
            "10-km-away",
            "everything 10 km from the origin: positions lose four digits",
            small_capture(),
        )
        .starting(|built| {
            let away = Vector3::new(6e3, -5e3, 6.2e3);
            built.net.folded.iter_mut().for_each(|position| *position += away);
            if let Some(target) = &mut built.target {
                target.position += away;
            }
        }),
    ]
}

/// A net of 300 m meets a cube of 50 m after some 3 s.
fn huge_capture() -> Value {
    let huge = with(
        net(10, 30.0, 50.0, 20.0, 8.0),
        json!({ "net": { "cable": { "material": "kevlar", "diameter_m": 0.005 }, "fold": { "ratio": 0.5 } } }),
    );
    let cube = json!({ "cuboid": [50.0, 50.0, 50.0] });
    with_target(huge, cube, 60.0, json!({ "mass_kg": 5e5, "offset_m": [3.0, 5.0] }))
}

fn large_steps() -> [StressCase; 4] {
    let kevlar = json!({ "net": { "cable": { "material": "kevlar" }, "fold": { "ratio": 0.05 } },
                         "launch": { "angle_deg": 55.0 } });
    let deployment = |step: f64| {
        with(with(net(6, 1.0, 1.0, 10.0, 1.2), kevlar.clone()), json!({ "solver": { "step_s": step } }))
    };
    let why = "the step is many times longer than anything that happens within it";
    [
        StressCase::new(Theme::LargeStep, "step-5-ms", why, deployment(5e-3))
            .may_be_refused_at(&["solver.step_s"]),
        StressCase::new(Theme::LargeStep, "step-50-ms", why, deployment(5e-2))
            .may_be_refused_at(&["solver.step_s"]),
        StressCase::new(
            Theme::LargeStep,
            "step-20-ms-capture",
            why,
            with(small_capture(), json!({ "solver": { "step_s": 0.02 } })),
        )
        .may_be_refused_at(&["solver.step_s"]),
        StressCase::new(
            Theme::LargeStep,
            "half-a-turn-a-step",
            "the target turns by half a turn within a step: no direction means anything",
            with(
                small_capture(),
                json!({ "solver": { "step_s": 5e-3 }, "target": { "spin_rad_s": [600.0, 0.0, 0.0] } }),
            ),
        )
        .may_be_refused_at(&["target.spin_rad_s", "solver.step_s"]),
    ]
}

fn ten_thousand_knots() -> StressCase {
    let shot = with(
        net(100, 0.3, 4.0, 10.0, 3.5),
        json!({ "net": { "cable": { "material": "kevlar" }, "fold": { "ratio": 0.05 } },
                "launch": { "angle_deg": 45.0 } }),
    );
    StressCase::new(
        Theme::Size,
        "ten-thousand-knots",
        "a net of 101 x 101 knots opens, meets a rocket stage and lies about it within 3.5 s",
        with(
            shot,
            json!({ "target": { "shape": "zenit-2-second-stage", "distance_m": 10.0, "mass_kg": 8226.0 } }),
        ),
    )
    .once()
    // Steps of 1 us for a penalty on knots of 0.3 g: ten minutes.
    .not_run("explicit+penalty", TOO_LONG)
    // It holds: four runs of 260 to 510 s made 2.0e-4 at most.
    .not_run("joints+impulse", MANY_PASSES)
    .not_run("joints+penalty", TOO_LONG)
}
