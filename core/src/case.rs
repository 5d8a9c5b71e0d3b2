//! A case: a scene that was checked, with its net and target built.
//!
//! A `Case` is built only when every check has passed. What is changed afterwards, by studies and tests that bring
//! their own net, target or step, goes through [`Case::changed`] or [`Case::with_scene`], which check it again.

pub mod uncertain;

use std::sync::Arc;

use data_encoding::HEXLOWER;
use nalgebra::Vector3;
use sha2::{Digest, Sha256};

use crate::limits::Limits;
use crate::net::{self, Net};
use crate::options::{BuildContext, TimeStep};
use crate::problems::Problems;
use crate::quantity::Positive;
use crate::scene::schema::Scene;
use crate::scene::{Source, checks};
use crate::step;
use crate::step::limits::Demands;
use crate::step::mass_spring::stability::{self, RESOLVES};
use crate::target::Target;
use crate::target::files::Files;
use uncertain::Uncertain;

/// A checked scene and what it is made of.
#[derive(Clone)]
pub struct Case {
    /// Name for results and messages.
    name: String,
    /// The scene, every default filled in.
    scene: Scene,
    /// First 16 digits of a SHA-256 over the scene and the built target.
    hash: String,
    /// What the scene was made into.
    built: Built,
    /// How much it may ask for while it runs.
    limits: Limits,
    /// What is drawn for each member, where something is.
    uncertain: Option<Arc<Uncertain>>,
}

/// What a scene is made into: what a study may bring itself, through [`Case::changed`].
#[derive(Clone)]
pub struct Built {
    /// The net.
    pub net: Net,
    /// The target, where the scene has one.
    pub target: Option<Target>,
    /// The step, chosen where the scene leaves it out.
    pub time_step: TimeStep,
}

impl Built {
    /// Adds what does not hang together or is not a number.
    fn check(&self, problems: &mut Problems) {
        self.net.check(problems);
        self.target.iter().for_each(|target| target.check(problems));
        if !(self.time_step.step.is_finite() && self.time_step.step > 0.0) {
            problems.add("step", self.time_step.step, "a number of seconds above 0");
        }
        if self.time_step.substeps == 0 {
            problems.add("substeps", 0, "at least 1");
        }
    }
}

impl Case {
    /// Finds, changes, reads and checks a scene: `scene` is a file or the name of a built-in one,
    /// `changes` as for [`Source::set`].
    ///
    /// # Errors
    /// Every fault at once.
    pub fn load(scene: &str, changes: &[String]) -> Result<Case, Problems> {
        Case::load_within(scene, changes, Limits::default())
    }

    /// The same, with other limits.
    ///
    /// # Errors
    /// Every fault at once.
    pub fn load_within(scene: &str, changes: &[String], limits: Limits) -> Result<Case, Problems> {
        let mut source = Source::find_within(scene, limits)?;
        source.set(changes)?;
        Case::build(&source)
    }

    /// The same for a user's changes, after which nothing is expected any more: see [`Source::change`].
    ///
    /// # Errors
    /// Every fault at once.
    pub fn load_changed(scene: &str, changes: &[String], limits: Limits) -> Result<Case, Problems> {
        let mut source = Source::find_within(scene, limits)?;
        source.change(changes)?;
        Case::build(&source)
    }

    /// Reads and checks a scene that was found.
    ///
    /// # Errors
    /// Every fault at once.
    pub fn build(source: &Source) -> Result<Case, Problems> {
        let mut case = Case::build_point(source)?;
        if let Some(uncertain) = &case.uncertain {
            let mut problems = Problems::new(&source.input);
            uncertain.check_ends(&mut problems);
            case = problems.into_result(Some(case))?;
        }
        Ok(case)
    }

    /// The same, but what is uncertain is not tried at its ends: for one of many points of a scene that was.
    ///
    /// # Errors
    /// Every other fault at once.
    pub fn build_point(source: &Source) -> Result<Case, Problems> {
        let mut problems = Problems::new(&source.input);
        let limits = &source.limits;
        let files = Files::of(source.folder.as_deref(), limits);
        // Net and target, and every fault that does not need both.
        let parts = |scene: &mut Scene, as_written: bool, problems: &mut Problems| {
            checks::check_scene(scene, limits, problems);
            let uncertain = Uncertain::read(scene, as_written, source, problems);
            scene.effects.load(&files, problems);
            let net = checks::check_knots(&scene.net, limits, problems)
                .then(|| Net::build(&scene.net, &scene.launch, problems))
                .flatten();
            let target = scene.target.as_ref().map(|spec| Target::build(spec, &files, "target", problems));
            (net, target, uncertain)
        };
        let readable = |mut scene: Scene, is_stepped: bool, problems: &mut Problems| {
            let (net, target, _) = parts(&mut scene, false, problems);
            if let (true, Some(net), Some(target)) = (is_stepped, net, all_of(target)) {
                choose_step(&mut scene, &net, target.as_ref(), limits, problems);
            }
        };
        let case = source.scene(&mut problems, readable).and_then(|mut scene| {
            let (net, target, uncertain) = parts(&mut scene, true, &mut problems);
            let (net, target) = (net?, all_of(target)?);
            let time_step = choose_step(&mut scene, &net, target.as_ref(), limits, &mut problems);
            let hash = hash(&scene, target.as_ref());
            let limits = *limits;
            let mut case = Case {
                name: source.name.clone(),
                scene,
                hash,
                built: Built { net, target, time_step },
                limits,
                uncertain,
            };
            case.disperse(0);
            Some(case)
        });
        problems.into_result(case)
    }

