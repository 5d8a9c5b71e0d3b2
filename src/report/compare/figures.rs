//! The figures of a comparison: what each shows.

use plotters::style::RGBColor;

use super::plain;
use crate::report::page::Figure;
use crate::report::plots::boxes::{box_plot, whisker};
use crate::report::plots::{Axis, Dot, INK, Key, MUTED, Mark, Panel, Swatch, colour, dashed, kind_colour};
use crate::report::survival::Named;
use crate::report::table::verdict_words;
use crate::study::compare::difference::{Differences, Horizon, Separation};
use crate::study::compare::track::{Band, Bands, ROWS, ROWS_HELD, ROWS_TAKEN};
use crate::study::compare::{Compared, Comparison, Outcome};

/// All figures; one that does not apply has no panels.
pub fn all(comparison: &Comparison) -> Vec<Figure> {
    vec![
        verdicts(comparison),
        survival(comparison),
        bullet_differences(comparison),
        difference_over_time(comparison),
        capture(comparison),
        closing(comparison),
        contact_response(comparison),
        energy(comparison),
        momentum(comparison),
        wall_time(comparison),
    ]
}

fn line(x: &[f64], y: &[f64], colour: RGBColor, dashed: bool) -> Mark {
    Mark::Line { points: x.iter().copied().zip(y.iter().copied()).collect(), colour, width: 2, dashed }
}

fn band(x: &[f64], lower: &[f64], upper: &[f64], colour: RGBColor, opacity: f64) -> Mark {
    Mark::Band { x: x.to_vec(), lower: lower.to_vec(), upper: upper.to_vec(), colour, opacity }
}

fn millimetres(metres: &[f64]) -> Vec<f64> {
    metres.iter().map(|metres| 1e3 * metres).collect()
}

fn swatch(series: usize) -> Swatch {
    if dashed(series) { Swatch::Dashed } else { Swatch::Line }
}

/// A legend of all variants that ran.
fn keys(comparison: &Comparison) -> Vec<Key> {
    let key = |(v, variant, _): (usize, &Compared, _)| Key {
        words: variant.label.clone(),
        colour: colour(v),
        swatch: swatch(v),
    };
    comparison.ran().map(key).collect()
}

/// A separation that is shown.
struct SeparationRow<'a> {
    name: String,
    colour: RGBColor,
    dashed: bool,
    separation: &'a Separation,
}

/// Every separation that is shown: the base's own first, then each variant against the base.
fn separations(comparison: &Comparison) -> Vec<SeparationRow<'_>> {
    let own = comparison.base().and_then(|base| base.own.as_ref());
    let chaos = own.map(|separation| SeparationRow {
        name: format!("chaos of {}", comparison.base),
        colour: MUTED,
        dashed: true,
        separation,
    });
    let against = comparison.ran().filter_map(|(v, variant, outcome)| {
        let separation = &outcome.against_base.as_ref()?.separation;
        Some(SeparationRow { name: variant.label.clone(), colour: colour(v), dashed: dashed(v), separation })
    });
    chaos.into_iter().chain(against).collect()
}

fn bullet_differences(comparison: &Comparison) -> Figure {
    let rows = separations(comparison);
    let panel = |title: &str, of: fn(&Separation) -> &Differences| {
        let boxes: Vec<&Differences> = rows.iter().map(|row| of(row.separation)).collect();
        let numbers =
            boxes.iter().flat_map(|d| &d.bullets_m).flat_map(|b| [b.lower_whisker, b.lower, b.median, b.max]);
        let mut x = Axis::log("difference of a bullet [mm]", numbers.map(|metres| 1e3 * metres), 6);
        // Room at the right for the bullets' numbers.
        x.range[1] *= 1.6;
        let mut marks = Vec::new();
        for (place, (row, differences)) in rows.iter().zip(boxes).enumerate() {
            for (bullet, plot) in differences.bullets_m.iter().enumerate() {
                let y = place as f64 + 0.21 * (bullet as f64 - 1.5);
                marks.extend(box_plot(plot, y, row.colour, |metres| 1e3 * metres));
                let at = (x.range[1], y);
                marks.push(Mark::Words { at, text: (bullet + 1).to_string(), colour: MUTED, ends: true });
            }
        }
        Panel::of_rows(title, rows.iter().map(|row| row.name.clone()).collect(), x, 78, marks)
    };
    let panels = if rows.is_empty() {
        Vec::new()
    } else {
        vec![
            panel("Over the whole run", |separation| &separation.whole),
            panel("Before the trust horizon", |separation| &separation.trusted),
        ]
    };
    Figure {
        name: "bullet-differences".into(),
        title: "How far the bullets are apart".into(),
        words: format!(
            "Distance between the same bullet (1 to 4) in the same member of a variant and of {}, over all recorded \
             times: quartiles, median, whiskers to the furthest value within 1.5 interquartile ranges, diamond for the \
             mean, ring for the largest. Grey: members of {} among themselves, whose folds differ by up to {} m; a \
             variant whose boxes look like the grey ones differs by chaos alone.",
            comparison.base,
            comparison.base,
            plain(comparison.request.ensemble.perturb_m)
        ),
        panels,
    }
}

