//! Where a study is run: from the number of a point to the values of all parameters there, without the points before.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use sobol_burley::NUM_DIMENSIONS;

use super::draw::{Parameter, Pick};
use super::spec::Design;
use crate::problems::Problems;

/// Numbers of the generator that perturbations of the fold take at most; what parameters take comes after.
const AFTER_PERTURBATION: u128 = 1 << 40;

/// A parameter's value at a point, or nothing where the scene's own stays.
pub type Picks = Vec<Option<Pick>>;

/// The points of a study.
#[derive(Clone, Debug)]
pub struct Points {
    design: Design,
    seed: u64,
    parameters: Vec<Parameter>,
}

impl Points {
    /// The points of `design`; a fault where the sequence has too few dimensions, or nothing is there to go through.
    pub fn new(design: Design, seed: u64, parameters: Vec<Parameter>, problems: &mut Problems) -> Points {
        let n_units: usize = parameters.iter().map(Parameter::n_units).sum();
        let most = NUM_DIMENSIONS as usize;
        if matches!(design, Design::Sobol { .. }) && n_units > most {
            problems.add(
                "design.kind",
                format!("\"sobol\" in {n_units} dimensions"),
                format!("at most {most}"),
            );
        }
        let goes_through = matches!(design, Design::Grid {} | Design::OneAtATime {});
        if goes_through && parameters.iter().all(|parameter| parameter.n_values().is_none()) {
            problems.add(
                "design.kind",
                "a design that goes through lists, of which there is none",
                "a parameter with values or a range; \"sobol\" or \"random\" for distributions alone",
            );
        }
        Points { design, seed, parameters }
    }

    /// How many points there are; none where they cannot be counted.
    pub fn count(&self) -> Option<u64> {
        let mut lists = self.parameters.iter().filter_map(Parameter::n_values);
        match self.design {
            Design::Sobol { points } | Design::Random { points } => Some(points),
            Design::Grid {} => lists.try_fold(1, u64::checked_mul),
            // The scene as it is comes first.
            Design::OneAtATime {} => lists.try_fold(1, u64::checked_add),
        }
    }

    /// The values at `point` for `member`, which counts only for what is drawn for every member.
    pub fn at(&self, point: u64, member: u64) -> Picks {
        match self.design {
            Design::Sobol { .. } => {
                let mut dimension = 0;
                self.drawn(|| {
                    let unit = sobol_burley::sample(point as u32, dimension, folded(self.seed));
                    dimension += 1;
                    f64::from(unit)
                })
            }
            Design::Random { .. } => self.drawn(units(self.seed, point)),
            Design::Grid {} => {
                let (mut left, mut next) = (point, units(self.seed, member));
                let pick = |parameter: &Parameter| {
                    let drawn = draw(parameter, &mut next);
                    let Some(n_values) = parameter.n_values() else { return Some(drawn) };
                    let value = parameter.value(left % n_values);
                    left /= n_values;
                    value
                };
                // The last parameter changes fastest.
                let mut picks: Picks = self.parameters.iter().rev().map(pick).collect();
                picks.reverse();
                picks
            }
            Design::OneAtATime {} => {
                let (mut left, mut next) = (point.checked_sub(1), units(self.seed, member));
                let pick = |parameter: &Parameter| {
                    let drawn = draw(parameter, &mut next);
                    let Some(n_values) = parameter.n_values() else { return Some(drawn) };
                    let here = left?;
                    left = here.checked_sub(n_values);
                    parameter.value(here)
                };
                self.parameters.iter().map(pick).collect()
            }
        }
    }

    fn drawn(&self, mut next: impl FnMut() -> f64) -> Picks {
        self.parameters.iter().map(|parameter| Some(draw(parameter, &mut next))).collect()
    }

    /// The parameters.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// What the table says of `picks` in a scene whose own value at a path is `own`.
    pub fn shown<'a>(&self, picks: &Picks, own: impl Fn(&str) -> Option<&'a Value>) -> Vec<String> {
        let all = self.parameters.iter().zip(picks);
        let shown = all.map(|(parameter, pick)| match pick {
            Some(pick) => pick.shown.clone(),
            None => parameter.as_it_is(own(&parameter.path)),
        });
        shown.flatten().collect()
    }
}

fn draw(parameter: &Parameter, next: &mut impl FnMut() -> f64) -> Pick {
    let units: Vec<f64> = (0..parameter.n_units()).map(|_| next()).collect();
    parameter.drawn(&units)
}

