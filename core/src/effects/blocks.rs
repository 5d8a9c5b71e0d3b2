//! What effects say at the end of a run: a block of the summary each, and how tables show it.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::Effects;

/// A number of an effect's block, or a vector of three, as tables show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SummaryRow {
    /// Its key in the block.
    pub key: &'static str,
    /// What it is called in the table of a run.
    pub name: &'static str,
    /// The head of its column in the table of a comparison, in two lines; empty: it has none there.
    pub head: &'static str,
    /// The unit it is shown in.
    pub unit: &'static str,
    /// How many of that are one of the summary's own [-].
    pub scale: f64,
    /// What stands there when it never came to be.
    pub without: &'static str,
}

impl SummaryRow {
    /// A number that is shown in the summary's own unit, in the table of a run alone.
    pub const fn new(key: &'static str, name: &'static str, unit: &'static str) -> SummaryRow {
        SummaryRow { key, name, head: "", unit, scale: 1.0, without: "–" }
    }

    /// The same with a column in the table of a comparison under `head`.
    #[must_use]
    pub const fn compared(self, head: &'static str) -> SummaryRow {
        SummaryRow { head, ..self }
    }

    /// The same, `scale` of the unit shown being one of the summary's.
    #[must_use]
    pub const fn scaled(self, scale: f64) -> SummaryRow {
        SummaryRow { scale, ..self }
    }

    /// The same with what is said when it never came to be.
    #[must_use]
    pub const fn or(self, without: &'static str) -> SummaryRow {
        SummaryRow { without, ..self }
    }
}

/// Blocks of a summary by the name of the effect that has something to say, in the order of the effects. One from outside
/// of the list is there as well.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Blocks(pub Map<String, Value>);

impl Blocks {
    /// The block of effect `name`, where there is one.
    ///
    /// # Errors
    /// The block is not a `T`.
    pub fn get<T: DeserializeOwned>(&self, name: &str) -> serde_json::Result<Option<T>> {
        self.0.get(name).map(|block| serde_json::from_value(block.clone())).transpose()
    }
}

/// What the effects of the list may say; blocks of others are open.
impl JsonSchema for Blocks {
    fn schema_name() -> Cow<'static, str> {
        "Blocks".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let blocks: Map<String, Value> = Effects::summaries(generator)
            .into_iter()
            .map(|(name, schema)| (name.to_owned(), schema.to_value()))
            .collect();
        schemars::json_schema!({ "type": "object", "properties": blocks })
    }
}
