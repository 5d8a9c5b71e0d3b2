//! Contact of the net with itself: cables against cables, bullets against both.
//!
//! Two strands (a cable is a segment with the radius of its cable, a bullet a ball) touch at their
//! closest points p and q, at shares s and t of the segments:
//!
//!   gap = n · (p − q) − r₁ − r₂,  n = (p − q) / |p − q|,
//!
//! and a row of [`super::gauss_seidel`] keeps n · (ṗ − q̇) from closing it: weights 1 − s, s, −(1 − t), −t.
//! The impulse acts along p − q, so linear and angular momentum of the net are kept exactly. What
//! a knot ties together is no pair.
//!
//! **Detection.** A pair with gap g is left alone until any two knots can have come g nearer; a calendar of all
//! pairs by when they are due is the whole of detection. On the Cubesat's net of 224 strands it takes less than
//! a tenth of the time of the engine's narrow phase, which looked at every near pair anew.
//!
//! **No passing.** A row acts before the strands touch, when the gap would close within the
//! (sub-)step, so thin strands do not step over each other. Where cables press them into each other
//! all the same, the normal keeps its side: p − q that has turned by more than 90 degrees since it was
//! last looked at has gone through the other strand. (It cannot have
//! turned so far without: the least distance of two convex bodies keeps its side while they move by
//! less than it.) There it is held, lest it goes further, and may come back, but nothing pushes it: where knots have gone through each
//! other, of the many pairs of their cables some have and some have not, and ask for opposite pushes, which nothing
//! satisfies and every pass makes larger. And those that overlap share the power that pushes out, for in a wad they are dozens.
//! Created of the energy at hand around the free Cubesat, at most, and members above 1e-3:
//!
//! | pair, fold | pushed back, each with its power | held, a shared power | and solved together |
//! |---|---|---|---|
//! | joints+rapier, 0.1 | 3e-2, 10 of 48 | 2e-4, 0 of 48 | 2e-4, 0 of 16 |
//! | joints+rapier, 0.9 | 1.1e-2, 13 of 48 | 2.9e-3, 4 of 48 | 7.9e-4, 0 of 16 |
//! | explicit+impulse, 0.1 | 1e-2, 7 of 16 | 1.3e-3, 3 of 32 | 3.6e-4, 0 of 64 |
//! | explicit+impulse, 0.9 | 5.7e-3, 3 of 16 | 6.4e-3, 4 of 32 | 2.4e-4, 0 of 64 |
//! | explicit+penalty, 0.1 | 1.9e-3, 1 of 16 | 3.4e-3, 2 of 16 | 2.7e-6, 0 of 16 |
//!
//! (Joints with what parts coming back as fast, see [`OfParting`], from the second column on. Together: with knots and cables on the target,
//! where all bounce alike, and after the forces of a penalty; explicit strands then come 0.1 mm into each other in the middle of 64, 0.3 mm at most, for 2 mm.)
//!
//! **In turn with the engine** rows are solved with those that it will have ([`super::lookahead`]): of cables, and of knots that
//! the target holds. What they leave is looked at when the engine has moved the net, and where a pair is about to go through, that
//! part of the step is done again with the impulses that it lacked. Pairs that went through each other in 16 members of 3 s each:
//!
//! | scene | cables ahead, 12 passes | and held knots | and 200 passes | and done again |
//! |---|---|---|---|---|
//! | `cubesat-free`, fold 0.1 | 3202 | 220 | 2 | 0 |
//! | `cube-fixed` | 1229 | 153 | 12 | 0 |
//! | `cubesat-free`, fold 0.9 | 483 | 99 | 2 | 0 |
//! | `cubesat-spin-x-2.0`, friction 0.3 | 265 | 75 | 66 | 9 |
//!
//! in 1, 1, 1.4 and 1.3 times the time (rows rest in the last), with the same energy created (2e-4 in the middle; 4.2e-3 and 8e-4 at most). None did where strands
//! are solved together with knots and cables (explicit cables). Bounces beyond a restitution of 0.5 are left at the first column: with
//! full ones the last made 9e3 of the energy at hand, with 0.9 2.1e-2 in one of 36.
//!
//! A step is taken in so many parts that no pair which nearly touches comes farther in one than it is thick. Heavy bullets shot at 8 m/s, a strand's
//! thickness in an eighth of a step, at a cube that is held (7 x 6 and 6 x 8 meshes, 0.2 kg, 1 and 0.5 mm, 8 members of 1 s each) drew 1251 and 246 pairs
//! through each other without, 147 and 12 so; a panel's net with whole cables 12 and 4, the Cubesat with a `cinch` and whole cables 9 and 7 in six members
//! each; with full bounces, left at the first column, eight free Cubesats 330 and 96. Of half as long parts 58 and 32 of the first two were left, in up to 1.7
//! times the time.
//!
//! Strands that overlap in the folded net are left alone until they have parted once.
//!
//! Frictionless, and strands have no bending: nearly parallel ones touch at one place at a time. Memory
//! is 16 bytes for every two strands, and as much again where the calendar's days have grown.

