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
//! Bands are 95 %: Greenwood's variance of ln S, carried through ln(−ln S) so that they stay within 0 and
//! 1 (Kalbfleisch and Prentice); where S is 1 or 0 they are those of Clopper and Pearson for the members
//! under watch.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Z;
use super::ensemble::Share;
use crate::metrics::summary::Summary;
use crate::metrics::verdict::Verdict;

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
struct Watched {
    /// For how long it was under watch [s]; infinite for one that settled.
    time: f64,
    /// Whether it was lost then.
    lost: bool,
}

impl Survival {
    /// Of members with these summaries; nothing when none was ever held.
    pub fn of(summaries: &[&Summary]) -> Option<Survival> {
        let judged = || summaries.iter().filter_map(|summary| Some((summary.capture?, summary.simulated_s)));
        let watched: Vec<Watched> = judged()
            .filter_map(|(capture, end)| {
                let from = capture.enclosed_at_s?;
                Some(match capture.first_lost_at_s {
                    Some(lost) => Watched { time: lost - from, lost: true },
                    None if capture.verdict == Verdict::HeldSettled => {
                        Watched { time: f64::INFINITY, lost: false }
                    }
                    None => Watched { time: end - from, lost: false },
                })
            })
            .collect();
        let longest = judged().map(|(capture, end)| end - capture.enclosed_at_s.unwrap_or(end));
        let until = longest.fold(0.0, f64::max);
        let settled = watched.iter().filter(|w| w.time.is_infinite()).count();
        let lost = watched.iter().filter(|w| w.lost).count();
        let mut censored: Vec<f64> =
            watched.iter().filter(|w| !w.lost && w.time.is_finite()).map(|w| w.time).collect();
        censored.sort_by(f64::total_cmp);
        (!watched.is_empty()).then(|| Survival {
            members: watched.len(),
            never_held: judged().count() - watched.len(),
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
    let (mut share, mut greenwood) = (1.0, 0.0);
    let mut steps = vec![SurvivalStep {
        time_s: 0.0,
        at_risk: watched.len(),
        lost: 0,
        share,
        band_95: band(share, greenwood, watched.len()),
    }];
    for time in times {
        // One that was censored at the very time was still under watch: the convention.
        let at_risk = watched.iter().filter(|w| w.time >= time).count();
        let lost = watched.iter().filter(|w| w.lost && w.time == time).count();
        let (n, d) = (at_risk as f64, lost as f64);
        share *= 1.0 - d / n;
        greenwood += d / (n * (n - d));
        steps.push(SurvivalStep {
            time_s: time,
            at_risk,
            lost,
            share,
            band_95: band(share, greenwood, at_risk),
        });
    }
    let at_risk = watched.iter().filter(|w| w.time >= until).count();
    if steps.last().is_some_and(|last| last.time_s < until) {
        steps.push(SurvivalStep {
            time_s: until,
            at_risk,
            lost: 0,
            share,
            band_95: band(share, greenwood, at_risk),
        });
    }
    steps
}

/// exp(−exp(θ ± z σ)) with θ = ln(−ln S) and σ² = greenwood / (ln S)².
fn band(share: f64, greenwood: f64, at_risk: usize) -> [f64; 2] {
    if share >= 1.0 || share <= 0.0 {
        return if at_risk == 0 {
            [0.0, 1.0]
        } else {
            Share::of(if share > 0.5 { at_risk } else { 0 }, at_risk).interval_95
        };
    }
    let sigma = greenwood.sqrt() / share.ln().abs();
    [1.0, -1.0].map(|sign| share.powf((sign * Z * sigma).exp()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lost(time: f64) -> Watched {
        Watched { time, lost: true }
    }

    fn censored(time: f64) -> Watched {
        Watched { time, lost: false }
    }

    /// The remission times of Freireich et al. (1963), 6-MP arm, the textbooks' example: S(6) = 0.857,
    /// S(10) = 0.753, S(23) = 0.448; the log-log band at 10 weeks is 0.503 to 0.889.
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
        let [low, high] = at(10.0).band_95;
        assert!((low - 0.503).abs() < 2e-3 && (high - 0.889).abs() < 2e-3, "{low} {high}");
    }

    #[test]
    fn a_settled_member_stays_under_watch_and_a_censored_one_does_not() {
        let settled = steps(&[lost(5.0), censored(f64::INFINITY)], 10.0);
        assert_eq!(settled.last().unwrap().share, 0.5);
        let undecided = steps(&[lost(5.0), censored(2.0)], 10.0);
        assert_eq!(undecided.last().unwrap().share, 0.0);
    }

    #[test]
    fn without_a_loss_the_band_is_that_of_the_members_under_watch() {
        let steps = steps(&[censored(3.0); 10], 3.0);
        assert_eq!(steps[0].share, 1.0);
        // 0.025^(1/10)
        assert!((steps[0].band_95[0] - 0.6915).abs() < 1e-3 && steps[0].band_95[1] == 1.0);
    }
}
