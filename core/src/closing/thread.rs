//! A thread that slides through knots: one unilateral row on its whole length.
//!
//! S(x) = Σ |xᵢ₊₁ − xᵢ| over the knots it passes must not exceed an allowed length. With the
//! gradient gⱼ = ∂S/∂xⱼ (the difference of the unit vectors of knot j's two segments) one impulse
//! λ acts on all knots at once,
//!
//!   vⱼ ← vⱼ − λ gⱼ / mⱼ,   λ = (S(x + h v) − allowed) / (h w),   w = Σ |gⱼ|² / mⱼ,   0 ≤ λ ≤ limit,
//!
//! so that the thread is no longer than allowed when the knots have moved on with their new
//! velocities. The tension λ / h is the same in every segment that is not bunched.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | S, Ṡ | length of the thread, Σ gⱼ · vⱼ | m, m/s |
//! | h | time step | s |
//! | λ | impulse within the step, positive when it pulls | N s |
//! | w | inverse effective mass of all knots on the thread | 1/kg |
//! | μ, φ | capstan friction, turning angle at a knot | -, rad |
//!
//! **Curvature.** S is not linear in the velocities where the thread turns. λ is therefore found by
//! a few Newton passes on S at the end of the step. The pull acts along the segments as they lie
//! at its start, which keeps linear and angular momentum exactly.
//!
//! **Short segments.** Two knots cannot come nearer than the tube bunched between them lets them, the
//! floor: where they are about to, the pull along their segment is at most the one that brings them
//! to the floor at the end of the step; it may push, as the bunched tube does, and takes energy only.
//! Where the floor is less than h² T / μₑ, μₑ their reduced mass, the two would turn about each other
//! faster than the step under a sustained tension T, and with light knots as energetically as the
//! shot. There the pull is the one that makes them meet at the end of the step, where that is less than
//! the tension, and points to where they will be otherwise: each segment then takes its exact part of
//! the convex problem min Σ mⱼ |v'ⱼ − vⱼ|² / 2 + λ S(x + h v') / h, whose steps never gain energy. The
//! price is an angular impulse of at most λ times the length of the short segment: with a floor of nothing, 5 N drawing four
//! knots into one place for a minute, 6e-3 of the angular momentum with explicit cables and 7e-3 to 3e-2 with the engine's. The floor is therefore
//! at least the size of a knot, with which they are 1e-11 and 2e-5.
//!
//! **What cables will do.** Where cables act after the thread, as the engine's do, they part the knots of a short segment
//! within the same step: the pull that was to bring these to the floor is then less than what holds them there, so the
//! bunched tube pushes while it lengthens, and gives the thread what no winch put in: up to 8 mJ at once on the Cubesat's
//! net. So a segment hears by how much it came out longer than it was to be, step by step ([`Foresight`]), and
//! pulls for that in advance. Created of the energy at hand, 16 Cubesats at 2 rad/s, 3 s, in the middle and at most: 1e-3
//! and 1e-2 without, 1.4e-4 and 3.2e-4 so, together with a step that is cut where a thread creates. With explicit cables
//! contacts act after the thread: eight `cinch`es about z with friction made 3.8e-3 and 1.1e-2 without, 2.2e-4 and 1e-3 so.
//! What presses its knots together a segment hears, too, but that is no reason to push: a cable drawn over an edge pressed two
//! knots together at 8 m/s in each sub-step, the segment pushed them apart at 8 m/s before, and one tube of eight gave 5e-3
//! that way, 1e-5 so. A pull may be less for it; not to hear it at all made the `cinch`es 1.8e-4 and 7.7e-4.
//!
//! **Many short segments** hold each other: what one needs depends on what its neighbours get. They are settled together with the
//! thread's own pull (`chain`), from that of the last step on. Where knots would turn about each other pulls have directions of their own and
//! segments are settled one after the other, forth and back, bunched ones from the share of the pull that they had in the step before.
//!
//! **Capstan friction.** Where the thread turns by φ and slides towards the nearest end that is wound, its tension falls by
//! e^(−μφ). It enters as a weight on each segment's pull (w = Σ gⱼ · fⱼ / mⱼ with the weighted gradient f). How
//! it slid is known from the last steps: past a node goes what all segments beyond it grew shorter by, up to the node at which it has turned half
//! of all it turns, where it goes to neither end. What slides slower than `SLIDES` rubs less. Where it is drawn back, away from the end, its tension
//! rises again, but never above that of the end: that much less friction than there is, but it takes energy only. As if all of it slid towards
//! its ends whatever the knots did, Cubesats at 2 rad/s made 4e-4 of the energy at hand in the middle and 2.3e-3 at most of 8 with a `tube` and a
//! coefficient of 0.2, and 0.10 and 0.26 with a `cinch`; 7.6e-6 and 2.7e-5, 4e-8 and 1.8e-5 so, and friction takes half as much again of
//! a tube's work and more than twice as much of a `cinch`'s.
//!
//! Ignored: the thread's mass, stretch and bending, its contact with the target, and the size of
//! the holes it runs through.

use nalgebra::Vector3;

use super::chain::{Link, LinkChain, Ring};
use crate::state::Knots;

