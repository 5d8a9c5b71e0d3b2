//! The engine's world, in the build that the module around this file names `rapier`.
//!
//! Bodies are built once; a step writes velocities that snaps, contacts and effects changed, lets
//! the engine advance, and reads positions, velocities and contacts back.

#[path = "capsules.rs"]
pub mod capsules;
#[path = "convert.rs"]
mod convert;
#[path = "detector.rs"]
pub mod detector;
#[path = "settings.rs"]
pub mod settings;
#[path = "shapes.rs"]
mod shapes;
#[path = "sliding.rs"]
mod sliding;

use nalgebra::Vector3;

use super::rapier;
use crate::net::Net;
use crate::state::{Body, Contact, Knots, State, TARGET};
use crate::target::Target;
use crate::target::spec::Motion;
use crate::world::{Census, Setup, Softness};
use convert::{engines, engines_mass, engines_pose, engines_pose_of, number, our_rotation, ours, real};
use rapier::prelude::{
    ActiveHooks, Collider, ColliderBuilder, ColliderHandle, ColliderSet, GenericJointBuilder, Group,
    ImpulseJointHandle, InteractionGroups, InteractionTestMode, JointAxesMask, JointAxis, LockedAxes,
    MassProperties, NarrowPhase, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, RigidBodyType,
    SpringCoefficients, Vector,
};
use rapier::utils::OrthonormalBasis;
use sliding::Sliding;

/// The engine's world; what each method does is said at [`crate::world::World`].
pub struct World {
    physics: PhysicsWorld,
    knots: Vec<RigidBodyHandle>,
    joints: Vec<ImpulseJointHandle>,
    target: Option<TargetHandles>,
    /// How friction acts, where it does.
    sliding: Option<Sliding>,
}

/// The target's handles and what detection needs of it.
struct TargetHandles {
    body: RigidBodyHandle,
    knot_colliders: Vec<ColliderHandle>,
    bounding_radius: f64,
    /// Distance from which the engine sees a knot and a part as a pair [m].
    reach: f64,
    detecting: bool,
}

const KNOTS: Group = Group::GROUP_1;
const PARTS: Group = Group::GROUP_2;

impl World {
    pub fn new(net: &Net, target: Option<&Target>, setup: &Setup) -> World {
        // How far a knot and a part may come closer within a step. Four times the fastest at the
        // start: light knots are snapped to several times a bullet's speed. With twice, 1 in 5 runs
        // of the Cubesat met a knot the engine had not seen, 0.25 mm deep; with four times the
        // deepest of 20 runs was 2e-3 mm.
        let fastest = net.launch_velocity.iter().map(|v| v.norm()).fold(0.0, f64::max)
            + target
                .map_or(0.0, |target| target.spin.norm() * target.bounding_radius + target.velocity.norm());
        let thickest = net.radius.iter().copied().fold(0.0, f64::max);
        let reach = (4.0 * fastest * setup.step).max(thickest);

        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::ZERO;
        physics.integration_parameters = settings::parameters(setup.step, reach, setup.friction.is_some());
        let knots: Vec<_> = (0..net.n_knots())
            .map(|knot| {
                physics.bodies.insert(
                    // A knot is a point: it does not turn. Bodies of a free-floating scene must not
                    // fall asleep: below 0.05 m/s the engine would freeze them.
                    RigidBodyBuilder::dynamic()
                        .translation(engines(&net.folded[knot]))
                        .linvel(engines(&net.launch_velocity[knot]))
                        .locked_axes(LockedAxes::ROTATION_LOCKED)
                        .additional_mass_properties(MassProperties::new(
                            Vector::ZERO,
                            real(net.mass[knot]),
                            Vector::ZERO,
                        ))
                        .can_sleep(false),
                )
            })
            .collect();
        let target = target.map(|target| insert_target(&mut physics, target, net, &knots, setup, reach));
        let sliding = setup.friction.map(|law| Sliding { law });
        World { physics, knots, joints: Vec::new(), target, sliding }
    }

    pub fn tie(&mut self, [a, b]: [usize; 2], rest_length: f64, softness: Softness) -> usize {
        // A coupled linear limit is one row along the line between the bodies, refreshed every
        // sub-step; uncoupled limits would keep its direction over the step and misjudge the
        // stretch of a turning cable.
        let joint = GenericJointBuilder::new(JointAxesMask::empty())
            .coupled_axes(JointAxesMask::LIN_AXES)
            .limits(JointAxis::LinX, [0.0, real(rest_length)])
            .softness(spring(softness))
            .build();
        let handle = self.physics.impulse_joints.insert(self.knots[a], self.knots[b], joint, false);
        self.joints.push(handle);
        self.joints.len() - 1
    }

