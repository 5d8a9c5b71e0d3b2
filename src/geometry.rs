//! Plain geometry: convex hulls, the area of a polygon in space, quasi-random points.
//!
//! # The hull is exact on a lattice
//!
//! A net folds flat, lies in a plane or holds knots on one line, and a hull that decides "above or
//! below this face" with rounded numbers then loses points or breaks down. So the points are moved
//! to an integer lattice of 2^40 steps along the longest side of their box (1e-12 of it, far below
//! anything measured here), where the question has an exact answer: with p, a, b, c integers,
//!
//! h = ((b − a) × (c − a)) · (p − a)
//!
//! fits 128 bits, and its sign is that of the height of p above the face (a, b, c). A floating
//! value is tried first and believed when it exceeds its own rounding error. With exact signs the
//! quickhull of Barber, Dobkin and Huhdanpaa (1996) needs no tolerance and no special cases: a face
//! is removed only when the new point is strictly above it, the rest is a closed disc, and no
//! triangle without area can arise.
//!
//! Why not the engine's hull: it takes a cloud as flat once its thickness is below about 1/1000 of
//! its extent, which a folded net is, and returns a hull that most knots stick out of (40 of 40
//! nets of 21 x 21 knots with out-of-plane noise from 1e-9 to 1e-2 of the mesh length).
//!
//! Cost for 441 points: 0.02 to 0.06 ms for nets, 0.17 ms when every point is a corner (two shared
//! cores, `cargo test`'s profile).

use nalgebra::Vector3;
use parry3d::query::PointQuery;

/// Steps of the lattice along the longest side of the box of the points. With 2^40 the height
/// above stays below 2^123.
const LATTICE_STEPS: f64 = (1u64 << 40) as f64;

/// Steps below which a cloud is flat: its points then are off a plane by their own rounding only.
const FLAT_STEPS: f64 = 16.0;

/// A point counts as inside the hull up to this share of its box's longest side beyond a face.
const CONTAINS_SLACK: f64 = 1e-9;

/// Convex hull of a cloud of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// Corners [m]: points of the cloud, unmoved; some may lie within a face or an edge.
    pub vertices: Vec<Vector3<f64>>,
    /// Faces, counter-clockwise seen from outside, as places in `vertices`.
    pub triangles: Vec<[u32; 3]>,
    /// Plane of each triangle.
    pub planes: Vec<Plane>,
    /// Slack of [`Hull::contains`] [m].
    slack: f64,
}

/// A plane of a hull: outside is where normal · p > offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal, outward.
    pub normal: Vector3<f64>,
    /// normal · p of every point p of the plane [m].
    pub offset: f64,
}

impl Hull {
    /// Hull of `points`; `None` where there is none to speak of: fewer than four points, a
    /// coordinate that is not finite, or all points in one plane (to 1.5e-11 of their extent).
    pub fn of(points: &[Vector3<f64>]) -> Option<Hull> {
        let lattice = Lattice::around(points)?;
        let cloud: Vec<[i64; 3]> = points.iter().map(|point| lattice.snap(point)).collect();
        let mut growth = Growth::start(&cloud)?;
        growth.finish();

        let mut place = vec![NONE; points.len()];
        let mut hull =
            Hull { vertices: Vec::new(), triangles: Vec::new(), planes: Vec::new(), slack: lattice.slack() };
        for face in growth.faces.iter().filter(|face| face.alive) {
            let corners = face.corners.map(|corner| {
                let corner = corner as usize;
                if place[corner] == NONE {
                    place[corner] = hull.vertices.len() as u32;
                    hull.vertices.push(points[corner]);
                }
                place[corner]
            });
            // The normal from the lattice is right even for a sliver, where one from the rounded
            // points would be noise.
            let normal = Vector3::from(face.normal).normalize();
            hull.triangles.push(corners);
            hull.planes.push(Plane { normal, offset: normal.dot(&points[face.corners[0] as usize]) });
        }
        Some(hull)
    }

