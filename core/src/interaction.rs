//! The contracts between what a scene calls for and the methods that step it, below both.
//!
//! An effect is one object that offers a view of itself for each kind of thing it does:
//!
//! | kind | does |
//! |---|---|
//! | [`ForceElement`] | forces on knots and bodies, held over a step |
//! | [`HalfKick`] | changes velocities at both ends of a step |
//! | [`SubstepConstraint`] | changes velocities of knots in every part of a step, and can be undone |
//! | [`ContactLaw`] | answers contacts that it finds itself, or brings their rows to one solver of all |
//! | [`StepObserver`] | says what it stores, and what it did to energy and momentum |
//! | [`EffectOutput`] | columns, and a report at the end |
//!
//! A kind that it does not offer costs nothing: [`Interactions`] asks once and keeps a list of each.
//! A stepper is given the whole of them and knows no effect by name.

use std::time::Duration;

use nalgebra::Vector3;
use serde::Serialize;
use serde_json::Value;

use crate::contact::row::{MarkedKnots, RowSource};
use crate::state::{Body, BodyModel, Contact, EffectWork, Forces, Knots, State, Tie, Wrench};
use crate::work::Clock;

/// Which half of a kick: before the motion of a step, or after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Before everything else.
    First,
    /// After everything else.
    Second,
}

/// Forces that are held over a step.
pub trait ForceElement: Send {
    /// Adds its forces at the start of a step.
    fn add_forces(&mut self, state: &State, forces: &mut Forces);

    /// Energy it stores [J], whose slope is part of its forces; the work of the rest is counted step by step.
    fn energy(&self, _state: &State) -> f64 {
        0.0
    }

    /// Velocity of the medium that its forces on knots are the resistance of [m/s]: seen from there they only take energy. What they give all the same
    /// was made, by their being held over a step.
    fn resists_in(&self) -> Option<Vector3<f64>> {
        None
    }
}

/// Changes velocities at both ends of a step, around all that happens in it.
pub trait HalfKick: Send {
    /// Half the kick of a step of `step` seconds; what it did.
    fn kick(&mut self, state: &mut State, step: f64, half: Half) -> EffectWork;

    /// Whether it changes velocities of knots: then methods bring these to the time of the positions first.
    fn kicks_knots(&self) -> bool {
        true
    }

    /// Whether it kicks the coordinates of elements as well, where the net has any.
    fn kicks_elements(&self) -> bool {
        false
    }
}

/// Holds knots in every part of a step: in every sub-step of a net of our own.
pub trait SubstepConstraint: Send {
    /// Adds the knots that it may change within the coming step; it reads no other.
    fn knots(&self, knots: &mut Vec<usize>);

    /// Changes velocities for a (sub-)step of `step` seconds, and marks the knots it changed.
    fn solve(&mut self, knots: &mut Knots, step: f64, touched: &mut [bool]);

    /// Keeps itself as it is, at the start of a step of `step` seconds that may be done again; what it needs of who does it.
    fn checkpoint(&mut self, step: f64) -> StepNeeds;

    /// Undoes what it did since the checkpoint.
    fn rollback(&mut self);

    /// How it fared since the checkpoint; `knots` are those at the end of the step.
    fn fared(&mut self, knots: &Knots) -> Fared;
}

/// What a constraint needs of a method that moves net and target by itself after it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepNeeds {
    /// Parts of the step, lest in one of them it throws knots that others have to catch.
    pub parts: u32,
    /// What the method is to hold from now on, and not the constraint: it cannot see what comes after it.
    pub ties: Vec<Tie>,
}

/// How a constraint fared in a step that may be taken back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fared {
    /// Whether it was so violated that the step is to be cut.
    pub is_violated: bool,
    /// Energy that it gave beyond what was put in; below 0 what it lost [J].
    pub created: f64,
}

