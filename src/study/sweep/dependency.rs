//! How strongly the numbers of a summary depend on each parameter of a `one-at-a-time` study (Section 3.4.3).
//!
//! D = δO / δI,  δO = (O₁ − O₀) / O₀,  δI = (I₁ − I₀) / I₀   (Eq. 3.17, 3.18)
//!
//! O is a number of the summary, I the parameter; 0 is the starting value of the parameter, 1 the value it is changed
//! to. D counts for these two values and no others: it is no derivative.
//!
//! Two models are set side by side over the values of a parameter by Δ = max |O_A − O_M| / O_M (Eq. 3.19).
//!
//! Members whose scenes are the same are one sample, also where they belong to several parameters, as the scene as it
//! is. Where a value has several members, O is their mean, and D has an interval: that of a ratio of two means, with
//! Student's t. Beside the source, which runs each scene once: a net whose cables hardly damp is chaotic.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::design::{Points, Spot};
use super::published::applies;
use super::{SweepPlan, parameters};
use crate::parameter::Parameter;
use crate::problems::Problems;
use crate::provenance::Provenance;
use crate::scene::pointer;
use crate::study::sweep::spec::{Design, Published};

/// The four of Section 3.2.3, in the order of Table 3.3.
pub const DEPLOYMENT: [&str; 4] = [
    "deployment.max_area_m2",
    "deployment.deployment_time_s",
    "deployment.travelling_distance_m",
    "deployment.effective_period_s",
];

/// The values of a group in words: `damping_ratio 0.003, material "Kevlar"`.
pub fn words(group: &BTreeMap<String, String>) -> String {
    let words = group.iter().map(|(path, value)| format!("{} {value}", last_key(path)));
    words.collect::<Vec<_>>().join(", ")
}

/// The last key of a path.
pub fn last_key(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}

/// A member of a sweep, and its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Observed {
    /// Its point.
    pub point: u64,
    /// A number for each column that was asked for; nothing where its row has none.
    pub numbers: Vec<Option<f64>>,
}

/// A number over the members of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeanOf {
    /// How many have it.
    pub members: usize,
    /// Mean.
    pub mean: f64,
    /// Standard deviation; null of one member.
    pub deviation: Option<f64>,
}

/// The numbers at a value of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AtValue {
    /// The value.
    pub value: f64,
    /// One for each number; null where no member has it.
    pub numbers: Vec<Option<MeanOf>>,
}

/// How the numbers go with one parameter, all others as the scene has them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OverParameter {
    /// Its path.
    pub path: String,
    /// Which of the groups.
    pub group: usize,
    /// In the order of its values.
    pub values: Vec<AtValue>,
}

/// A dependency D.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Dependency {
    /// D [%].
    pub percent: f64,
    /// Half the width of its 95 % interval [%]; null where a value has a single member.
    pub half_width_95: Option<f64>,
}

/// The dependencies on one parameter between two of its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DependencyRow {
    /// Path of the parameter.
    pub path: String,
    /// Which of the groups.
    pub group: usize,
    /// Starting value.
    pub from: f64,
    /// The value it is changed to.
    pub to: f64,
    /// D of each number; null where there is none.
    pub found: Vec<Option<Dependency>>,
    /// Where others published theirs; absent where nobody did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Theirs [%]; empty where nobody did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub published: Vec<Option<f64>>,
}

/// The largest difference of a group from the first one over the values of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DifferenceRow {
    /// Path of the parameter.
    pub path: String,
    /// The group that is set beside the first one.
    pub group: usize,
    /// Δ of each number [%]; null where a value lacks it.
    pub percent: Vec<Option<f64>>,
    /// Where others published theirs; absent where nobody did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Theirs [%]; empty where nobody did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub published: Vec<Option<f64>>,
}

