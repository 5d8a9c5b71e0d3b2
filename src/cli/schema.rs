//! `tumblenet schema`: the JSON Schema of every file that is read or written, from the types that do it.

use clap::ValueEnum;
use serde_json::Value;
use tumblenet::metrics::summary::Summary;
use tumblenet::read::{input_schema, schema};
use tumblenet::report::sweep::SweepResult;
use tumblenet::scene::schema::Scene;
use tumblenet::study::compare::Comparison;
use tumblenet::study::cost::Study;
use tumblenet::study::ensemble::Ensemble;
use tumblenet::study::experiment::found::Fit;
use tumblenet::study::experiment::residual::Residuals;
use tumblenet::study::experiment::spec::FitSpec;
use tumblenet::study::reproduce::Reproduction;
use tumblenet::study::stress::Stress;
use tumblenet::study::sweep::SweepPlan;
use tumblenet::study::sweep::dependency::Dependencies;
use tumblenet::study::sweep::map::CaptureMap;
use tumblenet::study::sweep::optimise::Optimised;
use tumblenet::study::sweep::sensitivity::Sensitivity;
use tumblenet::study::sweep::spec::SweepSpec;

/// Kinds of files.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SchemaOf {
    /// Scenes, of `run` and all others.
    Scene,
    /// Studies, of `sweep`.
    Study,
    /// Fits, of `fit`.
    Fit,
    /// `summary.json` of a run.
    Summary,
    /// `ensemble.json` of an ensemble.
    Ensemble,
    /// `compare.json`.
    Compare,
    /// `cost.json`.
    Cost,
    /// `stress.json`.
    Stress,
    /// `study.json` of a sweep's folder: what its rows are made from.
    Plan,
    /// `sweep.json`.
    Sweep,
    /// `map.json`.
    Map,
    /// `dependency.json`.
    Dependency,
    /// `sensitivity.json`.
    Sensitivity,
    /// `optimised.json`.
    Optimised,
    /// `residual.json`.
    Residual,
    /// `fit.json` of a fit's folder: what it found.
    Found,
    /// `reproduce.json`.
    Reproduce,
}

/// The schema of files of the kind `of`.
pub fn of(of: SchemaOf) -> Value {
    match of {
        SchemaOf::Scene => input_schema::<Scene>(),
        SchemaOf::Study => input_schema::<SweepSpec>(),
        SchemaOf::Fit => input_schema::<FitSpec>(),
        SchemaOf::Summary => schema::<Summary>(),
        SchemaOf::Ensemble => schema::<Ensemble>(),
        SchemaOf::Compare => schema::<Comparison>(),
        SchemaOf::Cost => schema::<Study>(),
        SchemaOf::Stress => schema::<Stress>(),
        SchemaOf::Plan => schema::<SweepPlan>(),
        SchemaOf::Sweep => schema::<SweepResult>(),
        SchemaOf::Map => schema::<CaptureMap>(),
        SchemaOf::Dependency => schema::<Dependencies>(),
        SchemaOf::Sensitivity => schema::<Sensitivity>(),
        SchemaOf::Optimised => schema::<Optimised>(),
        SchemaOf::Residual => schema::<Residuals>(),
        SchemaOf::Found => schema::<Fit>(),
        SchemaOf::Reproduce => schema::<Reproduction>(),
    }
}
