//! What the engine is about to do, for rows of ours that act before it.
//!
//! Cables of the engine pull after our rows have acted. A row solved alone stops its place, and the
//! engine draws it in again by T h / m in the same step: with light knots that is a metre a second and,
//! from step to step, millimetres. So our rows are solved together with those that the engine will
//! have: its cables, the knots that it holds together, and the knots' contacts of the step before. Of the solution only our own impulses
//! are used; the engine then finds nearly the same for the rest.
//!
//! A cable with stretch x and stretch rate ẋ at the end of the step pulls with
//! λ = h T = h (k (x + h ẋ) + c ẋ), hence the row (Kelvin-Voigt, implicit)
//!
//!   −ẋ + γ λ ≥ x / (h + c / k),  γ = 1 / (h² k + h c),  λ ≥ 0,
//!
//! for a slack one (x < 0) with x / h on the right: it may go taut within the step.

use std::sync::Arc;

use nalgebra::Vector3;

use super::InverseInertia;
use super::gauss_seidel::{self, IterationLimits, Rubbing};
use super::row::{ContactRow, JacobianWeights, NetMotion};
use crate::cable::Cable;
use crate::net::Net;
use crate::state::{Body, Contact, State, Tie};

/// A cable that cannot become taut at so many times the speed its ends part with has no row.
const REST_MARGIN: f64 = 3.0;

/// The rows of the engine's next step.
pub struct Lookahead {
    /// How far to go.
    limits: IterationLimits,
    /// Knots of the net.
    n_knots: usize,
    cables: Arc<[Cable]>,
    /// Impulse of each cable within the last step [N s], and how long that was [s].
    impulse: Vec<f64>,
    step: f64,
    /// The knots' contacts of the last part of the last step.
    held: Vec<HeldKnot>,
    /// Knots that it holds together.
    ties: Vec<Tie>,
    /// Cables that have a row; kept for its memory.
    taut: Vec<usize>,
    /// Velocities that are tried with the rows [m/s]; kept for their memory.
    trial: Vec<Vector3<f64>>,
}

/// A contact of a knot that the engine solves, in the body frame.
struct HeldKnot {
    knot: usize,
    part: usize,
    normal: Vector3<f64>,
    point: Vector3<f64>,
    /// Within the last part of a step [N s].
    impulse: f64,
}

impl Lookahead {
    /// For the cables of `net`, and rows solved with theirs as far as `limits` say.
    pub fn new(net: &Net, limits: IterationLimits) -> Lookahead {
        Lookahead {
            limits,
            n_knots: net.n_knots(),
            impulse: vec![0.0; net.cables.len()],
            step: f64::INFINITY,
            cables: Arc::clone(&net.cables),
            held: Vec::new(),
            ties: Vec::new(),
            taut: Vec::new(),
            trial: Vec::new(),
        }
    }

    /// Takes over which knots the engine holds together: a cable that is pushed out and does not know of the latch at its end is drawn in
    /// again by it. With latches and a `tube` around a Cubesat at 2 rad/s, 3 s, cables came 4.2 mm in, in the middle of 8, and 12 mm at most; so 1.0 and 2.0 mm.
    pub fn tie(&mut self, ties: &[Tie]) {
        self.ties.clear();
        self.ties.extend_from_slice(ties);
    }

    /// Takes over what the engine holds after the step that led to `state`, with the target as `body`: knots that are tied, and those in
    /// contact. A step in several parts has a record of each contact, of which the last counts: all together held a knot
    /// five times as hard as the engine did, and a cable that pressed it against a panel from the other side pressed
    /// five times harder at each step, up to 155 N s.
    pub fn update(&mut self, state: &State, body: &Body) {
        self.tie(&state.ties);
        self.held.clear();
        let in_body = |v: &Vector3<f64>| body.attitude.inverse_transform_vector(v);
        let pressed =
            state.contacts.iter().filter(|contact| contact.along.is_none() && contact.impulse > 0.0);
        self.held.extend(pressed.rev().map(|contact| HeldKnot {
            knot: contact.knot,
            part: contact.part,
            normal: in_body(&contact.normal),
            point: in_body(&(contact.point - body.position)),
            impulse: contact.impulse,
        }));
        self.held.sort_by_key(|held| (held.knot, held.part));
        self.held.dedup_by_key(|held| (held.knot, held.part));
    }

