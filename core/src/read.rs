//! Reading a JSON input against its own schema: every fault at once, then the typed value.
//!
//! The schema is generated from the type (`schemars`) and checked by a JSON Schema validator, so
//! types, unknown keys, missing keys and limits of single values need no code of ours. What is
//! left to us is to say them in words, with the place in the file.

use std::any::{TypeId, type_name};
use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex};

use jsonschema::error::{TypeKind, ValidationErrorKind as Kind};
use jsonschema::{ValidationError, Validator};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::json::{self, NegativeZero};
use crate::problems::Problems;
pub use crate::problems::join;
use crate::problems::nearest;
use crate::spelling;

/// The JSON Schema of `T`.
pub fn schema<T: JsonSchema>() -> Value {
    let mut schema = schemars::schema_for!(T).to_value();
    bound_whole_numbers(&mut schema);
    schema
}

/// The JSON Schema of `T` where a user writes it: with notes, and angles and rates in other ways.
pub fn input_schema<T: JsonSchema>() -> Value {
    let mut schema = schema::<T>();
    spelling::allow(&mut schema);
    schema
}

/// The schema that a user's `T` is checked against, and what checks it: made once, since a sweep reads a scene for each
/// member.
fn compiled<T: JsonSchema + 'static>() -> Arc<(Value, Validator)> {
    type Known = HashMap<TypeId, Arc<(Value, Validator)>>;
    static KNOWN: LazyLock<Mutex<Known>> = LazyLock::new(Mutex::default);
    let mut known = KNOWN.lock().unwrap_or_else(|poison| poison.into_inner());
    let compile = || {
        let schema = input_schema::<T>();
        match jsonschema::validator_for(&schema) {
            Ok(validator) => Arc::new((schema, validator)),
            // Our own schema: a fault in it is caught by the test below for every type that is read.
            Err(error) => unreachable!("the schema of {} is invalid: {error}", type_name::<T>()),
        }
    };
    known.entry(TypeId::of::<T>()).or_insert_with(compile).clone()
}

/// States the largest number of every type of whole numbers, which the generator leaves out: of JSON's, where the type
/// has larger ones.
fn bound_whole_numbers(schema: &mut Value) {
    match schema {
        Value::Array(list) => list.iter_mut().for_each(bound_whole_numbers),
        Value::Object(map) => {
            let most = match map.get("format").and_then(Value::as_str) {
                Some("uint8") => u8::MAX.into(),
                Some("uint16") => u16::MAX.into(),
                Some("uint32") => u32::MAX.into(),
                Some("uint64" | "uint") => json::LARGEST_WHOLE,
                _ => 0,
            };
            if most > 0 && !map.contains_key("maximum") {
                map.insert("maximum".to_owned(), most.into());
            }
            map.values_mut().for_each(bound_whole_numbers);
        }
        _ => {}
    }
}

/// Checks `value` against the schema of `T` and reads it; all faults go to `problems`, with their
/// places below `place`.
pub fn typed<T: JsonSchema + DeserializeOwned + 'static>(
    value: &Value,
    place: &str,
    problems: &mut Problems,
) -> Option<T> {
    let compiled = compiled::<T>();
    let (schema, validator) = &*compiled;
    if !validator.is_valid(value) {
        let faults = problems.list.len();
        let short = shortened(value, &mut { MOST_VALUES });
        for error in validator.iter_errors(&short) {
            explain(&error, schema, place, problems);
        }
        if problems.list.len() == faults {
            // Past what was kept.
            problems.add(place, "a fault late in a long list", "a list whose entries are all alike");
        }
        return None;
    }
    let (mut value, known) = (json::with_whole_numbers(value, NegativeZero::Kept), problems.list.len());
    spelling::plain(&mut value, place, problems);
    if problems.list.len() > known {
        return None;
    }
    let read = T::deserialize(&value);
    // A negative zero where a whole number is wanted is 0.
    match read.or_else(|_| serde_json::from_value(json::with_whole_numbers(&value, NegativeZero::Whole))) {
        Ok(typed) => Some(typed),
        // The schema is the stricter of the two, but a gap between them must not be a panic.
        Err(error) => {
            problems.add(place, "a value the schema lets pass", error.to_string());
            None
        }
    }
}

/// Values that are looked through for every single fault. The validator copies a value with its
/// faults once a level, so that a million wrong entries take gigabytes.
const MOST_VALUES: usize = 3_000;

/// A value whose long lists end where `left` values are copied; short ones stay whole, for a list
/// that is cut is too short by itself.
fn shortened(value: &Value, left: &mut usize) -> Value {
    const SHORT: usize = 16;
    *left = left.saturating_sub(1);
    match value {
        Value::Array(list) => {
            let kept = list
                .iter()
                .enumerate()
                .map_while(|(index, inner)| (index < SHORT || *left > 0).then(|| shortened(inner, left)));
            kept.collect()
        }
        Value::Object(map) => map.iter().map(|(key, inner)| (key.clone(), shortened(inner, left))).collect(),
        other => other.clone(),
    }
}

