//! Cables as the source's mass-spring net (Eq. 3.1 to 3.5), integrated in explicit sub-steps.
//!
//! State as structure of arrays, one array a component. Cables are sorted into runs whose ends both
//! advance by one knot from cable to cable, so that a run reads and writes contiguous memory and
//! needs no gather: the lines along Y of a grid are one run, those along Z another, with a cable
//! of no stiffness bridging each row's end. The loops are plain; at run time they are dispatched to
//! the widest vectors the processor has. No sum is reordered, so the bits do not depend on them.

use std::hint::select_unpredictable;

use nalgebra::Vector3;
use pulp::{Arch, NullaryFnOnce};

use super::dopri5::Dopri5;
use super::secant::{self, Secant};
use crate::cable::{Cable, stored_between, taut_force, work_by_law};
use crate::net::Net;
use crate::solver::Integrator;
use crate::state::Knots;

/// Cables whose forces are found together, and then added up. What is found goes to memory of its own, which the loop is told of: whether vectors
/// overlap with one of those that are read was asked at each loop, for a third of its time.
const CHUNK: usize = 128;

/// Cables that are passed over together while none of them is taut: most of a net in flight is slack. The length of a run is a multiple of it.
const GROUP: usize = 8;

/// Squared length over that of the rest up to which no rounding makes a cable taut [-].
const SLACK: f64 = 1.0 - 1e-14;

/// Three components, an array each.
pub(super) type Components = [Vec<f64>; 3];

/// The net as the kernel sees it.
pub struct ExplicitNet {
    arch: Arch,
    integrator: Integrator,
    /// The integrator of the flight, see [`ExplicitNet::land`].
    in_flight: Integrator,
    /// Place of each knot in the arrays.
    place: Vec<usize>,
    position: Components,
    velocity: Components,
    /// Acceleration by forces of effects [m/s^2].
    push: Components,
    inverse_mass: Vec<f64>,
    acceleration: Components,
    strands: CableRuns,
    stages: Option<Box<RungeKuttaStages>>,
    located: Option<Box<Dopri5>>,
    secant: Option<Box<Secant>>,
    /// Taken by cables by their law since it was last asked for, as found by methods with stages [J].
    dissipated: f64,
    /// Whether velocities were changed since the last kick.
    pushed: bool,
}

/// Cables in the order of the runs.
pub(super) struct CableRuns {
    pub(super) runs: Vec<CableRun>,
    pub(super) stiffness: Vec<f64>,
    pub(super) damping: Vec<f64>,
    pub(super) rest_length: Vec<f64>,
    /// Squared length up to which a cable is slack whatever is rounded [m^2].
    slack: Vec<f64>,
    /// Stretch when forces were last found, 0 where slack [m].
    stretch: Vec<f64>,
    /// Whether one of each group of cables was taut then, 1 or 0.
    was_taut: Vec<u64>,
    /// Taken by their law since it was last asked for, in sums side by side [J]; of a method with stages the power then [W].
    dissipated: [f64; GROUP],
    /// Whether forces are found at the stages of a step, and not at the ends of drifts.
    at_stages: bool,
    /// What [`secant`](super::secant) weighs a debt by [1/kg].
    pub(super) gentle: Vec<f64>,
    /// Largest tension since it was last asked for [N].
    pub(super) tension: Vec<f64>,
    /// Cable of the net at each place; none for a bridge.
    cable: Vec<Option<usize>>,
    /// Kept for its memory.
    found: Option<Box<PieceForces>>,
}

/// What is found of the cables of a piece.
struct PieceForces {
    /// Whether they may be taut, 1 or 0.
    is_taut: [u64; CHUNK],
    /// From where to where groups are that hold one that may.
    taut: [(usize, usize); CHUNK / GROUP],
    /// Forces on their first ends [N], their stretch, 0 where slack [m], and the rate of their length [m/s].
    of: [[f64; CHUNK]; 5],
}

impl Default for PieceForces {
    fn default() -> PieceForces {
        PieceForces { is_taut: [0; CHUNK], taut: [(0, 0); CHUNK / GROUP], of: [[0.0; CHUNK]; 5] }
    }
}

