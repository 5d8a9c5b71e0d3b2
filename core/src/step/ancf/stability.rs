//! The largest step at which elements are stable, and the share of it that is chosen.
//!
//! Leap-frog with explicit damping: h² ω² / 2 + h γ < 2, with ω² the largest eigenvalue of M⁻¹ K and γ that of M⁻¹ C.
//! Those of a net are no larger than the largest of an element by itself: ω² = κ E A / (μ l) + κ_b E I / (μ l³) for a
//! straight one at its own length, γ = κ_c c / μ.

use crate::contact::penalty::PenaltyForce;
use crate::net::Net;
use crate::solver::Ancf;
use crate::step::limits::Demands;

use super::element::{BEND, ElementMatrix, STRETCH, largest_eigenvalue};
use super::kernel::element_net;
use super::law::bending_stiffness;
use super::points::{answering_mass, point_net};

/// Share of the stable step that is chosen when a scene leaves the step out, and that where cables do not damp: leap-frog's
/// energy swings with the fastest modes, by the square of the step and more, and nothing takes these away. The free Cubesat's net made, of its launch energy,
/// until it met the target, with the first at a damping ratio of 0.1 3.1e-4, at 0.05 1.8e-3 and at 0.021 3.6e-3; at 0.003 3.1e-3 with 0.4 and 4.1e-4
/// with 0.25; with what is chosen now at most 6e-4 at any of these.
const SAFE: f64 = 0.6;
const SAFE_UNDAMPED: f64 = 0.25;

/// Damping ratio of a cable from which on it is damped [-]: the share grows up to there, by its square.
const DAMPED: f64 = 0.09;

/// The dashpot between the nodes of an element.
const DASHPOT: ElementMatrix = [[1.0, 0.0, -1.0, 0.0], [0.0; 4], [-1.0, 0.0, 1.0, 0.0], [0.0; 4]];

/// Largest step at which the elements of `net` are stable [s].
pub fn stable_step(net: &Net, ancf: &Ancf) -> f64 {
    let [stretch, bend, dashpot] = [STRETCH, BEND, DASHPOT].map(|matrix| largest_eigenvalue(&matrix));
    let n = f64::from(ancf.elements);
    let of = |index: usize| {
        let cable = &net.cables[index];
        let mass = cable.mass / n;
        let bending = if ancf.bending { n * n * n * bending_stiffness(net, index) } else { 0.0 };
        let square = (stretch * n * cable.stiffness + bend * bending) / mass;
        let damping = dashpot * n * cable.damping / mass;
        ((damping * damping + 4.0 * square).sqrt() - damping) / square
    };
    (0..net.cables.len()).map(of).fold(f64::INFINITY, f64::min)
}

/// Share of the stable step of `net` that is chosen when a scene leaves the step out [-].
pub fn safe_share(net: &Net) -> f64 {
    let damped = net.least_damping_ratio() / DAMPED;
    if damped < 1.0 { SAFE_UNDAMPED + damped * damped * (SAFE - SAFE_UNDAMPED) } else { SAFE }
}

/// [`stable_step`] with a contact force beside cables that are stable up to `stable` seconds: their ω² add up, and points answer
/// with less than the mass that is lumped on them.
pub fn stable_with_contact(stable: f64, demands: &Demands<'_>, ancf: &Ancf) -> f64 {
    if !demands.has_contact_force() {
        return stable;
    }
    let points = point_net(demands.net, ancf);
    let force = PenaltyForce::new(&points, &demands.solver.penalty);
    let answering = answering_mass(demands.net, ancf);
    let pull = 2.0 * demands.options.pull;
    let of_contact = force.stable_step(&points, &answering, demands.contact_speed(), pull);
    1.0 / (1.0 / (stable * stable) + 1.0 / (of_contact * of_contact)).sqrt()
}

/// [`Demands::throwing_step`] for knots that answer with less than their mass [s].
pub fn throwing_step(demands: &Demands<'_>, ancf: &Ancf) -> f64 {
    let lightest = |masses: &[f64]| masses.iter().copied().fold(f64::INFINITY, f64::min);
    let answering = element_net(demands.net, ancf).answering_mass;
    demands.throwing_step() * lightest(&answering) / lightest(&demands.net.mass)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The eigenvalues of one element, known to five digits.
    #[test]
    fn the_bound_follows_from_the_element() {
        println!("{:?}", [STRETCH, BEND, DASHPOT].map(|matrix| largest_eigenvalue(&matrix)));
        assert!((largest_eigenvalue(&BEND) - 8400.0).abs() < 1e-6);
    }
}
