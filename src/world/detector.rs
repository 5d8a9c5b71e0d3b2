//! Contacts from the engine's narrow phase, without its dynamics.
//!
//! The responses of our own ([`crate::contact`]) ask for the contacts at the pose just set; the
//! engine's full step would report gaps at the start of the step, and answer them itself.

use nalgebra::Isometry3;
use rapier3d::prelude::{
    ActiveCollisionTypes, BroadPhaseBvh, ColliderBuilder, ColliderHandle, ColliderSet, CollisionPipeline,
    IslandManager, NarrowPhase, RigidBodySet,
};

use super::convert::{engines_pose, engines_pose_of};
use super::{KNOTS, Setup, TARGET, contact_collider, read_contacts};
use crate::net::Net;
use crate::state::{Body, Contact, State};
use crate::target::Target;

/// Colliders of knots and parts, moved to where they are and asked for contacts.
pub struct Detector {
    pipeline: CollisionPipeline,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    knots: Vec<ColliderHandle>,
    parts: Vec<(ColliderHandle, Isometry3<f64>)>,
    reach: f64,
}

impl Detector {
    /// Finds contacts of `net` with `target` whose gap is at most `reach` [m].
    pub fn new(net: &Net, target: &Target, reach: f64) -> Detector {
        let mut colliders = ColliderSet::new();
        let setup = Setup::default();
        let all = ActiveCollisionTypes::all(); // no bodies stand behind them
        let parts = target
            .parts
            .iter()
            .enumerate()
            .map(|(index, part)| {
                let shape = ColliderBuilder::new(part.to_parry()).active_collision_types(all);
                (colliders.insert(contact_collider(shape, &setup, TARGET, KNOTS, index)), part.pose)
            })
            .collect();
        let knots = (0..net.n_knots())
            .map(|knot| {
                let ball = ColliderBuilder::ball(net.radius[knot]).active_collision_types(all);
                colliders.insert(contact_collider(ball, &setup, KNOTS, TARGET, knot))
            })
            .collect();
        Detector {
            pipeline: CollisionPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies: RigidBodySet::new(),
            colliders,
            knots,
            parts,
            reach,
        }
    }

    /// Contacts at the pose of `state` and `body`, in the order of knots and parts.
    pub fn detect(&mut self, state: &State, body: &Body, contacts: &mut Vec<Contact>) {
        let pose = engines_pose_of(&body.position, &body.attitude);
        for (handle, part) in &self.parts {
            if let Some(collider) = self.colliders.get_mut(*handle) {
                collider.set_position(pose * engines_pose(part));
            }
        }
        for (&handle, position) in self.knots.iter().zip(&state.knots.position) {
            if let Some(collider) = self.colliders.get_mut(handle) {
                collider.set_translation(super::convert::engines(position));
            }
        }
        self.pipeline.step(
            self.reach,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &(),
            &(),
        );
        contacts.clear();
        read_contacts(&self.narrow_phase, &self.colliders, contacts);
    }

    /// Number of colliders.
    pub fn n_colliders(&self) -> usize {
        self.colliders.len()
    }
}
