//! A table before it is text or part of a page.

use std::fmt::Write as _;

use comfy_table::{Cell, CellAlignment};

use super::page;
use super::text_table::TextTable;

/// A table of words and numbers.
pub struct Grid {
    /// What it shows.
    pub title: &'static str,
    /// So many cells of a row, the first ones, are words.
    pub n_words: usize,
    /// Heads of its columns.
    pub head: Vec<String>,
    /// Its rows.
    pub rows: Vec<Vec<String>>,
}

impl Grid {
    /// For a terminal.
    pub fn text(&self) -> TextTable {
        let mut table = TextTable::new(&self.head.iter().map(String::as_str).collect::<Vec<_>>());
        for row in &self.rows {
            table.add_row(row.iter().enumerate().map(|(column, text)| {
                let side = if column < self.n_words { CellAlignment::Left } else { CellAlignment::Right };
                Cell::new(text).set_alignment(side)
            }));
        }
        table
    }

    /// With its title, as HTML.
    pub fn page(&self) -> String {
        let cells = |cells: &[String], tag: &str| -> String {
            let cell = |text: &String| format!("<{tag}>{}</{tag}>", breakable(&page::escape(text)));
            cells.iter().map(cell).collect()
        };
        let rows = self.rows.iter().fold(String::new(), |mut rows, row| {
            let _ = writeln!(rows, "<tr>{}</tr>", cells(row, "td"));
            rows
        });
        format!("<h2>{}</h2>\n{}", self.title, page::table(&cells(&self.head, "th"), &rows))
    }
}

/// `text` with places where a line may end: within the paths of keys, not within numbers.
fn breakable(text: &str) -> String {
    let mut broken = String::with_capacity(text.len());
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        broken.push(letter);
        let is_of_path = letters.peek().is_some_and(|next| next.is_alphabetic());
        if letter == '_' || (letter == '.' && is_of_path) {
            broken.push_str("<wbr>");
        }
    }
    broken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_within_paths_and_not_within_numbers() {
        assert_eq!(breakable("a.b_c 0.25, 1.5"), "a.<wbr>b_<wbr>c 0.25, 1.5");
    }
}
