//! Volume, centroid and inertia of solids, exact for closed surfaces of triangles.
//!
//! A closed surface is summed as tetrahedra from one point to each triangle (a, b, c, relative to
//! that point; a triangle seen from inside counts negative):
//!
//! V = Σ D / 6,  V g = Σ D (a + b + c) / 24,
//! C = ∫ x xᵀ dV = Σ D ((a + b + c)(a + b + c)ᵀ + a aᵀ + b bᵀ + c cᵀ) / 120,  D = a · (b × c)
//!
//! and the inertia at unit density is J = tr(C) 1 − C, with C taken about the centroid g.

use nalgebra::{Isometry3, Matrix3, Vector3};

/// Moments of a solid at unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Volume [m^3].
    pub volume: f64,
    /// Centroid [m].
    pub centroid: Vector3<f64>,
    /// Inertia about the centroid over the density [m^5].
    pub inertia: Matrix3<f64>,
}

impl Moments {
    /// Moments of a closed surface; the volume is negative when the triangles face inward.
    pub fn of_surface(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Moments {
        // Near the solid, so that a body far from its origin loses no digits.
        let origin = vertices.iter().sum::<Vector3<f64>>() / vertices.len().max(1) as f64;
        let mut volume = 0.0;
        let mut first = Vector3::zeros();
        let mut second = Matrix3::zeros();
        for triangle in triangles {
            let [a, b, c] = triangle.map(|corner| vertices[corner as usize] - origin);
            let determinant = a.dot(&b.cross(&c));
            let sum = a + b + c;
            volume += determinant / 6.0;
            first += determinant / 24.0 * sum;
            second += determinant / 120.0
                * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
        }
        let centroid = if volume == 0.0 { Vector3::zeros() } else { first / volume };
        let about_centroid = second - volume * centroid * centroid.transpose();
        let inertia = Matrix3::from_diagonal_element(about_centroid.trace()) - about_centroid;
        Moments { volume, centroid: origin + centroid, inertia }
    }

    /// The same solid moved by `pose`.
    pub fn moved(&self, pose: &Isometry3<f64>) -> Moments {
        let turn = pose.rotation.to_rotation_matrix();
        Moments {
            volume: self.volume,
            centroid: pose.transform_point(&self.centroid.into()).coords,
            inertia: turn * self.inertia * turn.transpose(),
        }
    }
}

/// Inertia about `arm` away from the centre of mass, over that about it: m (|d|² 1 − d dᵀ).
pub fn parallel_axis(mass: f64, arm: Vector3<f64>) -> Matrix3<f64> {
    mass * (Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Hull;
    use nalgebra::UnitQuaternion;

    #[test]
    fn a_cuboid_far_from_the_origin_anywhere_turned() {
        let sides = Vector3::new(0.1, 0.3, 0.2);
        let pose = Isometry3::from_parts(
            Vector3::new(100.0, -50.0, 20.0).into(),
            UnitQuaternion::from_euler_angles(0.4, 1.0, -2.0),
        );
        let corners: Vec<_> = (0..8)
            .map(|i| Vector3::new((i & 1) as f64 - 0.5, (i >> 1 & 1) as f64 - 0.5, (i >> 2) as f64 - 0.5))
            .map(|corner| pose.transform_point(&corner.component_mul(&sides).into()).coords)
            .collect();
        let hull = Hull::of(&corners).unwrap();
        let moments = Moments::of_surface(&hull.vertices, &hull.triangles);
        let volume = sides.product();
        assert!((moments.volume / volume - 1.0).abs() < 1e-10);
        assert!((moments.centroid - pose.translation.vector).norm() < 1e-12);

        let squares = sides.component_mul(&sides);
        let inertia =
            volume / 12.0 * Vector3::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y);
        let upright =
            Moments { volume, centroid: Vector3::zeros(), inertia: Matrix3::from_diagonal(&inertia) };
        assert!((moments.inertia - upright.moved(&pose).inertia).norm() < 1e-10 * inertia.norm());
    }

    #[test]
    fn parallel_axis_of_a_point_mass() {
        let inertia = parallel_axis(2.0, Vector3::new(3.0, 0.0, 0.0));
        assert_eq!(inertia, Matrix3::from_diagonal(&Vector3::new(0.0, 18.0, 18.0)));
    }
}