fn difference_over_time(comparison: &Comparison) -> Figure {
    let rows = separations(comparison);
    let distance = 1e3 * comparison.request.trust_distance_m;
    let ends = rows.iter().filter_map(|row| row.separation.over_time.time_s.last().copied());
    let mut panel = Panel::of_curves(
        Axis::fixed("time [s]", 0.0, ends.fold(f64::MIN_POSITIVE, f64::max)),
        Axis::log(
            "largest bullet difference [mm]",
            rows.iter().flat_map(|row| millimetres(&row.separation.over_time.upper_m)).chain([distance]),
            7,
        ),
        380,
        Vec::new(),
    );
    for SeparationRow { name, colour, dashed, separation } in &rows {
        let curve = &separation.over_time;
        let opacity = if *colour == MUTED { 0.3 } else { 0.15 };
        let [lower, median, upper] =
            [&curve.lower_m, &curve.median_m, &curve.upper_m].map(|c| millimetres(c));
        panel.marks.push(band(&curve.time_s, &lower, &upper, *colour, opacity));
        panel.marks.push(line(&curve.time_s, &median, *colour, *dashed));
        panel.keys.push(Key {
            words: format!("{name}: {}", until(&separation.trust_horizon)),
            colour: *colour,
            swatch: if *dashed { Swatch::Dashed } else { Swatch::Line },
        });
    }
    let level = vec![(panel.x.range[0], distance), (panel.x.range[1], distance)];
    panel.marks.push(Mark::Line { points: level, colour: INK, width: 1, dashed: true });
    panel.marks.push(Mark::Words {
        at: (panel.x.range[0] + 0.01 * panel.x.range[1], distance * 1.6),
        text: format!("trust distance {} mm", plain(distance)),
        colour: INK,
        ends: false,
    });
    for SeparationRow { colour, separation, .. } in
        rows.iter().filter(|row| !row.separation.trust_horizon.to_the_end)
    {
        let at = separation.trust_horizon.time_s;
        let points = vec![(at, panel.y.range[0]), (at, distance)];
        panel.marks.push(Mark::Line { points, colour: *colour, width: 1, dashed: true });
        panel.marks.push(Mark::Dot { at: (at, distance), colour: *colour, shape: Dot::Full });
    }
    Figure {
        name: "difference-over-time".into(),
        title: "Until when they tell the same story".into(),
        words: format!(
            "The largest of the four bullet differences: median over the members, and quartiles as a band. Where the \
             median reaches the trust distance ({} mm), marked by a dot, the trust horizon ends. Grey, dashed: members \
             of {} among themselves. Before first contact a variant shows its own error; after it, two runs of one \
             method part as well, and no variant can agree for longer than the grey band does.",
            plain(distance),
            comparison.base
        ),
        panels: if rows.is_empty() { Vec::new() } else { vec![panel] },
    }
}

fn until(horizon: &Horizon) -> String {
    if horizon.to_the_end {
        "together to the end".to_owned()
    } else {
        format!("until {} s", plain(horizon.time_s))
    }
}

