//! Box plots along a row of a panel.

use plotters::style::RGBColor;

use super::{Dot, INK, Mark};
use crate::study::compare::difference::BoxPlot;

/// Half the height of a box, in rows.
const HALF: f64 = 0.075;

/// A whisker with its ends, along row `y`.
pub fn whisker(low: f64, high: f64, y: f64, tip: f64, colour: RGBColor) -> [Mark; 3] {
    let stroke = |points: Vec<(f64, f64)>| Mark::Line { points, colour, width: 1, dashed: false };
    [
        stroke(vec![(low, y), (high, y)]),
        stroke(vec![(low, y - tip), (low, y + tip)]),
        stroke(vec![(high, y - tip), (high, y + tip)]),
    ]
}

/// `plot` at row `y`, its numbers in the unit of the axis: box, median, whiskers, a ring for the largest beyond them, a
/// diamond for the mean.
pub fn box_plot(plot: &BoxPlot, y: f64, colour: RGBColor, unit: fn(f64) -> f64) -> Vec<Mark> {
    let mut marks =
        whisker(unit(plot.lower_whisker), unit(plot.upper_whisker), y, 0.5 * HALF, colour).to_vec();
    let [from, to] = [(unit(plot.lower), y - HALF), (unit(plot.upper), y + HALF)];
    marks.push(Mark::Bar { from, to, colour, opacity: 0.35, edge: true });
    let median = [y - HALF, y + HALF].map(|y| (unit(plot.median), y));
    marks.push(Mark::Line { points: median.into(), colour, width: 3, dashed: false });
    if plot.max > plot.upper_whisker {
        marks.push(Mark::Dot { at: (unit(plot.max), y), colour, shape: Dot::Ring });
    }
    marks.push(Mark::Dot { at: (unit(plot.mean), y), colour: INK, shape: Dot::Diamond });
    marks
}
