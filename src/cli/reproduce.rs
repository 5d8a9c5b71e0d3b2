//! `tumblenet reproduce`: every claim of the source beside what is found here.

use std::collections::HashMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use tumblenet::case::Case;
use tumblenet::limits::Limits;
use tumblenet::problems::Problems;
use tumblenet::provenance::Provenance;
use tumblenet::report::figure::{FigureWords, ShownRun};
use tumblenet::report::files::WriteError;
use tumblenet::report::page::Figure;
use tumblenet::report::recorded::RecordedRun;
use tumblenet::report::reproduce::{self as report, StudyRows};
use tumblenet::report::rows::KeptRows;
use tumblenet::report::{dependency, files};
use tumblenet::scene::Source;
use tumblenet::study::compare::variants::of_scenes;
use tumblenet::study::compare::{self, CompareRequest, Comparison};
use tumblenet::study::ensemble::EnsembleRequest;
use tumblenet::study::reproduce::finding::Finding;
use tumblenet::study::reproduce::spec::{Claim, Claims, FigureRun, Question};
use tumblenet::study::reproduce::{ReproducedRow, Reproduction, tables};
use tumblenet::study::sweep::Sweep;
use tumblenet::study::sweep::dependency::Dependencies;

use super::fingerprint::fingerprint;
use super::reading::Reading;
use super::reported::Told;
use super::run::one;
use super::terminal::stage;
use super::{Error, sweep};

/// What is found of a claim whose study the short form does not run.
const LEFT_OUT: &str = "left out of the short form";

/// Arguments of `reproduce`.
#[derive(Args)]
pub struct Arguments {
    /// In short: few members, and none of the dear studies.
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    reading: Reading,
    /// Folder for the results; left out: results/reproduce, or results/reproduce-quick.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    told: Told,
}

/// Runs what is missing of the studies, and sets the source beside them.
pub fn main(arguments: &Arguments) -> Result<(), Error> {
    stage("reading and checking");
    let limits = arguments.reading.limits()?;
    let name = if arguments.quick { "reproduce-quick" } else { "reproduce" };
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join(name));
    // Before the runs, not after: an unwritable folder should cost none.
    files::make_folder(&out)?;
    let claims = Claims::built_in();
    let (studies, mut of_tables) = studies(&claims, arguments.quick, &out, limits)?;
    stage("setting side by side");
    let mut rows = Vec::new();
    for claim in &claims.claims {
        rows.push(row(claim, &studies, arguments.quick, limits)?);
    }
    // The tables of dependencies stand among those of their chapter.
    rows.append(&mut of_tables);
    rows.sort_by_key(|row| chapter(&row.place));
    let all = Reproduction { quick: arguments.quick, rows, provenance: Provenance::here() };
    let drawn = figures(&claims, arguments.quick, &out, limits)?;
    stage("writing");
    report::write(&out, &all, &drawn)?;
    arguments.told.tell(&all, &report::text(&all), &out.join("reproduce.html"))
}

/// The first number of a place, which is its chapter; what has none comes last.
fn chapter(place: &str) -> u32 {
    place.chars().find_map(|letter| letter.to_digit(10)).unwrap_or(u32::MAX)
}

/// Runs the studies that `claims` ask: their rows by name, and what their tables of dependencies say.
fn studies(
    claims: &Claims,
    quick: bool,
    out: &Path,
    limits: Limits,
) -> Result<(HashMap<String, StudyRows>, Vec<ReproducedRow>), Error> {
    let (mut studies, mut of_tables) = (HashMap::new(), Vec::new());
    for asked in &claims.studies {
        let members = if quick { asked.quick.map(|quick| quick.members) } else { asked.members };
        let study =
            Sweep::load_with(&asked.name, limits, |spec| spec.members = members.unwrap_or(spec.members))?;
        let command = format!("tumblenet sweep {}; tumblenet dependency results/{}", asked.name, asked.name);
        if quick && asked.quick.is_none() {
            // Its tables have their rows nevertheless, as claims have.
            let plan = study.plan("");
            if !plan.study.published.is_empty() {
                let all = Dependencies::of(&plan, &dependency::names(None), &[])?;
                of_tables.extend(tables::rows(&all, &claims.tables, &command, LEFT_OUT));
            }
            continue;
        }
        let folder = out.join(&asked.name);
        let (plan, _) = sweep::run_in(&study, |_| true, &folder)?;
        let kept = KeptRows::read(&folder, &plan);
        if !plan.study.published.is_empty() {
            let names = dependency::names(None);
            let observed = dependency::observed(&plan, &kept, &names)?;
            let all = Dependencies::of(&plan, &names, &observed)?;
            dependency::write(&folder, &all, plan.study.seed)?;
            of_tables.extend(tables::rows(&all, &claims.tables, &command, "no member has the number"));
        }
        studies.insert(asked.name.clone(), StudyRows { plan, kept });
    }
    Ok((studies, of_tables))
}

