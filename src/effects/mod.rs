//! What a scene may call for beside cables and contact: one file each, and one line in the list.
//!
//! An effect that a scene does not name is absent: no body, no collider, no joint, no call. One
//! that it names owes: parameters with units and limits (read from the scene), what it asks of the
//! world, its force, its stored energy, and what it did to energy and momentum within a step,
//! which goes to its own row of the ledger. Each has its own timer and counter.

pub mod friction;

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::plan::Plan;
use crate::state::{Loads, State};

/// What an effect owes.
pub trait Effect: Send {
    /// Its key in the scene.
    fn name(&self) -> &'static str;

    /// What it asks of the world before that is built.
    fn install(&self, _plan: &mut Plan) {}

    /// What that is, in words, for `tumblenet show`.
    fn installs(&self) -> String;

    /// Whether it applies forces; one that does not is not called for them.
    fn acts(&self) -> bool {
        false
    }

    /// Adds its forces on knots and target for the coming step.
    fn act(&mut self, _state: &State, _loads: &mut Loads) {}

    /// Energy it holds in `state` [J].
    fn stored_energy(&self, _state: &State) -> f64 {
        0.0
    }

    /// What it did within the step that led from `before` to `after`.
    fn account(&mut self, before: &State, after: &State) -> Posting;
}

/// What an effect did within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Posting {
    /// Work it put into net and target, beyond what it stores [J]; negative when it took energy out.
    pub work: f64,
    /// Impulse from outside of net and target [N s].
    pub impulse: Vector3<f64>,
    /// Angular impulse from outside, about the origin [N m s].
    pub angular_impulse: Vector3<f64>,
    /// Times it acted: contacts, knots or whatever it works on.
    pub count: u64,
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
            /// The named effects, in the order of the list, whatever their order in the scene.
            pub fn build(&self) -> Vec<Box<dyn Effect>> {
                let mut list: Vec<Box<dyn Effect>> = Vec::new();
                $(if let Some(parameters) = &self.$name {
                    list.push(parameters.build());
                })*
                list
            }
        }
    };
}

effects! {
    /// Friction between net and target.
    friction: friction::Friction,
}
