//! What each kind of result brings to a page of many.

use std::fmt::Write as _;
use std::path::Path;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use serde::de::DeserializeOwned;

use crate::limits;
use crate::metrics::summary::Summary;
use crate::problems::Problems;
use crate::report::figure::{FigureKind, FigureRequest, ShownRun};
use crate::report::page::{self, escape};
use crate::report::recorded::RecordedRun;
use crate::report::rows::KeptRows;
use crate::report::sweep::{self, SweepResult};
use crate::report::{stress, table};
use crate::study::ensemble::Ensemble;
use crate::study::stress::Stress;
use crate::study::survival::Survival;

/// Most bytes of a file that is read.
const MOST_BYTES: u64 = 256 << 20;

/// Characters of a path that a link writes otherwise.
const IN_LINKS: &AsciiSet =
    &NON_ALPHANUMERIC.remove(b'/').remove(b'.').remove(b'-').remove(b'_').remove(b'+');

/// What a folder may hold, in the order of the page: verdicts and survival first, what methods cost last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ResultKind {
    /// A run.
    Run,
    /// An ensemble of a scene.
    Ensemble,
    /// Scenes or variants side by side.
    Comparison,
    /// A scene over its parameters.
    Sweep,
    /// A probability over parameters.
    Map,
    /// The best values of parameters.
    Optimum,
    /// Which input matters.
    Sensitivity,
    /// What depends on what.
    Dependency,
    /// A run beside another, or beside measured tracks.
    Residual,
    /// Parameters that meet measured tracks.
    Fit,
    /// The source's claims.
    Reproduction,
    /// What accuracy costs.
    Cost,
    /// The catalogue of hard cases.
    Stress,
}

impl ResultKind {
    /// All of them, in the order of the page.
    pub const ALL: [ResultKind; 13] = [
        ResultKind::Run,
        ResultKind::Ensemble,
        ResultKind::Comparison,
        ResultKind::Sweep,
        ResultKind::Map,
        ResultKind::Optimum,
        ResultKind::Sensitivity,
        ResultKind::Dependency,
        ResultKind::Residual,
        ResultKind::Fit,
        ResultKind::Reproduction,
        ResultKind::Cost,
        ResultKind::Stress,
    ];

    /// How one is called and how several are, and the file that says that a folder holds one.
    fn words(self) -> [&'static str; 3] {
        match self {
            ResultKind::Run => ["run", "runs", "summary.json"],
            ResultKind::Ensemble => ["ensemble", "ensembles", "ensemble.json"],
            ResultKind::Comparison => ["comparison", "comparisons", "compare.json"],
            ResultKind::Sweep => ["sweep", "sweeps", sweep::PLAN],
            ResultKind::Map => ["map", "maps", "map.json"],
            ResultKind::Optimum => ["optimum", "optima", "optimised.json"],
            ResultKind::Sensitivity => ["sensitivity", "sensitivities", "sensitivity.json"],
            ResultKind::Dependency => ["dependency", "dependencies", "dependency.json"],
            ResultKind::Residual => ["residual", "residuals", "residual.json"],
            ResultKind::Fit => ["fit", "fits", "fit.json"],
            ResultKind::Reproduction => ["reproduction", "reproductions", "reproduce.json"],
            ResultKind::Cost => ["cost study", "cost studies", "cost.json"],
            ResultKind::Stress => ["catalogue of hard cases", "catalogues of hard cases", "stress.json"],
        }
    }

    /// How one is called.
    pub fn name(self) -> &'static str {
        self.words()[0]
    }

    /// So many of them, in words.
    pub fn counted(self, n: usize) -> String {
        let [one, many, _] = self.words();
        format!("{n} {}", if n > 1 { many } else { one })
    }

    fn file(self) -> &'static str {
        self.words()[2]
    }

    /// The result's own page.
    fn page(self) -> String {
        match self {
            ResultKind::Run => "replay.html".to_owned(),
            _ => self.file().replace(".json", ".html"),
        }
    }

    /// Whether `folder` holds one.
    pub fn is_in(self, folder: &Path) -> bool {
        folder.join(self.file()).is_file()
    }
}

/// A result, read to be shown.
pub struct CollectedPart {
    /// What it is.
    pub kind: ResultKind,
    /// Its folder, as it was given.
    pub name: String,
    /// Its own title.
    pub title: String,
    /// What it found, in a sentence or two; may be empty.
    pub finding: String,
    /// Its folder, as HTML: with a link to its page where that has more than is shown.
    pub link: String,
    /// The summary of a run.
    pub summary: Option<Summary>,
    /// Survival of an ensemble.
    pub survival: Option<Survival>,
    /// What is shown below its title, as HTML; [`ANCHOR`] stands for its place in the page.
    html: String,
}

/// What stands for a part's place in the page.
const ANCHOR: &str = "{{here}}";

/// What a kind of result brings, before it is known from where.
#[derive(Default)]
struct Brought {
    title: String,
    finding: String,
    html: String,
    summary: Option<Summary>,
    survival: Option<Survival>,
}

