//! Where a study is run: from the number of a point to the values of all parameters there, without the points before.

use sobol_burley::NUM_DIMENSIONS;

use super::spec::Design;
use crate::parameter::{Own, Parameter, Pick, Stream, units};
use crate::problems::Problems;

/// A parameter's value at a point, or nothing where the scene's own stays.
pub type Picks = Vec<Option<Pick>>;

/// Where a point of a `one-at-a-time` study is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spot {
    /// The combination of `crossed` values.
    pub group: u64,
    /// The parameter that is changed alone, and which of its values it has; nothing for the scene as it is.
    pub changed: Option<(usize, u64)>,
}

/// The points of a study.
#[derive(Clone, Debug)]
pub struct Points {
    design: Design,
    seed: u64,
    parameters: Vec<Parameter>,
    /// Dimensions of each input: of the parameters, then of what is uncertain in the scene.
    n_units: Vec<usize>,
}

impl Points {
    /// The points of `design` over `parameters`, in a scene in which `uncertain` is drawn; a fault where the sequence has
    /// too few dimensions, or nothing is there to go through.
    pub fn new(
        design: Design,
        seed: u64,
        parameters: Vec<Parameter>,
        uncertain: &[Parameter],
        problems: &mut Problems,
    ) -> Points {
        let n_units: Vec<usize> = parameters.iter().chain(uncertain).map(Parameter::n_units).collect();
        let (most, all) = (NUM_DIMENSIONS as usize, n_units.iter().sum::<usize>());
        let dimensions = match design {
            Design::Sobol { .. } => n_units[..parameters.len()].iter().sum(),
            Design::Saltelli { .. } => 2 * all,
            _ => 0,
        };
        if dimensions > most {
            problems.add(
                "design.kind",
                format!("a Sobol sequence in {dimensions} dimensions"),
                format!("at most {most}"),
            );
        }
        if design != (Design::OneAtATime {}) && parameters.iter().any(|parameter| parameter.crossed) {
            problems.add(
                "design.kind",
                "another than \"one-at-a-time\", with a parameter that is `crossed`",
                "\"one-at-a-time\", or no parameter that is `crossed`",
            );
        }
        let goes_through = matches!(design, Design::Grid {} | Design::OneAtATime {});
        let is_gone_through = |parameter: &Parameter| parameter.n_values().is_some() && !parameter.crossed;
        if goes_through && !parameters.iter().any(is_gone_through) {
            problems.add(
                "design.kind",
                "a design that goes through lists, of which there is none",
                "a parameter with values or a range that is not `crossed`; \"sobol\" or \"random\" for distributions alone",
            );
        }
        Points { design, seed, parameters, n_units }
    }

    /// How many points a block of the design has, in which all but one input is the same as in its first or second; none
    /// of a design without blocks.
    pub fn block(&self) -> Option<u64> {
        matches!(self.design, Design::Saltelli { .. }).then_some(self.n_units.len() as u64 + 2)
    }

    /// How many points there are; none where they cannot be counted.
    pub fn count(&self) -> Option<u64> {
        let mut lists = self.parameters.iter().filter_map(Parameter::n_values);
        match self.design {
            Design::Sobol { points } | Design::Random { points } => Some(points),
            Design::Grid {} => lists.try_fold(1, u64::checked_mul),
            Design::OneAtATime {} => self.n_groups()?.checked_mul(self.n_in_group()?),
            Design::Saltelli { base } => base.checked_mul(self.n_units.len() as u64 + 2),
        }
    }

    /// The numbers from 0 to below 1 that what is uncertain in the scene is drawn from.
    pub fn uncertain(&self, point: u64, member: u64) -> Box<dyn FnMut() -> f64> {
        match self.design {
            Design::Saltelli { .. } => {
                let n_before: usize = self.n_units[..self.parameters.len()].iter().sum();
                Box::new(self.of_block(point, n_before))
            }
            _ => Box::new(units(self.seed, member, Stream::Uncertain)),
        }
    }

