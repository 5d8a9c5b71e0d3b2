//! Contacts that share knots, solved one after another: projected Gauss-Seidel.
//!
//! A row keeps one place of the net from the target, or two places of the net from each other. A
//! place is a weighted mean of knots, so rows share knots, D of Eq. 4.28 is no longer diagonal and
//! the Woodbury solve of [`super::woodbury`] does not apply. The rows ask for impulses λ with
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
//! that is not taken back in time does leave energy: a wad of 11 x 11 knots exploded that way. (To begin with nothing
//! where a guess would leave energy is worse with the engine's cables: 2.2e-3 for 2.1e-4 on the free Cubesat with
//! contact of whole cables, and 3.1e-3 with as much of it as lowers most what the passes lower.)
//!
//! Friction may be solved in the same passes: each row in turn brings its slip to zero with an impulse of at most
//! μ λ. After the passes, at velocities that the engine's cables then changed, it let cables of a closing net up to
//! 20 mm into a Cubesat at μ = 0.3, and created 4.8e-3 of the energy (0.9 mm and 3.5e-4 so). That of a row that bounces comes
//! after the passes all the same: a speed of parting that is asked for, beside friction that turns as the passes go, can give
//! energy (5 of 64 members of `stress restitution-1-friction-1` under joints+impulse above 5e-4, for 1).

use nalgebra::Vector3;

use super::InverseInertia;
use super::row::{ContactRow, JacobianWeights, NetMotion};
use crate::friction::Law;
use crate::state::Body;

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationLimits {
    /// Passes over the rows within a (sub-)step, at most.
    pub passes: usize,
    /// Passes end when none changes the speed of its row by more than this share of the fastest wanted
    /// change.
    pub tolerance: f64,
    /// Whether rows that have enough rest for some passes: most of those of a net's cables do where few strands touch.
    pub rests: bool,
}

impl IterationLimits {
    /// Until the rows hold. The Cubesat's capture takes 4 passes on average. (With a tolerance of 1e-6 nothing is nearer, and it takes 4 % longer, 11 %
    /// with friction; with 1e-4 it creates twice as much in one of a hundred nets around a cube that is held.)
    pub const WHOLE: IterationLimits = IterationLimits { passes: 100, tolerance: 1e-5, rests: true };

    /// The same where strands of the net touch: what is not solved goes through.
    pub const OF_STRANDS: IterationLimits = IterationLimits { tolerance: 1e-6, ..IterationLimits::WHOLE };

    /// The same where threads press strands of the net together. The nets of eight stages with a `tube` under 50 N had 318 pairs that went through
    /// each other with 100 passes, and one made 3.0e-3 of the energy at hand; 34 and 9.7e-5 with these. (In steps in which strands are not
    /// outrun, see `strand_step`, four have 14 with 100 passes, and two none with these.) Cubesats with a `tube`, whose strands do not, take 14 % longer.
    pub const OF_DRAWN_STRANDS: IterationLimits =
        IterationLimits { passes: 400, ..IterationLimits::OF_STRANDS };

    /// For rows of which the engine solves most again. With 12 passes a net of 6 x 6 meshes at 5 m/s around a box of
    /// 3.5 kg made 6.5e-3 of the energy at hand in the middle of 64 members, with friction 1 around one of 0.5 kg 1.6e-3: what
    /// is not solved comes in, and work pushes it out. With 50 it is 2.4e-4 and 2.0e-4, with 200 the same, and the Cubesat's
    /// capture takes no longer, for most answers end by the tolerance; with one of 1e-4 it takes a tenth more.
    pub const AHEAD: IterationLimits = IterationLimits { passes: 50, tolerance: 1e-3, rests: false };

    /// The same of strands of the net: what is not solved goes through, see [`super::strands`]. And of knots that impulses of ours answer: with
    /// 50 passes and 1e-3 a free Cubesat's net made 7e-4 in the middle of four and 2.4e-3 at most, 2e-4 so.
    pub const AHEAD_OF_STRANDS: IterationLimits =
        IterationLimits { passes: 200, tolerance: 1e-4, rests: true };

    /// The same of those that bounce well. What of a chain of bounces is left approaching is lost, and what is wanted of all at
    /// once may be more than there was: with full restitution 48 members made 2e-4 of the energy at hand in the middle and
    /// 3e-3 at most with 12 passes, 4.2e-3 and 0.1 with 50.
    pub const AHEAD_OF_BOUNCES: IterationLimits =
        IterationLimits { passes: 12, tolerance: 1e-3, rests: false };

