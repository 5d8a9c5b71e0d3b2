//! The law of an element: tension of what is stretched, the dashpot, bending; forces, energy, and what is taken.

use nalgebra::Vector3;

use super::element::{BEND, COORDINATES, GaussPoint, POINTS, gauss};
use super::motion::{Coordinates, LANES, Lanes, add_lanes, apart, lanes, lanes_of, padded};
use crate::net::Net;
use crate::solver::Ancf;

/// The law of the elements of each cable.
pub(super) struct ElementLaw {
    pub(super) points: [GaussPoint; POINTS],
    /// Length l [m], mass μ [kg].
    pub(super) length: Vec<f64>,
    pub(super) mass: Vec<f64>,
    pub(super) inverse_mass: Vec<f64>,
    /// E A / l [N/m].
    pub(super) axial: Vec<f64>,
    /// 1 / l² [1/m²].
    pub(super) inverse_square: Vec<f64>,
    /// Dashpot [N s/m]; `damped`: whether any cable has one.
    pub(super) damping: Vec<f64>,
    pub(super) damped: bool,
    /// E I / l³ [N/m]; none without bending.
    pub(super) bending: Option<Vec<f64>>,
    /// For each element: what its dashpot gives over its length [N/m].
    dashpot: Vec<Vec<f64>>,
}

/// What the points of the quadrature give, over E A / l [m].
#[derive(Default)]
struct InternalForce {
    /// On r₁ − r₀, σ₀ and σ₁.
    on: [[Lanes; 3]; 3],
    /// Largest strain [-].
    strain: Lanes,
}

impl InternalForce {
    /// Adds what `point` gives where an element has r₁ − r₀, σ₀ and σ₁ as in `shape`.
    #[inline(always)]
    fn add(&mut self, point: &GaussPoint, shape: &[[Lanes; 3]; 3], inverse_square: &Lanes) {
        let factors = [point.chord, point.slopes[0], point.slopes[1]];
        let mut rho = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for i in 0..LANES {
                rho[axis][i] = factors[0] * shape[0][axis][i]
                    + factors[1] * shape[1][axis][i]
                    + factors[2] * shape[2][axis][i];
            }
        }
        let mut share = [0.0; LANES];
        for i in 0..LANES {
            let square = rho[0][i] * rho[0][i] + rho[1][i] * rho[1][i] + rho[2][i] * rho[2][i];
            let green = 0.5 * (square * inverse_square[i] - 1.0);
            let strain = if green > 0.0 { green } else { 0.0 };
            self.strain[i] = if strain > self.strain[i] { strain } else { self.strain[i] };
            share[i] = point.weight * strain;
        }
        for (on, factor) in self.on.iter_mut().zip(factors) {
            for axis in 0..3 {
                for i in 0..LANES {
                    on[axis][i] += factor * share[i] * rho[axis][i];
                }
            }
        }
    }
}

impl ElementLaw {
    pub(super) fn of(net: &Net, ancf: &Ancf) -> ElementLaw {
        let n = f64::from(ancf.elements);
        let n_padded = padded(net.cables.len());
        // What fills the last group is slack, however it lies, and has no force to answer to.
        let each = |value: &dyn Fn(usize) -> f64, filling: f64| -> Vec<f64> {
            let mut values: Vec<f64> = (0..net.cables.len()).map(value).collect();
            values.resize(n_padded, filling);
            values
        };
        let cable = |index: usize| &net.cables[index];
        let length = each(&|i| cable(i).rest_length / n, 1.0);
        let mass = each(&|i| cable(i).mass / n, f64::INFINITY);
        ElementLaw {
            points: gauss(),
            inverse_mass: mass.iter().map(|mass| 1.0 / mass).collect(),
            axial: each(&|i| n * cable(i).stiffness, 0.0),
            inverse_square: length.iter().map(|length| 1.0 / (length * length)).collect(),
            damping: each(&|i| n * cable(i).damping, 0.0),
            damped: net.cables.iter().any(|cable| cable.damping > 0.0),
            bending: ancf.bending.then(|| each(&|i| n * n * n * bending_stiffness(net, i), 0.0)),
            dashpot: vec![vec![0.0; n_padded]; ancf.elements as usize],
            length,
            mass,
        }
    }

    /// Eq. 3.12 to 3.14 with tension only: the force of U = ½ E A l ∫ max(0, ε)² dξ, ε = ½ (r′·r′ − 1).
    ///
    /// With ρ = l r′ = ∂r/∂ξ it is −∂U/∂qᵢ = −(E A / l) ∫ max(0, ε) Sᵢ′ ρ dξ.
    #[inline(always)]
    pub(super) fn stretch(&self, element: usize, nodes: &mut [Coordinates], tension: &mut [f64]) {
        let [first, slope, second, other] = nodes else { return };
        for at in (0..tension.len()).step_by(LANES) {
            let [r0, r1] = [&first.position, &second.position].map(|axes| lanes_of(axes, at));
            let shape = [apart(&r1, &r0), lanes_of(&slope.position, at), lanes_of(&other.position, at)];
            let inverse_square = lanes(&self.inverse_square, at);
            let mut pull = InternalForce::default();
            for point in &self.points {
                pull.add(point, &shape, &inverse_square);
            }
            let along = lanes(&self.axial, at);
            let back = along.map(|axial| -axial);
            add_lanes(&mut first.force, at, &along, &pull.on[0]);
            add_lanes(&mut second.force, at, &back, &pull.on[0]);
            add_lanes(&mut slope.force, at, &back, &pull.on[1]);
            add_lanes(&mut other.force, at, &back, &pull.on[2]);
            let (length, dashpot) = (lanes(&self.length, at), lanes(&self.dashpot[element], at));
            let largest = &mut tension[at..at + LANES];
            for i in 0..LANES {
                largest[i] = largest[i].max((along[i] * pull.strain[i] + dashpot[i]) * length[i]);
            }
        }
    }

