//! The net: knots, cables and bullets, folded in its container and about to be shot.
//!
//! Knots of the grid are numbered row by row (rows along Y, columns along Z), middle knots after
//! them, cable by cable. The deployed net lies in the plane X = 0 around the origin; X is the
//! travelling direction.
//!
//! Lumping (Eq. 3.2): a knot carries half of each cable that ends at it, a corner carries the
//! bullet instead. With edge cables like the inner ones this is 2 ρ A l₀ inside and 3/2 ρ A l₀ on
//! an edge.

pub mod fold;
pub mod spec;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::assets::Kind;
use crate::cable::{self, Cable};
use crate::json;
use crate::problems::Problems;
use crate::read;
use spec::{Launch, Material, MaterialChoice};

/// A checked net.
#[derive(Clone, Debug)]
pub struct Net {
    /// Grid knots along Y and along Z.
    pub grid: [usize; 2],
    /// Mass of each knot [kg].
    pub mass: Vec<f64>,
    /// Radius of each knot's ball: that of its thickest cable [m].
    pub radius: Vec<f64>,
    /// Young's modulus of each knot's stiffest cable [Pa].
    pub young_modulus: Vec<f64>,
    /// All cables, in pieces where they carry middle knots.
    /// Shared: nothing in a run changes them.
    pub cables: Arc<[Cable]>,
    /// The four corner knots, in order around the mouth.
    pub bullets: [usize; 4],
    /// Knots around the mouth, in order, starting at the first bullet.
    pub perimeter: Vec<usize>,
    /// Area of the fully deployed net [m^2].
    pub designed_area: f64,
    /// Positions in the container [m].
    pub folded: Vec<Vector3<f64>>,
    /// Whether a cable that is longer than its ends are apart is folded there, and hangs along −X, where it has coordinates
    /// between them; else it lies straight, pressed together.
    pub folded_inwards: bool,
    /// Velocities just after the shot [m/s].
    pub launch_velocity: Vec<Vector3<f64>>,
    /// How much later than time 0 each bullet is shot [s].
    pub delay: [f64; 4],
}

impl Net {
    /// The knot in the middle of the net, or next to it.
    pub fn middle_knot(&self) -> usize {
        (self.grid[0] / 2) * self.grid[1] + self.grid[1] / 2
    }

    /// Builds the net of `spec`, shot as `launch` says.
    ///
    /// Faults go to `problems`, with their places below `net` of the scene.
    pub fn build(spec: &spec::NetSpec, launch: &Launch, problems: &mut Problems) -> Option<Net> {
        let [inner, edge] = CableMake::inner_and_edge(spec, problems)?;
        let n_meshes = spec.meshes.map(|n| n as usize);
        let middle = spec.middle_knots as usize;
        let n_knots = spec.n_knots() as usize;

        let grid = n_meshes.map(|n| n + 1);
        let sides = spec.mesh_length_m.sides();
        let lines = grid_lines(grid, middle);
        let mut net = Net {
            grid,
            mass: vec![0.0; n_knots],
            radius: vec![0.0; n_knots],
            young_modulus: vec![0.0; n_knots],
            cables: Arc::new([]),
            bullets: [
                0,
                knot_at(grid, grid[0] - 1, 0),
                knot_at(grid, grid[0] - 1, grid[1] - 1),
                knot_at(grid, 0, grid[1] - 1),
            ],
            perimeter: Vec::new(),
            designed_area: sides[0] * n_meshes[0] as f64 * sides[1] * n_meshes[1] as f64,
            folded: Vec::new(),
            folded_inwards: spec.fold.scheme == spec::FoldScheme::Inwards,
            launch_velocity: vec![Vector3::zeros(); n_knots],
            delay: launch.bullets.delay_s,
        };
        let make_of = |line: &GridLine| if line.on_edge { &edge } else { &inner };

        // Masses first: the damping of a cable needs them (Eq. 3.4).
        net.lump(spec, &lines, make_of);
        net.tie(spec, &lines, make_of);
        net.perimeter = perimeter(grid, &lines);
        net.folded = fold::folded(spec, grid, &lines);
        net.shoot(shots(spec, launch));
        net.check_delays(problems);
        Some(net)
    }

