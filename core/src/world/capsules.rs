//! Whole cables as the engine's narrow phase sees them: a capsule from knot to knot.
//!
//! A capsule sits at the middle of its cable, turned along it, and is made as long as the cable is
//! now: by turning and moving, not by a new shape in the same place, the engine notices that what
//! it remembers of a pair is stale.

use nalgebra::{UnitQuaternion, Vector3};

use super::convert::{engines, engines_pose_of, number, ours, real};
use super::detector::{Scan, ScannedParts};
use super::rapier::prelude::{ColliderBuilder, ColliderHandle, ContactPair};
use super::{CABLES, PARTS};
use crate::net::Net;
use crate::state::{Along, Body, Contact, Knots, State};
use crate::target::Target;
use crate::target::parts::ConvexPart;
use crate::world::POINT_ERROR;

/// Two places on one cable nearer than this share of its length are one contact.
const SAME_PLACE: f64 = 0.02;

/// A place nearer to a knot than this share of the cable is left to the knot. Not more: a knot that
/// rests on a face a little beyond an edge leaves its cable to cut into that edge.
const AT_KNOT: f64 = 1e-3;

/// Cosine of the angle between a cable and a normal up to which they are taken as square.
const SQUARE: f64 = 1e-3;

/// The capsules of a net's cables.
struct Capsules {
    ends: Vec<[usize; 2]>,
    radius: Vec<f64>,
    handles: Vec<ColliderHandle>,
}

impl Capsules {
    fn insert(scan: &mut Scan, net: &Net) -> Capsules {
        let ends: Vec<[usize; 2]> = net.cables.iter().map(|cable| [cable.a, cable.b]).collect();
        let radius: Vec<f64> = (0..ends.len()).map(|cable| net.cable_radius(cable)).collect();
        let shape = |cable: usize| {
            let half = 0.5 * net.cables[cable].rest_length;
            ColliderBuilder::capsule_y(real(half), real(radius[cable]))
        };
        let handles = (0..ends.len()).map(|cable| scan.insert(shape(cable), CABLES, PARTS, cable)).collect();
        Capsules { ends, radius, handles }
    }

    fn place(&self, scan: &mut Scan, knots: &Knots) {
        for (&[a, b], &handle) in self.ends.iter().zip(&self.handles) {
            let across = knots.position[b] - knots.position[a];
            let middle = knots.position[a] + 0.5 * across;
            // Against the y axis any turn by half a circle will do.
            let turn = UnitQuaternion::rotation_between(&Vector3::y(), &across)
                .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
            let Some(collider) = scan.collider(handle) else { continue };
            collider.set_position(engines_pose_of(&middle, &turn));
            if let Some(capsule) = collider.shape_mut().as_capsule_mut() {
                let half = 0.5 * across.norm();
                capsule.segment.a = engines(&Vector3::new(0.0, -half, 0.0));
                capsule.segment.b = engines(&Vector3::new(0.0, half, 0.0));
            }
        }
    }
}

/// Finds where cables are near a target; see [`crate::world::CableDetector`].
pub struct CableDetector {
    scan: Scan,
    parts: ScannedParts,
    solids: Vec<ConvexPart>,
    capsules: Capsules,
    /// Contacts as the engine has them, and their order; kept for their memory.
    unsorted: Vec<Contact>,
    order: Vec<PlaceInOrder>,
}

/// Where a contact stands in the order of cables, parts and places.
#[derive(Clone, Copy)]
struct PlaceInOrder {
    cable: usize,
    part: usize,
    share: f64,
    index: usize,
}

impl CableDetector {
    pub fn new(net: &Net, target: &Target) -> CableDetector {
        let mut scan = Scan::new();
        let parts = ScannedParts::insert(&mut scan, target, CABLES);
        let capsules = Capsules::insert(&mut scan, net);
        CableDetector {
            scan,
            parts,
            solids: target.parts.clone(),
            capsules,
            unsorted: Vec::new(),
            order: Vec::new(),
        }
    }

    pub fn detect(&mut self, state: &State, body: &Body, margin: f64, contacts: &mut Vec<Contact>) {
        let knots = &state.knots;
        self.parts.place(&mut self.scan, body);
        self.capsules.place(&mut self.scan, knots);
        self.scan.run(margin);
        contacts.clear();
        for pair in self.scan.narrow_phase.contact_pairs() {
            self.add_places(pair, knots, body, contacts);
        }
        self.sort(contacts);
    }

