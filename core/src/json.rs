//! JSON text to a value: no key twice, and a mark at its head (Windows editors write one) is no fault.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use crate::problems::Problems;
use crate::problems::join;

/// UTF-8's byte order mark; it has no meaning, and JSON does not allow it (RFC 8259, 8.1).
const MARK: char = '\u{feff}';

/// Parses JSON text that stands at `place`.
///
/// Adds a fault with line and column where it is not JSON, and one for every key that is given twice.
pub fn parse(text: &str, place: &str, problems: &mut Problems) -> Option<Value> {
    let mut twice = Vec::new();
    let mut reader = serde_json::Deserializer::from_str(text.strip_prefix(MARK).unwrap_or(text));
    let root = Place { above: None, step: Step::Root };
    let parsed = Strict { place: &root, twice: &mut twice }
        .deserialize(&mut reader)
        .and_then(|value| reader.end().map(|()| value));
    for below in twice {
        problems.add(join(place, &below), "this key twice", "each key once");
    }
    match parsed {
        Ok(value) => Some(value),
        Err(error) => {
            problems.add(place, format!("no JSON ({error})"), "one JSON value");
            None
        }
    }
}

/// Where the reader is; written out only where there is a fault.
struct Place<'a> {
    above: Option<&'a Place<'a>>,
    step: Step<'a>,
}

enum Step<'a> {
    Root,
    Key(&'a str),
    Index(usize),
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let above = self.above.map(ToString::to_string).unwrap_or_default();
        match self.step {
            Step::Root => Ok(()),
            Step::Key(key) => f.write_str(&join(&above, key)),
            Step::Index(index) => write!(f, "{above}[{index}]"),
        }
    }
}

/// Reads a value as serde_json does, and notes keys that come again; the last of them counts.
struct Strict<'a> {
    place: &'a Place<'a>,
    twice: &'a mut Vec<String>,
}

impl<'de> DeserializeSeed<'de> for Strict<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Strict<'_> {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E: Error>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_string<E: Error>(self, value: String) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let mut values = Vec::new();
        loop {
            let place = Place { above: Some(self.place), step: Step::Index(values.len()) };
            match list.next_element_seed(Strict { place: &place, twice: self.twice })? {
                Some(value) => values.push(value),
                None => return Ok(Value::Array(values)),
            }
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        let mut values = Map::new();
        while let Some(key) = map.next_key::<String>()? {
            let place = Place { above: Some(self.place), step: Step::Key(&key) };
            let value = map.next_value_seed(Strict { place: &place, twice: self.twice })?;
            if values.contains_key(&key) {
                self.twice.push(place.to_string());
            }
            values.insert(key, value);
        }
        Ok(Value::Object(values))
    }
}

/// Every whole number up to it is one of JSON: beyond, not all of them are an `f64` (RFC 8259, 6).
pub const LARGEST_WHOLE: u64 = (1 << 53) - 1;

/// What becomes of the negative zero, which no whole number is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum NegativeZero {
    /// It stays: its sign is a bit of the state.
    Kept,
    /// It is 0, where a whole number is wanted.
    Whole,
}

/// A copy in which a whole number is written as one: `3.0` is as whole as `3`, to JSON Schema and to
/// users, though not to the reader of types.
pub fn with_whole_numbers(value: &Value, zero: NegativeZero) -> Value {
    match value {
        Value::Array(list) => list.iter().map(|inner| with_whole_numbers(inner, zero)).collect(),
        Value::Object(map) => {
            map.iter().map(|(key, inner)| (key.clone(), with_whole_numbers(inner, zero))).collect()
        }
        Value::Number(number) => match number.as_f64() {
            Some(float) if number.is_f64() && float.fract() == 0.0 && float.abs() <= LARGEST_WHOLE as f64 => {
                let is_negative_zero = float == 0.0 && float.is_sign_negative();
                if is_negative_zero && zero == NegativeZero::Kept {
                    value.clone()
                } else {
                    (float as i64).into()
                }
            }
            _ => value.clone(),
        },
        other => other.clone(),
    }
}

/// Changes `into` to what `from` says, key by key where both are objects.
pub fn merge(into: &mut Value, from: Value) {
    match (into, from) {
        (Value::Object(into), Value::Object(from)) => {
            for (key, value) in from {
                merge(into.entry(key).or_insert(Value::Null), value);
            }
        }
        (into, from) => *into = from,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn parsed(text: &str) -> (Option<Value>, Vec<String>) {
        let mut problems = Problems::new("test");
        let value = parse(text, "", &mut problems);
        (value, problems.list.into_iter().map(|p| format!("{}: {}", p.place, p.found)).collect())
    }

    #[test]
    fn sound_text_is_read_as_serde_json_reads_it() {
        for text in ["null", "[]", "{}", "-0.0", r#"{"a":[1,-2,3.5,true,"ä\n",{"b":null}],"c":1e300}"#] {
            assert_eq!(parsed(text), (serde_json::from_str(text).ok(), Vec::new()), "{text}");
        }
        let deep = "[".repeat(100_000);
        assert!(parsed(&deep).1[0].contains("recursion limit"), "no overflow of the stack");
    }

    #[test]
    fn every_key_that_is_given_twice_is_told() {
        let (value, faults) = parsed(r#"{"a":1,"b":[{},{"c":1,"c":2,"c":3}],"a":{"d":0,"d":0}}"#);
        assert_eq!(faults, ["b[1].c: this key twice", "a.d: this key twice", "a: this key twice"]);
        assert_eq!(value.unwrap()["b"][1]["c"], json!(3));
    }

    #[test]
    fn a_byte_order_mark_is_no_fault() {
        assert_eq!(parsed("\u{feff}{\"a\":1}"), (Some(json!({ "a": 1 })), Vec::new()));
        assert_eq!(parsed("\u{feff}").1.len(), 1);
    }

    #[test]
    fn whole_numbers_stay_what_they_are() {
        let value = json!([3.0, -2.0, 0.5, 1e300, 7, "3.0", { "a": 1e15 }]);
        assert_eq!(
            with_whole_numbers(&value, NegativeZero::Kept),
            json!([3, -2, 0.5, 1e300, 7, "3.0", { "a": 1_000_000_000_000_000_i64 }])
        );
        let zero = with_whole_numbers(&json!(-0.0), NegativeZero::Kept).as_f64().unwrap();
        assert!(zero == 0.0 && zero.is_sign_negative());
        assert_eq!(with_whole_numbers(&json!([-0.0]), NegativeZero::Whole), json!([0]));
    }
}
