//! From numbers to files and tables.

pub mod files;
pub mod replay;
pub mod results;
pub mod table;
