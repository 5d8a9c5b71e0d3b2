//! What every command that reads a scene lets the user say about reading it.

use std::time::Duration;

use clap::Args;
use tumblenet::limits::Limits;
use tumblenet::problems::Problems;

use super::interrupt;

/// Limits of what a scene may ask for.
#[derive(Args)]
pub struct Reading {
    /// Raises or lowers a limit on what a scene may ask for: text, mesh (bytes), knots, steps, positions, parts, points,
    /// triangles, splits, members, memory (bytes), work (cable steps), cuts (parts of a step).
    #[arg(long = "limit", value_name = "NAME=N")]
    limits: Vec<String>,
    /// Ends the program, with status 1, when it has run so long: `90s`, `5min`, `2h`; what is finished is kept.
    #[arg(long, value_name = "TIME", value_parser = time)]
    time_limit: Option<Duration>,
    /// Lets a scene name shape and mesh files outside of its folder.
    #[arg(long)]
    allow_outside: bool,
}

impl Reading {
    /// The limits, as changed; the time limit begins to count.
    pub fn limits(&self) -> Result<Limits, Problems> {
        if let Some(limit) = self.time_limit {
            interrupt::after(limit);
        }
        let mut limits = Limits::default().allowing_outside(self.allow_outside);
        limits.set(&self.limits)?;
        Ok(limits)
    }
}

/// A time with its unit; without one, seconds.
pub fn time(text: &str) -> Result<Duration, String> {
    let units = [("min", 60.0), ("h", 3600.0), ("s", 1.0), ("", 1.0)];
    let seconds = units.into_iter().find_map(|(unit, factor)| {
        let number = text.strip_suffix(unit)?.trim().parse::<f64>().ok()?;
        Some(factor * number)
    });
    let known = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    known.ok_or_else(|| "a time of at least 0 s, as in 60s, 5min or 1h".to_owned())
}