    /// Volume [m^3].
    ///
    /// V = 1/6 Σ a · (b × c) over the faces, corners relative to one point of the hull.
    pub fn volume(&self) -> f64 {
        let origin = self.vertices[0];
        let six_fold: f64 = self
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|corner| self.vertices[corner as usize] - origin);
                a.dot(&b.cross(&c))
            })
            .sum();
        six_fold / 6.0
    }

    /// Surface [m^2].
    pub fn surface(&self) -> f64 {
        let two_fold: f64 = self
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|corner| self.vertices[corner as usize]);
                (b - a).cross(&(c - a)).norm()
            })
            .sum();
        two_fold / 2.0
    }

    /// Whether `point` is inside, a slack of 1e-9 of the box's longest side included.
    pub fn contains(&self, point: &Vector3<f64>) -> bool {
        self.planes.iter().all(|plane| plane.normal.dot(point) <= plane.offset + self.slack)
    }

    /// How deep `point` is inside: the distance to the surface, negative outside [m].
    pub fn depth(&self, point: &Vector3<f64>) -> f64 {
        let inside =
            self.planes.iter().map(|plane| plane.offset - plane.normal.dot(point)).fold(f64::MAX, f64::min);
        if inside >= 0.0 {
            return inside;
        }
        // Near an edge the surface is farther than the planes that meet there.
        let corner = |i: u32| {
            let vertex = &self.vertices[i as usize];
            parry3d::math::Vector::new(vertex.x, vertex.y, vertex.z)
        };
        let distance = |&[a, b, c]: &[u32; 3]| {
            let triangle = parry3d::shape::Triangle::new(corner(a), corner(b), corner(c));
            triangle.distance_to_local_point(parry3d::math::Vector::new(point.x, point.y, point.z), true)
        };
        -self.triangles.iter().map(distance).fold(f64::MAX, f64::min)
    }
}

/// Vector area of a closed polygon in space [m^2]: its direction is the normal of a flat polygon
/// that runs counter-clockwise, its length the area that the outline spans.
///
/// A = 1/2 Σ (pᵢ − p₀) × (pᵢ₊₁ − p₀)
pub fn vector_area(polygon: impl IntoIterator<Item = Vector3<f64>>) -> Vector3<f64> {
    let mut points = polygon.into_iter();
    let Some(first) = points.next() else { return Vector3::zeros() };
    let mut area = Vector3::zeros();
    let mut last = Vector3::zeros();
    for point in points {
        let next = point - first;
        area += last.cross(&next);
        last = next;
    }
    area / 2.0
}

/// The `index`-th quasi-random point of the unit cube: Halton's sequence in bases 2, 3 and 5.
///
/// Fills the cube more evenly than random points and needs no seed.
pub fn halton(index: usize) -> Vector3<f64> {
    Vector3::new(radical_inverse(2, index), radical_inverse(3, index), radical_inverse(5, index))
}

/// Digits of `index` + 1 in a base, mirrored at the point: evenly spread over (0, 1).
///
/// From 1 on, since 0 would be a corner of the cube in every base.
pub fn radical_inverse(base: usize, index: usize) -> f64 {
    let mut rest = index + 1;
    let mut digit_value = 1.0;
    let mut value = 0.0;
    while rest > 0 {
        digit_value /= base as f64;
        value += (rest % base) as f64 * digit_value;
        rest /= base;
    }
    value
}

/// The lattice on which the hull is exact.
struct Lattice {
    low: Vector3<f64>,
    extent: f64,
}

impl Lattice {
    fn around(points: &[Vector3<f64>]) -> Option<Lattice> {
        let first = *points.first()?;
        let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        let extent = (high - low).max();
        // A NaN may hide from inf and sup, hence the look at every point.
        let sound = points.len() >= 4
            && extent > 0.0
            && (LATTICE_STEPS / extent).is_finite()
            && points.iter().all(|point| point.iter().all(|x| x.is_finite()));
        sound.then_some(Lattice { low, extent })
    }

    fn snap(&self, point: &Vector3<f64>) -> [i64; 3] {
        let steps = (point - self.low) * (LATTICE_STEPS / self.extent);
        [steps.x.round() as i64, steps.y.round() as i64, steps.z.round() as i64]
    }

    fn slack(&self) -> f64 {
        CONTAINS_SLACK * self.extent
    }
}

