//! Where all knots of a net were over a run, at any time, and what each is called.
//!
//! Between two frames a knot moves along the cubic with their positions and velocities (Hermite): off by some Δt⁴ of a
//! smooth motion. Before the first frame, which is the shot, the net lies where it is folded; beyond the last one it flies
//! on straight, which is for who needs a number there.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::run::Run;

/// Where the knots of a net were: T frames of K knots.
#[derive(Clone, Debug, PartialEq)]
pub struct KnotPaths {
    /// Which knot is which.
    pub names: KnotNames,
    /// Time of each frame [s], T, rising.
    pub time: Vec<f64>,
    /// Positions [m], T × K.
    pub position: Vec<Vec<Vector3<f64>>>,
    /// Velocities [m/s], T × K.
    pub velocity: Vec<Vec<Vector3<f64>>>,
}

/// Where a knot is, and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// Position [m].
    pub position: Vector3<f64>,
    /// Velocity [m/s].
    pub velocity: Vector3<f64>,
}

impl KnotPaths {
    /// Those of `run`, a run of `case`.
    pub fn of(case: &Case, run: Run) -> KnotPaths {
        let names = KnotNames { grid: case.net().grid, n_knots: case.net().n_knots() };
        KnotPaths {
            names,
            time: run.frames.time,
            position: run.frames.knots,
            velocity: run.frames.velocities,
        }
    }

    /// The net of `case` before the shot.
    pub fn folded(case: &Case) -> KnotPaths {
        let net = case.net();
        KnotPaths {
            names: KnotNames { grid: net.grid, n_knots: net.n_knots() },
            time: vec![0.0],
            position: vec![net.folded.clone()],
            velocity: vec![net.launch_velocity.clone()],
        }
    }

    /// Time of the last frame [s].
    pub fn end(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    /// Whether `time` [s] is not beyond the last frame; one that differs by rounding is not.
    pub fn covers(&self, time: f64) -> bool {
        time <= self.end() + 1e-9 * self.end().abs()
    }

    /// Knot `knot` at `time` [s].
    pub fn at(&self, knot: usize, time: f64) -> Moving {
        let of = |frame: usize| Moving {
            position: self.position[frame][knot],
            velocity: self.velocity[frame][knot],
        };
        let last = self.time.len() - 1;
        let after = self.time.partition_point(|&t| t <= time);
        if after == 0 {
            return Moving { velocity: Vector3::zeros(), ..of(0) };
        }
        if after > last {
            let Moving { position, velocity } = of(last);
            return Moving { position: position + (time - self.time[last]) * velocity, velocity };
        }
        between(
            of(after - 1),
            of(after),
            self.time[after] - self.time[after - 1],
            time - self.time[after - 1],
        )
    }
}

/// The cubic from `from` to `to`, `span` later, at `since` after `from` [s].
///
/// x(s) = h₀₀ x₀ + h₁₀ Δ v₀ + h₀₁ x₁ + h₁₁ Δ v₁,  s = t / Δ
fn between(from: Moving, to: Moving, span: f64, since: f64) -> Moving {
    let s = since / span;
    let [h00, h10, h01, h11] = [
        (1.0 + 2.0 * s) * (1.0 - s).powi(2),
        s * (1.0 - s).powi(2),
        s * s * (3.0 - 2.0 * s),
        s * s * (s - 1.0),
    ];
    let [d00, d10, d01, d11] =
        [6.0 * s * (s - 1.0), (1.0 - s) * (1.0 - 3.0 * s), 6.0 * s * (1.0 - s), s * (3.0 * s - 2.0)];
    Moving {
        position: h00 * from.position
            + h10 * span * from.velocity
            + h01 * to.position
            + h11 * span * to.velocity,
        velocity: (d00 * from.position + d01 * to.position) / span + d10 * from.velocity + d11 * to.velocity,
    }
}

/// Groups of knots, as in Table 3.7.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum KnotGroup {
    /// The four bullets.
    Bullets,
    /// Knots on the edge of the net.
    Edge,
    /// Knots within.
    Inner,
    /// Knots in the middle of cables.
    Middle,
}

impl KnotGroup {
    /// All of them.
    pub const ALL: [KnotGroup; 4] =
        [KnotGroup::Bullets, KnotGroup::Edge, KnotGroup::Inner, KnotGroup::Middle];

    /// For a person.
    pub fn words(self) -> &'static str {
        match self {
            KnotGroup::Bullets => "bullets",
            KnotGroup::Edge => "knots on the edge",
            KnotGroup::Inner => "inner knots",
            KnotGroup::Middle => "middle knots",
        }
    }
}

