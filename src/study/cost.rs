//! wip
pub mod oracle;
