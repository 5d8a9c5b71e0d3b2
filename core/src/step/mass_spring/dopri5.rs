//! The net of Eq. 3.1 to 3.5 with every switch of a cable located: as many digits as one asks for.
//!
//! Eq. 3.3 jumps by c ṙ where a cable goes taut, so a method with fixed steps, of whatever order, is
//! of first order there. This one keeps the mode of every cable over a step (slack, pulling, or
//! stretched but held at zero where the dashpot would push), finds where a mode ends, and steps
//! just past that point. Between such points the equations are smooth: Dormand and Prince's pair
//! of orders 5 and 4 with its own choice of step.
//!
//! The most accurate way to fly a net, the reference of the cost study, and an integrator of the
//! explicit net (`solver.integrator: "located"`): there it is restarted for every sub-step, between
//! which contact and threads act.

use std::sync::Arc;

use nalgebra::Vector3;

use super::stability::stable_step;
use crate::cable::Cable;
use crate::net::Net;

/// Longest step over the stable step of an explicit net [-]: a cable must not go taut and slack again within one.
const LONGEST: f64 = 0.25;

/// Shortest step [s]: how far past the end of a mode a step may reach.
const SHORTEST: f64 = 1e-11;

/// Longest steps of a flight between two looks at whether to go on.
const SPANS: f64 = 64.0;

/// Halvings of a step in search of the end of a mode.
const HALVINGS: u32 = 44;

/// A flight.
#[derive(Clone, Debug, Default)]
pub struct LocatedFlight {
    /// Positions of all knots at the times asked for, as many as were reached [m].
    pub knots: Vec<Vec<Vector3<f64>>>,
    /// Steps taken.
    pub steps: u64,
    /// Ends of modes met: cables going taut, slack, or ceasing to pull.
    pub switches: u64,
}

/// Flies `net` from its fold through `times` [s] (ascending, from 0), with local errors of at most
/// `tolerance` metres a step, until `go_on` says no: it hears of the steps taken so far.
pub fn fly(net: &Net, times: &[f64], tolerance: f64, go_on: impl Fn(u64) -> bool) -> LocatedFlight {
    let mut located = Dopri5::new(net, tolerance);
    located.load(&net.folded, &net.launch_velocity, &[]);
    let mut flight = LocatedFlight::default();
    let mut now = 0.0;
    for &time in times {
        // In short spans, so that there is a place to stop.
        while now < time {
            if !go_on(located.steps) {
                return flight;
            }
            let end = time.min(now + SPANS * located.longest);
            located.advance(end - now);
            now = end;
        }
        flight.knots.push((0..net.n_knots()).map(|knot| located.position(knot)).collect());
        (flight.steps, flight.switches) = (located.steps, located.switches);
    }
    flight
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Slack,
    Pulling,
    /// Longer than at rest, yet without tension: the dashpot alone would push.
    Unloaded,
}

/// The net under way.
pub struct Dopri5 {
    cables: Arc<[Cable]>,
    mass: Vec<f64>,
    modes: Vec<Mode>,
    /// Largest tension of each cable since it was last asked for [N].
    tension: Vec<f64>,
    /// Positions of all knots, then their velocities, three components each.
    y: Vec<f64>,
    /// Acceleration of the knots by other forces than those of cables [m/s^2].
    push: Vec<f64>,
    /// Slope of `y` at the seven stages of a step; the first is that at its start.
    slopes: [Vec<f64>; 7],
    /// What cables take at the same stages [W].
    powers: [f64; 7],
    /// Taken by the cables since it was last asked for [J].
    dissipated: f64,
    trial: Vec<f64>,
    step: f64,
    longest: f64,
    tolerance: f64,
    /// Highest frequency [rad/s]: makes a velocity a length.
    frequency: f64,
    /// Steps taken.
    pub steps: u64,
    /// Ends of modes met.
    pub switches: u64,
    /// Steps tried, and the most that may be.
    tried: u64,
    most: u64,
}

/// Dormand and Prince's coefficients: stage by stage, the last row is the result of order 5.
const STAGES: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// Result of order 5 less that of order 4.
const ERROR: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

impl Dopri5 {
    /// The cables of `net`, with local errors of at most `tolerance` metres a step.
    pub fn new(net: &Net, tolerance: f64) -> Dopri5 {
        let n = 3 * net.n_knots();
        let stable = stable_step(net);
        Dopri5 {
            cables: Arc::clone(&net.cables),
            mass: net.mass.clone(),
            modes: vec![Mode::Slack; net.cables.len()],
            tension: vec![0.0; net.cables.len()],
            y: vec![0.0; 2 * n],
            push: vec![0.0; n],
            slopes: std::array::from_fn(|_| vec![0.0; 2 * n]),
            powers: [0.0; 7],
            dissipated: 0.0,
            trial: vec![0.0; 2 * n],
            step: LONGEST * stable,
            longest: LONGEST * stable,
            tolerance,
            frequency: 2.0 / stable,
            steps: 0,
            switches: 0,
            tried: 0,
            most: u64::MAX,
        }
    }