impl PieceForces {
    /// Joins groups of the first `n` cables that hold one that may be taut, or `was`; how many stretches that makes.
    #[inline(always)]
    fn join(&mut self, n: usize, was_taut: &[u64]) -> usize {
        let mut n_taut = 0;
        for ((group, is_taut), was_taut) in self.is_taut[..n].chunks_exact(GROUP).enumerate().zip(was_taut) {
            if is_taut.iter().sum::<u64>() + was_taut == 0 {
                continue;
            }
            let start = group * GROUP;
            if n_taut > 0 && self.taut[n_taut - 1].1 == start {
                self.taut[n_taut - 1].1 += GROUP;
            } else {
                self.taut[n_taut] = (start, start + GROUP);
                n_taut += 1;
            }
        }
        n_taut
    }
}

/// Cables `first..first + length`, from knots `a..` to knots `b..`.
pub(super) struct CableRun {
    pub(super) first: usize,
    pub(super) length: usize,
    pub(super) a: usize,
    pub(super) b: usize,
    /// 0 of the lines along Y, 1 of those along Z.
    pub(super) family: usize,
}

/// What classical RK4 keeps between its stages.
struct RungeKuttaStages {
    position: Components,
    velocity: Components,
    position_sum: Components,
    velocity_sum: Components,
}

impl ExplicitNet {
    /// The kernel for `net`; `tolerance` is that of the integrator `located` [m].
    pub fn new(net: &Net, integrator: Integrator, tolerance: f64) -> ExplicitNet {
        let place = places(net);
        // Those beyond the net are ends of the cables that fill runs up.
        let n_knots = net.n_knots() + GROUP;
        let zeros = || [vec![0.0; n_knots], vec![0.0; n_knots], vec![0.0; n_knots]];
        let mut inverse_mass = vec![0.0; n_knots];
        for (knot, &at) in place.iter().enumerate() {
            inverse_mass[at] = 1.0 / net.mass[knot];
        }
        let stages = (integrator == Integrator::Rk4).then(|| {
            let (position, velocity) = (zeros(), zeros());
            Box::new(RungeKuttaStages { position, velocity, position_sum: zeros(), velocity_sum: zeros() })
        });
        let strands = CableRuns::of(net, &place);
        let secant = (integrator == Integrator::Secant).then(|| Box::new(Secant::new(&strands, n_knots)));
        let mut kernel = ExplicitNet {
            arch: Arch::new(),
            integrator,
            in_flight: integrator,
            secant,
            dissipated: 0.0,
            pushed: false,
            strands,
            place,
            position: zeros(),
            velocity: zeros(),
            push: zeros(),
            inverse_mass,
            acceleration: zeros(),
            stages,
            located: (integrator == Integrator::Located).then(|| Box::new(Dopri5::new(net, tolerance))),
        };
        kernel.go_on_by(integrator);
        kernel.load(&Knots { position: net.folded.clone(), velocity: net.launch_velocity.clone() }, &[]);
        kernel
    }

    /// Takes positions and velocities over from `knots`, and the forces of effects [N].
    pub fn load(&mut self, knots: &Knots, forces: &[Vector3<f64>]) {
        self.tell_secant(knots);
        let mut moved = false;
        for (&at, (position, velocity)) in self.place.iter().zip(knots.position.iter().zip(&knots.velocity)) {
            for axis in 0..3 {
                moved |= self.position[axis][at] != position[axis];
                self.position[axis][at] = position[axis];
                self.velocity[axis][at] = velocity[axis];
            }
        }
        if moved {
            self.displace();
        }
        if !forces.is_empty() {
            for (&at, force) in self.place.iter().zip(forces) {
                for axis in 0..3 {
                    self.push[axis][at] = force[axis] * self.inverse_mass[at];
                }
            }
        }
    }

    /// The secant force hears of the energy of `knots`.
    fn tell_secant(&mut self, knots: &Knots) {
        if self.has_landed() {
            return;
        }
        let Some(secant) = &mut self.secant else { return };
        let speeds = self.place.iter().zip(&knots.velocity);
        secant.observe_kinetic(
            speeds.map(|(&at, velocity)| 0.5 * velocity.norm_squared() / self.inverse_mass[at]).sum(),
        );
    }

