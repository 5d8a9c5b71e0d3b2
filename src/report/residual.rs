//! What is left between a run and an experiment as tables, box plots (Fig. 3.29) and a page: `residual.json`,
//! `residual.csv`, `residual.svg`, `residual.html`.

use std::io::Write as _;
use std::path::Path;

use super::files::{self, WriteError};
use super::grid::Grid;
use super::page::{self, Figure, ResultPage};
use super::plots::boxes::box_plot;
use super::plots::{Axis, Key, Mark, Panel, Swatch, colour};
use super::results;
use super::rows::line;
use super::table::number;
use crate::study::compare::difference::BoxPlot;
use crate::study::experiment::align::Align;
use crate::study::experiment::residual::{FoundAlignment, GroupResidual, MarkerResidual, Residuals};
use crate::study::experiment::tracks::Matching;

const AXES: [&str; 3] = ["X", "Y", "Z"];

/// Most markers that have a row of their own in the text and in the figure; the file of rows has all.
const MOST_ROWS: usize = 24;

/// Writes all files of `residuals` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, residuals: &Residuals) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, vec![figure(residuals)])?;
    let page = ResultPage {
        title: &title(residuals),
        kind: "residuals",
        lead: &lead(residuals),
        tables: tables(residuals).iter().map(Grid::page).collect(),
        notes: String::new(),
        drawn: &drawn,
        provenance: &residuals.provenance,
        seed: None,
    }
    .html();
    files.write(&out.join("residual.html"), |file| file.write_all(page.as_bytes()))?;
    files.write(&out.join("residual.csv"), |file| file.write_all(&csv(residuals)))?;
    // Last: it says that the rest is there.
    files.write(&out.join("residual.json"), |file| results::as_json(file, residuals))?;
    files.appear()
}

/// Tables as text.
pub fn text(residuals: &Residuals) -> String {
    let tables = tables(residuals).into_iter().map(|grid| format!("\n{}\n{}", grid.title, grid.text()));
    format!("{}\n{}{}", title(residuals), lead(residuals), tables.collect::<String>())
}

fn title(residuals: &Residuals) -> String {
    format!("{} beside {}", residuals.run, residuals.experiment)
}

/// What was compared and what was fitted first, in words.
pub fn lead(residuals: &Residuals) -> String {
    let matched = match residuals.matching {
        Matching::Name => "markers on knots by their names",
        Matching::Nearest => "markers on the knots that are nearest where they were seen first",
    };
    let found = &residuals.alignment;
    let aligned = match residuals.align {
        Align::None => "nothing aligned".to_owned(),
        Align::Time => format!("aligned in time: {}", shift(found)),
        Align::Pose => format!("aligned in pose: {}", pose(found)),
        Align::Both => format!("aligned in time and pose: {}, {}", shift(found), pose(found)),
    };
    format!(
        "{} sightings of {} markers ({} gaps, {} after the run's end); {matched}; {aligned}. Root of the mean square \
         distance: {} mm.",
        residuals.compared,
        residuals.markers.len(),
        residuals.gaps,
        residuals.beyond,
        number(1e3 * residuals.rms_m)
    )
}

fn shift(found: &FoundAlignment) -> String {
    format!("its clock {:+.6} s", found.shift_s)
}

fn pose(found: &FoundAlignment) -> String {
    let angle = found.turn_deg.iter().map(|turn| turn * turn).sum::<f64>().sqrt();
    let [x, y, z] = found.offset_m;
    format!("turned by {angle:.4}°, moved by ({x:+.5}, {y:+.5}, {z:+.5}) m")
}

fn tables(residuals: &Residuals) -> Vec<Grid> {
    let head = |first: &[&str]| {
        let axes = AXES.iter().flat_map(|axis| [format!("{axis}, mean [mm]"), format!("{axis} / D [%]")]);
        let rest = ["distance, mean [mm]", "largest [mm]"].map(str::to_owned);
        first.iter().map(|head| (*head).to_owned()).chain(axes).chain(rest).collect()
    };
    let groups = residuals.groups.iter().map(|group| {
        let words = [words(group).to_owned(), group.markers.to_string()];
        words.into_iter().chain(cells(&group.axes_m, &group.relative_percent, &group.distance_m)).collect()
    });
    let marker = |marker: &MarkerResidual| {
        let words = [marker.marker.clone(), marker.knot.clone()];
        words.into_iter().chain(cells(&marker.axes_m, &marker.relative_percent, &marker.distance_m)).collect()
    };
    let mut tables = vec![Grid {
        title: "Residuals of groups (Eq. 3.20, 3.21)",
        n_words: 1,
        head: head(&["", "markers"]),
        rows: groups.collect(),
    }];
    if residuals.markers.len() <= MOST_ROWS {
        tables.push(Grid {
            title: "Residuals of markers",
            n_words: 2,
            head: head(&["marker", "knot"]),
            rows: residuals.markers.iter().map(marker).collect(),
        });
    }
    tables
}