/// Answers contacts that the method of the run does not know of.
pub trait ContactLaw: Send {
    /// Adds the knots that it may look at or change within the coming step, some perhaps again: all `n_knots`,
    /// where it does not know better.
    fn knots(&self, n_knots: usize, knots: &mut Vec<usize>) {
        knots.extend(0..n_knots);
    }

    /// Changes velocities of knots and bodies for a (sub-)step of `step` seconds, after all
    /// constraints, and marks the knots it changed. `before` are the knots' velocities before the forces of
    /// the (sub-)step acted [m/s]; empty where none did.
    fn solve(
        &mut self,
        knots: &mut Knots,
        before: &[Vector3<f64>],
        bodies: &mut [Body],
        step: f64,
        touched: &mut [bool],
    );

    /// Its rows, where impulses answer them.
    fn rows(&mut self) -> Option<&mut dyn RowSource> {
        None
    }

    /// Forgets what it answered since the start of the step, which is done again.
    fn rollback(&mut self) {}

    /// Adds the contacts it answered within the step from `before` to `after`.
    fn report(&mut self, _before: &Knots, _after: &Knots, _contacts: &mut Vec<Contact>) {}

    /// Colliders it has the engine detect with, times it did, since the start.
    fn detection(&self) -> (usize, u64) {
        (0, 0)
    }
}

/// Sees both ends of a step, and answers for energy and momentum.
pub trait StepObserver: Send {
    /// Sees the start of a step, before constraints and contacts act.
    fn start_of_step(&mut self, _before: &State) {}

    /// Energy it holds [J].
    fn stored_energy(&self, _state: &State) -> f64 {
        0.0
    }

    /// Energy that it may hold beyond that, at most [J]: where what it took cannot be told from what it lost.
    fn may_hold(&self) -> f64 {
        0.0
    }

    /// What it did within the step that led from `before` to `after`.
    fn end_of_step(&mut self, before: &State, after: &State) -> EffectWork;
}

/// What an effect has to say.
pub trait EffectOutput: Send {
    /// Names of its columns in the time series.
    fn columns(&self) -> Vec<String>;

    /// Their values; largest values are those since the last call.
    fn values(&mut self, state: &State) -> Vec<f64>;

    /// What it has to say at the end of a run.
    fn report(&self, _end: &State) -> Report {
        Report::default()
    }
}

/// What an effect has to say at the end of a run, as data: who shows it need not know the effect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Its block of the summary, an object.
    pub numbers: Option<Value>,
    /// What began to act, and when; no time if it waited in vain [s].
    pub start: Option<(&'static str, Option<f64>)>,
    /// From when to when the capture is put to the test by it [s].
    pub trial: Option<[f64; 2]>,
    /// What of it is not to be believed.
    pub warnings: Vec<String>,
    /// Threads to draw.
    pub threads: Vec<DrawnThread>,
    /// Column of the work that was put into them, all together [J].
    pub work: Option<&'static str>,
    /// Columns to plot over time: a name, a unit, the column.
    pub curves: Vec<(&'static str, &'static str, &'static str)>,
}

impl Report {
    /// The same with `block`, plain data, as its block of the summary.
    #[must_use]
    pub fn with_numbers(self, block: &impl Serialize) -> Report {
        Report { numbers: serde_json::to_value(block).ok(), ..self }
    }
}

/// A thread to draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnThread {
    /// When it began to be wound; none: never [s].
    pub start: Option<f64>,
    /// The knots it passes in order; none: where it ends outside of the net.
    pub way: Vec<Option<usize>>,
    /// What is off its reels where winding ends [m].
    pub stop: f64,
    /// Its largest tension [N].
    pub limit: f64,
    /// The body whose port it ends at, where it ends outside of the net; none: a place that is held.
    pub port_of: Option<&'static str>,
    /// Columns of its length [m], of what is off its reels [m], and of its tension [N].
    pub columns: [String; 3],
}

/// An effect at work: a view of itself for each kind of thing it does.
pub trait Effect: Send {
    /// Its forces.
    fn forces(&mut self) -> Option<&mut dyn ForceElement> {
        None
    }