    /// Books begin anew where knots are that did not come there by their velocities.
    fn displace(&mut self) {
        self.strands.begin_drift(&self.position);
        if let Some(secant) = &mut self.secant {
            secant.displace();
        }
    }

    /// Hands positions and velocities over to `knots`.
    pub fn store(&self, knots: &mut Knots) {
        self.store_some(knots, 0..self.place.len());
    }

    /// The same of some of the knots.
    pub fn store_some(&self, knots: &mut Knots, which: impl Iterator<Item = usize>) {
        for knot in which {
            knots.position[knot] = self.position(knot);
            knots.velocity[knot] = self.velocity(knot);
        }
    }

    /// Largest tension of each cable of the net since the last call [N].
    pub fn take_tension(&mut self, tension: &mut [f64]) {
        for (cable, largest) in self.strands.cable.iter().zip(&mut self.strands.tension) {
            if let Some(cable) = *cable {
                tension[cable] = *largest;
            }
            *largest = 0.0;
        }
    }

    /// Position of a knot [m].
    #[inline]
    pub fn position(&self, knot: usize) -> Vector3<f64> {
        let at = self.place[knot];
        Vector3::new(self.position[0][at], self.position[1][at], self.position[2][at])
    }

    /// Velocity of a knot [m/s].
    #[inline]
    pub fn velocity(&self, knot: usize) -> Vector3<f64> {
        let at = self.place[knot];
        Vector3::new(self.velocity[0][at], self.velocity[1][at], self.velocity[2][at])
    }

    /// One over the mass of a knot [1/kg].
    #[inline]
    pub fn inverse_mass(&self, knot: usize) -> f64 {
        self.inverse_mass[self.place[knot]]
    }

    /// Changes the velocity of a knot by an impulse [N s].
    #[inline]
    pub fn push(&mut self, knot: usize, impulse: &Vector3<f64>) {
        self.pushed = true;
        let at = self.place[knot];
        for axis in 0..3 {
            self.velocity[axis][at] += impulse[axis] * self.inverse_mass[at];
        }
    }

    /// Gives a knot a new velocity [m/s].
    #[inline]
    pub fn set_velocity(&mut self, knot: usize, velocity: &Vector3<f64>) {
        self.pushed = true;
        let at = self.place[knot];
        for axis in 0..3 {
            self.velocity[axis][at] = velocity[axis];
        }
    }

    /// Velocities after the forces of a sub-step of `step` seconds; positions follow in `drift`.
    pub fn kick(&mut self, step: f64) {
        match self.integrator {
            Integrator::Secant => self.kick_secant(step),
            // Scenes with another net are refused `implicit`.
            Integrator::Symplectic | Integrator::Auto | Integrator::Implicit => {
                self.kick_symplectic(step, None)
            }
            Integrator::Rk4 => self.kick_rk4(step),
            Integrator::Located => self.kick_located(step),
        }
    }

    /// A whole sub-step of `step` seconds in which nothing else changes velocities: kick and drift at once.
    pub fn fly(&mut self, step: f64) {
        if self.lags() {
            self.kick_symplectic(step, Some(step));
        } else {
            self.kick(step);
            self.drift(step);
        }
    }

    /// Velocities after the forces of `step` seconds, and where `drift` says how long positions go on with them, positions.
    fn kick_symplectic(&mut self, step: f64, drift: Option<f64>) {
        self.arch.dispatch(SymplecticKick {
            strands: &mut self.strands,
            position: &mut self.position,
            velocity: &mut self.velocity,
            inverse_mass: &self.inverse_mass,
            push: &self.push,
            force: &mut self.acceleration,
            step,
            drift,
        });
    }

    /// Whether velocities are those of half a sub-step before the positions.
    pub fn lags(&self) -> bool {
        self.integrator == Integrator::Symplectic
    }

    /// Whether a flight of velocities at the time of the positions was ended.
    pub fn has_landed(&self) -> bool {
        self.integrator != self.in_flight
    }

