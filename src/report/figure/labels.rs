//! Short names of runs that are shown together: what varies between their folders, and nothing else.

use std::path::Path;

use crate::problems::Problems;

/// What parts the words of a folder's name.
const BETWEEN: [char; 5] = ['-', '_', ' ', '/', '\\'];

/// The names `given`, or where there are none those [`of`] `folders`; too few or too many are a fault, and so are more runs
/// than `most`, where `why` says what is wrong with more.
pub fn given_or_of(
    given: &[String],
    folders: &[&Path],
    (most, why): (usize, &str),
    problems: &mut Problems,
) -> Vec<String> {
    let n_runs = folders.len();
    if n_runs > most {
        problems.add("RUN", format!("{n_runs} runs"), format!("at most {most}{why}"));
    }
    if given.is_empty() {
        return of(folders);
    }
    if given.len() != n_runs {
        let found = format!("{} labels", given.len());
        problems.add("--label", found, format!("one for each of {n_runs} runs"));
    }
    given.to_vec()
}

/// A name for each of `folders`, all different; for one alone none.
pub fn of(folders: &[&Path]) -> Vec<String> {
    if folders.len() < 2 {
        return vec![String::new(); folders.len()];
    }
    let names: Vec<String> = folders.iter().map(|folder| folder.display().to_string()).collect();
    let words: Vec<Vec<&str>> =
        names.iter().map(|name| name.split(BETWEEN).filter(|word| !word.is_empty()).collect()).collect();
    let shortest = words.iter().map(Vec::len).min().unwrap_or(0);
    let alike = |at: &dyn Fn(&[&str]) -> String| words.iter().all(|name| at(name) == at(&words[0]));
    let first = (0..shortest).take_while(|&i| alike(&|name| name[i].to_owned())).count();
    let last =
        (0..shortest - first).take_while(|&i| alike(&|name| name[name.len() - 1 - i].to_owned())).count();
    let mut short: Vec<String> = words.iter().map(|name| name[first..name.len() - last].join(" ")).collect();
    for (label, (words, name)) in short.iter_mut().zip(words.iter().zip(&names)) {
        // Where one name is within another nothing is left of it.
        if label.is_empty() {
            *label = words.last().map_or_else(|| name.clone(), |word| (*word).to_owned());
        }
    }
    // Where two are the same, a number tells them apart.
    let plain = short.clone();
    for (i, label) in short.iter_mut().enumerate() {
        let before = plain[..i].iter().filter(|other| **other == plain[i]).count();
        if before > 0 {
            *label = format!("{label} ({})", before + 1);
        }
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(folders: &[&str]) -> Vec<String> {
        of(&folders.iter().map(Path::new).collect::<Vec<_>>())
    }

    #[test]
    fn a_label_holds_only_what_varies() {
        let spins = ["results/cubesat-spin-x-1.0", "results/cubesat-spin-x-2.0"];
        assert_eq!(labels(&spins), ["1.0", "2.0"]);
        let solvers = ["a/joints+rapier/run", "a/explicit+impulse/run"];
        assert_eq!(labels(&solvers), ["joints+rapier", "explicit+impulse"]);
        assert_eq!(labels(&["x/coarse", "y/fine"]), ["x coarse", "y fine"]);
        assert_eq!(labels(&["one"]), [""]);
    }

    #[test]
    fn labels_differ_and_are_never_empty() {
        assert_eq!(labels(&["spin-2.0", "spin-2.0-tube"]), ["2.0", "tube"]);
        assert_eq!(labels(&["a", "a", "a"]), ["a", "a (2)", "a (3)"]);
    }
}
