//! The engine in 64 bits.

use rapier3d as rapier;

#[path = "engine.rs"]
pub mod engine;