use nalgebra::Vector3;
use parry3d::math::Vector as ParryVector;
use parry3d::query::details::closest_points_segment_segment_with_locations_nD as closest_points;

use super::InverseInertia;
use super::gauss_seidel::{self, IterationLimits};
use super::lookahead::Lookahead;
use super::row::{
    ContactRow, JacobianWeights, MarkedKnots, NetMotion, OfParting, Parting, PushOut, RowSource,
};
use super::solver::{ContactSolver, NormalSolver};
use crate::net::Net;
use crate::state::{Body, EffectWork, Knots, State, TARGET};

/// A pair is near while its gap is less than so many ways that two knots can come nearer in a
/// (sub-)step: contacts can add to their speeds.
const NEAR: f64 = 2.0;

/// Share of the distance of two touching middle lines up to which the engine may press strands into each other in a part of a step.
const LEEWAY: f64 = 0.5;

/// Restitution beyond which strands in turn with the engine are solved in few passes, each by itself.
pub const BOUNCY: f64 = 0.5;

/// Days of the calendar of distant pairs: what is due later is put off, and looked at once in so many.
const DAYS: usize = 1024;

/// Density of steel [kg/m^3].
const STEEL: f64 = 7850.0;

/// Radius of a steel ball of the bullets' mass [m].
pub fn bullet_radius(net: &Net) -> f64 {
    let mass = net.bullets.iter().map(|&bullet| net.mass[bullet]).fold(0.0, f64::max);
    (0.75 * mass / (std::f64::consts::PI * STEEL)).cbrt()
}

/// Memory that the strands of `net` take when they are watched [bytes].
pub fn memory(net: &Net) -> f64 {
    let n_strands = (net.cables.len() + net.bullets.len()) as f64;
    0.5 * n_strands * n_strands * size_of::<DistantPair>() as f64
}

/// The strands of a net, and their contacts.
pub struct StrandContacts {
    strands: Vec<Strand>,
    solver: ContactSolver,
    /// Of the target in the body frame; none without one.
    target: Option<InverseInertia>,
    parting: Parting,
    /// How much nearer any two knots can have come since the start [m].
    travelled: f64,
    distant: Calendar,
    /// Distant pairs that are due; kept for its memory.
    due: Vec<DistantPair>,
    near: Vec<StrandPair>,
    /// Rows of the pairs that act in this sub-step; kept for its memory.
    rows: Vec<ContactRow>,
    /// Pairs that overlapped and were pressed together in the last.
    n_deep: usize,
    /// Places of the pairs of the rows among the near ones.
    pairs_of: Vec<usize>,
    /// Where near pairs were when rows were last found, in turn with the engine.
    places: Vec<ContactRow>,
    /// Impulses within the step, a knot each [N s], where cables are moved after they were given.
    impulses: Vec<Vector3<f64>>,
    /// Work of the others on the net within the step, sub-step by sub-step [J].
    work: f64,
    /// Contacts with an impulse within the step, counted in every sub-step.
    n_acted: u64,
    /// Deepest overlap since the start [m].
    pub deepest: f64,
    /// Pairs that have gone through each other since the start; again where they had parted.
    pub n_through: u64,
}