    /// Ends the flight of an integrator whose velocities are of the time of the positions. Whether there was one.
    ///
    /// A contact lets a knot go on for the whole sub-step with the velocity that it leaves. That is no way that a cable's
    /// work could be booked over: kept on through contact, with its books set right afterwards, the secant force made
    /// 2e-4 to 2 of the launch energy on captures. And it is no way of Runge-Kutta's stages: a pressed knot is put back by half a
    /// kick's way each time, so that contacts gave cables 1.7 of the launch energy around a Cubesat, and took 2.3.
    pub fn land(&mut self) -> bool {
        let flies = !self.lags();
        if flies {
            self.go_on_by(Integrator::Symplectic);
            self.strands.begin_drift(&self.position);
        }
        flies
    }

    /// Takes up again the flight that was ended, where what cables did to velocities is `lag` seconds behind positions; effects push for whole steps.
    pub fn fly_again(&mut self, lag: f64) {
        self.kick(lag);
        self.push_for(-lag);
        self.dissipated += self.strands.take_dissipated();
        self.go_on_by(self.in_flight);
        if let Some(secant) = &mut self.secant {
            secant.displace();
        }
    }

    /// Finds forces from now on as `integrator` does.
    fn go_on_by(&mut self, integrator: Integrator) {
        self.integrator = integrator;
        self.strands.at_stages = integrator == Integrator::Rk4;
    }

    /// Velocities after what effects push with has acted for `time` seconds by itself.
    pub fn push_for(&mut self, time: f64) {
        let (sum, term) = (&mut self.velocity, &self.push);
        self.arch.dispatch(AddScaled { sum, term, factor: time });
    }

    /// Positions after a sub-step of `step` seconds at the velocities of its end.
    pub fn drift(&mut self, step: f64) {
        let lands = std::mem::take(&mut self.pushed);
        let (sum, term) = (&mut self.position, &self.velocity);
        self.arch.dispatch(AddScaled { sum, term, factor: step });
        if lands {
            self.land();
        }
    }

    /// What the cables took by their law since the last call [J].
    ///
    /// Semi-implicit Euler's drift is booked when it has led to the next forces: over the path that it took c (s₁ − s₀) ṙ, as that of
    /// [`secant`]. (At the mean of the rates before and after a kick it is 0.22 of a snap's loss short of what a pair of
    /// knots really loses at the own step and a damping ratio of 0.1, so -0.02.)
    pub fn take_dissipated(&mut self) -> f64 {
        let in_flight = self.secant.as_mut().map_or(0.0, |secant| std::mem::take(&mut secant.dissipated));
        in_flight + self.strands.take_dissipated() + std::mem::take(&mut self.dissipated)
    }

    fn kick_secant(&mut self, step: f64) {
        let Some(secant) = &mut self.secant else { return };
        let moving = [&mut self.position, &mut self.velocity];
        secant.kick(&self.arch, step, &mut self.strands, moving, &self.inverse_mass, &self.push);
    }

    /// Acceleration of all knots at the present positions and velocities (Eq. 3.5).
    fn accelerate(&mut self) {
        self.arch.dispatch(Accelerate {
            strands: &mut self.strands,
            position: &self.position,
            velocity: &self.velocity,
            inverse_mass: &self.inverse_mass,
            push: &self.push,
            acceleration: &mut self.acceleration,
        });
    }