    /// For friction beside forces, whose normal impulses are known. Of 40 nets with friction 1 around boxes, two members each, one made
    /// 1.9e-3 of the energy with 20 passes to 1e-2, none above 6.1e-4 so, and 1.7e-4 with 100 to 1e-6, which takes half as long again.
    pub const FRICTION: IterationLimits = IterationLimits { passes: 50, tolerance: 1e-4, rests: false };
}

impl Default for IterationLimits {
    fn default() -> Self {
        IterationLimits::WHOLE
    }
}

/// Every so many passes rows that rest are looked at.
const REST: usize = 8;

/// Friction of the first so many rows, solved in the same passes.
#[derive(Clone, Copy, Debug)]
pub struct Rubbing<'a> {
    /// Its law.
    pub law: &'a Law,
    /// How many rows have it.
    pub n_rows: usize,
}

/// What passes need of a row: its column of M⁻¹ Gᵀ is made once.
struct PassedRow {
    weights: JacobianWeights,
    normal: Vector3<f64>,
    /// r × n, and what the target turns by for a unit impulse, where it is touched [m, 1/(kg m)].
    lever: Option<[Vector3<f64>; 2]>,
    wanted_speed: f64,
    softness: f64,
    /// Its own entry of G M⁻¹ Gᵀ, with the softness, and one over it [1/kg, kg].
    diagonal: [f64; 2],
    impulse: f64,
    /// Passes in which it had enough, one after another: such a row rests but for every so many passes, and the last.
    quiet: u8,
}

impl PassedRow {
    fn of(row: &ContactRow, target: &InverseInertia) -> PassedRow {
        let lever = row.arm.map(|arm| {
            let moment = arm.cross(&row.normal);
            [moment, target.inverse_inertia * moment]
        });
        let of_target = lever.map_or(0.0, |[moment, turned]| target.inverse_mass + moment.dot(&turned));
        let diagonal = row.softness + row.inverse_mass + of_target;
        PassedRow {
            weights: row.weights,
            normal: row.normal,
            lever,
            wanted_speed: row.wanted_speed,
            softness: row.softness,
            diagonal: [diagonal, 1.0 / diagonal],
            impulse: row.impulse,
            quiet: 0,
        }
    }

    /// Speed of parting now [m/s].
    #[inline(always)]
    fn speed(&self, net: &impl NetMotion, body: &Body) -> f64 {
        let of_net = self.weights.sum(|knot| net.velocity(knot));
        match &self.lever {
            Some([moment, _]) => self.normal.dot(&(of_net - body.velocity)) - moment.dot(&body.rate),
            None => self.normal.dot(&of_net),
        }
    }

    /// Gives the net an impulse along the normal [N s], and takes it from the other side.
    #[inline(always)]
    fn push(&self, impulse: f64, net: &mut impl NetMotion, body: &mut Body, target: &InverseInertia) {
        let along = impulse * self.normal;
        self.weights.each(|knot, weight| net.push(knot, &along, weight));
        if let Some([_, turned]) = &self.lever {
            body.velocity -= target.inverse_mass * along;
            body.rate -= impulse * turned;
        }
    }
}

/// Solves for the impulses of `rows`, which begin with what they hold, and applies them to `net` and `body`;
/// returns the number of passes.
pub fn solve(
    rows: &mut [ContactRow],
    rubbing: Option<Rubbing<'_>>,
    net: &mut impl NetMotion,
    body: &mut Body,
    target: &InverseInertia,
    limits: IterationLimits,
) -> usize {
    let (law, n_rubbing) = rubbing.map_or((None, 0), |rubbing| (Some(rubbing.law), rubbing.n_rows));
    let mut passed: Vec<PassedRow> = rows.iter().map(|row| PassedRow::of(row, target)).collect();
    let wanted = passed.iter().map(|row| row.wanted_speed - row.speed(net, body)).fold(0.0, f64::max);
    passed.iter().filter(|row| row.impulse != 0.0).for_each(|row| row.push(row.impulse, net, body, target));
    let enough = limits.tolerance * wanted;
    let (mut passes, mut is_whole) = (0, true);
    while passes < limits.passes {
        passes += 1;
        is_whole |= passes % REST == 0;
        let mut largest = 0.0_f64;
        for (index, row) in passed.iter_mut().enumerate() {
            if !is_whole && row.quiet >= 2 {
                continue;
            }
            let short = row.wanted_speed - row.speed(net, body) - row.softness * row.impulse;
            let impulse = (row.impulse + short * row.diagonal[1]).max(0.0);
            let change = impulse - row.impulse;
            let changed = change.abs() * row.diagonal[0];
            if change != 0.0 {
                row.impulse = impulse;
                row.push(change, net, body, target);
                largest = largest.max(changed);
            }
            if limits.rests {
                row.quiet = if changed <= enough { row.quiet.saturating_add(1) } else { 0 };
            }
            if let Some(law) = law
                && index < n_rubbing
                && !rows[index].bounces
            {
                rows[index].impulse = row.impulse;
                largest = largest.max(rub_one(law, &mut rows[index], net, body, target));
            }
        }
        if largest <= enough && is_whole {
            break;
        }
        is_whole = !limits.rests || largest <= enough;
    }
    for (row, passed) in rows.iter_mut().zip(&passed) {
        row.impulse = passed.impulse;
    }
    if let Some(law) = law {
        for row in rows[..n_rubbing].iter_mut().filter(|row| row.bounces) {
            rub_one(law, row, net, body, target);
        }
    }
    passes
}