    /// Whether the engine holds the knot that a `place` on a cable is nearest to, on the other side of the part that it is pushed out
    /// of along `normal`, in the body frame: the cable runs straight through the part. What the two ask for cannot be had at
    /// once, and is more and more from step to step: a knot on a panel of 20 mm was shot through it at 106 m/s.
    pub fn holds_against(&self, place: &Contact, normal: &Vector3<f64>) -> bool {
        let is_held = |knot: usize| {
            let held = self.held.binary_search_by_key(&(knot, place.part), |held| (held.knot, held.part));
            held.is_ok_and(|index| self.held[index].normal.dot(normal) < 0.0)
        };
        place.bearers().iter().any(|&(knot, weight)| weight > 0.5 && is_held(knot))
    }

    /// Solves `rows` together with those that the engine will have in a step of `step` seconds, and applies their own impulses to `net` and
    /// `body`.
    pub fn solve(
        &mut self,
        rows: &mut Vec<ContactRow>,
        rubbing: Option<Rubbing<'_>>,
        net: &mut impl NetMotion,
        body: &mut Body,
        target: &InverseInertia,
        step: f64,
    ) {
        let own = rows.len();
        self.add_rows(net, body, step, rows);
        let mut trial = std::mem::take(&mut self.trial);
        trial.clear();
        trial.extend((0..self.n_knots).map(|knot| net.velocity(knot)));
        let (mut tried, mut tried_body) = (Tried { net: &*net, velocity: &mut trial }, *body);
        gauss_seidel::solve(rows, rubbing, &mut tried, &mut tried_body, target, self.limits);
        self.trial = trial;
        self.remember(&rows[own..]);
        rows.truncate(own);
        for row in rows.iter() {
            row.apply(&row.whole_impulse(), net, body, target);
        }
    }

    /// Adds the engine's rows for a step of `step` seconds to `rows`.
    fn add_rows(&mut self, net: &impl NetMotion, body: &Body, step: f64, rows: &mut Vec<ContactRow>) {
        self.taut.clear();
        // What a longer step took is too much of a guess for a shorter, and too few passes take it back.
        let share = (step / self.step).min(1.0);
        self.step = step;
        for (index, cable) in self.cables.iter().enumerate() {
            let across = net.position(cable.b) - net.position(cable.a);
            let parting = (net.velocity(cable.b) - net.velocity(cable.a)).norm();
            let length = across.norm();
            let stretch = length - cable.rest_length;
            if stretch + REST_MARGIN * parting * step <= 0.0 {
                continue;
            }
            let (k, c) = (cable.stiffness, cable.damping);
            self.taut.push(index);
            let weights = JacobianWeights::Two([(cable.b, 1.0), (cable.a, -1.0)]);
            rows.push(ContactRow {
                wanted_speed: if stretch > 0.0 { stretch / (step + c / k) } else { stretch / step },
                softness: 1.0 / (step * (step * k + c)),
                impulse: share * self.impulse[index],
                ..ContactRow::held(weights, weights.inverse_mass(net), -across / length, None)
            });
        }
        for &Tie { knots: [a, b], distance } in &self.ties {
            let across = net.position(b) - net.position(a);
            let apart = across.norm();
            let parting = (net.velocity(b) - net.velocity(a)).norm();
            // It takes nothing back: one that has given way holds where it is.
            let room = (distance - apart).max(0.0);
            // Knots in one place have no direction.
            if apart == 0.0 || room > REST_MARGIN * parting * step {
                continue;
            }
            let weights = JacobianWeights::Two([(b, 1.0), (a, -1.0)]);
            rows.push(ContactRow {
                wanted_speed: -room / step,
                ..ContactRow::held(weights, weights.inverse_mass(net), -across / apart, None)
            });
        }
        for held in &self.held {
            let (normal, arm) = (body.attitude * held.normal, body.attitude * held.point);
            let weights = JacobianWeights::of_knot(held.knot);
            rows.push(ContactRow {
                impulse: share * held.impulse,
                ..ContactRow::held(weights, weights.inverse_mass(net), normal, Some(arm))
            });
        }
    }

    /// Remembers what `rows`, as added last, were solved to.
    fn remember(&mut self, rows: &[ContactRow]) {
        self.impulse.fill(0.0);
        for (row, &index) in rows.iter().zip(&self.taut) {
            self.impulse[index] = row.impulse;
        }
    }
}

/// A net with velocities of its own.
struct Tried<'a, N> {
    net: &'a N,
    velocity: &'a mut [Vector3<f64>],
}

