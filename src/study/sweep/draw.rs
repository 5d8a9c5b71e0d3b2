//! One parameter: which values it takes, and how a number between 0 and 1 becomes one of them.
//!
//! Every value that is drawn is rounded to twelve digits: the mathematics of two systems may differ in the last ones, and
//! a table is read by people too.

use std::f64::consts::TAU;

use serde_json::{Value, json};
use statrs::distribution::{ContinuousCDF, Normal};

use super::spec::{CutNormal, Directions, Steps, Varied};
use crate::problems::{Problems, join, visible};

/// Values of a list that are tried before anything runs: each takes as long as reading a scene.
const MOST_CHECKED: usize = 100;

/// A parameter that was checked.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its path in the scene.
    pub path: String,
    factor: Factor,
}

/// What a parameter may be.
#[derive(Clone, Debug)]
enum Factor {
    /// These; whether they were written as a range.
    List(Vec<Pick>, bool),
    Uniform([f64; 2]),
    LogUniform([f64; 2]),
    Normal(CutNormal),
    Directions(Directions),
}

/// A value of a parameter, and what the table says of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pick {
    /// As the scene is to have it.
    pub value: Value,
    /// A text for each of the parameter's columns.
    pub shown: Vec<String>,
}

impl Pick {
    fn of(value: Value) -> Pick {
        Pick { shown: vec![shown(&value)], value }
    }

    /// A vector, with its length and the angle between its line and X.
    fn of_vector(vector: [f64; 3]) -> Pick {
        let length = vector.iter().map(|number| number * number).sum::<f64>().sqrt();
        let tilt = if length > 0.0 { (vector[0].abs() / length).min(1.0).acos().to_degrees() } else { 0.0 };
        // Fewer digits than those that they are made of.
        let numbers = vector.into_iter().chain([length, tilt].map(|number| of_digits(number, 10)));
        Pick { value: json!(vector), shown: numbers.map(number).collect() }
    }
}

/// A number as the table has it: the shortest text that is read back as the same.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::Number(given) => given.as_f64().map_or_else(|| given.to_string(), number),
        Value::String(text) => visible(text, false).into_owned(),
        other => other.to_string(),
    }
}

/// The nearest number of twelve digits.
fn rounded(value: f64) -> f64 {
    of_digits(value, 12)
}

fn of_digits(value: f64, n_digits: usize) -> f64 {
    let after_point = n_digits - 1;
    format!("{value:.after_point$e}").parse().unwrap_or(value)
}

impl Parameter {
    /// The parameter written as `varied` at `place`; what cannot be goes to `problems`.
    pub fn read(varied: &Varied, place: &str, problems: &mut Problems) -> Option<Parameter> {
        let known = problems.list.len();
        let mut factors: Vec<Factor> = Vec::new();
        let mut ordered = |key: &str, [low, high]: [f64; 2]| {
            if low > high {
                problems.add(
                    join(place, key),
                    format!("[{low}, {high}]"),
                    "the least first, then the largest",
                );
            }
            [low, high]
        };
        factors.extend(varied.uniform.map(|ends| Factor::Uniform(ordered("uniform", ends))));
        let logs = varied.log_uniform.map(|ends| ordered("log_uniform", ends.map(|end| end.0)));
        factors.extend(logs.map(Factor::LogUniform));
        if let Some(directions) = varied.direction {
            let [low, _] = ordered("direction.length", directions.length);
            if low < 0.0 {
                problems.add(join(place, "direction.length"), low, "lengths of at least 0");
            }
            factors.push(Factor::Directions(directions));
        }
        factors.extend(varied.normal.map(Factor::Normal));
        factors.extend(varied.range.map(|range| Factor::List(steps(range), true)));
        if let Some(values) = &varied.values {
            factors.push(Factor::List(list(values, varied.labels.as_deref(), place, problems), false));
        } else if varied.labels.is_some() {
            problems.add(join(place, "labels"), "labels without values", "labels beside values");
        }
        if varied.path.is_empty() {
            problems.add(
                join(place, "path"),
                "\"\"",
                "the path of a value of the scene, as in launch.speed_m_s",
            );
        }
        if factors.len() != 1 {
            let found = format!("{} of them", factors.len());
            let allowed = "exactly one of values, range, uniform, log_uniform, normal, direction";
            problems.add(place, found, allowed);
        }
        let factor = factors.pop()?;
        (problems.list.len() == known).then(|| Parameter { path: varied.path.clone(), factor })
    }

    /// How many values it has to choose from; none of a distribution.
    pub fn n_values(&self) -> Option<u64> {
        match &self.factor {
            Factor::List(picks, _) => Some(picks.len() as u64),
            _ => None,
        }
    }

