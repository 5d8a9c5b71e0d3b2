//! The largest step at which a net of springs is stable, and the shares of it that are chosen.
//!
//! Stability (semi-implicit Euler with explicit damping): h ω < 2 (√(1 + ζ²) − ζ), with ω² the
//! largest eigenvalue of M⁻¹ K and ζ = c ω / (2 k). The largest eigenvalue is bounded by that of
//! the net whose cables all pull in one direction, the worst case of any shape: a graph Laplacian,
//! found by power iteration.

use nalgebra::Vector3;

use crate::cable::stored_between;
use crate::net::Net;
use crate::solver::Integrator;

/// Share of the stable step that is chosen when a scene leaves the step out. The stable step is that of
/// the worst shape, so no net comes near its own. Bullets are as exact as with 0.6 (4e-4 m at 0.5 s on
/// the Cubesat net, against a step of 2 us), and energy rises by at most 7e-5 of the launch energy.
pub const SAFE: f64 = 0.9;

/// Share of the stable step at which a step resolves the cables, for what takes turns with them: a penalty force adds its ω² to theirs.
pub const RESOLVES: f64 = 0.6;

/// Share of the own step that is taken where a thread is drawn along the net: what contacts do to its segments after it pulled it hears
/// a sub-step late. Of the energy at hand 64 Cubesats about z with a `cinch` and friction 0.5 made at most 3.1e-3 (10 above 1e-3) with 1, 1.2e-3 (2) with 0.67,
/// 5.2e-4 with this; 32 and 64 under 5 N 2.8e-3 (5) with 1, 3.6e-4 with this.
pub const DRAWN: f64 = 0.45;

/// Share of the stable step at which semi-implicit Euler makes little energy of cables that hardly damp, and of those that do
/// not at all, without bounces and with full ones. Eight members each of the undamped free Cubesat, `cube-fixed` and
/// `envisat-mockup-fixed` made at most 5.9e-4, 5.7e-4 and 3.2e-3 of the energy at hand with 0.2, 5.9e-4, 5.6e-4 and 7.7e-4 with 0.1; with
/// restitution 1 6.8e-3, 4.5e-3 and 6.2e-3 with 0.2, 2.7e-3, 2.5e-3 and 1.9e-3 with 0.1, 7.5e-4, 6.5e-4 and 7.4e-4 with 0.05.
const FINE: f64 = 0.2;
const UNDAMPED: [f64; 2] = [0.1, 0.05];

/// Over these shares, where strands touch: they do throughout the flight. Undamped nets of 4 x 4 and 6 x 6 meshes of 1 m with `self_contact`, eight of each,
/// made at most 1.7e-3 of the energy at hand without bounces and 2.6e-3 with full ones, 3.5e-4 and 3.4e-4 so.
const OF_STRANDS: f64 = 0.5;

/// Damping ratio from which cables take what that makes [-]: with 0.02 the free Cubesat makes 1.4e-4 whatever the restitution, with
/// 0.003 3.5e-4 and 1.2e-3 with 0 and 1.
const HARDLY: f64 = 0.01;

/// Damping ratio of the two knots of a cable from which it takes what a step makes [-]. On the net of
/// Table 3.2 semi-implicit Euler makes of its launch energy 3e-1 at 0, 1e-2 at 0.003, 6e-4 at 0.03, 7e-5 at 0.1; the
/// secant force 6e-4, 2e-4, 6e-5 and 7e-6.
const DAMPED: f64 = 0.1;

/// The same up to which it takes no more than 1e-2 of the launch energy beyond what cables take by their law. Nets of 1 x 1 to 20 x 20 meshes at
/// 1, 10 and 60 m/s lost at most 5e-3 with the ratio of Table 3.2 (0.1 to 0.141 of two knots), 2.6e-2 with 1.2 times that, 3.6e-2 with three
/// times, 8e-2 with fifty; 4.5e-4 with the secant force, in 1.4 to 2 times the time.
const MOST_DAMPED: f64 = 0.15;

