//! The net of cable elements at work: coordinates, elastic forces, accelerations, motion.
//!
//! Coordinates are kept as structure of arrays: for each place in the list of a cable ([`NodeList`]) and each axis
//! one array over all cables. The positions of the ends stand in every cable's list and in the knots'; both are
//! moved by the same sums, so that they stay the same to the last bit. Loops are plain and dispatched to the
//! widest vectors of the processor; no sum is reordered.

use nalgebra::Vector3;
use pulp::{Arch, NullaryFnOnce};

use super::element::{COORDINATES, Condensation};
use super::law::{ElementLaw, bend};
use super::mass::{KnotMass, own_mass};
use super::motion::{Axes, Coordinates, add, padded, two};
use crate::net::Net;
use crate::solver::Ancf;
use crate::state::Knots;
use crate::state::elements::{ElementNet, NodeList};

/// The net as cable elements.
pub struct AncfNet {
    pub(super) arch: Arch,
    pub(super) layout: NodeList,
    /// The knots at both ends of each cable.
    pub(super) ends: [Vec<usize>; 2],
    pub(super) knots: Coordinates,
    /// For each place in the list of a cable.
    pub(super) places: Vec<Coordinates>,
    /// Forces of effects on the knots [N].
    pub(super) push: Axes,
    pub(super) knot_mass: KnotMass,
    pub(super) condensed: Condensation,
    pub(super) law: ElementLaw,
    /// Largest stress times area of each cable since it was last asked for [N].
    pub(super) tension: Vec<f64>,
    /// What the dashpots of each cable took since then [J].
    pub(super) dissipated: Vec<f64>,
}

/// The elements of `net` as the state knows them.
pub fn element_net(net: &Net, ancf: &Ancf) -> ElementNet {
    let layout = NodeList { elements: ancf.elements as usize };
    let element_mass: Vec<f64> = net.cables.iter().map(|cable| cable.mass / layout.elements as f64).collect();
    let own_mass = own_mass(net);
    let end = Condensation::new(layout).ends[0][0];
    let mut answering_mass = own_mass.clone();
    for (cable, mass) in net.cables.iter().zip(&element_mass) {
        answering_mass[cable.a] += end * mass;
        answering_mass[cable.b] += end * mass;
    }
    let ends = net.cables.iter().map(|cable| [cable.a, cable.b]).collect();
    ElementNet { layout, ends, element_mass, own_mass, answering_mass }
}

impl AncfNet {
    /// The elements of `net`.
    pub fn new(net: &Net, ancf: &Ancf) -> AncfNet {
        let layout = NodeList { elements: ancf.elements as usize };
        let condensed = Condensation::new(layout);
        let law = ElementLaw::of(net, ancf);
        let n_padded = padded(net.cables.len());
        AncfNet {
            arch: Arch::new(),
            layout,
            ends: [net.cables.iter().map(|c| c.a).collect(), net.cables.iter().map(|c| c.b).collect()],
            knots: Coordinates::of(net.n_knots()),
            places: vec![Coordinates::of(n_padded); layout.size()],
            push: [(); 3].map(|()| vec![0.0; net.n_knots()]),
            knot_mass: KnotMass::new(net, &law.mass, &condensed),
            condensed,
            law,
            tension: vec![0.0; n_padded],
            dissipated: vec![0.0; n_padded],
        }
    }

    /// Takes over the coordinates and their rates, and the forces of effects on the knots [N].
    pub fn load(&mut self, knots: &Knots, inner: &Knots, forces: &[Vector3<f64>]) {
        for knot in 0..knots.position.len() {
            self.knots.set(knot, &knots.position[knot], &knots.velocity[knot]);
            let force = forces.get(knot).copied().unwrap_or_default();
            (0..3).for_each(|axis| self.push[axis][knot] = force[axis]);
        }
        let mut own = inner.position.iter().zip(&inner.velocity);
        for cable in 0..self.ends[0].len() {
            for (end, place) in self.layout.ends().into_iter().enumerate() {
                let knot = self.ends[end][cable];
                self.places[place].set(cable, &knots.position[knot], &knots.velocity[knot]);
            }
            for (place, (position, velocity)) in self.layout.inner().zip(&mut own) {
                self.places[place].set(cable, position, velocity);
            }
        }
    }

    /// Hands them over.
    pub fn store(&self, knots: &mut Knots, inner: &mut Knots) {
        for knot in 0..knots.position.len() {
            [knots.position[knot], knots.velocity[knot]] = self.knots.get(knot);
        }
        let mut own = inner.position.iter_mut().zip(&mut inner.velocity);
        for cable in 0..self.ends[0].len() {
            for (place, (position, velocity)) in self.layout.inner().zip(&mut own) {
                [*position, *velocity] = self.places[place].get(cable);
            }
        }
    }

