//! Drawing: panels become SVG.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::element::{DashedPathElement, EmptyElement, PathElement, Polygon, Rectangle};
use plotters::prelude::{
    Cartesian2d, ChartBuilder, ChartContext, Circle, DrawingArea, DrawingAreaErrorKind, IntoDrawingArea,
    IntoFont, IntoLogRange, RGBColor, SVGBackend, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, ShapeStyle, TextStyle};

use super::{Axis, Dot, GRID, INK, Key, Mark, PAPER, Panel, Swatch, WIDTH};

/// A drawing that failed.
pub type PlotError = DrawingAreaErrorKind<std::io::Error>;

/// Labels and name of a horizontal axis [px].
pub const AXIS_HEIGHT: u32 = 44;
const TEXT_SIZE: i32 = 13;
const LINE_HEIGHT: u32 = 20;
/// Mean width of a character of sans-serif, over its size; a little generous, so that words never meet.
const CHARACTER: f64 = 0.56;
/// Most characters of a row's name.
const LONGEST_ROW: usize = 44;
const MARGIN: u32 = 14;

/// The panels as one SVG.
///
/// # Errors
/// Never in memory; the drawing library says so by a type.
pub fn svg(panels: &[Panel]) -> Result<String, PlotError> {
    let legends: Vec<Vec<Vec<&Key>>> = panels.iter().map(|panel| legend_lines(&panel.keys)).collect();
    let head = |i: usize| {
        let title = if panels[i].title.is_empty() { 0 } else { LINE_HEIGHT };
        6 + title + LINE_HEIGHT * legends[i].len() as u32
    };
    let height = MARGIN + (0..panels.len()).map(|i| head(i) + panels[i].height + MARGIN).sum::<u32>();
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        root.fill(&PAPER)?;
        let mut top = MARGIN;
        for (i, panel) in panels.iter().enumerate() {
            let mut line = top as i32 + LINE_HEIGHT as i32 / 2;
            if !panel.title.is_empty() {
                words(&root, &panel.title, (MARGIN as i32, line), INK, HPos::Left, TEXT_SIZE + 1)?;
                line += LINE_HEIGHT as i32;
            }
            for keys in &legends[i] {
                draw_keys(&root, keys, line)?;
                line += LINE_HEIGHT as i32;
            }
            top += head(i);
            let area = root.clone().shrink((0, top), (WIDTH - MARGIN, panel.height));
            draw_panel(&root, &area, panel)?;
            top += panel.height + MARGIN;
        }
        root.present()?;
    }
    Ok(text)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn style(size: i32, colour: RGBColor) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&colour)
}

fn words(
    root: &Area,
    text: &str,
    at: (i32, i32),
    colour: RGBColor,
    anchor: HPos,
    size: i32,
) -> Result<(), PlotError> {
    root.draw(&Text::new(text.to_owned(), at, style(size, colour).pos(Pos::new(anchor, VPos::Center))))
}

fn width_of(text: &str) -> i32 {
    (CHARACTER * f64::from(TEXT_SIZE) * text.chars().count() as f64).ceil() as i32
}

/// Width of a key with its swatch and the space after it [px].
fn key_width(key: &Key) -> i32 {
    34 + width_of(&key.words) + 18
}

/// Keys in lines that fit the figure.
fn legend_lines(keys: &[Key]) -> Vec<Vec<&Key>> {
    let mut lines: Vec<Vec<&Key>> = Vec::new();
    let mut used = i32::MAX;
    for key in keys {
        let width = key_width(key);
        if used.saturating_add(width) > (WIDTH - 2 * MARGIN) as i32 {
            lines.push(Vec::new());
            used = 0;
        }
        used += width;
        if let Some(line) = lines.last_mut() {
            line.push(key);
        }
    }
    lines
}

