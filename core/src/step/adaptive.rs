//! Into how many parts a step is cut: one, and more where its cables would make energy, alone or together with contacts
//! of effects, where a thread would give more than its winches, or a jerk within it lengthen one beyond its reels.
//!
//! SolverIterations alone do not save a step that is long against the cables' own period: rows that did not
//! converge leave stretch, stretch of a stiff cable is energy, and the next step turns a part of it
//! into speed. A net of 6 x 6 meshes of 7 cm around a box (`stress e-`) gained so, over its launch
//! energy: at 0.5 ms nothing with nylon, 5 with 70 GPa, 18 with 230 GPa; at 5 ms 430 and 240 000. In
//! parts of a few periods rows converge in few sweeps. So a step whose cables made energy is taken
//! back and done again in twice as many parts, until they make none, or the parts are shorter than
//! those of an explicit net, where an implicit row is nearly exact; the number then falls by an
//! eighth a step.

use crate::interaction::Fared;

/// Energy that cables may make, over the largest that the net has had. SolverIterations answer to
/// less (see [`super::iterations`]). With 1e-5, 1e-4, 3e-4 and 1e-3 the free Cubesat takes 13 600, 8 000, 6 700
/// and 6 000 parts for its 6 000 steps. Between frames the Cubesat at 1 rad/s with a knot in the middle of
/// every cable gains 3e-4, 8e-4 and 2e-3 of the launch energy with 1e-4, 2e-4 and 3e-4.
const TOLERANCE: f64 = 2e-4;

/// The same for what constraints give beyond what was put in. A `cinch` that creates is bunched, and needs shorter parts for as
/// long as it winds: 24 about x with friction made, in the middle and at most, 1.5e-3 and 1.1e-2 of the energy at hand where nothing was
/// asked of them, 1.2e-3 and 5.8e-3 (of 16) where each step might make the whole of 2e-4; with 5e-4 for all of them 1.4e-4 and 6.6e-4, in 2.2
/// times the time, with 2e-4 5.8e-5 and 8.3e-5 (of 16) in 3.3 times. More parts for the steps to come, instead of this one done again,
/// cost as much.
const TOLERANCE_OF_CONSTRAINTS: f64 = 5e-4;

/// Of that, what a step may make however much the steps before it have made since the energy was least. Where net and target first
/// meet, or strands bounce, many steps in a row made nearly the whole of the tolerance each, and 1.6e-3 of the energy at
/// hand in the middle of 8 captures of the book's own satellite, 5.6e-3 in one of 8 of `stress strands-bounce`: 2e-4 and 3e-4
/// with one tolerance for all of them, in 1.02 times the time. With a share of 0.05 a net that is rubbed at 20 rad/s with a coefficient of 10
/// made up to 1.8e-3 of 24 times, with this one 1.5e-4.
const LEAST_SHARE: f64 = 0.01;

/// Parts of a step, at most.
pub const MOST_PARTS: u32 = 4096;

/// The number of parts, between its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveSubstep {
    least: u32,
    most: u32,
    /// Those that energy of cables and contacts may ask for, at most.
    most_for_energy: u32,
    now: u32,
    /// Largest energy of the net so far [J].
    scale: f64,
    by_cables: Allowance,
    by_constraints: Allowance,
}

/// What steps together may make.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Allowance {
    /// Over the largest energy of the net [-].
    tolerance: f64,
    /// By how much energy has risen above an earlier minimum, beyond what was put in [J].
    made: f64,
}

impl Allowance {
    fn new(tolerance: f64) -> Allowance {
        Allowance { tolerance, made: 0.0 }
    }

    /// Whether a step may make `gain`, where the net has had the energy `scale` [J]. A gain that is no number it may not.
    fn allows(&self, gain: f64, scale: f64) -> bool {
        let most = self.tolerance * scale;
        gain <= (most - self.made).max(LEAST_SHARE * most)
    }

    fn book(&mut self, gain: f64) {
        self.made = (self.made + gain).max(0.0);
    }
}

impl AdaptiveSubstep {
    /// Starts with `least` parts; at most `most`.
    pub fn new(least: u32, most: u32) -> AdaptiveSubstep {
        let least = least.max(1);
        AdaptiveSubstep {
            least,
            most: most.max(least),
            most_for_energy: most.max(least),
            now: least,
            scale: 0.0,
            by_cables: Allowance::new(TOLERANCE),
            by_constraints: Allowance::new(TOLERANCE_OF_CONSTRAINTS),
        }
    }