    /// Coordinates of every place, and of the knots last.
    pub(super) fn coordinates(&self) -> impl Iterator<Item = &Coordinates> {
        self.places.iter().chain([&self.knots])
    }

    /// The same, to be changed.
    pub(super) fn coordinates_mut(&mut self) -> impl Iterator<Item = &mut Coordinates> {
        self.places.iter_mut().chain([&mut self.knots])
    }

    /// Positions after `step` seconds at the present velocities.
    pub fn drift(&mut self, step: f64) {
        self.arch.dispatch(Drift { net: self, step });
    }

    /// Velocities after `step` seconds of the present forces.
    pub fn kick(&mut self, step: f64) {
        self.arch.dispatch(Kick { net: self, step });
    }

    /// Largest tension of each cable since the last call [N]: with the stretch λ = √(1 + 2 ε) of its place,
    /// E A ε λ, and what its dashpot gave.
    pub fn take_tension(&mut self, tension: &mut [f64]) {
        for (cable, (tension, largest)) in tension.iter_mut().zip(&mut self.tension).enumerate() {
            let strain = *largest / (self.law.axial[cable] * self.law.length[cable]);
            *tension = std::mem::take(largest) * (1.0 + 2.0 * strain).sqrt();
        }
    }

    /// What the dashpots took since the last call [J].
    pub fn take_dissipated(&mut self) -> f64 {
        self.dissipated.iter_mut().map(std::mem::take).sum()
    }

    /// Elastic energy of all elements [J].
    pub fn elastic(&self) -> f64 {
        let mut energy = 0.0;
        for cable in 0..self.ends[0].len() {
            for element in 0..self.layout.elements {
                let nodes = &self.places[2 * element..2 * element + COORDINATES];
                energy += self.law.energy(cable, &std::array::from_fn(|i| nodes[i].get(cable)[0]));
            }
        }
        energy
    }

    /// Elastic forces on all coordinates, as they lie [N].
    #[inline(always)]
    fn pull(&mut self) {
        for place in &mut self.places {
            place.force.iter_mut().for_each(|axis| axis.fill(0.0));
        }
        for element in 0..self.layout.elements {
            let nodes = &mut self.places[2 * element..2 * element + COORDINATES];
            if self.law.damped {
                self.law.damp(element, nodes);
            }
            self.law.stretch(element, nodes, &mut self.tension);
            if let Some(bending) = &self.law.bending {
                bend(bending, nodes);
            }
        }
    }

    /// v += h a of all coordinates.
    #[inline(always)]
    pub(super) fn speed_up(&mut self, step: f64) {
        for Coordinates { velocity, acceleration, .. } in self.places.iter_mut().chain([&mut self.knots]) {
            for (velocity, acceleration) in velocity.iter_mut().zip(acceleration) {
                add(velocity, step, acceleration);
            }
        }
    }

    /// From forces to accelerations along `axis`: the condensed matrix for the knots, then every cable's own.
    #[inline(always)]
    pub(super) fn accelerate(&mut self, axis: usize) {
        let n = self.tension.len();
        let [first, last] = self.layout.ends();
        for (i, place) in self.layout.inner().enumerate() {
            for (end, at) in [first, last].into_iter().enumerate() {
                let factor = -self.condensed.share[i][end];
                let [from, to] = two(&mut self.places, place, at);
                add(&mut to.force[axis][..n], factor, &from.force[axis][..n]);
            }
        }
        let at_knots = &mut self.knots.acceleration[axis];
        at_knots.copy_from_slice(&self.knots.force[axis]);
        for (ends, place) in self.ends.iter().zip([first, last]) {
            for (&knot, force) in ends.iter().zip(&self.places[place].force[axis]) {
                at_knots[knot] += force;
            }
        }
        self.knot_mass.solve(at_knots);
        for (ends, place) in self.ends.iter().zip([first, last]) {
            for (&knot, at_end) in ends.iter().zip(&mut self.places[place].acceleration[axis]) {
                *at_end = at_knots[knot];
            }
        }
        for (i, place) in self.layout.inner().enumerate() {
            self.places[place].acceleration[axis].fill(0.0);
            for (factor, other) in self.condensed.inverse[i].iter().zip(self.layout.inner()) {
                if other == place {
                    let own = &mut self.places[place];
                    add(&mut own.acceleration[axis][..n], *factor, &own.force[axis][..n]);
                } else {
                    let [from, to] = two(&mut self.places, other, place);
                    add(&mut to.acceleration[axis][..n], *factor, &from.force[axis][..n]);
                }
            }
            let values = &mut self.places[place].acceleration[axis];
            for (value, inverse) in values.iter_mut().zip(&self.law.inverse_mass) {
                *value *= inverse;
            }
            for (end, at) in [first, last].into_iter().enumerate() {
                let [from, to] = two(&mut self.places, at, place);
                add(
                    &mut to.acceleration[axis][..n],
                    -self.condensed.share[i][end],
                    &from.acceleration[axis][..n],
                );
            }
        }
    }
}