    /// Classical RK4 over the sub-step. It leaves the velocity of the end, and positions such that
    /// `drift` takes them to RK4's own: contact impulses in between act as with the other method.
    fn kick_rk4(&mut self, step: f64) {
        let Some(mut stages) = self.stages.take() else { return };
        stages.position.clone_from(&self.position);
        stages.velocity.clone_from(&self.velocity);
        for (weight, next) in [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)] {
            self.accelerate();
            self.dissipated += step / 6.0 * weight * self.strands.take_dissipated();
            for axis in 0..3 {
                let first = next == 0.5 && weight == 1.0;
                let sums = stages.position_sum[axis].iter_mut().zip(stages.velocity_sum[axis].iter_mut());
                let rates = self.velocity[axis].iter().zip(&self.acceleration[axis]);
                for ((x_sum, v_sum), (v, a)) in sums.zip(rates) {
                    *x_sum = if first { *v } else { *x_sum + weight * v };
                    *v_sum = if first { *a } else { *v_sum + weight * a };
                }
                let start = stages.position[axis].iter().zip(&stages.velocity[axis]);
                let now = self.position[axis].iter_mut().zip(self.velocity[axis].iter_mut());
                for (((x, v), (x0, v0)), a) in now.zip(start).zip(&self.acceleration[axis]) {
                    *x = x0 + next * step * *v;
                    *v = v0 + next * step * a;
                }
            }
        }
        for axis in 0..3 {
            for i in 0..self.inverse_mass.len() {
                let end = stages.position[axis][i] + step / 6.0 * stages.position_sum[axis][i];
                self.velocity[axis][i] = stages.velocity[axis][i] + step / 6.0 * stages.velocity_sum[axis][i];
                self.position[axis][i] = end - step * self.velocity[axis][i];
            }
            self.acceleration[axis].fill(0.0); // as the other integrators find it
        }
        self.stages = Some(stages);
    }

    /// Allows so many more tries of steps of its own, where it has any.
    pub fn allow(&mut self, tries: u64) {
        if let Some(located) = &mut self.located {
            located.allow(tries);
        }
    }

    /// Steps of its own that it tried so far.
    pub fn tried(&self) -> u64 {
        self.located.as_ref().map_or(0, |located| located.tried())
    }

    /// The located flight over the sub-step; it leaves what `kick_rk4` leaves.
    fn kick_located(&mut self, step: f64) {
        let Some(located) = &mut self.located else { return };
        let of = |components: &Components| in_order(&self.place, components);
        located.load(&of(&self.position), &of(&self.velocity), &of(&self.push));
        located.advance(step);
        for (knot, &at) in self.place.iter().enumerate() {
            let (end, velocity) = (located.position(knot), located.velocity(knot));
            for axis in 0..3 {
                self.velocity[axis][at] = velocity[axis];
                self.position[axis][at] = end[axis] - step * velocity[axis];
            }
        }
        self.dissipated += located.take_dissipated();
        let largest: Vec<f64> = located.take_tension().collect();
        for (cable, tension) in self.strands.cable.iter().zip(&mut self.strands.tension) {
            *tension = cable.map_or(0.0, |cable| tension.max(largest[cable]));
        }
    }
}

/// Three components as vectors, in the net's own order of knots.
fn in_order(place: &[usize], [x, y, z]: &Components) -> Vec<Vector3<f64>> {
    place.iter().map(|&at| Vector3::new(x[at], y[at], z[at])).collect()
}

/// `sum += factor * term`, for the widest vectors of the processor.
struct AddScaled<'a> {
    sum: &'a mut Components,
    term: &'a Components,
    factor: f64,
}

// Both are structs and not closures: only a method that is always inlined is compiled again for
// wide vectors.
impl NullaryFnOnce for AddScaled<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (sum, term) in self.sum.iter_mut().zip(self.term) {
            for (sum, term) in sum.iter_mut().zip(term) {
                *sum += self.factor * term;
            }
        }
    }
}

/// Acceleration of all knots, for the widest vectors of the processor.
struct Accelerate<'a> {
    strands: &'a mut CableRuns,
    position: &'a Components,
    velocity: &'a Components,
    inverse_mass: &'a [f64],
    push: &'a Components,
    acceleration: &'a mut Components,
}

impl NullaryFnOnce for Accelerate<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for forces in self.acceleration.iter_mut() {
            forces.fill(0.0);
        }
        self.strands.pull_all(self.position, self.velocity, self.acceleration);
        for (forces, push) in self.acceleration.iter_mut().zip(self.push) {
            for ((a, im), push) in forces.iter_mut().zip(self.inverse_mass).zip(push) {
                *a = *a * im + push;
            }
        }
    }
}

/// Velocities after the forces of a step, and positions after a drift at these, for the widest vectors of the processor. Forces are
/// none before and after it.
struct SymplecticKick<'a> {
    strands: &'a mut CableRuns,
    position: &'a mut Components,
    velocity: &'a mut Components,
    inverse_mass: &'a [f64],
    push: &'a Components,
    force: &'a mut Components,
    step: f64,
    /// Time of the drift, where there is one [s].
    drift: Option<f64>,
}

