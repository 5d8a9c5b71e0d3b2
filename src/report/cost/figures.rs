//! The figures of a study of cost: what each shows.

use plotters::style::RGBColor;

use super::others;
use crate::report::page::Figure;
use crate::report::plots::{Axis, Dot, INK, Key, MUTED, Mark, Panel, Swatch, colour, dashed};
use crate::report::survival;
use crate::study::cost::advice::{length, seconds};
use crate::study::cost::dials::{AS_WRITTEN, FAMILIES};
use crate::study::cost::map::{Map, UNSTABLE};
use crate::study::cost::verdicts::{Agreement, Verdicts};
use crate::study::cost::{MeasuredSetting, Study};

/// Families of the diagram that are one point or a bundle, not a line.
const NO_LINE: [&str; 3] = ["as written", "other cables", "contact"];

/// Gain of energy that a stable method may show [-].
const QUIET: f64 = 1e-3;

/// All figures; one that does not apply has no panels.
pub fn all(study: &Study) -> Vec<Figure> {
    let after = [verdicts(study), survival::figure(&curves(study))];
    [work_precision(study), trust(study), convergence(study)]
        .into_iter()
        .chain(after)
        .chain([stability(study)])
        .collect()
}

/// Curves of survival: the finest's, then each that is told apart from it; of those that are not, the scene's as written.
fn curves(study: &Study) -> Vec<survival::Named<'_>> {
    let is_shown =
        |one: &&Verdicts| one.label == AS_WRITTEN || one.holding.is_none_or(|test| test.told_apart());
    let shown = study.verdicts.iter().filter(is_shown);
    let curves = shown.filter_map(|one| Some((one.label.clone(), one.survival.as_ref()?)));
    curves.enumerate().map(|(series, (name, survival))| survival::Named { name, series, survival }).collect()
}

fn line(points: Vec<(f64, f64)>, colour: RGBColor, width: u32, dashed: bool) -> Mark {
    Mark::Line { points, colour, width, dashed }
}

fn key(words: &str, colour: RGBColor, swatch: Swatch) -> Key {
    Key { words: words.to_owned(), colour, swatch }
}

/// Number of a family's colour.
fn series(family: &str) -> usize {
    FAMILIES.iter().position(|known| *known == family).unwrap_or(FAMILIES.len())
}

/// The settings of a family that have a point in a window, by their position on the dial.
fn points<'a>(study: &'a Study, family: &str, window: usize) -> Vec<(&'a MeasuredSetting, (f64, f64))> {
    let of = study.settings.iter().filter(|one| one.family == family);
    let mut points: Vec<_> = of.filter_map(|one| Some((one, one.point(window)?))).collect();
    points.sort_by(|a, b| a.0.value.unwrap_or(0.0).total_cmp(&b.0.value.unwrap_or(0.0)));
    points
}

/// Log error against log time, window by window: one line a family, the front marked and labelled.
fn work_precision(study: &Study) -> Figure {
    let panels: Vec<Panel> = (0..study.windows().len()).map(|window| work_panel(study, window)).collect();
    let spared =
        if others::of(study).is_empty() { String::new() } else { format!(" Diamonds: {}.", others::SOURCE) };
    Figure {
        name: "work-precision".into(),
        title: "What accuracy costs".into(),
        words: format!(
            "Each point is one setting: to the left it is cheaper, further down more accurate. The black line is the \
             front: nothing else is as cheap and as accurate. Rings mark settings that break a law of conservation or \
             let knots sink in.{spared}"
        ),
        panels,
    }
}

