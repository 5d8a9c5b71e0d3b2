//! The energy ledger: what the net and the bodies have, and where the rest went.
//!
//! At any time
//!
//! E₀ + Σ work of effects + work of a driven target
//!   = kinetic + elastic + stored by effects + taken by cables, solver and contact + residual.
//!
//! Within a step the momentum of a knot changes by the impulses of its contacts, of effects and of
//! its cables, and its kinetic energy by Δp · (v⁻ + v⁺) / 2, exactly. Contact impulses are read
//! from the engine and forces of effects are known, so what is left of Δp is the cables'. "Taken by
//! cables" is what they take by their own law (∫ c ṙ² dt while taut), over the path that the method took. In flight, what else is missing is
//! in no row. Once contacts or threads have acted "taken by solver" is what the method took beyond the law, and below zero what it
//! made. Where cables are joints that is so in flight too: snaps (1 - e²) and dashpots took so much by the law of
//! Eq. 3.3, at most, and "taken by solver" is what the engine's implicit rows took beyond it, at least. Within a part of a step
//! that is long before a cable's own period, a dashpot's share is known only roughly, and no more is the law's than is missing.
//! Classical RK4 and located flights do not know the law's share once contacts act: then all that is missing is the cables'.
//!
//! Where a method's velocities are those of some time before its positions (half a sub-step with semi-implicit Euler), what
//! cables hold is measured for that time too: with positions of the end the sum wobbles by h T ṙ / 2.
//!
//! What effects do at the ends of a step (fields) is booked by itself; the identity is that of the motion
//! between.
//!
//! The residual is then what a net in flight made or destroyed against its law; after that, what contact
//! impulses on the target and the target's own motion do not agree on: an impulse misread, a turning body
//! integrated badly, a work term forgotten.
//!
//! "Created" is the largest rise of all energy above any earlier minimum, looked at after every step, less
//! what came in from outside. Nothing but an error of the method makes it. What an effect may hold beyond what it
//! says, as a thread does that was drawn out against its winches, counts as there: no more is said to be created than
//! must have been.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::cable::Cable;
use crate::interaction::Interactions;
use crate::net::Net;
use crate::state::{EffectWork, Knots, State};
use crate::step::stepper::{CableLoss, StepReport};

/// Energies and works since the start [J].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    /// All energy at the start.
    pub start: f64,
    /// Kinetic energy of the net and its bullets.
    pub kinetic_net: f64,
    /// Kinetic energy of the target.
    pub kinetic_target: f64,
    /// Elastic energy of the cables.
    pub elastic: f64,
    /// Energy stored by effects and by contact forces, and that of the motion of bodies that effects bring.
    pub stored: f64,
    /// Taken by cables since the start.
    pub cables: f64,
    /// Taken since the start by the method beyond what cables take by their law, among contacts or by rows that are solved implicitly; none
    /// without either.
    pub solver: Option<f64>,
    /// What a method took in flight beside the law of its cables, or made where it is below zero: in no row, the largest part of the residual.
    pub beside_law: f64,
    /// Taken by contact, normal to the surface, since the start.
    pub contact: f64,
    /// Work done by whatever keeps a `spinning` target turning.
    pub drive: f64,
    /// Work of each effect, in the order of the list.
    pub effects: Vec<f64>,
    /// The part of it that came from outside net and target.
    pub outside: f64,
    /// What drives of effects put in beyond it, and was lost on the way; negative: effects gave more.
    pub lost: f64,
    /// What of the work from outside, the drive's included, was positive, step by step.
    pub put_in: f64,
    /// Work of fields' kicks on the net.
    pub by_fields: f64,
    /// The most that it was so far.
    pub most_by_fields: f64,
    /// Largest rise of [`Ledger::closed`], less what was lost on the way, above any earlier minimum.
    pub created: f64,
    /// That minimum, with what effects may have held beyond what they said.
    pub least: f64,
}