    /// Masses, radii and moduli of the knots (Eq. 3.2).
    fn lump<'a>(
        &mut self,
        spec: &spec::NetSpec,
        lines: &[GridLine],
        make_of: impl Fn(&GridLine) -> &'a CableMake,
    ) {
        for line in lines {
            let make = make_of(line);
            let piece = spec.mesh_length_m.sides()[line.along] / f64::from(spec.middle_knots + 1);
            let half_mass = 0.5 * make.material.density_kg_m3.0 * make.cross_section() * piece;
            for [a, b] in line.pieces() {
                for knot in [a, b] {
                    self.mass[knot] += half_mass;
                    self.radius[knot] = self.radius[knot].max(0.5 * make.diameter);
                    let modulus = make.material.young_modulus_pa.0;
                    self.young_modulus[knot] = self.young_modulus[knot].max(modulus);
                }
            }
        }
        for bullet in self.bullets {
            self.mass[bullet] = spec.bullet_mass_kg.0;
        }
    }

    /// Cables between the knots, whose masses are known (Eq. 3.1, 3.4).
    fn tie<'a>(
        &mut self,
        spec: &spec::NetSpec,
        lines: &[GridLine],
        make_of: impl Fn(&GridLine) -> &'a CableMake,
    ) {
        let mut cables = Vec::with_capacity(lines.len() * (spec.middle_knots as usize + 1));
        let uncut = self.uncut_masses(spec, lines, &make_of);
        for line in lines {
            let make = make_of(line);
            let n_pieces = f64::from(spec.middle_knots + 1);
            let whole_length = spec.mesh_length_m.sides()[line.along];
            let rest_length = whole_length / n_pieces;
            let stiffness_of =
                |length| cable::stiffness(make.material.young_modulus_pa.0, make.cross_section(), length);
            let stiffness = stiffness_of(rest_length);
            // Dashpots in a row: a line of c has pieces of n c each, however finely it is cut.
            let lesser = uncut[line.ends[0]].min(uncut[line.ends[1]]);
            let damping = n_pieces * cable::damping(make.damping_ratio, lesser, stiffness_of(whole_length));
            for [a, b] in line.pieces() {
                cables.push(Cable {
                    a,
                    b,
                    rest_length,
                    stiffness,
                    damping,
                    mass: make.material.density_kg_m3.0 * make.cross_section() * rest_length,
                    reduced_mass: cable::reduced_mass(self.mass[a], self.mass[b]),
                    breaking_tension: make.material.tensile_strength_pa.0 * make.cross_section(),
                });
            }
        }
        self.cables = cables.into();
    }

    /// Masses of the grid knots of the same net without middle knots (Eq. 3.2) [kg], which Eq. 3.4 takes.
    fn uncut_masses<'a>(
        &self,
        spec: &spec::NetSpec,
        lines: &[GridLine],
        make_of: impl Fn(&GridLine) -> &'a CableMake,
    ) -> Vec<f64> {
        let mut uncut = vec![0.0; self.grid[0] * self.grid[1]];
        for line in lines {
            let (make, length) = (make_of(line), spec.mesh_length_m.sides()[line.along]);
            let half_mass = 0.5 * make.material.density_kg_m3.0 * make.cross_section() * length;
            for knot in line.ends {
                uncut[knot] += half_mass;
            }
        }
        for corner in self.bullets {
            uncut[corner] = spec.bullet_mass_kg.0;
        }
        uncut
    }

    /// Gives the bullets their velocities [m/s]; all else stays at rest. Those that are shot later are as far behind as
    /// they fly until then.
    pub fn shoot(&mut self, shots: [Vector3<f64>; 4]) {
        for ((bullet, shot), delay) in self.bullets.into_iter().zip(shots).zip(self.delay) {
            self.folded[bullet] += delay * (self.launch_velocity[bullet] - shot);
            self.launch_velocity[bullet] = shot;
        }
    }

    /// Adds cables that a bullet which is shot late would pull taut behind the folded net.
    fn check_delays(&self, problems: &mut Problems) {
        for (number, (bullet, delay)) in self.bullets.into_iter().zip(self.delay).enumerate() {
            let behind = delay * self.launch_velocity[bullet];
            let is_taut =
                |cable: &&Cable| (self.folded[cable.a] - self.folded[cable.b]).norm() > cable.rest_length;
            let of_bullet = |cable: &&Cable| delay > 0.0 && (cable.a == bullet || cable.b == bullet);
            if let Some(cable) = self.cables.iter().filter(of_bullet).find(is_taut) {
                problems.add(
                    format!("launch.bullets.delay_s[{number}]"),
                    format!("{delay}: the bullet would be {:.3e} m behind", behind.norm()),
                    format!("a delay in which its cables of {:.3e} m stay slack", cable.rest_length),
                );
            }
        }
    }

    /// Whether it hangs together: for nets that were not built from a scene.
    pub fn check(&self, problems: &mut Problems) {
        let n = self.n_knots();
        let lists = [
            ("radius", self.radius.len()),
            ("young_modulus", self.young_modulus.len()),
            ("folded", self.folded.len()),
            ("launch_velocity", self.launch_velocity.len()),
        ];
        for (name, found) in lists.into_iter().filter(|(_, found)| *found != n) {
            problems.add(format!("net.{name}"), format!("{found} entries"), format!("{n}, as many as knots"));
        }
        let is_above_zero = |x: f64| x.is_finite() && x > 0.0;
        for (knot, mass) in self.mass.iter().enumerate().filter(|(_, mass)| !is_above_zero(**mass)) {
            problems.add(format!("net.mass[{knot}]"), mass, "a mass above 0");
        }
        for (index, cable) in self.cables.iter().enumerate() {
            let place = format!("net.cables[{index}]");
            if cable.a == cable.b || cable.a.max(cable.b) >= n {
                let ends = format!("knots {} and {}", cable.a, cable.b);
                problems.add(&*place, ends, format!("two different knots below {n}"));
            }
            let sizes = [cable.rest_length, cable.stiffness, cable.reduced_mass];
            let is_from_zero = |x: f64| x.is_finite() && x >= 0.0;
            let others = [cable.damping, cable.mass];
            if !(sizes.into_iter().all(is_above_zero) && others.into_iter().all(is_from_zero)) {
                problems.add(
                    place,
                    format!("{cable:?}"),
                    "length, stiffness and reduced mass above 0, damping and mass from 0",
                );
            }
        }
        for (name, vectors) in [("folded", &self.folded), ("launch_velocity", &self.launch_velocity)] {
            if let Some(knot) = vectors.iter().position(|vector| !vector.iter().all(|x| x.is_finite())) {
                let found = format!("{:?}", vectors[knot].as_slice());
                problems.add(format!("net.{name}[{knot}]"), found, "numbers");
            }
        }
        let corners = self.bullets.iter().chain(&self.perimeter);
        for knot in corners.filter(|knot| **knot >= n) {
            problems.add("net.perimeter", knot, format!("knots below {n}"));
        }
    }

    /// Number of knots.
    pub fn n_knots(&self) -> usize {
        self.mass.len()
    }

    /// The cables of each line of the grid: one, or the pieces in a row into which middle knots cut it.
    pub fn lines(&self) -> Vec<Range<usize>> {
        let n_grid = self.grid[0] * self.grid[1];
        let mut lines: Vec<Range<usize>> = Vec::new();
        for (number, cable) in self.cables.iter().enumerate() {
            let goes_on =
                |line: &&mut Range<usize>| cable.a >= n_grid && self.cables[line.end - 1].b == cable.a;
            match lines.last_mut().filter(goes_on) {
                Some(line) => line.end = number + 1,
                None => lines.push(number..number + 1),
            }
        }
        lines
    }

    /// Radius of a cable [m]: that of its thinner end knot.
    pub fn cable_radius(&self, cable: usize) -> f64 {
        self.radius[self.cables[cable].a].min(self.radius[self.cables[cable].b])
    }

    /// Damping ratio of the cable that damps least [-].
    pub fn least_damping_ratio(&self) -> f64 {
        self.cables.iter().map(Cable::damping_ratio).fold(f64::INFINITY, f64::min)
    }

    /// Damping ratio of the cable that damps most [-].
    pub fn most_damping_ratio(&self) -> f64 {
        self.cables.iter().map(Cable::damping_ratio).fold(0.0, f64::max)
    }

    /// Total mass [kg].
    pub fn total_mass(&self) -> f64 {
        self.mass.iter().sum()
    }

    /// Kinetic energy of the shot [J].
    pub fn launch_energy(&self) -> f64 {
        self.mass.iter().zip(&self.launch_velocity).map(|(m, v)| 0.5 * m * v.norm_squared()).sum()
    }

    /// Linear momentum of the shot [kg m/s].
    pub fn launch_momentum(&self) -> Vector3<f64> {
        self.mass.iter().zip(&self.launch_velocity).map(|(m, v)| *m * v).sum()
    }
}