    /// Hears that for energy alone steps are to be in so many parts at most. What constraints make beyond that shorter parts do take: with a bound for
    /// all, 6 `tube`s of 20 N with latches and whole cables made 8.4e-4 of the energy at hand in the middle and 4.6e-3 at most; so 1.3e-4 and
    /// 2.3e-4 (of 8), in the same time.
    pub fn for_energy_at_most(&mut self, parts: u32) {
        self.most_for_energy = self.most.min(parts).max(self.least);
    }

    /// Hears that the coming step needs so many parts at least, whatever its energy.
    pub fn at_least(&mut self, parts: u32) {
        self.now = self.now.max(parts.min(MOST_PARTS));
    }

    /// Parts of the coming step.
    pub fn now(&self) -> u32 {
        self.now
    }

    /// Whether steps may be cut at all.
    pub fn may_cut(&self) -> bool {
        self.most > self.least
    }

    /// Hears that cables made `gain` of energy in a step that ended with `energy` in the net [J], and how
    /// constraints fared in it. Whether that will do; if not, the step is to be done again in the
    /// parts that are now asked for.
    pub fn accept(&mut self, gain: f64, energy: f64, constraints: Fared) -> bool {
        let constraints_will_do =
            !constraints.is_violated && self.by_constraints.allows(constraints.created, self.scale);
        let most = if constraints_will_do { self.most_for_energy } else { self.most };
        let will_do = constraints_will_do && self.by_cables.allows(gain, self.scale);
        if !will_do && self.now < most {
            self.now = (2 * self.now).min(most);
            return false;
        }
        self.scale = self.scale.max(energy);
        self.by_cables.book(gain);
        self.by_constraints.book(constraints.created);
        self.now = (self.now - (self.now / 8).max(1)).max(self.least);
        true
    }

    /// Hears of the energy of the net before any step [J].
    pub fn start(&mut self, energy: f64) {
        self.scale = self.scale.max(energy);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_share_what_they_may_make() {
        let mut substep = AdaptiveSubstep::new(1, 24);
        substep.start(1.0);
        assert!(substep.accept(1.5e-4, 1.0, Fared::default()));
        assert!(!substep.accept(1e-4, 1.0, Fared::default()), "more than is left");
        assert!(substep.accept(4e-5, 1.0, Fared::default()));
        assert!(substep.accept(1.9e-6, 1.0, Fared::default()), "a little may always be");
        assert!(substep.accept(-1e-3, 1.0, Fared::default()));
        assert!(substep.accept(1.5e-4, 1.0, Fared::default()), "all of it again after a loss");
    }

    #[test]
    fn constraints_have_an_allowance_of_their_own() {
        let made = |created| Fared { is_violated: false, created };
        let mut substep = AdaptiveSubstep::new(1, 24);
        substep.start(1.0);
        assert!(substep.accept(1.5e-4, 1.0, made(4.5e-4)));
        assert!(!substep.accept(0.0, 1.0, made(6e-5)), "more than is left");
        assert!(substep.accept(4e-5, 1.0, made(4e-5)));
        assert!(!substep.accept(0.0, 1.0, made(f64::NAN)), "what is not a number will not do");
    }

    /// Where more parts are of no help against energy, constraints still ask for them.
    #[test]
    fn energy_and_constraints_have_bounds_of_their_own() {
        let mut substep = AdaptiveSubstep::new(1, 16);
        substep.for_energy_at_most(4);
        substep.start(1.0);
        let parts = |substep: &mut AdaptiveSubstep, fared| {
            while !substep.accept(1e-3, 1.001, fared) {}
            substep.now()
        };
        assert_eq!(parts(&mut substep, Fared::default()), 3, "four, and fewer in the next step");
        assert_eq!(parts(&mut substep, Fared { is_violated: true, created: 0.0 }), 14);
    }

    #[test]
    fn a_step_that_makes_energy_is_cut_until_it_makes_none() {
        let mut substep = AdaptiveSubstep::new(1, 24);
        substep.start(1.0);
        let mut asked = vec![substep.now()];
        while !substep.accept(1e-3, 1.001, Fared::default()) {
            asked.push(substep.now());
        }
        assert_eq!(asked, [1, 2, 4, 8, 16, 24], "at the bound it has to do");
        for _ in 0..40 {
            assert!(substep.accept(0.0, 1.0, Fared::default()));
        }
        assert_eq!(substep.now(), 1);
        assert!(!substep.accept(0.0, 1.0, Fared { is_violated: true, created: 0.0 }), "threads");
        assert_eq!(substep.now(), 2);
        assert!(!substep.accept(f64::NAN, f64::NAN, Fared::default()), "what is not a number will not do");
    }
}