    /// Its kicks.
    fn half_kick(&mut self) -> Option<&mut dyn HalfKick> {
        None
    }

    /// Its constraint.
    fn constraint(&mut self) -> Option<&mut dyn SubstepConstraint> {
        None
    }

    /// Its contacts.
    fn contacts(&mut self) -> Option<&mut dyn ContactLaw> {
        None
    }

    /// Its account.
    fn observer(&mut self) -> Option<&mut dyn StepObserver> {
        None
    }

    /// Its output.
    fn output(&mut self) -> Option<&mut dyn EffectOutput> {
        None
    }
}

/// An effect with its name and what is known of it before the first step.
pub struct Interaction {
    /// Its key in the scene.
    pub name: &'static str,
    /// What it installs, in words.
    pub about: String,
    /// Whether it acts between net and target, or within the net: it may take energy, and never gives any.
    pub is_internal: bool,
    /// Whether its contacts ask for the velocities before forces acted, as restitution does.
    pub bounces: bool,
    /// Whether rows of its contacts are solved together with those of others, and not by itself.
    pub shares_rows: bool,
    /// Bodies that it brings, as they start.
    pub bodies: Vec<(BodyModel, Body)>,
    /// The effect.
    pub effect: Box<dyn Effect>,
}

impl Interaction {
    /// An effect that acts from outside and brings no body.
    pub fn new(name: &'static str, about: impl Into<String>, effect: impl Effect + 'static) -> Interaction {
        Interaction {
            name,
            about: about.into(),
            is_internal: false,
            bounces: false,
            shares_rows: false,
            bodies: Vec::new(),
            effect: Box::new(effect),
        }
    }

    /// The same, between net and target or within the net.
    #[must_use]
    pub fn internal(self) -> Interaction {
        Interaction { is_internal: true, ..self }
    }

    /// The same with contacts that bounce, or do not.
    #[must_use]
    pub fn bouncing(self, bounces: bool) -> Interaction {
        Interaction { bounces, ..self }
    }

    /// The same with contacts whose rows are solved together with those of others, or are not.
    #[must_use]
    pub fn sharing_rows(self, shares_rows: bool) -> Interaction {
        Interaction { shares_rows, ..self }
    }

    /// The same with a body of its own that starts as `body`: it moves on by itself, its energy and momenta are counted,
    /// it is recorded and drawn, and forces, fields and tethers act on it, without anything else being told.
    #[must_use]
    pub fn with_body(mut self, model: BodyModel, body: Body) -> Interaction {
        self.bodies.push((model, body));
        self
    }

    /// A force and nothing else.
    pub fn force(
        name: &'static str,
        about: impl Into<String>,
        element: impl ForceElement + 'static,
    ) -> Interaction {
        struct Alone<F>(F);
        impl<F: ForceElement> Effect for Alone<F> {
            fn forces(&mut self) -> Option<&mut dyn ForceElement> {
                Some(&mut self.0)
            }
        }
        Interaction::new(name, about, Alone(element))
    }
}

/// All effects of a run, by kind.
#[derive(Default)]
pub struct Interactions {
    list: Vec<Interaction>,
    times: Vec<Duration>,
    forces: Vec<AppliedForces>,
    half_kicks: Vec<usize>,
    kicks_knots: bool,
    kicks_only_knots: bool,
    constraints: Vec<usize>,
    contacts: Vec<usize>,
    shares_rows: bool,
    observers: Vec<usize>,
}

/// What a force element applies over the step under way.
struct AppliedForces {
    index: usize,
    forces: Forces,
    /// Change of the bodies' energy by them [J].
    work_on_bodies: f64,
    /// Energy it stored at the start of the step [J].
    stored: f64,
    resistance: Resistance,
}

/// Work of a resistance on knots as seen from its medium, which can only fall.
#[derive(Default)]
struct Resistance {
    /// Now, and at least so far [J].
    work: f64,
    least: f64,
}

