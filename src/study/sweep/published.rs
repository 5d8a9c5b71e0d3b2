//! Published numbers that a study brings along: whether they fit it, and to which of its groups they belong.

use std::collections::BTreeMap;

use super::design::Points;
use super::spec::{Design, Published, PublishedOutcome, SweepSpec};
use crate::parameter::Parameter;
use crate::problems::{Problems, did_you_mean, join};

/// Whether `published` belongs to the parameter at `path` in a group of these values.
pub(super) fn applies(published: &Published, path: &str, at: &BTreeMap<String, String>) -> bool {
    published.path == path && published.at.iter().all(|(path, value)| at.get(path) == Some(value))
}

/// Checks that the inputs of `published` outcomes are among the `columns` of inputs.
pub(super) fn check_outcomes(published: &[PublishedOutcome], columns: &[String], problems: &mut Problems) {
    for (number, published) in published.iter().enumerate() {
        let place = join(&format!("published_outcomes[{number}]"), "at");
        for column in published.at.keys().filter(|column| !columns.contains(column)) {
            let meant = did_you_mean(column, columns.iter().map(String::as_str));
            problems.add(
                &place,
                format!("{column:?}"),
                format!("{meant}columns of inputs: {}", list(columns)),
            );
        }
    }
}

/// Checks what `spec` has published of its `points` and of the numbers `names`.
pub(super) fn check(spec: &SweepSpec, points: &Points, names: &[String], problems: &mut Problems) {
    if spec.design != (Design::OneAtATime {}) && !spec.published.is_empty() {
        problems.add("published", "beside another design", "a design \"one-at-a-time\"");
        return;
    }
    let parameters = points.parameters();
    for (number, published) in spec.published.iter().enumerate() {
        let place = |key: &str| join(&format!("published[{number}]"), key);
        let find = |path: &str, crossed: bool| {
            parameters.iter().find(|parameter| parameter.path == path && parameter.crossed == crossed)
        };
        let paths = |crossed: bool| parameters.iter().filter(move |one| one.crossed == crossed).map(path);
        match find(&published.path, false).and_then(Parameter::numbers) {
            None => {
                let meant = did_you_mean(&published.path, paths(false));
                let allowed = format!("{meant}the path of a parameter that is a range or a list of numbers");
                problems.add(place("path"), format!("{:?}", published.path), allowed);
            }
            Some(values) => {
                for (key, end) in [("from", published.from), ("to", published.to)] {
                    if let Some(end) = end.filter(|end| !values.contains(end)) {
                        problems.add(place(key), end, format!("a value of the parameter: {}", list(&values)));
                    }
                }
            }
        }
        for (path, value) in &published.at {
            let Some(crossed) = find(path, true) else {
                let meant = did_you_mean(path, paths(true));
                problems.add(place("at"), path, format!("{meant}paths of `crossed` parameters"));
                continue;
            };
            let shown = (0..crossed.n_values().unwrap_or(0)).filter_map(|value| crossed.value(value));
            let shown: Vec<String> = shown.map(|pick| pick.shown.join(" ")).collect();
            if !shown.contains(value) {
                problems.add(join(&place("at"), path), format!("{value:?}"), list(&shown));
            }
        }
        let n_crossed = parameters.iter().filter(|parameter| parameter.crossed).count();
        if !published.difference_percent.is_empty() && n_crossed != 1 {
            let found = format!("beside {n_crossed} parameters that are `crossed`");
            problems.add(
                place("difference_percent"),
                found,
                "one parameter that is `crossed`, whose values differ",
            );
        }
        for (key, numbers) in [
            ("dependency_percent", &published.dependency_percent),
            ("difference_percent", &published.difference_percent),
        ] {
            for name in numbers.keys().filter(|name| !names.contains(name)) {
                let meant = did_you_mean(name, names.iter().map(String::as_str));
                problems.add(place(key), name, format!("{meant}names of numbers that the table has"));
            }
        }
    }
}

fn path(parameter: &Parameter) -> &str {
    &parameter.path
}

fn list<T: std::fmt::Display>(values: &[T]) -> String {
    values.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}