/// A cable, or the ball of a bullet.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Strand {
    /// End knots; a bullet's twice.
    ends: [usize; 2],
    radius: f64,
}

/// Two strands far from each other.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DistantPair {
    /// When to look again, as a distance travelled [m].
    due: f64,
    strands: [u32; 2],
}

/// Distant pairs by when they are due: a queue of days in a ring, each unordered. To take out the next that is due of a
/// heap of all pairs was a fifth of a run.
struct Calendar {
    /// Length of a day [m].
    day: f64,
    /// From the day that `today` is, round to the day before it.
    days: Vec<Vec<DistantPair>>,
    /// Days since the start.
    today: usize,
    /// Pairs of a day that is looked at; kept for its memory.
    page: Vec<DistantPair>,
}

impl Calendar {
    fn new(day: f64) -> Calendar {
        Calendar { day, days: vec![Vec::new(); DAYS], today: 0, page: Vec::new() }
    }

    fn push(&mut self, pair: DistantPair) {
        let last = self.today.saturating_add(DAYS - 1);
        let day = ((pair.due / self.day) as usize).clamp(self.today, last);
        self.days[day % DAYS].push(pair);
    }

    /// Moves those due up to `until` [m] to `due`, in no order.
    fn take_due(&mut self, until: f64, due: &mut Vec<DistantPair>) {
        let from = self.today;
        self.today = from.max((until / self.day) as usize);
        for day in from..=self.today.min(from.saturating_add(DAYS - 1)) {
            std::mem::swap(&mut self.page, &mut self.days[day % DAYS]);
            for index in 0..self.page.len() {
                let pair = self.page[index];
                if pair.due <= until {
                    due.push(pair);
                } else {
                    self.push(pair);
                }
            }
            self.page.clear();
        }
    }

    fn len(&self) -> usize {
        self.days.iter().map(Vec::len).sum()
    }
}

/// Two strands near each other.
#[derive(Clone, Copy, Debug)]
struct StrandPair {
    strands: [u32; 2],
    /// From the second to the first when last looked at; 0 before.
    normal: Vector3<f64>,
    /// Whether it overlaps since the net was folded.
    folded_into: bool,
    /// Whether it has gone through each other, and has not parted since.
    is_through: bool,
    /// What it was pressed together with in the (sub-)step before [N].
    force: f64,
}

/// A pair as it lies now.
struct ClosestPoints {
    shares: [f64; 2],
    normal: Vector3<f64>,
    gap: f64,
}

impl ClosestPoints {
    /// `normal`: that of the last look, 0 for a pair that was apart.
    fn of(strands: [&Strand; 2], normal: &Vector3<f64>, knots: &Knots) -> ClosestPoints {
        let end = |side: usize, end: usize| &knots.position[strands[side].ends[end]];
        let (a, b, c, d) = (end(0, 0), end(0, 1), end(1, 0), end(1, 1));
        let (on_one, on_other) = closest_points((&parrys(a), &parrys(b)), (&parrys(c), &parrys(d)));
        let [s, t] = [on_one.barycentric_coordinates()[1], on_other.barycentric_coordinates()[1]];
        let apart = (a + s * (b - a)) - (c + t * (d - c));
        let shares = [s, t];
        let (distance, touching) = (apart.norm(), strands[0].radius + strands[1].radius);
        if distance < 1e-6 * touching {
            return ClosestPoints { shares, normal: *normal, gap: -touching };
        }
        let side = if apart.dot(normal) < 0.0 { -1.0 } else { 1.0 };
        ClosestPoints { shares, normal: apart * (side / distance), gap: side * distance - touching }
    }
}

