//! Numbers from a run: deployment, capture, conservation.

pub mod capture;
pub mod conservation;
pub mod deployment;
pub mod inside;
pub mod mouth;
pub mod retention;
pub mod verdict;
pub mod warnings;
