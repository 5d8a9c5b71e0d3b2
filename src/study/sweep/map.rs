//! The probability that a capture holds, or of another outcome, over one to four inputs of a sweep.
//!
//! Two answers stand side by side: raw shares in boxes of equal size, each with its exact (Clopper–Pearson) interval,
//! which assume nothing; and a logistic regression with all terms up to second order in the inputs, which is smooth and
//! has narrower intervals, and is right as far as the probability has such a shape. Members of a study that is spread over other
//! inputs too count at whatever those were: the probability is a mean over them. Members that are undecided are left out,
//! and counted: what the shares would be were all of them a yes, or none, is told beside.
//!
//! How far the regression may be believed is tried on points that it has not seen: of five parts each is foretold from
//! the other four. What was foretold stands beside what came, and the Brier score, the mean square of the difference, beside that
//! of the overall share.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::logistic::{LogisticFit, Probability, RIDGE};
use super::outcome::MapOutcome;
use super::refine::{Refined, Refinement};
use super::spec::PublishedOutcome;
use crate::provenance::Provenance;
use crate::study::ensemble::Share;

/// Parts of the points, of which each is foretold from the others.
const PARTS: u64 = 5;

/// Classes of what was foretold.
const CLASSES: usize = 5;

/// A member of a sweep, where it was and how it ended.
#[derive(Clone, Debug, PartialEq)]
pub struct MapSample {
    /// Its point.
    pub point: u64,
    /// Its inputs.
    pub at: Vec<f64>,
    /// Whether the outcome came.
    pub came: bool,
}

/// An input of a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MapInput {
    /// Its column in the table.
    pub name: String,
    /// Least and largest value.
    pub range: [f64; 2],
}

impl MapInput {
    /// The one called `name`, from the least to the largest of `values`.
    pub fn of(name: &str, values: impl Iterator<Item = f64>) -> MapInput {
        let range = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
        MapInput { name: name.to_owned(), range }
    }
}

/// A box of the inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MapBox {
    /// Its lower edges, one for each input.
    pub from: Vec<f64>,
    /// Its upper edges.
    pub to: Vec<f64>,
    /// Share of the members in it for whom the outcome came.
    pub captured: Share,
    /// What the regression says of its middle.
    pub fitted: Probability,
}

/// Members of whom about the same was foretold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Foretold {
    /// Mean of the probabilities that were foretold [-].
    pub probability: f64,
    /// What came.
    pub captured: Share,
}

/// How a capture of others ended, at the inputs of a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PublishedSample {
    /// Where it stands.
    pub source: String,
    /// Its inputs.
    pub at: Vec<f64>,
    /// Whether it was captured, in the words of that source.
    pub captured: bool,
    /// What the regression says of it, of the map's own outcome.
    pub fitted: Probability,
}

/// `map.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CaptureMap {
    /// What the study asks.
    pub title: String,
    /// What it is the probability of.
    pub outcome: String,
    /// The inputs.
    pub inputs: Vec<MapInput>,
    /// Share of all members for whom it came.
    pub captured: Share,
    /// Members whose run ended before it could be told; they are left out.
    pub undecided: usize,
    /// Boxes that have members.
    pub boxes: Vec<MapBox>,
    /// How its members were chosen; absent: all that are there. Intervals of boxes then are confidence sequences.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refined: Option<Refined>,
    /// What others found at points that have all inputs of the map.
    #[serde(default)]
    pub published: Vec<PublishedSample>,
    /// Features of the regression, in u, v, w, x: the inputs from −1 to 1.
    pub terms: Vec<String>,
    /// The regression.
    pub fit: LogisticFit,
    /// What was foretold of points that the regression had not seen.
    pub foretold: Vec<Foretold>,
    /// Mean square of foretold probability minus outcome [-].
    pub brier: f64,
    /// The same of the overall share.
    pub brier_of_share: f64,
    /// What made it.
    pub provenance: Provenance,
}

/// Letters of the inputs from −1 to 1; a map has as many inputs at most.
pub const LETTERS: [&str; 4] = ["u", "v", "w", "x"];