/// A panel of one curve of every variant, with its quartiles.
fn curves(comparison: &Comparison, label: &str, height: u32, of: fn(&Bands) -> &Band) -> Option<Panel> {
    let shown: Vec<(usize, &Outcome)> = comparison
        .ran()
        .filter(|(_, _, outcome)| !of(&outcome.curves).median.is_empty())
        .map(|(v, _, outcome)| (v, outcome))
        .collect();
    let mut marks = Vec::new();
    for (v, outcome) in &shown {
        let (curves, curve) = (&outcome.curves, of(&outcome.curves));
        marks.push(band(&curves.time_s, &curve.lower, &curve.upper, colour(*v), 0.15));
    }
    for (v, outcome) in &shown {
        let (curves, curve) = (&outcome.curves, of(&outcome.curves));
        marks.push(line(&curves.time_s, &curve.median, colour(*v), dashed(*v)));
    }
    let values = shown.iter().flat_map(|(_, outcome)| &of(&outcome.curves).upper).copied();
    let y = Axis::linear(label, values.chain([0.0]));
    (!shown.is_empty()).then(|| Panel::of_curves(time_axis(comparison), y, height, marks))
}

fn time_axis(comparison: &Comparison) -> Axis {
    let ends = comparison.ran().filter_map(|(_, _, outcome)| outcome.curves.time_s.last().copied());
    Axis::fixed("time [s]", 0.0, ends.fold(f64::MIN_POSITIVE, f64::max))
}

fn capture(comparison: &Comparison) -> Figure {
    let mut panels: Vec<Panel> = [
        curves(comparison, "area of the bullets [-]", 220, |curves| &curves.area),
        curves(comparison, "enclosed [-]", 220, |curves| &curves.enclosed),
        curves(comparison, "mouth [-]", 220, |curves| &curves.mouth),
    ]
    .into_iter()
    .flatten()
    .collect();
    if let Some(first) = panels.first_mut() {
        first.keys = keys(comparison);
    }
    Figure {
        name: "capture".into(),
        title: "Opening, enclosing, closing".into(),
        words: "Area of the quadrilateral of the bullets across the travelling direction, enclosed share of the \
                target's volume, and vector area of the mouth; areas over the designed area of the net. Medians over \
                the members, quartiles as bands."
            .to_owned(),
        panels,
    }
}

fn closing(comparison: &Comparison) -> Figure {
    let threads = [
        curves(comparison, "thread off the reels [m]", 200, |curves| &curves.off_reels_m),
        curves(comparison, "largest tension [N]", 200, |curves| &curves.thread_tension_n),
        curves(comparison, "winch work [J]", 200, |curves| &curves.winch_work_j),
    ];
    let mut panels: Vec<Panel> = threads.into_iter().flatten().collect();
    if !panels.is_empty() {
        panels.splice(0..0, curves(comparison, "mouth [-]", 220, |curves| &curves.mouth));
        panels[0].keys = keys(comparison);
    }
    Figure {
        name: "closing".into(),
        title: "How the mouth is closed".into(),
        words: "Vector area of the mouth over the designed area of the net; closing thread off the reels, all threads \
                together; largest tension of any thread since the frame before; work of the winches. Medians over the \
                members, quartiles as bands."
            .to_owned(),
        panels,
    }
}

fn contact_response(comparison: &Comparison) -> Figure {
    let shown: Vec<_> = comparison
        .ran()
        .filter(|(_, _, outcome)| outcome.median("contact.max_impulse_n_s").is_some())
        .collect();
    let largest = shown.iter().flat_map(|(_, _, outcome)| &outcome.curves.impulse_n_s.max);
    let most = largest.fold(0.0, |most: f64, &value| most.max(value));
    let mut panels = Vec::new();
    for (v, variant, outcome) in &shown {
        let milli = |curve: &[f64]| -> Vec<f64> { curve.iter().map(|value| 1e3 * value).collect() };
        let (time, curve) = (&outcome.curves.time_s, &outcome.curves.impulse_n_s);
        let median = |name: &str| outcome.median(name).map_or_else(|| "none".to_owned(), plain);
        let milli_median = outcome.median("contact.max_impulse_n_s").map_or(0.0, |value| 1e3 * value);
        let marks = vec![
            band(time, &vec![0.0; time.len()], &milli(&curve.max), colour(*v), 0.25),
            line(time, &milli(&curve.median), colour(*v), false),
        ];
        let y = Axis::linear("impulse [mN s]", [0.0, 1e3 * most]);
        let mut panel = Panel::of_curves(time_axis(comparison), y, 170, marks);
        panel.title = format!(
            "{}: largest {} mN s, as a force {} N over a step of {} ms",
            variant.label,
            plain(milli_median),
            median("contact.max_force_n"),
            plain(1e3 * outcome.solver.step_s.map_or(f64::NAN, |step| step.0))
        );
        panels.push(panel);
    }
    Figure {
        name: "contact-response".into(),
        title: "How contacts are answered".into(),
        words: "Largest impulse of one contact within a step, since the frame before: line for the median over the \
                members, field up to the largest of any member. An impulse within a step grows with the step, a lasting \
                force does not: between variants of different steps compare the force in the title."
            .to_owned(),
        panels,
    }
}

