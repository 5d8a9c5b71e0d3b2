//! Figures of a run, or of several in the same axes, for print: what may be asked for, and the files.
//!
//! [`curves`] says which curves a figure has and from where in the results they come, [`strip`] is a row of pictures of net
//! and target, [`seen`] what of them a viewer sees, [`labels`] how runs are told apart, [`pixels`] makes PNG of SVG. Widths are
//! those of a column.

pub mod curves;
pub mod labels;
pub mod pixels;
pub mod seen;
pub mod strip;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::files::{self, WriteError};
use super::page::Figure;
use super::plots::{self, MOST_PENS, PlotError};
use super::recorded::RecordedRun;
use crate::problems::{Problems, did_you_mean};
use seen::View;

/// What a figure shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureKind {
    /// Pictures of net and target.
    Strip,
    /// Area of the bullets over time and distance (Fig. 3.4).
    Deployment,
    /// Linear and angular momentum (Fig. 4.18).
    Momentum,
    /// Energy, and where it went (Fig. 4.18).
    Energy,
    /// Spin, attitude and displacement of the target (Fig. 5.3, 5.5, 5.9).
    Motion,
    /// Contact impulses over time, and how many there are of each size (Fig. 5.8).
    Impulses,
    /// Mouth, enclosed share, closing threads.
    Closing,
    /// Largest tension, and its share of what breaks a cable.
    Tension,
}

impl FigureKind {
    /// All of them, in the order they are written.
    pub const ALL: [FigureKind; 8] = [
        FigureKind::Strip,
        FigureKind::Deployment,
        FigureKind::Momentum,
        FigureKind::Energy,
        FigureKind::Motion,
        FigureKind::Impulses,
        FigureKind::Closing,
        FigureKind::Tension,
    ];

    /// How it is called, in `--of` and in its file's name.
    pub fn name(self) -> &'static str {
        match self {
            FigureKind::Strip => "strip",
            FigureKind::Deployment => "deployment",
            FigureKind::Momentum => "momentum",
            FigureKind::Energy => "energy",
            FigureKind::Motion => "motion",
            FigureKind::Impulses => "impulses",
            FigureKind::Closing => "closing",
            FigureKind::Tension => "tension",
        }
    }

    /// What it shows, as a heading.
    pub fn title(self) -> &'static str {
        match self {
            FigureKind::Strip => "Net and target",
            FigureKind::Deployment => "How the net opens",
            FigureKind::Momentum => "Momentum",
            FigureKind::Energy => "Energy, and where it went",
            FigureKind::Motion => "Motion of the target",
            FigureKind::Impulses => "Contact impulses",
            FigureKind::Closing => "How the mouth closes",
            FigureKind::Tension => "Largest tension",
        }
    }

    /// Whether it has nothing to show of a run without a target.
    fn needs_target(self) -> bool {
        matches!(self, FigureKind::Motion | FigureKind::Impulses | FigureKind::Closing)
    }
}

/// Widths of a figure that are allowed [mm]: of a narrow column to a wide page.
const WIDTHS: [f64; 2] = [60.0, 300.0];

/// Width of a figure where nothing is said [mm]: of two columns.
pub const WIDE: f64 = 170.0;

/// Least width of a picture of a strip [mm].
const LEAST_PICTURE: f64 = 10.0;