    /// Name for results and messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The scene, every default filled in.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// First 16 digits of a SHA-256 over the scene and the built target.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// The net.
    pub fn net(&self) -> &Net {
        &self.built.net
    }

    /// The target, where the scene has one.
    pub fn target(&self) -> Option<&Target> {
        self.built.target.as_ref()
    }

    /// The step, chosen where the scene leaves it out.
    pub fn time_step(&self) -> TimeStep {
        self.built.time_step
    }

    /// How much it may ask for while it runs.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// What is drawn for each member, where something is uncertain.
    pub fn uncertain(&self) -> Option<&Uncertain> {
        self.uncertain.as_deref()
    }

    /// The same with what `change` makes of net, target and step, whether or not the method would have chosen that
    /// step; the scene stays as it is. Nothing in it is drawn any more.
    ///
    /// # Errors
    /// A net that does not hang together: lists of different lengths, cables between knots that are not there,
    /// masses or cables without a positive size. Anything that is not a number.
    pub fn changed(mut self, change: impl FnOnce(&mut Built)) -> Result<Case, Problems> {
        let mut problems = Problems::new(&*self.name);
        self.uncertain = None;
        change(&mut self.built);
        self.built.check(&mut problems);
        problems.into_result(Some(self))
    }

    /// The same with what `change` makes of the scene's method, effects, limits and times; net, target and step
    /// stay as they are. Nothing in it is drawn any more.
    ///
    /// # Errors
    /// Every fault of the changed scene.
    pub fn with_scene(mut self, change: impl FnOnce(&mut Scene)) -> Result<Case, Problems> {
        let mut problems = Problems::new(&*self.name);
        self.uncertain = None;
        change(&mut self.scene);
        checks::check_scene(&self.scene, &self.limits, &mut problems);
        problems.into_result(Some(self))
    }

    /// Shoots the bullets as they deviate in `member` of an ensemble.
    fn disperse(&mut self, member: u64) {
        let shots = net::shots(&self.scene.net, &self.scene.launch);
        let dispersed = self.scene.effects.disperse(shots, member);
        if dispersed != shots {
            self.built.net.shoot(dispersed);
        }
    }

    /// A copy as `member` of an ensemble: bullets shot as they deviate there, folded knots moved by `shift` [m].
    pub fn member(&self, member: u64, mut shift: impl FnMut() -> Vector3<f64>) -> Case {
        let mut case = self.clone();
        case.disperse(member);
        case.built.net.folded.iter_mut().for_each(|position| *position += shift());
        case
    }

    /// Number of steps of the run.
    pub fn n_steps(&self) -> u64 {
        (self.scene.duration_s.0 / self.built.time_step.step).round().max(1.0) as u64
    }

    /// What it demands of a step.
    pub fn demands(&self) -> Demands<'_> {
        demands(&self.scene, &self.built.net, self.built.target.as_ref())
    }

    /// What effects and method are built from.
    pub fn context(&self) -> BuildContext<'_> {
        let demands = self.demands();
        BuildContext {
            net: &self.built.net,
            target: self.built.target.as_ref(),
            solver: &self.scene.solver,
            time_step: self.built.time_step,
            limits: self.limits,
            options: self.scene.effects.options(),
            acts_in_substeps: step::method(&self.scene.solver).acts_in_substeps(),
            contact_margin: demands.contact_margin(),
            contact_speed: demands.contact_speed(),
        }
    }

    /// A step that resolves the cables [s].
    pub fn resolving_step(&self) -> f64 {
        RESOLVES * stability::stable_step(&self.built.net)
    }

    /// Steps between two recorded frames.
    pub fn steps_per_frame(&self) -> u64 {
        (self.scene.output.sample_s.0 / self.built.time_step.step).round().max(1.0) as u64
    }
}

/// The target, or that there is none; none where there is one that could not be built.
fn all_of(target: Option<Option<Target>>) -> Option<Option<Target>> {
    match target {
        Some(None) => None,
        built => Some(built.flatten()),
    }
}

/// The step of a run with `net` and `target`, which is written to `scene`, and what they do not allow it.
fn choose_step(
    scene: &mut Scene,
    net: &Net,
    target: Option<&Target>,
    limits: &Limits,
    problems: &mut Problems,
) -> TimeStep {
    scene.solver.integrator = stability::integrator(scene.solver.integrator, net);
    let demands = demands(scene, net, target);
    let steps = step::method(&scene.solver).limits(&demands);
    checks::check_built(scene, &demands, &steps, limits, problems);
    scene.solver.step_s = Some(Positive(steps.written));
    steps.chosen
}

/// What `scene` demands of a step.
fn demands<'a>(scene: &'a Scene, net: &'a Net, target: Option<&'a Target>) -> Demands<'a> {
    Demands {
        solver: &scene.solver,
        net,
        target,
        launch_speed: scene.launch.top_speed(),
        sample: scene.output.sample_s.0.min(scene.duration_s.0),
        options: scene.effects.options(),
    }
}

/// The scene names its shape; what the shape turned out to be enters through the target's numbers.
fn hash(scene: &Scene, target: Option<&Target>) -> String {
    let mut hasher = Sha256::new();
    // A scene is plain data: strings, numbers and lists always become JSON.
    hasher.update(serde_json::to_string(scene).unwrap_or_default());
    for number in scene.effects.loaded() {
        hasher.update(number.to_le_bytes());
    }
    if let Some(target) = target {
        let numbers = target.inertia.iter().chain(target.samples.iter().flat_map(|sample| sample.iter()));
        for number in numbers.chain([&target.mass, &target.hull_volume, &target.hull_surface]) {
            hasher.update(number.to_le_bytes());
        }
    }
    HEXLOWER.encode(&hasher.finalize()[..8])
}
