//! What is compared: one scene in several variants, each checked like any scene.

use crate::case::Case;
use crate::problems::Problems;
use crate::scene::Source;
use crate::solver;

/// The pairs of cables and contact that are compared when no other is named.
pub const PAIRS: [&str; solver::PAIRS.len()] = {
    let mut names = [""; solver::PAIRS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = solver::PAIRS[i].2;
        i += 1;
    }
    names
};

/// Most variants of a comparison: a table and a plot of more cannot be read.
pub const MAX_VARIANTS: usize = 24;

/// One variant of the scene.
#[derive(Clone)]
pub struct Variant {
    /// Its name in tables and plots: `joints+impulse`, `solver.sweeps=4`.
    pub label: String,
    /// Which of the scenes that are compared it is of, from 0.
    pub scene: usize,
    /// What it changes, as for [`Source::set`].
    pub changes: Vec<String>,
    /// The checked scene, or why it cannot be run.
    pub case: Result<Case, Problems>,
}

/// One value along one axis of the comparison.
#[derive(Clone)]
struct Choice {
    label: String,
    changes: Vec<String>,
}

/// The variants of the scene `source`: every one of `solvers` with every value of every one of `vary`.
///
/// A solver pair is written `joints+rapier`, values `path.to.key=one,two`. Without `vary`, pairs left out
/// are all of [`PAIRS`], and one that the checks refuse stays in the list with its reason; what is
/// named must pass. With `vary`, pairs left out are the scene's own.
///
/// # Errors
/// Every fault of the arguments, of the scene itself, and of the variants that were named.
pub fn variants(
    source: &Source,
    solvers: Option<&[String]>,
    vary: &[String],
) -> Result<Vec<Variant>, Problems> {
    // The scene's own faults once, not once a variant.
    Case::build(source)?;

    let mut problems = Problems::new(&source.input);
    let mut axes: Vec<Vec<Choice>> = Vec::new();
    match solvers {
        Some(named) => axes.push(pairs(named, &mut problems)),
        None if vary.is_empty() => axes.push(pairs(&PAIRS.map(str::to_owned), &mut problems)),
        None => {}
    }
    axes.extend(vary.iter().map(|axis| values(axis, &mut problems)));
    let count: usize = axes.iter().map(Vec::len).product();
    if count > MAX_VARIANTS {
        problems.add("variants", count, format!("at most {MAX_VARIANTS} in one comparison"));
    }
    if !problems.list.is_empty() {
        return Err(problems);
    }

    let all_named = solvers.is_some() || !vary.is_empty();
    let mut variants = Vec::with_capacity(count);
    for choice in product(&axes) {
        let mut changed = source.clone();
        let case = changed.set(&choice.changes).and_then(|()| Case::build(&changed));
        if let (Err(refusal), true) = (&case, all_named) {
            for problem in &refusal.list {
                let place = format!("{}: {}", choice.label, problem.place);
                problems.add(place, &problem.found, &problem.allowed);
            }
        }
        variants.push(Variant { label: choice.label, scene: 0, changes: choice.changes, case });
    }
    if problems.list.is_empty() && variants.iter().all(|variant| variant.case.is_err()) {
        problems.add("--solvers", "only pairs that this scene refuses", PAIRS.join(", "));
    }
    problems.into_result(Some(variants))
}

/// The variants of several scenes, each named after its scene: as it is written where neither `solvers`
/// nor `vary` are named.
///
/// # Errors
/// Every fault of the arguments and of the first scene that has any.
pub fn of_scenes(
    sources: &[Source],
    solvers: Option<&[String]>,
    vary: &[String],
) -> Result<Vec<Variant>, Problems> {
    if let [source] = sources {
        return variants(source, solvers, vary);
    }
    let mut problems = Problems::new("compare");
    let mut all: Vec<Variant> = Vec::new();
    for (scene, source) in sources.iter().enumerate() {
        let of_scene = if solvers.is_none() && vary.is_empty() {
            vec![Variant { label: String::new(), scene, changes: Vec::new(), case: Ok(Case::build(source)?) }]
        } else {
            variants(source, solvers, vary)?
        };
        for variant in of_scene {
            let parts = [source.name.as_str(), variant.label.as_str()];
            let label = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ");
            if all.iter().any(|known| known.label == label) {
                problems.add("scenes", format!("{label}, twice"), "each scene once");
            }
            all.push(Variant { label, scene, ..variant });
        }
    }
    if all.len() > MAX_VARIANTS {
        problems.add("variants", all.len(), format!("at most {MAX_VARIANTS} in one comparison"));
    }
    problems.into_result(Some(all))
}

