//! The settings under measurement: each once, then those worth it again and again, as time allows.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::budget::{Budget, Extent};
use super::dials::{DialKind, DialSetting};
use super::errors::Evaluation;
use super::reference::{Reference, Window};
use super::timing::{Cost, timed_while};
use super::{MeasuredSetting, Store, front_of, knot_radius};
use crate::case::Case;
use crate::failure::Failure;
use crate::problems::Problem;
use crate::run::Run;

/// How the word on a setting begins that the budget did not cover.
pub const LEFT_OUT: &str = "left out";

/// Most repeats of a setting.
const REPEATS: usize = 9;

/// Settings off the front that are repeated: those within this factor of its cost at their error [-].
const NEAR: f64 = 1.5;

/// A run is ended that costs this many times what was foreseen: a stiff net may be cut into parts that nothing foretold, and
/// took 150 s of a study of 20 s [-].
const OVERRUN: f64 = 4.0;

/// One measurement of one setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Sample {
    /// Ends of the windows it was measured in, in frames of the reference: another reference, another error.
    windows: Vec<usize>,
    /// Processor time per simulated second [s/s].
    cost: f64,
    /// What the run was worth, or why it failed.
    outcome: Result<Evaluation, String>,
}

/// Why a setting is without a measurement that could have one.
#[derive(Clone, Copy, Debug, PartialEq)]
enum LeftOut {
    /// It is foreseen to cost that, and less is left [s].
    Unpaid(f64),
    /// It was ended when it had cost that [s].
    Ended(f64),
    /// It differs in contact only, and runs end before that.
    Alike,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LeftOut::Unpaid(seconds) => write!(f, "{LEFT_OUT}: about {seconds:.1} s"),
            LeftOut::Ended(seconds) => write!(f, "{LEFT_OUT}: more than {seconds:.1} s"),
            LeftOut::Alike => write!(f, "{LEFT_OUT}: alike before contact"),
        }
    }
}

/// The settings under measurement.
pub struct BenchmarkRunner<'a, S> {
    settings: &'a [DialSetting],
    reference: Option<&'a Reference>,
    store: &'a S,
    samples: Vec<Vec<Sample>>,
    left_out: Vec<Option<LeftOut>>,
    /// How far the runs go.
    extent: Extent<'a>,
}

impl<'a, S: Store> BenchmarkRunner<'a, S> {
    /// A bench for `settings`, the scene as written first, whose runs go as far as `extent` says.
    pub fn new(
        settings: &'a [DialSetting],
        reference: Option<&'a Reference>,
        store: &'a S,
        extent: Extent<'a>,
    ) -> Self {
        let (samples, left_out) = (vec![Vec::new(); settings.len()], vec![None; settings.len()]);
        BenchmarkRunner { settings, reference, store, samples, left_out, extent }
    }

    /// Takes over a run of the scene as written that was done before, in `seconds` of processor time: it is not done again.
    pub fn take_over(&mut self, run: &Run, seconds: f64) {
        let Ok(case) = &self.settings[0].case else { return };
        let sample = self.known(0, 0).unwrap_or_else(|| {
            let sample = self.sample_of(case, Ok(run), seconds);
            self.store.keep(case, "measured", 0, &sample);
            sample
        });
        self.samples[0].push(sample);
    }

    /// Each setting once for `survey` seconds, then those worth it again for `repeats` and what was left; what that cost [s]. `tell`
    /// hears what is done and about what has been spent [s].
    pub fn measure_all(&mut self, survey: f64, repeats: f64, mut tell: impl FnMut(&str, f64)) -> f64 {
        let mut budget = Budget::new(survey);
        self.survey(&mut budget, |what| tell(what, 0.0));
        budget.spend(-repeats);
        let left = budget.left();
        self.repeat(&mut budget, |what| tell(what, survey + repeats - left));
        survey + repeats - budget.left()
    }

