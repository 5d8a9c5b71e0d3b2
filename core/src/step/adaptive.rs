//! Into how many parts a step is cut: one, and more where its cables would make energy, alone or together with contacts
//! of effects, where the engine's rows would take more than the cables' law does, where a thread would give more than
//! its winches, or a jerk within it lengthen one beyond its reels.
//!
//! SolverIterations alone do not save a step that is long against the cables' own period: rows that did not
//! converge leave stretch, stretch of a stiff cable is energy, and the next step turns a part of it
//! into speed. A net of 6 x 6 meshes of 7 cm around a box (`stress e-`) gained so, over its launch
//! energy: at 0.5 ms nothing with nylon, 5 with 70 GPa, 18 with 230 GPa; at 5 ms 430 and 240 000. In
//! parts of a few periods rows converge in few sweeps. So a step whose cables made energy is taken
//! back and done again in twice as many parts, until they make none, or the parts are shorter than
//! those of an explicit net, where an implicit row is nearly exact; the number then falls by an
//! eighth a step.
//!
//! Nor do rows take energy evenly: on a net of 4 x 4 meshes of 1 m (Kevlar, Table 3.2's damping) thirty steps of 2400 took 0.084 of the
//! 0.118 of the launch energy that all took. In twelve parts and more snaps and rows take turns as the cables would have it, and what is
//! taken beyond their law falls to 0.008.

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

/// What rows may take beyond the cables' law before net and target have met, over the largest energy of the net. Table 3.2's net
/// at damping ratios of 0.1 and 0.03 lost 1.3e-2 and 3.7e-2 without a bound, 5e-3 and 1.1e-2 with this one, in 1.1 and 1.3 times the time.
const TAKEN_IN_FLIGHT: f64 = 8e-3;

/// The same over what they may take in all, where that is more.
const SHARE_IN_FLIGHT: f64 = 0.05;

/// What rows of one step may always take, over the same, where they may take more than a hundred times as much in all. With a tenth of it
/// a Cubesat's capture at a damping ratio of 0.003 takes twice the time, and its rows 0.13 for 0.16.
const ALWAYS_TAKEN: f64 = 1e-4;

/// Parts of a step, at most.
pub const MOST_PARTS: u32 = 4096;

/// The number of parts, between its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveSubstep {
    least: u32,
    most: u32,
    /// Those that energy of cables and contacts may ask for, at most.
    most_for_energy: u32,
    /// Those that what rows take may ask for, at most.
    most_for_rows: u32,
    now: u32,
    /// Largest energy of the net so far [J].
    scale: f64,
    by_cables: Allowance,
    by_constraints: Allowance,
    by_rows: Allowance,
    /// What rows may take in all, over the largest energy of the net [-].
    loss_tolerance: f64,
}

/// What a step did with energy.
#[derive(Clone, Copy, Debug)]
pub struct StepEnergy {
    /// In the net at its end [J].
    pub at_end: f64,
    /// Made by cables, alone or together with contacts [J].
    pub made: f64,
    /// Taken by rows beyond the cables' law [J].
    pub taken_by_rows: f64,
}

/// What steps together may make, or take.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Allowance {
    /// Over the largest energy of the net [-].
    tolerance: f64,
    /// What a step may make however much others have made, over the same [-].
    always: f64,
    /// By how much energy has risen above an earlier minimum, beyond what was put in; or what was taken in sum [J].
    made: f64,
}

impl Allowance {
    fn new(tolerance: f64) -> Allowance {
        Allowance { tolerance, always: LEAST_SHARE * tolerance, made: 0.0 }
    }

    /// What rows may take.
    fn of_rows(tolerance: f64) -> Allowance {
        Allowance { always: ALWAYS_TAKEN.min(LEAST_SHARE * tolerance), ..Allowance::new(tolerance) }
    }

    /// Whether a step may make `gain`, where the net has had the energy `scale` [J]. A gain that is no number it may not.
    fn allows(&self, gain: f64, scale: f64) -> bool {
        gain <= (self.tolerance * scale - self.made).max(self.always * scale)
    }

    fn book(&mut self, gain: f64) {
        self.made = (self.made + gain).max(0.0);
    }
}

impl AdaptiveSubstep {
    /// Starts with `least` parts; at most `most`, and because of what rows take `most_for_rows`: `loss_tolerance` of the largest energy of
    /// the net [-].
    pub fn new(least: u32, most: u32, most_for_rows: u32, loss_tolerance: f64) -> AdaptiveSubstep {
        let least = least.max(1);
        let in_flight = loss_tolerance.min(TAKEN_IN_FLIGHT).max(SHARE_IN_FLIGHT * loss_tolerance);
        AdaptiveSubstep {
            least,
            most: most.max(least),
            most_for_energy: most.max(least),
            most_for_rows,
            now: least,
            scale: 0.0,
            by_cables: Allowance::new(TOLERANCE),
            by_constraints: Allowance::new(TOLERANCE_OF_CONSTRAINTS),
            by_rows: Allowance::of_rows(in_flight),
            loss_tolerance,
        }
    }

