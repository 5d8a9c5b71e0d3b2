//! Which values of a study's parameters make an outcome likeliest, over all that is uncertain in its scene.
//!
//! The study is run in rounds, each in a box of the parameters. After each, a logistic regression with all terms up to second
//! order is fitted to the members in the box, those of earlier rounds too; the next box, half as wide, lies about the point
//! where the lower end of the regression's 95 % interval is highest (response surfaces, after Box and Wilson 1951). No point
//! is run again and again for a mean: the regression is what averages, so a round of members that answer yes or no tells as
//! much as they are many.
//!
//! A search looks for luck too. What it found is confirmed by a fresh sample, beside the scene as it is, member by member with
//! the same draws: the gain is a mean of differences in pairs.

use nalgebra::Vector2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::Sweep;
use super::logistic::{LogisticFit, Probability, RIDGE};
use super::map::{LETTERS, MapInput, MapSample, features};
use super::spec::{Design, SweepSpec};
use crate::parameter::spec::Varied;
use crate::problems::Problems;
use crate::provenance::Provenance;
use crate::scene::pointer;
use crate::study::Z;
use crate::study::ensemble::Share;

/// Points of a box among which the best is looked for.
const CANDIDATES: u32 = 4096;

/// A box's width over that of the one before.
const SHRINK: f64 = 0.5;

/// A parameter that is looked for.
#[derive(Clone, Debug, PartialEq)]
struct SearchAxis {
    path: String,
    /// Whether its logarithm is what counts.
    is_log: bool,
    /// What the scene says.
    scene: f64,
}

impl SearchAxis {
    fn scaled(&self, value: f64) -> f64 {
        if self.is_log { value.ln() } else { value }
    }

    fn value(&self, scaled: f64) -> f64 {
        if self.is_log { scaled.exp() } else { scaled }
    }
}

/// Where members of a round lie: least and largest of each parameter, as the search scales them.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchBox(Vec<Vector2<f64>>);

/// A search for the best values of a study's parameters.
pub struct Search {
    axes: Vec<SearchAxis>,
    whole: SearchBox,
    seed: u64,
}

/// A round of a search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SearchRound {
    /// Least and largest value of each parameter.
    pub within: Vec<[f64; 2]>,
    /// Share of its members for whom the outcome came; undecided and failed ones are none.
    pub came: Share,
    /// The best point of the regression.
    pub best: Vec<f64>,
    /// What the regression says of it.
    pub probability: Probability,
}

/// A parameter, and what was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BestValue {
    /// Its path.
    pub path: String,
    /// Where it was looked for.
    pub within: [f64; 2],
    /// What the scene says.
    pub scene: f64,
    /// What is best.
    pub best: f64,
}

/// How much better the best point is than the scene as it is, in pairs of members with the same draws.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Gain {
    /// Pairs in which the outcome came at the best point alone.
    pub better: usize,
    /// Pairs in which it came in the scene as it is alone.
    pub worse: usize,
    /// Difference of the two shares [-].
    pub value: f64,
    /// Its 95 % interval, of proportions in pairs (Agresti and Min 2005) [-].
    pub interval_95: [f64; 2],
}

/// `optimised.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Optimised {
    /// What the study asks.
    pub title: String,
    /// Of what the probability is made large.
    pub outcome: String,
    /// The parameters.
    pub parameters: Vec<BestValue>,
    /// The rounds of the search.
    pub rounds: Vec<SearchRound>,
    /// Share of fresh members of the scene as it is for whom the outcome came.
    pub of_scene: Share,
    /// The same at the best point.
    pub of_best: Share,
    /// How much more that is.
    pub gain: Gain,
    /// What made it.
    pub provenance: Provenance,
}

impl Search {
    /// A search for the parameters of `study`.
    ///
    /// # Errors
    /// A design that is no Sobol sequence; no parameter, too many, or one that is no number between two.
    pub fn of(study: &Sweep) -> Result<Search, Problems> {
        let (spec, scene) = (&study.spec, &study.source.json);
        let mut problems = Problems::new(study.name());
        if !matches!(spec.design, Design::Sobol { .. }) {
            problems.add("design.kind", "a design that no search can begin with", "\"sobol\"");
        }
        let most = LETTERS.len();
        if !(1..=most).contains(&spec.parameters.len()) {
            problems.add("parameters", spec.parameters.len(), format!("one to {most}: what is looked for"));
        }
        let (mut axes, mut whole) = (Vec::new(), Vec::new());
        for (number, varied) in spec.parameters.iter().enumerate() {
            let ends = match (varied.uniform, varied.log_uniform) {
                (Some(ends), _) => Some((false, ends)),
                (_, Some(ends)) => Some((true, ends.map(|end| end.0))),
                _ => None,
            };
            let own = scene.pointer(&pointer(&varied.path)).and_then(Value::as_f64);
            let (Some((is_log, ends)), Some(scene)) = (ends, own) else {
                let allowed = "\"uniform\" or \"log_uniform\" of a number that the scene has; what is uncertain stands in \
                               the scene's \"uncertain\"";
                problems.add(format!("parameters[{number}]"), format!("{:?}", varied.path), allowed);
                continue;
            };
            let axis = SearchAxis { path: varied.path.clone(), is_log, scene };
            whole.push(Vector2::from(ends.map(|end| axis.scaled(end))));
            axes.push(axis);
        }
        problems.into_result(Some(Search { axes, whole: SearchBox(whole), seed: spec.seed }))
    }

