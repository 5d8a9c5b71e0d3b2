//! Simultaneous contacts answered by impulses (Section 4.3).
//!
//! For k knots that touch the target at once, Eq. 4.25 asks for impulses j with
//!
//! M j = v,  M = D + G W Gᵀ  (Eq. 4.28, 4.29)
//!
//! | symbol | meaning |
//! |---|---|
//! | D | diagonal of 1 / mᵢ, one over the masses of the knots |
//! | G | k × 6: rows (nᵢ, rᵢ × nᵢ), the normals and their moments about the target's centre of mass |
//! | W | 6 × 6: 1/m_O and I_O⁻¹, the inverse spatial inertia of the target |
//! | v | wanted changes of the normal relative speeds |
//!
//! G W Gᵀ has rank six whatever k is, so j = M⁻¹ v (Eq. 4.30) costs O(k) by the Woodbury identity
//! with one 6 × 6 solve: j = D⁻¹ v − D⁻¹ G (W⁻¹ + Gᵀ D⁻¹ G)⁻¹ Gᵀ D⁻¹ v. For one contact this is
//! Eq. 4.17.
//!
//! Wanted changes: −(1 + e) vᵣ⁻ with restitution (Eq. 4.26). Without (e = 0) a knot is stopped where
//! it meets the surface, −vᵣ⁻ − gap / h: it touches at the end of the step and not before.
//!
//! A knot that overlaps at the start of the step (the plane of another part came first, or a corner of
//! the target turned onto it) is moved out at [`PUSH_OUT`] at most: at overlap / h a light knot would
//! leave with a hundred times the speed of the shot.
//!
//! Departures from the source: Eq. 4.30 does not forbid an impulse that pulls; contacts that would
//! pull are released and the rest is solved again, until none pulls. A knot in a corner between two parts has two
//! contacts, with n₁ · n₂ = c, and D a block (1, c; c, 1) / m there. With the second row less c times the first,
//! over √(1 − c²), D is diagonal again: that is the block's Cholesky factor. Coulomb friction is our extension,
//! applied after the normal impulses.

use nalgebra::{Matrix6, Vector6};

use super::InverseInertia;
use super::row::ContactRow;

/// Speed at which an overlap at the start of a step is made up for, at most [m/s]. With no bound, knots
/// of 2.5 g that a closing thread pulled into the corners of Envisat left at 100 m/s and pulled others in.
pub const PUSH_OUT: f64 = 1.0;

/// Solves for the impulses of many contacts at once; keeps its memory from call to call.
#[derive(Clone, Debug, Default)]
pub struct Woodbury {
    acting: Vec<Acting>,
}

/// A contact that pushes.
#[derive(Clone, Copy, Debug)]
struct Acting {
    index: usize,
    knot: usize,
    /// Row of G.
    moments: Vector6<f64>,
    /// mᵢ, the entry of D⁻¹ [kg].
    mass: f64,
    /// Impulse that would do if it were the only one and the target were held [N s].
    alone: f64,
    /// jᵢ as last solved [N s].
    impulse: f64,
}

/// A row made independent of the one before it, which may be of the same knot.
#[derive(Clone, Copy, Debug)]
struct Independent {
    moments: Vector6<f64>,
    alone: f64,
    /// n₁ · n₂ and 1 / √(1 − c²) of a second row of a knot.
    second: Option<[f64; 2]>,
}

impl Woodbury {
    /// Writes to `rows`, each of another knot or one of two that follow each other, the impulses that change their speeds
    /// by what is `wanted` [m/s], where that is more than nothing, and that pull nowhere: what would is released, and the
    /// rest solved again.
    pub fn solve(
        &mut self,
        rows: &mut [ContactRow],
        target: &InverseInertia,
        wanted: impl Fn(&ContactRow) -> f64,
    ) {
        self.acting.clear();
        for (index, row) in rows.iter_mut().enumerate() {
            row.impulse = 0.0;
            let wanted = wanted(row);
            if wanted > 0.0 {
                self.acting.push(Acting::of(index, row, wanted));
            }
        }
        while !self.acting.is_empty() {
            self.solve_acting(target);
            if self.acting.iter().all(|contact| contact.impulse >= 0.0) {
                break;
            }
            self.acting.retain(|contact| contact.impulse >= 0.0);
        }
        for contact in &self.acting {
            rows[contact.index].impulse = contact.impulse;
        }
    }

