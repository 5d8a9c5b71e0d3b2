//! Measured tracks of markers on a net: a table in CSV, and which knot each marker is.
//!
//! A row is a marker at a time, under a heading that states the units: `time_s,marker,x_m,y_m,z_m`, or `time_ms` and
//! `x_mm,y_mm,z_mm`; columns in any order, rows too. Where a marker was not seen its row is left out, or has no
//! coordinates. Lines that begin with `#` are skipped.

use std::collections::HashMap;

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::paths::KnotPaths;
use crate::problems::{Problems, nearest};

/// Where a marker was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// When [s], by the clock of the experiment.
    pub time: f64,
    /// Where [m], in the frame of the experiment.
    pub position: Vector3<f64>,
}

/// The track of a marker.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerTrack {
    /// As the file calls it.
    pub name: String,
    /// First line that names it.
    pub line: u64,
    /// Where it was seen, by time.
    pub seen: Vec<Sighting>,
    /// Rows without coordinates.
    pub gaps: usize,
}

/// The tracks of all markers, in the order of their first rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkerTracks {
    /// The markers.
    pub markers: Vec<MarkerTrack>,
}

/// How markers find their knots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Matching {
    /// A marker is called as its knot: `bullet-1`, `knot-5-5`, `knot-60`.
    #[default]
    Name,
    /// A marker is on the knot that is nearest where and when it was seen first, before anything is aligned.
    Nearest,
}

/// A marker seen, and the knot that it is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paired {
    /// Which of the markers.
    pub marker: usize,
    /// The knot.
    pub knot: usize,
    /// Where and when.
    pub seen: Sighting,
}

/// What the heading may have.
const HEADING: &str = "time_s,marker,x_m,y_m,z_m, or with time_ms, x_mm, y_mm, z_mm";

/// What a row may have.
const ROW: &str = "a finite time, a name, and three finite coordinates or none";

/// Where a number is in a row, and how many SI units are one of its.
#[derive(Clone, Copy)]
struct NumberColumn {
    index: usize,
    unit: f64,
}

struct Heading {
    marker: usize,
    time: NumberColumn,
    axes: [NumberColumn; 3],
}

impl Heading {
    /// That of the fields `named`; faults go to `problems`.
    fn read(named: &csv::StringRecord, problems: &mut Problems) -> Option<Heading> {
        let known = problems.list.len();
        let mut found: HashMap<&str, NumberColumn> = HashMap::new();
        for (index, name) in named.iter().enumerate() {
            let (quantity, unit) = match name {
                "marker" => ("marker", 1.0),
                "time_s" => ("time", 1.0),
                "time_ms" => ("time", 1e-3),
                "x_m" => ("x", 1.0),
                "y_m" => ("y", 1.0),
                "z_m" => ("z", 1.0),
                "x_mm" => ("x", 1e-3),
                "y_mm" => ("y", 1e-3),
                "z_mm" => ("z", 1e-3),
                _ => {
                    problems.add("line 1", format!("the column {name:?}"), HEADING);
                    continue;
                }
            };
            if found.insert(quantity, NumberColumn { index, unit }).is_some() {
                problems.add("line 1", format!("a second column of {quantity}"), HEADING);
            }
        }
        for quantity in ["time", "marker", "x", "y", "z"] {
            if !found.contains_key(quantity) {
                problems.add("line 1", format!("no column of {quantity}"), HEADING);
            }
        }
        let at = |quantity: &str| found.get(quantity).copied();
        let heading =
            Heading { marker: at("marker")?.index, time: at("time")?, axes: [at("x")?, at("y")?, at("z")?] };
        (problems.list.len() == known).then_some(heading)
    }

    /// The marker, the time and the place that a row states, or what is wrong with it.
    fn row<'a>(&self, row: &'a csv::StringRecord) -> Result<(&'a str, f64, Option<Vector3<f64>>), String> {
        let text = |index: usize| row.get(index).unwrap_or_default();
        let number = |column: NumberColumn| match text(column.index).parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(column.unit * value),
            _ => Err(format!("{:?}", text(column.index))),
        };
        let marker = text(self.marker);
        if marker.is_empty() {
            return Err("no name of a marker".to_owned());
        }
        let time = number(self.time)?;
        if self.axes.iter().all(|axis| text(axis.index).is_empty()) {
            return Ok((marker, time, None));
        }
        let [x, y, z] = self.axes.map(number);
        Ok((marker, time, Some(Vector3::new(x?, y?, z?))))
    }
}

