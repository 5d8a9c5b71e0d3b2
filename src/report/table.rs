//! The result of a run as a table that a person enjoys reading.

use std::collections::BTreeMap;

use comfy_table::{Cell, CellAlignment};
use serde_json::Value;

use super::text_table::{TextTable, tied};
use crate::effects::Effects;
use crate::metrics::retention::Trial;
use crate::metrics::summary::Summary;
use crate::metrics::verdict::{Capture, Reason, Verdict};
use crate::study::ensemble::Ensemble;

/// `summary` as text.
pub fn summary(summary: &Summary) -> String {
    let mut rows = Rows(TextTable::new(&["", "", ""]));
    let deployment = &summary.deployment;
    rows.head("deployment");
    rows.number("largest area", deployment.max_area_m2, "m²");
    rows.number("deployment time", deployment.deployment_time_s, "s");
    rows.number("travelling distance", deployment.travelling_distance_m, "m");
    rows.number("effective period", deployment.effective_period_s, "s");
    if let Some(contact) = &summary.contact {
        rows.head("contact");
        rows.optional("first contact", contact.first_contact_s, "s", "none");
        rows.number("largest impulse", contact.max_impulse_n_s, "N s");
        rows.number("deepest penetration", contact.max_penetration_m * 1e3, "mm");
        rows.text("cables through the target", &contact.cables_inside.to_string(), "");
    }
    if let Some(target) = &summary.target {
        rows.head("target");
        rows.text("displacement", &vector(&target.displacement_m), "m");
        rows.text("spin at the end (body)", &vector(&target.spin_rad_s), "rad/s");
    }
    if let Some(capture) = &summary.capture {
        rows.head("capture");
        rows.number("enclosed", capture.enclosed * 100.0, "% of the target");
        rows.number("mouth, vector area", capture.mouth * 100.0, "% of the net");
        rows.number("mouth, planar hull", capture.mouth_hull * 100.0, "% of the net");
        rows.number("bullets from their centre", capture.gather * 100.0, "% of the side");
        rows.number("directions covered", capture.coverage * 100.0, "%");
        rows.number("separation", capture.separation, "target lengths");
        rows.number("quality index", capture.cqi, "0 is ideal");
        rows.number("relative energy", capture.relative_energy * 100.0, "% of the launch");
        rows.number("turns held", capture.turns_held, "");
    }
    rows.effects(summary);
    rows.holds(summary);
    rows.kept_and_cost(summary);
    let warnings: String = summary.warnings.iter().map(|warning| format!("\nwarning: {warning}.")).collect();
    format!("{}\n{}\n{}{warnings}", summary.title, rows.0, verdict(summary))
}

/// `ensemble` as text: the share captured, and the quartiles of its main numbers.
pub fn ensemble(ensemble: &Ensemble) -> String {
    let mut rows = TextTable::new(&["", "least", "quartile", "median", "quartile", "largest", "members"]);
    for (name, spread) in &ensemble.scalars {
        let block = name.split('.').next().unwrap_or_default();
        if !MAIN_BLOCKS.contains(&block) && Effects::rows(block).is_empty() {
            continue;
        }
        let numbers = [spread.min, spread.lower, spread.median, spread.upper, spread.max].map(number);
        let mut row = vec![Cell::new(name)];
        row.extend(numbers.into_iter().map(|n| Cell::new(n).set_alignment(CellAlignment::Right)));
        row.push(Cell::new(spread.count).set_alignment(CellAlignment::Right));
        rows.add_row(row);
    }
    let mut text = format!("{}\n{rows}", ensemble.title);
    for (member, failure) in &ensemble.failures {
        text.push_str(&format!("\nmember {member} failed: {failure}"));
    }
    if let Some(drawn) = &ensemble.drawn {
        text.push_str(&format!("\nDrawn for each member: {}.", drawn.columns.join(", ")));
    }
    text.push('\n');
    text.push_str(&ensemble_verdict(ensemble));
    for (share, trial) in
        [(ensemble.held_turn, "over one turn"), (ensemble.held_trial, "when put to the test")]
    {
        if let Some(share) = share {
            text.push_str(&format!("\nHeld {trial}: {} of {}.", share.captured, share.of));
        }
    }
    text
}

