//! A run beside an experiment: how far they are apart, and which parameters bring them together (Section 3.5.2).
//!
//! An experiment is a set of [`tracks`]: where markers on the net were seen, and when. A run is a set of [`paths`]: where
//! all its knots were. [`align`] puts the clock and the frame of the one into those of the other; [`residual`] says what is
//! left; [`fit`] makes it least.

pub mod checked;
pub mod fit;
pub mod found;
pub mod residual;
pub mod spec;
pub mod uncertainty;

#[doc(inline)]
pub use tumblenet_core::study::experiment::{align, paths, tracks};