fn words(group: &GroupResidual) -> &'static str {
    group.group.map_or("all", |group| group.words())
}

fn cells(axes: &[BoxPlot; 3], relative: &[Option<f64>; 3], distance: &BoxPlot) -> Vec<String> {
    let percent = |percent: Option<f64>| percent.map_or_else(|| "–".to_owned(), |p| format!("{p:.2}"));
    let of_axes =
        axes.iter().zip(relative).flat_map(|(along, &share)| [number(1e3 * along.mean), percent(share)]);
    of_axes.chain([distance.mean, distance.max].map(|metres| number(1e3 * metres))).collect()
}

/// A line for each marker and axis, then for each group and axis.
fn csv(residuals: &Residuals) -> Vec<u8> {
    let head = [
        "kind",
        "name",
        "knot",
        "group",
        "axis",
        "sightings",
        "mean_m",
        "lower_whisker_m",
        "lower_quartile_m",
    ];
    let rest = ["median_m", "upper_quartile_m", "upper_whisker_m", "max_m", "farthest_m", "relative_percent"];
    let mut lines = line(&[&head[..], &rest[..]].concat());
    let mut add =
        |words: [&str; 4], axis: usize, plot: &BoxPlot, farthest: Option<f64>, share: Option<f64>| {
            let numbers = [
                plot.mean,
                plot.lower_whisker,
                plot.lower,
                plot.median,
                plot.upper,
                plot.upper_whisker,
                plot.max,
            ];
            let text = |number: Option<f64>| number.map_or_else(String::new, |number| number.to_string());
            let first = words.map(str::to_owned).into_iter();
            let first = first.chain([AXES[axis].to_owned(), plot.count.to_string()]);
            let numbers = numbers.map(|number| number.to_string());
            lines
                .extend(line(&first.chain(numbers).chain([text(farthest), text(share)]).collect::<Vec<_>>()));
        };
    for marker in &residuals.markers {
        for axis in 0..3 {
            let words = ["marker", &marker.marker, &marker.knot, marker.group.words()];
            let farthest = Some(marker.farthest_m[axis]);
            add(words, axis, &marker.axes_m[axis], farthest, marker.relative_percent[axis]);
        }
    }
    for group in &residuals.groups {
        for axis in 0..3 {
            let words = ["group", words(group), "", words(group)];
            add(words, axis, &group.axes_m[axis], None, group.relative_percent[axis]);
        }
    }
    lines
}

/// Box plots of Eq. 3.20, a row a marker, or a group where there are many.
pub fn figure(residuals: &Residuals) -> Figure {
    let of_markers = residuals.markers.len() <= MOST_ROWS;
    let rows: Vec<(String, &[BoxPlot; 3])> = match of_markers {
        true => residuals.markers.iter().map(|marker| (marker.marker.clone(), &marker.axes_m)).collect(),
        false => residuals.groups.iter().map(|group| (words(group).to_owned(), &group.axes_m)).collect(),
    };
    let largest = rows.iter().flat_map(|(_, axes)| axes.iter().map(|plot| 1e3 * plot.max));
    let x = Axis::fixed("residual [mm]", 0.0, 1.04 * largest.fold(f64::MIN_POSITIVE, f64::max));
    let mut marks: Vec<Mark> = Vec::new();
    for (row, (_, axes)) in rows.iter().enumerate() {
        for (axis, plot) in axes.iter().enumerate() {
            let y = row as f64 + 0.25 * (axis as f64 - 1.0);
            marks.extend(box_plot(plot, y, colour(axis), |metres| 1e3 * metres));
        }
    }
    let names = rows.into_iter().map(|(name, _)| name).collect();
    let key = |axis: usize| Key {
        words: format!("along {}", AXES[axis]),
        colour: colour(axis),
        swatch: Swatch::Field,
    };
    let keys = [0, 1, 2].map(key).into();
    Figure {
        name: "residual".into(),
        title: "Residuals over time (Eq. 3.20, Fig. 3.29)".into(),
        words: format!(
            "Of each {}: quartiles, median, whiskers to the furthest value within 1.5 interquartile ranges, diamond for \
             the mean, ring for the largest.",
            if of_markers { "marker" } else { "group of knots" }
        ),
        panels: vec![Panel { keys, ..Panel::of_rows("", names, x, 66, marks) }],
    }
}