    /// Each setting once, the cheapest first, as far as the budget goes.
    fn survey(&mut self, budget: &mut Budget, mut tell: impl FnMut(&str)) {
        let mut order: Vec<(f64, usize)> = (0..self.settings.len()).map(|i| (self.forecast(i), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        // The scene as written always, and first: the others are set against it.
        order.sort_by_key(|(_, place)| *place != 0);
        for (forecast, place) in order {
            if !self.samples[place].is_empty() {
                continue;
            }
            if matches!(self.extent, Extent::Flight) && self.settings[place].kind == DialKind::Contact {
                self.left_out[place] = Some(LeftOut::Alike);
                continue;
            }
            if place != 0 && !budget.covers(forecast) {
                self.left_out[place] = Some(LeftOut::Unpaid(forecast));
                continue;
            }
            tell(&self.settings[place].label);
            self.measure(place, budget);
        }
    }

    /// The front and what is near it again and again, one after the other, so that a machine that
    /// slows down slows all of them.
    fn repeat(&mut self, budget: &mut Budget, mut tell: impl FnMut(&str)) {
        for repeat in 1..REPEATS {
            for place in self.near_front() {
                if self.samples[place].len() == repeat && budget.covers(self.price_of(place)) {
                    tell(&format!("{}, repeat {}", self.settings[place].label, repeat + 1));
                    self.measure(place, budget);
                }
            }
        }
    }

    /// What a setting will cost [s]; nothing where it is refused.
    fn forecast(&self, place: usize) -> f64 {
        self.settings[place].case.as_ref().map_or(0.0, |case| self.extent.forecast(case))
    }

    /// What a sample cost, by its counts [s]: the same whether it was measured now or before.
    fn price(&self, place: usize, sample: &Sample) -> f64 {
        match (&self.settings[place].case, &sample.outcome) {
            (Ok(case), Ok(worth)) => self.extent.price(case, &worth.counts.work()),
            _ => self.forecast(place),
        }
    }

    fn windows(&self) -> Vec<usize> {
        self.reference.map_or_else(Vec::new, Reference::window_frames)
    }

    fn known(&self, place: usize, number: usize) -> Option<Sample> {
        let case = self.settings[place].case.as_ref().ok()?;
        self.store.known(case, "measured", number).filter(|sample: &Sample| sample.windows == self.windows())
    }

    /// Runs a setting once more, unless the first time it turns out far dearer than foreseen: the scene as written to its end.
    fn measure(&mut self, place: usize, budget: &mut Budget) {
        let Ok(case) = &self.settings[place].case else { return };
        let number = self.samples[place].len();
        let allowed = match (place, number) {
            (1.., 0) => budget.left().min(OVERRUN * self.forecast(place)),
            _ => f64::INFINITY,
        };
        let measured = || {
            let sample = self.sample(case, allowed)?;
            self.store.keep(case, "measured", number, &sample);
            Some(sample)
        };
        let Some(sample) = self.known(place, number).or_else(measured) else {
            self.left_out[place] = Some(LeftOut::Ended(allowed));
            budget.spend(allowed);
            return;
        };
        budget.spend(self.price(place, &sample));
        self.samples[place].push(sample);
    }

    /// A run of a setting that costs at most `allowed` by its counts [s]; none where it costs more.
    fn sample(&self, case: &Case, allowed: f64) -> Option<Sample> {
        let (done, seconds) = timed_while(case, |work| self.extent.price(case, work) <= allowed);
        match &done {
            Ok((_, false)) => None,
            Ok((run, true)) => Some(self.sample_of(case, Ok(run), seconds)),
            Err(failure) => Some(self.sample_of(case, Err(failure), seconds)),
        }
    }

    /// What a run of `case` was worth, and that it took `seconds` of processor time.
    fn sample_of(&self, case: &Case, run: Result<&Run, &Failure>, seconds: f64) -> Sample {
        let mut outcome =
            run.map(|run| Evaluation::of(case, run, self.reference)).map_err(ToString::to_string);
        if let (Extent::Flight, Ok(worth)) = (self.extent, &mut outcome) {
            worth.ending = None;
        }
        Sample { windows: self.windows(), cost: seconds / case.scene().duration_s.0, outcome }
    }

    /// What a run of a setting costs, by the counts of one where there is one, and else as foreseen [s]; infinite where it was ended.
    pub fn price_of(&self, place: usize) -> f64 {
        match (self.samples[place].last(), self.left_out[place]) {
            (Some(sample), _) => self.price(place, sample),
            (None, Some(LeftOut::Ended(_))) => f64::INFINITY,
            (None, _) => self.forecast(place),
        }
    }

    /// Places of the fronts, and of settings not much dearer than what these offer at their error.
    fn near_front(&self) -> Vec<usize> {
        let measured = self.measured();
        let near = |window: usize, floor: f64, place: usize| {
            let Some((cost, error)) = measured[place].point(window) else { return false };
            let front = measured.iter().filter(|one| one.fronts.contains(&window));
            let same = front.filter_map(|one| one.point(window)).filter(|p| p.1 <= error.max(floor));
            same.map(|p| p.0).fold(f64::INFINITY, f64::min) * NEAR >= cost
        };
        let windows = || self.reference.iter().flat_map(|reference| &reference.quality.windows).enumerate();
        let worth_it = |place: usize| windows().any(|(window, w)| near(window, w.floor_m, place));
        (0..measured.len()).filter(|&place| place == 0 || worth_it(place)).collect()
    }

    /// What has been measured so far.
    pub fn measured(&self) -> Vec<MeasuredSetting> {
        let mut measured: Vec<MeasuredSetting> = self
            .settings
            .iter()
            .zip(&self.samples)
            .zip(&self.left_out)
            .map(|((setting, samples), left_out)| MeasuredSetting::of(setting, samples, *left_out))
            .collect();
        let windows = self.reference.iter().flat_map(|reference| &reference.quality.windows);
        for (window, Window { floor_m, .. }) in windows.enumerate() {
            for place in front_of(&measured, window, *floor_m) {
                measured[place].fronts.push(window);
            }
        }
        measured
    }
}

impl MeasuredSetting {
    fn of(setting: &DialSetting, samples: &[Sample], left_out: Option<LeftOut>) -> MeasuredSetting {
        let worth = samples.first().and_then(|sample| sample.outcome.as_ref().ok());
        let failure = samples.first().and_then(|sample| sample.outcome.as_ref().err());
        let case = setting.case.as_ref();
        let refused = case.err().map(|problems| {
            let words = |p: &Problem| format!("{}: found {}; allowed: {}", p.place, p.found, p.allowed);
            format!("refused: {}", problems.list.iter().map(words).collect::<Vec<_>>().join("; "))
        });
        MeasuredSetting {
            kind: setting.kind,
            family: setting.family.to_owned(),
            label: setting.label.clone(),
            value: setting.value,
            changes: setting.changes.clone(),
            step_s: case.ok().and_then(|case| case.scene().solver.step_s).map(|step| step.0),
            without: refused
                .or_else(|| failure.map(|why| format!("failed: {why}")))
                .or_else(|| left_out.map(|left_out| left_out.to_string())),
            cost: Cost::of(samples.iter().filter(|s| s.outcome.is_ok()).map(|s| s.cost).collect()),
            worth: worth.cloned(),
            warnings: match (worth, case) {
                (Some(worth), Ok(case)) => worth.warnings(knot_radius(case)),
                _ => Vec::new(),
            },
            fronts: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Source;
    use crate::study::cost::dials;
    use crate::work::Work;
    use serde::Serialize;
    use serde::de::DeserializeOwned;

    /// Keeps nothing.
    struct Forgetful;

    impl Store for Forgetful {
        fn known<T: DeserializeOwned>(&self, _: &Case, _: &str, _: usize) -> Option<T> {
            None
        }
        fn keep<T: Serialize>(&self, _: &Case, _: &str, _: usize, _: &T) {}
    }

    /// What turns out dearer than what is left is ended and has no price that could be paid; the scene as written runs to its end, and so
    /// does what is cheap enough, to the bits of a run of its own.
    #[test]
    fn a_run_far_dearer_than_foreseen_is_ended() {
        let changes = ["net.meshes=[1,1]", "duration_s=0.4", "expect=null"].map(str::to_owned);
        let mut source = Source::find("cubesat-free").unwrap();
        source.set(&changes).unwrap();
        let base = Case::build(&source).unwrap();
        let (settings, nothing) = (dials::settings(&source, &base), Work::default());
        let place = settings.iter().position(|setting| setting.label == "joints 1 ms").unwrap();
        let case = settings[place].case.as_ref().unwrap();
        let mut bench = BenchmarkRunner::new(&settings, None, &Forgetful, Extent::Whole(&nothing));
        let forecast = bench.price_of(place);
        assert!(forecast > 0.0 && forecast.is_finite());

        let mut budget = Budget::new(1e-6);
        bench.measure(place, &mut budget);
        bench.measure(0, &mut budget);
        let measured = bench.measured();
        let told = measured[place].without.as_ref().unwrap();
        assert!(told.starts_with(LEFT_OUT) && bench.price_of(place).is_infinite(), "{told}");
        assert!(measured[0].cost.is_some() && bench.price_of(0).is_finite() && budget.left() == 0.0);

        let mut bench = BenchmarkRunner::new(&settings, None, &Forgetful, Extent::Whole(&nothing));
        bench.measure(place, &mut Budget::new(1e3));
        let (price, counts) = (bench.price_of(place), bench.measured()[place].worth.clone().unwrap().counts);
        assert_eq!(counts.work().substeps, crate::run::Run::of(case, |_| {}).unwrap().work.substeps);
        assert!((0.2..4.0).contains(&(price / forecast)), "{price} for {forecast}");
    }
}