/// How hard a (sub-)step tries to settle all threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreadSweeps {
    /// Gauss–Seidel sweeps over the threads, at most.
    pub sweeps: usize,
    /// Newton passes of each on its length at the end of the step, at most.
    pub passes: usize,
    /// Both end when no impulse changes by more than this share.
    pub tolerance: f64,
}

impl ThreadSweeps {
    /// Within a step.
    pub const WHOLE: ThreadSweeps = ThreadSweeps { sweeps: 3, passes: 6, tolerance: 1e-7 };

    /// Where sub-steps follow each other so closely that one settles what the last left of other threads, and of the thread's length.
    pub const IN_SUBSTEPS: ThreadSweeps = ThreadSweeps { sweeps: 1, passes: 3, tolerance: 1e-4 };
}

/// A segment is long, and pulled along the line it has at the start of the step, when its knots
/// would need more than so many steps to meet under the thread's pull alone. An explicit pull
/// oscillates without end below 1 and rings below 4.
const LONG: f64 = 4.0;

/// Share by which what is foreseen follows the last step. Behind it a segment lengthens with less than the thread's pull: 16 Cubesats about
/// z with a `cinch` and friction, under joints+rapier, made 1.4e-3 of the energy in the middle with 0.2, 8e-4 with 0.4, 5e-4 with 0.7 and 7e-4
/// with 1 (4e-3 to 6e-3 at most with any), explicit ones 4e-5, 3.6e-5 and 3.3e-5 with 0.2, 0.5 and 0.8.
const FOLLOW: f64 = 0.7;

/// A thread that slides over a knot at less than so much [m/s] rubs less than the capstan's law says, down to nothing at rest. With ten times as much
/// eight Cubesats' tubes lose 0.166 +- 0.006 J to knots and friction for 0.152 +- 0.004, `cinch`es 1.18 +- 0.03 for 1.21 +- 0.02.
const SLIDES: f64 = 0.01;

/// Time within which friction follows another sliding speed [s]: light knots swing faster. Of 64 `cinch`es, explicit, with a coefficient of 0.2 one made
/// 9.3e-4 of the energy at hand and 8 of the suite 1.2e-3 without, 2e-5 at most so, 3.2e-5 with three times and 1.2e-4 with ten times as much.
const SETTLES: f64 = 1e-4;

/// Least share of its weight if all segments pulled that a Newton pass counts on.
const LEAST_WEIGHT: f64 = 1e-3;

/// A point of a thread's way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// A knot of the net.
    Knot(usize),
    /// The anchor, a fixed point outside of the net.
    Anchor,
}

/// Which ends of a thread are wound; tension falls away from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// Both.
    Both,
    /// The first.
    First,
}

/// What a thread is to do within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthCommand {
    /// Length allowed at the end of the step [m].
    pub length: f64,
    /// The same where the reels give way to the pull, at most [m].
    pub length_most: f64,
    /// By how much they give way: their inverse inertia [1/kg].
    pub compliance: f64,
    /// Largest impulse [N s].
    pub impulse_most: f64,
}

impl LengthCommand {
    /// A plain bound on the length, whatever it takes.
    pub fn hold(length: f64) -> LengthCommand {
        LengthCommand { length, length_most: length, compliance: 0.0, impulse_most: f64::INFINITY }
    }

    /// Whether an impulse that ends at `length` stays as it is: at its limit, as long as the thread is too long.
    fn stays(&self, length: f64, impulse: f64, step: f64) -> bool {
        let given = self.length + step * self.compliance * impulse;
        impulse >= self.impulse_most && length >= given.min(self.length_most)
    }

    /// The impulse that ends at the allowed length, from `impulse` that ends at `length`, if the
    /// knots' inverse effective mass is `weight`.
    fn solve(&self, length: f64, impulse: f64, weight: f64, step: f64) -> f64 {
        let given = self.length + step * self.compliance * impulse;
        let wanted = if given < self.length_most {
            impulse + (length - given) / (step * (weight + self.compliance))
        } else {
            impulse + (length - self.length_most) / (step * weight) // the reels stand
        };
        // Not `clamp`: where a method fails the bounds may be no numbers, and the end of the step says so.
        wanted.max(0.0).min(self.impulse_most)
    }
}

/// What a thread ends at that is no knot, and goes on whatever the thread does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anchor {
    /// Where it is [m].
    pub position: Vector3<f64>,
    /// How fast it is [m/s].
    pub velocity: Vector3<f64>,
}

/// A thread, its way, and its pull within the step under way.
#[derive(Clone, Debug)]
pub struct Thread {
    /// The points it passes, in order.
    pub nodes: Vec<Node>,
    /// Its anchor, if it has one.
    pub anchor: Anchor,
    ends: Ends,
    friction: f64,
    /// Length at which a segment is bunched and can be no shorter [m].
    floor: f64,
    /// The knots it passes, each once: a loop comes back to its first.
    distinct: Vec<usize>,
    /// For every node its place among the distinct knots; the anchor's is behind them.
    slots: Vec<usize>,
    /// The node to which its end comes back, where it closes a ring.
    ring_at: Option<usize>,

    /// What the rest of the world does to segments, where somebody asks; to be kept, and given back when a step is done
    /// again.
    pub foresight: Foresight,

    // Written by `begin`; in the order of slots, so that passes run through memory one after another.
    segments: Vec<Segment>,
    /// Where they are [m], and one over their masses [1/kg]: the anchor's is 0.
    position: Vec<Vector3<f64>>,
    inverse_masses: Vec<f64>,
    length_at_start: f64,

