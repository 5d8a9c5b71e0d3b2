//! How much an input may ask for, and which files it may name: a slip of the pen ends in words, not
//! in a machine that stalls, and a scene from elsewhere cannot read the user's files.
//!
//! The limits are the user's, not the scene's: `--limit NAME=N` raises one, `--allow-outside` lets a
//! scene name files outside of its folder.

use std::io::Read;
use std::path::Path;
use std::{fmt, fs, io};

use crate::problems::Problems;

/// What is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Bytes of a scene or shape file, which becomes some thirty times as much memory.
    Text,
    /// Bytes of all mesh files.
    Mesh,
    /// Knots of a net.
    Knots,
    /// Steps of a run; sub-steps with explicit cables.
    Steps,
    /// Recorded knot positions of a run, 24 bytes each and twice while they are written.
    Positions,
    /// Parts of a shape: the hull of 10 000 balls in one place takes 10 s, of capsules 12 s, of cylinders 0.8 s.
    Parts,
    /// Points of all convex parts.
    Points,
    /// Triangles of all meshes: a ball of 190 000 takes 0.8 s, one so rough that every corner is apart 8.3 s, and a net sees
    /// no difference.
    Triangles,
    /// Meshes that are not convex, each of which is split into parts: 0.7 to 1.3 s each where they are as rough.
    Splits,
    /// Members of an ensemble.
    Members,
    /// Bytes of memory that a run is estimated to take.
    Memory,
    /// Cables, summed over all (sub-)steps of a run: 1e12 take days.
    Work,
    /// Parts that steps are cut into within, on average over a run.
    Cuts,
}

/// Each limit with its name, its default and its unit, in the order of [`Limit`].
const TABLE: [(Limit, &str, u64, &str); 13] = [
    (Limit::Text, "text", 8 << 20, "bytes of JSON"),
    (Limit::Mesh, "mesh", 64 << 20, "bytes of meshes"),
    (Limit::Knots, "knots", 250_000, "knots"),
    (Limit::Steps, "steps", 100_000_000, "steps"),
    (Limit::Positions, "positions", 20_000_000, "recorded positions"),
    (Limit::Parts, "parts", 1_000, "parts"),
    (Limit::Points, "points", 50_000, "points"),
    (Limit::Triangles, "triangles", 30_000, "triangles"),
    (Limit::Splits, "splits", 2, "meshes that are not convex"),
    (Limit::Members, "members", 100_000, "members"),
    (Limit::Memory, "memory", 2 << 30, "bytes of memory"),
    (Limit::Work, "work", 1_000_000_000_000, "cable steps"),
    (Limit::Cuts, "cuts", 1000, "parts a step"),
];

/// How much an input may ask for. Within the defaults the worst input that was found, which takes all of them at once, costs
/// `check` 3.2 s of processor time; the one with most memory takes 1 GB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    values: [u64; TABLE.len()],
    /// Whether files outside of the scene's folder may be read.
    pub allow_outside: bool,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { values: TABLE.map(|(_, _, default, _)| default), allow_outside: false }
    }
}

impl Limits {
    /// The same, but files outside of the scene's folder may be read, or may not.
    pub fn allowing_outside(self, allow_outside: bool) -> Limits {
        Limits { allow_outside, ..self }
    }

    /// The largest count of `limit` that is allowed.
    pub fn of(&self, limit: Limit) -> u64 {
        self.values[limit as usize]
    }

    /// Whether `count` is too much; also when it is not a number.
    pub fn exceeded(&self, limit: Limit, count: f64) -> bool {
        count.is_nan() || count > self.of(limit) as f64
    }

    /// What is allowed and how to raise it, for a fault.
    pub fn allowed(&self, limit: Limit) -> String {
        let (_, name, _, unit) = TABLE[limit as usize];
        format!("at most {} {unit} (--limit {name}=N raises it)", self.of(limit))
    }

    /// Name and largest count of each.
    pub fn all(&self) -> impl Iterator<Item = (&'static str, u64)> {
        TABLE.iter().zip(self.values).map(|((_, name, _, _), value)| (*name, value))
    }

    /// Changes limits, each given as `NAME=N`.
    ///
    /// # Errors
    /// A fault for every change that is no `NAME=N` or names no limit.
    pub fn set(&mut self, changes: &[String]) -> Result<(), Problems> {
        let mut problems = Problems::new("--limit");
        for change in changes {
            let known = change.split_once('=').and_then(|(name, count)| {
                let index = TABLE.iter().position(|(_, known, _, _)| *known == name)?;
                // `1e6` as well as `1000000`.
                let count = count.parse::<f64>().ok().filter(|count| *count >= 1.0 && count.is_finite())?;
                Some((index, count as u64))
            });
            match known {
                Some((index, count)) => self.values[index] = count,
                None => {
                    problems.add(change.clone(), "no NAME=N", format!("N of at least 1, and one of {self}"))
                }
            }
        }
        problems.into_result(Some(()))
    }
}

/// All limits as they stand: `knots=250000, steps=100000000`.
impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let each = self.all().map(|(name, value)| format!("{name}={value}"));
        f.write_str(&each.collect::<Vec<_>>().join(", "))
    }
}

/// Why a file was not read.
#[derive(Debug, thiserror::Error)]
pub enum Unread {
    /// It is not there, or may not be read.
    #[error("{0}")]
    Unreadable(#[from] io::Error),
    /// A folder, a pipe, a device.
    #[error("not a plain file")]
    NoFile,
    /// It has so many bytes.
    #[error("{0} bytes")]
    TooLong(u64),
}

/// Bytes of the plain file `path`, of at most `most`.
///
/// # Errors
/// It is not there, not plain, or longer.
pub fn read_file(path: &Path, most: u64) -> Result<Vec<u8>, Unread> {
    // Opening a pipe would wait for a writer.
    let told = fs::metadata(path)?;
    if !told.is_file() {
        return Err(Unread::NoFile);
    }
    if told.len() > most {
        return Err(Unread::TooLong(told.len()));
    }
    // No more than it says it has: a file of the kernel, which says none, may never end.
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(told.len()).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_limits() {
        for (index, (limit, ..)) in TABLE.iter().enumerate() {
            assert_eq!(*limit as usize, index);
        }
    }

    #[test]
    fn a_limit_is_raised_by_its_name() {
        let mut limits = Limits::default();
        limits.set(&["knots=1e6".to_owned(), "parts=7".to_owned()]).unwrap();
        assert_eq!([limits.of(Limit::Knots), limits.of(Limit::Parts)], [1_000_000, 7]);
        assert!(limits.exceeded(Limit::Parts, 8.0) && !limits.exceeded(Limit::Parts, 7.0));
        assert!(limits.exceeded(Limit::Parts, f64::NAN));
        for bad in ["knots", "knot=1", "knots=0", "knots=many", "knots=inf", ""] {
            let problems = Limits::default().set(&[bad.to_owned()]).unwrap_err().to_string();
            assert!(problems.contains("knots=250000, steps=100000000"), "{problems}");
        }
    }
}
