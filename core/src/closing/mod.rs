//! The closing mechanism: threads that winches reel in, once triggered.
//!
//! [`thread`] is the constraint, [`winch`] what reels it in, [`layouts`] the ways it may take
//! through a net, [`trigger`] when it starts, [`lock`] what may latch. A mechanism changes
//! velocities of knots and knows nothing of how cables or contacts are solved: every cable model
//! calls the same [`SubstepConstraint::solve`] in each of its own steps, or of the parts into which it cuts one.
//!
//! Several threads meet in the bullets; Gauss–Seidel sweeps over them settle it, within a step or from
//! sub-step to sub-step (see [`ThreadSweeps`]).

mod chain;
pub mod layouts;
pub mod lock;
mod pulled;
pub mod thread;
pub mod trigger;
pub mod winch;

use nalgebra::Vector3;

use crate::interaction::{Fared, StepNeeds, SubstepConstraint};
use crate::state::{EffectWork, Knots};
use layouts::Route;
use lock::Lock;
use pulled::{Done, PulledKnots};
use thread::{Anchor, Foresight, Node, Thread, ThreadSweeps};
use winch::{Drive, Winch, WinchRecord};

/// By how much a thread may be longer than what is off its reels below their largest tension, over its full
/// length; a step that ends beyond that is to be cut. Without, a jerk of its bullets left up to 3.1e-3. What a thread
/// too long takes back makes energy: closing a Cubesat's net, eight members made 1.4e-3 to 1.2e-2 of the energy at hand
/// with 8e-4, and 0.9e-3 to 8.9e-3 with 2e-4, in a sixth more parts.
const EXCESS: f64 = 2e-4;

/// A pull that begins within a step may throw knots so many times as fast as one that was there before, until the
/// step is taken back.
const JERK: f64 = 2.0;

/// Sweeps over threads and latches, at most. A thread that does not know of latches pushes what it has bunched into them, and gives more than its
/// winches put in. Twelve Cubesats at 2 rad/s, 3 s, explicit cables, created in the middle and at most: a `tube` 5.4e-3 and 1.4e-2 with one sweep, 3.0e-5
/// and 1.0e-4 with these, 2.6e-5 and 1.6e-4 with 30; a `cinch` about z 3.8e-4 and 1.9e-3 with 3, 2.9e-5 and 1.1e-4, 1.4e-5 and 4.2e-5.
const SWEEPS_WITH_LATCHES: usize = 8;

/// Threads, winches and latches of a net.
#[derive(Clone, Debug)]
pub struct Mechanism {
    lines: Vec<Line>,
    lock: Option<Lock>,
    inverse_mass: Vec<f64>,
    /// Speed to which it may throw a knot within a (sub-)step [m/s].
    throw: f64,
    /// Length of the last (sub-)step [s].
    last_step: f64,
    runs: bool,
    effort: ThreadSweeps,

    pulled: PulledKnots,
    /// What came in through the anchors since that was last accounted for.
    outside: Outside,
    /// Energy of the reels as last posted [J].
    stored_before: f64,
    /// Work of the winches as last posted [J].
    put_in_before: f64,
    /// As it was at the start of a step that may be done again.
    checkpoint: Option<Checkpoint>,
}

/// A thread and its winches.
#[derive(Clone, Debug)]
pub struct Line {
    thread: Thread,
    winch: Winch,
    full_length: f64,
}

/// What a step changes, to be taken back.
#[derive(Clone, Debug)]
struct Checkpoint {
    /// See [`Mechanism::given`] [J].
    given: f64,
    winches: Vec<Winch>,
    foresight: Vec<Foresight>,
    anchors: Vec<Anchor>,
    lock: Option<Lock>,
    pulled: PulledKnots,
    outside: Outside,
}

/// What came from outside of the net.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outside {
    /// Impulse [N s].
    pub impulse: Vector3<f64>,
    /// Its moment about the origin [N m s].
    pub angular_impulse: Vector3<f64>,
}

impl Outside {
    /// The impulse of the anchor of `thread` within the step.
    pub fn of(thread: &Thread) -> Outside {
        let impulse = thread.impulse_of_anchor();
        Outside { impulse, angular_impulse: thread.anchor.position.cross(&impulse) }
    }
}