impl CollectedPart {
    /// The result `kind` in `folder`, for a page in the folder `out`.
    ///
    /// # Errors
    /// Faults of its files.
    pub fn read(kind: ResultKind, folder: &Path, out: &Path) -> Result<CollectedPart, Problems> {
        let above = link(folder, out);
        let brought = match kind {
            ResultKind::Run => run(folder)?,
            ResultKind::Sweep => sweep(folder)?,
            ResultKind::Stress => stress_of(folder)?,
            ResultKind::Ensemble => {
                let ensemble: Ensemble = json(&folder.join(kind.file()))?;
                Brought { survival: ensemble.survival, ..own_page(kind, folder, &above)? }
            }
            _ => own_page(kind, folder, &above)?,
        };
        let name = folder.display().to_string();
        let page = kind.page();
        let link = if folder.join(&page).is_file() {
            format!("<a href=\"{above}{page}\">{}</a>", escape(&name))
        } else {
            escape(&name)
        };
        let Brought { title, finding, html, summary, survival } = brought;
        Ok(CollectedPart { kind, name, title, finding, link, summary, survival, html })
    }

    /// What is shown below its title, as HTML, at the place `anchor` of the page.
    pub fn body(&self, anchor: &str) -> String {
        self.html.replace(ANCHOR, anchor)
    }
}

/// The way from the folder `out` to `folder`, as a link has it.
fn link(folder: &Path, out: &Path) -> String {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let way = pathdiff::diff_paths(whole(folder), whole(out)).unwrap_or_else(|| whole(folder));
    let way: Vec<String> =
        way.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
    way.iter().map(|part| format!("{}/", utf8_percent_encode(part, IN_LINKS))).collect()
}

fn text(path: &Path) -> Result<String, Problems> {
    let bytes = limits::read_file(path, MOST_BYTES);
    let bytes = bytes.map_err(|error| fault(path, &error.to_string(), "a file in the folder of a result"))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn json<T: DeserializeOwned>(path: &Path) -> Result<T, Problems> {
    let read = serde_json::from_str(&text(path)?);
    read.map_err(|error| fault(path, &error.to_string(), "a result of this version of the program"))
}

fn fault(path: &Path, found: &str, allowed: &str) -> Problems {
    let mut problems = Problems::new("");
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    problems.add(name, found, allowed);
    problems
}

/// A result from the page that it wrote, whose links lead `above` from here.
fn own_page(kind: ResultKind, folder: &Path, above: &str) -> Result<Brought, Problems> {
    let place = folder.join(kind.page());
    let parts = page::parts(&text(&place)?);
    let Some(parts) = parts else {
        let allowed = format!("the page that a {} by this version of the program writes", kind.name());
        return Err(fault(&place, "a page of another kind", &allowed));
    };
    let html = below(&parts.body.replace("<a href=\"", &format!("<a href=\"{above}")));
    Ok(Brought { title: parts.title, finding: parts.lead, html, ..Brought::default() })
}

/// What stands in a page of its own, as it stands below a result's title.
fn below(html: &str) -> String {
    html.replace("<h2>", "<h3>")
        .replace("</h2>", "</h3>")
        .replace("<figure id=\"", &format!("<figure id=\"{ANCHOR}-"))
}

/// A run: its verdict, warnings, pictures and curves.
fn run(folder: &Path) -> Result<Brought, Problems> {
    let run = RecordedRun::read(folder)?;
    let finding = table::verdict(&run.summary);
    let mut html = format!("<p class=\"lead\">{}</p>\n", page::prose(&finding));
    for warning in &run.summary.warnings {
        let _ = writeln!(html, "<p class=\"warning\">Warning: {}.</p>", page::prose(warning));
    }
    let summary = run.summary.clone();
    let second = if run.target.is_some() { FigureKind::Closing } else { FigureKind::Deployment };
    let shown = [ShownRun { label: String::new(), run }];
    let request = FigureRequest::default();
    let mut drawn = Vec::new();
    for kind in [FigureKind::Strip, second, FigureKind::Energy] {
        let mut figure = request
            .drawn(kind, &shown)
            .map_err(|error| fault(folder, &error.to_string(), "curves that can be drawn"))?;
        figure.0.words = format!("tumblenet figure {} --of {}", folder.display(), kind.name());
        drawn.push(figure);
    }
    html += &below(&page::drawings(&drawn));
    let _ = write!(html, "<footer>{}</footer>", page::made(&summary.provenance, None));
    Ok(Brought { title: summary.title.clone(), finding, html, summary: Some(summary), survival: None })
}

/// A sweep: how many members, and what became of them.
fn sweep(folder: &Path) -> Result<Brought, Problems> {
    let allowed = "the folder of a sweep's results";
    let plan = sweep::read_plan(folder).map_err(|why| fault(&folder.join(sweep::PLAN), &why, allowed))?;
    let result = SweepResult::of(&plan, &KeptRows::read(folder, &plan));
    let words = sweep::words(&result);
    // The title stands in a line of its own.
    let finding = words.split_once('\n').map_or("", |(_, rest)| rest).replace('\n', " ");
    let html = format!(
        "<p class=\"lead\">{}</p>\n<footer>{}</footer>",
        page::prose(&finding),
        page::made(&plan.provenance, None)
    );
    Ok(Brought { title: result.title, finding, html, ..Brought::default() })
}

/// The catalogue of hard cases: verdicts by pairs, and what does not hold.
fn stress_of(folder: &Path) -> Result<Brought, Problems> {
    let stress: Stress = json(&folder.join(ResultKind::Stress.file()))?;
    let html = format!(
        "<section class=\"card\">\n{}</section>\n<footer>{}</footer>",
        stress::html(&stress),
        page::made(&stress.provenance, None)
    );
    Ok(Brought {
        title: "Hard cases".to_owned(),
        finding: stress::count(&stress),
        html,
        ..Brought::default()
    })
}