fn energy(comparison: &Comparison) -> Figure {
    let mut panels = Vec::new();
    if let Some(mut panel) = curves(comparison, "mechanical energy [J]", 300, |curves| &curves.mechanical_j) {
        panel.title = "Kinetic, elastic and stored energy".to_owned();
        panel.keys = keys(comparison);
        panels.push(panel);
    }
    let shown: Vec<_> = comparison.ran().collect();
    let at_end = |outcome: &Outcome, row: &str| outcome.curves.energy_j[row].last().copied().unwrap_or(0.0);
    // What flowed in is no part of where energy is; the residual may have either sign and is told in words.
    let stacked: Vec<(usize, &str)> = (0..ROWS_HELD + ROWS_TAKEN)
        .map(|row| (row, ROWS[row]))
        .filter(|(_, row)| shown.iter().any(|(_, _, outcome)| at_end(outcome, row) > 0.0))
        .collect();
    let mut marks = Vec::new();
    let mut longest = 0.0_f64;
    for (row, (_, _, outcome)) in shown.iter().enumerate() {
        let mut from = 0.0;
        for (kind, (_, name)) in stacked.iter().enumerate() {
            let to = from + at_end(outcome, name).max(0.0);
            let y = row as f64;
            marks.push(Mark::Bar {
                from: (from, y - 0.3),
                to: (to, y + 0.3),
                colour: kind_colour(kind),
                opacity: 1.0,
                edge: false,
            });
            from = to;
        }
        longest = longest.max(from);
    }
    let residual = |outcome: &Outcome| format!("residual {} J", plain(at_end(outcome, ROWS[ROWS.len() - 1])));
    if !shown.is_empty() {
        let names = shown.iter().map(|(_, variant, _)| variant.label.clone()).collect();
        let x = Axis::fixed("energy at the end [J]", 0.0, 1.02 * longest.max(f64::MIN_POSITIVE));
        let mut panel = Panel::of_rows("Where the energy is at the end", names, x, 40, marks);
        panel.notes = shown.iter().map(|(_, _, outcome)| residual(outcome)).collect();
        panel.keys = stacked
            .iter()
            .enumerate()
            .map(|(kind, (_, name))| Key {
                words: (*name).to_owned(),
                colour: kind_colour(kind),
                swatch: Swatch::Field,
            })
            .collect();
        panels.push(panel);
    }
    Figure {
        name: "energy".into(),
        title: "Energy".into(),
        words: "It falls a little while the net opens and drops at contacts. Below, medians of the ledger's rows: what \
                net and target still have, and what cables and contact took. Nothing may be missing: the residual is \
                what is nowhere in the ledger."
            .to_owned(),
        panels,
    }
}

fn momentum(comparison: &Comparison) -> Figure {
    let mut panels = Vec::new();
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        let (mut marks, mut values) = (Vec::new(), vec![0.0]);
        for (v, _, outcome) in comparison.ran() {
            let (time, curves) = (&outcome.curves.time_s, &outcome.curves);
            for (curve, is_target) in
                [(&curves.momentum_net[axis], false), (&curves.momentum_target[axis], true)]
            {
                if !curve.is_empty() {
                    marks.push(line(time, curve, colour(v), is_target));
                    values.extend(curve);
                }
            }
        }
        let y = Axis::linear(&format!("along {name} [kg m/s]"), values);
        let height = if axis == 0 { 280 } else { 190 };
        panels.push(Panel::of_curves(time_axis(comparison), y, height, marks));
    }
    let has_target = comparison.ran().any(|(_, _, outcome)| !outcome.curves.momentum_target[0].is_empty());
    panels[0].keys = keys(comparison);
    if has_target {
        panels[0].keys.push(Key {
            words: "dashed: the target".to_owned(),
            colour: MUTED,
            swatch: Swatch::Dashed,
        });
    }
    let worst =
        comparison.ran().filter_map(|(_, _, o)| Some(o.scalars.get("conservation.momentum_residual")?.max));
    Figure {
        name: "momentum".into(),
        title: "Momentum".into(),
        words: format!(
            "Momentum of the net{}, medians over the members. Their sum changes only by what comes from outside (a held \
             target, effects); beyond that by at most {} of the launch momentum in any run.",
            if has_target { " and, dashed, of the target, which takes over what the net gives" } else { "" },
            plain(worst.fold(0.0, f64::max))
        ),
        panels: if comparison.base().is_some() { panels } else { Vec::new() },
    }
}

