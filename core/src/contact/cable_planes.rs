//! Planes of whole cables: found anew, and kept where one detection does not find them again.
//!
//! A cable touches at places between its knots. The engine's narrow phase finds them with capsules; each
//! becomes a plane that keeps the material place at share s of the cable outside. Both end knots bear the
//! impulse J of a place, by the lever rule: (1 − s) J and s J. The place answers with the inverse mass
//! (1 − s)² / m_a + s² / m_b; linear and angular momentum are kept, since the weighted mean of the
//! knots' positions is the place.
//!
//! The engine finds the one place of a cable that is nearest, the formula for a box that and the next edge. A cable that rests on two
//! edges touches at both: a place that is not found again is kept while it is near the surface that it touched, or the cable sinks
//! into one edge while the engine sees the other, and is pushed out of each in turn.
//!
//! A place that got inside is pushed out within a few milliseconds, not at once: planes found anew differ
//! a little from those carried along, and to undo that within a sub-step would shoot the cable off. So
//! would a force that answered such an overlap at once: what a plane is found with is left out first.

use std::sync::Arc;

use nalgebra::{Rotation3, Vector3};

use crate::cable::Cable;
use crate::net::Net;
use crate::solver::Precision;
use crate::state::{Along, Body, Contact, Knots};
use crate::target::Target;
use crate::target::curved::RidgeLine;
use crate::target::parts::ConvexPart;
use crate::world::{CableContacts, CableDetector, POINT_ERROR};

use super::plane::ContactPlane;
use super::row::NetMotion;

/// A place found anew within this share of the cable from one known before is the same.
const SAME_CONTACT: f64 = 0.1;

/// Sine of the angle up to which a cable lies along a face.
const ALONG: f64 = 0.05;

/// Finds planes of cables.
pub struct CablePlanes {
    detector: CableDetector,
    /// The target's parts in the body frame, and their ridges.
    solids: Vec<ConvexPart>,
    ridges: Vec<Vec<RidgeLine>>,
    cables: Arc<[Cable]>,
    /// Of each cable [m].
    radius: Vec<f64>,
    /// Cables of each knot.
    cables_of: Vec<Vec<usize>>,
    /// Whether overlaps are answered by a force.
    by_force: bool,
    /// Whether places slide along faces, and planes follow edges and round parts.
    slides: bool,
    /// Cables that are looked at in a detection, contacts of one and all planes before it; kept for their memory.
    moved: Vec<bool>,
    found: CableContacts,
    before: Vec<ContactPlane>,
}

impl CablePlanes {
    /// For the cables of `net` around `target`, found in the engine's `precision`, and answered `by_force` or not.
    pub fn new(
        net: &Net,
        target: &Target,
        precision: Precision,
        by_force: bool,
        slides: bool,
    ) -> CablePlanes {
        let mut cables_of = vec![Vec::new(); net.n_knots()];
        for (index, cable) in net.cables.iter().enumerate() {
            [cable.a, cable.b].into_iter().for_each(|knot| cables_of[knot].push(index));
        }
        CablePlanes {
            detector: CableDetector::new(net, target, precision),
            solids: target.parts.clone(),
            ridges: target.parts.iter().map(ConvexPart::ridge_lines).collect(),
            cables: Arc::clone(&net.cables),
            radius: (0..net.cables.len()).map(|cable| net.cable_radius(cable)).collect(),
            cables_of,
            by_force,
            slides,
            moved: vec![false; net.cables.len()],
            found: CableContacts::default(),
            before: Vec::new(),
        }
    }

    /// Of each cable [m].
    pub fn radii(&self) -> &[f64] {
        &self.radius
    }

    /// How far the cables at a knot reach from it, also when their other ends have moved away [m].
    pub fn reach(&self, knots: &Knots, knot: usize) -> f64 {
        let length = |&cable: &usize| {
            let Cable { a, b, rest_length, .. } = self.cables[cable];
            (knots.position[a] - knots.position[b]).norm().max(rest_length) + self.radius[cable]
        };
        self.cables_of[knot].iter().map(length).fold(0.0, f64::max)
    }

