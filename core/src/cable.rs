//! The tension law: a cable that pulls and cannot push (Kelvin–Voigt, Eq. 3.1 to 3.4).
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | k = E A / l₀ | axial stiffness (Eq. 3.1) | N/m |
//! | c = 2 ξ √(m k) | damping (Eq. 3.4) | N s/m |
//! | l₀, r, ṙ | unstretched length, length, its rate | m, m/s |
//! | mₑ = mₐ m_b / (mₐ + m_b) | reduced mass of the two end knots | kg |
//! | ω = √(k / mₑ), ζ = c / (2 mₑ ω) | natural frequency and damping ratio of the pair | rad/s, - |
//!
//! Assumptions: the cable has no mass of its own (its mass is lumped on the knots, Eq. 3.2) and no
//! bending stiffness. Departure from the source: Eq. 3.4 gives each end of a cable its own c;
//! we use the lesser knot mass for both, so that the two ends feel opposite forces and momentum is
//! kept. A line that middle knots cut into n pieces has n times the damping of the whole line in each,
//! as dashpots in a row have: Eq. 3.4 with the pieces' own masses and stiffness would take the less of a
//! snap the more finely a line is cut.

use std::hint::select_unpredictable;

/// A cable between two knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cable {
    /// Index of the first end knot.
    pub a: usize,
    /// Index of the second end knot.
    pub b: usize,
    /// Unstretched length l₀ [m].
    pub rest_length: f64,
    /// Axial stiffness k [N/m].
    pub stiffness: f64,
    /// Damping c [N s/m].
    pub damping: f64,
    /// Mass ρ A l₀ of its own [kg]: lumped on its end knots (Eq. 3.2), or spread along it where the model does.
    pub mass: f64,
    /// Reduced mass mₑ of the two end knots [kg].
    pub reduced_mass: f64,
    /// Tension at which it breaks, strength times cross-section [N].
    pub breaking_tension: f64,
}

/// Axial stiffness of a cable, Eq. 3.1 [N/m].
pub fn stiffness(young_modulus: f64, cross_section: f64, rest_length: f64) -> f64 {
    young_modulus * cross_section / rest_length
}

/// Damping of a cable, Eq. 3.4 [N s/m].
pub fn damping(damping_ratio: f64, knot_mass: f64, stiffness: f64) -> f64 {
    2.0 * damping_ratio * (knot_mass * stiffness).sqrt()
}

/// Reduced mass of two ends, mₐ m_b / (mₐ + m_b) [kg].
pub fn reduced_mass(a: f64, b: f64) -> f64 {
    a * b / (a + b)
}

/// What spring and dashpot of a taut cable give together, k (r − l₀) + c ṙ [N]; below zero it would push. The rate is that
/// of `change` [m] in a time of one over `per_time` [1/s]. Every path has it from here, cable by cable or in arrays.
#[inline(always)]
pub fn taut_force(stiffness: f64, damping: f64, stretch: f64, change: f64, per_time: f64) -> f64 {
    stiffness * stretch + damping * change * per_time
}

/// Energy that a cable takes up when its stretch goes from `from` to `to`, neither below zero [J].
#[inline(always)]
pub fn stored_between(stiffness: f64, from: f64, to: f64) -> f64 {
    0.5 * stiffness * (to - from) * (to + from)
}

/// Work against the law while a cable goes from one stretch to another, neither below zero, and its length changes by `change` [m] in a
/// time of one over `per_time` [1/s], in joules: what it stores and what its dashpot takes, but no less than nothing of a cable that grows
/// and no more of one that shrinks, for it does not push (Eq. 3.3).
#[inline(always)]
pub fn work_by_law(stiffness: f64, damping: f64, [from, to]: [f64; 2], change: f64, per_time: f64) -> f64 {
    let asked = stored_between(stiffness, from, to) + damping * (to - from) * change * per_time;
    select_unpredictable(to > from, asked.max(0.0), asked.min(0.0))
}