/// Velocities of the bullets [m/s]: outward along the diagonals of the net, at `angle_deg` from X.
///
/// With deviations δv, δθ and ψ of a bullet, n outward along its diagonal:
/// (v + δv) [cos ψ (cos(θ + δθ) X + sin(θ + δθ) n) + sin ψ X × n].
pub fn shots(spec: &spec::NetSpec, launch: &Launch) -> [Vector3<f64>; 4] {
    let (sin, cos) = launch.angle_deg.to_radians().sin_cos();
    let [width, height] = spec.mesh_length_m.sides();
    let size = [width * f64::from(spec.meshes[0]), height * f64::from(spec.meshes[1])];
    let outward = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[y, z]| Vector3::new(0.0, y * size[0], z * size[1]).normalize());
    if launch.bullets.is_zero() {
        return outward.map(|outward| launch.speed_m_s * (cos * Vector3::x() + sin * outward));
    }
    let deviations = &launch.bullets;
    std::array::from_fn(|bullet| {
        let outward = outward[bullet];
        let (sin, cos) = (launch.angle_deg + deviations.angle_deg[bullet]).to_radians().sin_cos();
        let (aside, along) = deviations.aside_deg[bullet].to_radians().sin_cos();
        let direction = along * (cos * Vector3::x() + sin * outward) + aside * Vector3::x().cross(&outward);
        (launch.speed_m_s + deviations.speed_m_s[bullet]) * direction
    })
}

