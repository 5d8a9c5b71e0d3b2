//! Many runs: a study is a function from cases to summaries.

pub mod ensemble;
