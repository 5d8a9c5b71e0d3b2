//! From numbers to files and tables.

pub mod compare;
pub mod files;
pub mod plots;
pub mod replay;
pub mod results;
pub mod table;

mod template;
