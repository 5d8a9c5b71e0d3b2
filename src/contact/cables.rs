//! Contact of whole cables with the target.
//!
//! A cable touches at places between its knots. The engine's narrow phase finds them with capsules;
//! each becomes a plane fixed to the target, as for knots (see [`super::watch`]), that keeps the
//! material place at share s of the cable outside. Both end knots bear the impulse J of a place, by
//! the lever rule: (1 − s) J and s J. The place answers with the inverse mass
//! (1 − s)² / m_a + s² / m_b; linear and angular momentum are kept, since the weighted mean of the
//! knots' positions is the place.
//!
//! With `impulse` (and with the engine's response, which knows no rows of ours) the places are
//! stopped together, by [`super::sequential`]; with `penalty` each by its own force, of an overlap
//! no deeper than that for which the step is chosen.
//!
//! The engine finds the one place of a cable that is nearest. A cable that rests on two edges touches at both:
//! a place that is not found again is kept while it is near the surface that it touched, or the cable sinks
//! into one edge while the engine sees the other, and is pushed out of each in turn.
//!
//! A place that got inside is pushed out within a few milliseconds, not at once: planes found anew differ
//! a little from those carried along, and to undo that within a sub-step would shoot the cable off. So
//! would a force that answered such an overlap at once: it is forgiven first.
//!
//! Cables of the engine pull after our contact has acted: rows of ours then look ahead, with
//! [`super::preview`].

use nalgebra::Vector3;

use super::approach::{Approach, Look};
use super::friction::slowing_impulse;
use super::penalty::Penalty;
use super::preview::Preview;
use super::sequential::{self, Bearers, Effort, Row as SharedRow};
use super::{Mobility, Row, Tally};
use crate::friction::Law;
use crate::net::Net;
use crate::solver::{CableModel, Solver};
use crate::state::{Along, Body, Contact, Knots, State};
use crate::target::Target;
use crate::target::parts::ConvexPart;
use crate::world::CableDetector;

/// Time in which an overlap is undone [s], at least a step. With 1 ms the speed of that, half a metre a second,
/// stayed with a place beside a bullet: 2 % of the Cubesat net's launch energy at once.
const PUSH_OUT: f64 = 5e-3;

/// The same where the engine moves the cables, and presses what is left inside further in at every step: with
/// 5 ms energy rose by up to 2e-3 of the launch energy, with 1 ms by 5e-4.
const PUSH_OUT_OF_ENGINE: f64 = 1e-3;

/// A place found anew within this share of the cable from one known before is the same.
const SAME_CONTACT: f64 = 0.1;

/// Speed that the engine's cables may give a place within a step [m/s]: nearer than that, it has a row.
const DRAWN_IN: f64 = 1.0;

/// How a place is answered.
pub enum Response {
    /// Stopped, with a coefficient of restitution [-].
    Impulse {
        /// e [-]
        restitution: f64,
    },
    /// Pushed by a force that grows with the overlap.
    Penalty {
        /// The force.
        force: Penalty,
        /// Speed at which its step is stable [m/s].
        speed: f64,
    },
}

/// The cables near the target, and how their contacts are answered.
pub struct CableWatch {
    detector: CableDetector,
    /// The target's parts in the body frame.
    solids: Vec<ConvexPart>,
    response: Response,
    friction: Option<Law>,
    mobility: Mobility,
    approach: Approach,
    /// The engine's rows, where it moves the cables.
    preview: Option<Preview>,
    /// Deepest overlap that a force of a knot's contact may grow to [m].
    deepest: Vec<f64>,
    /// Time in which an overlap is undone [s].
    push_out: f64,
    radius: Vec<f64>,
    inverse_mass: Vec<f64>,
    planes: Vec<Plane>,
    found: Vec<Contact>,
    /// Planes that act in this sub-step, and their rows; kept for their memory.
    acting: Vec<Acting>,
    rows: Vec<SharedRow>,
    scratch: Vec<Vector3<f64>>,
    /// Times the engine looked for contacts.
    pub n_detections: u64,
}

/// A piece of the target's surface near a cable, in the body frame.
struct Plane {
    normal: Vector3<f64>,
    /// Distance of a touching cable's middle line from the target's centre of mass, along the
    /// normal [m].
    height: f64,
    /// Where the target is touched, from its centre of mass [m].
    foot: Vector3<f64>,
    /// Impulse within the last sub-step [N s].
    impulse: f64,
    /// Overlap that it was found with and that no force answers, on its way to zero [m].
    forgiven: f64,
    /// Which cable and part, and what happened within the step.
    record: Contact,
    tally: Tally,
}

