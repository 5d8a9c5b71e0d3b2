//! Contact of the net with itself (Section 6.3, item 5): cables and bullets against each other.
//!
//! The physics stands in [`crate::contact::strands`]. It is frictionless: a cable of ours cannot bear the
//! moment that friction between two of them would put on it. Internal to the net: it takes energy
//! out and moves momentum between knots. With explicit cables it is answered in every sub-step, together with the contacts of
//! knots and cables; with joints before every part of a step, and again where the engine presses strands into each other.

use nalgebra::Vector3;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};

use super::{Parameters, SummaryRow};
use crate::contact::InverseInertia;
use crate::contact::row::{MarkedKnots, RowSource};
use crate::contact::strands::{StrandContacts, bullet_radius};
use crate::interaction::{ContactLaw, Effect, EffectOutput, Interaction, Report, StepObserver};
use crate::options::{BuildContext, BuildOptions};
use crate::quantity::Positive;
use crate::solver::ContactModel;
use crate::state::{Body, EffectWork, Knots, State};

/// Parameters of self contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SelfContact {
    /// Coefficient of restitution [-].
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub restitution: f64,
    /// Radius of a bullet [m]; left out: that of a steel ball of its mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bullet_radius_m: Option<Positive>,
}

/// What it says at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SelfContactSummary {
    /// Deepest overlap of two strands that met in flight, and not in the fold [m].
    pub deepest_m: f64,
    /// Pairs of strands that went through each other; again where they had parted since.
    #[serde(default)]
    pub went_through: u64,
}

impl Parameters for SelfContact {
    const ROWS: &'static [SummaryRow] = &[
        SummaryRow::new("deepest_m", "deepest overlap of strands", "mm").scaled(1e3),
        SummaryRow::new("went_through", "pairs of strands that went through each other", ""),
    ];

    fn summary(generator: &mut SchemaGenerator) -> Option<Schema> {
        Some(generator.subschema_for::<SelfContactSummary>())
    }

    fn ask(&self, options: &mut BuildOptions) {
        options.strands_touch = Some(self.restitution);
    }

    fn build(&self, context: &BuildContext<'_>) -> Interaction {
        let net = context.net;
        let bullet_radius = self.bullet_radius_m.map_or_else(|| bullet_radius(net), |radius| radius.0);
        let (in_turn, by_force) =
            (!context.acts_in_substeps, context.solver.contact == ContactModel::Penalty);
        // A force yields to what presses on it.
        let target = context.target.filter(|_| !by_force).map(|target| InverseInertia::of(&target.model()));
        let contacts = StrandContacts::new(net, bullet_radius, self.restitution, in_turn, target);
        let (n_pairs, millimetres) = (contacts.n_pairs(), 1e3 * bullet_radius);
        let about = format!("{n_pairs} pairs of cables and bullets, which are balls of {millimetres:.1} mm");
        let inverse_mass = net.mass.iter().map(|mass| 1.0 / mass).collect();
        let strands = Strands { contacts, in_turn, inverse_mass };
        Interaction::new("self_contact", about, strands)
            .internal()
            .bouncing(self.restitution > 0.0)
            .sharing_rows(context.strands_share_rows())
    }
}

/// The net's strands under way.
struct Strands {
    contacts: StrandContacts,
    /// Whether the engine moves cables after they are answered.
    in_turn: bool,
    /// Of each knot [1/kg].
    inverse_mass: Vec<f64>,
}

impl Effect for Strands {
    fn contacts(&mut self) -> Option<&mut dyn ContactLaw> {
        Some(self)
    }

    fn observer(&mut self) -> Option<&mut dyn StepObserver> {
        Some(self)
    }

    fn output(&mut self) -> Option<&mut dyn EffectOutput> {
        Some(self)
    }
}

impl EffectOutput for Strands {
    fn columns(&self) -> Vec<String> {
        Vec::new()
    }

    fn values(&mut self, _: &State) -> Vec<f64> {
        Vec::new()
    }

    fn report(&self, _: &State) -> Report {
        let StrandContacts { deepest, n_through, .. } = self.contacts;
        let numbers = SelfContactSummary { deepest_m: deepest, went_through: n_through };
        let warning = (n_through > 0).then(|| {
            let cure = if !self.in_turn { "try a smaller solver.step_s" } else { "explicit cables (`--set solver.cables=explicit`, \
                `solver.contact=impulse`) keep most apart" };
            format!("{n_through} pairs of strands went through each other, where self_contact is to keep them apart: {cure}")
        });
        Report { warnings: warning.into_iter().collect(), ..Report::default().with_numbers(&numbers) }
    }
}

impl ContactLaw for Strands {
    fn solve(
        &mut self,
        knots: &mut Knots,
        before: &[Vector3<f64>],
        bodies: &mut [Body],
        step: f64,
        touched: &mut [bool],
    ) {
        let mut net = MarkedKnots { knots, before, inverse_mass: &self.inverse_mass, touched };
        self.contacts.solve(&mut net, bodies, step);
    }

    fn rows(&mut self) -> Option<&mut dyn RowSource> {
        Some(&mut self.contacts)
    }

    fn rollback(&mut self) {
        self.contacts.forget();
    }
}

impl StepObserver for Strands {
    fn start_of_step(&mut self, state: &State) {
        self.contacts.update(state);
    }

    fn end_of_step(&mut self, before: &State, after: &State) -> EffectWork {
        self.contacts.account(&before.knots, &after.knots)
    }
}
