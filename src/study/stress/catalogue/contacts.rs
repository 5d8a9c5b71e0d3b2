//! Contacts: thin parts, edges, overlaps at the start, many at once.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::{COARSE, OVERLAPS, RISES, SOFT, TOO_LONG, net, with, with_target};
use crate::case::Built;
use crate::json;
use crate::study::stress::hard::{StressCase, Theme};

/// The cases.
pub fn cases() -> Vec<StressCase> {
    [thin_parts(), edges().to_vec(), overlaps().to_vec(), many().to_vec()].concat()
}

/// Every knot flies as the first bullet does.
fn all_alike(built: &mut Built) {
    let bullet = built.net.launch_velocity[built.net.bullets[0]];
    built.net.launch_velocity.fill(bullet);
}

/// A flat open net that flies straight on.
fn flat(meshes: u32, mesh: f64, speed: f64, duration: f64) -> Value {
    with(
        net(meshes, mesh, 0.03, speed, duration),
        json!({ "launch": { "angle_deg": 0.0 }, "net": { "fold": { "ratio": 1.0 } } }),
    )
}

/// Bullets at 10 and 50 m/s on a panel of 2 mm: the four of them go through it.
const GOES_THROUGH: [(&str, f64, f64); 2] = [("overlap", 1.0, 30.0), ("through", 1.0, 4.0)]; // measured 2.9, 4

fn thin_parts() -> Vec<StressCase> {
    let why = "a panel of 2 mm, less than knots and bullets fly within a step";
    let panel = |speed: f64, duration: f64| {
        let net = flat(8, 0.05, speed, duration);
        with_target(net, json!({ "cuboid": [0.002, 2.0, 2.0] }), 0.02, json!({ "mass_kg": 2.0 }))
    };
    let mut cases = Vec::new();
    for (speed, names) in [
        (1.0, ["panel-1-m-s", "panel-1-m-s-step-x2", "panel-1-m-s-step-x5"]),
        (10.0, ["panel-10-m-s", "panel-10-m-s-step-x2", "panel-10-m-s-step-x5"]),
        (50.0, ["panel-50-m-s", "panel-50-m-s-step-x2", "panel-50-m-s-step-x5"]),
    ] {
        for (name, times) in names.into_iter().zip([1.0, 2.0, 5.0]) {
            let hard = StressCase::new(Theme::ThinParts, name, why, panel(speed, 0.1))
                .starting(all_alike)
                .at_times_step(times)
                .may_be_refused_at(&["solver.step_s"]);
            cases.push(match (times == 1.0, speed > 20.0, speed > 5.0) {
                (false, ..) => hard.once(),
                (true, true, _) => hard
                    .limited("explicit+penalty", SOFT, &["solver.penalty.stiffness=1e10"], &GOES_THROUGH)
                    .not_run("joints+penalty", TOO_LONG),
                (true, _, true) => hard
                    .limited("joints+penalty", SOFT, &["solver.penalty.stiffness=1e9"], &GOES_THROUGH)
                    .limited("explicit+penalty", SOFT, &["solver.penalty.stiffness=1e9"], &GOES_THROUGH),
                // Measured: 1.8e-3.
                (true, ..) => hard.limited("joints+penalty", COARSE, &["solver.step_s=9e-6"], &RISES),
            });
        }
    }
    cases
}

