//! What a capture must show, over ensembles: after contact a single run is a coin.

use std::sync::OnceLock;

use crate::common::{FAST_PAIRS, below, captured, changes_of, ensemble, scene, spread, within};
use tumblenet::metrics::summary::Summary;

/// Copies of a scene: so many under the engine's own pair, which takes five times as long, and under the source's.
fn copies(scene_name: &str, counts: [usize; 2]) -> Vec<Summary> {
    let members = |(pair, n): (&str, usize)| {
        let [cables, contact] = changes_of(pair);
        ensemble(&scene(scene_name, &[&cables, &contact]), n)
    };
    FAST_PAIRS.into_iter().zip(counts).flat_map(members).collect()
}

/// Ten copies of a Cubesat scene.
fn cubesat(scene_name: &str) -> Vec<Summary> {
    copies(scene_name, [3, 7])
}

fn free_cubesat() -> &'static [Summary] {
    static SHARED: OnceLock<Vec<Summary>> = OnceLock::new();
    SHARED.get_or_init(|| cubesat("cubesat-free"))
}

fn slow_cubesat() -> &'static [Summary] {
    static SHARED: OnceLock<Vec<Summary>> = OnceLock::new();
    SHARED.get_or_init(|| cubesat("cubesat-spin-x-0.5"))
}

fn fast_cubesat() -> &'static [Summary] {
    static SHARED: OnceLock<Vec<Summary>> = OnceLock::new();
    SHARED.get_or_init(|| cubesat("cubesat-spin-x-2.0"))
}

fn stage() -> &'static [Summary] {
    static SHARED: OnceLock<Vec<Summary>> = OnceLock::new();
    SHARED.get_or_init(|| copies("stage-free", [1, 3]))
}

/// Every ensemble of this file.
fn all() -> impl Iterator<Item = &'static Summary> {
    [free_cubesat(), slow_cubesat(), fast_cubesat(), stage()].into_iter().flatten()
}

#[test]
fn a_free_cubesat_is_met_in_time() {
    let [first, _, last] = spread(free_cubesat(), "contact.first_contact_s");
    within("earliest contact, s", first, [0.74, 0.80]); // measured 0.7650
    within("latest contact, s", last, [0.74, 0.80]); // measured 0.7670
}

/// The launch momentum allows no more.
#[test]
fn a_free_cubesat_is_pushed_a_tenth_of_a_metre() {
    let [least, _, most] = spread(free_cubesat(), "target.displacement_m.0");
    within("least push, m", least, [0.10, 0.12]); // measured 0.1084
    within("largest push, m", most, [0.10, 0.12]); // measured 0.1113
}

#[test]
fn a_free_or_slowly_tumbling_cubesat_is_kept() {
    assert!(captured(free_cubesat()) >= 9); // measured 10 of 10
    assert!(captured(slow_cubesat()) >= 9); // measured 10 of 10
}

#[test]
fn a_cubesat_at_two_radians_a_second_is_lost() {
    assert!(captured(fast_cubesat()) <= 1); // measured 0 of 10
    assert!(fast_cubesat().iter().all(|summary| summary.contact.is_some()));
}

/// Held means held: the bullets passed each other and the mouth stays shut behind the target.
#[test]
fn a_kept_cubesat_is_wrapped() {
    let [least, ..] = spread(free_cubesat(), "capture.enclosed");
    let [.., widest] = spread(free_cubesat(), "capture.mouth");
    within("least enclosed share", least, [0.5, 1.0]); // measured 0.84
    below("widest mouth", widest, 0.2); // measured 0.108
}

/// Section 5.2.2: of the order of 1e-4 rad/s. A net that is perturbed by a micrometre meets the
/// stage almost symmetrically and turns it less. The peak is chance, as the source says itself, so
/// the band spans what unequal contacts can do.
#[test]
fn a_stage_is_hardly_turned() {
    let [least, _, most] = spread(stage(), "target.max_rate_change_rad_s");
    within("least rate change, 1e-4 rad/s", 1e4 * least, [0.01, 5.0]); // measured 0.11
    within("largest rate change, 1e-4 rad/s", 1e4 * most, [0.05, 5.0]); // measured 0.37
    assert_eq!(captured(stage()), stage().len());
}

#[test]
fn knots_do_not_sink_into_the_target() {
    for summary in all() {
        let depth = summary.contact.map_or(0.0, |contact| contact.max_penetration_m);
        assert!(depth < 2e-5, "{}: {depth}", summary.title); // measured at most 1.8e-6
    }
}

/// Nor do cables: of two edges that a cable crosses the second was seen when it had become the nearest, 0.20 to 0.75 mm deep in 16 members, 0.34 in their
/// middle; 0.23 at most in 64 where none waited for an edge that it rose over. Measured 0.08 mm at most, and 0.024.
#[test]
fn cables_hardly_sink_into_the_target() {
    let whole =
        ["effects.cable_contact={}", "solver.cables=explicit", "solver.contact=impulse", "duration_s=2.2"];
    let members = ensemble(&scene("cubesat-free", &whole), 8);
    let [_, median, deepest] = spread(&members, "contact.max_penetration_m");
    below("cables inside, in the middle, m", median, 1e-4);
    below("at most, m", deepest, 2.5e-4);
}

/// Where the engine moves the cables it draws them in after they were answered: 0.30 mm in the middle of 16 members and 0.47 at most before they
/// were asked for more, 0.11 and 0.25 where none waited for an edge that it rose over. Measured 0.10 and 0.15.
#[test]
fn cables_hardly_sink_in_where_the_engine_moves_them() {
    let whole = ["effects.cable_contact={}", "solver.step_s=5e-4", "duration_s=2.2"];
    let members = ensemble(&scene("cubesat-free", &whole), 8);
    let [_, median, deepest] = spread(&members, "contact.max_penetration_m");
    below("cables inside, in the middle, m", median, 2e-4);
    below("at most, m", deepest, 5e-4);
}

/// Knots at 17 m/s swing cables of the default scene round edges within a step of the engine: one of these ten members came 2.3 mm in
/// before an edge that a cable rises over waited for it. Measured 0.38 mm.
#[test]
fn cables_that_swing_round_an_edge_within_a_step_hardly_sink_in() {
    let swings = scene("cubesat-spin-x-2.0-tube-settled", &["duration_s=1.4", "capture.hold_s=0"]);
    let [_, _, deepest] = spread(&ensemble(&swings, 10), "contact.max_penetration_m");
    below("cables inside at most, m", deepest, 1e-3);
}

#[test]
fn momentum_is_kept() {
    for summary in all() {
        let (title, found) = (&summary.title, summary.conservation);
        // Measured at most 1e-13; the angular at most 1e-5, where the Cubesat turns at 0.5 rad/s.
        assert!(found.momentum_residual < 1e-12, "{title}: {found:?}");
        assert!(found.angular_momentum_residual < 1e-4, "{title}: {found:?}");
    }
}

#[test]
fn energy_does_not_come_from_nowhere() {
    for summary in all() {
        let (title, found) = (&summary.title, summary.conservation);
        // Measured at most 1e-4 and 5e-4, the latter at 2 rad/s.
        assert!(found.energy_created < 1e-3, "{title}: {found:?}");
        assert!(found.energy_residual < 5e-3, "{title}: {found:?}");
        assert!(found.energy_end_j < found.energy_start_j, "{title}: {found:?}");
    }
}
