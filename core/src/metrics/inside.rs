//! How many cables go through the target.
//!
//! A cable counts when its middle line meets the solid of any part. One that lies on the surface as
//! it should stays a radius away; one that counts is pressed in by more than its radius, cuts a
//! corner, or goes right through. Contact of knots alone leaves such cables wherever a mesh spans
//! an edge; the effect `cable_contact` is to leave none.

use nalgebra::Vector3;
use parry3d::math::{Pose, Vector as ParryVector};
use parry3d::query::details::intersection_test_support_map_support_map_with_params as meet;
use parry3d::query::gjk::VoronoiSimplex;
use parry3d::shape::{Segment, SupportMap};

use crate::cable::Cable;
use crate::state::Body;
use crate::target::Target;
use crate::target::parts::ConvexPart;

/// The parts of a target, ready to be asked.
pub struct Inside {
    solids: Vec<PartSupport>,
    bounding_radius: f64,
}

/// A part in the body frame, as the library sees convex bodies.
struct PartSupport {
    part: ConvexPart,
    /// A ball around it: centre and radius [m].
    ball: (Vector3<f64>, f64),
}

impl SupportMap for PartSupport {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        parrys(&self.part.support(&Vector3::new(direction.x, direction.y, direction.z)))
    }
}

impl PartSupport {
    /// Whether a plane across `direction` keeps all of the part from the line between two points.
    fn is_below(&self, direction: &Vector3<f64>, ends: [&Vector3<f64>; 2]) -> bool {
        let highest = direction.dot(&self.part.support(direction));
        ends.iter().all(|end| direction.dot(end) > highest)
    }
}

impl Inside {
    /// For the parts of `target`.
    pub fn of(target: &Target) -> Inside {
        let solid = |part: &ConvexPart| PartSupport { part: part.clone(), ball: part.bounding_ball() };
        Inside { solids: target.parts.iter().map(solid).collect(), bounding_radius: target.bounding_radius }
    }

    /// Number of `cables` between `knots` [m] that go through the target at `body`.
    pub fn count(&self, cables: &[Cable], knots: &[Vector3<f64>], body: &Body) -> usize {
        let at: Vec<Vector3<f64>> = knots.iter().map(body.all_to_body()).collect();
        cables.iter().filter(|cable| self.meets(at[cable.a], at[cable.b])).count()
    }

    /// The same of cables of several pieces each, given their ends.
    pub fn count_lines(&self, cables: &[Vec<Vector3<f64>>], body: &Body) -> usize {
        let goes_through = |line: &&Vec<Vector3<f64>>| {
            line.windows(2).any(|ends| self.meets(body.to_body(&ends[0]), body.to_body(&ends[1])))
        };
        cables.iter().filter(goes_through).count()
    }

    /// Whether the line from `a` to `b`, in the body frame, meets a part.
    fn meets(&self, a: Vector3<f64>, b: Vector3<f64>) -> bool {
        // Bounds first: most cables are far from the target, and from most of its parts.
        to_line(&Vector3::zeros(), &a, &b).norm() <= self.bounding_radius
            && self.solids.iter().any(|solid| {
                let (centre, radius) = &solid.ball;
                let outwards = to_line(centre, &a, &b);
                let ends = [&a, &b];
                outwards.norm() <= *radius
                    && !solid.is_below(&outwards, ends)
                    && !solid.part.has_face_below(ends)
                    && {
                        // Most cables are outside: the search for a gap begins where it is likely.
                        let (line, first) =
                            (Segment::new(parrys(&a), parrys(&b)), outwards.try_normalize(0.0));
                        let first = first.as_ref().map(parrys);
                        meet(&Pose::IDENTITY, solid, &line, &mut VoronoiSimplex::new(), first).0
                    }
            })
    }
}

/// From `point` to the nearest point of the line from `a` to `b`.
fn to_line(point: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    let along = b - a;
    let share = (along.dot(&(point - a)) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    a + share * along - point
}

fn parrys(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}
