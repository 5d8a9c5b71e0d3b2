//! The debris: convex parts held together, their mass, and where the body starts.

pub mod files;
pub mod import;
pub mod moments;
pub mod parts;
pub mod spec;
