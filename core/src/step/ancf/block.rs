//! Linear equations of cables, [`LANES`] at a time, with each cable's own coordinates eliminated: what is left couples
//! its two ends, as the mass matrix does ([`super::element::Condensation`]), but along all axes together.
//!
//! The own coordinates of a cable couple only within an element, so their matrix has a band; its ends are a border of six
//! rows. Eliminated by L D Lᵀ without exchange: a mass matrix plus what stiffness adds is positive definite.

use super::element::COORDINATES;
use super::motion::{LANES, Lanes};
use crate::state::elements::NodeList;

/// Axes of both ends.
pub(super) const BORDER: usize = 6;

/// Entries beside the diagonal: a coordinate couples with the three after it, along three axes.
const BAND: usize = 3 * COORDINATES - 1;

/// Of a row of an own coordinate: the diagonal, the band, the border, the right side.
const ROW: usize = 1 + BAND + BORDER + 1;

/// Where a coordinate of a cable stands in its equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Slot {
    /// Among its own.
    Own(usize),
    /// At one of its ends.
    End(usize),
}

/// The slots of a cable's coordinates, place by place.
pub(super) fn slots(layout: NodeList) -> Vec<Slot> {
    let mut own = 0..;
    let ends = layout.ends();
    let slot = |place| match ends.iter().position(|&end| end == place) {
        Some(end) => Slot::End(end),
        None => Slot::Own(own.next().unwrap_or_default()),
    };
    (0..layout.size()).map(slot).collect()
}

/// The equations of a group of cables: a symmetric matrix and a right side.
pub(super) struct CableBlock {
    n_own: usize,
    /// Of each own coordinate and axis: its column from the diagonal down, its border, its right side.
    rows: Vec<Lanes>,
    /// Of the ends, row by row: lower half and right side.
    ends: [[Lanes; BORDER + 1]; BORDER],
}

impl CableBlock {
    /// All zero.
    pub(super) fn new(layout: NodeList) -> CableBlock {
        let n_own = 3 * layout.n_inner();
        CableBlock {
            n_own,
            rows: vec![[0.0; LANES]; n_own * ROW],
            ends: [[[0.0; LANES]; BORDER + 1]; BORDER],
        }
    }

    /// Sets all to zero.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.rows.fill([0.0; LANES]);
        self.ends = [[[0.0; LANES]; BORDER + 1]; BORDER];
    }

    /// Adds `factor` times a value to the entry of a coordinate along an axis and another, each pair to be named once; without
    /// another, to the right side.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        (one, axis): (Slot, usize),
        other: Option<(Slot, usize)>,
        factor: f64,
        value: &Lanes,
    ) {
        let border = |end: usize, axis: usize| 1 + BAND + 3 * end + axis;
        let entry = match (one, other) {
            (Slot::Own(i), None) => &mut self.rows[(3 * i + axis + 1) * ROW - 1],
            (Slot::End(e), None) => &mut self.ends[3 * e + axis][BORDER],
            (Slot::Own(i), Some((Slot::Own(j), across))) => {
                let (i, j) = (3 * i + axis, 3 * j + across);
                &mut self.rows[i.min(j) * ROW + i.abs_diff(j)]
            }
            (Slot::Own(i), Some((Slot::End(e), across))) => {
                &mut self.rows[(3 * i + axis) * ROW + border(e, across)]
            }
            (Slot::End(e), Some((Slot::Own(j), across))) => {
                &mut self.rows[(3 * j + across) * ROW + border(e, axis)]
            }
            (Slot::End(d), Some((Slot::End(e), across))) => {
                let (i, j) = (3 * d + axis, 3 * e + across);
                &mut self.ends[i.max(j)][i.min(j)]
            }
        };
        for i in 0..LANES {
            entry[i] += factor * value[i];
        }
    }

    /// Eliminates the own coordinates.
    #[inline(always)]
    pub(super) fn eliminate(&mut self) {
        for k in 0..self.n_own {
            let (before, after) = self.rows.split_at_mut((k + 1) * ROW);
            let pivot = &mut before[k * ROW..];
            for diagonal in &mut pivot[0] {
                *diagonal = 1.0 / *diagonal;
            }
            let n_below = BAND.min(self.n_own - 1 - k);
            for i in 1..=n_below {
                let factor = times(&pivot[i], &pivot[0]);
                let row = &mut after[(i - 1) * ROW..i * ROW];
                take(&mut row[..=n_below - i], &factor, &pivot[i..=n_below]);
                take(&mut row[1 + BAND..], &factor, &pivot[1 + BAND..]);
            }
            let border = &pivot[1 + BAND..];
            for (i, row) in self.ends.iter_mut().enumerate() {
                let factor = times(&border[i], &pivot[0]);
                take(&mut row[..=i], &factor, &border[..=i]);
                take(&mut row[BORDER..], &factor, &border[BORDER..]);
            }
        }
    }

    /// What is left of the matrix and of the right side for cable `lane`: rows of the lower half, and the right side last.
    pub(super) fn left(&self, lane: usize) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let rows = self.ends.iter().enumerate();
        rows.flat_map(move |(i, row)| (0..=i).chain([BORDER]).map(move |j| (i, j, row[j][lane])))
    }

    /// The own coordinates where the ends have `ends`, after elimination: in place of the right side.
    #[inline(always)]
    pub(super) fn substitute(&mut self, ends: &[Lanes; BORDER]) {
        for k in (0..self.n_own).rev() {
            let (before, after) = self.rows.split_at_mut((k + 1) * ROW);
            let pivot = &mut before[k * ROW..];
            let mut value = pivot[ROW - 1];
            let n_below = BAND.min(self.n_own - 1 - k);
            for i in 1..=n_below {
                less(&mut value, &pivot[i], &after[i * ROW - 1]);
            }
            for (end, factor) in ends.iter().zip(&pivot[1 + BAND..]) {
                less(&mut value, factor, end);
            }
            pivot[ROW - 1] = times(&value, &pivot[0]);
        }
    }

    /// The solution along `axis` of own coordinate `own`.
    #[inline(always)]
    pub(super) fn solution(&self, own: usize, axis: usize) -> &Lanes {
        &self.rows[(3 * own + axis + 1) * ROW - 1]
    }
}

