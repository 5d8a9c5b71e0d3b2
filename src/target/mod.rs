//! Target.
pub mod spec;