    /// How many numbers between 0 and 1 make a value of it.
    pub fn n_units(&self) -> usize {
        if matches!(self.factor, Factor::Directions(_)) { 3 } else { 1 }
    }

    /// Its columns in the table.
    pub fn columns(&self) -> Vec<String> {
        match self.factor {
            Factor::Directions(_) => {
                ["0", "1", "2", "length", "tilt_deg"].map(|name| format!("{}.{name}", self.path)).into()
            }
            _ => vec![self.path.clone()],
        }
    }

    /// Value `number` of a list.
    pub fn value(&self, number: u64) -> Option<Pick> {
        match &self.factor {
            Factor::List(picks, _) => picks.get(usize::try_from(number).ok()?).cloned(),
            _ => None,
        }
    }

    /// The value that `units`, numbers from 0 to below 1, stand for.
    pub fn drawn(&self, units: &[f64]) -> Pick {
        let between = |[low, high]: [f64; 2], unit: f64| low + unit * (high - low);
        let unit = units[0];
        let value = match &self.factor {
            Factor::List(picks, _) => {
                let number = (unit * picks.len() as f64) as usize;
                return picks[number.min(picks.len() - 1)].clone();
            }
            Factor::Directions(directions) => {
                // Archimedes: heights on a sphere are as likely all.
                let (x, turn) = (2.0 * unit - 1.0, TAU * units[1]);
                let (beside, length) = ((1.0 - x * x).max(0.0).sqrt(), between(directions.length, units[2]));
                let direction = [x, beside * turn.cos(), beside * turn.sin()];
                return Pick::of_vector(direction.map(|part| rounded(length * part)));
            }
            Factor::Uniform(ends) => between(*ends, unit),
            Factor::LogUniform(ends) => between(ends.map(f64::ln), unit).exp().clamp(ends[0], ends[1]),
            Factor::Normal(CutNormal { mean, sigma, cut }) => {
                let normal = Normal::standard();
                let ends = [normal.cdf(-cut.0), normal.cdf(cut.0)];
                mean + sigma.0 * normal.inverse_cdf(between(ends, unit)).clamp(-cut.0, cut.0)
            }
        };
        Pick::of(json!(rounded(value)))
    }

    /// The values at its ends, with their places below the parameter's: who may have all of these may have those between.
    pub fn ends(&self) -> Vec<(String, Pick)> {
        let both = |key: &str, ends: [f64; 2]| {
            let end = |number: usize| (format!("{key}[{number}]"), Pick::of(json!(ends[number])));
            vec![end(0), end(1)]
        };
        match &self.factor {
            Factor::List(picks, true) => [picks.first(), picks.last()]
                .into_iter()
                .flatten()
                .map(|pick| ("range".to_owned(), pick.clone()))
                .collect(),
            Factor::List(picks, false) => {
                let places = picks.iter().enumerate().take(MOST_CHECKED);
                places.map(|(number, pick)| (format!("values[{number}]"), pick.clone())).collect()
            }
            Factor::Uniform(ends) => both("uniform", *ends),
            Factor::LogUniform(ends) => both("log_uniform", *ends),
            Factor::Normal(CutNormal { mean, sigma, cut }) => {
                let farthest = |side: f64| Pick::of(json!(mean + side * cut.0 * sigma.0));
                vec![("normal".to_owned(), farthest(-1.0)), ("normal".to_owned(), farthest(1.0))]
            }
            Factor::Directions(directions) => {
                let along = |x: f64| Pick::of_vector([x, 0.0, 0.0]);
                let place = "direction.length".to_owned();
                vec![(place.clone(), along(directions.length[0])), (place, along(directions.length[1]))]
            }
        }
    }

    /// What the table says where the scene's own `value` stays.
    pub fn as_it_is(&self, value: Option<&Value>) -> Vec<String> {
        let n_columns = self.columns().len();
        if n_columns == 1 {
            return vec![value.map_or_else(String::new, shown)];
        }
        let vector: Option<[f64; 3]> = value.and_then(|value| serde_json::from_value(value.clone()).ok());
        vector.map_or_else(|| vec![String::new(); n_columns], |vector| Pick::of_vector(vector).shown)
    }
}

fn steps(range: Steps) -> Vec<Pick> {
    let last = f64::from(range.steps.max(2) - 1);
    let value = |step: u32| {
        let share = f64::from(step) / last;
        rounded((1.0 - share) * range.from + share * range.to)
    };
    (0..range.steps).map(|step| Pick::of(json!(value(step)))).collect()
}

