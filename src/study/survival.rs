//! How long a capture holds: the share still held over time since it was first held.
//!
//! The estimator of Kaplan and Meier (1958): at each time at which a member is lost for the first time,
//! the share falls by the members lost then over those still under watch,
//!
//! S(t) = Π (1 − dᵢ / nᵢ) over all tᵢ ≤ t.
//!
//! A member that ends undecided is censored: from its end on it is no longer under watch, and counts
//! neither as held nor as lost. One that has settled counts as held for as long as the study asks for:
//! were it censored where it stopped, only those that are still in doubt would be left under watch, and
//! the share would fall with each member that is safe. How often that is wrong stands in `docs/verdict.md`.
//!
//! Bands are 95 %: the beta product confidence procedure of Fay, Brittain and Proschan (2013), which needs no
//! large numbers, holds where S is 1 or 0, and is the interval of Clopper and Pearson where nobody is censored.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use statrs::distribution::{Beta, ContinuousCDF};

use crate::metrics::summary::Summary;
use crate::metrics::verdict::{Capture, Verdict};

/// Share still held over time since it was first held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Survival {
    /// Members that were ever held: those the curve is about.
    pub members: usize,
    /// Members that were never held.
    pub never_held: usize,
    /// Members that were lost.
    pub lost: usize,
    /// Members that settled, and count as held to the end of the curve.
    pub settled: usize,
    /// Members that ended undecided: censored.
    pub censored: usize,
    /// Where the curve ends [s].
    pub until_s: f64,
    /// A step at 0 and at each time at which a member was lost, then one at the end.
    pub steps: Vec<SurvivalStep>,
    /// When members were censored [s].
    pub censored_at_s: Vec<f64>,
}

/// The curve from a time on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SurvivalStep {
    /// Since it was first held [s].
    pub time_s: f64,
    /// Members under watch just before.
    pub at_risk: usize,
    /// Members lost then.
    pub lost: usize,
    /// Share still held [-].
    pub share: f64,
    /// 95 % band [-].
    pub band_95: [f64; 2],
}

/// How one member left the watch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Watched {
    /// For how long it was under watch [s]; infinite for one that settled.
    pub(super) time: f64,
    /// Whether it was lost then.
    pub(super) lost: bool,
}

impl Watched {
    /// The member of this verdict, whose run ended at `end` [s]; nothing when it was never held.
    pub(super) fn of(capture: &Capture, end: f64) -> Option<Watched> {
        let from = capture.enclosed_at_s?;
        Some(match capture.first_lost_at_s {
            Some(lost) => Watched { time: lost - from, lost: true },
            None if capture.verdict == Verdict::HeldSettled => Watched { time: f64::INFINITY, lost: false },
            None => Watched { time: end - from, lost: false },
        })
    }
}

impl Survival {
    /// Of members with these summaries; nothing when none was ever held.
    pub fn of(summaries: &[&Summary]) -> Option<Survival> {
        let judged: Vec<(Capture, f64)> =
            summaries.iter().filter_map(|summary| Some((summary.capture?, summary.simulated_s))).collect();
        Survival::of_captures(&judged)
    }

    /// Of members with these verdicts and ends of their runs [s]; nothing when none was ever held.
    pub fn of_captures(judged: &[(Capture, f64)]) -> Option<Survival> {
        let watched: Vec<Watched> =
            judged.iter().filter_map(|(capture, end)| Watched::of(capture, *end)).collect();
        let longest = judged.iter().map(|(capture, end)| end - capture.enclosed_at_s.unwrap_or(*end));
        let until = longest.fold(0.0, f64::max);
        let settled = watched.iter().filter(|w| w.time.is_infinite()).count();
        let lost = watched.iter().filter(|w| w.lost).count();
        let mut censored: Vec<f64> =
            watched.iter().filter(|w| !w.lost && w.time.is_finite()).map(|w| w.time).collect();
        censored.sort_by(f64::total_cmp);
        (!watched.is_empty()).then(|| Survival {
            members: watched.len(),
            never_held: judged.len() - watched.len(),
            lost,
            settled,
            censored: censored.len(),
            until_s: until,
            steps: steps(&watched, until),
            censored_at_s: censored,
        })
    }

    /// The curve at `time` [s] since it was first held.
    pub fn at(&self, time: f64) -> Option<&SurvivalStep> {
        self.steps.iter().rev().find(|step| step.time_s <= time)
    }
}

fn steps(watched: &[Watched], until: f64) -> Vec<SurvivalStep> {
    let mut times: Vec<f64> = watched.iter().filter(|w| w.lost).map(|w| w.time).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    // One that was censored at the very time was still under watch: the convention.
    let under_watch = |from: f64| watched.iter().filter(|w| w.time >= from).count();
    let (mut share, mut upper) = (1.0, BetaProduct::ONE);
    let next = times.iter().copied().chain([until]);
    let mut steps: Vec<SurvivalStep> = Vec::new();
    for (time, next) in [0.0].into_iter().chain(times.iter().copied()).zip(next) {
        let is_start = steps.is_empty();
        let at_risk = if is_start { watched.len() } else { under_watch(time) };
        let lost = watched.iter().filter(|w| !is_start && w.lost && w.time == time).count();
        if lost > 0 {
            share *= 1.0 - lost as f64 / at_risk as f64;
            upper = upper.times((at_risk - lost + 1) as f64, lost as f64);
        }
        // Nobody is lost from here to the next step: whoever is left then was under watch all the way.
        let left = watched.iter().filter(|w| w.time > time && w.time >= next).count();
        steps.push(SurvivalStep { time_s: time, at_risk, lost, share, band_95: band(upper, left) });
    }
    if let Some(last) = steps.last().copied()
        && last.time_s < until
    {
        steps.push(SurvivalStep { time_s: until, at_risk: under_watch(until), lost: 0, ..last });
    }
    steps
}

