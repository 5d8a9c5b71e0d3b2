//! What was found of a claim, and whether the source says the same.
//!
//! - Of an outcome: the share of the members, with its Clopper–Pearson interval. It agrees with yes where more than half
//!   of those that are decided have it, with no where less than half do.
//! - Of a number: the median of the members, with the least and the largest. It agrees where it keeps the bound that the
//!   source states; or is within a tenth of the source's number, or has that among the members.
//! - Of a trend: the medians, which must rise or fall from each value to the next.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::spec::SourceSays;
use crate::study::ensemble::{Quartiles, Share};

/// Whether two numbers are about the same [-].
const ABOUT: f64 = 0.1;

/// Whether ours is what the source says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ClaimAgreement {
    /// It is.
    Agrees,
    /// It is not.
    Differs,
    /// The source does not ask, or nothing was measured.
    Open,
}

/// What was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ClaimMeasure {
    /// Members with an outcome, of those decided.
    Share {
        /// The share.
        share: Share,
        /// Members that ended undecided.
        undecided: usize,
    },
    /// A number over the members.
    Number {
        /// Its quartiles.
        quartiles: Quartiles,
        /// Its unit.
        unit: String,
    },
    /// Medians over the values of a parameter.
    Trend {
        /// The values.
        values: Vec<String>,
        /// Median at each; null where no member has the number.
        medians: Vec<Option<f64>>,
        /// Its unit.
        unit: String,
    },
    /// A percentage, with half of its 95 % interval where there is one.
    Percent {
        /// It [%].
        value: f64,
        /// Half of the interval [%].
        half_width_95: Option<f64>,
    },
    /// Nothing.
    Nothing {
        /// Why not.
        because: String,
    },
}

/// What was found of a claim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    /// The numbers.
    pub measured: ClaimMeasure,
    /// Whether the source says the same.
    pub agreement: ClaimAgreement,
}

impl ClaimAgreement {
    /// That of an answer, open without one.
    pub fn of(agrees: Option<bool>) -> ClaimAgreement {
        match agrees {
            Some(true) => ClaimAgreement::Agrees,
            Some(false) => ClaimAgreement::Differs,
            None => ClaimAgreement::Open,
        }
    }
}

impl Finding {
    /// Nothing was measured.
    pub fn nothing(because: &str) -> Finding {
        Finding {
            measured: ClaimMeasure::Nothing { because: because.to_owned() },
            agreement: ClaimAgreement::Open,
        }
    }

    /// Of the answers of members, none where one is undecided.
    pub fn of_answers(answers: &[Option<bool>], source: &SourceSays) -> Finding {
        let decided: Vec<bool> = answers.iter().copied().flatten().collect();
        if decided.is_empty() {
            return Finding::nothing("no member was decided");
        }
        let share = Share::of(decided.iter().filter(|is| **is).count(), decided.len());
        let agrees = match source {
            SourceSays::Yes => Some(share.share > 0.5),
            SourceSays::No => Some(share.share < 0.5),
            _ => None,
        };
        let undecided = answers.len() - decided.len();
        Finding { measured: ClaimMeasure::Share { share, undecided }, agreement: ClaimAgreement::of(agrees) }
    }

    /// Of a number of the members.
    pub fn of_numbers(numbers: Vec<f64>, unit: &str, source: &SourceSays) -> Finding {
        if numbers.is_empty() {
            return Finding::nothing("no member has the number");
        }
        let quartiles = Quartiles::of(numbers);
        let agrees = match source {
            SourceSays::About { value, .. } => Some(
                (quartiles.median - value).abs() <= ABOUT * value.abs()
                    || (quartiles.min..=quartiles.max).contains(value),
            ),
            SourceSays::AtMost { value, .. } => Some(quartiles.median <= *value),
            SourceSays::Above { value, .. } => Some(quartiles.median > *value),
            _ => None,
        };
        let measured = ClaimMeasure::Number { quartiles, unit: unit.to_owned() };
        Finding { measured, agreement: ClaimAgreement::of(agrees) }
    }

    /// Of the medians of a number over the `values` of a parameter.
    pub fn of_trend(
        values: &[String],
        medians: Vec<Option<f64>>,
        unit: &str,
        source: &SourceSays,
    ) -> Finding {
        let all: Option<Vec<f64>> = medians.iter().copied().collect();
        let agrees = all.and_then(|all| match source {
            SourceSays::Rises => Some(all.windows(2).all(|pair| pair[0] < pair[1])),
            SourceSays::Falls => Some(all.windows(2).all(|pair| pair[0] > pair[1])),
            _ => None,
        });
        let measured = ClaimMeasure::Trend { values: values.to_vec(), medians, unit: unit.to_owned() };
        Finding { measured, agreement: ClaimAgreement::of(agrees) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_agree_by_the_majority_of_the_decided() {
        let of = |answers: &[Option<bool>], source| Finding::of_answers(answers, &source).agreement;
        let [yes, no] = [Some(true), Some(false)];
        assert_eq!(of(&[yes, yes, no, None], SourceSays::Yes), ClaimAgreement::Agrees);
        assert_eq!(of(&[yes, yes, no, None], SourceSays::No), ClaimAgreement::Differs);
        assert_eq!(of(&[yes, no], SourceSays::Yes), ClaimAgreement::Differs, "half is no majority");
        assert_eq!(of(&[None], SourceSays::Yes), ClaimAgreement::Open);
        assert_eq!(of(&[yes], SourceSays::NotAsked), ClaimAgreement::Open);
    }

    #[test]
    fn numbers_agree_within_a_tenth_a_bound_or_the_members() {
        let unit = || "m".to_owned();
        let of = |numbers: &[f64], source| Finding::of_numbers(numbers.to_vec(), "m", &source).agreement;
        let about = |value| SourceSays::About { value, unit: unit() };
        assert_eq!(of(&[1.0, 1.05, 1.1], about(1.1)), ClaimAgreement::Agrees);
        assert_eq!(of(&[1.0, 1.0, 1.0], about(1.2)), ClaimAgreement::Differs);
        assert_eq!(of(&[1.0, 1.0, 1.3], about(1.2)), ClaimAgreement::Agrees, "among the members");
        assert_eq!(of(&[0.1, 0.2], SourceSays::AtMost { value: 0.1, unit: unit() }), ClaimAgreement::Differs);
        assert_eq!(of(&[0.1, 0.2], SourceSays::Above { value: 0.1, unit: unit() }), ClaimAgreement::Agrees);
        assert_eq!(of(&[], about(1.0)), ClaimAgreement::Open);
    }

    #[test]
    fn a_trend_must_go_on_from_value_to_value() {
        let values: Vec<String> = ["a", "b", "c"].map(str::to_owned).to_vec();
        let of = |medians: [Option<f64>; 3], source| {
            Finding::of_trend(&values, medians.to_vec(), "s", &source).agreement
        };
        assert_eq!(of([Some(3.0), Some(2.0), Some(1.0)], SourceSays::Falls), ClaimAgreement::Agrees);
        assert_eq!(of([Some(3.0), Some(2.0), Some(2.0)], SourceSays::Falls), ClaimAgreement::Differs);
        assert_eq!(of([Some(3.0), Some(2.0), Some(1.0)], SourceSays::Rises), ClaimAgreement::Differs);
        assert_eq!(of([Some(3.0), None, Some(1.0)], SourceSays::Falls), ClaimAgreement::Open);
    }
}
