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

/// Energy that cables may make, over the largest that the net has had. SolverIterations answer to
/// less (see [`super::iterations`]). With 1e-5, 1e-4, 3e-4 and 1e-3 the free Cubesat takes 13 600, 8 000, 6 700
/// and 6 000 parts for its 6 000 steps. Between frames the Cubesat at 1 rad/s with a knot in the middle of
/// every cable gains 3e-4, 8e-4 and 2e-3 of the launch energy with 1e-4, 2e-4 and 3e-4.
const TOLERANCE: f64 = 2e-4;

/// Of that, what a step may make however much the steps before it have made since the energy was least. Where net and target first
/// meet, or strands bounce, many steps in a row made nearly the whole of the tolerance each, and 1.6e-3 of the energy at
/// hand in the middle of 8 captures of the book's own satellite, 5.6e-3 in one of 8 of `stress strands-bounce`: 2e-4 and 3e-4
/// with one tolerance for all of them, in 1.02 times the time.
const LEAST_SHARE: f64 = 0.05;

/// Parts of a step, at most.
pub const MOST_PARTS: u32 = 4096;

/// The number of parts, between its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveSubstep {
    least: u32,
    most: u32,
    now: u32,
    /// Largest energy of the net so far [J].
    scale: f64,
    /// By how much its energy has risen above an earlier minimum, beyond what was put in [J].
    made: f64,
}

impl AdaptiveSubstep {
    /// Starts with `least` parts; at most `most`.
    pub fn new(least: u32, most: u32) -> AdaptiveSubstep {
        let least = least.max(1);
        AdaptiveSubstep { least, most: most.max(least), now: least, scale: 0.0, made: 0.0 }
    }

    /// Hears that steps are to be in so many parts at most.
    pub fn at_most(&mut self, parts: u32) {
        self.most = self.most.min(parts).max(self.least);
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

    /// Energy that cables, and constraints each, may create within the coming step [J]: what the steps before it have left.
    pub fn may_create(&self) -> f64 {
        (TOLERANCE * self.scale - self.made).max(LEAST_SHARE * TOLERANCE * self.scale)
    }

    /// Hears that cables made `gain` of energy in a step that ended with `energy` in the net [J], and
    /// whether threads `overran` in it. Whether that will do; if not, the step is to be done again in the
    /// parts that are now asked for.
    pub fn accept(&mut self, gain: f64, energy: f64, overran: bool) -> bool {
        // A gain that is no number will not do either.
        let too_much = overran || gain.is_nan() || gain > self.may_create();
        if too_much && self.now < self.most {
            self.now = (2 * self.now).min(self.most);
            return false;
        }
        self.scale = self.scale.max(energy);
        self.made = (self.made + gain).max(0.0);
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
        assert!(substep.accept(1.5e-4, 1.0, false));
        assert!(!substep.accept(1e-4, 1.0, false), "more than is left");
        assert!(substep.accept(4e-5, 1.0, false));
        assert!(substep.accept(9e-6, 1.0, false), "a little may always be");
        assert!(substep.accept(-1e-3, 1.0, false));
        assert!(substep.accept(1.5e-4, 1.0, false), "all of it again after a loss");
    }

    #[test]
    fn a_step_that_makes_energy_is_cut_until_it_makes_none() {
        let mut substep = AdaptiveSubstep::new(1, 24);
        substep.start(1.0);
        let mut asked = vec![substep.now()];
        while !substep.accept(1e-3, 1.001, false) {
            asked.push(substep.now());
        }
        assert_eq!(asked, [1, 2, 4, 8, 16, 24], "at the bound it has to do");
        for _ in 0..40 {
            assert!(substep.accept(0.0, 1.0, false));
        }
        assert_eq!(substep.now(), 1);
        assert!(!substep.accept(0.0, 1.0, true), "threads");
        assert_eq!(substep.now(), 2);
        assert!(!substep.accept(f64::NAN, f64::NAN, false), "what is not a number will not do");
    }
}
