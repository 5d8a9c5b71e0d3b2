//! The mass of the net as its knots see it: cables condensed to their ends, bullets added, factorised once.
//!
//! A bullet is a point that shares its coordinates with the knot it hangs on, so that Eq. 3.15b holds by itself and
//! its mass is a number on the diagonal: no multiplier, and no drift of a constraint. The same is done at every
//! knot where cables meet (Eq. 3.15a).

use crate::net::Net;

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
    place: Vec<usize>,
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
        // Entry k of column j is that of row j + k.
        let mut matrix = vec![0.0; n * (width + 1)];
        let at = |i: usize, j: usize| j * (width + 1) + (i - j);
        for (knot, own) in own_mass(net).into_iter().enumerate() {
            matrix[at(place[knot], place[knot])] += own;
        }
        for (cable, mass) in net.cables.iter().zip(element_mass) {
            let [a, b] = [place[cable.a], place[cable.b]];
            matrix[at(a, a)] += mass * condensed.ends[0][0];
            matrix[at(b, b)] += mass * condensed.ends[1][1];
            matrix[at(a.max(b), a.min(b))] += mass * condensed.ends[0][1];
        }
        factorise(&mut matrix, n, width);
        let mut knot_mass = KnotMass {
            place,
            width,
            inverse_diagonal: (0..n).map(|j| 1.0 / matrix[at(j, j)]).collect(),
            columns: vec![0.0; n * width],
            rows: vec![0.0; n * width],
            sorted: vec![0.0; n],
        };
        for j in 0..n {
            for k in 1..=width.min(n - 1 - j) {
                let value = matrix[at(j + k, j)];
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

/// Cholesky's factorisation of a band, in place; a matrix of masses is positive definite.
fn factorise(matrix: &mut [f64], n: usize, width: usize) {
    let at = |i: usize, j: usize| j * (width + 1) + (i - j);
    for j in 0..n {
        let last = (j + width).min(n - 1);
        let root = matrix[at(j, j)].sqrt();
        for i in j..=last {
            matrix[at(i, j)] /= root;
        }
        matrix[at(j, j)] = root;
        for k in j + 1..=last {
            for i in k..=last {
                matrix[at(i, k)] -= matrix[at(i, j)] * matrix[at(k, j)];
            }
        }
    }
}

/// Places of `n` knots such that those on one cable stand close together: Cuthill and McKee's order.
fn band_order(n: usize, cables: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
    let mut neighbours = vec![Vec::new(); n];
    for [a, b] in cables {
        neighbours[a].push(b);
        neighbours[b].push(a);
    }
    let degree: Vec<usize> = neighbours.iter().map(Vec::len).collect();
    let mut starts: Vec<usize> = (0..n).collect();
    starts.sort_by_key(|&knot| degree[knot]);
    let mut place = vec![usize::MAX; n];
    let mut order = Vec::with_capacity(n);
    for start in starts {
        if place[start] != usize::MAX {
            continue;
        }
        place[start] = order.len();
        order.push(start);
        let mut next = place[start];
        while next < order.len() {
            let mut found = neighbours[order[next]].clone();
            found.sort_by_key(|&knot| (degree[knot], knot));
            for knot in found {
                if place[knot] == usize::MAX {
                    place[knot] = order.len();
                    order.push(knot);
                }
            }
            next += 1;
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid's band is as wide as its shorter side and one, whatever the numbers of its knots.
    #[test]
    fn knots_of_a_grid_stand_in_a_narrow_band() {
        let (rows, columns) = (11, 30);
        // Numbered as badly as may be.
        let number = |row: usize, column: usize| (row * columns + column) * 7 % (rows * columns);
        let mut cables = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                if row + 1 < rows {
                    cables.push([number(row, column), number(row + 1, column)]);
                }
                if column + 1 < columns {
                    cables.push([number(row, column), number(row, column + 1)]);
                }
            }
        }
        let place = band_order(rows * columns, cables.iter().copied());
        let mut sorted = place.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..rows * columns));
        let width = cables.iter().map(|[a, b]| place[*a].abs_diff(place[*b])).max().unwrap();
        assert!(width <= rows + 1, "{width}");
    }
}