    // Written by `pull`.
    /// Their velocities, in the order of slots [m/s].
    velocity: Vec<Vector3<f64>>,
    impulse: f64,
    /// Length at the end of the step, as far as this thread decides it [m].
    length_at_end: f64,
    /// What its segments are settled with.
    chain: LinkChain,
    /// Whether pulls have changed since the chain heard of them.
    is_stale: bool,
}

/// What the last steps tell of the next: how the rest of the world lengthens short segments within a step, and what they
/// pulled with. What comes at once, as a hit does, is met a few steps late.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Foresight {
    /// The step under way [s]; 0: none.
    step: f64,
    /// Tension in the last step [N].
    tension: f64,
    segments: Vec<Foreseen>,
}

/// What is foreseen of a segment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Foreseen {
    /// Rate at which it is lengthened [m/s²].
    rate: f64,
    /// Its length to come if nothing lengthens it [m]; only where it is short.
    expected: Option<f64>,
    /// Its tension over that of the thread [-], until a pull begins with it; only where it is short.
    share: f64,
    /// Its length at the start of the last step, and the rate at which it lengthened since, see [`SETTLES`] [m, m/s]; only where it rubs.
    length: f64,
    lengthening: f64,
}

/// A stretch of thread between two nodes.
#[derive(Clone, Copy, Debug, Default)]
struct Segment {
    /// At the start of the step [m].
    length: f64,
    /// Unit vector from the first node to the second at the start of the step.
    along: Vector3<f64>,
    /// Its tension over the largest on the thread [-].
    share: f64,
    /// Angle by which the thread turns at its end [rad]; only where it rubs.
    turn: f64,
    /// Impulse on its first node within the step, and minus that on its second [N s].
    pull: Vector3<f64>,
    /// Speed at which the rest of the world will part its nodes within the step, as far as can be foreseen [m/s].
    parted: f64,
    /// Whether its nodes would meet within a few steps.
    is_short: bool,
}

impl Thread {
    /// A thread through `nodes`, wound at `ends`, with capstan friction coefficient `friction` [-].
    pub fn new(nodes: Vec<Node>, ends: Ends, friction: f64) -> Thread {
        let mut distinct = Vec::new();
        for node in &nodes {
            if let Node::Knot(knot) = node
                && !distinct.contains(knot)
            {
                distinct.push(*knot);
            }
        }
        let slot = |node: &Node| match node {
            Node::Knot(knot) => distinct.iter().position(|k| k == knot).unwrap_or(distinct.len()),
            Node::Anchor => distinct.len(),
        };
        let zeros = vec![Vector3::zeros(); distinct.len() + 1];
        let n_segments = nodes.len().saturating_sub(1);
        let ring_at = nodes.split_last().and_then(|(end, others)| others.iter().position(|node| node == end));
        Thread {
            segments: vec![Segment::default(); n_segments],
            slots: nodes.iter().map(slot).collect(),
            foresight: Foresight { segments: vec![Foreseen::default(); n_segments], ..Foresight::default() },
            nodes,
            anchor: Anchor::default(),
            ends,
            friction,
            floor: 0.0,
            // At its first node one segment begins and none ends.
            ring_at: ring_at.filter(|at| *at > 0),
            inverse_masses: vec![0.0; zeros.len()],
            position: zeros.clone(),
            velocity: zeros,
            distinct,
            length_at_start: 0.0,
            chain: LinkChain::default(),
            is_stale: true,
            impulse: 0.0,
            length_at_end: 0.0,
        }
    }

    /// The same thread in a tube that is bunched when a segment is as short as `floor` [m].
    pub fn in_tube(self, floor: f64) -> Thread {
        Thread { floor, ..self }
    }

    /// A thread of one segment between two knots.
    pub fn between(a: usize, b: usize) -> Thread {
        Thread::new(vec![Node::Knot(a), Node::Knot(b)], Ends::Both, 0.0)
    }

    /// The knots it passes, each once.
    pub fn knots(&self) -> &[usize] {
        &self.distinct
    }

    /// Its length in `knots` [m].
    pub fn length(&self, knots: &Knots) -> f64 {
        self.length_after(knots, 0.0)
    }

    /// Length of its first segment, where that comes from the anchor [m]; else 0.
    pub fn length_of_tether(&self, knots: &Knots) -> f64 {
        match self.nodes.first() {
            Some(Node::Anchor) => (self.position(1, knots) - self.anchor.position).norm(),
            _ => 0.0,
        }
    }

    /// Its length when the step began [m].
    pub fn length_at_start(&self) -> f64 {
        self.length_at_start
    }

    /// Its length at the end of the step, as far as its own pull decides it [m].
    pub fn length_at_end(&self) -> f64 {
        self.length_at_end
    }

    /// Its pull within the step so far [N s].
    pub fn impulse(&self) -> f64 {
        self.impulse
    }

    /// Impulse of the anchor on the thread within the step so far [N s].
    pub fn impulse_of_anchor(&self) -> Vector3<f64> {
        let ends = self.nodes.iter().zip(self.nodes.iter().skip(1)).zip(&self.segments);
        ends.map(|((a, b), segment)| match (a, b) {
            (Node::Anchor, _) => -segment.pull,
            (_, Node::Anchor) => segment.pull,
            _ => Vector3::zeros(),
        })
        .sum()
    }