    pub fn set_softness(&mut self, index: usize, softness: Softness) {
        if let Some(joint) = self.physics.impulse_joints.get_mut(self.joints[index], false) {
            joint.data.softness = spring(softness);
        }
    }

    pub fn set_rest_length(&mut self, index: usize, rest_length: f64) {
        if let Some(joint) = self.physics.impulse_joints.get_mut(self.joints[index], false) {
            joint.data.set_limits(JointAxis::LinX, [0.0, real(rest_length)]);
        }
    }

    pub fn set_acting(&mut self, index: usize, acts: bool) {
        if let Some(joint) = self.physics.impulse_joints.get_mut(self.joints[index], false) {
            joint.data.set_enabled(acts);
        }
    }

    pub fn impulse_of_joint(&self, index: usize) -> f64 {
        let joint = self.physics.impulse_joints.get(self.joints[index]);
        // A coupled limit's row writes to the first of its axes.
        joint.map_or(0.0, |joint| number(joint.data.limits[JointAxis::LinX as usize].impulse))
    }

    pub fn set_velocity(&mut self, index: usize, velocity: &Vector3<f64>) {
        self.physics.bodies[self.knots[index]].set_linvel(engines(velocity), false);
    }

    pub fn set_position(&mut self, index: usize, position: &Vector3<f64>) {
        self.physics.bodies[self.knots[index]].set_translation(engines(position), false);
    }

    pub fn set_target(&mut self, body: &Body) {
        let Some(target) = &self.target else { return };
        let own = &mut self.physics.bodies[target.body];
        own.set_position(engines_pose_of(&body.position, &body.attitude), false);
        own.set_linvel(engines(&body.velocity), false);
        own.set_angvel(engines(&body.rate), false);
    }

    pub fn write(&mut self, state: &State) {
        for knot in 0..self.knots.len() {
            self.set_position(knot, &state.knots.position[knot]);
            self.set_velocity(knot, &state.knots.velocity[knot]);
        }
        if let Some(body) = state.target() {
            self.set_target(body);
        }
    }

    pub fn write_velocities(&mut self, state: &State) {
        for (&handle, velocity) in self.knots.iter().zip(&state.knots.velocity) {
            self.physics.bodies[handle].set_linvel(engines(velocity), false);
        }
        if let (Some(target), Some(body)) = (&self.target, state.bodies.get(TARGET)) {
            let own = &mut self.physics.bodies[target.body];
            // One that is held moves as prescribed; its velocity is not free to change.
            if own.is_dynamic() {
                own.set_linvel(engines(&body.velocity), false);
                own.set_angvel(engines(&body.rate), false);
            }
        }
    }

    /// Turns detection on when the boxes of net and target come within reach of each other.
    fn watch(&mut self, state: &State) {
        if self.detecting() || self.apart(state) {
            return;
        }
        if let Some(target) = &mut self.target {
            target.detecting = !target.knot_colliders.is_empty();
            for &handle in &target.knot_colliders {
                self.physics.colliders[handle].set_enabled(true);
            }
        }
    }

    pub fn look_ahead(&self) -> f64 {
        self.target.as_ref().map_or(0.0, |target| target.reach)
    }

    pub fn apart(&self, state: &State) -> bool {
        let (Some(target), Some(body)) = (&self.target, state.bodies.get(TARGET)) else { return true };
        state.knots.apart_from(body, target.bounding_radius + target.reach)
    }

    pub fn advance(&mut self, state: &mut State, step: f64, sweeps: u32) {
        self.watch(state);
        self.physics.integration_parameters.dt = real(step);
        self.physics.integration_parameters.num_internal_pgs_iterations = sweeps as usize;
        match &self.sliding {
            Some(sliding) => self.physics.step_with_events(sliding, &()),
            None => self.physics.step(),
        }
        self.read(state);
    }

    pub fn read(&self, state: &mut State) {
        let Knots { position, velocity } = &mut state.knots;
        position.clear();
        velocity.clear();
        for &handle in &self.knots {
            let body = &self.physics.bodies[handle];
            position.push(ours(body.translation()));
            velocity.push(ours(body.linvel()));
        }
        if let Some(target) = &self.target {
            let body = &self.physics.bodies[target.body];
            state.bodies[TARGET] = Body {
                position: ours(body.translation()),
                attitude: our_rotation(body.rotation()),
                velocity: ours(body.linvel()),
                rate: ours(body.angvel()),
            };
        }
    }

    pub fn contacts(&self, contacts: &mut Vec<Contact>) {
        read_contacts(&self.physics.narrow_phase, &self.physics.colliders, contacts);
    }

    pub fn detecting(&self) -> bool {
        self.target.as_ref().is_some_and(|target| target.detecting)
    }

    pub fn has_quarantined(&self) -> bool {
        !self.physics.quarantine().is_empty()
    }