/// `dependency.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Dependencies {
    /// What the study asks.
    pub title: String,
    /// Members that count, and all.
    pub members: [u64; 2],
    /// Names of the numbers.
    pub numbers: Vec<String>,
    /// What `crossed` parameters are in each group, by path, as the table shows it.
    pub groups: Vec<BTreeMap<String, String>>,
    /// The numbers over each parameter, in each group.
    pub curves: Vec<OverParameter>,
    /// The dependencies.
    pub dependencies: Vec<DependencyRow>,
    /// Each value of a `crossed` parameter against the first one, where there is one such parameter.
    pub differences: Vec<DifferenceRow>,
    /// What made it.
    pub provenance: Provenance,
}

impl Dependencies {
    /// The dependencies of the columns `names` of the sweep `plan`, whose members are `observed`; without any the rows are
    /// there, empty.
    ///
    /// # Errors
    /// The study is not `one-at-a-time`, or none of its parameters is a list of numbers.
    pub fn of(plan: &SweepPlan, names: &[String], observed: &[Observed]) -> Result<Dependencies, Problems> {
        let mut problems = Problems::new(&plan.title);
        let points = Points::new(
            plan.study.design,
            plan.study.seed,
            parameters(&plan.study, None, &mut problems),
            &[],
            &mut problems,
        );
        if plan.study.design != (Design::OneAtATime {}) {
            problems.add(
                "design.kind",
                "another than \"one-at-a-time\"",
                "a study of one parameter at a time",
            );
        }
        let numeric = |parameter: &&Parameter| !parameter.crossed && parameter.numbers().is_some();
        if !points.parameters().iter().any(|parameter| numeric(&parameter)) {
            problems.add(
                "parameters",
                "none with numbers",
                "a parameter that is a range or a list of numbers",
            );
        }
        problems.into_result(Some(()))?;
        let n_groups = points.n_groups().unwrap_or(1);
        let groups: Vec<BTreeMap<String, String>> =
            (0..n_groups).map(|group| shown(&points, group)).collect();
        let mut all = Dependencies {
            title: plan.title.clone(),
            members: [observed.len() as u64, plan.members],
            numbers: names.to_vec(),
            curves: Vec::new(),
            dependencies: Vec::new(),
            differences: Vec::new(),
            provenance: Provenance::here(),
            groups,
        };
        let scenes = Scenes::of(plan, &points, observed, names.len());
        for (number, parameter) in points.parameters().iter().enumerate().filter(|(_, one)| numeric(one)) {
            for group in 0..all.groups.len() {
                all.add(plan, scenes.over(number, parameter, group));
            }
        }
        all.add_differences(plan);
        Ok(all)
    }

    /// Adds a curve, with the dependencies between its ends, and between those that others published.
    fn add(&mut self, plan: &SweepPlan, curve: OverParameter) {
        let at = &self.groups[curve.group];
        let published: Vec<&Published> =
            plan.study.published.iter().filter(|one| applies(one, &curve.path, at)).collect();
        let (Some(first), Some(last)) = (curve.values.first(), curve.values.last()) else { return };
        let ends = [first.value, last.value];
        let ends_of = |one: &Published| [one.from.unwrap_or(ends[0]), one.to.unwrap_or(ends[1])];
        let mut rows: Vec<([f64; 2], Option<&Published>)> = published
            .into_iter()
            .filter(|one| !one.dependency_percent.is_empty())
            .map(|one| (ends_of(one), Some(one)))
            .collect();
        if rows.iter().all(|(others, _)| *others != ends) {
            rows.insert(0, (ends, None));
        }
        for ([from, to], published) in rows {
            let at = |value: f64| curve.values.iter().find(|one| one.value == value);
            let found = |number: usize| {
                let of = |value: f64| at(value)?.numbers[number];
                Dependency::between([of(from)?, of(to)?], [from, to])
            };
            let theirs = |one: &Published| {
                self.numbers.iter().map(|name| one.dependency_percent.get(name).copied()).collect()
            };
            self.dependencies.push(DependencyRow {
                path: curve.path.clone(),
                group: curve.group,
                from,
                to,
                found: (0..self.numbers.len()).map(found).collect(),
                source: published.map(|one| one.source.clone()),
                published: published.map(theirs).unwrap_or_default(),
            });
        }
        self.curves.push(curve);
    }