impl Resistance {
    /// It did so much more `work`; what of that its method made [J].
    fn made(&mut self, work: f64) -> f64 {
        let before = self.work - self.least;
        self.work += work;
        self.least = self.least.min(self.work);
        self.work - self.least - before
    }
}

impl Interactions {
    /// `list` at work, in its order.
    pub fn new(mut list: Vec<Interaction>) -> Interactions {
        for Interaction { shares_rows, effect, .. } in &mut list {
            // What offers no rows shares none.
            *shares_rows &= effect.contacts().is_some_and(|law| law.rows().is_some());
        }
        let shares_rows = list.iter().any(|interaction| interaction.shares_rows);
        let mut of_kind = |offers: fn(&mut dyn Effect) -> bool| -> Vec<usize> {
            (0..list.len()).filter(|&index| offers(list[index].effect.as_mut())).collect()
        };
        let forces = of_kind(|effect| effect.forces().is_some());
        let kicks_knots = of_kind(|effect| effect.half_kick().is_some_and(|kick| kick.kicks_knots()));
        let kicks_only_knots = of_kind(|effect| {
            effect.half_kick().is_some_and(|kick| kick.kicks_knots() && !kick.kicks_elements())
        });
        let applied = |index| AppliedForces {
            index,
            forces: Forces::default(),
            work_on_bodies: 0.0,
            stored: 0.0,
            resistance: Resistance::default(),
        };
        Interactions {
            half_kicks: of_kind(|effect| effect.half_kick().is_some()),
            kicks_knots: !kicks_knots.is_empty(),
            kicks_only_knots: !kicks_only_knots.is_empty(),
            constraints: of_kind(|effect| effect.constraint().is_some()),
            contacts: of_kind(|effect| effect.contacts().is_some()),
            observers: of_kind(|effect| effect.observer().is_some()),
            forces: forces.into_iter().map(applied).collect(),
            times: vec![Duration::ZERO; list.len()],
            shares_rows,
            list,
        }
    }

    /// The effects.
    pub fn list(&self) -> &[Interaction] {
        &self.list
    }

    /// Wall time of each so far.
    pub fn times(&self) -> &[Duration] {
        &self.times
    }

    /// Whether anything but the method itself moves knots or bodies.
    pub fn act(&self) -> bool {
        let lists = [&self.half_kicks, &self.constraints, &self.contacts];
        !self.forces.is_empty() || lists.iter().any(|list| !list.is_empty())
    }

    /// Lets effect `index` do something, on its clock.
    fn timed<T>(&mut self, index: usize, act: impl FnOnce(&mut dyn Effect) -> T) -> T {
        let mut clock = Clock::start();
        let done = act(self.list[index].effect.as_mut());
        clock.lap(&mut self.times[index]);
        done
    }

    /// Whether any kicks.
    pub fn kick(&self) -> bool {
        !self.half_kicks.is_empty()
    }

    /// Whether any changes velocities of knots.
    pub fn kick_knots(&self) -> bool {
        self.kicks_knots
    }

    /// Whether any changes velocities of knots and would leave those of elements behind.
    pub fn kick_only_knots(&self) -> bool {
        self.kicks_only_knots
    }

    /// Half a kick of a step of `step` seconds, the second half in reverse order; `record` hears what each
    /// effect did.
    pub fn half_kick(
        &mut self,
        state: &mut State,
        step: f64,
        half: Half,
        mut record: impl FnMut(usize, &EffectWork),
    ) {
        for i in 0..self.half_kicks.len() {
            let index = match half {
                Half::First => self.half_kicks[i],
                Half::Second => self.half_kicks[self.half_kicks.len() - 1 - i],
            };
            let work = self.timed(index, |effect| {
                effect.half_kick().map(|kick| kick.kick(state, step, half)).unwrap_or_default()
            });
            record(index, &work);
        }
    }