impl StrandContacts {
    /// Watches `net`, whose bullets have `bullet_radius` [m]; `in_turn`: where the engine moves its cables. The `target`, where there
    /// is one, holds knots.
    pub fn new(
        net: &Net,
        bullet_radius: f64,
        restitution: f64,
        in_turn: bool,
        target: Option<InverseInertia>,
    ) -> StrandContacts {
        let cable = |index: usize| {
            let cable = &net.cables[index];
            Strand { ends: [cable.a, cable.b], radius: net.cable_radius(index) }
        };
        let bullets = net.bullets.iter().map(|&knot| Strand { ends: [knot; 2], radius: bullet_radius });
        let strands: Vec<Strand> = (0..net.cables.len()).map(cable).chain(bullets).collect();
        let folded = Knots { position: net.folded.clone(), velocity: Vec::new() };
        let thinnest = strands.iter().map(|strand| strand.radius).fold(f64::INFINITY, f64::min);
        let (mut distant, mut near) = (Calendar::new(thinnest), Vec::new());
        for (i, one) in strands.iter().enumerate() {
            for (j, other) in strands.iter().enumerate().skip(i + 1) {
                if one.ends.iter().any(|knot| other.ends.contains(knot)) {
                    continue; // tied together
                }
                let ClosestPoints { normal, gap, .. } =
                    ClosestPoints::of([one, other], &Vector3::zeros(), &folded);
                let strands = [i as u32, j as u32];
                if gap < 0.0 {
                    near.push(StrandPair {
                        strands,
                        normal,
                        folded_into: true,
                        is_through: false,
                        force: 0.0,
                    });
                } else {
                    distant.push(DistantPair { due: gap, strands });
                }
            }
        }
        let is_bouncy = restitution > BOUNCY;
        let limits =
            if is_bouncy { IterationLimits::AHEAD_OF_BOUNCES } else { IterationLimits::AHEAD_OF_STRANDS };
        let lookahead = in_turn.then(|| Lookahead::new(net, limits));
        let push_out = PushOut::of_cables(in_turn, net.launch_energy());
        // In turn, a step is ten times as long, and the speed that of a cable's jerk.
        let of_parting = if in_turn { OfParting::ComesBackAsFast } else { OfParting::ComesBack };
        let parting = Parting { restitution, push_out, in_turn, of_parting };
        let normal = NormalSolver::GaussSeidel { lookahead };
        StrandContacts {
            strands,
            solver: ContactSolver { normal, friction: None, coupled: true },
            target: target.filter(|_| !is_bouncy),
            parting,
            travelled: 0.0,
            distant,
            due: Vec::new(),
            near,
            rows: Vec::new(),
            n_deep: 0,
            pairs_of: Vec::new(),
            places: Vec::new(),
            impulses: vec![Vector3::zeros(); if in_turn { net.n_knots() } else { 0 }],
            work: 0.0,
            n_acted: 0,
            deepest: 0.0,
            n_through: 0,
        }
    }

    /// Solves the contacts of a (sub-)step of `step` seconds: changes velocities of knots, and marks them.
    pub fn solve(&mut self, net: &mut MarkedKnots<'_>, bodies: &[Body], step: f64) {
        // No row of strands names the target, but those that the engine will have do.
        let of_target = self.target.map(|target| (bodies[TARGET], target));
        let (mut body, target) = of_target.unwrap_or_else(|| (Body::at_rest(), InverseInertia::default()));
        let mut rows = std::mem::take(&mut self.rows);
        rows.clear();
        self.add_rows(net, &body, step, false, &mut rows);
        if !rows.is_empty() {
            let target = target.at(&body);
            self.solver.solve(&mut rows, net, &mut body, &target, step);
            self.take_rows(&rows, net, [&body; 2], step);
        }
        self.rows = rows;
    }

