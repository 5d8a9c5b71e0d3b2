//! The record of a run: frames, energy ledger, work counters, extremes.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use nalgebra::Vector3;

use crate::audit::Ledger;
use crate::case::Case;
use crate::failure::Failure;
use crate::hits::Hits;
use crate::interaction::{DrawnThread, Interaction, Report};
use crate::simulation::Simulation;
use crate::state::{Body, BodyModel, State};
use crate::work::Work;
use crate::world::Census;

/// What was recorded, T frames of K knots.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frames {
    /// Time of each frame [s], T.
    pub time: Vec<f64>,
    /// Positions of the knots [m], T × K.
    pub knots: Vec<Vec<Vector3<f64>>>,
    /// Velocities of the knots [m/s], T × K.
    pub velocities: Vec<Vec<Vector3<f64>>>,
    /// Largest tension of each cable since the frame before [N], T × C.
    pub tensions: Vec<Vec<f64>>,
    /// Sum of the contact impulses on each knot since the frame before [N s], T × K.
    pub contact_impulses: Vec<Vec<Vector3<f64>>>,
    /// The target, T, or nothing without one.
    pub target: Vec<Body>,
    /// Bodies that effects brought, such as a free chaser.
    pub brought: Vec<BodyTrack>,
    /// The energy ledger, T.
    pub ledger: Vec<Ledger>,
    /// Linear momentum of net and free bodies [kg m/s], T.
    pub momentum: Vec<Vector3<f64>>,
    /// Angular momentum of the same about the origin [kg m^2/s], T.
    pub angular_momentum: Vec<Vector3<f64>>,
    /// Largest cable tension since the frame before [N], T.
    pub tension: Vec<f64>,
    /// Largest impulse of a hit since the frame before [N s], T.
    pub impulse: Vec<f64>,
    /// Kinetic energy of the net in the frame that moves and turns with the target [J], T; empty without one.
    pub relative_energy: Vec<f64>,
    /// Places along each cable of elements [m], T × C × as many; empty with other cables and without a target.
    pub lines: Vec<Vec<Vec<Vector3<f64>>>>,
    /// What the effects have to say, T × as many as `Run::reading_names`.
    pub readings: Vec<Vec<f64>>,
}

/// A body over time.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyTrack {
    /// What of it does not change.
    pub model: BodyModel,
    /// Pose and motion in every frame, T.
    pub frames: Vec<Body>,
}

impl Frames {
    /// The body of this name that an effect brought.
    pub fn body(&self, name: &str) -> Option<&BodyTrack> {
        self.brought.iter().find(|track| track.model.name == name)
    }
}

/// The largest values of a run, over all steps and not only over frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extremes {
    /// End of the step with the first contact impulse [s].
    pub first_contact: Option<f64>,
    /// Largest normal impulse of one contact within [`crate::hits::HIT`] [N s].
    pub impulse: f64,
    /// Largest contact force [N] (see [`crate::hits`]).
    pub force: f64,
    /// Deepest overlap of a knot and a part [m].
    pub penetration: f64,
    /// Largest cable tension [N].
    pub tension: f64,
    /// Largest elastic strain T / (E A) [-].
    pub strain: f64,
    /// Largest tension over breaking tension [-].
    pub utilisation: f64,
}

