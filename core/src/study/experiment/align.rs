//! The clock and the frame of an experiment in those of a run.
//!
//! t = t' + τ,  x = R x' + p   (primed: of the experiment)
//!
//! For a given shift τ the turn R and the offset p that leave the least squares are Kabsch's: with H = Σ (x' − x̄')(x − x̄)ᵀ =
//! U S Vᵀ, R = V diag(1, 1, det(V Uᵀ)) Uᵀ and p = x̄ − R x̄'. What is left is a function of τ alone. It is looked at on a
//! grid of shifts that put the middle one of the sightings anywhere in the run; beside the least its slope, Σ r · ẋ with R and
//! p held, is then halved to its root.
//!
//! A net that flies on as it is tells a shift in time from one along its way only by what happens before: its opening.

use nalgebra::{Matrix3, Rotation3, SVD, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::paths::KnotPaths;
use super::tracks::Paired;

/// What is fitted before a run and an experiment are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Align {
    /// Nothing: clock and frame are the same.
    None,
    /// When the experiment's clock was zero.
    Time,
    /// How its frame lies in that of the run.
    Pose,
    /// Both.
    #[default]
    Both,
}

impl Align {
    fn time(self) -> bool {
        matches!(self, Align::Time | Align::Both)
    }

    fn pose(self) -> bool {
        matches!(self, Align::Pose | Align::Both)
    }

    /// How many numbers are fitted.
    pub fn n_numbers(self) -> usize {
        usize::from(self.time()) + if self.pose() { 6 } else { 0 }
    }

    /// For a person.
    pub fn words(self) -> &'static str {
        match self {
            Align::None => "nothing",
            Align::Time => "time",
            Align::Pose => "pose",
            Align::Both => "time and pose",
        }
    }
}

/// Shifts in time that are looked at.
const N_SHIFTS: usize = 201;

/// Halvings of the distance between two of them: down to the last bits.
const N_HALVINGS: usize = 50;

/// Least of the second singular value over the first: markers on a line leave the turn about it open.
const LEAST_SPREAD: f64 = 1e-9;

/// How an experiment lies in the clock and the frame of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// τ [s].
    pub shift: f64,
    /// R.
    pub turn: UnitQuaternion<f64>,
    /// p [m].
    pub offset: Vector3<f64>,
}

