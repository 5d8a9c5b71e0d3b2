//! Whether two ensembles hold alike for long: the log-rank test, by permutation.
//!
//! Each member has a score that only the pooled ensembles decide (Peto and Peto 1972),
//!
//! aᵢ = δᵢ − Σ dⱼ / nⱼ over all tⱼ ≤ tᵢ,
//!
//! with δ = 1 for one that was lost at tᵢ, and d lost of n under watch at tⱼ. Their sum over one of the two ensembles
//! is losses observed less losses expected, the numerator of the log-rank test. How large it is by chance is
//! found by dealing the same scores out anew, which needs no large numbers: p = (1 + b) / (1 + N), where b of N deals
//! are at least as far from 0 (Phipson and Smyth 2010: never 0, never too small). That asks what the question
//! says: members are under watch for equally long in both, as those of one study of cost are.
//!
//! One that was never held counts as lost at once: a setting that never holds and one that always does differ.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::survival::Watched;
use crate::metrics::verdict::Capture;

/// Deals of the scores.
const DEALS: usize = 9999;

/// Times that differ by less are one [s].
const EQUAL: f64 = 1e-9;

/// Chance of a word that is wrong, over all comparisons of a study.
pub const LEVEL: f64 = 0.05;

/// What the test says of two ensembles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LogRank {
    /// Members of the one and of the other.
    pub members: [usize; 2],
    /// Losses of the one over those expected, were both alike.
    pub excess: f64,
    /// Chance of a difference at least as large, were both alike.
    pub p: f64,
    /// The same for all comparisons of the study together (Holm 1979).
    pub adjusted_p: f64,
}

impl LogRank {
    /// The test of two ensembles, each member with the end of its run [s]; `seed` deals the scores.
    pub fn of(one: &[(Capture, f64)], other: &[(Capture, f64)], seed: u64) -> LogRank {
        let watched = |(capture, end): &(Capture, f64)| {
            let one = Watched::of(capture, *end).unwrap_or(Watched { time: 0.0, lost: true });
            // Members lost at the same frame since they were held are lost at the same time, whatever rounding made of it.
            Watched { time: (one.time / EQUAL).round() * EQUAL, ..one }
        };
        LogRank::of_watched(&one.iter().chain(other).map(watched).collect::<Vec<_>>(), one.len(), seed)
    }

    /// The test of the first `n_one` of `all` against the rest.
    fn of_watched(all: &[Watched], n_one: usize, seed: u64) -> LogRank {
        let mut scores = scores(all);
        let excess: f64 = scores[..n_one].iter().sum();
        // Equal deals are summed up in another order.
        let as_far = excess.abs() * (1.0 - 1e-9) - 1e-12;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let farther = (0..DEALS).filter(|_| {
            scores.shuffle(&mut random);
            scores[..n_one].iter().sum::<f64>().abs() >= as_far
        });
        let p = (1 + farther.count()) as f64 / (1 + DEALS) as f64;
        LogRank { members: [n_one, all.len() - n_one], excess, p, adjusted_p: p }
    }

    /// Whether the two are told apart, with all comparisons of the study in mind.
    pub fn told_apart(&self) -> bool {
        self.adjusted_p <= LEVEL
    }

    /// Whether so many members could be told apart at all, in a study of so many comparisons: two deals, that of
    /// all losses to the one and that of all to the other, are the most extreme.
    pub fn can_tell(&self, comparisons: usize) -> bool {
        let [n, m] = self.members;
        let deals = (1..=n).fold(1.0, |deals, i| deals * (m + i) as f64 / i as f64);
        (2.0 / deals).max(1.0 / (1 + DEALS) as f64) * comparisons as f64 <= LEVEL
    }
}

