//! Coordinates of many cables or knots as structure of arrays, and the plain loops over them.

use nalgebra::Vector3;

/// Three components, an array each.
pub(super) type Axes = [Vec<f64>; 3];

/// Positions (or slopes) and their rates at one place of every cable, or of all knots.
#[derive(Clone)]
pub(super) struct Coordinates {
    pub(super) position: Axes,
    pub(super) velocity: Axes,
    /// Force, then acceleration.
    pub(super) force: Axes,
    pub(super) acceleration: Axes,
}

impl Coordinates {
    pub(super) fn of(n: usize) -> Coordinates {
        let zeros = || [(); 3].map(|()| vec![0.0; n]);
        Coordinates { position: zeros(), velocity: zeros(), force: zeros(), acceleration: zeros() }
    }

    pub(super) fn set(&mut self, at: usize, position: &Vector3<f64>, velocity: &Vector3<f64>) {
        for axis in 0..3 {
            self.position[axis][at] = position[axis];
            self.velocity[axis][at] = velocity[axis];
        }
    }

    pub(super) fn get(&self, at: usize) -> [Vector3<f64>; 2] {
        [&self.position, &self.velocity].map(|axes| Vector3::new(axes[0][at], axes[1][at], axes[2][at]))
    }
}

/// Places `a` and `b` of a list, which are different.
#[inline(always)]
pub(super) fn two(places: &mut [Coordinates], a: usize, b: usize) -> [&mut Coordinates; 2] {
    let (low, high) = places.split_at_mut(a.max(b));
    let [low, high] = [&mut low[a.min(b)], &mut high[0]];
    if a < b { [low, high] } else { [high, low] }
}

/// sum += factor * term.
#[inline(always)]
pub(super) fn add(sum: &mut [f64], factor: f64, term: &[f64]) {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum += factor * term;
    }
}

/// Cables that a loop over an element's law takes at once. It copies them to arrays of its own, of which the compiler
/// knows that none overlaps another: only then does a loop with so many of them become one of wide vectors.
pub(super) const LANES: usize = 8;

/// A number for each of them.
pub(super) type Lanes = [f64; LANES];

/// Length of the arrays of `n` cables: whole groups, the last filled with cables that nothing moves.
pub(super) fn padded(n: usize) -> usize {
    n.next_multiple_of(LANES)
}

/// Those from place `at` on.
#[inline(always)]
pub(super) fn lanes(values: &[f64], at: usize) -> Lanes {
    let mut lanes = [0.0; LANES];
    lanes.copy_from_slice(&values[at..at + LANES]);
    lanes
}

/// The same of three components.
#[inline(always)]
pub(super) fn lanes_of(axes: &Axes, at: usize) -> [Lanes; 3] {
    [lanes(&axes[0], at), lanes(&axes[1], at), lanes(&axes[2], at)]
}

/// sum += factor * term from place `at` on.
#[inline(always)]
pub(super) fn add_lanes(sum: &mut Axes, at: usize, factor: &Lanes, term: &[Lanes; 3]) {
    for (sum, term) in sum.iter_mut().zip(term) {
        let sum = &mut sum[at..at + LANES];
        for i in 0..LANES {
            sum[i] += factor[i] * term[i];
        }
    }
}

/// One minus the other.
#[inline(always)]
pub(super) fn apart(to: &[Lanes; 3], from: &[Lanes; 3]) -> [Lanes; 3] {
    let mut apart = *to;
    for axis in 0..3 {
        for i in 0..LANES {
            apart[axis][i] -= from[axis][i];
        }
    }
    apart
}
