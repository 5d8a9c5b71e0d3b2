//! Contacts from the engine's narrow phase, without its dynamics.
//!
//! The responses of our own ([`crate::contact`]) ask for the contacts at the pose just set; the
//! engine's full step would report gaps at the start of the step, and answer them itself.

use nalgebra::Isometry3;
use rapier3d::prelude::{
    ActiveCollisionTypes, BroadPhaseBvh, Collider, ColliderBuilder, ColliderHandle, ColliderSet,
    CollisionPipeline, Group, IslandManager, NarrowPhase, PhysicsHooks, RigidBodySet,
};

use super::convert::{engines, engines_pose, engines_pose_of};
use super::{KNOTS, Setup, TARGET, contact_collider, read_contacts};
use crate::net::Net;
use crate::state::{Body, Contact, Knots};
use crate::target::Target;

/// Colliders of knots and parts, moved to where they are and asked for contacts.
pub struct Detector {
    scan: Scan,
    parts: Parts,
    knots: Vec<ColliderHandle>,
}

impl Detector {
    /// Finds contacts of `net` with `target` whose gap is at most `reach` [m].
    pub fn new(net: &Net, target: &Target, reach: f64) -> Detector {
        let mut scan = Scan::new(reach);
        let parts = Parts::insert(&mut scan, target, KNOTS);
        let ball = |knot: usize| ColliderBuilder::ball(net.radius[knot]);
        let knots = (0..net.n_knots()).map(|knot| scan.insert(ball(knot), KNOTS, TARGET, knot)).collect();
        Detector { scan, parts, knots }
    }

    /// Contacts at the pose of `knots` and `body`, in the order of knots and parts.
    pub fn detect(&mut self, knots: &Knots, body: &Body, contacts: &mut Vec<Contact>) {
        self.parts.place(&mut self.scan, body);
        for (&handle, position) in self.knots.iter().zip(&knots.position) {
            if let Some(collider) = self.scan.colliders.get_mut(handle) {
                collider.set_translation(engines(position));
            }
        }
        self.scan.run(&());
        read_contacts(&self.scan.narrow_phase, &self.scan.colliders, contacts);
    }

    /// Number of colliders.
    pub fn n_colliders(&self) -> usize {
        self.scan.colliders.len()
    }
}

/// The engine's detection with colliders that no body carries.
pub(super) struct Scan {
    pipeline: CollisionPipeline,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    bodies: RigidBodySet,
    reach: f64,
    pub(super) narrow_phase: NarrowPhase,
    pub(super) colliders: ColliderSet,
}

impl Scan {
    /// Finds what is at most `reach` apart [m].
    pub(super) fn new(reach: f64) -> Scan {
        Scan {
            pipeline: CollisionPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            bodies: RigidBodySet::new(),
            reach,
            narrow_phase: NarrowPhase::new(),
            colliders: ColliderSet::new(),
        }
    }

    /// Adds collider `index` of a group, which sees another.
    pub(super) fn insert(
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

    /// Collider to be moved.
    pub(super) fn collider(&mut self, handle: ColliderHandle) -> Option<&mut Collider> {
        self.colliders.get_mut(handle)
    }

    /// Detects where the colliders are now.
    pub(super) fn run(&mut self, hooks: &dyn PhysicsHooks) {
        self.pipeline.step(
            self.reach,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            hooks,
            &(),
        );
    }
}

/// The parts of a target in a scan, with their poses in the body frame.
pub(super) struct Parts(Vec<(ColliderHandle, Isometry3<f64>)>);

impl Parts {
    /// Adds the parts of `target`, which see one group.
    pub(super) fn insert(scan: &mut Scan, target: &Target, sees: Group) -> Parts {
        let mut add = |(index, part): (usize, &crate::target::parts::ConvexPart)| {
            (scan.insert(ColliderBuilder::new(part.to_parry()), TARGET, sees, index), part.pose)
        };
        Parts(target.parts.iter().enumerate().map(&mut add).collect())
    }

    /// Moves them to where the body is.
    pub(super) fn place(&self, scan: &mut Scan, body: &Body) {
        let pose = engines_pose_of(&body.position, &body.attitude);
        for (handle, part) in &self.0 {
            if let Some(collider) = scan.collider(*handle) {
                collider.set_position(pose * engines_pose(part));
            }
        }
    }
}