    /// Begins a step: takes the geometry as it is, with no pull yet.
    pub fn begin(&mut self, knots: &Knots, inverse_mass: &[f64]) {
        self.impulse = 0.0;
        self.length_at_start = 0.0;
        let anchor = self.distinct.len();
        for (slot, &knot) in self.distinct.iter().enumerate() {
            self.position[slot] = knots.position[knot];
            self.inverse_masses[slot] = inverse_mass[knot];
        }
        self.position[anchor] = self.anchor.position;
        self.velocity[anchor] = self.anchor.velocity;
        let mut from = self.position[self.slots[0]];
        for (segment, &slot) in self.segments.iter_mut().zip(&self.slots[1..]) {
            let to = self.position[slot];
            let across = to - from;
            let length = across.norm();
            let along = if length > 0.0 { across / length } else { Vector3::zeros() };
            *segment = Segment { length, along, share: 1.0, pull: Vector3::zeros(), ..Segment::default() };
            self.length_at_start += length;
            from = to;
        }
        self.length_at_end = self.length_at_start;
        if self.friction > 0.0 {
            self.share_tension();
        }
        self.is_stale = true;
    }

    /// Begins a step of `step` seconds after which others change the velocities again, and hears what they did last.
    pub fn foresee(&mut self, step: f64) {
        let Foresight { step: last, segments, .. } = &mut self.foresight;
        for (segment, seen) in self.segments.iter_mut().zip(segments) {
            let met = seen.expected.take().map_or(0.0, |length| (segment.length - length) / (*last * *last));
            seen.rate += FOLLOW * (met - seen.rate);
            segment.parted = step * seen.rate;
        }
        *last = step;
    }

    /// Takes down how long short segments will be if the rest of the world does nothing, and how hard they pulled.
    pub fn expect(&mut self, knots: &Knots, step: f64) {
        let at = |node: &Node| node.place_after(step, knots, &self.anchor);
        let impulse = self.impulse.max(f64::MIN_POSITIVE);
        self.foresight.tension = self.impulse / step;
        for ((segment, seen), nodes) in
            self.segments.iter().zip(&mut self.foresight.segments).zip(self.nodes.windows(2))
        {
            seen.expected = segment.is_short.then(|| (at(&nodes[1]) - at(&nodes[0])).norm());
            seen.share = if segment.is_short {
                (segment.along.dot(&segment.pull) / impulse).clamp(0.0, 1.0)
            } else {
                0.0
            };
        }
    }

    /// Tension of each segment over that of the nearest wound end, see above.
    fn share_tension(&mut self) {
        let n_segments = self.segments.len();
        let Foresight { step, segments: foreseen, .. } = &mut self.foresight;
        let mut turns = 0.0;
        for (i, seen) in foreseen.iter_mut().enumerate() {
            let next = self.segments.get(i + 1).map(|next| next.along);
            let segment = &mut self.segments[i];
            let before = std::mem::replace(&mut seen.length, segment.length);
            if *step > 0.0 {
                let rate = (segment.length - before) / *step;
                seen.lengthening += *step / (*step + SETTLES) * (rate - seen.lengthening);
            } else {
                seen.lengthening = -SLIDES; // as if all of it was wound
            }
            segment.turn = next.map_or(0.0, |along| segment.along.angle(&along));
            turns += segment.turn;
        }
        let mut n_to_first = n_segments;
        if self.ends == Ends::Both {
            let mut turned = 0.0;
            let is_near = |segment: &&Segment| {
                turned += segment.turn;
                turned <= 0.5 * turns
            };
            n_to_first = n_segments.min(1 + self.segments.iter().take_while(is_near).count());
        }
        self.rub(n_to_first, |k| k);
        self.rub(n_segments - n_to_first, |k| n_segments - 1 - k);
    }

    /// Friction over `n` segments, of which the first is at a wound end and the k-th from there has the index `at(k)`; nothing slides
    /// out of the last.
    fn rub(&mut self, n: usize, at: impl Fn(usize) -> usize) {
        let foreseen = &self.foresight.segments;
        let mut slide: f64 = (0..n).map(|k| -foreseen[at(k)].lengthening).sum();
        let mut share = 1.0_f64;
        for k in 1..n {
            let (before, this) = (at(k - 1), at(k));
            slide += foreseen[before].lengthening;
            let rubs = (slide / SLIDES).clamp(-1.0, 1.0);
            let turn = self.segments[before.min(this)].turn;
            share = (share * (-self.friction * turn * rubs).exp()).min(1.0);
            self.segments[this].share = share;
        }
    }