/// A thread as it is now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Length in the net [m].
    pub length: f64,
    /// What is off its reels [m].
    pub off_reels: f64,
    /// Largest tension since the reading before [N].
    pub tension: f64,
}

impl Line {
    /// A thread along `route`, with capstan friction coefficient `friction` [-], through knots that come no nearer to
    /// each other than `knot_size` [m]; the number of winches is the route's.
    pub fn new(route: &Route, drive: Drive, friction: f64, knot_size: f64) -> Line {
        let drive = Drive { winches: f64::from(route.winches), ..drive };
        let n_tethers = route.nodes.iter().filter(|node| **node == Node::Anchor).count();
        let n_in_net = route.nodes.len() - 1 - n_tethers;
        // What is left when winding ends is shared out: the tube between two knots takes its room.
        let floor = knot_size.max(drive.stop_share * route.full_length / n_in_net.max(1) as f64);
        Line {
            thread: Thread::new(route.nodes.clone(), route.ends, friction).in_tube(floor),
            winch: Winch::new(drive, route.full_length),
            full_length: route.full_length,
        }
    }
}

impl Mechanism {
    /// A mechanism at rest, for knots of the given masses [kg].
    pub fn new(lines: Vec<Line>, lock: Option<Lock>, mass: &[f64]) -> Mechanism {
        let mut reached: Vec<usize> = lines.iter().flat_map(|line| line.thread.knots()).copied().collect();
        reached.extend(lock.iter().flat_map(Lock::knots));
        reached.sort_unstable();
        reached.dedup();
        Mechanism {
            lines,
            lock,
            inverse_mass: mass.iter().map(|mass| 1.0 / mass).collect(),
            throw: f64::INFINITY,
            last_step: 0.0,
            runs: false,
            effort: ThreadSweeps::WHOLE,
            pulled: PulledKnots::new(reached),
            outside: Outside::default(),
            stored_before: 0.0,
            put_in_before: 0.0,
            checkpoint: None,
        }
    }

    /// Starts it. Until then the threads run freely off their reels; what is off them now is the
    /// full length of each thread, or its length in the net where that is more, as it is with a
    /// tether to the chaser.
    pub fn start(&mut self, knots: &Knots) {
        self.runs = true;
        self.pulled.begin(knots);
        for line in &mut self.lines {
            let tether = line.thread.length_of_tether(knots);
            line.winch.run_free((line.full_length + tether).max(line.thread.length(knots)));
        }
    }

    /// Gives every winch another speed [m/s] and another largest tension [N].
    pub fn command(&mut self, speed: f64, tension: f64) {
        for line in &mut self.lines {
            line.winch.command_limits(speed.max(0.0), tension.max(0.0));
        }
    }

    /// Ends it.
    pub fn stop(&mut self) {
        self.runs = false;
    }

    /// Throws no knot at more than `speed` [m/s] within a step that may be cut.
    pub fn throws_at_most(&mut self, speed: f64) {
        self.throw = speed;
    }

    /// Largest rate at which its threads pulled at a knot last [m/s^2].
    fn rate(&self) -> f64 {
        let of_line = |line: &Line| {
            let lightest =
                line.thread.knots().iter().map(|&knot| self.inverse_mass[knot]).fold(0.0, f64::max);
            line.winch.pull() * lightest
        };
        self.lines.iter().map(of_line).fold(0.0, f64::max)
    }

    /// Takes less trouble within a call: it is called in every sub-step.
    pub fn in_substeps(&mut self) {
        self.effort = ThreadSweeps::IN_SUBSTEPS;
    }

    /// Puts the anchor of every thread to where `anchor` is, from where it moves on in every (sub-)step. One that jumped once a step
    /// wound threads in at the tension of the first sub-step of many: a tether to 5 kg that recoil with 2 mm/s made 1.6e-2 of the
    /// energy at hand.
    pub fn anchor(&mut self, anchor: Anchor) {
        for line in &mut self.lines {
            line.thread.anchor = anchor;
        }
    }

