//! Every fault of an input: its place in the file, the value found, and what is allowed.

use std::borrow::Cow;
use std::fmt;

/// One fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Place in the file, as a path of keys: `target.shape.parts[2].cuboid`.
    pub place: String,
    /// What stands there, as the user wrote it.
    pub found: String,
    /// What may stand there.
    pub allowed: String,
}

/// Most faults that are kept: nobody reads more, and a list of a million wrong entries has as many.
const MAX_FAULTS: usize = 100;

/// All faults of one input.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Problems {
    /// File or name of the input.
    pub input: String,
    /// The faults, in the order they were found.
    pub list: Vec<Problem>,
}

impl Problems {
    /// No faults yet in `input`.
    pub fn new(input: impl Into<String>) -> Self {
        Problems { input: input.into(), list: Vec::new() }
    }

    /// Whether so many faults are known that no more are kept.
    pub fn is_full(&self) -> bool {
        self.list.len() >= MAX_FAULTS
    }

    /// Adds a fault; a fault already known at the same place with the same words is kept once.
    pub fn add(&mut self, place: impl Into<String>, found: impl fmt::Display, allowed: impl Into<String>) {
        if self.is_full() {
            return;
        }
        let shown = |text: String| visible(&text, false).into_owned();
        let problem = Problem {
            place: shown(shorten(&place.into())),
            found: shown(shorten(&found.to_string())),
            allowed: allowed.into(),
        };
        if !self.list.contains(&problem) {
            self.list.push(problem);
        }
    }

    /// Adds `faults` of what stands at `above`.
    pub fn add_below(&mut self, above: &str, faults: Problems) {
        for fault in faults.list {
            self.add(join(above, &fault.place), fault.found, fault.allowed);
        }
    }

    /// All of them in one line, for a table.
    pub fn in_a_line(&self) -> String {
        self.to_string().replace("\n  ", " ")
    }

    /// `value` when nothing was found, else the faults.
    ///
    /// # Errors
    /// The faults found so far.
    pub fn into_result<T>(self, value: Option<T>) -> Result<T, Problems> {
        match value {
            Some(value) if self.list.is_empty() => Ok(value),
            _ => Err(self),
        }
    }
}

/// `text` without what a terminal would obey: control characters, and marks that turn the direction of
/// writing, become `\\u` and their number, as JSON writes them. Line ends stay with `lines` only.
pub fn visible(text: &str, lines: bool) -> Cow<'_, str> {
    let obeyed = |c: char| match c {
        '\n' | '\t' => !lines,
        '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => true,
        _ => c.is_control(),
    };
    if !text.chars().any(obeyed) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if obeyed(c) {
            shown.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// A long value (a whole mesh, say) is cut, so that the place and the rule stay readable.
fn shorten(found: &str) -> String {
    const MAX: usize = 120;
    if found.chars().count() <= MAX {
        return found.to_owned();
    }
    let head: String = found.chars().take(MAX).collect();
    format!("{head}…")
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let n = self.list.len();
        let more = if self.is_full() { " or more" } else { "" };
        write!(f, "{}: {n} fault{}{more}", self.input, if n == 1 { "" } else { "s" })?;
        for problem in &self.list {
            let place = if problem.place.is_empty() { "(top level)" } else { &problem.place };
            write!(f, "\n  {place}: found {}; allowed: {}", problem.found, problem.allowed)?;
        }
        Ok(())
    }
}

/// The word of `known` that `word` was most likely meant to be, if it is like one.
pub fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    /// Jaro's likeness from which a word is taken for a slip: `cubesat-fre` has 0.97 to `cubesat-free`, `moon` 0.63 to
    /// `nylon`.
    const LIKE: f64 = 0.8;
    // The comparison takes the square of the length.
    if word.len() > 100 {
        return None;
    }
    let likeness = known.map(|known| (strsim::jaro(word, known), known));
    let best = likeness.max_by(|one, other| one.0.total_cmp(&other.0));
    best.filter(|(likeness, _)| *likeness >= LIKE).map(|(_, known)| known)
}

/// `did you mean X? ` where a word of `known` is like `word`, else nothing.
pub fn did_you_mean<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> String {
    nearest(word, known).map_or_else(String::new, |meant| format!("did you mean {meant}? "))
}

/// Path `below` under path `above`.
pub fn join(above: &str, below: &str) -> String {
    match (above.is_empty(), below.is_empty()) {
        (true, _) => below.to_owned(),
        (_, true) => above.to_owned(),
        _ if below.starts_with('[') => format!("{above}{below}"),
        _ => format!("{above}.{below}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_written_out() {
        assert_eq!(visible("ä\t1\n", true), "ä\t1\n");
        assert_eq!(
            visible("a\u{1b}[31mb\n\u{9b}\u{7f}\r\u{202e}", false),
            "a\\u001b[31mb\\u000a\\u009b\\u007f\\u000d\\u202e"
        );
        let mut problems = Problems::new("test");
        problems.add("a\u{7}", "line 1: \u{1b}[2J", "no such thing");
        assert!(problems.to_string().contains("a\\u0007: found line 1: \\u001b[2J;"), "{problems}");
    }

    #[test]
    fn a_slip_is_told_from_another_word() {
        let known =
            || ["cubesat-free", "cubesat-spin-x-2.0", "kevlar", "nylon", "bullet_mass_kg"].into_iter();
        assert_eq!(nearest("cubesat-fre", known()), Some("cubesat-free"));
        assert_eq!(nearest("kelvar", known()), Some("kevlar"));
        assert_eq!(nearest("bulet_mass", known()), Some("bullet_mass_kg"));
        assert_eq!(nearest("moon", known()), None);
        assert_eq!(nearest("", known()), None);
        assert_eq!(nearest(&"cubesat".repeat(1000), known()), None);
    }

    #[test]
    fn names_input_place_value_and_rule() {
        let mut problems = Problems::new("scene.json");
        problems.add("net.bullet_mass_kg", -1.0, "a number above 0");
        problems.add("net.bullet_mass_kg", -1.0, "a number above 0");
        assert_eq!(
            problems.to_string(),
            "scene.json: 1 fault\n  net.bullet_mass_kg: found -1; allowed: a number above 0"
        );
        assert!(problems.into_result(Some(())).is_err());
    }
}
