//! Numbers that carry their limits, so that the schema states them and the code may rely on them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number above zero, in the unit of its key.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Positive(#[schemars(extend("exclusiveMinimum" = 0))] pub f64);
