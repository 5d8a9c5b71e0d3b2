//! The simulation: everything a case calls for, and the step.

use std::time::Duration;

use nalgebra::Vector3;

use crate::audit::EnergyAudit;
use crate::case::Case;
use crate::closing::Mechanism;
use crate::effects::Effect;
use crate::effects::closing::Report;
use crate::failure::Failure;
use crate::options::Setting;
use crate::state::{Body, Contact, Knots, State};
use crate::step::{Method, Pull};
use crate::target::spec::Motion;
use crate::work::{Clock, Work};
use crate::world::Census;

/// A run under way.
pub struct Simulation {
    /// The state after the last step.
    pub state: State,
    /// Energy and momenta.
    pub audit: EnergyAudit,
    /// Work done so far.
    pub work: Work,
    before: State,
    method: Method,
    effects: Vec<Box<dyn Effect>>,
    any_effect_brackets: bool,
    any_effect_acts: bool,
    any_effect_pulls: bool,
    any_effect_presses: bool,
    effect_times: Vec<Duration>,
    launch_energy: f64,
    step: f64,
}

impl Simulation {
    /// Builds what `case` calls for, and nothing else.
    pub fn new(case: &Case) -> Simulation {
        let mut effects = case.scene.effects.build(&case.net, case.target.as_ref());
        let mut plan = case.plan();
        for effect in &effects {
            effect.install(&mut plan);
        }
        let setting = Setting {
            net: &case.net,
            target: case.target.as_ref(),
            solver: &case.scene.solver,
            plan: &plan,
            reach: case.reach(),
            contact_speed: case.contact_speed(),
        };
        for effect in &mut effects {
            effect.prepare(&setting);
        }
        let mut state = start(case);
        for effect in &effects {
            effect.begin(&mut state);
        }
        Simulation {
            before: state.clone(),
            audit: EnergyAudit::start(&case.net, case.target.as_ref(), &effects, &state),
            work: Work::default(),
            effect_times: vec![Duration::ZERO; effects.len()],
            method: Method::new(case, &plan),
            any_effect_brackets: effects.iter().any(|effect| effect.brackets()),
            any_effect_acts: effects.iter().any(|effect| effect.acts()),
            any_effect_pulls: effects.iter().any(|effect| effect.threads().is_some()),
            any_effect_presses: effects.iter().any(|effect| effect.presses()),
            launch_energy: case.net.launch_energy().max(f64::MIN_POSITIVE),
            step: plan.step,
            state,
            effects,
        }
    }

    /// One step.
    ///
    /// # Errors
    /// A state that is not a number.
    pub fn step(&mut self) -> Result<(), Failure> {
        let energy = self.audit.ledger.own();

        // Fields kick first: the rest of the step is then as if there were none.
        self.open();
        self.before.clone_from(&self.state);

        // Forces next: they are frozen over the step.
        self.apply_effects();

        // Detection, contact, cables and motion, as the method orders them.
        let mut pull = Pulling {
            effects: &mut self.effects,
            times: &mut self.effect_times,
            pulls: self.any_effect_pulls,
            presses: self.any_effect_presses,
        };
        pull.watch(&self.before);
        self.method.advance(&self.before, &mut self.state, &mut self.work, &mut pull)?;
        self.state.step += 1;
        // From the count, not by adding: a million steps must not drift.
        self.state.time = self.state.step as f64 * self.step;

        self.observe(energy);

        // The other half of the kick, where the knots are now.
        self.close();
        Ok(())
    }

    fn open(&mut self) {
        if !self.any_effect_brackets {
            return;
        }
        for (index, effect) in self.effects.iter_mut().enumerate() {
            if effect.brackets() {
                let mut clock = Clock::start();
                let posting = effect.open(&mut self.state, self.step);
                clock.lap(&mut self.effect_times[index]);
                self.audit.add(index, &posting);
            }
        }
        self.method.take_velocities(&self.state);
        self.audit.measure_motion(&self.state);
    }

    fn close(&mut self) {
        if !self.any_effect_brackets {
            return;
        }
        for (index, effect) in self.effects.iter_mut().enumerate().rev() {
            if effect.brackets() {
                let mut clock = Clock::start();
                let posting = effect.close(&mut self.state, self.step);
                clock.lap(&mut self.effect_times[index]);
                self.audit.add(index, &posting);
            }
        }
        self.audit.measure_motion(&self.state);
        if self.state.chaser.is_some() {
            // Its kinetic energy is stored by its effect, and fields kick it.
            self.audit.measure_stored(&self.state, &self.effects);
        }
    }

    fn apply_effects(&mut self) {
        if !self.any_effect_acts {
            return;
        }
        self.state.loads.clear(self.state.knots.position.len());
        for (effect, time) in self.effects.iter_mut().zip(&mut self.effect_times) {
            if effect.acts() {
                let mut clock = Clock::start();
                effect.act(&self.before, &mut self.state.loads);
                clock.lap(time);
            }
        }
    }