    /// Looks at what forces store at the start of a step, before anything moves.
    pub fn begin_step(&mut self, state: &State) {
        for i in 0..self.forces.len() {
            let index = self.forces[i].index;
            self.forces[i].stored =
                self.timed(index, |effect| effect.forces().map_or(0.0, |force| force.energy(state)));
        }
    }

    /// Whether any applies forces.
    pub fn push(&self) -> bool {
        !self.forces.is_empty()
    }

    /// Forces of the coming step of `step` seconds: those on knots stay in `state.forces` for the stepper to
    /// hold over the step, those on bodies act at once, as an impulse; none on a body that is held.
    pub fn apply_forces(&mut self, state: &mut State, step: f64) {
        let mut all = std::mem::take(&mut state.forces);
        all.clear(state);
        for i in 0..self.forces.len() {
            let index = self.forces[i].index;
            let mut own = std::mem::take(&mut self.forces[i].forces);
            own.clear(state);
            self.timed(index, |effect| {
                if let Some(element) = effect.forces() {
                    element.add_forces(state, &mut own);
                }
            });
            for (sum, force) in all.on_knots.iter_mut().zip(&own.on_knots) {
                *sum += force;
            }
            let mut work = 0.0;
            let pushed = state.each_body_mut().zip(&mut own.on_bodies).zip(&mut all.on_bodies);
            for (((model, body), wrench), sum) in pushed {
                if !model.is_free() {
                    *wrench = Wrench::default();
                } else if *wrench != Wrench::default() {
                    work += model.push(body, &(step * wrench.force), &(step * wrench.torque));
                    *sum += *wrench;
                }
            }
            self.forces[i].work_on_bodies = work;
            self.forces[i].forces = own;
        }
        state.forces = all;
    }

    /// Sees the start of a step.
    pub fn start_of_step(&mut self, before: &State) {
        for i in 0..self.observers.len() {
            self.timed(self.observers[i], |effect| {
                if let Some(observer) = effect.observer() {
                    observer.start_of_step(before);
                }
            });
        }
    }

    /// Whether anything acts within a step.
    pub fn act_within(&self) -> bool {
        self.constrain() || self.touch()
    }

    /// Whether there are constraints.
    pub fn constrain(&self) -> bool {
        !self.constraints.is_empty()
    }

    /// The knots that constraints may change within the coming step.
    pub fn constrained_knots(&mut self, knots: &mut Vec<usize>) {
        knots.clear();
        for &index in &self.constraints {
            if let Some(constraint) = self.list[index].effect.constraint() {
                constraint.knots(knots);
            }
        }
    }

    /// Those of `n_knots` that constraints and contact laws may look at or change within the coming step, those of several again.
    pub fn reached_knots(&mut self, n_knots: usize, knots: &mut Vec<usize>) {
        self.constrained_knots(knots);
        for &index in &self.contacts {
            if let Some(law) = self.list[index].effect.contacts() {
                law.knots(n_knots, knots);
            }
        }
    }

    fn each_constraint(&mut self, mut act: impl FnMut(&mut dyn SubstepConstraint)) {
        for i in 0..self.constraints.len() {
            self.timed(self.constraints[i], |effect| {
                if let Some(constraint) = effect.constraint() {
                    act(constraint);
                }
            });
        }
    }

    /// Constraints change velocities for a (sub-)step of `step` seconds and mark the knots.
    pub fn solve_constraints(&mut self, knots: &mut Knots, step: f64, touched: &mut [bool]) {
        self.each_constraint(|constraint| constraint.solve(knots, step, touched));
    }

    /// Constraints keep themselves as they are; what they need of a step of `step` seconds, together.
    pub fn checkpoint(&mut self, step: f64) -> StepNeeds {
        let mut all = StepNeeds::default();
        self.each_constraint(|constraint| {
            let StepNeeds { parts, ties } = constraint.checkpoint(step);
            all.parts = all.parts.max(parts);
            all.ties.extend(ties);
        });
        all
    }

