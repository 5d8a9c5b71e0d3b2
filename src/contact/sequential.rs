//! Unilateral rows that share knots, solved one after another.
//!
//! A row keeps one place of the net from the target, or two places of the net from each other. A
//! place is a weighted mean of knots, so rows share knots, D of Eq. 4.28 is no longer diagonal and
//! the Woodbury solve of [`super::impulse`] does not apply. The rows ask for impulses λ with
//!
//!   0 ≤ λ  ⟂  w = n · (velocity of the place relative to its other side) − w* + γ λ ≥ 0,
//!
//! a linear complementarity problem with the symmetric matrix G M⁻¹ Gᵀ. Projected Gauss-Seidel
//! passes solve it: each row in turn takes the impulse that brings its own w to zero, and never a
//! negative sum. A row of a cable on the target begins with what it had in the (sub-)step before, so few
//! passes suffice.
//!
//! Each pass lowers the energy Σ m |v − v*|² / 2 that the problem minimises, whatever the order of
//! the rows. From zero, ended early it leaves rows that still approach, and never energy; a first guess
//! that is not taken back in time does leave energy: a wad of 11 x 11 knots exploded that way.

use nalgebra::Vector3;

use super::Mobility;
use crate::state::Body;

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Passes over the rows within a (sub-)step, at most.
    pub passes: usize,
    /// Passes end when none changes the speed of its row by more than this share of the fastest wanted
    /// change.
    pub tolerance: f64,
}

impl Effort {
    /// Until the rows hold. The Cubesat's capture takes 4 passes on average.
    pub const WHOLE: Effort = Effort { passes: 100, tolerance: 1e-6 };

    /// For rows of which the engine solves most again. With 5, 10, 30 and 100 passes the Cubesat's
    /// capture took 2.2, 2.5, 3.0 and 4 times the time without such rows, and cables were pressed in by
    /// at most 1.9, 1.0, 0.9 and 1.5 mm.
    pub const AHEAD: Effort = Effort { passes: 12, tolerance: 1e-3 };
}

/// A row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Knots and their weights: they sum up to 1 on the side that the normal points to, and to −1 on
    /// the other, where that is the net too.
    pub knots: Bearers,
    /// Unit normal, towards the first side.
    pub normal: Vector3<f64>,
    /// Where the target is touched, from its centre of mass [m]; `None`: the net itself is.
    pub arm: Option<Vector3<f64>>,
    /// Least speed of parting at the end, w* [m/s].
    pub least: f64,
    /// γ: by how much the row gives way to its own impulse [1/kg]; 0: not at all.
    pub softness: f64,
    /// Impulse λ, at first that of the step before [N s].
    pub impulse: f64,
}

/// Knots and their weights: two or four.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bearers {
    /// Those of one place on a cable, or of a cable's two ends.
    Two([(usize, f64); 2]),
    /// Those of two places.
    Four([(usize, f64); 4]),
}

impl Bearers {
    /// All of them.
    pub fn all(&self) -> &[(usize, f64)] {
        match self {
            Bearers::Two(knots) => knots,
            Bearers::Four(knots) => knots,
        }
    }
}

impl Row {
    /// One over the mass of both sides along `direction` [1/kg].
    fn inverse_mass(&self, direction: &Vector3<f64>, inverse_mass: &[f64], mobility: &Mobility) -> f64 {
        let net: f64 =
            self.knots.all().iter().map(|&(knot, weight)| weight * weight * inverse_mass[knot]).sum();
        net + self.arm.map_or(0.0, |arm| mobility.along(direction, &arm))
    }

    /// The weighted sum of the knots' velocities [m/s].
    pub fn velocity_of_knots(&self, velocity: &[Vector3<f64>]) -> Vector3<f64> {
        self.knots.all().iter().map(|&(knot, weight)| weight * velocity[knot]).sum()
    }

    /// Velocity of the first side relative to the other [m/s].
    pub fn velocity(&self, velocity: &[Vector3<f64>], body: &Body) -> Vector3<f64> {
        self.velocity_of_knots(velocity)
            - self.arm.map_or_else(Vector3::zeros, |arm| body.velocity + body.rate.cross(&arm))
    }

    /// Gives `impulse` to the first side, and takes it from the other.
    pub fn apply(
        &self,
        impulse: &Vector3<f64>,
        velocity: &mut [Vector3<f64>],
        inverse_mass: &[f64],
        body: &mut Body,
        mobility: &Mobility,
    ) {
        for &(knot, weight) in self.knots.all() {
            velocity[knot] += impulse * (weight * inverse_mass[knot]);
        }
        if let Some(arm) = self.arm {
            body.velocity -= mobility.inverse_mass * impulse;
            body.rate -= mobility.inverse_inertia * arm.cross(impulse);
        }
    }
}