impl<N: NetMotion> NetMotion for Tried<'_, N> {
    fn position(&self, knot: usize) -> Vector3<f64> {
        self.net.position(knot)
    }

    fn velocity(&self, knot: usize) -> Vector3<f64> {
        self.velocity[knot]
    }

    fn inverse_mass(&self, knot: usize) -> f64 {
        self.net.inverse_mass(knot)
    }

    fn push(&mut self, knot: usize, impulse: &Vector3<f64>, weight: f64) {
        self.velocity[knot] += impulse * (weight * self.net.inverse_mass(knot));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::row::MarkedKnots;
    use crate::state::{Along, Knots};

    fn without_cables() -> Lookahead {
        Lookahead {
            limits: IterationLimits::AHEAD,
            n_knots: 8,
            cables: Arc::from([]),
            impulse: Vec::new(),
            step: 1e-3,
            held: Vec::new(),
            ties: Vec::new(),
            taut: Vec::new(),
            trial: Vec::new(),
        }
    }

    /// A step in three parts has three records of a knot that the engine holds: one row, with what the last part took.
    #[test]
    fn a_knot_is_held_once_however_many_parts_the_step_had() {
        let mut ahead = without_cables();
        let record =
            |knot, part, impulse| Contact { knot, part, impulse, normal: Vector3::x(), ..Contact::default() };
        let of_parts = [
            record(7, 0, 3.0),
            record(2, 0, 1.0),
            record(7, 0, 4.0),
            record(2, 1, 2.0),
            record(7, 0, 5.0),
            record(3, 0, 0.0),
        ];
        let body = Body::at_rest();
        ahead.update(&State { contacts: of_parts.to_vec(), ..State::default() }, &body);
        let mut knots = Knots { position: vec![Vector3::zeros(); 8], velocity: vec![Vector3::zeros(); 8] };
        let net = MarkedKnots { knots: &mut knots, before: &[], inverse_mass: &[1.0; 8], touched: &mut [] };
        let mut rows = Vec::new();
        ahead.add_rows(&net, &body, 1e-3, &mut rows);
        let held: Vec<_> = rows.iter().map(|row| (row.weights.first(), row.impulse)).collect();
        assert_eq!(held, [(2, 1.0), (2, 2.0), (7, 5.0)]);
    }

    /// A knot that another is tied to takes it along, where it goes beyond the distance and no farther than that.
    #[test]
    fn what_is_tied_goes_along() {
        let mut ahead = without_cables();
        ahead.tie(&[Tie { knots: [0, 1], distance: 0.1 }]);
        let (body, step) = (Body::at_rest(), 1e-3);
        for (apart, speed, wanted) in [(0.1, 1.0, 0.0), (0.12, 1.0, 0.0), (0.0995, 1.0, -0.5)] {
            let mut knots = Knots {
                position: vec![Vector3::zeros(), apart * Vector3::x()],
                velocity: vec![-speed * Vector3::x(), Vector3::zeros()],
            };
            let net =
                MarkedKnots { knots: &mut knots, before: &[], inverse_mass: &[1.0; 2], touched: &mut [] };
            let mut rows = Vec::new();
            ahead.add_rows(&net, &body, step, &mut rows);
            assert_eq!(rows.len(), 1);
            assert!((rows[0].wanted_speed - wanted).abs() < 1e-9, "{}", rows[0].wanted_speed);
            assert!((rows[0].normal + Vector3::x()).norm() < 1e-12);
        }
        let mut far = Knots {
            position: vec![Vector3::zeros(), 0.09 * Vector3::x()],
            velocity: vec![-Vector3::x(), Vector3::zeros()],
        };
        let net = MarkedKnots { knots: &mut far, before: &[], inverse_mass: &[1.0; 2], touched: &mut [] };
        let mut rows = Vec::new();
        ahead.add_rows(&net, &body, step, &mut rows);
        assert!(rows.is_empty());
    }

    /// A cable runs from above a panel straight through it to below: a plane of the edge below would press the knot that the engine
    /// holds above onto the panel. Not so where its other end is nearer, which can give way, nor where another part holds the knot.
    #[test]
    fn a_plane_is_held_against_where_its_cable_runs_through_the_part() {
        let mut ahead = without_cables();
        let above = Contact { knot: 1, part: 3, impulse: 1.0, normal: Vector3::z(), ..Contact::default() };
        ahead.update(&State { contacts: vec![above], ..State::default() }, &Body::at_rest());
        let at =
            |share, part| Contact { part, along: Some(Along { cable: 0, end: 2, share }), knot: 1, ..above };
        let below = Vector3::new(0.15, 0.0, -0.99);
        assert!(ahead.holds_against(&at(0.01, 3), &below));
        assert!(!ahead.holds_against(&at(0.6, 3), &below));
        assert!(!ahead.holds_against(&at(0.01, 2), &below));
        assert!(!ahead.holds_against(&at(0.01, 3), &Vector3::new(0.99, 0.0, 0.15)));
    }
}