impl NullaryFnOnce for SymplecticKick<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.strands.pull_all(self.position, self.velocity, self.force);
        for axis in 0..3 {
            let knots = self.force[axis].iter_mut().zip(self.inverse_mass).zip(&self.push[axis]);
            let (position, velocity) = (&mut self.position[axis], &mut self.velocity[axis]);
            match self.drift {
                None => {
                    for (v, ((f, im), push)) in velocity.iter_mut().zip(knots) {
                        *v += self.step * (std::mem::take(f) * im + push);
                    }
                }
                Some(time) => {
                    for ((x, v), ((f, im), push)) in position.iter_mut().zip(velocity).zip(knots) {
                        *v += self.step * (std::mem::take(f) * im + push);
                        *x += time * *v;
                    }
                }
            }
        }
    }
}

impl CableRuns {
    fn of(net: &Net, place: &[usize]) -> CableRuns {
        let cables = &net.cables;
        let n_lines = |along: usize| (net.grid[along] - 1) * net.grid[1 - along];
        // Lines along Y stand first, all lines with as many pieces.
        let pieces = cables.len() / (n_lines(0) + n_lines(1)).max(1);
        let along_y = n_lines(0) * pieces;
        let mut order: Vec<(usize, usize, usize)> = cables
            .iter()
            .enumerate()
            .map(|(index, cable)| {
                let ends = [place[cable.a], place[cable.b]];
                let (a, b) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                (b - a, a, index)
            })
            .collect();
        order.sort_unstable();
        let mut strands = CableRuns {
            runs: Vec::new(),
            stiffness: Vec::new(),
            damping: Vec::new(),
            rest_length: Vec::new(),
            slack: Vec::new(),
            stretch: Vec::new(),
            was_taut: Vec::new(),
            dissipated: [0.0; GROUP],
            at_stages: false,
            gentle: Vec::new(),
            tension: Vec::new(),
            cable: Vec::new(),
            found: None,
        };
        for (apart, a, index) in order {
            let family = usize::from(index >= along_y);
            let next = strands.runs.last().map(|run| ((run.family, run.b - run.a), run.a + run.length));
            match next {
                Some((same, expected)) if same == (family, apart) && a == expected => {}
                // A bridge costs one cable, a new run the rest of a vector and its set-up.
                Some((same, expected)) if same == (family, apart) && a == expected + 1 => {
                    strands.add(None, None);
                }
                _ => {
                    strands.fill_up();
                    let first = strands.cable.len();
                    strands.runs.push(CableRun { first, length: 0, a, b: a + apart, family });
                }
            }
            strands.add(Some(index), Some(&cables[index]));
        }
        strands.fill_up();
        strands.stretch = vec![0.0; strands.cable.len()];
        strands.was_taut = vec![0; strands.cable.len() / GROUP];
        strands
    }

    /// Makes the last run as long as whole groups are, with cables that never pull.
    fn fill_up(&mut self) {
        while self.runs.last().is_some_and(|run| run.length % GROUP != 0) {
            self.add(None, None);
        }
    }

    fn add(&mut self, index: Option<usize>, cable: Option<&Cable>) {
        self.cable.push(index);
        self.stiffness.push(cable.map_or(0.0, |cable| cable.stiffness));
        self.damping.push(cable.map_or(0.0, |cable| cable.damping));
        let rest_length = cable.map_or(f64::INFINITY, |cable| cable.rest_length);
        self.rest_length.push(rest_length);
        self.slack.push(SLACK * (rest_length * rest_length));
        self.gentle.push(cable.map_or(1.0, secant::gentleness));
        self.tension.push(0.0);
        if let Some(run) = self.runs.last_mut() {
            run.length += 1;
        }
    }

    /// Adds the cable forces on every knot [N].
    #[inline(always)]
    fn pull_all(&mut self, position: &Components, velocity: &Components, force: &mut Components) {
        let mut found = self.found.take().unwrap_or_default();
        for run in 0..self.runs.len() {
            for start in (0..self.runs[run].length).step_by(CHUNK) {
                let piece = self.runs[run].piece(start, CHUNK);
                self.pull_piece(&piece, position, velocity, force, &mut found);
            }
        }
        self.found = Some(found);
    }

