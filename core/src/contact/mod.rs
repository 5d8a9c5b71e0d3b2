//! How contacts are found and solved: one pipeline, one row, solvers that read nothing else.
//!
//! | file | subject |
//! |---|---|
//! | [`row`], [`inertia`] | the row that every contact becomes; how the target answers an impulse |
//! | [`work`], [`plane`] | work of a contact's impulses; a contact between two detections |
//! | [`schedule`] | when to detect |
//! | [`friction`], [`woodbury`], [`gauss_seidel`], [`penalty`] | from rows to impulses |
//! | [`lookahead`], [`solver`] | the engine's next rows; all solvers behind one call |
//! | [`cable_planes`], [`surface`] | places on cables; net against target, from detection to record |
//! | [`strands`] | the net against itself |
//! | [`engine`], [`manager`] | the engine's own contacts, read back; who owns `State::contacts` |

// The order is the reading order.
pub mod row;

pub mod inertia;

pub mod work;

pub mod plane;

pub mod schedule;

pub mod friction;

pub mod woodbury;

pub mod gauss_seidel;

pub mod penalty;

pub mod lookahead;

pub mod solver;

pub mod cable_planes;

pub mod surface;

pub mod strands;

pub mod engine;

pub mod manager;

pub use inertia::InverseInertia;
pub use manager::{ContactManager, ContactSettings};
pub use row::{ContactRow, NetMotion};
