//! The largest step at which elements are stable, and the share of it that is chosen.
//!
//! Leap-frog with explicit damping: h² ω² / 2 + h γ < 2, with ω² the largest eigenvalue of M⁻¹ K and γ that of M⁻¹ C.
//! Those of a net are no larger than the largest of an element by itself: ω² = κ E A / (μ l) + κ_b E I / (μ l³) for a
//! straight one at its own length, γ = κ_c c / μ.

use crate::net::Net;
use crate::solver::Ancf;

use super::element::{BEND, ElementMatrix, STRETCH, largest_eigenvalue};
use super::law::bending_stiffness;

/// Share of the stable step that is chosen when a scene leaves the step out.
pub const SAFE: f64 = 0.6;

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