    /// `energy`: that of net and target at the start of the step [J].
    fn observe(&mut self, energy: f64) {
        let mut clock = Clock::start();
        self.audit.record(&self.before, &self.state, &mut self.effects, &mut self.effect_times);
        self.method.hear_gain((self.audit.ledger.own() - energy) / self.launch_energy);
        self.work.steps += 1;
        self.work.contacts += self.state.contacts.len() as u64;
        clock.lap(&mut self.work.stages.observe);
    }

    /// What the engine consists of.
    pub fn census(&self) -> Census {
        let mut census = self.method.census();
        census.colliders += self.effects.iter().map(|effect| effect.detection().0).sum::<usize>();
        census
    }

    /// Wall time of each active effect so far.
    pub fn effect_times(&self) -> &[Duration] {
        &self.effect_times
    }

    /// What each active effect installed, in words.
    pub fn effect_installs(&self) -> Vec<(&'static str, String)> {
        self.effects.iter().map(|effect| (effect.name(), effect.installs())).collect()
    }

    /// Names of what the effects have to say in every frame.
    pub fn reading_names(&self) -> Vec<String> {
        self.effects.iter().flat_map(|effect| effect.reading_names()).collect()
    }

    /// Their values now.
    pub fn readings(&mut self) -> Vec<f64> {
        self.effects.iter_mut().flat_map(|effect| effect.readings(&self.state)).collect()
    }

    /// What the closing mechanism did, if there is one.
    pub fn closing(&self) -> Option<Report> {
        self.effects.iter().find_map(|effect| effect.closing())
    }

    /// From when to when the net was tugged at [s], if it was.
    pub fn tug(&self) -> Option<[f64; 2]> {
        self.effects.iter().find_map(|effect| effect.tug())
    }

    /// Names of the active effects, in the order of the list.
    pub fn effect_names(&self) -> Vec<&'static str> {
        self.effects.iter().map(|effect| effect.name()).collect()
    }
}

/// The effects that change velocities of knots at once, for the method to call at its place.
struct Pulling<'a> {
    effects: &'a mut [Box<dyn Effect>],
    times: &'a mut [Duration],
    pulls: bool,
    presses: bool,
}

impl Pulling<'_> {
    fn each(&mut self, of_kind: fn(&dyn Effect) -> bool, act: &mut dyn FnMut(&mut dyn Effect)) {
        for (effect, time) in self.effects.iter_mut().zip(&mut *self.times) {
            if of_kind(effect.as_ref()) {
                let mut clock = Clock::start();
                act(effect.as_mut());
                clock.lap(time);
            }
        }
    }

    fn each_threads(&mut self, act: &mut dyn FnMut(&mut Mechanism)) {
        for (effect, time) in self.effects.iter_mut().zip(&mut *self.times) {
            if let Some(threads) = effect.threads_mut() {
                let mut clock = Clock::start();
                act(threads);
                clock.lap(time);
            }
        }
    }

    fn watch(&mut self, before: &State) {
        if self.pulls || self.presses {
            let acts = |effect: &dyn Effect| effect.threads().is_some() || effect.presses();
            self.each(acts, &mut |effect| effect.watch(before));
        }
    }
}

impl Pull for Pulling<'_> {
    fn pulls(&self) -> bool {
        self.pulls
    }

    fn reach(&self, knots: &mut Vec<usize>) {
        knots.clear();
        let threads = self.effects.iter().filter_map(|effect| effect.threads());
        knots.extend(threads.flat_map(Mechanism::reach));
    }

    fn pull(&mut self, knots: &mut Knots, step: f64, touched: &mut [bool]) {
        self.each_threads(&mut |threads| threads.pull(knots, step, touched));
    }

    fn keep(&mut self) {
        self.each_threads(&mut Mechanism::keep);
    }

    fn overran(&mut self, knots: &Knots) -> bool {
        let mut overran = false;
        self.each_threads(&mut |threads| overran |= threads.overran(knots));
        overran
    }

    fn take_back(&mut self) {
        self.each_threads(&mut Mechanism::take_back);
    }

    fn presses(&self) -> bool {
        self.presses
    }

    fn press(&mut self, knots: &mut Knots, target: &mut Option<Body>, step: f64, touched: &mut [bool]) {
        self.each(|effect| effect.presses(), &mut |effect| effect.press(knots, target, step, touched));
    }

    fn report(&self, before: &Knots, after: &Knots, contacts: &mut Vec<Contact>) {
        if !self.presses {
            return;
        }
        for effect in self.effects.iter().filter(|effect| effect.presses()) {
            effect.report(before, after, contacts);
        }
    }
}

/// Net in its container, just shot; target as placed.
fn start(case: &Case) -> State {
    let knots = Knots { position: case.net.folded.clone(), velocity: case.net.launch_velocity.clone() };
    let target = case.target.as_ref().map(|target| Body {
        position: target.position,
        attitude: target.attitude,
        velocity: Vector3::zeros(),
        rate: match target.motion {
            Motion::Fixed => Vector3::zeros(),
            Motion::Free | Motion::Spinning => target.attitude * target.spin,
        },
    });
    State { knots, target, tension: vec![0.0; case.net.cables.len()], ..State::default() }
}
