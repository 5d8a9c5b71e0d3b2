//! What is left between a run and an experiment.
//!
//! re = |s − ex| along each axis, at each time that a marker was seen        (Eq. 3.20)
//! ar = (1/n) Σ mean(re_i) / D_i · 100 %  over the n markers of a group      (Eq. 3.21)
//!
//! s is the knot in the run, ex its marker in the experiment, both in the frame of the run, and D the farthest that the
//! marker came along that axis from where it was seen first. The source does not say which re of many times Eq. 3.21 takes:
//! here it is the mean. A marker that did not move along an axis has no relative residual there.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::align::{Align, AlignError, Alignment};
use super::paths::{KnotGroup, KnotPaths};
use super::tracks::{MarkerTracks, Matching, Paired};
use crate::problems::Problems;
use crate::provenance::Provenance;
use crate::study::compare::difference::BoxPlot;

/// `residual.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Residuals {
    /// The run.
    pub run: String,
    /// The experiment: a file of tracks, or another run.
    pub experiment: String,
    /// How markers found their knots.
    pub matching: Matching,
    /// What was fitted first.
    pub align: Align,
    /// What was found.
    pub alignment: FoundAlignment,
    /// Sightings that are compared.
    pub compared: usize,
    /// Sightings after the run's end, which are not.
    pub beyond: usize,
    /// Rows of the tracks without coordinates.
    pub gaps: usize,
    /// Root of the mean square distance of knot and marker [m].
    pub rms_m: f64,
    /// Groups of knots, then all together.
    pub groups: Vec<GroupResidual>,
    /// The markers.
    pub markers: Vec<MarkerResidual>,
    /// What made it.
    pub provenance: Provenance,
}

/// Clock and frame of the experiment in those of the run: t = t' + shift, x = turn x' + offset.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FoundAlignment {
    /// Shift in time [s].
    pub shift_s: f64,
    /// Turn, as a vector along its axis [deg].
    pub turn_deg: [f64; 3],
    /// Offset [m].
    pub offset_m: [f64; 3],
}

impl From<&Alignment> for FoundAlignment {
    fn from(found: &Alignment) -> FoundAlignment {
        FoundAlignment {
            shift_s: found.shift,
            turn_deg: found.turn.scaled_axis().map(f64::to_degrees).into(),
            offset_m: found.offset.into(),
        }
    }
}

/// What is left of a marker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MarkerResidual {
    /// Its name in the experiment.
    pub marker: String,
    /// The knot it is on.
    pub knot: String,
    /// The knot's group.
    pub group: KnotGroup,
    /// Eq. 3.20 along X, Y and Z over time [m].
    pub axes_m: [BoxPlot; 3],
    /// How far knot and marker are apart over time [m].
    pub distance_m: BoxPlot,
    /// D of Eq. 3.21 along X, Y and Z [m].
    pub farthest_m: [f64; 3],
    /// Mean of Eq. 3.20 over D along X, Y and Z [%]; null where it did not move.
    pub relative_percent: [Option<f64>; 3],
}

/// What is left of a group of knots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GroupResidual {
    /// The group; null: all markers.
    pub group: Option<KnotGroup>,
    /// Its markers.
    pub markers: usize,
    /// Eq. 3.20 along X, Y and Z over markers and time [m].
    pub axes_m: [BoxPlot; 3],
    /// How far knot and marker are apart, over markers and time [m].
    pub distance_m: BoxPlot,
    /// Eq. 3.21 along X, Y and Z [%]; null where no marker moved.
    pub relative_percent: [Option<f64>; 3],
}

/// What is compared, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResidualRequest {
    /// How markers find their knots.
    pub matching: Matching,
    /// What is fitted first.
    pub align: Align,
}

/// |r| of a sighting along the axes.
struct Left {
    group: KnotGroup,
    axes: [f64; 3],
}

impl Left {
    fn distance(&self) -> f64 {
        self.axes.iter().map(|along| along * along).sum::<f64>().sqrt()
    }
}