/// What the features of `n_inputs` are, in words: those of [`features`], in their order.
fn terms(n_inputs: usize) -> Vec<String> {
    let letters = &LETTERS[..n_inputs];
    let products = (0..n_inputs).flat_map(|i| {
        (i..n_inputs).map(move |j| match i == j {
            true => format!("{}^2", letters[i]),
            false => format!("{} {}", letters[i], letters[j]),
        })
    });
    std::iter::once("1".to_owned())
        .chain(letters.iter().map(|letter| (*letter).to_owned()))
        .chain(products)
        .collect()
}

/// The features of a point `at` within `inputs`: 1, u, u², or 1, u, v, u², u v, v², and so on.
pub fn features(inputs: &[MapInput], at: &[f64]) -> Vec<f64> {
    let scaled = |(input, value): (&MapInput, &f64)| {
        let [low, high] = input.range;
        if high > low { 2.0 * (value - low) / (high - low) - 1.0 } else { 0.0 }
    };
    let u: Vec<f64> = inputs.iter().zip(at).map(scaled).collect();
    let squares = (0..u.len()).flat_map(|i| (i..u.len()).map(move |j| (i, j)));
    let products: Vec<f64> = squares.map(|(i, j)| u[i] * u[j]).collect();
    std::iter::once(1.0).chain(u).chain(products).collect()
}

impl CaptureMap {
    /// The map of `outcome`, which is undecided for so many, of `samples` over one to four `inputs`, with so many boxes along
    /// each; none without samples.
    pub fn of(
        title: &str,
        (outcome, undecided): (MapOutcome, usize),
        inputs: &[MapInput],
        samples: &[MapSample],
        n_boxes: usize,
    ) -> Option<CaptureMap> {
        let inputs = inputs.to_vec();
        let fit = fitted(&inputs, samples.iter())?;
        let all = share(samples.iter())?;
        let foretold = foretold(&inputs, samples);
        let brier = |probability: &dyn Fn(usize) -> f64| {
            let error = |(i, sample): (usize, &MapSample)| {
                (probability(i) - f64::from(u8::from(sample.came))).powi(2)
            };
            samples.iter().enumerate().map(error).sum::<f64>() / samples.len() as f64
        };
        Some(CaptureMap {
            title: title.to_owned(),
            outcome: outcome.to_string(),
            undecided,
            boxes: boxes(&inputs, samples.iter(), n_boxes, |at| fit.at(&features(&inputs, at))),
            refined: None,
            published: Vec::new(),
            terms: terms(inputs.len()),
            fit,
            brier: brier(&|i| foretold[i]),
            brier_of_share: brier(&|_| all.share),
            foretold: classes(samples, &foretold),
            captured: all,
            inputs,
            provenance: Provenance::here(),
        })
    }

    /// The same map of members that were asked for by `refinement`: shares of boxes have their confidence sequences.
    pub fn refined(mut self, refinement: &Refinement, half_width: f64) -> CaptureMap {
        for one in &mut self.boxes {
            one.captured.interval_95 = refinement.sequence_from(&one.from);
        }
        self.refined = Some(refinement.refined(half_width));
        self
    }

    /// The same map with what others found.
    pub fn beside(mut self, published: &[PublishedOutcome]) -> CaptureMap {
        let sample = |one: &PublishedOutcome| {
            let at: Option<Vec<f64>> =
                self.inputs.iter().map(|input| one.at.get(&input.name).copied()).collect();
            at.map(|at| PublishedSample {
                source: one.source.clone(),
                captured: one.captured,
                fitted: self.at(&at),
                at,
            })
        };
        self.published = published.iter().filter_map(sample).collect();
        self
    }

    /// What the regression says of the point `at`.
    pub fn at(&self, at: &[f64]) -> Probability {
        self.fit.at(&features(&self.inputs, at))
    }

    /// What stands for `undecided` members: the share were none of them a yes, and were all.
    pub fn bounds(&self) -> [f64; 2] {
        let (came, all) = (self.captured.captured as f64, (self.captured.of + self.undecided) as f64);
        [came / all, (came + self.undecided as f64) / all]
    }