/// How often each verdict was given, as `3 held so far, 1 lost`.
pub fn verdict_words(counts: &BTreeMap<String, usize>) -> String {
    let words: Vec<String> =
        counts.iter().map(|(verdict, count)| format!("{count} {}", verdict.replace('_', " "))).collect();
    words.join(", ")
}

/// What became of the captures of an ensemble, in a sentence or two; empty without a target.
pub fn ensemble_verdict(ensemble: &Ensemble) -> String {
    let Some(share) = &ensemble.captured else { return String::new() };
    let [low, high] = share.interval_95.map(|bound| 100.0 * bound);
    let mut text = format!(
        "Captured {} of {} ({:.0} %; 95 % interval {low:.0} to {high:.0} %): {}.",
        share.captured,
        share.of,
        100.0 * share.share,
        verdict_words(&ensemble.verdict_counts)
    );
    if let Some(survival) = &ensemble.survival {
        text.push_str(&format!(" Of those ever held: {}.", super::survival::words(survival)));
    }
    text
}

/// Blocks of the summary that the table of an ensemble shows; the file holds all.
const MAIN_BLOCKS: [&str; 7] =
    ["deployment", "contact", "capture", "target", "retention", "conservation", "wall_s"];

/// The verdict in a sentence.
pub fn verdict(summary: &Summary) -> String {
    let Some(capture) = &summary.capture else {
        return format!(
            "Opened to {:.4} m² after {:.4} s.",
            summary.deployment.max_area_m2, summary.deployment.deployment_time_s
        );
    };
    captured(capture, summary.simulated_s)
}

/// The verdict on a target in a sentence; the run lasted for `simulated` [s].
fn captured(capture: &Capture, simulated: f64) -> String {
    let since = capture.captured_at_s.map_or_else(String::new, |time| format!(" since {time:.2} s"));
    let again = match capture.recaptured {
        0 => String::new(),
        times => format!(", lost and recaptured {}", count(times)),
    };
    let lost = capture.lost_at_s.map_or_else(String::new, |time| format!(" at {time:.2} s"));
    match (capture.verdict, capture.reason) {
        (Verdict::HeldSettled, _) => {
            let settled = capture.settled_at_s.map_or_else(String::new, |time| format!(" at {time:.2} s"));
            format!("CAPTURED, held: settled{settled}; enclosed behind a closed mouth{since}{again}.")
        }
        (Verdict::HeldSoFar, _) => format!(
            "HELD SO FAR, not settled: enclosed behind a closed mouth{since}, to the end at {simulated:.2} s{again}. \
             Run on with `--until settled`."
        ),
        (Verdict::Lost, Reason::Open) => {
            format!("NOT CAPTURED: it was held{again}, and the mouth opened{lost}.")
        }
        (Verdict::Lost, _) => format!("NOT CAPTURED: it was held{again}, and lost{lost}."),
        (Verdict::Missed, Reason::Open) => "NOT CAPTURED: enclosed, but the mouth never closed.".to_owned(),
        (Verdict::Missed, _) => "NOT CAPTURED: the net met the target and never held it.".to_owned(),
        (Verdict::NeverMet, _) => "NOT CAPTURED: net and target never met.".to_owned(),
    }
}

fn count(times: usize) -> String {
    match times {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        n => format!("{n} times"),
    }
}

/// How a trial ended, in words.
pub fn held(trial: &Trial) -> &'static str {
    match trial.held {
        Some(true) => "held",
        Some(false) => "lost",
        None => "held so far",
    }
}

struct Rows(TextTable);

