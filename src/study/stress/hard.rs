//! What a hard case is: a scene, why it is hard, and the numbers that must hold.

use serde_json::Value;

use super::measure::Numbers;
use crate::case::Built;

/// The limit of a pair that holds a case at the step which it takes by itself.
pub const OWN_STEP: &str = "solver.step_s=null";

/// What a case is an example of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Theme {
    /// From soft to stiff cables, from short to long steps.
    Stiffness,
    /// Heavy on light.
    MassRatio,
    /// Cables that go taut at speed.
    Snap,
    /// Parts thinner than a step is long.
    ThinParts,
    /// Where the normal jumps.
    Edges,
    /// Fast targets.
    HighSpin,
    /// Nothing gives way.
    Jam,
    /// A start that overlaps.
    Overlap,
    /// Many contacts at once.
    ManyContacts,
    /// Very small, very large, far away.
    Scale,
    /// A million steps.
    LongRun,
    /// Steps that are too large for the method.
    LargeStep,
    /// Ten thousand knots.
    Size,
    /// Steps of parts.
    Substeps,
    /// Contacts that bounce while cables press them on.
    Restitution,
    /// Threads that throw knots about.
    Winch,
    /// Falls, tugs and threads onto thin parts.
    Pulled,
    /// Targets that turn whatever touches them.
    PrescribedSpin,
    /// Effects by twos, and all together.
    Together,
}

impl Theme {
    /// In words.
    pub fn title(self) -> &'static str {
        match self {
            Theme::Stiffness => "stiffness",
            Theme::MassRatio => "mass ratio",
            Theme::Snap => "snap",
            Theme::ThinParts => "thin parts",
            Theme::Edges => "edges and corners",
            Theme::HighSpin => "high spin",
            Theme::Jam => "jam",
            Theme::Overlap => "overlap at the start",
            Theme::ManyContacts => "many contacts",
            Theme::Scale => "scale",
            Theme::LongRun => "long run",
            Theme::LargeStep => "large step",
            Theme::Size => "size",
            Theme::Substeps => "sub-steps",
            Theme::Restitution => "restitution",
            Theme::Winch => "strong winches",
            Theme::Pulled => "falls and tugs onto thin parts",
            Theme::PrescribedSpin => "prescribed spin",
            Theme::Together => "pairs of effects",
        }
    }
}

/// A hard case.
#[derive(Clone)]
pub struct StressCase {
    /// Its name.
    pub name: &'static str,
    /// What it is an example of.
    pub theme: Theme,
    /// Why it is hard, in a sentence.
    pub why: &'static str,
    /// The scene; the pair of cables and contact is put in.
    pub scene: Value,
    /// The step over that which a pair takes by itself [-].
    pub times_step: f64,
    /// A start that no scene can ask for.
    pub start: Option<fn(&mut Built)>,
    /// What must hold.
    pub bounds: Numbers,
    /// Whether it must hold at half the step, too.
    pub halves: bool,
    /// Places where the checks may refuse it.
    pub refusals: Vec<&'static str>,
    /// Pairs that do not hold it.
    pub limits: Vec<KnownFailure>,
}

/// A pair that does not hold a case.
#[derive(Clone)]
pub struct KnownFailure {
    /// The pair.
    pub pair: &'static str,
    /// Why, in a sentence.
    pub why: &'static str,
    /// Changes of the scene with which it holds; none: no such are known.
    pub from: Vec<&'static str>,
    /// The numbers that break their bounds, and how far.
    pub foretold: Vec<FailureBand>,
    /// Whether it is not even run.
    pub not_run: bool,
}

/// What is known of a number that does not keep its bound: less, and the limit is no longer needed; more, and
/// something else is broken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FailureBand {
    /// The number, by its name in [`Numbers::each`].
    pub number: &'static str,
    /// Least value that was measured, with a margin [-].
    pub low: f64,
    /// Largest, with a margin [-].
    pub high: f64,
}

impl KnownFailure {
    /// What `numbers`, which break `bounds`, have against this limit: a bound that it does not foretell, a number
    /// that is worse than it says, or none that is as bad, so that nothing needs it any more.
    pub fn contradicted(&self, numbers: &Numbers, bounds: &Numbers) -> Vec<String> {
        let mut words = Vec::new();
        let mut needed = false;
        for ((name, value), (_, bound)) in numbers.each().into_iter().zip(bounds.each()) {
            let (Some(value), Some(bound)) = (value, bound) else { continue };
            match self.foretold.iter().find(|band| band.number == name) {
                Some(band) if value >= band.low && value <= band.high => needed = true,
                Some(band) if value.is_nan() || value > band.high => {
                    needed = true;
                    words.push(format!("{name} {value:.2e}, foretold at most {:.0e}", band.high));
                }
                None if value.is_nan() || value > bound => {
                    words.push(format!(
                        "{name} {value:.2e}, at most {bound:.0e}, and no word of it in the limit"
                    ));
                }
                _ => {}
            }
        }
        if !needed {
            words.push(format!("the limit is no longer needed: {}", self.why));
        }
        words
    }

    /// The changes in words.
    pub fn words(&self) -> String {
        let word = |&change: &&'static str| match change {
            OWN_STEP => "the step that it takes by itself",
            change => change,
        };
        self.from.iter().map(word).collect::<Vec<_>>().join(", ")
    }
}

impl StressCase {
    /// A case with the bounds that apply to all.
    pub fn new(theme: Theme, name: &'static str, why: &'static str, scene: Value) -> StressCase {
        StressCase {
            name,
            theme,
            why,
            scene,
            times_step: 1.0,
            start: None,
            bounds: Numbers::BOUNDS,
            halves: true,
            refusals: Vec::new(),
            limits: Vec::new(),
        }
    }

    /// At a multiple of the step that the pair takes by itself.
    pub fn at_times_step(mut self, factor: f64) -> StressCase {
        self.times_step = factor;
        self
    }

    /// From a start that no scene can ask for.
    pub fn starting(mut self, start: fn(&mut Built)) -> StressCase {
        self.start = Some(start);
        self
    }

    /// With other bounds.
    pub fn bounded(mut self, change: impl FnOnce(&mut Numbers)) -> StressCase {
        change(&mut self.bounds);
        self
    }

    /// Not at half the step, for its cost.
    pub fn once(mut self) -> StressCase {
        self.halves = false;
        self
    }

    /// Refused by the checks at one of `places`, or else it must hold.
    pub fn may_be_refused_at(mut self, places: &[&'static str]) -> StressCase {
        self.refusals.extend(places);
        self
    }

    /// `pair` holds it only with the changes `from`, and why; `foretold`: which numbers break their bounds as
    /// it is, from and up to which value.
    pub fn limited(
        mut self,
        pair: &'static str,
        why: &'static str,
        from: &[&'static str],
        foretold: &[(&'static str, f64, f64)],
    ) -> StressCase {
        let foretold =
            foretold.iter().map(|&(number, low, high)| FailureBand { number, low, high }).collect();
        self.limits.push(KnownFailure { pair, why, from: from.to_vec(), foretold, not_run: false });
        self
    }

    /// `pair` is not run, and why.
    pub fn not_run(mut self, pair: &'static str, why: &'static str) -> StressCase {
        self.limits.push(KnownFailure { pair, why, from: Vec::new(), foretold: Vec::new(), not_run: true });
        self
    }

    /// The limit of `pair`, if it has one.
    pub fn limit(&self, pair: &str) -> Option<&KnownFailure> {
        self.limits.iter().find(|limit| limit.pair == pair)
    }
}
