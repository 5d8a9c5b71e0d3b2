//! Where the knots of a run and the markers of an experiment were, in one clock and one frame.

pub mod align;
pub mod paths;
pub mod tracks;
