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

use super::{Axis, Dot, GRID, INK, Key, Mark, PAPER, Panel, Pen, Swatch, WIDTH, hex};
use crate::report::page::escape;

/// A drawing that failed.
pub type PlotError = DrawingAreaErrorKind<std::io::Error>;

/// Labels and name of a horizontal axis [px].
pub const AXIS_HEIGHT: u32 = 44;
/// The same of one without either [px].
const BARE_HEIGHT: u32 = 8;
const TEXT_SIZE: i32 = 13;
const LINE_HEIGHT: u32 = 20;
/// Mean width of a character of sans-serif, over its size; a little generous, so that words never meet.
const CHARACTER: f64 = 0.56;
/// Most characters of a row's name.
const LONGEST_ROW: usize = 44;
const MARGIN: u32 = 14;

/// What panels are drawn on: lengths are told in pixels, which a sheet of paper parts into smaller ones.
#[derive(Clone, Copy, Debug)]
struct Sheet {
    /// Its width [px].
    width: u32,
    /// Places of a coordinate in a pixel: a browser shows none between two, a printer does.
    scale: u32,
    /// Its width on paper [mm]; none: on a page.
    millimetres: Option<f64>,
}

/// A pixel on paper [mm]: text of 13 px becomes one of 7.5 points.
const PIXEL_MM: f64 = 0.2525;

/// Places of a coordinate in a pixel on paper: 0.013 mm.
const FINE: u32 = 20;

impl Sheet {
    const PAGE: Sheet = Sheet { width: WIDTH, scale: 1, millimetres: None };

    fn of_paper(millimetres: f64) -> Sheet {
        Sheet { width: (millimetres / PIXEL_MM).round() as u32, scale: FINE, millimetres: Some(millimetres) }
    }

    /// `pixels` in places of a coordinate.
    fn px(&self, pixels: u32) -> u32 {
        self.scale * pixels
    }

    /// The same with a sign.
    fn at(&self, pixels: i32) -> i32 {
        self.scale as i32 * pixels
    }

    fn is_paper(&self) -> bool {
        self.millimetres.is_some()
    }

    fn style(&self, size: i32, colour: RGBColor) -> TextStyle<'static> {
        ("sans-serif", self.at(size)).into_font().color(&colour)
    }
}

/// The panels as one SVG, for a page.
///
/// # Errors
/// Never in memory; the drawing library says so by a type.
pub fn svg(panels: &[Panel]) -> Result<String, PlotError> {
    drawn(panels, Sheet::PAGE)
}

/// The panels as one SVG of so many `millimetres` on paper: finer lines, text of 7.5 points, and the name of a
/// horizontal axis that neighbours share at the lowest of them alone.
///
/// # Errors
/// Never in memory; the drawing library says so by a type.
pub fn printed(panels: &[Panel], millimetres: f64) -> Result<String, PlotError> {
    drawn(panels, Sheet::of_paper(millimetres))
}

fn drawn(panels: &[Panel], sheet: Sheet) -> Result<String, PlotError> {
    let legends: Vec<Vec<Vec<&Key>>> =
        panels.iter().map(|panel| legend_lines(&panel.keys, sheet.width)).collect();
    let head = |i: usize| {
        let title = if panels[i].title.is_empty() { 0 } else { LINE_HEIGHT };
        6 + title + LINE_HEIGHT * legends[i].len() as u32
    };
    // A panel whose horizontal axis stands below the next one gives its labels' room back.
    let shares = |i: usize| sheet.is_paper() && panels.get(i + 1).is_some_and(|next| next.x == panels[i].x);
    let height_of = |i: usize| panels[i].height - if shares(i) { AXIS_HEIGHT - BARE_HEIGHT } else { 0 };
    let gap = if sheet.is_paper() { 2 } else { MARGIN };
    let height = MARGIN + (0..panels.len()).map(|i| head(i) + height_of(i) + gap).sum::<u32>();
    let (mut text, mut curves) = (String::new(), String::new());
    {
        let size = (sheet.px(sheet.width), sheet.px(height));
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&PAPER)?;
        let mut top = MARGIN;
        for (i, panel) in panels.iter().enumerate() {
            let mut line = top as i32 + LINE_HEIGHT as i32 / 2;
            if !panel.title.is_empty() {
                let at = (sheet.at(MARGIN as i32), sheet.at(line));
                root.draw(&words(&panel.title, at, HPos::Left, sheet.style(TEXT_SIZE + 1, INK)))?;
                line += LINE_HEIGHT as i32;
            }
            for keys in &legends[i] {
                draw_keys(&root, keys, line, sheet, &mut curves)?;
                line += LINE_HEIGHT as i32;
            }
            top += head(i);
            let size = (sheet.px(sheet.width - MARGIN), sheet.px(height_of(i)));
            let area = root.clone().shrink((0, sheet.px(top)), size);
            draw_panel(&root, &area, panel, PanelDrawing { sheet, is_bare: shares(i), curves: &mut curves })?;
            top += height_of(i) + gap;
        }
        root.present()?;
    }
    Ok(finished(text, &curves, sheet))
}