    /// Pulls as `ask` says; may be called again within a step, after other threads have pulled.
    ///
    /// Returns whether it changed any velocity.
    pub fn pull(&mut self, knots: &mut Knots, step: f64, ask: &LengthCommand, effort: &ThreadSweeps) -> bool {
        for (velocity, &knot) in self.velocity.iter_mut().zip(&self.distinct) {
            *velocity = knots.velocity[knot];
        }
        self.load_chain(step);
        let mut weight = self.chain.weight_taut();
        if weight <= 0.0 {
            return false; // all its knots are in one place
        }
        let start = self.impulse;
        let mut largest = 0.0_f64;
        // As in the step before: that is nearly it.
        let last = (self.foresight.tension * step).min(ask.impulse_most);
        let mut is_settled = start == 0.0 && last > 0.0 && !self.sort(step, last);
        if is_settled {
            largest = self.settle(step, last);
        }
        let mut has_ended = false;
        for pass in 0..effort.passes {
            self.length_at_end = self.length_ahead(step);
            if is_settled {
                has_ended = ask.stays(self.length_at_end, self.impulse, step);
                if has_ended {
                    break;
                }
                weight = self.chain.weight().max(LEAST_WEIGHT * weight);
            }
            let impulse = ask.solve(self.length_at_end, self.impulse, weight, step);
            let tolerance = effort.tolerance * impulse;
            has_ended = is_settled && (impulse - self.impulse).abs() <= tolerance;
            if has_ended {
                break;
            }
            is_settled = !self.sort(step, impulse);
            let change = if is_settled {
                self.settle(step, impulse)
            } else {
                if self.impulse == 0.0 {
                    self.guess(impulse);
                }
                self.settle_in_turn(step, impulse, (effort.passes - pass).is_multiple_of(2))
            };
            largest = largest.max(change);
            has_ended = change <= tolerance;
            if has_ended || impulse == 0.0 {
                break;
            }
        }
        if !has_ended {
            self.length_at_end = self.length_ahead(step);
        }
        for (velocity, &knot) in self.velocity.iter().zip(&self.distinct) {
            knots.velocity[knot] = *velocity;
        }
        largest > effort.tolerance * start.max(self.impulse)
    }

    /// Says which segments are short under the pull `impulse`, and whether the knots of one would turn about each other.
    fn sort(&mut self, step: f64, impulse: f64) -> bool {
        let mut turns = false;
        for (segment, link) in self.segments.iter_mut().zip(&mut self.chain.links) {
            // Two free knots under this pull would come nearer by so much in the step.
            let nearer = segment.share * impulse * link.inverse_mass * step;
            segment.is_short = segment.length <= self.floor + LONG * nearer;
            link.is_short = segment.is_short;
            turns |= segment.is_short && nearer > self.floor;
        }
        turns
    }

    /// Tells the chain of the segments, their pulls and the velocities of their knots.
    fn load_chain(&mut self, step: f64) {
        let Thread { segments, slots, velocity, inverse_masses, chain, floor, .. } = self;
        chain.links.resize(segments.len(), Link::default());
        for ((segment, ends), link) in segments.iter().zip(slots.windows(2)).zip(&mut chain.links) {
            let [a, b] = [ends[0], ends[1]];
            link.inverse_mass = inverse_masses[a] + inverse_masses[b];
            link.share = segment.share;
            link.room = (segment.length - floor.min(segment.length)) / step;
            link.parted = segment.parted;
            link.rate = segment.along.dot(&(velocity[b] - velocity[a]));
            link.pull = segment.along.dot(&segment.pull);
        }
        let coupling = |at: usize, i: usize, j: usize| {
            inverse_masses[slots[at]] * segments[i].along.dot(&segments[j].along)
        };
        for i in 1..segments.len() {
            chain.links[i - 1].next = coupling(i, i - 1, i);
        }
        let last = segments.len() - 1;
        // Its pull moves the knot at its end the other way than one that begins there.
        let ring = |at: usize| Ring {
            into: at - 1,
            couplings: [-coupling(at, at - 1, last), coupling(at, at, last)],
        };
        chain.ring = self.ring_at.map(ring);
        chain.release();
        self.is_stale = false;
    }

    /// Gives all segments together their part of the pull `impulse`; the largest change of any.
    fn settle(&mut self, step: f64, impulse: f64) -> f64 {
        if self.is_stale {
            self.load_chain(step);
        }
        let Thread { segments, slots, velocity, inverse_masses, chain, .. } = self;
        chain.settle(impulse);
        let mut largest = 0.0_f64;
        for ((segment, link), ends) in segments.iter_mut().zip(&chain.links).zip(slots.windows(2)) {
            let change = link.pull - segment.along.dot(&segment.pull);
            largest = largest.max(change.abs());
            let change = change * segment.along;
            velocity[ends[0]] += inverse_masses[ends[0]] * change;
            velocity[ends[1]] -= inverse_masses[ends[1]] * change;
            segment.pull += change;
        }
        self.impulse = impulse;
        largest
    }

    /// Gives short segments, which have none yet, the part of the pull `impulse` that they had in the step before: they tell each other what
    /// they need but one by one, pass by pass.
    fn guess(&mut self, impulse: f64) {
        let foreseen = self.foresight.segments.iter_mut();
        for ((segment, seen), slots) in self.segments.iter_mut().zip(foreseen).zip(self.slots.windows(2)) {
            let share = std::mem::take(&mut seen.share);
            if share != 0.0 {
                segment.pull = share * impulse * segment.along;
                self.velocity[slots[0]] += self.inverse_masses[slots[0]] * segment.pull;
                self.velocity[slots[1]] -= self.inverse_masses[slots[1]] * segment.pull;
            }
        }
    }