    /// Boxes over the first two inputs, of those of `samples` that are near `at` in all others.
    pub fn boxes_of_slice<'a>(
        &self,
        samples: impl Iterator<Item = &'a MapSample>,
        others: &[f64],
        n_boxes: usize,
    ) -> Vec<MapBox> {
        boxes(&self.inputs[..2], samples, n_boxes, |at| self.at(&[at, others].concat()))
    }
}

fn fitted<'a>(inputs: &[MapInput], samples: impl Iterator<Item = &'a MapSample>) -> Option<LogisticFit> {
    let (rows, yes): (Vec<_>, Vec<_>) =
        samples.map(|sample| (features(inputs, &sample.at), sample.came)).unzip();
    LogisticFit::of(&rows, &yes, RIDGE)
}

fn share<'a>(samples: impl Iterator<Item = &'a MapSample>) -> Option<Share> {
    let [captured, of] = samples.fold([0, 0], |[yes, all], sample| [yes + usize::from(sample.came), all + 1]);
    (of > 0).then(|| Share::of(captured, of))
}

/// The box of `value` among `n_boxes` within `range`; the largest value is in the last.
pub(super) fn box_of(range: [f64; 2], value: f64, n_boxes: usize) -> usize {
    let [low, high] = range;
    let share = if high > low { (value - low) / (high - low) } else { 0.0 };
    ((share * n_boxes as f64) as usize).min(n_boxes - 1)
}

fn boxes<'a>(
    inputs: &[MapInput],
    samples: impl Iterator<Item = &'a MapSample>,
    n_boxes: usize,
    fitted: impl Fn(&[f64]) -> Probability,
) -> Vec<MapBox> {
    let number = |sample: &MapSample| -> Vec<usize> {
        inputs.iter().zip(&sample.at).map(|(input, value)| box_of(input.range, *value, n_boxes)).collect()
    };
    let mut members: std::collections::BTreeMap<Vec<usize>, Vec<&MapSample>> = Default::default();
    for sample in samples {
        members.entry(number(sample)).or_default().push(sample);
    }
    let edge = |numbers: &[usize], shift: f64| -> Vec<f64> {
        let edge = |(input, number): (&MapInput, &usize)| {
            let [low, high] = input.range;
            low + (*number as f64 + shift) / n_boxes as f64 * (high - low)
        };
        inputs.iter().zip(numbers).map(edge).collect()
    };
    let one = |(numbers, samples): (&Vec<usize>, &Vec<&MapSample>)| {
        Some(MapBox {
            from: edge(numbers, 0.0),
            to: edge(numbers, 1.0),
            captured: share(samples.iter().copied())?,
            fitted: fitted(&edge(numbers, 0.5)),
        })
    };
    members.iter().filter_map(one).collect()
}

/// What is foretold of each sample from the parts that its point is not in.
fn foretold(inputs: &[MapInput], samples: &[MapSample]) -> Vec<f64> {
    let others = |part: u64| samples.iter().filter(move |sample| sample.point % PARTS != part);
    let fits: Vec<Option<LogisticFit>> = (0..PARTS).map(|part| fitted(inputs, others(part))).collect();
    let one = |sample: &MapSample| {
        let fit = fits[(sample.point % PARTS) as usize].as_ref();
        // Of a single point there are no others.
        fit.map_or(0.5, |fit| fit.at(&features(inputs, &sample.at)).value)
    };
    samples.iter().map(one).collect()
}

