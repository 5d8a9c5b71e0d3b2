//! Tether-net capture of tumbling space debris, simulated on the Rapier rigid-body engine.
//!
//! A net is shot from a chaser by four flying weights (bullets), opens, meets a satellite or rocket
//! stage that may be tumbling, and wraps it. Will it hold? This crate answers with a trajectory, an
//! energy balance and a verdict, and says what the answer costs.
//!
//! ```
//! use tumblenet::{case::Case, metrics::deployment::Deployment, run::Run};
//!
//! let shorter = ["duration_s=0.1".to_owned(), "expect=null".to_owned()];
//! let case = Case::load("deployment-kevlar", &shorter)?;
//! let run = Run::of(&case, |_| {})?;
//! assert!(Deployment::of(&case, &run).max_area_m2 > 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Flow
//!
//! ```text
//! scene file -> Case -> Simulation -> Run -> Metrics -> Study -> Report
//! (as written) (checked) (world, net,  (frames, (numbers) (many   (tables, files,
//!                         effects,      ledger,            runs)    replay)
//!                         contact)      counters)
//! ```
//!
//! Each takes the value before it and returns the next; no import climbs the list below (`tests/architecture.rs`).
//!
//! # Map, in reading order
//!
//! Down to [`metrics`] this is the package `tumblenet-core` in `core/`, under the same names, and so is what of the last three goes
//! over every knot of every step or frame: that package is optimised, this one is not.
//!
//! | module | subject |
//! |---|---|
//! | [`problems`], [`limits`], [`json`], [`spelling`], [`read`], [`quantity`], [`assets`] | inputs: every fault at once, how much may be asked for, text to values, other ways to write them, the schema, what is built in |
//! | [`state`] | the nouns that travel in a step |
//! | [`cable`], [`friction`] | the tension law; the friction laws |
//! | [`solver`] | the numerical method as a user chooses it |
//! | [`net`] | knots, cables, bullets; fold and launch |
//! | [`geometry`], [`target`] | hulls; shapes, mass properties, pose and spin |
//! | [`work`], [`failure`] | what a step cost; what ends a run |
//! | [`world`] | the engine behind our words; every engine setting |
//! | [`contact`] | how contacts are found and solved: one pipeline, one row |
//! | [`interaction`] | the contracts between what a scene calls for and the methods that step it |
//! | [`options`], [`step`] | what is built from what; a step with joints of the engine, or with a net of our own: mass-spring, or finite elements |
//! | [`closing`] | threads, winches, triggers, locks |
//! | [`field`] | gravity and frames that turn |
//! | [`effects`] | what a scene may call for |
//! | [`audit`] | where energy and momentum went |
//! | [`parameter`] | values that vary: lists, distributions, what is drawn from them |
//! | [`scene`], [`case`](mod@case) | as written; as checked |
//! | [`hits`] | how hard a contact is, whatever the step |
//! | [`simulation`], [`run`] | the step, the record |
//! | [`metrics`] | deployment, capture, conservation, summary |
//! | [`study`], [`report`] | many runs; tables, files, figures, replay |
//!
//! # Conventions
//!
//! SI units and radians in the code; a file key carries its unit. The local frame O-XYZ has its
//! origin at the centre of the net container, X along the travelling direction, Y to the left, Z up.
//! The body frame o-xyz has its origin at the target's centre of mass. Equations, tables and
//! sections without another source are those of M. Shan, "Net Deployment and Contact Dynamics of
//! Capturing Space Debris Objects", dissertation, TU Delft; "the source" is that work.

#![warn(clippy::too_many_lines)]

// The physics, in the order of `core/src/lib.rs`.
#[doc(inline)]
pub use tumblenet_core::*;

pub mod provenance;

pub mod metrics;

pub mod study;

pub mod report;