    /// The numbers of `point` of a design of blocks, from the dimension `first` on: those of A, or of B where they are
    /// of the input that is taken from it.
    fn of_block(&self, point: u64, first: usize) -> impl FnMut() -> f64 + use<> {
        let (in_block, n_all) = (self.n_units.len() as u64 + 2, self.n_units.iter().sum::<usize>());
        let (block, seed) = ((point / in_block) as u32, folded(self.seed));
        let of_b = match point % in_block {
            0 => 0..0,
            1 => 0..n_all,
            other => {
                let input = other as usize - 2;
                let begin: usize = self.n_units[..input].iter().sum();
                begin..begin + self.n_units[input]
            }
        };
        let mut dimension = first;
        move || {
            let at = if of_b.contains(&dimension) { dimension + n_all } else { dimension };
            dimension += 1;
            f64::from(sobol_burley::sample(block, at as u32, seed))
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
            Design::Random { .. } => self.drawn(units(self.seed, point, Stream::Study)),
            Design::Saltelli { .. } => self.drawn(self.of_block(point, 0)),
            Design::Grid {} => {
                let (mut left, mut next) = (point, units(self.seed, member, Stream::Study));
                let pick = |parameter: &Parameter| {
                    let drawn = parameter.draw(&mut next);
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
                let (spot, mut next) = (self.spot(point), units(self.seed, member, Stream::Study));
                let crossed = self.crossed(spot.group);
                let pick = |(number, parameter): (usize, &Parameter)| {
                    let drawn = parameter.draw(&mut next);
                    let Some(_) = parameter.n_values() else { return Some(drawn) };
                    let alone =
                        || spot.changed.filter(|(changed, _)| *changed == number).map(|(_, value)| value);
                    parameter.value(crossed[number].or_else(alone)?)
                };
                self.parameters.iter().enumerate().map(pick).collect()
            }
        }
    }

    /// How often a `one-at-a-time` study is repeated: once for each combination of `crossed` values.
    pub fn n_groups(&self) -> Option<u64> {
        let mut crossed = self.parameters.iter().filter(|parameter| parameter.crossed);
        crossed.try_fold(1, |groups: u64, parameter| groups.checked_mul(parameter.n_values()?))
    }

    /// Points of a group: the scene as it is, and each value alone.
    fn n_in_group(&self) -> Option<u64> {
        let alone = self.parameters.iter().filter(|parameter| !parameter.crossed);
        alone.filter_map(Parameter::n_values).try_fold(1, u64::checked_add)
    }

    /// Where `point` of a `one-at-a-time` study is.
    pub fn spot(&self, point: u64) -> Spot {
        let in_group = self.n_in_group().unwrap_or(1);
        let (group, mut left) = (point / in_group, (point % in_group).checked_sub(1));
        let mut changed = None;
        for (number, parameter) in self.parameters.iter().enumerate().filter(|(_, one)| !one.crossed) {
            let (Some(here), Some(n_values)) = (left, parameter.n_values()) else { continue };
            left = here.checked_sub(n_values);
            if left.is_none() {
                changed = Some((number, here));
            }
        }
        Spot { group, changed }
    }

    /// Which value each parameter has in `group`; none of those that are not `crossed`. The last one changes fastest.
    pub fn crossed(&self, group: u64) -> Vec<Option<u64>> {
        let mut left = group;
        let value = |parameter: &Parameter| {
            let n_values = parameter.n_values().filter(|_| parameter.crossed)?;
            let value = left % n_values;
            left /= n_values;
            Some(value)
        };
        let mut values: Vec<Option<u64>> = self.parameters.iter().rev().map(value).collect();
        values.reverse();
        values
    }

    fn drawn(&self, mut next: impl FnMut() -> f64) -> Picks {
        self.parameters.iter().map(|parameter| Some(parameter.draw(&mut next))).collect()
    }

    /// The parameters.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// What the table says of `picks` in a scene that says `own` at a path.
    pub fn shown(&self, picks: &Picks, own: impl Fn(&str) -> Own) -> Vec<String> {
        let all = self.parameters.iter().zip(picks);
        let shown = all.map(|(parameter, pick)| match pick {
            Some(pick) => pick.shown.clone(),
            None => parameter.as_it_is(&own(&parameter.path)),
        });
        shown.flatten().collect()
    }
}

/// A seed of half the width; small ones stay what they are.
fn folded(seed: u64) -> u32 {
    (seed ^ (seed >> 32)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::spec::Varied;
    use serde_json::{Value, json};

    fn points(design: Value, parameters: Value) -> Points {
        let mut problems = Problems::new("test");
        let varied: Vec<Varied> = serde_json::from_value(parameters).unwrap();
        let parameters: Vec<Parameter> = varied
            .iter()
            .filter_map(|varied| Parameter::read(varied, &Own::Unknown, "p", &mut problems))
            .collect();
        let points = Points::new(serde_json::from_value(design).unwrap(), 7, parameters, &[], &mut problems);
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
    fn what_is_crossed_repeats_the_whole_study() {
        let mut written = two_lists();
        written.as_array_mut().unwrap().push(json!({ "path": "c", "values": [7, 8], "crossed": true }));
        written
            .as_array_mut()
            .unwrap()
            .insert(0, json!({ "path": "d", "values": ["p", "q"], "crossed": true }));
        let crossed = points(json!({ "kind": "one-at-a-time" }), written);
        assert_eq!((crossed.count(), crossed.n_groups()), (Some(24), Some(4)));
        let expected = [("p", 7), ("p", 8), ("q", 7), ("q", 8)];
        for point in 0..24 {
            let Spot { group, changed } = crossed.spot(point);
            assert_eq!(group, point / 6);
            let found = values(&crossed, point, point);
            let (d, c) = expected[group as usize];
            assert_eq!((&found[0], &found[3]), (&json!(d), &json!(c)), "point {point}");
            let alone = [&found[1], &found[2]].iter().filter(|value| !value.is_null()).count();
            assert_eq!(alone, usize::from(point % 6 > 0));
            assert_eq!(changed.is_some(), point % 6 > 0);
        }
        assert_eq!(crossed.spot(9), Spot { group: 1, changed: Some((2, 0)) });
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

    /// Of a block A and B differ in all inputs, and each further point differs from A in one, where it is B's.
    #[test]
    fn a_block_takes_one_input_after_the_other_from_its_second_point() {
        let parameters = json!([{ "path": "a", "uniform": [0, 1] }, { "path": "b", "direction": { "length": [1, 2] } },
                                { "path": "c", "values": [1, 2, 3, 4, 5, 6, 7, 8, 9] }]);
        let design = points(json!({ "kind": "saltelli", "base": 4 }), parameters);
        assert_eq!((design.count(), design.block()), (Some(20), Some(5)));
        for block in 0..4 {
            let all: Vec<Vec<Value>> = (0..5).map(|i| values(&design, 5 * block + i, 0)).collect();
            assert!((0..2).all(|input| all[0][input] != all[1][input]));
            for input in 0..3 {
                let expected: Vec<&Value> =
                    (0..3).map(|other| &all[usize::from(input == other)][other]).collect();
                assert_eq!(all[2 + input].iter().collect::<Vec<_>>(), expected, "block {block}, {input}");
            }
        }
    }

    #[test]
    fn a_design_without_anything_to_go_through_is_a_fault() {
        let crossed = json!({ "path": "a", "values": [1, 2], "crossed": true });
        let crossed: Varied = serde_json::from_value(crossed).unwrap();
        for (design, varied, n_faults) in [
            (Design::Grid {}, None, 1),
            (Design::OneAtATime {}, Some(&crossed), 1),
            (Design::Random { points: 3 }, Some(&crossed), 1),
        ] {
            let mut problems = Problems::new("test");
            let parameters =
                varied.and_then(|varied| Parameter::read(varied, &Own::Unknown, "p", &mut problems));
            Points::new(design, 1, parameters.into_iter().collect(), &[], &mut problems);
            assert_eq!(problems.list.len(), n_faults, "{problems}");
        }
    }
}
