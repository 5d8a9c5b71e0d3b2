//! What of studies goes over every knot of every step or frame; all else of them is in `tumblenet`.

pub mod experiment;
pub mod stress;
