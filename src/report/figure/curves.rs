//! Which curves each figure has, and from where in the results of a run they come.
//!
//! One run has its curves of one quantity in one panel, a curve a part (the axes of a vector, say). Several runs have a panel
//! for each part and a curve a run, so that a line never means two things.

use nalgebra::Vector3;

use super::{FigureKind, ShownRun};
use crate::report::plots::{Axis, INK, Key, MOST_PENS, Mark, Panel, Swatch, colour, pen};
use crate::report::recorded::RecordedRun;

/// Curves of a run that share their axes.
struct CurveGroup {
    /// What they show.
    quantity: &'static str,
    /// Its unit.
    unit: &'static str,
    /// Horizontal axis, with its unit.
    along: &'static str,
    /// Whether equal lengths are equal ratios along it.
    log: bool,
    /// The curves.
    parts: Vec<CurvePart>,
}

/// A curve.
struct CurvePart {
    name: String,
    points: Vec<(f64, f64)>,
}

const TIME: &str = "time [s]";

/// Height of a panel [px].
const HEIGHT: u32 = 200;

/// The same of a part's own.
const PART_HEIGHT: u32 = 150;

/// The panels of the figure `kind` of `runs`.
pub fn panels(kind: FigureKind, runs: &[ShownRun]) -> Vec<Panel> {
    let all: Vec<Vec<CurveGroup>> = runs.iter().map(|shown| groups(kind, &shown.run)).collect();
    let mut panels = match &all[..] {
        [groups] => groups.iter().map(alone).collect(),
        _ => together(&all, runs),
    };
    // Curves over time share the whole time, also those of a shorter run.
    let end = runs.iter().map(|shown| shown.run.end()).fold(f64::MIN_POSITIVE, f64::max);
    for panel in panels.iter_mut().filter(|panel| panel.x.label == TIME) {
        panel.x = Axis::fixed(TIME, 0.0, end);
    }
    panels
}

/// A panel of one run.
fn alone(group: &CurveGroup) -> Panel {
    let curves: Vec<(usize, &str, &CurvePart)> =
        group.parts.iter().enumerate().map(|(n, part)| (n, part.name.as_str(), part)).collect();
    let label = format!("{} [{}]", group.quantity, group.unit);
    let keys = match &curves[..] {
        [_] => Vec::new(),
        curves => curves.iter().map(|(n, name, _)| key(*n, name)).collect(),
    };
    Panel { keys, ..panel(group, &label, &curves, size(&[group]), HEIGHT) }
}

/// Panels of several runs: one for each part that any of them has.
fn together(all: &[Vec<CurveGroup>], runs: &[ShownRun]) -> Vec<Panel> {
    let mut panels: Vec<Panel> = Vec::new();
    let mut last = "";
    for (quantity, name, many) in all_parts(all) {
        let of_run = |n: usize| all[n].iter().find(|group| group.quantity == quantity);
        let groups: Vec<&CurveGroup> = (0..all.len()).filter_map(of_run).collect();
        let Some(group) = groups.first() else { continue };
        let curve = |n: usize| {
            let part = of_run(n)?.parts.iter().find(|part| part.name == name)?;
            Some((n, runs[n].label.as_str(), part))
        };
        let curves: Vec<(usize, &str, &CurvePart)> = (0..all.len()).filter_map(curve).collect();
        let (what, height) = if many { (name.as_str(), PART_HEIGHT) } else { (quantity, HEIGHT) };
        let label = format!("{what} [{}]", group.unit);
        let title = if many && last != quantity { quantity.to_owned() } else { String::new() };
        last = quantity;
        panels.push(Panel { title, ..panel(group, &label, &curves, size(&groups), height) });
    }
    if let Some(first) = panels.first_mut() {
        first.keys = runs.iter().enumerate().map(|(n, shown)| key(n, &shown.label)).collect();
    }
    panels
}

/// The largest value of a quantity, over all its parts.
fn size(groups: &[&CurveGroup]) -> f64 {
    let values =
        groups.iter().flat_map(|group| &group.parts).flat_map(|part| &part.points).map(|point| point.1.abs());
    values.filter(|value| value.is_finite()).fold(0.0, f64::max)
}

