//! One parameter: which values it takes, and how a number between 0 and 1 becomes one of them.
//!
//! Every value that is drawn is rounded to twelve digits: the mathematics of two systems may differ in the last ones, and
//! a table is read by people too.

mod law;
pub mod spec;
mod turn;

use nalgebra::{UnitQuaternion, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use crate::problems::{Problems, join, visible};
use crate::spelling;
use crate::target::parts;
use law::NumberLaw;
use spec::{Directions, Steps, Varied};

/// Values of a list that are tried before anything runs: each takes as long as reading a scene.
const MOST_CHECKED: usize = 100;

/// What a parameter must be exactly one of.
const KINDS: &str = "exactly one of values, range, uniform, log_uniform, normal, direction, attitude";

/// A parameter that was checked.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its path in the scene.
    pub path: String,
    /// Whether it lies about what the scene says at its path, and moves with that.
    pub is_about_own: bool,
    /// Whether a `one-at-a-time` study is repeated for each of its values.
    pub crossed: bool,
    factor: Factor,
}

/// What the scene says at the path of a parameter.
#[derive(Clone, Debug)]
pub enum Own {
    /// There is no scene to ask: what depends on it is left out, and is no fault.
    Unknown,
    /// Nothing.
    Nothing,
    /// This.
    Value(Value),
}

impl Own {
    fn numbers(&self) -> Option<Vec<f64>> {
        let Own::Value(value) = self else { return None };
        match value {
            Value::Array(list) if !list.is_empty() => list.iter().map(Value::as_f64).collect(),
            other => other.as_f64().map(|number| vec![number]),
        }
    }

    fn vector(&self) -> Option<[f64; 3]> {
        self.numbers()?.try_into().ok()
    }

    fn is_list(&self) -> bool {
        matches!(self, Own::Value(Value::Array(_))) && self.numbers().is_some()
    }
}

/// What a parameter may be.
#[derive(Clone, Debug)]
enum Factor {
    /// These; whether they were written as a range.
    List(Vec<Pick>, bool),
    /// A number; or a list of them, each by itself.
    Numbers { laws: Vec<NumberLaw>, key: &'static str, is_list: bool },
    /// A vector: its length, and the direction that it is near to with the largest angle [rad].
    Direction { length: [f64; 2], near: Option<(Vector3<f64>, f64)> },
    /// An attitude at most so far from one [rad].
    Attitude { own: UnitQuaternion<f64>, within: f64 },
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

    fn of_numbers(numbers: &[f64], is_list: bool) -> Pick {
        let value = if is_list { json!(numbers) } else { json!(numbers[0]) };
        Pick { value, shown: numbers.iter().copied().map(number).collect() }
    }

    /// A vector, with its length and the angle between its line and X.
    fn of_vector(vector: [f64; 3]) -> Pick {
        let length = vector.iter().map(|number| number * number).sum::<f64>().sqrt();
        // Fewer digits than those that they are made of.
        let derived = [length, tilt(&vector.into())].map(|number| of_digits(number, 10));
        Pick { value: json!(vector), shown: vector.into_iter().chain(derived).map(number).collect() }
    }

    /// Turns about three axes [deg], with the angles between the body's axes and X.
    fn of_turns(turns: [f64; 3]) -> Pick {
        let attitude = parts::turns(turns);
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let tilts = axes.map(|axis| of_digits(tilt(&(attitude * axis)), 10));
        Pick { value: json!(turns), shown: turns.into_iter().chain(tilts).map(number).collect() }
    }
}

/// Angle between the line of `vector` and X [deg]; 0 of none.
fn tilt(vector: &Vector3<f64>) -> f64 {
    let length = vector.norm();
    if length > 0.0 { (vector.x.abs() / length).min(1.0).acos().to_degrees() } else { 0.0 }
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

/// What numbers are drawn for: each has a part of a member's stream to itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// The parameters of a study; perturbations of the fold, which come before, take fewer numbers than that.
    Study,
    /// What is uncertain in a scene.
    Uncertain,
}

/// Numbers from 0 to below 1, a stream for every `number`.
pub fn units(seed: u64, number: u64, stream: Stream) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    random.set_word_pos(match stream {
        Stream::Study => 1 << 40,
        Stream::Uncertain => 1 << 41,
    });
    // The 53 bits of a number, so that it stays what it is whatever the library does for a range.
    move || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Adds paths that are, or are within, one another: each of `varied`, which stand at `place`, must be alone.
pub fn check_apart(varied: &[Varied], place: &str, problems: &mut Problems) {
    for (number, one) in varied.iter().enumerate() {
        if let Some(other) = varied[..number].iter().find(|other| overlap(&other.path, &one.path)) {
            let found = format!("{:?} beside {:?}", one.path, other.path);
            problems.add(
                format!("{place}[{number}].path"),
                found,
                "a value of the scene that no other parameter changes",
            );
        }
    }
}

/// Whether two paths are the same, or one leads on from the other.
pub fn overlap(one: &str, other: &str) -> bool {
    let within = |inner: &str, outer: &str| {
        inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    within(one, other) || within(other, one)
}

impl Parameter {
    /// The parameter written as `varied` at `place`, where the scene says `own`; what cannot be goes to `problems`.
    pub fn read(varied: &Varied, own: &Own, place: &str, problems: &mut Problems) -> Option<Parameter> {
        let known = problems.list.len();
        let is_about_own = varied.normal.is_some_and(|normal| normal.mean.is_none())
            || varied.direction.is_some_and(|d| d.length.is_none() || d.within_deg.is_some())
            || varied.attitude.is_some_and(|attitude| attitude.within_deg.is_some());
        let mut factors = law::numbers(varied, own, place, problems);
        factors
            .extend(varied.direction.and_then(|direction| read_direction(direction, own, place, problems)));
        if let Some(attitude) = varied.attitude {
            let turns = own.vector().or(attitude.within_deg.is_none().then_some([0.0; 3]));
            if turns.is_none() && !matches!(own, Own::Unknown) {
                problems.add(join(place, "attitude"), "no turns about three axes there", "a path to some");
            }
            let within = attitude.within_deg.unwrap_or(180.0).to_radians();
            factors.extend(turns.map(|turns| Factor::Attitude { own: parts::turns(turns), within }));
        }
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
        let n_kinds = varied.n_kinds();
        if n_kinds != 1 {
            problems.add(place, format!("{n_kinds} of them"), KINDS);
        }
        let factor = factors.pop()?;
        if varied.crossed && !matches!(factor, Factor::List(..)) {
            problems.add(join(place, "crossed"), "a distribution", "values or a range");
        }
        let (path, crossed) = (varied.path.clone(), varied.crossed);
        (problems.list.len() == known).then_some(Parameter { path, is_about_own, crossed, factor })
    }

    /// How many values it has to choose from; none of a distribution.
    pub fn n_values(&self) -> Option<u64> {
        match &self.factor {
            Factor::List(picks, _) => Some(picks.len() as u64),
            _ => None,
        }
    }

    /// Its values where they are a range or a list of numbers.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        match &self.factor {
            Factor::List(picks, _) => picks.iter().map(|pick| pick.value.as_f64()).collect(),
            _ => None,
        }
    }

