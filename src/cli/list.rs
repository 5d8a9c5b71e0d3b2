//! `tumblenet list`: what is built in.

use clap::Args;
use comfy_table::presets::NOTHING;
use comfy_table::{Cell, CellAlignment};
use serde_json::{Value, json};
use tumblenet::assets::Kind;
use tumblenet::report::text_table::TextTable;

use super::{Error, print};

/// Arguments of `list`.
#[derive(Args)]
pub struct Arguments {
    /// Prints the same as JSON: of each kind names, titles, and numbers in SI units.
    #[arg(long)]
    json: bool,
}

/// Prints what is built in, a table a kind.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    if arguments.json {
        return print(&super::json(&as_json()));
    }
    let mut text = String::new();
    for (head, table) in [
        ("scenes", scenes()),
        ("shapes of targets", shapes()),
        ("materials of cables", materials()),
        ("motions of a cabin", cabins()),
        ("studies of sweeps", studies()),
    ] {
        text.push_str(&format!("{}\n{table}\n\n", head.to_uppercase()));
    }
    text.push_str("More on one: `tumblenet show SCENE`. To begin a scene of your own: `tumblenet new FILE`.");
    print(&text)
}

/// What the tables show, without rounding, for a program.
fn as_json() -> Value {
    let rows = |kind: Kind, more: fn(&Value) -> Value| -> Vec<Value> {
        let row = |(name, content): (&str, Value)| {
            let mut row = json!({ "name": name });
            tumblenet::json::merge(&mut row, more(&content));
            row
        };
        all(kind).map(row).collect()
    };
    let cabins: Vec<Value> =
        Kind::Cabin.names().into_iter().map(|name| json!({ "name": name, "title": comment(name) })).collect();
    json!({
        "scenes": rows(Kind::Scene, |scene| json!({ "title": scene["title"], "expect": scene["expect"] })),
        "shapes": rows(Kind::Shape, |shape| json!({ "title": shape["title"], "parts": n_parts(shape) })),
        "materials": rows(Kind::Material, Value::clone),
        "cabins": cabins,
        "studies": rows(Kind::Study, |study| json!({ "title": study["title"], "scene": study["scene"] })),
    })
}

fn table(header: &[&str]) -> TextTable {
    let mut table = TextTable::new(header);
    table.load_style(NOTHING);
    table
}

/// Everything built in of one kind: its name and its JSON.
fn all(kind: Kind) -> impl Iterator<Item = (&'static str, Value)> {
    // Checked by a test to be JSON.
    let parsed = move |name| serde_json::from_str(kind.text(name).unwrap_or_default()).unwrap_or_default();
    kind.names().into_iter().map(move |name| (name, parsed(name)))
}

fn scenes() -> TextTable {
    let mut rows = table(&["name", "what", "expected"]);
    for (name, scene) in all(Kind::Scene) {
        rows.add_row([name, &what(&scene), expected(&scene["expect"])]);
    }
    rows
}

/// The title without what most of them begin with.
fn what(json: &Value) -> String {
    let title = json["title"].as_str().unwrap_or_default();
    let short = ["Capture of a ", "Capture of an ", "Capture of the ", "Capture of "]
        .into_iter()
        .find_map(|start| title.strip_prefix(start));
    short.unwrap_or(title).to_owned()
}

/// The verdict that a scene expects, in a word.
fn expected(expect: &Value) -> &'static str {
    match (expect["verdict"].as_str(), expect["captured"].as_bool()) {
        (Some("held_settled"), _) => "settled",
        (Some("held_so_far"), _) | (None, Some(true)) => "captured",
        (Some(_), _) | (None, Some(false)) => "not captured",
        (None, None) => "-",
    }
}

fn studies() -> TextTable {
    let mut rows = table(&["name", "what"]);
    for (name, study) in all(Kind::Study) {
        rows.add_row([name, &what(&study)]);
    }
    rows
}

fn shapes() -> TextTable {
    let mut rows = table(&["name", "what", "parts"]);
    for (name, shape) in all(Kind::Shape) {
        let n_parts = Cell::new(n_parts(&shape)).set_alignment(CellAlignment::Right);
        rows.add_row([Cell::new(name), Cell::new(what(&shape)), n_parts]);
    }
    rows
}

fn n_parts(shape: &Value) -> usize {
    shape["parts"].as_array().map_or(0, Vec::len)
}

fn materials() -> TextTable {
    let mut rows = table(&["name", "modulus\nGPa", "density\nkg/m³", "strength\nMPa", "breaks at\n%"]);
    for (name, material) in all(Kind::Material) {
        let numbers = [
            ("young_modulus_pa", 1e-9),
            ("density_kg_m3", 1.0),
            ("tensile_strength_pa", 1e-6),
            ("elongation_at_break", 100.0),
        ];
        let number = |(key, factor): (&str, f64)| {
            // As many digits as were written, whatever the unit.
            let value = material[key].as_f64().map_or(f64::NAN, |value| value * factor);
            Cell::new((value * 1e6).round() / 1e6).set_alignment(CellAlignment::Right)
        };
        rows.add_row([Cell::new(name)].into_iter().chain(numbers.map(number)));
    }
    rows
}

fn cabins() -> TextTable {
    let mut rows = table(&["name", "what"]);
    for name in Kind::Cabin.names() {
        rows.add_row([name, &comment(name)]);
    }
    rows
}

/// What the file of a cabin's motion says at its head.
fn comment(name: &str) -> String {
    let text = Kind::Cabin.text(name).unwrap_or_default();
    let lines = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
    lines.collect::<Vec<_>>().join(" ")
}
