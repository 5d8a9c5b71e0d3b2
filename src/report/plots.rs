//! Plots as SVG: panels one below the other, each with its own legend, for print and for a page.
//!
//! A figure is data first ([`Panel`], [`Mark`]) and drawn by [`svg`], so that what a figure shows is decided in one
//! place and how it looks in another. Panels have a numeric vertical axis, or rows with a name each.
//!
//! Colours are those of Okabe and Ito, which the colour-blind can tell apart; from the eighth series on they repeat
//! with dashes. Every colour stands in the file as `#RRGGBB` from this list, so that a page can give each another one
//! in the dark ([`DARK`]).

pub mod boxes;
mod draw;

use plotters::style::RGBColor;

pub use draw::{PlotError, printed, svg};

/// Width of every figure [px].
pub const WIDTH: u32 = 960;

/// Paper.
pub const PAPER: RGBColor = RGBColor(255, 255, 255);
/// Text and axes.
pub const INK: RGBColor = RGBColor(23, 32, 43);
/// Second voice: chaos, remarks.
pub const MUTED: RGBColor = RGBColor(110, 118, 128);
/// Grid lines.
pub const GRID: RGBColor = RGBColor(222, 227, 234);

/// Colours of series.
const SERIES: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 94, 60),
];

/// Colours of kinds within a bar, after Tol's muted scheme: none of them is a series'.
const KINDS: [RGBColor; 7] = [
    RGBColor(51, 34, 136),
    RGBColor(136, 204, 238),
    RGBColor(17, 119, 51),
    RGBColor(153, 153, 51),
    RGBColor(204, 102, 119),
    RGBColor(221, 204, 119),
    RGBColor(136, 34, 85),
];

/// What each colour becomes on a dark page.
pub const DARK: [(RGBColor, &str); 18] = [
    (PAPER, "#121821"),
    (INK, "#E7ECF3"),
    (MUTED, "#9AA8BA"),
    (GRID, "#2B3645"),
    (SERIES[0], "#4FA3E0"),
    (SERIES[1], "#FF8A3D"),
    (SERIES[2], "#2FC79A"),
    (SERIES[3], "#E5A0C8"),
    (SERIES[4], "#F2C14E"),
    (SERIES[5], "#A5DBFF"),
    (SERIES[6], "#B79A74"),
    (KINDS[0], "#8E7FE0"),
    (KINDS[1], "#A9DCF5"),
    (KINDS[2], "#3FA866"),
    (KINDS[3], "#C2C25A"),
    (KINDS[4], "#E08A98"),
    (KINDS[5], "#EBDD9A"),
    (KINDS[6], "#D278A6"),
];

/// Colour of series `number`.
pub fn colour(number: usize) -> RGBColor {
    SERIES[number % SERIES.len()]
}

/// Colour of kind `number` within a bar.
pub fn kind_colour(number: usize) -> RGBColor {
    KINDS[number % KINDS.len()]
}

/// Whether series `number` is dashed, since its colour is taken.
pub fn dashed(number: usize) -> bool {
    number >= SERIES.len()
}

/// `colour` as it stands in the file.
pub fn hex(colour: RGBColor) -> String {
    format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2)
}

/// How a curve is stroked, so that it is told from others without colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Width [px].
    pub width: f64,
    /// Lengths of strokes and gaps in turn [px]; none: unbroken.
    pub dashes: &'static [f64],
}

/// Pens that differ in print without colours; none occurs twice.
const PENS: [&[f64]; MOST_PENS] = [
    &[],
    &[7.0, 3.0],
    &[1.5, 2.5],
    &[9.0, 2.5, 1.5, 2.5],
    &[16.0, 4.0],
    &[4.0, 2.0],
    &[9.0, 2.5, 1.5, 2.5, 1.5, 2.5],
    &[2.0, 7.0],
];

/// Most curves of one panel that are told apart without colours.
pub const MOST_PENS: usize = 8;

/// The pen of curve `number`, which is below [`MOST_PENS`].
pub fn pen(number: usize) -> Pen {
    Pen { width: 1.6, dashes: PENS[number % MOST_PENS] }
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What it shows, with the unit.
    pub label: String,
    /// Its ends.
    pub range: [f64; 2],
    /// Whether equal lengths are equal ratios.
    pub log: bool,
}

impl Axis {
    /// An axis with equal steps that holds all `values`, with some room.
    pub fn linear(label: &str, values: impl IntoIterator<Item = f64>) -> Axis {
        let [low, high] = ends(values.into_iter());
        // All alike: room for one value, so that rounding noise is not blown up into a curve.
        let room = if high - low > 1e-9 * high.abs().max(low.abs()) {
            0.04 * (high - low)
        } else {
            high.abs().max(1.0)
        };
        let low = if low == 0.0 { 0.0 } else { low - room };
        Axis { label: label.to_owned(), range: [low, high + room], log: false }
    }

    /// An axis with equal ratios that holds the positive ones of `values`, at most `decades` below the largest.
    pub fn log(label: &str, values: impl IntoIterator<Item = f64>, decades: i32) -> Axis {
        let positive = values.into_iter().filter(|value| *value > 0.0);
        let [low, high] = ends(positive);
        let high = if high > 0.0 { 10_f64.powf((1.5 * high).log10()) } else { 1.0 };
        let low = low.max(high * 10_f64.powi(-decades)).min(0.1 * high);
        Axis { label: label.to_owned(), range: [low.max(f64::MIN_POSITIVE), high], log: true }
    }

    /// From `low` to `high`.
    pub fn fixed(label: &str, low: f64, high: f64) -> Axis {
        Axis { label: label.to_owned(), range: [low, high], log: false }
    }