    /// j = M⁻¹ v by the Woodbury identity, O(k).
    fn solve_acting(&mut self, target: &InverseInertia) {
        let shared = if target.inverse_mass == 0.0 { Vector6::zeros() } else { self.shared(target) };
        for i in 0..self.acting.len() {
            let row = self.independent(i);
            let mut impulse = row.alone - self.acting[i].mass * row.moments.dot(&shared);
            if let Some([cosine, scale]) = row.second {
                impulse *= scale;
                self.acting[i - 1].impulse -= cosine * impulse;
            }
            self.acting[i].impulse = impulse;
        }
    }

    /// (W⁻¹ + Gᵀ D⁻¹ G)⁻¹ Gᵀ D⁻¹ v.
    fn shared(&self, target: &InverseInertia) -> Vector6<f64> {
        let mut core = Matrix6::zeros();
        let inertia = target.inverse_inertia.try_inverse().unwrap_or_default();
        core.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        for axis in 0..3 {
            core[(axis, axis)] = 1.0 / target.inverse_mass;
        }
        let mut pull = Vector6::zeros();
        for (i, &Acting { mass, .. }) in self.acting.iter().enumerate() {
            let Independent { moments, alone, .. } = self.independent(i);
            // The lower half, which is all that is read.
            for column in 0..6 {
                let weighed = mass * moments[column];
                for row in column..6 {
                    core[(row, column)] += weighed * moments[row];
                }
            }
            pull += moments * alone;
        }
        // Symmetric and positive definite: mass and inertia are, and the rest is a sum of squares.
        core.cholesky().map_or_else(Vector6::zeros, |factor| factor.solve(&pull))
    }

    /// The contact at `index`, made independent of the one before it.
    #[inline]
    fn independent(&self, index: usize) -> Independent {
        let contact = &self.acting[index];
        let before = index.checked_sub(1).map(|before| &self.acting[before]);
        let Some(first) = before.filter(|before| before.knot == contact.knot) else {
            return Independent { moments: contact.moments, alone: contact.alone, second: None };
        };
        let normal = |of: &Acting| of.moments.fixed_rows::<3>(0).into_owned();
        let cosine = normal(first).dot(&normal(contact));
        let scale = 1.0 / (1.0 - cosine * cosine).sqrt();
        Independent {
            moments: scale * (contact.moments - cosine * first.moments),
            alone: scale * (contact.alone - cosine * first.alone),
            second: Some([cosine, scale]),
        }
    }
}

