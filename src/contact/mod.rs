//! How a contact between net and target is answered.
//!
//! One file a response. All speak of the same plain record, [`crate::state::Contact`].

pub mod rapier;