/// Solver pairs, written `cables+contact`.
fn pairs(named: &[String], problems: &mut Problems) -> Vec<Choice> {
    let mut choices: Vec<Choice> = Vec::new();
    let known: Vec<&str> = solver::PAIRS.iter().chain(&solver::ELEMENT_PAIRS).map(|pair| pair.2).collect();
    for pair in named {
        let Some((cables, contact)) = pair.split_once('+').filter(|_| known.contains(&pair.as_str())) else {
            let found = if pair.is_empty() { "an empty list or name" } else { pair };
            problems.add("--solvers", found, format!("pairs out of {}", known.join(", ")));
            continue;
        };
        let changes = vec![format!("solver.cables={cables}"), format!("solver.contact={contact}")];
        add(&mut choices, Choice { label: pair.clone(), changes }, "--solvers", problems);
    }
    choices
}

/// Values of one key, written `path.to.key=one,two`, or as a range `first:last:count`.
fn values(axis: &str, problems: &mut Problems) -> Vec<Choice> {
    let rule = "PATH=V1,V2,..., as in solver.step_s=0.0005,0.001, or a range, target.mass_kg=1:5:9";
    let Some((path, list)) = axis.split_once('=').filter(|(path, _)| !path.is_empty()) else {
        problems.add("--vary", format!("{axis:?}"), rule);
        return Vec::new();
    };
    let mut choices = Vec::new();
    for value in split_values(list).into_iter().flat_map(in_steps) {
        if value.is_empty() {
            problems.add("--vary", format!("{axis:?}, where a value is empty"), rule);
            continue;
        }
        let change = format!("{path}={value}");
        add(&mut choices, Choice { label: change.clone(), changes: vec![change] }, "--vary", problems);
    }
    choices
}

/// The values of a range `first:last:count`, evenly spaced; any other value alone.
fn in_steps(value: &str) -> Vec<String> {
    let range = || {
        let mut words = value.split(':');
        let (first, last) = (words.next()?.parse::<f64>().ok()?, words.next()?.parse::<f64>().ok()?);
        let count = words.next()?.parse::<u32>().ok().filter(|count| (2..=1000).contains(count))?;
        (words.next().is_none() && first.is_finite() && last.is_finite()).then_some((first, last, count))
    };
    let Some((first, last, count)) = range() else { return vec![value.to_owned()] };
    let share = |i: u32| f64::from(i) / f64::from(count - 1);
    (0..count).map(|i| (first + (last - first) * share(i)).to_string()).collect()
}

/// A variant named twice would be compared with itself.
fn add(choices: &mut Vec<Choice>, choice: Choice, option: &str, problems: &mut Problems) {
    if choices.iter().any(|known| known.label == choice.label) {
        problems.add(option, format!("{}, twice", choice.label), "each variant once");
    } else {
        choices.push(choice);
    }
}

/// Splits at commas, but not at those within a JSON list, object or text: `[0,0,1],[1,0,0]` is two values.
fn split_values(list: &str) -> Vec<&str> {
    let (mut depth, mut in_text, mut escaped, mut start) = (0_i32, false, false, 0);
    let mut values = Vec::new();
    for (place, character) in list.char_indices() {
        match character {
            '"' if !escaped => in_text = !in_text,
            '[' | '{' if !in_text => depth += 1,
            ']' | '}' if !in_text => depth -= 1,
            ',' if !in_text && depth <= 0 => {
                values.push(list[start..place].trim());
                start = place + 1;
            }
            _ => {}
        }
        escaped = in_text && character == '\\' && !escaped;
    }
    values.push(list[start..].trim());
    values
}

