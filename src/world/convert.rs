//! Between our vectors (nalgebra) and the engine's (glam).

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use rapier3d::math::{Pose, Rotation, Vector};
use rapier3d::prelude::MassProperties;

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

/// The engine's mass properties of a body of `mass` [kg] and `inertia` about its centre of mass
/// [kg m^2].
///
/// The principal axes are ours: those that the engine finds are wrong where two moments are equal
/// and the third is larger, so that a square plate turned half as fast as it should.
pub fn engines_mass(mass: f64, inertia: &Matrix3<f64>) -> MassProperties {
    let eigen = inertia.symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let frame = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let q = frame.quaternion();
    MassProperties::with_principal_inertia_frame(
        Vector::ZERO,
        mass,
        engines(&eigen.eigenvalues),
        Rotation::from_xyzw(q.i, q.j, q.k, q.w),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_plate_turns_as_its_inertia_says() {
        let turned = UnitQuaternion::from_euler_angles(0.3, -1.1, 2.0).to_rotation_matrix();
        for moments in
            [[2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0], [2.0, 2.0, 1.0], [1.0, 2.0, 2.5], [1.0; 3]]
        {
            let plain = Matrix3::from_diagonal(&moments.into());
            for inertia in [plain, turned * plain * turned.inverse()] {
                let found = engines_mass(3.0, &inertia).reconstruct_inertia_matrix();
                let found = Matrix3::from_column_slice(&found.to_cols_array());
                assert!((found - inertia).amax() < 1e-12, "{moments:?}: {found}");
            }
        }
    }
}