fn work_panel(study: &Study, window: usize) -> Panel {
    let floor = study.windows()[window].floor_m;
    let (mut marks, mut keys) = (Vec::new(), vec![key("the front", INK, Swatch::Line)]);
    let (mut costs, mut errors) = (Vec::new(), vec![floor]);
    let mut front: Vec<((f64, f64), &str)> = Vec::new();
    for family in FAMILIES {
        let points = points(study, family, window);
        if points.is_empty() {
            continue;
        }
        let (colour, dashed) = (colour(series(family)), dashed(series(family)));
        keys.push(key(family, colour, if dashed { Swatch::Dashed } else { Swatch::Line }));
        if !NO_LINE.contains(&family) {
            marks.push(line(points.iter().map(|(_, point)| *point).collect(), colour, 2, dashed));
        }
        for (one, at) in points {
            costs.push(at.0);
            errors.push(at.1);
            let shape = if one.warnings.is_empty() { Dot::Full } else { Dot::Ring };
            marks.push(Mark::Dot { at, colour, shape });
            if one.fronts.contains(&window) {
                front.push((at, &one.label));
            }
        }
    }
    let others = if window + 1 == study.windows().len() { others::of(study) } else { &[] };
    costs.extend(others.iter().map(|other| other.cost));
    errors.extend(others.iter().map(|other| other.error_m));
    front.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
    let mut x = Axis::log("processor time per simulated second [s/s]", costs, 9);
    // Room for labels at the right, and left of the least cost.
    x.range = [0.7 * x.range[0], 3.0 * x.range[1]];
    let mut y = Axis::log("largest error of a bullet [m]", errors, 12);
    y.range[0] *= 0.4;
    marks.insert(0, line(front.iter().map(|(at, _)| *at).collect(), INK, 5, false));
    marks.push(line(vec![(x.range[0], floor), (x.range[1], floor)], MUTED, 1, true));
    marks.push(words((x.range[1], 0.75 * floor), "chaos: no error below means anything", MUTED, true));
    for (number, other) in others.iter().enumerate() {
        let at = (other.cost, other.error_m);
        marks.push(Mark::Dot { at, colour: MUTED, shape: Dot::Diamond });
        marks.push(words((1.06 * at.0, beside(number) * at.1), other.name, MUTED, false));
    }
    for (number, (at, label)) in front.iter().enumerate() {
        marks.push(words((1.06 * at.0, beside(number) * at.1), label, INK, false));
    }
    let mut panel = Panel::of_curves(x, y, 520, marks);
    let window = &study.windows()[window];
    panel.title = format!("Errors up to {} s: {}", short(window.end_s), window.name);
    panel.keys = keys;
    panel
}

fn words(at: (f64, f64), text: &str, colour: RGBColor, ends: bool) -> Mark {
    Mark::Words { at, text: text.to_owned(), colour, ends }
}

/// Labels stand above and below their points in turn, so that neighbours stay apart.
fn beside(number: usize) -> f64 {
    if number.is_multiple_of(2) { 1.3 } else { 0.77 }
}

/// Errors over time, with the floor under them.
fn trust(study: &Study) -> Figure {
    let Some(quality) = &study.reference else {
        return Figure { name: "trust".into(), title: "".into(), words: String::new(), panels: Vec::new() };
    };
    let curve = |values: &[f64]| -> Vec<(f64, f64)> {
        let pairs = quality.time_s.iter().copied().zip(values.iter().copied());
        pairs.filter(|(_, value)| *value > 0.0).collect()
    };
    let mut marks = Vec::new();
    let mut keys = vec![
        key("chaos: runs 1 nm apart", MUTED, Swatch::Dashed),
        key("the two references", INK, Swatch::Line),
    ];
    let mut all: Vec<f64> = quality.means_apart_m.iter().chain(&quality.floor_m).copied().collect();
    let front: Vec<&MeasuredSetting> = study.settings.iter().filter(|one| !one.fronts.is_empty()).collect();
    for (number, one) in front.iter().enumerate() {
        let Some(worth) = &one.worth else { continue };
        marks.push(line(curve(&worth.curve_m), colour(number), 2, dashed(number)));
        let swatch = if dashed(number) { Swatch::Dashed } else { Swatch::Line };
        keys.push(key(&one.label, colour(number), swatch));
        all.extend(&worth.curve_m);
    }
    marks.push(line(curve(&quality.floor_m), MUTED, 2, true));
    marks.push(line(curve(&quality.means_apart_m), INK, 2, false));
    let y = Axis::log("largest distance of a bullet from the reference [m]", all, 12);
    let ends = quality.windows.iter().map(|window| (window.end_s, window.name.as_str()));
    for (number, (time, label)) in ends.chain([(quality.horizon_s, "the references part")]).enumerate() {
        marks.push(line(vec![(time, y.range[0]), (time, y.range[1])], MUTED, 1, false));
        let at = (time, y.range[1] * 0.55_f64.powi(number as i32 + 1));
        marks.push(words(at, &format!("{label} "), MUTED, true));
    }
    let end = quality.time_s.last().copied().unwrap_or(1.0);
    let mut panel = Panel::of_curves(Axis::fixed("time [s]", 0.0, end), y, 400, marks);
    panel.keys = keys;
    Figure {
        name: "trust".into(),
        title: "Until when a run can be trusted".into(),
        words: format!(
            "Two integrators that share no code, {} and {} runs of each ({}; {}), agree on the bullets within {} until {} s; \
             single runs that start a nanometre apart do so until {} s, and after that no setting, however fine, is \
             nearer to the truth than they are to each other.",
            quality.runs[0],
            quality.runs[1],
            quality.methods[0],
            quality.methods[1],
            length(quality.trust_distance_m),
            short(quality.horizon_s),
            short(quality.single_run_horizon_s)
        ),
        panels: vec![panel],
    }
}

