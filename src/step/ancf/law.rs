//! The law of an element: tension of what is stretched, the dashpot, bending; forces, energy, and what is taken.

use nalgebra::Vector3;

use super::element::{BEND, GaussPoint, MASS, POINTS, gauss};
use super::motion::{Coordinates, cut, cut_mut};
use crate::net::Net;
use crate::solver::Ancf;
use crate::state::NetTotals;

/// The law of the elements of each cable.
pub(super) struct ElementLaw {
    points: [GaussPoint; POINTS],
    /// Length l [m], mass μ [kg].
    pub(super) length: Vec<f64>,
    pub(super) mass: Vec<f64>,
    pub(super) inverse_mass: Vec<f64>,
    /// E A / l [N/m].
    pub(super) axial: Vec<f64>,
    /// 1 / l² [1/m²].
    inverse_square: Vec<f64>,
    /// Dashpot [N s/m]; `damped`: whether any cable has one.
    damping: Vec<f64>,
    pub(super) damped: bool,
    /// E I / l³ [N/m]; none without bending.
    pub(super) bending: Option<Vec<f64>>,
    /// For each element: what its dashpot gives over its length [N/m].
    dashpot: Vec<Vec<f64>>,
}

impl ElementLaw {
    pub(super) fn of(net: &Net, ancf: &Ancf) -> ElementLaw {
        let n = f64::from(ancf.elements);
        let each = |value: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..net.cables.len()).map(value).collect() };
        let cable = |index: usize| &net.cables[index];
        let length = each(&|i| cable(i).rest_length / n);
        let mass = each(&|i| cable(i).mass / n);
        ElementLaw {
            points: gauss(),
            inverse_mass: mass.iter().map(|mass| 1.0 / mass).collect(),
            axial: each(&|i| n * cable(i).stiffness),
            inverse_square: length.iter().map(|length| 1.0 / (length * length)).collect(),
            damping: each(&|i| n * cable(i).damping),
            damped: net.cables.iter().any(|cable| cable.damping > 0.0),
            bending: ancf.bending.then(|| each(&|i| n * n * n * bending_stiffness(net, i))),
            dashpot: vec![vec![0.0; net.cables.len()]; ancf.elements as usize],
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
        let n = tension.len();
        let [r0, s0, r1, s1] =
            [&first.position, &slope.position, &second.position, &other.position].map(|axes| cut(axes, n));
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz], [dx, dy, dz]] =
            [&mut first.force, &mut slope.force, &mut second.force, &mut other.force]
                .map(|axes| cut_mut(axes, n));
        let (axial, inverse_square) = (&self.axial[..n], &self.inverse_square[..n]);
        let (length, dashpot) = (&self.length[..n], &self.dashpot[element][..n]);
        for i in 0..n {
            let chord = [r1[0][i] - r0[0][i], r1[1][i] - r0[1][i], r1[2][i] - r0[2][i]];
            let slopes = [[s0[0][i], s0[1][i], s0[2][i]], [s1[0][i], s1[1][i], s1[2][i]]];
            let mut pull = [[0.0; 3]; 3];
            let mut largest: f64 = 0.0;
            for GaussPoint { weight, chord: of_chord, slopes: [of_first, of_second] } in &self.points {
                let mut rho = [0.0; 3];
                for axis in 0..3 {
                    rho[axis] =
                        of_chord * chord[axis] + of_first * slopes[0][axis] + of_second * slopes[1][axis];
                }
                let square = rho[0] * rho[0] + rho[1] * rho[1] + rho[2] * rho[2];
                let strain = (0.5 * (square * inverse_square[i] - 1.0)).max(0.0);
                largest = largest.max(strain);
                let share = weight * strain;
                for (factor, pull) in [of_chord, of_first, of_second].into_iter().zip(&mut pull) {
                    for axis in 0..3 {
                        pull[axis] += share * factor * rho[axis];
                    }
                }
            }
            let k = axial[i];
            (ax[i], ay[i], az[i]) = (ax[i] + k * pull[0][0], ay[i] + k * pull[0][1], az[i] + k * pull[0][2]);
            (cx[i], cy[i], cz[i]) = (cx[i] - k * pull[0][0], cy[i] - k * pull[0][1], cz[i] - k * pull[0][2]);
            (bx[i], by[i], bz[i]) = (bx[i] - k * pull[1][0], by[i] - k * pull[1][1], bz[i] - k * pull[1][2]);
            (dx[i], dy[i], dz[i]) = (dx[i] - k * pull[2][0], dy[i] - k * pull[2][1], dz[i] - k * pull[2][2]);
            tension[i] = tension[i].max((k * largest + dashpot[i]) * length[i]);
        }
    }

    /// The dashpot of Eq. 3.3 between the nodes of an element, c ḋ along d = r₁ − r₀ while |d| > l; with the spring
    /// of the chord it never pushes.
    #[inline(always)]
    pub(super) fn damp(&mut self, element: usize, nodes: &mut [Coordinates]) {
        let [first, _, second, _] = nodes else { return };
        let n = self.length.len();
        let (x0, v0) = (cut(&first.position, n), cut(&first.velocity, n));
        let (x1, v1) = (cut(&second.position, n), cut(&second.velocity, n));
        let ([ax, ay, az], [bx, by, bz]) = (cut_mut(&mut first.force, n), cut_mut(&mut second.force, n));
        let dashpot = &mut self.dashpot[element][..n];
        let (axial, length, damping) = (&self.axial[..n], &self.length[..n], &self.damping[..n]);
        for i in 0..n {
            let (dx, dy, dz) = (x1[0][i] - x0[0][i], x1[1][i] - x0[1][i], x1[2][i] - x0[2][i]);
            let (ux, uy, uz) = (v1[0][i] - v0[0][i], v1[1][i] - v0[1][i], v1[2][i] - v0[2][i]);
            let apart = (dx * dx + dy * dy + dz * dz).sqrt();
            let inverse = 1.0 / apart;
            let stretch = apart - length[i];
            let rate = (dx * ux + dy * uy + dz * uz) * inverse;
            let law = (damping[i] * rate).max(-axial[i] * stretch);
            let along = if stretch > 0.0 { law * inverse } else { 0.0 };
            dashpot[i] = along;
            (ax[i], ay[i], az[i]) = (ax[i] + along * dx, ay[i] + along * dy, az[i] + along * dz);
            (bx[i], by[i], bz[i]) = (bx[i] - along * dx, by[i] - along * dy, bz[i] - along * dz);
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

    /// Adds an element of `cable`, given position and velocity of its coordinates.
    pub(super) fn add_element(&self, cable: usize, element: &[[Vector3<f64>; 2]], totals: &mut NetTotals) {
        let mass = self.mass[cable];
        for (row, [x, _]) in MASS.iter().zip(element) {
            // The momentum that goes with this coordinate.
            let moved: Vector3<f64> =
                row.iter().zip(element).map(|(factor, [_, v])| mass * *factor * v).sum();
            totals.angular_momentum += x.cross(&moved);
        }
        for (row, [_, v]) in MASS.iter().zip(element) {
            let moved: Vector3<f64> =
                row.iter().zip(element).map(|(factor, [_, v])| mass * *factor * v).sum();
            totals.kinetic += 0.5 * v.dot(&moved);
        }
        // ∫ S dξ.
        for (share, [_, v]) in [0.5, 1.0 / 12.0, 0.5, -1.0 / 12.0].into_iter().zip(element) {
            totals.momentum += mass * share * v;
        }
        let [[r0, _], [s0, _], [r1, _], [s1, _]] = element else { return };
        for GaussPoint { weight, chord, slopes: [first, second] } in &self.points {
            let rho = *chord * (r1 - r0) + *first * s0 + *second * s1;
            let strain = (0.5 * (rho.norm_squared() * self.inverse_square[cable] - 1.0)).max(0.0);
            let square = self.length[cable] * self.length[cable];
            totals.elastic += 0.5 * weight * self.axial[cable] * square * strain * strain;
        }
        if let Some(bending) = &self.bending {
            for (row, [x, _]) in BEND.iter().zip(element) {
                let bent: Vector3<f64> = row.iter().zip(element).map(|(factor, [x, _])| *factor * x).sum();
                totals.elastic += 0.5 * bending[cable] * x.dot(&bent);
            }
        }
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
