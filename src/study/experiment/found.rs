//! What a fit found: the parameters with their intervals, and what stands against them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checked::{FitAxis, FitStudy};
use super::fit::{FitError, Least};
use super::residual::Residuals;
use super::uncertainty::Uncertainty;
use crate::metrics::conservation::CREATED;

/// Share of its range within which a parameter is at an end of it.
const AT_END: f64 = 1e-6;

/// So many times the noise may be left before it is told.
const MOST_LEFT: f64 = 1.5;

/// Correlation from one sighting to the next from which it is told: what is left is then no noise.
const MOST_CORRELATION: f64 = 0.5;

/// `fit.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Fit {
    /// What the fit asks.
    pub title: String,
    /// Hash of scene and target before anything was fitted.
    pub scene_hash: String,
    /// What was found.
    pub parameters: Vec<FittedParameter>,
    /// Correlations of the parameters; null where they cannot be told apart.
    pub correlations: Option<Vec<Vec<f64>>>,
    /// Standard deviation of a coordinate, as the study says [m]; null where it was estimated.
    pub noise_known_m: Option<f64>,
    /// The same from what is left [m].
    pub noise_left_m: f64,
    /// Correlation of what is left of a marker along an axis from one sighting to the next.
    pub correlation: f64,
    /// By how much fewer independent sightings there are for it: variances are so many times larger.
    pub fewer: f64,
    /// Flights in all.
    pub flights: u64,
    /// Steps of the descent.
    pub steps: usize,
    /// Step of all flights [s]; null where the method has none of its own.
    pub step_s: Option<f64>,
    /// What stands against it, in words.
    pub warnings: Vec<String>,
    /// The command that flies the scene as it was found.
    pub again: String,
    /// What is left between the scene as it was found and the tracks.
    pub residual: Residuals,
}

/// A parameter that was fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FittedParameter {
    /// Its path.
    pub path: String,
    /// Its least and largest value.
    pub between: [f64; 2],
    /// Whether equal shares of its range are equal ratios.
    pub logarithmic: bool,
    /// What the scene says; null where that is no number within the range.
    pub own: Option<f64>,
    /// Where the descent began.
    pub start: f64,
    /// What was found.
    pub found: f64,
    /// Its interval of 95 %, which may reach beyond the range; null where parameters cannot be told apart.
    pub interval_95: Option<[f64; 2]>,
    /// Whether it is at an end of its range.
    pub at_end: bool,
}

impl FittedParameter {
    fn of(axis: &FitAxis, start: f64, unit: f64, half: Option<f64>) -> FittedParameter {
        FittedParameter {
            path: axis.parameter.path.clone(),
            between: axis.ends,
            logarithmic: axis.is_log,
            own: axis.own,
            start: axis.value(start),
            found: axis.value(unit),
            interval_95: half.map(|half| [axis.value(unit - half), axis.value(unit + half)]),
            at_end: !(AT_END..=1.0 - AT_END).contains(&unit),
        }
    }
}

impl FitStudy {
    /// Finds what makes the scene meet its tracks; `done` hears of every flight.
    ///
    /// # Errors
    /// See [`FitError`].
    pub fn find(&self, done: &(dyn Fn() + Sync)) -> Result<Fit, FitError> {
        let mut least = self.descend(done)?;
        let known = self.spec.noise_m.map(|noise| noise.0);
        let n_fitted = self.axes.len() + self.spec.align.n_numbers();
        let uncertain = |least: &Least, jacobian: &[Vec<f64>]| {
            Uncertainty::of(&least.left, least.seen(), jacobian, n_fitted, known)
        };
        let first = least.first_jacobian()?;
        let first = uncertain(&least, &first);
        // Then once more with derivatives over what is uncertain: a range may be much wider.
        let errors: Option<Vec<f64>> = (0..self.axes.len()).map(|number| first.error(number)).collect();
        let uncertainty = match errors {
            Some(errors) => {
                let jacobian = least.jacobian(&errors)?;
                uncertain(&least, &jacobian)
            }
            None => first,
        };
        let (residual, creates) = self.best(&least.units)?;
        done();
        let half = |number: usize| uncertainty.error(number).map(|error| uncertainty.reach * error);
        let parameters = self.axes.iter().enumerate().map(|(number, axis)| {
            FittedParameter::of(axis, least.start[number], least.units[number], half(number))
        });
        let parameters: Vec<FittedParameter> = parameters.collect();
        let changes = self.again(&least.units);
        Ok(Fit {
            title: self.spec.title.clone(),
            scene_hash: self.case.hash().to_owned(),
            warnings: warnings(&parameters, &uncertainty, known, creates),
            parameters,
            correlations: uncertainty.correlations(),
            noise_known_m: known,
            noise_left_m: uncertainty.noise,
            correlation: uncertainty.correlation,
            fewer: uncertainty.fewer,
            flights: least.n_flights() + 1,
            steps: least.steps,
            step_s: self.step(),
            again: format!("tumblenet run {}{changes}", self.spec.scene),
            residual,
        })
    }

    fn again(&self, units: &[f64]) -> String {
        let own = self.spec.set.iter().map(|(path, value)| format!("{path}={value}"));
        let pair = self.spec.solver.as_deref().and_then(|pair| pair.split_once('+'));
        let pair = pair.map(|(cables, contact)| {
            [format!("solver.cables={cables}"), format!("solver.contact={contact}")]
        });
        let all = own.chain(pair.into_iter().flatten()).chain(self.changes(units));
        all.map(|change| format!(" --set '{change}'")).collect()
    }
}

fn warnings(
    parameters: &[FittedParameter],
    uncertainty: &Uncertainty,
    known: Option<f64>,
    creates: bool,
) -> Vec<String> {
    let mut warnings = Vec::new();
    for parameter in parameters.iter().filter(|parameter| parameter.at_end) {
        warnings.push(format!("{} is at an end of its range: the least may lie beyond", parameter.path));
    }
    if uncertainty.covariance.is_none() {
        warnings.push("the parameters cannot be told apart by these tracks".to_owned());
    }
    if let Some(noise) = known.filter(|noise| uncertainty.noise > MOST_LEFT * noise) {
        let times = uncertainty.noise / noise;
        warnings.push(format!(
            "{times:.1} times the noise is left: no parameters make this scene meet the tracks"
        ));
    }
    if uncertainty.correlation > MOST_CORRELATION {
        let correlation = uncertainty.correlation;
        warnings.push(format!(
            "what is left goes on from one sighting to the next (correlation {correlation:.2}): it is no noise, the model \
             is not right, and the intervals are of the model"
        ));
    }
    if creates {
        warnings.push(format!("the flight that was found created more than {CREATED} of its energy"));
    }
    warnings
}