/// Error over step, with the observed orders.
fn convergence(study: &Study) -> Figure {
    let (mut marks, mut keys, mut steps, mut errors) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut said = Vec::new();
    for order in &study.orders {
        let mut of: Vec<(f64, f64)> = points(study, &order.family, 0)
            .into_iter()
            .filter_map(|(one, (_, error))| Some((one.step_s?, error)))
            .collect();
        of.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (colour, dashed) = (colour(series(&order.family)), dashed(series(&order.family)));
        steps.extend(of.iter().map(|point| point.0));
        errors.extend(of.iter().map(|point| point.1));
        marks.extend(of.iter().map(|at| Mark::Dot { at: *at, colour, shape: Dot::Full }));
        marks.push(line(of, colour, 2, dashed));
        let words = format!("{}: order {:.1}", order.family, order.order);
        keys.push(key(&words, colour, if dashed { Swatch::Dashed } else { Swatch::Line }));
        said.push(words);
    }
    let panels = if marks.is_empty() {
        Vec::new()
    } else {
        let x = Axis::log("step [s]", steps, 9);
        let mut panel =
            Panel::of_curves(x, Axis::log("largest error of a bullet [m]", errors, 12), 340, marks);
        panel.keys = keys;
        vec![panel]
    };
    Figure {
        name: "convergence".into(),
        title: "How fast errors fall with the step".into(),
        words: format!(
            "Observed orders of convergence before first contact, by least squares over the points above the floor: {}. \
             The tension of a cable that goes taut jumps, so no method with fixed steps is above first order.",
            said.join("; ")
        ),
        panels,
    }
}

/// Shares captured and quality indices, with their intervals.
fn verdicts(study: &Study) -> Figure {
    let names: Vec<String> = study.verdicts.iter().map(|verdicts| verdicts.label.clone()).collect();
    let hue = |agreement: Agreement| match agreement {
        Agreement::Finest => INK,
        Agreement::Agrees => colour(0),
        Agreement::Differs => colour(1),
        Agreement::TooFew => MUTED,
    };
    let stroke = |points, colour, width| line(points, colour, width, false);
    let (mut shares, mut indices) = (Vec::new(), Vec::new());
    let mut widest = 0.0_f64;
    for (row, verdicts) in study.verdicts.iter().enumerate() {
        let (y, hue) = (row as f64, hue(verdicts.agreement));
        let [low, high] = verdicts.captured.interval_95.map(|bound| 100.0 * bound);
        shares.push(stroke(vec![(low, y), (high, y)], hue, 2));
        shares.push(Mark::Dot { at: (100.0 * verdicts.captured.share, y), colour: hue, shape: Dot::Full });
        let [lower, median, upper] = verdicts.cqi;
        let ends = [lower.interval_95[0].unwrap_or(lower.value), upper.interval_95[1].unwrap_or(upper.value)];
        widest = widest.max(ends[1]);
        indices.push(stroke(vec![(ends[0], y), (ends[1], y)], hue, 1));
        indices.push(Mark::Bar {
            from: (lower.value, y - 0.25),
            to: (upper.value, y + 0.25),
            colour: hue,
            opacity: 0.3,
            edge: true,
        });
        indices.push(stroke(vec![(median.value, y - 0.25), (median.value, y + 0.25)], hue, 2));
    }
    let panels = if names.is_empty() {
        Vec::new()
    } else {
        let x = Axis::fixed("members captured [%]", 0.0, 100.0);
        let mut first = Panel::of_rows("Captured", names.clone(), x, 26, shares);
        first.notes = study
            .verdicts
            .iter()
            .map(|v| format!("{} of {}, {} per s", v.captured.captured, v.captured.of, seconds(v.cost)))
            .collect();
        first.keys = vec![
            key("the finest", INK, Swatch::Line),
            key("agrees with it", colour(0), Swatch::Line),
            key("another distribution", colour(1), Swatch::Line),
            key("too few members to tell", MUTED, Swatch::Line),
        ];
        let x = Axis::fixed("capture quality index (0 is ideal)", 0.0, 1.05 * widest.max(f64::MIN_POSITIVE));
        vec![first, Panel::of_rows("Quality", names, x, 26, indices)]
    };
    Figure {
        name: "verdicts".into(),
        title: "After contact: distributions".into(),
        words: "Paths are chaotic after contact, so settings are compared by ensembles with the same perturbations: share \
                captured with its exact 95 % interval, and quartiles of the quality index (thin lines: 95 % interval of \
                the outer ones, where the members suffice). A setting agrees with the finest while its intervals \
                overlap."
            .to_owned(),
        panels,
    }
}