    /// Adds the forces of the cables of `piece`, of which whole groups are slack.
    #[inline(always)]
    fn pull_piece(
        &mut self,
        piece: &CableRun,
        position: &Components,
        velocity: &Components,
        force: &mut Components,
        found: &mut PieceForces,
    ) {
        let &CableRun { first, length: n, a, b, .. } = piece;
        let ([xa, ya, za], [xb, yb, zb]) = (slices(position, a, n), slices(position, b, n));
        let slack = &self.slack[first..first + n];
        let is_taut = &mut found.is_taut[..n];
        for i in 0..n {
            let (dx, dy, dz) = (xb[i] - xa[i], yb[i] - ya[i], zb[i] - za[i]);
            // What is no number is not slack: it goes on, and is found.
            let slack = dx * dx + dy * dy + dz * dz <= slack[i];
            is_taut[i] = u64::from(!slack);
        }
        let n_taut = found.join(n, &self.was_taut[first / GROUP..]);
        for &(start, end) in &found.taut[..n_taut] {
            let of = found.of.each_mut().map(|of| &mut of[start..end]);
            let piece = piece.piece(start, end - start);
            self.pull_taut(&piece, position, velocity, of);
            let [.., stretches, rates] = &found.of;
            self.book_drift(&piece, &stretches[start..end], &rates[start..end]);
        }
        // All first ends and then all second ones, or sums would have other bits.
        for (forces, pull) in force.iter_mut().zip(&found.of) {
            for &(start, end) in &found.taut[..n_taut] {
                for (f, p) in forces[a + start..a + end].iter_mut().zip(&pull[start..end]) {
                    *f += p;
                }
            }
            for &(start, end) in &found.taut[..n_taut] {
                for (f, p) in forces[b + start..b + end].iter_mut().zip(&pull[start..end]) {
                    *f -= p;
                }
            }
        }
    }

    /// T = max(0, k (r − l₀) + c ṙ) while r > l₀, along the line between the ends (Eq. 3.3): forces on first ends [N].
    #[inline(always)]
    fn pull_taut(
        &mut self,
        piece: &CableRun,
        position: &Components,
        velocity: &Components,
        [px, py, pz, stretches, rates]: [&mut [f64]; 5],
    ) {
        let &CableRun { first, length: n, a, b, .. } = piece;
        let ([xa, ya, za], [xb, yb, zb]) = (slices(position, a, n), slices(position, b, n));
        let ([ua, va, wa], [ub, vb, wb]) = (slices(velocity, a, n), slices(velocity, b, n));
        let (stiffness, damping) = (&self.stiffness[first..first + n], &self.damping[first..first + n]);
        let rest_length = &self.rest_length[first..first + n];
        let largest = &mut self.tension[first..first + n];
        let (px, py, pz) = (&mut px[..n], &mut py[..n], &mut pz[..n]);
        let (stretches, rates) = (&mut stretches[..n], &mut rates[..n]);
        for i in 0..n {
            let (dx, dy, dz) = (xb[i] - xa[i], yb[i] - ya[i], zb[i] - za[i]);
            let parting = dx * (ub[i] - ua[i]) + dy * (vb[i] - va[i]) + dz * (wb[i] - wa[i]);
            let length = (dx * dx + dy * dy + dz * dz).sqrt();
            let inverse = 1.0 / length;
            let stretch = length - rest_length[i];
            let law = taut_force(stiffness[i], damping[i], stretch, parting, inverse).max(0.0);
            let taut = stretch > 0.0;
            // Not `if`: it would load what is behind it lane by lane where it holds.
            largest[i] = largest[i].max(select_unpredictable(taut, law, 0.0));
            let along = select_unpredictable(taut, law * inverse, 0.0);
            px[i] = along * dx;
            py[i] = along * dy;
            pz[i] = along * dz;
            stretches[i] = select_unpredictable(taut, stretch, 0.0);
            rates[i] = parting * inverse;
        }
    }