/// A plane that acts in a sub-step.
struct Acting {
    plane: usize,
    /// As a contact of one place alone.
    alone: Row,
    /// Impulse of friction [N s].
    across: Vector3<f64>,
}

impl Plane {
    /// Gap of a cable at `place` from the body's centre [m].
    fn gap(&self, place: &Vector3<f64>, body: &Body) -> f64 {
        (body.attitude * self.normal).dot(place) - self.height
    }

    /// Overlap that is answered [m].
    fn depth(&self, knots: &Knots, body: &Body) -> f64 {
        let place = self.record.at_place(&knots.position) - body.position;
        (-self.gap(&place, body) - self.forgiven).max(0.0)
    }

    /// The same plane for where the cable is nearest to its foot now; none where that is a knot.
    fn moved(&self, knots: &Knots, body: &Body) -> Option<Plane> {
        let (from, along) = (knots.position[self.record.knot], self.place().1);
        let across = knots.position[along.end] - from;
        let foot = body.position + body.attitude * self.foot;
        let share = across.dot(&(foot - from)) / across.norm_squared();
        (0.0..=1.0).contains(&share).then(|| Plane {
            record: empty_record(&Contact { along: Some(Along { share, ..along }), ..self.record }),
            tally: Tally::default(),
            forgiven: 0.0,
            ..*self
        })
    }

    /// Where the contact is on the cable.
    fn place(&self) -> ([(usize, f64); 2], Along) {
        (self.record.bearers(), self.record.along.unwrap_or_default())
    }
}

impl CableWatch {
    /// Watches `target` for the cables of `net` from the distance `reach` [m]; cables may be joints
    /// of the engine.
    pub fn new(
        net: &Net,
        target: &Target,
        reach: f64,
        response: Response,
        friction: Option<Law>,
        solver: &Solver,
    ) -> CableWatch {
        let deepest = match &response {
            Response::Impulse { .. } => Vec::new(),
            Response::Penalty { force, speed } => {
                (0..net.n_knots()).map(|knot| force.deepest(net, knot, *speed)).collect()
            }
        };
        CableWatch {
            preview: (solver.cables == CableModel::Joints).then(|| Preview::new(net)),
            push_out: if solver.cables == CableModel::Joints { PUSH_OUT_OF_ENGINE } else { PUSH_OUT },
            deepest,
            detector: CableDetector::new(net, target, solver.precision),
            solids: target.parts.clone(),
            response,
            friction,
            mobility: Mobility::of(target),
            approach: Approach::new(reach, target.bounding_radius),
            radius: (0..net.cables.len()).map(|cable| net.cable_radius(cable)).collect(),
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            planes: Vec::new(),
            found: Vec::new(),
            acting: Vec::new(),
            rows: Vec::new(),
            scratch: Vec::new(),
            n_detections: 0,
        }
    }

    /// Before a step of `step` seconds from `state`: finds the planes anew where they are due.
    pub fn look(&mut self, state: &State, body: &Body, step: f64) {
        let knots = &state.knots;
        if let Some(preview) = &mut self.preview {
            preview.hear(&state.contacts, body);
        }
        for plane in &mut self.planes {
            plane.record = empty_record(&plane.record);
            plane.tally = Tally::default();
        }
        match self.approach.look(knots, body, step) {
            Look::Apart => self.planes.clear(),
            Look::Known => {}
            Look::Due(reach) => self.detect(state, body, reach),
        }
    }

    fn detect(&mut self, state: &State, body: &Body, reach: f64) {
        let knots = &state.knots;
        self.detector.detect(state, body, reach, &mut self.found);
        self.n_detections += 1;
        self.approach.found_cables(knots, body);
        let before = std::mem::take(&mut self.planes);
        let found = std::mem::take(&mut self.found);
        for contact in &found {
            let place = contact.at_place(&knots.position) - body.position;
            let fresh = Plane {
                normal: body.attitude.inverse_transform_vector(&contact.normal),
                height: contact.normal.dot(&place) - contact.gap,
                foot: body.to_body(&contact.point),
                impulse: 0.0,
                forgiven: 0.0,
                record: empty_record(contact),
                tally: Tally::default(),
            };
            let old = nearest(&before, contact);
            self.planes.push(self.follow(fresh, old, knots, body));
        }
        self.found = found;
        let n_found = self.planes.len();
        for old in &before {
            if nearest(&self.planes[..n_found], &old.record).is_none()
                && let Some(moved) = old.moved(knots, body)
                && self.is_real(&moved, knots, body, reach)
            {
                self.planes.push(self.follow(moved, Some(old), knots, body));
            }
        }
    }

