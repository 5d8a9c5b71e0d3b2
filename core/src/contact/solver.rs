//! The solvers of contacts with the target behind one call: rows in, impulses out.
//!
//! | solver | rows | normal impulses | friction (Eq. 4.10) |
//! |---|---|---|---|
//! | [`super::woodbury`] | of different knots, or two of a knot in a corner | all at once | at the velocities before; in a corner along it |
//! | [`super::gauss_seidel`] | may share knots | pass by pass | row by row within the passes, but for rows that bounce: after them |
//! | [`super::penalty`] of knots | of different knots | each by its own overlap | at the velocities before |
//! | [`super::penalty`] of cables | may share knots | each by its own overlap | pass by pass, after all that acts in the (sub-)step, or before |
//!
//! Knots of cable elements are different ones and act on each other through the mass of the cables: their rows are solved
//! as if they shared knots.
//!
//! Friction row by row never turns a slip, so where rows share knots it only takes energy.

use nalgebra::Vector3;

use super::InverseInertia;
use super::friction::slowing_impulse;
use super::gauss_seidel::{self, IterationLimits, Rubbing};
use super::lookahead::Lookahead;
use super::penalty::PenaltyForce;
use super::plane::ContactPlane;
use super::row::{ContactRow, NetMotion};
use super::woodbury::Woodbury;
use crate::friction::Law;
use crate::state::Body;

/// How normal impulses are found.
pub enum NormalSolver {
    /// Simultaneous impulses on different knots.
    Woodbury(Woodbury),
    /// Impulses on rows that share knots.
    GaussSeidel {
        /// The engine's rows, where it moves the cables after ours have acted.
        lookahead: Option<Lookahead>,
    },
    /// A force that grows with the overlap.
    Penalty {
        /// The force.
        force: PenaltyForce,
        /// Of hits that steps are chosen for [m/s].
        speed: f64,
        /// Whether rows share knots: then it grows no more beyond the overlap of such a hit.
        of_cables: bool,
        /// Whether the cables act after it, and not before.
        in_turn: bool,
    },
}

/// A solver with the friction that goes with it.
pub struct ContactSolver {
    /// Normal impulses.
    pub normal: NormalSolver,
    /// Friction, where an effect asks for it.
    pub friction: Option<Law>,
    /// Whether an impulse of one row changes the speed of others within the net.
    pub coupled: bool,
}

impl ContactSolver {
    /// Speed up to which hits are resolved, where overlaps are answered by a force [m/s].
    pub fn resolved_speed(&self) -> Option<f64> {
        match self.normal {
            NormalSolver::Penalty { speed, .. } => Some(speed),
            _ => None,
        }
    }

    /// Whether the engine holds a knot against what a plane of its cable would do to it.
    pub fn holds_against(&self, plane: &ContactPlane) -> bool {
        let NormalSolver::GaussSeidel { lookahead: Some(lookahead) } = &self.normal else { return false };
        lookahead.holds_against(&plane.record, &plane.normal)
    }

    /// Solves for the impulses of `rows` within a (sub-)step of `step` seconds and applies them to `net` and
    /// `body`.
    pub fn solve(
        &mut self,
        rows: &mut Vec<ContactRow>,
        net: &mut impl NetMotion,
        body: &mut Body,
        target: &InverseInertia,
        step: f64,
    ) {
        match &mut self.normal {
            NormalSolver::Woodbury(woodbury) => {
                // What parts by itself within the step wants nothing.
                let wanted = |row: &ContactRow| {
                    if row.gap + row.speed * step >= 0.0 { 0.0 } else { row.wanted_speed - row.speed }
                };
                woodbury.solve(rows, target, wanted);
                self.apply_at_once(rows, net, body, target);
            }
            NormalSolver::Penalty { force, of_cables: false, .. } if !self.coupled => {
                force.solve(rows, step, None);
                self.apply_at_once(rows, net, body, target);
            }
            NormalSolver::Penalty { force, speed, of_cables, in_turn } => {
                force.solve(rows, step, of_cables.then_some(*speed));
                // Slip is what there is when all forces on a light knot have acted, or none: what cables press in and
                // normals push out over an edge is, each alone, larger. Before cables acted, friction of one face once
                // held back what the other pushed out, and pushed on along the slip: 4e-2 of the energy at hand in
                // `stress pressed-whole-friction-1` under joints+penalty, for 1.4e-5.
                if *in_turn {
                    self.rub(rows, net, body, target);
                    apply_normal(rows, net, body, target);
                } else {
                    apply_normal(rows, net, body, target);
                    self.rub(rows, net, body, target);
                }
            }
            NormalSolver::GaussSeidel { lookahead: None } => {
                let rubbing = self.friction.as_ref().map(|law| Rubbing { law, n_rows: rows.len() });
                gauss_seidel::solve(rows, rubbing, net, body, target, IterationLimits::WHOLE);
            }
            NormalSolver::GaussSeidel { lookahead: Some(lookahead) } => {
                let rubbing = self.friction.as_ref().map(|law| Rubbing { law, n_rows: rows.len() });
                lookahead.solve(rows, rubbing, net, body, target, step);
            }
        }
    }