    /// Sets the values of the only `crossed` parameter beside the first one; of several it would not be clear which.
    fn add_differences(&mut self, plan: &SweepPlan) {
        if self.groups.first().is_none_or(|group| group.len() != 1) {
            return;
        }
        let mut rows = Vec::new();
        for curve in self.curves.iter().filter(|curve| curve.group > 0) {
            let base = self.curves.iter().find(|one| one.path == curve.path && one.group == 0);
            let Some(base) = base else { continue };
            let at = &self.groups[curve.group];
            let published = plan
                .study
                .published
                .iter()
                .find(|one| applies(one, &curve.path, at) && !one.difference_percent.is_empty());
            let theirs = |one: &Published| {
                self.numbers.iter().map(|name| one.difference_percent.get(name).copied()).collect()
            };
            rows.push(DifferenceRow {
                path: curve.path.clone(),
                group: curve.group,
                percent: (0..self.numbers.len()).map(|number| difference(base, curve, number)).collect(),
                source: published.map(|one| one.source.clone()),
                published: published.map(theirs).unwrap_or_default(),
            });
        }
        self.differences = rows;
    }
}

impl Dependency {
    /// D between `numbers` at two values `inputs` of a parameter; none where a relative deviation has no meaning.
    fn between(numbers: [MeanOf; 2], inputs: [f64; 2]) -> Option<Dependency> {
        let [start, end] = numbers;
        if start.mean == 0.0 || inputs[0] == 0.0 || inputs[0] == inputs[1] {
            return None;
        }
        let (ratio, input) = (end.mean / start.mean, (inputs[1] - inputs[0]) / inputs[0]);
        // Of first order in the deviations of the two means.
        let error = |one: MeanOf| one.deviation.map(|s| s / start.mean / (one.members as f64).sqrt());
        let half_width = error(start).zip(error(end)).and_then(|(of_start, of_end)| {
            let freedom = (start.members + end.members - 2) as f64;
            let t = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975);
            Some(100.0 * t * (ratio * of_start).hypot(of_end) / input.abs())
        });
        Some(Dependency { percent: 100.0 * (ratio - 1.0) / input, half_width_95: half_width })
    }
}

/// Δ of number `number` over the values of two curves [%].
fn difference(base: &OverParameter, other: &OverParameter, number: usize) -> Option<f64> {
    let pairs = base.values.iter().zip(&other.values);
    let apart = pairs.map(|(base, other)| {
        let (base, other) = (base.numbers[number]?.mean, other.numbers[number]?.mean);
        (base != 0.0).then(|| 100.0 * ((other - base) / base).abs())
    });
    apart.collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::max)
}

/// Values of the `crossed` parameters in `group`, by path.
fn shown(points: &Points, group: u64) -> BTreeMap<String, String> {
    let crossed = points.parameters().iter().zip(points.crossed(group));
    crossed
        .filter_map(|(parameter, number)| {
            Some((parameter.path.clone(), parameter.value(number?)?.shown.join(" ")))
        })
        .collect()
}

/// The members of a sweep by what their scenes are.
struct Scenes<'a> {
    /// Values of all parameters as the scene has them.
    own: Vec<Value>,
    members: Vec<(Spot, &'a Observed)>,
    /// How many numbers each has.
    n_numbers: usize,
    points: &'a Points,
}

