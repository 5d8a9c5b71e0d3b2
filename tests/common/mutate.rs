//! Valid inputs, spoilt at random: JSON by its structure, files by their bytes.

use rand::{Rng, RngExt};
use serde_json::{Value, json};

/// Spoils `value` in one to five places; `donors` are valid inputs whose parts are put in.
pub fn spoil(value: &mut Value, donors: &[Value], random: &mut impl Rng) {
    for _ in 0..random.random_range(1..=5) {
        let places = places(value);
        let place = pick(&places, random).clone();
        match random.random_range(0..8) {
            0 | 1 => put(value, &place, leaf(random)),
            2 | 3 => {
                if let Some(number) = value.pointer(&place).and_then(Value::as_f64) {
                    put(value, &place, json!(shifted(number, random)));
                }
            }
            4 => remove(value, &place),
            // A part of a valid input, where it stands there or anywhere.
            5 | 6 => {
                let donor = pick(donors, random);
                let from = pick(&self::places(donor), random).clone();
                let part = donor.pointer(&from).cloned().unwrap_or_default();
                let to = if random.random_bool(0.8) { from } else { place };
                put(value, &to, part);
            }
            _ => {
                let long = stretched(value.pointer(&place).cloned().unwrap_or_default(), random);
                put(value, &place, long);
            }
        }
    }
}

/// Spoils bytes in one to ten places.
pub fn spoil_bytes(bytes: &mut Vec<u8>, random: &mut impl Rng) {
    for _ in 0..random.random_range(1..=10) {
        let at = random.random_range(0..=bytes.len());
        let end = (at + random.random_range(0..40)).min(bytes.len());
        match random.random_range(0..6) {
            0 if at < bytes.len() => bytes[at] = random.random(),
            1 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let piece = bytes[at..end].to_vec();
                let to = random.random_range(0..=bytes.len());
                bytes.splice(to..to, piece);
            }
            4 => {
                let words: [&[u8]; 12] = [
                    b"nan",
                    b" 1e39 ",
                    b"-1e-45",
                    b"\nf 1 2 3\n",
                    b"-",
                    b"\n",
                    b"f 1/1/1 2//2 -3\n",
                    b"9999999999999999999",
                    b"{",
                    b"]",
                    b"\"",
                    b"\xff\xfe",
                ];
                bytes.splice(at..at, pick(&words, random).iter().copied());
            }
            _ if random.random_bool(0.1) => bytes.truncate(at),
            _ => {}
        }
    }
}

/// Bytes of no meaning at all, or of JSON's characters only.
pub fn noise(random: &mut impl Rng) -> Vec<u8> {
    let length = random.random_range(0..300);
    if random.random_bool(0.5) {
        return (0..length).map(|_| random.random()).collect();
    }
    let alphabet = b"{}[]\",:-+.eE0123456789truefalsn \n\\u";
    (0..length).map(|_| *pick(alphabet, random)).collect()
}

/// One of `from`.
pub fn pick<'a, T>(from: &'a [T], random: &mut impl Rng) -> &'a T {
    &from[random.random_range(0..from.len())]
}

/// A value that is odd in most places.
fn leaf(random: &mut impl Rng) -> Value {
    let numbers = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        3.0,
        90.0,
        1e-320,
        1e-300,
        1e-30,
        1e-12,
        1e-6,
        1e6,
        1e9,
        4294967296.0,
        1e12,
        1e19,
        1e30,
        1e150,
        1e300,
        f64::MAX,
        f64::MIN,
        f64::MIN_POSITIVE,
        f64::EPSILON,
    ];
    let words = [
        "",
        "free",
        "fixed",
        "spinning",
        "joints",
        "explicit",
        "rapier",
        "impulse",
        "penalty",
        "f32",
        "rk4",
        "kevlar",
        "cubesat-3u",
        "envisat",
        "shape.json",
        "mesh.obj",
        "mesh.stl",
        "../secret.json",
        "/etc/passwd",
        "contact",
        "time",
        "mouth",
        "tube",
        "cinch",
        "inwards",
        "hollars",
        "\u{0}",
        "ä",
        "1",
    ];
    match random.random_range(0..10) {
        0 => Value::Null,
        1 => json!(random.random_bool(0.5)),
        2 => json!(u64::MAX),
        3 => json!(i64::MIN),
        4 => json!(pick(&words, random)),
        5 => json!("x".repeat(random.random_range(0..2000))),
        6 => pick(&[json!([]), json!({}), json!([[]]), json!([null]), json!({ "": 0 })], random).clone(),
        7 => json!(random.random_range(-1000..1000)),
        _ => json!(pick(&numbers, random)),
    }
}

/// A number of another size or sign.
fn shifted(number: f64, random: &mut impl Rng) -> f64 {
    match random.random_range(0..5) {
        0 => -number,
        1 => number + 1.0,
        2 => number * random.random_range(0.0..2.0),
        _ => number * 10f64.powf(random.random_range(-15.0..15.0)),
    }
}

/// A value wrapped many times, or a list much longer than it was.
fn stretched(value: Value, random: &mut impl Rng) -> Value {
    match value {
        Value::Array(list) if !list.is_empty() => {
            // Of at most some 200 kB: longer files are refused before they are read.
            let bytes = Value::from(list.clone()).to_string().len();
            let most = list.len() * 200_000 / bytes;
            let length = random.random_range(0..most.clamp(2, 2000));
            list.iter().cycle().take(length).cloned().collect()
        }
        other => (0..random.random_range(1..150)).fold(other, |inner, _| json!([inner])),
    }
}

/// Pointers to every value in `value`.
fn places(value: &Value) -> Vec<String> {
    fn walk(value: &Value, place: &str, places: &mut Vec<String>) {
        places.push(place.to_owned());
        match value {
            Value::Object(map) => {
                for (key, inner) in map {
                    let key = key.replace('~', "~0").replace('/', "~1");
                    walk(inner, &format!("{place}/{key}"), places);
                }
            }
            Value::Array(list) => {
                for (index, inner) in list.iter().take(20).enumerate() {
                    walk(inner, &format!("{place}/{index}"), places);
                }
            }
            _ => {}
        }
    }
    let mut all = Vec::new();
    walk(value, "", &mut all);
    all
}

fn put(root: &mut Value, place: &str, new: Value) {
    if let Some(value) = root.pointer_mut(place) {
        *value = new;
    } else if let Some((above, key)) = place.rsplit_once('/')
        && let Some(map) = root.pointer_mut(above).and_then(Value::as_object_mut)
    {
        map.insert(key.to_owned(), new);
    }
}

fn remove(root: &mut Value, place: &str) {
    let Some((above, key)) = place.rsplit_once('/') else { return };
    match root.pointer_mut(above) {
        Some(Value::Object(map)) => drop(map.shift_remove(key)),
        Some(Value::Array(list)) => {
            if let Some(index) = key.parse().ok().filter(|index: &usize| *index < list.len()) {
                list.remove(index);
            }
        }
        _ => {}
    }
}
