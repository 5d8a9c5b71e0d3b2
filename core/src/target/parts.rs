//! The convex parts of a target, and how a part as written becomes them.
//!
//! Round parts have their axis along their own y. A primitive sits at the origin of its own frame;
//! its pose takes that frame to the frame of the shape or, in a finished target, of the body.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use parry3d::mass_properties::MassProperties;
use parry3d::math::Vector as ParryVector;
use parry3d::shape::SharedShape;

use super::files::Files;
use super::moments::Moments;
use super::{import, spec};
use crate::geometry::Hull;
use crate::limits::Limit;
use crate::problems::Problems;
use crate::read::join;

/// Shortest and longest length of a part [m]: beyond them a key is in the wrong unit, and products
/// of lengths leave the range of the numbers.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Points on a full circle that stand for a round part in the hull of a target. They lie on the
/// part, so its hull misses 0.2 % of a cylinder's volume and 1.1 % of a ball's.
const CIRCLE_POINTS: usize = 64;
/// Rings of points from pole to pole of a ball, the poles not counted; odd, so that one is the
/// equator.
const BALL_RINGS: usize = 15;

/// A convex solid in its own frame.
#[derive(Clone, Debug)]
pub enum Primitive {
    /// Box.
    Cuboid {
        /// Half sides along x, y, z [m].
        half: [f64; 3],
    },
    /// Cylinder along y.
    Cylinder {
        /// Radius [m].
        radius: f64,
        /// Half its length [m].
        half_length: f64,
    },
    /// Cylinder along y with half balls beyond both ends.
    Capsule {
        /// Radius [m].
        radius: f64,
        /// Half the length of the cylindrical piece [m].
        half_length: f64,
    },
    /// Ball.
    Ball {
        /// Radius [m].
        radius: f64,
    },
    /// Hull of points; made by [`Primitive::convex`].
    Convex {
        /// The hull, with its corners.
        hull: Hull,
    },
}

/// A convex part of a target.
#[derive(Clone, Debug)]
pub struct ConvexPart {
    /// What it is.
    pub name: Option<String>,
    /// Its form.
    pub primitive: Primitive,
    /// Body frame (or the shape's, while loading) from the part's frame.
    pub pose: Isometry3<f64>,
    /// Mass [kg].
    pub mass: f64,
}

/// A part as written, made of one convex part or, for a mesh, of several.
#[derive(Clone, Debug)]
pub struct Solid {
    /// The convex parts, in the frame of the shape, their masses not yet known.
    pub pieces: Vec<ConvexPart>,
    /// Moments in the frame of the shape. Those of a mesh are of its surface, not of its pieces.
    pub moments: Moments,
    /// Mass [kg], where the part has its own.
    pub own_mass: Option<f64>,
}

impl Primitive {
    /// Convex hull of `points`; `None` when they span no volume, or the engine refuses the hull.
    pub fn convex(points: &[Vector3<f64>]) -> Option<Primitive> {
        let hull = Hull::of(points)?;
        let corners = hull.vertices.iter().map(to_parry).collect();
        SharedShape::convex_mesh(corners, &hull.triangles)?;
        Some(Primitive::Convex { hull })
    }

    /// Volume [m^3].
    pub fn volume(&self) -> f64 {
        self.moments().volume
    }

    /// Volume, centroid and inertia at unit density.
    pub fn moments(&self) -> Moments {
        let properties = match *self {
            Primitive::Cuboid { half } => MassProperties::from_cuboid(1.0, half.into()),
            Primitive::Cylinder { radius, half_length } => {
                MassProperties::from_cylinder(1.0, half_length, radius)
            }
            Primitive::Capsule { radius, half_length } => {
                let end = ParryVector::new(0.0, half_length, 0.0);
                MassProperties::from_capsule(1.0, -end, end, radius)
            }
            Primitive::Ball { radius } => MassProperties::from_ball(1.0, radius),
            // The engine would pass through eigenvectors here; the direct sum keeps all digits.
            Primitive::Convex { ref hull } => {
                return Moments::of_surface(&hull.vertices, &hull.triangles);
            }
        };
        // All of these have their own axes as principal axes.
        let inertia = properties.principal_inertia();
        Moments {
            volume: properties.mass(),
            centroid: Vector3::zeros(),
            inertia: Matrix3::from_diagonal(&Vector3::new(inertia.x, inertia.y, inertia.z)),
        }
    }

