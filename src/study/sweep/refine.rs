//! Which members of a study a map asks for next, so that few are run where it is sure.
//!
//! The inputs are cut into boxes, and every box has a confidence sequence for its share: bounds that hold at all times
//! together with 95 %, however often one looks and whenever one stops. An interval for a fixed number of members does not:
//! watched while it grows, it will one day leave out the truth. With a uniform prior on the share p,
//!
//!   M(p) = B(k + 1, n − k + 1) / (pᵏ (1 − p)ⁿ⁻ᵏ)
//!
//! after k of n is a martingale that starts at 1 where p is true, and reaches 20 with a chance of at most 1 / 20 ever
//! (Ville; Robbins 1970): the sequence is all p at which it is below. That members go where the sequences are widest changes
//! nothing of it, since within a box they come in the study's own order.
//!
//! A member is still its number in the study: what is chosen is only which of them are run.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::function::beta::ln_beta;

use super::map::{MapInput, box_of};
use crate::study::Z;

/// 1 − the chance that a sequence ever leaves out the truth.
const LEVEL: f64 = 0.95;

/// Halvings by which an end of a sequence is found.
const HALVINGS: u32 = 50;

/// The 95 % confidence sequence of a share after `came` of `of`.
pub fn sequence(came: f64, of: f64) -> [f64; 2] {
    let least = ln_beta(came + 1.0, of - came + 1.0) + (1.0 - LEVEL).ln();
    // ln M(p) + ln(1/20) at p; a power of zero of nothing is one.
    let times = |count: f64, p: f64| if count > 0.0 { count * p.ln() } else { 0.0 };
    let is_in = |p: f64| least < times(came, p) + times(of - came, 1.0 - p);
    let end = |outside: f64| {
        let (mut inside, mut outside) = (came / of.max(1.0), outside);
        if is_in(outside) {
            return outside;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            *if is_in(middle) { &mut inside } else { &mut outside } = middle;
        }
        outside
    };
    [end(0.0), end(1.0)]
}

/// A box of a refined map.
#[derive(Clone, Debug, Default, PartialEq)]
struct RefinedBox {
    /// The study's members in it, in their order.
    members: Vec<u64>,
    /// How many of them were asked for.
    asked: usize,
    /// How many of these answered.
    of: usize,
    /// For how many of these the outcome came.
    came: usize,
}

impl RefinedBox {
    fn sequence(&self) -> [f64; 2] {
        sequence(self.came as f64, self.of as f64)
    }

    /// Half the width of its sequence were so many `more` of its members to answer as the others did.
    fn half_width(&self, more: usize) -> f64 {
        let (came, of, more) = (self.came as f64, self.of as f64, more as f64);
        let share = (came + 1.0) / (of + 2.0);
        let [low, high] = sequence(if more > 0.0 { came + more * share } else { came }, of + more);
        0.5 * (high - low)
    }
}

/// A map that asks for members round after round.
#[derive(Clone, Debug)]
pub struct Refinement {
    inputs: Vec<MapInput>,
    n_boxes: usize,
    boxes: Vec<RefinedBox>,
    /// The box of each of the study's members.
    number: Vec<usize>,
    n_rounds: usize,
}

/// How a map was refined.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Refined {
    /// Half the width that was asked of the confidence sequence of every box [-].
    pub half_width: f64,
    /// The widest half of a box [-]: more where the study had no more members there.
    pub widest: f64,
    /// Rounds of members.
    pub rounds: usize,
    /// Members that were run.
    pub members: usize,
    /// Members of the whole study.
    pub of_members: usize,
    /// Share over the whole study: of every box as much as it has of the study's members [-].
    pub share: f64,
    /// Its 95 % interval, at the end of the last round [-].
    pub interval_95: [f64; 2],
}

