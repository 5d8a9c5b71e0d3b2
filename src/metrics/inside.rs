//! How many cables go through the target.
//!
//! A cable counts when its middle line meets the solid of any part. One that lies on the surface as
//! it should stays a radius away; one that counts is pressed in by more than its radius, cuts a
//! corner, or goes right through. Contact of knots alone leaves such cables wherever a mesh spans
//! an edge; the effect `cable_contact` is to leave none.

use parry3d::math::{Pose, Vector as ParryVector};
use parry3d::query::intersection_test;
use parry3d::shape::{Segment, SharedShape};

use nalgebra::Vector3;

use crate::cable::Cable;
use crate::state::Body;
use crate::target::Target;

/// The parts of a target, ready to be asked.
pub struct Inside {
    parts: Vec<(SharedShape, nalgebra::Isometry3<f64>, f64)>,
    bounding_radius: f64,
}

impl Inside {
    /// For the parts of `target`.
    pub fn of(target: &Target) -> Inside {
        let part = |part: &crate::target::parts::ConvexPart| {
            let shape = part.to_parry();
            let radius = shape.compute_local_bounding_sphere();
            (shape, part.pose, radius.center.length() + radius.radius)
        };
        Inside { parts: target.parts.iter().map(part).collect(), bounding_radius: target.bounding_radius }
    }

    /// Number of `cables` between `knots` [m] that go through the target at `body`.
    pub fn count(&self, cables: &[Cable], knots: &[Vector3<f64>], body: &Body) -> usize {
        let in_body = |knot: usize| body.attitude.inverse_transform_vector(&(knots[knot] - body.position));
        cables.iter().filter(|cable| self.meets(in_body(cable.a), in_body(cable.b))).count()
    }

    /// Whether the line from `a` to `b`, in the body frame, meets a part.
    fn meets(&self, a: Vector3<f64>, b: Vector3<f64>) -> bool {
        // Bounds first: most cables are far from the target, and from most of its parts.
        distance_to_line(&Vector3::zeros(), &a, &b) <= self.bounding_radius
            && self.parts.iter().any(|(shape, pose, radius)| {
                if distance_to_line(&pose.translation.vector, &a, &b) > *radius {
                    return false;
                }
                let [a, b] = [a, b].map(|end| pose.inverse_transform_point(&end.into()).coords);
                let line = Segment::new(parrys(&a), parrys(&b));
                // Every part is convex, and the library tests a line against any convex shape.
                intersection_test(&Pose::IDENTITY, shape.as_ref(), &Pose::IDENTITY, &line)
                    .is_ok_and(|found| found.intersecting)
            })
    }
}

fn distance_to_line(point: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let along = b - a;
    let share = (along.dot(&(point - a)) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (a + share * along - point).norm()
}

fn parrys(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}