/// Score of each member: its loss less the hazard that it was under.
fn scores(all: &[Watched]) -> Vec<f64> {
    let mut times: Vec<f64> = all.iter().filter(|one| one.lost).map(|one| one.time).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let share = |time: &f64| {
        let lost = all.iter().filter(|one| one.lost && one.time == *time).count();
        lost as f64 / all.iter().filter(|one| one.time >= *time).count() as f64
    };
    let hazards: Vec<f64> = times.iter().map(share).collect();
    let under =
        |one: &Watched| hazards[..times.partition_point(|time| *time <= one.time)].iter().sum::<f64>();
    all.iter().map(|one| f64::from(u8::from(one.lost)) - under(one)).collect()
}

/// Adjusts the p of all comparisons of a study for their number: Holm's rule, the smallest times their number, the next
/// times one less, never below the one before.
pub fn adjust(tests: &mut [&mut LogRank]) {
    tests.sort_by(|a, b| a.p.total_cmp(&b.p));
    let (n, mut before) = (tests.len(), 0.0_f64);
    for (place, test) in tests.iter_mut().enumerate() {
        before = before.max((n - place) as f64 * test.p).min(1.0);
        test.adjusted_p = before;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lost(times: &[f64]) -> Vec<Watched> {
        times.iter().map(|&time| Watched { time, lost: true }).collect()
    }

    /// Remission of Freireich et al. (1963), the textbooks' example: 9 observed and 19.25 expected under 6-MP, chi square
    /// 16.8 of one degree of freedom, so p = 4e-5.
    #[test]
    fn the_textbook_example_is_met() {
        let mut all = lost(&[6.0, 6.0, 6.0, 7.0, 10.0, 13.0, 16.0, 22.0, 23.0]);
        let left = [6.0, 9.0, 10.0, 11.0, 17.0, 19.0, 20.0, 25.0, 32.0, 32.0, 34.0, 35.0];
        all.extend(left.map(|time| Watched { time, lost: false }));
        all.extend(lost(&[1.0, 1.0, 2.0, 2.0, 3.0, 4.0, 4.0, 5.0, 5.0, 8.0, 8.0, 8.0, 8.0]));
        all.extend(lost(&[11.0, 11.0, 12.0, 12.0, 15.0, 17.0, 22.0, 23.0]));
        let found = LogRank::of_watched(&all, 21, 1);
        assert!((found.excess + 10.25).abs() < 5e-3, "{found:?}");
        assert!(found.p <= 5e-4 && found.told_apart(), "{found:?}");
        // The same people, dealt out by their number.
        let (even, odd): (Vec<_>, Vec<_>) = all.iter().enumerate().partition(|(number, _)| number % 2 == 0);
        let dealt: Vec<Watched> = even.into_iter().chain(odd).map(|(_, one)| *one).collect();
        let found = LogRank::of_watched(&dealt, 21, 1);
        assert!(found.p > 0.2, "{found:?}");
    }

    /// Two and two, all lost one after another: 2 of the 6 deals are as far.
    #[test]
    fn the_chance_is_that_of_all_deals() {
        let found = LogRank::of_watched(&lost(&[1.0, 2.0, 3.0, 4.0]), 2, 7);
        assert!((found.excess - 7.0 / 6.0).abs() < 1e-12 && (found.p - 1.0 / 3.0).abs() < 0.02, "{found:?}");
        assert!(!found.can_tell(1));
        let alike = LogRank::of_watched(&lost(&[1.0; 12]), 6, 7);
        assert!(alike.p == 1.0 && alike.can_tell(20) && !alike.can_tell(30), "{alike:?}");
    }

    #[test]
    fn many_comparisons_are_adjusted_for() {
        let of = |p: f64| LogRank { members: [6, 6], excess: 0.0, p, adjusted_p: p };
        let mut all = [of(0.04), of(0.01), of(0.03), of(0.5)];
        adjust(&mut all.each_mut());
        let found = all.map(|test| test.adjusted_p);
        let wanted = [0.09, 0.04, 0.09, 0.5];
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    }
}