/// Quantity, part, and whether the quantity has several, of every part that a run has; in the order of the runs.
fn all_parts(all: &[Vec<CurveGroup>]) -> Vec<(&'static str, String, bool)> {
    let mut quantities: Vec<&'static str> = Vec::new();
    for group in all.iter().flatten() {
        if !quantities.contains(&group.quantity) {
            quantities.push(group.quantity);
        }
    }
    let mut parts = Vec::new();
    for quantity in quantities {
        let mut names: Vec<String> = Vec::new();
        for part in
            all.iter().flatten().filter(|group| group.quantity == quantity).flat_map(|group| &group.parts)
        {
            if !names.contains(&part.name) {
                names.push(part.name.clone());
            }
        }
        let many = names.len() > 1;
        parts.extend(names.into_iter().map(|name| (quantity, name, many)));
    }
    parts
}

fn key(number: usize, words: &str) -> Key {
    Key { words: words.to_owned(), colour: ink(number), swatch: Swatch::Pen(pen(number)) }
}

fn ink(number: usize) -> plotters::style::RGBColor {
    // The last pen has no colour of its own left.
    if number + 1 == MOST_PENS { INK } else { colour(number) }
}

/// A panel of `curves`, of a quantity whose largest value is `size`.
fn panel(
    group: &CurveGroup,
    label: &str,
    curves: &[(usize, &str, &CurvePart)],
    size: f64,
    height: u32,
) -> Panel {
    let of = |axis: fn(&(f64, f64)) -> f64| {
        curves.iter().flat_map(move |(_, _, part)| part.points.iter().map(axis)).collect::<Vec<f64>>()
    };
    let x = match group.log {
        true => Axis::log(group.along, of(|point| point.0), 12),
        false => Axis::linear(group.along, of(|point| point.0)),
    };
    let mut values = of(|point| point.1);
    // What differs by rounding alone, along an axis that nothing moves along say, is drawn as the line that it is.
    if values.iter().all(|value| (value - values[0]).abs() <= 1e-9 * size) {
        values.extend([-size, size]);
    }
    let marks = curves.iter().map(|(n, name, part)| Mark::Curve {
        name: curve_name(name, group.quantity, &part.name),
        points: part.points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite()).collect(),
        colour: ink(*n),
        pen: pen(*n),
    });
    let marks = marks.collect();
    Panel::of_curves(x, Axis::linear(label, values), height, marks)
}

/// `2.0, momentum, x`: what tells the curve from others in its panel comes first, and nothing twice.
fn curve_name(first: &str, quantity: &str, part: &str) -> String {
    let mut words: Vec<&str> = Vec::new();
    for word in [first, quantity, part] {
        if !word.is_empty() && !words.contains(&word) {
            words.push(word);
        }
    }
    words.join(", ")
}

fn groups(kind: FigureKind, run: &RecordedRun) -> Vec<CurveGroup> {
    let groups = match kind {
        FigureKind::Strip => Vec::new(),
        FigureKind::Deployment => deployment(run),
        FigureKind::Momentum => vec![
            of_columns(run, "momentum", "kg m/s", &axes("momentum", "kg_m_s")),
            of_columns(run, "angular momentum", "kg m²/s", &axes("angular_momentum", "kg_m2_s")),
        ],
        FigureKind::Energy => energy(run),
        FigureKind::Motion => motion(run),
        FigureKind::Impulses => impulses(run),
        FigureKind::Closing => closing(run),
        FigureKind::Tension => tension(run),
    };
    groups.into_iter().filter(|group| !group.parts.is_empty()).collect()
}

fn over_time(quantity: &'static str, unit: &'static str, parts: Vec<CurvePart>) -> CurveGroup {
    CurveGroup { quantity, unit, along: TIME, log: false, parts }
}

/// A curve over time with a value a frame.
fn part(run: &RecordedRun, name: &str, values: impl IntoIterator<Item = f64>) -> CurvePart {
    CurvePart { name: name.to_owned(), points: run.paths.time.iter().copied().zip(values).collect() }
}

/// Columns of `series.csv` over time; `columns` has their names there and in the figure. One that is not there is left out.
fn of_columns(
    run: &RecordedRun,
    quantity: &'static str,
    unit: &'static str,
    columns: &[(String, String)],
) -> CurveGroup {
    let parts = columns
        .iter()
        .filter_map(|(column, name)| Some(part(run, name, run.series.column(column)?.iter().copied())));
    over_time(quantity, unit, parts.collect())
}