#[inline(always)]
fn times(one: &Lanes, other: &Lanes) -> Lanes {
    let mut product = [0.0; LANES];
    for i in 0..LANES {
        product[i] = one[i] * other[i];
    }
    product
}

/// value −= factor * of.
#[inline(always)]
fn less(value: &mut Lanes, factor: &Lanes, of: &Lanes) {
    for i in 0..LANES {
        value[i] -= factor[i] * of[i];
    }
}

/// The same of many.
#[inline(always)]
fn take(from: &mut [Lanes], factor: &Lanes, of: &[Lanes]) {
    for (value, of) in from.iter_mut().zip(of) {
        less(value, factor, of);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// Own coordinates eliminated, ends solved, own coordinates found again: the solution of the whole.
    #[test]
    fn elimination_solves_the_whole() {
        for elements in [1, 2, 3, 5] {
            let layout = NodeList { elements };
            let slots = slots(layout);
            let n = 3 * layout.size();
            let (mut block, mut whole) = (CableBlock::new(layout), DMatrix::zeros(n, n));
            let right = DVector::from_fn(n, |i, _| (1.7 * i as f64).sin());
            for element in 0..elements {
                // A positive definite matrix of an element, of all its coordinates along all axes.
                let size = 3 * COORDINATES;
                let root = DMatrix::from_fn(size, size, |i, j| ((i * 7 + j * 3 + element) as f64).sin());
                let matrix = &root * root.transpose() + DMatrix::identity(size, size);
                for i in 0..size {
                    for j in 0..=i {
                        let [at, to] = [i, j].map(|k| (2 * element + k / 3, k % 3));
                        let value = matrix[(i, j)];
                        block.add((slots[at.0], at.1), Some((slots[to.0], to.1)), 1.0, &[value; LANES]);
                        whole[(3 * at.0 + at.1, 3 * to.0 + to.1)] += value;
                        if i != j {
                            whole[(3 * to.0 + to.1, 3 * at.0 + at.1)] += value;
                        }
                    }
                }
            }
            for i in 0..n {
                block.add((slots[i / 3], i % 3), None, right[i], &[1.0; LANES]);
            }
            let wanted = whole.lu().solve(&right).unwrap();
            block.eliminate();
            let (mut left, mut right) = (DMatrix::zeros(BORDER, BORDER), DVector::zeros(BORDER));
            for (i, j, value) in block.left(LANES - 1) {
                if j == BORDER {
                    right[i] = value;
                } else {
                    (left[(i, j)], left[(j, i)]) = (value, value);
                }
            }
            let ends = left.lu().solve(&right).unwrap();
            block.substitute(&std::array::from_fn(|i| [ends[i]; LANES]));
            for (place, slot) in slots.iter().enumerate() {
                for axis in 0..3 {
                    let found = match *slot {
                        Slot::Own(own) => block.solution(own, axis)[0],
                        Slot::End(end) => ends[3 * end + axis],
                    };
                    assert!((found - wanted[3 * place + axis]).abs() < 1e-9, "{elements} {place} {axis}");
                }
            }
        }
    }
}