/// The drawing with its curves, which the drawing library has no dashes for, and its size on paper.
fn finished(text: String, curves: &str, sheet: Sheet) -> String {
    let mut text = text.replacen("</svg>", &format!("{curves}</svg>"), 1);
    if let Some(width) = sheet.millimetres
        && let Some((head, rest)) = text.split_once("viewBox")
    {
        let number = |name: &str| head.split_once(name)?.1.split('"').nth(1)?.parse::<f64>().ok();
        let height = number("height").zip(number("width")).map_or(0.0, |(high, wide)| width * high / wide);
        text = format!("<svg width=\"{width}mm\" height=\"{height:.2}mm\" viewBox{rest}");
    }
    text
}

/// What a panel is drawn with: its sheet, whether its horizontal axis has no labels, and where its curves go.
struct PanelDrawing<'a> {
    sheet: Sheet,
    is_bare: bool,
    curves: &'a mut String,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn words(
    text: &str,
    at: (i32, i32),
    anchor: HPos,
    style: TextStyle<'static>,
) -> Text<'static, (i32, i32), String> {
    Text::new(text.to_owned(), at, style.pos(Pos::new(anchor, VPos::Center)))
}

/// A broken line with `points` in places of a coordinate; `name` is shown by who points at it.
fn stroke(points: &[(i32, i32)], colour: RGBColor, pen: Pen, name: &str, sheet: Sheet) -> String {
    let points: Vec<String> = points.iter().map(|(x, y)| format!("{x},{y}")).collect();
    let scale = f64::from(sheet.scale);
    let dashes: Vec<String> = pen.dashes.iter().map(|length| (scale * length).to_string()).collect();
    let dashes = match dashes.is_empty() {
        true => String::new(),
        false => format!(" stroke-dasharray=\"{}\"", dashes.join(" ")),
    };
    let name = if name.is_empty() { String::new() } else { format!("<title>{}</title>", escape(name)) };
    format!(
        "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{dashes} \
         points=\"{}\">{name}</polyline>\n",
        hex(colour),
        scale * pen.width,
        points.join(" ")
    )
}

fn width_of(text: &str) -> i32 {
    (CHARACTER * f64::from(TEXT_SIZE) * text.chars().count() as f64).ceil() as i32
}

/// Width of a key with its swatch and the space after it [px].
fn key_width(key: &Key) -> i32 {
    34 + width_of(&key.words) + 18
}

/// Keys in lines that fit a figure of that `width` [px].
fn legend_lines(keys: &[Key], width: u32) -> Vec<Vec<&Key>> {
    let mut lines: Vec<Vec<&Key>> = Vec::new();
    let mut used = i32::MAX;
    for key in keys {
        let wide = key_width(key);
        if used.saturating_add(wide) > (width - 2 * MARGIN) as i32 {
            lines.push(Vec::new());
            used = 0;
        }
        used += wide;
        if let Some(line) = lines.last_mut() {
            line.push(key);
        }
    }
    lines
}

fn draw_keys(root: &Area, keys: &[&Key], y: i32, sheet: Sheet, curves: &mut String) -> Result<(), PlotError> {
    let mut x = MARGIN as i32;
    let place = |x: i32, y: i32| (sheet.at(x), sheet.at(y));
    for key in keys {
        let bold = key.colour.stroke_width(sheet.px(3));
        match key.swatch {
            Swatch::Field => {
                root.draw(&Rectangle::new([place(x, y - 5), place(x + 26, y + 5)], key.colour.filled()))?
            }
            Swatch::Line => root.draw(&PathElement::new([place(x, y), place(x + 26, y)], bold))?,
            Swatch::Dashed => {
                for start in [x, x + 10, x + 20] {
                    root.draw(&PathElement::new([place(start, y), place(start + 6, y)], bold))?;
                }
            }
            Swatch::Pen(pen) => {
                let ends = [place(x, y), place(x + 28, y)];
                curves.push_str(&stroke(&ends, key.colour, pen, "", sheet));
            }
        }
        root.draw(&words(&key.words, place(x + 34, y), HPos::Left, sheet.style(TEXT_SIZE, INK)))?;
        x += key_width(key);
    }
    Ok(())
}

