//! The lock: perimeter knots that come close may latch onto each other, and stay.
//!
//! A latch between two knots is a thread of one segment that no winch holds: they may not part
//! beyond the distance at which they latched. Every knot latches onto one other at most. Neighbours along the
//! perimeter may latch too: their cable lets them come close as any others.
//!
//! Where a method moves cables by itself after threads and latches, it holds latches together with them (see [`Tie`]): what cables part
//! within a step a latch of ours would have to take back in the next, which is work that nobody puts in. They are pulled here all the same, for threads
//! to find what is held: one that takes a latched knot for free finds it twice as heavy after every step, and six `tube`s of 20 N made 1.1e-3 of
//! the energy at hand in the middle and 1.4e-2 at most, 1.8e-4 and 4.6e-4 so.
//!
//! What contacts, which act after it, part a latch by, it does not take back either: it holds its knots where they are, and where they come nearer it follows.
//! One whose cable ran through a body's edge fought for them with contact of whole cables, and threw a knot of the Cubesat's at 7 m/s: 9e-2 of the energy in
//! one of four `cinch`es, 2e-6 so. Of 118 latches in six runs of 5 s four had opened by more than 0.5 %, one to 1.8 times its distance.
//!
//! Latches are a choice of ours: the source has none.

use super::thread::{LengthCommand, Thread, ThreadSweeps};
use crate::state::{Knots, Tie};

/// Steps between two looks for knots to latch: between them a knot moves a few millimetres.
const EVERY: u64 = 8;

/// The latches of a net.
#[derive(Clone, Debug)]
pub struct Lock {
    knots: Vec<usize>,
    distance: f64,
    /// Knots that are free to latch.
    free: Vec<usize>,
    latches: Vec<(Thread, Tie)>,
    /// How many of the first of them somebody else holds, too.
    n_handed_over: usize,
    n_looks: u64,
}

impl Lock {
    /// Lets `knots` latch within `distance` [m].
    pub fn new(knots: &[usize], distance: f64) -> Lock {
        Lock {
            knots: knots.to_vec(),
            distance,
            free: knots.to_vec(),
            latches: Vec::new(),
            n_handed_over: 0,
            n_looks: 0,
        }
    }

    /// The knots that may latch.
    pub fn knots(&self) -> &[usize] {
        &self.knots
    }

    /// Number of latches.
    pub fn len(&self) -> usize {
        self.latches.len()
    }

    /// Whether nothing has latched.
    pub fn is_empty(&self) -> bool {
        self.latches.is_empty()
    }

    /// Those that it has held by itself, for somebody else to hold, too, from now on.
    pub fn hand_over(&mut self) -> Vec<Tie> {
        let held = self.latches.iter().skip(std::mem::replace(&mut self.n_handed_over, self.latches.len()));
        held.map(|(_, tie)| *tie).collect()
    }

    /// Latches what came close, and begins a step.
    pub fn begin(&mut self, knots: &Knots, inverse_mass: &[f64]) {
        if self.n_looks.is_multiple_of(EVERY) {
            self.latch_close_pairs(knots);
        }
        self.n_looks += 1;
        for (latch, _) in &mut self.latches {
            latch.begin(knots, inverse_mass);
        }
    }

    /// Pulls every latch; returns whether it changed any velocity.
    pub fn pull(&mut self, knots: &mut Knots, step: f64) -> bool {
        let mut changed = false;
        for (latch, tie) in &mut self.latches {
            let command = LengthCommand::hold(tie.holds_at(knots));
            changed |= latch.pull(knots, step, &command, &ThreadSweeps::WHOLE);
        }
        changed
    }

