//! Winches that reel a thread in, and never pay it out.
//!
//! The length still off the reels, L, falls by at most the reel speed of every winch, and by no
//! more than the knots compliance: after a step of h seconds that left the thread S long
//!
//!   L ← min(L, max(S, L − n s h)),
//!
//! with n winches of speed s. The thread pulls with what brings S to L − n s h, and with the
//! tension limit at most; where that does not suffice the reels stand at the present length. L
//! never rises: that is the ratchet. A pull from outside beyond the limit drags S beyond L against
//! the full tension, and S comes back when it ends; that drag is tallied. Tension never exceeds the
//! limit, so a bullet that pulls harder is braked over a way: 30 g at 1.8 m/s have 0.05 J, which
//! two threads of 1 N take up over 2.4 cm, 3.5 % of a side of 0.7 m.
//!
//! Winding ends at a given length: the knots and the tube bunched between them take room.
//!
//! **Inertia.** A reel of inertia J and radius r acts on the thread like the mass m_r = J / r². Its
//! motor speeds it up with the tension limit as its force, the thread holds it back:
//! s ← min(s_max, s + T_max h / m_r) − λ / m_r, not below 0. Without inertia s = s_max at once.
//!
//! **Work.** The winches put in T (−dL/dt), tension times the rate of reeling in, and what the
//! reels gain in kinetic energy. The thread passes on less: going taut against moving knots is
//! inelastic, friction at the knots takes its part.
//!
//! **Resistance.** The thread is solved with the inverse mass w of its own knots, which are light,
//! and the cables that hold them answer only when the world moves: within the same step they undo
//! most of what the thread did, and pulling for w alone it would stall at a tension of
//! n s / (h w), far below its limit. So the winch remembers by how much the rest of the world
//! lengthened the thread in the last steps, and pulls for that in advance.
//!
//! It pulls for no more than that, however heavy the ends that drag the thread out: a pull that would brake two bullets
//! within ten steps, on a thread whose light knots swing, threw these at 150 m/s and made up to 0.1 J a step. What
//! sudden pulls of bullets leave too long, a shorter step mends (see `EXCESS` of the mechanism).

use super::thread::LengthCommand;

/// How fast the remembered resistance follows the last step's. On the Cubesat 0 stalls, 0.2 and
/// 0.5 reach the tension limit, and from 0.5 on a thread that comes free overshoots: it does more work on
/// the knots than the winches on it.
const FOLLOW: f64 = 0.2;

/// A tension this share off the limit is at it.
const ROUNDING: f64 = 1e-9;

/// What the winches of a thread can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Number of winches on the thread.
    pub winches: f64,
    /// Speed at which each reels in, at most [m/s].
    pub speed: f64,
    /// Largest tension [N].
    pub tension: f64,
    /// Inertia of a reel over its radius squared [kg]; 0: none.
    pub reel_mass: f64,
    /// Share of the thread's full length at which winding ends [-].
    pub stop_share: f64,
}

/// The winches of one thread.
#[derive(Clone, Copy, Debug)]
pub struct Winch {
    drive: Drive,
    /// Length off the reels [m].
    length: f64,
    /// Length at which winding ends [m].
    stop: f64,
    /// Speed of each reel, positive when it reels in [m/s].
    speed: f64,
    /// Lengthening of the thread by the rest of the world that is expected in a step [m/s].
    resistance: f64,
    /// By how much the thread is longer than what is off the reels, as last heard [m].
    beyond: f64,
    /// The step under way, until its outcome is known.
    commanded: Option<Commanded>,
    /// Tension in the last (sub-)step [N].
    pull: f64,
    /// Largest tension since it was last read [N].
    pub tension: f64,
    /// As in the tally, since it was last set to nothing [m].
    pub excess: f64,
    /// What it has done.
    pub tally: WinchRecord,
}

#[derive(Clone, Copy, Debug)]
struct Commanded {
    shortest: f64,
    step: f64,
    impulse: f64,
    length_ahead: f64,
}

/// What the winches of a thread have done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WinchRecord {
    /// Work put in [J].
    pub work: f64,
    /// Largest tension [N].
    pub tension: f64,
    /// Time at the tension limit [s].
    pub time_at_limit: f64,
    /// Largest length of the thread beyond what was off the reels while the winches had tension to
    /// spare [m]: an error of the method.
    pub excess: f64,
    /// The same at the tension limit [m]: knots that pull harder drag the thread out.
    pub limit_overshoot: f64,
}

