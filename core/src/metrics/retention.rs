//! Does it hold? The capture put to the test, over a tug and over a whole turn of the target.
//!
//! A capture that lasts for `hold_s` may still be lost when the chaser pulls, or when the tumbling
//! target comes round to the mouth. Both tests ask what the verdict asks, enclosed ≥ `enclosed_min`
//! and mouth ≤ `mouth_max`, in every frame of a window:
//!
//! | test | window |
//! |---|---|
//! | `tug` | from the start of the tug to its end |
//! | `turn` | from the first frame in which both hold, after the start of the winches where there are any, for one period 2π / ω₀ of the tumbling at the start |
//!
//! The net slows the tumbling down, so that the target turns by less than once within that period.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::capture::Curves;
use crate::case::Case;
use crate::run::Run;
use crate::scene::schema::CaptureRule;
use crate::target::spec::Motion;

/// How the capture stood its tests; one that does not apply is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Retention {
    /// Over one period of the tumbling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn: Option<Trial>,
    /// Over the time in which an effect puts it to the test.
    #[serde(default, rename = "tug", skip_serializing_if = "Option::is_none")]
    pub trial: Option<Trial>,
}

/// A window in which the net must hold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Trial {
    /// Whether the target was enclosed behind a closed mouth throughout; null: it was as long as the run
    /// lasted, which is less than the window.
    pub held: Option<bool>,
    /// Start of the window [s].
    pub from_s: f64,
    /// Its end, beyond the run's where that is too short [s].
    pub to_s: f64,
    /// Least enclosed share within it [-].
    pub least_enclosed: f64,
    /// Widest mouth within it, over designed area [-].
    pub widest_mouth: f64,
    /// Until when the target was held [s]: to the end of the window, or of the run.
    pub held_until_s: f64,
}

impl Retention {
    /// What `run` went through; nothing without a target, or without a test.
    pub fn of(case: &Case, run: &Run, curves: &Curves) -> Option<Retention> {
        let target = case.target()?;
        let (rule, times) = (&case.scene().capture, &run.frames.time);
        let trial = run.reports.iter().find_map(|(_, report)| Trial::of(rule, times, curves, report.trial?));
        let rate = if target.motion == Motion::Fixed { 0.0 } else { target.spin.norm() };
        let mut starts = run.reports.iter().filter_map(|(_, report)| report.start);
        let started = starts.next().map_or(Some(0.0), |(_, start)| start);
        let closed = started.and_then(|start| {
            (0..times.len()).find(|&i| times[i] >= start && holds(rule, curves, i)).map(|i| times[i])
        });
        let turn = closed
            .filter(|_| rate > 0.0)
            .and_then(|from| Trial::of(rule, times, curves, [from, from + TAU / rate]));
        (turn.is_some() || trial.is_some()).then_some(Retention { turn, trial })
    }
}

impl Trial {
    /// The trial over the window `[from, to]` [s]; nothing when no frame lies in it.
    fn of(rule: &CaptureRule, times: &[f64], curves: &Curves, [from, to]: [f64; 2]) -> Option<Trial> {
        // Times are multiples of the step up to rounding.
        let within = |t: f64| t >= from - 1e-9 && t <= to + 1e-9;
        let frames: Vec<usize> = (0..curves.enclosed.len()).filter(|&i| within(times[i])).collect();
        let (&first, &last) = (frames.first()?, frames.last()?);
        let is_whole = times.last().is_some_and(|&end| end >= to - 1e-9);
        let lost = frames.iter().copied().find(|&i| !holds(rule, curves, i));
        let over = |curve: &[f64], pick: fn(f64, f64) -> f64| {
            frames.iter().map(|&i| curve[i]).fold(curve[first], pick)
        };
        Some(Trial {
            held: if lost.is_some() { Some(false) } else { is_whole.then_some(true) },
            from_s: from,
            to_s: to,
            least_enclosed: over(&curves.enclosed, f64::min),
            widest_mouth: over(&curves.mouth, f64::max),
            held_until_s: times[lost.map_or(last, |i| i.saturating_sub(1).max(first))],
        })
    }
}

fn holds(rule: &CaptureRule, curves: &Curves, frame: usize) -> bool {
    curves.enclosed[frame] >= rule.enclosed_min && curves.mouth[frame] <= rule.mouth_max
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: [f64; 5] = [0.0, 0.1, 0.2, 0.3, 0.4];

    fn trial(enclosed: [f64; 5], mouth: [f64; 5], window: [f64; 2]) -> Option<Trial> {
        let curves = Curves { enclosed: enclosed.into(), mouth: mouth.into(), ..Curves::default() };
        let rule = CaptureRule { enclosed_min: 0.5, mouth_max: 0.2, ..CaptureRule::default() };
        Trial::of(&rule, &TIMES, &curves, window)
    }

    #[test]
    fn held_throughout_is_held() {
        let trial = trial([0.0, 0.9, 0.7, 0.8, 0.0], [1.0, 0.1, 0.15, 0.1, 1.0], [0.1, 0.3]).unwrap();
        assert_eq!(trial.held, Some(true));
        assert_eq!((trial.least_enclosed, trial.widest_mouth, trial.held_until_s), (0.7, 0.15, 0.3));
    }

    #[test]
    fn lost_for_one_frame_is_lost_even_if_it_comes_back() {
        let trial = trial([0.9, 0.9, 0.4, 0.9, 0.9], [0.1; 5], [0.0, 0.4]).unwrap();
        assert_eq!((trial.held, trial.held_until_s), (Some(false), 0.1));
        let open = self::trial([0.9; 5], [0.1, 0.1, 0.1, 0.3, 0.1], [0.0, 0.4]).unwrap();
        assert_eq!((open.held, open.widest_mouth), (Some(false), 0.3));
    }

    #[test]
    fn a_run_that_ends_within_the_window_leaves_it_open_unless_it_is_lost_before() {
        assert_eq!(trial([0.9; 5], [0.1; 5], [0.2, 0.5]).unwrap().held, None);
        assert_eq!(trial([0.9, 0.9, 0.9, 0.9, 0.1], [0.1; 5], [0.2, 0.5]).unwrap().held, Some(false));
        assert_eq!(trial([0.9; 5], [0.1; 5], [0.5, 0.6]), None);
    }
}
