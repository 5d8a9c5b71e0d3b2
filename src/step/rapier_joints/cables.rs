//! Cables as tension-only spring joints of the engine.
//!
//! The engine's spring joint also pushes and its rope joint does not rebound, so neither is a
//! cable. Ours has three parts, per cable with reduced mass mₑ, ω = √(k / mₑ), ζ = c / (2 mₑ ω)
//! (see [`crate::cable`]):
//!
//! 1. **Sustained tension**: a limit on the distance of the two knots, whose softness is the
//!    cable's own spring (ω / 2π in Hz, ζ). Solved implicitly in every sub-step it is a
//!    Kelvin–Voigt element that only pulls (Eq. 3.3).
//! 2. **Snap**: a cable that goes taut and slack again within a few steps (π / ω_d is 0.3 ms for 1 m
//!    of 1 mm Kevlar) is too fast for the implicit row, which would swallow the rebound. Before the
//!    step each cable that is slack and would be taut by its end passes on the impulse of the whole half
//!    cycle, (1 + e) mₑ ṙ along the cable, with its exact restitution e = exp(−π ζ / √(1 − ζ²)). A few
//!    Gauss–Seidel passes let snaps set off their neighbours'.
//! 3. **Rest**: a cable that cannot become taut within the step has no row in it.
//!
//! Limits: a snap acts at the start of the step it falls in, so its time is known to a step; the
//! implicit row damps what it cannot resolve (ω times sub-step above 1), on the safe side.

use std::sync::Arc;

use crate::cable::Cable;
use crate::net::Net;
use crate::state::{Knots, State};
use crate::world::World;

/// A cable that may become taut although its knots drift apart too slowly now: its knots can gain
/// speed within the step from neighbours. The row of a cable must be there before it is stretched,
/// or the stretch turns up as energy from nowhere.
const REST_MARGIN: f64 = 3.0;

/// Steps in a half cycle from which the implicit row resolves it. It damps like a ratio of ω h / 2, half of
/// Table 3.2's 0.1 at 30 steps. On that net's bullets, with snaps only where the half cycle is shorter
/// than one step, 0.2 ms and 0.05 ms erred by 6 mm at 0.5 s, 0.5 ms by 0.9 mm.
const RESOLVED: f64 = 30.0;

/// The cables of a net as joints of the world.
pub struct CableJoints {
    cables: Arc<[Cable]>,
    inverse_mass: Vec<f64>,
    snaps: Vec<Snap>,
    /// Whether each cable's joint acts, as last told to the world.
    acting: Vec<bool>,
    passes: u32,
    /// Knots whose velocity a snap changed in this step.
    touched: Vec<bool>,
    /// Snaps of this step: cable and largest tension [N].
    snapped: Vec<(usize, f64)>,
    /// Snaps since the start.
    pub n_snaps: u64,
    /// Rows given to the engine since the start, one a cable and step.
    pub n_rows: u64,
}

/// What a snap of a cable does, worked out once.
struct Snap {
    /// Half a cycle [s].
    time: f64,
    /// (1 + e) mₑ [kg]: impulse per closing speed.
    impulse_per_speed: f64,
    /// Largest elastic tension per closing speed [N s/m].
    tension_per_speed: f64,
}

impl CableJoints {
    /// Energy that knots and cables hold [J].
    pub fn energy(&self, knots: &Knots) -> f64 {
        let moving = self.inverse_mass.iter().zip(&knots.velocity);
        let kinetic: f64 = moving.map(|(inverse_mass, v)| 0.5 * v.norm_squared() / inverse_mass).sum();
        let length = |cable: &Cable| (knots.position[cable.b] - knots.position[cable.a]).norm();
        kinetic + self.cables.iter().map(|cable| cable.energy(length(cable))).sum::<f64>()
    }

    /// Ties the cables of `net` in `world`, with `passes` over the snaps.
    pub fn install(net: &Net, passes: u32, world: &mut World) -> CableJoints {
        for cable in net.cables.iter() {
            let frequency = cable.natural_frequency() / std::f64::consts::TAU;
            world.tie([cable.a, cable.b], cable.rest_length, frequency, cable.damping_ratio());
        }
        let snaps = net
            .cables
            .iter()
            .map(|cable| Snap {
                time: cable.snap_time(),
                impulse_per_speed: (1.0 + cable.snap_restitution()) * cable.reduced_mass,
                tension_per_speed: cable.stiffness * cable.snap_stretch(1.0),
            })
            .collect();
        CableJoints {
            inverse_mass: net.mass.iter().map(|mass| 1.0 / mass).collect(),
            snaps,
            acting: vec![true; net.cables.len()],
            passes,
            touched: vec![false; net.n_knots()],
            snapped: Vec::new(),
            n_snaps: 0,
            n_rows: 0,
            cables: Arc::clone(&net.cables),
        }
    }

    /// Before the world moves for `step` seconds: snaps change velocities, and cables that cannot act
    /// are put to rest.
    pub fn prepare(&mut self, state: &mut State, step: f64, world: &mut World) {
        self.snapped.clear();
        for _ in 0..self.passes {
            if !self.snap(state, step) {
                break;
            }
        }
        for (knot, touched) in self.touched.iter_mut().enumerate() {
            if std::mem::take(touched) {
                world.set_velocity(knot, &state.knots.velocity[knot]);
            }
        }
        self.rest(state, step, world);
    }

    /// One pass over all cables; whether any snapped.
    fn snap(&mut self, state: &mut State, step: f64) -> bool {
        let n_before = self.snapped.len();
        let (position, velocity) = (&state.knots.position, &mut state.knots.velocity);
        for (index, (cable, snap)) in self.cables.iter().zip(&self.snaps).enumerate() {
            if snap.time > RESOLVED * step {
                continue; // slow enough for the row
            }
            let across = position[cable.b] - position[cable.a];
            let length_squared = across.norm_squared();
            if length_squared > cable.rest_length * cable.rest_length {
                continue; // taut already: the row carries it
            }
            let parting = velocity[cable.b] - velocity[cable.a];
            let stretching = across.dot(&parting);
            let end = across + parting * step;
            if stretching <= 0.0 || end.norm_squared() <= cable.rest_length * cable.rest_length {
                continue;
            }
            let length = length_squared.sqrt();
            let rate = stretching / length;
            let impulse = across * (snap.impulse_per_speed * rate / length);
            velocity[cable.a] += impulse * self.inverse_mass[cable.a];
            velocity[cable.b] -= impulse * self.inverse_mass[cable.b];
            self.touched[cable.a] = true;
            self.touched[cable.b] = true;
            self.snapped.push((index, snap.tension_per_speed * rate));
        }
        self.n_snaps += (self.snapped.len() - n_before) as u64;
        self.snapped.len() > n_before
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

    /// After the world moved: the largest tension of each cable so far within the step, by the law at
    /// the end of this part or by a snap at its start.
    pub fn observe(&self, state: &mut State) {
        let (position, velocity) = (&state.knots.position, &state.knots.velocity);
        for (cable, tension) in self.cables.iter().zip(&mut state.tension) {
            let across = position[cable.b] - position[cable.a];
            let length = across.norm();
            if length > cable.rest_length {
                let rate = across.dot(&(velocity[cable.b] - velocity[cable.a])) / length;
                *tension = tension.max(cable.tension(length, rate));
            }
        }
        for &(index, tension) in &self.snapped {
            state.tension[index] = state.tension[index].max(tension);
        }
    }
}
