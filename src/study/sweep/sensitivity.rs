//! What matters: which input of a study the spread of a number comes from.
//!
//! Of a design of blocks (`saltelli`): A and B are independent points, A with its input i from B is Aᵢ, f what came there.
//! By Jansen (1999), over all N blocks and with the variance V of f over all A and B,
//!
//! total Tᵢ = Σ (f(A) − f(Aᵢ))² / (2 N V),  alone Sᵢ = 1 − Σ (f(B) − f(Aᵢ))² / (2 N V).
//!
//! Sᵢ is the share of the variance that would go if input i were known; Tᵢ the share that would stay if all others were:
//! what i does alone and together with others. Inputs that do not work together have Σ T = 1. Intervals are the middle 95 %
//! of what the same sums give for blocks drawn with replacement. A chaotic run adds to every Tᵢ what it makes of the
//! smallest change of i.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::provenance::Provenance;

/// Times that blocks are drawn with replacement.
const RESAMPLES: usize = 1000;

/// Fewest blocks of which something is said.
const FEWEST: usize = 8;

/// A share of the variance [-], with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VarianceShare {
    /// The estimate [-]; by chance it may be below 0 or above 1.
    pub value: f64,
    /// 95 % interval [-].
    pub interval_95: [f64; 2],
}

/// How much of a number's variance comes from one input.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct InputShares {
    /// From it alone.
    pub alone: VarianceShare,
    /// From it alone and together with others.
    pub total: VarianceShare,
}

/// Where the spread of a number comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OutputShares {
    /// Blocks all of whose members have the number.
    pub blocks: usize,
    /// Mean over the first two points of the blocks.
    pub mean: f64,
    /// Standard deviation over these.
    pub deviation: f64,
    /// For each input of the study, in its order.
    pub inputs: Vec<InputShares>,
}

/// `sensitivity.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Sensitivity {
    /// What the study asks.
    pub title: String,
    /// Its inputs, by path.
    pub inputs: Vec<String>,
    /// Blocks that are finished.
    pub blocks: usize,
    /// What was asked of members first.
    pub outcome: String,
    /// Where its spread comes from; absent where all members agree, or fewer than eight blocks tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of_outcome: Option<OutputShares>,
    /// The same of every number of the summary.
    pub scalars: BTreeMap<String, OutputShares>,
    /// What made it.
    pub provenance: Provenance,
}

impl OutputShares {
    /// The shares of `blocks`, each of which has what came at A, at B, and at A with one input after the other from B.
    /// None where there are fewer than eight blocks, or nothing varies.
    pub fn of(blocks: &[Vec<f64>], seed: u64) -> Option<OutputShares> {
        let n_inputs = blocks.first()?.len().checked_sub(2)?;
        let all: Vec<&[f64]> = blocks.iter().map(Vec::as_slice).collect();
        let (mean, variance) = spread(&all);
        // What is below rounding is no spread.
        if blocks.len() < FEWEST || variance <= (1e-12 * mean).powi(2) {
            return None;
        }
        let found = shares(&all, n_inputs);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut resampled: Vec<Vec<f64>> = vec![Vec::with_capacity(RESAMPLES); 2 * n_inputs];
        for _ in 0..RESAMPLES {
            let drawn: Vec<&[f64]> = all.iter().map(|_| all[random.random_range(0..all.len())]).collect();
            let values = shares(&drawn, n_inputs);
            let sound = values.iter().all(|value| value.is_finite());
            // Of blocks that are all alike nothing can be said.
            for (list, value) in resampled.iter_mut().zip(values).filter(|_| sound) {
                list.push(value);
            }
        }
        let share = |number: usize| {
            let mut list = resampled[number].clone();
            list.sort_by(f64::total_cmp);
            let at = |p: f64| list.get((p * list.len() as f64) as usize).copied().unwrap_or(found[number]);
            VarianceShare { value: found[number], interval_95: [at(0.025), at(0.975)] }
        };
        let inputs = (0..n_inputs).map(|i| InputShares { alone: share(2 * i), total: share(2 * i + 1) });
        Some(OutputShares {
            blocks: blocks.len(),
            mean,
            deviation: variance.sqrt(),
            inputs: inputs.collect(),
        })
    }
}

/// Mean and variance over the first two points of all blocks.
fn spread(blocks: &[&[f64]]) -> (f64, f64) {
    let n = 2.0 * blocks.len() as f64;
    let values = || blocks.iter().flat_map(|block| &block[..2]);
    let mean = values().sum::<f64>() / n;
    (mean, values().map(|value| (value - mean).powi(2)).sum::<f64>() / n)
}

/// Sᵢ and Tᵢ of one input after the other.
fn shares(blocks: &[&[f64]], n_inputs: usize) -> Vec<f64> {
    let (_, variance) = spread(blocks);
    let scale = 2.0 * blocks.len() as f64 * variance;
    let apart = |one: usize, other: usize| {
        blocks.iter().map(|block| (block[one] - block[other]).powi(2)).sum::<f64>() / scale
    };
    (2..n_inputs + 2).flat_map(|i| [1.0 - apart(1, i), apart(0, i)]).collect()
}

impl Sensitivity {
    /// Of members whose blocks have `inputs.len() + 2` points with `copies` members each: `outcome` and every one of
    /// `scalars` has a number for each member that is there. Copies of a block count as blocks.
    pub fn of(
        title: &str,
        inputs: Vec<String>,
        copies: u64,
        seed: u64,
        outcome: (String, BTreeMap<u64, f64>),
        scalars: BTreeMap<String, BTreeMap<u64, f64>>,
    ) -> Sensitivity {
        let in_block = inputs.len() as u64 + 2;
        let blocks = |values: &BTreeMap<u64, f64>| -> Vec<Vec<f64>> {
            let mut found: BTreeMap<(u64, u64), Vec<f64>> = BTreeMap::new();
            // In the order of the members, hence of the points of a block.
            for (member, value) in values {
                let (point, copy) = (member / copies, member % copies);
                found.entry((point / in_block, copy)).or_default().push(*value);
            }
            found.into_values().filter(|block| block.len() as u64 == in_block).collect()
        };
        let of = |values: &BTreeMap<u64, f64>| OutputShares::of(&blocks(values), seed);
        let n_blocks = scalars.values().map(|values| blocks(values).len()).max().unwrap_or(0);
        let scalars: Vec<(String, Option<OutputShares>)> =
            scalars.into_par_iter().map(|(name, values)| (name, of(&values))).collect();
        Sensitivity {
            title: title.to_owned(),
            inputs,
            blocks: n_blocks,
            of_outcome: of(&outcome.1),
            outcome: outcome.0,
            scalars: scalars.into_iter().filter_map(|(name, shares)| Some((name, shares?))).collect(),
            provenance: Provenance::here(),
        }
    }
}
