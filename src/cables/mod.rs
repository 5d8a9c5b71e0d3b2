//! How cable tension acts on the knots.
//!
//! One file a model: as joints of the engine ([`joints`]), or as a mass-spring net of our own
//! ([`explicit`]). Which contact response goes with which is in [`crate::method`].

pub mod explicit;
pub mod joints;
pub mod located;
