//! What is asked of a member: captured at its end, still held at a time, or settled.
//!
//! A capture at the end of a short run is a snapshot. *Held at t* is a member that was held by then and not lost since it was
//! first held, as in a curve of survival; one that settled before counts as held on. A member whose run ended before it
//! could be told is undecided: neither yes nor no.

use std::fmt;
use std::str::FromStr;

use crate::scene::schema::Verdict;

/// A question that a member answers with yes or no, or is undecided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapOutcome {
    /// Held at the end of its run, whenever that was.
    Captured,
    /// Held, and settled.
    Settled,
    /// First held by a time [s], and not lost until then.
    HeldAt(f64),
}

/// How a member ended, as its row says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MemberEnd {
    /// Its verdict.
    pub verdict: Verdict,
    /// When it was first held [s].
    pub enclosed_at: Option<f64>,
    /// When it was first lost [s].
    pub first_lost_at: Option<f64>,
    /// The end of its run [s].
    pub simulated: f64,
    /// For how long it would have run at most [s]: one that ended before was decided.
    pub at_most: f64,
}

/// A run ends at a whole step: so much of its time may be missing [-].
const ROUNDING: f64 = 1e-3;

impl MapOutcome {
    /// The columns of a table that it is told by, beside the verdict.
    pub const COLUMNS: [&str; 3] = ["capture.enclosed_at_s", "capture.first_lost_at_s", "simulated_s"];

    /// The answer of a member; none where it is undecided.
    pub fn of(self, end: &MemberEnd) -> Option<bool> {
        let reached = |time: f64| end.simulated >= time * (1.0 - ROUNDING);
        match self {
            MapOutcome::Captured => Some(end.verdict.is_held()),
            MapOutcome::Settled => {
                (end.verdict != Verdict::HeldSoFar).then_some(end.verdict == Verdict::HeldSettled)
            }
            MapOutcome::HeldAt(time) => {
                let by_then = |at: Option<f64>| at.is_some_and(|at| at <= time);
                let was_lost = by_then(end.first_lost_at);
                let was_held = by_then(end.enclosed_at);
                let is_settled = end.verdict == Verdict::HeldSettled;
                // What has gone does not come back.
                let is_decided = reached(time) || is_settled || !reached(end.at_most);
                if was_lost { Some(false) } else { is_decided.then_some(was_held) }
            }
        }
    }
}

impl fmt::Display for MapOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MapOutcome::Captured => write!(f, "captured"),
            MapOutcome::Settled => write!(f, "settled"),
            MapOutcome::HeldAt(time) => write!(f, "held at {time} s"),
        }
    }
}

impl FromStr for MapOutcome {
    type Err = String;

    fn from_str(text: &str) -> Result<MapOutcome, String> {
        let time = |text: &str| text.parse::<f64>().ok().filter(|time| time.is_finite() && *time > 0.0);
        match text.split_once('@') {
            Some(("held", at)) => time(at).map(MapOutcome::HeldAt),
            None if text == "captured" => Some(MapOutcome::Captured),
            None if text == "settled" => Some(MapOutcome::Settled),
            _ => None,
        }
        .ok_or_else(|| "captured, settled, or held@T with a time in seconds, as in held@20".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(verdict: Verdict, enclosed: Option<f64>, lost: Option<f64>, simulated: f64) -> MemberEnd {
        MemberEnd { verdict, enclosed_at: enclosed, first_lost_at: lost, simulated, at_most: 20.0 }
    }

    #[test]
    fn a_member_is_held_from_when_it_was_enclosed_until_it_is_lost() {
        let lost = end(Verdict::Lost, Some(1.0), Some(7.0), 9.0);
        let answers = [0.5, 3.0, 8.0, 20.0].map(|time| MapOutcome::HeldAt(time).of(&lost));
        assert_eq!(answers, [Some(false), Some(true), Some(false), Some(false)]);
        assert_eq!(MapOutcome::Settled.of(&lost), Some(false));
        assert_eq!(MapOutcome::Captured.of(&lost), Some(false));
        let again = end(Verdict::HeldSoFar, Some(1.0), Some(7.0), 20.0);
        assert_eq!(MapOutcome::HeldAt(20.0).of(&again), Some(false), "a first loss counts");
        assert_eq!(MapOutcome::Captured.of(&again), Some(true));
    }

    #[test]
    fn one_that_ended_too_early_is_undecided_unless_it_settled_or_has_gone() {
        let settled = end(Verdict::HeldSettled, Some(1.0), None, 4.0);
        assert_eq!(MapOutcome::HeldAt(20.0).of(&settled), Some(true));
        assert_eq!(MapOutcome::Settled.of(&settled), Some(true));
        let so_far = end(Verdict::HeldSoFar, Some(1.0), None, 19.9999);
        assert_eq!(MapOutcome::HeldAt(20.0).of(&so_far), Some(true), "to the last whole step");
        assert_eq!(MapOutcome::HeldAt(40.0).of(&so_far), None);
        assert_eq!(MapOutcome::Settled.of(&so_far), None);
        let gone = end(Verdict::Missed, None, None, 5.0);
        assert_eq!(MapOutcome::HeldAt(40.0).of(&gone), Some(false));
        let not_yet = end(Verdict::Missed, None, None, 20.0);
        assert_eq!(MapOutcome::HeldAt(40.0).of(&not_yet), None);
    }

    #[test]
    fn outcomes_are_read_as_they_are_written() {
        assert_eq!("held@2.5".parse(), Ok(MapOutcome::HeldAt(2.5)));
        assert_eq!("settled".parse(), Ok(MapOutcome::Settled));
        for bad in ["held", "held@", "held@-1", "held@x", "lost", "captured@3", ""] {
            assert!(bad.parse::<MapOutcome>().is_err(), "{bad}");
        }
    }
}