fn named(columns: &[(&str, &str)]) -> Vec<(String, String)> {
    columns.iter().map(|(column, name)| ((*column).to_owned(), (*name).to_owned())).collect()
}

/// Columns of a vector: `spin_x_rad_s` as `x`.
fn axes(vector: &str, unit: &str) -> Vec<(String, String)> {
    ["x", "y", "z"].map(|axis| (format!("{vector}_{axis}_{unit}"), axis.to_owned())).into()
}

fn deployment(run: &RecordedRun) -> Vec<CurveGroup> {
    let areas = of_columns(run, "area of the bullets", "m²", &named(&[("area_m2", "")]));
    let total: f64 = run.net.masses.iter().sum();
    let centre = |knots: &Vec<Vector3<f64>>| {
        let weighted = run.net.masses.iter().zip(knots).map(|(mass, at)| *mass * at);
        weighted.sum::<Vector3<f64>>() / total
    };
    let centres: Vec<Vector3<f64>> = run.paths.position.iter().map(centre).collect();
    let distance = centres.iter().map(|at| (at - centres[0]).norm());
    let area = run.series.column("area_m2").unwrap_or_default();
    let points = distance.zip(area.iter().copied()).collect();
    let over_way = CurveGroup {
        quantity: "area over distance",
        along: "distance of the net's centre of mass [m]",
        ..over_time("", "m²", vec![CurvePart { name: String::new(), points }])
    };
    vec![areas, over_way]
}

fn energy(run: &RecordedRun) -> Vec<CurveGroup> {
    let held = [
        ("kinetic_net_j", "net, kinetic"),
        ("kinetic_target_j", "target, kinetic"),
        ("elastic_j", "elastic"),
        ("stored_j", "stored"),
    ];
    let mut mechanical = of_columns(run, "energy", "J", &named(&held));
    let sum = |frame: usize| mechanical.parts.iter().map(|part| part.points[frame].1).sum::<f64>();
    let sums: Vec<f64> = (0..run.paths.time.len()).map(sum).collect();
    mechanical.parts.retain(is_not_zero);
    mechanical.parts.push(part(run, "sum", sums));
    let taken = [
        ("taken_by_cables_j", "cables"),
        ("taken_by_solver_j", "solver"),
        ("taken_by_contact_j", "contact"),
        ("drive_j", "drive"),
    ];
    let mut taken = of_columns(run, "energy moved", "J", &named(&taken));
    let works = run.series.columns(|name| name.starts_with("work_of_"));
    taken.parts.extend(works.map(|(name, column)| {
        let effect = name.trim_start_matches("work_of_").trim_end_matches("_j").replace('_', " ");
        part(run, &format!("put in by {effect}"), column.iter().copied())
    }));
    taken.parts.extend(of_columns(run, "", "", &named(&[("residual_j", "residual")])).parts);
    taken.parts.retain(is_not_zero);
    // More lines than pens would look alike; what is left out is in the table.
    taken.parts.truncate(MOST_PENS);
    vec![mechanical, taken]
}

fn is_not_zero(part: &CurvePart) -> bool {
    part.points.iter().any(|(_, value)| *value != 0.0)
}

fn motion(run: &RecordedRun) -> Vec<CurveGroup> {
    vec![
        of_columns(run, "spin, body axes", "rad/s", &axes("spin", "rad_s")),
        attitude(run),
        displacement(run, "displacement", "target"),
        displacement(run, "chaser, displacement", "chaser"),
        of_columns(run, "chaser, spin", "rad/s", &axes("chaser_spin", "rad_s")),
    ]
}

/// How far `body` has come from where it was at the start; no parts of one that the run has not.
fn displacement(run: &RecordedRun, quantity: &'static str, body: &str) -> CurveGroup {
    let moved = axes(body, "m").into_iter().filter_map(|(column, name)| {
        let places = run.series.column(&column)?;
        Some(part(run, &name, places.iter().map(|at| at - places[0])))
    });
    over_time(quantity, "m", moved.collect())
}

