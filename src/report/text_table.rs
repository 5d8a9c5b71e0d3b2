//! A table for a terminal: as wide as it needs to be, as narrow as the terminal; where that is too narrow for its
//! columns, one row below the other. Plain text: what a terminal would obey is not in it.

use std::fmt;
use std::ops::{Deref, DerefMut};

use comfy_table::presets::UTF8_BORDERS_ONLY;
use comfy_table::{Cell, ColumnConstraint, ContentArrangement, Row, Table, Width};

/// A table that fits.
#[derive(Clone)]
pub struct TextTable {
    table: Table,
    width: Option<u16>,
}

impl TextTable {
    /// No rows yet below `header`; one that says nothing is not there.
    pub fn new(header: &[&str]) -> TextTable {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_content_arrangement(ContentArrangement::Dynamic);
        if header.iter().any(|head| !head.is_empty()) {
            table.set_header(header.iter().map(Cell::new));
        }
        let width = table.width().or_else(|| std::env::var("COLUMNS").ok()?.parse().ok());
        TextTable { table, width }
    }

    /// The same for a terminal of `width` columns.
    pub fn within(mut self, width: u16) -> TextTable {
        self.width = Some(width);
        self
    }
}

impl Deref for TextTable {
    type Target = Table;

    fn deref(&self) -> &Table {
        &self.table
    }
}

impl DerefMut for TextTable {
    fn deref_mut(&mut self) -> &mut Table {
        &mut self.table
    }
}

impl fmt::Display for TextTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.drawn().replace(TIE, " "))
    }
}

impl TextTable {
    fn drawn(&self) -> String {
        let Some(width) = self.width else { return self.table.trim_fmt() };
        let mut table = self.table.clone();
        table.set_width(width);
        let mut least: Vec<u16> = Vec::new();
        for row in self.table.header().into_iter().chain(self.table.row_iter()) {
            least.resize(least.len().max(row.cell_count()), 0);
            for (least, cell) in least.iter_mut().zip(row.cell_iter()) {
                *least = longest_word(cell).max(*least);
            }
        }
        // A blank at both sides of each, and the border.
        let needed: usize = least.iter().map(|word| usize::from(*word) + 2).sum::<usize>() + 2;
        if needed > usize::from(width) {
            return one_below_the_other(&self.table, width);
        }
        for (index, word) in least.iter().enumerate() {
            if let Some(column) = table.column_mut(index) {
                column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(word + 2)));
            }
        }
        table.trim_fmt()
    }
}

/// Length of what is not to be broken in a cell.
fn longest_word(cell: &Cell) -> u16 {
    let longest = cell.content().split([' ', '\n']).map(|word| word.chars().count()).max();
    longest.unwrap_or(0).min(1000) as u16
}

/// A blank at which no line ends.
const TIE: &str = "\u{a0}";

/// `text` that stays in one line, with the blanks that it begins with.
pub fn tied(text: &str) -> String {
    text.replace(' ', TIE)
}

/// Each row as its first cell, and below it the others, each with the head of its column.
fn one_below_the_other(table: &Table, width: u16) -> String {
    let words = |cell: &Cell| cell.content().split_whitespace().collect::<Vec<_>>().join(" ");
    let heads: Vec<String> = table.header().into_iter().flat_map(Row::cell_iter).map(words).collect();
    let mut lines = Vec::new();
    for row in table.row_iter() {
        let cells: Vec<String> = row.cell_iter().map(words).collect();
        let Some((first, others)) = cells.split_first() else { continue };
        wrap(first, "", width, &mut lines);
        let head = |index: usize| heads.get(index + 1).filter(|head| !head.is_empty());
        let others = others.iter().enumerate().filter(|(_, cell)| !cell.is_empty());
        let others = others.map(|(index, cell)| match head(index) {
            // What belongs together is not parted by the end of a line.
            Some(head) => format!("{head}:{TIE}{cell}").replace(' ', if cell.len() > 20 { " " } else { TIE }),
            None => cell.clone(),
        });
        let others: Vec<String> = others.collect();
        if !others.is_empty() {
            wrap(&others.join(", "), "  ", width, &mut lines);
        }
    }
    lines.join("\n")
}

/// Adds `text` to `lines`, each of which begins with `indent` and is at most `width` long, where words are not longer.
fn wrap(text: &str, indent: &str, width: u16, lines: &mut Vec<String>) {
    let mut line = indent.to_owned();
    for word in text.split(' ') {
        let is_empty = line.trim().is_empty();
        if !is_empty && line.chars().count() + 1 + word.chars().count() > usize::from(width) {
            lines.push(std::mem::replace(&mut line, format!("{indent}{indent}")));
            line.push_str(word);
            continue;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines.push(line);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seven() -> TextTable {
        let mut table =
            TextTable::new(&["", "least", "quartile", "median", "quartile", "largest", "members"]);
        table.add_row([
            "conservation.momentum_residual",
            "1.000e-9",
            "1.100e-9",
            "0.1234",
            "-1234",
            "5",
            "10",
        ]);
        table
    }

    #[test]
    fn a_narrow_terminal_breaks_no_word_and_no_line() {
        for width in [40, 60, 70, 80, 100, 200] {
            let text = seven().within(width).to_string();
            assert!(text.lines().all(|line| line.chars().count() <= usize::from(width)), "{width}:\n{text}");
            for word in ["conservation.momentum_residual", "1.000e-9", "quartile", "members", "-1234"] {
                assert!(text.contains(word), "{width}: {word} in\n{text}");
            }
        }
        let below = seven().within(60).to_string();
        assert!(
            below.contains(
                "conservation.momentum_residual\n  least: 1.000e-9, quartile: 1.100e-9, median: 0.1234,\n"
            ),
            "{below}"
        );
        assert!(seven().within(120).to_string().starts_with('┌'));
    }

    #[test]
    fn names_below_a_heading_stay_within_it_and_in_one_line() {
        let mut table = TextTable::new(&["", "", ""]);
        table.add_row(["deployment", "", ""]);
        table.add_row([
            &tied("  travelling distance"),
            "+0.3838  -0.0042  -0.0049",
            "of the launch and the work",
        ]);
        for width in [48, 60, 90] {
            let text = table.clone().within(width).to_string();
            assert!(text.contains("│   travelling distance "), "{width}:\n{text}");
            assert!(!text.contains(TIE));
        }
    }

    #[test]
    fn a_header_that_says_nothing_is_not_there() {
        let mut table = TextTable::new(&["", ""]);
        table.add_row(["a", "b"]);
        let text = table.within(60).to_string();
        assert_eq!(text.lines().count(), 3, "{text}");
        assert!(!text.contains('\u{1b}'), "{text:?}");
    }
}