    /// Before a step from `state`: sees what the engine holds.
    pub fn update(&mut self, state: &State) {
        if let (NormalSolver::GaussSeidel { lookahead: Some(lookahead) }, Some(_)) =
            (&mut self.solver.normal, self.target)
        {
            lookahead.update(state, &state.bodies[TARGET]);
        }
    }

    /// Books the impulses of `rows`, and marks their knots.
    fn gave(&mut self, rows: &[ContactRow], net: &mut MarkedKnots<'_>) {
        for row in rows.iter().filter(|row| row.impulse > 0.0) {
            self.n_acted += 1;
            for &(knot, weight) in row.weights.all() {
                let impulse = weight * row.impulse * row.normal;
                if self.parting.in_turn {
                    self.impulses[knot] += impulse;
                } else {
                    self.work += 0.5 * impulse.dot(&(net.velocity_before(knot) + net.velocity(knot)));
                }
                net.mark(knot);
            }
        }
    }

    /// Takes up the pairs that may be `near` [m] or nearer.
    fn approach(&mut self, knots: &Knots, near: f64) {
        let mut due = std::mem::take(&mut self.due);
        self.distant.take_due(self.travelled + near, &mut due);
        due.retain(|&DistantPair { strands, .. }| {
            let gap = self.closest(strands, &Vector3::zeros(), knots).gap;
            let is_distant = gap > near;
            if is_distant {
                self.distant.push(DistantPair { due: self.travelled + gap, strands });
            }
            !is_distant
        });
        // Rows are solved in the order of the near pairs.
        due.sort_unstable_by(|one, other| {
            one.due.total_cmp(&other.due).then(one.strands.cmp(&other.strands))
        });
        for DistantPair { strands, .. } in due.drain(..) {
            let normal = self.closest(strands, &Vector3::zeros(), knots).normal;
            self.near.push(StrandPair { strands, normal, folded_into: false, is_through: false, force: 0.0 });
        }
        self.due = due;
    }

    /// Adds rows of the near pairs that would touch within the step; those farther than `near` [m] become distant.
    fn find_rows(&mut self, net: &MarkedKnots<'_>, step: f64, near: f64, rows: &mut Vec<ContactRow>) {
        let push_out = self.parting.push_out.shared_by(std::mem::take(&mut self.n_deep));
        self.pairs_of.clear();
        self.places.clear();
        let mut kept = 0;
        for index in 0..self.near.len() {
            let mut pair = self.near[index];
            let place = self.closest(pair.strands, &pair.normal, net.knots);
            if place.gap > near {
                let due = self.travelled + place.gap;
                self.distant.push(DistantPair { due, strands: pair.strands });
                continue;
            }
            pair.normal = place.normal;
            pair.folded_into &= place.gap < 0.0;
            pair.is_through &= place.gap < 0.0;
            if let Some(row) = self.row(&pair, &place, push_out, net, step) {
                rows.push(row);
                self.pairs_of.push(kept);
                self.deepest = self.deepest.max(-place.gap);
                let is_through = self.is_through(&pair, place.gap);
                self.n_through += u64::from(is_through && !pair.is_through);
                pair.is_through |= is_through;
            }
            if self.parting.in_turn && !pair.folded_into && !pair.is_through {
                let weights = self.weights(&pair, &place);
                let leeway = LEEWAY * self.touching(&pair);
                self.places.push(ContactRow {
                    gap: place.gap + leeway,
                    ..ContactRow::held(weights, weights.inverse_mass(net), place.normal, None)
                });
            }
            pair.force = 0.0;
            self.near[kept] = pair;
            kept += 1;
        }
        self.near.truncate(kept);
    }

