//! A contact between two detections: a plane that is fixed to the target and moves and turns with it.
//!
//! A plane stands for the surface near a knot, or near a place on a cable: past an edge it goes on by at most
//! half the margin of detection, and on a curved part of radius R the knot floats by up to margin² / (8 R).

use nalgebra::{Rotation3, Vector3};

use super::row::{ContactRow, JacobianWeights, NetMotion, Parting};
use super::work::ContactWork;
use crate::state::{Along, Body, Contact, Knots};

/// A piece of the target's surface near a knot or a cable, in the body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPlane {
    /// Unit normal, towards the net.
    pub normal: Vector3<f64>,
    /// Distance of a touching knot's centre, or of a touching cable's middle line, from the target's centre of
    /// mass, along the normal [m].
    pub height: f64,
    /// Radius of the knot or the cable [m].
    pub radius: f64,
    /// Where the target is touched, from its centre of mass [m]; of cables only.
    pub foot: Vector3<f64>,
    /// Which of its part's ridges it is on, where a cable is followed along it.
    pub ridge: Option<usize>,
    /// Whether its cable did not pass that ridge when it was found, and might come to.
    pub is_ahead: bool,
    /// Whether it still does not, so that there is nothing to keep out.
    pub waits: bool,
    /// Impulse within the last sub-step [N s].
    pub impulse: f64,
    /// Of that, what was given before it was answered again [N s].
    pub given: f64,
    /// Speed of parting that is to be foreseen beyond what is wanted, for want of it [m/s].
    pub lacking: f64,
    /// Overlap that it was found with and that no force answers, on its way to zero [m].
    pub initial_overlap: f64,
    /// Of a force: fastest approach within this overlap so far [m/s].
    pub fastest: f64,
    /// Which knot or cable, which part, and what happened within the step.
    pub record: Contact,
    work: ContactWork,
    /// Whether its impulses within the step had more than one direction.
    has_turned: bool,
}

/// A place of the net that might cross a plane within the (sub-)step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceAtPlane {
    /// Normal of the plane, local frame.
    pub normal: Vector3<f64>,
    /// The place, from the target's centre of mass [m].
    pub arm: Vector3<f64>,
    /// Gap now [m].
    pub gap: f64,
    /// Velocity relative to the plane [m/s].
    pub velocity: Vector3<f64>,
    /// Its part along the normal [m/s].
    pub speed: f64,
}

/// Motion of the target's surface while contacts act: the mean of before and after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMotion {
    velocity: Vector3<f64>,
    rate: Vector3<f64>,
}

/// When a row is needed, and what it is to reach.
#[derive(Clone, Copy, Debug)]
pub struct RowRules {
    /// What is wanted at the end of the step.
    pub parting: Parting,
    /// Speed that the engine's cables may give a place within a step [m/s]: nearer than that, it has a row.
    pub drawn_in: Option<f64>,
}

impl SurfaceMotion {
    /// While the body went from `before` to `after`.
    pub fn between(before: &Body, after: &Body) -> SurfaceMotion {
        SurfaceMotion {
            velocity: 0.5 * (before.velocity + after.velocity),
            rate: 0.5 * (before.rate + after.rate),
        }
    }

    /// Velocity at `arm` from the centre [m/s].
    #[inline]
    fn at(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.rate.cross(arm)
    }
}

impl ContactPlane {
    /// The plane of `contact` with `normal`, `height` and `foot` in the body frame.
    pub fn new(
        contact: &Contact,
        normal: Vector3<f64>,
        height: f64,
        radius: f64,
        foot: Vector3<f64>,
    ) -> ContactPlane {
        ContactPlane {
            normal,
            height,
            radius,
            foot,
            ridge: None,
            is_ahead: false,
            waits: false,
            impulse: 0.0,
            given: 0.0,
            lacking: 0.0,
            initial_overlap: 0.0,
            fastest: 0.0,
            record: empty_record(contact),
            work: ContactWork::default(),
            has_turned: false,
        }
    }

    /// Where the contact is on its cable.
    pub fn along(&self) -> Along {
        self.record.along.unwrap_or_default()
    }

    /// The same plane for another place on its cable, without what happened at the old one.
    pub fn moved_to(&self, along: Along) -> ContactPlane {
        ContactPlane {
            record: empty_record(&Contact { along: Some(along), ..self.record }),
            work: ContactWork::default(),
            has_turned: false,
            initial_overlap: 0.0,
            ..*self
        }
    }

