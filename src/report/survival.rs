//! Survival of captures: the curve with its bands, and the table below it.

use plotters::style::RGBColor;

use super::page::Figure;
use super::plots::{Axis, Key, MUTED, Mark, Panel, Swatch, dashed};
use crate::study::survival::{Survival, SurvivalStep};

/// One curve of a figure.
pub struct Named<'a> {
    /// Its name.
    pub name: String,
    /// Its colour and whether it is broken: the number of its series.
    pub series: usize,
    /// The curve.
    pub survival: &'a Survival,
}

/// What the figure shows, for its caption.
const WORDS: &str = "Share of the members still held, over the time since each was first held (Kaplan and Meier), with \
    95 % bands (the beta product procedure of Fay, Brittain and Proschan). A first loss counts, even where the net came round again. Small strokes: members \
    whose run ended undecided there; they count neither as held nor as lost from then on. A member that settled counts \
    as held.";

/// The figure of all `curves`; without any it has no panel.
pub fn figure(curves: &[Named<'_>]) -> Figure {
    let longest = curves.iter().map(|named| named.survival.until_s).fold(0.0, f64::max);
    let mut marks = Vec::new();
    for named in curves {
        let colour = super::plots::colour(named.series);
        marks.extend(band(named.survival, longest, colour));
    }
    for named in curves {
        let colour = super::plots::colour(named.series);
        marks.push(Mark::Line {
            points: stairs(&named.survival.steps, longest.min(named.survival.until_s), |step| step.share),
            colour,
            width: 2,
            dashed: dashed(named.series),
        });
        marks.extend(named.survival.censored_at_s.iter().map(|&time| {
            let share = named.survival.at(time).map_or(1.0, |step| step.share);
            let points = vec![(time, 100.0 * share - 1.5), (time, 100.0 * share + 1.5)];
            Mark::Line { points, colour: MUTED, width: 1, dashed: false }
        }));
    }
    let keys = curves.iter().map(|named| Key {
        words: format!("{} ({} held)", named.name, named.survival.members),
        colour: super::plots::colour(named.series),
        swatch: if dashed(named.series) { Swatch::Dashed } else { Swatch::Line },
    });
    let keys: Vec<Key> = keys.collect();
    let x = Axis::fixed("time since first held [s]", 0.0, longest.max(1e-3));
    let y = Axis::fixed("still held [%]", 0.0, 103.0);
    let panel = Panel { keys, ..Panel::of_curves(x, y, 300, marks) };
    Figure {
        name: "survival".into(),
        title: "How long it holds".into(),
        words: WORDS.to_owned(),
        panels: if curves.is_empty() { Vec::new() } else { vec![panel] },
    }
}

fn band(survival: &Survival, longest: f64, colour: RGBColor) -> Option<Mark> {
    let until = longest.min(survival.until_s);
    let edge = |side: usize| stairs(&survival.steps, until, |step| step.band_95[side]);
    let (lower, upper) = (edge(0), edge(1));
    (lower.len() > 1).then(|| Mark::Band {
        x: lower.iter().map(|(x, _)| *x).collect(),
        lower: lower.iter().map(|(_, y)| *y).collect(),
        upper: upper.iter().map(|(_, y)| *y).collect(),
        colour,
        opacity: 0.12,
    })
}

/// The corners of a curve that falls in steps [s, %].
fn stairs(steps: &[SurvivalStep], until: f64, value: impl Fn(&SurvivalStep) -> f64) -> Vec<(f64, f64)> {
    let mut corners: Vec<(f64, f64)> = Vec::new();
    for step in steps {
        if let Some(&(_, before)) = corners.last() {
            corners.push((step.time_s, before));
        }
        corners.push((step.time_s, 100.0 * value(step)));
    }
    if let Some(&(_, last)) = corners.last() {
        corners.push((until, last));
    }
    corners
}

/// The curve in a line: `12 of 16 lost, 2 undecided; still held 38 % (15 to 61 %) at 27.0 s`.
pub fn words(survival: &Survival) -> String {
    let last = survival.steps.last();
    let held = last.map_or_else(String::new, |step| {
        let [low, high] = step.band_95.map(|bound| 100.0 * bound);
        format!(
            "; still held {:.0} % (95 % band {low:.0} to {high:.0} %) {:.1} s after it was first held",
            100.0 * step.share,
            survival.until_s
        )
    });
    format!(
        "{} of {} lost, {} settled, {} undecided{held}",
        survival.lost, survival.members, survival.settled, survival.censored
    )
}