fn list(values: &[Value], labels: Option<&[String]>, place: &str, problems: &mut Problems) -> Vec<Pick> {
    let mut picks: Vec<Pick> = values.iter().cloned().map(Pick::of).collect();
    if let Some(labels) = labels {
        if labels.len() != values.len() {
            let found = format!("{} labels of {} values", labels.len(), values.len());
            problems.add(join(place, "labels"), found, "a label for each value");
        }
        for (pick, label) in picks.iter_mut().zip(labels) {
            pick.shown = vec![visible(label, false).into_owned()];
        }
    }
    picks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(written: Value) -> Parameter {
        let mut problems = Problems::new("test");
        let varied: Varied = serde_json::from_value(written).unwrap();
        Parameter::read(&varied, "p", &mut problems).unwrap_or_else(|| panic!("{problems}"))
    }

    fn drawn(parameter: &Parameter, units: &[f64]) -> f64 {
        parameter.drawn(units).value.as_f64().unwrap()
    }

    #[test]
    fn every_kind_keeps_to_its_ends_and_to_its_middle() {
        for (written, low, middle, high) in [
            (json!({ "path": "a", "uniform": [-1, 3] }), -1.0, 1.0, 3.0),
            (json!({ "path": "a", "log_uniform": [0.01, 100] }), 0.01, 1.0, 100.0),
            (json!({ "path": "a", "normal": { "mean": 5, "sigma": 2, "cut": 1.5 } }), 2.0, 5.0, 8.0),
            (json!({ "path": "a", "range": { "from": 1, "to": 3, "steps": 3 } }), 1.0, 2.0, 3.0),
            (json!({ "path": "a", "values": [1, 5, 7] }), 1.0, 5.0, 7.0),
        ] {
            let parameter = parameter(written);
            let values: Vec<f64> = (0..1000).map(|i| drawn(&parameter, &[f64::from(i) / 1000.0])).collect();
            assert!(values.is_sorted(), "{parameter:?}");
            assert!((values[0] - low).abs() < 1e-9, "{parameter:?}: {}", values[0]);
            assert!((values[500] - middle).abs() < 1e-6, "{parameter:?}: {}", values[500]);
            assert!(
                (0.0..0.2 * (high - low)).contains(&(high - values[999])),
                "{parameter:?}: {}",
                values[999]
            );
        }
    }

    /// Quartiles of the standard normal distribution, cut so far out that it does not matter.
    #[test]
    fn a_normal_distribution_has_its_quartiles() {
        let normal = parameter(json!({ "path": "a", "normal": { "mean": 0, "sigma": 1, "cut": 8 } }));
        assert!((drawn(&normal, &[0.75]) - 0.674_489_750_196).abs() < 1e-9);
    }

    #[test]
    fn directions_have_their_length_and_no_side_that_they_prefer() {
        let sphere = parameter(json!({ "path": "a", "direction": { "length": [2, 2] } }));
        assert_eq!(sphere.columns(), ["a.0", "a.1", "a.2", "a.length", "a.tilt_deg"]);
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        let n = 40;
        for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
            let pick = sphere.drawn(&[(f64::from(i) + 0.5) / 40.0, (f64::from(j) + 0.5) / 40.0, 0.3]);
            let vector: [f64; 3] = serde_json::from_value(pick.value).unwrap();
            assert_eq!(pick.shown[3], "2.0");
            for axis in 0..3 {
                sum[axis] += vector[axis] / f64::from(n * n);
                squares[axis] += vector[axis].powi(2) / f64::from(n * n);
            }
        }
        // Mean 0 and mean square 4/3; measured 1e-17 and 2e-4 off.
        assert!(sum.iter().all(|mean| mean.abs() < 1e-9), "{sum:?}");
        assert!(squares.iter().all(|square| (square - 4.0 / 3.0).abs() < 2e-3), "{squares:?}");
        let tilt = |x: [f64; 3]| Pick::of_vector(x).shown[4].clone();
        assert_eq!([[1.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 3.0, 0.0]].map(tilt), ["0.0", "0.0", "90.0"]);
    }

    #[test]
    fn what_is_drawn_is_read_back_as_the_same() {
        let uniform = parameter(json!({ "path": "a", "uniform": [0, 1] }));
        let pick = uniform.drawn(&[1.0 / 3.0]);
        assert_eq!((pick.value, pick.shown), (json!(0.333333333333), vec!["0.333333333333".to_owned()]));
    }

    #[test]
    fn faults_of_a_parameter_are_told_together() {
        let mut problems = Problems::new("test");
        let bad = json!({ "path": "", "uniform": [3, 1], "direction": { "length": [-2, 1] }, "values": [1, 2],
                          "labels": ["one"] });
        assert!(Parameter::read(&serde_json::from_value(bad).unwrap(), "p", &mut problems).is_none());
        let places: Vec<&str> = problems.list.iter().map(|problem| problem.place.as_str()).collect();
        assert_eq!(places, ["p.uniform", "p.direction.length", "p.labels", "p.path", "p"]);
    }
}