/// x += h v of all coordinates, for the widest vectors of the processor.
struct Drift<'a> {
    net: &'a mut AncfNet,
    step: f64,
}

/// v += h M⁻¹ f of all coordinates, likewise.
struct Kick<'a> {
    net: &'a mut AncfNet,
    step: f64,
}

// Both are structs and not closures: only a method that is always inlined is compiled again for wide vectors.
impl NullaryFnOnce for Drift<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for Coordinates { position, velocity, .. } in self.net.places.iter_mut().chain([&mut self.net.knots])
        {
            for (position, velocity) in position.iter_mut().zip(velocity) {
                add(position, self.step, velocity);
            }
        }
    }
}

impl NullaryFnOnce for Kick<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Kick { net, step } = self;
        net.pull();
        for (force, push) in net.knots.force.iter_mut().zip(&net.push) {
            force.copy_from_slice(push);
        }
        for axis in 0..3 {
            net.accelerate(axis);
        }
        if net.law.damped {
            net.law.book(&net.places, step, &mut net.dissipated);
        }
        net.speed_up(step);
    }
}

#[cfg(test)]
mod tests {
    use super::super::element::MASS;
    use super::*;
    use crate::cable::Cable;
    use nalgebra::Rotation3;

    const LENGTH: f64 = 1.5;
    const STIFFNESS: f64 = 4e4;
    const MASS_OF_CABLE: f64 = 0.02;

    /// Two cables from one knot to two others.
    fn net() -> Net {
        let cable = |a, b| Cable {
            a,
            b,
            rest_length: LENGTH,
            stiffness: STIFFNESS,
            damping: 0.0,
            mass: MASS_OF_CABLE,
            reduced_mass: 0.5,
            breaking_tension: f64::INFINITY,
        };
        let corners = [Vector3::zeros(), LENGTH * Vector3::y(), LENGTH * Vector3::z()];
        Net {
            grid: [3, 1],
            mass: vec![1.0; 3],
            radius: vec![0.01; 3],
            young_modulus: vec![1e9; 3],
            cables: [cable(0, 1), cable(2, 0)].into(),
            bullets: [0; 4],
            perimeter: vec![0],
            designed_area: 1.0,
            folded: corners.to_vec(),
            folded_inwards: false,
            launch_velocity: vec![Vector3::zeros(); 3],
            delay: [0.0; 4],
        }
    }

    fn ancf(elements: u32, bending: bool) -> Ancf {
        Ancf { elements, bending, ..Ancf::default() }
    }

    /// Elastic forces on all coordinates at `knots` and `inner`.
    fn forces(ancf: &Ancf, knots: &Knots, inner: &Knots) -> Vec<Vector3<f64>> {
        let mut elements = AncfNet::new(&net(), ancf);
        elements.load(knots, inner, &[]);
        elements.pull();
        let at = |place: &Coordinates, cable: usize| {
            Vector3::new(place.force[0][cable], place.force[1][cable], place.force[2][cable])
        };
        (0..2)
            .flat_map(|cable| elements.places.iter().map(move |place| at(place, cable)).collect::<Vec<_>>())
            .collect()
    }

    /// Both cables straight, `factor` times their length, moved and turned.
    fn placed(ancf: &Ancf, factor: f64) -> (Knots, Knots) {
        let turn = Rotation3::from_euler_angles(0.4, -0.9, 2.1);
        let shift = Vector3::new(3.0, -2.0, 5.0);
        let position = net().folded.iter().map(|x| shift + turn * (factor * x)).collect();
        let knots = Knots { position, velocity: vec![Vector3::zeros(); 3] };
        let inner = element_net(&net(), ancf).straight(&knots);
        (knots, inner)
    }

    #[test]
    fn rigid_motion_gives_no_force() {
        for ancf in [ancf(1, false), ancf(2, false), ancf(3, true)] {
            let (knots, inner) = placed(&ancf, 1.0);
            let largest = forces(&ancf, &knots, &inner).iter().map(Vector3::norm).fold(0.0, f64::max);
            let rigidity = STIFFNESS * LENGTH;
            println!("{ancf:?}: {:e} of E A", largest / rigidity);
            assert!(largest < 1e-12 * rigidity, "{largest}"); // measured: see the printed values
        }
    }

