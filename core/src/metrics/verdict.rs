//! Does the net hold, and for good? The verdict in time.
//!
//! At every frame the net **holds** the target when enclosed ≥ `enclosed_min` and mouth ≤ `mouth_max`
//! (see [`super::capture`]). Held and lost are states that last: each begins where its condition
//! began, once that has lasted for `hold_s`, so that a flicker of one frame is neither.
//!
//! | verdict | meaning |
//! |---|---|
//! | `never_met` | net and target never touched, and it never held |
//! | `missed` | they met, but it never held |
//! | `lost` | held, and not at the end |
//! | `held_so_far` | held at the end, and nothing says yet that it stays |
//! | `held_settled` | held at the end, and settled |
//!
//! # Settled
//!
//! A capture is settled once all of these have been true together, for as long as a target that
//! tumbles takes to turn by `settled_turns`, and at least `settled_crossings` times the crossing time (side of
//! the net over launch speed):
//!
//! - it holds,
//! - the bullets have met: gather ≤ `settled_gather` (see [`super::mouth`]),
//! - no path out is left between them: planar hull of the mouth ≤ `settled_hull`; bullets that are tied
//!   together leave the edges of the net between them free, and a stage slipped out there,
//! - what is left of relative motion is small: kinetic energy of the net in the frame that moves with the
//!   target ≤ `settled_energy` times the launch energy.
//!
//! How the numbers were found, and how often a settled capture was lost, stands in `docs/verdict.md`.
//!
//! # Decided
//!
//! A run is decided when it is settled, or when the net has gone: no sample of the target enclosed, no
//! knot within the target's bounding sphere, and the centres of mass moving apart, for `hold_s`. Nothing
//! but a thread or a tether brings such a net back, so a scene with one of these is never decided so.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::capture::Curves;
use crate::case::Case;
use crate::scene::schema::CaptureRule;
pub use crate::scene::schema::Verdict;
use crate::target::spec::Motion;

/// Why a target counts as captured or not, at the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// Enclosed behind a closed mouth to the end.
    Held,
    /// Never enclosed.
    Missed,
    /// Enclosed, then lost.
    Slipped,
    /// Enclosed, but the mouth is too wide.
    Open,
}

impl Reason {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Reason::Held => "held",
            Reason::Missed => "missed",
            Reason::Slipped => "slipped",
            Reason::Open => "open",
        }
    }
}

/// The verdict and the curves' values at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Capture {
    /// Whether the target is held at the end: `held_so_far` or `held_settled`.
    pub captured: bool,
    /// The verdict in time.
    pub verdict: Verdict,
    /// Why, at the end.
    pub reason: Reason,
    /// Since when it is held, to the end [s]; null when it is not.
    pub captured_at_s: Option<f64>,
    /// When it was first held [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub enclosed_at_s: Option<f64>,
    /// When it was first lost [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_lost_at_s: Option<f64>,
    /// When it was lost last [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lost_at_s: Option<f64>,
    /// How often it was held again after it was lost.
    #[serde(default)]
    pub recaptured: usize,
    /// When it was first settled [s]; with the verdict `lost` the criterion was wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settled_at_s: Option<f64>,
    /// Turns of the target since it is held [-]; 0 when it is not.
    #[serde(default)]
    pub turns_held: f64,
    /// Enclosed share of the target [-].
    pub enclosed: f64,
    /// Vector area of the mouth over designed area [-].
    pub mouth: f64,
    /// Planar hull of the perimeter over designed area [-].
    #[serde(default)]
    pub mouth_hull: f64,
    /// Mean distance of the bullets from their centre over the side of the net [-].
    #[serde(default)]
    pub gather: f64,
    /// Share of all directions from the target that the net covers [-].
    #[serde(default)]
    pub coverage: f64,
    /// Separation over the target's characteristic length [-].
    pub separation: f64,
    /// Capture quality index [-].
    pub cqi: f64,
    /// Kinetic energy of the net in the frame of the target over the launch energy [-].
    #[serde(default)]
    pub relative_energy: f64,
}

/// What the target's state was from a time on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// From then on [s].
    pub at_s: f64,
    /// What it was.
    pub state: Verdict,
}

