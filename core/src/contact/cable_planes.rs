//! Planes of whole cables: found anew, and kept where one detection does not find them again.
//!
//! A cable touches at places between its knots. The engine's narrow phase finds them with capsules; each
//! becomes a plane that keeps the material place at share s of the cable outside. Both end knots bear the
//! impulse J of a place, by the lever rule: (1 − s) J and s J. The place answers with the inverse mass
//! (1 − s)² / m_a + s² / m_b; linear and angular momentum are kept, since the weighted mean of the
//! knots' positions is the place.
//!
//! The engine finds the one place of a cable that is nearest. A cable that rests on two edges touches at both:
//! a place that is not found again is kept while it is near the surface that it touched, or the cable sinks
//! into one edge while the engine sees the other, and is pushed out of each in turn.
//!
//! A place that got inside is pushed out within a few milliseconds, not at once: planes found anew differ
//! a little from those carried along, and to undo that within a sub-step would shoot the cable off. So
//! would a force that answered such an overlap at once: what a plane is found with is left out first.

use nalgebra::Vector3;

use crate::net::Net;
use crate::solver::Precision;
use crate::state::{Along, Body, Contact, Knots, State};
use crate::target::Target;
use crate::target::curved::Ridge;
use crate::target::parts::ConvexPart;
use crate::world::{CableDetector, POINT_ERROR};

use super::plane::ContactPlane;
use super::row::NetMotion;

/// A place found anew within this share of the cable from one known before is the same.
const SAME_CONTACT: f64 = 0.1;

/// Sine of the angle up to which a cable lies along a face.
const ALONG: f64 = 0.05;

/// Finds planes of cables.
pub struct CablePlanes {
    detector: CableDetector,
    /// The target's parts in the body frame.
    solids: Vec<ConvexPart>,
    /// Of each cable [m].
    radius: Vec<f64>,
    /// Whether overlaps are answered by a force.
    by_force: bool,
    /// Whether places slide along faces, and planes follow edges and round parts.
    slides: bool,
    /// Contacts and planes of a detection; kept for their memory.
    found: Vec<Contact>,
    before: Vec<ContactPlane>,
    /// How many planes the last detection found: they come first, in the order of cables, and those kept after them.
    n_found: usize,
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
        CablePlanes {
            detector: CableDetector::new(net, target, precision),
            solids: target.parts.clone(),
            radius: (0..net.cables.len()).map(|cable| net.cable_radius(cable)).collect(),
            by_force,
            slides,
            found: Vec::new(),
            before: Vec::new(),
            n_found: 0,
        }
    }

    /// Finds all planes within `margin` [m] anew; those that were and still are stay.
    pub fn detect(&mut self, state: &State, body: &Body, margin: f64, planes: &mut Vec<ContactPlane>) {
        let knots = &state.knots;
        self.detector.detect(state, body, margin, &mut self.found);
        self.before.clear();
        self.before.append(planes);
        let (ordered, kept) = self.before.split_at(self.n_found.min(self.before.len()));
        for contact in &self.found {
            let old = nearest(of_cable(ordered, contact).iter().chain(kept), contact);
            planes.push(self.follow(self.plane(contact, knots, body), old, knots, body));
        }
        self.n_found = planes.len();
        for old in &self.before {
            let found = of_cable(&planes[..self.n_found], &old.record);
            if nearest(found, &old.record).is_none()
                // Of what is round, and of an edge, one place of a cable is nearest.
                && !self.is_followed(old, found)
                && let Some(moved) = self.moved(old, knots, body)
                && self.is_real(&moved, knots, body, margin)
            {
                let mut plane = self.follow(moved, Some(old), knots, body);
                self.slide(&mut plane, knots, body);
                planes.push(plane);
            }
        }
    }

    /// Moves the foot of a plane below its place, where the cable lies along a flat face and is still on it: as it slides over
    /// the face, it takes its places along.
    fn slide(&self, plane: &mut ContactPlane, knots: &Knots, body: &Body) {
        if !self.slides || !lies_along(plane, &ends(plane, |knot| knots.position[knot], body)) {
            return;
        }
        let place = plane.record.at_place(&knots.position);
        let height = plane.gap(&(place - body.position), body) + plane.radius;
        let below = body.to_body(&place) - height * plane.normal;
        if self.solids[plane.record.part].depth(&below) > -POINT_ERROR {
            plane.foot = below;
        }
    }

    /// Whether a plane is on a ridge of a part that one of `found`, of the same cable, is followed along.
    fn is_followed(&self, plane: &ContactPlane, found: &[ContactPlane]) -> bool {
        let ridge = self.ridge(plane);
        let same =
            |other: &ContactPlane| other.record.part == plane.record.part && self.ridge(other) == ridge;
        self.slides && ridge.is_some() && found.iter().any(same)
    }

    /// The ridge that a plane follows.
    fn ridge(&self, plane: &ContactPlane) -> Option<Ridge> {
        self.solids[plane.record.part].ridge(&plane.normal)
    }

    /// Within a step: takes planes on round parts and on edges along to where their cables are nearest now.
    pub fn follow_ridges(&self, planes: &mut [ContactPlane], net: &impl NetMotion, body: &Body) {
        if !self.slides {
            return;
        }
        let gap = |plane: &ContactPlane| {
            let [(a, u), (b, v)] = plane.record.bearers();
            plane.gap(&(u * net.position(a) + v * net.position(b) - body.position), body)
        };
        for plane in planes {
            // A force has many sub-steps, each shorter than what comes from farther away takes.
            if self.by_force && gap(plane) > plane.radius {
                continue;
            }
            let Some(ridge) = self.ridge(plane) else { continue };
            let [from, to] = ends(plane, |knot| net.position(knot), body);
            let part = &self.solids[plane.record.part];
            let Some(nearest) = part.nearest_on(ridge, &plane.normal, &from, &to) else { continue };
            // One that has come through the part's middle would be drawn through the rest.
            if nearest.normal.dot(&plane.normal) > 0.0 {
                plane.foot = nearest.foot;
                plane.normal = nearest.normal;
                plane.height = nearest.normal.dot(&nearest.foot) + plane.radius;
                plane.record.along = Some(Along { share: nearest.share, ..plane.along() });
            }
        }
    }

    fn plane(&self, contact: &Contact, knots: &Knots, body: &Body) -> ContactPlane {
        let place = contact.at_place(&knots.position) - body.position;
        let normal = body.attitude.inverse_transform_vector(&contact.normal);
        let height = contact.normal.dot(&place) - contact.gap;
        let radius = self.radius[contact.along.unwrap_or_default().cable];
        ContactPlane::new(contact, normal, height, radius, body.to_body(&contact.point))
    }

    /// Whether a plane is still the surface of the target near the cable: within half the `margin` of its
    /// foot, and as far from the place as the part is. A cable that slid off an edge has the part beside it,
    /// and the plane above. But one that lies straight below a face has the next face beside it where it comes out: there it
    /// counts where the cable is deepest, or it would be held at one end and at the other in turn, and sink.
    fn is_real(&self, plane: &ContactPlane, knots: &Knots, body: &Body, margin: f64) -> bool {
        let in_body = body.to_body(&plane.record.at_place(&knots.position));
        if (in_body - plane.foot).norm() >= 0.5 * margin {
            return false;
        }
        let part = &self.solids[plane.record.part];
        let is_so_deep = |depth: f64, place: &Vector3<f64>| {
            let gap = plane.normal.dot(place) - plane.height;
            -depth - plane.radius - gap < plane.radius
        };
        let below_a_face = || {
            let [from, to] = ends(plane, |knot| knots.position[knot], body);
            lies_along(plane, &[from, to]) && {
                let (share, depth) = part.deepest_at(&from, &to);
                is_so_deep(depth, &(from + share * (to - from)))
            }
        };
        is_so_deep(part.depth(&in_body), &in_body) || self.slides && below_a_face()
    }

    /// The same plane for where the cable is nearest to its foot now, or, where it lies below a face, for the place of it there that
    /// is nearest; none where that is a knot.
    fn moved(&self, plane: &ContactPlane, knots: &Knots, body: &Body) -> Option<ContactPlane> {
        let along = plane.along();
        let [from, to] = ends(plane, |knot| knots.position[knot], body);
        let across = to - from;
        let share = across.dot(&(plane.foot - from)) / across.norm_squared();
        let part = &self.solids[plane.record.part];
        let over = if self.slides { part.over_face(&plane.normal, &from, &to) } else { None };
        let share = over.map_or(share, |[first, last]| share.clamp(first, last));
        (0.0..=1.0).contains(&share).then(|| plane.moved_to(Along { share, ..along }))
    }

    /// A plane that takes the place of an `old` one: no force answers what it finds deeper.
    fn follow(
        &self,
        mut plane: ContactPlane,
        old: Option<&ContactPlane>,
        knots: &Knots,
        body: &Body,
    ) -> ContactPlane {
        if self.by_force {
            let answered = old.map_or(0.0, |old| old.depth(knots, body, 0.0));
            plane.initial_overlap = (plane.depth(knots, body, 0.0) - answered).max(0.0);
        }
        plane.impulse = old.map_or(0.0, |old| old.impulse);
        plane
    }

    /// Number of colliders of the detector.
    pub fn n_colliders(&self) -> usize {
        self.detector.n_colliders()
    }
}

