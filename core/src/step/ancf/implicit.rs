//! An implicit step of the net of elements: of second order, stable whatever its length, and it keeps energy.
//!
//! x₁ = x₀ + h (v₀ + v₁) / 2,  M (v₁ − v₀) = h F̄(x₀, x₁),
//!
//! with the mean force F̄ of [`super::over_step`]: the energy-momentum form of the midpoint rule. What elements store is what
//! the motion gave them, so a step of any length makes no energy; only the dashpots take any. Forces of effects are held
//! over the step. Unknown is w = x₁ − x₀ − h v₀, and Newton's method solves
//!
//! M w − (h²/2) F̄(x₀ + h v₀ + w) = 0.
//!
//! The energy of what pulls and cannot push is convex, so the matrix M + (h²/2) K is positive definite however the net lies. Each
//! cable's own coordinates are eliminated ([`super::block`]), what is left couples knots along three axes and has a band three
//! times as wide as the mass matrix. A whole correction keeps momentum to rounding, an unfinished one too; angular momentum
//! and energy are kept as far as the corrections went. A step that they do not finish is cut in two.

use pulp::NullaryFnOnce;

use super::band::BandMatrix;
use super::block::{BORDER, CableBlock, Slot, slots};
use super::element::{BEND, COORDINATES, ElementMatrix, MASS};
use super::kernel::AncfNet;
use super::mass::own_mass;
use super::motion::{Axes, Coordinates, LANES, Lanes, add_lanes, lanes, lanes_of};
use super::over_step::{AXES, Nodes, OverStep, account};
use crate::net::Net;

/// Corrections end when the largest is below this share of a cable's length.
const TOLERANCE: f64 = 1e-9;

/// Corrections before a step is cut.
const MOST: u32 = 25;

/// How often a step is cut in two, at most.
const CUTS: u32 = 12;

/// The implicit step's memory.
pub(super) struct ImplicitStep {
    /// Mass of an element of each cable, 1 for those that fill the last group [kg].
    mass: Vec<f64>,
    /// Mass of each knot beside its cables [kg].
    own_mass: Vec<f64>,
    /// Length of the shortest cable [m].
    length: f64,
    slots: Vec<Slot>,
    /// Of each group of cables.
    blocks: Vec<CableBlock>,
    matrix: BandMatrix,
    /// Right side, then solution, for each knot in the order of the band along three axes.
    values: Vec<f64>,
    /// Positions before the step, of each place and of the knots last [m].
    start: Vec<Axes>,
    /// Corrections so far.
    pub(super) n_corrections: u64,
}

impl ImplicitStep {
    /// For the elements of `net`, which `elements` holds.
    pub(super) fn new(net: &Net, elements: &AncfNet) -> ImplicitStep {
        let place = &elements.knot_mass.place;
        let apart = net.cables.iter().map(|cable| place[cable.a].abs_diff(place[cable.b]));
        let width = 3 * apart.max().unwrap_or(0) + 2;
        let n = 3 * net.n_knots();
        let n_groups = elements.law.length.len() / LANES;
        ImplicitStep {
            mass: elements.law.mass.iter().map(|mass| if mass.is_finite() { *mass } else { 1.0 }).collect(),
            own_mass: own_mass(net),
            length: net.cables.iter().map(|cable| cable.rest_length).fold(f64::INFINITY, f64::min),
            slots: slots(elements.layout),
            blocks: (0..n_groups).map(|_| CableBlock::new(elements.layout)).collect(),
            matrix: BandMatrix::zeros(n, width.min(n - 1)),
            values: vec![0.0; n],
            start: elements.coordinates().map(|of| of.position.clone()).collect(),
            n_corrections: 0,
        }
    }

    /// Moves `net` on by `step` seconds. Where corrections do not end the step is taken in halves; whether they ended at all.
    pub(super) fn advance(&mut self, net: &mut AncfNet, step: f64) -> bool {
        self.advance_by(net, step, CUTS)
    }

    fn advance_by(&mut self, net: &mut AncfNet, step: f64, cuts: u32) -> bool {
        if self.solve(net, step) {
            let arch = net.arch;
            arch.dispatch(Finish { of: self, net, step });
            return true;
        }
        for (coordinates, start) in net.coordinates_mut().zip(&self.start) {
            coordinates.position.clone_from(start);
        }
        cuts > 0 && (0..2).all(|_| self.advance_by(net, 0.5 * step, cuts - 1))
    }

