//! A sweep: one scene at many points of its parameters, a row of a table for every member.
//!
//! Member i of a study with m members a point is the copy i mod m of point ⌊i / m⌋. It is its number and the study's seed,
//! nothing else: which thread, shard or machine runs it, in which order, and how often, changes no bit of its row. What
//! depends on the machine, as wall times do, is in no row.

pub mod dependency;
pub mod design;
pub mod logistic;
pub mod map;
pub mod optimise;
pub mod outcome;
mod published;
pub mod refine;
pub mod sensitivity;
pub mod spec;

use std::path::Path;
use std::str::FromStr;

use data_encoding::HEXLOWER;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use sha2::{Digest, Sha256};

use super::ensemble::{self, EnsembleRequest};
use super::{caught, settle};
use crate::assets::Kind;
use crate::case::Case;
use crate::case::uncertain::check_ends;
use crate::json;
use crate::limits::{Limit, Limits};
use crate::metrics::summary::Summary;
use crate::parameter::{self, Own, Parameter, Pick};
use crate::problems::{Problems, did_you_mean, visible};
use crate::provenance::Provenance;
use crate::read;
use crate::scene::{self, Source};
use crate::target::files::Files;
use design::{Picks, Points};
use spec::{Design, SweepSpec};

/// Columns of every table before those of the inputs, and after them before the numbers of the summary.
const FIRST: [&str; 3] = ["member", "point", "seed"];
const OUTCOME: [&str; 4] = ["captured", "verdict", "reason", "failure"];

/// How the columns of inputs begin.
pub const INPUT: &str = "input.";

/// How the columns begin of what was drawn of what is uncertain in the scene.
pub const DRAWN: &str = "drawn.";

/// A study that was checked.
pub struct Sweep {
    spec: SweepSpec,
    points: Points,
    /// The scene before anything varies, every default filled in.
    source: Source,
    case: Case,
    n_members: u64,
    /// Numbers of the summary that rows have.
    names: Vec<String>,
}

/// What a table's rows were made from: `study.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepPlan {
    /// What the study asks.
    pub title: String,
    /// Rows of the same key go together: same scene, parameters, seed and program.
    pub key: String,
    /// Hash of scene and target before anything varies.
    pub scene_hash: String,
    /// All members.
    pub members: u64,
    /// Columns of a row.
    pub columns: Vec<String>,
    /// The study as written.
    pub study: SweepSpec,
    /// The scene before anything varies, every default filled in.
    pub scene: Value,
    /// What made it.
    pub provenance: Provenance,
}

/// Members of a plan, at most: beyond, it is none of this program, and what is missing would fill the memory.
const MOST_MEMBERS: u64 = 10_000_000;

impl SweepPlan {
    /// Whether it may be what this program wrote: a folder is called by its key, and its members are counted.
    ///
    /// # Errors
    /// Why it is not, in words.
    pub fn check(&self) -> Result<(), String> {
        if self.key.len() != 16 || HEXLOWER.decode(self.key.as_bytes()).is_err() {
            return Err(format!("its key is {:?}, not 16 digits of a hash", self.key));
        }
        if self.members > MOST_MEMBERS {
            return Err(format!("it has {} members, above {MOST_MEMBERS}", self.members));
        }
        if self.study.members == 0 {
            return Err("it has no members at its points".to_owned());
        }
        Ok(())
    }
}

/// A part of a sweep: every n-th member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its number, from 1.
    pub number: u64,
    /// How many there are.
    pub of: u64,
}

impl Shard {
    /// All of it.
    pub const ALL: Shard = Shard { number: 1, of: 1 };

    /// The one of so many that has `member`.
    pub fn with(member: u64, of: u64) -> Shard {
        Shard { number: member % of + 1, of }
    }

    /// Whether it has `member`.
    pub fn has(self, member: u64) -> bool {
        self == Shard::with(member, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let parts =
            text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        match parts {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Shard { number, of }),
            _ => Err("I/N, a number from 1 to N, as in 2/7".to_owned()),
        }
    }
}

/// How a member ended, and its row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its number, from 0.
    pub member: u64,
    /// Whether the target was captured; nothing without a verdict.
    pub captured: Option<bool>,
    /// A text for each column.
    pub fields: Vec<String>,
}

