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
//! | W | 6 × 6: 1/m_O and I_O⁻¹, the mobility of the target |
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
//! pull are released and the rest is solved again, until none pulls. A knot has one contact at a
//! time, the one it is deepest in: D is then diagonal. Coulomb friction is our extension, applied
//! after the normal impulses.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::friction::slowing_impulse;
use super::{Mobility, Row};
use crate::friction::Law;

/// Speed at which an overlap at the start of a step is made up for, at most [m/s]. With no bound, knots
/// of 2.5 g that a closing thread pulled into the corners of Envisat left at 100 m/s and pulled others in.
pub const PUSH_OUT: f64 = 1.0;

/// The impulse response.
#[derive(Clone, Debug, Default)]
pub struct Impulse {
    /// Coefficient of restitution e (Eq. 4.11) [-].
    pub restitution: f64,
    /// Friction, where an effect asks for it.
    pub friction: Option<Law>,
    wanted: Vec<f64>,
    solver: Simultaneous,
}

impl Impulse {
    /// The response with coefficient of restitution `restitution` [-], and `friction` if any.
    pub fn new(restitution: f64, friction: Option<Law>) -> Impulse {
        Impulse { restitution, friction, ..Impulse::default() }
    }

    /// Impulse on the knot of each row within a step of `step` seconds: along the normal and across
    /// it [N s]. Rows must be of different knots.
    pub fn respond(
        &mut self,
        rows: &[Row],
        mobility: &Mobility,
        step: f64,
        impulses: &mut Vec<(f64, Vector3<f64>)>,
    ) {
        let mut wanted = std::mem::take(&mut self.wanted);
        wanted.clear();
        wanted.extend(rows.iter().map(|row| self.wanted_change(row, step)));
        impulses.clear();
        impulses.extend(self.solver.push(rows, mobility, &wanted).iter().map(|&j| (j, Vector3::zeros())));
        self.wanted = wanted;
        if let Some(law) = &self.friction {
            for (row, impulse) in rows.iter().zip(impulses) {
                impulse.1 = slowing_impulse(law, row, mobility, impulse.0);
            }
        }
    }

    fn wanted_change(&self, row: &Row, step: f64) -> f64 {
        let speed = row.speed();
        let overlap = -(row.gap + speed * step); // at the end of the step, if nothing is done
        if overlap <= 0.0 {
            0.0
        } else if self.restitution > 0.0 && speed < 0.0 {
            -(1.0 + self.restitution) * speed
        } else {
            // −speed − gap / h, the second part bounded where the knot is inside already.
            -speed + (-row.gap / step).min(PUSH_OUT)
        }
    }
}

/// Solves for impulses of many contacts at once; keeps its memory from call to call.
#[derive(Clone, Debug, Default)]
pub struct Simultaneous {
    acting: Vec<Acting>,
    impulses: Vec<f64>,
}

/// A contact that pushes.
#[derive(Clone, Copy, Debug)]
struct Acting {
    index: usize,
    /// Row of G.
    moments: Vector6<f64>,
    /// mᵢ, the entry of D⁻¹ [kg].
    mass: f64,
    /// Impulse that would do if the target were held [N s].
    alone: f64,
    /// jᵢ as last solved [N s].
    impulse: f64,
}

impl Simultaneous {
    /// Impulses that change the normal relative speeds of `rows` by what is `wanted`, where that is more
    /// than nothing, and pull nowhere: what would is released, and the rest solved again.
    pub fn push(&mut self, rows: &[Row], mobility: &Mobility, wanted: &[f64]) -> &[f64] {
        self.impulses.clear();
        self.impulses.resize(rows.len(), 0.0);
        self.acting.clear();
        let pressed = rows.iter().zip(wanted).enumerate().filter(|(_, (_, wanted))| **wanted > 0.0);
        self.acting.extend(pressed.map(|(index, (row, wanted))| Acting::of(index, row, *wanted)));
        while !self.acting.is_empty() {
            self.solve(mobility);
            if self.acting.iter().all(|contact| contact.impulse >= 0.0) {
                break;
            }
            self.acting.retain(|contact| contact.impulse >= 0.0);
        }
        for contact in &self.acting {
            self.impulses[contact.index] = contact.impulse;
        }
        &self.impulses
    }

    /// j = M⁻¹ v by the Woodbury identity, O(k).
    fn solve(&mut self, mobility: &Mobility) {
        if mobility.inverse_mass == 0.0 {
            for contact in &mut self.acting {
                contact.impulse = contact.alone;
            }
            return;
        }
        let mut core = Matrix6::zeros();
        let inertia = mobility.inverse_inertia.try_inverse().unwrap_or_default();
        core.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        for axis in 0..3 {
            core[(axis, axis)] = 1.0 / mobility.inverse_mass;
        }
        let mut pull = Vector6::zeros();
        for Acting { moments, mass, alone, .. } in &self.acting {
            core.syger(*mass, moments, moments, 1.0); // the lower half, which is all that is read
            pull += moments * *alone;
        }
        // Symmetric and positive definite: mass and inertia are, and the rest is a sum of squares.
        let shared = core.cholesky().map_or_else(Vector6::zeros, |factor| factor.solve(&pull));
        for contact in &mut self.acting {
            contact.impulse = contact.alone - contact.mass * contact.moments.dot(&shared);
        }
    }
}

