//! The largest step at which a net of springs is stable, and the shares of it that are chosen.
//!
//! Stability (semi-implicit Euler with explicit damping): h ω < 2 (√(1 + ζ²) − ζ), with ω² the
//! largest eigenvalue of M⁻¹ K and ζ = c ω / (2 k). The largest eigenvalue is bounded by that of
//! the net whose cables all pull in one direction, the worst case of any shape: a graph Laplacian,
//! found by power iteration.

use crate::net::Net;

/// Share of the stable step that is chosen when a scene leaves the step out. The stable step is that of
/// the worst shape, so no net comes near its own. Bullets are as exact as with 0.6 (4e-4 m at 0.5 s on
/// the Cubesat net, against a step of 2 us), and energy rises by at most 7e-5 of the launch energy.
pub const SAFE: f64 = 0.9;

/// Share of the stable step at which a step resolves the cables, for what takes turns with them. A penalty
/// force adds its ω² to theirs. Threads bring knots close together: clamped between them for a minute, a
/// net loses 1.4e-4 of its angular momentum with 0.9, 4e-5 with this.
pub const RESOLVES: f64 = 0.6;

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
