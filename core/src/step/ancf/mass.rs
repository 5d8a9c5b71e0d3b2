//! The mass of the net as its knots see it: cables condensed to their ends, bullets added, factorised once.
//!
//! A bullet is a point that shares its coordinates with the knot it hangs on, so that Eq. 3.15b holds by itself and
//! its mass is a number on the diagonal: no multiplier, and no drift of a constraint. The same is done at every
//! knot where cables meet (Eq. 3.15a).

use crate::net::Net;

use super::band::{BandMatrix, band_order};
use super::element::Condensation;

/// Share of a knot's mass below which the difference between it and its cables' halves is rounding [-].
const ROUNDING: f64 = 1e-9;

/// Mass of each knot without the cables that end at it [kg]. A bullet's is all that is lumped on it; any other
/// knot has what is left when half of each cable is taken away (Eq. 3.2), which is nothing in a net from a scene.
pub fn own_mass(net: &Net) -> Vec<f64> {
    let mut own = net.mass.clone();
    for cable in net.cables.iter() {
        for knot in [cable.a, cable.b] {
            own[knot] -= 0.5 * cable.mass;
        }
    }
    for (own, lumped) in own.iter_mut().zip(&net.mass) {
        if *own < ROUNDING * lumped {
            *own = 0.0;
        }
    }
    for bullet in net.bullets {
        own[bullet] = net.mass[bullet];
    }
    own
}

/// The condensed mass matrix of all knots, factorised: L Lᵀ in a band along the diagonal.
pub struct KnotMass {
    /// Place of each knot in the band.
    pub(super) place: Vec<usize>,
    width: usize,
    /// One over the diagonal of L.
    inverse_diagonal: Vec<f64>,
    /// Below the diagonal, column by column; the same row by row, the nearest first.
    columns: Vec<f64>,
    rows: Vec<f64>,
    /// The right side in the order of the band.
    sorted: Vec<f64>,
}

impl KnotMass {
    /// That of `net`, whose cables have elements of mass `element_mass` [kg] and are condensed as `condensed` says.
    pub fn new(net: &Net, element_mass: &[f64], condensed: &Condensation) -> KnotMass {
        let n = net.n_knots();
        let place = band_order(n, net.cables.iter().map(|cable| [cable.a, cable.b]));
        let apart = net.cables.iter().map(|cable| place[cable.a].abs_diff(place[cable.b]));
        let width = apart.max().unwrap_or(0);
        let mut matrix = BandMatrix::zeros(n, width);
        for (knot, own) in own_mass(net).into_iter().enumerate() {
            *matrix.at(place[knot], place[knot]) += own;
        }
        for (cable, mass) in net.cables.iter().zip(element_mass) {
            let [a, b] = [place[cable.a], place[cable.b]];
            *matrix.at(a, a) += mass * condensed.ends[0][0];
            *matrix.at(b, b) += mass * condensed.ends[1][1];
            *matrix.at(a, b) += mass * condensed.ends[0][1];
        }
        matrix.factorise();
        let mut knot_mass = KnotMass {
            place,
            width,
            inverse_diagonal: (0..n).map(|j| 1.0 / *matrix.at(j, j)).collect(),
            columns: vec![0.0; n * width],
            rows: vec![0.0; n * width],
            sorted: vec![0.0; n],
        };
        for j in 0..n {
            for k in 1..=width.min(n - 1 - j) {
                let value = *matrix.at(j + k, j);
                knot_mass.columns[j * width + k - 1] = value;
                // Row j + k holds its entries in the order of the columns, the last beside the diagonal.
                knot_mass.rows[(j + k) * width + width - k] = value;
            }
        }
        knot_mass
    }

    /// From forces on all knots along one axis [N] to their accelerations [m/s²], in place.
    #[inline(always)]
    pub fn solve(&mut self, values: &mut [f64]) {
        let (n, width) = (self.place.len(), self.width);
        let sorted = &mut self.sorted;
        for (value, &place) in values.iter().zip(&self.place) {
            sorted[place] = *value;
        }
        // Both ways by columns of what is left, which has no sum to reorder.
        for j in 0..n {
            let value = sorted[j] * self.inverse_diagonal[j];
            sorted[j] = value;
            let below = &mut sorted[j + 1..(j + 1 + width).min(n)];
            for (other, factor) in below.iter_mut().zip(&self.columns[j * width..(j + 1) * width]) {
                *other -= factor * value;
            }
        }
        for j in (0..n).rev() {
            let value = sorted[j] * self.inverse_diagonal[j];
            sorted[j] = value;
            let first = j.saturating_sub(width);
            let row = &self.rows[j * width..(j + 1) * width];
            for (other, factor) in sorted[first..j].iter_mut().zip(&row[width - (j - first)..]) {
                *other -= factor * value;
            }
        }
        for (value, &place) in values.iter_mut().zip(&self.place) {
            *value = sorted[place];
        }
    }
}
