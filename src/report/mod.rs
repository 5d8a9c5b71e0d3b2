//! From numbers to files and tables.

pub mod collected;
pub mod columns;
pub mod compare;
pub mod cost;
pub mod dependency;
pub mod ensemble;
pub mod figure;
pub mod files;
pub mod fit;
pub mod gltf;
pub mod grid;
pub mod map;
pub mod optimise;
pub mod page;
pub mod plots;
pub mod recorded;
pub mod replay;
pub mod reproduce;
pub mod residual;
pub mod results;
pub mod rows;
pub mod sensitivity;
pub mod stress;
pub mod survival;
pub mod sweep;
pub mod table;
pub mod text_table;
pub mod vtk;

pub mod template;

#[doc(inline)]
pub use tumblenet_core::report::packed;