fn draw_panel<'a>(
    root: &Area<'a>,
    area: &Area<'a>,
    panel: &Panel,
    drawn: PanelDrawing<'_>,
) -> Result<(), PlotError> {
    let sheet = drawn.sheet;
    let longest = panel.rows.iter().map(|row| width_of(&cut(row))).max();
    let longest_note = panel.notes.iter().map(|note| width_of(note)).max();
    let below = if drawn.is_bare { BARE_HEIGHT } else { AXIS_HEIGHT };
    let mut builder = ChartBuilder::on(area);
    builder
        .margin_left(sheet.px(MARGIN))
        .margin_top(sheet.px(4))
        .margin_right(sheet.at(longest_note.map_or(0, |width| width + 12)))
        .x_label_area_size(sheet.px(below))
        .y_label_area_size(sheet.at(longest.map_or(66, |width| width + 10)));
    let [x0, x1] = panel.x.range;
    let [y0, y1] = panel.y.range;
    match (panel.x.log, panel.y.log) {
        (false, false) => draw_chart(root, builder.build_cartesian_2d(x0..x1, y0..y1)?, panel, drawn),
        (true, false) => {
            draw_chart(root, builder.build_cartesian_2d((x0..x1).log_scale(), y0..y1)?, panel, drawn)
        }
        (false, true) => {
            draw_chart(root, builder.build_cartesian_2d(x0..x1, (y0..y1).log_scale())?, panel, drawn)
        }
        (true, true) => {
            let (x, y) = ((x0..x1).log_scale(), (y0..y1).log_scale());
            draw_chart(root, builder.build_cartesian_2d(x, y)?, panel, drawn)
        }
    }
}