    /// Least extent [m]; of a hull the least width across a face.
    pub fn thickness(&self) -> f64 {
        match self {
            Primitive::Cuboid { half: [x, y, z] } => 2.0 * x.min(*y).min(*z),
            Primitive::Cylinder { radius, half_length } => 2.0 * radius.min(*half_length),
            Primitive::Capsule { radius, .. } | Primitive::Ball { radius } => 2.0 * radius,
            Primitive::Convex { hull } => hull.thickness(),
        }
    }

    /// The point furthest along `direction`, which must not be zero [m].
    pub fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let radial = Vector3::new(direction.x, 0.0, direction.z).try_normalize(0.0);
        let along = |half_length: f64| Vector3::new(0.0, half_length.copysign(direction.y), 0.0);
        match self {
            Primitive::Cuboid { half } => Vector3::from_fn(|i, _| half[i].copysign(direction[i])),
            Primitive::Cylinder { radius, half_length } => {
                along(*half_length) + *radius * radial.unwrap_or_default()
            }
            Primitive::Capsule { radius, half_length } => {
                along(*half_length) + *radius * direction.normalize()
            }
            Primitive::Ball { radius } => *radius * direction.normalize(),
            Primitive::Convex { hull } => {
                let height = |v: &&Vector3<f64>| direction.dot(v);
                let highest = hull.vertices.iter().max_by(|a, b| height(a).total_cmp(&height(b)));
                highest.copied().unwrap_or_default()
            }
        }
    }

    /// Distance from `point` to the furthest point of the solid [m].
    pub fn reach_from(&self, point: &Vector3<f64>) -> f64 {
        let off_axis = point.x.hypot(point.z);
        match self {
            Primitive::Cuboid { half } => (point.abs() + Vector3::from(*half)).norm(),
            Primitive::Cylinder { radius, half_length } => {
                (off_axis + radius).hypot(point.y.abs() + half_length)
            }
            Primitive::Capsule { radius, half_length } => {
                off_axis.hypot(point.y.abs() + half_length) + radius
            }
            Primitive::Ball { radius } => point.norm() + radius,
            Primitive::Convex { hull } => {
                hull.vertices.iter().map(|vertex| (vertex - point).norm()).fold(0.0, f64::max)
            }
        }
    }

    /// Whether `point` is inside.
    pub fn contains(&self, point: &Vector3<f64>) -> bool {
        match self {
            Primitive::Convex { hull, .. } => hull.contains(point),
            _ => self.depth(point) >= 0.0,
        }
    }

    /// How deep `point` is inside: the distance to the surface, negative outside [m].
    pub fn depth(&self, point: &Vector3<f64>) -> f64 {
        let off_axis = point.x.hypot(point.z);
        // Of what lies along several axes at once: the least inside, the distance of the corner outside.
        let least = |inside: &[f64]| {
            let outside: f64 = inside.iter().map(|d| d.min(0.0).powi(2)).sum();
            if outside > 0.0 { -outside.sqrt() } else { inside.iter().copied().fold(f64::MAX, f64::min) }
        };
        match self {
            Primitive::Cuboid { half } => {
                least(&[half[0] - point.x.abs(), half[1] - point.y.abs(), half[2] - point.z.abs()])
            }
            Primitive::Cylinder { radius, half_length } => {
                least(&[radius - off_axis, half_length - point.y.abs()])
            }
            Primitive::Capsule { radius, half_length } => {
                radius - off_axis.hypot((point.y.abs() - half_length).max(0.0))
            }
            Primitive::Ball { radius } => radius - point.norm(),
            Primitive::Convex { hull } => hull.depth(point),
        }
    }

    /// At which share of the way from one point to another it is deepest inside, and how deep [m].
    pub fn deepest_at(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> (f64, f64) {
        let depth = |share: f64| self.depth(&(from + share * (to - from)));
        let share = deepest(depth);
        (share, depth(share))
    }

    /// How far `point` is outside at least [m]: of a hull what the farthest of its faces says. Not above zero inside.
    pub fn clearance(&self, point: &Vector3<f64>) -> f64 {
        match self {
            Primitive::Convex { hull } => hull.farthest_height(point),
            _ => -self.depth(point),
        }
    }

    /// Whether `point` is surely farther than `distance` outside [m]: at once where one face says so.
    pub fn is_farther(&self, point: &Vector3<f64>, distance: f64) -> bool {
        match self {
            Primitive::Convex { hull } => hull.planes.iter().any(|plane| plane.height(point) > distance),
            _ => self.depth(point) < -distance,
        }
    }

    /// Whether all of the line between two points is outside of one flat face.
    pub fn has_face_below(&self, ends: [&Vector3<f64>; 2]) -> bool {
        let beyond = |axis: usize, half: f64| {
            ends.iter().all(|end| end[axis] > half) || ends.iter().all(|end| end[axis] < -half)
        };
        match self {
            Primitive::Cuboid { half } => (0..3).any(|axis| beyond(axis, half[axis])),
            Primitive::Cylinder { half_length, .. } => beyond(1, *half_length),
            Primitive::Convex { hull } => hull.has_face_below(ends),
            Primitive::Capsule { .. } | Primitive::Ball { .. } => false,
        }
    }

    /// Points on the solid whose hull stands for it; round solids lose a little (see
    /// [`CIRCLE_POINTS`]).
    pub(super) fn hull_points(&self) -> Vec<Vector3<f64>> {
        let ring = |radius: f64, y: f64| {
            (0..CIRCLE_POINTS).map(move |i| {
                let (sin, cos) = (i as f64 * TAU / CIRCLE_POINTS as f64).sin_cos();
                Vector3::new(radius * cos, y, radius * sin)
            })
        };
        // A ball pulled apart at its equator by the length of the cylindrical piece.
        let capped = |radius: f64, half_length: f64| {
            let mut points = vec![
                Vector3::new(0.0, radius + half_length, 0.0),
                Vector3::new(0.0, -radius - half_length, 0.0),
            ];
            for i in 0..=BALL_RINGS / 2 {
                let (sin, cos) = (i as f64 * TAU / 2.0 / (BALL_RINGS + 1) as f64).sin_cos();
                points.extend(ring(radius * cos, radius * sin + half_length));
                points.extend(ring(radius * cos, -radius * sin - half_length));
            }
            points
        };
        match self {
            Primitive::Cuboid { half: [x, y, z] } => (0..8)
                .map(|corner| {
                    let sign = |bit: i32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                    Vector3::new(sign(0) * x, sign(1) * y, sign(2) * z)
                })
                .collect(),
            Primitive::Cylinder { radius, half_length } => {
                ring(*radius, *half_length).chain(ring(*radius, -half_length)).collect()
            }
            Primitive::Capsule { radius, half_length } => capped(*radius, *half_length),
            Primitive::Ball { radius } => capped(*radius, 0.0),
            Primitive::Convex { hull } => hull.vertices.clone(),
        }
    }
}