impl Sweep {
    /// Finds, reads and checks the study in the file `path`, or the built-in one of that name.
    ///
    /// # Errors
    /// Every fault at once: of the study, of its scene, and of the scene at the ends of every parameter.
    pub fn load(path: &str, limits: Limits) -> Result<Sweep, Problems> {
        Sweep::load_with(path, limits, |_| ())
    }

    /// The same, where `change` has changed what the file says.
    ///
    /// # Errors
    /// As [`Sweep::load`].
    pub fn load_with(
        path: &str,
        limits: Limits,
        change: impl FnOnce(&mut SweepSpec),
    ) -> Result<Sweep, Problems> {
        let known = "the path of a study file";
        super::load(path, Some(Kind::Study), known, limits, |mut spec: SweepSpec, file, limits, problems| {
            change(&mut spec);
            Sweep::check(spec, file, limits, problems)
        })
    }

    /// Reads and checks a study that is in no file; its paths are relative to the working folder, `name` is for results
    /// and messages.
    ///
    /// # Errors
    /// As [`Sweep::load`].
    pub fn of(study: &Value, name: &str, limits: Limits) -> Result<Sweep, Problems> {
        let mut problems = Problems::new(name);
        let spec = read::typed::<SweepSpec>(study, "", &mut problems);
        let sweep = spec.and_then(|spec| Sweep::check(spec, Path::new(name), limits, &mut problems));
        problems.into_result(sweep)
    }

    fn check(spec: SweepSpec, file: &Path, limits: Limits, problems: &mut Problems) -> Option<Sweep> {
        let scene = SceneOf { scene: &spec.scene, set: &spec.set, solver: spec.solver.as_deref() };
        let source = scene.source(file, limits, problems);
        let parameters = parameters(&spec, source.as_ref(), problems);
        let whole = parameters.len() == spec.parameters.len();
        let case = source.as_ref().and_then(|source| built(source, "scene", problems));
        let uncertain = case.as_ref().and_then(Case::uncertain).map_or(&[][..], |drawn| drawn.parameters());
        check_uncertain(&parameters, uncertain, case.is_some(), problems);
        let points = Points::new(spec.design, spec.seed, parameters, uncertain, problems);
        let n_members = points.count().and_then(|points| points.checked_mul(spec.members));
        if limits.exceeded(Limit::Members, n_members.map_or(f64::INFINITY, |members| members as f64)) {
            let found = n_members
                .map_or_else(|| "more than can be counted".to_owned(), |members| members.to_string());
            problems.add("design", format!("{found} members"), limits.allowed(Limit::Members));
        }
        let names = names(&spec, problems);
        if whole {
            published::check(&spec, &points, &names, problems);
        }
        let (source, case) = (source?, case?);
        check_fold(&spec, &case, problems);
        if whole {
            for (number, parameter) in points.parameters().iter().enumerate() {
                check_ends(&source, parameter, &format!("parameters[{number}]"), problems);
            }
        }
        let sweep = Sweep { spec, points, source, case, n_members: n_members?, names };
        if whole {
            published::check_outcomes(&sweep.spec.published_outcomes, &sweep.input_columns(), problems);
        }
        Some(sweep)
    }

    /// All members.
    pub fn n_members(&self) -> u64 {
        self.n_members
    }

    /// Name for results and messages.
    pub fn name(&self) -> &str {
        &self.source.name
    }

    /// The study as written.
    pub fn spec(&self) -> &SweepSpec {
        &self.spec
    }

    /// The scene before anything varies.
    pub fn case(&self) -> &Case {
        &self.case
    }

    /// What varies.
    pub fn parameters(&self) -> &[Parameter] {
        self.points.parameters()
    }

    /// The columns of a row that say at which values a member is run.
    fn input_columns(&self) -> Vec<String> {
        // Some are numbers of the summary too: the spin as it begins, and as it ends.
        let inputs = self.points.parameters().iter().flat_map(Parameter::columns);
        let drawn = self.case.uncertain().map_or_else(Vec::new, |drawn| drawn.columns());
        let drawn = drawn.into_iter().map(|name| format!("{DRAWN}{name}"));
        inputs.map(|name| format!("{INPUT}{name}")).chain(drawn).collect()
    }

