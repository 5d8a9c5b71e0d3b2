//! How cable tension acts on the knots.
//!
//! One file a model; each keeps the same two promises to a step: `prepare` before the world moves,
//! `observe` after it.

pub mod joints;
