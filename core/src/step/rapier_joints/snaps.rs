//! Snaps: cables that go taut and slack again within a few steps.
//!
//! π / ω_d is 0.3 ms for 1 m of 1 mm Kevlar between two knots of its net, too fast for the engine's implicit row, which
//! would swallow the rebound. Before the step cables that are slack and would be taut by its end pass on the impulse of the
//! whole half cycle.
//!
//! They do in the order in which they go taut, and those that begin within [`OVERLAP`] of each other pull together: they share
//! knots, so that their impulses are those of one problem. Each only pulls, and leaves its ends closing at e times the rate at which
//! they parted, or faster where others pull more. Projected Gauss–Seidel passes go on until nothing changes, for then the
//! velocities are the same in whatever order cables stand; and they take energy, since each impulse is against the mean of
//! the rates before and after it. What snaps set off comes next.
//!
//! How much an end gives back is decided by the mass m that the cable stops, ω = √(k / m), ζ = c / (2 m ω), e = exp(−π ζ / √(1 − ζ²)):
//! its own reduced mass, or more where others pull its ends the other way. A light knot between two bullets that part
//! stays where it is, and the line rebounds as the bullets' masses have it, not as the knot's. Less, where others help, is not taken: what of two
//! cables has little left to stop would seem stiff and dead.
//!
//! A line that middle knots cut into pieces snaps whole where its ends are much heavier than it is, like the one cable that it was: when they
//! come as far apart as it is long, it passes on an impulse from one to the other, and the light knots between them follow. Piece by piece they
//! would pass it on as so many collisions, and the engine's rows do not converge over them: between bullets of 1 kg, 1 m of Kevlar in 8
//! pieces rebounded with 0.697 for 0.638, and 0.875 for 0.915.
//!
//! The net of Table 3.2 in steps of 0.5 ms, against explicit cables in steps of 2 µs; the mirror error is that of 0.5 s:
//!
//! | | bullets at 0.5 s | all knots, mean, at 0.3 and 0.5 s | mirror error |
//! |---|---|---|---|
//! | one snap after another, in the order of the cables | 0.9 mm | 45, 49 mm | 95 mm |
//! | all of a step together | 3.2 mm | 63, 59 mm | 4e-16 m |
//! | in the order of their times | 1.0 mm | 6, 44 mm | 3e-15 m |
//! | that, and together what overlaps by 0.1 to 0.25 of a half cycle | 0.3 mm | 6, 19 mm | 4e-15 m |

use std::ops::Range;

use nalgebra::Vector3;

use crate::cable::Cable;
use crate::net::Net;
use crate::state::{Knots, State};

/// Steps in a half cycle from which the implicit row resolves it. It damps like a ratio of ω h / 2, half of
/// Table 3.2's 0.1 at 30 steps. On that net's bullets, with snaps only where the half cycle is shorter
/// than one step, 0.2 ms and 0.05 ms erred by 6 mm at 0.5 s, 0.5 ms by 0.9 mm.
const RESOLVED: f64 = 30.0;

/// The same where ends move by their mean velocities: the row then takes nothing by itself, but where it would push it lets go, as Eq. 3.3 does, and
/// the half cycle of a snap goes on. Bullets of 1 kg on one mesh rebound within 19 steps of 0.5 ms.
const RESOLVED_BY_MEAN: f64 = 20.0;

/// Share of half a period of a cable's own within which cables go taut as good as at once [-].
const OVERLAP: f64 = 0.2;

/// Reduced mass of a line's ends over its own from which it snaps whole [-].
const HEAVY: f64 = 10.0;

/// Change of a rate within a pass at which the passes end, over the fastest of the problem [-].
const TOLERANCE: f64 = 1e-10;

/// Rate of which that is a share at least [m/s]: below, it would be that of rounding.
const SLOW: f64 = 1e-3;

/// Passes over the snaps of one problem, at most: what bullets pull through knots that are a hundred times lighter converges
/// slowly. What is left snaps in the next problem.
const MOST_PASSES: usize = 1000;

/// The snaps of a net's cables.
pub struct Snaps {
    inverse_mass: Vec<f64>,
    /// Problems within a step, at most.
    most_problems: u32,
    /// What may snap.
    chains: Vec<Chain>,
    /// Snaps of one problem; kept for its memory.
    together: Vec<Snap>,
    /// Cables that snapped in this step, with their largest tension [N].
    tensions: Vec<(usize, f64)>,
    /// Energy that snaps took since it was last set to none [J].
    pub taken: f64,
    /// Snaps since the start.
    pub count: u64,
}

/// Cables in a row that snap as one.
struct Chain {
    cables: Range<usize>,
    whole: Cable,
    /// Half a cycle of it alone [s].
    alone: f64,
}

impl Chain {
    fn new(cables: Range<usize>, whole: Cable) -> Chain {
        Chain { cables, alone: whole.half_cycle(whole.reduced_mass).time(), whole }
    }

    /// Those of `net` in the order of its cables, each line that snaps whole before its pieces, for steps of `step` seconds.
    fn all(net: &Net, step: f64) -> Vec<Chain> {
        let mut chains = Vec::new();
        for cables in net.lines() {
            if cables.len() > 1 {
                let pieces = &net.cables[cables.clone()];
                let line = Chain::new(cables.clone(), Cable::in_a_row(pieces, &net.mass));
                if line.whole.reduced_mass > HEAVY * line.whole.mass && line.alone <= RESOLVED * step {
                    chains.push(line);
                }
            }
            chains.extend(cables.map(|cable| Chain::new(cable..cable + 1, net.cables[cable])));
        }
        chains
    }
}