    /// Forgets the step before.
    pub fn begin_step(&mut self) {
        self.record = empty_record(&self.record);
        (self.given, self.lacking) = (0.0, 0.0);
        self.work = ContactWork::default();
        self.has_turned = false;
    }

    /// Gap of a net at `place` from the body's centre [m].
    pub fn gap(&self, place: &Vector3<f64>, body: &Body) -> f64 {
        (body.attitude * self.normal).dot(place) - self.height
    }

    /// Overlap that is answered, so many seconds before the end of a step [m]. Contact forces change velocities first
    /// and positions with them: velocities are those of the middle of a (sub-)step, and what is held then is
    /// what goes with their kinetic energy.
    pub fn depth(&self, knots: &Knots, body: &Body, earlier: f64) -> f64 {
        let place = self.record.at_place(&knots.position) - body.position;
        let velocity = self.record.at_place(&knots.velocity) - body.velocity - body.rate.cross(&place);
        let gap = self.gap(&place, body) - earlier * (body.attitude * self.normal).dot(&velocity);
        (-gap - self.initial_overlap).max(0.0)
    }

    /// At the start of a step: whether its knot, or all of its cable, is farther before it than a `reach` [m]; `turn` is the attitude of `body`.
    #[inline]
    pub fn is_beyond(&mut self, reach: f64, knots: &Knots, body: &Body, turn: &Rotation3<f64>) -> bool {
        let normal = turn * self.normal;
        let gap = |knot: usize| normal.dot(&(knots.position[knot] - body.position)) - self.height;
        let [(knot, share), (end, of_end)] = self.record.bearers();
        let gaps = [gap(knot), gap(end)];
        let is_beyond = gaps.iter().all(|gap| *gap > reach);
        if is_beyond {
            self.record.gap = share * gaps[0] + of_end * gaps[1];
            (self.impulse, self.fastest) = (0.0, 0.0);
        }
        is_beyond
    }

    /// Whether all of its cable stays before it within a (sub-)step of `step` seconds: then no plane of the same part is crossed there.
    #[inline]
    pub fn is_clear(&mut self, net: &impl NetMotion, body: &Body, turn: &Rotation3<f64>, step: f64) -> bool {
        let normal = turn * self.normal;
        let mut at_place = 0.0;
        for (knot, share) in self.record.bearers() {
            let arm = net.position(knot) - body.position;
            let gap = normal.dot(&arm) - self.height;
            let speed = normal.dot(&(net.velocity(knot) - body.velocity - body.rate.cross(&arm)));
            if gap < 0.0 || gap + step * speed < 0.0 {
                return false;
            }
            at_place += share * gap;
        }
        self.record.gap = self.record.gap.min(at_place);
        (self.impulse, self.fastest) = (0.0, 0.0);
        true
    }

    /// The place before it in a (sub-)step of `step` seconds, where it might be crossed within it; `turn` is the
    /// attitude of `body`. Most planes need no row: a row is five times as large, and made after this.
    #[inline]
    pub fn predict(
        &mut self,
        net: &impl NetMotion,
        body: &Body,
        turn: &Rotation3<f64>,
        step: f64,
        drawn_in: Option<f64>,
    ) -> Option<PlaceAtPlane> {
        let (normal, weights) = (turn * self.normal, self.weights());
        // normal · (x − surface point) − radius, the surface point in the body frame.
        let arm = weights.sum(|knot| net.position(knot)) - body.position;
        let gap = normal.dot(&arm) - self.height;
        let velocity = weights.sum(|knot| net.velocity(knot)) - body.velocity - body.rate.cross(&arm);
        let speed = normal.dot(&velocity);
        self.record.gap = self.record.gap.min(gap);
        let margin = drawn_in.map_or(0.0, |drawn_in| step * velocity.norm().max(drawn_in));
        if gap >= margin && gap + step * speed >= 0.0 && self.lacking == 0.0 {
            (self.impulse, self.fastest) = (self.given, 0.0);
            return None;
        }
        Some(PlaceAtPlane { normal, arm, gap, velocity, speed })
    }

