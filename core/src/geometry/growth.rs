//! A hull that grows point by point, exact on a lattice.
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

/// Steps of the lattice along the longest side of the box of the points. With 2^40 the height
/// above stays below 2^123.
const LATTICE_STEPS: f64 = (1u64 << 40) as f64;

/// Steps below which a cloud is flat: its points then are off a plane by their own rounding only.
const FLAT_STEPS: f64 = 16.0;

/// The lattice on which the hull is exact.
pub struct Lattice {
    /// Lowest corner of the box of the points [m].
    low: Vector3<f64>,
    /// Its longest side [m].
    pub extent: f64,
}

impl Lattice {
    /// The lattice for `points`; none where there are too few or a coordinate is not finite.
    pub fn around(points: &[Vector3<f64>]) -> Option<Lattice> {
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

    /// The place of `point` [steps].
    pub fn snap(&self, point: &Vector3<f64>) -> [i64; 3] {
        let steps = (point - self.low) * (LATTICE_STEPS / self.extent);
        [steps.x.round() as i64, steps.y.round() as i64, steps.z.round() as i64]
    }
}

/// No point, no face.
pub const NONE: u32 = u32::MAX;

/// A face of the growing hull.
pub struct Face {
    /// Counter-clockwise seen from outside.
    pub corners: [u32; 3],
    /// The face across each edge; edge i runs from corner i to corner i + 1.
    across: [u32; 3],
    /// (b − a) × (c − a), exact.
    exact_normal: [i128; 3],
    /// The same, rounded.
    pub normal: [f64; 3],
    /// The points this face answers for, as a list in `Growth::next`; the highest comes first.
    points: u32,
    /// Height of the first of them.
    highest: f64,
    /// Still part of the hull.
    pub alive: bool,
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
pub struct Growth<'a> {
    cloud: &'a [[i64; 3]],
    /// All faces there were; some are part of the hull no more.
    pub faces: Vec<Face>,
    /// The point after each point in the list of its face.
    next: Vec<u32>,
}

impl<'a> Growth<'a> {
    /// A tetrahedron of far apart points, and the other points shared among its faces; `None`
    /// where the cloud is flat.
    pub fn start(cloud: &'a [[i64; 3]]) -> Option<Growth<'a>> {
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
    pub fn finish(&mut self) {
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