/// Every combination of one choice from each axis; the last axis turns fastest.
fn product(axes: &[Vec<Choice>]) -> Vec<Choice> {
    let start = vec![Choice { label: String::new(), changes: Vec::new() }];
    axes.iter().fold(start, |sofar, axis| {
        let both = |left: &Choice, right: &Choice| Choice {
            label: [left.label.as_str(), right.label.as_str()]
                .into_iter()
                .filter(|label| !label.is_empty())
                .collect::<Vec<_>>()
                .join(", "),
            changes: left.changes.iter().chain(&right.changes).cloned().collect(),
        };
        sofar.iter().flat_map(|left| axis.iter().map(move |right| both(left, right))).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(solvers: Option<&[&str]>, vary: &[&str]) -> Result<Vec<Variant>, Problems> {
        let owned = |list: &[&str]| list.iter().map(|&text| text.to_owned()).collect::<Vec<_>>();
        let source = Source::find("cubesat-free").unwrap();
        variants(&source, solvers.map(owned).as_deref(), &owned(vary))
    }

    fn labels(variants: &[Variant]) -> Vec<&str> {
        variants.iter().map(|variant| variant.label.as_str()).collect()
    }

    #[test]
    fn without_arguments_every_pair_is_listed_and_a_refused_one_keeps_its_reason() {
        let variants = of(None, &[]).unwrap();
        assert_eq!(labels(&variants), PAIRS);
        assert!(variants[0].case.is_ok());
        for variant in variants.iter().filter(|variant| variant.case.is_err()) {
            assert!(!variant.case.as_ref().err().unwrap().list.is_empty());
        }
    }

    #[test]
    fn values_of_several_keys_are_combined() {
        let variants =
            of(Some(&["joints+rapier"]), &["solver.sweeps=2,4", "launch.speed_m_s=1.5,2"]).unwrap();
        assert_eq!(variants.len(), 4);
        assert_eq!(variants[1].label, "joints+rapier, solver.sweeps=2, launch.speed_m_s=2");
        let case = variants[3].case.as_ref().unwrap();
        assert_eq!((case.scene().solver.sweeps, case.scene().launch.speed_m_s), (4, 2.0));
    }

    #[test]
    fn a_range_is_its_values() {
        assert_eq!(in_steps("0:2:5"), ["0", "0.5", "1", "1.5", "2"]);
        for other in ["0:2", "0:2:1", "0:2:x", "0:2:3:4", "a:b:3", "x", ""] {
            assert_eq!(in_steps(other), [other]);
        }
        let variants = of(None, &["target.mass_kg=1:2:3"]).unwrap();
        assert_eq!(labels(&variants), ["target.mass_kg=1", "target.mass_kg=1.5", "target.mass_kg=2"]);
    }

    #[test]
    fn a_list_is_one_value() {
        assert_eq!(split_values("[0,0,1], [1,0,0]"), ["[0,0,1]", "[1,0,0]"]);
        assert_eq!(split_values(r#"{"a":1,"b":"x,]y"},null"#), [r#"{"a":1,"b":"x,]y"}"#, "null"]);
        assert_eq!(split_values("a,,b,"), ["a", "", "b", ""]);
    }

    #[test]
    fn bad_arguments_are_named_with_what_is_allowed() {
        let said = |solvers: Option<&[&str]>, vary: &[&str], words: &str| {
            let said = of(solvers, vary).err().map(|problems| problems.to_string()).unwrap_or_default();
            assert!(said.contains(words), "{words:?} not in {said:?}");
        };
        said(Some(&["joints+magic"]), &[], "joints+magic; allowed: pairs out of joints+rapier");
        said(Some(&["joints"]), &[], "found joints;");
        said(Some(&[""]), &[], "an empty list");
        said(Some(&["joints+rapier", "joints+rapier"]), &[], "joints+rapier, twice");
        said(None, &["solver.sweeps="], "where a value is empty");
        said(None, &["solver.sweeps"], "allowed: PATH=V1,V2");
        said(None, &["solver.nothing=1,2"], "solver.nothing=1: solver.nothing: found an unknown key");
        said(None, &["net.meshes.7=1,2"], "no entry 7 in a list of 2");
        said(None, &["solver.sweeps=1,2,3,4,5", "solver.snap_passes=1,2,3,4,5"], "at most 24");
    }
}