    /// Finds the planes within `margin` [m] of the cables at `renewed` knots anew; those that were and still are stay, and those of
    /// all other cables. Planes are in the order of cables, those just found first.
    pub fn detect(
        &mut self,
        renewed: &[(usize, Vector3<f64>)],
        knots: &Knots,
        body: &Body,
        margin: f64,
        planes: &mut Vec<ContactPlane>,
    ) {
        for (knot, _) in renewed {
            self.cables_of[*knot].iter().for_each(|&cable| self.moved[cable] = true);
        }
        let mut before = std::mem::replace(planes, std::mem::take(&mut self.before));
        let mut rest = before.as_slice();
        let to_body = body.all_to_body();
        for cable in 0..self.cables.len() {
            let n_old = rest.iter().take_while(|plane| plane.along().cable == cable).count();
            let (old, others) = rest.split_at(n_old);
            rest = others;
            if std::mem::take(&mut self.moved[cable]) {
                let Cable { a, b, .. } = self.cables[cable];
                let ends = [to_body(&knots.position[a]), to_body(&knots.position[b])];
                self.detect_one(cable, &ends, old, margin, planes);
            } else {
                planes.extend_from_slice(old);
            }
        }
        before.clear();
        self.before = before;
    }

    /// The planes of a cable with its `ends` in the body frame [m], which had `old` ones.
    fn detect_one(
        &mut self,
        cable: usize,
        ends: &[Vector3<f64>; 2],
        old: &[ContactPlane],
        margin: f64,
        planes: &mut Vec<ContactPlane>,
    ) {
        self.detector.look(cable, *ends, margin, &mut self.found);
        let first = planes.len();
        for contact in &self.found.touching {
            planes.push(self.follow(self.plane(contact, ends), nearest(old, contact), ends));
        }
        let n_found = planes.len();
        if self.slides {
            planes.extend(self.found.waiting.iter().filter_map(|contact| self.waiting(contact, ends)));
        }
        let n_with_waiting = planes.len();
        for old in old {
            if !old.waits
                && nearest(&planes[first..n_found], &old.record).is_none()
                // Of what is round, and of an edge, one place of a cable is nearest.
                && !self.is_followed(old, &planes[first..n_with_waiting])
                && let Some(moved) = self.moved(old, ends)
                && self.is_real(&moved, ends, margin)
            {
                let mut plane = self.follow(moved, Some(old), ends);
                self.slide(&mut plane, ends);
                planes.push(plane);
            }
        }
    }

    /// Moves the foot of a plane below its place, where the cable lies along a flat face and is still on it: as it slides over
    /// the face, it takes its places along.
    fn slide(&self, plane: &mut ContactPlane, ends: &[Vector3<f64>; 2]) {
        if !self.slides || !lies_along(plane, ends) {
            return;
        }
        let place = place(plane, ends);
        let height = gap(plane, ends) + plane.radius;
        let below = place - height * plane.normal;
        if self.solids[plane.record.part].depth(&below) > -POINT_ERROR {
            plane.foot = below;
        }
    }

    /// Whether a plane is on a ridge of a part that one of `found`, of the same cable, is followed along.
    fn is_followed(&self, plane: &ContactPlane, found: &[ContactPlane]) -> bool {
        let same =
            |other: &ContactPlane| other.record.part == plane.record.part && other.ridge == plane.ridge;
        self.slides && plane.ridge.is_some() && found.iter().any(same)
    }

