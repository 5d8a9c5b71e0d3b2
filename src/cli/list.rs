//! `tumblenet list`: what is built in.

use serde_json::Value;
use tumblenet::assets::Kind;

use super::{Error, print};

/// Prints names and titles of scenes, shapes and materials.
pub fn main() -> Result<(), Error> {
    let mut text = String::new();
    for (kind, head) in [(Kind::Scene, "scenes"), (Kind::Shape, "shapes"), (Kind::Material, "materials")] {
        text.push_str(&format!("{head}\n"));
        let names = kind.names();
        let width = names.iter().map(|name| name.len()).max().unwrap_or(0);
        for name in names {
            let value: Value =
                kind.text(name).and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default();
            let words = [&value["title"], &value["source"]];
            let about: Vec<&str> = words.into_iter().filter_map(Value::as_str).collect();
            text.push_str(&format!("  {name:width$}  {}\n", about.join(". ")));
        }
    }
    print(text.trim_end())
}