/// Numbers from 0 to below 1, a stream for every `number`.
fn units(seed: u64, number: u64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    random.set_word_pos(AFTER_PERTURBATION);
    // The 53 bits of a number, so that it stays what it is whatever the library does for a range.
    move || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// A seed of half the width; small ones stay what they are.
fn folded(seed: u64) -> u32 {
    (seed ^ (seed >> 32)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::sweep::spec::Varied;
    use serde_json::json;

    fn points(design: Value, parameters: Value) -> Points {
        let mut problems = Problems::new("test");
        let varied: Vec<Varied> = serde_json::from_value(parameters).unwrap();
        let parameters: Vec<Parameter> =
            varied.iter().filter_map(|varied| Parameter::read(varied, "p", &mut problems)).collect();
        let points = Points::new(serde_json::from_value(design).unwrap(), 7, parameters, &mut problems);
        assert!(problems.list.is_empty(), "{problems}");
        points
    }

    fn values(points: &Points, point: u64, member: u64) -> Vec<Value> {
        points.at(point, member).into_iter().map(|pick| pick.map_or(Value::Null, |pick| pick.value)).collect()
    }

    fn two_lists() -> Value {
        json!([{ "path": "a", "values": [1, 2] }, { "path": "b", "values": ["x", "y", "z"] }])
    }

    #[test]
    fn a_grid_has_every_pair_once() {
        let grid = points(json!({ "kind": "grid" }), two_lists());
        assert_eq!(grid.count(), Some(6));
        let all: Vec<Vec<Value>> = (0..6).map(|point| values(&grid, point, point)).collect();
        assert_eq!(
            all[..4],
            [json!([1, "x"]), json!([1, "y"]), json!([1, "z"]), json!([2, "x"])]
                .map(|v| v.as_array().unwrap().clone())
        );
        let mut texts: Vec<String> = all.iter().map(|values| format!("{values:?}")).collect();
        texts.sort();
        texts.dedup();
        assert_eq!(texts.len(), 6);
    }

    #[test]
    fn one_at_a_time_begins_with_the_scene_as_it_is() {
        let one = points(json!({ "kind": "one-at-a-time" }), two_lists());
        assert_eq!(one.count(), Some(6));
        let all: Vec<Value> = (0..6).map(|point| values(&one, point, point).into()).collect();
        let expected = [
            json!([null, null]),
            json!([1, null]),
            json!([2, null]),
            json!([null, "x"]),
            json!([null, "y"]),
            json!([null, "z"]),
        ];
        assert_eq!(all, expected);
    }

    #[test]
    fn a_distribution_in_a_grid_is_drawn_for_every_member() {
        let both = json!([{ "path": "a", "values": [1, 2] }, { "path": "b", "uniform": [0, 1] }]);
        let grid = points(json!({ "kind": "grid" }), both.clone());
        assert_eq!(grid.count(), Some(2));
        assert_eq!(values(&grid, 1, 5)[0], json!(2));
        assert_ne!(values(&grid, 0, 0)[1], values(&grid, 0, 1)[1]);
        let random = points(json!({ "kind": "random", "points": 9 }), both);
        assert_eq!(
            values(&random, 3, 0),
            values(&random, 3, 1),
            "members of a point differ in their fold alone"
        );
        assert_ne!(values(&random, 3, 0), values(&random, 4, 0));
    }

    /// The first 2^k points of the sequence have one in each of 2^k strips, in every dimension, and of 2^(k/2) squares'
    /// sides in the first two: more points later leave those that are there.
    #[test]
    fn every_beginning_of_the_sobol_sequence_fills_the_space() {
        let parameters: Vec<Value> =
            (0..6).map(|i| json!({ "path": format!("p{i}"), "uniform": [0, 1] })).collect();
        let sobol = points(json!({ "kind": "sobol", "points": 1024 }), parameters.into());
        let all: Vec<Vec<f64>> = (0..1024)
            .map(|point| values(&sobol, point, 0).iter().map(|v| v.as_f64().unwrap()).collect())
            .collect();
        for n in [16_usize, 64, 256, 1024] {
            for dimension in 0..6 {
                let mut strips = vec![0; n];
                all[..n].iter().for_each(|point| strips[(point[dimension] * n as f64) as usize] += 1);
                assert!(strips.iter().all(|count| *count == 1), "{n} points, dimension {dimension}");
            }
            let side = n.isqrt();
            let mut squares = vec![0; n];
            for point in &all[..n] {
                let [x, y] = [point[0], point[1]].map(|value| (value * side as f64) as usize);
                squares[x * side + y] += 1;
            }
            assert!(squares.iter().all(|count| *count == 1), "{n} points");
        }
    }

    #[test]
    fn a_design_without_anything_to_go_through_is_a_fault() {
        let mut problems = Problems::new("test");
        Points::new(Design::Grid {}, 1, Vec::new(), &mut problems);
        assert_eq!(problems.list.len(), 1);
    }
}