fn edges() -> [StressCase; 5] {
    let shot = |speed| flat(6, 0.07, speed, 0.6);
    let onto = |part: Value, distance: f64, more: Value| {
        let mut target = json!({ "motion": "fixed" });
        json::merge(&mut target, more);
        with_target(shot(1.5), part, distance, target)
    };
    let wedge = json!({ "convex": { "points_m": [
        [0.0, -0.5, 0.0], [0.0, 0.5, 0.0],
        [0.2, -0.5, 0.02], [0.2, 0.5, 0.02], [0.2, -0.5, -0.02], [0.2, 0.5, -0.02]] } });
    // A fold that is not quite symmetric: nothing balances for ever.
    [
        StressCase::new(
            Theme::Edges,
            "knife-edge",
            "the middle row of knots falls on a wedge of 11 degrees, where the normal jumps",
            onto(wedge, 0.3, json!({})),
        )
        .starting(all_alike),
        StressCase::new(
            Theme::Edges,
            "needle",
            "the centre knot meets the tip of a needle of 2 mm head on",
            onto(
                json!({ "cylinder": { "radius_m": 0.001, "length_m": 0.3 }, "attitude_deg": [0.0, 0.0, 90.0] }),
                0.2,
                json!({}),
            ),
        )
        .starting(all_alike),
        StressCase::new(
            Theme::Edges,
            "pole",
            "the centre knot meets the pole of a ball, the others its round",
            onto(json!({ "ball": { "radius_m": 0.1 } }), 0.15, json!({})),
        )
        .starting(all_alike)
        .limited("joints+penalty", COARSE, &["solver.step_s=5e-6"], &RISES), // measured 1.9e-3
        StressCase::new(
            Theme::Edges,
            "corner",
            "the centre knot meets the corner of a cube, where three faces compete",
            onto(
                json!({ "cuboid": [0.15, 0.15, 0.15] }),
                0.2,
                json!({ "attitude_deg": [0.0, -35.264_389_682_754_66, 45.0] }),
            ),
        )
        .starting(all_alike),
        StressCase::new(
            Theme::Edges,
            "off-the-edge",
            "half of the net lies on a plate and is dragged over its edge by the other half",
            onto(json!({ "cuboid": [0.05, 0.4, 0.6] }), 0.1, json!({ "offset_m": [0.22, 0.0] })),
        )
        .starting(all_alike),
    ]
}

fn overlaps() -> [StressCase; 4] {
    let cube = json!({ "cuboid": [0.1, 0.1, 0.1] });
    let shot = || net(6, 0.07, 0.03, 1.8, 0.5);
    [
        StressCase::new(
            Theme::Overlap,
            "knots-inside",
            "knots that start inside the target would be shot out of it",
            with_target(shot(), cube.clone(), 0.04, json!({ "mass_kg": 1.0 })),
        )
        .may_be_refused_at(&["target.distance_m"]),
        StressCase::new(
            Theme::Overlap,
            "touching",
            "the target touches every knot of the folded net exactly",
            with_target(shot(), cube.clone(), 0.05 + 5e-4, json!({ "mass_kg": 1.0 })),
        ),
        StressCase::new(
            Theme::Overlap,
            "bullets-in-each-other",
            "the whole net is folded into a tenth of a millimetre",
            with(
                with_target(shot(), cube.clone(), 0.3, json!({ "mass_kg": 1.0 })),
                json!({ "net": { "fold": { "ratio": 2e-4 } } }),
            ),
        ),
        StressCase::new(
            Theme::Overlap,
            "coincident-knots",
            "all knots at one point: cables without length or direction",
            with_target(shot(), cube, 0.3, json!({ "mass_kg": 1.0 })),
        )
        .starting(|built| built.net.folded.fill(Vector3::zeros())),
    ]
}

fn many() -> [StressCase; 4] {
    let why = "all knots meet one face of a free plate in the same step";
    let plate = |restitution: f64| {
        let net = flat(8, 0.05, 2.0, 0.1);
        let plate = json!({ "cuboid": [0.05, 0.6, 0.6] });
        let scene = with_target(net, plate, 0.07, json!({ "mass_kg": 1.0, "offset_m": [0.02, 0.03] }));
        with(scene, json!({ "solver": { "restitution": restitution } }))
    };
    [
        StressCase::new(Theme::ManyContacts, "one-face", why, plate(0.0)).starting(all_alike).limited(
            "joints+penalty",
            SOFT,
            &["solver.penalty.stiffness=1e8"],
            &OVERLAPS,
        ),
        StressCase::new(Theme::ManyContacts, "one-face-half-restitution", why, plate(0.5))
            .starting(all_alike)
            .may_be_refused_at(&["solver.restitution"]),
        StressCase::new(Theme::ManyContacts, "one-face-full-restitution", why, plate(1.0))
            .starting(all_alike)
            .may_be_refused_at(&["solver.restitution"]),
        StressCase::new(
            Theme::ManyContacts,
            "one-point",
            "twenty-five knots hit the same point of a free cube",
            with_target(
                flat(4, 0.05, 2.0, 0.1),
                json!({ "cuboid": [0.1, 0.1, 0.1] }),
                0.1,
                json!({
                "mass_kg": 1.0, "offset_m": [0.02, 0.03] }),
            ),
        )
        .starting(|built| {
            built.net.folded.fill(Vector3::zeros());
            all_alike(built);
        })
        .limited("joints+penalty", SOFT, &["solver.penalty.stiffness=1e8"], &OVERLAPS),
    ]
}
