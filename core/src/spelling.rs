//! Other ways to write what a scene says: degrees a second for radians a second, a quaternion for three turns, and
//! notes that mean nothing. They are read, and gone: a scene that says the same is the same, to the last bit.

use std::f64::consts::PI;

use nalgebra::{Quaternion, Rotation3, UnitQuaternion};
use serde_json::{Map, Value, json};

use crate::problems::{Problems, join};

/// The key of a remark, a text or a list of texts, which any object may have.
const NOTE: &str = "note";

/// Turns about three axes [deg], and the same as a quaternion (w, x, y, z).
const TURNS: &str = "attitude_deg";
const QUATERNION: &str = "attitude_wxyz";

/// How far the length of a quaternion may be from 1 [-]: four digits of each of its numbers.
const SLACK: f64 = 1e-3;

/// The key that says the same as `key` in another way.
pub fn other(key: &str) -> Option<String> {
    match key {
        TURNS => Some(QUATERNION.to_owned()),
        QUATERNION => Some(TURNS.to_owned()),
        _ => {
            let to = |from: &str, to: &str| Some(format!("{}{to}", key.strip_suffix(from)?));
            to("_rad_s", "_deg_s").or_else(|| to("_deg_s", "_rad_s"))
        }
    }
}

/// Lets every object of `schema` have a note, and its angles and rates in the other way, but not in both.
pub fn allow(schema: &mut Value) {
    match schema {
        Value::Array(list) => list.iter_mut().for_each(allow),
        Value::Object(map) => {
            map.values_mut().for_each(allow);
            if map.get("additionalProperties") == Some(&Value::Bool(false)) {
                allow_in(map);
            }
        }
        _ => {}
    }
}

/// The same for the object that `schema` describes.
fn allow_in(schema: &mut Map<String, Value>) {
    let properties = schema.entry("properties").or_insert_with(|| json!({}));
    let Some(properties) = properties.as_object_mut() else { return };
    let mut pairs = Vec::new();
    let written: Vec<String> = properties.keys().cloned().collect();
    for key in written {
        let Some(other) = other(&key) else { continue };
        let mut same = properties[&key].clone();
        if key == TURNS {
            let numbers = json!({ "type": "number", "format": "double" });
            same = json!({ "type": "array", "items": numbers, "minItems": 4, "maxItems": 4 });
            same["description"] =
                format!("The same as a unit quaternion [w, x, y, z], in place of `{key}`.").into();
        } else {
            same["description"] = format!("The same in deg/s, in place of `{key}`.").into();
            in_degrees(&mut same["items"]);
        }
        if let Some(map) = same.as_object_mut() {
            map.shift_remove("default");
        }
        properties.insert(other.clone(), same);
        pairs.push(json!({ "not": { "required": [key, other] } }));
    }
    let texts = json!({ "type": "array", "items": { "type": "string" } });
    let note =
        json!({ "description": "A remark; nothing comes of it.", "anyOf": [{ "type": "string" }, texts] });
    properties.insert(NOTE.to_owned(), note);
    if !pairs.is_empty() {
        match schema.get_mut("allOf").and_then(Value::as_array_mut) {
            Some(all) => all.extend(pairs),
            None => drop(schema.insert("allOf".to_owned(), pairs.into())),
        }
    }
}

/// States the limits of a number in degrees.
fn in_degrees(number: &mut Value) {
    for limit in ["minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"] {
        if let Some(value) = number.get(limit).and_then(Value::as_f64) {
            number[limit] = value.to_degrees().into();
        }
    }
}

/// Writes what `value`, which stands at `place`, says in the way that the types are written in, and leaves notes out.
/// A quaternion of another length than 1 is a fault.
pub fn plain(value: &mut Value, place: &str, problems: &mut Problems) {
    match value {
        Value::Array(list) => {
            for (index, inner) in list.iter_mut().enumerate() {
                // A path only where there may be something to tell.
                if inner.is_object() || inner.is_array() {
                    plain(inner, &format!("{place}[{index}]"), problems);
                }
            }
        }
        Value::Object(map) => {
            if map.get(NOTE).is_some_and(is_note) {
                map.shift_remove(NOTE);
            }
            let keys: Vec<String> = map.keys().cloned().collect();
            for key in keys {
                if let Some(inner) = map.get_mut(&key).filter(|inner| inner.is_object() || inner.is_array()) {
                    plain(inner, &join(place, &key), problems);
                }
                if key == QUATERNION {
                    check_length(&map[&key], &join(place, &key), problems);
                    respell(map, TURNS);
                } else if let Some(of) = key.strip_suffix("_deg_s") {
                    respell(map, &format!("{of}_rad_s"));
                }
            }
        }
        _ => {}
    }
}

fn is_note(value: &Value) -> bool {
    value.is_string() || value.as_array().is_some_and(|list| list.iter().all(Value::is_string))
}

fn check_length(quaternion: &Value, place: &str, problems: &mut Problems) {
    let Some([w, x, y, z]) = numbers(quaternion) else { return };
    let length = Quaternion::new(w, x, y, z).norm();
    if !((1.0 - SLACK)..=(1.0 + SLACK)).contains(&length) {
        problems.add(
            place,
            format!("{quaternion}, of length {length}"),
            "a quaternion [w, x, y, z] of length 1",
        );
    }
}

