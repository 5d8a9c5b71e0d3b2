//! What a scene may call for beside cables and contact: one file each, and one line in the list.
//!
//! An effect that a scene does not name is absent: no body, no collider, no joint, no call. One
//! that it names owes: parameters with units and limits (read from the scene), what it asks of the
//! world, its force, its stored energy, and what it did to energy and momentum within a step,
//! which goes to its own row of the ledger. Each has its own timer and counter.

pub mod cabin;
pub mod cable_contact;
pub mod chaser;
pub mod closing;
mod field;
pub mod friction;
pub mod orbit;
pub mod self_contact;
pub mod tug;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::closing::Mechanism;
use crate::net::Net;
use crate::options::{BuildOptions, Setting};
use crate::problems::Problems;
use crate::read::join;
use crate::state::{Body, Contact, EffectWork, Forces, Knots, State};
use crate::target::Target;
use crate::target::files::Files;

/// What a scene says of an effect.
pub trait Parameters {
    /// Reads the files it names, and checks what no single value shows; faults go to `problems`.
    fn load(&mut self, _files: &Files, _place: &str, _problems: &mut Problems) {}

    /// Numbers that came from files: part of the scene's hash.
    fn loaded(&self) -> Vec<f64> {
        Vec::new()
    }

    /// The effect on `net` and `target`.
    fn build(&self, net: &Net, target: Option<&Target>) -> Box<dyn Effect>;
}

/// What an effect owes.
pub trait Effect: Send {
    /// Its key in the scene.
    fn name(&self) -> &'static str;

    /// What it asks of the world before that is built.
    fn install(&self, _plan: &mut BuildOptions) {}

    /// Builds what depends on the whole scene, after all effects have said what they ask for.
    fn prepare(&mut self, _setting: &Setting<'_>) {}

    /// What that is, in words, for `tumblenet show`.
    fn installs(&self) -> String;

    /// Puts what it brings along into the state at the start.
    fn begin(&self, _state: &mut State) {}

    /// Whether it acts at both ends of a step; one that does not is not called for that.
    fn brackets(&self) -> bool {
        false
    }

    /// Acts before everything else in a step of `step` seconds: changes velocities of knots and bodies,
    /// moves bodies of its own. Returns what it did.
    fn open(&mut self, _state: &mut State, _step: f64) -> EffectWork {
        EffectWork::default()
    }

    /// Acts after everything else in the step, in the reverse order of the list: changes velocities of
    /// knots and bodies.
    fn close(&mut self, _state: &mut State, _step: f64) -> EffectWork {
        EffectWork::default()
    }

    /// Whether it applies forces; one that does not is not called for them.
    fn acts(&self) -> bool {
        false
    }

    /// Adds its forces on knots and target for the coming step.
    fn act(&mut self, _state: &State, _loads: &mut Forces) {}

    /// Hears the state at the start of a step, before its threads pull or its contacts press.
    fn watch(&mut self, _state: &State) {}

    /// Threads of its own, which the cable model has pull in every part of a step: in every sub-step of
    /// explicit cables.
    fn threads(&self) -> Option<&Mechanism> {
        None
    }

    /// The same, to be pulled.
    fn threads_mut(&mut self) -> Option<&mut Mechanism> {
        None
    }

    /// Whether it answers contacts, of net and target or of the net with itself; one that does not is
    /// not called for that.
    fn presses(&self) -> bool {
        false
    }

    /// Answers contacts within the coming (sub-)step of `step` seconds, after all pulls: changes
    /// velocities of knots and target, and marks the knots it changed.
    fn press(&mut self, _knots: &mut Knots, _target: &mut Option<Body>, _step: f64, _touched: &mut [bool]) {}

    /// Adds the contacts it answered within the step from `before` to `after`.
    fn report(&self, _before: &Knots, _after: &Knots, _contacts: &mut Vec<Contact>) {}

    /// Colliders it has the engine detect with, times it did, since the start.
    fn detection(&self) -> (usize, u64) {
        (0, 0)
    }

    /// Whether it acts between net and target, or within the net: it may take energy, and never gives any.
    fn is_internal(&self) -> bool {
        false
    }

    /// Energy it holds in `state` [J].
    fn stored_energy(&self, _state: &State) -> f64 {
        0.0
    }

    /// What it did within the step that led from `before` to `after`.
    fn account(&mut self, before: &State, after: &State) -> EffectWork;

    /// Names of what it has to say in every frame, as columns of the time series.
    fn reading_names(&self) -> Vec<String> {
        Vec::new()
    }

    /// Their values in `state`; largest values are those since the last call.
    fn readings(&mut self, _state: &State) -> Vec<f64> {
        Vec::new()
    }

    /// What a closing mechanism did, if it is one.
    fn closing(&self) -> Option<closing::Report> {
        None
    }

    /// From when to when it tugs at the net [s], once it has started.
    fn tug(&self) -> Option<[f64; 2]> {
        None
    }
}

/// Declares the list of effects: the scene's `effects` object, and how each is built.
macro_rules! effects {
    ($($(#[doc = $doc:literal])* $name:ident: $parameters:ty,)*) => {
        /// Effects that the scene calls for; one that is not named is absent.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Effects {
            $($(#[doc = $doc])*
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub $name: Option<$parameters>,)*
        }

        impl Effects {
            /// Keys of all effects there are, in the order of the list.
            pub const NAMES: &[&str] = &[$(stringify!($name)),*];

            /// Loads what the named effects need from files, and checks each by itself.
            pub fn load(&mut self, files: &Files, problems: &mut Problems) {
                $(if let Some(parameters) = &mut self.$name {
                    parameters.load(files, &join("effects", stringify!($name)), problems);
                })*
            }

            /// Numbers that came from files.
            pub fn loaded(&self) -> Vec<f64> {
                let mut numbers = Vec::new();
                $(numbers.extend(self.$name.iter().flat_map(Parameters::loaded));)*
                numbers
            }

            /// The same without the effect called `name`.
            #[must_use]
            pub fn without(&self, name: &str) -> Effects {
                let mut effects = self.clone();
                $(if name == stringify!($name) {
                    effects.$name = None;
                })*
                effects
            }

            /// The named effects, in the order of the list, whatever their order in the scene.
            pub fn build(&self, net: &Net, target: Option<&Target>) -> Vec<Box<dyn Effect>> {
                let mut list: Vec<Box<dyn Effect>> = Vec::new();
                $(if let Some(parameters) = &self.$name {
                    list.push(parameters.build(net, target));
                })*
                list
            }
        }
    };
}

effects! {
    /// Two-body gravity and the turn of the local frame on an orbit.
    orbit: orbit::Orbit,
    /// Residual gravity and rotation of an aeroplane's cabin.
    cabin: cabin::Cabin,
    /// The chaser, free to recoil, and the dispersion of its shots.
    chaser: chaser::Chaser,
    /// Friction between net and target.
    friction: friction::Friction,
    /// Threads that winches reel in to close the net's mouth.
    closing: closing::Closing,
    /// A pull on the net's centre.
    tug: tug::Tug,
    /// Contact of cables and bullets of the net with each other.
    self_contact: self_contact::SelfContact,
    // Last: nothing then moves the net into the target.
    /// Contact of whole cables with the target, not of knots alone.
    cable_contact: cable_contact::CableContact,
}
