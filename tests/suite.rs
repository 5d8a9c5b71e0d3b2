//! The tests from outside of the library, in one program: linked once, and busy on all cores to its end.
//!
//! `cargo test --test suite verdict::` runs those of one file. On their own stand what counts the memory (`fuzz`) or the
//! instructions (`instructions`) of its process.

mod common;

mod ancf;
mod ancf_capture;
mod architecture;
mod audit;
mod capture;
mod chaser;
mod closing;
mod compare;
mod cost;
mod counts;
mod dependency;
mod deployment;
mod determinism;
mod drag;
mod effects;
mod energy;
mod engine_facts;
mod examples;
mod exchange;
mod experiments;
mod fields;
mod figure;
mod first_minutes;
mod invariants;
mod kills;
mod models;
mod optimise;
mod precision;
mod profiles;
mod program;
mod random_scenes;
mod readme;
mod replay;
mod report;
mod reproduce;
mod robust;
mod scenes;
mod schemas;
mod sensitivity;
mod sliding;
mod solvers;
mod strands;
mod stress;
mod sweep;
mod uncertain;
mod verdict;