    /// Puts contacts in the order of cables, parts and places, and leaves one of those at the same place.
    fn sort(&mut self, contacts: &mut Vec<Contact>) {
        let place = |contact: &Contact| contact.along.map_or((0, 0.0), |along| (along.cable, along.share));
        // By number: a contact is as large as nine numbers and more, and a sort moves it ten times.
        self.order.clear();
        self.order.extend(contacts.iter().enumerate().map(|(index, contact)| {
            let (cable, share) = place(contact);
            PlaceInOrder { cable, part: contact.part, share, index }
        }));
        self.order.sort_unstable_by(|one, other| {
            let whole = |at: &PlaceInOrder| (at.cable, at.part);
            let by_share = || one.share.total_cmp(&other.share);
            whole(one).cmp(&whole(other)).then_with(by_share).then(one.index.cmp(&other.index))
        });
        self.unsorted.clear();
        self.unsorted.append(contacts);
        let mut last: Option<PlaceInOrder> = None;
        for at in &self.order {
            let is_same = |kept: PlaceInOrder| {
                at.cable == kept.cable && at.part == kept.part && at.share - kept.share < SAME_PLACE
            };
            if !last.is_some_and(is_same) {
                contacts.push(self.unsorted[at.index]);
                last = Some(*at);
            }
        }
    }

    /// Adds the places of a pair of cable and part.
    fn add_places(&self, pair: &ContactPair, knots: &Knots, body: &Body, contacts: &mut Vec<Contact>) {
        let colliders = &self.scan.colliders;
        let (Some(first), Some(second)) = (colliders.get(pair.collider1), colliders.get(pair.collider2))
        else {
            return;
        };
        let cable_is_first = first.collision_groups().memberships == CABLES;
        let (cable, part) = if cable_is_first { (first, second) } else { (second, first) };
        let (cable, part) = (cable.user_data as usize, part.user_data as usize);
        let [a, b] = self.capsules.ends[cable];
        let across = knots.position[b] - knots.position[a];
        let (n_before, mut is_inside) = (contacts.len(), false);
        for manifold in pair.solver_manifolds() {
            let normal = if cable_is_first { -manifold.data.normal } else { manifold.data.normal };
            let normal = ours(normal);
            for point in &manifold.points {
                is_inside |= number(point.dist) < -self.capsules.radius[cable];
                // From the part's surface to the middle line of the cable.
                let on_part = if cable_is_first {
                    second.position() * point.local_p2
                } else {
                    first.position() * point.local_p1
                };
                let on_part = ours(on_part);
                let place = on_part + (number(point.dist) + self.capsules.radius[cable]) * normal;
                let share = across.dot(&(place - knots.position[a])) / across.norm_squared();
                let is_square = normal.dot(&across).abs() <= SQUARE * across.norm();
                let margin = if is_square { 0.0 } else { AT_KNOT };
                if !(margin..=1.0 - margin).contains(&share) || !self.bounds(part, body, &normal, &on_part) {
                    continue;
                }
                contacts.push(Contact {
                    knot: a,
                    along: Some(Along { cable, end: b, share }),
                    part,
                    point: on_part,
                    normal,
                    gap: number(point.dist),
                    ..Contact::default()
                });
            }
        }
        if is_inside && contacts.len() == n_before {
            contacts.extend(self.crossing(cable, part, knots, body));
        }
    }

    /// The place at which a cable that lies through a part comes out of it, where the engine has none: the nearest way for
    /// it was a knot back through the part.
    fn crossing(&self, cable: usize, part: usize, knots: &Knots, body: &Body) -> Option<Contact> {
        let ([a, b], radius) = (self.capsules.ends[cable], self.capsules.radius[cable]);
        let [from, to] = [a, b].map(|knot| body.to_body(&knots.position[knot]));
        let crossing = self.solids[part].crossing(&from, &to, POINT_ERROR)?;
        let normal = body.attitude * crossing.normal;
        let place = knots.position[a] + crossing.share * (knots.position[b] - knots.position[a]);
        Some(Contact {
            knot: a,
            along: Some(Along { cable, end: b, share: crossing.share }),
            part,
            point: place + crossing.depth * normal,
            normal,
            gap: -crossing.depth - radius,
            ..Contact::default()
        })
    }

    /// Whether the plane through `point` with `normal` has all of a part behind it.
    ///
    /// Of a cable across an edge the engine gives, beside the closest point, places over the faces at
    /// both sides, with the normal of the edge: planes through these cut into the part.
    fn bounds(&self, part: usize, body: &Body, normal: &Vector3<f64>, point: &Vector3<f64>) -> bool {
        let in_body = |v: Vector3<f64>| body.attitude.inverse_transform_vector(&v);
        let (normal, point) = (in_body(*normal), in_body(point - body.position));
        let furthest = self.solids[part].support(&normal);
        normal.dot(&(furthest - point)) <= POINT_ERROR
    }

    pub fn n_colliders(&self) -> usize {
        self.scan.colliders.len()
    }
}