impl Cable {
    /// What `pieces` are together, one after another: springs and dashpots in a row. `mass`: of every knot [kg].
    pub fn in_a_row(pieces: &[Cable], mass: &[f64]) -> Cable {
        let (a, b) = (pieces[0].a, pieces[pieces.len() - 1].b);
        let sum = |of: fn(&Cable) -> f64| pieces.iter().map(of).sum::<f64>();
        Cable {
            a,
            b,
            rest_length: sum(|piece| piece.rest_length),
            stiffness: 1.0 / sum(|piece| 1.0 / piece.stiffness),
            damping: 1.0 / sum(|piece| 1.0 / piece.damping),
            mass: sum(|piece| piece.mass),
            reduced_mass: reduced_mass(mass[a], mass[b]),
            breaking_tension: pieces.iter().map(|piece| piece.breaking_tension).fold(f64::INFINITY, f64::min),
        }
    }

    /// Tension (Eq. 3.3) [N], positive when it pulls the ends together.
    ///
    /// T = max(0, k (r − l₀) + c ṙ) while r > l₀, else 0.
    pub fn tension(&self, length: f64, stretch_rate: f64) -> f64 {
        if length <= self.rest_length {
            return 0.0; // slack
        }
        self.taut_force(length, stretch_rate).max(0.0)
    }

    /// What a taut cable's spring and dashpot give together, k (r − l₀) + c ṙ [N]; below zero it would push.
    pub fn taut_force(&self, length: f64, stretch_rate: f64) -> f64 {
        taut_force(self.stiffness, self.damping, length - self.rest_length, stretch_rate, 1.0)
    }

    /// Mean tension [N] over `step` seconds in which stretch, below zero where it is slack, goes from `from` to `to` [m]: what it stored over
    /// the way, and its dashpot for the share of the step in which it is taut. It does not push.
    pub fn mean_tension(&self, from: f64, to: f64, step: f64) -> f64 {
        let (taut_from, taut_to) = (from.max(0.0), to.max(0.0));
        if taut_from == taut_to {
            return self.stiffness * taut_from;
        }
        let by_spring = stored_between(self.stiffness, taut_from, taut_to) / (to - from);
        (by_spring + self.damping * (taut_to - taut_from) / step).max(0.0)
    }

    /// Elastic energy [J]: U = k (r − l₀)² / 2 while r > l₀, else 0.
    pub fn energy(&self, length: f64) -> f64 {
        stored_between(self.stiffness, 0.0, (length - self.rest_length).max(0.0))
    }

    /// What the dashpot takes in `step` seconds [J] in which stretch [m] and its rate [m/s] go from `start` to `end`, the rate in
    /// proportion to time: ∫ c ṙ² dt over the share of the step in which the cable is taut. In a step that is long before its own
    /// period, no more than what its ends have at the start and the rate of the end asks for. Of one that shrinks, no more than
    /// its spring gives: it does not push (Eq. 3.3).
    pub fn dissipated(&self, start: [f64; 2], end: [f64; 2], step: f64) -> f64 {
        let ([from, was], [to, is]) = (start, end);
        let [taut_from, taut_to] = [from, to].map(|stretch| stretch.max(0.0));
        let share = match from > 0.0 && to > 0.0 {
            true => 1.0,
            false if from <= 0.0 && to <= 0.0 => 0.0,
            false => (taut_to - taut_from) / (to - from),
        };
        let dashpot = share * self.damping * step;
        let at_hand = 0.5 * self.reduced_mass * was * was + stored_between(self.stiffness, 0.0, taut_from);
        let taken = (dashpot * (was * was + was * is + is * is) / 3.0).min(at_hand + dashpot * is * is);
        match was < 0.0 && is < 0.0 {
            true => taken.min(stored_between(self.stiffness, taut_to, taut_from).max(0.0)),
            false => taken,
        }
    }

