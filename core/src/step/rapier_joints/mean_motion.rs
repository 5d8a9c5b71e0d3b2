//! A net in flight whose cables the step resolves: its knots move by the mean of their velocities before and after.
//!
//! The engine moves a body by the velocity that the step's impulses leave it. A row that pulls by the mean of the stretch before and after
//! then takes λ² / 2 m of a mass m in every step of h seconds: of a cable's half cycle as much as a damping ratio of ω h / 4 would. And a cable that goes taut
//! or slack within a step pulls as if it had been taut all along. So after the engine has moved a net that is out of reach of its target, and on which
//! no thread pulls, knots are put to where the mean of both velocities takes them, and cables that went taut or slack on the way pull with
//! what they stored or gave back over the way ([`Cable::mean_tension`]). All other impulses are the engine's.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | λ, m | impulse of a cable within the step, mass of a knot | N s, kg |
//! | h, k, c | step, stiffness, damping | s, N/m, N s/m |
//! | s₀, s₁; v, v' | stretch and velocities before and after | m; m/s |
//!
//! **The row.** λ = h k (s₀ + s₁) / 2 + h c ṡ' with s₁ = s₀ + h (ṡ + ṡ') / 2: by what the row knows, s₀ and ṡ', and with ṡ = ṡ' + λ / mₑ,
//! λ (1 − ω² h² / 4) = h k s₀ + (h² k / 2 + h c) ṡ'. That is a spring of k / (1 − ω² h² / 4) with h k / 2 less than c.
//!
//! **Momenta.** A pair of impulses ± P on knots at d from each other that move on by h v' − h P / 2 m keeps the angular momentum where P points along
//! d + h ḋ' / 2. The engine's points along d: so it is turned, which changes ḋ', until nothing changes any more.
//!
//! The net of Table 3.2 at 0.15 s, farthest knot from explicit cables in steps of 1 µs, by the engine's own motion, and so [mm]:
//!
//! | damping ratio | step 2e-5 | 1e-5 | 5e-6 |
//! |---|---|---|---|
//! | 0.003 | 10.9, 10.9 | 22.6, 0.05 | 11.4, 0.015 |
//! | 0.1 | 4.5, 1.0 | 2.2, 0.6 | 1.0, 0.4 |

use nalgebra::Vector3;

use crate::cable::Cable;
use crate::state::Knots;
use crate::world::{Softness, World};

/// Steps in a half cycle from which a cable may move so: with so many the energy of taut cables swings by 1 %. Nylon nets at a damping ratio of 0.1
/// took up to 1.85 times the time with ten, for the steps that were cut for that.
pub const RESOLVED: f64 = 15.0;

/// The same where the dashpot can give back all that the row takes (ζ above ω h / 2), so that there is less to win.
const RESOLVED_AND_DAMPED: f64 = 20.0;

/// Damping ratio above which a plain row, which gives back what it takes, is as good: the farthest knot of Table 3.2's net is a third as far off so with ratios of 0.17
/// (half with 0.28), a mass that is swung around on a cable of 0.3 twice as far.
const SWINGS: f64 = 0.25;

/// Change of a velocity at which passes end, over the fastest [-].
const TOLERANCE: f64 = 1e-14;

/// Passes, at most: each leaves about ω² h² / 4 of what the one before changed.
const MOST_PASSES: usize = 40;

/// The motion of knots by their mean velocities.
#[derive(Default)]
pub struct MeanMotion {
    pulls: Vec<Pull>,
    /// Knots at the ends of these, in order.
    ends: Vec<usize>,
    /// Where the engine left all knots; kept for its memory.
    moved: Knots,
    /// What each knot gets beyond what the engine gave it [m/s], and half of what its cables gave it [m/s].
    given: Vec<[Vector3<f64>; 2]>,
}

/// A cable that pulls within the step, or may.
struct Pull {
    cable: usize,
    /// From its first end to its second before the step [m].
    across: Vector3<f64>,
    /// The same of length 1.
    along: Vector3<f64>,
    /// Its stretch then [m].
    from: f64,
    /// Impulse that the engine gave its first end [N s].
    by_engine: f64,
    /// The one that it is to have [N s].
    impulse: f64,
    /// Whether it goes taut or slack within the step.
    switches: bool,
}

impl MeanMotion {
    /// Whether `cable` may move so in steps of `step` seconds.
    pub fn resolves(cable: &Cable, step: f64) -> bool {
        let (phase, ratio) = (cable.natural_frequency() * step, cable.damping_ratio());
        let least = if ratio < 0.5 * phase { RESOLVED } else { RESOLVED_AND_DAMPED };
        std::f64::consts::PI >= least * phase && ratio <= SWINGS
    }