impl Ledger {
    /// What a series has of it, by name; works of effects, whose names the ledger does not know, apart [J].
    pub fn parts(&self) -> [(&'static str, f64); 10] {
        [
            ("kinetic_net", self.kinetic_net),
            ("kinetic_target", self.kinetic_target),
            ("elastic", self.elastic),
            ("stored", self.stored),
            ("taken_by_cables", self.cables),
            ("taken_by_solver", self.solver.unwrap_or(0.0)),
            ("taken_by_contact", self.contact),
            ("drive", self.drive),
            ("residual", self.residual()),
            ("created", self.created),
        ]
    }

    /// Energy of net and target now [J].
    pub fn mechanical(&self) -> f64 {
        self.kinetic_net + self.kinetic_target + self.elastic + self.stored
    }

    /// Energy of net and target less what effects and a drive put in or took out [J].
    pub fn own(&self) -> f64 {
        self.mechanical() - self.drive - self.effects.iter().sum::<f64>()
    }

    /// Energy of net and target less what came in from outside, effects between them not taken out [J]: it may
    /// fall, and must not rise.
    pub fn closed(&self) -> f64 {
        self.mechanical() - self.drive - self.outside
    }

    /// Work put in so far, that of fields on the net included.
    pub fn all_put_in(&self) -> f64 {
        self.put_in + self.most_by_fields
    }

    /// Energy that is in no row of the ledger [J]; negative when too much was found.
    pub fn residual(&self) -> f64 {
        self.start - self.own() - self.cables - self.solver.unwrap_or(0.0) - self.contact
    }

    /// What of that is not the method's own: the books do not close by it [J].
    pub fn unbooked(&self) -> f64 {
        self.residual() - self.beside_law
    }
}

/// Keeps the ledger and the momenta of a run.
pub struct EnergyAudit {
    net_mass: Vec<f64>,
    cables: Arc<[Cable]>,
    /// The ledger so far.
    pub ledger: Ledger,
    /// Impulse from outside net and free bodies since the start [N s].
    pub outside_impulse: Vector3<f64>,
    /// Angular impulse from outside, about the origin, since the start [N m s].
    pub outside_angular_impulse: Vector3<f64>,
    /// Times each effect acted.
    pub effect_counts: Vec<u64>,
    /// Which effects act between net and target.
    internal: Vec<bool>,
    /// Largest strain of a cable now [-], and its first knot.
    pub strained: (f64, usize),
    /// Energy of net and target at the start, without what effects store [J].
    moving_at_start: f64,
    /// Work from outside at the end of the step before [J].
    from_outside: f64,
    /// Energy that contact forces hold [J].
    in_contacts: f64,
    /// What was missing of steps with implicit rows, beyond what cables took by their law [J]; negative where the law would have had
    /// more.
    beyond_law: f64,
}

impl EnergyAudit {
    /// Starts the ledger at `state`.
    pub fn start(net: &Net, effects: &mut Interactions, state: &State) -> Self {
        let mut audit = EnergyAudit {
            net_mass: net.mass.clone(),
            cables: Arc::clone(&net.cables),
            ledger: Ledger { effects: vec![0.0; effects.list().len()], ..Ledger::default() },
            outside_impulse: Vector3::zeros(),
            outside_angular_impulse: Vector3::zeros(),
            effect_counts: vec![0; effects.list().len()],
            internal: effects.list().iter().map(|effect| effect.is_internal).collect(),
            strained: (0.0, 0),
            from_outside: 0.0,
            in_contacts: 0.0,
            beyond_law: 0.0,
            moving_at_start: 0.0,
        };
        audit.measure(state, 0.0);
        audit.measure_stored(state, effects);
        audit.ledger.start = audit.ledger.mechanical();
        audit.ledger.least = audit.ledger.start;
        audit.moving_at_start = audit.ledger.start - audit.ledger.stored;
        audit
    }

    /// Books what effect `index` did at an end of a step.
    pub fn add(&mut self, index: usize, work: &EffectWork) {
        self.ledger.effects[index] += work.work;
        if !self.internal[index] {
            self.ledger.outside += work.work - work.made;
            self.ledger.lost += work.lost;
        }
        self.outside_impulse += work.impulse;
        self.outside_angular_impulse += work.angular_impulse;
        self.effect_counts[index] += work.count;
    }