impl Acting {
    fn of(index: usize, row: &ContactRow, wanted: f64) -> Acting {
        let (n, turn) = (row.normal, row.arm.unwrap_or_default().cross(&row.normal));
        let moments = Vector6::new(n.x, n.y, n.z, turn.x, turn.y, turn.z);
        let mass = 1.0 / row.inverse_mass;
        Acting { index, knot: row.weights.first(), moments, mass, alone: mass * wanted, impulse: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::row::JacobianWeights;
    use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn target() -> InverseInertia {
        let inertia = Matrix3::new(3.0, 0.1, 0.2, 0.1, 2.0, 0.05, 0.2, 0.05, 1.5);
        InverseInertia { inverse_mass: 1.0 / 3.5, inverse_inertia: inertia.try_inverse().unwrap() }
    }

    /// Touching knots, and the changes of their speeds that are wanted.
    fn random_rows(n: usize, random: &mut ChaCha8Rng) -> Vec<ContactRow> {
        let mut number = |low: f64, high: f64| random.random_range(low..high);
        let mut vector = |size: f64| Vector3::from_fn(|_, _| number(-size, size)) as Vector3<f64>;
        (0..n)
            .map(|knot| {
                let (normal, velocity) = (vector(1.0).normalize(), vector(2.0));
                let speed = normal.dot(&velocity);
                ContactRow {
                    weights: JacobianWeights::of_knot(knot),
                    inverse_mass: 100.0 + 50.0 * vector(1.0).x,
                    radius: 5e-4,
                    normal,
                    arm: Some(vector(0.2)),
                    gap: 0.0,
                    velocity,
                    speed,
                    wanted_speed: speed + 1.0 + vector(1.0).x,
                    bounces: false,
                    softness: 0.0,
                    impulse: 0.0,
                    friction: Vector3::zeros(),
                }
            })
            .collect()
    }

    fn wanted(row: &ContactRow) -> f64 {
        row.wanted_speed - row.speed
    }

    /// Every third row is in a corner with the one before it.
    fn with_corners(rows: &mut [ContactRow]) {
        for second in (1..rows.len()).step_by(3) {
            let ContactRow { weights, inverse_mass, arm, velocity, .. } = rows[second - 1];
            let row = &mut rows[second];
            row.speed = row.normal.dot(&velocity);
            row.wanted_speed = row.speed + 1.0;
            (row.weights, row.inverse_mass, row.arm, row.velocity) = (weights, inverse_mass, arm, velocity);
        }
    }

    /// Eq. 4.28 entry by entry, solved densely.
    fn dense(rows: &[ContactRow], target: &InverseInertia) -> Vec<f64> {
        let k = rows.len();
        let m = DMatrix::from_fn(k, k, |i, j| {
            let (a, b) = (&rows[i], &rows[j]);
            let turned = (target.inverse_inertia * b.arm.unwrap().cross(&b.normal)).cross(&a.arm.unwrap());
            let own = if a.is_of_the_knot_of(b) { a.inverse_mass * a.normal.dot(&b.normal) } else { 0.0 };
            own + target.inverse_mass * a.normal.dot(&b.normal) + a.normal.dot(&turned)
        });
        let wanted = DVector::from_iterator(k, rows.iter().map(wanted));
        m.lu().solve(&wanted).unwrap().iter().copied().collect()
    }

    #[test]
    fn woodbury_agrees_with_the_dense_matrix_of_eq_4_28() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for n in 1..=60 {
            let mut rows = random_rows(n, &mut random);
            with_corners(&mut rows);
            let mut solver = Woodbury::default();
            solver.acting.extend(rows.iter().enumerate().map(|(i, row)| Acting::of(i, row, wanted(row))));
            solver.solve_acting(&target());
            let slow = dense(&rows, &target());
            let scale = slow.iter().map(|j| j.abs()).fold(0.0, f64::max);
            for (contact, slow) in solver.acting.iter().zip(&slow) {
                let fast = contact.impulse;
                assert!((fast - slow).abs() < 6e-12 * scale, "{n}: {fast} and {slow}"); // measured 7e-13
            }
        }
    }

    #[test]
    fn one_contact_is_eq_4_17() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        for restitution in [0.0, 0.5, 1.0] {
            let mut rows = random_rows(1, &mut random);
            (rows[0].speed, rows[0].wanted_speed) = (-1.0, restitution); // approaching at 1 m/s, touching
            Woodbury::default().solve(&mut rows, &target(), wanted);
            let effective = rows[0].inverse_mass_along(&rows[0].normal, &target());
            assert!((rows[0].impulse * effective - (1.0 + restitution)).abs() < 1e-14);
        }
    }

    #[test]
    fn no_contact_pulls_and_what_wants_nothing_gets_nothing() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut released = 0;
        for _ in 0..200 {
            let mut rows = random_rows(20, &mut random);
            rows[7].wanted_speed = rows[7].speed;
            Woodbury::default().solve(&mut rows, &target(), wanted);
            assert!(rows.iter().all(|row| row.impulse >= 0.0));
            assert_eq!(rows[7].impulse, 0.0);
            released += rows.iter().filter(|row| row.impulse == 0.0).count() - 1;
        }
        assert!(released > 0, "no contact would have pulled, so none was kept from it"); // measured 6
    }
}