/// A chain that snaps.
struct Snap {
    chain: usize,
    /// When it goes taut, from the start of the step on [s].
    time: f64,
    /// From its first end to its second, of length 1.
    along: Vector3<f64>,
    /// Rate at which its ends part [m/s].
    rate: f64,
    /// Rate at which they are to part afterwards, at most [m/s]; negative: they close.
    wanted: f64,
    /// Along it [N s].
    impulse: f64,
    /// Mass that it stops, with what the others do [kg].
    mass: f64,
}

impl Snaps {
    /// The snaps of the cables of `net` in steps of `step` seconds or parts of them, in `most_problems` one after another
    /// within a part, at most.
    pub fn new(net: &Net, most_problems: u32, step: f64) -> Snaps {
        Snaps {
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            most_problems,
            chains: Chain::all(net, step),
            together: Vec::new(),
            tensions: Vec::new(),
            taken: 0.0,
            count: 0,
        }
    }

    /// The snaps of the coming `step` seconds: changes velocities, and marks in `touched` whose. Of cables `by_mean` ends move by their mean
    /// velocities.
    pub fn solve(&mut self, knots: &mut Knots, step: f64, by_mean: &[bool], touched: &mut [bool]) {
        self.tensions.clear();
        for _ in 0..self.most_problems {
            self.find(knots, step, by_mean);
            if self.together.is_empty() {
                break;
            }
            // What stops their ends says how much mass each of them pulls, and that what it gives back.
            self.pull(&mut knots.velocity);
            for snap in &mut self.together {
                let cable = &self.chains[snap.chain].whole;
                snap.mass = (snap.impulse / snap.rate).max(cable.reduced_mass);
                snap.wanted = -cable.half_cycle(snap.mass).restitution() * snap.rate;
            }
            self.pull(&mut knots.velocity);
            for snap in self.together.iter().filter(|snap| snap.impulse > 0.0) {
                let Chain { cables, whole, .. } = &self.chains[snap.chain];
                touched[whole.a] = true;
                touched[whole.b] = true;
                let tension = whole.stiffness * whole.half_cycle(snap.mass).largest_stretch(snap.rate);
                self.tensions.extend(cables.clone().map(|cable| (cable, tension)));
                self.count += 1;
            }
        }
    }

    /// The first cables that go taut within `step` seconds.
    fn find(&mut self, knots: &Knots, step: f64, by_mean: &[bool]) {
        let Knots { position, velocity } = knots;
        self.together.clear();
        // Cables before this one are in a line that snaps whole.
        let mut taken = 0;
        for (number, chain) in self.chains.iter().enumerate() {
            let cable = &chain.whole;
            if chain.cables.start < taken {
                continue;
            }
            // A line is left to rows for the step of the scene alone: the parts of a step are short for its light knots.
            let resolved = if by_mean[chain.cables.start] { RESOLVED_BY_MEAN } else { RESOLVED };
            if chain.cables.len() == 1 && chain.alone > resolved * step {
                continue; // slow enough for the row
            }
            let across = position[cable.b] - position[cable.a];
            let length_squared = across.norm_squared();
            let missing = cable.rest_length * cable.rest_length - length_squared;
            if missing < 0.0 {
                continue; // taut already: the row carries it
            }
            let parting = velocity[cable.b] - velocity[cable.a];
            let (stretching, square) = (across.dot(&parting), parting.norm_squared());
            // Its length squared at the end of the step, less that at rest.
            if stretching <= 0.0 || step * (2.0 * stretching + step * square) <= missing {
                continue;
            }
            let time = ((stretching * stretching + square * missing).sqrt() - stretching) / square;
            let length = length_squared.sqrt();
            let rate = stretching / length;
            let along = across / length;
            taken = chain.cables.end;
            self.together.push(Snap {
                chain: number,
                time,
                along,
                rate,
                wanted: 0.0,
                impulse: 0.0,
                mass: 0.0,
            });
        }
        let first = self.together.iter().map(|snap| snap.time).fold(f64::INFINITY, f64::min);
        let within = |cable: &Cable| OVERLAP * std::f64::consts::PI / cable.natural_frequency();
        self.together.retain(|snap| snap.time <= first + within(&self.chains[snap.chain].whole));
    }

    /// Finds the impulses after which ends part as they are wanted to, and what velocities these leave.
    fn pull(&mut self, velocity: &mut [Vector3<f64>]) {
        let mut fastest = SLOW;
        for _ in 0..MOST_PASSES {
            let mut change: f64 = 0.0;
            for snap in &mut self.together {
                let Cable { a, b, .. } = self.chains[snap.chain].whole;
                let (of_a, of_b) = (self.inverse_mass[a], self.inverse_mass[b]);
                let excess = snap.along.dot(&(velocity[b] - velocity[a])) - snap.wanted;
                let impulse = (snap.impulse + excess / (of_a + of_b)).max(0.0);
                let more = impulse - snap.impulse;
                self.taken += more * (excess + snap.wanted - 0.5 * more * (of_a + of_b));
                snap.impulse = impulse;
                velocity[a] += snap.along * (more * of_a);
                velocity[b] -= snap.along * (more * of_b);
                change = change.max(more.abs() * (of_a + of_b));
            }
            fastest = change.max(fastest);
            if change <= TOLERANCE * fastest {
                break;
            }
        }
    }

    /// Raises each cable's largest tension within the step to that of its snap.
    pub fn observe(&self, state: &mut State) {
        for &(cable, tension) in &self.tensions {
            state.tension[cable] = state.tension[cable].max(tension);
        }
    }
}