    pub fn census(&self) -> Census {
        Census {
            bodies: self.physics.bodies.len(),
            colliders: self.physics.colliders.len(),
            joints: self.physics.impulse_joints.len(),
        }
    }
}

/// The contacts that `narrow_phase` holds, in the order of knots and parts.
fn read_contacts(narrow_phase: &NarrowPhase, colliders: &ColliderSet, contacts: &mut Vec<Contact>) {
    contacts.clear();
    for pair in narrow_phase.contact_pairs() {
        let (Some(first), Some(second)) = (colliders.get(pair.collider1), colliders.get(pair.collider2))
        else {
            continue;
        };
        // The engine orders a pair as it likes; its normal points from first to second.
        let knot_is_first = first.collision_groups().memberships == KNOTS;
        let (knot, part) = if knot_is_first { (first, second) } else { (second, first) };
        for manifold in pair.solver_manifolds() {
            let from_first = manifold.data.normal;
            let normal = if knot_is_first { -from_first } else { from_first };
            // The engine's own pair of directions: any other reads friction off its line.
            let tangent = (-from_first).orthonormal_vector();
            let bitangent = (-from_first).cross(tangent);
            for point in &manifold.points {
                let along = point.data.tangent_impulse;
                let on_first = tangent * along.x + bitangent * along.y;
                contacts.push(Contact {
                    knot: knot.user_data as usize,
                    part: part.user_data as usize,
                    normal: ours(normal),
                    gap: number(point.dist),
                    impulse: number(point.data.impulse),
                    friction: ours(if knot_is_first { on_first } else { -on_first }),
                    ..Contact::default()
                });
            }
        }
    }
    // By keys beside them: a contact is as large as thirty numbers, and a sort moves it ten times.
    contacts.sort_by_cached_key(|contact| (contact.knot, contact.part));
}

/// The target as one rigid body with a collider a part, and a collider for every knot.
fn insert_target(
    physics: &mut PhysicsWorld,
    target: &Target,
    net: &Net,
    knots: &[RigidBodyHandle],
    setup: &Setup,
    reach: f64,
) -> TargetHandles {
    let kind = match target.motion {
        Motion::Free => RigidBodyType::Dynamic,
        Motion::Fixed => RigidBodyType::Fixed,
        Motion::Spinning => RigidBodyType::KinematicVelocityBased,
    };
    let spin = if target.motion == Motion::Fixed { Vector3::zeros() } else { target.attitude * target.spin };
    let body = physics.bodies.insert(
        RigidBodyBuilder::new(kind)
            .pose(engines_pose_of(&target.position, &target.attitude))
            .linvel(engines(&target.velocity))
            .angvel(engines(&spin))
            // Without the gyroscopic term a body tumbling about its middle axis never flips.
            .gyroscopic_forces_enabled(true)
            .additional_mass_properties(engines_mass(target.mass, &target.inertia))
            .can_sleep(false),
    );
    let (parts, touching) = match setup.has_contacts {
        true => (&target.parts[..], knots),
        false => (&[][..], &[][..]),
    };
    for (index, part) in parts.iter().enumerate() {
        let collider = ColliderBuilder::new(shapes::shape(part)).position(engines_pose(&part.pose));
        physics.insert_collider(contact_collider(collider, setup, PARTS, KNOTS, index), Some(body));
    }
    // Knots see the target and not each other: a scene that wants more names an effect.
    let knot_colliders = touching
        .iter()
        .enumerate()
        .map(|(knot, &handle)| {
            let ball = ColliderBuilder::ball(real(net.radius[knot])).enabled(false);
            physics.insert_collider(contact_collider(ball, setup, KNOTS, PARTS, knot), Some(handle))
        })
        .collect();
    TargetHandles { body, knot_colliders, bounding_radius: target.bounding_radius, reach, detecting: false }
}

fn spring(Softness { frequency, damping_ratio }: Softness) -> SpringCoefficients<rapier::math::Real> {
    SpringCoefficients::new(real(frequency), real(damping_ratio))
}

/// What knots' and parts' colliders have in common; masses are set on the bodies.
fn contact_collider(
    builder: ColliderBuilder,
    setup: &Setup,
    member_of: Group,
    sees: Group,
    index: usize,
) -> Collider {
    builder
        .density(0.0)
        // Restitution is ours: see `contact::engine`.
        .restitution(0.0)
        .friction(real(setup.friction.map_or(0.0, |law| law.coefficient(f64::INFINITY))))
        .active_hooks(match setup.friction {
            Some(_) => ActiveHooks::MODIFY_SOLVER_CONTACTS,
            None => ActiveHooks::empty(),
        })
        .collision_groups(InteractionGroups::new(member_of, sees, InteractionTestMode::And))
        .user_data(index as u128)
        .build()
}