    /// Gives every segment its part of the pull `impulse`, from the first on or `backwards`; the largest change of any.
    fn settle_in_turn(&mut self, step: f64, impulse: f64, backwards: bool) -> f64 {
        let mut largest = 0.0_f64;
        self.is_stale = true;
        self.impulse = impulse;
        let last = self.segments.len() - 1;
        for index in 0..=last {
            let index = if backwards { last - index } else { index };
            let segment = &mut self.segments[index];
            let [a, b] = [self.slots[index], self.slots[index + 1]];
            let (inverse_a, inverse_b) = (self.inverse_masses[a], self.inverse_masses[b]);
            let pair = inverse_a + inverse_b;
            let most = segment.share * impulse;
            // Two free knots under this pull would come nearer by so much in the step.
            let nearer = most * pair * step;
            let pull = if !segment.is_short {
                most * segment.along
            } else {
                let parting = self.velocity[b] - self.velocity[a] + segment.parted * segment.along;
                let floor = self.floor.min(segment.length);
                if nearer <= self.floor {
                    // No nearer than the floor at the end of the step, measured along the segment.
                    let now = segment.along.dot(&segment.pull);
                    let stop = now + ((segment.length - floor) / step + segment.along.dot(&parting)) / pair;
                    // What is foreseen to press them together is no reason to push: it would be given for nothing.
                    let unforeseen = stop - segment.parted / pair;
                    let stop = if segment.parted < 0.0 { stop.max(unforeseen.min(0.0)) } else { stop };
                    most.min(stop) * segment.along
                } else {
                    // Their turning about each other is faster than the step: they are to meet.
                    let meet = segment.pull + (segment.length / step * segment.along + parting) / pair;
                    let size = meet.norm();
                    if size > most { meet * (most / size) } else { meet }
                }
            };
            let change = pull - segment.pull;
            if change != Vector3::zeros() {
                largest = largest.max(change.norm_squared());
                self.velocity[a] += inverse_a * change;
                self.velocity[b] -= inverse_b * change;
                segment.pull = pull;
            }
        }
        largest.sqrt()
    }

    /// Its length after `step` seconds at the velocities that it has pulled its knots to [m].
    fn length_ahead(&self, step: f64) -> f64 {
        let at = |slot: usize| self.position[slot] + step * self.velocity[slot];
        let mut from = at(self.slots[0]);
        let mut length = 0.0;
        for &slot in &self.slots[1..] {
            let to = at(slot);
            length += (to - from).norm();
            from = to;
        }
        length
    }

    /// S(x + h v): its length after `step` seconds if nothing changes the velocities [m].
    pub fn length_after(&self, knots: &Knots, step: f64) -> f64 {
        let at = |node: &Node| node.place_after(step, knots, &self.anchor);
        let mut from = at(&self.nodes[0]);
        let mut length = 0.0;
        for node in &self.nodes[1..] {
            let to = at(node);
            length += (to - from).norm();
            from = to;
        }
        length
    }

    fn position(&self, i: usize, knots: &Knots) -> Vector3<f64> {
        self.nodes[i].place(knots, &self.anchor)
    }
}

impl Node {
    /// Where it is [m].
    fn place(self, knots: &Knots, anchor: &Anchor) -> Vector3<f64> {
        match self {
            Node::Knot(knot) => knots.position[knot],
            Node::Anchor => anchor.position,
        }
    }

    /// Where it is `step` seconds later if nothing changes its velocity [m].
    fn place_after(self, step: f64, knots: &Knots, anchor: &Anchor) -> Vector3<f64> {
        self.place(knots, anchor) + step * self.velocity(knots, anchor)
    }

