//! Between our vectors (nalgebra) and the engine's (glam).

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::math::{Pose, Rotation, Vector};

/// Ours from the engine's.
pub fn ours(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

/// The engine's from ours.
pub fn engines(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// Our rotation from the engine's.
pub fn our_rotation(q: &Rotation) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z))
}

/// The engine's pose from ours.
pub fn engines_pose(pose: &Isometry3<f64>) -> Pose {
    let q = pose.rotation.quaternion();
    Pose::from_parts(engines(&pose.translation.vector), Rotation::from_xyzw(q.i, q.j, q.k, q.w))
}

/// The engine's pose from a position and a rotation of ours.
pub fn engines_pose_of(position: &Vector3<f64>, rotation: &UnitQuaternion<f64>) -> Pose {
    engines_pose(&Isometry3::from_parts(Translation3::from(*position), *rotation))
}

/// The engine's matrix from ours.
pub fn engines_matrix(m: &Matrix3<f64>) -> rapier3d::math::Matrix {
    rapier3d::math::Matrix::from_cols_array(&[
        m[(0, 0)],
        m[(1, 0)],
        m[(2, 0)],
        m[(0, 1)],
        m[(1, 1)],
        m[(2, 1)],
        m[(0, 2)],
        m[(1, 2)],
        m[(2, 2)],
    ])
}
