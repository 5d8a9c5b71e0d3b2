//! The scene as written, run first: what a study knows of it before a setting is measured.
//!
//! From it follow when net and target meet, what runs of other settings will cost, and how far they go. Errors are told until
//! contact, so where runs to the scene's end are too dear for a front, settings are run until contact only.

use super::bench::BenchmarkRunner;
use super::budget::{self, Extent};
use super::dials::{DialKind, DialSetting};
use super::reference::Reference;
use super::timing::timed_while;
use super::{Store, flight_times};
use crate::case::Case;
use crate::failure::Failure;
use crate::run::Run;
use crate::scene::Source;

/// Share of a budget that the run may cost [-].
const SHARE: f64 = 0.25;

/// Settings of the method that a study is for, at least.
const ENOUGH: usize = 12;

/// The run of a scene as written, as far as it was paid for.
pub struct FirstRun {
    /// The run.
    pub run: Run,
    /// Its processor time [s].
    pub seconds: f64,
    /// Whether it went to the scene's end.
    pub is_whole: bool,
}

impl FirstRun {
    /// A run of `base`, ended where it costs more than its share of a study's `budget` by its counts [s].
    ///
    /// # Errors
    /// A run that fails.
    pub fn of(base: &Case, budget: f64) -> Result<FirstRun, Failure> {
        let (done, seconds) = timed_while(base, |work| budget::price(base, work) <= SHARE * budget);
        done.map(|(run, is_whole)| FirstRun { run, seconds, is_whole })
    }

    /// When net and target first touch [s]; the end of the run where it had to end before.
    pub fn end_of_flight(&self) -> Option<f64> {
        let end = || self.run.frames.time.last().copied();
        self.run.extremes.first_contact.or_else(|| if self.is_whole { None } else { end() })
    }

    /// The scene `source`, built as `base`, until net and target meet or as far as `reference` knows its flight: where `seconds`
    /// do not pay for runs of enough `settings` to the scene's end.
    pub fn flight_only(
        &self,
        source: &Source,
        base: &Case,
        settings: &[DialSetting],
        seconds: f64,
        reference: Option<&Reference>,
    ) -> Option<(Source, Case)> {
        let of_method = settings.iter().skip(1).filter(|setting| setting.kind == DialKind::Method);
        let cases = of_method.filter_map(|setting| setting.case.as_ref().ok());
        let mut prices: Vec<f64> = cases.map(|case| budget::forecast(case, &self.run.work)).collect();
        prices.sort_by(f64::total_cmp);
        let dearest_of_enough = prices.len().min(ENOUGH - 1);
        if self.is_whole && prices[..dearest_of_enough].iter().sum::<f64>() <= seconds {
            return None;
        }
        let known =
            reference.and_then(|reference| reference.quality.windows.last()).map(|window| window.end_s);
        let end = known.or_else(|| flight_times(base, self.end_of_flight()).last().copied())?;
        let mut cut = source.clone();
        cut.set(&[format!("duration_s={end}"), "capture.hold_s=0".to_owned()]).ok()?;
        let case = Case::build(&cut).ok()?;
        Some((cut, case))
    }

    /// What a run of each of `settings` to the scene's end costs [s], by what `bench` measured of them as far as `extent` says;
    /// infinite where that was ended.
    pub fn prices<S: Store>(
        &self,
        settings: &[DialSetting],
        bench: &BenchmarkRunner<'_, S>,
        extent: Extent<'_>,
    ) -> Vec<f64> {
        let whole = |place: usize| match (extent, &settings[place].case) {
            (Extent::Flight, Ok(case)) if bench.price_of(place).is_finite() => match (place, self.is_whole) {
                (0, true) => budget::price(case, &self.run.work),
                _ => budget::forecast(case, &self.run.work),
            },
            _ => bench.price_of(place),
        };
        (0..settings.len()).map(whole).collect()
    }
}
