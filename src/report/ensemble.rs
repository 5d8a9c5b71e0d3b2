//! An ensemble as a page: `ensemble.json`, `ensemble.html` and `survival.svg`.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use super::files::{self, WriteError};
use super::page::{self, ResultPage};
use super::survival::{self, Named};
use super::{results, table};
use crate::provenance::Provenance;
use crate::study::ensemble::{self, Ensemble};

/// Writes all files of `ensemble` of the scene called `scene` with `changes` to the folder `out`.
///
/// # Errors
/// The first file that cannot be written.
pub fn write(out: &Path, scene: &str, changes: &[String], ensemble: &Ensemble) -> Result<(), WriteError> {
    files::make_folder(out)?;
    let curve = ensemble.survival.iter();
    let curve: Vec<Named> =
        curve.map(|survival| Named { name: scene.to_owned(), series: 0, survival }).collect();
    let figure = survival::figure(&curve);
    let mut files = files::Together::begin();
    let drawn = page::draw(&mut files, out, vec![figure])?;
    let again = ensemble::again(scene, changes, &ensemble.request);
    let page = ResultPage {
        title: &ensemble.title,
        kind: "ensemble",
        lead: &table::ensemble_verdict(ensemble),
        tables: members(out, ensemble),
        notes: format!("<p>To watch a member: <code>{} --member N</code></p>\n", page::escape(&again)),
        drawn: &drawn,
        provenance: &Provenance::here(),
        seed: Some(ensemble.request.seed),
    }
    .html();
    files.write(&out.join("ensemble.html"), |file| file.write_all(page.as_bytes()))?;
    // Last: it says that the rest is there.
    files.write(&out.join("ensemble.json"), |file| results::as_json(file, ensemble))?;
    files.appear()
}

/// A row a member, with what was drawn for it, and a link to its replay where it was written.
fn members(out: &Path, ensemble: &Ensemble) -> String {
    let time = |time: Option<f64>| time.map_or_else(|| "–".to_owned(), |time| format!("{time:.2}"));
    let drawn = ensemble.drawn.as_ref();
    let mut rows = String::new();
    for ended in &ensemble.verdicts {
        let replay = format!("member-{}/replay.html", ended.member);
        let name = if out.join(&replay).exists() {
            format!("<a href=\"{replay}\">{}</a>", ended.member)
        } else {
            ended.member.to_string()
        };
        let inputs = drawn.and_then(|drawn| drawn.members.get(ended.member)).into_iter().flatten();
        let inputs: String = inputs.map(|text| format!("<td>{}</td>", page::escape(&short(text)))).collect();
        let _ = writeln!(
            rows,
            "<tr><td>{name}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2}</td>{inputs}</tr>",
            ended.verdict.words(),
            time(ended.enclosed_at_s),
            time(ended.settled_at_s),
            time(ended.lost_at_s),
            ended.simulated_s
        );
    }
    let heads =
        ["first held", "settled", "lost", "end"].map(|head| format!("<th>{head} <small>s</small></th>"));
    let inputs = drawn.into_iter().flat_map(|drawn| &drawn.columns);
    let inputs: String = inputs.map(|name| format!("<th>{}</th>", page::escape(name))).collect();
    page::table(&format!("<th>member</th><th>verdict</th>{}{inputs}", heads.concat()), &rows)
}

/// A number that was drawn, in four digits; other texts as they are.
fn short(text: &str) -> String {
    text.parse::<f64>().map_or_else(|_| text.to_owned(), table::number)
}
