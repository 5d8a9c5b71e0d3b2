//! What effects and steppers are built from.

use crate::contact::ContactSettings;
use crate::contact::strands::BOUNCY;
use crate::friction::Law;
use crate::limits::Limits;
use crate::net::Net;
use crate::solver::{ContactModel, Solver};
use crate::target::Target;

/// Steps and sub-steps of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeStep {
    /// A step of the simulation [s].
    pub step: f64,
    /// Sub-steps within it: of the engine with `joints`, of the integration with `explicit` cables.
    pub substeps: u32,
}

/// What effects ask of the method and of each other, before anything is built.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildOptions {
    /// Friction of contacts, where an effect asks for it.
    pub friction: Option<Law>,
    /// Name of the body whose port tethers leave, where an effect brings one: else they leave the origin, which is held.
    pub port_of: Option<&'static str>,
    /// Whether something holds knots within a step: threads, which bring them close together.
    pub has_constraints: bool,
    /// Whether one of them is drawn along the net, and not only between knots that it shortens the way of.
    pub is_drawn_along: bool,
    /// Largest force of theirs on a knot [N].
    pub pull: f64,
    /// Largest acceleration of a field that the target is held against [m/s^2].
    pub gravity: f64,
    /// Whether whole cables touch the target, and not its knots alone.
    pub cables_touch: bool,
    /// Restitution of strands that touch each other [-], where they do.
    pub strands_touch: Option<f64>,
    /// Whether a field kicks all that moves at both ends of a step.
    pub has_fields: bool,
    /// Whether forces that are held over a step follow the speed of knots.
    pub drags: bool,
}

impl BuildOptions {
    /// Whether more of the net touches than its knots.
    pub fn more_touches(&self) -> bool {
        self.cables_touch || self.strands_touch.is_some()
    }
}

/// What is simulated, and how.
#[derive(Clone, Copy)]
pub struct BuildContext<'a> {
    /// The net.
    pub net: &'a Net,
    /// The target, where the scene has one.
    pub target: Option<&'a Target>,
    /// The numerical method.
    pub solver: &'a Solver,
    /// Its steps.
    pub time_step: TimeStep,
    /// How much a run may ask for.
    pub limits: Limits,
    /// What all effects ask for.
    pub options: BuildOptions,
    /// Whether constraints and contacts of effects act in every sub-step, not once a step or part of one.
    pub acts_in_substeps: bool,
    /// Distance from which solvers of our own look for contacts [m].
    pub contact_margin: f64,
    /// Speed of contact that steps are chosen for [m/s].
    pub contact_speed: f64,
}

impl<'a> BuildContext<'a> {
    /// Whether contacts of whole cables share one problem with others: of knots, where impulses of ours answer these, or of strands. In turn
    /// with the engine they do alone, too: there what they lacked is found.
    pub fn cables_share_rows(&self) -> bool {
        match self.solver.contact {
            ContactModel::Impulse => true,
            ContactModel::Penalty => false,
            ContactModel::Rapier => self.options.strands_touch.is_none() || self.bounce_alike_in_turn(),
        }
    }

    /// The same of strands. Bounces of more than one kind in one problem may give energy: strands that bounce fully beside cables that do
    /// not bounce off the target made more than 1e-3 of it in 10 of 192 members, 9.4e-3 at most, for none and 3.1e-4 one after the other.
    pub fn strands_share_rows(&self) -> bool {
        match (self.acts_in_substeps, self.solver.contact) {
            (true, ContactModel::Penalty) => true,
            (true, _) => self.options.strands_touch == Some(self.solver.restitution),
            (false, ContactModel::Penalty) => false,
            (false, ContactModel::Impulse) => self.bounce_alike_in_turn(),
            (false, ContactModel::Rapier) => self.options.cables_touch && self.bounce_alike_in_turn(),
        }
    }

    /// Whether strands bounce as what touches the target does, and not well, before the engine moves what they act on.
    fn bounce_alike_in_turn(&self) -> bool {
        let restitution = self.solver.restitution;
        self.options.strands_touch == Some(restitution) && restitution <= BOUNCY
    }

    /// What contacts with the target are made of; none without a target.
    pub fn contact_settings(&self) -> Option<ContactSettings<'a>> {
        Some(ContactSettings {
            net: self.net,
            target: self.target?,
            solver: self.solver,
            friction: self.options.friction,
            margin: self.contact_margin,
            speed: self.contact_speed,
            in_turn: !self.acts_in_substeps,
            more_touches: self.options.more_touches() && self.acts_in_substeps,
            coupled: false,
        })
    }
}