impl ConvexPart {
    /// Volume [m^3].
    pub fn volume(&self) -> f64 {
        self.primitive.volume()
    }

    /// Whether a point of the body frame is inside.
    pub fn contains(&self, point: &Vector3<f64>) -> bool {
        self.primitive.contains(&self.to_part(point))
    }

    /// How deep a point of the body frame is inside (see [`Primitive::depth`]) [m].
    pub fn depth(&self, point: &Vector3<f64>) -> f64 {
        self.primitive.depth(&self.to_part(point))
    }

    /// How deep the way from one point of the body frame to another comes inside [m].
    pub fn deepest_between(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
        self.deepest_at(from, to).1
    }

    /// At which share of the way from one point of the body frame to another it is deepest inside, and how deep [m].
    pub fn deepest_at(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> (f64, f64) {
        self.primitive.deepest_at(&self.to_part(from), &self.to_part(to))
    }

    /// How far a point of the body frame is outside at least (see [`Primitive::clearance`]) [m].
    pub fn clearance(&self, point: &Vector3<f64>) -> f64 {
        self.primitive.clearance(&self.to_part(point))
    }

    /// Whether a point of the body frame is surely farther than `distance` outside [m].
    pub fn is_farther(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.primitive.is_farther(&self.to_part(point), distance)
    }

    /// Whether all of the line between two points of the body frame is outside of one flat face.
    pub fn has_face_below(&self, [a, b]: [&Vector3<f64>; 2]) -> bool {
        self.primitive.has_face_below([&self.to_part(a), &self.to_part(b)])
    }

    /// Points of the part, in the body frame, that make the hull of the whole target.
    pub fn hull_points(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.primitive.hull_points().into_iter().map(|point| self.to_body(&point))
    }

    /// The part as a polyhedron in the body frame: its own hull, or that of points on a round one; `None` where it is too
    /// thin to have one.
    pub fn hull(&self) -> Option<Hull> {
        Hull::of(&self.hull_points().collect::<Vec<_>>())
    }

    /// The furthest point along `direction`, both in the body frame [m].
    pub fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let direction = self.pose.rotation.inverse_transform_vector(direction);
        self.to_body(&self.primitive.support(&direction))
    }

    /// Distance from the origin of the body frame to the furthest point of the part [m].
    pub fn bounding_radius(&self) -> f64 {
        self.primitive.reach_from(&self.to_part(&Vector3::zeros()))
    }