    /// Constraints undo what they did since the checkpoint, and contact laws forget it.
    pub fn rollback(&mut self) {
        self.each_constraint(|constraint| constraint.rollback());
        self.each_contact_law(None, |law| law.rollback());
    }

    /// How constraints fared together since the checkpoint.
    pub fn fared(&mut self, knots: &Knots) -> Fared {
        let mut all = Fared::default();
        self.each_constraint(|constraint| {
            let Fared { is_violated, created } = constraint.fared(knots);
            all.is_violated |= is_violated;
            all.created += created;
        });
        all
    }

    /// Whether there are contact laws.
    pub fn touch(&self) -> bool {
        !self.contacts.is_empty()
    }

    /// Whether a contact law asks for velocities before forces acted.
    pub fn bounce(&self) -> bool {
        self.list.iter().any(|interaction| interaction.bounces)
    }

    /// Contact laws do something: all, or those that share rows, or that do not.
    fn each_contact_law(&mut self, sharing: Option<bool>, mut act: impl FnMut(&mut dyn ContactLaw)) {
        for i in 0..self.contacts.len() {
            let index = self.contacts[i];
            if sharing.is_none_or(|shares| shares == self.list[index].shares_rows) {
                self.timed(index, |effect| {
                    if let Some(law) = effect.contacts() {
                        act(law);
                    }
                });
            }
        }
    }

    /// Contact laws that share no rows change velocities for a (sub-)step of `step` seconds and mark the knots.
    pub fn solve_contacts(
        &mut self,
        knots: &mut Knots,
        before: &[Vector3<f64>],
        bodies: &mut [Body],
        step: f64,
        touched: &mut [bool],
    ) {
        self.each_contact_law(Some(false), |law| law.solve(knots, before, bodies, step, touched));
    }

    /// Contact laws change velocities of `net` by what they should have given for a part of `step` seconds that is over.
    pub fn correct_contacts(&mut self, net: &mut MarkedKnots<'_>, step: f64) {
        self.each_contact_law(None, |law| {
            if let Some(rows) = law.rows() {
                rows.correct(net, step);
            }
        });
    }

    /// Parts that contact laws need in a step of `step` seconds from `knots`.
    pub fn parts_of_contacts(&mut self, knots: &Knots, step: f64) -> u32 {
        let mut parts = 1;
        self.each_contact_law(None, |law| {
            parts = parts.max(law.rows().map_or(1, |rows| rows.parts(knots, step)));
        });
        parts
    }

    /// Whether contact laws share rows.
    pub fn share_rows(&self) -> bool {
        self.shares_rows
    }

    /// Contact laws that share rows do something with them.
    pub fn each_shared_source(&mut self, mut act: impl FnMut(&mut dyn RowSource)) {
        self.each_contact_law(Some(true), |law| {
            if let Some(rows) = law.rows() {
                act(rows);
            }
        });
    }

    /// Adds the contacts that were answered within the step from `before` to `after`.
    pub fn report_contacts(&mut self, before: &Knots, after: &Knots, contacts: &mut Vec<Contact>) {
        for &index in &self.contacts {
            if let Some(law) = self.list[index].effect.contacts() {
                law.report(before, after, contacts);
            }
        }
    }

    /// Colliders that contact laws have the engine detect with.
    pub fn n_colliders(&mut self) -> usize {
        let lists = self.contacts.iter();
        lists.filter_map(|&index| Some(self.list[index].effect.contacts()?.detection().0)).sum()
    }

    /// Times that contact laws have had the engine detect.
    pub fn n_detections(&mut self) -> u64 {
        let lists = self.contacts.iter();
        lists.filter_map(|&index| Some(self.list[index].effect.contacts()?.detection().1)).sum()
    }

