//! Contacts of our own responses: found by the engine's narrow phase, carried as planes.
//!
//! When a detection is due (see [`super::approach`]) the engine finds every knot within `reach` of a
//! part; each becomes a plane fixed to the target, which sub-steps carry along as the target moves
//! and turns.
//!
//! A plane stands for the surface near the knot: past an edge it goes on by at most half the reach,
//! and on a curved part of radius R the knot floats by up to reach² / (8 R).

use nalgebra::Vector3;

use super::approach::{Approach, Look};
use super::impulse::Impulse;
use super::penalty::Penalty;
use super::{Mobility, Row, Tally};
use crate::net::Net;
use crate::solver::Precision;
use crate::state::{Body, Contact, Knots, State};
use crate::target::Target;
use crate::world::Detector;

/// A response of our own.
pub enum Response {
    /// Simultaneous impulses.
    Impulse(Impulse),
    /// A force that grows with the overlap.
    Penalty(Penalty),
}

/// The knots near the target, and how their contacts are answered.
pub struct Watch {
    detector: Detector,
    response: Response,
    /// In the body frame.
    mobility: Mobility,
    approach: Approach,
    radius: Vec<f64>,
    planes: Vec<Plane>,
    found: Vec<Contact>,
    /// Rows of the sub-step, their planes, and the impulses on them; kept for their memory.
    rows: Vec<Row>,
    planes_of: Vec<usize>,
    impulses: Vec<(f64, Vector3<f64>)>,
    /// Times the engine looked for contacts.
    pub n_detections: u64,
}

/// A piece of the target's surface near a knot, in the body frame.
struct Plane {
    knot: usize,
    part: usize,
    normal: Vector3<f64>,
    /// Distance of a touching knot's centre from the target's centre of mass, along the normal [m].
    height: f64,
    /// What happened at it within the step.
    record: Contact,
    tally: Tally,
}

/// Knots whose contacts are answered: those of a kernel, or of the state.
pub trait Movable {
    /// Position at the start of the (sub-)step [m].
    fn position(&self, knot: usize) -> Vector3<f64>;
    /// Velocity that contacts have to answer [m/s].
    fn velocity(&self, knot: usize) -> Vector3<f64>;
    /// One over the mass [1/kg].
    fn inverse_mass(&self, knot: usize) -> f64;
    /// Changes the velocity by an impulse [N s].
    fn push(&mut self, knot: usize, impulse: &Vector3<f64>);
}

impl Watch {
    /// Watches `target` for the knots of `net` from the distance `reach` [m].
    ///
    /// `precision` is that of the engine, which finds contacts and no more.
    pub fn new(net: &Net, target: &Target, reach: f64, response: Response, precision: Precision) -> Watch {
        Watch {
            detector: Detector::new(net, target, precision),
            response,
            mobility: Mobility::of(target),
            approach: Approach::new(reach, target.bounding_radius),
            radius: net.radius.clone(),
            planes: Vec::new(),
            found: Vec::new(),
            rows: Vec::new(),
            planes_of: Vec::new(),
            impulses: Vec::new(),
            n_detections: 0,
        }
    }

    /// Before a step of `step` seconds: finds the planes anew where they are due.
    pub fn look(&mut self, state: &State, body: &Body, step: f64) {
        for plane in &mut self.planes {
            plane.record = empty_record(plane.knot, plane.part);
            plane.tally = Tally::default();
        }
        match self.approach.look(&state.knots, body, step) {
            Look::Apart => self.planes.clear(),
            Look::Known => {}
            Look::Due(reach) => self.detect(state, body, reach),
        }
    }

    fn detect(&mut self, state: &State, body: &Body, reach: f64) {
        let renewed = self.approach.renew(&state.knots, body, reach);
        self.detector.detect(renewed, reach, &mut self.found);
        self.n_detections += 1;
        self.planes.clear();
        for contact in &self.found {
            self.approach.found(contact.knot, contact.normal);
            self.planes.push(Plane {
                knot: contact.knot,
                part: contact.part,
                normal: contact.normal,
                height: contact.normal.dot(&self.approach.at(contact.knot)) - contact.gap,
                record: empty_record(contact.knot, contact.part),
                tally: Tally::default(),
            });
        }
    }