impl ResidualRequest {
    /// What is left between `paths`, which are those of `run`, and `tracks`, those of `experiment`.
    ///
    /// # Errors
    /// Faults of the tracks: markers on no knot of the net, or on the same; nothing seen while the run lasts; markers on a
    /// line, of which there is no pose.
    pub fn residuals(
        self,
        (run, paths): (&str, &KnotPaths),
        (experiment, tracks): (&str, &MarkerTracks),
    ) -> Result<Residuals, Problems> {
        let mut problems = Problems::new(experiment);
        let knots = tracks.knots(paths, self.matching, &mut problems);
        let residuals = knots.and_then(|knots| {
            let found = self.compare((run, paths), (experiment, tracks), &tracks.paired(&knots));
            found.map_err(|why| problems.add("", why, "tracks that can be compared, or --align none")).ok()
        });
        problems.into_result(residuals)
    }

    /// The same of sightings whose knots are known.
    pub(super) fn compare(
        self,
        (run, paths): (&str, &KnotPaths),
        (experiment, tracks): (&str, &MarkerTracks),
        seen: &[Paired],
    ) -> Result<Residuals, AlignError> {
        let alignment = &Alignment::fit(paths, seen, self.align)?;
        let compared: Vec<&Paired> = seen.iter().filter(|one| paths.covers(alignment.time(one))).collect();
        if compared.is_empty() {
            return Err(AlignError::Apart);
        }
        let left = |one: &&Paired| Left {
            group: paths.names.group(one.knot),
            axes: alignment.residual(paths, one).abs().into(),
        };
        let left: Vec<Left> = compared.iter().map(left).collect();
        let squares = left.iter().map(|one| one.distance().powi(2)).sum::<f64>();
        let markers = markers(paths, tracks, &compared, &left, alignment);
        let group = |group: Option<KnotGroup>| {
            let is_of = |other: KnotGroup| group.is_none_or(|group| group == other);
            let members: Vec<&MarkerResidual> = markers.iter().filter(|marker| is_of(marker.group)).collect();
            let of_group: Vec<&Left> = left.iter().filter(|one| is_of(one.group)).collect();
            (!of_group.is_empty()).then(|| {
                let (axes_m, distance_m) = boxes(&of_group);
                let relative =
                    |axis: usize| members.iter().filter_map(move |m| m.relative_percent[axis]).collect();
                let relative_percent = [0, 1, 2].map(|axis| mean(relative(axis)));
                GroupResidual { group, markers: members.len(), axes_m, distance_m, relative_percent }
            })
        };
        let groups = KnotGroup::ALL.into_iter().map(Some).chain([None]).filter_map(group).collect();
        Ok(Residuals {
            run: run.to_owned(),
            experiment: experiment.to_owned(),
            matching: self.matching,
            align: self.align,
            alignment: alignment.into(),
            compared: compared.len(),
            beyond: seen.len() - compared.len(),
            gaps: tracks.markers.iter().map(|marker| marker.gaps).sum(),
            rms_m: (squares / left.len() as f64).sqrt(),
            groups,
            markers,
            provenance: Provenance::here(),
        })
    }
}

/// Every marker of which something is compared; its sightings follow one another.
fn markers(
    paths: &KnotPaths,
    tracks: &MarkerTracks,
    compared: &[&Paired],
    left: &[Left],
    alignment: &Alignment,
) -> Vec<MarkerResidual> {
    let mut markers = Vec::new();
    let mut from = 0;
    for seen in compared.chunk_by(|one, other| one.marker == other.marker) {
        let own: Vec<&Left> = left[from..from + seen.len()].iter().collect();
        from += seen.len();
        let (first, start) = (seen[0], alignment.place(seen[0]));
        let came = |axis: usize| {
            seen.iter().map(|one| (alignment.place(one)[axis] - start[axis]).abs()).fold(0.0, f64::max)
        };
        let farthest_m = [0, 1, 2].map(came);
        let (axes_m, distance_m) = boxes(&own);
        let relative = |axis: usize| {
            let farthest = farthest_m[axis];
            (farthest > 0.0).then(|| 100.0 * axes_m[axis].mean / farthest)
        };
        markers.push(MarkerResidual {
            marker: tracks.markers[first.marker].name.clone(),
            knot: paths.names.name(first.knot),
            group: paths.names.group(first.knot),
            axes_m,
            distance_m,
            farthest_m,
            relative_percent: [0, 1, 2].map(relative),
        });
    }
    markers
}