    /// Hears that net and target have met: rows may take more from now on, less what they took before.
    pub fn meet(&mut self) {
        self.by_rows = Allowance { made: self.by_rows.made, ..Allowance::of_rows(self.loss_tolerance) };
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

    /// Hears what a step did with energy, and how constraints fared in it. Whether that will do; if not, the step is to be
    /// done again in the parts that are now asked for.
    pub fn accept(&mut self, energy: StepEnergy, constraints: Fared) -> bool {
        let constraints_will_do =
            !constraints.is_violated && self.by_constraints.allows(constraints.created, self.scale);
        let most = if !constraints_will_do {
            self.most
        } else if !self.by_cables.allows(energy.made, self.scale) {
            self.most_for_energy
        } else if !self.by_rows.allows(energy.taken_by_rows, self.scale) {
            self.most_for_rows.min(self.most_for_energy)
        } else {
            self.now
        };
        if self.now < most {
            self.now = (2 * self.now).min(most);
            return false;
        }
        self.scale = self.scale.max(energy.at_end);
        self.by_cables.book(energy.made);
        self.by_constraints.book(constraints.created);
        // In sum, as it is told: where the law's own share was an upper estimate what was taken is below none.
        self.by_rows.made += energy.taken_by_rows;
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

    fn made(made: f64, at_end: f64) -> StepEnergy {
        StepEnergy { at_end, made, taken_by_rows: 0.0 }
    }

    #[test]
    fn steps_share_what_they_may_make() {
        let mut substep = AdaptiveSubstep::new(1, 24, 1, 0.1);
        substep.start(1.0);
        assert!(substep.accept(made(1.5e-4, 1.0), Fared::default()));
        assert!(!substep.accept(made(1e-4, 1.0), Fared::default()), "more than is left");
        assert!(substep.accept(made(4e-5, 1.0), Fared::default()));
        assert!(substep.accept(made(1.9e-6, 1.0), Fared::default()), "a little may always be");
        assert!(substep.accept(made(-1e-3, 1.0), Fared::default()));
        assert!(substep.accept(made(1.5e-4, 1.0), Fared::default()), "all of it again after a loss");
    }

    #[test]
    fn constraints_have_an_allowance_of_their_own() {
        let fared = |created| Fared { is_violated: false, created };
        let mut substep = AdaptiveSubstep::new(1, 24, 1, 0.1);
        substep.start(1.0);
        assert!(substep.accept(made(1.5e-4, 1.0), fared(4.5e-4)));
        assert!(!substep.accept(made(0.0, 1.0), fared(6e-5)), "more than is left");
        assert!(substep.accept(made(4e-5, 1.0), fared(4e-5)));
        assert!(!substep.accept(made(0.0, 1.0), fared(f64::NAN)), "what is not a number will not do");
    }

    /// Where more parts are of no help against energy, constraints still ask for them.
    #[test]
    fn energy_and_constraints_have_bounds_of_their_own() {
        let mut substep = AdaptiveSubstep::new(1, 16, 1, 0.1);
        substep.for_energy_at_most(4);
        substep.start(1.0);
        let parts = |substep: &mut AdaptiveSubstep, fared| {
            while !substep.accept(made(1e-3, 1.001), fared) {}
            substep.now()
        };
        assert_eq!(parts(&mut substep, Fared::default()), 3, "four, and fewer in the next step");
        assert_eq!(parts(&mut substep, Fared { is_violated: true, created: 0.0 }), 14);
    }

    #[test]
    fn a_step_that_makes_energy_is_cut_until_it_makes_none() {
        let mut substep = AdaptiveSubstep::new(1, 24, 1, 0.1);
        substep.start(1.0);
        let mut asked = vec![substep.now()];
        while !substep.accept(made(1e-3, 1.001), Fared::default()) {
            asked.push(substep.now());
        }
        assert_eq!(asked, [1, 2, 4, 8, 16, 24], "at the bound it has to do");
        for _ in 0..40 {
            assert!(substep.accept(made(0.0, 1.0), Fared::default()));
        }
        assert_eq!(substep.now(), 1);
        assert!(!substep.accept(made(0.0, 1.0), Fared { is_violated: true, created: 0.0 }), "threads");
        assert_eq!(substep.now(), 2);
        assert!(
            !substep.accept(made(f64::NAN, f64::NAN), Fared::default()),
            "what is not a number will not do"
        );
    }

    #[test]
    fn a_step_whose_rows_take_too_much_is_cut_as_far_as_that_helps() {
        let mut substep = AdaptiveSubstep::new(1, 24, 6, 0.1);
        substep.start(1.0);
        let took = |taken_by_rows| StepEnergy { at_end: 1.0, made: 0.0, taken_by_rows };
        let mut accepts = |taken| substep.accept(took(taken), Fared::default());
        assert!(accepts(7e-3));
        assert!(!accepts(2e-3), "more than is left in flight");
        assert!(!accepts(2e-3) && !accepts(2e-3) && accepts(2e-3), "2, 4 and 6 parts");
        assert!(accepts(7e-5), "a little may always be");
        substep.meet();
        for _ in 0..9 {
            assert!(substep.accept(took(1e-2), Fared::default()));
        }
        assert!(!substep.accept(took(1e-2), Fared::default()), "what flight and contact took together");
        assert!(substep.accept(took(9e-5), Fared::default()));
        let mut strict = AdaptiveSubstep::new(1, 24, 6, 1e-3);
        strict.start(1.0);
        strict.meet();
        assert!(strict.accept(took(9.9e-4), Fared::default()));
        assert!(!strict.accept(took(9e-5), Fared::default()), "a hundredth of the whole at most");
        let none_helps = AdaptiveSubstep::new(1, 24, 1, 0.1).accept(took(f64::NAN), Fared::default());
        assert!(none_helps, "parts in which rows would take more");
    }
}