    /// Whether it runs.
    pub fn runs(&self) -> bool {
        self.runs
    }

    /// Threads and latches pull in turn, until none changes what the others left.
    fn sweep(&mut self, knots: &mut Knots, step: f64) {
        let has_latches = self.lock.as_ref().is_some_and(|lock| !lock.is_empty());
        let sweeps = if has_latches { SWEEPS_WITH_LATCHES } else { self.effort.sweeps };
        for _ in 0..sweeps {
            let mut changed = false;
            for Line { thread, winch, .. } in &mut self.lines {
                changed |= thread.pull(knots, step, &winch.command(step), &self.effort);
            }
            if let Some(lock) = &mut self.lock {
                changed |= lock.pull(knots, step);
            }
            if !changed {
                break;
            }
        }
    }

    /// What it gave the knots since that was last accounted for and what threads drawn out may still give, less the work
    /// of the winches from the start on: what rises it has created [J].
    fn given(&self) -> f64 {
        self.pulled.work() + self.stored() + self.drawn_out() - self.tally().work
    }

    /// Hears where the knots are after the (sub-)step, and winds the threads in.
    fn finish_substep(&mut self, knots: &Knots) {
        for Line { thread, winch, .. } in &mut self.lines {
            winch.wind(|| thread.length(knots));
        }
        self.pulled.end_step(knots);
    }

    /// What it did since the last time; `after` are the knots as they are now.
    pub fn account(&mut self, after: &Knots) -> EffectWork {
        if !self.runs {
            return EffectWork::default();
        }
        self.finish_substep(after);
        let Done { work: on_knots, count } = self.pulled.take_done();
        let (stored, put_in) = (self.stored(), self.tally().work);
        let work = on_knots + stored - std::mem::replace(&mut self.stored_before, stored);
        let lost = put_in - std::mem::replace(&mut self.put_in_before, put_in) - work;
        let Outside { impulse, angular_impulse } = std::mem::take(&mut self.outside);
        EffectWork { work, lost, on_knots, count, impulse, angular_impulse, ..EffectWork::default() }
    }

    /// Every thread as it is in `knots`.
    pub fn read(&mut self, knots: &Knots) -> impl Iterator<Item = Reading> {
        self.lines.iter_mut().map(|line| Reading {
            length: line.thread.length(knots),
            off_reels: line.winch.length(),
            tension: std::mem::take(&mut line.winch.tension),
        })
    }

    /// The knots of each thread in order; `None`: its anchor.
    pub fn ways(&self) -> impl Iterator<Item = Vec<Option<usize>>> + '_ {
        let knot = |node: &Node| match node {
            Node::Knot(knot) => Some(*knot),
            Node::Anchor => None,
        };
        self.lines.iter().map(move |line| line.thread.nodes.iter().map(knot).collect())
    }

    /// Number of threads.
    pub fn n_threads(&self) -> usize {
        self.lines.len()
    }

    /// Number of latches.
    pub fn n_latches(&self) -> usize {
        self.lock.as_ref().map_or(0, Lock::len)
    }

    /// Length of all threads off their reels [m].
    pub fn length(&self) -> f64 {
        self.lines.iter().map(|line| line.winch.length()).sum()
    }

    /// Kinetic energy of the reels [J].
    pub fn stored(&self) -> f64 {
        self.lines.iter().map(|line| line.winch.stored()).sum()
    }

    /// What threads that are drawn out beyond their reels can give back, at most [J]: nothing once it has ended.
    pub fn drawn_out(&self) -> f64 {
        if !self.runs {
            return 0.0;
        }
        self.lines.iter().map(|line| line.winch.drawn_out()).sum()
    }

    /// What the winches have done together: works add up, tensions, times and excesses (over the
    /// full length of their thread [-]) are the largest.
    pub fn tally(&self) -> WinchRecord {
        self.lines.iter().fold(
            WinchRecord::default(),
            |sum, Line { winch: Winch { tally, .. }, full_length, .. }| WinchRecord {
                work: sum.work + tally.work,
                tension: sum.tension.max(tally.tension),
                time_at_limit: sum.time_at_limit.max(tally.time_at_limit),
                excess: sum.excess.max(tally.excess / full_length),
                limit_overshoot: sum.limit_overshoot.max(tally.limit_overshoot / full_length),
            },
        )
    }
}