/// The quaternion with the sign that makes it go on without a jump.
fn attitude(run: &RecordedRun) -> CurveGroup {
    let mut turns: Vec<[f64; 4]> = Vec::new();
    for attitude in run.target.iter().flat_map(|target| &target.attitude) {
        let q = attitude.quaternion();
        let q = [q.w, q.i, q.j, q.k];
        let jumps =
            turns.last().is_some_and(|last| last.iter().zip(q).map(|(a, b)| a * b).sum::<f64>() < 0.0);
        turns.push(if jumps { q.map(|number| -number) } else { q });
    }
    let parts = ["w", "x", "y", "z"].iter().enumerate();
    let parts = parts.map(|(n, name)| part(run, name, turns.iter().map(move |q| q[n])));
    over_time("attitude, quaternion", "-", parts.collect())
}

/// Steps of the histogram of impulses in a factor of ten.
const STEPS: f64 = 5.0;

fn impulses(run: &RecordedRun) -> Vec<CurveGroup> {
    let most = of_columns(run, "largest impulse", "N s", &named(&[("max_impulse_n_s", "")]));
    let impulses = run.contact_impulses.as_slice().unwrap_or_default().chunks(3);
    let sizes = impulses.map(|vector| vector.iter().map(|part| part * part).sum::<f64>().sqrt());
    let steps: Vec<i32> =
        sizes.filter(|size| *size > 0.0).map(|size| (STEPS * size.log10()).floor() as i32).collect();
    let mut histogram = Vec::new();
    if let (Some(&first), Some(&last)) = (steps.iter().min(), steps.iter().max()) {
        let edge = |step: i32| 10_f64.powf(f64::from(step) / STEPS);
        histogram.push((edge(first), 0.0));
        for step in first..=last {
            let count = steps.iter().filter(|other| **other == step).count() as f64;
            histogram.extend([(edge(step), count), (edge(step + 1), count)]);
        }
        histogram.push((edge(last + 1), 0.0));
    }
    let parts = if histogram.is_empty() {
        Vec::new()
    } else {
        vec![CurvePart { name: String::new(), points: histogram }]
    };
    let sizes = CurveGroup {
        quantity: "knots and frames",
        unit: "-",
        along: "impulse on a knot in a frame [N s]",
        log: true,
        parts,
    };
    vec![most, sizes]
}

fn closing(run: &RecordedRun) -> Vec<CurveGroup> {
    let shares = [("enclosed", "enclosed"), ("mouth", "mouth"), ("mouth_hull", "mouth hull")];
    let threads = |what: &'static str| {
        run.series
            .columns(move |name| name.starts_with("thread_") && name.ends_with(what))
            .collect::<Vec<_>>()
    };
    let add_up = |what: &'static str, start: f64, add: fn(f64, f64) -> f64| {
        let columns = threads(what);
        let at = |frame: usize| columns.iter().map(|(_, column)| column[frame]).fold(start, add);
        (!columns.is_empty()).then(|| (0..run.paths.time.len()).map(at).collect::<Vec<f64>>())
    };
    let sum = |one: f64, other: f64| one + other;
    let lengths = [("in the net", "length_m"), ("off the reels", "off_reels_m")];
    let lengths = lengths.iter().filter_map(|(name, what)| Some(part(run, name, add_up(what, 0.0, sum)?)));
    let tension = add_up("tension_n", 0.0, f64::max).map(|values| part(run, "", values));
    let work = run.series.columns(|name| name.ends_with("_work_j"));
    let work = work.map(|(_, column)| part(run, "", column.iter().copied()));
    vec![
        of_columns(run, "share", "-", &named(&shares)),
        over_time("thread", "m", lengths.collect()),
        over_time("thread tension", "N", tension.into_iter().collect()),
        over_time("winch work", "J", work.collect()),
    ]
}

fn tension(run: &RecordedRun) -> Vec<CurveGroup> {
    let largest = of_columns(run, "largest tension", "N", &named(&[("max_tension_n", "")]));
    let share = |tensions: ndarray::ArrayView1<f64>| {
        let shares =
            tensions.iter().zip(&run.net.breaking_tensions).map(|(tension, most)| 100.0 * tension / most);
        shares.filter(|share| share.is_finite()).fold(0.0, f64::max)
    };
    let shares = part(run, "", run.tensions.outer_iter().map(share));
    vec![largest, over_time("share of breaking", "%", vec![shares])]
}
