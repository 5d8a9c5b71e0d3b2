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

/// How the lead begins.
const LEAD: &str = "<p class=\"lead\">";

/// One figure.
pub struct Figure {
    /// Name of its file, without ending.
    pub name: Cow<'static, str>,
    /// Its subject.
    pub title: Cow<'static, str>,
    /// What it shows, in a sentence or two.
    pub words: String,
    /// Its panels; none where it is drawn as on paper, with colours of its own.
    pub panels: Vec<Panel>,
}

/// A page of results.
pub struct ResultPage<'a> {
    /// Its title.
    pub title: &'a str,
    /// What kind of results they are, in a word or two.
    pub kind: &'static str,
    /// What was found, in a sentence or two; may be empty.
    pub lead: &'a str,
    /// Tables, as HTML.
    pub tables: String,
    /// Notes, as HTML.
    pub notes: String,
    /// Figures with their drawings.
    pub drawn: &'a [(Figure, String)],
    /// What made it.
    pub provenance: &'a Provenance,
    /// Seed of what was drawn at random; none where nothing was.
    pub seed: Option<u64>,
}

impl ResultPage<'_> {
    /// Everything within one file.
    pub fn html(self) -> String {
        self.html_with("")
    }

    /// The same with `more` below, as HTML.
    pub fn html_with(self, more: &str) -> String {
        let lead = match self.lead {
            "" => String::new(),
            lead => format!("{LEAD}{}</p>\n", prose(lead)),
        };
        let parts = [
            ("title", escape(self.title)),
            ("kind", self.kind.to_owned()),
            ("dark", dark()),
            ("lead", lead),
            ("tables", self.tables),
            ("notes", self.notes),
            ("figures", drawings(self.drawn) + more),
            ("made", made(self.provenance, self.seed)),
        ];
        template::fill(TEMPLATE, &parts.each_ref().map(|(name, text)| (*name, text.as_str())))
    }
}

/// What a page of results is made of, as HTML but for the title and the lead.
pub struct PageParts {
    /// Its title.
    pub title: String,
    /// What was found; may be empty.
    pub lead: String,
    /// Lead, tables, notes, figures, and what made it.
    pub body: String,
}

/// The parts of the `page` that [`ResultPage::html`] made; none where it is no page of ours.
pub fn parts(page: &str) -> Option<PageParts> {
    let (_, main) = page.split_once("<main>\n<h1>")?;
    let (main, _) = main.rsplit_once("</main>")?;
    let (title, body) = main.split_once("</h1>\n")?;
    let lead = body.strip_prefix(LEAD).and_then(|rest| rest.split_once("</p>"));
    let lead = lead.map_or_else(String::new, |(lead, _)| plain(lead));
    Some(PageParts { title: plain(title), lead, body: body.to_owned() })
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
        let class = if figure.panels.is_empty() { "paper" } else { "plot" };
        let _ = writeln!(
            text,
            "<figure id=\"{}\">\n<h2>{}</h2>\n<figcaption>{}</figcaption>\n<div class=\"{class}\">{svg}</div>\n</figure>",
            figure.name,
            escape(&figure.title),
            escape(&figure.words)
        );
    }
    text
}

/// What made a result, in a line.
pub fn made(provenance: &Provenance, seed: Option<u64>) -> String {
    let seed = seed.map_or_else(String::new, |seed| format!(" Seed {seed}."));
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

/// [`escape`] of a text whose commands stand between backticks, which a page shows as code.
pub fn prose(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return escape(text);
    }
    let part = |(n, part): (usize, &&str)| match n % 2 {
        0 => escape(part),
        _ => format!("<code>{}</code>", escape(part)),
    };
    parts.iter().enumerate().map(part).collect()
}

/// [`prose`] undone.
fn plain(text: &str) -> String {
    let text = text.replace("<code>", "`").replace("</code>", "`");
    text.replace("&quot;", "\"").replace("&gt;", ">").replace("&lt;", "<").replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_in_a_text_are_code_and_come_back() {
        let text = "Run on with `--until settled`: a < b.";
        assert_eq!(prose(text), "Run on with <code>--until settled</code>: a &lt; b.");
        assert_eq!(plain(&prose(text)), text);
        assert_eq!(prose("one ` alone"), "one ` alone");
    }

    #[test]
    fn every_gap_of_the_page_is_known() {
        assert_eq!(
            template::gaps(TEMPLATE),
            ["title", "kind", "dark", "title", "lead", "tables", "notes", "figures", "made"]
        );
    }
}
