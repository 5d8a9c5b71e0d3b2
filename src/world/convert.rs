//! Between our numbers and vectors (64 bits, nalgebra) and the engine's (its build's width, glam).

#![allow(clippy::unnecessary_cast, reason = "one of the two builds has our own width")]

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::rapier::math::{Matrix, Pose, Real, Rotation, Vector};

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

/// The engine's pose from ours.
pub fn engines_pose(pose: &Isometry3<f64>) -> Pose {
    let q = pose.rotation.quaternion();
    let rotation = Rotation::from_xyzw(real(q.i), real(q.j), real(q.k), real(q.w));
    Pose::from_parts(engines(&pose.translation.vector), rotation)
}

/// The engine's pose from a position and a rotation of ours.
pub fn engines_pose_of(position: &Vector3<f64>, rotation: &UnitQuaternion<f64>) -> Pose {
    engines_pose(&Isometry3::from_parts(Translation3::from(*position), *rotation))
}

/// The engine's matrix from ours.
pub fn engines_matrix(m: &Matrix3<f64>) -> Matrix {
    // Both are stored column by column.
    let mut columns = [0.0; 9];
    columns.iter_mut().zip(m).for_each(|(theirs, ours)| *theirs = real(*ours));
    Matrix::from_cols_array(&columns)
}