    /// Its ends where it is one number between two, and whether its logarithm is what is as likely everywhere.
    pub fn number_between(&self) -> Option<([f64; 2], bool)> {
        let Factor::Numbers { laws, is_list: false, .. } = &self.factor else { return None };
        match laws[..] {
            [NumberLaw::Uniform(ends)] => Some((ends, false)),
            [NumberLaw::LogUniform(ends)] => Some((ends, true)),
            _ => None,
        }
    }

    /// How many numbers between 0 and 1 make a value of it.
    pub fn n_units(&self) -> usize {
        match &self.factor {
            Factor::List(..) => 1,
            Factor::Numbers { laws, .. } => laws.len(),
            Factor::Direction { .. } | Factor::Attitude { .. } => 3,
        }
    }

    /// Its columns in the table.
    pub fn columns(&self) -> Vec<String> {
        let path = &self.path;
        let below = |names: &[&str]| names.iter().map(|name| format!("{path}.{name}")).collect();
        match &self.factor {
            Factor::Direction { .. } => below(&["0", "1", "2", "length", "tilt_deg"]),
            Factor::Attitude { .. } => below(&["0", "1", "2", "x_tilt_deg", "y_tilt_deg", "z_tilt_deg"]),
            Factor::Numbers { laws, is_list: true, .. } => {
                (0..laws.len()).map(|entry| format!("{path}.{entry}")).collect()
            }
            Factor::List(..) | Factor::Numbers { .. } => vec![path.clone()],
        }
    }

    /// Value `number` of a list.
    pub fn value(&self, number: u64) -> Option<Pick> {
        match &self.factor {
            Factor::List(picks, _) => picks.get(usize::try_from(number).ok()?).cloned(),
            _ => None,
        }
    }

    /// The change of a scene to `pick`, as for `--set`.
    pub fn change(&self, pick: &Pick) -> String {
        format!("{}={}", self.path, pick.value)
    }

    /// The value that the next numbers of `next`, from 0 to below 1, stand for.
    pub fn draw(&self, next: &mut dyn FnMut() -> f64) -> Pick {
        let units: Vec<f64> = (0..self.n_units()).map(|_| next()).collect();
        self.drawn(&units)
    }

