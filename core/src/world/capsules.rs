//! Whole cables as the engine's narrow phase sees them: a capsule from knot to knot.
//!
//! The engine is asked for one cable and part after another, and only for cables whose ends have moved: its own loop, with its broad phase and its graph of
//! pairs, took as long as all else of a Cubesat's capture together. Of boxes it is not asked at all: there is a formula (see [`crate::target::cuboid`]).

use std::ops::RangeInclusive;
use std::sync::Arc;

use nalgebra::Vector3;

use super::convert::{engines, number, ours, real};
use super::detector::PlacedPart;
use super::rapier::geometry::{Aabb, Capsule};
use super::rapier::math::{Pose, Real};
use super::rapier::parry::bounding_volume::BoundingVolume;
use super::rapier::parry::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use crate::cable::Cable;
use crate::net::Net;
use crate::state::{Along, Contact};
use crate::target::Target;
use crate::target::cuboid::{AT_KNOT, Cuboid, LineSegment, NearPlace, SAME_PLACE};
use crate::target::parts::{ConvexPart, Primitive};
use crate::world::{CableContacts, POINT_ERROR};

/// Cosine of the angle between a cable and a normal up to which they are taken as square.
const SQUARE: f64 = 1e-3;

/// Finds where cables are near a target; see [`crate::world::CableDetector`].
pub struct CableDetector {
    cables: Arc<[Cable]>,
    radius: Vec<f64>,
    parts: Vec<TouchablePart>,
    /// Of the pair that is looked at.
    manifolds: Vec<ContactManifold<(), ()>>,
}

/// A part as the engine has it, and as we have it.
struct TouchablePart {
    placed: PlacedPart,
    solid: ConvexPart,
}

/// A straight cable in the frame of a part.
struct StraightCable {
    index: usize,
    knots: [usize; 2],
    from: Vector3<f64>,
    to: Vector3<f64>,
    radius: f64,
}

impl CableDetector {
    pub fn new(net: &Net, target: &Target) -> CableDetector {
        let both = |part: &ConvexPart| TouchablePart { placed: PlacedPart::new(part), solid: part.clone() };
        CableDetector {
            cables: Arc::clone(&net.cables),
            radius: (0..net.cables.len()).map(|cable| net.cable_radius(cable)).collect(),
            parts: target.parts.iter().map(both).collect(),
            manifolds: Vec::new(),
        }
    }

    pub fn look(&mut self, index: usize, ends: [Vector3<f64>; 2], margin: f64, found: &mut CableContacts) {
        found.clear();
        let (knots, radius) = ([self.cables[index].a, self.cables[index].b], self.radius[index]);
        for (of_part, part) in self.parts.iter().enumerate() {
            let Some([from, to]) = part.near(&ends, margin + radius) else { continue };
            let cable = StraightCable { index, knots, from, to, radius };
            let [touching, waiting] = [found.touching.len(), found.waiting.len()];
            part.touch(&cable, margin, &mut self.manifolds, found);
            for contact in found.touching[touching..].iter_mut().chain(&mut found.waiting[waiting..]) {
                contact.part = of_part;
                contact.normal = part.solid.pose.rotation * contact.normal;
                contact.point = part.solid.to_body(&contact.point);
            }
        }
        sort(&mut found.touching);
    }

    pub fn n_colliders(&self) -> usize {
        self.cables.len() + self.parts.len()
    }
}

/// Puts the contacts of a cable in the order of parts and places, and leaves one of those at the same place.
fn sort(contacts: &mut Vec<Contact>) {
    let share = |contact: &Contact| contact.along.map_or(0.0, |along| along.share);
    contacts
        .sort_by(|one, other| one.part.cmp(&other.part).then_with(|| share(one).total_cmp(&share(other))));
    contacts.dedup_by(|contact, last| last.part == contact.part && share(contact) - share(last) < SAME_PLACE);
}

impl StraightCable {
    /// Its contact at a share of its way.
    fn contact(&self, share: f64, point: Vector3<f64>, normal: Vector3<f64>, gap: f64) -> Contact {
        let [knot, end] = self.knots;
        let along = Some(Along { cable: self.index, end, share });
        Contact { knot, along, point, normal, gap, ..Contact::default() }
    }
}

/// Shares of the way `across` from knot to knot at which a place with that `normal` is the cable's business.
fn between_knots(normal: &Vector3<f64>, across: &Vector3<f64>) -> RangeInclusive<f64> {
    let is_square = normal.dot(across).abs() <= SQUARE * across.norm();
    let at_knot = if is_square { 0.0 } else { AT_KNOT };
    at_knot..=1.0 - at_knot
}