/// What the knots of a net are called: `bullet-1` to `bullet-4`, `knot-I-J` in row I and column J from 0 (rows along Y,
/// columns along Z), `knot-N` by number from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnotNames {
    /// Knots of the grid along Y and along Z.
    pub grid: [usize; 2],
    /// All knots, with the middle ones.
    pub n_knots: usize,
}

impl KnotNames {
    /// The four corners, around the mouth, as [`crate::net::Net::bullets`] has them.
    pub fn bullets(&self) -> [usize; 4] {
        let [rows, columns] = self.grid;
        [0, (rows - 1) * columns, rows * columns - 1, columns - 1]
    }

    /// Name of `knot`.
    pub fn name(&self, knot: usize) -> String {
        let [rows, columns] = self.grid;
        match self.bullets().iter().position(|bullet| *bullet == knot) {
            Some(bullet) => format!("bullet-{}", bullet + 1),
            None if knot < rows * columns => format!("knot-{}-{}", knot / columns, knot % columns),
            None => format!("knot-{knot}"),
        }
    }

    /// The knot called `name`, by any of its names.
    pub fn find(&self, name: &str) -> Option<usize> {
        let number = |text: &str| text.parse::<usize>().ok();
        if let Some(bullet) = name.strip_prefix("bullet-") {
            return self.bullets().get(number(bullet)?.checked_sub(1)?).copied();
        }
        let place = name.strip_prefix("knot-")?;
        let knot = match place.split_once('-') {
            Some((row, column)) => {
                let (row, column) = (number(row)?, number(column)?);
                (row < self.grid[0] && column < self.grid[1]).then_some(row * self.grid[1] + column)?
            }
            None => number(place)?,
        };
        (knot < self.n_knots).then_some(knot)
    }

    /// The group of `knot`.
    pub fn group(&self, knot: usize) -> KnotGroup {
        let [rows, columns] = self.grid;
        let (row, column) = (knot / columns, knot % columns);
        match () {
            () if self.bullets().contains(&knot) => KnotGroup::Bullets,
            () if knot >= rows * columns => KnotGroup::Middle,
            () if row == 0 || row == rows - 1 || column == 0 || column == columns - 1 => KnotGroup::Edge,
            () => KnotGroup::Inner,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: KnotNames = KnotNames { grid: [3, 4], n_knots: 14 };

    #[test]
    fn every_knot_is_found_by_its_name() {
        for knot in 0..NAMES.n_knots {
            assert_eq!(NAMES.find(&NAMES.name(knot)), Some(knot), "{}", NAMES.name(knot));
            assert_eq!(NAMES.find(&format!("knot-{knot}")), Some(knot));
        }
        let groups = [0, 1, 5, 13].map(|knot| NAMES.group(knot));
        assert_eq!(groups, KnotGroup::ALL);
        for name in
            ["bullet-0", "bullet-5", "knot-3-0", "knot-0-4", "knot-14", "knot", "knot-1-2-3", "knot--1"]
        {
            assert_eq!(NAMES.find(name), None, "{name}");
        }
    }

    /// A cubic is met to the last digits, between frames and in its velocity.
    #[test]
    fn a_cubic_motion_is_met_between_frames() {
        let position = |t: f64| Vector3::new(1.0 + t, t * t, -2.0 * t * t * t);
        let velocity = |t: f64| Vector3::new(1.0, 2.0 * t, -6.0 * t * t);
        let time = vec![0.0, 0.3, 1.0];
        let paths = KnotPaths {
            names: KnotNames { grid: [1, 1], n_knots: 1 },
            position: time.iter().map(|&t| vec![position(t)]).collect(),
            velocity: time.iter().map(|&t| vec![velocity(t)]).collect(),
            time,
        };
        for t in [0.0, 0.1, 0.3, 0.77, 1.0] {
            let moving = paths.at(0, t);
            assert!((moving.position - position(t)).norm() < 1e-14, "{t}: {moving:?}");
            assert!((moving.velocity - velocity(t)).norm() < 1e-14, "{t}: {moving:?}");
        }
        assert_eq!(paths.at(0, -1.0), Moving { position: position(0.0), velocity: Vector3::zeros() });
        assert!((paths.at(0, 2.0).position - position(1.0) - velocity(1.0)).norm() < 1e-14);
        assert!(paths.covers(1.0) && !paths.covers(1.1));
    }
}
