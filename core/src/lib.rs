//! The physics of [tumblenet](../tumblenet/index.html): from a scene to the record of a run, and what is measured of it.
//!
//! A package of its own because how well a package is optimised is said once for all of it. Everything here is under the same
//! name in `tumblenet`, whose first page is the map of the code and says what holds everywhere.

#![warn(clippy::too_many_lines)]

// The order is the reading order of the map, not the alphabet.
pub mod problems;

pub mod limits;

pub mod json;

pub mod spelling;

pub mod read;

pub mod quantity;

pub mod assets;

pub mod state;

pub mod cable;

pub mod friction;

pub mod solver;

pub mod net;

pub mod geometry;

pub mod target;

pub mod work;

pub mod failure;

pub mod world;

pub mod contact;

pub mod interaction;

pub mod options;

pub mod step;

pub mod closing;

pub mod field;

pub mod effects;

pub mod audit;

pub mod parameter;

pub mod scene;

pub mod case;

pub mod hits;

pub mod simulation;

pub mod run;

pub mod metrics;

pub mod study;

pub mod report;
