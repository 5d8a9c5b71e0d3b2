//! What every command that reads a scene lets the user say about reading it.

use clap::Args;
use tumblenet::limits::Limits;
use tumblenet::problems::Problems;

/// Limits of what a scene may ask for.
#[derive(Args)]
pub struct Reading {
    /// Raises or lowers a limit on what a scene may ask for: text, mesh (bytes), knots, steps, positions, parts, points, triangles, members.
    #[arg(long = "limit", value_name = "NAME=N")]
    limits: Vec<String>,
    /// Lets a scene name shape and mesh files outside of its folder.
    #[arg(long)]
    allow_outside: bool,
}

impl Reading {
    /// The limits, as changed.
    pub fn limits(&self) -> Result<Limits, Problems> {
        let mut limits = Limits::default().allowing_outside(self.allow_outside);
        limits.set(&self.limits)?;
        Ok(limits)
    }
}