impl Rows {
    /// What effects had to say.
    fn effects(&mut self, summary: &Summary) {
        for (name, block) in &summary.effect_blocks.0 {
            self.head(name);
            let rows = Effects::rows(name);
            for row in rows {
                match &block[row.key] {
                    Value::Number(value) => {
                        self.number(row.name, row.scale * value.as_f64().unwrap_or(f64::NAN), row.unit);
                    }
                    Value::Array(values) => {
                        let scaled: Vec<f64> =
                            values.iter().filter_map(Value::as_f64).map(|value| row.scale * value).collect();
                        self.text(row.name, &vector(&scaled), row.unit);
                    }
                    _ => self.text(row.name, row.without, ""),
                }
            }
            // One from outside: its numbers under its own names.
            for (key, value) in block.as_object().into_iter().flatten().filter(|_| rows.is_empty()) {
                if let Some(value) = value.as_f64() {
                    self.number(key, value, "");
                }
            }
        }
    }

    /// Whether the capture held when tried.
    fn holds(&mut self, summary: &Summary) {
        if let Some(retention) = &summary.retention {
            self.head("holds");
            for (name, trial) in [("one turn", retention.turn), ("when put to the test", retention.trial)] {
                if let Some(trial) = trial {
                    self.text(name, held(&trial), &format!("to {:.2} s", trial.held_until_s));
                }
            }
        }
    }

    /// Cables, what must be kept, and what the run cost.
    fn kept_and_cost(&mut self, summary: &Summary) {
        let cables = &summary.cables;
        self.head("cables");
        self.number("largest tension", cables.max_tension_n, "N");
        self.optional("least safety factor", cables.safety_factor, "", "never taut");
        let kept = &summary.conservation;
        self.head("kept");
        self.number("momentum residual", kept.momentum_residual, "of the launch");
        self.number("angular momentum residual", kept.angular_momentum_residual, "of scale");
        self.number("energy residual", kept.energy_residual, "of the launch");
        if let Some(taken) = kept.energy_taken_by_solver {
            self.number("energy taken by the solver", taken, "of the launch");
        }
        self.number("energy created", kept.energy_created, "of the launch and the work put in");
        self.head("cost");
        self.number("wall time", summary.wall_s, "s");
        self.number("simulated", summary.simulated_s, "s");
        for name in &summary.effects {
            let share = summary.time_shares.get(&format!("effects.{name}"));
            self.number(
                &format!("effect {name}"),
                100.0 * share.copied().unwrap_or(0.0),
                "% of the wall time",
            );
        }
    }

    fn head(&mut self, name: &str) {
        self.0.add_row([name]);
    }

    fn text(&mut self, name: &str, value: &str, unit: &str) {
        let value = Cell::new(value).set_alignment(CellAlignment::Right);
        self.0.add_row(vec![Cell::new(tied(&format!("  {name}"))), value, Cell::new(unit)]);
    }

    fn number(&mut self, name: &str, value: f64, unit: &str) {
        self.text(name, &number(value), unit);
    }

    fn optional(&mut self, name: &str, value: Option<f64>, unit: &str, without: &str) {
        match value {
            Some(value) => self.number(name, value, unit),
            None => self.text(name, without, ""),
        }
    }
}

/// Four significant digits; very small and very large numbers in powers of ten.
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = value.abs().log10().floor();
    if (-3.0..6.0).contains(&digits) {
        format!("{value:.*}", (3.0 - digits).max(0.0) as usize)
    } else {
        format!("{value:.3e}")
    }
}

fn vector(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:+.4}")).collect::<Vec<_>>().join("  ")
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(number(99.8765), "99.88");
        assert_eq!(number(-0.012345), "-0.01235");
        assert_eq!(number(1e-9), "1.000e-9");
        assert_eq!(number(0.0), "0");
        assert_eq!(number(123456.0), "123456");
    }
}
