//! What the source says, and what this program finds: each claim of its chapters 3 to 5 beside the numbers of studies.
//!
//! `assets/reproduce.json` lists the claims, each with the study that is asked and how. No number of ours stands in it:
//! what is found comes from the rows of the studies, and so does whether it agrees.

pub mod finding;
pub mod spec;
pub mod tables;

use serde::{Deserialize, Serialize};

use crate::provenance::Provenance;
use finding::{ClaimAgreement, Finding};
use schemars::JsonSchema;
use spec::{Claim, SourceSays};

/// A claim, and what was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReproducedRow {
    /// Where the source says it: `Table 3.3`.
    pub place: String,
    /// What it says, or what is asked beyond it.
    pub says: String,
    /// Its answer.
    pub source: SourceSays,
    /// Ours.
    pub finding: Finding,
    /// Why they differ, as far as is known; empty where they do not.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub why: String,
    /// The command that ours comes from.
    pub command: String,
}

/// `reproduce.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Reproduction {
    /// Whether few members were run, and the dear studies not at all.
    pub quick: bool,
    /// Every claim.
    pub rows: Vec<ReproducedRow>,
    /// What made it.
    pub provenance: Provenance,
}

/// Stands where answers differ and nobody knows why: an empty place would look forgotten.
const UNKNOWN: &str = "No reason is known.";

/// The reason of a row with `finding`: nothing where answers do not differ.
fn why(finding: &Finding, known: Option<&str>) -> String {
    match finding.agreement {
        ClaimAgreement::Differs => known.unwrap_or(UNKNOWN).to_owned(),
        ClaimAgreement::Agrees | ClaimAgreement::Open => String::new(),
    }
}

impl ReproducedRow {
    /// `claim` with what was found of it.
    pub fn of(claim: &Claim, finding: Finding, command: String) -> ReproducedRow {
        ReproducedRow {
            place: claim.place.clone(),
            says: claim.says.clone(),
            source: claim.source.clone(),
            why: why(&finding, claim.why.as_deref()),
            finding,
            command,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::Kind;
    use crate::limits::Limits;
    use crate::metrics::summary::Summary;
    use crate::study::sweep::Sweep;
    use crate::study::sweep::outcome::MapOutcome;
    use spec::{Claims, Question};
    use std::collections::BTreeMap;

    /// Every claim asks a study that is there, a number that summaries have, an outcome that can be told.
    #[test]
    fn claims_ask_what_can_be_answered() {
        let claims = Claims::built_in();
        let (studies, names) = (Kind::Study.names(), Summary::scalar_names());
        assert!(claims.claims.len() > 60);
        for study in &claims.studies {
            assert!(studies.contains(&study.name.as_str()), "{}", study.name);
        }
        let sweep =
            |name: &str| Sweep::load(name, Limits::default()).unwrap_or_else(|faults| panic!("{faults}"));
        let sweeps: BTreeMap<&str, Sweep> =
            claims.studies.iter().map(|study| (study.name.as_str(), sweep(&study.name))).collect();
        for claim in &claims.claims {
            let Some(study) = claim.of.study() else { continue };
            for (path, values) in claim.of.points() {
                let parameter = sweeps[study].parameters().iter().find(|parameter| parameter.path == path);
                let parameter = parameter.unwrap_or_else(|| panic!("{study} has no {path}"));
                let shown: Vec<String> = (0..parameter.n_values().unwrap())
                    .map(|value| parameter.value(value).unwrap().shown.join(" "))
                    .collect();
                assert!(values.iter().all(|value| shown.contains(value)), "{study}: {values:?} of {shown:?}");
            }
            match &claim.of {
                Question::Outcome { is, .. } => drop(is.parse::<MapOutcome>().unwrap()),
                Question::Number { name, .. } | Question::Trend { name, .. } => {
                    assert!(names.contains(name), "{name}");
                }
                Question::Difference { .. } | Question::Cannot { .. } => {}
            }
        }
    }
}