    /// Natural frequency ω of the two end knots on this cable [rad/s].
    pub fn natural_frequency(&self) -> f64 {
        self.half_cycle(self.reduced_mass).natural_frequency
    }

    /// Damping ratio ζ of the two end knots on this cable [-].
    pub fn damping_ratio(&self) -> f64 {
        self.half_cycle(self.reduced_mass).damping_ratio
    }

    /// What happens when this cable goes taut and stops a `mass` [kg]: of its two end knots, where it is alone, the reduced mass.
    pub fn half_cycle(&self, mass: f64) -> HalfCycle {
        let natural_frequency = (self.stiffness / mass).sqrt();
        HalfCycle { natural_frequency, damping_ratio: self.damping / (2.0 * mass * natural_frequency) }
    }
}

/// What happens between going taut and going slack again: half a damped cycle.
///
/// From going taut with a rate ṙ₀ on the stretch is (ṙ₀ / ω_d) e^(−ζωt) sin ω_d t, with ω_d = ω √(1 − ζ²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfCycle {
    /// Natural frequency ω [rad/s].
    pub natural_frequency: f64,
    /// Damping ratio ζ [-].
    pub damping_ratio: f64,
}

impl HalfCycle {
    /// How long it takes [s]; infinite from ζ = 1 on.
    pub fn time(&self) -> f64 {
        let zeta = self.damping_ratio;
        if zeta >= 1.0 {
            return f64::INFINITY;
        }
        std::f64::consts::PI / (self.natural_frequency * (1.0 - zeta * zeta).sqrt())
    }

