//! A study of cost as a table, as rows and as a page: `cost.csv`, `cost.json`, `cost.html`, an SVG a figure.

use std::path::Path;

use comfy_table::{Cell, CellAlignment};

use super::files::{self, WriteError};
use super::results;
use super::table::{number, table};
use crate::study::cost::advice::{length, seconds};
use crate::study::cost::{Measured, Study};

/// Writes all files of `study` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, study: &Study) -> Result<(), WriteError> {
    files::make_folder(out)?;
    files::write(&out.join("cost.csv"), |file| rows(file, study))?;
    // Last: it says that the rest is there.
    results::json(&out.join("cost.json"), study)
}

/// A row a setting.
fn rows(file: impl std::io::Write, study: &Study) -> Result<(), csv::Error> {
    let mut rows = csv::Writer::from_writer(file);
    rows.write_record([
        "family",
        "label",
        "value",
        "step_s",
        "on_front",
        "cpu_s_per_s",
        "cpu_least",
        "cpu_most",
        "repeats",
        "bullets_rms_m",
        "bullets_max_m",
        "knots_rms_m",
        "knots_max_m",
        "max_area_m2",
        "deployment_time_s",
        "travelling_distance_m",
        "effective_period_s",
        "max_tension_n",
        "momentum_residual",
        "angular_momentum_residual",
        "energy_residual",
        "energy_rise",
        "max_penetration_m",
        "cables_through_target",
        "steps",
        "substeps",
        "sweeps",
        "rows",
        "snaps",
        "detections",
        "contacts",
        "without",
        "warnings",
        "changes",
    ])?;
    for one in &study.settings {
        let text = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:e}"));
        let worth = one.worth.as_ref();
        let of = |value: fn(&crate::study::cost::errors::Worth) -> Option<f64>| text(worth.and_then(value));
        let count = |value: fn(&crate::study::cost::errors::Counts) -> u64| {
            worth.map_or_else(String::new, |worth| value(&worth.counts).to_string())
        };
        rows.write_record([
            one.family.clone(),
            one.label.clone(),
            text(one.value),
            text(one.step_s),
            one.on_front.to_string(),
            text(one.cost.map(|cost| cost.median)),
            text(one.cost.map(|cost| cost.least)),
            text(one.cost.map(|cost| cost.most)),
            one.cost.map_or_else(String::new, |cost| cost.repeats.to_string()),
            of(|worth| Some(worth.bullets?.rms_m)),
            of(|worth| Some(worth.bullets?.max_m)),
            of(|worth| Some(worth.knots?.rms_m)),
            of(|worth| Some(worth.knots?.max_m)),
            of(|worth| Some(worth.deployment.max_area_m2)),
            of(|worth| Some(worth.deployment.deployment_time_s)),
            of(|worth| Some(worth.deployment.travelling_distance_m)),
            of(|worth| Some(worth.deployment.effective_period_s)),
            of(|worth| Some(worth.max_tension_n)),
            of(|worth| Some(worth.conservation.momentum_residual)),
            of(|worth| Some(worth.conservation.angular_momentum_residual)),
            of(|worth| Some(worth.conservation.energy_residual)),
            of(|worth| Some(worth.conservation.energy_rise)),
            of(|worth| Some(worth.ending?.max_penetration_m)),
            of(|worth| Some(worth.ending?.through as f64)),
            count(|counts| counts.steps),
            count(|counts| counts.substeps),
            count(|counts| counts.sweeps),
            count(|counts| counts.rows),
            count(|counts| counts.snaps),
            count(|counts| counts.detections),
            count(|counts| counts.contacts),
            one.without.clone().unwrap_or_default(),
            one.warnings.join("; "),
            one.changes.join(" "),
        ])?;
    }
    rows.flush()?;
    Ok(())
}

/// The study as text: the front, the distributions, the advice.
pub fn text(study: &Study) -> String {
    let mut rows = table(&["setting", "family", "error", "s per s", "runs", "substeps", "energy rise", ""]);
    let mut list: Vec<&Measured> = study.settings.iter().filter(|one| one.cost.is_some()).collect();
    list.sort_by(|a, b| a.family.cmp(&b.family));
    for one in list {
        let worth = one.worth.as_ref();
        rows.add_row(vec![
            one.label.clone(),
            one.family.clone(),
            one.error().map_or_else(String::new, length),
            one.cost.map_or_else(String::new, |cost| number(cost.median)),
            one.cost.map_or_else(String::new, |cost| cost.repeats.to_string()),
            worth.map_or_else(String::new, |worth| worth.counts.substeps.to_string()),
            worth.map_or_else(String::new, |worth| number(worth.conservation.energy_rise)),
            format!("{}{}", if one.on_front { "front " } else { "" }, one.warnings.join("; ")),
        ].into_iter().map(|text| Cell::new(text).set_alignment(CellAlignment::Left)));
    }
    let mut text = format!("{}\n{rows}\n", study.title);
    if let Some(q) = &study.reference {
        text.push_str(&format!("window {} horizon {} single {} floor {} pairs {:?} runs {:?} scal {:?}\n", q.window_s, q.horizon_s, q.single_run_horizon_s, length(study.floor_m), q.pairs, q.runs, q.scalars));
    }
    for v in &study.verdicts { text.push_str(&format!("{} {}/{} cqi {:?} cost {} agrees {:?} through {} pen {}\n", v.label, v.captured.captured, v.captured.of, v.cqi.map(|q| q.value), seconds(v.cost), v.agrees, v.through_mean, v.max_penetration_m)); }
    for o in &study.orders { text.push_str(&format!("{o:?}\n")); }
    text.push_str(&study.advice.sentence);
    for w in &study.advice.warnings { text.push('\n'); text.push_str(w); }
    for one in &study.settings { if let Some(w) = &one.without { text.push_str(&format!("\n{}: {w}", one.label)); } }
    text
}
