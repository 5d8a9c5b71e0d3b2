//! Which parameters make a scene meet measured tracks: least squares over flights.
//!
//! S(u) = Σ |r(u)|²,  r the coordinates that are left of all sightings once clock and frame are aligned (Eq. 3.20)
//!
//! u are the parameters as shares of their ranges, of the logarithms where a range is one of these. Flights at points that
//! fill the ranges come first; from the best of them MINPACK's Levenberg-Marquardt descends within the ranges, with
//! derivatives from both sides. All flights of one Jacobian, and all of the scan, run in parallel, and are summed in their
//! order: threads change no bit.
//!
//! Method and step are the same in all flights, those of the corner of the ranges that asks for the shortest step: a step that
//! went with the parameters would make what is left jump.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use rayon::prelude::*;
use rmpfit::{MPConfig, MPError, MPFitter, MPMaxFev, MPPar, MPResult, MPSide, MPSuccess};

use super::align::{AlignError, Alignment};
use super::checked::FitStudy;
use super::paths::KnotPaths;
use super::residual::{ResidualRequest, Residuals};
use super::tracks::Paired;
use crate::metrics::conservation::is_too_much;
use crate::metrics::summary::Summary;
use crate::run::Run;
use crate::study::settle;

/// Distance of the two flights of a derivative from its point, as a share of the range.
const STEP: f64 = 0.01;

/// Least and largest such distance for the intervals, where it is the standard error.
const STEPS: [f64; 2] = [1e-4, 0.05];

/// Change of a parameter, as a share of its range, and relative one of the sum of squares, below which the descent ends.
const TOLERANCE: [f64; 2] = [1e-6, 1e-8];

/// Most steps of the descent; flights are counted by themselves.
const MOST_STEPS: usize = 100;

/// Why a fit ended without a result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// A flight failed, or cannot be compared.
    #[error("with {changes}: {why}")]
    Flight {
        /// The parameters.
        changes: String,
        /// What happened.
        why: String,
    },
    /// There are fewer coordinates than numbers to be fitted.
    #[error("{coordinates} coordinates are seen before the run ends, of at least {needed}")]
    TooFew {
        /// So many there are.
        coordinates: usize,
        /// So many are needed.
        needed: usize,
    },
    /// As many flights as are allowed.
    #[error("no least after {0} flights (most_flights); nearest so far: {1}")]
    Flights(u64, String),
    /// The descent gave up.
    #[error("the descent ended without a least: {0}")]
    Descent(&'static str),
}

impl FitStudy {
    fn failed(&self, units: &[f64], why: String) -> FitError {
        FitError::Flight { changes: self.changes(units).join(", "), why }
    }

    /// What is left of `seen` after a flight at `units`.
    fn fly(&self, units: &[f64], seen: &[Paired]) -> Result<TrialFlight, String> {
        let case = self.case_at(units)?;
        let run = Run::of(&case, |_| {}).map_err(|failure| failure.to_string())?;
        let paths = KnotPaths::of(&case, run);
        let alignment = Alignment::fit(&paths, seen, self.spec.align).map_err(|why| why.to_string())?;
        let is_covered = |one: &&Paired| paths.covers(alignment.time(one));
        let (mut square, mut covered) = (0.0, 0_usize);
        for one in seen.iter().filter(is_covered) {
            square += alignment.residual(&paths, one).norm_squared();
            covered += 1;
        }
        if covered == 0 {
            return Err(AlignError::Apart.to_string());
        }
        let left = seen.iter().flat_map(|one| <[f64; 3]>::from(alignment.residual(&paths, one))).collect();
        Ok(TrialFlight {
            left,
            mean_square: square / covered as f64,
            covered,
            shift: alignment.shift,
            end: paths.end(),
        })
    }

    /// Flies at the least, `units`, and compares all of it; says too whether the flight created too much energy.
    pub(super) fn best(&self, units: &[f64]) -> Result<(Residuals, bool), FitError> {
        let failed = |why: String| self.failed(units, why);
        let case = self.case_at(units).map_err(failed)?;
        let (run, curves) =
            settle::run(&case, None, |_| {}).map_err(|failure| failed(failure.to_string()))?;
        let created = Summary::of(&case, &run, &curves).conservation.energy_created;
        let paths = KnotPaths::of(&case, run);
        let request = ResidualRequest { matching: self.spec.matching, align: self.spec.align };
        let residuals = request
            .compare((&self.spec.scene, &paths), (&self.spec.track, &self.tracks), &self.seen)
            .map_err(|why| failed(why.to_string()))?;
        Ok((residuals, is_too_much(created)))
    }