/// Solves for friction of `rows` whose normal impulses are known and have acted, or are yet to: that of each is against the slip that
/// is left when all have theirs. Each in turn and once, friction on the one side of a panel was against what that on the other
/// took at once, and pushed on along the slip: 0.14 of the energy at hand with a coefficient of 1.
pub fn rub(
    law: &Law,
    rows: &mut [ContactRow],
    net: &mut impl NetMotion,
    body: &mut Body,
    target: &InverseInertia,
    limits: IterationLimits,
) {
    let mut fastest = 0.0_f64;
    for _ in 0..limits.passes {
        let mut largest = 0.0_f64;
        for row in rows.iter_mut() {
            largest = largest.max(rub_one(law, row, net, body, target));
        }
        fastest = fastest.max(largest);
        if largest <= limits.tolerance * fastest {
            break;
        }
    }
}

/// Brings the slip of `row` towards zero, by a friction impulse within the cone of its normal impulse; by how much the
/// slip changed [m/s].
fn rub_one(
    law: &Law,
    row: &mut ContactRow,
    net: &mut impl NetMotion,
    body: &mut Body,
    target: &InverseInertia,
) -> f64 {
    let along_surface = |v: &Vector3<f64>| v - row.normal.dot(v) * row.normal;
    let slip = along_surface(&row.velocity_now(net, body));
    let speed = slip.norm();
    if speed <= 0.0 {
        return 0.0;
    }
    let inverse_mass = row.inverse_mass_along(&(slip / speed), target);
    let mut friction = row.friction - slip / inverse_mass;
    let most = law.coefficient(along_surface(&row.velocity).norm()) * row.impulse;
    if friction.norm() > most {
        friction *= most / friction.norm();
    }
    let change = friction - row.friction;
    row.friction = friction;
    row.apply(&change, net, body, target);
    change.norm() * inverse_mass
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::row::{MarkedKnots, OfParting, Parting, PushOut};
    use crate::state::Knots;
    use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const KNOTS: usize = 6;

    /// Rows that share few knots, against the target and against each other.
    fn random_rows(n: usize, inverse_mass: &[f64], random: &mut ChaCha8Rng) -> Vec<ContactRow> {
        let mut number = |low: f64, high: f64| random.random_range(low..high);
        (0..n)
            .map(|i| {
                let mut vector = || Vector3::new(number(-1.0, 1.0), number(-1.0, 1.0), number(-1.0, 1.0));
                let (normal, arm) = (vector().normalize(), 0.2 * vector());
                let (s, t) = (number(0.1, 0.9), number(0.1, 0.9));
                let knot = |shift: usize| (i + shift) % KNOTS;
                let with_target = i % 2 == 0;
                let weights = if with_target {
                    JacobianWeights::Two([(knot(0), 1.0 - s), (knot(1), s)])
                } else {
                    JacobianWeights::Four([
                        (knot(0), 1.0 - s),
                        (knot(1), s),
                        (knot(3), t - 1.0),
                        (knot(4), -t),
                    ])
                };
                let inverse_mass: f64 =
                    weights.all().iter().map(|&(knot, w)| w * w * inverse_mass[knot]).sum();
                ContactRow {
                    wanted_speed: number(-0.5, 0.5),
                    softness: if i % 3 == 0 { number(0.0, 50.0) } else { 0.0 },
                    ..ContactRow::held(weights, inverse_mass, normal, with_target.then_some(arm))
                }
            })
            .collect()
    }

    fn net<'a>(knots: &'a mut Knots, inverse_mass: &'a [f64]) -> MarkedKnots<'a> {
        MarkedKnots { knots, before: &[], inverse_mass, touched: &mut [] }
    }

    fn speed(row: &ContactRow, knots: &Knots, inverse_mass: &[f64], body: &Body) -> f64 {
        row.normal.dot(&row.velocity_now(&net(&mut knots.clone(), inverse_mass), body))
    }

    /// The complementarity problem by trying every set of acting rows: the velocities of the solution.
    fn dense(
        rows: &[ContactRow],
        knots: &Knots,
        inverse_mass: &[f64],
        body: &Body,
        target: &InverseInertia,
    ) -> Vec<f64> {
        let n = rows.len();
        // Column j: change of every row's speed by a unit impulse of row j.
        let mut matrix = DMatrix::zeros(n, n);
        for j in 0..n {
            let (mut moved, mut moved_body) = (knots.clone(), *body);
            rows[j].apply(&rows[j].normal, &mut net(&mut moved, inverse_mass), &mut moved_body, target);
            for (i, row) in rows.iter().enumerate() {
                let now = row.velocity_now(&net(&mut moved, inverse_mass), &moved_body);
                matrix[(i, j)] = row.normal.dot(&now) - speed(row, knots, inverse_mass, body);
            }
            matrix[(j, j)] += rows[j].softness;
        }
        let short: Vec<f64> =
            rows.iter().map(|row| row.wanted_speed - speed(row, knots, inverse_mass, body)).collect();
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
        let target =
            InverseInertia { inverse_mass: 1.0 / 3.5, inverse_inertia: inertia.try_inverse().unwrap() };
        for n in 1..=6 {
            for _ in 0..20 {
                let inverse_mass: Vec<f64> = (0..KNOTS).map(|_| random.random_range(50.0..150.0)).collect();
                let mut rows = random_rows(n, &inverse_mass, &mut random);
                let mut number = |low: f64, high: f64| random.random_range(low..high);
                let velocity =
                    (0..KNOTS).map(|_| Vector3::new(number(-1.0, 1.0), number(-1.0, 1.0), 0.3)).collect();
                let mut knots = Knots { position: vec![Vector3::zeros(); KNOTS], velocity };
                let mut body = Body {
                    position: Vector3::zeros(),
                    attitude: UnitQuaternion::identity(),
                    velocity: Vector3::new(0.1, 0.0, 0.2),
                    rate: Vector3::new(0.5, -0.3, 0.1),
                };
                let expected = dense(&rows, &knots, &inverse_mass, &body, &target);
                let limits = IterationLimits { passes: 100_000, tolerance: 1e-13, rests: true };
                solve(&mut rows, None, &mut net(&mut knots, &inverse_mass), &mut body, &target, limits);
                let scale = expected.iter().fold(1e-3, |most: f64, j| most.max(*j));
                for (row, expected) in rows.iter().zip(&expected) {
                    assert!((row.impulse - expected).abs() < 1e-6 * scale, "{} {expected}", row.impulse);
                }
            }
        }
    }

    fn kinetic(knots: &Knots, inverse_mass: &[f64], body: &Body, mass: f64, inertia: &Matrix3<f64>) -> f64 {
        let of_knots = knots.velocity.iter().zip(inverse_mass).map(|(v, w)| 0.5 * v.norm_squared() / w);
        of_knots.sum::<f64>() + body.kinetic_energy(mass, inertia)
    }

    /// Bounces of rows that share knots, some of which part already, take energy whatever the restitution: what is wanted is
    /// Moreau's law of all rows, not of those alone that approach.
    #[test]
    fn bounces_of_rows_that_share_knots_take_energy() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let inertia = Matrix3::from_diagonal(&Vector3::new(3.0, 2.0, 1.5));
        let target =
            InverseInertia { inverse_mass: 1.0 / 3.5, inverse_inertia: inertia.try_inverse().unwrap() };
        let mut pushed_while_parting = 0;
        for restitution in [0.5, 0.9, 1.0] {
            let push_out = PushOut::Speed(1.0);
            let parting = Parting { restitution, push_out, in_turn: false, of_parting: OfParting::ComesBack };
            for _ in 0..50 {
                let inverse_mass: Vec<f64> = (0..KNOTS).map(|_| random.random_range(50.0..150.0)).collect();
                let mut rows = random_rows(6, &inverse_mass, &mut random);
                let mut number = |low: f64, high: f64| random.random_range(low..high);
                let velocity =
                    (0..KNOTS).map(|_| Vector3::new(number(-1.0, 1.0), number(-1.0, 1.0), 0.3)).collect();
                let mut knots = Knots { position: vec![Vector3::zeros(); KNOTS], velocity };
                let mut body = Body { rate: Vector3::new(0.5, -0.3, 0.1), ..Body::at_rest() };
                for row in &mut rows {
                    row.speed = speed(row, &knots, &inverse_mass, &body);
                    row.wanted_speed = parting.wanted_speed(0.0, [row.speed; 2], row.radius, 0.0, 1e-3);
                    row.softness = 0.0;
                }
                let before = kinetic(&knots, &inverse_mass, &body, 3.5, &inertia);
                let limits = IterationLimits { passes: 100_000, tolerance: 1e-13, rests: true };
                solve(&mut rows, None, &mut net(&mut knots, &inverse_mass), &mut body, &target, limits);
                let after = kinetic(&knots, &inverse_mass, &body, 3.5, &inertia);
                assert!(after <= before * (1.0 + 1e-9), "{restitution}: {before} {after}");
                pushed_while_parting +=
                    rows.iter().filter(|row| row.impulse > 0.0 && row.speed > 0.0).count();
            }
        }
        assert!(pushed_while_parting > 5, "{pushed_while_parting}");
    }

    /// Random rows with friction that want no approach: what is left of the slip is against the friction or within the
    /// cone, and energy only falls, also where few passes end early.
    #[test]
    fn friction_stays_in_its_cone_and_takes_energy() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let inertia = Matrix3::from_diagonal(&Vector3::new(3.0, 2.0, 1.5));
        let target =
            InverseInertia { inverse_mass: 1.0 / 3.5, inverse_inertia: inertia.try_inverse().unwrap() };
        let (mut sliding, mut sticking) = (0, 0);
        for passes in [100_000, 12, 1] {
            for _ in 0..50 {
                let inverse_mass: Vec<f64> = (0..KNOTS).map(|_| random.random_range(50.0..150.0)).collect();
                let mut rows = random_rows(6, &inverse_mass, &mut random);
                rows.sort_by_key(|row| row.arm.is_none());
                let n_rows = rows.iter().filter(|row| row.arm.is_some()).count();
                let mut number = |low: f64, high: f64| random.random_range(low..high);
                let velocity =
                    (0..KNOTS).map(|_| Vector3::new(number(-1.0, 1.0), number(-1.0, 1.0), 0.3)).collect();
                let mut knots = Knots { position: vec![Vector3::zeros(); KNOTS], velocity };
                let mut body = Body { rate: Vector3::new(0.5, -0.3, 0.1), ..Body::at_rest() };
                for row in &mut rows {
                    row.velocity = row.velocity_now(&net(&mut knots.clone(), &inverse_mass), &body);
                    row.wanted_speed = 0.0;
                }
                let before = kinetic(&knots, &inverse_mass, &body, 3.5, &inertia);
                let law = Law::Coulomb { coefficient: 1.0 };
                let rubbing = Some(Rubbing { law: &law, n_rows });
                let limits = IterationLimits { passes, tolerance: 1e-13, rests: true };
                solve(&mut rows, rubbing, &mut net(&mut knots, &inverse_mass), &mut body, &target, limits);
                let after = kinetic(&knots, &inverse_mass, &body, 3.5, &inertia);
                assert!(after <= before * (1.0 + 1e-12), "{passes}: {before} {after}");
                for row in &rows[..n_rows] {
                    let most = row.impulse;
                    assert!(row.friction.norm() <= most * (1.0 + 1e-12));
                    assert!(row.friction.dot(&row.normal).abs() < 1e-12);
                    let velocity = row.velocity_now(&net(&mut knots.clone(), &inverse_mass), &body);
                    let slip = velocity - row.normal.dot(&velocity) * row.normal;
                    if passes < 100 || row.impulse == 0.0 {
                        continue;
                    }
                    if row.friction.norm() < 0.999 * most {
                        sticking += 1;
                        assert!(slip.norm() < 1e-9, "sticks at {slip}");
                    } else {
                        sliding += 1;
                        assert!(slip.dot(&row.friction) <= 1e-9, "pushes on at {slip}");
                    }
                }
            }
        }
        assert!(sliding > 5 && sticking > 5, "{sliding} {sticking}");
    }
}