    /// What each effect did within the step that led from `before` to `after`, in `step` seconds.
    pub fn end_of_step(
        &mut self,
        before: &State,
        after: &State,
        step: f64,
        mut record: impl FnMut(usize, &EffectWork),
    ) {
        for i in 0..self.forces.len() {
            let index = self.forces[i].index;
            let (now, medium) = self.timed(index, |effect| {
                effect.forces().map_or((0.0, None), |force| (force.energy(after), force.resists_in()))
            });
            let mut work = self.forces[i].work(before, after, step, now);
            if let Some(medium) = medium {
                work.made = self.forces[i].made_in(&medium, before, after, step);
            }
            record(index, &work);
        }
        for i in 0..self.observers.len() {
            let index = self.observers[i];
            let work = self.timed(index, |effect| {
                effect.observer().map(|observer| observer.end_of_step(before, after)).unwrap_or_default()
            });
            record(index, &work);
        }
    }

    /// Energy that all of them hold [J].
    pub fn stored_energy(&mut self, state: &State) -> f64 {
        let mut stored = 0.0;
        for &index in &self.observers {
            let observer = self.list[index].effect.observer();
            stored += observer.map_or(0.0, |observer| observer.stored_energy(state));
        }
        for AppliedForces { index, .. } in &self.forces {
            stored += self.list[*index].effect.forces().map_or(0.0, |force| force.energy(state));
        }
        stored
    }

    /// Energy that all of them may hold beyond that, at most [J].
    pub fn may_hold(&mut self) -> f64 {
        let observers = self.observers.iter();
        observers
            .map(|&index| self.list[index].effect.observer().map_or(0.0, |observer| observer.may_hold()))
            .sum()
    }

    /// What each has to say at the end of a run, by name.
    pub fn reports(&mut self, end: &State) -> Vec<(&'static str, Report)> {
        let outputs = self.list.iter_mut().filter_map(|one| Some((one.name, one.effect.output()?)));
        outputs.map(|(name, output)| (name, output.report(end))).collect()
    }

    /// Names of all columns.
    pub fn columns(&mut self) -> Vec<String> {
        let outputs = self.list.iter_mut().filter_map(|interaction| interaction.effect.output());
        outputs.flat_map(|output| output.columns()).collect()
    }

    /// Their values.
    pub fn values(&mut self, state: &State) -> Vec<f64> {
        let outputs = self.list.iter_mut().filter_map(|interaction| interaction.effect.output());
        outputs.flat_map(|output| output.values(state)).collect()
    }
}

impl AppliedForces {
    /// What it did; `stored`: what it stores now [J].
    fn work(&self, before: &State, after: &State, step: f64, stored: f64) -> EffectWork {
        let forces = &self.forces;
        let mut work =
            EffectWork { work: self.work_on_bodies + stored - self.stored, ..EffectWork::default() };
        let moved = before.knots.position.iter().zip(&after.knots.position);
        for (knot, (force, (from, to))) in forces.on_knots.iter().zip(moved).enumerate() {
            if *force == Vector3::zeros() {
                continue;
            }
            work.work += force.dot(&(to - from));
            work.impulse += step * force;
            let place = after.forces.acted_at.get(knot).copied().unwrap_or_else(|| 0.5 * (from + to));
            work.angular_impulse += step * place.cross(force);
            work.count += 1;
        }
        for (body, Wrench { force, torque }) in before.bodies.iter().zip(&forces.on_bodies) {
            work.impulse += step * force;
            work.angular_impulse += step * (body.position.cross(force) + torque);
            work.count += u64::from(*force != Vector3::zeros() || *torque != Vector3::zeros());
        }
        work
    }

    /// What it made as the resistance of a `medium` with that velocity [J].
    fn made_in(&mut self, medium: &Vector3<f64>, before: &State, after: &State, step: f64) -> f64 {
        let moved = before.knots.position.iter().zip(&after.knots.position);
        let seen = self.forces.on_knots.iter().zip(moved);
        self.resistance.made(seen.map(|(force, (from, to))| force.dot(&(to - from - step * medium))).sum())
    }
}