    /// Corrects positions until they are those after the step; whether that ended.
    fn solve(&mut self, net: &mut AncfNet, step: f64) -> bool {
        let arch = net.arch;
        for (coordinates, start) in net.coordinates_mut().zip(&mut self.start) {
            start.clone_from(&coordinates.position);
            coordinates.acceleration.iter_mut().for_each(|axis| axis.fill(0.0));
        }
        net.drift(step);
        for _ in 0..MOST {
            self.n_corrections += 1;
            arch.dispatch(Assemble { of: self, net, step });
            arch.dispatch(Solve { of: self, net, step });
            let largest = arch.dispatch(Correct { of: self, net });
            if largest <= TOLERANCE * self.length {
                return true;
            }
            if !largest.is_finite() {
                return false;
            }
        }
        false
    }

    /// The equations of the knots: what cables leave of theirs, and what knots have themselves.
    #[inline(always)]
    fn couple(&mut self, net: &AncfNet, step: f64) {
        let place = &net.knot_mass.place;
        self.matrix.clear();
        for (knot, mass) in self.own_mass.iter().enumerate() {
            for axis in 0..3 {
                let at = 3 * place[knot] + axis;
                let inertia = mass * net.knots.acceleration[axis][knot];
                self.values[at] = 0.5 * step * step * net.push[axis][knot] - inertia;
                *self.matrix.at(at, at) += mass;
            }
        }
        for cable in 0..net.ends[0].len() {
            let at = |i: usize| 3 * place[net.ends[i / 3][cable]] + i % 3;
            for (i, j, value) in self.blocks[cable / LANES].left(cable % LANES) {
                if j == BORDER {
                    self.values[at(i)] += value;
                } else {
                    *self.matrix.at(at(i), at(j)) += value;
                }
            }
        }
    }
}

/// The equations of all cables, for the widest vectors of the processor.
struct Assemble<'a> {
    of: &'a mut ImplicitStep,
    net: &'a AncfNet,
    step: f64,
}

/// Eliminates, factorises and solves, likewise.
struct Solve<'a> {
    of: &'a mut ImplicitStep,
    net: &'a AncfNet,
    step: f64,
}

/// Corrects all coordinates; the largest correction [m].
struct Correct<'a> {
    of: &'a mut ImplicitStep,
    net: &'a mut AncfNet,
}

/// Velocities after the step, and what the dashpots took.
struct Finish<'a> {
    of: &'a mut ImplicitStep,
    net: &'a mut AncfNet,
    step: f64,
}

impl NullaryFnOnce for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Solve { of, net, step } = self;
        // A loop and not `for_each`: what is not inlined is not compiled for wide vectors.
        for block in &mut of.blocks {
            block.eliminate();
        }
        of.couple(net, step);
        of.matrix.factorise();
        of.matrix.solve(&mut of.values);
    }
}

/// Of the cables from `at` on, the coordinates of an element whose places begin with `places`.
#[inline(always)]
fn nodes(places: &[Coordinates], of: impl Fn(&Coordinates) -> &Axes, at: usize) -> Nodes {
    let mut nodes = [[[0.0; LANES]; 3]; COORDINATES];
    for (node, place) in nodes.iter_mut().zip(places) {
        *node = lanes_of(of(place), at);
    }
    nodes
}

/// The same before the step.
#[inline(always)]
fn nodes_before(start: &[Axes], at: usize) -> Nodes {
    let mut nodes = [[[0.0; LANES]; 3]; COORDINATES];
    for (node, axes) in nodes.iter_mut().zip(start) {
        *node = lanes_of(axes, at);
    }
    nodes
}

impl NullaryFnOnce for Assemble<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Assemble { of, net, step } = self;
        for (group, block) in of.blocks.iter_mut().enumerate() {
            let at = group * LANES;
            block.clear();
            for element in 0..net.layout.elements {
                let places = &net.places[2 * element..];
                let before = nodes_before(&of.start[2 * element..], at);
                let after = nodes(places, |of| &of.position, at);
                let moved = nodes(places, |of| &of.acceleration, at);
                let slots = &of.slots[2 * element..2 * element + COORDINATES];
                let over_step = OverStep::of(&net.law, at, &before, &after, step);
                add_law(block, slots, &over_step, 0.5 * step * step);
                add_matrix(block, slots, &MASS, &lanes(&of.mass, at), [1.0, 1.0], &moved);
                if let Some(bending) = &net.law.bending {
                    let mut sum = before;
                    for i in 0..3 * COORDINATES {
                        for lane in 0..LANES {
                            sum[i / 3][i % 3][lane] += after[i / 3][i % 3][lane];
                        }
                    }
                    let quarter = 0.25 * step * step;
                    add_matrix(block, slots, &BEND, &lanes(bending, at), [quarter, quarter], &sum);
                }
            }
        }
    }
}

