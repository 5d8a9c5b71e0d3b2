//! Contacts of the net with the target: found by the engine's narrow phase, carried as planes, solved as
//! rows. The same for knots and for whole cables.
//!
//! ```text
//! DetectionSchedule -> narrow phase -> ContactPlane -> ContactRow -> ContactSolver -> Contact
//! (when)               (knots, cables)  (moves with     (sub-step)    (impulses)       (record of the step)
//!                                        the target)
//! ```

use super::InverseInertia;
use super::cable_planes::CablePlanes;
use super::plane::{ContactPlane, RowRules, SurfaceMotion};
use super::row::{ContactRow, MarkedKnots, NetMotion, Parting, RowSource};
use super::schedule::{Detection, DetectionSchedule, Stale};
use super::solver::{ContactSolver, NormalSolver};
use crate::net::Net;
use crate::solver::{JOINTS_STEP, Precision};
use crate::state::{Body, Contact, Knots, State, TARGET};
use crate::target::Target;
use crate::world::Detector;
use nalgebra::Vector3;

/// Two faces that a knot is between make a corner that holds it where the cosine of their normals is smaller: others are
/// one face in two parts, or the sides of a gap.
const CORNER: f64 = 0.95;

/// When knots are looked at again, and when cables are. A cable has other places that may touch than those known, so it is looked at when its
/// ends have moved less: before the next edge of a box was looked for, cables came 0.5 mm into a cube that is held, in the middle of 64 members, with 0.2 of the
/// margin, 0.8 mm with 0.35 and 1.3 mm with a half, in 0.98 of the time.
const KNOTS_STALE: Stale = Stale { holds: 0.5, renews: 0.25 };
pub(super) const CABLES_STALE: Stale = Stale { holds: 0.2, renews: 0.5 };

/// Share of its radius that a knot may be drawn in within a step of the engine's own, and the less in a part of it, before what holds it out is asked
/// for more. As much in each part, knots sank in by up to 0.8 of it.
const KNOTS_LACKING: f64 = 0.1;

/// The same of a place on a cable, which comes out within 10 ms and no faster: what is drawn in step by step adds up. Around a free Cubesat cables
/// were 0.30 mm in, in the middle of 16 members under `joints+rapier`, and 0.47 mm at most where none was asked for more, 0.30 and 0.41
/// with a share of 0.1, 0.14 and 0.21 with 0.02, and no less with 0.005.
const CABLES_LACKING: f64 = 0.02;

/// What of the net is to be kept from the target.
pub enum Feature {
    /// Its knots.
    Knots {
        /// Finds them.
        detector: Detector,
        /// Of each [m].
        radius: Vec<f64>,
    },
    /// Its cables.
    Cables(CablePlanes),
}

/// Knots or cables near the target, and how their contacts are solved.
pub struct SurfaceContacts {
    feature: Feature,
    solver: ContactSolver,
    rules: RowRules,
    /// In the body frame.
    inverse_inertia: InverseInertia,
    schedule: DetectionSchedule,
    planes: Vec<ContactPlane>,
    /// Those that may be touched within the step.
    awake: Vec<usize>,
    /// Rows of the sub-step, and their planes; kept for their memory.
    rows: Vec<ContactRow>,
    planes_of: Vec<usize>,
    /// What forces gave in the last sub-step, in which others act after them: rows of effects, which answer what forces did.
    unsettled: Vec<Unsettled>,
    /// Length of the last (sub-)step [s].
    step: f64,
    /// By what share of it velocities at the end of a step are behind positions [-].
    lag: f64,
    /// Whether they were answered again, so that planes hold what they lacked.
    was_again: bool,
    /// Times the engine looked for contacts.
    pub n_detections: u64,
}

/// What a force gave in a sub-step whose end it does not know yet.
struct Unsettled {
    row: ContactRow,
    plane: usize,
    /// Velocity of the net there at its start [m/s].
    start: Vector3<f64>,
}

impl Feature {
    /// The knots of `net` around `target`, found in the engine's `precision`.
    pub fn knots(net: &Net, target: &Target, precision: Precision) -> Feature {
        let detector = Detector::new(net, target, precision);
        Feature::Knots { detector, radius: net.radius.clone() }
    }

    /// The largest radius of it [m].
    fn thickest(&self) -> f64 {
        let radii = match self {
            Feature::Knots { radius, .. } => radius,
            Feature::Cables(cables) => cables.radii(),
        };
        radii.iter().copied().fold(0.0, f64::max)
    }

    /// Number of colliders of its detector.
    fn n_colliders(&self) -> usize {
        match self {
            Feature::Knots { detector, .. } => detector.n_colliders(),
            Feature::Cables(cables) => cables.n_colliders(),
        }
    }
}