impl MarkerTracks {
    /// Those of the CSV file `text`; every fault goes to `problems`, with its line.
    pub fn read(text: &[u8], problems: &mut Problems) -> Option<MarkerTracks> {
        let known = problems.list.len();
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text);
        let named = match reader.headers() {
            Ok(named) => named.clone(),
            Err(error) => {
                problems.add("line 1", error.to_string(), HEADING);
                return None;
            }
        };
        let heading = Heading::read(&named, problems)?;
        let mut tracks = MarkerTracks::default();
        let mut numbers: HashMap<String, usize> = HashMap::new();
        // Lines by marker and time: nothing is in two places at once.
        let mut lines: HashMap<(usize, u64), u64> = HashMap::new();
        let mut line = 1;
        for record in reader.records() {
            let row = record.map_err(|error| {
                line = error.position().map_or(line, csv::Position::line);
                error.to_string()
            });
            let row = row.and_then(|record| {
                line = record.position().map_or(line, csv::Position::line);
                let (name, time, place) = heading.row(&record)?;
                Ok((name.to_owned(), time, place))
            });
            let (name, time, place) = match row {
                Ok(row) => row,
                Err(found) => {
                    problems.add(format!("line {line}"), found, ROW);
                    continue;
                }
            };
            let marker = *numbers.entry(name.clone()).or_insert_with(|| {
                tracks.markers.push(MarkerTrack { name: name.clone(), line, seen: Vec::new(), gaps: 0 });
                tracks.markers.len() - 1
            });
            // Zero of either sign is one time.
            if let Some(before) = lines.insert((marker, (time + 0.0).to_bits()), line) {
                let found = format!("{name:?} at {time} s, as in line {before}");
                problems.add(format!("line {line}"), found, "each marker once at a time");
            }
            match place {
                Some(position) => tracks.markers[marker].seen.push(Sighting { time, position }),
                None => tracks.markers[marker].gaps += 1,
            }
        }
        if problems.list.len() == known && tracks.markers.iter().all(|marker| marker.seen.is_empty()) {
            problems.add("", "no marker that was seen", "at least one row with coordinates");
        }
        for marker in &mut tracks.markers {
            marker.seen.sort_by(|one, other| one.time.total_cmp(&other.time));
        }
        (problems.list.len() == known).then_some(tracks)
    }

    /// Every knot of a run as a marker of its name, seen at every frame.
    pub fn of(paths: &KnotPaths) -> MarkerTracks {
        let track = |knot: usize| MarkerTrack {
            name: paths.names.name(knot),
            line: 0,
            seen: paths
                .time
                .iter()
                .zip(&paths.position)
                .map(|(&time, at)| Sighting { time, position: at[knot] })
                .collect(),
            gaps: 0,
        };
        MarkerTracks { markers: (0..paths.names.n_knots).map(track).collect() }
    }

    /// The four bullets alone: what nets of different meshes have in common.
    #[must_use]
    pub fn bullets(mut self) -> MarkerTracks {
        self.markers.retain(|marker| marker.name.starts_with("bullet-"));
        self
    }

    /// The knot of each marker on the net of `paths`, none of one that was never seen; faults go to `problems`.
    pub fn knots(
        &self,
        paths: &KnotPaths,
        how: Matching,
        problems: &mut Problems,
    ) -> Option<Vec<Option<usize>>> {
        let known = problems.list.len();
        let mut knots: Vec<Option<usize>> = Vec::new();
        for marker in &self.markers {
            let knot = match how {
                Matching::Name => by_name(paths, marker, problems),
                Matching::Nearest => marker.seen.first().map(|seen| by_place(paths, seen)),
            };
            if let Some(knot) = knot
                && let Some(other) = knots.iter().position(|other| *other == Some(knot))
            {
                let (knot, other) = (paths.names.name(knot), &self.markers[other].name);
                problems.add(
                    format!("line {}", marker.line),
                    format!("{:?} on {knot}, as {other:?}", marker.name),
                    "a knot of its own for each marker; names of knots, where the nearest are not right",
                );
            }
            knots.push(knot);
        }
        (problems.list.len() == known).then_some(knots)
    }

    /// All sightings with the knots that they are of.
    pub fn paired(&self, knots: &[Option<usize>]) -> Vec<Paired> {
        let mut paired = Vec::new();
        for (marker, (track, knot)) in self.markers.iter().zip(knots).enumerate() {
            let Some(knot) = *knot else { continue };
            paired.extend(track.seen.iter().map(|&seen| Paired { marker, knot, seen }));
        }
        paired
    }
}