    /// Whether a pair with this `gap` [m] has its middle lines on the wrong sides of each other.
    fn is_through(&self, pair: &StrandPair, gap: f64) -> bool {
        gap < -self.touching(pair)
    }

    /// Distance of the middle lines of a pair that touches [m].
    fn touching(&self, pair: &StrandPair) -> f64 {
        pair.strands.iter().map(|&strand| self.strands[strand as usize].radius).sum()
    }

    fn weights(&self, pair: &StrandPair, place: &ClosestPoints) -> JacobianWeights {
        let [[a, b], [c, d]] = pair.strands.map(|strand| self.strands[strand as usize].ends);
        let [s, t] = place.shares;
        JacobianWeights::Four([(a, 1.0 - s), (b, s), (c, t - 1.0), (d, -t)])
    }

    fn closest(&self, strands: [u32; 2], normal: &Vector3<f64>, knots: &Knots) -> ClosestPoints {
        ClosestPoints::of(strands.map(|strand| &self.strands[strand as usize]), normal, knots)
    }

    /// The row of a pair, if it would touch; `push_out`: how overlaps are undone.
    fn row(
        &self,
        pair: &StrandPair,
        place: &ClosestPoints,
        push_out: PushOut,
        net: &MarkedKnots<'_>,
        step: f64,
    ) -> Option<ContactRow> {
        let ClosestPoints { normal, gap, .. } = *place;
        let weights = self.weights(pair, place);
        let velocity = weights.sum(|knot| net.velocity(knot));
        let speed = normal.dot(&velocity);
        if pair.folded_into || (gap >= 0.0 && gap + step * speed >= 0.0) {
            return None;
        }
        let speed_before = normal.dot(&weights.sum(|knot| net.velocity_before(knot)));
        // The thinner strand's: one that went through another would be shot off.
        let [one, other] = pair.strands.map(|strand| self.strands[strand as usize].radius);
        let radius = one.min(other);
        let push_out = if self.is_through(pair, gap) { PushOut::Speed(0.0) } else { push_out };
        let parting = Parting { push_out, ..self.parting };
        // From nothing: in a wad the impulses of the step before are no guess, and passes that end
        // before they have taken a bad one back leave its energy behind.
        Some(ContactRow {
            radius,
            gap,
            velocity,
            speed,
            wanted_speed: parting.wanted_speed(gap, [speed_before, speed], radius, pair.force, step),
            bounces: parting.bounces(gap, [speed_before, speed], radius),
            ..ContactRow::held(weights, weights.inverse_mass(net), normal, None)
        })
    }

    /// Forgets what it did since it was last asked: the step is done again.
    pub fn forget(&mut self) {
        if std::mem::take(&mut self.n_acted) > 0 {
            self.impulses.fill(Vector3::zeros());
        }
    }

    /// What it did since the last time, within a step from `before` to `after`.
    ///
    /// Work on the knots: Σ J · (v⁻ + v⁺) / 2 over their impulses J, exactly its share in the change
    /// of their energy, sub-step by sub-step where nothing moves them after.
    pub fn account(&mut self, before: &Knots, after: &Knots) -> EffectWork {
        let count = std::mem::take(&mut self.n_acted);
        if count == 0 {
            return EffectWork::default();
        }
        let mut work = std::mem::take(&mut self.work);
        for (knot, impulse) in self.impulses.iter_mut().enumerate() {
            let impulse = std::mem::take(impulse);
            work += 0.5 * impulse.dot(&(before.velocity[knot] + after.velocity[knot]));
        }
        EffectWork { work, on_knots: work, count, ..EffectWork::default() }
    }

    /// Number of pairs.
    pub fn n_pairs(&self) -> usize {
        self.distant.len() + self.near.len()
    }
}

impl RowSource for StrandContacts {
    fn add_rows(&mut self, net: &MarkedKnots<'_>, _: &Body, step: f64, _: bool, rows: &mut Vec<ContactRow>) {
        let way = step * closing_speed(net.knots);
        self.approach(net.knots, NEAR * way);
        self.find_rows(net, step, NEAR * way, rows);
        self.travelled += way;
    }

