//! The page of a study: table and figures in one self-contained file, light and dark.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use super::files::{Together, WriteError};
use super::plots::{self, DARK, Panel, hex};
use super::template;
use crate::provenance::Provenance;

const TEMPLATE: &str = include_str!("page.html");

/// One figure.
pub struct Figure {
    /// Name of its file, without ending.
    pub name: Cow<'static, str>,
    /// Its subject.
    pub title: Cow<'static, str>,
    /// What it shows, in a sentence or two.
    pub words: String,
    /// Its panels.
    pub panels: Vec<Panel>,
}

/// The page whose gaps hold `parts`, each with its name; what is in them is HTML.
pub fn fill(parts: &[(&str, String)]) -> String {
    let dark = dark();
    let named = parts.iter().map(|(name, text)| (*name, text.as_str()));
    let parts: Vec<(&str, &str)> = named.chain([("dark", dark.as_str())]).collect();
    template::fill(TEMPLATE, &parts)
}

/// A table from its header cells and its rows, which are HTML.
pub fn table(head: &str, rows: &str) -> String {
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}

/// Draws figures, each as a file of the set in the folder `out`; one without panels is none, and an earlier set's goes.
///
/// # Errors
/// The first file that cannot be written.
pub fn draw(
    files: &mut Together,
    out: &Path,
    figures: Vec<Figure>,
) -> Result<Vec<(Figure, String)>, WriteError> {
    let mut drawn = Vec::new();
    for figure in figures {
        let place = out.join(format!("{}.svg", figure.name));
        if figure.panels.is_empty() {
            files.without(&place);
            continue;
        }
        let svg = plots::svg(&figure.panels).map_err(|error| WriteError::new(&place, error))?;
        files.write(&place, |file| file.write_all(svg.as_bytes()))?;
        drawn.push((figure, svg));
    }
    Ok(drawn)
}

/// Figures with their drawings, one below the other.
pub fn drawings(drawn: &[(Figure, String)]) -> String {
    let mut text = String::new();
    for (figure, svg) in drawn {
        let _ = writeln!(
            text,
            "<figure id=\"{}\">\n<h2>{}</h2>\n<figcaption>{}</figcaption>\n<div class=\"plot\">{svg}</div>\n</figure>",
            figure.name,
            escape(&figure.title),
            escape(&figure.words)
        );
    }
    text
}

/// What made the page, in a line.
pub fn made(provenance: &Provenance, seed: u64) -> String {
    made_with(provenance, &format!(" Seed {seed}."))
}

/// The same of what no seed is in.
pub fn made_by(provenance: &Provenance) -> String {
    made_with(provenance, "")
}

fn made_with(provenance: &Provenance, seed: &str) -> String {
    format!(
        "{} ({}), {}, {}; {}, {} processors: {}.{seed} <code>{}</code>",
        escape(&provenance.program),
        escape(&provenance.commit),
        escape(&provenance.engine),
        escape(&provenance.compiler),
        escape(&provenance.platform),
        provenance.threads,
        escape(&provenance.processor),
        escape(&provenance.command)
    )
}

/// Style rules that give every colour of a plot its dark counterpart.
fn dark() -> String {
    let rule = |(light, dark): (plotters::style::RGBColor, &str)| {
        let light = hex(light);
        format!(
            ".plot [fill=\"{light}\"] {{ fill: {dark} }} .plot [stroke=\"{light}\"] {{ stroke: {dark} }}\n"
        )
    };
    DARK.into_iter().map(rule).collect()
}

/// `text` as it stands in HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_gap_of_the_page_is_known() {
        assert_eq!(
            template::gaps(TEMPLATE),
            ["title", "kind", "dark", "title", "lead", "tables", "notes", "figures", "made"]
        );
    }
}
