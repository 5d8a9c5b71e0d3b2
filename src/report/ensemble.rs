//! An ensemble as a page: `ensemble.json`, `ensemble.html` and `survival.svg`.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use super::files::{self, WriteError};
use super::page;
use super::survival::{self, Named};
use super::{results, table};
use crate::provenance::Provenance;
use crate::study::ensemble::{self, Ended, Ensemble};

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
    let page = page::fill(&[
        ("title", page::escape(&ensemble.title)),
        ("kind", "ensemble".to_owned()),
        ("lead", format!("<p class=\"lead\">{}</p>\n", page::escape(&table::ensemble_verdict(ensemble)))),
        ("tables", members(out, &ensemble.verdicts)),
        ("notes", format!("<p>To watch a member: <code>{} --member N</code></p>\n", page::escape(&again))),
        ("figures", page::drawings(&drawn)),
        ("made", page::made(&Provenance::here(), ensemble.request.seed)),
    ]);
    files.write(&out.join("ensemble.html"), |file| file.write_all(page.as_bytes()))?;
    // Last: it says that the rest is there.
    files.write(&out.join("ensemble.json"), |file| results::as_json(file, ensemble))?;
    files.appear()
}

/// A row a member, with a link to its replay where it was written.
fn members(out: &Path, all: &[Ended]) -> String {
    let time = |time: Option<f64>| time.map_or_else(|| "–".to_owned(), |time| format!("{time:.2}"));
    let mut rows = String::new();
    for ended in all {
        let replay = format!("member-{}/replay.html", ended.member);
        let name = if out.join(&replay).exists() {
            format!("<a href=\"{replay}\">{}</a>", ended.member)
        } else {
            ended.member.to_string()
        };
        let _ = writeln!(
            rows,
            "<tr><td>{name}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2}</td></tr>",
            ended.verdict.words(),
            time(ended.enclosed_at_s),
            time(ended.settled_at_s),
            time(ended.lost_at_s),
            ended.simulated_s
        );
    }
    let heads =
        ["first held", "settled", "lost", "end"].map(|head| format!("<th>{head} <small>s</small></th>"));
    page::table(&format!("<th>member</th><th>verdict</th>{}", heads.concat()), &rows)
}
