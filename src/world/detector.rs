//! Contacts from the narrow phase, without dynamics; see [`crate::world::Detector`].

use super::convert::{engines, engines_pose, engines_pose_of, real};
use super::rapier::prelude::{
    ActiveCollisionTypes, BroadPhaseBvh, ColliderBuilder, ColliderHandle, ColliderSet, CollisionPipeline,
    IslandManager, NarrowPhase, RigidBodySet,
};
use super::{KNOTS, TARGET, contact_collider, read_contacts, shapes};
use crate::net::Net;
use crate::state::{Body, Contact, State};
use crate::target::Target;
use crate::world::Setup;
use nalgebra::Isometry3;

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
}

impl Detector {
    /// Finds contacts of `net` with `target`.
    pub fn new(net: &Net, target: &Target) -> Detector {
        let mut colliders = ColliderSet::new();
        let setup = Setup::default();
        let all = ActiveCollisionTypes::all(); // no bodies stand behind them
        let parts = target
            .parts
            .iter()
            .enumerate()
            .map(|(index, part)| {
                let shape = ColliderBuilder::new(shapes::shape(part)).active_collision_types(all);
                (colliders.insert(contact_collider(shape, &setup, TARGET, KNOTS, index)), part.pose)
            })
            .collect();
        let knots = (0..net.n_knots())
            .map(|knot| {
                let ball = ColliderBuilder::ball(real(net.radius[knot])).active_collision_types(all);
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
        }
    }

    /// Contacts at the pose of `state` and `body` whose gap is at most `reach` [m], in the order of
    /// knots and parts.
    pub fn detect(&mut self, state: &State, body: &Body, reach: f64, contacts: &mut Vec<Contact>) {
        let pose = engines_pose_of(&body.position, &body.attitude);
        for (handle, part) in &self.parts {
            if let Some(collider) = self.colliders.get_mut(*handle) {
                collider.set_position(pose * engines_pose(part));
            }
        }
        for (&handle, position) in self.knots.iter().zip(&state.knots.position) {
            if let Some(collider) = self.colliders.get_mut(handle) {
                collider.set_translation(engines(position));
            }
        }
        self.pipeline.step(
            real(reach),
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &(),
            &(),
        );
        read_contacts(&self.narrow_phase, &self.colliders, contacts);
    }

    pub fn n_colliders(&self) -> usize {
        self.colliders.len()
    }
}