/// Solves for the impulses of `rows`, and applies them; returns the number of passes.
pub fn settle(
    rows: &mut [Row],
    velocity: &mut [Vector3<f64>],
    inverse_mass: &[f64],
    body: &mut Body,
    mobility: &Mobility,
    effort: Effort,
) -> usize {
    let mut wanted = 0.0_f64;
    for row in rows.iter_mut() {
        wanted = wanted.max(row.least - row.normal.dot(&row.velocity(velocity, body)));
    }
    for row in rows.iter_mut() {
        row.apply(&(row.impulse * row.normal), velocity, inverse_mass, body, mobility);
    }
    let weights: Vec<f64> =
        rows.iter().map(|row| row.softness + row.inverse_mass(&row.normal, inverse_mass, mobility)).collect();
    for pass in 1..=effort.passes {
        let mut largest = 0.0_f64;
        for (row, weight) in rows.iter_mut().zip(&weights) {
            let speed = row.normal.dot(&row.velocity(velocity, body));
            let short = row.least - speed - row.softness * row.impulse;
            let impulse = (row.impulse + short / weight).max(0.0);
            let change = impulse - row.impulse;
            if change != 0.0 {
                row.impulse = impulse;
                row.apply(&(change * row.normal), velocity, inverse_mass, body, mobility);
                largest = largest.max(change.abs() * weight);
            }
        }
        if largest <= effort.tolerance * wanted {
            return pass;
        }
    }
    effort.passes
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const KNOTS: usize = 6;

    /// Rows that share few knots, against the target and against each other.
    fn random_rows(n: usize, random: &mut ChaCha8Rng) -> Vec<Row> {
        let mut number = |low: f64, high: f64| random.random_range(low..high);
        (0..n)
            .map(|i| {
                let mut vector = || Vector3::new(number(-1.0, 1.0), number(-1.0, 1.0), number(-1.0, 1.0));
                let (normal, arm) = (vector().normalize(), 0.2 * vector());
                let (s, t) = (number(0.1, 0.9), number(0.1, 0.9));
                let knot = |shift: usize| (i + shift) % KNOTS;
                let with_target = i % 2 == 0;
                Row {
                    knots: if with_target {
                        Bearers::Two([(knot(0), 1.0 - s), (knot(1), s)])
                    } else {
                        Bearers::Four([(knot(0), 1.0 - s), (knot(1), s), (knot(3), t - 1.0), (knot(4), -t)])
                    },
                    normal,
                    arm: with_target.then_some(arm),
                    least: number(-0.5, 0.5),
                    softness: if i % 3 == 0 { number(0.0, 50.0) } else { 0.0 },
                    impulse: 0.0,
                }
            })
            .collect()
    }

    /// The complementarity problem by trying every set of acting rows: the velocities of the solution.
    fn dense(
        rows: &[Row],
        velocity: &[Vector3<f64>],
        inverse_mass: &[f64],
        body: &Body,
        mobility: &Mobility,
    ) -> Vec<f64> {
        let n = rows.len();
        // Column j: change of every row's speed by a unit impulse of row j.
        let mut matrix = DMatrix::zeros(n, n);
        for j in 0..n {
            let (mut moved, mut target) = (velocity.to_vec(), *body);
            rows[j].apply(&rows[j].normal, &mut moved, inverse_mass, &mut target, mobility);
            for (i, row) in rows.iter().enumerate() {
                let change = row.velocity(&moved, &target) - row.velocity(velocity, body);
                matrix[(i, j)] = row.normal.dot(&change);
            }
            matrix[(j, j)] += rows[j].softness;
        }
        let short: Vec<f64> =
            rows.iter().map(|row| row.least - row.normal.dot(&row.velocity(velocity, body))).collect();
        for set in 0..1u32 << n {
            let acting: Vec<usize> = (0..n).filter(|i| set >> i & 1 == 1).collect();
            let part = DMatrix::from_fn(acting.len(), acting.len(), |i, j| matrix[(acting[i], acting[j])]);
            let wanted = DVector::from_fn(acting.len(), |i, _| short[acting[i]]);
            // No row acts: nothing to solve.
            let solved = if acting.is_empty() { Some(wanted) } else { part.lu().solve(&wanted) };
            let Some(solved) = solved else { continue };
            let mut impulses = DVector::zeros(n);
            for (&i, j) in acting.iter().zip(solved.iter()) {
                impulses[i] = *j;
            }
            let left = &matrix * &impulses - DVector::from_row_slice(&short);
            if impulses.iter().all(|j| *j >= -1e-9) && left.iter().all(|w| *w >= -1e-9) {
                return impulses.iter().copied().collect();
            }
        }
        panic!("a positive matrix has a solution");
    }

    #[test]
    fn passes_agree_with_every_set_of_rows_tried_in_turn() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let inertia = Matrix3::new(3.0, 0.1, 0.2, 0.1, 2.0, 0.05, 0.2, 0.05, 1.5);
        let mobility = Mobility { inverse_mass: 1.0 / 3.5, inverse_inertia: inertia.try_inverse().unwrap() };
        for n in 1..=6 {
            for _ in 0..20 {
                let mut rows = random_rows(n, &mut random);
                let mut number = |low: f64, high: f64| random.random_range(low..high);
                let inverse_mass: Vec<f64> = (0..KNOTS).map(|_| number(50.0, 150.0)).collect();
                let mut velocity: Vec<Vector3<f64>> =
                    (0..KNOTS).map(|_| Vector3::new(number(-1.0, 1.0), number(-1.0, 1.0), 0.3)).collect();
                let mut body = Body {
                    position: Vector3::zeros(),
                    attitude: UnitQuaternion::identity(),
                    velocity: Vector3::new(0.1, 0.0, 0.2),
                    rate: Vector3::new(0.5, -0.3, 0.1),
                };
                let expected = dense(&rows, &velocity, &inverse_mass, &body, &mobility);
                let effort = Effort { passes: 100_000, tolerance: 1e-13 };
                settle(&mut rows, &mut velocity, &inverse_mass, &mut body, &mobility, effort);
                let scale = expected.iter().fold(1e-3, |most: f64, j| most.max(*j));
                for (row, expected) in rows.iter().zip(&expected) {
                    assert!((row.impulse - expected).abs() < 1e-6 * scale, "{} {expected}", row.impulse);
                }
            }
        }
    }
}