    /// Rate at its end over that at its start, exp(−π ζ / √(1 − ζ²)) [-]. From ζ = 1 on nothing comes back.
    pub fn restitution(&self) -> f64 {
        let zeta = self.damping_ratio;
        if zeta >= 1.0 {
            return 0.0;
        }
        (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp()
    }

    /// Largest stretch when it begins at `rate` [m/s], in metres: (ṙ₀ / ω) exp(−ζ / √(1 − ζ²) · ω_d t) at
    /// ω_d t = arctan(√(1 − ζ²) / ζ).
    pub fn largest_stretch(&self, rate: f64) -> f64 {
        let zeta = self.damping_ratio.min(1.0 - 1e-9);
        let root = (1.0 - zeta * zeta).sqrt();
        rate / self.natural_frequency * (-zeta / root * root.atan2(zeta)).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cable() -> Cable {
        Cable {
            a: 0,
            b: 1,
            rest_length: 2.0,
            stiffness: 100.0,
            damping: 0.5,
            mass: 0.0,
            reduced_mass: 0.25,
            breaking_tension: 1.0,
        }
    }

    #[test]
    fn slack_cable_neither_pulls_nor_pushes() {
        assert_eq!(cable().tension(2.0, 5.0), 0.0);
        assert_eq!(cable().tension(1.0, -5.0), 0.0);
        assert_eq!(cable().energy(1.0), 0.0);
        assert_eq!(cable().tension(2.01, -5.0), 0.0, "a dashpot does not push");
    }

    #[test]
    fn pieces_in_a_row_are_the_cable_that_was_cut() {
        let pieces = [0, 1].map(|a| Cable { a, b: a + 1, ..cable() });
        let whole = Cable::in_a_row(&pieces, &[1.0, 1e-3, 1.0]);
        assert_eq!((whole.a, whole.b, whole.rest_length), (0, 2, 4.0));
        assert_eq!((whole.stiffness, whole.damping, whole.reduced_mass), (50.0, 0.25, 0.5));
        let undamped = pieces.map(|piece| Cable { damping: 0.0, ..piece });
        assert_eq!(Cable::in_a_row(&undamped, &[1.0, 1e-3, 1.0]).damping, 0.0);
    }

    /// Wherever on the way it goes taut or slack: spring and dashpot as integrals of Eq. 3.3 over time, summed up in small pieces.
    #[test]
    fn a_mean_tension_does_the_work_of_the_law() {
        let (cable, step, n) = (cable(), 1e-2, 100_000);
        for (from, to) in [(0.1, 0.3), (-0.2, 0.1), (0.3, -0.1), (-0.3, -0.1), (0.2, 0.2)] {
            let rate = (to - from) / step;
            let tension = |share: f64| {
                let stretch = from + share * (to - from);
                if stretch > 0.0 { cable.taut_force(cable.rest_length + stretch, rate) } else { 0.0 }
            };
            let mean =
                (0..n).map(|i| tension((f64::from(i) + 0.5) / f64::from(n))).sum::<f64>() / f64::from(n);
            let found = cable.mean_tension(from, to, step);
            assert!((found - mean.max(0.0)).abs() < 1e-3, "{from} {to}: {found} {mean}");
        }
    }

    #[test]
    fn taut_cable_pulls_by_stretch_and_rate() {
        assert!((cable().tension(2.1, 2.0) - (100.0 * 0.1 + 0.5 * 2.0)).abs() < 1e-12);
        // The force is the slope of the energy.
        let slope = (cable().energy(2.1 + 1e-6) - cable().energy(2.1 - 1e-6)) / 2e-6;
        assert!((slope - cable().tension(2.1, 0.0)).abs() < 1e-6);
    }

    /// Half a cycle of Eq. 3.3 in steps that resolve it: what the dashpots took is what is missing, from slack to slack.
    #[test]
    fn dissipation_is_what_a_half_cycle_loses() {
        let cable = Cable { damping: 2.0, ..cable() };
        let (mut stretch, mut rate, mut taken) = (-1e-3, 1.0, 0.0);
        let dt = 1e-4;
        while stretch > 0.0 || rate > 0.0 {
            let start = [stretch, rate];
            rate -= dt * cable.tension(cable.rest_length + stretch, rate) / cable.reduced_mass;
            stretch += dt * rate;
            taken += cable.dissipated(start, [stretch, rate], dt);
        }
        let lost = 0.5 * cable.reduced_mass * (1.0 - rate * rate);
        assert!((taken - lost).abs() < 1e-2 * lost, "{taken} of {lost}");
        let half = 1e-3 * cable.damping;
        let motion = 0.5 * cable.reduced_mass;
        let spring = cable.energy(cable.rest_length + 0.1);
        for (what, start, end, step, expected) in [
            ("slack", [-2.0, 1.0], [-1.0, 1.0], 1.0, 0.0),
            ("taut for half of the step", [-1e-3, 1.0], [1e-3, 1.0], 2e-3, half),
            ("all of its motion", [1e-9, 1.0], [1e-9, 0.0], 10.0, motion),
            ("no more than the spring gives", [0.1, -9.0], [0.0, -9.0], 1.0, spring),
        ] {
            let taken = cable.dissipated(start, end, step);
            assert!((taken - expected).abs() < 1e-9, "{what}: {taken} for {expected}");
        }
    }

    /// The closed forms of a snap against a fine integration of Eq. 3.3 in its linear range.
    #[test]
    fn snap_matches_the_integrated_half_cycle() {
        let cable = cable();
        let snap = cable.half_cycle(cable.reduced_mass);
        let (mut stretch, mut rate, mut time, mut largest) = (0.0_f64, 1.0_f64, 0.0, 0.0_f64);
        let dt = 1e-6;
        while stretch >= 0.0 {
            rate -= dt * (cable.stiffness * stretch + cable.damping * rate) / cable.reduced_mass;
            stretch += dt * rate;
            time += dt;
            largest = largest.max(stretch);
        }
        assert!((-rate - snap.restitution()).abs() < 1e-5, "{rate}");
        assert!((time - snap.time()).abs() < 1e-5, "{time}");
        assert!((largest - snap.largest_stretch(1.0)).abs() < 1e-6, "{largest}");
    }
}
