//! Many runs: a study is a function from cases to summaries.

pub mod compare;
pub mod cost;
pub mod ensemble;
pub mod experiment;
pub mod settle;
pub mod stress;
pub mod survival;
pub mod sweep;

/// Quantile of 97.5 % of the standard normal distribution: half an interval of 95 %, in standard deviations.
pub const Z: f64 = 1.959_963_984_540_054;
