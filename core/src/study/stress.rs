//! The numbers that hard cases must hold.

pub mod measure;