    /// Whether a plane is still the surface of the target near the cable: within half the `reach` of its
    /// foot, and as far from the place as the part is. A cable that slid off an edge has the part beside it,
    /// and the plane above.
    fn is_real(&self, plane: &Plane, knots: &Knots, body: &Body, reach: f64) -> bool {
        let place = plane.record.at_place(&knots.position) - body.position;
        let in_body = body.attitude.inverse_transform_vector(&place);
        let radius = self.radius[plane.place().1.cable];
        let distance = -self.solids[plane.record.part].depth(&in_body) - radius;
        (in_body - plane.foot).norm() < 0.5 * reach && distance - plane.gap(&place, body) < radius
    }

    /// A plane that takes the place of an `old` one: what it finds deeper is forgiven.
    fn follow(&self, plane: Plane, old: Option<&Plane>, knots: &Knots, body: &Body) -> Plane {
        let forgiven = match self.response {
            Response::Impulse { .. } => 0.0,
            Response::Penalty { .. } => {
                let answered = old.map_or(0.0, |old| old.depth(knots, body));
                (plane.depth(knots, body) - answered).max(0.0)
            }
        };
        Plane { forgiven, impulse: old.map_or(0.0, |old| old.impulse), ..plane }
    }

    /// Answers the contacts of a (sub-)step of `step` seconds: changes velocities of knots and body,
    /// and marks the knots.
    pub fn answer(&mut self, knots: &mut Knots, body: &mut Body, step: f64, touched: &mut [bool]) {
        if self.planes.is_empty() {
            return;
        }
        self.find_acting(knots, body, step);
        if !self.acting.is_empty() {
            self.respond(knots, body, step, touched);
        }
    }

    fn respond(&mut self, knots: &mut Knots, body: &mut Body, step: f64, touched: &mut [bool]) {
        let mobility = self.mobility.at(body);
        let before = *body;
        match &self.response {
            Response::Impulse { .. } => {
                let own = self.rows.len();
                if let Some(preview) = &mut self.preview {
                    preview.add(knots, body, step, &mut self.rows);
                    self.scratch.clone_from(&knots.velocity);
                    let (velocity, mut ahead) = (&mut self.scratch, *body);
                    sequential::settle(
                        &mut self.rows,
                        velocity,
                        &self.inverse_mass,
                        &mut ahead,
                        &mobility,
                        Effort::AHEAD,
                    );
                    preview.remember(&self.rows[own..]);
                    self.rows.truncate(own);
                    for row in &self.rows {
                        let impulse = row.impulse * row.normal;
                        row.apply(&impulse, &mut knots.velocity, &self.inverse_mass, body, &mobility);
                    }
                } else {
                    sequential::settle(
                        &mut self.rows,
                        &mut knots.velocity,
                        &self.inverse_mass,
                        body,
                        &mobility,
                        Effort::WHOLE,
                    );
                }
            }
            Response::Penalty { force, .. } => {
                for (row, Acting { alone, .. }) in self.rows.iter_mut().zip(&self.acting) {
                    let depth = (-alone.gap).min(self.deepest[alone.knot]);
                    row.impulse = step * force.force(alone.knot, depth, -alone.speed());
                }
                for row in &self.rows {
                    let impulse = row.impulse * row.normal;
                    row.apply(&impulse, &mut knots.velocity, &self.inverse_mass, body, &mobility);
                }
            }
        }
        // Friction row by row at the velocities so far: it never turns a slip, so it only takes energy.
        if let Some(law) = &self.friction {
            for (row, Acting { alone, across, .. }) in self.rows.iter().zip(&mut self.acting) {
                let now = Row { velocity: row.velocity(&knots.velocity, body), ..*alone };
                *across = slowing_impulse(law, &now, &mobility, row.impulse);
                row.apply(across, &mut knots.velocity, &self.inverse_mass, body, &mobility);
            }
        }
        self.record(&before, body, touched);
    }