    /// The value that `units`, numbers from 0 to below 1, stand for.
    pub fn drawn(&self, units: &[f64]) -> Pick {
        match &self.factor {
            Factor::List(picks, _) => {
                let number = (units[0] * picks.len() as f64) as usize;
                picks[number.min(picks.len() - 1)].clone()
            }
            Factor::Numbers { laws, is_list, .. } => {
                let numbers = laws.iter().zip(units).map(|(law, unit)| rounded(law.at(*unit)));
                Pick::of_numbers(&numbers.collect::<Vec<f64>>(), *is_list)
            }
            Factor::Direction { length, near } => {
                let length = length[0] + units[2] * (length[1] - length[0]);
                let on_sphere = [units[0], units[1]];
                let direction = match near {
                    None => turn::direction(on_sphere),
                    Some((own, within)) => turn::direction_near(own, *within, on_sphere),
                };
                Pick::of_vector(<[f64; 3]>::from(direction).map(|part| rounded(length * part)))
            }
            Factor::Attitude { own, within } => {
                let turned = turn::turn(*within, [units[0], units[1], units[2]]) * own;
                Pick::of_turns(spelling::turns_of(&turned).map(rounded))
            }
        }
    }

    /// The values at its ends, with their places below the parameter's: who may have all of these may have those between.
    pub fn ends(&self) -> Vec<(String, Pick)> {
        let place = |place: &str| place.to_owned();
        match &self.factor {
            Factor::List(picks, true) => {
                let ends = [picks.first(), picks.last()].into_iter().flatten();
                ends.map(|pick| (place("range"), pick.clone())).collect()
            }
            Factor::List(picks, false) => {
                let places = picks.iter().enumerate().take(MOST_CHECKED);
                places.map(|(number, pick)| (format!("values[{number}]"), pick.clone())).collect()
            }
            Factor::Numbers { laws, key, is_list } => {
                let end = |side: usize| {
                    let numbers: Vec<f64> = laws.iter().map(|law| law.ends()[side]).collect();
                    let place = if *key == "normal" { place(key) } else { format!("{key}[{side}]") };
                    (place, Pick::of_numbers(&numbers, *is_list))
                };
                vec![end(0), end(1)]
            }
            Factor::Direction { length, near } => {
                let along = near.map_or(Vector3::x(), |(own, _)| own.normalize());
                let end = |length: f64| (place("direction.length"), Pick::of_vector((length * along).into()));
                vec![end(length[0]), end(length[1])]
            }
            Factor::Attitude { own, .. } => {
                vec![(place("attitude"), Pick::of_turns(spelling::turns_of(own)))]
            }
        }
    }

    /// What the table says where the scene's `own` value stays.
    pub fn as_it_is(&self, own: &Own) -> Vec<String> {
        let pick = match &self.factor {
            Factor::Direction { .. } => own.vector().map(Pick::of_vector),
            Factor::Attitude { .. } => own.vector().map(Pick::of_turns),
            Factor::Numbers { is_list: true, .. } => own.numbers().map(|own| Pick::of_numbers(&own, true)),
            Factor::List(..) | Factor::Numbers { .. } => match own {
                Own::Value(value) => Some(Pick::of(value.clone())),
                Own::Nothing | Own::Unknown => None,
            },
        };
        let n_columns = self.columns().len();
        let shown = pick.map(|pick| pick.shown).filter(|shown| shown.len() == n_columns);
        shown.unwrap_or_else(|| vec![String::new(); n_columns])
    }
}

fn read_direction(direction: Directions, own: &Own, place: &str, problems: &mut Problems) -> Option<Factor> {
    let vector = own.vector().map(Vector3::from).filter(|vector| vector.norm() > 0.0);
    let place = join(place, "direction");
    let needs_own = direction.length.is_none() || direction.within_deg.is_some();
    if needs_own && vector.is_none() {
        if !matches!(own, Own::Unknown) {
            let allowed = "a path to a vector that is not zero; or a length, and no within_deg";
            problems.add(place, "no direction there", allowed);
        }
        return None;
    }
    let own_length = vector.map_or(0.0, |vector| vector.norm());
    let length = law::ordered(direction.length.unwrap_or([own_length; 2]), &join(&place, "length"), problems);
    if length[0] < 0.0 {
        problems.add(join(&place, "length"), length[0], "lengths of at least 0");
    }
    let near = vector.zip(direction.within_deg.map(f64::to_radians));
    Some(Factor::Direction { length, near })
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
        Parameter::read(&varied, &Own::Unknown, "p", &mut problems).unwrap_or_else(|| panic!("{problems}"))
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
        assert!(
            Parameter::read(&serde_json::from_value(bad).unwrap(), &Own::Unknown, "p", &mut problems)
                .is_none()
        );
        let places: Vec<&str> = problems.list.iter().map(|problem| problem.place.as_str()).collect();
        assert_eq!(places, ["p.uniform", "p.direction.length", "p.labels", "p.path", "p"]);
    }
}
