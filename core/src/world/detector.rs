//! Contacts from the narrow phase, without dynamics; see [`crate::world::Detector`].

use nalgebra::{Isometry3, Vector3};

use super::convert::{engines, engines_pose, engines_pose_of, number, ours, real};
use super::rapier::geometry::{Aabb, Ball, SharedShape};
use super::rapier::math::{Pose, Vector};
use super::rapier::parry::bounding_volume::BoundingVolume;
use super::rapier::parry::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use super::rapier::prelude::{
    ActiveCollisionTypes, BroadPhaseBvh, Collider, ColliderBuilder, ColliderHandle, ColliderSet,
    CollisionPipeline, Group, IslandManager, NarrowPhase, RigidBodySet,
};
use super::{PARTS, contact_collider, shapes};
use crate::net::Net;
use crate::state::{Body, Contact};
use crate::target::Target;
use crate::world::Setup;

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

/// A part in the body frame.
struct PlacedPart {
    shape: SharedShape,
    pose: Pose,
    /// Its box, in its own frame.
    bounds: Aabb,
    /// Centre of that box in the body frame.
    centre: Vector,
}

impl Detector {
    /// Finds contacts of `net` with `target`.
    pub fn new(net: &Net, target: &Target) -> Detector {
        let placed = |part| {
            let (shape, pose) = (shapes::shape(part), engines_pose(&part.pose));
            let bounds = shape.compute_local_aabb();
            PlacedPart { centre: pose * bounds.center(), pose, bounds, shape }
        };
        Detector {
            balls: net.radius.iter().map(|radius| Ball::new(real(*radius))).collect(),
            parts: target.parts.iter().map(placed).collect(),
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

/// Detection with colliders that no body carries.
pub struct Scan {
    pipeline: CollisionPipeline,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    bodies: RigidBodySet,
    pub narrow_phase: NarrowPhase,
    pub colliders: ColliderSet,
}

impl Scan {
    pub fn new() -> Scan {
        Scan {
            pipeline: CollisionPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            bodies: RigidBodySet::new(),
            narrow_phase: NarrowPhase::new(),
            colliders: ColliderSet::new(),
        }
    }

    /// Adds collider `index` of a group, which sees another.
    pub fn insert(
        &mut self,
        shape: ColliderBuilder,
        member_of: Group,
        sees: Group,
        index: usize,
    ) -> ColliderHandle {
        // No bodies stand behind them.
        let shape = shape.active_collision_types(ActiveCollisionTypes::all());
        self.colliders.insert(contact_collider(shape, &Setup::default(), member_of, sees, index))
    }

    /// A collider, to be moved.
    pub fn collider(&mut self, handle: ColliderHandle) -> Option<&mut Collider> {
        self.colliders.get_mut(handle)
    }

    /// Detects what is at most `margin` apart [m] where the colliders are now.
    pub fn run(&mut self, margin: f64) {
        self.pipeline.step(
            real(margin),
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &(),
            &(),
        );
    }
}

/// The parts of a target in a scan, with their poses in the body frame.
pub struct ScannedParts(Vec<(ColliderHandle, Isometry3<f64>)>);

impl ScannedParts {
    /// Adds the parts of `target`, which see one group, where they are in the body frame.
    pub fn insert(scan: &mut Scan, target: &Target, sees: Group) -> ScannedParts {
        let parts = target.parts.iter().enumerate();
        let add = parts.map(|(index, part)| {
            let shape = ColliderBuilder::new(shapes::shape(part)).position(engines_pose(&part.pose));
            (scan.insert(shape, PARTS, sees, index), part.pose)
        });
        ScannedParts(add.collect())
    }

    /// Moves them to where the body is.
    pub fn place(&self, scan: &mut Scan, body: &Body) {
        let pose = engines_pose_of(&body.position, &body.attitude);
        for (handle, part) in &self.0 {
            if let Some(collider) = scan.collider(*handle) {
                collider.set_position(pose * engines_pose(part));
            }
        }
    }
}