    fn apply_at_once(
        &self,
        rows: &mut [ContactRow],
        net: &mut impl NetMotion,
        body: &mut Body,
        target: &InverseInertia,
    ) {
        if let Some(law) = &self.friction {
            for index in 0..rows.len() {
                let velocity = slip_at(rows, index);
                rows[index].friction = slowing_impulse(law, &rows[index], &velocity, target);
            }
        }
        // On the target together.
        let (mut impulse, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for row in rows.iter() {
            let of_row = row.whole_impulse();
            row.weights.each(|knot, weight| net.push(knot, &of_row, weight));
            impulse += of_row;
            moment += row.arm.unwrap_or_default().cross(&of_row);
        }
        target.take(body, &impulse, &moment);
    }

    fn rub(
        &self,
        rows: &mut [ContactRow],
        net: &mut impl NetMotion,
        body: &mut Body,
        target: &InverseInertia,
    ) {
        if let Some(law) = &self.friction {
            gauss_seidel::rub(law, rows, net, body, target, IterationLimits::FRICTION);
        }
    }
}

/// Velocity that friction of the row at `index` is against, where those before it have theirs [m/s]. In a corner that is along
/// both faces, for across it the one holds what comes along the other: friction beside that, with restitution 1, once made
/// 4e-2 of the energy at hand. And the second face slows what the first left.
fn slip_at(rows: &[ContactRow], index: usize) -> Vector3<f64> {
    let row = &rows[index];
    let is_of_corner = |other: &&ContactRow| row.is_of_the_knot_of(other) && other.impulse > 0.0;
    let before = index.checked_sub(1).map(|before| &rows[before]).filter(is_of_corner);
    let Some(other) = before.or(rows.get(index + 1).filter(is_of_corner)) else { return row.velocity };
    let left = before.map_or_else(Vector3::zeros, |first| first.inverse_mass * first.friction);
    let slip = row.velocity + left;
    // Faces of parts that stand in each other may be one plane, which has no corner.
    row.normal.cross(&other.normal).try_normalize(1e-9).map_or(slip, |along| along.dot(&slip) * along)
}

fn apply_normal(rows: &[ContactRow], net: &mut impl NetMotion, body: &mut Body, target: &InverseInertia) {
    for row in rows {
        row.apply(&(row.impulse * row.normal), net, body, target);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::row::{JacobianWeights, MarkedKnots};
    use crate::state::Knots;
    use nalgebra::vector;

    /// In a corner friction is against what comes along both faces, and on two parts with one face against all of the slip.
    #[test]
    fn a_knot_slips_along_both_its_faces() {
        let velocity = vector![0.3, -0.2, 0.1];
        let row = |normal: Vector3<f64>| ContactRow {
            velocity,
            impulse: 1.0,
            ..ContactRow::held(JacobianWeights::of_knot(0), 1.0, normal, Some(Vector3::zeros()))
        };
        let corner = [row(Vector3::y()), row(Vector3::z())];
        assert_eq!(slip_at(&corner, 0), vector![0.3, 0.0, 0.0]);
        assert_eq!(slip_at(&[row(Vector3::y()), row(Vector3::y())], 0), velocity);
        assert_eq!(slip_at(&[row(Vector3::y())], 0), velocity);
    }

    /// A light knot lies in two faces at an edge, 70 N of each throw it out at 4 m/s within the step, and cables throw it
    /// back in: friction is against the slip between, in the step of either order.
    #[test]
    fn friction_of_a_force_at_an_edge_is_against_the_slip() {
        let (step, mass, depth) = (6e-6, 1e-4, 5e-4);
        let slip = vector![0.2, -0.04, -0.3];
        let thrown = 70.0 * step / mass * vector![0.0, 1.0, 1.0];
        for in_turn in [true, false] {
            // Where cables act before contact, they have thrown it in already.
            let velocity = if in_turn { slip } else { slip - thrown };
            let mut knots = Knots { position: vec![Vector3::zeros(); 2], velocity: vec![velocity; 2] };
            let inverse_mass = [1.0 / mass; 2];
            let weights = JacobianWeights::Two([(0, 1.0), (1, 0.0)]);
            let row = |normal: Vector3<f64>| ContactRow {
                radius: 1e-3,
                gap: -depth,
                velocity,
                speed: normal.dot(&velocity),
                wanted_speed: f64::INFINITY,
                ..ContactRow::held(weights, 1.0 / mass, normal, Some(Vector3::zeros()))
            };
            let mut rows = vec![row(Vector3::y()), row(Vector3::z())];
            let force = PenaltyForce::spring(2, 70.0 / depth);
            let normal = NormalSolver::Penalty { force, speed: 1e3, of_cables: true, in_turn };
            let friction = Some(Law::Coulomb { coefficient: 1.0 });
            let mut solver = ContactSolver { normal, friction, coupled: true };
            let mut net = MarkedKnots {
                knots: &mut knots,
                before: &[],
                inverse_mass: &inverse_mass,
                touched: &mut [false; 2],
            };
            let mut body = Body::at_rest();
            solver.solve(&mut rows, &mut net, &mut body, &InverseInertia::default(), step);
            for row in &rows {
                assert!((row.impulse / (70.0 * step) - 1.0).abs() < 1e-12);
                let power = row.friction.dot(&slip);
                assert!(power < 0.0, "in turn {in_turn}: it pushes on with {power} N s m/s");
            }
        }
    }
}
