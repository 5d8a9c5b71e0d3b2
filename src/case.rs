//! A case: a scene that was checked, with its net and target built.
//!
//! Past this point nothing is checked again: a `Case` exists only when every check has passed.

use sha2::{Digest, Sha256};

use crate::contact::penalty::Penalty;
use crate::limits::Limits;
use crate::net::{self, Net};
use crate::options::BuildOptions;
use crate::problems::Problems;
use crate::quantity::Positive;
use crate::scene::schema::Scene;
use crate::scene::{Source, checks};
use crate::solver::{CableModel, ContactModel, JOINTS_STEP};
use crate::step::mass_spring::stability::{self, RESOLVES, SAFE};
use crate::target::Target;
use crate::target::files::Files;

/// A checked scene and what it is made of.
#[derive(Clone)]
pub struct Case {
    /// Name for results and messages.
    pub name: String,
    /// The scene, every default filled in.
    pub scene: Scene,
    /// First 16 digits of a SHA-256 over the scene and the built target.
    pub hash: String,
    /// The net.
    pub net: Net,
    /// The target, where the scene has one.
    pub target: Option<Target>,
    /// The step, chosen where the scene leaves it out.
    pub time_step: TimeStep,
    /// How much it may ask for while it runs.
    pub limits: Limits,
}

/// Steps and sub-steps of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeStep {
    /// A step of the simulation [s].
    pub step: f64,
    /// Sub-steps within it: of the engine with `joints`, of the integration with `explicit` cables.
    pub substeps: u32,
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

    /// Reads and checks a scene that was found.
    ///
    /// # Errors
    /// Every fault at once.
    pub fn build(source: &Source) -> Result<Case, Problems> {
        let mut problems = Problems::new(&source.input);
        let limits = &source.limits;
        let files = Files::of(source.folder.as_deref(), limits);
        // Net and target, and every fault that does not need both.
        let parts = |scene: &mut Scene, problems: &mut Problems| {
            checks::check_scene(scene, limits, problems);
            scene.effects.load(&files, problems);
            let net = checks::check_knots(&scene.net, limits, problems)
                .then(|| Net::build(&scene.net, &scene.launch, problems))
                .flatten();
            let target = scene.target.as_ref().map(|spec| Target::build(spec, &files, "target", problems));
            (net, target)
        };
        let readable = |mut scene: Scene, problems: &mut Problems| drop(parts(&mut scene, problems));
        let case = source.scene(&mut problems, readable).and_then(|mut scene| {
            let (net, target) = parts(&mut scene, &mut problems);
            let net = net?;
            let target = match target {
                Some(None) => return None,
                Some(built) => built,
                None => None,
            };
            let time_step = choose_step(&scene, &net, target.as_ref());
            checks::check_built(&scene, &net, target.as_ref(), time_step, limits, &mut problems);
            scene.solver.step_s = Some(Positive(match scene.solver.cables {
                CableModel::Joints => time_step.step,
                CableModel::Explicit => time_step.step / f64::from(time_step.substeps),
            }));
            let hash = hash(&scene, target.as_ref());
            let limits = *limits;
            let mut case = Case { name: source.name.clone(), scene, hash, net, target, time_step, limits };
            case.disperse(0);
            Some(case)
        });
        problems.into_result(case)
    }

    /// Shoots the bullets as they deviate in `member` of an ensemble, where the scene names a chaser.
    pub fn disperse(&mut self, member: u64) {
        if let Some(chaser) = &self.scene.effects.chaser {
            self.net.shoot(chaser.disperse(net::shots(&self.scene.net, &self.scene.launch), member));
        }
    }

    /// Number of steps of the run.
    pub fn n_steps(&self) -> u64 {
        (self.scene.duration_s.0 / self.time_step.step).round().max(1.0) as u64
    }

    /// What its solver asks for; effects may add to it.
    pub fn plan(&self) -> BuildOptions {
        let solver = &self.scene.solver;
        BuildOptions {
            step: self.time_step.step,
            substeps: self.time_step.substeps,
            restitution: solver.restitution,
            friction: None,
            contact_by_engine: solver.contact == ContactModel::Rapier,
            free_chaser: false,
            precision: solver.precision,
        }
    }

    /// A sub-step at which an explicit net is stable [s].
    pub fn safe_substep(&self) -> f64 {
        SAFE * stability::stable_step(&self.net)
    }

    /// A step that resolves the cables [s].
    pub fn resolving_step(&self) -> f64 {
        RESOLVES * stability::stable_step(&self.net)
    }

    /// Distance from which responses of our own watch a knot [m].
    pub fn reach(&self) -> f64 {
        reach(&self.scene, &self.net, self.target.as_ref())
    }

    /// Speed of contact that steps are chosen for [m/s]; 0 without a target.
    pub fn contact_speed(&self) -> f64 {
        self.target.as_ref().map_or(0.0, |target| contact_speed(&self.scene, target))
    }

    /// Steps between two recorded frames.
    pub fn steps_per_frame(&self) -> u64 {
        (self.scene.output.sample_s.0 / self.time_step.step).round().max(1.0) as u64
    }
}