/// Box plots along the axes, and of the distance; there is at least one sighting.
fn boxes(left: &[&Left]) -> ([BoxPlot; 3], BoxPlot) {
    let along = |axis: usize| BoxPlot::of(left.iter().map(|one| one.axes[axis]).collect());
    ([0, 1, 2].map(along), BoxPlot::of(left.iter().map(|one| one.distance()).collect()))
}

fn mean(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::paths::KnotNames;
    use super::super::tracks::{MarkerTrack, Sighting};
    use super::*;

    /// A grid of 3 x 3 knots that goes 1 m along X in 1 s.
    fn paths() -> KnotPaths {
        let position = |t: f64| (0..9).map(|k| Vector3::new(t, f64::from(k / 3), f64::from(k % 3))).collect();
        KnotPaths {
            names: KnotNames { grid: [3, 3], n_knots: 9 },
            time: vec![0.0, 0.5, 1.0],
            position: [0.0, 0.5, 1.0].map(position).into(),
            velocity: vec![vec![Vector3::x(); 9]; 3],
        }
    }

    fn track(name: &str, seen: &[(f64, [f64; 3])]) -> MarkerTrack {
        let seen = seen.iter().map(|&(time, place)| Sighting { time, position: place.into() }).collect();
        MarkerTrack { name: name.to_owned(), line: 2, seen, gaps: 1 }
    }

    /// By hand: one bullet 0.1 and 0.3 m behind, the middle knot 0.2 m aside, one sighting too late.
    #[test]
    fn residuals_are_those_of_the_equations() {
        let markers = vec![
            track("bullet-1", &[(0.0, [-0.1, 0.0, 0.0]), (0.8, [0.5, 0.0, 0.0])]),
            track("knot-1-1", &[(0.5, [0.5, 1.2, 1.0]), (2.0, [2.0, 1.0, 1.0])]),
        ];
        let tracks = MarkerTracks { markers };
        let request = ResidualRequest { matching: Matching::Name, align: Align::None };
        let found = request.residuals(("run", &paths()), ("track", &tracks)).unwrap();
        assert_eq!((found.compared, found.beyond, found.gaps), (3, 1, 2));
        let near =
            |value: f64, expected: f64| assert!((value - expected).abs() < 1e-12, "{value}, {expected}");
        let bullet = &found.markers[0];
        near(bullet.axes_m[0].mean, 0.2);
        near(bullet.axes_m[0].max, 0.3);
        near(bullet.farthest_m[0], 0.6);
        near(bullet.relative_percent[0].unwrap(), 100.0 / 3.0);
        assert_eq!(bullet.relative_percent[1], None);
        near(found.markers[1].axes_m[1].mean, 0.2);
        let groups: Vec<_> = found.groups.iter().map(|group| (group.group, group.markers)).collect();
        assert_eq!(groups, [(Some(KnotGroup::Bullets), 1), (Some(KnotGroup::Inner), 1), (None, 2)]);
        near(found.groups[2].axes_m[0].mean, 0.4 / 3.0);
        near(found.rms_m, ((0.01 + 0.09 + 0.04) / 3.0_f64).sqrt());
    }

    #[test]
    fn markers_find_their_knots_by_place_where_they_have_other_names() {
        let tracks = MarkerTracks {
            markers: vec![track("A", &[(0.2, [0.2, 0.1, 1.9])]), track("B", &[(0.9, [0.9, 1.4, 0.8])])],
        };
        let by = |matching: Matching| {
            let request = ResidualRequest { matching, align: Align::None };
            request.residuals(("run", &paths()), ("track", &tracks))
        };
        let told = by(Matching::Name).unwrap_err().to_string();
        assert!(told.contains("2 faults") && told.contains("the marker \"A\""), "{told}");
        let knots: Vec<String> =
            by(Matching::Nearest).unwrap().markers.into_iter().map(|marker| marker.knot).collect();
        assert_eq!(knots, ["bullet-4", "knot-1-1"]);
        let twice =
            MarkerTracks { markers: vec![tracks.markers[0].clone(), track("C", &[(0.0, [0.0, 0.0, 2.0])])] };
        let request = ResidualRequest { matching: Matching::Nearest, align: Align::None };
        let told = request.residuals(("run", &paths()), ("track", &twice)).unwrap_err().to_string();
        assert!(told.contains("\"C\" on bullet-4, as \"A\""), "{told}");
    }
}