    /// Where the search begins.
    pub fn whole(&self) -> &SearchBox {
        &self.whole
    }

    /// Columns of a round's table that say where a member is.
    pub fn columns(&self) -> Vec<String> {
        self.axes.iter().map(|axis| format!("{}{}", super::INPUT, axis.path)).collect()
    }

    /// Makes of the study `spec` that of round `number` (from 0), with members `within` a box.
    pub fn round(&self, spec: &mut SweepSpec, number: u64, within: &SearchBox) {
        spec.seed = self.seed.wrapping_add(number);
        for ((varied, axis), ends) in spec.parameters.iter_mut().zip(&self.axes).zip(&within.0) {
            *varied = Varied { path: axis.path.clone(), ..Varied::default() };
            let ends = [ends.x, ends.y].map(|end| axis.value(end));
            match axis.is_log {
                true => varied.log_uniform = Some(ends.map(crate::quantity::Positive)),
                false => varied.uniform = Some(ends),
            }
        }
    }

    /// Makes of the study `spec` that of so many fresh `members` at `at`; none: of the scene as it is.
    pub fn confirmation(&self, spec: &mut SweepSpec, n_rounds: u64, members: u64, at: Option<&[f64]>) {
        spec.seed = self.seed.wrapping_add(n_rounds);
        spec.design = Design::Grid {};
        spec.members = members;
        for (number, (varied, axis)) in spec.parameters.iter_mut().zip(&self.axes).enumerate() {
            let value = at.map_or(axis.scene, |at| at[number]);
            *varied =
                Varied { path: axis.path.clone(), values: Some(vec![json!(value)]), ..Varied::default() };
        }
    }

    /// What the members `samples` of all rounds tell of the box `within`, of which the last round was; and the box of the
    /// next. None where the numbers are none.
    pub fn told(
        &self,
        within: &SearchBox,
        samples: &[MapSample],
    ) -> Option<(Vec<f64>, Probability, SearchBox)> {
        let input = |(axis, ends): (&SearchAxis, &Vector2<f64>)| MapInput {
            name: axis.path.clone(),
            range: [ends.x, ends.y],
        };
        let inputs: Vec<MapInput> = self.axes.iter().zip(&within.0).map(input).collect();
        let scaled = |sample: &MapSample| -> Vec<f64> {
            self.axes.iter().zip(&sample.at).map(|(axis, value)| axis.scaled(*value)).collect()
        };
        let rows = samples.iter().map(|sample| (features(&inputs, &scaled(sample)), sample.came));
        // A feature from −1 to 1 is in the box, its edges with what rounding makes of them.
        let is_inside = |row: &Vec<f64>| row[1..=inputs.len()].iter().all(|u| u.abs() <= 1.0 + 1e-9);
        let (rows, came): (Vec<_>, Vec<_>) = rows.filter(|(row, _)| is_inside(row)).unzip();
        let fit = LogisticFit::of(&rows, &came, RIDGE)?;
        let candidate = |number: u32| -> Vec<f64> {
            let at = |(axis, ends): (usize, &Vector2<f64>)| {
                ends.x + f64::from(sobol_burley::sample(number, axis as u32, 0)) * (ends.y - ends.x)
            };
            within.0.iter().enumerate().map(at).collect()
        };
        let lower = |at: &Vec<f64>| fit.at(&features(&inputs, at)).interval_95[0];
        let all = (0..CANDIDATES).map(candidate).map(|at| (lower(&at), at));
        let (_, best) = all.max_by(|one, other| one.0.total_cmp(&other.0))?;
        let probability = fit.at(&features(&inputs, &best));
        let next = self.about(&best, within);
        let best = self.axes.iter().zip(best).map(|(axis, at)| axis.value(at)).collect();
        Some((best, probability, next))
    }

    /// The box about `best`, narrower than `within` and nowhere outside of the whole.
    fn about(&self, best: &[f64], within: &SearchBox) -> SearchBox {
        let side = |((at, ends), whole): ((&f64, &Vector2<f64>), &Vector2<f64>)| {
            let width = SHRINK * (ends.y - ends.x);
            let from = (at - 0.5 * width).clamp(whole.x, (whole.y - width).max(whole.x));
            Vector2::new(from, (from + width).min(whole.y))
        };
        SearchBox(best.iter().zip(&within.0).zip(&self.whole.0).map(side).collect())
    }