impl Alignment {
    /// The same clock and the same frame.
    pub const SAME: Alignment = Alignment {
        shift: 0.0,
        turn: UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(1.0, 0.0, 0.0, 0.0)),
        offset: Vector3::new(0.0, 0.0, 0.0),
    };

    /// The one of `what` that brings `seen` nearest to `paths`.
    ///
    /// # Errors
    /// Nothing is seen while the run lasts; markers on a line, of which there is no pose.
    pub fn fit(paths: &KnotPaths, seen: &[Paired], what: Align) -> Result<Alignment, AlignError> {
        let inside = |shift: f64| -> Vec<Paired> {
            seen.iter().filter(|one| paths.covers(one.seen.time + shift)).copied().collect()
        };
        if !what.time() {
            let inside = inside(0.0);
            return if inside.is_empty() { Err(AlignError::Apart) } else { posed(paths, &inside, 0.0, what) };
        }
        let mut times: Vec<f64> = seen.iter().map(|one| one.seen.time).collect();
        times.sort_by(f64::total_cmp);
        let Some(&middle) = times.get(times.len() / 2) else { return Err(AlignError::Apart) };
        let step = paths.end() / (N_SHIFTS - 1) as f64;
        let mut best: Option<(f64, f64)> = None;
        let mut fault = AlignError::Apart;
        for number in 0..N_SHIFTS {
            let shift = step * number as f64 - middle;
            let inside = inside(shift);
            match posed(paths, &inside, shift, what) {
                Ok(alignment) => {
                    let (square, _) = alignment.left(paths, &inside);
                    if best.is_none_or(|(_, least)| square < least) {
                        best = Some((shift, square));
                    }
                }
                Err(error) => fault = error,
            }
        }
        let (shift, _) = best.ok_or(fault)?;
        // The same sightings all along: their number must not be what makes a shift better.
        let inside = inside(shift);
        let (mut low, mut high) = (shift - step, shift + step);
        for _ in 0..N_HALVINGS {
            let middle = 0.5 * (low + high);
            let (_, slope) = posed(paths, &inside, middle, what)?.left(paths, &inside);
            if slope < 0.0 { low = middle } else { high = middle }
        }
        posed(paths, &inside, 0.5 * (low + high), what)
    }

    /// Where a sighting is in the frame of the run [m].
    pub fn place(&self, seen: &Paired) -> Vector3<f64> {
        self.turn * seen.seen.position + self.offset
    }

    /// When it is by the clock of the run [s].
    pub fn time(&self, seen: &Paired) -> f64 {
        seen.seen.time + self.shift
    }

    /// How far the run is from a sighting [m].
    pub fn residual(&self, paths: &KnotPaths, seen: &Paired) -> Vector3<f64> {
        paths.at(seen.knot, self.time(seen)).position - self.place(seen)
    }

    /// Mean square of what is left [m²], and half its slope over the shift [m²/s].
    fn left(&self, paths: &KnotPaths, seen: &[Paired]) -> (f64, f64) {
        let mut sums = (0.0, 0.0);
        for one in seen {
            let moving = paths.at(one.knot, self.time(one));
            let residual = moving.position - self.place(one);
            sums.0 += residual.norm_squared();
            sums.1 += residual.dot(&moving.velocity);
        }
        (sums.0 / seen.len() as f64, sums.1 / seen.len() as f64)
    }
}

/// Why an experiment cannot be aligned with a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AlignError {
    /// Nothing is compared.
    #[error("no marker is seen before the run ends")]
    Apart,
    /// No turn is better than all others.
    #[error("all that is seen lies on a line or in a point, which leaves the pose open")]
    Line,
}

/// The pose that brings `seen` nearest, `shift` later [s]: Kabsch's, where `what` has one.
fn posed(paths: &KnotPaths, seen: &[Paired], shift: f64, what: Align) -> Result<Alignment, AlignError> {
    if !what.pose() {
        return Ok(Alignment { shift, ..Alignment::SAME });
    }
    let there = |one: &Paired| paths.at(one.knot, one.seen.time + shift).position;
    let n = seen.len() as f64;
    let mean_here = seen.iter().map(|one| one.seen.position).sum::<Vector3<f64>>() / n;
    let mean_there = seen.iter().map(there).sum::<Vector3<f64>>() / n;
    let product = |one: &Paired| (one.seen.position - mean_here) * (there(one) - mean_there).transpose();
    let covariance: Matrix3<f64> = seen.iter().map(product).sum();
    let svd = SVD::new(covariance, true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Err(AlignError::Line) };
    let [first, second] = [0, 1].map(|number| svd.singular_values[number]);
    if second.is_nan() || second <= LEAST_SPREAD * first {
        return Err(AlignError::Line);
    }
    let side = (v_t.transpose() * u.transpose()).determinant().signum();
    let turn = v_t.transpose() * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, side)) * u.transpose();
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    Ok(Alignment { shift, turn, offset: mean_there - turn * mean_here })
}

#[cfg(test)]
mod tests {
    use super::super::paths::KnotNames;
    use super::super::tracks::Sighting;
    use super::*;