    /// Allows so many more tries of steps; until it is called there is no limit.
    pub fn allow(&mut self, tries: u64) {
        self.most = self.tried.saturating_add(tries);
    }

    /// Steps tried so far.
    pub fn tried(&self) -> u64 {
        self.tried
    }

    /// Takes over positions [m], velocities [m/s] and accelerations by other forces [m/s^2], of which
    /// there may be none.
    pub fn load(&mut self, position: &[Vector3<f64>], velocity: &[Vector3<f64>], push: &[Vector3<f64>]) {
        let both = position.iter().chain(velocity).flat_map(|v| [v.x, v.y, v.z]);
        self.y.iter_mut().zip(both).for_each(|(y, value)| *y = value);
        let push = push.iter().flat_map(|v| [v.x, v.y, v.z]);
        self.push.iter_mut().zip(push).for_each(|(own, value)| *own = value);
        self.take_modes();
        self.powers[0] =
            slope(&self.cables, &self.mass, &self.push, &self.modes, &self.y, &mut self.slopes[0]);
    }

    /// Position of a knot [m].
    pub fn position(&self, knot: usize) -> Vector3<f64> {
        at(&self.y, knot)
    }

    /// Velocity of a knot [m/s].
    pub fn velocity(&self, knot: usize) -> Vector3<f64> {
        at(&self.y, self.mass.len() + knot)
    }

    /// Largest tension of each cable at the ends of the steps since the last call [N].
    pub fn take_tension(&mut self) -> impl Iterator<Item = f64> {
        self.tension.iter_mut().map(std::mem::take)
    }

    /// What cables took by their law since the last call [J].
    pub fn take_dissipated(&mut self) -> f64 {
        std::mem::take(&mut self.dissipated)
    }

    /// Flies on for `span` seconds, or as far as the allowed tries reach.
    pub fn advance(&mut self, span: f64) {
        let mut left = span;
        while left > 0.0 && self.tried < self.most {
            left -= self.step(left);
            self.tried += 1;
        }
    }

    /// Tries one step of at most `left` seconds; how far it went [s].
    fn step(&mut self, left: f64) -> f64 {
        let step = self.step.min(left);
        let error = self.attempt(step);
        let next = step * (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.2, 4.0);
        if error > 1.0 && step > SHORTEST {
            self.step = next.max(SHORTEST);
            return 0.0;
        }
        // A step cut short by the end of the span says nothing about the step that suits.
        if step == self.step || next < self.step {
            self.step = next.clamp(SHORTEST, self.longest);
        }
        let share = self.end_of_modes(step);
        let reached = (share * step).max(SHORTEST).min(step);
        if reached < step {
            self.attempt(reached);
        }
        std::mem::swap(&mut self.y, &mut self.trial);
        let weighed = STAGES[5].iter().zip(&self.powers).map(|(weight, power)| weight * power);
        self.dissipated += reached * weighed.sum::<f64>();
        self.steps += 1;
        if self.take_modes() {
            self.switches += 1;
            self.powers[0] =
                slope(&self.cables, &self.mass, &self.push, &self.modes, &self.y, &mut self.slopes[0]);
        } else {
            // The last stage is the slope at the new state.
            let [first, .., last] = &mut self.slopes;
            std::mem::swap(first, last);
            self.powers[0] = self.powers[6];
        }
        reached
    }

    /// Takes `y` to `trial` over `step`, modes kept; the estimated error over the tolerance.
    fn attempt(&mut self, step: f64) -> f64 {
        for (stage, row) in STAGES.iter().enumerate() {
            self.trial.copy_from_slice(&self.y);
            for (slope, weight) in self.slopes.iter().zip(*row).filter(|(_, weight)| **weight != 0.0) {
                for (y, slope) in self.trial.iter_mut().zip(slope) {
                    *y += step * weight * slope;
                }
            }
            self.powers[stage + 1] = slope(
                &self.cables,
                &self.mass,
                &self.push,
                &self.modes,
                &self.trial,
                &mut self.slopes[stage + 1],
            );
        }
        let half = self.y.len() / 2;
        let mut worst = 0.0_f64;
        for i in 0..self.y.len() {
            let error: f64 = self.slopes.iter().zip(ERROR).map(|(slope, weight)| weight * slope[i]).sum();
            let as_length = if i < half { error } else { error / self.frequency };
            worst = worst.max((step * as_length).abs());
        }
        worst / self.tolerance
    }

