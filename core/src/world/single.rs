//! The engine in 32 bits: the same files again, against its other build.

use rapier3d_f32 as rapier;

#[path = "engine.rs"]
#[expect(clippy::duplicate_mod, reason = "one source for both builds keeps them the same")]
pub mod engine;