impl Capture {
    /// The verdict on `curves`, whose frames are at `times` [s]; nothing without a target.
    pub fn of(case: &Case, met: bool, times: &[f64], curves: &Curves) -> Option<Capture> {
        let last = curves.enclosed.len().checked_sub(1)?;
        let rule = &case.scene().capture;
        let stretches = stretches(rule, times, curves);
        let now = stretches.last().filter(|stretch| stretch.to.is_none());
        let settling = Settling::of(case);
        let settled = |stretch: &Stretch| settling.first(rule, times, curves, stretch);
        let losses = || stretches.iter().filter_map(|stretch| stretch.to);
        let verdict = match now {
            Some(stretch) if settled(stretch).is_some() => Verdict::HeldSettled,
            Some(_) => Verdict::HeldSoFar,
            None if !stretches.is_empty() => Verdict::Lost,
            None if met => Verdict::Missed,
            None => Verdict::NeverMet,
        };
        let enclosed = |i: usize| curves.enclosed[i] >= rule.enclosed_min;
        let reason = match verdict {
            _ if verdict.is_held() => Reason::Held,
            _ if enclosed(last) => Reason::Open,
            _ if (0..=last).any(enclosed) => Reason::Slipped,
            _ => Reason::Missed,
        };
        Some(Capture {
            captured: verdict.is_held(),
            verdict,
            reason,
            captured_at_s: now.map(|stretch| times[stretch.from]),
            enclosed_at_s: stretches.first().map(|stretch| times[stretch.from]),
            first_lost_at_s: losses().next().map(|i| times[i]),
            lost_at_s: losses().next_back().map(|i| times[i]),
            recaptured: stretches.len().saturating_sub(1),
            settled_at_s: stretches.iter().find_map(settled).map(|i| times[i]),
            turns_held: now.map_or(0.0, |stretch| curves.turns[last] - curves.turns[stretch.from]),
            enclosed: curves.enclosed[last],
            mouth: curves.mouth[last],
            mouth_hull: curves.mouth_hull[last],
            gather: curves.gather[last],
            coverage: curves.coverage[last],
            separation: curves.separation[last],
            cqi: curves.cqi[last],
            relative_energy: curves.relative_energy[last],
        })
    }

    /// Whether running on would change nothing: settled, or the net has gone.
    pub fn is_decided(&self, case: &Case, times: &[f64], curves: &Curves) -> bool {
        self.verdict == Verdict::HeldSettled || (!self.captured && has_gone(case, times, curves))
    }
}

/// What the target's state was, from when on: nothing before the first entry.
pub fn changes(case: &Case, times: &[f64], curves: &Curves) -> Vec<Change> {
    let rule = &case.scene().capture;
    let settling = Settling::of(case);
    let mut changes = Vec::new();
    for stretch in stretches(rule, times, curves) {
        let mut push = |frame: usize, state| changes.push(Change { at_s: times[frame], state });
        push(stretch.from, Verdict::HeldSoFar);
        if let Some(frame) = settling.first(rule, times, curves, &stretch) {
            push(frame, Verdict::HeldSettled);
        }
        if let Some(frame) = stretch.to {
            push(frame, Verdict::Lost);
        }
    }
    changes
}

/// Frames in which the target is held, the last of which may last to the end.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    from: usize,
    /// The first frame in which it is lost; none: held to the end.
    to: Option<usize>,
}

fn holds(rule: &CaptureRule, curves: &Curves, frame: usize) -> bool {
    curves.enclosed[frame] >= rule.enclosed_min && curves.mouth[frame] <= rule.mouth_max
}

/// A state changes where its opposite has lasted for `hold_s`, and dates from where that began.
fn stretches(rule: &CaptureRule, times: &[f64], curves: &Curves) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    let (mut held, mut since) = (false, None);
    for (frame, time) in times.iter().enumerate().take(curves.enclosed.len()) {
        if holds(rule, curves, frame) == held {
            since = None;
            continue;
        }
        let from = *since.get_or_insert(frame);
        if time - times[from] < rule.hold_s - 1e-9 {
            continue;
        }
        (held, since) = (!held, None);
        match stretches.last_mut() {
            Some(stretch) if !held => stretch.to = Some(from),
            _ => stretches.push(Stretch { from, to: None }),
        }
    }
    stretches
}

/// The criterion in the scene's own units.
struct Settling {
    /// Least length of a window [s].
    shortest: f64,
    /// Least turns of the target within it [-].
    turns: f64,
}

impl Settling {
    fn of(case: &Case) -> Settling {
        let rule = &case.scene().capture;
        let crossing = case.net().designed_area.sqrt() / case.scene().launch.speed_m_s.max(f64::MIN_POSITIVE);
        // A target that did not tumble need not turn.
        let tumbles = case.target().is_some_and(|t| t.motion != Motion::Fixed && t.spin.norm() > 0.0);
        Settling {
            shortest: rule.settled_crossings * crossing,
            turns: if tumbles { rule.settled_turns } else { 0.0 },
        }
    }