    /// The columns of a row.
    pub fn columns(&self) -> Vec<String> {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        names(&FIRST)
            .into_iter()
            .chain(self.input_columns())
            .chain(names(&OUTCOME))
            .chain(self.names.iter().cloned())
            .collect()
    }

    /// What rows made by `program` go together with.
    pub fn plan(&self, program: &str) -> SweepPlan {
        SweepPlan {
            title: self.spec.title.clone(),
            key: self.key(program),
            scene_hash: self.case.hash().to_owned(),
            members: self.n_members,
            columns: self.columns(),
            study: self.spec.clone(),
            scene: self.source.json.clone(),
            provenance: Provenance::here(),
        }
    }

    /// The key of rows made by `program`. How many points an open design has is no part of it: more may come;
    /// nor is what others published.
    fn key(&self, program: &str) -> String {
        let (title, scene, published, published_outcomes) = Default::default();
        let mut spec = SweepSpec { title, scene, published, published_outcomes, ..self.spec.clone() };
        if let Design::Sobol { points: n } | Design::Random { points: n } | Design::Saltelli { base: n } =
            &mut spec.design
        {
            *n = 0;
        }
        let mut hasher = Sha256::new();
        for text in [program, self.case.hash(), &serde_json::to_string(&spec).unwrap_or_default()] {
            hasher.update(text);
            hasher.update([0]);
        }
        HEXLOWER.encode(&hasher.finalize()[..8])
    }

    /// Beyond the scene's end a member goes on for so long at most, until its verdict is decided [s].
    pub fn at_most_s(&self) -> Option<f64> {
        self.spec.at_most_s.map(|time| time.0)
    }

    fn point(&self, member: u64) -> u64 {
        member / self.spec.members
    }

    fn picks(&self, member: u64) -> Picks {
        self.points.at(self.point(member), member)
    }

    /// The scene that `member` runs.
    ///
    /// # Errors
    /// Faults that the ends of no single parameter have.
    pub fn member(&self, member: u64) -> Result<Case, Problems> {
        let (case, drawn) = self.drawn(member, &self.picks(member))?;
        self.member_of(&case, &drawn, member)
    }

    /// The scene at the point `picks`, and what is drawn in it for `member`.
    fn drawn(&self, member: u64, picks: &Picks) -> Result<(Case, Vec<Pick>), Problems> {
        let mut source = self.source.clone();
        let all = self.points.parameters().iter().zip(picks);
        let changes = all.filter_map(|(parameter, pick)| Some(parameter.change(pick.as_ref()?)));
        source.set(&changes.collect::<Vec<_>>())?;
        let case = Case::build_point(&source)?;
        let mut next = self.points.uncertain(self.point(member), member);
        let drawn = case.uncertain().map_or_else(Vec::new, |uncertain| uncertain.draw_from(&mut next));
        Ok((case, drawn))
    }

    fn member_of(&self, case: &Case, drawn: &[Pick], member: u64) -> Result<Case, Problems> {
        // Points of a block share their folds: a difference between them is none of chance.
        let fold = self.points.block().map_or(member, |n_points| {
            self.point(member) / n_points * self.spec.members + member % self.spec.members
        });
        let request = request(&self.spec);
        let perturbed = |case: &Case| ensemble::perturbed(case, &request, fold as usize);
        Ok(match case.uncertain() {
            Some(uncertain) => perturbed(&uncertain.with(drawn)?),
            None => perturbed(case),
        })
    }

    /// Where every member is, in the columns of inputs `names`: what is asked of a study before anything of it is run.
    ///
    /// # Errors
    /// Columns of `place` that no parameter fills with numbers.
    pub fn inputs(&self, names: &[String], place: &str) -> Result<Vec<Vec<f64>>, Problems> {
        let columns: Vec<String> = self
            .points
            .parameters()
            .iter()
            .flat_map(Parameter::columns)
            .map(|name| format!("{INPUT}{name}"))
            .collect();
        let mut problems = Problems::new(self.name());
        let mut wanted = Vec::new();
        for name in names {
            match columns.iter().position(|column| column == name) {
                Some(column) => wanted.push(column),
                None => {
                    let meant = did_you_mean(name, columns.iter().map(String::as_str));
                    problems.add(
                        place,
                        name,
                        format!("{meant}columns of parameters: {}", columns.join(", ")),
                    );
                }
            }
        }
        let mut all = Vec::new();
        for member in 0..self.n_members {
            if !problems.list.is_empty() {
                break;
            }
            let shown = self.points.shown(&self.picks(member), |path| self.source.own(path));
            let at: Option<Vec<f64>> = wanted.iter().map(|&column| shown[column].parse().ok()).collect();
            match at {
                Some(at) => all.push(at),
                None => problems.add(place, format!("words of member {member}"), "columns of numbers"),
            }
        }
        problems.into_result(Some(all))
    }

