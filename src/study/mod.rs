//! Many runs: a study is a function from cases to summaries.

pub mod compare;
pub mod cost;
pub mod ensemble;
pub mod settle;
pub mod stress;
pub mod survival;
pub mod sweep;
