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

use nalgebra::{Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};

use super::InverseInertia;
use super::row::ContactRow;

/// Speed at which an overlap at the start of a step is made up for, at most [m/s]. With no bound, knots
/// of 2.5 g that a closing thread pulled into the corners of Envisat left at 100 m/s and pulled others in.
pub const PUSH_OUT: f64 = 1.0;

/// Solves for the impulses of many contacts at once; keeps its memory from call to call.
#[derive(Clone, Debug, Default)]
pub struct Woodbury {
    arch: Arch,
    acting: Vec<Acting>,
    independent: Vec<Independent>,
}

/// A contact that pushes.
#[derive(Clone, Copy, Debug)]
struct Acting {
    index: usize,
    knot: usize,
    /// Row of (G | v | 0).
    row: [f64; 8],
    /// mᵢ, the entry of D⁻¹ [kg].
    mass: f64,
    /// jᵢ as last solved [N s].
    impulse: f64,
}

/// A row made independent of the one before it, which may be of the same knot.
#[derive(Clone, Copy, Debug)]
struct Independent {
    /// Row of (G | v | 0).
    row: [f64; 8],
    /// Entry of D⁻¹ [kg].
    mass: f64,
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
        let Woodbury { arch, acting, independent } = self;
        independent.clear();
        let mut before = None;
        for contact in acting.iter() {
            let first = before.replace(contact).filter(|before: &&Acting| before.knot == contact.knot);
            independent.push(first.map_or_else(|| contact.alone(), |first| contact.beside(first)));
        }
        let shared = if target.inverse_mass == 0.0 { [0.0; 6] } else { shared(*arch, independent, target) };
        for i in 0..acting.len() {
            let Independent { row, mass, second } = &independent[i];
            let turned: f64 = row.iter().zip(&shared).map(|(own, shared)| own * shared).sum();
            let mut impulse = mass * (row[6] - turned);
            if let Some([cosine, scale]) = second {
                impulse *= scale;
                acting[i - 1].impulse -= cosine * impulse;
            }
            acting[i].impulse = impulse;
        }
    }
}

/// (W⁻¹ + Gᵀ D⁻¹ G)⁻¹ Gᵀ D⁻¹ v, by blocks of what moves and what turns: each is symmetric and positive definite, for mass and
/// inertia are, and the rest is a sum of squares.
fn shared(arch: Arch, rows: &[Independent], target: &InverseInertia) -> [f64; 6] {
    let sums = arch.dispatch(WeighedProducts { rows });
    let block = |from: usize, to: usize| Matrix3::from_fn(|i, j| sums[from + i][to + j]);
    let pull = |from: usize| Vector3::from_fn(|i, _| sums[from + i][6]);
    let inverse = |matrix: Matrix3<f64>| matrix.try_inverse().unwrap_or_default();
    let moving = inverse(block(0, 0) + Matrix3::from_diagonal_element(1.0 / target.inverse_mass));
    let turning = block(3, 3) + inverse(target.inverse_inertia);
    let both = block(0, 3);
    let carried = moving * both;
    let turn = inverse(turning - both.tr_mul(&carried)) * (pull(3) - carried.tr_mul(&pull(0)));
    let motion = moving * pull(0) - carried * turn;
    [motion.x, motion.y, motion.z, turn.x, turn.y, turn.z]
}

/// The columns of Gᵀ D⁻¹ (G | v | 0), for the widest vectors of the processor.
struct WeighedProducts<'a> {
    rows: &'a [Independent],
}

impl WithSimd for WeighedProducts<'_> {
    type Output = [[f64; 8]; 6];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [[f64; 8]; 6] {
        // As many of the eight as there are vectors for eight numbers.
        let mut sums = [[simd.splat_f64s(0.0); 8]; 6];
        for Independent { row, mass, .. } in self.rows {
            let (vectors, _) = S::as_simd_f64s(row);
            for (sums, own) in sums.iter_mut().zip(row) {
                let weighed = simd.splat_f64s(mass * own);
                for (sum, other) in sums.iter_mut().zip(vectors) {
                    *sum = simd.add_f64s(*sum, simd.mul_f64s(weighed, *other));
                }
            }
        }
        let mut found = [[0.0; 8]; 6];
        for (found, sums) in found.iter_mut().zip(&sums) {
            let (vectors, _) = S::as_mut_simd_f64s(found);
            for (vector, sum) in vectors.iter_mut().zip(sums) {
                *vector = *sum;
            }
        }
        found
    }
}

impl Acting {
    fn of(index: usize, row: &ContactRow, wanted: f64) -> Acting {
        let (n, turn) = (row.normal, row.arm.unwrap_or_default().cross(&row.normal));
        Acting {
            index,
            knot: row.weights.first(),
            row: [n.x, n.y, n.z, turn.x, turn.y, turn.z, wanted, 0.0],
            mass: 1.0 / row.inverse_mass,
            impulse: 0.0,
        }
    }

    /// Of a knot with no other.
    fn alone(&self) -> Independent {
        Independent { row: self.row, mass: self.mass, second: None }
    }

    /// Independent of the `first` of its knot.
    fn beside(&self, first: &Acting) -> Independent {
        let cosine: f64 = (0..3).map(|axis| first.row[axis] * self.row[axis]).sum();
        let scale = 1.0 / (1.0 - cosine * cosine).sqrt();
        Independent {
            row: std::array::from_fn(|i| scale * (self.row[i] - cosine * first.row[i])),
            mass: self.mass,
            second: Some([cosine, scale]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::row::JacobianWeights;
    use nalgebra::{DMatrix, DVector};
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
                let (inverse_mass, arm) = (100.0 + 50.0 * vector(1.0).x, vector(0.2));
                ContactRow {
                    velocity,
                    speed,
                    wanted_speed: speed + 1.0 + vector(1.0).x,
                    ..ContactRow::held(JacobianWeights::of_knot(knot), inverse_mass, normal, Some(arm))
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