impl SubstepConstraint for Mechanism {
    fn knots(&self, knots: &mut Vec<usize>) {
        knots.extend(self.pulled.knots().filter(|_| self.runs));
    }

    fn solve(&mut self, knots: &mut Knots, step: f64, touched: &mut [bool]) {
        if !self.runs {
            return;
        }
        let inverse_mass = &self.inverse_mass;
        for Line { thread, winch, .. } in &mut self.lines {
            thread.begin(knots, inverse_mass);
            thread.foresee(step);
            winch.wind(|| thread.length_at_start());
        }
        if let Some(lock) = &mut self.lock {
            lock.begin(knots, inverse_mass);
        }
        self.pulled.before_pull(knots, step);
        self.last_step = step;

        self.sweep(knots, step);

        for Line { thread, winch, .. } in &mut self.lines {
            winch.pulled(step, thread.impulse(), thread.length_at_end());
            thread.expect(knots, step);
            let outside = Outside::of(thread);
            self.outside.impulse += outside.impulse;
            self.outside.angular_impulse += outside.angular_impulse;
            thread.anchor.position += step * thread.anchor.velocity;
        }
        self.pulled.after_pull(knots, &self.inverse_mass, touched);
    }

    fn checkpoint(&mut self, step: f64) -> StepNeeds {
        if !self.runs {
            self.checkpoint = None;
            return StepNeeds::default();
        }
        let ties = self.lock.as_mut().map(Lock::hand_over).unwrap_or_default();
        for line in &mut self.lines {
            line.winch.excess = 0.0;
        }
        self.checkpoint = Some(Checkpoint {
            given: self.given(),
            winches: self.lines.iter().map(|line| line.winch).collect(),
            foresight: self.lines.iter().map(|line| line.thread.foresight.clone()).collect(),
            anchors: self.lines.iter().map(|line| line.thread.anchor).collect(),
            lock: self.lock.clone(),
            pulled: self.pulled.clone(),
            outside: self.outside,
        });
        StepNeeds { parts: (step * self.rate() / self.throw).ceil() as u32, ties }
    }

    fn rollback(&mut self) {
        let Some(kept) = self.checkpoint.clone() else { return };
        let threads = kept.foresight.into_iter().zip(kept.anchors);
        for ((line, winch), (foresight, anchor)) in self.lines.iter_mut().zip(kept.winches).zip(threads) {
            line.winch = winch;
            line.thread.foresight = foresight;
            line.thread.anchor = anchor;
        }
        self.lock = kept.lock;
        self.pulled = kept.pulled;
        self.outside = kept.outside;
    }