fn by_name(paths: &KnotPaths, marker: &MarkerTrack, problems: &mut Problems) -> Option<usize> {
    let names = paths.names;
    let found = names.find(&marker.name);
    if found.is_none() {
        let all: Vec<String> = (0..names.n_knots).map(|knot| names.name(knot)).collect();
        let meant = nearest(&marker.name, all.iter().map(String::as_str))
            .map_or_else(String::new, |meant| format!("did you mean {meant}? "));
        let [rows, columns] = names.grid;
        let allowed = format!(
            "{meant}bullet-1 to bullet-4, knot-I-J up to knot-{}-{}, knot-N up to knot-{}; or matching by `nearest`",
            rows - 1,
            columns - 1,
            names.n_knots - 1
        );
        problems.add(format!("line {}", marker.line), format!("the marker {:?}", marker.name), allowed);
    }
    found
}

fn by_place(paths: &KnotPaths, seen: &Sighting) -> usize {
    let distance = |knot: usize| (paths.at(knot, seen.time).position - seen.position).norm();
    // A net has knots.
    (1..paths.names.n_knots).fold(0, |best, knot| if distance(knot) < distance(best) { knot } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<MarkerTracks, Problems> {
        let mut problems = Problems::new("track.csv");
        let tracks = MarkerTracks::read(text.as_bytes(), &mut problems);
        problems.into_result(tracks)
    }

    #[test]
    fn units_order_and_gaps_are_as_the_heading_and_the_rows_say() {
        let text = "# seen from two sides\nmarker, x_mm, time_ms, y_m, z_m\nb, 20, 20, 0, 1\na, 10, 5, 2, 3\n\
                    b, , 10, , \nb, 30, 0, 4, 5\n";
        let tracks = read(text).unwrap();
        let [b, a] = &tracks.markers[..] else { panic!("{tracks:?}") };
        assert_eq!((b.name.as_str(), b.gaps, b.line), ("b", 1, 3));
        let seen: Vec<(f64, [f64; 3])> = b.seen.iter().map(|s| (s.time, s.position.into())).collect();
        assert_eq!(seen, [(0.0, [0.03, 4.0, 5.0]), (0.02, [0.02, 0.0, 1.0])]);
        assert_eq!(a.seen, [Sighting { time: 0.005, position: Vector3::new(0.01, 2.0, 3.0) }]);
    }

    #[test]
    fn all_faults_of_a_file_are_told_with_their_lines() {
        let text = "time_s,marker,x_m,y_m,z_m\n0,a,1,2,3\nnow,a,1,2,3\n1,a,1,,3\n0,a,,,\n2,,1,1,1\n3,a,1,inf,0\n4,a\n";
        let told = read(text).unwrap_err().to_string();
        for fault in [
            "6 faults",
            "line 3: found \"now\"",
            "line 4: found \"\"",
            "line 5: found \"a\" at 0 s, as in line 2",
            "line 6: found no name",
            "line 7: found \"inf\"",
            "line 8: found",
        ] {
            assert!(told.contains(fault), "{fault:?} not in {told}");
        }
        let told = read("time_s,time_ms,marker,x_m,y_m,colour\n").unwrap_err().to_string();
        for fault in ["a second column of time", "no column of z", "the column \"colour\""] {
            assert!(told.contains(fault), "{fault:?} not in {told}");
        }
        assert!(read("time_s,marker,x_m,y_m,z_m\n0,a,,,\n").unwrap_err().to_string().contains("no marker"));
        assert!(read("").is_err());
    }
}