impl SurfaceContacts {
    /// Contacts of a `feature` of the net with `target`, detected from the distance `margin` [m].
    pub fn new(
        feature: Feature,
        target: &Target,
        margin: f64,
        solver: ContactSolver,
        parting: Parting,
        drawn_in: Option<f64>,
    ) -> SurfaceContacts {
        let stale = match feature {
            Feature::Knots { .. } => KNOTS_STALE,
            Feature::Cables(_) => CABLES_STALE,
        };
        let around = target.bounding_radius + feature.thickest();
        SurfaceContacts {
            feature,
            solver,
            rules: RowRules { parting, drawn_in },
            inverse_inertia: InverseInertia::of(&target.model()),
            schedule: DetectionSchedule::new(margin, &target.parts, around, stale),
            planes: Vec::new(),
            awake: Vec::new(),
            rows: Vec::new(),
            planes_of: Vec::new(),
            unsettled: Vec::new(),
            step: f64::MIN_POSITIVE,
            lag: 0.5,
            was_again: false,
            n_detections: 0,
        }
    }

    /// The same of a net whose velocities at the end of a step are those of its positions.
    #[must_use]
    pub fn in_time(self) -> SurfaceContacts {
        SurfaceContacts { lag: 0.0, ..self }
    }

    /// Knots with a plane, those with several of them again.
    pub fn watched(&self) -> impl Iterator<Item = usize> {
        self.planes.iter().map(|plane| plane.record.knot)
    }

    /// Knots that bear the contacts that may come within the step, those of several again.
    pub fn bearers(&self) -> impl Iterator<Item = usize> {
        self.awake.iter().flat_map(|&plane| self.planes[plane].record.bearers()).map(|(knot, _)| knot)
    }

    /// Before a step of `step` seconds from `state`: finds the planes anew where they are stale.
    pub fn update(&mut self, state: &State, body: &Body, step: f64) {
        if let NormalSolver::GaussSeidel { lookahead: Some(lookahead), .. } = &mut self.solver.normal {
            lookahead.update(state, body);
        }
        match self.schedule.update(&state.knots, body, step) {
            Detection::Separated => self.planes.clear(),
            Detection::Cached => {}
            Detection::Stale(margin) => self.detect(state, body, margin),
        }
        self.wake(&state.knots, body, step);
    }

    /// Forgets the step before, and finds the planes that may be touched within one of `step` seconds. Most are too far for
    /// it, and have no part in its sub-steps.
    fn wake(&mut self, knots: &Knots, body: &Body, step: f64) {
        self.awake.clear();
        let turn = body.attitude.to_rotation_matrix();
        let reach = self.schedule.thrown().max(2.0 * step * self.rules.drawn_in.unwrap_or(0.0));
        for (index, plane) in self.planes.iter_mut().enumerate() {
            plane.begin_step();
            if !plane.is_beyond(reach, knots, body, &turn) {
                self.awake.push(index);
            }
        }
    }

    /// Forgets what was answered within the step, which is done again.
    pub fn forget(&mut self) {
        self.unsettled.clear();
        for &plane in &self.awake {
            self.planes[plane].begin_step();
        }
    }

    fn detect(&mut self, state: &State, body: &Body, margin: f64) {
        let (planes, schedule) = (&mut self.planes, &mut self.schedule);
        self.n_detections += 1;
        match &mut self.feature {
            Feature::Knots { detector, radius } => {
                let renewed = schedule.renew(&state.knots, body, margin, |knot| radius[knot]);
                let found = detector.detect(renewed, margin);
                planes.clear();
                for contact in found {
                    let (knot, normal) = (contact.knot, contact.normal);
                    schedule.found(knot, normal);
                    let height = normal.dot(&schedule.at(knot)) - contact.gap;
                    planes.push(ContactPlane::new(contact, normal, height, radius[knot], Vector3::zeros()));
                }
            }
            Feature::Cables(cables) => {
                let renewed =
                    schedule.renew(&state.knots, body, margin, |knot| cables.reach(&state.knots, knot));
                cables.detect(renewed, &state.knots, body, margin, planes);
                for (knot, _) in planes.iter().flat_map(|plane| plane.record.bearers()) {
                    schedule.found_cable(knot);
                }
            }
        }
    }

    /// Solves the contacts of a (sub-)step of `step` seconds: changes velocities of `net` and `body`, and marks
    /// the knots.
    pub fn solve(&mut self, net: &mut impl NetMotion, body: &mut Body, step: f64) {
        self.settle(|knot| net.velocity_before(knot));
        self.prepare(net, body, step, false);
        if !self.rows.is_empty() {
            let mut rows = std::mem::take(&mut self.rows);
            let (target, before) = (self.inverse_inertia.at(body), *body);
            self.solver.solve(&mut rows, net, body, &target, step);
            self.finish(&rows, net, [&before, body], step);
            self.rows = rows;
        }
    }