    /// N = E A ε λ with ε = (λ² − 1) / 2: to first order E A times the strain; shortened, none.
    #[test]
    fn a_stretched_element_gives_its_strain_times_its_rigidity() {
        let rigidity = STIFFNESS * LENGTH;
        for elements in [1, 2, 3] {
            let ancf = ancf(elements, false);
            for strain in [1e-4, 1e-2, -0.5] {
                let (knots, inner) = placed(&ancf, 1.0 + strain);
                let force = forces(&ancf, &knots, &inner)[0].norm();
                let factor = 1.0 + strain;
                let wanted = (rigidity * 0.5 * (factor * factor - 1.0) * factor).max(0.0);
                assert!((force - wanted).abs() < 1e-11 * rigidity, "{force} {wanted}");
                if strain > 0.0 {
                    assert!((force / (rigidity * strain) - 1.0).abs() < 2.0 * strain);
                }
            }
        }
    }

    /// Bent, partly slack and partly taut: forces are the slope of the energy, sum to zero, and have no moment.
    #[test]
    fn forces_are_the_slope_of_the_energy_and_keep_momentum() {
        for ancf in [ancf(2, false), ancf(2, true)] {
            let (knots, mut inner) = placed(&ancf, 1.01);
            for (i, x) in inner.position.iter_mut().enumerate() {
                let phase = i as f64;
                *x += 0.02 * Vector3::new(phase.sin(), (2.0 * phase).cos(), (3.0 * phase).sin());
            }
            let all = forces(&ancf, &knots, &inner);
            let energy = |inner: &Knots| {
                let mut elements = AncfNet::new(&net(), &ancf);
                elements.load(&knots, inner, &[]);
                elements.elastic()
            };
            let layout = NodeList { elements: 2 };
            let inner_of: Vec<usize> = (0..2)
                .flat_map(|cable| layout.inner().map(move |place| cable * layout.size() + place))
                .collect();
            let scale = all.iter().map(Vector3::norm).fold(0.0, f64::max);
            for (coordinate, &place) in inner_of.iter().enumerate() {
                let slope = Vector3::from_fn(|axis, _| {
                    let [more, less] = [1e-6, -1e-6].map(|shift| {
                        let mut moved = inner.clone();
                        moved.position[coordinate][axis] += shift;
                        energy(&moved)
                    });
                    (less - more) / 2e-6
                });
                assert!((slope - all[place]).norm() < 1e-5 * scale, "{slope} {}", all[place]);
            }
            let mut elements = AncfNet::new(&net(), &ancf);
            elements.load(&knots, &inner, &[]);
            let (mut sum, mut moment) = (Vector3::zeros(), Vector3::zeros());
            for cable in 0..2 {
                for (place, motion) in elements.places.iter().enumerate() {
                    let force = all[cable * layout.size() + place];
                    let [x, _] = motion.get(cable);
                    moment += x.cross(&force);
                    if place % 2 == 0 {
                        sum += force;
                    }
                }
            }
            assert!(sum.norm() < 1e-12 * scale && moment.norm() < 1e-11 * scale, "{sum} {moment}");
        }
    }

    /// M a = f: the accelerations times the whole mass matrix give the forces back.
    #[test]
    fn accelerations_times_the_mass_matrix_are_the_forces() {
        for elements in [1, 2, 4] {
            let ancf = ancf(elements, false);
            let (knots, mut inner) = placed(&ancf, 1.02);
            inner.position.iter_mut().enumerate().for_each(|(i, x)| x.x += 0.01 * (i as f64).sin());
            let push = [Vector3::new(1.0, 2.0, 3.0), Vector3::zeros(), Vector3::new(-5.0, 0.0, 7.0)];
            let all = forces(&ancf, &knots, &inner);
            let mut elements = AncfNet::new(&net(), &ancf);
            elements.load(&knots, &inner, &push);
            elements.kick(1.0);
            // What is missing at each knot, and the largest at any inner coordinate.
            let mut missing = push;
            for (knot, mass) in own_mass(&net()).into_iter().enumerate() {
                missing[knot] -= mass * elements.knots.get(knot)[1];
            }
            let scale = all.iter().map(Vector3::norm).fold(1.0, f64::max);
            let len = elements.layout.size();
            for cable in 0..2 {
                for place in 0..len {
                    let mut left = all[cable * len + place];
                    for element in 0..elements.layout.elements {
                        let nodes = 2 * element..2 * element + COORDINATES;
                        if !nodes.contains(&place) {
                            continue;
                        }
                        for other in nodes.clone() {
                            let mass =
                                elements.law.mass[cable] * MASS[place - nodes.start][other - nodes.start];
                            left -= mass * elements.places[other].get(cable)[1];
                        }
                    }
                    match elements.layout.ends().iter().position(|&end| end == place) {
                        Some(end) => missing[elements.ends[end][cable]] += left,
                        None => assert!(left.norm() < 1e-10 * scale, "{place}: {left}"),
                    }
                }
            }
            assert!(missing.iter().all(|left| left.norm() < 1e-10 * scale), "{missing:?}");
        }
    }
}