fn classes(samples: &[MapSample], foretold: &[f64]) -> Vec<Foretold> {
    let class = |class: usize| {
        let members = samples.iter().zip(foretold).filter(|(_, p)| box_of([0.0, 1.0], **p, CLASSES) == class);
        let members: Vec<(&MapSample, &f64)> = members.collect();
        let mean = members.iter().map(|(_, p)| **p).sum::<f64>() / members.len() as f64;
        Some(Foretold { probability: mean, captured: share(members.iter().map(|(sample, _)| *sample))? })
    };
    (0..CLASSES).filter_map(class).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const CAPTURED: (MapOutcome, usize) = (MapOutcome::Captured, 0);

    /// Samples of a known law of two inputs, of the shape that the regression has.
    fn samples(n: u64) -> Vec<MapSample> {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let one = |point| {
            let at = vec![random.random_range(0.0..3.0), random.random_range(0.0..90.0)];
            let came = random.random_bool(law(&at));
            MapSample { point, at, came }
        };
        (0..n).map(one).collect()
    }

    fn inputs(names: &[String], samples: &[MapSample]) -> Vec<MapInput> {
        let input =
            |(axis, name): (usize, &String)| MapInput::of(name, samples.iter().map(|sample| sample.at[axis]));
        names.iter().enumerate().map(input).collect()
    }

    fn law(at: &[f64]) -> f64 {
        1.0 / (1.0 + (-(3.0 - 2.0 * at[0] + 0.02 * at[1])).exp())
    }

    #[test]
    fn a_map_finds_the_law_that_its_members_follow() {
        let names = ["rate", "tilt"].map(str::to_owned);
        let map = CaptureMap::of("t", CAPTURED, &inputs(&names, &samples(2000)), &samples(2000), 6).unwrap();
        let mut held = 0;
        for (i, j) in (0..36).map(|k| (k / 6, k % 6)) {
            let at = [0.25 + 0.5 * f64::from(i), 7.5 + 15.0 * f64::from(j)];
            let found = map.at(&at);
            // Largest difference measured: 0.05.
            assert!((found.value - law(&at)).abs() < 0.15, "{at:?}: {found:?}, {}", law(&at));
            held += usize::from((found.interval_95[0]..=found.interval_95[1]).contains(&law(&at)));
        }
        println!("{held} of 36 intervals hold the law");
        assert!(held >= 25, "{held} of 36");
        assert_eq!(map.boxes.len(), 36);
        assert_eq!(map.boxes.iter().map(|b| b.captured.of).sum::<usize>(), 2000);
        assert!(map.brier < 0.8 * map.brier_of_share, "{} {}", map.brier, map.brier_of_share);
        for class in &map.foretold {
            let [low, high] = class.captured.interval_95;
            assert!((low - 0.05..=high + 0.05).contains(&class.probability), "{class:?}");
        }
    }

    #[test]
    fn one_point_and_no_points_are_no_panic() {
        let one = [MapSample { point: 0, at: vec![1.0], came: true }];
        let map = CaptureMap::of("t", CAPTURED, &inputs(&["a".to_owned()], &one), &one, 3).unwrap();
        assert_eq!((map.boxes.len(), map.terms.len()), (1, 3));
        assert!(CaptureMap::of("t", CAPTURED, &inputs(&["a".to_owned()], &[]), &[], 3).is_none());
    }

    /// Inputs that do nothing leave the law of the first two what it is, in every slice.
    #[test]
    fn a_map_over_four_inputs_has_the_law_of_two_in_each_slice() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut all = samples(4000);
        all.iter_mut().for_each(|sample| sample.at.extend([random.random(), random.random::<f64>()]));
        let names = ["rate", "tilt", "c", "d"].map(str::to_owned);
        let map = CaptureMap::of("t", (MapOutcome::Settled, 1000), &inputs(&names, &all), &all, 3).unwrap();
        assert_eq!((map.terms.len(), map.boxes.len()), (15, 81));
        assert_eq!(map.terms[5..9], ["u^2", "u v", "u w", "u x"]);
        for others in [[0.2, 0.8], [0.5, 0.5]] {
            for at in [[0.5, 20.0], [1.5, 45.0], [2.5, 70.0]] {
                let found = map.at(&[at, others].concat()).value;
                assert!((found - law(&at)).abs() < 0.15, "{at:?}: {found}, {}", law(&at)); // measured: 0.05
            }
        }
        let boxes = map.boxes_of_slice(all.iter(), &[0.5, 0.5], 3);
        assert_eq!(boxes.iter().map(|b| b.captured.of).sum::<usize>(), 4000);
        let [low, high] = map.bounds();
        assert!((high - low - 0.2).abs() < 1e-12 && (low..high).contains(&map.captured.share));
    }
}