    /// Share of the step after which the first cable leaves its mode; 1 when none does.
    ///
    /// Within the step a cable's ends move on Hermite's quintic through positions, velocities and
    /// accelerations of both ends of the step.
    fn end_of_modes(&self, step: f64) -> f64 {
        let mut first = 1.0;
        for (cable, mode) in self.cables.iter().zip(&self.modes) {
            if mode_of(cable, &across(&self.trial, cable), &parting(&self.trial, cable)) == *mode {
                continue;
            }
            let path = CablePath::of(self, cable, step);
            let left = |share: f64| {
                let (across, parting) = path.at(share);
                mode_of(cable, &across, &parting) != *mode
            };
            if left(0.0) {
                return 0.0;
            }
            // `low` is in the old mode, `high` in the new one.
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if left(middle) { high = middle } else { low = middle }
            }
            first = f64::min(first, high);
        }
        first
    }

    /// Takes the modes and tensions of all cables from the state; whether any mode is new.
    fn take_modes(&mut self) -> bool {
        let mut any = false;
        for ((cable, mode), tension) in self.cables.iter().zip(&mut self.modes).zip(&mut self.tension) {
            let (pull, length) = pull(cable, &across(&self.y, cable), &parting(&self.y, cable));
            let now = mode_by(cable, pull, length);
            if now == Mode::Pulling {
                *tension = tension.max(pull * length);
            }
            any |= now != *mode;
            *mode = now;
        }
        any
    }
}

fn at(y: &[f64], vector: usize) -> Vector3<f64> {
    Vector3::new(y[3 * vector], y[3 * vector + 1], y[3 * vector + 2])
}

/// From the first end of a cable to the second, of positions in `y`.
fn across(y: &[f64], cable: &Cable) -> Vector3<f64> {
    at(y, cable.b) - at(y, cable.a)
}

/// The same of what stands in the second half of `y`.
fn parting(y: &[f64], cable: &Cable) -> Vector3<f64> {
    let n_knots = y.len() / 6;
    at(y, n_knots + cable.b) - at(y, n_knots + cable.a)
}

/// Tension over length if the cable pulls, T = k (r − l₀) + c ṙ, and its length.
fn pull(cable: &Cable, across: &Vector3<f64>, parting: &Vector3<f64>) -> (f64, f64) {
    let length = across.norm();
    let rate = across.dot(parting) / length;
    (cable.taut_force(length, rate) / length, length)
}

fn mode_of(cable: &Cable, across: &Vector3<f64>, parting: &Vector3<f64>) -> Mode {
    let (pull, length) = pull(cable, across, parting);
    mode_by(cable, pull, length)
}

fn mode_by(cable: &Cable, pull: f64, length: f64) -> Mode {
    match (length > cable.rest_length, pull > 0.0) {
        (false, _) => Mode::Slack,
        (true, true) => Mode::Pulling,
        (true, false) => Mode::Unloaded,
    }
}

/// Velocities and accelerations of all knots at `y`, with the cables in their `modes`; what cables take by their law [W].
fn slope(cables: &[Cable], mass: &[f64], push: &[f64], modes: &[Mode], y: &[f64], slope: &mut [f64]) -> f64 {
    let half = y.len() / 2;
    slope[..half].copy_from_slice(&y[half..]);
    let forces = &mut slope[half..];
    forces.fill(0.0);
    let mut power = 0.0;
    for (cable, mode) in cables.iter().zip(modes).filter(|(_, mode)| **mode != Mode::Slack) {
        let (across, parting) = (across(y, cable), parting(y, cable));
        let length = across.norm();
        let rate = across.dot(&parting) / length;
        // Without tension, stretched, it takes what its spring gives.
        let tension = if *mode == Mode::Pulling { cable.taut_force(length, rate) } else { 0.0 };
        power += (tension - cable.stiffness * (length - cable.rest_length)) * rate;
        let pull = tension / length;
        for axis in 0..3 {
            forces[3 * cable.a + axis] += pull * across[axis];
            forces[3 * cable.b + axis] -= pull * across[axis];
        }
    }
    for (i, (force, push)) in forces.iter_mut().zip(push).enumerate() {
        *force = *force / mass[i / 3] + push;
    }
    power
}

/// A cable within a step: position, velocity and acceleration of one end from the other, at both
/// ends of the step.
struct CablePath {
    step: f64,
    from: [Vector3<f64>; 3],
    to: [Vector3<f64>; 3],
}