/// No point, no face.
const NONE: u32 = u32::MAX;

/// A face of the growing hull.
struct Face {
    /// Counter-clockwise seen from outside.
    corners: [u32; 3],
    /// The face across each edge; edge i runs from corner i to corner i + 1.
    across: [u32; 3],
    /// (b − a) × (c − a), exact.
    exact_normal: [i128; 3],
    /// The same, rounded.
    normal: [f64; 3],
    /// The points this face answers for, as a list in `Growth::next`; the highest comes first.
    points: u32,
    /// Height of the first of them.
    highest: f64,
    /// Still part of the hull.
    alive: bool,
}

/// An edge between a face that goes and one that stays.
struct HorizonEdge {
    from: u32,
    to: u32,
    /// The face that stays, and which of its edges this is.
    stays: u32,
    side: usize,
}

/// A hull that grows until no point is outside.
struct Growth<'a> {
    cloud: &'a [[i64; 3]],
    faces: Vec<Face>,
    /// The point after each point in the list of its face.
    next: Vec<u32>,
}

impl<'a> Growth<'a> {
    /// A tetrahedron of far apart points, and the other points shared among its faces; `None`
    /// where the cloud is flat.
    fn start(cloud: &'a [[i64; 3]]) -> Option<Growth<'a>> {
        let index = |best: Option<(usize, f64)>| best.filter(|best| best.1 > 0.0).map(|best| best.0);
        let furthest = |measure: &dyn Fn(&[i64; 3]) -> f64| {
            let measures = cloud.iter().map(measure).enumerate();
            index(measures.max_by(|a, b| a.1.total_cmp(&b.1)))
        };
        let squared = |v: [i128; 3]| v.iter().map(|&x| (x as f64) * (x as f64)).sum::<f64>();

        let a = (0..cloud.len()).min_by_key(|&point| cloud[point])?;
        let b = furthest(&|p| squared(minus(p, &cloud[a]).map(i128::from)))?;
        let c = furthest(&|p| squared(cross(minus(&cloud[b], &cloud[a]), minus(p, &cloud[a]))))?;
        let normal = cross(minus(&cloud[b], &cloud[a]), minus(&cloud[c], &cloud[a]));
        let height = |p: &[i64; 3]| exact_dot(&normal, minus(p, &cloud[a]));
        let d = furthest(&|p| height(p).unsigned_abs() as f64)?;
        if (height(&cloud[d]).unsigned_abs() as f64) < FLAT_STEPS * squared(normal).sqrt() {
            return None;
        }

        let [a, b, c, d] = [a, b, c, d].map(|point| point as u32);
        let (b, c) = if height(&cloud[d as usize]) < 0 { (b, c) } else { (c, b) };
        let mut growth = Growth { cloud, faces: Vec::with_capacity(256), next: vec![NONE; cloud.len()] };
        growth.add_face([a, b, c], [1, 2, 3]);
        growth.add_face([b, a, d], [0, 3, 2]);
        growth.add_face([c, b, d], [0, 1, 3]);
        growth.add_face([a, c, d], [0, 2, 1]);
        for point in 0..cloud.len() as u32 {
            growth.share_out(point, 0);
        }
        Some(growth)
    }

    /// Takes in the highest point of each face in turn until no face has points above it.
    fn finish(&mut self) {
        let mut horizon = Vec::new();
        let mut gone = Vec::new();
        let mut face_from = vec![NONE; self.cloud.len()];
        let mut face = 0;
        while face < self.faces.len() {
            if self.faces[face].alive && self.faces[face].points != NONE {
                let apex = self.faces[face].points;
                self.remove_faces_below(apex, face as u32, &mut horizon, &mut gone);
                self.cover(apex, &horizon, &gone, &mut face_from);
            }
            face += 1;
        }
    }

    /// Removes `first` and all other faces that `apex` is above; they are neighbours of one
    /// another. `horizon` gets the outline of the hole.
    fn remove_faces_below(
        &mut self,
        apex: u32,
        first: u32,
        horizon: &mut Vec<HorizonEdge>,
        gone: &mut Vec<u32>,
    ) {
        horizon.clear();
        gone.clear();
        gone.push(first);
        self.faces[first as usize].alive = false;
        let mut visited = 0;
        while visited < gone.len() {
            let Face { corners, across, .. } = self.faces[gone[visited] as usize];
            let here = gone[visited];
            visited += 1;
            for (side, &neighbour) in across.iter().enumerate() {
                if !self.faces[neighbour as usize].alive {
                    continue;
                }
                if self.height(&self.faces[neighbour as usize], apex) > 0.0 {
                    self.faces[neighbour as usize].alive = false;
                    gone.push(neighbour);
                } else if let Some(back) = (0..3).find(|&back| {
                    let other = &self.faces[neighbour as usize];
                    other.across[back] == here && other.corners[back] == corners[(side + 1) % 3]
                }) {
                    let (from, to) = (corners[side], corners[(side + 1) % 3]);
                    horizon.push(HorizonEdge { from, to, stays: neighbour, side: back });
                }
            }
        }
    }

    /// Closes the hole by faces from its outline to `apex`, and hands them the points of the faces
    /// that went. A point above a face that went is inside now or above one of the new faces.
    fn cover(&mut self, apex: u32, horizon: &[HorizonEdge], gone: &[u32], face_from: &mut [u32]) {
        let first_new = self.faces.len();
        for edge in horizon {
            let new = self.faces.len() as u32;
            face_from[edge.from as usize] = new;
            self.faces[edge.stays as usize].across[edge.side] = new;
            self.add_face([edge.from, edge.to, apex], [edge.stays, NONE, NONE]);
        }
        // The outline is one closed round, so a face starts where each face ends.
        for (new, edge) in horizon.iter().enumerate() {
            let following = face_from[edge.to as usize];
            self.faces[first_new + new].across[1] = following;
            self.faces[following as usize].across[2] = (first_new + new) as u32;
        }
        for &old in gone {
            let mut point = self.faces[old as usize].points;
            while point != NONE {
                let following = self.next[point as usize];
                if point != apex {
                    self.share_out(point, first_new);
                }
                point = following;
            }
        }
    }

    fn add_face(&mut self, corners: [u32; 3], across: [u32; 3]) {
        let [a, b, c] = corners.map(|corner| &self.cloud[corner as usize]);
        let exact_normal = cross(minus(b, a), minus(c, a));
        let normal = exact_normal.map(|x| x as f64);
        self.faces.push(Face {
            corners,
            across,
            exact_normal,
            normal,
            points: NONE,
            highest: 0.0,
            alive: true,
        });
    }

    /// Gives `point` to the first face from `first` on that it is above, if there is one.
    fn share_out(&mut self, point: u32, first: usize) {
        for face in first..self.faces.len() {
            let height = self.height(&self.faces[face], point);
            if height <= 0.0 {
                continue;
            }
            let face = &mut self.faces[face];
            if height > face.highest || face.points == NONE {
                self.next[point as usize] = face.points;
                face.points = point;
                face.highest = height;
            } else {
                self.next[point as usize] = self.next[face.points as usize];
                self.next[face.points as usize] = point;
            }
            return;
        }
    }

    /// Height of a point above a face, times twice the face's area; its sign is exact.
    fn height(&self, face: &Face, point: u32) -> f64 {
        // Three products of one rounded factor each and two sums: the error stays below 5 units of
        // 2^-53 of the sum of the products' sizes. The differences of lattice points are exact.
        const ROUNDING: f64 = 1e-15;
        let from_face = minus(&self.cloud[point as usize], &self.cloud[face.corners[0] as usize]);
        let x = face.normal[0] * from_face[0] as f64;
        let y = face.normal[1] * from_face[1] as f64;
        let z = face.normal[2] * from_face[2] as f64;
        let height = x + y + z;
        if height.abs() > ROUNDING * (x.abs() + y.abs() + z.abs()) {
            return height;
        }
        exact_dot(&face.exact_normal, from_face) as f64
    }
}

fn minus(a: &[i64; 3], b: &[i64; 3]) -> [i64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [i64; 3], b: [i64; 3]) -> [i128; 3] {
    let product = |i: usize, j: usize| i128::from(a[i]) * i128::from(b[j]);
    [product(1, 2) - product(2, 1), product(2, 0) - product(0, 2), product(0, 1) - product(1, 0)]
}

fn exact_dot(normal: &[i128; 3], v: [i64; 3]) -> i128 {
    (0..3).map(|i| normal[i] * i128::from(v[i])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::collections::HashMap;

    fn random_point(rng: &mut ChaCha8Rng) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0))
    }

    /// What makes a hull a hull: it holds every point, it is closed and a ball in kind
    /// (V − E + F = 2), its planes face outward, and its volume and surface are numbers.
    fn assert_hull(hull: &Hull, points: &[Vector3<f64>]) {
        for point in points {
            assert!(hull.contains(point), "{point:?} is outside");
        }
        let mut edges = HashMap::new();
        for triangle in &hull.triangles {
            for side in 0..3 {
                *edges.entry((triangle[side], triangle[(side + 1) % 3])).or_insert(0) += 1;
            }
        }
        for (&(from, to), &count) in &edges {
            assert_eq!(count, 1);
            assert!(edges.contains_key(&(to, from)), "an open edge");
        }
        assert_eq!(hull.vertices.len() + hull.triangles.len(), edges.len() / 2 + 2);
        assert!(hull.volume() >= 0.0 && hull.surface() > 0.0);
        for plane in &hull.planes {
            assert!((plane.normal.norm() - 1.0).abs() < 1e-12);
        }
    }

    /// Nodes of a flat square net, `n` to a side, spacing 1, moved by up to `noise` and turned.
    fn net(n: usize, noise: f64, rng: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.3, -1.1, 2.0);
        let mut points = Vec::new();
        for row in 0..n {
            for column in 0..n {
                let flat = Vector3::new(0.0, row as f64, column as f64);
                points.push(turn * (flat + noise * random_point(rng)));
            }
        }
        points
    }

    #[test]
    fn hull_of_a_cube() {
        let mut points: Vec<Vector3<f64>> = Vec::new();
        for i in 0..27 {
            points.push(Vector3::new((i % 3) as f64, (i / 3 % 3) as f64, (i / 9) as f64));
        }
        let hull = Hull::of(&points).unwrap();
        assert_hull(&hull, &points);
        assert!((hull.volume() - 8.0).abs() < 1e-12);
        assert!((hull.surface() - 24.0).abs() < 1e-12);
        assert!(hull.contains(&Vector3::new(2.0, 1.0, 1.0)), "a face is inside");
        assert!(!hull.contains(&Vector3::new(2.0 + 1e-8, 1.0, 1.0)));
        assert!(!hull.contains(&Vector3::new(f64::NAN, 1.0, 1.0)));
    }

    #[test]
    fn no_hull_without_volume() {
        let p = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        let none = |points: &[Vector3<f64>]| assert_eq!(Hull::of(points), None);
        none(&[]);
        none(&[p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.)]);
        none(&[p(3., 3., 3.); 50]);
        none(&(0..50).map(|i| p(i as f64, 0.5 * i as f64, 7.0)).collect::<Vec<_>>());
        none(&(0..441).map(|i| p(2.0, (i / 21) as f64, (i % 21) as f64)).collect::<Vec<_>>());
        none(&[p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.), p(0., 0., f64::NAN)]);
        none(&[p(0., 0., 0.), p(1., 0., 0.), p(0., f64::INFINITY, 0.), p(0., 0., 1.)]);
        none(&[p(-1e308, 0., 0.), p(1e308, 0., 0.), p(0., 1e308, 0.), p(0., 0., 1e308)]);
    }

    #[test]
    fn extreme_scales_neither_panic_nor_lie() {
        for scale in [1e-320, 1e-300, 1e-12, 1.0, 1e12, 1e100, 1e300] {
            let points: Vec<_> = (0..8)
                .map(|i| scale * Vector3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64))
                .collect();
            if let Some(hull) = Hull::of(&points) {
                let relative = hull.volume() / (scale * scale * scale);
                assert!((relative - 1.0).abs() < 1e-9 || !relative.is_normal(), "{scale}: {relative}");
            }
        }
    }

    #[test]
    fn folded_nets_of_every_thickness() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for n in [2, 3, 11, 21] {
            for exponent in -16..=0 {
                for _ in 0..20 {
                    let noise = 10f64.powi(exponent);
                    let points = net(n, noise, &mut rng);
                    let Some(hull) = Hull::of(&points) else {
                        assert!(noise < 1e-10 * n as f64, "noise {noise} taken for flat");
                        continue;
                    };
                    assert_hull(&hull, &points);
                    assert!(hull.volume() < 2.5 * noise * (n * n) as f64 + 30.0 * noise * noise + 1e-9);
                }
            }
        }
    }

    #[test]
    fn grids_duplicates_and_lines_in_a_cloud() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for round in 0..300 {
            let mut points: Vec<_> =
                (0..40).map(|_| random_point(&mut rng).map(|x| (x * 3.0).round() / 3.0)).collect();
            points.extend_from_within(0..20);
            points.extend((0..20).map(|i| Vector3::new(i as f64 * 0.1 - 1.0, 0.3, 0.3)));
            if round % 2 == 0 {
                points.iter_mut().for_each(|point| *point += 1e-13 * random_point(&mut rng));
            }
            assert_hull(&Hull::of(&points).unwrap(), &points);
        }
    }

    /// Volume by trying every triple of points as a face, for clouds in general position.
    fn volume_by_force(points: &[Vector3<f64>]) -> (f64, usize) {
        let centre = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let (mut volume, mut faces) = (0.0, 0);
        for i in 0..points.len() {
            for j in i + 1..points.len() {
                for k in j + 1..points.len() {
                    let normal = (points[j] - points[i]).cross(&(points[k] - points[i]));
                    let above = points.iter().filter(|&p| normal.dot(&(p - points[i])) > 1e-12).count();
                    let below = points.iter().filter(|&p| normal.dot(&(p - points[i])) < -1e-12).count();
                    if above == 0 || below == 0 {
                        volume += (normal.dot(&(points[i] - centre)) / 6.0).abs();
                        faces += 1;
                    }
                }
            }
        }
        (volume, faces)
    }

    #[test]
    fn random_clouds_agree_with_trying_every_face() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for n in [4, 5, 8, 20, 40] {
            for _ in 0..10 {
                let points: Vec<_> = (0..n).map(|_| random_point(&mut rng)).collect();
                let hull = Hull::of(&points).unwrap();
                assert_hull(&hull, &points);
                let (volume, faces) = volume_by_force(&points);
                assert_eq!(hull.triangles.len(), faces);
                assert!((hull.volume() - volume).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn every_point_of_a_ball_is_a_corner() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let points: Vec<_> = (0..2000).map(|_| random_point(&mut rng).normalize()).collect();
        let hull = Hull::of(&points).unwrap();
        assert_hull(&hull, &points);
        assert_eq!(hull.vertices.len(), points.len());
        assert!((hull.volume() / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
    }

    #[test]
    fn vector_area_of_a_square_and_of_none() {
        let square = [(0., 0.), (2., 0.), (2., 2.), (0., 2.)].map(|(y, z)| Vector3::new(5.0, y, z));
        assert_eq!(vector_area(square), Vector3::new(4.0, 0.0, 0.0));
        assert_eq!(vector_area([]), Vector3::zeros());
        let saddle = [(1., 0., 1.), (0., 1., -1.), (-1., 0., 1.), (0., -1., -1.)]
            .map(|(x, y, z)| Vector3::new(x, y, z));
        assert!((vector_area(saddle) - Vector3::new(0.0, 0.0, 2.0)).norm() < 1e-15);
    }

    #[test]
    fn halton_points_fill_the_cube_evenly() {
        assert_eq!(halton(0), Vector3::new(0.5, 1.0 / 3.0, 0.2));
        assert_eq!(halton(1), Vector3::new(0.25, 2.0 / 3.0, 0.4));
        let mean = (0..512).map(halton).sum::<Vector3<f64>>() / 512.0;
        // Measured: 0.0010, 0.0014, 0.0031.
        assert!((mean - Vector3::repeat(0.5)).amax() < 0.005, "{mean}");
    }
}
