//! Contacts from the narrow phase, without dynamics; see [`crate::world::Detector`].

use nalgebra::{Isometry3, Vector3};

use super::convert::{engines, engines_pose, engines_pose_of, real};
use super::rapier::prelude::{
    ActiveCollisionTypes, BroadPhaseBvh, Collider, ColliderBuilder, ColliderHandle, ColliderSet,
    CollisionPipeline, Group, IslandManager, NarrowPhase, RigidBodySet,
};
use super::{KNOTS, PARTS, contact_collider, read_contacts, shapes};
use crate::net::Net;
use crate::state::{Body, Contact};
use crate::target::Target;
use crate::world::Setup;

/// Colliders of knots and parts in the body frame, asked for contacts.
pub struct Detector {
    scan: Scan,
    knots: Vec<ColliderHandle>,
}

impl Detector {
    /// Finds contacts of `net` with `target`.
    pub fn new(net: &Net, target: &Target) -> Detector {
        let mut scan = Scan::new();
        ScannedParts::insert(&mut scan, target, KNOTS);
        let ball = |knot: usize| ColliderBuilder::ball(real(net.radius[knot]));
        let knots = (0..net.n_knots()).map(|knot| scan.insert(ball(knot), KNOTS, PARTS, knot)).collect();
        Detector { scan, knots }
    }

    /// Contacts whose gap is at most `margin` [m], in the body frame and in the order of knots and parts; the
    /// `renewed` knots are moved to new places in that frame. The engine looks at no other again.
    pub fn detect(&mut self, renewed: &[(usize, Vector3<f64>)], margin: f64, contacts: &mut Vec<Contact>) {
        for (knot, at) in renewed {
            if let Some(collider) = self.scan.collider(self.knots[*knot]) {
                collider.set_translation(engines(at));
            }
        }
        self.scan.run(margin);
        read_contacts(&self.scan.narrow_phase, &self.scan.colliders, contacts);
    }

    pub fn n_colliders(&self) -> usize {
        self.scan.colliders.len()
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