    fn take_rows(&mut self, rows: &[ContactRow], net: &mut MarkedKnots<'_>, _: [&Body; 2], step: f64) {
        for (row, &pair) in rows.iter().zip(&self.pairs_of) {
            self.near[pair].force = row.impulse / step;
            self.n_deep += usize::from(row.gap < 0.0 && row.impulse > 0.0);
        }
        self.gave(rows, net);
    }

    fn touches_target(&self) -> bool {
        false
    }

    /// No pair that nearly touches comes farther than it is thick, along its strands or across.
    fn parts(&self, knots: &Knots, step: f64) -> u32 {
        let watched = self.near.iter().filter(|pair| !pair.folded_into && !pair.is_through);
        let way = |pair: &StrandPair| {
            let (place, thick) = (self.closest(pair.strands, &pair.normal, knots), self.touching(pair));
            let velocity = self.weights(pair, &place).sum(|knot| knots.velocity[knot]);
            if place.gap > thick { 0.0 } else { step * velocity.norm() / thick }
        };
        watched.map(way).fold(1.0, f64::max).ceil() as u32
    }

    /// What pairs lacked that went too far into each other.
    fn correct(&mut self, net: &mut MarkedKnots<'_>, step: f64) {
        let mut rows = std::mem::take(&mut self.rows);
        rows.clear();
        for place in &self.places {
            let speed = place.normal.dot(&place.weights.sum(|knot| net.velocity(knot)));
            if place.gap + step * speed < 0.0 {
                rows.push(ContactRow { wanted_speed: -place.gap.max(0.0) / step, ..*place });
            }
        }
        if !rows.is_empty() {
            let target = InverseInertia::default();
            let limits = IterationLimits::OF_STRANDS;
            gauss_seidel::solve(&mut rows, None, net, &mut Body::at_rest(), &target, limits);
            self.gave(&rows, net);
        }
        self.rows = rows;
    }
}

/// Largest speed at which any two knots can come nearer [m/s].
fn closing_speed(knots: &Knots) -> f64 {
    let mean = knots.velocity.iter().sum::<Vector3<f64>>() / knots.velocity.len() as f64;
    2.0 * knots.velocity.iter().map(|v| (v - mean).norm_squared()).fold(0.0, f64::max).sqrt()
}

#[inline]
fn parrys(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Whatever a day is, and however many pass at once, exactly what is due is taken, and nothing is lost.
    #[test]
    fn a_calendar_gives_what_is_due_and_keeps_the_rest() {
        for (day, pace) in [(1e-3, 1e-4), (1e-3, 5e-2), (1e-5, 1.0), (10.0, 1e-2)] {
            let mut random = ChaCha8Rng::seed_from_u64(1);
            let (mut calendar, mut waiting) = (Calendar::new(day), Vec::new());
            let (mut until, mut due) = (0.0, Vec::new());
            for n in 0..2000 {
                // Some are due at once, some after the last day.
                let reach = [2.0 * pace, 3.0 * day * DAYS as f64, 0.0][n % 3];
                let pair = DistantPair {
                    due: until + reach * random.random_range(0.0..1.0),
                    strands: [n as u32, 0],
                };
                calendar.push(pair);
                waiting.push(pair);
                until += pace * random.random_range(0.0..1.0);
                due.clear();
                calendar.take_due(until, &mut due);
                let (mut expected, rest): (Vec<DistantPair>, Vec<DistantPair>) =
                    waiting.iter().partition(|pair| pair.due <= until);
                due.sort_unstable_by_key(|pair| pair.strands);
                expected.sort_unstable_by_key(|pair| pair.strands);
                assert_eq!(due, expected);
                assert_eq!(calendar.len(), rest.len());
                waiting = rest;
            }
        }
    }
}