impl Refinement {
    /// One over `inputs` in so many boxes along each, of a study whose members are at `at`, in their order.
    pub fn of(names: &[String], at: &[Vec<f64>], n_boxes: usize) -> Refinement {
        let inputs: Vec<MapInput> = names
            .iter()
            .enumerate()
            .map(|(axis, name)| MapInput::of(name, at.iter().map(|at| at[axis])))
            .collect();
        let mut boxes = vec![RefinedBox::default(); n_boxes.pow(names.len() as u32)];
        let place = |at: &Vec<f64>| {
            let along = inputs.iter().zip(at);
            along.fold(0, |place, (input, value)| place * n_boxes + box_of(input.range, *value, n_boxes))
        };
        let number: Vec<usize> = at.iter().map(place).collect();
        for (member, &place) in number.iter().enumerate() {
            boxes[place].members.push(member as u64);
        }
        Refinement { inputs, n_boxes, boxes, number, n_rounds: 0 }
    }

    /// The inputs, with the ranges of the whole study.
    pub fn inputs(&self) -> &[MapInput] {
        &self.inputs
    }

    /// The members of the next round, at most so many: each goes where the confidence sequence will be widest. None once
    /// all are at most `half_width` to either side, or there are no more where they are wider.
    pub fn next(&mut self, half_width: f64, most: usize) -> Vec<u64> {
        let mut more = vec![0; self.boxes.len()];
        let mut widths: Vec<f64> = self.boxes.iter().map(|one| one.half_width(0)).collect();
        for _ in 0..most {
            let open = |place: &usize| {
                let one: &RefinedBox = &self.boxes[*place];
                one.asked + more[*place] < one.members.len() && widths[*place] > half_width
            };
            // Of equal ones the first.
            let widest =
                (0..self.boxes.len()).rev().filter(open).max_by(|a, b| widths[*a].total_cmp(&widths[*b]));
            let Some(place) = widest else { break };
            more[place] += 1;
            widths[place] = self.boxes[place].half_width(more[place]);
        }
        let mut chosen = BTreeSet::new();
        for (one, more) in self.boxes.iter_mut().zip(more) {
            chosen.extend(&one.members[one.asked..one.asked + more]);
            one.asked += more;
        }
        self.n_rounds += usize::from(!chosen.is_empty());
        chosen.into_iter().collect()
    }

    /// Takes the answer of `member`, who was asked for.
    pub fn answer(&mut self, member: u64, came: bool) {
        let Some(one) = self.number.get(member as usize).map(|&place| &mut self.boxes[place]) else { return };
        one.of += 1;
        one.came += usize::from(came);
    }

    /// The confidence sequence of the box of a map that begins at `from`.
    pub fn sequence_from(&self, from: &[f64]) -> [f64; 2] {
        let along = self.inputs.iter().zip(from);
        let place = along.fold(0, |place, (input, from)| {
            let [low, high] = input.range;
            // The middle of the box is away from what rounding makes of its edges.
            let middle = from + 0.5 * (high - low) / self.n_boxes as f64;
            place * self.n_boxes + box_of(input.range, middle, self.n_boxes)
        });
        self.boxes[place].sequence()
    }

