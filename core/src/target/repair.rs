//! A shape with sound parts in the place of those that the schema refuses, so that what the others mean is checked
//! all the same.

use serde_json::{Value, json};

use super::files::Files;
use super::shape::FoundShape;
use super::spec::Shape;
use crate::problems::{Problem, Problems, join};
use crate::read;

/// Repairs `shape`, whose faults are at `places` below it; says what was replaced or left out, and nothing where a
/// part alone is not the fault.
pub fn repair<'a>(shape: &mut Value, places: impl Iterator<Item = &'a str>) -> Option<Vec<String>> {
    let mut repaired: Vec<String> = Vec::new();
    for place in places {
        let own = own(place)?;
        if repaired.iter().any(|known| known == own) {
            continue;
        }
        match index(own) {
            Some(index) => *shape["parts"].get_mut(index)? = json!({ "ball": { "radius_m": 0.05 } }),
            None => drop(shape.as_object_mut()?.shift_remove(own)),
        }
        repaired.push(own.to_owned());
    }
    Some(repaired)
}

/// The part, or the key of the shape, that `place` lies in; nothing for the list of parts itself.
fn own(place: &str) -> Option<&str> {
    let end = match place.strip_prefix("parts[") {
        Some(_) => place.find(']')? + 1,
        None => place.find(['.', '[', '(']).unwrap_or(place.len()),
    };
    let own = &place[..end];
    (!own.is_empty() && own != "parts").then_some(own)
}

/// `parts[3]`: 3.
fn index(place: &str) -> Option<usize> {
    place.strip_prefix("parts[")?.strip_suffix(']')?.parse().ok()
}

/// Whether one place is the other, or lies in it.
pub fn related(one: &str, other: &str) -> bool {
    let within = |inner: &str, outer: &str| {
        inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[', '(']))
    };
    within(one, other) || within(other, one)
}

/// Checks the sound parts of the shape `value`, a file that stands at `place`, in which the schema found `faults`.
pub fn check_others(
    value: &Value,
    faults: &[Problem],
    files: &Files<'_>,
    place: &str,
    problems: &mut Problems,
) {
    let mut value = value.clone();
    let below =
        |fault: &Problem| fault.place.strip_prefix(place).map(|rest| rest.trim_start_matches('.').to_owned());
    let Some(places) = faults.iter().map(below).collect::<Option<Vec<String>>>() else { return };
    let Some(repaired) = repair(&mut value, places.iter().map(String::as_str)) else { return };
    let Some(shape) = read::typed::<Shape>(&value, "", &mut Problems::new("")) else { return };
    let found =
        FoundShape { shape: std::borrow::Cow::Owned(shape), files: files.clone(), place: place.to_owned() };
    let mut meant = Problems::new("");
    super::solids(&found, &mut meant);
    let repaired: Vec<String> = repaired.iter().map(|own| join(place, own)).collect();
    for problem in meant.list {
        if !repaired.iter().any(|own| related(own, &problem.place)) {
            problems.add(problem.place, problem.found, problem.allowed);
        }
    }
}
