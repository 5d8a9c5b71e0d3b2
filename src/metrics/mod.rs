//! Numbers from a run: deployment, capture, conservation, and the summary that holds them.

pub mod capture;
pub mod conservation;
pub mod deployment;
pub mod inside;
pub mod mouth;
pub mod retention;
pub mod summary;
pub mod verdict;
pub mod warnings;