    /// A ball around the part: its centre in the body frame, and its radius [m].
    pub fn bounding_ball(&self) -> (Vector3<f64>, f64) {
        (self.to_body(&Vector3::zeros()), self.primitive.reach_from(&Vector3::zeros()))
    }

    /// A point of its own frame in the body frame [m].
    pub fn to_body(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.pose.transform_point(&(*point).into()).coords
    }

    /// A point of the body frame in its own [m].
    pub fn to_part(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.pose.inverse_transform_point(&(*point).into()).coords
    }
}

/// Where on [0, 1] a concave function is largest.
pub(super) fn deepest(depth: impl Fn(f64) -> f64) -> f64 {
    least([0.0, 1.0], |share| -depth(share))
}

/// Where a function with one minimum in a range has it, by golden sections.
pub(super) fn least([mut low, mut high]: [f64; 2], value: impl Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    for _ in 0..40 {
        let (a, b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if value(a) > value(b) {
            low = a;
        } else {
            high = b;
        }
    }
    0.5 * (low + high)
}

impl Solid {
    /// Makes a part as written, found at `place`, into a solid. `files` are those that its
    /// file may name.
    pub fn from_spec(
        part: &spec::Part,
        files: &Files<'_>,
        place: &str,
        problems: &mut Problems,
    ) -> Option<Solid> {
        let given = forms_of(part);
        let &[form] = given.as_slice() else {
            let found = if given.is_empty() { "none of them".to_owned() } else { given.join(", ") };
            problems.add(place, found, "exactly one of cuboid, cylinder, capsule, ball, convex, mesh");
            return None;
        };
        let place = join(place, form);
        let (primitives, moments) = match &part.mesh {
            Some(mesh) => {
                let mesh = import::load(mesh, files, &place, problems)?;
                (mesh.pieces, mesh.moments)
            }
            None => {
                let n_points = part.convex.as_ref().map_or(0, |convex| convex.points_m.len());
                if files.limits.exceeded(Limit::Points, n_points as f64) {
                    problems.add(place, format!("{n_points} points"), files.limits.allowed(Limit::Points));
                    return None;
                }
                let Some(primitive) = primitive(part) else {
                    problems.add(
                        place,
                        "points that span no volume",
                        "four points or more, not in one plane",
                    );
                    return None;
                };
                let moments = primitive.moments();
                (vec![primitive], moments)
            }
        };
        let pose = pose_of(part);
        let piece = |primitive| ConvexPart { name: part.name.clone(), primitive, pose, mass: 0.0 };
        let pieces: Vec<ConvexPart> = primitives.into_iter().map(piece).collect();
        for length in pieces.iter().flat_map(|piece| [piece.primitive.thickness(), piece.bounding_radius()]) {
            if !LENGTHS.contains(&length) {
                let allowed = "thickness and distance from the shape's origin from 1e-6 m to 1e6 m";
                problems.add(place, format!("a length of {length:e} m"), allowed);
                return None;
            }
        }
        Some(Solid { pieces, moments: moments.moved(&pose), own_mass: part.mass_kg.map(|mass| mass.0) })
    }
}

/// The forms that a part has.
fn forms_of(part: &spec::Part) -> Vec<&'static str> {
    [
        ("cuboid", part.cuboid.is_some()),
        ("cylinder", part.cylinder.is_some()),
        ("capsule", part.capsule.is_some()),
        ("ball", part.ball.is_some()),
        ("convex", part.convex.is_some()),
        ("mesh", part.mesh.is_some()),
    ]
    .into_iter()
    .filter_map(|(form, given)| given.then_some(form))
    .collect()
}

/// The form of a part that is no mesh; `None` for points that span no volume.
fn primitive(part: &spec::Part) -> Option<Primitive> {
    if let Some(sides) = part.cuboid {
        Some(Primitive::Cuboid { half: sides.map(|side| side.0 / 2.0) })
    } else if let Some(round) = part.cylinder {
        Some(Primitive::Cylinder { radius: round.radius_m.0, half_length: round.length_m.0 / 2.0 })
    } else if let Some(round) = part.capsule {
        Some(Primitive::Capsule { radius: round.radius_m.0, half_length: round.length_m.0 / 2.0 })
    } else if let Some(ball) = part.ball {
        Some(Primitive::Ball { radius: ball.radius_m.0 })
    } else {
        let points: Vec<_> = part.convex.as_ref()?.points_m.iter().map(|&point| point.into()).collect();
        Primitive::convex(&points)
    }
}

fn pose_of(part: &spec::Part) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(part.position_m), turns(part.attitude_deg))
}

