//! The parts of a target as shapes of the engine.

use super::convert::{engines, real};
use super::rapier::geometry::SharedShape;
use crate::target::parts::{ConvexPart, Primitive};

/// The form of a part; its place in the body is `part.pose`.
pub fn shape(part: &ConvexPart) -> SharedShape {
    match &part.primitive {
        Primitive::Cuboid { half: [x, y, z] } => SharedShape::cuboid(real(*x), real(*y), real(*z)),
        Primitive::Cylinder { radius, half_length } => {
            SharedShape::cylinder(real(*half_length), real(*radius))
        }
        Primitive::Capsule { radius, half_length } => {
            SharedShape::capsule_y(real(*half_length), real(*radius))
        }
        Primitive::Ball { radius } => SharedShape::ball(real(*radius)),
        Primitive::Convex { hull } => {
            let corners = hull.vertices.iter().map(engines).collect();
            match SharedShape::convex_mesh(corners, &hull.triangles) {
                Some(shape) => shape,
                // It looks at how triangles hang together, not at numbers: the same in both builds.
                None => unreachable!("`Primitive::convex` has tried this hull"),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Vector3};

    use super::super::convert::{number, ours};
    use super::super::rapier::math::Real;
    use super::*;

    /// What rounding to the engine's numbers may cost.
    fn rounding() -> f64 {
        10.0 * number(Real::EPSILON)
    }

    fn part(primitive: Primitive) -> ConvexPart {
        ConvexPart { name: None, primitive, pose: Isometry3::identity(), mass: 1.0 }
    }

    #[test]
    fn the_engine_gets_the_same_solid() {
        let corners = (0..8).map(|i| Vector3::from_fn(|axis, _| f64::from(i >> axis & 1)));
        for primitive in [
            Primitive::Cuboid { half: [0.5, 1.0, 1.5] },
            Primitive::Cylinder { radius: 0.5, half_length: 1.0 },
            Primitive::Capsule { radius: 0.5, half_length: 1.0 },
            Primitive::Ball { radius: 0.5 },
            Primitive::convex(&corners.collect::<Vec<_>>()).unwrap(),
        ] {
            let volume = primitive.volume();
            let theirs = number(shape(&part(primitive)).mass_properties(1.0).mass());
            assert!((theirs / volume - 1.0).abs() < rounding(), "{theirs} {volume}");
        }
    }

    #[test]
    fn hulls_of_rough_and_flat_clouds_suit_the_engine() {
        for exponent in -9..=0 {
            for n in [5, 8, 21] {
                let noise = 10f64.powi(exponent);
                let node = |i: usize| {
                    let flat = Vector3::new((i / n) as f64, (i % n) as f64, 0.0);
                    flat + noise * (crate::geometry::halton(i) - Vector3::repeat(0.5))
                };
                let convex = part(Primitive::convex(&(0..n * n).map(node).collect::<Vec<_>>()).unwrap());
                let shape = shape(&convex);
                let theirs = shape.as_support_map().unwrap();
                for i in 0..100 {
                    let direction = crate::geometry::halton(i) - Vector3::repeat(0.5);
                    let point = ours(theirs.local_support_point(engines(&direction)));
                    let missed = direction.dot(&(point - convex.support(&direction)));
                    assert!(missed.abs() < n as f64 * rounding(), "{missed}");
                }
                assert!(convex.primitive.thickness() <= noise);
            }
        }
    }
}