/// Adds the contacts of a cable with a box, in its frame, and the edges ahead of it; whether the middle line of the cable comes inside and
/// has no contact.
fn touch_box(cuboid: &Cuboid, cable: &StraightCable, margin: f64, found: &mut CableContacts) -> bool {
    let line = LineSegment { from: cable.from, along: cable.to - cable.from };
    let reach = margin + cable.radius;
    let (places, is_inside) = cuboid.places(&line, reach);
    let contact = |NearPlace { share, normal, height }: NearPlace| {
        cable.contact(share, line.at(share) - height * normal, normal, height - cable.radius)
    };
    let is_of_cable = |place: &NearPlace| between_knots(&place.normal, &line.along).contains(&place.share);
    let n_before = found.touching.len();
    found.touching.extend(places.into_iter().flatten().filter(is_of_cable).map(contact));
    // What is too far has none ahead either.
    if places.iter().any(Option::is_some) {
        found.waiting.extend(cuboid.edges_ahead(&line, reach).into_iter().flatten().map(contact));
    }
    is_inside && found.touching.len() == n_before
}

impl TouchablePart {
    /// The `ends` of a straight line in its frame, where the line may be within `margin` of it [m]: of hundreds of parts most are farther
    /// than a corner of the box, which takes no turn into its frame.
    fn near(&self, ends: &[Vector3<f64>; 2], margin: f64) -> Option<[Vector3<f64>; 2]> {
        let PlacedPart { bounds, centre, .. } = &self.placed;
        let bounds = bounds.loosened(real(margin));
        let (from, to) = (engines(&ends[0]), engines(&ends[1]));
        let farthest: Real = bounds.half_extents().length() + 0.5 * (to - from).length();
        if (0.5 * (from + to) - *centre).length_squared() > farthest * farthest {
            return None;
        }
        let ends = [self.solid.to_part(&ends[0]), self.solid.to_part(&ends[1])];
        let (from, to) = (engines(&ends[0]), engines(&ends[1]));
        bounds.intersects(&Aabb::new(from.min(to), from.max(to))).then_some(ends)
    }

    /// Adds the contacts of a cable with it, in its frame.
    fn touch(
        &self,
        cable: &StraightCable,
        margin: f64,
        manifolds: &mut Vec<ContactManifold<(), ()>>,
        found: &mut CableContacts,
    ) {
        let n_before = found.touching.len();
        let is_lost = match &self.solid.primitive {
            Primitive::Cuboid { half } => touch_box(&Cuboid { half: *half }, cable, margin, found),
            _ => {
                self.touch_any(cable, margin, manifolds, &mut found.touching)
                    && found.touching.len() == n_before
            }
        };
        if is_lost {
            found.touching.extend(self.crossing(cable));
        }
    }

    /// Adds what the engine finds of any convex part; whether the middle line of the cable comes inside.
    fn touch_any(
        &self,
        cable: &StraightCable,
        margin: f64,
        manifolds: &mut Vec<ContactManifold<(), ()>>,
        contacts: &mut Vec<Contact>,
    ) -> bool {
        let across = cable.to - cable.from;
        let half = engines(&(0.5 * across));
        // The engine would take what it remembers for the same pair.
        manifolds.clear();
        let seen = DefaultQueryDispatcher.contact_manifolds(
            &Pose::from_translation(engines(&(0.5 * (cable.from + cable.to)))),
            &*self.placed.shape,
            &Capsule::new(-half, half, real(cable.radius)),
            real(margin),
            manifolds,
            &mut None,
        );
        debug_assert!(seen.is_ok(), "parts are convex");
        let mut is_inside = false;
        for manifold in manifolds {
            let normal = ours(manifold.local_n1);
            let between = between_knots(&normal, &across);
            for point in &manifold.points {
                let (gap, on_part) = (number(point.dist), ours(point.local_p1));
                is_inside |= gap < -cable.radius;
                // From the part's surface to the middle line of the cable.
                let place = on_part + (gap + cable.radius) * normal;
                let share = across.dot(&(place - cable.from)) / across.norm_squared();
                if between.contains(&share) && self.is_behind(&normal, &on_part) {
                    contacts.push(cable.contact(share, on_part, normal, gap));
                }
            }
        }
        is_inside
    }

    /// Whether all of it is behind the plane through a `point` with a `normal`.
    ///
    /// Of a cable across an edge the engine gives, beside the closest point, places over the faces at
    /// both sides, with the normal of the edge: planes through these cut into the part.
    fn is_behind(&self, normal: &Vector3<f64>, point: &Vector3<f64>) -> bool {
        normal.dot(&(self.solid.primitive.support(normal) - point)) <= POINT_ERROR
    }

    /// The place at which a cable that lies through it comes out of it, where the engine has none: the nearest way for
    /// it was a knot back through the part.
    fn crossing(&self, cable: &StraightCable) -> Option<Contact> {
        let StraightCable { from, to, radius, .. } = cable;
        let crossing = self.solid.primitive.crossing(from, to, POINT_ERROR)?;
        let place = from + crossing.share * (to - from);
        let point = place + crossing.depth * crossing.normal;
        Some(cable.contact(crossing.share, point, crossing.normal, -crossing.depth - radius))
    }
}