    /// Least and largest value of each parameter in a box.
    pub fn ends(&self, of: &SearchBox) -> Vec<[f64; 2]> {
        let ends = self.axes.iter().zip(&of.0);
        ends.map(|(axis, ends)| [ends.x, ends.y].map(|end| axis.value(end))).collect()
    }

    /// Each parameter with what is `best`.
    pub fn values(&self, best: &[f64]) -> Vec<BestValue> {
        let all = self.axes.iter().zip(self.ends(&self.whole)).zip(best);
        all.map(|((axis, within), &best)| BestValue {
            path: axis.path.clone(),
            within,
            scene: axis.scene,
            best,
        })
        .collect()
    }
}

impl Gain {
    /// That of pairs of answers: in the scene as it is, and at the best point.
    pub fn of(pairs: &[(bool, bool)]) -> Gain {
        let count = |of: (bool, bool)| pairs.iter().filter(|pair| **pair == of).count();
        let (better, worse) = (count((false, true)), count((true, false)));
        // A half more of each of the four answers that a pair may give keeps the interval honest where pairs are few.
        let [up, down] = [better, worse].map(|count| count as f64 + 0.5);
        let n = pairs.len() as f64 + 2.0;
        let middle = (up - down) / n;
        let either = Z * ((up + down - (up - down).powi(2) / n).sqrt() / n);
        let value = (better as f64 - worse as f64) / pairs.len() as f64;
        let interval_95 = [middle - either, middle + either].map(|end| end.clamp(-1.0, 1.0));
        Gain { better, worse, value, interval_95 }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn search() -> Search {
        let axis = |path: &str, is_log| SearchAxis { path: path.to_owned(), is_log, scene: 1.0 };
        let axes = vec![axis("a", false), axis("b", true)];
        let whole = SearchBox(vec![Vector2::new(0.0, 4.0), Vector2::new(0.01_f64.ln(), 1.0_f64.ln())]);
        Search { axes, whole, seed: 3 }
    }

    /// Members that answer yes with a probability that is highest, 90 %, at a = 1, b = 0.1.
    fn answered(within: &SearchBox, seed: u64) -> Vec<MapSample> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let member = |point: u64| {
            let [a, b] = [0, 1]
                .map(|axis| within.0[axis].x + rng.random::<f64>() * (within.0[axis].y - within.0[axis].x));
            let logit = 2.2 - (a - 1.0).powi(2) - (b - 0.1_f64.ln()).powi(2);
            MapSample {
                point,
                at: vec![a, b.exp()],
                came: rng.random::<f64>() < 1.0 / (1.0 + (-logit).exp()),
            }
        };
        (0..100).map(member).collect()
    }

    #[test]
    fn a_search_ends_near_what_is_best_from_any_seed() {
        let search = search();
        let mut off = Vec::new();
        for seed in 0..20 {
            let (mut within, mut samples, mut found) = (search.whole().clone(), Vec::new(), Vec::new());
            for round in 0..4 {
                samples.extend(answered(&within, 100 * seed + round));
                let (best, probability, next) = search.told(&within, &samples).unwrap();
                assert!(probability.interval_95[0] <= probability.value);
                for (ends, whole) in next.0.iter().zip(&search.whole.0) {
                    assert!(ends.x >= whole.x - 1e-12 && ends.y <= whole.y + 1e-12, "{next:?}");
                }
                (within, found) = (next, best);
            }
            off.push(((found[0] - 1.0).powi(2) + (found[1].ln() - 0.1_f64.ln()).powi(2)).sqrt());
        }
        off.sort_by(f64::total_cmp);
        // Anywhere at random is 2 away; half of the probability is lost at 1.5.
        assert!(off[10] < 0.6 && off[18] < 1.2, "{off:?}");
    }

    #[test]
    fn a_gain_is_a_mean_of_differences_in_pairs() {
        let pairs = [vec![(false, true); 30], vec![(true, false); 10], vec![(true, true); 60]].concat();
        let gain = Gain::of(&pairs);
        assert_eq!([gain.better, gain.worse], [30, 10]);
        assert!((gain.value - 0.2).abs() < 1e-12);
        // (30.5 - 10.5) / 102 = 0.196 ± 1.96 sqrt(41 - 400 / 102) / 102 = 0.117.
        let [low, high] = gain.interval_95;
        assert!((low - 0.0791).abs() < 2e-4 && (high - 0.3131).abs() < 2e-4, "{gain:?}");
        let few = Gain::of(&[(true, false), (true, false), (true, true), (true, true)]);
        assert!(few.interval_95[1] > 0.0, "two of four may be chance: {few:?}");
    }
}