/// What a user writes.
#[derive(Clone, Debug, Default)]
pub struct FigureWords {
    /// Names of figures; none: all that the runs have data for.
    pub of: Vec<String>,
    /// Times of the strip [s]; none: moments of the run.
    pub at: Vec<String>,
    /// Views of the strip; none: from the side.
    pub view: Vec<String>,
    /// Width, as in `85mm`.
    pub width: Option<String>,
    /// Kinds of files; none: SVG.
    pub format: Vec<String>,
    /// Dots an inch of PNG.
    pub dpi: Option<f64>,
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureRequest {
    /// The figures; none: all that the runs have data for.
    pub of: Option<Vec<FigureKind>>,
    /// Times of the strip [s]; none: moments of the run.
    pub at: Option<Vec<f64>>,
    /// Views of the strip.
    pub views: Vec<View>,
    /// Width [mm].
    pub width: f64,
    /// Whether there are files of SVG.
    pub svg: bool,
    /// Dots an inch of PNG; none: no such files.
    pub png: Option<f64>,
}

/// A run with its name in the figures.
pub struct ShownRun {
    /// What tells it from the others; empty for one alone.
    pub label: String,
    /// The run.
    pub run: RecordedRun,
}

impl FigureWords {
    /// What is asked for; every fault goes to `problems`. None where there is one.
    pub fn read(&self, problems: &mut Problems) -> Option<FigureRequest> {
        let known = problems.list.len();
        let of: Vec<FigureKind> = self.of.iter().filter_map(|word| kind(word, problems)).collect();
        let at: Vec<f64> = self.at.iter().filter_map(|word| time(word, problems)).collect();
        let views: Vec<View> = self.view.iter().filter_map(|word| view(word, problems)).collect();
        let (svg, png) = self.formats(problems);
        let width = self.width.as_ref().map_or(Some(WIDE), |word| width(word, problems))?;
        let most = ((width + strip::GAP) / (LEAST_PICTURE + strip::GAP)) as usize;
        if at.len() > most {
            problems.add(
                "--at",
                format!("{} times", at.len()),
                format!("at most {most} in a width of {width} mm"),
            );
        }
        (problems.list.len() == known).then_some(FigureRequest {
            of: (!of.is_empty()).then_some(of),
            at: (!at.is_empty()).then_some(at),
            views: if views.is_empty() { FigureRequest::default().views } else { views },
            width,
            svg,
            png,
        })
    }

    /// Whether SVG is wanted, and PNG of how many dots an inch.
    fn formats(&self, problems: &mut Problems) -> (bool, Option<f64>) {
        let wanted = |format: &str| self.format.iter().any(|word| word == format);
        for word in &self.format {
            let found = FORMATS.iter().find(|format| *format == word);
            named(found, word, "--format", FORMATS.into_iter(), problems);
        }
        let dots = self.dpi.unwrap_or(pixels::USUAL_DOTS);
        let [least, most] = pixels::DOTS;
        if wanted("png") && !pixels::CAN {
            problems.add("--format", "png", format!("svg: {}", pixels::PixelError::Without));
        } else if self.dpi.is_some() && !wanted("png") {
            problems.add("--dpi", dots, "--format png: SVG has no dots");
        } else if !(least..=most).contains(&dots) {
            problems.add("--dpi", dots, format!("{least} to {most} dots an inch"));
        }
        (wanted("svg") || self.format.is_empty(), wanted("png").then_some(dots))
    }
}

/// Kinds of files.
const FORMATS: [&str; 2] = ["svg", "png"];

/// What is called `word`; where nothing is, that is a fault of `place`, which tells all `names`.
fn named<'a, T>(
    found: Option<T>,
    word: &str,
    place: &str,
    names: impl Iterator<Item = &'a str> + Clone,
    problems: &mut Problems,
) -> Option<T> {
    if found.is_none() {
        let meant = did_you_mean(word, names.clone());
        problems.add(place, word, format!("{meant}one of {}", names.collect::<Vec<_>>().join(", ")));
    }
    found
}

fn kind(word: &str, problems: &mut Problems) -> Option<FigureKind> {
    let found = FigureKind::ALL.into_iter().find(|kind| kind.name() == word);
    named(found, word, "--of", FigureKind::ALL.iter().map(|kind| kind.name()), problems)
}

fn view(word: &str, problems: &mut Problems) -> Option<View> {
    named(View::named(word), word, "--view", View::names(), problems)
}

fn time(word: &str, problems: &mut Problems) -> Option<f64> {
    let found = word.trim().parse::<f64>().ok().filter(|time| time.is_finite());
    if found.is_none() {
        problems.add("--at", word, "times in seconds, as in 0.5,1,2");
    }
    found
}

fn width(word: &str, problems: &mut Problems) -> Option<f64> {
    let [least, most] = WIDTHS;
    let number = word.trim().strip_suffix("mm").unwrap_or("").trim_end().parse::<f64>().ok();
    let found = number.filter(|width| (least..=most).contains(width));
    if found.is_none() {
        problems.add("--width", word, format!("a width from {least}mm to {most}mm, as in 85mm"));
    }
    found
}