    /// Books the step of `step` seconds that led from `before` to `after`, of which the method said what is in
    /// `report`.
    pub fn record(
        &mut self,
        before: &State,
        after: &State,
        step: f64,
        effects: &mut Interactions,
        report: &StepReport,
    ) {
        let (kinetic, elastic) = (self.ledger.kinetic_net, self.ledger.elastic);
        self.measure(after, report.velocity_lag);

        let mut on_knots = 0.0; // work of contacts and effects on the knots
        for contact in &after.contacts {
            on_knots += contact.work_on_knot;
            // That of cables is their effect's, where they are no elements.
            if contact.along.is_none() || after.elements.is_some() {
                self.ledger.contact += contact.loss;
            }
            if after.body_models.get(contact.body).is_some_and(|model| !model.is_free()) {
                // A held body passes the impulse to the outside; the work of its moving surface
                // comes from what drives it.
                let impulse = contact.impulse_on_knot();
                self.outside_impulse += impulse;
                self.outside_angular_impulse += contact.moment;
                self.ledger.drive += contact.work_of_surface();
            }
        }
        let moved = before.knots.position.iter().zip(&after.knots.position);
        for (force, (from, to)) in after.forces.on_knots.iter().zip(moved) {
            on_knots += force.dot(&(to - from));
        }
        effects.end_of_step(before, after, step, |index, work| {
            on_knots += work.on_knots;
            self.add(index, work);
        });
        let held_before = self.in_contacts;
        // Last: an effect may settle what it stores in its account.
        self.measure_stored(after, effects);
        // What a contact force holds is not taken yet.
        self.ledger.contact += held_before - self.in_contacts;
        // Δkinetic = work of contacts and effects + work of cables; the cables keep Δelastic of theirs.
        let by_cables = (self.ledger.kinetic_net - kinetic) - on_knots;
        let missing = -by_cables - (self.ledger.elastic - elastic);
        self.book_cables(missing, report.cable_loss);
    }

    /// Books what is `missing` after a step of what knots and cables had [J].
    fn book_cables(&mut self, missing: f64, known: CableLoss) {
        let ledger = &mut self.ledger;
        match known {
            CableLoss::Missing => ledger.cables += missing,
            CableLoss::ByLaw(taken) => {
                ledger.cables += taken;
                ledger.beside_law += missing - taken;
            }
            CableLoss::BesideContact(taken) => {
                ledger.cables += taken;
                ledger.solver = Some(ledger.solver.unwrap_or(0.0) + missing - taken);
            }
            CableLoss::WithRows(taken) => {
                self.beyond_law += missing - taken;
                let by_solver = self.beyond_law.max(0.0);
                ledger.cables += missing - (by_solver - ledger.solver.unwrap_or(0.0));
                ledger.solver = Some(by_solver);
            }
        }
    }

    /// Looks for created energy at the end of a step, in which effects may hold so much more than they say; the ledger's
    /// largest so far [J].
    pub fn look_for_rise(&mut self, may_hold: f64) -> f64 {
        let ledger = &mut self.ledger;
        let from_outside = ledger.drive + ledger.outside + ledger.lost;
        ledger.put_in += (from_outside - self.from_outside).max(0.0);
        self.from_outside = from_outside;
        let closed = ledger.closed() - ledger.lost;
        ledger.least = ledger.least.min(closed + may_hold);
        // One that is no number is no less than any.
        let rise = closed - ledger.least;
        if rise.is_nan() || rise > ledger.created {
            ledger.created = rise;
        }
        ledger.created
    }

    /// What created energy is set against [J]: the energy of net and target at the start, without what fields store,
    /// whose zero is anywhere, and the work put in; of a scene at rest that of the net at a millimetre a second.
    pub fn energy_scale(&self) -> f64 {
        let at_rest = 0.5e-6 * self.net_mass.iter().sum::<f64>();
        (self.moving_at_start + self.ledger.all_put_in()).max(at_rest)
    }