/// A bar of a variant, with a whisker and words.
struct Barred {
    name: String,
    colour: RGBColor,
    value: f64,
    whisker: [f64; 2],
    note: String,
}

/// Bars below each other; no panel without any.
fn bars(rows: Vec<Barred>, x: Axis) -> Vec<Panel> {
    let mut marks = Vec::new();
    for (row, Barred { colour, value, whisker: [low, high], .. }) in rows.iter().enumerate() {
        let (y, colour) = (row as f64, *colour);
        let (from, to) = ((0.0, y - 0.25), (*value, y + 0.25));
        marks.push(Mark::Bar { from, to, colour, opacity: 0.75, edge: true });
        marks.extend(whisker(*low, *high, y, 0.12, INK));
    }
    if rows.is_empty() {
        return Vec::new();
    }
    let (names, notes) = rows.into_iter().map(|row| (row.name, row.note)).unzip();
    vec![Panel { notes, ..Panel::of_rows("", names, x, 40, marks) }]
}

fn verdicts(comparison: &Comparison) -> Figure {
    let bar = |(v, variant, outcome): (usize, &Compared, &Outcome)| {
        let share = outcome.captured?;
        let verdicts = verdict_words(&outcome.verdict_counts);
        Some(Barred {
            name: variant.label.clone(),
            colour: colour(v),
            value: 100.0 * share.share,
            whisker: share.interval_95.map(|bound| 100.0 * bound),
            note: format!("{} of {}: {verdicts}", share.captured, share.of),
        })
    };
    Figure {
        name: "verdicts".into(),
        title: "Captured?".into(),
        words: "Share of the members whose target is captured, with its 95 % interval (Clopper-Pearson): variants \
                whose intervals overlap widely are not told apart by so few members."
            .to_owned(),
        panels: bars(
            comparison.ran().filter_map(bar).collect(),
            Axis::fixed("members captured [%]", 0.0, 100.0),
        ),
    }
}

fn survival(comparison: &Comparison) -> Figure {
    let named = |(v, variant, outcome): (usize, &'_ Compared, &'_ Outcome)| {
        Some((variant.label.clone(), v, outcome.survival.clone()?))
    };
    let curves: Vec<_> = comparison.ran().filter_map(named).collect();
    let named =
        curves.iter().map(|(name, series, survival)| Named { name: name.clone(), series: *series, survival });
    crate::report::survival::figure(&named.collect::<Vec<_>>())
}

fn wall_time(comparison: &Comparison) -> Figure {
    let mut longest = f64::MIN_POSITIVE;
    let rows = comparison.ran().filter_map(|(v, variant, outcome)| {
        let wall = outcome.scalars.get("wall_s")?;
        longest = longest.max(wall.max);
        let ratio = outcome.against_base.as_ref().map(|against| plain(against.wall_over_base));
        let ratio = ratio.map_or_else(String::new, |ratio| format!(", {ratio} of the base"));
        Some(Barred {
            name: variant.label.clone(),
            colour: colour(v),
            value: wall.median,
            whisker: [wall.min, wall.max],
            note: format!("{} s{ratio}", plain(wall.median)),
        })
    });
    let rows: Vec<Barred> = rows.collect();
    Figure {
        name: "wall-time".into(),
        title: "What a run costs".into(),
        words: format!(
            "Wall time of the simulation alone: median over the members, whiskers from the least to the largest. {}",
            timing(comparison)
        ),
        panels: bars(rows, Axis::fixed("wall time of a run [s]", 0.0, 1.02 * longest)),
    }
}

/// How wall times were measured.
pub fn timing(comparison: &Comparison) -> String {
    match comparison.runs_at_once {
        0 | 1 => "Runs went one after another.".to_owned(),
        many => format!("Up to {many} runs shared the machine; `--serial` times them alone."),
    }
}