    /// Answers the contacts of a (sub-)step of `step` seconds: changes velocities of knots and body.
    ///
    /// `touched` hears of every knot that was pushed.
    pub fn answer(
        &mut self,
        knots: &mut impl Movable,
        body: &mut Body,
        step: f64,
        mut touched: impl FnMut(usize),
    ) {
        if self.planes.is_empty() {
            return;
        }
        let turn = body.attitude.to_rotation_matrix();
        let (rows, planes_of) = (&mut self.rows, &mut self.planes_of);
        rows.clear();
        planes_of.clear();
        for (index, plane) in self.planes.iter_mut().enumerate() {
            let normal = turn * plane.normal;
            let from_centre = knots.position(plane.knot) - body.position;
            // normal · (x − surface point) − radius, the surface point in the body frame.
            let gap = normal.dot(&from_centre) - plane.height;
            // A knot cannot turn: impulses act at its centre, or the moment of friction would be lost.
            let arm = from_centre;
            let velocity = knots.velocity(plane.knot) - body.velocity - body.rate.cross(&arm);
            plane.record.gap = plane.record.gap.min(gap);
            if gap + step * normal.dot(&velocity) >= 0.0 && gap >= 0.0 {
                continue;
            }
            let row = Row {
                knot: plane.knot,
                inverse_mass: knots.inverse_mass(plane.knot),
                radius: self.radius[plane.knot],
                normal,
                arm,
                gap,
                velocity,
            };
            // A knot between two parts: the one it is deeper in at the end of the step.
            let depth = |row: &Row| -(row.gap + step * row.speed());
            match (rows.last_mut(), planes_of.last_mut()) {
                (Some(last), Some(of)) if last.knot == row.knot => {
                    if depth(&row) > depth(last) {
                        (*last, *of) = (row, index);
                    }
                }
                _ => {
                    rows.push(row);
                    planes_of.push(index);
                }
            }
        }
        if rows.is_empty() {
            return;
        }
        let mobility = self.mobility.at(body);
        match &mut self.response {
            Response::Impulse(response) => response.respond(rows, &mobility, step, &mut self.impulses),
            Response::Penalty(response) => response.respond(rows, &mobility, step, &mut self.impulses),
        }
        let before = *body;
        for (row, (normal, across)) in rows.iter().zip(&self.impulses) {
            let impulse = *normal * row.normal + across;
            body.velocity -= mobility.inverse_mass * impulse;
            body.rate -= mobility.inverse_inertia * row.arm.cross(&impulse);
        }
        for ((row, index), (normal, across)) in rows.iter().zip(planes_of).zip(&self.impulses) {
            let impulse = *normal * row.normal + across;
            if impulse == Vector3::zeros() {
                continue;
            }
            knots.push(row.knot, &impulse);
            touched(row.knot);
            let surface = 0.5 * (before.velocity + body.velocity + (before.rate + body.rate).cross(&row.arm));
            let Plane { record, tally, .. } = &mut self.planes[*index];
            record.normal = row.normal;
            record.impulse += normal;
            // The mean over the sub-steps, so that impulse and moment agree.
            if record.impulse > 0.0 {
                record.point += (normal / record.impulse) * (before.position + row.arm - record.point);
            }
            record.friction += across;
            tally.add(&(*normal * row.normal), across, &surface);
        }
    }

    /// The contacts within the step from `before` to `after`.
    pub fn report(&self, before: &Knots, after: &Knots, contacts: &mut Vec<Contact>) {
        contacts.clear();
        for plane in self.planes.iter().filter(|plane| plane.record.gap.is_finite()) {
            let mut contact = plane.record;
            plane.tally.weigh(&mut contact, before, after);
            contacts.push(contact);
        }
    }

    /// Whether contacts are being looked for.
    pub fn detecting(&self) -> bool {
        self.approach.near()
    }

    /// Number of colliders of the detector.
    pub fn n_colliders(&self) -> usize {
        self.detector.n_colliders()
    }
}

fn empty_record(knot: usize, part: usize) -> Contact {
    Contact { knot, part, gap: f64::INFINITY, ..Contact::default() }
}
