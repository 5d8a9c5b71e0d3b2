//! Cables as tension-only spring joints of the engine.
//!
//! The engine's spring joint also pushes and its rope joint does not rebound, so neither is a
//! cable. Ours has three parts, per cable with reduced mass mₑ, ω = √(k / mₑ), ζ = c / (2 mₑ ω)
//! (see [`crate::cable`]):
//!
//! 1. **Sustained tension**: a limit on the distance of the two knots, whose softness is the
//!    cable's own spring (ω / 2π in Hz, ζ). Solved implicitly in every sub-step it is a
//!    Kelvin–Voigt element that only pulls (Eq. 3.3).
//!    In flight, where the sub-step resolves a cable, its ends move by the mean of their velocities (`mean_motion.rs` beside).
//! 2. **Snap**: a cable that goes taut and slack again within a few steps is too fast for the implicit row, and passes on
//!    an impulse before the step (`snaps.rs` beside).
//! 3. **Rest**: a cable that cannot become taut within the step has no row in it.
//!
//! Limits: a snap acts at the start of the step it falls in, so its time is known to a step; the
//! implicit row damps what it cannot resolve (ω times sub-step above 1), on the safe side. What it damps by being implicit, k h in
//! sub-steps h, is taken off the cable's own c, whatever masses swing on it: 1 kg on 1 m of Kevlar in steps of
//! 0.1 ms rebounds with 0.661 and 0.915 so, where Eq. 3.3 has 0.665 and 0.917, with 0.623 and 0.855 without. Where the cable has less, half of
//! it at least is: around a free Cubesat rows took 0.18 of the launch energy without, 0.11 so, in the same time. Not where threads pull
//! between the engine's steps: `tube`s of 20 N with latches made 3.7e-4 and 1.6e-3 of the energy at hand so, in the middle and at most of 6, 1.1e-4
//! and 4.6e-4 without. And nothing is taken off where contacts of effects push there: of 96 thin nets around a panel 9 made more than 1e-3
//! so, 2 without.

use std::sync::Arc;

use crate::cable::Cable;
use crate::net::Net;
use crate::state::{Knots, State};
use crate::world::{Softness, World};

use super::mean_motion::{self, MeanMotion};
use super::snaps::Snaps;

/// A cable that may become taut although its knots drift apart too slowly now: its knots can gain
/// speed within the step from neighbours. The row of a cable must be there before it is stretched,
/// or the stretch turns up as energy from nowhere.
const REST_MARGIN: f64 = 3.0;

/// What acts at a net beside its cables' rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beside {
    /// Nothing: it flies.
    Nothing,
    /// Contacts of the engine, or forces of ours after the step.
    Target,
    /// Threads and latches.
    Constraints,
    /// Contacts of effects or impulses of ours.
    Contacts,
}

/// The cables of a net as joints of the world.
pub struct CableJoints {
    cables: Arc<[Cable]>,
    inverse_mass: Vec<f64>,
    snaps: Snaps,
    /// Whether each cable's joint acts, as last told to the world.
    acting: Vec<bool>,
    /// Knots whose velocity a snap changed in this step.
    touched: Vec<bool>,
    /// What the joints' softness is made for: the sub-step [s], and what acts beside.
    made_for: Option<(f64, Beside)>,
    softness: Vec<Softness>,
    /// Which cables' ends move by their mean velocities, and how.
    by_mean: Vec<bool>,
    mean_motion: MeanMotion,
    /// Stretch [m] and its rate [m/s] of each cable that acts, before the world moves.
    begun: Vec<[f64; 2]>,
    /// What dashpots took since [`CableJoints::begin`] [J].
    by_dashpots: f64,
    /// Rows given to the engine since the start, one a cable and step.
    pub n_rows: u64,
}

impl CableJoints {
    /// Energy that knots and cables hold [J].
    pub fn energy(&self, knots: &Knots) -> f64 {
        let moving = self.inverse_mass.iter().zip(&knots.velocity);
        let kinetic: f64 = moving.map(|(inverse_mass, v)| 0.5 * v.norm_squared() / inverse_mass).sum();
        let length = |cable: &Cable| (knots.position[cable.b] - knots.position[cable.a]).norm();
        kinetic + self.cables.iter().map(|cable| cable.energy(length(cable))).sum::<f64>()
    }

    /// Ties the cables of `net` in `world`, for steps of `step` seconds, with `passes` over the snaps of each, at most.
    pub fn install(net: &Net, passes: u32, step: f64, world: &mut World) -> CableJoints {
        let softness: Vec<Softness> = net.cables.iter().map(|cable| softness(cable, 0.0, 0.0)).collect();
        for (cable, softness) in net.cables.iter().zip(&softness) {
            world.tie([cable.a, cable.b], cable.rest_length, *softness);
        }
        CableJoints {
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            snaps: Snaps::new(net, passes, step),
            acting: vec![true; net.cables.len()],
            touched: vec![false; net.n_knots()],
            made_for: None,
            softness,
            by_mean: vec![false; net.cables.len()],
            mean_motion: MeanMotion::default(),
            begun: vec![[0.0; 2]; net.cables.len()],
            by_dashpots: 0.0,
            n_rows: 0,
            cables: Arc::clone(&net.cables),
        }
    }

    /// The shortest part of a step that is of use against what rows take [s]: in flight ends of all cables that hardly damp move by their mean velocities in
    /// it. Elsewhere snaps of the fastest cable are left to its row in one of half of it, and an undamped net of 4 x 4 meshes shot at 60 m/s lost
    /// 0.23 of the launch energy for 0.01.
    pub fn shortest_part(&self) -> f64 {
        let fastest = self.cables.iter().map(Cable::natural_frequency).fold(0.0, f64::max);
        std::f64::consts::PI / (mean_motion::RESOLVED * fastest)
    }