    /// The first frame of `stretch` in which the target is settled.
    fn first(&self, rule: &CaptureRule, times: &[f64], curves: &Curves, stretch: &Stretch) -> Option<usize> {
        let mut from = None;
        for frame in stretch.from..stretch.to.unwrap_or(curves.enclosed.len()) {
            let calm = holds(rule, curves, frame)
                && curves.gather[frame] <= rule.settled_gather
                && curves.mouth_hull[frame] <= rule.settled_hull
                && curves.relative_energy[frame] <= rule.settled_energy;
            if !calm {
                from = None;
                continue;
            }
            let from = *from.get_or_insert(frame);
            let turns = curves.turns[frame] - curves.turns[from];
            if times[frame] - times[from] >= self.shortest && turns >= self.turns {
                return Some(frame);
            }
        }
        None
    }
}

/// Whether the net has left the target and nothing brings it back.
fn has_gone(case: &Case, times: &[f64], curves: &Curves) -> bool {
    if case.scene().effects.options().pull > 0.0 {
        return false;
    }
    let last = curves.enclosed.len() - 1;
    let from = times.partition_point(|&t| t < times[last] - case.scene().capture.hold_s - 1e-9).min(last);
    from < last
        && (from..=last).all(|i| curves.enclosed[i] == 0.0 && curves.clearance[i] > 0.0)
        && (from..last).all(|i| curves.separation[i + 1] > curves.separation[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.1;

    /// Frames every 0.1 s: held where `held` says so, and turning once a second.
    fn curves(held: &[bool], gather: f64) -> (Vec<f64>, Curves) {
        let enclosed: Vec<f64> = held.iter().map(|&held| if held { 0.9 } else { 0.1 }).collect();
        let all = |value: f64| vec![value; held.len()];
        let times: Vec<f64> = (0..held.len()).map(|i| STEP * i as f64).collect();
        let turns = times.clone();
        let curves = Curves {
            mouth: all(0.1),
            gather: all(gather),
            mouth_hull: all(0.05),
            relative_energy: all(0.0),
            enclosed,
            turns,
            ..Curves::default()
        };
        (times, curves)
    }

    fn rule() -> CaptureRule {
        CaptureRule { hold_s: 0.2, ..CaptureRule::default() }
    }

    fn held(pattern: &str) -> Vec<bool> {
        pattern.chars().map(|c| c == 'h').collect()
    }

    #[test]
    fn held_and_lost_last_for_hold_s_and_a_flicker_is_neither() {
        let of = |pattern: &str| {
            let (times, curves) = curves(&held(pattern), 0.5);
            stretches(&rule(), &times, &curves)
        };
        assert_eq!(of("..h..hh.."), []);
        assert_eq!(of("..hhhh"), [Stretch { from: 2, to: None }]);
        assert_eq!(of("..hhh.hh..hhh"), [Stretch { from: 2, to: None }]);
        assert_eq!(of(".hhhh....hhhh"), [Stretch { from: 1, to: Some(5) }, Stretch { from: 9, to: None }]);
        assert_eq!(of(".hhhh..."), [Stretch { from: 1, to: Some(5) }]);
    }

    #[test]
    fn settled_needs_bullets_that_have_met_time_and_turns() {
        let first = |gather: f64, shortest: f64, turns: f64| {
            let (times, curves) = curves(&[true; 30], gather);
            let stretch = Stretch { from: 3, to: None };
            Settling { shortest, turns }.first(&rule(), &times, &curves, &stretch)
        };
        assert_eq!(first(0.5, 0.0, 0.0), None);
        assert_eq!(first(0.1, 0.0, 0.0), Some(3));
        assert_eq!(first(0.1, 1.0, 0.0), Some(13));
        assert_eq!(first(0.1, 0.5, 2.0), Some(23));
        assert_eq!(first(0.1, 0.5, 2.8), None, "the run is too short");
    }

    #[test]
    fn a_flicker_begins_the_window_of_settled_anew() {
        let (times, mut curves) = curves(&[true; 30], 0.1);
        curves.mouth_hull[10] = 0.3;
        let stretch = Stretch { from: 0, to: None };
        let settled = Settling { shortest: 1.05, turns: 0.0 }.first(&rule(), &times, &curves, &stretch);
        assert_eq!(settled, Some(22));
    }
}