/// Own step over the time of the fastest pair of knots, h ω [-]. A cable that goes taut within a step is stretched
/// by what it goes on until the next, which holds up to (h ω)² of the pair's energy. At damping 0.1 that made
/// 2e-2 of one mesh (h ω = 1.03), 2e-3 of nets with an edge three times as thick (0.93) and of 2 x 2 meshes
/// (0.87), 8e-4 of 3 x 3, 5e-5 of 5 x 5 (0.788), 7e-5 of 10 x 10 (0.787), which pays for no other integrator.
const PAIR: f64 = 0.788;

/// What a cable that goes taut within a step may hold of its way, over the launch energy [-]: light bullets before a heavy net are stopped
/// by a cable that bears much of all energy. Nets of 2 mm nylon with bullets of 5 to 200 g made 0.1 to 0.7 of it (of 2.6e-2 1.9e-2, of 1.3e-3
/// 4.6e-4), with the secant force 1.8e-4 at most; built-in scenes have 1.3e-4 to 2.5e-4.
const OVERSHOOT: f64 = 1e-3;

/// Whether some cable of `net` hardly damps.
fn hardly_damps(net: &Net) -> bool {
    net.least_damping_ratio() < DAMPED
}

/// The integrator that is `chosen`, or which one suits `net` where that is left open.
pub fn integrator(chosen: Integrator, net: &Net) -> Integrator {
    if chosen != Integrator::Auto {
        return chosen;
    }
    let step = SAFE * stable_step(net);
    let fastest = net.cables.iter().map(|cable| cable.natural_frequency()).fold(0.0, f64::max);
    if hardly_damps(net)
        || net.most_damping_ratio() > MOST_DAMPED
        || step * fastest > PAIR
        || most_overshoot(net, step) > OVERSHOOT
    {
        Integrator::Secant
    } else {
        Integrator::Symplectic
    }
}

/// What a cable of `net` holds that is stretched by the way of a step at the speed of the shot, over the launch energy [-].
fn most_overshoot(net: &Net, step: f64) -> f64 {
    let speed = net.launch_velocity.iter().map(Vector3::norm).fold(0.0, f64::max);
    let stiffest = net.cables.iter().map(|cable| cable.stiffness).fold(0.0, f64::max);
    stored_between(stiffest, 0.0, speed * step) / net.launch_energy()
}

/// Into how many a sub-step of `substep` seconds is to be cut from the first contact on, when other integrators give
/// way to semi-implicit Euler; `restitution`: of contacts [-], `of_strands`: of those of the net with itself, where it has them.
pub fn parts_in_contact(
    integrator: Integrator,
    net: &Net,
    restitution: f64,
    of_strands: Option<f64>,
    substep: f64,
) -> u32 {
    if integrator != Integrator::Symplectic && hardly_damps(net) {
        let restitution = restitution.max(of_strands.unwrap_or(0.0));
        let finer = if of_strands.is_some() { OF_STRANDS } else { 1.0 };
        let undamped = finer * (UNDAMPED[0] + restitution * (UNDAMPED[1] - UNDAMPED[0]));
        let share = undamped + (net.least_damping_ratio() / HARDLY).min(1.0) * (FINE - undamped);
        (substep / (share * stable_step(net))).ceil().max(1.0) as u32
    } else {
        1
    }
}

/// Largest step at which the net is stable [s].
pub fn stable_step(net: &Net) -> f64 {
    let cables = &net.cables;
    let mut mode: Vec<f64> = (0..net.n_knots()).map(|i| (12.9898 * i as f64).sin()).collect();
    let mut eigenvalue = 0.0_f64;
    // The bound below adds what a few dozen iterations may still miss.
    for _ in 0..60 {
        let mut image = vec![0.0; mode.len()];
        for cable in cables.iter() {
            let pull = cable.stiffness * (mode[cable.a] - mode[cable.b]);
            image[cable.a] += pull / net.mass[cable.a];
            image[cable.b] -= pull / net.mass[cable.b];
        }
        let norm = image.iter().map(|x| x * x).sum::<f64>().sqrt();
        let before = mode.iter().map(|x| x * x).sum::<f64>().sqrt();
        eigenvalue = norm / before;
        mode = image.iter().map(|x| x / norm).collect();
    }
    let frequency = (1.02 * eigenvalue).sqrt();
    let damping = cables.iter().map(|c| 0.5 * c.damping * frequency / c.stiffness).fold(0.0, f64::max);
    2.0 * ((1.0 + damping * damping).sqrt() - damping) / frequency
}