    /// Within a step of `step` seconds: takes a plane on a round part or on an edge along to where its cable is nearest now, or on an edge will be;
    /// it waits where its cable does not pass the edge. `turn` is the attitude of `body`.
    ///
    /// A knot that swings round an edge takes its cable across within a step: 2 mm of it, at 4 m/s under joints.
    pub fn follow_ridge(
        &self,
        plane: &mut ContactPlane,
        net: &impl NetMotion,
        body: &Body,
        turn: &Rotation3<f64>,
        step: f64,
    ) {
        let Some(line) = self.ridge_line(plane) else { return };
        let moving = [plane.record.knot, plane.along().end].map(|knot| {
            let arm = net.position(knot) - body.position;
            (arm, net.velocity(knot) - body.velocity - body.rate.cross(&arm))
        });
        // In the body frame, so many seconds from now.
        let ends =
            |time: f64| moving.map(|(arm, velocity)| turn.inverse_transform_vector(&(arm + time * velocity)));
        let now = ends(0.0);
        if self.by_force {
            // A force has many sub-steps, each shorter than what comes from farther away takes.
            plane.waits &= gap(plane, &now) > plane.radius || !take_along(plane, line, &now);
        } else if line.is_edge() {
            let passes =
                take_along(plane, line, &ends(step)) || !plane.waits && take_along(plane, line, &now);
            plane.waits = !passes && plane.is_ahead;
        } else {
            take_along(plane, line, &now);
        }
    }

    /// What a plane is followed along, if it is.
    fn ridge_line(&self, plane: &ContactPlane) -> Option<&RidgeLine> {
        plane.ridge.filter(|_| self.slides).map(|ridge| &self.ridges[plane.record.part][ridge])
    }

    /// The plane of an edge ahead of a cable; none of what has no edges.
    fn waiting(&self, contact: &Contact, ends: &[Vector3<f64>; 2]) -> Option<ContactPlane> {
        let along = contact.along?;
        let mut plane = self.plane(contact, ends);
        plane.record.along = Some(Along { share: along.share.clamp(0.0, 1.0), ..along });
        (plane.is_ahead, plane.waits) = (true, true);
        plane.ridge = Some(self.solids[contact.part].edge_at(&contact.point)?);
        Some(plane)
    }

    fn plane(&self, contact: &Contact, ends: &[Vector3<f64>; 2]) -> ContactPlane {
        let along = contact.along.unwrap_or_default();
        let place = ends[0] + along.share * (ends[1] - ends[0]);
        let height = contact.normal.dot(&place) - contact.gap;
        let radius = self.radius[along.cable];
        let ridge = self.ridge(contact);
        let mut plane = ContactPlane::new(contact, contact.normal, height, radius, contact.point);
        plane.ridge = ridge;
        plane
    }

    /// The ridge that a contact is on, in the body frame.
    fn ridge(&self, contact: &Contact) -> Option<usize> {
        self.solids[contact.part].ridge(&contact.normal)
    }

    /// Whether a plane is still the surface of the target near the cable: within half the `margin` of its
    /// foot, and as far from the place as the part is. A cable that slid off an edge has the part beside it,
    /// and the plane above. But one that lies straight below a face has the next face beside it where it comes out: there it
    /// counts where the cable is deepest, or it would be held at one end and at the other in turn, and sink.
    fn is_real(&self, plane: &ContactPlane, ends: &[Vector3<f64>; 2], margin: f64) -> bool {
        let in_body = place(plane, ends);
        if (in_body - plane.foot).norm() >= 0.5 * margin {
            return false;
        }
        let part = &self.solids[plane.record.part];
        let is_so_deep = |depth: f64, place: &Vector3<f64>| {
            let gap = plane.normal.dot(place) - plane.height;
            -depth - plane.radius - gap < plane.radius
        };
        let below_a_face = || {
            let [from, to] = ends;
            lies_along(plane, ends) && {
                let (share, depth) = part.deepest_at(from, to);
                is_so_deep(depth, &(from + share * (to - from)))
            }
        };
        is_so_deep(part.depth(&in_body), &in_body) || self.slides && below_a_face()
    }

    /// The same plane for where the cable is nearest to its foot now, or, where it lies below a face, for the place of it there that
    /// is nearest; none where that is a knot.
    fn moved(&self, plane: &ContactPlane, [from, to]: &[Vector3<f64>; 2]) -> Option<ContactPlane> {
        let along = plane.along();
        let across = to - from;
        let share = across.dot(&(plane.foot - from)) / across.norm_squared();
        let part = &self.solids[plane.record.part];
        let over = if self.slides { part.over_face(&plane.normal, from, to) } else { None };
        let share = over.map_or(share, |[first, last]| share.clamp(first, last));
        (0.0..=1.0).contains(&share).then(|| plane.moved_to(Along { share, ..along }))
    }