/// What a cable is made of.
struct CableMake {
    material: Material,
    diameter: f64,
    damping_ratio: f64,
}

impl CableMake {
    /// Of the mesh's cables, and of those around it.
    fn inner_and_edge(spec: &spec::NetSpec, problems: &mut Problems) -> Option<[CableMake; 2]> {
        let (cable, edge) = (&spec.cable, spec.edge_cable.as_ref());
        let inner = material(&cable.material, "net.cable.material", problems);
        let around = match edge.and_then(|edge| edge.material.as_ref()) {
            Some(own) => material(own, "net.edge_cable.material", problems),
            None => inner.clone(),
        };
        let edge_diameter = edge.and_then(|edge| edge.diameter_m).unwrap_or(cable.diameter_m);
        let edge_ratio = edge.and_then(|edge| edge.damping_ratio).unwrap_or(cable.damping_ratio);
        Some([
            CableMake { material: inner?, diameter: cable.diameter_m.0, damping_ratio: cable.damping_ratio },
            CableMake { material: around?, diameter: edge_diameter.0, damping_ratio: edge_ratio },
        ])
    }

    /// A = π d² / 4 [m^2].
    fn cross_section(&self) -> f64 {
        0.25 * std::f64::consts::PI * self.diameter * self.diameter
    }
}