impl Winch {
    /// Winches for a thread of `full_length` [m], all of it off the reels, at rest.
    pub fn new(drive: Drive, full_length: f64) -> Winch {
        Winch {
            drive,
            length: full_length,
            stop: drive.stop_share * full_length,
            speed: if drive.reel_mass > 0.0 { 0.0 } else { drive.speed },
            resistance: 0.0,
            beyond: 0.0,
            commanded: None,
            pull: 0.0,
            tension: 0.0,
            excess: 0.0,
            tally: WinchRecord::default(),
        }
    }

    /// Tension in the last (sub-)step [N].
    pub fn pull(&self) -> f64 {
        self.pull
    }

    /// Energy that a thread drawn out beyond its reels can give back, at most [J].
    pub fn drawn_out(&self) -> f64 {
        self.drive.tension * self.beyond
    }

    /// Length off the reels [m].
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Pays out to `length` [m]: only before it starts.
    pub fn run_free(&mut self, length: f64) {
        self.length = length;
    }

    /// Reels in at another speed, at most [m/s], and with another largest tension [N].
    pub fn command_limits(&mut self, speed: f64, tension: f64) {
        (self.drive.speed, self.drive.tension) = (speed, tension);
    }

    /// What the thread is to do within a step of `step` seconds.
    pub fn command(&self, step: f64) -> LengthCommand {
        let expected = step * self.resistance;
        let wound = self.shortest(step);
        let (most, compliance) = if self.drive.reel_mass > 0.0 {
            (self.length, self.drive.winches / self.drive.reel_mass)
        } else {
            (wound, 0.0)
        };
        LengthCommand {
            length: wound - expected,
            length_most: most - expected,
            compliance,
            impulse_most: self.drive.tension * step,
        }
    }

    /// Length off the reels at the end of a step if nothing held them back [m].
    fn shortest(&self, step: f64) -> f64 {
        let Drive { winches, speed, tension, reel_mass, .. } = self.drive;
        let speed =
            if reel_mass > 0.0 { (self.speed + tension * step / reel_mass).min(speed) } else { speed };
        (self.length - winches * speed * step).max(self.stop.min(self.length))
    }

    /// Hears what the thread did: its impulse, and its length ahead as far as that decides it.
    pub fn pulled(&mut self, step: f64, impulse: f64, length_ahead: f64) {
        self.pull = impulse / step;
        self.tension = self.tension.max(self.pull);
        self.commanded = Some(Commanded { shortest: self.shortest(step), step, impulse, length_ahead });
    }

    /// Hears how long the thread is now that the step is done, and winds it in.
    pub fn wind(&mut self, length_now: impl FnOnce() -> f64) {
        let Some(Commanded { shortest, step, impulse, length_ahead }) = self.commanded.take() else { return };
        let length_now = length_now();
        let Drive { winches, reel_mass, tension: limit, .. } = self.drive;
        let beyond = length_now - self.length;
        self.beyond = beyond.max(0.0);
        let wound = self.length - length_now.max(shortest).min(self.length);
        let tension = impulse / step;
        self.length -= wound;
        self.tally.work += tension * wound;
        if reel_mass > 0.0 {
            let energy = self.stored();
            self.speed = wound / (winches * step);
            self.tally.work += self.stored() - energy;
        }

        self.tally.tension = self.tally.tension.max(tension);
        if tension >= limit * (1.0 - ROUNDING) {
            self.tally.time_at_limit += step;
            self.tally.limit_overshoot = self.tally.limit_overshoot.max(beyond);
        } else {
            self.tally.excess = self.tally.excess.max(beyond);
            self.excess = self.excess.max(beyond);
        }
        let met = (length_now - length_ahead) / step;
        self.resistance =
            if impulse > 0.0 { (self.resistance + FOLLOW * (met - self.resistance)).max(0.0) } else { 0.0 };
    }

    /// Kinetic energy of the reels [J].
    pub fn stored(&self) -> f64 {
        if self.drive.reel_mass == 0.0 {
            return 0.0; // the speed may be without limit
        }
        0.5 * self.drive.winches * self.drive.reel_mass * self.speed * self.speed
    }
}