    /// A plane that takes the place of an `old` one: no force answers what it finds deeper.
    fn follow(
        &self,
        mut plane: ContactPlane,
        old: Option<&ContactPlane>,
        ends: &[Vector3<f64>; 2],
    ) -> ContactPlane {
        if self.by_force {
            let depth = |plane: &ContactPlane| (-gap(plane, ends) - plane.initial_overlap).max(0.0);
            plane.initial_overlap = (depth(&plane) - old.map_or(0.0, depth)).max(0.0);
        }
        plane.impulse = old.map_or(0.0, |old| old.impulse);
        plane
    }

    /// Number of colliders of the detector.
    pub fn n_colliders(&self) -> usize {
        self.detector.n_colliders()
    }
}

/// The place at a plane of a cable with its ends in the body frame [m].
fn place(plane: &ContactPlane, [from, to]: &[Vector3<f64>; 2]) -> Vector3<f64> {
    from + plane.along().share * (to - from)
}

/// How far that is from the plane [m].
fn gap(plane: &ContactPlane, ends: &[Vector3<f64>; 2]) -> f64 {
    plane.normal.dot(&place(plane, ends)) - plane.height
}

/// Takes a plane to where a cable with its ends in the body frame is nearest to its ridge; whether it is there.
fn take_along(plane: &mut ContactPlane, line: &RidgeLine, [from, to]: &[Vector3<f64>; 2]) -> bool {
    let nearest = line.nearest(&plane.normal, from, to);
    // One that has come through the part's middle would be drawn through the rest.
    let Some(nearest) = nearest.filter(|nearest| nearest.normal.dot(&plane.normal) > 0.0) else {
        return false;
    };
    plane.foot = nearest.foot;
    plane.normal = nearest.normal;
    plane.height = nearest.normal.dot(&nearest.foot) + plane.radius;
    plane.record.along = Some(Along { share: nearest.share, ..plane.along() });
    true
}

/// Whether a cable from one end to the other, in the body frame, lies along a plane.
fn lies_along(plane: &ContactPlane, [from, to]: &[Vector3<f64>; 2]) -> bool {
    let across = to - from;
    plane.normal.dot(&across).abs() < ALONG * across.norm()
}