    /// Finds the least; `done` hears of every flight.
    ///
    /// # Errors
    /// See [`FitError`].
    pub(super) fn descend<'a>(&'a self, done: &'a (dyn Fn() + Sync)) -> Result<Least<'a>, FitError> {
        let mut flights = Flights { study: self, seen: self.seen.clone(), known: HashMap::new(), n: 0, done };
        let start = flights.scan()?;
        let needed = self.axes.len() + self.spec.align.n_numbers() + 1;
        let coordinates = 3 * flights.seen.len();
        if coordinates < needed {
            return Err(FitError::TooFew { coordinates, needed });
        }
        let mut units = start.clone();
        let mut descent = Descent::new(&mut flights, self.axes.len());
        let status = descent.mpfit(&mut units);
        let (fault, best) = (descent.fault.take(), descent.best.take());
        let status = match (status, fault) {
            (_, Some(FitError::Flights(n, _))) => {
                let nearest = best.map_or(start, |(_, nearest)| nearest);
                return Err(FitError::Flights(n, self.changes(&nearest).join(", ")));
            }
            (_, Some(fault)) => return Err(fault),
            (Err(error), None) => return Err(FitError::Descent(words_of(&error))),
            (Ok(status), None) => status,
        };
        if status.success == MPSuccess::MaxIter {
            return Err(FitError::Descent("too many steps"));
        }
        let left = flights.point(&units)?;
        Ok(Least { start, units, left: left.left.clone(), steps: status.n_iter, flights })
    }
}

/// Where the sum of squares is least.
pub(super) struct Least<'a> {
    /// Where the descent began.
    pub start: Vec<f64>,
    /// The parameters, as shares of their ranges.
    pub units: Vec<f64>,
    /// What is left there [m].
    pub left: Vec<f64>,
    /// Steps of the descent.
    pub steps: usize,
    flights: Flights<'a>,
}

impl Least<'_> {
    /// The derivatives of what is left [m], with flights so far from the least, as shares of the ranges.
    pub fn jacobian(&mut self, steps: &[f64]) -> Result<Vec<Vec<f64>>, FitError> {
        let steps: Vec<f64> = steps.iter().map(|step| step.clamp(STEPS[0], STEPS[1])).collect();
        self.flights.jacobian(&self.units, &steps)
    }

    /// The same with the distances of the descent.
    pub fn first_jacobian(&mut self) -> Result<Vec<Vec<f64>>, FitError> {
        self.flights.jacobian(&self.units, &vec![STEP; self.units.len()])
    }

    /// The sightings that were fitted.
    pub fn seen(&self) -> &[Paired] {
        &self.flights.seen
    }

    /// Flights so far.
    pub fn n_flights(&self) -> u64 {
        self.flights.n
    }
}

/// What is left of all sightings after a flight.
struct TrialFlight {
    /// Three coordinates a sighting [m].
    left: Vec<f64>,
    /// Over sightings before the end [m²].
    mean_square: f64,
    /// So many these are.
    covered: usize,
    /// Shift in time [s].
    shift: f64,
    /// The end [s].
    end: f64,
}

/// All flights so far: none is flown twice.
struct Flights<'a> {
    study: &'a FitStudy,
    seen: Vec<Paired>,
    known: HashMap<Vec<u64>, Arc<TrialFlight>>,
    n: u64,
    done: &'a (dyn Fn() + Sync),
}