impl CablePath {
    fn of(net: &Dopri5, cable: &Cable, step: f64) -> CablePath {
        let of = |y: &[f64], slope: &[f64]| [across(y, cable), parting(y, cable), parting(slope, cable)];
        CablePath { step, from: of(&net.y, &net.slopes[0]), to: of(&net.trial, &net.slopes[6]) }
    }

    /// Position and velocity after a `share` of the step.
    fn at(&self, share: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (h, s) = (self.step, share);
        let [x0, v0, a0] = self.from;
        let [x1, v1, a1] = self.to;
        // x(s) = x0 + h v0 s + h² a0 s²/2 + s³ (p + q s + r s²), the rest from the three ends at s = 1.
        let dx = x1 - x0 - h * v0 - 0.5 * h * h * a0;
        let dv = h * (v1 - v0) - h * h * a0;
        let da = h * h * (a1 - a0);
        let p = 10.0 * dx - 4.0 * dv + 0.5 * da;
        let q = -15.0 * dx + 7.0 * dv - da;
        let r = 6.0 * dx - 3.0 * dv + 0.5 * da;
        let x = x0 + s * h * v0 + 0.5 * (s * h).powi(2) * a0 + s.powi(3) * (p + s * (q + s * r));
        let slope = h * v0 + s * h * h * a0 + s * s * (3.0 * p + s * (4.0 * q + 5.0 * s * r));
        (x, slope / h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cable::Cable;

    /// Two knots of 1 kg on a cable of 1 m, ω = 20 rad/s, ζ = 0.1.
    fn pair(stretch: f64, rate: f64) -> Net {
        let cable = Cable {
            a: 0,
            b: 1,
            rest_length: 1.0,
            stiffness: 200.0,
            damping: 2.0,
            mass: 0.0,
            reduced_mass: 0.5,
            breaking_tension: f64::INFINITY,
        };
        let along = |x: f64| Vector3::new(x, 0.0, 0.0);
        Net {
            grid: [2, 1],
            mass: vec![1.0; 2],
            young_modulus: vec![1e9; 2],
            radius: vec![1e-3; 2],
            cables: Arc::new([cable]),
            bullets: [0; 4],
            perimeter: vec![0],
            designed_area: 1.0,
            folded: vec![along(0.0), along(1.0 + stretch)],
            folded_inwards: false,
            launch_velocity: vec![along(0.0), along(rate)],
            delay: [0.0; 4],
        }
    }

    /// The closed form of the half cycle until the tension is gone, and free flight before and after.
    #[test]
    fn a_snap_is_that_of_the_closed_form() {
        let net = pair(-0.1, 1.0);
        let cable = net.cables[0];
        let (omega, zeta) = (cable.natural_frequency(), cable.damping_ratio());
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        // Tension k s + c s' vanishes where tan(ω_d t) = 2 ζ √(1 − ζ²) / (2 ζ² − 1).
        let end = (std::f64::consts::PI
            + (2.0 * zeta * (1.0 - zeta * zeta).sqrt() / (2.0 * zeta * zeta - 1.0)).atan())
            / damped;
        let taut = |t: f64| (-zeta * omega * t).exp() * (damped * t).sin() / damped;
        let speed = |t: f64| {
            (-zeta * omega * t).exp() * ((damped * t).cos() - zeta * omega / damped * (damped * t).sin())
        };
        let times = [0.0, 0.05, 0.1 + 0.5 * end, 0.1 + end + 0.2];
        let flight = fly(&net, &times, 1e-13, |_| true);
        let lengths: Vec<f64> = flight.knots.iter().map(|knots| (knots[1] - knots[0]).norm()).collect();
        let expected = [0.9, 0.95, 1.0 + taut(0.5 * end), 1.0 + taut(end) + 0.2 * speed(end)];
        for (found, expected) in lengths.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-10, "{lengths:?} against {expected}");
        }
        // Taut, without tension, slack.
        assert_eq!(flight.switches, 3);
    }

    #[test]
    fn momentum_is_kept_and_a_stopped_flight_is_short() {
        let flight = fly(&pair(0.3, 0.7), &[0.0, 2.0], 1e-12, |_| true);
        let centre = 0.5 * (flight.knots[1][0] + flight.knots[1][1]);
        assert!((centre.x - (0.65 + 0.35 * 2.0)).abs() < 1e-12, "{centre}");
        assert_eq!(fly(&pair(0.3, 0.7), &[0.0, 2.0], 1e-12, |_| false).knots.len(), 1);
    }
}
