//! What is driven: sub-steps, bounces, winches, falls, tugs, prescribed spin, effects by twos and all together.

use serde_json::{Value, json};

use super::{BY_CHANCE, OR_NONE, OVERLAPS, PRESSED, SOFT, TOO_LONG, net, small_capture, with, with_target};
use crate::study::stress::hard::{StressCase, Theme};

/// The cases.
pub fn cases() -> Vec<StressCase> {
    [
        substeps().to_vec(),
        bounces().to_vec(),
        winches(),
        thin_parts().to_vec(),
        spins().to_vec(),
        together().to_vec(),
    ]
    .concat()
}

/// Threads along the perimeter that close at `tension` [N] from the first contact on.
fn closing(tension: f64) -> Value {
    json!({ "effects": { "closing": { "layout": "tube", "trigger": { "on": "contact", "delay_s": 0.0 },
            "reel_speed_m_s": 1.0, "max_tension_n": tension } } })
}

fn substeps() -> [StressCase; 2] {
    let in_substeps = |n: u32, tension: f64| {
        with(with(small_capture(), closing(tension)), json!({ "solver": { "substeps": n } }))
    };
    [
        StressCase::new(
            Theme::Substeps,
            "substeps-4",
            "a step in four, with a thread that acts in each of them",
            in_substeps(4, 1.0),
        ),
        StressCase::new(
            Theme::Substeps,
            "substeps-8-winch-20-n",
            "the same in eight, with a thread that throws a knot at the speed of the shot in 20 us",
            in_substeps(8, 20.0),
        ),
    ]
    .map(|case| {
        let case = case.once().may_be_refused_at(&["solver.substeps"]);
        if case.name == "substeps-4" { case } else { soft(case, "solver.penalty.stiffness=1e9") }
    })
}

fn bounces() -> [StressCase; 5] {
    let bouncing =
        |restitution: f64| with(small_capture(), json!({ "solver": { "restitution": restitution } }));
    [
        StressCase::new(
            Theme::Restitution,
            "restitution-0.5",
            "knots that cables press onto the target bounce at every step",
            bouncing(0.5),
        ),
        StressCase::new(
            Theme::Restitution,
            "restitution-1",
            "the same, and no bounce takes anything",
            bouncing(1.0),
        ),
        StressCase::new(
            Theme::Restitution,
            "restitution-1-friction-1",
            "friction and full restitution of knots and of whole cables",
            with(
                bouncing(1.0),
                json!({ "effects": { "friction": { "coefficient": 1.0 }, "cable_contact": {} } }),
            ),
        ),
        StressCase::new(
            Theme::Restitution,
            "pressed-whole",
            "whole cables, drawn tight over the edges of a heavier box, are pressed in and pushed out",
            with(bouncing(0.0), json!({ "target": { "mass_kg": 3.5 }, "effects": { "cable_contact": {} } })),
        )
        // Measured 1.0e-2 of the energy at hand; 16 members with joints 8.5e-5 at most, and 0.3 to 1.8 radii.
        .limited("joints+penalty", SOFT, &["solver.penalty.stiffness=1e9"], &BY_CHANCE)
        .limited("explicit+penalty", SOFT, &["solver.penalty.stiffness=1e8"], &OR_NONE),
        StressCase::new(
            Theme::Restitution,
            "pressed-whole-friction-1",
            "whole cables are pressed onto edges and rub there",
            with(
                bouncing(0.0),
                json!({ "effects": { "friction": { "coefficient": 1.0 }, "cable_contact": {} } }),
            ),
        )
        .limited("joints+penalty", SOFT, &["solver.penalty.stiffness=1e8"], &BY_CHANCE)
        .limited("explicit+penalty", SOFT, &["solver.penalty.stiffness=1e8"], &OVERLAPS),
    ]
    .map(|case| case.once().may_be_refused_at(&["solver.restitution"]))
}

fn winches() -> Vec<StressCase> {
    [(5.0, "winch-5-n"), (20.0, "winch-20-n"), (50.0, "winch-50-n")]
        .into_iter()
        .map(|(tension, name)| {
            let why =
                "a thread throws knots of a tenth of a gram at the speed of the shot within a part of a step";
            let case =
                StressCase::new(Theme::Winch, name, why, with(small_capture(), closing(tension))).once();
            let holds_from =
                if tension < 20.0 { "solver.penalty.stiffness=1e8" } else { "solver.penalty.stiffness=1e9" };
            soft(case, holds_from)
        })
        .collect()
}

/// A case in which knots are pressed deep into what is soft, which it `holds_from`.
fn soft(case: StressCase, holds_from: &'static str) -> StressCase {
    case.limited("explicit+penalty", SOFT, &[holds_from], &OVERLAPS).not_run("joints+penalty", TOO_LONG)
}

/// An open net at `speed`, `distance` before a plate of 2 mm with sides of `side`.
fn before_a_plate(speed: f64, distance: f64, side: f64, duration: f64) -> Value {
    let open = with(
        net(6, 0.1, 0.03, speed, duration),
        json!({ "launch": { "angle_deg": 0.0 }, "net": { "fold": { "ratio": 1.0 } } }),
    );
    with_target(open, json!({ "cuboid": [0.002, side, side] }), distance, json!({ "mass_kg": 1.0 }))
}