/// Says one validation error in words: place, value found, what is allowed.
fn explain(error: &ValidationError<'_>, schema: &Value, root: &str, problems: &mut Problems) {
    let place = join(root, &keys(error.instance_path().as_str()));
    let found = describe(error.instance());
    let mut add = |allowed: String| problems.add(&place, &found, allowed);
    match error.kind() {
        Kind::AdditionalProperties { unexpected } => {
            let known = known_keys(schema, error.schema_path().as_str());
            for key in unexpected {
                if problems.is_full() {
                    break;
                }
                let meant = nearest(key, known.iter().map(String::as_str));
                let meant =
                    meant.map_or_else(String::new, |meant| format!("did you mean {meant}? Keys here: "));
                problems.add(join(&place, key), "an unknown key", format!("{meant}{}", known.join(", ")));
            }
        }
        Kind::Required { property } => {
            let key = property.as_str().unwrap_or_default();
            problems.add(join(&place, key), "nothing", "this key must be given");
        }
        Kind::AnyOf { context } | Kind::OneOfNotValid { context } => {
            explain_choice(error, context, schema, root, problems);
        }
        Kind::Constant { expected_value } => add(expected_value.to_string()),
        Kind::Enum { options } => add(one_of(options.as_array().into_iter().flatten())),
        Kind::ExclusiveMinimum { limit } => add(format!("a number above {limit}")),
        Kind::Minimum { limit } => add(format!("a number of at least {limit}")),
        Kind::ExclusiveMaximum { limit } => add(format!("a number below {limit}")),
        Kind::Maximum { limit } => add(format!("a number of at most {limit}")),
        Kind::MinItems { limit } => add(format!("at least {limit} entries")),
        Kind::MaxItems { limit } => add(format!("at most {limit} entries")),
        Kind::Type { kind } => add(type_names(kind)),
        // Two ways to say the same.
        Kind::Not { schema } => {
            let keys = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
            let keys: Vec<&str> = keys.collect();
            let last = keys.last().copied().unwrap_or_default();
            problems.add(join(&place, last), format!("both {}", keys.join(" and ")), "one of them");
        }
        other => add(format!("what the rule `{}` says: {error}", other.keyword())),
    }
}

/// A value that fits none of several forms: the form it was most likely meant to be is explained,
/// where one has the right JSON type; else all forms are named.
fn explain_choice(
    error: &ValidationError<'_>,
    context: &[Vec<ValidationError<'static>>],
    schema: &Value,
    root: &str,
    problems: &mut Problems,
) {
    let here = error.instance_path().as_str();
    let wrong_type =
        |fault: &ValidationError<'_>| matches!(fault.kind(), Kind::Type { .. }) && is_here(fault, here);
    let constants: Vec<&Value> = context
        .iter()
        .filter_map(|branch| match branch.first()?.kind() {
            Kind::Constant { expected_value } => Some(expected_value.as_ref()),
            _ => None,
        })
        .collect();
    let place = join(root, &keys(here));
    if constants.len() == context.len() {
        problems.add(place, describe(error.instance()), one_of(constants.into_iter()));
    } else if let Some(meant) = context
        .iter()
        .filter(|branch| !branch.iter().any(wrong_type))
        // Of forms that a word tells apart, the one whose word is given.
        .min_by_key(|branch| (branch.iter().any(is_constant), branch.len()))
    {
        // The faults of a branch carry places relative to the file, as the outer error does.
        for fault in meant {
            explain(fault, schema, root, problems);
        }
    } else {
        let mut forms: Vec<String> = context
            .iter()
            .filter_map(|branch| match branch.iter().find(|fault| wrong_type(fault))?.kind() {
                Kind::Type { kind } => Some(type_names(kind)),
                _ => None,
            })
            .filter(|form| form != "null")
            .collect();
        forms.dedup();
        problems.add(place, describe(error.instance()), forms.join(" or "));
    }
}

fn is_constant(fault: &ValidationError<'_>) -> bool {
    matches!(fault.kind(), Kind::Constant { .. })
}

fn is_here(fault: &ValidationError<'_>, here: &str) -> bool {
    fault.instance_path().as_str() == here
}

/// `/net/meshes/0` as `net.meshes[0]`.
fn keys(pointer: &str) -> String {
    let mut path = String::new();
    for part in pointer.split('/').skip(1) {
        let part = part.replace("~1", "/").replace("~0", "~");
        if !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()) {
            path.push_str(&format!("[{part}]"));
        } else {
            path = join(&path, &part);
        }
    }
    path
}

fn describe(value: &Value) -> String {
    match value {
        Value::Object(map) if map.len() > 3 => format!("an object of {} keys", map.len()),
        Value::Array(list) if list.len() > 6 => format!("a list of {} entries", list.len()),
        other => other.to_string(),
    }
}

