//! `tumblenet list`: what is built in.

use serde_json::Value;
use tumblenet::assets::Kind;

use super::{Error, print};

/// Prints names and titles of scenes, shapes and materials.
pub fn main() -> Result<(), Error> {
    let mut text = String::new();
    for (kind, head) in [
        (Kind::Scene, "scenes"),
        (Kind::Shape, "shapes"),
        (Kind::Material, "materials"),
        (Kind::Cabin, "cabins"),
    ] {
        text.push_str(&format!("{head}\n"));
        let names = kind.names();
        let width = names.iter().map(|name| name.len()).max().unwrap_or(0);
        for name in names {
            text.push_str(&format!("  {name:width$}  {}\n", about(kind.text(name).unwrap_or_default())));
        }
    }
    print(text.trim_end())
}

/// Title and source of a JSON file, or the comment that heads a CSV file.
fn about(text: &str) -> String {
    if let Ok(value) = serde_json::from_str::<Value>(text) {
        let words = [&value["title"], &value["source"]];
        return words.into_iter().filter_map(Value::as_str).collect::<Vec<_>>().join(". ");
    }
    let comment = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
    comment.collect::<Vec<_>>().join(" ")
}