/// The ends of the cable at a plane, where knots are at `position`, in the body frame [m].
fn ends(plane: &ContactPlane, position: impl Fn(usize) -> Vector3<f64>, body: &Body) -> [Vector3<f64>; 2] {
    [plane.record.knot, plane.along().end].map(|knot| body.to_body(&position(knot)))
}

/// Whether a cable from one end to the other, in the body frame, lies along a plane.
fn lies_along(plane: &ContactPlane, [from, to]: &[Vector3<f64>; 2]) -> bool {
    let across = to - from;
    plane.normal.dot(&across).abs() < ALONG * across.norm()
}

/// Those of `planes`, in the order of cables, that are of the cable of `contact`.
fn of_cable<'a>(planes: &'a [ContactPlane], contact: &Contact) -> &'a [ContactPlane] {
    let cable = contact.along.unwrap_or_default().cable;
    let first = planes.partition_point(|plane| plane.along().cable < cable);
    let n = planes[first..].partition_point(|plane| plane.along().cable == cable);
    &planes[first..first + n]
}

/// The plane that stands nearest on the same cable and part.
fn nearest<'a>(
    planes: impl IntoIterator<Item = &'a ContactPlane>,
    contact: &Contact,
) -> Option<&'a ContactPlane> {
    let place = contact.along.unwrap_or_default();
    let same =
        |plane: &&ContactPlane| plane.along().cable == place.cable && plane.record.part == contact.part;
    let away = |plane: &ContactPlane| (plane.along().share - place.share).abs();
    let nearest = planes.into_iter().filter(same).min_by(|one, other| away(one).total_cmp(&away(other)));
    nearest.filter(|plane| away(plane) < SAME_CONTACT)
}
