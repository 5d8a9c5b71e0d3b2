//! The claims as they are written: what the source says, and how it is asked here.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const BUILT_IN: &str = include_str!("../../../assets/reproduce.json");

/// `assets/reproduce.json`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claims {
    /// What the file is.
    #[serde(rename = "note")]
    _note: String,
    /// The studies, in the order in which they are run.
    pub studies: Vec<AskedStudy>,
    /// Why rows of tables that studies bring along differ.
    pub tables: Vec<TableReason>,
    /// Figures of the source that are drawn anew.
    pub figures: Vec<SourceFigure>,
    /// The claims.
    pub claims: Vec<Claim>,
}

/// A figure of the source that is drawn from runs of our own.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceFigure {
    /// Which: `5.3`.
    pub number: String,
    /// What it shows.
    pub title: String,
    /// Which figure of ours, as in `tumblenet figure --of`.
    pub of: String,
    /// The runs.
    pub runs: Vec<FigureRun>,
    /// Times of a strip [s]; absent: moments of the run.
    #[serde(default)]
    pub at: Vec<String>,
    /// Whether it is drawn in short, too.
    #[serde(default)]
    pub quick: bool,
}

impl SourceFigure {
    /// What `tumblenet figure` is told beside the folders of its runs.
    pub fn options(&self) -> String {
        let labels: Vec<&str> = self.runs.iter().map(|run| run.label.as_str()).collect();
        let is_told = |words: &[&str]| words.iter().any(|word| !word.is_empty());
        let at: Vec<&str> = self.at.iter().map(String::as_str).collect();
        let mut options = format!(" --of {}", self.of);
        for (name, words) in [("at", at), ("label", labels)] {
            if is_told(&words) {
                options += &format!(" --{name} '{}'", words.join(","));
            }
        }
        options
    }
}

/// A run of a figure of the source.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureRun {
    /// A built-in scene.
    pub scene: String,
    /// What tells it from the others of its figure; absent: nothing.
    #[serde(default)]
    pub label: String,
    /// The solver pair; absent: the source's own.
    #[serde(default = "source_pair")]
    pub pair: String,
}

/// The source's mass-spring net with its impulse-based contact.
fn source_pair() -> String {
    "explicit+impulse".to_owned()
}

impl FigureRun {
    /// Its scene with its pair, as `--set` takes it.
    pub fn changes(&self) -> Vec<String> {
        let parts = self.pair.split('+').zip(["cables", "contact"]);
        parts.map(|(name, part)| format!("solver.{part}={name}")).collect()
    }

    /// The name of its folder.
    pub fn folder(&self) -> String {
        format!("{}-{}", self.scene, self.pair)
    }
}

/// Why rows of a table that a study brings along differ, as far as is known.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableReason {
    /// Which table: `Table 3.3`.
    pub source: String,
    /// Rows of which parameter; empty: of any.
    pub path: String,
    /// In which of its groups.
    pub at: BTreeMap<String, String>,
    /// The reason.
    pub why: String,
}

/// A built-in study that claims ask.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AskedStudy {
    /// Its name.
    pub name: String,
    /// Members at each point; absent: as many as the study says.
    pub members: Option<u64>,
    /// What of it is run in short; absent: nothing.
    pub quick: Option<Quick>,
}

/// What of a study is run in short.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quick {
    /// Members at each point.
    pub members: u64,
}

/// Something that the source says, or that is asked beyond it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Where: `Section 5.2.1, Fig. 5.3`.
    pub place: String,
    /// What.
    pub says: String,
    /// How it is asked here.
    pub of: Question,
    /// The source's answer.
    pub source: SourceSays,
    /// Why ours is another, where it is, as far as is known.
    pub why: Option<String>,
}

/// How a claim is asked. `at` chooses points of a study: values of its parameters, as the table shows them, by path.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Question {
    /// Which share of the members has an outcome.
    Outcome {
        /// The study.
        study: String,
        /// `captured`, `settled`, `held@20`.
        is: String,
        /// Which points.
        at: BTreeMap<String, String>,
    },
    /// What a number of the summary is: the median of the members.
    Number {
        /// The study.
        study: String,
        /// The number.
        name: String,
        /// Its unit.
        unit: String,
        /// Which points.
        at: BTreeMap<String, String>,
    },
    /// How a number goes over the values of a parameter.
    Trend {
        /// The study.
        study: String,
        /// The number.
        name: String,
        /// Its unit.
        unit: String,
        /// Path of the parameter.
        over: String,
        /// Its values, in order.
        values: Vec<String>,
        /// Which points.
        at: BTreeMap<String, String>,
    },
    /// How far bullets are apart under two solver pairs, over the way of the net.
    Difference {
        /// A built-in scene.
        scene: String,
        /// The pairs.
        pairs: [String; 2],
    },
    /// It cannot be asked.
    Cannot {
        /// Why not.
        because: String,
    },
}

/// The source's answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SourceSays {
    /// It is so.
    Yes,
    /// It is not so.
    No,
    /// About this.
    About {
        /// The number.
        value: f64,
        /// Its unit.
        unit: String,
    },
    /// This, or less.
    AtMost {
        /// The number.
        value: f64,
        /// Its unit.
        unit: String,
    },
    /// More than this.
    Above {
        /// The number.
        value: f64,
        /// Its unit.
        unit: String,
    },
    /// The number rises over the values.
    Rises,
    /// The number falls over the values.
    Falls,
    /// It does not ask.
    NotAsked,
}

impl Claims {
    /// Those of the source.
    pub fn built_in() -> Claims {
        match serde_json::from_str(BUILT_IN) {
            Ok(claims) => claims,
            // Our own file, which a test reads.
            Err(error) => unreachable!("assets/reproduce.json: {error}"),
        }
    }
}

impl TableReason {
    /// Whether it is that of a row of `source`, about the parameter at `path`, in the group `at`.
    pub fn is_of(&self, source: &str, path: &str, at: &BTreeMap<String, String>) -> bool {
        let is_path = self.path.is_empty() || self.path == path;
        self.source == source && is_path && self.at.iter().all(|(path, value)| at.get(path) == Some(value))
    }
}

impl Question {
    /// The study that is asked, where one is.
    pub fn study(&self) -> Option<&str> {
        match self {
            Question::Outcome { study, .. }
            | Question::Number { study, .. }
            | Question::Trend { study, .. } => Some(study),
            Question::Difference { .. } | Question::Cannot { .. } => None,
        }
    }

    /// The values of parameters that it names, by path.
    #[cfg(test)]
    pub(super) fn points(&self) -> Vec<(&str, Vec<String>)> {
        let (at, over) = match self {
            Question::Outcome { at, .. } | Question::Number { at, .. } => (at, None),
            Question::Trend { at, over, values, .. } => (at, Some((over.as_str(), values.clone()))),
            Question::Difference { .. } | Question::Cannot { .. } => return Vec::new(),
        };
        at.iter().map(|(path, value)| (path.as_str(), vec![value.clone()])).chain(over).collect()
    }
}