/// The keys that the schema object of a failed `additionalProperties` does allow.
fn known_keys(schema: &Value, schema_path: &str) -> Vec<String> {
    let parent = schema_path.rsplit_once('/').map_or("", |(parent, _)| parent);
    let object = schema.pointer(parent);
    let known = object.and_then(|object| object["properties"].as_object());
    known.into_iter().flat_map(Map::keys).cloned().collect()
}

fn one_of<'a>(options: impl Iterator<Item = &'a Value>) -> String {
    options.map(ToString::to_string).collect::<Vec<_>>().join(" or ")
}

fn type_names(kind: &TypeKind) -> String {
    let name = |name: &str| match name {
        "object" => "an object".to_owned(),
        "array" => "a list".to_owned(),
        "integer" => "a whole number".to_owned(),
        "number" => "a number".to_owned(),
        "string" => "a text".to_owned(),
        "boolean" => "true or false".to_owned(),
        other => other.to_owned(),
    };
    match kind {
        TypeKind::Single(single) => name(single.as_str()),
        TypeKind::Multiple(several) => several
            .iter()
            .map(|one| name(one.as_str()))
            .filter(|one| one != "null")
            .collect::<Vec<_>>()
            .join(" or "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::schema::Scene;
    use serde_json::json;

    fn faults(value: Value) -> Vec<String> {
        let mut problems = Problems::new("test");
        let read = typed::<Scene>(&value, "", &mut problems);
        assert_eq!(read.is_none(), !problems.list.is_empty());
        problems.list.iter().map(|p| format!("{}: {}; {}", p.place, p.found, p.allowed)).collect()
    }

    fn scene() -> Value {
        json!({
            "title": "t", "duration_s": 1.0,
            "net": { "meshes": [2, 2], "mesh_length_m": 1.0, "bullet_mass_kg": 1.0,
                     "cable": { "material": "kevlar", "diameter_m": 0.001 } },
            "launch": { "speed_m_s": 1.0, "angle_deg": 30.0 }
        })
    }

    #[test]
    fn a_sound_scene_has_no_faults() {
        assert_eq!(faults(scene()), Vec::<String>::new());
    }

    #[test]
    fn every_fault_is_named_with_place_value_and_rule() {
        let mut bad = scene();
        bad["colour"] = json!("red");
        bad["net"]["meshes"] = json!([0, 2]);
        bad["net"]["bullet_mass_kg"] = json!(-1);
        bad["net"]["cable"]["material"] = json!({ "young_modulus_pa": 1.0 });
        bad["net"]["fold"] = json!({ "scheme": "rolled", "ratio": 2 });
        bad["launch"] = json!(7);
        bad.as_object_mut().unwrap().remove("title");
        let faults = faults(bad);
        for expected in [
            "title: nothing; this key must be given",
            "net.meshes[0]: 0; a number of at least 1",
            "net.bullet_mass_kg: -1; a number above 0",
            "net.cable.material.density_kg_m3: nothing; this key must be given",
            "net.fold.scheme: \"rolled\"; \"scaled\" or \"inwards\"",
            "net.fold.ratio: 2; a number of at most 1",
            "launch: 7; an object",
        ] {
            assert!(faults.iter().any(|fault| fault == expected), "{expected} not in {faults:#?}");
        }
        let unknown = faults.iter().find(|fault| fault.starts_with("colour: an unknown key")).unwrap();
        assert!(unknown.contains("duration_s"), "names the known keys: {unknown}");
    }

    #[test]
    fn a_fault_late_in_a_long_list_is_found() {
        let mut bad = scene();
        let mut points = vec![json!([0, 0, 0]); 5000];
        points[654] = json!("x");
        bad["target"] =
            json!({ "shape": { "parts": [{ "convex": { "points_m": points } }] }, "distance_m": 1 });
        let late = faults(bad.clone());
        assert_eq!(late.len(), 1, "{late:#?}");
        assert!(late[0].contains("points_m[654]"), "{late:#?}");
        let mut points = vec![json!([0, 0, 0]); 100_000];
        points[99_999] = json!("x");
        bad["target"]["shape"]["parts"][0]["convex"]["points_m"] = points.into();
        assert_eq!(faults(bad.clone()).len(), 1);
        bad["target"]["shape"]["parts"][0]["convex"]["points_m"] = vec![json!("x"); 5000].into();
        let many = faults(bad);
        assert_eq!(many.len(), 100, "as many as are kept");
        assert!(many[99].contains("points_m[99]"), "{}", many[99]);
    }

    #[test]
    fn a_value_of_no_form_names_all_forms() {
        let mut bad = scene();
        bad["net"]["mesh_length_m"] = json!("long");
        bad["net"]["cable"]["material"] = json!(3);
        let faults = faults(bad);
        assert!(
            faults.contains(&"net.mesh_length_m: \"long\"; a number or a list".to_owned()),
            "{faults:#?}"
        );
        assert!(faults.contains(&"net.cable.material: 3; a text or an object".to_owned()), "{faults:#?}");
    }
}