fn draw_keys(root: &Area, keys: &[&Key], y: i32) -> Result<(), PlotError> {
    let mut x = MARGIN as i32;
    for key in keys {
        match key.swatch {
            Swatch::Field => {
                root.draw(&Rectangle::new([(x, y - 5), (x + 26, y + 5)], key.colour.filled()))?
            }
            Swatch::Line => {
                root.draw(&PathElement::new([(x, y), (x + 26, y)], key.colour.stroke_width(3)))?
            }
            Swatch::Dashed => {
                for start in [x, x + 10, x + 20] {
                    root.draw(&PathElement::new([(start, y), (start + 6, y)], key.colour.stroke_width(3)))?;
                }
            }
        }
        words(root, &key.words, (x + 34, y), INK, HPos::Left, TEXT_SIZE)?;
        x += key_width(key);
    }
    Ok(())
}

fn draw_panel<'a>(root: &Area<'a>, area: &Area<'a>, panel: &Panel) -> Result<(), PlotError> {
    let longest = panel.rows.iter().map(|row| width_of(&cut(row))).max();
    let longest_note = panel.notes.iter().map(|note| width_of(note)).max();
    let mut builder = ChartBuilder::on(area);
    builder
        .margin_left(MARGIN)
        .margin_top(4)
        .margin_right(longest_note.map_or(0, |width| width + 12))
        .x_label_area_size(AXIS_HEIGHT)
        .y_label_area_size(longest.map_or(66, |width| width + 10));
    let [x0, x1] = panel.x.range;
    let [y0, y1] = panel.y.range;
    match (panel.x.log, panel.y.log) {
        (false, false) => draw_chart(root, builder.build_cartesian_2d(x0..x1, y0..y1)?, panel),
        (true, false) => draw_chart(root, builder.build_cartesian_2d((x0..x1).log_scale(), y0..y1)?, panel),
        (false, true) => draw_chart(root, builder.build_cartesian_2d(x0..x1, (y0..y1).log_scale())?, panel),
        (true, true) => {
            draw_chart(root, builder.build_cartesian_2d((x0..x1).log_scale(), (y0..y1).log_scale())?, panel)
        }
    }
}

fn draw_chart<'a, 'b, X, Y>(
    root: &Area<'b>,
    mut chart: ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>,
    panel: &Panel,
) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let x_ticks = |value: &f64| tick(*value, &panel.x);
    let y_ticks = |value: &f64| tick(*value, &panel.y);
    let mut mesh = chart.configure_mesh();
    mesh.bold_line_style(GRID)
        .light_line_style(GRID.mix(0.0))
        .max_light_lines(0)
        .axis_style(INK)
        .label_style(style(TEXT_SIZE, INK))
        .axis_desc_style(style(TEXT_SIZE, INK))
        .x_labels(10)
        .y_labels(if panel.height > 180 { 7 } else { 4 })
        .x_label_formatter(&x_ticks)
        .y_label_formatter(&y_ticks)
        .x_desc(panel.x.label.clone());
    if panel.rows.is_empty() {
        mesh.y_desc(panel.y.label.clone());
    } else {
        mesh.disable_y_mesh().disable_y_axis();
    }
    mesh.draw()?;
    for (row, name) in panel.rows.iter().enumerate() {
        let (x, y) = chart.backend_coord(&(panel.x.range[0], row as f64));
        words(root, &cut(name), (x - 8, y), INK, HPos::Right, TEXT_SIZE)?;
    }
    for (row, note) in panel.notes.iter().enumerate() {
        let (x, y) = chart.backend_coord(&(panel.x.range[1], row as f64));
        words(root, note, (x + 10, y), INK, HPos::Left, TEXT_SIZE)?;
    }
    for mark in &panel.marks {
        draw_mark(&mut chart, mark, &panel.x, &panel.y)?;
    }
    Ok(())
}

/// A name that would leave no room for the diagram is cut.
fn cut(name: &str) -> String {
    if name.chars().count() <= LONGEST_ROW {
        return name.to_owned();
    }
    name.chars().take(LONGEST_ROW - 1).chain(['…']).collect()
}

