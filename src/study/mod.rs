//! Many runs: a study is a function from cases to summaries.

pub mod compare;
pub mod cost;
pub mod ensemble;
pub mod experiment;
pub mod log_rank;
pub mod reproduce;
pub mod settle;
pub mod stress;
pub mod survival;
pub mod sweep;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;

use crate::assets::Kind;
use crate::json;
use crate::limits::Limits;
use crate::problems::Problems;
use crate::read;
use crate::scene;

/// Reads the study file at `path`, or the built-in one of that name of a `kind` that has some, and makes of it what `check`
/// says; `known` is what may stand in its place.
///
/// # Errors
/// Every fault at once.
fn load<S: JsonSchema + DeserializeOwned + 'static, T>(
    path: &str,
    kind: Option<Kind>,
    known: &str,
    limits: Limits,
    check: impl FnOnce(S, &Path, Limits, &mut Problems) -> Option<T>,
) -> Result<T, Problems> {
    let mut problems = Problems::new(path);
    let file = Path::new(path);
    let instead =
        || kind.map_or_else(String::new, |kind| format!(", or a built-in one: {}", kind.instead_of(path)));
    let text = match kind.and_then(|kind| kind.text(path)) {
        Some(text) => Some(text.to_owned()),
        None => scene::read_text(file, &limits, || format!("{known}{}", instead()), &mut problems),
    };
    let written = text.and_then(|text| json::parse(&text, "", &mut problems));
    let spec = written.and_then(|value| read::typed::<S>(&value, "", &mut problems));
    let study = spec.and_then(|spec| check(spec, file, limits, &mut problems));
    problems.into_result(study)
}

/// What `run` makes; a panic in it, as the reason of a failure: no run takes the others of a batch with it.
pub fn caught<T>(run: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(run))
        .unwrap_or_else(|_| Err("a panic, which is a fault of the program".to_owned()))
}

/// Quantile of 97.5 % of the standard normal distribution: half an interval of 95 %, in standard deviations.
pub const Z: f64 = 1.959_963_984_540_054;