/// A finished run.
#[derive(Clone, Debug)]
pub struct Run {
    /// The frames.
    pub frames: Frames,
    /// Projected area of the four bullets [m^2] at the start and after every step.
    pub mouth_area: Vec<f64>,
    /// Time step [s].
    pub step: f64,
    /// First 16 digits of a SHA-256 over the last state: the same bits, the same hash.
    pub state_hash: String,
    /// Largest values.
    pub extremes: Extremes,
    /// Impulse from outside of net and free target [N s].
    pub outside_impulse: Vector3<f64>,
    /// Angular impulse from outside, about the origin [N m s].
    pub outside_angular_impulse: Vector3<f64>,
    /// Work done.
    pub work: Work,
    /// What the world consisted of.
    pub census: Census,
    /// Names of the active effects and how often each acted.
    pub effects: Vec<(&'static str, u64)>,
    /// Names of what the effects have to say in every frame.
    pub reading_names: Vec<String>,
    /// What effects had to say at the end, by name.
    pub reports: Vec<(&'static str, Report)>,
    /// Wall time of the simulation, without building and metrics.
    pub wall: Duration,
}

/// What is said to a run by who hears of its progress: nothing, or whether it goes on.
pub trait Heard {
    /// Whether the run goes on.
    fn goes_on(self) -> bool;
}

impl Heard for () {
    fn goes_on(self) -> bool {
        true
    }
}

impl Heard for ControlFlow<()> {
    fn goes_on(self) -> bool {
        self.is_continue()
    }
}

impl Run {
    /// What an effect had to say in every frame under `name`; empty where none did.
    pub fn reading(&self, name: &str) -> Vec<f64> {
        let Some(column) = self.reading_names.iter().position(|known| known == name) else {
            return Vec::new();
        };
        self.frames.readings.iter().map(|readings| readings[column]).collect()
    }

    /// The threads that effects have to draw.
    pub fn threads(&self) -> impl Iterator<Item = &DrawnThread> {
        self.reports.iter().flat_map(|(_, report)| &report.threads)
    }

    /// Time of the first frame with a number that is not finite [s], if there is one.
    pub fn first_not_finite(&self) -> Option<f64> {
        let frames = &self.frames;
        let is_finite = |frame: usize| {
            let ledger = &frames.ledger[frame];
            let vectors = [frames.momentum[frame], frames.angular_momentum[frame]];
            let numbers = [ledger.own(), ledger.residual(), frames.tension[frame], frames.impulse[frame]];
            let target = frames.target.get(frame).map(|body| body.spin().sum() + body.position.sum());
            numbers.iter().chain(&frames.readings[frame]).chain(&target).all(|number| number.is_finite())
                && vectors.iter().all(|vector| vector.iter().all(|number| number.is_finite()))
        };
        (0..frames.time.len()).find(|&frame| !is_finite(frame)).map(|frame| frames.time[frame])
    }

    /// Runs `case` to its end; `progress` hears of every frame, with the share done, and may end it.
    ///
    /// # Errors
    /// A state that is not a number; `progress` ended it.
    pub fn of<H: Heard>(case: &Case, progress: impl FnMut(f64) -> H) -> Result<Run, Failure> {
        Run::with(case, Vec::new(), progress)
    }

    /// The same with effects that the scene does not know.
    ///
    /// # Errors
    /// A state that is not a number; `progress` ended it.
    pub fn with<H: Heard>(
        case: &Case,
        more: Vec<Interaction>,
        progress: impl FnMut(f64) -> H,
    ) -> Result<Run, Failure> {
        Run::further(case, more, case.scene().duration_s.0, |_, _| true, progress)
    }

    /// Runs `case` to its end and on until `decided` says so of the frames and whether net and target
    /// have met, at most for `at_most` [s].
    ///
    /// Frames beyond the scene's own end are at most 1500, so that memory stays bounded however long the run.
    ///
    /// # Errors
    /// A state that is not a number; `progress` ended it.
    pub fn until<H: Heard>(
        case: &Case,
        at_most: f64,
        decided: impl FnMut(&Frames, bool) -> bool,
        progress: impl FnMut(f64) -> H,
    ) -> Result<Run, Failure> {
        Run::further(case, Vec::new(), at_most, decided, progress)
    }

    fn further<H: Heard>(
        case: &Case,
        more: Vec<Interaction>,
        at_most: f64,
        mut decided: impl FnMut(&Frames, bool) -> bool,
        mut progress: impl FnMut(f64) -> H,
    ) -> Result<Run, Failure> {
        let mut simulation = Simulation::with(case, more);
        let mut recorder = Recorder::start(case, &mut simulation, at_most);
        while !recorder.is_full() {
            simulation.step()?;
            if !recorder.record(case, &mut simulation) {
                continue;
            }
            if !progress(recorder.share_done()).goes_on() {
                return Err(Failure::Interrupted { time: simulation.state.time });
            }
            if recorder.has_passed_end() && decided(&recorder.frames, recorder.has_met()) {
                break;
            }
        }
        Ok(recorder.finish(case, &mut simulation))
    }
}

/// Frames beyond the scene's own end, at most.
const MAX_BEYOND: u64 = 1500;

/// Knot positions in them, at most: 240 MB.
const MAX_POSITIONS_BEYOND: u64 = 10_000_000;

/// Frames beyond the scene's own end of `case`, at most.
fn most_beyond(case: &Case) -> u64 {
    (MAX_POSITIONS_BEYOND / case.net().n_knots().max(1) as u64).clamp(10, MAX_BEYOND)
}

/// Collects what a run leaves behind, for who steps a simulation in a loop of their own; [`Run::of`] is such a loop.
#[derive(Clone)]
pub struct Recorder {
    frames: Frames,
    mouth_area: Vec<f64>,
    extremes: Extremes,
    hits: Hits,
    step: f64,
    bullets: [usize; 4],
    /// Largest values since the last frame.
    tension: f64,
    impulse: f64,
    tensions: Vec<f64>,
    contact_impulses: Vec<Vector3<f64>>,
    /// Steps recorded; those to the scene's own end; those to the end of all.
    done: u64,
    own: u64,
    n_steps: u64,
    /// Steps from frame to frame, to the scene's own end and beyond.
    strides: [u64; 2],
    started: Instant,
}

impl Recorder {
    /// Records the start of `simulation` of `case`, which goes on for at most `at_most` [s]: beyond the scene's own end
    /// frames are as far apart as that asks for.
    pub fn start(case: &Case, simulation: &mut Simulation, at_most: f64) -> Recorder {
        let own = case.n_steps();
        let n_steps = own.max((at_most / case.time_step().step).round() as u64);
        let stride = case.steps_per_frame();
        let mut recorder = Recorder {
            frames: Frames::default(),
            mouth_area: Vec::with_capacity(own as usize + 1),
            extremes: Extremes::default(),
            hits: Hits::default(),
            step: case.time_step().step,
            bullets: case.net().bullets,
            tension: 0.0,
            impulse: 0.0,
            tensions: vec![0.0; case.net().cables.len()],
            contact_impulses: vec![Vector3::zeros(); case.net().n_knots()],
            done: 0,
            own,
            n_steps,
            strides: [stride, stride.max((n_steps - own).div_ceil(most_beyond(case)))],
            started: Instant::now(),
        };
        let brought = simulation.state.body_models.iter().filter(|model| !model.has_shape());
        recorder.frames.brought =
            brought.map(|model| BodyTrack { model: model.clone(), frames: Vec::new() }).collect();
        recorder.mouth_area.push(recorder.area(&case.net().folded));
        recorder.frame(case, simulation);
        recorder
    }

    /// Records the step that `simulation` has just done; whether it is a frame.
    pub fn record(&mut self, case: &Case, simulation: &mut Simulation) -> bool {
        self.step(case, &simulation.state);
        self.done += 1;
        let stride = self.strides[usize::from(self.done > self.own)];
        let is_frame = self.done.is_multiple_of(stride) || self.done == self.own || self.done == self.n_steps;
        if is_frame {
            self.frame(case, simulation);
        }
        is_frame
    }

    /// The frames so far.
    pub fn frames(&self) -> &Frames {
        &self.frames
    }

    /// Whether net and target have met.
    pub fn has_met(&self) -> bool {
        self.extremes.first_contact.is_some()
    }

    /// Whether the scene's own end is reached.
    pub fn has_passed_end(&self) -> bool {
        self.done >= self.own
    }

    /// Whether the end of all is reached.
    pub fn is_full(&self) -> bool {
        self.done >= self.n_steps
    }

    /// Share of all steps that is done [-].
    pub fn share_done(&self) -> f64 {
        self.done as f64 / self.n_steps as f64
    }

    /// The run that ends with `simulation` as it is now, which is its last frame.
    pub fn finish(mut self, case: &Case, simulation: &mut Simulation) -> Run {
        if self.frames.time.last() != Some(&simulation.state.time) {
            self.frame(case, simulation);
        }
        let names = simulation.effect_names();
        Run {
            frames: self.frames,
            mouth_area: self.mouth_area,
            step: self.step,
            state_hash: simulation.state.hash(),
            extremes: self.extremes,
            outside_impulse: simulation.audit.outside_impulse,
            outside_angular_impulse: simulation.audit.outside_angular_impulse,
            census: simulation.census(),
            reading_names: simulation.columns(),
            reports: simulation.reports(),
            effects: names.into_iter().zip(simulation.audit.effect_counts.iter().copied()).collect(),
            work: Work { effects: simulation.effect_times().to_vec(), ..simulation.work },
            wall: self.started.elapsed(),
        }
    }

    /// Area of the quadrilateral of the bullets, projected on the plane X = 0 [m^2].
    pub fn area(&self, position: &[Vector3<f64>]) -> f64 {
        let [a, b, c, d] = self.bullets.map(|bullet| position[bullet]);
        0.5 * (c - a).cross(&(d - b)).x.abs()
    }

    fn step(&mut self, case: &Case, state: &State) {
        self.mouth_area.push(self.area(&state.knots.position));
        for contact in &state.contacts {
            if contact.impulse > 0.0 {
                self.extremes.first_contact.get_or_insert(state.time);
            }
            self.extremes.penetration = self.extremes.penetration.max(-contact.gap);
            let impulse = contact.impulse_on_knot();
            if impulse != Vector3::zeros() {
                for (knot, share) in contact.bearers() {
                    self.contact_impulses[knot] += share * impulse;
                }
            }
        }
        let hardest = self.hits.record(&state.contacts, state.time, self.step);
        self.impulse = self.impulse.max(hardest.impulse);
        self.extremes.force = self.extremes.force.max(hardest.force);
        for (index, (cable, &tension)) in case.net().cables.iter().zip(&state.tension).enumerate() {
            // One that was larger since the last frame has told all of it.
            if tension > self.tensions[index] {
                self.tensions[index] = tension;
                self.tension = self.tension.max(tension);
                let extremes = &mut self.extremes;
                extremes.strain = extremes.strain.max(tension / (cable.stiffness * cable.rest_length));
                extremes.utilisation = extremes.utilisation.max(tension / cable.breaking_tension);
            }
        }
        self.extremes.impulse = self.extremes.impulse.max(self.impulse);
        self.extremes.tension = self.extremes.tension.max(self.tension);
    }

    fn frame(&mut self, case: &Case, simulation: &mut Simulation) {
        let readings = simulation.values();
        let (state, frames) = (&simulation.state, &mut self.frames);
        frames.readings.push(readings);
        frames.time.push(state.time);
        frames.knots.push(state.knots.position.clone());
        frames.velocities.push(state.knots.velocity.clone());
        frames.tensions.push(self.tensions.clone());
        frames.contact_impulses.push(self.contact_impulses.clone());
        self.tensions.fill(0.0);
        self.contact_impulses.fill(Vector3::zeros());
        if let (Some(elements), Some(_)) = (&state.elements, state.target()) {
            let lines =
                (0..elements.ends.len()).map(|cable| elements.line(cable, &state.knots, &state.inner));
            frames.lines.push(lines.collect());
        }
        frames.target.extend(state.target());
        let brought = state.each_body().filter(|(model, _)| !model.has_shape());
        for (track, (_, body)) in frames.brought.iter_mut().zip(brought) {
            track.frames.push(*body);
        }
        frames.ledger.push(simulation.audit.ledger.clone());
        frames.momentum.push(simulation.audit.momentum(state));
        frames.angular_momentum.push(simulation.audit.angular_momentum(state));
        frames.tension.push(std::mem::take(&mut self.tension));
        frames.impulse.push(std::mem::take(&mut self.impulse));
        frames
            .relative_energy
            .extend(state.target().map(|body| relative_energy(&case.net().mass, state, body)));
    }
}

/// Kinetic energy of the net in the frame that moves and turns with the target [J].
fn relative_energy(mass: &[f64], state: &State, body: &Body) -> f64 {
    if let Some(elements) = &state.elements {
        let mut energy = 0.0;
        elements.mass_points(&state.knots, &state.inner, |mass, x, v| {
            energy += 0.5 * mass * (v - body.velocity_at(*x)).norm_squared();
        });
        return energy;
    }
    let knots = state.knots.position.iter().zip(&state.knots.velocity).zip(mass);
    knots.map(|((x, v), mass)| 0.5 * mass * (v - body.velocity_at(*x)).norm_squared()).sum()
}