    /// What it came to.
    pub fn refined(&self, half_width: f64) -> Refined {
        let filled = || self.boxes.iter().filter(|one| !one.members.is_empty());
        let all: usize = filled().map(|one| one.members.len()).sum();
        let weight = |one: &RefinedBox| one.members.len() as f64 / all as f64;
        // Two answers more, one of them yes: a box of which all said the same is not sure.
        let share = |one: &RefinedBox| (one.came as f64 + 1.0) / (one.of as f64 + 2.0);
        let variance = |one: &RefinedBox| share(one) * (1.0 - share(one)) / (one.of as f64 + 2.0);
        let told = |one: &RefinedBox| if one.of > 0 { one.came as f64 / one.of as f64 } else { 0.5 };
        let mean: f64 = filled().map(|one| weight(one) * told(one)).sum();
        let either = Z * filled().map(|one| weight(one).powi(2) * variance(one)).sum::<f64>().sqrt();
        Refined {
            half_width,
            widest: filled().map(|one| one.half_width(0)).fold(0.0, f64::max),
            rounds: self.n_rounds,
            members: filled().map(|one| one.asked).sum(),
            of_members: all,
            share: mean,
            interval_95: [mean - either, mean + either].map(|end| end.clamp(0.0, 1.0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_sequence_ends_where_the_martingale_reaches_twenty() {
        for (came, of) in [(0.0, 1.0), (3.0, 10.0), (10.0, 10.0), (40.0, 200.0)] {
            let [low, high] = sequence(came, of);
            let martingale =
                |p: f64| ln_beta(came + 1.0, of - came + 1.0) - came * p.ln() - (of - came) * (1.0 - p).ln();
            for end in [low, high].into_iter().filter(|end| (1e-9..1.0 - 1e-9).contains(end)) {
                assert!((martingale(end) - 20.0_f64.ln()).abs() < 1e-6, "{came} of {of}: {end}");
            }
            assert!(low <= came / of && came / of <= high);
        }
        assert_eq!(sequence(0.0, 0.0), [0.0, 1.0]);
    }

    /// Looked at after every answer, it leaves out the truth in at most 5 % of all histories; the interval for a fixed
    /// number does in far more.
    #[test]
    fn a_sequence_may_be_watched_and_an_interval_may_not() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let (mut left, mut left_by_interval) = (0, 0);
        for _ in 0..400 {
            let (mut came, mut out, mut out_by_interval) = (0, false, false);
            for of in 1..=300 {
                came += usize::from(random.random_bool(0.4));
                let is_out = |[low, high]: [f64; 2]| !(low..=high).contains(&0.4);
                out |= is_out(sequence(came as f64, of as f64));
                out_by_interval |= is_out(crate::study::ensemble::Share::of(came, of).interval_95);
            }
            left += usize::from(out);
            left_by_interval += usize::from(out_by_interval);
        }
        // Of 1000 histories drawn by another program: 3 and 30 %.
        assert!(left <= 20 && left_by_interval > 2 * left.max(10), "{left} and {left_by_interval} of 400");
    }

    fn points(n: u64) -> Vec<Vec<f64>> {
        (0..n)
            .map(|point| (0..2).map(|axis| f64::from(sobol_burley::sample(point as u32, axis, 0))).collect())
            .collect()
    }

    /// A share that falls from 1 to 0 within a tenth of the first input is known everywhere with a third of all members, as many
    /// as asked for by any path to it.
    #[test]
    fn members_go_where_the_map_is_least_certain() {
        let at = points(4096);
        let names = ["a", "b"].map(str::to_owned);
        let mut refinement = Refinement::of(&names, &at, 4);
        let mut asked = BTreeSet::new();
        loop {
            let chosen = refinement.next(0.15, 64);
            if chosen.is_empty() {
                break;
            }
            for member in chosen {
                assert!(asked.insert(member), "{member} was asked for twice");
                let [a, b] = [at[member as usize][0], at[member as usize][1]];
                // 0.5 by a coin of its own where neither is sure.
                let came = if (a - 0.4).abs() < 0.1 { (1e4 * b).fract() < 0.5 } else { a < 0.4 };
                refinement.answer(member, came);
            }
        }
        let refined = refinement.refined(0.15);
        assert_eq!(refined.members, asked.len());
        assert!(refined.widest <= 0.15 && refined.members < 1000, "{refined:?}");
        assert!((refined.interval_95[0]..=refined.interval_95[1]).contains(&0.4), "{refined:?}");
        // Where it is a coin: a from 0.25 to 0.5; a quarter of the boxes has more members than the rest on average.
        let in_doubt = asked.iter().filter(|member| (0.25..0.5).contains(&at[**member as usize][0])).count();
        assert!(in_doubt * 3 > asked.len(), "{in_doubt} of {}", asked.len());
        for from in [[0.0, 0.0], [0.25, 0.5]] {
            let [low, high] = refinement.sequence_from(&from);
            assert!(high - low <= 0.3);
        }
    }

    #[test]
    fn a_box_without_members_left_ends_it() {
        let mut refinement = Refinement::of(
            &["a".to_owned()],
            &points(10).into_iter().map(|at| vec![at[0]]).collect::<Vec<_>>(),
            2,
        );
        assert_eq!(refinement.next(0.01, 100).len(), 10);
        assert!(refinement.next(0.01, 100).is_empty());
        assert!(refinement.refined(0.01).widest > 0.01);
    }
}