/// Of the `planes` of a cable that which stands nearest to a contact of it, on the same part.
fn nearest<'a>(planes: &'a [ContactPlane], contact: &Contact) -> Option<&'a ContactPlane> {
    let share = contact.along.unwrap_or_default().share;
    let same = |plane: &&ContactPlane| plane.record.part == contact.part;
    let away = |plane: &ContactPlane| (plane.along().share - share).abs();
    let nearest = planes.iter().filter(same).min_by(|one, other| away(one).total_cmp(&away(other)));
    nearest.filter(|plane| away(plane) < SAME_CONTACT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::schedule::{Detection, DetectionSchedule};
    use crate::contact::surface::CABLES_STALE;
    use crate::limits::Limits;
    use crate::problems::Problems;
    use crate::target::files::Files;
    use nalgebra::{UnitQuaternion, vector};
    use serde_json::json;

    fn net_and_target() -> (Net, Target) {
        let mut problems = Problems::new("test");
        let net = json!({ "meshes": [1, 1], "mesh_length_m": 0.2, "bullet_mass_kg": 0.03,
            "cable": { "material": "nylon", "diameter_m": 0.001 } });
        let launch = json!({ "speed_m_s": 1.8, "angle_deg": 25.0 });
        let net = Net::build(
            &serde_json::from_value(net).unwrap(),
            &serde_json::from_value(launch).unwrap(),
            &mut problems,
        );
        let target = json!({ "distance_m": 1.0, "mass_kg": 3.5, "shape": { "parts": [
            { "cuboid": [0.1, 0.3, 0.1] },
            { "cylinder": { "radius_m": 0.04, "length_m": 0.2 }, "position_m": [0.15, 0.0, 0.0] },
            { "ball": { "radius_m": 0.05 }, "position_m": [0.0, 0.25, 0.0] },
        ] } });
        let limits = Limits::default();
        let files = Files::of(None, &limits);
        let target = Target::build(&serde_json::from_value(target).unwrap(), &files, "target", &mut problems);
        assert_eq!(problems.list, vec![]);
        (net.unwrap(), target.unwrap())
    }

    /// Of a net that flutters about a turning target, cables whose ends hardly moved are not looked at again, and all the same
    /// whatever all cables looked at anew would find within reach of a step has its plane.
    #[test]
    fn what_may_be_touched_within_a_step_has_its_plane() {
        const STEP: f64 = 5e-4;
        let (net, target) = net_and_target();
        let make = || CablePlanes::new(&net, &target, Precision::F64, false, true);
        let (mut cables, mut anew) = (make(), make());
        let mut schedule = DetectionSchedule::new(4e-3, &target.parts, target.bounding_radius, CABLES_STALE);
        let (mut planes, mut all) = (Vec::new(), Vec::new());
        let (mut n_within_reach, mut n_looked, mut n_steps) = (0, 0, 0);
        let n_side = net.grid[0];
        for step in 0..40_000 {
            let time = f64::from(step) * STEP;
            let body = Body {
                attitude: UnitQuaternion::from_scaled_axis(0.7 * time * vector![0.2, 1.0, 0.4].normalize()),
                rate: 0.7 * vector![0.2, 1.0, 0.4].normalize(),
                ..Body::at_rest()
            };
            // A sheet that sways through the target's surface, each knot in its own time.
            let of_knot = |knot: usize| {
                let [i, j] = [knot / n_side, knot % n_side].map(|n| n as f64 - 0.5 * (n_side - 1) as f64);
                let (pace, phase) = (1.5 + 0.2 * (knot % 7) as f64, knot as f64);
                let at = vector![0.1 + 0.08 * (pace * time + phase).sin(), 0.2 * i, 0.2 * j];
                (at, vector![0.08 * pace * (pace * time + phase).cos(), 0.0, 0.0])
            };
            let (position, velocity) = (0..net.n_knots()).map(of_knot).unzip();
            let knots = Knots { position, velocity };
            match schedule.update(&knots, &body, STEP) {
                Detection::Separated => planes.clear(),
                Detection::Cached => {}
                Detection::Stale(margin) => {
                    let renewed = schedule.renew(&knots, &body, margin, |knot| cables.reach(&knots, knot));
                    n_looked += renewed.len();
                    cables.detect(renewed, &knots, &body, margin, &mut planes);
                    for (knot, _) in planes.iter().flat_map(|plane| plane.record.bearers()) {
                        schedule.found_cable(knot);
                    }
                }
            }
            n_steps += 1;
            let everywhere: Vec<_> = (0..net.n_knots()).map(|knot| (knot, Vector3::zeros())).collect();
            all.clear();
            anew.detect(&everywhere, &knots, &body, 4e-3, &mut all);
            for plane in &all {
                let ends =
                    [plane.record.knot, plane.along().end].map(|knot| body.to_body(&knots.position[knot]));
                // What is inside has no nearest place that moves as it does.
                let is_outside =
                    target.parts.iter().all(|part| part.deepest_between(&ends[0], &ends[1]) < 0.0);
                // At a knot it is the knot's business.
                let is_between = (1e-3..0.999).contains(&plane.along().share);
                if is_outside && is_between && gap(plane, &ends) < schedule.thrown() {
                    n_within_reach += 1;
                    let known = planes.iter().any(|known: &ContactPlane| {
                        known.along().cable == plane.along().cable && known.record.part == plane.record.part
                    });
                    assert!(known, "step {step}, cable {}", plane.along().cable);
                }
            }
        }
        assert!(n_within_reach > 100, "{n_within_reach}");
        let share = n_looked as f64 / (n_steps * net.n_knots()) as f64;
        assert!(share < 0.3, "{share} of the knots are looked at in a step");
    }
}