impl<'a> Scenes<'a> {
    fn of(plan: &SweepPlan, points: &'a Points, observed: &'a [Observed], n_numbers: usize) -> Scenes<'a> {
        let own = |parameter: &Parameter| {
            plan.scene.pointer(&pointer(&parameter.path)).cloned().unwrap_or_default()
        };
        Scenes {
            own: points.parameters().iter().map(own).collect(),
            members: observed.iter().map(|one| (points.spot(one.point), one)).collect(),
            n_numbers,
            points,
        }
    }

    /// Whether a member has the value `value` of parameter `number`, and all others as the scene has them.
    fn is_at(&self, spot: Spot, number: usize, value: &Value) -> bool {
        let is_own = |number: usize, value: &Value| is_same(&self.own[number], value);
        match spot.changed {
            None => is_own(number, value),
            Some((changed, which)) => {
                let Some(pick) = self.points.parameters()[changed].value(which) else { return false };
                match changed == number {
                    true => is_same(&pick.value, value),
                    false => is_own(changed, &pick.value) && is_own(number, value),
                }
            }
        }
    }

    fn over(&self, number: usize, parameter: &Parameter, group: usize) -> OverParameter {
        let n_values = parameter.n_values().unwrap_or(0);
        let at_value = |which: u64| {
            let pick = parameter.value(which)?;
            let here = self
                .members
                .iter()
                .filter(|(spot, _)| spot.group == group as u64 && self.is_at(*spot, number, &pick.value));
            let members: Vec<&Observed> = here.map(|(_, one)| *one).collect();
            let of = |i: usize| MeanOf::of(members.iter().filter_map(|one| one.numbers[i]).collect());
            Some(AtValue { value: pick.value.as_f64()?, numbers: (0..self.n_numbers).map(of).collect() })
        };
        OverParameter {
            path: parameter.path.clone(),
            group,
            values: (0..n_values).filter_map(at_value).collect(),
        }
    }
}

impl MeanOf {
    fn of(values: Vec<f64>) -> Option<MeanOf> {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let deviation = (values.len() > 1).then(|| (squares / (n - 1.0)).sqrt());
        (!values.is_empty()).then_some(MeanOf { members: values.len(), mean, deviation })
    }
}

/// Equal as values of a scene: 10 is 10.0.
fn is_same(one: &Value, other: &Value) -> bool {
    one.as_f64().zip(other.as_f64()).map_or(one == other, |(one, other)| one == other)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(values: &[f64]) -> MeanOf {
        MeanOf::of(values.to_vec()).unwrap()
    }

    /// O = I² from 2 to 3: δO = 5/4, δI = 1/2.
    #[test]
    fn a_square_depends_by_its_finite_ratio() {
        let found = Dependency::between([mean(&[4.0]), mean(&[9.0])], [2.0, 3.0]).unwrap();
        assert!((found.percent - 250.0).abs() < 1e-12, "{found:?}");
        assert_eq!(found.half_width_95, None);
        let falling = Dependency::between([mean(&[4.0]), mean(&[2.0])], [1.0, 3.0]).unwrap();
        assert!((falling.percent + 25.0).abs() < 1e-12, "{falling:?}");
    }

    #[test]
    fn nothing_depends_on_what_begins_at_zero() {
        assert_eq!(Dependency::between([mean(&[4.0]), mean(&[9.0])], [0.0, 3.0]), None);
        assert_eq!(Dependency::between([mean(&[0.0]), mean(&[9.0])], [1.0, 3.0]), None);
    }

    /// Two means of two members, 4 ± 1 and 8 ± 2 (standard errors): the ratio 2 has the error √(2² + 2²) / 4, and t of
    /// two degrees of freedom is 4.3027.
    #[test]
    fn the_interval_is_that_of_a_ratio_of_means() {
        let found = Dependency::between([mean(&[3.0, 5.0]), mean(&[6.0, 10.0])], [1.0, 2.0]).unwrap();
        assert!((found.percent - 100.0).abs() < 1e-12);
        let expected = 100.0 * 4.302_652_73 * 8.0_f64.sqrt() / 4.0;
        assert!((found.half_width_95.unwrap() - expected).abs() < 1e-5, "{found:?}");
    }
}