/// The step of a scene: its own step where it names one, else one that suits it.
fn choose_step(scene: &Scene, net: &Net, target: Option<&Target>) -> TimeStep {
    let solver = &scene.solver;
    let safe = safe_step(scene, net, target);
    let sample = scene.output.sample_s.0.min(scene.duration_s.0);
    let thin = thin_step(scene, target);
    match (solver.cables, solver.step_s) {
        (CableModel::Joints, Some(step)) => TimeStep { step: step.0, substeps: solver.substeps },
        (CableModel::Joints, None) if solver.contact == ContactModel::Rapier => {
            TimeStep { step: JOINTS_STEP.min(thin), substeps: solver.substeps }
        }
        // The engine's cables and a response of our own take turns, so neither feels the other
        // within a step: a knot that contact holds lets its neighbour stretch the cable. Energy
        // gained on the free-floating Cubesat, over the launch energy: 3 at 0.5 ms, 0.2 at 0.2 ms,
        // 0.02 at 0.1 ms, 2e-3 at 0.05 ms, where a step resolves the cables.
        (CableModel::Joints, None) => {
            let step = JOINTS_STEP.min(thin).min(safe).min(RESOLVES * stability::stable_step(net));
            TimeStep { step, substeps: solver.substeps }
        }
        (CableModel::Explicit, step) => {
            let substep = step.map_or(safe, |step| step.0);
            // Contacts are found once a step: no knot may come from beyond the reach within it, nor
            // one at twice the speed after a snap.
            // Without a target there is nothing to find: a tenth of the steps sufficed for Table 3.2.
            let found = target.map_or(f64::INFINITY, |_| {
                0.5 * reach(scene, net, target) / fastest(scene, target).max(f64::MIN_POSITIVE)
            });
            let step = JOINTS_STEP.min(sample).min(thin).min(found).max(substep);
            TimeStep { step, substeps: (step / substep).ceil().max(1.0) as u32 }
        }
    }
}

/// Speed of the fastest that is to meet: bullets, and the target's farthest point [m/s].
pub fn fastest(scene: &Scene, target: Option<&Target>) -> f64 {
    scene.launch.speed_m_s + target.map_or(0.0, |target| target.spin.norm() * target.bounding_radius)
}

/// Largest step within which no knot crosses half of the target's thinnest part [s]: past the middle
/// of a part a knot is pushed out on its far side. Infinite without a target.
pub fn thin_step(scene: &Scene, target: Option<&Target>) -> f64 {
    target.map_or(f64::INFINITY, |built| 0.5 * built.thinnest / fastest(scene, target))
}

/// Distance from which responses of our own watch a knot [m].
pub fn reach(scene: &Scene, net: &Net, target: Option<&Target>) -> f64 {
    let thinnest = target.map_or(0.0, |target| target.thinnest);
    let thickest = net.radius.iter().copied().fold(0.0, f64::max);
    scene.solver.reach_m.map_or((0.04 * thinnest).max(2.0 * thickest), |reach| reach.0)
}

/// Largest step at which the explicit parts of the method are stable [s]; infinite without any.
pub fn stable_step(scene: &Scene, net: &Net, target: Option<&Target>) -> f64 {
    let solver = &scene.solver;
    let mut limit = f64::INFINITY;
    if solver.cables == CableModel::Explicit {
        limit = stability::stable_step(net);
    }
    if let (ContactModel::Penalty, Some(target)) = (solver.contact, target) {
        let speed = contact_speed(scene, target);
        limit = limit.min(Penalty::new(net, &solver.penalty, None).stable_step(net, speed));
    }
    limit
}

/// Step at which the explicit parts of the method are stable together [s]; infinite without any.
pub fn safe_step(scene: &Scene, net: &Net, target: Option<&Target>) -> f64 {
    let has_force = scene.solver.contact == ContactModel::Penalty && target.is_some();
    let has_threads = scene.effects.closing.is_some() || scene.effects.tug.is_some();
    let share = if has_force || has_threads { RESOLVES } else { SAFE };
    share * stable_step(scene, net, target)
}

/// Speed of a contact, at most: a snap can double a knot's speed [m/s].
fn contact_speed(scene: &Scene, target: &Target) -> f64 {
    2.0 * scene.launch.speed_m_s + target.spin.norm() * target.bounding_radius
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
    hasher.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}