    /// Four knots that fly apart, ever slower, while they travel on.
    fn paths() -> KnotPaths {
        let time: Vec<f64> = (0..=50).map(|i| 0.02 * f64::from(i)).collect();
        let outward = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.2], [-1.0, 1.0]];
        let position = |t: f64| {
            outward.map(|[y, z]| Vector3::new(2.0 * t, y * t * (2.0 - t), z * t * (2.0 - t))).to_vec()
        };
        let velocity = |t: f64| {
            outward.map(|[y, z]| Vector3::new(2.0, y * (2.0 - 2.0 * t), z * (2.0 - 2.0 * t))).to_vec()
        };
        KnotPaths {
            names: KnotNames { grid: [2, 2], n_knots: 4 },
            position: time.iter().map(|&t| position(t)).collect(),
            velocity: time.iter().map(|&t| velocity(t)).collect(),
            time,
        }
    }

    /// What a camera that stands at `pose`, and whose clock began `shift` late, sees of them.
    fn seen(paths: &KnotPaths, pose: &Alignment) -> Vec<Paired> {
        let sighting = |frame: i32, knot: usize| {
            let time = 0.1 + 0.03 * f64::from(frame);
            let there = paths.at(knot, time + pose.shift).position;
            let position = pose.turn.inverse() * (there - pose.offset);
            Paired { marker: knot, knot, seen: Sighting { time, position } }
        };
        // A quarter of it is missing.
        let all = (0..25).flat_map(|frame| (0..4).map(move |knot| (frame, knot)));
        all.filter(|(frame, knot)| (frame + *knot as i32) % 4 != 0).map(|(f, k)| sighting(f, k)).collect()
    }

    #[test]
    fn clock_and_frame_of_a_camera_are_found() {
        let paths = paths();
        let pose = Alignment {
            shift: -0.0731,
            turn: UnitQuaternion::from_euler_angles(0.3, -1.2, 2.0),
            offset: Vector3::new(0.4, -3.0, 1.0),
        };
        let found = Alignment::fit(&paths, &seen(&paths, &pose), Align::Both).unwrap();
        let off = [
            (found.shift - pose.shift).abs(),
            found.turn.angle_to(&pose.turn),
            (found.offset - pose.offset).norm(),
        ];
        // An angle by its cosine has half the digits.
        assert!(off[0] < 1e-12 && off[1] < 3e-7 && off[2] < 1e-12, "{off:?}");
        let only_time = Alignment { turn: UnitQuaternion::identity(), offset: Vector3::zeros(), ..pose };
        let found = Alignment::fit(&paths, &seen(&paths, &only_time), Align::Time).unwrap();
        assert!((found.shift - pose.shift).abs() < 1e-12, "{found:?}");
        let only_pose = Alignment { shift: 0.0, ..pose };
        let found = Alignment::fit(&paths, &seen(&paths, &only_pose), Align::Pose).unwrap();
        assert!(found.shift == 0.0 && (found.offset - pose.offset).norm() < 1e-12, "{found:?}");
        let same = Alignment::fit(&paths, &seen(&paths, &pose), Align::None).unwrap();
        assert_eq!(same, Alignment::SAME);
    }

    #[test]
    fn a_mirror_image_is_no_pose() {
        let paths = paths();
        let mut mirrored = seen(&paths, &Alignment::SAME);
        mirrored.iter_mut().for_each(|one| one.seen.position.z *= -1.0);
        let found = Alignment::fit(&paths, &mirrored, Align::Pose).unwrap();
        assert!((found.turn.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn what_leaves_a_pose_or_a_time_open_is_refused() {
        let paths = paths();
        let mut line = seen(&paths, &Alignment::SAME);
        line.retain(|one| one.seen.time < 0.11 && one.knot < 2);
        assert_eq!(Alignment::fit(&paths, &line, Align::Pose), Err(AlignError::Line));
        let mut late = seen(&paths, &Alignment::SAME);
        late.iter_mut().for_each(|one| one.seen.time += 100.0);
        assert_eq!(Alignment::fit(&paths, &late, Align::None), Err(AlignError::Apart));
        // A clock that began long before the shot is no hindrance.
        let found = Alignment::fit(&paths, &late, Align::Both).unwrap();
        assert!((found.shift + 100.0).abs() < 1e-9, "{found:?}");
    }
}