    /// Natural frequency and damping ratio of the joint that is `cable` then.
    pub fn softness(cable: &Cable, step: f64) -> Softness {
        let (frequency, ratio) = (cable.natural_frequency(), cable.damping_ratio());
        let phase = frequency * step;
        let root = (1.0 - 0.25 * phase * phase).sqrt();
        Softness {
            frequency: frequency / root / std::f64::consts::TAU,
            damping_ratio: (ratio - 0.25 * phase) / root,
        }
    }

    /// Before the world moves: no cable.
    pub fn begin(&mut self) {
        self.pulls.clear();
    }

    /// And now this one, by the name of `index`.
    pub fn add(&mut self, index: usize, cable: &Cable, knots: &Knots) {
        let across = knots.position[cable.b] - knots.position[cable.a];
        let length = across.norm();
        let from = length - cable.rest_length;
        let along = across / length;
        self.pulls.push(Pull {
            cable: index,
            across,
            along,
            from,
            by_engine: 0.0,
            impulse: 0.0,
            switches: false,
        });
    }

    /// After `world` moved `knots` for `step` seconds: puts those at the ends of the cables that were added to where their mean velocities take them.
    pub fn correct(
        &mut self,
        cables: &[Cable],
        inverse_mass: &[f64],
        knots: &mut Knots,
        step: f64,
        world: &mut World,
    ) {
        for pull in &mut self.pulls {
            pull.by_engine = world.impulse_of_joint(pull.cable);
            pull.impulse = pull.by_engine;
        }
        self.pulls.retain(|pull| pull.by_engine > 0.0 || pull.from > 0.0);
        if self.pulls.is_empty() {
            return;
        }
        self.ends.clear();
        self.ends.extend(self.pulls.iter().flat_map(|pull| [cables[pull.cable].a, cables[pull.cable].b]));
        self.ends.sort_unstable();
        self.ends.dedup();
        self.moved.clone_from(knots);
        self.given.resize(inverse_mass.len(), Default::default());
        for pass in 0..MOST_PASSES {
            if pass > 0 {
                for pull in &mut self.pulls {
                    pull.ask(&cables[pull.cable], knots, step, pass == 1);
                }
            }
            let (change, fastest) = self.give(cables, inverse_mass, knots, step);
            if pass > 1 && change <= TOLERANCE * fastest {
                break;
            }
        }
        for &knot in &self.ends {
            world.set_position(knot, &knots.position[knot]);
            world.set_velocity(knot, &knots.velocity[knot]);
        }
    }

    /// Gives `knots` what pulls ask for. The largest change of a velocity, and the fastest [m/s].
    fn give(&mut self, cables: &[Cable], inverse_mass: &[f64], knots: &mut Knots, step: f64) -> (f64, f64) {
        for &knot in &self.ends {
            self.given[knot] = Default::default();
        }
        for pull in &self.pulls {
            let Cable { a, b, .. } = cables[pull.cable];
            let middle = pull.across + 0.5 * step * (knots.velocity[b] - knots.velocity[a]);
            let impulse = pull.impulse / middle.norm() * middle;
            let more = impulse - pull.by_engine * pull.along;
            for (knot, share) in [(a, inverse_mass[a]), (b, -inverse_mass[b])] {
                self.given[knot][0] += share * more;
                self.given[knot][1] += 0.5 * share * impulse;
            }
        }
        let (mut change, mut fastest) = (0.0_f64, 0.0_f64);
        for &knot in &self.ends {
            let [more, half] = self.given[knot];
            let velocity = self.moved.velocity[knot] + more;
            change = change.max((velocity - knots.velocity[knot]).norm_squared());
            fastest = fastest.max(velocity.norm_squared());
            knots.velocity[knot] = velocity;
            knots.position[knot] = self.moved.position[knot] + step * (more - half);
        }
        (change.sqrt(), fastest.sqrt())
    }
}

impl Pull {
    /// Where `cable` goes taut or slack on the way to where `knots` are, what it pulls with; `is_first`: nobody has asked yet whether it does.
    fn ask(&mut self, cable: &Cable, knots: &Knots, step: f64, is_first: bool) {
        let to = (knots.position[cable.b] - knots.position[cable.a]).norm() - cable.rest_length;
        if is_first {
            self.switches = self.from <= 0.0 || to <= 0.0;
        }
        if self.switches {
            self.impulse = step * cable.mean_tension(self.from, to, step);
        }
    }
}
