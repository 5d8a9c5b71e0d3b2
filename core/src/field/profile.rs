//! Residual gravity and rotation of a cabin over time (Fig. 3.20), as accelerometers and gyroscopes
//! record them: rows of a table, joined by straight lines.
//!
//! Two rows of the same time are a jump. Before the first row and after the last the values stand.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Field, Frame, Gravity, Span};
use crate::problems::Problems;

/// A row of a profile, as in its file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileRow {
    /// Time since the shot [s].
    pub t_s: f64,
    /// Residual gravity along X [m/s^2].
    pub gravity_x_m_s2: f64,
    /// Along Y.
    pub gravity_y_m_s2: f64,
    /// Along Z.
    pub gravity_z_m_s2: f64,
    /// Angular velocity about X [rad/s].
    pub rate_x_rad_s: f64,
    /// About Y.
    pub rate_y_rad_s: f64,
    /// About Z.
    pub rate_z_rad_s: f64,
}

/// The heading of a profile's file, for messages.
const HEADING: &str =
    "t_s,gravity_x_m_s2,gravity_y_m_s2,gravity_z_m_s2,rate_x_rad_s,rate_y_rad_s,rate_z_rad_s";

impl ProfileRow {
    fn values(&self) -> Values {
        Values {
            gravity: Vector3::new(self.gravity_x_m_s2, self.gravity_y_m_s2, self.gravity_z_m_s2),
            rate: Vector3::new(self.rate_x_rad_s, self.rate_y_rad_s, self.rate_z_rad_s),
        }
    }

    /// Its seven numbers.
    pub fn numbers(&self) -> [f64; 7] {
        let Values { gravity: g, rate: w } = self.values();
        [self.t_s, g.x, g.y, g.z, w.x, w.y, w.z]
    }
}

/// Rows of the CSV file `text`; lines that begin with `#` are skipped. Faults go to `problems`, with
/// their lines.
pub fn read(text: &[u8], place: &str, problems: &mut Problems) -> Option<Vec<ProfileRow>> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text);
    let heading = reader.headers().cloned().unwrap_or_default();
    let mut rows: Vec<ProfileRow> = Vec::new();
    let n_faults = problems.list.len();
    let mut line = 1;
    for record in reader.records() {
        let row = record.and_then(|record| {
            line = record.position().map_or(line, csv::Position::line);
            record.deserialize::<ProfileRow>(Some(&heading))
        });
        let fault = match row {
            Ok(row) if !row.numbers().iter().all(|number| number.is_finite()) => {
                "a number that is not finite".to_owned()
            }
            Ok(row) if rows.last().is_some_and(|last| row.t_s < last.t_s) => {
                format!("time {} after a later one", row.t_s)
            }
            Ok(row) => {
                rows.push(row);
                continue;
            }
            Err(error) => {
                line = error.position().map_or(line, csv::Position::line);
                error.to_string()
            }
        };
        let allowed =
            format!("rows of seven finite numbers, time never falling, under the heading {HEADING}");
        problems.add(place, format!("line {line}: {fault}"), allowed);
        if problems.list.len() >= n_faults + MAX_FAULTS {
            break;
        }
    }
    let sound = problems.list.len() == n_faults;
    if sound && rows.is_empty() {
        problems.add(place, "no row", format!("at least one row of numbers under the heading {HEADING}"));
        return None;
    }
    sound.then_some(rows)
}

/// Faults of a file after which the rest is not told.
const MAX_FAULTS: usize = 20;

/// Gravity [m/s^2] and angular velocity [rad/s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    /// Residual gravity.
    pub gravity: Vector3<f64>,
    /// Angular velocity.
    pub rate: Vector3<f64>,
}

impl Values {
    fn sum(self, other: Values) -> Values {
        Values { gravity: self.gravity + other.gravity, rate: self.rate + other.rate }
    }

    fn times(self, factor: f64) -> Values {
        Values { gravity: factor * self.gravity, rate: factor * self.rate }
    }
}

/// The frame of a cabin: constant values, and those of a profile on top.
#[derive(Clone, Debug, PartialEq)]
pub struct CabinMotion {
    /// Constant values.
    pub constant: Values,
    /// Values over time; none: the constant ones alone.
    pub rows: Vec<ProfileRow>,
    /// Where the gravity was recorded, about which the cabin turns [m].
    pub centre: Vector3<f64>,
}

impl CabinMotion {
    /// Values at `time` [s]; at a jump, those after it.
    fn values(&self, time: f64) -> Values {
        let next = self.rows.partition_point(|row| row.t_s <= time);
        let of_rows = match (next.checked_sub(1).map(|last| &self.rows[last]), self.rows.get(next)) {
            (None, None) => return self.constant,
            (Some(only), None) | (None, Some(only)) => only.values(),
            (Some(last), Some(next)) => {
                let share = (time - last.t_s) / (next.t_s - last.t_s);
                let (last, next) = (last.values(), next.values());
                // In this form equal rows give their own values, to the last bit.
                last.sum(next.sum(last.times(-1.0)).times(share))
            }
        };
        self.constant.sum(of_rows)
    }

    fn frame(&self, values: Values) -> Frame {
        Frame { rate: values.rate, centre: self.centre, gravity: Gravity::Uniform(values.gravity) }
    }
}

impl Field for CabinMotion {
    fn at(&self, time: f64) -> Frame {
        self.frame(self.values(time))
    }

    fn over(&self, start: f64, end: f64) -> Span {
        // The mean of a straight line is its middle, so the span is cut where lines meet.
        let first = self.rows.partition_point(|row| row.t_s <= start);
        let cuts = self.rows[first..].iter().map(|row| row.t_s).take_while(|&time| time < end);
        let mut mean = Values::default();
        let mut from = start;
        for to in cuts.chain([end]) {
            mean = mean.sum(self.values(0.5 * (from + to)).times((to - from) / (end - start)));
            from = to;
        }
        let rate_change = self.values(end).rate - self.values(start).rate;
        Span { length: end - start, mean: self.frame(mean), rate_change }
    }
}
