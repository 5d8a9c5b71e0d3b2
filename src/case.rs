//! A case: a scene that was checked, with its net and target built.
//!
//! Past this point nothing is checked again: a `Case` exists only when every check has passed.

use sha2::{Digest, Sha256};

use crate::net::Net;
use crate::problems::Problems;
use crate::scene::schema::Scene;
use crate::scene::{Source, checks};
use crate::target::Target;

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
}

impl Case {
    /// Finds, changes, reads and checks a scene: `scene` is a file or the name of a built-in one,
    /// `changes` as for [`Source::set`].
    ///
    /// # Errors
    /// Every fault at once.
    pub fn load(scene: &str, changes: &[String]) -> Result<Case, Problems> {
        let mut source = Source::find(scene)?;
        source.set(changes)?;
        Case::build(&source)
    }

    /// Reads and checks a scene that was found.
    ///
    /// # Errors
    /// Every fault at once.
    pub fn build(source: &Source) -> Result<Case, Problems> {
        let mut problems = Problems::new(&source.input);
        let case = source.scene(&mut problems).and_then(|scene| {
            checks::check_scene(&scene, &mut problems);
            let net = Net::build(&scene.net, &scene.launch, &mut problems);
            let target = scene
                .target
                .as_ref()
                .map(|spec| Target::build(spec, source.folder.as_deref(), "target", &mut problems));
            let net = net?;
            let target = match target {
                Some(None) => return None,
                Some(built) => built,
                None => None,
            };
            checks::check_built(&scene, &net, target.as_ref(), &mut problems);
            let hash = hash(&scene, target.as_ref());
            Some(Case { name: source.name.clone(), scene, hash, net, target })
        });
        problems.into_result(case)
    }

    /// Number of steps of the run.
    pub fn n_steps(&self) -> u64 {
        (self.scene.duration_s.0 / self.scene.solver.step_s.0).round().max(1.0) as u64
    }

    /// Steps between two recorded frames.
    pub fn steps_per_frame(&self) -> u64 {
        (self.scene.output.sample_s.0 / self.scene.solver.step_s.0).round().max(1.0) as u64
    }
}

/// The scene names its shape; what the shape turned out to be enters through the target's numbers.
fn hash(scene: &Scene, target: Option<&Target>) -> String {
    let mut hasher = Sha256::new();
    // A scene is plain data: strings, numbers and lists always become JSON.
    hasher.update(serde_json::to_string(scene).unwrap_or_default());
    if let Some(target) = target {
        let numbers = target.inertia.iter().chain(target.samples.iter().flat_map(|sample| sample.iter()));
        for number in numbers.chain([&target.mass, &target.hull_volume, &target.hull_surface]) {
            hasher.update(number.to_le_bytes());
        }
    }
    hasher.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}