/// Writes what `object` says with the other key of `key` with `key` itself; nothing where it says nothing, or already
/// has that key. Turns have no quaternion made of them: the other is left out.
pub fn respell(object: &mut Map<String, Value>, key: &str) {
    let Some(said) = other(key).and_then(|other| object.shift_remove(&other)) else { return };
    if object.contains_key(key) {
        return;
    }
    let spelt = match key {
        QUATERNION => None,
        TURNS => turns(&said),
        _ if key.ends_with("_deg_s") => each(&said, f64::to_degrees),
        _ => each(&said, f64::to_radians),
    };
    if let Some(spelt) = spelt {
        object.insert(key.to_owned(), spelt);
    }
}

/// A number, or each of a list, changed.
pub fn each(value: &Value, change: fn(f64) -> f64) -> Option<Value> {
    match value {
        Value::Array(list) => list.iter().map(|inner| each(inner, change)).collect(),
        _ => Some(change(value.as_f64()?).into()),
    }
}

fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let list: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    list?.try_into().ok()
}

fn turns(quaternion: &Value) -> Option<Value> {
    let [w, x, y, z] = numbers(quaternion)?;
    Some(json!(turns_of(&UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.0)?)))
}

/// Turns about x, then y, then z [deg] that make `turn`.
///
/// R = Rx(a) Ry(b) Rz(c): the first row is (cos b cos c, −cos b sin c, sin b). Where cos b is nothing only a + c
/// matters; so a is taken from R Rz(−c), whose second column is (0, cos a, sin a), whatever c is.
pub fn turns_of(turn: &UnitQuaternion<f64>) -> [f64; 3] {
    let r = *turn.to_rotation_matrix().matrix();
    let c = if r[(0, 0)].hypot(r[(0, 1)]) > 0.0 { (-r[(0, 1)]).atan2(r[(0, 0)]) } else { 0.0 };
    let rest = r * Rotation3::from_euler_angles(0.0, 0.0, -c).matrix();
    let (a, b) = (rest[(2, 1)].atan2(rest[(1, 1)]), rest[(0, 2)].atan2(rest[(0, 0)]));
    [a, b, c].map(|angle: f64| angle * (180.0 / PI))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn read(mut value: Value) -> (Value, Vec<String>) {
        let mut problems = Problems::new("test");
        plain(&mut value, "", &mut problems);
        (value, problems.list.into_iter().map(|problem| problem.place).collect())
    }

    #[test]
    fn notes_are_gone_and_degrees_are_radians() {
        let written = json!({ "note": "a", "a": [{ "note": ["b", "c"], "spin_deg_s": [180, 0, -90] }], "b": { "note": 3 } });
        let meant = json!({ "a": [{ "spin_rad_s": [PI, 0.0, -PI / 2.0] }], "b": { "note": 3 } });
        assert_eq!(read(written), (meant, Vec::new()));
    }

    #[test]
    fn a_quaternion_becomes_the_turns_that_make_it() {
        let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
        let mut worst: f64 = 0.0;
        for degrees in [
            [0.0, 0.0, 0.0],
            [30.0, 40.0, 50.0],
            [-170.0, 80.0, 120.0],
            [10.0, 90.0, 20.0],
            [10.0, -90.0, 20.0],
            [10.0, 90.0 - 1e-6, 20.0],
            [33.0, 90.0 - 1e-9, -70.0],
            [180.0, 0.0, 0.0],
        ] {
            let made = |degrees: [f64; 3]| {
                axes.iter().zip(degrees).fold(UnitQuaternion::identity(), |turned, (axis, angle)| {
                    turned * UnitQuaternion::from_axis_angle(axis, angle.to_radians())
                })
            };
            let given = made(degrees);
            let (value, faults) = read(json!({ "attitude_wxyz": [given.w, given.i, given.j, given.k] }));
            assert!(faults.is_empty() && value.get(QUATERNION).is_none(), "{value}");
            worst = worst.max(given.angle_to(&made(numbers(&value[TURNS]).unwrap())));
        }
        assert!(worst < 1e-14, "{worst:e}"); // measured: about 1e-15
    }

    #[test]
    fn a_quaternion_of_another_length_is_a_fault() {
        let (_, faults) = read(json!({ "target": { "attitude_wxyz": [1, 1, 0, 0] } }));
        assert_eq!(faults, ["target.attitude_wxyz"]);
        assert!(read(json!({ "attitude_wxyz": [0.9239, 0.3827, 0, 0] })).1.is_empty());
    }

    #[test]
    fn what_is_set_last_is_what_counts() {
        let mut object = json!({ "spin_rad_s": [PI, 0, 0], "attitude_deg": [1, 2, 3] });
        let map = object.as_object_mut().unwrap();
        respell(map, "spin_deg_s");
        respell(map, "attitude_wxyz");
        respell(map, "mass_kg");
        assert_eq!(object, json!({ "spin_deg_s": [180.0, 0.0, 0.0] }));
    }
}
