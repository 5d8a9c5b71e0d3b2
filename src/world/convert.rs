//! Between our numbers and vectors (64 bits, nalgebra) and the engine's (its build's width, glam).

#![allow(clippy::unnecessary_cast, reason = "one of the two builds has our own width")]

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::rapier::math::{Pose, Real, Rotation, Vector};

/// Our number from the engine's.
pub fn number(x: Real) -> f64 {
    x as f64
}

/// The engine's number from ours.
pub fn real(x: f64) -> Real {
    x as Real
}

/// Ours from the engine's.
pub fn ours(v: Vector) -> Vector3<f64> {
    Vector3::new(number(v.x), number(v.y), number(v.z))
}

/// The engine's from ours.
pub fn engines(v: &Vector3<f64>) -> Vector {
    Vector::new(real(v.x), real(v.y), real(v.z))
}

/// Our rotation from the engine's.
pub fn our_rotation(q: &Rotation) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(number(q.w), number(q.x), number(q.y), number(q.z)))
}

/// The engine's rotation from ours.
pub fn engines_rotation(rotation: &UnitQuaternion<f64>) -> Rotation {
    let q = rotation.quaternion();
    Rotation::from_xyzw(real(q.i), real(q.j), real(q.k), real(q.w))
}

/// The engine's pose from ours.
pub fn engines_pose(pose: &Isometry3<f64>) -> Pose {
    Pose::from_parts(engines(&pose.translation.vector), engines_rotation(&pose.rotation))
}

/// The engine's pose from a position and a rotation of ours.
pub fn engines_pose_of(position: &Vector3<f64>, rotation: &UnitQuaternion<f64>) -> Pose {
    engines_pose(&Isometry3::from_parts(Translation3::from(*position), *rotation))
}