    fn clamp(&self, value: f64) -> f64 {
        if value.is_nan() { self.range[0] } else { value.clamp(self.range[0], self.range[1]) }
    }
}

fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let finite = values.filter(|value| value.is_finite());
    let [low, high] =
        finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    if low > high { [0.0, 1.0] } else { [low, high] }
}

/// Something drawn in a panel; of a panel with rows, row i is at y = i.
#[derive(Clone, Debug)]
pub enum Mark {
    /// A curve.
    Line {
        /// Its points.
        points: Vec<(f64, f64)>,
        /// Its colour.
        colour: RGBColor,
        /// Width [px].
        width: u32,
        /// Whether it is broken.
        dashed: bool,
    },
    /// A curve with a name and a pen of its own.
    Curve {
        /// What it shows; a browser shows that at the pointer.
        name: String,
        /// Its points.
        points: Vec<(f64, f64)>,
        /// Its colour.
        colour: RGBColor,
        /// How it is stroked.
        pen: Pen,
    },
    /// The space between two curves.
    Band {
        /// Along x.
        x: Vec<f64>,
        /// Lower edge.
        lower: Vec<f64>,
        /// Upper edge.
        upper: Vec<f64>,
        /// Its colour.
        colour: RGBColor,
        /// 0 is not seen, 1 covers.
        opacity: f64,
    },
    /// A rectangle between two corners.
    Bar {
        /// One corner.
        from: (f64, f64),
        /// The other.
        to: (f64, f64),
        /// Its colour.
        colour: RGBColor,
        /// 0 is not seen, 1 covers.
        opacity: f64,
        /// Whether it has an edge in its colour.
        edge: bool,
    },
    /// A point.
    Dot {
        /// Where.
        at: (f64, f64),
        /// Its colour.
        colour: RGBColor,
        /// How it looks.
        shape: Dot,
    },
    /// Words.
    Words {
        /// Where.
        at: (f64, f64),
        /// What.
        text: String,
        /// Their colour.
        colour: RGBColor,
        /// Whether they end there, and do not begin.
        ends: bool,
    },
}

/// Shape of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dot {
    /// A full diamond on paper: a mean.
    Diamond,
    /// A ring: an outlier.
    Ring,
    /// A full circle.
    Full,
    /// A full square on paper: what others found.
    Square,
    /// An open square on paper.
    OpenSquare,
}

/// An entry of a legend.
#[derive(Clone, Debug)]
pub struct Key {
    /// Its words.
    pub words: String,
    /// Its colour.
    pub colour: RGBColor,
    /// How it looks.
    pub swatch: Swatch,
}

/// What a legend shows beside the words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Swatch {
    /// A line.
    Line,
    /// A broken line.
    Dashed,
    /// A filled field.
    Field,
    /// A stroke of a pen.
    Pen(Pen),
}

/// One diagram.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Words above it; may be empty.
    pub title: String,
    /// Legend above it.
    pub keys: Vec<Key>,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis; of a panel with rows only its label is not used.
    pub y: Axis,
    /// Names of rows, from above; without any the vertical axis carries numbers.
    pub rows: Vec<String>,
    /// Words to the right of each row; may be empty.
    pub notes: Vec<String>,
    /// What it shows, from back to front.
    pub marks: Vec<Mark>,
    /// Height of the diagram, without title and legend [px].
    pub height: u32,
}

impl Panel {
    /// A panel with numbers along both axes.
    pub fn of_curves(x: Axis, y: Axis, height: u32, marks: Vec<Mark>) -> Panel {
        let (rows, notes) = (Vec::new(), Vec::new());
        Panel { title: String::new(), keys: Vec::new(), x, y, rows, notes, marks, height }
    }

    /// A panel of `rows`, `row_height` pixels each.
    pub fn of_rows(title: &str, rows: Vec<String>, x: Axis, row_height: u32, marks: Vec<Mark>) -> Panel {
        let height = draw::AXIS_HEIGHT + 8 + row_height * rows.len() as u32;
        let y = Axis::fixed("", rows.len() as f64 - 0.5, -0.5);
        let (title, notes) = (title.to_owned(), Vec::new());
        Panel { title, keys: Vec::new(), x, y, rows, notes, marks, height }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_their_values_and_survive_none() {
        let axis = Axis::linear("", [0.0, 2.0, f64::NAN]);
        assert!(axis.range[0] == 0.0 && axis.range[1] > 2.0);
        let flat = Axis::linear("", [3.0, 3.0]);
        assert!(flat.range[0] < 3.0 && flat.range[1] > 3.0);
        let log = Axis::log("", [0.0, 1e-30, 10.0], 6);
        assert!(log.range[0] > 9e-6 && log.range[1] >= 10.0, "{log:?}");
        for axis in [Axis::linear("", []), Axis::log("", [0.0], 6), Axis::log("", [], 6)] {
            assert!(axis.range[0] < axis.range[1] && axis.range[1].is_finite(), "{axis:?}");
        }
    }

    #[test]
    fn no_pen_occurs_twice() {
        let all: Vec<Pen> = (0..MOST_PENS).map(pen).collect();
        assert!(all.iter().enumerate().all(|(n, one)| !all[..n].contains(one)));
    }

    #[test]
    fn every_colour_has_one_for_the_dark() {
        let known = |colour: RGBColor| DARK.iter().any(|(light, _)| *light == colour);
        assert!(
            (0..20).flat_map(|n| [colour(n), kind_colour(n)]).chain([PAPER, INK, MUTED, GRID]).all(known)
        );
    }
}