    /// Whether nothing may be touched in the (sub-)steps of this step, and nothing was in the last.
    pub fn is_asleep(&self) -> bool {
        self.awake.is_empty() && self.rows.is_empty()
    }

    /// Whether net and target are apart.
    pub fn is_separated(&self) -> bool {
        self.schedule.is_separated()
    }

    /// Rows of a (sub-)step of `step` seconds, with what they begin with; `again` for the same one, with what they lacked.
    fn prepare(&mut self, net: &impl NetMotion, body: &Body, step: f64, again: bool) {
        self.rows.clear();
        if self.awake.is_empty() {
            return;
        }
        // What a longer step took is too much of a guess for a shorter, and too few passes take it back.
        let last = std::mem::replace(&mut self.step, step);
        let share = (step / last).min(1.0);
        let was_again = std::mem::replace(&mut self.was_again, again);
        if again || was_again {
            for &plane in &self.awake {
                let plane = &mut self.planes[plane];
                plane.given = if again { plane.impulse } else { 0.0 };
                plane.lacking = if again { plane.lacking } else { 0.0 };
            }
        }
        self.find_rows(net, body, [last, step]);
        for row in &mut self.rows {
            row.impulse = if again { 0.0 } else { share * row.impulse };
        }
    }

    /// Takes the impulses of `rows`, which are its own, over to its planes, while the body went from `before` to `after`.
    fn finish(
        &mut self,
        rows: &[ContactRow],
        net: &mut impl NetMotion,
        [before, after]: [&Body; 2],
        step: f64,
    ) {
        // Where the engine moves the cables after this, velocities are not yet those of the end.
        let acts_last = !self.rules.parting.in_turn;
        let (is_force, surface) = (self.is_force(), SurfaceMotion::between(before, after));
        for (row, &index) in rows.iter().zip(&self.planes_of) {
            let plane = &mut self.planes[index];
            plane.impulse = plane.given + row.impulse;
            if row.impulse == 0.0 && row.friction == Vector3::zeros() {
                continue;
            }
            for &(knot, _) in row.weights.all() {
                net.mark(knot);
            }
            plane.add(row, &before.position, &surface);
            if is_force {
                plane.record.force = plane.record.force.max(row.impulse / step);
            }
            if !acts_last {
                continue;
            }
            if is_force {
                let start = row.weights.sum(|knot| net.velocity_before(knot));
                self.unsettled.push(Unsettled { row: *row, plane: index, start });
            } else {
                let mean = |knot| 0.5 * (net.velocity_before(knot) + net.velocity(knot));
                plane.weigh(row, &row.weights.sum(mean));
            }
        }
    }

    /// Books the work of forces of the last sub-step, which ended with these velocities of knots [m/s].
    fn settle(&mut self, velocity: impl Fn(usize) -> Vector3<f64>) {
        for Unsettled { row, plane, start } in self.unsettled.drain(..) {
            self.planes[plane].weigh(&row, &(0.5 * (start + row.weights.sum(&velocity))));
        }
    }

    /// Whether what it keeps out bounces.
    pub fn bounce(&self) -> bool {
        self.rules.parting.restitution > 0.0
    }

    /// Whether overlaps are answered by a force.
    pub fn is_force(&self) -> bool {
        self.solver.resolved_speed().is_some()
    }

    /// Rows of the planes that may be crossed within the second of two (sub-)steps.
    fn find_rows(&mut self, net: &impl NetMotion, body: &Body, [last, step]: [f64; 2]) {
        let turn = body.attitude.to_rotation_matrix();
        let resolved = self.solver.resolved_speed();
        // Two forces would be stiffer than the step was chosen for.
        let holds_both = resolved.is_none();
        let (rows, planes_of) = (&mut self.rows, &mut self.planes_of);
        rows.clear();
        planes_of.clear();
        for &index in &self.awake {
            let plane = &mut self.planes[index];
            if let Feature::Cables(cables) = &self.feature {
                let is_clear = self.rules.drawn_in.is_none() && plane.is_clear(net, body, &turn, step);
                if !is_clear {
                    cables.follow_ridge(plane, net, body, &turn, step);
                }
                if plane.waits {
                    plane.record.gap = f64::INFINITY;
                }
                if is_clear || plane.waits {
                    continue;
                }
            }
            let Some(place) = plane.predict(net, body, &turn, step, self.rules.drawn_in) else { continue };
            if self.solver.holds_against(plane) {
                plane.impulse = 0.0;
                continue;
            }
            // At once where it belongs: it is large.
            rows.push(plane.row(&place, net, body, [last, step], &self.rules.parting));
            planes_of.push(index);
            if let (Some(resolved), Some(row)) = (resolved, rows.last_mut()) {
                row.wanted_speed = plane.most_parting(&place, resolved);
            }
            if let Some(less_deep) = one_too_many(rows, holds_both, step) {
                rows.swap_remove(less_deep);
                planes_of.swap_remove(less_deep);
            }
        }
    }