/// Adds what the law of an element gives over a step, times `factor`.
#[inline(always)]
fn add_law(block: &mut CableBlock, slots: &[Slot], law: &OverStep, factor: f64) {
    // Coordinates of an element in r₁ − r₀, σ₀ and σ₁, with which sign; and where their pairs are in `PAIRS`.
    const PARTS: [(usize, f64); COORDINATES] = [(0, -1.0), (1, 1.0), (0, 1.0), (2, 1.0)];
    const PAIR: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
    for (j, (other, sign)) in PARTS.into_iter().enumerate() {
        for axis in 0..3 {
            block.add((slots[j], axis), None, -sign * factor, &law.force[other][axis]);
        }
        for (i, (one, its_sign)) in PARTS[..=j].iter().enumerate() {
            let by = sign * its_sign * factor;
            for ([axis, across], value) in AXES.iter().zip(&law.stiffness[PAIR[*one][other]]) {
                block.add((slots[j], *axis), Some((slots[i], *across)), by, value);
                if i != j && axis != across {
                    block.add((slots[j], *across), Some((slots[i], *axis)), by, value);
                }
            }
        }
    }
}

/// Adds a matrix that is the same along all axes, times `scale` and the first of `factors`, and what it makes of `of` times the
/// second.
#[inline(always)]
fn add_matrix(
    block: &mut CableBlock,
    slots: &[Slot],
    matrix: &ElementMatrix,
    scale: &Lanes,
    factors: [f64; 2],
    of: &Nodes,
) {
    for (j, row) in matrix.iter().enumerate() {
        for axis in 0..3 {
            let mut made = [0.0; LANES];
            for (entry, node) in row.iter().zip(of) {
                for lane in 0..LANES {
                    made[lane] += entry * node[axis][lane];
                }
            }
            for lane in 0..LANES {
                made[lane] *= scale[lane];
            }
            block.add((slots[j], axis), None, -factors[1], &made);
            for (entry, slot) in row[..=j].iter().zip(slots) {
                block.add((slots[j], axis), Some((*slot, axis)), factors[0] * entry, scale);
            }
        }
    }
}

impl NullaryFnOnce for Correct<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Correct { of, net } = self;
        let AncfNet { places, knots, knot_mass, ends, .. } = net;
        let mut largest = 0.0_f64;
        // What is not a number is never the smaller.
        let mut see = |value: f64| largest = if value.abs() <= largest { largest } else { value.abs() };
        for (knot, place) in knot_mass.place.iter().enumerate() {
            for axis in 0..3 {
                let value = of.values[3 * place + axis];
                see(value);
                knots.position[axis][knot] += value;
                knots.acceleration[axis][knot] += value;
            }
        }
        let n = ends[0].len();
        for (group, block) in of.blocks.iter_mut().enumerate() {
            let at = group * LANES;
            let n_cables = LANES.min(n - at);
            let mut at_ends = [[0.0; LANES]; BORDER];
            for (i, values) in at_ends.iter_mut().enumerate() {
                for (value, knot) in values.iter_mut().zip(&ends[i / 3][at..at + n_cables]) {
                    *value = of.values[3 * knot_mass.place[*knot] + i % 3];
                }
            }
            block.substitute(&at_ends);
            for (place, slot) in of.slots.iter().enumerate() {
                let mut change = [[0.0; LANES]; 3];
                for (axis, change) in change.iter_mut().enumerate() {
                    *change = match *slot {
                        Slot::Own(own) => *block.solution(own, axis),
                        Slot::End(end) => at_ends[3 * end + axis],
                    };
                    for value in &change[..n_cables] {
                        see(*value);
                    }
                }
                let Coordinates { position, acceleration, .. } = &mut places[place];
                add_lanes(position, at, &[1.0; LANES], &change);
                add_lanes(acceleration, at, &[1.0; LANES], &change);
            }
        }
        largest
    }
}

impl NullaryFnOnce for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Finish { of, net, step } = self;
        for at in (0..net.law.length.len()).step_by(LANES) {
            let length = lanes(&net.law.length, at);
            for element in 0..net.layout.elements {
                let before = nodes_before(&of.start[2 * element..], at);
                let after = nodes(&net.places[2 * element..], |of| &of.position, at);
                let [taken, largest] = account(&net.law, at, &before, &after, step);
                for i in 0..LANES {
                    net.dissipated[at + i] += taken[i];
                    net.tension[at + i] = net.tension[at + i].max(largest[i] * length[i]);
                }
            }
        }
        net.speed_up(2.0 / step);
    }
}