/// What is found of `claim`.
fn row(
    claim: &Claim,
    studies: &HashMap<String, StudyRows>,
    quick: bool,
    limits: Limits,
) -> Result<ReproducedRow, Error> {
    Ok(match &claim.of {
        Question::Cannot { because } => ReproducedRow::of(claim, Finding::nothing(because), String::new()),
        Question::Difference { scene, pairs } => {
            let comparison = compared(scene, pairs, if quick { 2 } else { 5 }, limits)?;
            let command = format!("tumblenet compare {scene} --solvers {}", pairs.join(","));
            ReproducedRow::of(claim, report::difference(&comparison, &claim.source), command)
        }
        Question::Outcome { study, .. } | Question::Number { study, .. } | Question::Trend { study, .. } => {
            let finding = match studies.get(study) {
                Some(rows) => rows.answer(claim)?,
                None => Finding::nothing(LEFT_OUT),
            };
            ReproducedRow::of(claim, finding, format!("tumblenet sweep {study}"))
        }
    })
}

/// A scene under the two pairs, as `compare` runs it.
fn compared(scene: &str, pairs: &[String; 2], members: usize, limits: Limits) -> Result<Comparison, Error> {
    let source = Source::find_within(scene, limits)?;
    let sources = [source];
    let variants = of_scenes(&sources, Some(pairs), &[])?;
    let base = variants.iter().find_map(|variant| variant.case.as_ref().ok());
    let request = CompareRequest {
        ensemble: EnsembleRequest { members, perturb_m: 1e-6, seed: 1, at_most_s: None },
        trust_distance_m: base.map_or(0.0, compare::trust_distance),
        serial: false,
    };
    let known = variants.iter().map(|_| Vec::new()).collect();
    let members = compare::run(&variants, &request, known, |_, _| {});
    Ok(Comparison::of(scene, &variants, &request, &members))
}

/// Figures of the source, drawn from runs of our own, which are kept in the folder `out`.
fn figures(claims: &Claims, quick: bool, out: &Path, limits: Limits) -> Result<Vec<(Figure, String)>, Error> {
    let mut drawn = Vec::new();
    for figure in claims.figures.iter().filter(|figure| figure.quick || !quick) {
        let request =
            FigureWords { of: vec![figure.of.clone()], at: figure.at.clone(), ..FigureWords::default() };
        let mut problems = Problems::new(&figure.number);
        let request = request.read(&mut problems);
        let request = problems.into_result(request)?;
        let (mut runs, mut folders) = (Vec::new(), Vec::new());
        for run in &figure.runs {
            let folder = out.join("runs").join(run.folder());
            runs.push(ShownRun { label: run.label.clone(), run: recorded(run, &folder, limits)? });
            folders.push(folder.display().to_string());
        }
        for &kind in request.of.iter().flatten() {
            let (mut shown, svg) = request
                .drawn(kind, &runs)
                .map_err(|error| WriteError::new(&out.join("reproduce.html"), error))?;
            shown.name = format!("figure-{}-{}", figure.number, kind.name()).into();
            shown.title = format!("Fig. {}: {}", figure.number, figure.title).into();
            shown.words = format!("tumblenet figure {}{}", folders.join(" "), figure.options());
            drawn.push((shown, svg));
        }
    }
    Ok(drawn)
}

/// In the folder of a run that is kept: which program wrote it.
const PROGRAM: &str = "program.txt";

/// The run in `folder`, or where this program has not written it there, a new one.
fn recorded(run: &FigureRun, folder: &Path, limits: Limits) -> Result<RecordedRun, Error> {
    let case = Case::load_changed(&run.scene, &run.changes(), limits)?;
    let (mark, program) = (folder.join(PROGRAM), fingerprint()?);
    if std::fs::read(&mark).is_ok_and(|by| by == program.as_bytes())
        && let Ok(kept) = RecordedRun::read(folder)
        && kept.summary.scene_hash == case.hash()
    {
        return Ok(kept);
    }
    one(&case, None, folder, &[])?;
    files::write(&mark, |file| file.write_all(program.as_bytes()))?;
    Ok(RecordedRun::read(folder)?)
}