fn material(choice: &MaterialChoice, place: &str, problems: &mut Problems) -> Option<Material> {
    match choice {
        MaterialChoice::Inline(material) => Some(material.clone()),
        MaterialChoice::Named(name) => match Kind::Material.text(name) {
            Some(text) => {
                let value = json::parse(text, place, problems)?;
                read::typed(&value, place, problems)
            }
            None => {
                let choices = Kind::Material.instead_of(name);
                problems.add(place, format!("\"{name}\""), format!("{choices}, or an object of numbers"));
                None
            }
        },
    }
}

/// A line of the grid between two neighbouring grid knots.
pub(crate) struct GridLine {
    ends: [usize; 2],
    /// The middle knots that divide it, from its first end to its second.
    middle: Range<usize>,
    /// 0 along Y, 1 along Z.
    along: usize,
    on_edge: bool,
}

impl GridLine {
    /// Its pieces, as pairs of knots.
    fn pieces(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let starts = std::iter::once(self.ends[0]).chain(self.middle.clone());
        let stops = self.middle.clone().chain(std::iter::once(self.ends[1]));
        starts.zip(stops).map(|(start, stop)| [start, stop])
    }
}

fn knot_at(grid: [usize; 2], row: usize, column: usize) -> usize {
    row * grid[1] + column
}

/// All lines of the grid: first those along Y, then those along Z.
fn grid_lines(grid: [usize; 2], n_middle: usize) -> Vec<GridLine> {
    let mut lines = Vec::new();
    let mut add = |ends, along, on_edge| {
        let first = grid[0] * grid[1] + lines.len() * n_middle;
        lines.push(GridLine { ends, middle: first..first + n_middle, along, on_edge });
    };
    for row in 0..grid[0] - 1 {
        for column in 0..grid[1] {
            let ends = [knot_at(grid, row, column), knot_at(grid, row + 1, column)];
            add(ends, 0, column == 0 || column == grid[1] - 1);
        }
    }
    for row in 0..grid[0] {
        for column in 0..grid[1] - 1 {
            let ends = [knot_at(grid, row, column), knot_at(grid, row, column + 1)];
            add(ends, 1, row == 0 || row == grid[0] - 1);
        }
    }
    lines
}

