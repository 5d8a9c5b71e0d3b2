//! What a scene may call for beside cables and contact: one file each, and one line in the list.
//!
//! An effect that a scene does not name is absent: no body, no collider, no joint, no call. One that it
//! names owes parameters with units and limits, and builds an [`Interaction`] from them: forces, kicks,
//! constraints or contacts, and what they do to energy and momentum, which goes to its own row of the
//! audit. Each has its own timer and counter.

pub mod blocks;
pub mod cabin;
pub mod cable_contact;
pub mod chaser;
pub mod closing;
pub mod drag;
mod field;
pub mod friction;
pub mod orbit;
pub mod self_contact;
pub mod tug;

use nalgebra::Vector3;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};

use crate::interaction::Interaction;
use crate::options::{BuildContext, BuildOptions};
use crate::problems::Problems;
use crate::read::join;
use crate::target::files::Files;
use blocks::SummaryRow;

/// What a scene says of an effect.
pub trait Parameters {
    /// How tables show its block of the summary.
    const ROWS: &'static [SummaryRow] = &[];

    /// The schema of that block; none: it says nothing at the end.
    fn summary(_generator: &mut SchemaGenerator) -> Option<Schema> {
        None
    }

    /// Reads the files it names, and checks what no single value shows; faults go to `problems`.
    fn load(&mut self, _files: &Files, _place: &str, _problems: &mut Problems) {}

    /// Numbers that came from files: part of the scene's hash.
    fn loaded(&self) -> Vec<f64> {
        Vec::new()
    }

    /// What it asks of the method and of other effects, before anything is built.
    fn ask(&self, _options: &mut BuildOptions) {}

    /// The shots of the bullets [m/s] as they deviate in `member` of an ensemble.
    fn disperse(&self, shots: [Vector3<f64>; 4], _member: u64) -> [Vector3<f64>; 4] {
        shots
    }

    /// The effect at work on what `context` holds.
    fn build(&self, context: &BuildContext<'_>) -> Interaction;
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

            /// Keys of those that are named, in the order of the list.
            pub fn named(&self) -> impl Iterator<Item = &'static str> {
                let named = [$((stringify!($name), self.$name.is_some())),*];
                named.into_iter().filter(|(_, is_named)| *is_named).map(|(name, _)| name)
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

            /// What the named effects ask for.
            pub fn options(&self) -> BuildOptions {
                let mut options = BuildOptions::default();
                $(if let Some(parameters) = &self.$name {
                    parameters.ask(&mut options);
                })*
                options
            }

            /// The shots of the bullets [m/s] as they deviate in `member` of an ensemble.
            pub fn disperse(&self, shots: [Vector3<f64>; 4], member: u64) -> [Vector3<f64>; 4] {
                $(let shots = match &self.$name {
                    Some(parameters) => parameters.disperse(shots, member),
                    None => shots,
                };)*
                shots
            }

            /// How tables show the block that the effect called `name` has in the summary.
            pub fn rows(name: &str) -> &'static [SummaryRow] {
                match name {
                    $(stringify!($name) => <$parameters>::ROWS,)*
                    _ => &[],
                }
            }

            /// Schemas of the blocks that effects may have in the summary.
            pub fn summaries(generator: &mut SchemaGenerator) -> Vec<(&'static str, Schema)> {
                let mut list = Vec::new();
                $(list.extend(<$parameters>::summary(generator).map(|schema| (stringify!($name), schema)));)*
                list
            }

            /// The named effects, in the order of the list, whatever their order in the scene.
            pub fn build(&self, context: &BuildContext<'_>) -> Vec<Interaction> {
                let mut list = Vec::new();
                $(if let Some(parameters) = &self.$name {
                    list.push(Interaction { name: stringify!($name), ..parameters.build(context) });
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
    /// Drag of the air on net and target.
    drag: drag::Drag,
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