fn draw_chart<'a, 'b, X, Y>(
    root: &Area<'b>,
    mut chart: ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>,
    panel: &Panel,
    drawn: PanelDrawing<'_>,
) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let sheet = drawn.sheet;
    let x_ticks = |value: &f64| if drawn.is_bare { String::new() } else { tick(*value, &panel.x) };
    let y_ticks = |value: &f64| tick(*value, &panel.y);
    let mut mesh = chart.configure_mesh();
    mesh.bold_line_style(GRID.stroke_width(sheet.px(1)))
        .light_line_style(GRID.mix(0.0))
        .max_light_lines(0)
        .axis_style(INK.stroke_width(sheet.px(1)))
        .label_style(sheet.style(TEXT_SIZE, INK))
        .axis_desc_style(sheet.style(TEXT_SIZE, INK))
        .set_all_tick_mark_size(sheet.px(5))
        .x_labels(if sheet.width < 600 { 6 } else { 10 })
        .y_labels(if panel.height > 180 { 7 } else { 4 })
        .x_label_formatter(&x_ticks)
        .y_label_formatter(&y_ticks)
        .x_desc(if drawn.is_bare { String::new() } else { panel.x.label.clone() });
    if panel.rows.is_empty() {
        mesh.y_desc(panel.y.label.clone());
    } else {
        mesh.disable_y_mesh().disable_y_axis();
    }
    mesh.draw()?;
    let beside = |text: &str, (x, y): (i32, i32), by: i32, anchor: HPos| {
        words(text, (x + sheet.at(by), y), anchor, sheet.style(TEXT_SIZE, INK))
    };
    for (row, name) in panel.rows.iter().enumerate() {
        let at = chart.backend_coord(&(panel.x.range[0], row as f64));
        root.draw(&beside(&cut(name), at, -8, HPos::Right))?;
    }
    for (row, note) in panel.notes.iter().enumerate() {
        let at = chart.backend_coord(&(panel.x.range[1], row as f64));
        root.draw(&beside(note, at, 10, HPos::Left))?;
    }
    for mark in &panel.marks {
        draw_mark(&mut chart, mark, panel, sheet, drawn.curves)?;
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
    panel: &Panel,
    sheet: Sheet,
    curves: &mut String,
) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let (x, y) = (&panel.x, &panel.y);
    // Rows count downward: their axis runs from high to low and nothing lies outside of it.
    let in_y = |value: f64| if y.range[0] < y.range[1] { y.clamp(value) } else { value };
    let inside = |&(a, b): &(f64, f64)| (x.clamp(a), in_y(b));
    match mark {
        Mark::Line { points, colour, width, dashed } => {
            let points: Vec<(f64, f64)> = points.iter().map(inside).collect();
            let style = colour.stroke_width(sheet.px(*width));
            if *dashed {
                chart.draw_series([DashedPathElement::new(points, sheet.px(6), sheet.px(4), style)])?;
            } else {
                chart.draw_series([PathElement::new(points, style)])?;
            }
        }
        Mark::Curve { name, points, colour, pen } => {
            let points: Vec<(i32, i32)> =
                points.iter().map(|point| chart.backend_coord(&inside(point))).collect();
            curves.push_str(&stroke(&points, *colour, *pen, name, sheet));
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
                chart.draw_series([Rectangle::new(corners, colour.stroke_width(sheet.px(1)))])?;
            }
        }
        Mark::Dot { at, colour, shape } => draw_dot(chart, inside(at), *colour, *shape, sheet)?,
        Mark::Words { at, text, colour, ends } => {
            let anchor = Pos::new(if *ends { HPos::Right } else { HPos::Left }, VPos::Center);
            let style = sheet.style(TEXT_SIZE - 1, *colour).pos(anchor);
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
    sheet: Sheet,
) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let px = sheet.scale as i32;
    match shape {
        Dot::Ring => {
            let style = ShapeStyle::from(colour).stroke_width(sheet.px(1));
            chart.draw_series([Circle::new(at, 3 * px, style)])?
        }
        Dot::Full => chart.draw_series([Circle::new(at, 4 * px, ShapeStyle::from(colour).filled())])?,
        Dot::Diamond => {
            let diamond = |size: i32| vec![(-size, 0), (0, -size), (size, 0), (0, size)];
            let element =
                |size: i32, colour: RGBColor| EmptyElement::at(at) + Polygon::new(diamond(size), colour);
            chart.draw_series([element(5 * px, PAPER)])?;
            chart.draw_series([element(4 * px, colour)])?
        }
        Dot::Square | Dot::OpenSquare => {
            let square = |size: i32, colour: RGBColor| {
                EmptyElement::at(at)
                    + Polygon::new(vec![(-size, -size), (size, -size), (size, size), (-size, size)], colour)
            };
            chart.draw_series([square(7 * px, PAPER)])?;
            chart.draw_series([square(6 * px, colour)])?;
            let inside = if shape == Dot::Square { colour } else { PAPER };
            chart.draw_series([square(4 * px, inside)])?
        }
    };
    Ok(())
}

/// A number at an axis, with no more digits than its range needs.
fn tick(value: f64, axis: &Axis) -> String {
    let size = value.abs();
    let span = if axis.log { size } else { (axis.range[1] - axis.range[0]).abs() };
    // Zero, or what is left of a zero that rounding missed.
    if size <= 1e-9 * span && !axis.log || size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&span) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let decimals = (1.0 - span.log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
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
        assert_eq!(tick(-1e-17, &linear(0.4)), "0");
        assert_eq!(tick(-6.8e-21, &linear(2e-4)), "0");
        let log = Axis::log("", [1e-4, 1e4], 6);
        assert_eq!(["0.01", "1", "1000"], [1e-2, 1.0, 1e3].map(|v| tick(v, &log)));
    }

    #[test]
    fn a_long_legend_goes_on_in_a_second_line() {
        let key = |words: &str| Key { words: words.to_owned(), colour: INK, swatch: Swatch::Line };
        let keys: Vec<Key> = (0..12).map(|i| key(&format!("effects.closing.layout=number{i}"))).collect();
        let lines = legend_lines(&keys, WIDTH);
        assert!(lines.len() > 1 && lines.iter().map(Vec::len).sum::<usize>() == 12);
        for line in lines {
            assert!(line.iter().map(|key| key_width(key)).sum::<i32>() <= (WIDTH - 2 * MARGIN) as i32);
        }
    }
}
