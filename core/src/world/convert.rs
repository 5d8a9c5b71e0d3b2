//! Between our numbers and vectors (64 bits, nalgebra) and the engine's (its build's width, glam).

#![allow(clippy::unnecessary_cast, reason = "one of the two builds has our own width")]

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::rapier::math::{Pose, Real, Rotation, Vector};
use super::rapier::prelude::MassProperties;

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
        real(mass),
        engines(&eigen.eigenvalues),
        Rotation::from_xyzw(real(q.i), real(q.j), real(q.k), real(q.w)),
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
                let found = Matrix3::from_column_slice(&found.to_cols_array().map(number));
                let rounding = 64.0 * number(Real::EPSILON); // a moment comes back by way of its inverse
                assert!((found - inertia).amax() < rounding, "{moments:?}: {found}");
            }
        }
    }
}
