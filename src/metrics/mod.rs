//! Numbers from a run: deployment, capture, conservation, and the summary that holds them.

#[doc(inline)]
pub use tumblenet_core::metrics::*;

pub mod summary;
