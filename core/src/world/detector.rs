//! Contacts from the narrow phase, without dynamics; see [`crate::world::Detector`].

use nalgebra::Vector3;

use super::convert::{engines, engines_pose, number, ours, real};
use super::rapier::geometry::{Aabb, Ball, SharedShape};
use super::rapier::math::{Pose, Vector};
use super::rapier::parry::bounding_volume::BoundingVolume;
use super::rapier::parry::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use super::shapes;
use crate::net::Net;
use crate::state::Contact;
use crate::target::Target;
use crate::target::parts::ConvexPart;

/// Balls of the knots and solids of the parts in the body frame, asked for contacts.
///
/// It calls the narrow phase for one knot and part after another: the engine's own loop over colliders that no body
/// carries, with its broad phase and its graph of pairs, took four times as long for a Cubesat's net.
pub struct Detector {
    balls: Vec<Ball>,
    parts: Vec<PlacedPart>,
    /// Contacts of the last detection, and of the one before; these kept for their memory.
    found: Vec<Contact>,
    before: Vec<Contact>,
    /// Of the pair that is looked at.
    manifolds: Vec<ContactManifold<(), ()>>,
}

/// A part in the body frame, as the engine has it.
pub struct PlacedPart {
    pub shape: SharedShape,
    pub pose: Pose,
    /// Its box, in its own frame.
    pub bounds: Aabb,
    /// Centre of that box in the body frame.
    pub centre: Vector,
}

impl PlacedPart {
    pub fn new(part: &ConvexPart) -> PlacedPart {
        let (shape, pose) = (shapes::shape(part), engines_pose(&part.pose));
        let bounds = shape.compute_local_aabb();
        PlacedPart { centre: pose * bounds.center(), pose, bounds, shape }
    }
}

impl Detector {
    /// Finds contacts of `net` with `target`.
    pub fn new(net: &Net, target: &Target) -> Detector {
        Detector {
            balls: net.radius.iter().map(|radius| Ball::new(real(*radius))).collect(),
            parts: target.parts.iter().map(PlacedPart::new).collect(),
            found: Vec::new(),
            before: Vec::new(),
            manifolds: Vec::new(),
        }
    }

    /// Contacts whose gap is at most `margin` [m], in the body frame and in the order of knots and parts; the
    /// `renewed` knots, in order, are at new places in that frame. Those of others are as they were found.
    pub fn detect(&mut self, renewed: &[(usize, Vector3<f64>)], margin: f64) -> &[Contact] {
        std::mem::swap(&mut self.found, &mut self.before);
        self.found.clear();
        let mut standing = std::mem::take(&mut self.before);
        let mut known = standing.iter().peekable();
        for (knot, at) in renewed {
            while let Some(contact) = known.next_if(|contact| contact.knot < *knot) {
                self.found.push(*contact);
            }
            while known.next_if(|contact| contact.knot == *knot).is_some() {}
            self.look(*knot, at, margin);
        }
        self.found.extend(known);
        standing.clear();
        self.before = standing;
        &self.found
    }

    /// Adds the contacts of a knot at a place in the body frame [m].
    fn look(&mut self, knot: usize, at: &Vector3<f64>, margin: f64) {
        let (ball, at) = (&self.balls[knot], Pose::from_translation(engines(at)));
        for (index, PlacedPart { shape, pose, bounds, centre }) in self.parts.iter().enumerate() {
            // Of hundreds of parts most are farther than a corner of the box, which takes no turn into its frame.
            let bounds = bounds.loosened(ball.radius + real(margin));
            if (at.translation - *centre).length_squared() > bounds.half_extents().length_squared() {
                continue;
            }
            let in_part = pose.inv_mul(&at);
            if !bounds.contains_local_point(in_part.translation) {
                continue;
            }
            let seen = DefaultQueryDispatcher.contact_manifolds(
                &in_part,
                &**shape,
                ball,
                real(margin),
                &mut self.manifolds,
                &mut None,
            );
            debug_assert!(seen.is_ok(), "parts are convex");
            for manifold in &self.manifolds {
                let normal = ours(pose.rotation * manifold.local_n1);
                self.found.extend(manifold.points.iter().map(|point| Contact {
                    knot,
                    part: index,
                    normal,
                    gap: number(point.dist),
                    ..Contact::default()
                }));
            }
        }
    }

    /// Number of solids.
    pub fn n_colliders(&self) -> usize {
        self.balls.len() + self.parts.len()
    }
}