/// Knots around the mouth: along Y, along Z, and back.
fn perimeter(grid: [usize; 2], lines: &[GridLine]) -> Vec<usize> {
    let (last_row, last_column) = (grid[0] - 1, grid[1] - 1);
    let corners: Vec<usize> = (0..last_row)
        .map(|row| knot_at(grid, row, 0))
        .chain((0..last_column).map(|column| knot_at(grid, last_row, column)))
        .chain((1..=last_row).rev().map(|row| knot_at(grid, row, last_column)))
        .chain((1..=last_column).rev().map(|column| knot_at(grid, 0, column)))
        .collect();
    let on_edge: HashMap<[usize; 2], &GridLine> =
        lines.iter().filter(|line| line.on_edge).map(|line| (line.ends, line)).collect();
    let mut around = Vec::new();
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        around.push(from);
        if let Some(line) = on_edge.get(&[from, to]) {
            around.extend(line.middle.clone());
        } else if let Some(line) = on_edge.get(&[to, from]) {
            around.extend(line.middle.clone().rev());
        }
    }
    around
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn net(changes: serde_json::Value) -> Net {
        let mut spec = json!({ "meshes": [10, 10], "mesh_length_m": 1.0, "bullet_mass_kg": 1.0,
            "cable": { "material": "kevlar", "diameter_m": 0.001 } });
        for (key, value) in changes.as_object().unwrap() {
            spec[key] = value.clone();
        }
        let launch = Launch { speed_m_s: 10.0, angle_deg: 55.0, bullets: Default::default() };
        let mut problems = Problems::new("test");
        let net = Net::build(&serde_json::from_value(spec).unwrap(), &launch, &mut problems);
        assert_eq!(problems.list, vec![]);
        net.unwrap()
    }

    #[test]
    fn masses_follow_eq_3_2() {
        let net = net(json!({}));
        let cable_mass = 1440.0 * std::f64::consts::FRAC_PI_4 * 1e-6;
        assert_eq!(net.n_knots(), 121);
        assert_eq!(net.cables.len(), 220);
        assert_eq!(net.mass[0], 1.0);
        assert!((net.mass[5] - 1.5 * cable_mass).abs() < 1e-12);
        assert!((net.mass[60] - 2.0 * cable_mass).abs() < 1e-12);
        // The speed of the centre of mass that Table 3.2 leads to.
        let speed = net.launch_momentum().x / net.total_mass();
        assert!((speed - 5.4056).abs() < 5e-5, "{speed}");
    }

    #[test]
    fn middle_knots_divide_cables_and_keep_the_mass() {
        let (plain, divided) = (net(json!({})), net(json!({ "middle_knots": 3 })));
        assert_eq!(plain.lines(), (0..220).map(|cable| cable..cable + 1).collect::<Vec<_>>());
        assert_eq!(divided.lines(), (0..220).map(|line| 4 * line..4 * line + 4).collect::<Vec<_>>());
        assert_eq!(divided.n_knots(), 121 + 3 * 220);
        assert_eq!(divided.cables.len(), 4 * 220);
        // What the corners' halves lose differs: a bullet replaces its share of two cables.
        let lost = 4.0 * 2.0 * (0.5 - 0.125) * 1440.0 * std::f64::consts::FRAC_PI_4 * 1e-6;
        assert!((divided.total_mass() - plain.total_mass() - lost).abs() < 1e-12);
    }

    #[test]
    fn perimeter_goes_once_around() {
        for middle in [0, 1, 2] {
            let net = net(json!({ "meshes": [3, 2], "mesh_length_m": [1.0, 2.0], "middle_knots": middle }));
            let mut seen = net.perimeter.clone();
            assert_eq!(seen.len(), 10 * (1 + middle));
            for (i, &from) in net.perimeter.iter().enumerate() {
                let to = net.perimeter[(i + 1) % net.perimeter.len()];
                let tied = net.cables.iter().any(|c| [c.a, c.b] == [from, to] || [c.b, c.a] == [from, to]);
                assert!(tied, "no cable from {from} to {to}");
            }
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), net.perimeter.len());
            for bullet in net.bullets {
                assert!(seen.contains(&bullet));
            }
        }
    }

    #[test]
    fn edge_cables_are_their_own() {
        let net = net(json!({ "edge_cable": { "diameter_m": 0.003 } }));
        assert_eq!(net.radius[60], 0.0005);
        assert_eq!(net.radius[5], 0.0015);
        let area = |d: f64| std::f64::consts::FRAC_PI_4 * d * d;
        let edge_mass = 1440.0 * (area(0.003) + 0.5 * area(0.001));
        assert!((net.mass[5] - edge_mass).abs() < 1e-12);
    }

    #[test]
    fn bullets_fly_outward_along_the_diagonals() {
        let net = net(json!({ "meshes": [3, 2], "mesh_length_m": [1.0, 2.0] }));
        for bullet in net.bullets {
            let (velocity, corner) = (net.launch_velocity[bullet], net.folded[bullet]);
            assert!((velocity.norm() - 10.0).abs() < 1e-12);
            assert!((velocity.x - 10.0 * 55f64.to_radians().cos()).abs() < 1e-12);
            let outward = Vector3::new(0.0, velocity.y, velocity.z);
            assert!((outward.normalize() - corner.normalize()).norm() < 1e-12);
        }
        assert_eq!(net.launch_velocity.iter().filter(|v| v.norm() > 0.0).count(), 4);
    }
}