    /// The dashpot of Eq. 3.3 between the nodes of an element, c ḋ along d = r₁ − r₀ while |d| > l; with the spring
    /// of the chord it never pushes.
    #[inline(always)]
    pub(super) fn damp(&mut self, element: usize, nodes: &mut [Coordinates]) {
        let [first, _, second, _] = nodes else { return };
        for at in (0..self.length.len()).step_by(LANES) {
            let [x0, x1] = [&first.position, &second.position].map(|axes| lanes_of(axes, at));
            let [v0, v1] = [&first.velocity, &second.velocity].map(|axes| lanes_of(axes, at));
            let (d, rate) = (apart(&x1, &x0), apart(&v1, &v0));
            let [axial, length, damping] =
                [&self.axial, &self.length, &self.damping].map(|values| lanes(values, at));
            let mut along = [0.0; LANES];
            for i in 0..LANES {
                let chord = (d[0][i] * d[0][i] + d[1][i] * d[1][i] + d[2][i] * d[2][i]).sqrt();
                let inverse = 1.0 / chord;
                let stretch = chord - length[i];
                let parting = d[0][i] * rate[0][i] + d[1][i] * rate[1][i] + d[2][i] * rate[2][i];
                let (pull, least) = (damping[i] * parting * inverse, -axial[i] * stretch);
                let law = if pull > least { pull } else { least };
                along[i] = if stretch > 0.0 { law * inverse } else { 0.0 };
            }
            self.dashpot[element][at..at + LANES].copy_from_slice(&along);
            add_lanes(&mut first.force, at, &along, &d);
            add_lanes(&mut second.force, at, &along.map(|along| -along), &d);
        }
    }

    /// Books what the dashpots take within a kick of `step` seconds: their force on the mean of the velocities before
    /// and after it, exactly.
    #[inline(always)]
    pub(super) fn book(&self, places: &[Coordinates], step: f64, dissipated: &mut [f64]) {
        for (element, dashpot) in self.dashpot.iter().enumerate() {
            let [first, second] = [&places[2 * element], &places[2 * element + 2]];
            for axis in 0..3 {
                let mean =
                    |of: &Coordinates, i: usize| of.velocity[axis][i] + 0.5 * step * of.acceleration[axis][i];
                for i in 0..dissipated.len() {
                    let apart = second.position[axis][i] - first.position[axis][i];
                    dissipated[i] += step * dashpot[i] * apart * (mean(second, i) - mean(first, i));
                }
            }
        }
    }

    /// Elastic energy of an element of `cable` with these coordinates [J].
    pub(super) fn energy(&self, cable: usize, element: &[Vector3<f64>; COORDINATES]) -> f64 {
        let mut energy = 0.0;
        let [r0, s0, r1, s1] = element;
        for GaussPoint { weight, chord, slopes: [first, second] } in &self.points {
            let rho = *chord * (r1 - r0) + *first * s0 + *second * s1;
            let strain = (0.5 * (rho.norm_squared() * self.inverse_square[cable] - 1.0)).max(0.0);
            let square = self.length[cable] * self.length[cable];
            energy += 0.5 * weight * self.axial[cable] * square * strain * strain;
        }
        if let Some(bending) = &self.bending {
            for (row, x) in BEND.iter().zip(element) {
                let bent: Vector3<f64> = row.iter().zip(element).map(|(factor, x)| *factor * x).sum();
                energy += 0.5 * bending[cable] * x.dot(&bent);
            }
        }
        energy
    }
}

/// E I of a cable over the cube of its length [N/m]: a round one has I = A d² / 16 (Eq. 3.12).
pub(super) fn bending_stiffness(net: &Net, cable: usize) -> f64 {
    let radius = net.cable_radius(cable);
    let length = net.cables[cable].rest_length;
    net.cables[cable].stiffness * 0.25 * radius * radius / (length * length)
}

/// −∂/∂qᵢ ½ E I ∫ |r″|² dx: the curvature of Eq. 3.12 where |r′| = 1, which a taut cable keeps to its strain.
#[inline(always)]
pub(super) fn bend(bending: &[f64], nodes: &mut [Coordinates]) {
    let [first, slope, second, other] = nodes else { return };
    let n = bending.len();
    for axis in 0..3 {
        let x = [&first.position, &slope.position, &second.position, &other.position];
        let x = x.map(|axes| &axes[axis][..n]);
        let force = [&mut first.force, &mut slope.force, &mut second.force, &mut other.force];
        let mut force = force.map(|axes| &mut axes[axis][..n]);
        for i in 0..n {
            for (row, force) in BEND.iter().zip(&mut force) {
                let bent = row[0] * x[0][i] + row[1] * x[1][i] + row[2] * x[2][i] + row[3] * x[3][i];
                force[i] -= bending[i] * bent;
            }
        }
    }
}