/// Turns about the body's own x, then y, then z [deg]: R = Rx Ry Rz.
pub fn turns(degrees: [f64; 3]) -> UnitQuaternion<f64> {
    let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
    let turns = axes.iter().zip(degrees);
    turns.fold(UnitQuaternion::identity(), |turned, (axis, angle)| {
        turned * UnitQuaternion::from_axis_angle(axis, angle.to_radians())
    })
}

pub(super) fn to_parry(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

pub(super) fn from_parry(v: &ParryVector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn primitives() -> [Primitive; 5] {
        let corners = Primitive::Cuboid { half: [0.5, 1.0, 1.5] }.hull_points();
        [
            Primitive::Cuboid { half: [0.5, 1.0, 1.5] },
            Primitive::Cylinder { radius: 0.5, half_length: 1.0 },
            Primitive::Capsule { radius: 0.5, half_length: 1.0 },
            Primitive::Ball { radius: 0.5 },
            Primitive::convex(&corners).unwrap(),
        ]
    }

    #[test]
    fn volumes_and_inertias_in_closed_form() {
        let (r, l) = (0.5f64, 2.0f64);
        let ball = 4.0 / 3.0 * PI * r.powi(3);
        let rod = PI * r * r * l;
        let cuboid = (6.0, [(4.0 + 9.0) / 2.0, (1.0 + 9.0) / 2.0, (1.0 + 4.0) / 2.0]);
        let across_rod = rod * (r * r / 4.0 + l * l / 12.0);
        // Half balls: centroids 3 r / 8 beyond the ends.
        let across_caps = ball * (0.4 * r * r + l * l / 4.0 + 3.0 / 8.0 * r * l);
        let expected = [
            cuboid,
            (rod, [across_rod, rod * r * r / 2.0, across_rod]),
            (
                rod + ball,
                [across_rod + across_caps, rod * r * r / 2.0 + 0.4 * ball * r * r, across_rod + across_caps],
            ),
            (ball, [0.4 * ball * r * r; 3]),
            cuboid,
        ];
        for (primitive, (volume, inertia)) in primitives().iter().zip(expected) {
            let moments = primitive.moments();
            assert!((moments.volume / volume - 1.0).abs() < 1e-14, "{primitive:?}");
            assert!(moments.centroid.norm() < 1e-14);
            let by_hand = Matrix3::from_diagonal(&inertia.into());
            assert!((moments.inertia - by_hand).amax() < 1e-13, "{primitive:?} {}", moments.inertia);
        }
    }

    #[test]
    fn small_parts_keep_their_digits() {
        let moments = Primitive::Cuboid { half: [5e-4, 1e-3, 1.5e-3] }.moments();
        assert!((moments.volume / 6e-9 - 1.0).abs() < 1e-12);
        assert!((moments.inertia[(0, 0)] / 6.5e-15 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn support_reach_and_containment_agree() {
        for primitive in primitives() {
            let furthest = primitive.reach_from(&Vector3::new(0.3, -2.0, 0.1));
            let mut reached = 0.0f64;
            for i in 0..2000 {
                let direction = crate::geometry::halton(i) - Vector3::repeat(0.5);
                let point = primitive.support(&direction);
                assert!(primitive.contains(&(0.999_999 * point)), "{primitive:?} {point}");
                assert!(!primitive.contains(&(point + 1e-3 * direction)), "{primitive:?} {point}");
                let highest =
                    primitive.hull_points().iter().map(|p| p.dot(&direction)).fold(f64::MIN, f64::max);
                assert!(highest <= point.dot(&direction) + 1e-12);
                assert!(highest > 0.99 * point.dot(&direction));
                reached = reached.max((point - Vector3::new(0.3, -2.0, 0.1)).norm());
            }
            assert!(reached <= furthest + 1e-12 && reached > 0.99 * furthest, "{reached} {furthest}");
        }
    }

    #[test]
    fn thickness_is_the_least_extent() {
        let expected = [1.0, 1.0, 1.0, 1.0, 1.0];
        for (primitive, expected) in primitives().iter().zip(expected) {
            assert!((primitive.thickness() - expected).abs() < 1e-12, "{primitive:?}");
        }
    }

    #[test]
    fn deepest_point_of_a_way_through_a_panel() {
        let primitive = Primitive::Cuboid { half: [1e-3, 1.0, 1.0] };
        let (from, to) = (Vector3::new(-0.9, 0.0, 0.0), Vector3::new(0.1, 0.2, 0.0));
        let depth = |share: f64| primitive.depth(&(from + share * (to - from)));
        let deepest = depth(deepest(depth));
        assert!((deepest - 1e-3).abs() < 1e-8, "{deepest}");
    }
}