    /// Rows of the planes that would be crossed within the step.
    fn find_acting(&mut self, knots: &Knots, body: &Body, step: f64) {
        let turn = body.attitude.to_rotation_matrix();
        self.acting.clear();
        self.rows.clear();
        for (index, plane) in self.planes.iter_mut().enumerate() {
            let normal = turn * plane.normal;
            let ([(a, of_a), (b, of_b)], along) = plane.place();
            let from_centre = plane.record.at_place(&knots.position) - body.position;
            let gap = normal.dot(&from_centre) - plane.height;
            let radius = self.radius[along.cable];
            // Impulses act at the middle line: a cable cannot turn about it.
            let arm = from_centre;
            let place = plane.record.at_place(&knots.velocity);
            let velocity = place - body.velocity - body.rate.cross(&arm);
            plane.record.gap = plane.record.gap.min(gap);
            let inverse_mass = of_a * of_a * self.inverse_mass[a] + of_b * of_b * self.inverse_mass[b];
            // The engine's cables may draw in what is not yet coming.
            let margin = if self.preview.is_some() { step * velocity.norm().max(DRAWN_IN) } else { 0.0 };
            if gap >= margin && gap + step * normal.dot(&velocity) >= 0.0 {
                plane.impulse = 0.0;
                continue;
            }
            plane.forgiven *= 1.0 - step / self.push_out.max(step);
            let gap = gap + plane.forgiven;
            let row = Row { knot: a, inverse_mass, radius, normal, arm, gap, velocity };
            self.rows.push(SharedRow {
                knots: Bearers::Two([(a, of_a), (b, of_b)]),
                normal,
                arm: Some(arm),
                least: self.response.least_speed(&row, step, self.push_out),
                softness: 0.0,
                impulse: plane.impulse,
            });
            self.acting.push(Acting { plane: index, alone: row, across: Vector3::zeros() });
        }
    }

    /// Notes the impulses, while the body went from `before` to `after`.
    fn record(&mut self, before: &Body, after: &Body, touched: &mut [bool]) {
        for (row, Acting { plane, alone, across }) in self.rows.iter().zip(&self.acting) {
            let Plane { record, tally, impulse, .. } = &mut self.planes[*plane];
            *impulse = row.impulse;
            let whole = row.impulse * row.normal + across;
            if whole == Vector3::zeros() {
                continue;
            }
            for (knot, _) in record.bearers() {
                touched[knot] = true;
            }
            let turning = (before.rate + after.rate).cross(&alone.arm);
            let surface = 0.5 * (before.velocity + after.velocity + turning);
            record.point = before.position + alone.arm;
            record.normal = row.normal;
            record.impulse += row.impulse;
            record.friction += across;
            tally.add(&(row.impulse * row.normal), across, &surface);
        }
    }

    /// Adds the contacts within the step from `before` to `after` to `contacts`.
    pub fn report(&self, before: &Knots, after: &Knots, contacts: &mut Vec<Contact>) {
        for plane in self.planes.iter().filter(|plane| plane.record.gap.is_finite()) {
            let mut contact = plane.record;
            plane.tally.weigh(&mut contact, before, after);
            contacts.push(contact);
        }
    }

    /// Energy that forces hold where the cables are pressed in now [J].
    pub fn stored_energy(&self, knots: &Knots, body: &Body) -> f64 {
        let Response::Penalty { force, .. } = &self.response else { return 0.0 };
        let of = |plane: &Plane| {
            let (knot, depth) = (plane.record.knot, plane.depth(knots, body));
            // Beyond the deepest the force grows no more.
            let beyond = (depth - self.deepest[knot]).max(0.0);
            force.energy(knot, depth - beyond) + beyond * force.force(knot, self.deepest[knot], 0.0)
        };
        self.planes.iter().map(of).sum()
    }

    /// Number of colliders of the detector.
    pub fn n_colliders(&self) -> usize {
        self.detector.n_colliders()
    }
}

impl Response {
    /// Least speed of parting at the end of a step [m/s].
    fn least_speed(&self, row: &Row, step: f64, push_out: f64) -> f64 {
        let speed = row.speed();
        match self {
            Response::Impulse { restitution } if *restitution > 0.0 && speed < 0.0 => -restitution * speed,
            _ if row.gap >= 0.0 => -row.gap / step,
            _ => (-row.gap).min(row.radius) / push_out.max(step),
        }
    }
}

/// The plane before that stood nearest on the same cable and part.
fn nearest<'a>(before: &'a [Plane], contact: &Contact) -> Option<&'a Plane> {
    let place = contact.along.unwrap_or_default();
    let same = |plane: &&Plane| plane.place().1.cable == place.cable && plane.record.part == contact.part;
    let away = |plane: &Plane| (plane.place().1.share - place.share).abs();
    let nearest = before.iter().filter(same).min_by(|one, other| away(one).total_cmp(&away(other)));
    nearest.filter(|plane| away(plane) < SAME_CONTACT)
}

fn empty_record(contact: &Contact) -> Contact {
    let Contact { knot, along, part, .. } = *contact;
    Contact { knot, along, part, gap: f64::INFINITY, ..Contact::default() }
}