/// A product of independent beta variables by its first two moments.
#[derive(Clone, Copy)]
struct BetaProduct {
    mean: f64,
    square: f64,
}

impl BetaProduct {
    /// That of none.
    const ONE: BetaProduct = BetaProduct { mean: 1.0, square: 1.0 };

    /// With one more of the shape `a`, `b`.
    fn times(self, a: f64, b: f64) -> BetaProduct {
        let mean = a / (a + b);
        BetaProduct { mean: self.mean * mean, square: self.square * mean * (a + 1.0) / (a + b + 1.0) }
    }

    /// Its quantile `p`, as that of the beta variable with the same moments.
    fn quantile(self, p: f64) -> f64 {
        let spread = self.square - self.mean * self.mean;
        let scale = (self.mean - self.square) / spread;
        let beta = Beta::new(self.mean * scale, (1.0 - self.mean) * scale);
        beta.map_or(self.mean, |beta| beta.inverse_cdf(p))
    }
}

/// The band where the curve's upper end is spread as `upper` and so many members are `left` under watch: the lower end is
/// spread as the share of them that is the least, too.
fn band(upper: BetaProduct, left: usize) -> [f64; 2] {
    let low = if left == 0 { 0.0 } else { upper.times(left as f64, 1.0).quantile(0.025) };
    [low, upper.quantile(0.975)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::ensemble::Share;

    fn lost(time: f64) -> Watched {
        Watched { time, lost: true }
    }

    fn censored(time: f64) -> Watched {
        Watched { time, lost: false }
    }

    /// The remission times of Freireich et al. (1963), 6-MP arm, the textbooks' example: S(6) = 0.857,
    /// S(10) = 0.753, S(23) = 0.448.
    #[test]
    fn the_textbook_example_is_met() {
        let mut watched: Vec<Watched> = [6.0, 6.0, 6.0, 7.0, 10.0, 13.0, 16.0, 22.0, 23.0].map(lost).to_vec();
        let left = [6.0, 9.0, 10.0, 11.0, 17.0, 19.0, 20.0, 25.0, 32.0, 32.0, 34.0, 35.0];
        watched.extend(left.map(censored));
        let steps = steps(&watched, 35.0);
        let at = |time: f64| steps.iter().rev().find(|step| step.time_s <= time).unwrap();
        assert!((at(6.0).share - 0.857).abs() < 5e-4 && at(6.0).at_risk == 21);
        assert!((at(10.0).share - 0.753).abs() < 5e-4 && at(10.0).at_risk == 15);
        assert!((at(23.0).share - 0.448).abs() < 5e-4 && at(23.0).at_risk == 6);
        // Around the log-log band of the textbooks, 0.503 to 0.889, which small numbers make too narrow.
        let [low, high] = at(10.0).band_95;
        assert!((0.45..0.503).contains(&low) && (0.889..0.92).contains(&high), "{low} {high}");
    }

    #[test]
    fn a_settled_member_stays_under_watch_and_a_censored_one_does_not() {
        let settled = steps(&[lost(5.0), censored(f64::INFINITY)], 10.0);
        assert_eq!(settled.last().unwrap().share, 0.5);
        let undecided = steps(&[lost(5.0), censored(2.0)], 10.0);
        assert_eq!(undecided.last().unwrap().share, 0.0);
    }

    /// Where nobody is censored the share lost is binomial at every time.
    #[test]
    fn without_a_censored_member_the_band_is_exact() {
        let times = [1.0, 2.0, 2.0, 3.0, 4.0, 5.0];
        let steps = steps(&times.map(lost), 6.0);
        for step in &steps {
            let held = times.iter().filter(|time| **time > step.time_s).count();
            let exact = Share::of(held, times.len());
            assert!((step.share - exact.share).abs() < 1e-12, "{step:?}");
            for side in [0, 1] {
                assert!((step.band_95[side] - exact.interval_95[side]).abs() < 1e-9, "{step:?} {exact:?}");
            }
        }
        assert_eq!(steps.last().unwrap().share, 0.0);
    }

    #[test]
    fn without_a_loss_the_band_is_that_of_the_members_under_watch() {
        let steps = steps(&[censored(3.0); 10], 3.0);
        assert_eq!(steps[0].share, 1.0);
        // 0.025^(1/10)
        assert!((steps[0].band_95[0] - 0.6915).abs() < 1e-3 && steps[0].band_95[1] == 1.0);
    }
}
