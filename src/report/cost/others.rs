//! What general engines need for the net of Table 3.2, for scale in its diagram.
//!
//! Measured once elsewhere, on a machine like ours, each with its own tendons, joints or springs as
//! that net; wall seconds of one core per simulated second, error of the bullets at 0.5 s. They are no
//! part of a study, so they are shown only in the diagram of that very net and shot.

use crate::scene::Source;
use crate::study::cost::Study;

/// One engine.
pub struct Other {
    /// Its name and how it was used.
    pub name: &'static str,
    /// Wall time per simulated second [s/s].
    pub cost: f64,
    /// Error of the bullets at 0.5 s [m].
    pub error_m: f64,
}

/// Where the numbers come from, in words.
pub const SOURCE: &str =
    "general engines with the same net, wall time on a machine like this one, error at 0.5 s";

const OTHERS: [Other; 6] = [
    Other { name: "MuJoCo 4, tendon limits", cost: 0.11, error_m: 4.7e-3 },
    Other { name: "MuJoCo 4, hand-made damping", cost: 1.5, error_m: 1e-3 },
    Other { name: "Newton 1.8, own kernel", cost: 0.86, error_m: 1.1e-3 },
    Other { name: "compiled loop, explicit Euler", cost: 0.010, error_m: 2.6e-3 },
    Other { name: "Exudyn 1.13", cost: 3.1, error_m: 1.0e-3 },
    Other { name: "compiled loop, half the step", cost: 0.020, error_m: 4.8e-4 },
];

/// The engines that the study's scene can be compared with: all, if it is the net of Table 3.2 as
/// built in and its errors are those at 0.5 s; else none.
pub fn of(study: &Study) -> &'static [Other] {
    let at = study.windows().last().map_or(0.0, |window| window.end_s);
    let as_built_in = Source::find("deployment-kevlar")
        .and_then(|source| crate::case::Case::build(&source))
        .is_ok_and(|case| case.hash() == study.scene_hash);
    if as_built_in && (at - 0.5).abs() < 0.05 { &OTHERS } else { &[] }
}