    /// Its row for a `place` that might cross it.
    #[inline]
    pub fn row(
        &mut self,
        place: &PlaceAtPlane,
        net: &impl NetMotion,
        body: &Body,
        [last, step]: [f64; 2],
        parting: &Parting,
    ) -> ContactRow {
        let PlaceAtPlane { normal, arm, velocity, speed, .. } = *place;
        let weights = self.weights();
        let speed_before = if parting.restitution > 0.0 {
            let before = weights.sum(|knot| net.velocity_before(knot));
            normal.dot(&(before - body.velocity - body.rate.cross(&arm)))
        } else {
            speed
        };
        let pressed = self.impulse / last;
        if self.initial_overlap > 0.0 {
            let speed = parting.push_out.speed(self.initial_overlap, self.radius, pressed, step);
            self.initial_overlap -= step * speed;
        }
        let gap = place.gap + self.initial_overlap;
        // What cables may yet draw in within the step does not bounce before it is there.
        let meets = gap < 0.0 || gap + step * speed < 0.0;
        let speeds = if meets { [speed_before, speed] } else { [0.0; 2] };
        ContactRow {
            weights,
            inverse_mass: weights.inverse_mass(net),
            radius: self.radius,
            normal,
            arm: Some(arm),
            gap,
            velocity,
            speed,
            wanted_speed: self.lacking + parting.wanted_speed(gap, speeds, self.radius, pressed, step),
            bounces: parting.bounces(gap, speeds, self.radius),
            softness: 0.0,
            impulse: self.impulse,
            friction: Vector3::zeros(),
        }
    }

    /// Speed at which a force may have a `place` part, at most, where hits up to a speed are `resolved` [m/s]: one that is faster gives
    /// back no more than it came with. A step too long for it finds it deep inside at once, and a knot that a thread had whipped
    /// to 40 m/s left at 200, and the next hit was beyond all numbers.
    pub fn most_parting(&mut self, place: &PlaceAtPlane, resolved: f64) -> f64 {
        self.fastest = if place.gap >= 0.0 { 0.0 } else { self.fastest.max(-place.speed) };
        if self.fastest > resolved { self.fastest } else { f64::INFINITY }
    }

    #[inline]
    fn weights(&self) -> JacobianWeights {
        match self.record.along {
            None => JacobianWeights::of_knot(self.record.knot),
            Some(_) => JacobianWeights::Two(self.record.bearers()),
        }
    }

    /// Adds the impulses of its `row`, of a body that was at `centre` and whose mean motion was `surface`.
    #[inline]
    pub fn add(&mut self, row: &ContactRow, centre: &Vector3<f64>, surface: &SurfaceMotion) {
        let arm = row.arm.unwrap_or_default();
        let (point, record) = (centre + arm, &mut self.record);
        self.has_turned |= record.impulse > 0.0 && record.normal != row.normal;
        record.normal = row.normal;
        record.impulse += row.impulse;
        record.moment += point.cross(&row.whole_impulse());
        // The mean over the sub-steps, so that impulse and moment agree.
        if record.impulse > 0.0 {
            record.point += (row.impulse / record.impulse) * (point - record.point);
        }
        record.friction += row.friction;
        self.work.add(&(row.impulse * row.normal), &row.friction, &surface.at(&arm));
    }

    /// Weighs what `row` gave by the mean velocity of the net over the sub-step [m/s].
    pub fn weigh(&mut self, row: &ContactRow, mean: &Vector3<f64>) {
        self.work.weigh(&(row.impulse * row.normal), &row.friction, mean);
    }

    /// The contact within the step from `before` to `after`, if there was a sub-step in which it was looked at.
    pub fn contact(&self, before: &Knots, after: &Knots) -> Option<Contact> {
        self.record.gap.is_finite().then(|| {
            let mut contact = self.record;
            if self.has_turned {
                // The target turned between sub-steps, and their impulses with it: their sum, not their lengths'.
                (contact.normal, contact.impulse) =
                    self.work.mean_normal().unwrap_or((contact.normal, contact.impulse));
            }
            if self.work != ContactWork::default() {
                self.work.write_to(&mut contact, before, after);
            }
            contact
        })
    }
}

fn empty_record(contact: &Contact) -> Contact {
    let Contact { knot, along, body, part, .. } = *contact;
    Contact { knot, along, body, part, gap: f64::INFINITY, ..Contact::default() }
}