    /// Runs `member`. Whatever becomes of it, it has a row.
    pub fn run(&self, member: u64) -> Row {
        let picks = self.picks(member);
        let mut drawn = Vec::new();
        let outcome = caught(|| self.outcome(member, &picks, &mut drawn));
        let (point, seed) = (self.point(member), self.spec.seed);
        let mut fields = vec![member.to_string(), point.to_string(), seed.to_string()];
        fields.extend(self.points.shown(&picks, |path| self.source.own(path)));
        let n_drawn = self.case.uncertain().map_or(0, |uncertain| uncertain.columns().len());
        let shown = drawn.into_iter().flat_map(|pick| pick.shown).chain(std::iter::repeat(String::new()));
        fields.extend(shown.take(n_drawn));
        let (capture, failure) = match &outcome {
            Ok(summary) => (summary.capture, String::new()),
            Err(why) => (None, visible(&why.replace("\n  ", " "), false).into_owned()),
        };
        let text = |text: Option<&str>| text.unwrap_or_default().to_owned();
        fields.push(text(capture.map(|capture| if capture.captured { "true" } else { "false" })));
        fields.push(text(capture.map(|capture| capture.verdict.name())));
        fields.push(text(capture.map(|capture| capture.reason.name())));
        fields.push(failure);
        let scalars: std::collections::HashMap<String, f64> =
            outcome.map_or_else(|_| Default::default(), |summary| summary.scalars().into_iter().collect());
        let number =
            |name: &String| scalars.get(name).map_or_else(String::new, |value| parameter::number(*value));
        fields.extend(self.names.iter().map(number));
        Row { member, captured: capture.map(|capture| capture.captured), fields }
    }

    fn outcome(&self, member: u64, picks: &Picks, drawn: &mut Vec<Pick>) -> Result<Summary, String> {
        let told = |problems: Problems| problems.to_string();
        let point;
        (point, *drawn) = self.drawn(member, picks).map_err(told)?;
        let case = self.member_of(&point, drawn, member).map_err(told)?;
        let (run, curves) =
            settle::run(&case, self.at_most_s(), |_| {}).map_err(|failure| failure.to_string())?;
        Summary::of(&case, &run, &curves).sound()
    }

    /// Runs `members` in parallel, the first ones first; `done` hears of each as it ends.
    pub fn run_all(&self, members: Vec<u64>, done: impl Fn(Row) + Sync) {
        members.into_iter().par_bridge().for_each(|member| done(self.run(member)));
    }
}

/// The parameters of `spec`, those without a fault, about what the scene `source` says.
fn parameters(spec: &SweepSpec, source: Option<&Source>, problems: &mut Problems) -> Vec<Parameter> {
    parameter::check_apart(&spec.parameters, "parameters", problems);
    let own = |path: &str| source.map_or(Own::Unknown, |source| source.own(path));
    let all = spec.parameters.iter().enumerate();
    let read = all.filter_map(|(number, varied)| {
        Parameter::read(varied, &own(&varied.path), &format!("parameters[{number}]"), problems)
    });
    read.collect()
}

/// Adds parameters whose values would be drawn anew, and a study in which nothing varies.
fn check_uncertain(
    parameters: &[Parameter],
    uncertain: &[Parameter],
    is_known: bool,
    problems: &mut Problems,
) {
    for (number, parameter) in parameters.iter().enumerate() {
        let again =
            |drawn: &&Parameter| !drawn.is_about_own && parameter::overlap(&drawn.path, &parameter.path);
        if let Some(drawn) = uncertain.iter().find(again) {
            problems.add(
                format!("parameters[{number}].path"),
                format!("{:?}, which the scene draws anew as {:?}", parameter.path, drawn.path),
                "another value; or what is uncertain about it without a mean or ends of its own",
            );
        }
    }
    if parameters.is_empty() && uncertain.is_empty() && is_known && problems.list.is_empty() {
        problems.add("parameters", "none", "at least one, or a scene in which something is uncertain");
    }
}