    /// Books what the law takes of the cables of `piece` over the drift since forces were found before, which ended at these
    /// stretches [m] and rates [m/s].
    #[inline(always)]
    fn book_drift(&mut self, piece: &CableRun, stretches: &[f64], rates: &[f64]) {
        let &CableRun { first, length: n, .. } = piece;
        let laws = groups(&self.stiffness[first..first + n]).zip(groups(&self.damping[first..first + n]));
        let ends = groups(stretches).zip(groups(rates));
        let (before, _) = self.stretch[first..first + n].as_chunks_mut();
        let was_taut = &mut self.was_taut[first / GROUP..];
        let mut dissipated = self.dissipated;
        for (((stretch, was_taut), (k, c)), (to, rate)) in before.iter_mut().zip(was_taut).zip(laws).zip(ends)
        {
            // All of a group is read before anything is written: the loop is one of wide vectors.
            let (from, mut taken, mut is_taut) = (*stretch, [0.0; GROUP], [0; GROUP]);
            for i in 0..GROUP {
                is_taut[i] = u64::from(to[i] > 0.0);
            }
            if self.at_stages {
                for i in 0..GROUP {
                    let tension = taut_force(k[i], c[i], to[i], rate[i], 1.0).max(0.0);
                    taken[i] = select_unpredictable(to[i] > 0.0, (tension - k[i] * to[i]) * rate[i], 0.0);
                }
            } else {
                for i in 0..GROUP {
                    let work = work_by_law(k[i], c[i], [from[i], to[i]], rate[i], 1.0);
                    taken[i] = work - stored_between(k[i], from[i], to[i]);
                }
            }
            for (dissipated, taken) in dissipated.iter_mut().zip(taken) {
                *dissipated += taken;
            }
            (*stretch, *was_taut) = (to, is_taut.iter().sum());
        }
        self.dissipated = dissipated;
    }

    /// What was taken by their law since the last call [J], or at the last stage [W].
    fn take_dissipated(&mut self) -> f64 {
        std::mem::take(&mut self.dissipated).iter().sum()
    }

    /// Where a drift begins at `position` that nothing is known of what was before.
    fn begin_drift(&mut self, position: &Components) {
        let Self { runs, rest_length, stretch, was_taut, .. } = self;
        was_taut.fill(0);
        for run in &*runs {
            for i in 0..run.length {
                let across = position.each_ref().map(|x| x[run.b + i] - x[run.a + i]);
                let (at, length) = (run.first + i, across.iter().map(|d| d * d).sum::<f64>().sqrt());
                stretch[at] = (length - rest_length[at]).max(0.0);
                was_taut[at / GROUP] |= u64::from(stretch[at] > 0.0);
            }
        }
    }
}

/// `values` of cables, a group of them after the other.
#[inline(always)]
fn groups(values: &[f64]) -> impl Iterator<Item = [f64; GROUP]> {
    values.as_chunks().0.iter().copied()
}

/// The three components of `of`, from `start`, `length` of them.
#[inline(always)]
pub(super) fn slices(of: &Components, start: usize, length: usize) -> [&[f64]; 3] {
    let [x, y, z] = of;
    [&x[start..start + length], &y[start..start + length], &z[start..start + length]]
}

impl CableRun {
    /// At most `length` cables of it from `start`.
    #[inline(always)]
    pub(super) fn piece(&self, start: usize, length: usize) -> CableRun {
        let length = length.min(self.length - start);
        CableRun {
            first: self.first + start,
            length,
            a: self.a + start,
            b: self.b + start,
            family: self.family,
        }
    }
}

/// Place of each knot in the arrays: grid knots as numbered, then the first middle knots of all
/// lines, then the second, so that the pieces of neighbouring lines run in step.
fn places(net: &Net) -> Vec<usize> {
    let n_grid = net.grid[0] * net.grid[1];
    let n_lines = (net.grid[0] - 1) * net.grid[1] + net.grid[0] * (net.grid[1] - 1);
    let n_middle = (net.n_knots() - n_grid) / n_lines;
    (0..net.n_knots())
        .map(|knot| match knot.checked_sub(n_grid) {
            None => knot,
            Some(middle) => n_grid + (middle % n_middle) * n_lines + middle / n_middle,
        })
        .collect()
}