    /// Measures motion, and what the cables hold `lag` seconds before, when the velocities are of then: energies of two
    /// times would wobble against each other.
    fn measure(&mut self, state: &State, lag: f64) {
        self.measure_motion(state);
        let Knots { position, velocity } = &state.knots;
        let (mut elastic, mut strained) = (0.0, (0.0, 0));
        // Shorter by more than ends go on within the lag a cable is slack now and was then: as most are.
        let part = if lag > 0.0 {
            2.0 * lag * velocity.iter().map(Vector3::norm_squared).fold(0.0, f64::max).sqrt()
        } else {
            0.0
        };
        for cable in self.cables.iter() {
            let across = position[cable.b] - position[cable.a];
            let squared = across.norm_squared();
            let surely = cable.rest_length - part;
            if surely > 0.0 && squared < surely * surely {
                continue;
            }
            let was = if lag > 0.0 {
                (across - lag * (velocity[cable.b] - velocity[cable.a])).norm_squared()
            } else {
                squared
            };
            // Slack, as most are, it holds nothing and is not strained: no roots.
            let slack = cable.rest_length * cable.rest_length;
            if was > slack {
                elastic += cable.energy(was.sqrt());
            }
            if squared > slack {
                let strain = squared.sqrt() / cable.rest_length - 1.0;
                if strain > strained.0 {
                    strained = (strain, cable.a);
                }
            }
        }
        self.strained = strained;
        self.ledger.elastic = state.totals.map_or(elastic, |totals| totals.elastic);
    }

    /// Measures kinetic energies.
    pub fn measure_motion(&mut self, state: &State) {
        let speeds = self.net_mass.iter().zip(&state.knots.velocity);
        self.ledger.kinetic_net = match state.totals {
            Some(totals) => totals.kinetic,
            None => speeds.map(|(mass, v)| 0.5 * mass * v.norm_squared()).sum(),
        };
        self.ledger.kinetic_target = state.energy_of_bodies(true);
    }

    /// Measures what `effects` store, and the motion of bodies that nothing touches.
    pub fn measure_stored(&mut self, state: &State, effects: &mut Interactions) {
        self.in_contacts = state.contacts.iter().map(|contact| contact.stored).sum();
        self.ledger.stored = state.energy_of_bodies(false) + effects.stored_energy(state) + self.in_contacts;
    }

    /// Measures kinetic energies after a kick of fields, and books its work on the net.
    pub fn book_kick(&mut self, state: &State) {
        let before = self.ledger.kinetic_net;
        self.measure_motion(state);
        let ledger = &mut self.ledger;
        ledger.by_fields += ledger.kinetic_net - before;
        ledger.most_by_fields = ledger.most_by_fields.max(ledger.by_fields);
    }

    /// The same again after a kick, where there are bodies that it may have changed.
    pub fn measure_kicked(&mut self, state: &State, effects: &mut Interactions) {
        if state.body_models.iter().any(|model| !model.has_shape()) {
            self.measure_stored(state, effects);
        }
    }

    /// Linear momentum of the net and all free bodies [kg m/s].
    pub fn momentum(&self, state: &State) -> Vector3<f64> {
        let lumped = || self.net_mass.iter().zip(&state.knots.velocity).map(|(m, v)| *m * v).sum();
        let net = state.totals.map_or_else(lumped, |totals| totals.momentum);
        state.each_body().fold(net, |sum, (model, body)| sum + model.momentum(body))
    }

    /// Angular momentum of the same about the origin [kg m^2/s].
    pub fn angular_momentum(&self, state: &State) -> Vector3<f64> {
        let knots = &state.knots;
        let moments = self.net_mass.iter().zip(knots.position.iter().zip(&knots.velocity));
        let lumped = || moments.map(|(m, (x, v))| *m * x.cross(v)).sum();
        let net = state.totals.map_or_else(lumped, |totals| totals.angular_momentum);
        state.each_body().fold(net, |sum, (model, body)| sum + model.angular_momentum(body))
    }
}