/// Step against stiffness: where a method gains energy.
fn stability(study: &Study) -> Figure {
    let panels: Vec<Panel> =
        study.maps.iter().filter(|map| !map.cells.is_empty()).map(stability_panel).collect();
    Figure {
        name: "stability".into(),
        title: "Where a method is stable".into(),
        words: "Each field is one run of the free net up to its full opening, with all cables made softer or stiffer: \
                green gains no energy, yellow a little, red is unstable. The explicit net has an analytic limit, \
                h \u{3c9} < 2 (\u{221a}(1 + \u{3b6}\u{b2}) \u{2212} \u{3b6}) (black line), for the worst shape of the net: \
                above it a run may survive while not all cables are taut. The engine's joints have no limit, but long \
                steps gain energy."
            .to_owned(),
        panels,
    }
}

fn stability_panel(map: &Map) -> Panel {
    let mut steps: Vec<f64> = map.cells.iter().map(|cell| cell.step_s).collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    let mut factors: Vec<f64> = map.cells.iter().map(|cell| cell.stiffness).collect();
    factors.sort_by(f64::total_cmp);
    factors.dedup();
    let hue = |gain: Option<f64>| match gain {
        Some(gain) if gain <= QUIET => colour(2),
        Some(gain) if gain <= UNSTABLE => colour(4),
        _ => colour(1),
    };
    let mut marks: Vec<Mark> = map
        .cells
        .iter()
        .map(|cell| {
            let [x, y] = [edges(&steps, cell.step_s), edges(&factors, cell.stiffness)];
            Mark::Bar {
                from: (x[0], y[0]),
                to: (x[1], y[1]),
                colour: hue(cell.gain),
                opacity: 0.75,
                edge: false,
            }
        })
        .collect();
    if !map.limit.is_empty() {
        let limit = map.limit.iter().map(|(factor, step)| (*step, *factor)).collect();
        marks.push(line(limit, INK, 3, false));
    }
    let ends = |values: &[f64]| {
        let [first, last] = [values[0], values[values.len() - 1]];
        [edges(values, first)[0], edges(values, last)[1]]
    };
    let axis = |label: &str, range: [f64; 2]| Axis { label: label.to_owned(), range, log: true };
    let x = axis("step [s]", ends(&steps));
    let mut panel = Panel::of_curves(x, axis("stiffness over that as written", ends(&factors)), 300, marks);
    panel.title = map.method.clone();
    panel.keys = vec![
        key("gains at most 0.1 % of the launch energy", colour(2), Swatch::Field),
        key("up to 10 %", colour(4), Swatch::Field),
        key("more, or no number", colour(1), Swatch::Field),
    ];
    if !map.limit.is_empty() {
        panel.keys.push(key("analytic limit", INK, Swatch::Line));
    }
    panel
}

/// Where the field of `value` begins and ends among its sorted neighbours: half way, in ratios.
fn edges(sorted: &[f64], value: f64) -> [f64; 2] {
    let place = sorted.partition_point(|known| *known < value);
    let half = |a: f64, b: f64| (a / b).sqrt();
    let below = place.checked_sub(1).map(|i| half(sorted[i], value));
    let above = sorted.get(place + 1).map(|next| half(*next, value));
    let (below, above) = (below.or(above.map(|a| 1.0 / a)), above.or(below.map(|b| 1.0 / b)));
    [value * below.unwrap_or(0.5), value * above.unwrap_or(2.0)]
}

fn short(value: f64) -> String {
    format!("{value:.2}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_a_map_meet_half_way() {
        let sorted = [1.0, 4.0, 64.0];
        assert_eq!([1.0, 4.0, 64.0].map(|v| edges(&sorted, v)), [[0.5, 2.0], [2.0, 16.0], [16.0, 256.0]]);
        assert_eq!(edges(&[3.0], 3.0), [1.5, 6.0]);
    }
}