impl Default for FigureRequest {
    /// What is drawn where nothing is said.
    fn default() -> FigureRequest {
        let views = View::named("side").into_iter().collect();
        FigureRequest { of: None, at: None, views, width: WIDE, svg: true, png: None }
    }
}

impl FigureRequest {
    /// The runs with their names; faults of what is asked of them go to `problems`. None where there is one.
    pub fn shown(
        &self,
        runs: Vec<(PathBuf, RecordedRun)>,
        labels: &[String],
        problems: &mut Problems,
    ) -> Option<Vec<ShownRun>> {
        let known = problems.list.len();
        let folders: Vec<&Path> = runs.iter().map(|(folder, _)| folder.as_path()).collect();
        let most = (MOST_PENS, ": more lines look alike");
        let labels = labels::given_or_of(labels, &folders, most, problems);
        for (folder, run) in &runs {
            self.check(&folder.display().to_string(), run, problems);
        }
        let shown = runs.into_iter().zip(labels).map(|((_, run), label)| ShownRun { label, run });
        (problems.list.len() == known).then(|| shown.collect())
    }

    fn check(&self, name: &str, run: &RecordedRun, problems: &mut Problems) {
        for &time in self.at.iter().flatten() {
            if !(run.paths.time[0]..=run.end()).contains(&time) {
                let [start, end] = [run.paths.time[0], run.end()];
                problems.add("--at", time, format!("a time of {name}: {start} to {end} s"));
            }
        }
        for kind in self.of.iter().flatten() {
            if kind.needs_target() && run.target.is_none() {
                problems.add("--of", kind.name(), format!("figures that need no target: {name} has none"));
            }
        }
    }

    /// The figures that are drawn of `runs`.
    fn kinds(&self, runs: &[ShownRun]) -> Vec<FigureKind> {
        let has_target = runs.iter().any(|shown| shown.run.target.is_some());
        let all = || FigureKind::ALL.into_iter().filter(|kind| has_target || !kind.needs_target());
        self.of.clone().unwrap_or_else(|| all().collect())
    }

    /// The figure `kind` of `runs` for a page, and its drawing; [`Figure::panels`] are those of its curves.
    ///
    /// # Errors
    /// Never in memory; the drawing library says so by a type.
    pub fn drawn(&self, kind: FigureKind, runs: &[ShownRun]) -> Result<(Figure, String), PlotError> {
        let panels = if kind == FigureKind::Strip { Vec::new() } else { curves::panels(kind, runs) };
        let svg = if panels.is_empty() { strip::svg(runs, self) } else { plots::svg(&panels)? };
        let (name, title) = (kind.name().into(), kind.title().into());
        Ok((Figure { name, title, words: String::new(), panels }, svg))
    }

    /// Writes the figures of `runs` to the folder `out`; returns their places.
    ///
    /// # Errors
    /// The first file that cannot be written.
    pub fn write(&self, runs: &[ShownRun], out: &Path) -> Result<Vec<PathBuf>, WriteError> {
        files::make_folder(out)?;
        let mut files = files::Together::begin();
        let mut places = Vec::new();
        for kind in self.kinds(runs) {
            let place = |ending: &str| out.join(format!("figure-{}.{ending}", kind.name()));
            let svg = match kind {
                FigureKind::Strip => strip::svg(runs, self),
                _ => {
                    let panels = curves::panels(kind, runs);
                    plots::printed(&panels, self.width)
                        .map_err(|error| WriteError::new(&place("svg"), error))?
                }
            };
            if self.svg {
                places.push(place("svg"));
                files.write(&place("svg"), |file| file.write_all(svg.as_bytes()))?;
            }
            if let Some(dots) = self.png {
                let drawn = pixels::png(&svg, dots).map_err(|error| WriteError::new(&place("png"), error))?;
                places.push(place("png"));
                files.write(&place("png"), |file| file.write_all(&drawn))?;
            }
        }
        files.appear()?;
        Ok(places)
    }
}
