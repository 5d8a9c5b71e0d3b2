//! Hits: how hard a contact is, whatever the step.
//!
//! An impulse of a single step says little: a hit falls into one step or into two, and impulse over step is a force
//! that grows as the step is cut (300, 600, 3000 N at 1, 0.5, 0.1 ms for one hit). So impulses of one contact, of a knot
//! or a cable with a part, are joined over [`HIT`]; a force is that over the same time, but where contact is a force,
//! which is itself.

use std::collections::{BTreeMap, VecDeque};

use crate::state::Contact;

/// Time over which the impulses of one contact are joined [s]; a step where that is longer.
pub const HIT: f64 = 1e-3;

/// Impulses of every contact within the last [`HIT`].
#[derive(Clone, Default)]
pub struct Hits {
    recent: BTreeMap<Touching, VecDeque<(f64, f64)>>,
}

/// Knot or cable, and body and its part.
type Touching = (Option<usize>, usize, usize, usize);

/// The hardest of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hardest {
    /// Impulse of one contact within [`HIT`] [N s].
    pub impulse: f64,
    /// Force [N].
    pub force: f64,
}

impl Hits {
    /// Takes in the contacts of a step of `step` seconds that ended at `time` [s].
    pub fn record(&mut self, contacts: &[Contact], time: f64, step: f64) -> Hardest {
        let mut hardest = Hardest::default();
        // A hair less than the time: steps of a whole share of it end at its edge.
        let since = time - HIT + 1e-6 * step;
        if !self.recent.is_empty() {
            self.recent.retain(|_, hit| hit.back().is_some_and(|last| last.0 > since));
        }
        for contact in contacts.iter().filter(|contact| contact.impulse > 0.0) {
            let touching = (contact.along.map(|along| along.cable), contact.knot, contact.body, contact.part);
            let hit = self.recent.entry(touching).or_default();
            hit.push_back((time, contact.impulse));
            while hit.front().is_some_and(|first| first.0 <= since && hit.len() > 1) {
                hit.pop_front();
            }
            let impulse = hit.iter().map(|(_, impulse)| impulse).sum::<f64>();
            let force = if contact.force > 0.0 { contact.force } else { impulse / HIT.max(step) };
            hardest.impulse = hardest.impulse.max(impulse);
            hardest.force = hardest.force.max(force);
        }
        hardest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact(impulse: f64) -> Contact {
        Contact { impulse, ..Contact::default() }
    }

    /// One hit of 3 mN s, split over two steps or not, is the same at any step.
    #[test]
    fn a_hit_is_as_hard_at_any_step() {
        for (step, impulses) in
            [(1e-3, vec![3e-3]), (5e-4, vec![1e-3, 2e-3]), (1e-4, vec![2e-3, 1e-3]), (1e-2, vec![3e-3])]
        {
            let (mut hits, mut hardest) = (Hits::default(), Hardest::default());
            for (index, impulse) in impulses.into_iter().enumerate() {
                hardest = hits.record(&[contact(impulse)], step * (index + 1) as f64, step);
            }
            assert!((hardest.impulse - 3e-3).abs() < 1e-15, "{step}: {hardest:?}");
            assert!((hardest.force - 3e-3 / step.max(HIT)).abs() < 1e-12, "{step}: {hardest:?}");
        }
    }

    #[test]
    fn hits_apart_are_two_and_a_force_is_itself() {
        let mut hits = Hits::default();
        hits.record(&[contact(1e-3)], 1e-4, 1e-4);
        let later = hits.record(&[contact(2e-3)], 2e-3, 1e-4);
        assert_eq!(later.impulse, 2e-3);
        let pressed = hits.record(&[Contact { force: 50.0, ..contact(1e-3) }], 4e-3, 1e-4);
        assert_eq!(pressed.force, 50.0);
        // A thread that presses on for long has the force that it has.
        let mut hits = Hits::default();
        let mut last = Hardest::default();
        for step in 1..100 {
            last = hits.record(&[contact(1e-4)], 1e-4 * f64::from(step), 1e-4);
        }
        assert!((last.force - 1.0).abs() < 1e-9, "{last:?}");
    }
}