fn draw_mark<'a, 'b, X, Y>(
    chart: &mut ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>,
    mark: &Mark,
    x: &Axis,
    y: &Axis,
) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    // Rows count downward: their axis runs from high to low and nothing lies outside of it.
    let in_y = |value: f64| if y.range[0] < y.range[1] { y.clamp(value) } else { value };
    let inside = |&(a, b): &(f64, f64)| (x.clamp(a), in_y(b));
    match mark {
        Mark::Line { points, colour, width, dashed } => {
            let points: Vec<(f64, f64)> = points.iter().map(inside).collect();
            let style = colour.stroke_width(*width);
            if *dashed {
                chart.draw_series([DashedPathElement::new(points, 6, 4, style)])?;
            } else {
                chart.draw_series([PathElement::new(points, style)])?;
            }
        }
        Mark::Band { x: along, lower, upper, colour, opacity } => {
            let there = along.iter().copied().zip(upper.iter().copied());
            let back = along.iter().copied().zip(lower.iter().copied()).rev();
            let outline: Vec<(f64, f64)> = there.chain(back).map(|point| inside(&point)).collect();
            chart.draw_series([Polygon::new(outline, colour.mix(*opacity))])?;
        }
        Mark::Bar { from, to, colour, opacity, edge } => {
            let corners = [inside(from), inside(to)];
            chart.draw_series([Rectangle::new(corners, colour.mix(*opacity).filled())])?;
            if *edge {
                chart.draw_series([Rectangle::new(corners, colour.stroke_width(1))])?;
            }
        }
        Mark::Dot { at, colour, shape } => draw_dot(chart, inside(at), *colour, *shape)?,
        Mark::Words { at, text, colour, ends } => {
            let anchor = Pos::new(if *ends { HPos::Right } else { HPos::Left }, VPos::Center);
            let style = style(TEXT_SIZE - 1, *colour).pos(anchor);
            chart.draw_series([Text::new(text.clone(), inside(at), style)])?;
        }
    }
    Ok(())
}

fn draw_dot<'a, 'b, X, Y>(
    chart: &mut ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>,
    at: (f64, f64),
    colour: RGBColor,
    shape: Dot,
) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    match shape {
        Dot::Ring => chart.draw_series([Circle::new(at, 3, ShapeStyle::from(colour).stroke_width(1))])?,
        Dot::Full => chart.draw_series([Circle::new(at, 4, ShapeStyle::from(colour).filled())])?,
        Dot::Diamond => {
            let diamond = |size: i32| vec![(-size, 0), (0, -size), (size, 0), (0, size)];
            let element =
                |size: i32, colour: RGBColor| EmptyElement::at(at) + Polygon::new(diamond(size), colour);
            chart.draw_series([element(5, PAPER)])?;
            chart.draw_series([element(4, colour)])?
        }
    };
    Ok(())
}

/// A number at an axis, with no more digits than its range needs.
fn tick(value: f64, axis: &Axis) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    let span = if axis.log { size } else { (axis.range[1] - axis.range[0]).abs() };
    if !(1e-3..1e5).contains(&span) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let decimals = (1.0 - span.log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        let linear = |high: f64| Axis::fixed("", 0.0, high);
        assert_eq!(tick(0.5, &linear(3.0)), "0.5");
        assert_eq!(tick(2.0, &linear(3.0)), "2");
        assert_eq!(tick(20000.0, &linear(90000.0)), "20000");
        assert_eq!(tick(0.0002, &linear(0.0009)), "2e-4");
        let log = Axis::log("", [1e-4, 1e4], 6);
        assert_eq!(["0.01", "1", "1000"], [1e-2, 1.0, 1e3].map(|v| tick(v, &log)));
    }

    #[test]
    fn a_long_legend_goes_on_in_a_second_line() {
        let key = |words: &str| Key { words: words.to_owned(), colour: INK, swatch: Swatch::Line };
        let keys: Vec<Key> = (0..12).map(|i| key(&format!("effects.closing.layout=number{i}"))).collect();
        let lines = legend_lines(&keys);
        assert!(lines.len() > 1 && lines.iter().map(Vec::len).sum::<usize>() == 12);
        for line in lines {
            assert!(line.iter().map(|key| key_width(key)).sum::<i32>() <= (WIDTH - 2 * MARGIN) as i32);
        }
    }
}