    /// How fast it is [m/s].
    fn velocity(self, knots: &Knots, anchor: &Anchor) -> Vector3<f64> {
        match self {
            Node::Knot(knot) => knots.velocity[knot],
            Node::Anchor => anchor.velocity,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, vector};

    const STEP: f64 = 1e-3;

    fn row(n: usize) -> (Knots, Thread) {
        let position: Vec<_> = (0..n).map(|i| vector![0.0, i as f64, 0.0]).collect();
        let thread = Thread::new((0..n).map(Node::Knot).collect(), Ends::Both, 0.0);
        (Knots { velocity: vec![Vector3::zeros(); n], position }, thread)
    }

    /// A bent thread whose knots move, no two alike.
    fn bent() -> (Knots, Vec<f64>, Thread) {
        let place = |i: f64| vector![(1.7 * i).sin(), 0.9 * i, 0.4 * (2.3 * i).cos()];
        let motion = |i: f64| vector![(4.1 * i).cos(), (3.1 * i).sin(), 0.3 * i];
        let knots = Knots {
            position: (0..7).map(|i| place(f64::from(i))).collect(),
            velocity: (0..7).map(|i| motion(f64::from(i))).collect(),
        };
        let inverse_mass = (0..7).map(|i| 1.0 + f64::from(i * i)).collect();
        (knots, inverse_mass, Thread::new((0..7).map(Node::Knot).collect(), Ends::Both, 0.0))
    }

    fn pulled(knots: &Knots, inverse_mass: &[f64], thread: &mut Thread, ask: &LengthCommand) -> Knots {
        let mut after = knots.clone();
        thread.begin(knots, inverse_mass);
        thread.pull(&mut after, STEP, ask, &ThreadSweeps::WHOLE);
        after
    }

    /// λ = r m / 2 for two ends of mass m: the knots between feel two equal pulls and stay.
    #[test]
    fn a_row_of_free_knots_closes_at_the_asked_speed_with_equal_tension() {
        let (knots, mut thread) = row(9);
        let (mass, rate) = (0.2, 0.8);
        let after = pulled(&knots, &[1.0 / mass; 9], &mut thread, &LengthCommand::hold(8.0 - rate * STEP));
        assert!((thread.impulse() - rate * mass / 2.0).abs() < 1e-12);
        for segment in &thread.segments {
            assert!((segment.pull - vector![0.0, thread.impulse(), 0.0]).norm() < 1e-12);
        }
        assert!((after.velocity[0].y - rate / 2.0).abs() < 1e-12);
        assert!((after.velocity[8].y + rate / 2.0).abs() < 1e-12);
        assert!(after.velocity[1..8].iter().all(|v| v.norm() < 1e-12));
    }

    #[test]
    fn slack_thread_does_nothing() {
        let (knots, inverse_mass, mut thread) = bent();
        let length = thread.length_after(&knots, STEP);
        assert_eq!(pulled(&knots, &inverse_mass, &mut thread, &LengthCommand::hold(length + 1e-9)), knots);
    }

    /// Where it turns, too: the length is met at the end of the step and not only to first order.
    #[test]
    fn a_bent_thread_ends_at_the_asked_length_and_keeps_both_momenta() {
        let (knots, inverse_mass, mut thread) = bent();
        let ask = LengthCommand::hold(thread.length(&knots) - 0.02);
        let after = pulled(&knots, &inverse_mass, &mut thread, &ask);
        assert!((thread.length_after(&after, STEP) - ask.length).abs() < 1e-9);
        let mut momentum = Vector3::zeros();
        let mut angular = Vector3::zeros();
        for (i, w) in inverse_mass.iter().enumerate() {
            let change = (after.velocity[i] - knots.velocity[i]) / *w;
            momentum += change;
            angular += knots.position[i].cross(&change);
        }
        // Relative to a pull of 1 to 10 N s.
        assert!(momentum.norm() < 1e-12 && angular.norm() < 1e-12, "{momentum} {angular}");
    }

    #[test]
    fn the_pull_never_exceeds_its_limit() {
        let (knots, inverse_mass, mut thread) = bent();
        let limit = 1e-3;
        let ask = LengthCommand { impulse_most: limit, ..LengthCommand::hold(thread.length(&knots) - 0.02) };
        pulled(&knots, &inverse_mass, &mut thread, &ask);
        assert_eq!(thread.impulse(), limit);
        assert!(thread.segments.iter().all(|s| s.pull.norm() <= limit * (1.0 + 1e-12)));
    }

    #[test]
    fn the_same_in_a_turned_frame() {
        let (knots, inverse_mass, mut thread) = bent();
        let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
        let turned = Knots {
            position: knots.position.iter().map(|x| turn * x).collect(),
            velocity: knots.velocity.iter().map(|v| turn * v).collect(),
        };
        let ask = LengthCommand::hold(thread.length(&knots) - 0.02);
        let after = pulled(&knots, &inverse_mass, &mut thread, &ask);
        let again = pulled(&turned, &inverse_mass, &mut thread, &ask);
        for (v, w) in after.velocity.iter().zip(&again.velocity) {
            assert!((turn * v - w).norm() < 1e-10);
        }
    }

    /// Two light knots between two fixed ones, 1 mm off their line, under a tension that throws them
    /// past each other: explicit in every segment they jitter at h T / m = 10 m/s. What may remain
    /// is the string's own vibration, 1 mm times 450 rad/s.
    #[test]
    fn light_knots_close_together_do_not_jitter_under_sustained_tension() {
        let mut knots = Knots {
            position: vec![
                Vector3::zeros(),
                vector![0.1, 1e-3, 0.0],
                vector![0.1, -1e-3, 5e-4],
                vector![0.2, 0.0, 0.0],
            ],
            velocity: vec![Vector3::zeros(); 4],
        };
        let inverse_mass = [0.0, 1e4, 1e4, 0.0];
        let mut thread = Thread::new((0..4).map(Node::Knot).collect(), Ends::Both, 0.0);
        let ask = LengthCommand { impulse_most: 1.0 * STEP, ..LengthCommand::hold(0.0) };
        for _ in 0..300 {
            thread.begin(&knots, &inverse_mass);
            thread.pull(&mut knots, STEP, &ask, &ThreadSweeps::WHOLE);
            for i in 0..4 {
                let velocity = knots.velocity[i];
                knots.position[i] += STEP * velocity;
            }
        }
        let fastest = knots.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(fastest < 0.45, "{fastest} m/s"); // measured: 0.106
        assert!((thread.length(&knots) - 0.2).abs() < 1e-4);
    }

    /// It begins with the pull of the step before, under which no knots turn about each other, and ends with one under which they do: what its
    /// segments pulled with is what the knots have, the anchor's too.
    #[test]
    fn a_pull_that_comes_to_turn_knots_is_counted_once() {
        let position = vec![vector![1.0, 0.0, 0.0], vector![1.0, 0.01, 0.0], vector![1.5, 0.2, 0.1]];
        let mut knots = Knots { velocity: vec![Vector3::zeros(); 3], position };
        let nodes = std::iter::once(Node::Anchor).chain((0..3).map(Node::Knot)).collect();
        let mut thread = Thread::new(nodes, Ends::First, 0.0);
        let seen = Foreseen { share: 0.7, ..Foreseen::default() };
        thread.foresight = Foresight { step: STEP, tension: 0.05, segments: vec![seen; 3] };
        let ask = LengthCommand { impulse_most: 1e-3, ..LengthCommand::hold(0.0) };
        thread.begin(&knots, &[1e4; 3]);
        thread.pull(&mut knots, STEP, &ask, &ThreadSweeps::WHOLE);
        assert_eq!(thread.impulse(), 1e-3);
        let momentum = knots.velocity.iter().sum::<Vector3<f64>>() / 1e4;
        assert!((momentum - thread.impulse_of_anchor()).norm() < 1e-15, "{momentum}");
    }

    /// Around a right angle the tension falls to e^(−μ π/2), from either wound end to the middle.
    #[test]
    fn tension_falls_by_the_capstan_law() {
        let knots = Knots {
            position: vec![
                vector![0.0, 1.0, 0.0],
                vector![0.0, 0.0, 0.0],
                vector![1.0, 0.0, 0.0],
                vector![1.0, 1.0, 0.0],
            ],
            velocity: vec![Vector3::zeros(); 4],
        };
        let falls = (-0.4 * std::f64::consts::FRAC_PI_2).exp();
        for (ends, shares) in [(Ends::Both, [1.0, falls, 1.0]), (Ends::First, [1.0, falls, falls * falls])] {
            let mut thread = Thread::new((0..4).map(Node::Knot).collect(), ends, 0.4);
            pulled(&knots, &[1.0; 4], &mut thread, &LengthCommand::hold(2.999));
            for (segment, share) in thread.segments.iter().zip(shares) {
                assert!((segment.pull.norm() / thread.impulse() - share).abs() < 1e-12);
            }
        }
    }

    /// Around a right angle: a thread that runs out over the knot rubs nothing, one that stands rubs nothing, one that is wound in over it rubs by the
    /// capstan's law, and half as much at half the speed from which on it slides.
    #[test]
    fn friction_is_against_the_way_that_the_thread_slides() {
        let at = |way: f64| Knots {
            position: vec![vector![0.0, 1.0, 0.0], Vector3::zeros(), vector![1.0 - way, 0.0, 0.0]],
            velocity: vec![Vector3::zeros(); 3],
        };
        let all = -0.4 * std::f64::consts::FRAC_PI_2;
        for (speed, exponent) in [(1.0, all), (0.5 * SLIDES, 0.5 * all), (0.0, 0.0), (-1.0, 0.0)] {
            let mut thread = Thread::new((0..3).map(Node::Knot).collect(), Ends::First, 0.4);
            for i in 0..20 {
                thread.begin(&at(speed * STEP * f64::from(i)), &[1.0; 3]);
                thread.foresee(STEP);
            }
            assert!((thread.segments[1].share - f64::exp(exponent)).abs() < 1e-9, "{speed} m/s");
        }
    }

    /// Knots that swing as they please, drawn by a thread from both ends: friction takes, step by step, what it takes off the pull times how fast
    /// the thread slid, and never gives.
    #[test]
    fn friction_only_takes() {
        let (mut knots, inverse_mass, _) = bent();
        let mut thread = Thread::new((0..7).map(Node::Knot).collect(), Ends::Both, 0.5);
        let (mut taken, mut slid) = (0.0, 0);
        for i in 0..400 {
            for (knot, x) in knots.position.iter_mut().enumerate() {
                let phase = 0.05 * f64::from(i) * (1.0 + 0.3 * knot as f64);
                *x += 2e-3 * vector![phase.sin(), (1.3 * phase).cos(), (0.7 * phase).sin()];
            }
            thread.begin(&knots, &inverse_mass);
            thread.foresee(STEP);
            if i > 0 {
                let slid_by = thread.foresight.segments.iter().map(|seen| -seen.lengthening);
                let lost: f64 = thread.segments.iter().zip(slid_by).map(|(s, by)| (1.0 - s.share) * by).sum();
                assert!(lost > -1e-12, "{i}: {lost}");
                taken += lost;
                slid += u32::from(lost > 0.1);
            }
        }
        assert!(taken > 10.0 && slid > 50, "{taken} {slid}");
    }

    /// A loop passes its first knot twice; an anchor takes what the knots lack in momentum.
    #[test]
    fn a_loop_to_an_anchor_balances() {
        let knots = Knots {
            position: vec![vector![1.0, 0.0, 0.0], vector![2.0, 1.0, 0.0], vector![2.0, -1.0, 0.0]],
            velocity: vec![Vector3::zeros(); 3],
        };
        let nodes = vec![Node::Anchor, Node::Knot(0), Node::Knot(1), Node::Knot(2), Node::Knot(0)];
        let mut thread = Thread::new(nodes, Ends::First, 0.0);
        let ask = LengthCommand::hold(thread.length(&knots) - 1e-3);
        let after = pulled(&knots, &[1.0, 2.0, 4.0], &mut thread, &ask);
        assert!((thread.length_after(&after, STEP) - ask.length).abs() < 1e-9);
        let momentum = after.velocity[0] + after.velocity[1] / 2.0 + after.velocity[2] / 4.0;
        assert!((momentum - thread.impulse_of_anchor()).norm() < 1e-12);
        assert!((momentum - vector![-thread.impulse(), 0.0, 0.0]).norm() < 1e-12);
    }
}