impl Flights<'_> {
    /// Flies at all of `points` that are not known, in parallel; a flight that fails says why.
    fn all(&mut self, points: &[Vec<f64>]) -> Result<Vec<Result<Arc<TrialFlight>, FitError>>, FitError> {
        let key = |units: &Vec<f64>| units.iter().map(|unit| unit.to_bits()).collect::<Vec<u64>>();
        let mut asked = HashSet::new();
        let is_new = |units: &&Vec<f64>| !self.known.contains_key(&key(units)) && asked.insert(key(units));
        let new: Vec<&Vec<f64>> = points.iter().filter(is_new).collect();
        self.n += new.len() as u64;
        if self.n > self.study.spec.most_flights {
            return Err(FitError::Flights(self.study.spec.most_flights, "none yet".to_owned()));
        }
        let flown = new.into_par_iter().map(|units| {
            let flight = self.study.fly(units, &self.seen).map_err(|why| self.study.failed(units, why));
            (self.done)();
            (key(units), flight.map(Arc::new))
        });
        let flown: Vec<_> = flown.collect();
        let mut failed = HashMap::new();
        for (key, flight) in flown {
            match flight {
                Ok(flight) => drop(self.known.insert(key, flight)),
                Err(why) => drop(failed.insert(key, why)),
            }
        }
        let of = |units: &Vec<f64>| match self.known.get(&key(units)) {
            Some(flight) => Ok(Arc::clone(flight)),
            None => Err(failed.get(&key(units)).cloned().unwrap_or(FitError::Descent("a flight is missing"))),
        };
        Ok(points.iter().map(of).collect())
    }

    fn point(&mut self, units: &[f64]) -> Result<Arc<TrialFlight>, FitError> {
        self.all(&[units.to_vec()])?.pop().unwrap_or(Err(FitError::Descent("a flight is missing")))
    }

    /// Flies at the scene's own point and at those that fill the ranges; the best of them. From then on what is seen is
    /// what the best one sees before its end.
    fn scan(&mut self) -> Result<Vec<f64>, FitError> {
        let axes = &self.study.axes;
        let own: Vec<f64> = axes.iter().map(|axis| axis.own.map_or(0.5, |own| axis.unit(own))).collect();
        let point = |number: u32| -> Vec<f64> {
            (0..axes.len() as u32).map(|axis| f64::from(sobol_burley::sample(number, axis, 0))).collect()
        };
        let points: Vec<Vec<f64>> =
            std::iter::once(own).chain((0..self.study.spec.scan).map(point)).collect();
        let mut best: Option<(usize, Arc<TrialFlight>)> = None;
        let mut fault = None;
        for (number, flight) in self.all(&points)?.into_iter().enumerate() {
            match flight {
                Ok(flight) => {
                    if best.as_ref().is_none_or(|(_, least)| flight.mean_square < least.mean_square) {
                        best = Some((number, flight));
                    }
                }
                Err(why) => fault = fault.or(Some(why)),
            }
        }
        let Some((number, best)) = best else {
            return Err(fault.unwrap_or(FitError::Descent("nothing was flown")));
        };
        if best.covered < self.seen.len() {
            let last = best.end + 1e-9 * best.end;
            self.seen.retain(|one| one.seen.time + best.shift <= last);
            self.known.clear();
        }
        Ok(points[number].clone())
    }

    /// Derivatives of what is left [m] at `units`, a column a parameter, from flights `steps` to both sides within the
    /// ranges.
    fn jacobian(&mut self, units: &[f64], steps: &[f64]) -> Result<Vec<Vec<f64>>, FitError> {
        let mut points = Vec::new();
        for (axis, step) in steps.iter().enumerate() {
            for side in [-step, *step] {
                let mut point = units.to_vec();
                point[axis] = (point[axis] + side).clamp(0.0, 1.0);
                points.push(point);
            }
        }
        let flown = self.all(&points)?.into_iter().collect::<Result<Vec<_>, _>>()?;
        let column = |axis: usize| {
            let [below, above] = [2 * axis, 2 * axis + 1];
            let apart = points[above][axis] - points[below][axis];
            let pairs = flown[above].left.iter().zip(&flown[below].left);
            pairs.map(|(above, below)| (above - below) / apart).collect()
        };
        Ok((0..units.len()).map(column).collect())
    }
}

/// The descent as MPFIT sees it; residuals in metres, as their unit moves no least.
struct Descent<'f, 'a> {
    flights: &'f mut Flights<'a>,
    parameters: Vec<MPPar>,
    config: MPConfig,
    fault: Option<FitError>,
    /// Least sum of squares so far, and where.
    best: Option<(f64, Vec<f64>)>,
}

impl<'f, 'a> Descent<'f, 'a> {
    fn new(flights: &'f mut Flights<'a>, n: usize) -> Descent<'f, 'a> {
        let parameter = || MPPar {
            limited_low: true,
            limited_up: true,
            limit_low: 0.0,
            limit_up: 1.0,
            side: MPSide::User,
            ..MPPar::new()
        };
        let config = MPConfig {
            xtol: TOLERANCE[0],
            ftol: TOLERANCE[1],
            max_iter: MOST_STEPS,
            max_fev: MPMaxFev::NoLimit,
            ..MPConfig::new()
        };
        let parameters = (0..n).map(|_| parameter()).collect();
        Descent { flights, parameters, config, fault: None, best: None }
    }

    /// MPFIT's errors say nothing of why.
    fn kept<T>(&mut self, found: Result<T, FitError>) -> MPResult<T> {
        found.map_err(|fault| {
            self.fault = Some(fault);
            MPError::Eval
        })
    }
}

impl MPFitter for Descent<'_, '_> {
    fn eval(&mut self, units: &[f64], deviates: &mut [f64]) -> MPResult<()> {
        let flight = self.flights.point(units);
        let flight = self.kept(flight)?;
        deviates.copy_from_slice(&flight.left);
        let squares = flight.left.iter().map(|r| r * r).sum();
        if self.best.as_ref().is_none_or(|(least, _)| squares < *least) {
            self.best = Some((squares, units.to_vec()));
        }
        Ok(())
    }

    fn number_of_points(&self) -> usize {
        3 * self.flights.seen.len()
    }

    fn config(&self) -> &MPConfig {
        &self.config
    }

    fn parameters(&self) -> &[MPPar] {
        &self.parameters
    }

    fn jacobian(
        &mut self,
        units: &[f64],
        deviates: &mut [f64],
        derivatives: &mut [Option<Vec<f64>>],
    ) -> MPResult<()> {
        self.eval(units, deviates)?;
        let found = self.flights.jacobian(units, &vec![STEP; units.len()]);
        let found = self.kept(found)?;
        for (asked, found) in derivatives.iter_mut().zip(found) {
            *asked = asked.is_some().then_some(found);
        }
        Ok(())
    }
}

fn words_of(error: &MPError) -> &'static str {
    match error {
        MPError::Nan => "a derivative that is not finite",
        MPError::DoF | MPError::Empty => "fewer coordinates than parameters",
        _ => "bounds that cannot be",
    }
}