    /// It is violated where it left a thread too long or throws a knot; it creates what it gave beyond the work of its winches and
    /// beyond what it held.
    fn fared(&mut self, knots: &Knots) -> Fared {
        self.finish_substep(knots);
        if !self.runs {
            return Fared::default();
        }
        let is_thrown = self.rate() * self.last_step > JERK * self.throw;
        let is_long = self.lines.iter().any(|line| line.winch.excess > EXCESS * line.full_length);
        let created = self.checkpoint.as_ref().map_or(0.0, |kept| self.given() - kept.given);
        Fared { is_violated: is_thrown || is_long, created }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;
    use thread::Ends;

    const DRIVE: Drive = Drive { winches: 1.0, speed: 0.5, tension: 2.0, reel_mass: 0.0, stop_share: 0.0 };

    fn route(nodes: Vec<Node>, winches: u32, full_length: f64) -> Route {
        Route { nodes, ends: Ends::Both, winches, full_length }
    }

    /// Knots that nothing but the mechanism moves.
    #[derive(Clone)]
    struct Free {
        knots: Knots,
        mechanism: Mechanism,
        posted: f64,
    }

    impl Free {
        fn new(position: Vec<Vector3<f64>>, mass: &[f64], route: &Route, drive: Drive) -> Free {
            let knots = Knots { velocity: vec![Vector3::zeros(); position.len()], position };
            let mut mechanism = Mechanism::new(vec![Line::new(route, drive, 0.0, 0.0)], None, mass);
            mechanism.start(&knots);
            Free { knots, mechanism, posted: 0.0 }
        }

        fn step(&mut self, step: f64) -> EffectWork {
            let n_knots = self.knots.position.len();
            self.mechanism.solve(&mut self.knots, step, &mut vec![false; n_knots]);
            for (x, v) in self.knots.position.iter_mut().zip(&self.knots.velocity) {
                *x += step * v;
            }
            let done = self.mechanism.account(&self.knots);
            self.posted += done.work;
            done
        }
    }

    /// Reeling in a row of free knots at speed n s: both ends move at n s / 2 from the first step
    /// on, with kinetic energy m (n s)² / 4; the winches put in twice that, λ n s, and half is lost
    /// when the thread goes taut against knots at rest. Nothing more is needed afterwards.
    #[test]
    fn closing_a_row_matches_the_closed_form() {
        let (n, mass) = (7, 0.3);
        let position = (0..n).map(|i| vector![0.1 * i as f64, 0.0, 0.0]).collect();
        let row = route((0..n).map(Node::Knot).collect(), 2, 0.6);
        let drive = Drive { tension: 1e9, ..DRIVE };
        let mut free = Free::new(position, &vec![mass; n], &row, drive);
        for _ in 0..90 {
            free.step(1e-3);
        }
        let rate = 2.0 * DRIVE.speed;
        assert!((free.mechanism.length() - (0.6 - 0.09 * rate)).abs() < 1e-9);
        assert!((free.knots.velocity[0].x - rate / 2.0).abs() < 1e-9);
        let energy = mass * rate * rate / 4.0;
        assert!((free.posted - energy).abs() < 1e-9 * energy, "{} of {energy}", free.posted);
        let work = free.mechanism.tally().work;
        assert!((work - 2.0 * energy).abs() < 1e-9 * energy, "{work}");
        let momentum: Vector3<f64> = free.knots.velocity.iter().sum();
        assert!(momentum.norm() < 1e-12);
    }

    /// A mass on a tether at the limit T: v = T t / m. Work of the winch: T times the way, which is
    /// the kinetic energy but for a step's worth.
    #[test]
    fn at_the_limit_the_tension_is_constant() {
        let (mass, time, step) = (0.5, 0.1, 1e-4);
        let tether = route(vec![Node::Anchor, Node::Knot(0)], 1, 0.0);
        let mut free =
            Free::new(vec![vector![3.0, 0.0, 0.0]], &[mass], &tether, Drive { speed: 1e3, ..DRIVE });
        for _ in 0..1000 {
            free.step(step);
        }
        let speed = DRIVE.tension * time / mass;
        assert!((free.knots.velocity[0].x + speed).abs() < 1e-9);
        let tally = free.mechanism.tally();
        assert!((tally.tension - DRIVE.tension).abs() < 1e-12);
        assert!((tally.time_at_limit - time).abs() < 1e-9);
        let energy = 0.5 * mass * speed * speed;
        assert!((free.posted - energy).abs() < 1e-9 * energy);
        // Reeled in over n steps: T² h² n (n + 1) / 2 m, a share 1 / n above the energy.
        assert!((tally.work / energy - (1.0 + step / time)).abs() < 1e-9);
    }

    /// Motor force T on reel m_r and mass m together: a = T / (m_r + m), tension m a.
    #[test]
    fn an_inert_reel_speeds_up_with_what_it_pulls() {
        let (mass, reel_mass, time) = (0.5, 0.3, 0.1);
        let tether = route(vec![Node::Anchor, Node::Knot(0)], 1, 0.0);
        let drive = Drive { speed: 1e3, reel_mass, ..DRIVE };
        let mut free = Free::new(vec![vector![3.0, 0.0, 0.0]], &[mass], &tether, drive);
        for _ in 0..1000 {
            free.step(1e-4);
        }
        let speed = DRIVE.tension * time / (reel_mass + mass);
        assert!((free.knots.velocity[0].x + speed).abs() < 1e-3 * speed, "{}", free.knots.velocity[0].x);
        let tension = DRIVE.tension * mass / (reel_mass + mass);
        assert!((free.mechanism.tally().tension - tension).abs() < 1e-3 * tension);
        let stored = 0.5 * reel_mass * speed * speed;
        assert!((free.mechanism.stored() - stored).abs() < 2e-3 * stored);
        // Posted: what the mass and the reel have.
        let energy = 0.5 * (mass + reel_mass) * speed * speed;
        assert!((free.posted - energy).abs() < 2e-3 * energy);
    }

    /// Two masses fly apart and are caught: the thread holds its length, and pays nothing out.
    #[test]
    fn a_thread_that_is_pulled_apart_holds_and_never_pays_out() {
        let pair = route(vec![Node::Knot(0), Node::Knot(1)], 2, 1.0);
        let position = vec![Vector3::zeros(), vector![0.9, 0.0, 0.0]];
        let drive = Drive { speed: 0.1, tension: 1e9, ..DRIVE };
        let mut free = Free::new(position, &[1.0, 2.0], &pair, drive);
        free.knots.velocity = vec![vector![-1.0, 0.5, 0.0], vector![1.0, -0.5, 0.2]];
        let mut last = free.mechanism.length();
        for _ in 0..2000 {
            free.step(5e-4);
            assert!(free.mechanism.length() <= last);
            last = free.mechanism.length();
        }
        let excess = free.mechanism.tally().excess;
        assert!(excess < 1e-9, "{excess}");
    }

    /// Two masses draw a thread of 2 N out, all their energy, and it brings them back: on the way it may hold no less
    /// than it took. The winch has stopped and puts in nothing. A thread that pulls harder on the way back gives more
    /// than it got, which its account says: 3 N over the way that it was drawn out.
    #[test]
    fn a_thread_gives_back_what_drew_it_out_and_no_more_unseen() {
        let pair = route(vec![Node::Knot(0), Node::Knot(1)], 1, 1.0);
        let position = vec![Vector3::zeros(), vector![1.0, 0.0, 0.0]];
        let mut free = Free::new(position, &[1.0, 1.0], &pair, Drive { speed: 0.0, ..DRIVE });
        free.knots.velocity = vec![vector![-0.5, 0.0, 0.0], vector![0.5, 0.0, 0.0]];
        let lost_when_back = |mut free: Free, tension_back: f64| {
            let (mut lost, mut farthest) = (0.0, 0.0_f64);
            for _ in 0..4000 {
                let [from, to] = [0, 1].map(|knot| free.knots.position[knot].x);
                farthest = farthest.max(to - from - 1.0);
                if free.knots.velocity[1].x <= 0.0 {
                    free.mechanism.command(0.0, tension_back);
                }
                lost += free.step(2e-4).lost;
                if tension_back == DRIVE.tension {
                    // What it has taken so far is what it has lost so far; a step is 2e-4 s at 1 m/s and 2 N.
                    assert!(
                        lost < free.mechanism.drawn_out() + 1e-3,
                        "{lost} of {}",
                        free.mechanism.drawn_out()
                    );
                }
                if to - from < 1.0 - 1e-3 {
                    break;
                }
            }
            assert!((farthest - 0.125).abs() < 3e-4, "0.25 J over 2 N: {farthest}");
            lost
        };
        let lost = lost_when_back(free.clone(), DRIVE.tension);
        assert!(lost.abs() < 1e-3, "{lost}");
        let lost = lost_when_back(free, DRIVE.tension + 3.0);
        assert!((lost + 3.0 * 0.125).abs() < 5e-3, "{lost}");
    }

    #[test]
    fn winding_ends_at_the_stop() {
        let pair = route(vec![Node::Knot(0), Node::Knot(1)], 2, 1.0);
        let position = vec![Vector3::zeros(), vector![1.0, 0.0, 0.0]];
        let mut free = Free::new(position, &[1.0, 2.0], &pair, Drive { stop_share: 0.4, ..DRIVE });
        for _ in 0..2000 {
            free.step(5e-4);
        }
        assert!((free.mechanism.length() - 0.4).abs() < 1e-12);
    }
}