    /// Adds the contacts within the step from `before` to `after` to `contacts`; what forces on knots hold then, with
    /// `body` as it is after the step.
    pub fn report(
        &mut self,
        before: &Knots,
        after: &Knots,
        body: Option<&Body>,
        contacts: &mut Vec<Contact>,
    ) {
        self.settle(|knot| after.velocity[knot]);
        let force = match &self.solver.normal {
            NormalSolver::Penalty { force, of_cables: false, .. } => Some(force),
            _ => None,
        };
        contacts.extend(self.planes.iter().filter_map(|plane| {
            let mut contact = plane.contact(before, after)?;
            if let (Some(force), Some(body)) = (force, body) {
                contact.stored = force.energy(contact.knot, plane.depth(after, body, self.lag * self.step));
            }
            Some(contact)
        }));
    }

    /// Energy that forces on cables hold where these are pressed in now [J].
    pub fn stored_energy(&self, knots: &Knots, body: &Body) -> f64 {
        let NormalSolver::Penalty { force, speed, of_cables: true, .. } = &self.solver.normal else {
            return 0.0;
        };
        let energy = |plane: &ContactPlane| {
            force.energy_of(&plane.record.bearers(), plane.depth(knots, body, self.lag * self.step), *speed)
        };
        self.planes.iter().filter(|plane| !plane.waits).map(energy).sum()
    }

    /// Number of colliders of the detector.
    pub fn n_colliders(&self) -> usize {
        self.feature.n_colliders()
    }
}

impl RowSource for SurfaceContacts {
    fn add_rows(
        &mut self,
        net: &MarkedKnots<'_>,
        body: &Body,
        step: f64,
        again: bool,
        rows: &mut Vec<ContactRow>,
    ) {
        self.prepare(net, body, step, again);
        rows.append(&mut self.rows);
    }

    fn take_rows(&mut self, rows: &[ContactRow], net: &mut MarkedKnots<'_>, bodies: [&Body; 2], step: f64) {
        self.finish(rows, net, bodies, step);
    }

    fn touches_target(&self) -> bool {
        true
    }

    /// Whether the method that moves the cables after this acted drew the net in all the same: planes hear how much is lacking.
    ///
    /// The engine ends its passes before all rows hold, so it does not do what was foreseen to the last bit: of light knots between
    /// stretched cables a tenth of a millimetre is left in each step.
    fn lacks(&mut self, states: [&State; 2], step: f64) -> bool {
        let [before, after] = states.map(|state| {
            let body = &state.bodies[TARGET];
            let turn = body.attitude.to_rotation_matrix();
            move |plane: &ContactPlane| {
                let arm = plane.record.at_place(&state.knots.position) - body.position;
                (turn * plane.normal).dot(&arm) - plane.height
            }
        });
        let mut lacks = false;
        let share = match self.feature {
            Feature::Knots { .. } => KNOTS_LACKING,
            Feature::Cables(_) => CABLES_LACKING,
        };
        let lacking = share * (step / JOINTS_STEP).min(1.0);
        for &index in &self.awake {
            let plane = &mut self.planes[index];
            if plane.waits {
                continue;
            }
            let start = before(plane).min(0.0);
            let wanted = start + step * self.rules.parting.push_out.speed(-start, plane.radius, 0.0, step);
            let short = wanted - after(plane);
            if short > lacking * plane.radius {
                plane.lacking += short / step;
                lacks = true;
            }
        }
        lacks
    }
}

/// Which of `rows` goes, where the last makes them more than a knot may have: it is held by the two parts that make a corner,
/// if a solver `holds_both`, or by the one that it would be deeper in after a `step` [s].
fn one_too_many(rows: &[ContactRow], holds_both: bool, step: f64) -> Option<usize> {
    let (row, others) = rows.split_last()?;
    let of_the_knot = |back: usize| {
        let other = others.len().checked_sub(back).map(|index| &others[index]);
        other.filter(|other| row.is_of_the_knot_of(other))
    };
    let last = of_the_knot(1)?;
    let first = of_the_knot(2);
    let makes_corner = |with: &ContactRow| row.normal.dot(&with.normal).abs() < CORNER;
    if holds_both && first.is_none() && makes_corner(last) {
        return None;
    }
    let depth = |row: &ContactRow| -(row.gap + step * row.speed);
    let stays = depth(row) > depth(last) && first.is_none_or(makes_corner);
    Some(others.len() - usize::from(stays))
}