impl Acting {
    fn of(index: usize, row: &Row, wanted: f64) -> Acting {
        let turn = row.arm.cross(&row.normal);
        let moments = Vector6::new(row.normal.x, row.normal.y, row.normal.z, turn.x, turn.y, turn.z);
        let mass = 1.0 / row.inverse_mass;
        Acting { index, moments, mass, alone: mass * wanted, impulse: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector, Matrix3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn mobility() -> Mobility {
        let inertia = Matrix3::new(3.0, 0.1, 0.2, 0.1, 2.0, 0.05, 0.2, 0.05, 1.5);
        Mobility { inverse_mass: 1.0 / 3.5, inverse_inertia: inertia.try_inverse().unwrap() }
    }

    fn random_rows(n: usize, random: &mut ChaCha8Rng) -> Vec<Row> {
        let mut vector =
            |size: f64| Vector3::from_fn(|_, _| size * random.random_range(-1.0..1.0)) as Vector3<f64>;
        (0..n)
            .map(|knot| Row {
                knot,
                inverse_mass: 100.0 + 50.0 * vector(1.0).x,
                radius: 5e-4,
                normal: vector(1.0).normalize(),
                arm: vector(0.2),
                gap: 0.0,
                velocity: vector(2.0),
            })
            .collect()
    }

    /// Eq. 4.28 entry by entry, solved densely.
    fn dense(rows: &[Row], mobility: &Mobility, wanted: &[f64]) -> Vec<f64> {
        let k = rows.len();
        let m = DMatrix::from_fn(k, k, |i, j| {
            let (a, b) = (&rows[i], &rows[j]);
            let turned = (mobility.inverse_inertia * b.arm.cross(&b.normal)).cross(&a.arm);
            let own = if i == j { a.inverse_mass } else { 0.0 };
            own + mobility.inverse_mass * a.normal.dot(&b.normal) + a.normal.dot(&turned)
        });
        m.lu().solve(&DVector::from_row_slice(wanted)).unwrap().iter().copied().collect()
    }

    fn answer(restitution: f64, rows: &[Row], mobility: &Mobility, step: f64) -> Vec<(f64, Vector3<f64>)> {
        let mut impulses = Vec::new();
        Impulse::new(restitution, None).respond(rows, mobility, step, &mut impulses);
        impulses
    }

    #[test]
    fn woodbury_agrees_with_the_dense_matrix_of_eq_4_28() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for n in 1..=60 {
            let rows = random_rows(n, &mut random);
            let wanted: Vec<f64> = (0..n).map(|_| random.random_range(0.0..2.0)).collect();
            let mut solver = Simultaneous::default();
            solver
                .acting
                .extend(rows.iter().zip(&wanted).enumerate().map(|(i, (r, v))| Acting::of(i, r, *v)));
            solver.solve(&mobility());
            let fast = solver.acting.iter().map(|contact| contact.impulse);
            let slow = dense(&rows, &mobility(), &wanted);
            let scale = slow.iter().map(|j| j.abs()).fold(0.0, f64::max);
            for (a, b) in fast.zip(&slow) {
                assert!((a - b).abs() < 1e-10 * scale, "{n} contacts: {a} and {b}"); // measured 3e-14
            }
        }
    }

    #[test]
    fn one_contact_is_eq_4_17() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        for restitution in [0.0, 0.5, 1.0] {
            let mut row = random_rows(1, &mut random)[0];
            row.velocity -= (row.speed() + 1.0) * row.normal; // approaching at 1 m/s, touching
            let mobility = mobility();
            let answered = answer(restitution, &[row], &mobility, 1e-3);
            let effective = row.inverse_mass + mobility.along(&row.normal, &row.arm);
            assert!((answered[0].0 * effective - (1.0 + restitution)).abs() < 1e-12);
        }
    }

    #[test]
    fn no_contact_pulls() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..200 {
            let rows = random_rows(20, &mut random);
            let answers = answer(0.0, &rows, &mobility(), 1e-3);
            assert!(answers.iter().all(|(j, _)| *j >= 0.0));
        }
    }

    #[test]
    fn a_deep_knot_is_not_shot_out() {
        let mut row = random_rows(1, &mut ChaCha8Rng::seed_from_u64(5))[0];
        row.velocity = -row.normal;
        row.gap = -0.05;
        let held = Mobility { inverse_mass: 0.0, inverse_inertia: Matrix3::zeros() };
        let answered = answer(0.0, &[row], &held, 1e-4);
        assert!((answered[0].0 * row.inverse_mass - (1.0 + PUSH_OUT)).abs() < 1e-12);
    }

    #[test]
    fn nothing_happens_at_rest_or_apart() {
        let mut row = random_rows(1, &mut ChaCha8Rng::seed_from_u64(4))[0];
        row.velocity = Vector3::zeros();
        assert_eq!(answer(0.5, &[row], &mobility(), 1e-3)[0].0, 0.0);
        row.velocity = -row.normal;
        row.gap = 1.1e-3; // out of reach within the step
        assert_eq!(answer(0.5, &[row], &mobility(), 1e-3)[0].0, 0.0);
    }
}
