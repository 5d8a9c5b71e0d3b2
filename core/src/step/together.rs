//! Contacts of all kinds in a sub-step, solved together: of knots and cables with the target, of strands with each other.
//!
//! One kind after the other, what cables kick a knot by into the target would in part go to the other end of a cable, and
//! what the target keeps out goes into a strand that was answered before. Created of the energy at hand, in the middle and at most:
//!
//! | members | one after the other | together |
//! |---|---|---|
//! | a net of 0.5 mm around a panel, whole cables and knots, 16 | 6e-3, 4.5e-2 | 6e-5, 1.2e-4 |
//! | `cube-fixed`, strands and knots, 32 | 2.8e-4, 1.1e-2 | 1.9e-5, 7e-5 |
//!
//! In turn with the engine they are solved together with what it is about to do ([`crate::contact::lookahead`]), knots too where impulses of ours
//! answer them: after the engine, which was how these did once, cables had been stretched by what they now let go of, and a free
//! Cubesat's net took 118 000 steps of 0.025 ms for 3 s. Before it, it takes 6000, in a sixth of the time, as with the engine's own contacts.

use crate::contact::gauss_seidel::{self, IterationLimits, Rubbing};
use crate::contact::lookahead::Lookahead;
use crate::contact::row::{ContactRow, MarkedKnots, RowSource};
use crate::contact::{ContactManager, InverseInertia};
use crate::friction::Law;
use crate::interaction::Interactions;
use crate::options::BuildContext;
use crate::solver::ContactModel;
use crate::state::{Body, State, TARGET, Tie};

/// Contacts that share one problem: all rows of a sub-step.
#[derive(Default)]
pub struct SharedContacts {
    /// With the target first; kept for their memory.
    rows: Vec<ContactRow>,
    /// How many there are behind those of each source.
    ends: Vec<usize>,
    /// How far to go where nothing acts after them.
    limits: IterationLimits,
    /// Of those with the target.
    friction: Option<Law>,
    /// The engine's rows, where it moves net and target after these have acted.
    lookahead: Option<Lookahead>,
    /// Of the target in the body frame; none without one.
    target: Option<InverseInertia>,
}

impl SharedContacts {
    /// Of a scene; in turn with the engine, where it moves the cables after contacts of effects have acted.
    pub fn new(context: &BuildContext<'_>) -> SharedContacts {
        let BuildContext { net, target, options, .. } = *context;
        let in_turn = !context.acts_in_substeps;
        let cables_alone = options.strands_touch.is_none() && context.solver.contact == ContactModel::Rapier;
        let ahead = if cables_alone { IterationLimits::AHEAD } else { IterationLimits::AHEAD_OF_STRANDS };
        SharedContacts {
            limits: match (options.strands_touch, options.has_constraints) {
                (None, _) => IterationLimits::WHOLE,
                (Some(_), false) => IterationLimits::OF_STRANDS,
                (Some(_), true) => IterationLimits::OF_DRAWN_STRANDS,
            },
            friction: options.friction,
            lookahead: in_turn.then(|| Lookahead::new(net, ahead)),
            target: target.map(|target| InverseInertia::of(&target.model())),
            ..SharedContacts::default()
        }
    }

    /// Before a step from `state`: sees what the engine holds.
    pub fn update(&mut self, state: &State) {
        if let (Some(lookahead), Some(body)) = (&mut self.lookahead, state.target()) {
            lookahead.update(state, body);
        }
    }

    /// Sees which knots the engine holds together.
    pub fn tie(&mut self, ties: &[Tie]) {
        if let Some(lookahead) = &mut self.lookahead {
            lookahead.tie(ties);
        }
    }

    /// Whether the sources gave too little for a part of `step` seconds, in which a method that moved net and target after they had acted led
    /// from the first to the second of `states`: see [`RowSource::lacks`].
    pub fn lack(
        &self,
        knots: &mut ContactManager,
        with: &mut Interactions,
        states: [&State; 2],
        step: f64,
    ) -> bool {
        let mut lack = false;
        for touches_target in [true, false] {
            each_source(knots, with, touches_target, &mut |source| lack |= source.lacks(states, step));
        }
        lack
    }

    /// Solves what the laws of `with` find in a sub-step of `step` seconds, and what `knots` find where impulses answer it; `again` for the same
    /// one, where they lacked something.
    pub fn solve(
        &mut self,
        knots: &mut ContactManager,
        with: &mut Interactions,
        net: &mut MarkedKnots<'_>,
        bodies: &mut [Body],
        step: f64,
        again: bool,
    ) {
        let mut nobody = Body::at_rest();
        let body = match self.target {
            Some(_) => &mut bodies[TARGET],
            None => &mut nobody,
        };
        let Self { rows, ends, .. } = self;
        rows.clear();
        ends.clear();
        let mut n_with_target = 0;
        for touches_target in [true, false] {
            each_source(knots, with, touches_target, &mut |source| {
                source.add_rows(net, body, step, again, rows);
                ends.push(rows.len());
            });
            if touches_target {
                n_with_target = rows.len();
            }
        }
        if rows.is_empty() {
            return;
        }
        if n_with_target < rows.len() {
            // In a wad the impulses of the sub-step before are no guess.
            rows.iter_mut().for_each(|row| row.impulse = 0.0);
        }
        let (target, before) = (self.target.unwrap_or_default().at(body), *body);
        let rubbing = self.friction.as_ref().map(|law| Rubbing { law, n_rows: n_with_target });
        match &mut self.lookahead {
            None => {
                gauss_seidel::solve(rows, rubbing, net, body, &target, self.limits);
            }
            Some(lookahead) => lookahead.solve(rows, rubbing, net, body, &target, step),
        }
        let (mut start, mut ends) = (0, ends.iter());
        for touches_target in [true, false] {
            each_source(knots, with, touches_target, &mut |source| {
                let end = ends.next().copied().unwrap_or(start);
                source.take_rows(&rows[start..end], net, [&before, body], step);
                start = end;
            });
        }
    }
}

/// The sources of rows with the target, those of laws first, or of rows within the net.
fn each_source(
    knots: &mut ContactManager,
    with: &mut Interactions,
    touches_target: bool,
    act: &mut dyn FnMut(&mut dyn RowSource),
) {
    with.each_shared_source(|source| {
        if source.touches_target() == touches_target {
            act(source);
        }
    });
    if let Some(knots) = knots.row_source().filter(|_| touches_target) {
        act(knots);
    }
}