    fn latch_close_pairs(&mut self, knots: &Knots) {
        let mut i = 0;
        while i < self.free.len() {
            let a = self.free[i];
            let apart = |b: usize| (knots.position[b] - knots.position[a]).norm();
            let rest = self.free[i + 1..].iter().enumerate();
            let nearest = rest.map(|(k, &b)| (i + 1 + k, apart(b))).min_by(|x, y| x.1.total_cmp(&y.1));
            match nearest {
                Some((k, distance)) if distance <= self.distance => {
                    let tie = Tie { knots: [a, self.free[k]], distance };
                    self.latches.push((Thread::between(a, self.free[k]), tie));
                    self.free.remove(k);
                    self.free.remove(i);
                }
                _ => i += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector3, vector};

    const STEP: f64 = 1e-3;

    fn run(lock: &mut Lock, knots: &mut Knots, inverse_mass: &[f64], steps: usize) {
        for _ in 0..steps {
            lock.begin(knots, inverse_mass);
            lock.pull(knots, STEP);
            for (x, v) in knots.position.iter_mut().zip(&knots.velocity) {
                *x += STEP * v;
            }
        }
    }

    /// What parted a latch's knots it leaves, and holds them there; where they come nearer, it holds them nearer.
    #[test]
    fn a_latch_takes_nothing_back() {
        let mut knots = Knots {
            position: vec![Vector3::zeros(), vector![0.01, 0.0, 0.0]],
            velocity: vec![Vector3::zeros(); 2],
        };
        let mut lock = Lock::new(&[0, 1], 0.02);
        let apart = |knots: &Knots| (knots.position[1] - knots.position[0]).norm();
        run(&mut lock, &mut knots, &[1.0; 2], 1);
        knots.position[1].x = 0.015;
        run(&mut lock, &mut knots, &[1.0; 2], 50);
        assert!((apart(&knots) - 0.015).abs() < 1e-12, "{}", apart(&knots));
        for (speed, end) in [(1.0, 0.015), (-1.0, 0.013), (1.0, 0.013)] {
            knots.velocity = vec![Vector3::zeros(), vector![speed, 0.0, 0.0]];
            run(&mut lock, &mut knots, &[1.0; 2], 2);
            assert!((apart(&knots) - end).abs() < 1e-12, "{speed} m/s: {}", apart(&knots));
        }
        knots.velocity = vec![Vector3::zeros(), vector![-1.0, 0.0, 0.0]];
        run(&mut lock, &mut knots, &[1.0; 2], 8);
        knots.velocity = vec![Vector3::zeros(), vector![1.0, 0.0, 0.0]];
        run(&mut lock, &mut knots, &[1.0; 2], 50);
        assert!((apart(&knots) - 0.01).abs() < 1e-12, "no nearer than it latched: {}", apart(&knots));
    }

    /// Two knots pass within the lock distance: from then on they stay together, and what is left
    /// of their motion is that of their centre of mass.
    #[test]
    fn knots_that_come_close_latch_and_stay() {
        let mut knots = Knots {
            position: vec![vector![-0.1, 0.0, 0.0], vector![0.1, 0.005, 0.0], vector![0.0, 1.0, 0.0]],
            velocity: vec![vector![1.0, 0.0, 0.0], vector![-1.0, 0.0, 0.0], Vector3::zeros()],
        };
        let mut lock = Lock::new(&[0, 1, 2], 0.02);
        run(&mut lock, &mut knots, &[1.0, 2.0, 1.0], 500);
        assert_eq!(lock.len(), 1);
        let apart = (knots.position[0] - knots.position[1]).norm();
        assert!(apart < 0.02 * (1.0 + 1e-6), "{apart}");
        let centre = (knots.velocity[0] + 0.5 * knots.velocity[1]) / 1.5;
        assert!((centre - vector![1.0 / 3.0, 0.0, 0.0]).norm() < 1e-12);
    }

    #[test]
    fn a_knot_latches_onto_its_nearest_and_only_once() {
        let mut knots = Knots {
            position: vec![Vector3::zeros(), vector![0.01, 0.0, 0.0], vector![0.0, 0.005, 0.0]],
            velocity: vec![Vector3::zeros(); 3],
        };
        let mut lock = Lock::new(&[0, 1, 2], 0.02);
        run(&mut lock, &mut knots, &[1.0; 3], 20);
        assert_eq!(lock.len(), 1);
        assert_eq!(lock.free, [1]);
    }
}