/// The numbers of the summary that rows have.
fn names(spec: &SweepSpec, problems: &mut Problems) -> Vec<String> {
    let mut names = Summary::scalar_names();
    // What the solver is, is the same for all.
    names.retain(|name| !name.starts_with("solver.") && !Summary::is_of_machine(name));
    let Some(wanted) = &spec.collect else { return names };
    let is = |name: &str, wanted: &str| name == wanted || name.starts_with(&format!("{wanted}."));
    for (number, wanted) in
        wanted.iter().enumerate().filter(|(_, wanted)| !names.iter().any(|name| is(name, wanted)))
    {
        let blocks = names.iter().filter_map(|name| name.split('.').next());
        let meant = did_you_mean(wanted, names.iter().map(String::as_str).chain(blocks));
        let allowed = format!(
            "{meant}A number of the summary but those of solver and machine, or a block of them: capture"
        );
        problems.add(format!("collect[{number}]"), format!("{wanted:?}"), allowed);
    }
    names.retain(|name| wanted.iter().any(|wanted| is(name, wanted)));
    names
}

/// What a study says of its scene.
pub(super) struct SceneOf<'a> {
    /// A built-in scene, or a file.
    pub scene: &'a str,
    /// Changes by path.
    pub set: &'a Map<String, Value>,
    /// Cables and contact.
    pub solver: Option<&'a str>,
}

impl SceneOf<'_> {
    /// The scene of the study `file`, before anything varies, every default filled in.
    pub fn source(&self, file: &Path, limits: Limits, problems: &mut Problems) -> Option<Source> {
        let name = scene::name_of(file);
        let (text, folder) = match Kind::Scene.text(self.scene) {
            Some(text) => (text.to_owned(), None),
            None => {
                // A path without a folder is in this one.
                let folder = file.parent().unwrap_or(Path::new(""));
                let (bytes, path) =
                    Files::of(Some(folder), &limits).read(self.scene, Limit::Text, "scene", problems)?;
                (scene::as_text(bytes, "scene", problems)?, path.parent().map(Path::to_path_buf))
            }
        };
        let json = json::parse(&text, "scene", problems)?;
        let mut source = Source { name, input: self.scene.to_owned(), folder, json, limits };
        let mut changes: Vec<String> = self.set.iter().map(|(path, value)| change(path, value)).collect();
        if let Some((cables, contact)) = self.solver.and_then(|pair| pair.split_once('+')) {
            changes.extend([format!("solver.cables=\"{cables}\""), format!("solver.contact=\"{contact}\"")]);
        }
        // What the scene itself is expected to show is expected of no member.
        changes.push("expect=null".to_owned());
        if let Err(faults) = source.change(&changes) {
            problems.add_below("set", faults);
            return None;
        }
        let mut own = Problems::new("");
        let filled = source.scene(&mut own, |_, _, _| ()).map(|scene| scene.written_out());
        match filled {
            Some(filled) => source.json = filled,
            // With all its faults, not only those of single values.
            None => drop(built(&source, "scene", problems)),
        }
        own.list.is_empty().then_some(source)
    }
}

/// The case of `source`; its faults go to those of the study's `place`.
pub(super) fn built(source: &Source, place: &str, problems: &mut Problems) -> Option<Case> {
    Case::build(source).map_err(|faults| problems.add_below(place, faults)).ok()
}

/// How members of a point differ from each other, and how long they run.
fn request(spec: &SweepSpec) -> EnsembleRequest {
    let at_most_s = spec.at_most_s.map(|time| time.0);
    EnsembleRequest { members: 0, perturb_m: spec.perturb_m, seed: spec.seed, at_most_s }
}

/// Checks what members add to the scene: moved knots, and time.
fn check_fold(spec: &SweepSpec, case: &Case, problems: &mut Problems) {
    let request = request(spec);
    for fault in request.check(case).err().into_iter().flat_map(|faults| faults.list) {
        problems.add("perturb_m", fault.found, fault.allowed);
    }
    let Some(at_most) = request.at_most_s else { return };
    settle::check(case, at_most, "at_most_s", problems);
}

fn change(path: &str, value: &Value) -> String {
    format!("{path}={value}")
}