    /// Before the world moves for `step` seconds: snaps change velocities, and cables that cannot act
    /// are put to rest. `beside`: what acts at the net beside the engine.
    pub fn prepare(&mut self, state: &mut State, step: f64, beside: Beside, world: &mut World) {
        self.suit(step, beside, world);
        self.snaps.solve(&mut state.knots, step, &self.by_mean, &mut self.touched);
        for (knot, touched) in self.touched.iter_mut().enumerate() {
            if std::mem::take(touched) {
                world.set_velocity(knot, &state.knots.velocity[knot]);
            }
        }
        self.rest(state, step, world);
    }

    /// Makes the joints as soft as steps of `step` seconds ask for, and what acts `beside`.
    fn suit(&mut self, step: f64, beside: Beside, world: &mut World) {
        if self.made_for.replace((step, beside)) == Some((step, beside)) {
            return;
        }
        for (index, cable) in self.cables.iter().enumerate() {
            self.by_mean[index] = beside == Beside::Nothing && MeanMotion::resolves(cable, step);
            let softness = match beside {
                _ if self.by_mean[index] => MeanMotion::softness(cable, step),
                Beside::Nothing | Beside::Target => softness(cable, step, -0.25),
                Beside::Constraints => softness(cable, step, 0.0),
                Beside::Contacts => softness(cable, 0.0, 0.0),
            };
            // Told of a joint, the engine lays out all of them anew.
            if softness != self.softness[index] {
                self.softness[index] = softness;
                world.set_softness(index, softness);
            }
        }
    }

    /// Snaps since the start.
    pub fn n_snaps(&self) -> u64 {
        self.snaps.count
    }

    fn rest(&mut self, state: &State, step: f64, world: &mut World) {
        let (position, velocity) = (&state.knots.position, &state.knots.velocity);
        for (index, cable) in self.cables.iter().enumerate() {
            let length = (position[cable.b] - position[cable.a]).norm();
            let speed = (velocity[cable.b] - velocity[cable.a]).norm();
            let acts = length + REST_MARGIN * speed * step > cable.rest_length;
            if acts != self.acting[index] {
                self.acting[index] = acts;
                world.set_acting(index, acts);
            }
            self.n_rows += u64::from(acts);
        }
    }

    /// A step begins, or begins again.
    pub fn begin(&mut self) {
        (self.by_dashpots, self.snaps.taken) = (0.0, 0.0);
    }

    /// Before the world moves: where cables are.
    pub fn mark(&mut self, knots: &Knots) {
        self.mean_motion.begin();
        for (index, cable) in self.cables.iter().enumerate().filter(|(index, _)| self.acting[*index]) {
            self.begun[index] = stretch(cable, knots);
            if self.by_mean[index] {
                self.mean_motion.add(index, cable, knots);
            }
        }
    }

    /// After the world moved for `step` seconds: moves ends by their mean velocities, where they are to.
    pub fn correct(&mut self, knots: &mut Knots, step: f64, world: &mut World) {
        self.mean_motion.correct(&self.cables, &self.inverse_mass, knots, step, world);
    }

    /// And then: books what the dashpots took on the way.
    pub fn book(&mut self, knots: &Knots, step: f64) {
        for ((cable, acts), begun) in self.cables.iter().zip(&self.acting).zip(&self.begun) {
            if *acts {
                self.by_dashpots += cable.dissipated(*begun, stretch(cable, knots), step);
            }
        }
    }

    /// What snaps and dashpots took by the cables' law since the step began [J].
    pub fn taken_by_law(&self) -> f64 {
        self.snaps.taken + self.by_dashpots
    }

    /// After the world moved: the largest tension of each cable so far within the step, by the law at
    /// the end of this part or by a snap at its start.
    pub fn observe(&self, state: &mut State) {
        for (cable, tension) in self.cables.iter().zip(&mut state.tension) {
            let [length, rate] = length_and_rate(cable, &state.knots);
            if length > cable.rest_length {
                *tension = tension.max(cable.tension(length, rate));
            }
        }
        self.snaps.observe(state);
    }
}

/// Stretch of `cable` [m] and its rate [m/s].
fn stretch(cable: &Cable, knots: &Knots) -> [f64; 2] {
    let [length, rate] = length_and_rate(cable, knots);
    [length - cable.rest_length, rate]
}

/// Length of `cable` [m] and its rate [m/s]; knots at one place part at no rate.
fn length_and_rate(cable: &Cable, knots: &Knots) -> [f64; 2] {
    let across = knots.position[cable.b] - knots.position[cable.a];
    let length = across.norm();
    let parting = across.dot(&(knots.velocity[cable.b] - knots.velocity[cable.a]));
    [length, parting / length.max(f64::MIN_POSITIVE)]
}

/// Natural frequency and damping ratio of the joint that is `cable` in sub-steps of `step` seconds; the ratio over ω h is `least` at least.
///
/// An implicit row takes k (h ẋ)² / 2 and m (h ẍ)² / 2 in each of them beyond what its dashpot does: over a cycle, as much as k h more of c
/// would, for whatever mass m. One with k h / 2 less than none of c pulls by k times the mean of the stretch before and after. That
/// is the least with which no row gives energy, whatever h: one that pulls by the stretch before, like an explicit net, keeps its energy in the mean
/// only, and one mesh in steps of 0.1 ms had 3e-2 more than before while it was taut.
fn softness(cable: &Cable, step: f64, least: f64) -> Softness {
    let natural_frequency = cable.natural_frequency();
    let phase = natural_frequency * step;
    Softness {
        frequency: natural_frequency / std::f64::consts::TAU,
        damping_ratio: (cable.damping_ratio() - 0.5 * phase).max(least * phase),
    }
}
