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

#[inline(always)]
pub(super) fn cut(axes: &Axes, n: usize) -> [&[f64]; 3] {
    [&axes[0][..n], &axes[1][..n], &axes[2][..n]]
}

#[inline(always)]
pub(super) fn cut_mut(axes: &mut Axes, n: usize) -> [&mut [f64]; 3] {
    let [x, y, z] = axes;
    [&mut x[..n], &mut y[..n], &mut z[..n]]
}
