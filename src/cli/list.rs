//! `tumblenet list`: what is built in.

use comfy_table::presets::NOTHING;
use comfy_table::{Cell, CellAlignment};
use serde_json::Value;
use tumblenet::assets::Kind;
use tumblenet::report::text_table::TextTable;

use super::{Error, print};

/// Prints what is built in, a table a kind.
pub fn main() -> Result<(), Error> {
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
        let n_parts = shape["parts"].as_array().map_or(0, Vec::len);
        let n_parts = Cell::new(n_parts).set_alignment(CellAlignment::Right);
        rows.add_row([Cell::new(name), Cell::new(what(&shape)), n_parts]);
    }
    rows
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
        let text = Kind::Cabin.text(name).unwrap_or_default();
        let comment = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
        rows.add_row([name, &comment.collect::<Vec<_>>().join(" ")]);
    }
    rows
}