fn thin_parts() -> [StressCase; 3] {
    let fall = with(
        before_a_plate(0.1, 5.0, 2.0, 1.1),
        json!({ "target": { "motion": "fixed" }, "effects": { "cabin": { "gravity_m_s2": [9.81, 0.0, 0.0] } } }),
    );
    let tug = with(
        before_a_plate(0.5, 0.2, 1.5, 0.6),
        json!({ "effects": { "tug": { "start": { "on": "time", "at_s": 0.1 }, "time_s": 0.5,
                "direction": [1.0, 0.2, 0.1], "force_n": 10.0 } } }),
    );
    let winch = with(
        before_a_plate(2.0, 0.1, 0.3, 0.4),
        json!({ "effects": { "closing": { "layout": "tube", "trigger": { "on": "contact", "delay_s": 0.02 },
                "reel_speed_m_s": 2.0, "max_tension_n": 20.0, "stop_share": 0.0 } } }),
    );
    [
        StressCase::new(
            Theme::Pulled,
            "fall-onto-a-plate",
            "a fall of 5 m makes a net a hundred times as fast as it was shot: the speed of the shot says nothing of it",
            fall,
        )
        .limited("explicit+penalty", SOFT, &["solver.penalty.stiffness=1e8"], &OVERLAPS),
        StressCase::new(
            Theme::Pulled,
            "tug-across-a-plate",
            "a tug of 10 N drags the net's centre into a plate of 2 mm, 5 mm a step and more",
            tug,
        ),
        StressCase::new(
            Theme::Pulled,
            "winch-around-a-plate",
            "threads at 20 N close around a plate of 2 mm",
            winch,
        )
        .limited("explicit+penalty", SOFT, &["solver.penalty.stiffness=1e8"], &OVERLAPS),
    ]
    .map(|case| case.once().not_run("joints+penalty", TOO_LONG))
}

fn spins() -> [StressCase; 3] {
    let held = |rate: f64| {
        with(small_capture(), json!({ "target": { "motion": "spinning", "spin_rad_s": [rate, 0.0, 0.0] } }))
    };
    let why = "what drives the target takes up every impulse, in the pose in which it acts";
    [
        StressCase::new(Theme::PrescribedSpin, "held-at-2-rad-s", why, held(2.0))
            .not_run("joints+penalty", TOO_LONG),
        StressCase::new(Theme::PrescribedSpin, "held-at-10-rad-s", why, held(10.0)),
        StressCase::new(
            Theme::PrescribedSpin,
            "held-at-20-rad-s-friction-10",
            "the same, and friction winds the net up",
            with(held(20.0), json!({ "effects": { "friction": { "coefficient": 10.0 } } })),
        )
        .not_run("joints+penalty", TOO_LONG),
    ]
    .map(StressCase::once)
}

fn together() -> [StressCase; 5] {
    let bouncing = json!({ "effects": { "self_contact": { "restitution": 1.0 } } });
    let inside = with(
        with_target(
            net(4, 0.1, 0.03, 1.8, 0.2),
            json!({ "cuboid": [0.05, 0.05, 0.05] }),
            0.02,
            json!({ "mass_kg": 1.0, "offset_m": [0.05, 0.0] }),
        ),
        json!({ "net": { "fold": { "ratio": 1.0 } }, "effects": { "cable_contact": {} } }),
    );
    let all = json!({ "effects": {
        "chaser": { "mass_kg": 100.0, "inertia_kg_m2": [10.0, 10.0, 10.0] }, "friction": { "coefficient": 0.3 }, "self_contact": {}, "cable_contact": {},
        "tug": { "start": { "on": "contact", "delay_s": 0.1 }, "time_s": 0.2, "direction": [-1.0, 0.0, 0.0],
                 "force_n": 1.0 } } });
    [
        StressCase::new(
            Theme::Together,
            "strands-bounce",
            "strands of the net bounce off each other, and nothing takes what that costs",
            with(small_capture(), bouncing.clone()),
        )
        .not_run("joints+penalty", TOO_LONG),
        StressCase::new(
            Theme::Together,
            "strands-bounce-0.9",
            "the same, and each bounce loses some: a strand that parts is in the way of others",
            with(small_capture(), json!({ "effects": { "self_contact": { "restitution": 0.9 } } })),
        )
        .not_run("joints+penalty", TOO_LONG),
        StressCase::new(
            Theme::Together,
            "strands-and-cables",
            "strands that bounce off each other lie between cables and target",
            with(with(small_capture(), bouncing), json!({ "effects": { "cable_contact": {} } })),
        )
        .limited("joints+impulse", PRESSED, &["solver.step_s=5e-5"], &OR_NONE)
        .limited("explicit+penalty", SOFT, &["solver.penalty.stiffness=1e8"], &OR_NONE)
        .not_run("joints+penalty", TOO_LONG),
        StressCase::new(
            Theme::Together,
            "all-effects",
            "threads, a tug, friction, strands, cables and a free chaser at once",
            with(with(small_capture(), closing(1.0)), all),
        )
        .not_run("joints+penalty", TOO_LONG),
        StressCase::new(
            Theme::Together,
            "cable-inside",
            "a cable lies through the target at the start, and no one can say which way is out",
            inside,
        )
        .may_be_refused_at(&["target.distance_m"]),
    ]
    .map(StressCase::once)
}
