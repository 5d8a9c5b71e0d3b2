//! Runs a case and measures what must hold, step by step and not only at frames.
//!
//! Where knots are is looked up here anew, against the parts themselves: a contact that a detection
//! missed is in no list of contacts.

use std::time::Instant;

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::simulation::Simulation;
use crate::state::{Body, State};
use crate::target::Target;

/// A path that comes deeper into a part than this share of its thickness has gone through it [-].
const THROUGH: f64 = 0.45;

/// The numbers that must hold: as bounds, or as measured. What is absent is not asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Numbers {
    /// Largest rise of all energy above any earlier minimum, less what came in from outside, over the energy at
    /// the start and the work put in [-]. What effects between net and target make counts as made.
    pub energy: Option<f64>,
    /// Largest change of momentum that nothing outside explains, over the largest sum of all bodies'
    /// mass times speed [-].
    pub momentum: Option<f64>,
    /// The same of angular momentum about the first centre of mass, over the target's at the start plus
    /// that sum times the size of the scene [-].
    pub angular_momentum: Option<f64>,
    /// Largest overlap of a knot's ball and a part, over the ball's radius [-]: at 1 its centre is inside.
    pub overlap: Option<f64>,
    /// Knots that went through a part.
    pub through: Option<f64>,
    /// Largest elastic strain over the static answer [-].
    pub strain: Option<f64>,
}

impl Numbers {
    /// Bounds of a case that says nothing else.
    pub const BOUNDS: Numbers = Numbers {
        energy: Some(1e-3),
        momentum: Some(1e-9),
        angular_momentum: Some(1e-4),
        overlap: Some(0.5),
        through: Some(0.0),
        // All energy in one cable: a net cannot do more. 5e-4 is the root of the energy's own bound.
        strain: Some(1.0005),
    };

    /// The bounds under `pair`: a penalty force is an overlap, so with it no more is asked than that
    /// the centre of no knot comes inside.
    pub fn under(self, pair: &str) -> Numbers {
        let overlap =
            self.overlap.map(|bound| if pair.ends_with("penalty") { bound.max(1.0) } else { bound });
        Numbers { overlap, ..self }
    }

    /// Names and values, in the order of the table.
    pub fn each(&self) -> [(&'static str, Option<f64>); 6] {
        [
            ("energy", self.energy),
            ("momentum", self.momentum),
            ("angular momentum", self.angular_momentum),
            ("overlap", self.overlap),
            ("through", self.through),
            ("strain", self.strain),
        ]
    }

    /// The larger of each number.
    pub fn worst(self, other: Numbers) -> Numbers {
        let worst = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(larger(a, b)),
            (a, b) => a.or(b),
        };
        Numbers {
            energy: worst(self.energy, other.energy),
            momentum: worst(self.momentum, other.momentum),
            angular_momentum: worst(self.angular_momentum, other.angular_momentum),
            overlap: worst(self.overlap, other.overlap),
            through: worst(self.through, other.through),
            strain: worst(self.strain, other.strain),
        }
    }
}

/// What a run came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Measured {
    /// Why the run ended early: a state that is not a number, a body that the engine set aside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// The numbers that must hold.
    pub numbers: Numbers,
    /// The step [s]: of the engine, or the sub-step of the explicit net.
    pub step_s: f64,
    /// Steps of that length done.
    pub steps: u64,
    /// Contacts, summed over the steps.
    pub contacts: u64,
    /// Wall time [s].
    pub wall_s: f64,
}

impl Measured {
    /// Runs `case`. Strains are measured against that of one cable which takes all energy there is.
    pub fn of(case: &Case) -> Measured {
        let started = Instant::now();
        let mut simulation = Simulation::new(case);
        let mut gauge = Gauge::new(case, &simulation);
        let mut failure = None;
        for _ in 0..case.n_steps() {
            if let Err(error) = simulation.step() {
                failure = Some(error.to_string());
                break;
            }
            gauge.observe(case, &simulation);
        }
        Measured {
            failure,
            numbers: gauge.numbers(case),
            step_s: case.scene().solver.step_s.map_or(case.time_step().step, |step| step.0),
            steps: simulation.work.substeps,
            contacts: simulation.work.contacts,
            wall_s: started.elapsed().as_secs_f64(),
        }
    }

    /// This run with what was worse in `other`.
    pub fn worst(self, other: Measured) -> Measured {
        let numbers = self.numbers.worst(other.numbers);
        Measured { failure: self.failure.or(other.failure), numbers, ..self }
    }

    /// What of `bounds` is broken, in words.
    pub fn broken(&self, bounds: &Numbers) -> Vec<String> {
        let mut broken: Vec<String> = self.failure.iter().cloned().collect();
        for ((name, value), (_, bound)) in self.numbers.each().into_iter().zip(bounds.each()) {
            // A number that is none breaks every bound.
            if let (Some(value), Some(bound)) = (value, bound)
                && (value.is_nan() || value > bound)
            {
                broken.push(format!("{name} {value:.2e}, at most {bound:.0e}"));
            }
        }
        broken
    }
}

/// Largest values so far.
struct Gauge {
    /// Thickness of each part [m].
    parts: Vec<f64>,
    start_momentum: Vector3<f64>,
    start_angular_momentum: Vector3<f64>,
    centre: Vector3<f64>,
    arm: f64,
    spin_momentum: f64,
    motion: f64,
    work: f64,
    energy: f64,
    momentum: f64,
    angular_momentum: f64,
    overlap: f64,
    through: Vec<bool>,
    /// Largest strain; and with it, the largest energy of one cable over k l₀² / 2.
    strain: f64,
    last: State,
}

impl Gauge {
    fn new(case: &Case, simulation: &Simulation) -> Gauge {
        let state = &simulation.state;
        let target = case.target();
        let (centre, arm) = scene_size(case, state);
        let start_momentum = simulation.audit.momentum(state);
        let parts = target.map_or(&[][..], |target| &target.parts);
        let angular = simulation.audit.angular_momentum(state) - centre.cross(&start_momentum);
        let mut gauge = Gauge {
            parts: parts.iter().map(|part| part.primitive.thickness()).collect(),
            start_momentum,
            start_angular_momentum: angular,
            centre,
            arm,
            spin_momentum: angular.norm(),
            motion: 0.0,
            work: 0.0,
            energy: 0.0,
            momentum: 0.0,
            angular_momentum: 0.0,
            overlap: 0.0,
            through: vec![false; case.net().n_knots()],
            strain: 0.0,
            last: state.clone(),
        };
        gauge.conserve(case, simulation);
        gauge
    }

    /// Takes in the state after a step.
    fn observe(&mut self, case: &Case, simulation: &Simulation) {
        self.conserve(case, simulation);
        let state = &simulation.state;
        for cable in case.net().cables.iter() {
            let length = (state.knots.position[cable.b] - state.knots.position[cable.a]).norm();
            self.strain = self.strain.max(length / cable.rest_length - 1.0);
        }
        if let (Some(target), Some(now), Some(then)) = (case.target(), state.target(), self.last.target()) {
            let (now, then) = (*now, *then);
            self.probe(case, target, state, [&then, &now]);
        }
        self.last.knots.clone_from(&state.knots);
        self.last.bodies.clone_from(&state.bodies);
    }

    fn conserve(&mut self, case: &Case, simulation: &Simulation) {
        let (audit, state) = (&simulation.audit, &simulation.state);
        let moving: f64 = case.net().mass.iter().zip(&state.knots.velocity).map(|(m, v)| m * v.norm()).sum();
        let target = case.target().zip(state.target());
        let of_target = target.map_or(0.0, |(target, body)| target.mass * body.velocity.norm());
        self.motion = self.motion.max(moving + of_target);
        let momentum = audit.momentum(state) - self.start_momentum - audit.outside_impulse;
        self.momentum = larger(self.momentum, momentum.norm());
        let angular = audit.angular_momentum(state)
            - self.centre.cross(&audit.momentum(state))
            - self.start_angular_momentum
            - (audit.outside_angular_impulse - self.centre.cross(&audit.outside_impulse));
        self.angular_momentum = larger(self.angular_momentum, angular.norm());
        self.energy = larger(self.energy, audit.ledger.created / audit.energy_scale());
        self.work = self.work.max(audit.ledger.start + audit.ledger.put_in);
    }

    /// Where the knots are in the parts, and where they went within the step.
    fn probe(&mut self, case: &Case, target: &Target, state: &State, [then, now]: [&Body; 2]) {
        for (knot, radius) in case.net().radius.iter().enumerate() {
            let from = then.to_body(&self.last.knots.position[knot]);
            let to = now.to_body(&state.knots.position[knot]);
            let way = (to - from).norm();
            if to.norm() - way > target.bounding_radius + radius {
                continue;
            }
            for (part, thickness) in target.parts.iter().zip(&self.parts) {
                let depths = [part.depth(&from), part.depth(&to)];
                self.overlap = larger(self.overlap, 1.0 + depths[1] / radius);
                let limit = THROUGH * thickness;
                // No point of the way is deeper than this.
                if 0.5 * (depths[0] + depths[1] + way) > limit && !self.through[knot] {
                    self.through[knot] = part.deepest_between(&from, &to) > limit;
                }
            }
        }
    }

    fn numbers(&self, case: &Case) -> Numbers {
        let over = |value: f64, scale: f64| if scale > 0.0 { value / scale } else { value };
        // The cable that gives most.
        let strain_of = |cable: &crate::cable::Cable| {
            (2.0 * self.work.max(0.0) / cable.stiffness).sqrt() / cable.rest_length
        };
        let answer = case.net().cables.iter().map(strain_of).fold(0.0, f64::max);
        let touches = case.target().is_some();
        Numbers {
            energy: Some(self.energy),
            momentum: Some(over(self.momentum, self.motion)),
            angular_momentum: Some(over(self.angular_momentum, self.spin_momentum + self.motion * self.arm)),
            overlap: touches.then_some(self.overlap.max(0.0)),
            through: touches.then(|| self.through.iter().filter(|&&through| through).count() as f64),
            strain: Some(over(self.strain, answer)),
        }
    }
}

/// The larger of both; what is not a number stays.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// First centre of mass of net and target, and distance to what is farthest from it [m].
fn scene_size(case: &Case, state: &State) -> (Vector3<f64>, f64) {
    let mut mass = case.net().total_mass();
    let knots = case.net().mass.iter().zip(&state.knots.position);
    let mut moment: Vector3<f64> = knots.map(|(m, x)| *m * x).sum();
    if let (Some(target), Some(body)) = (case.target(), state.target()) {
        mass += target.mass;
        moment += target.mass * body.position;
    }
    let centre = moment / mass;
    let points = state.knots.position.iter().chain(state.target().map(|body| &body.position));
    let farthest = points.map(|point| (point - centre).norm()).fold(0.0, f64::max);
    // A folded net opens.
    (centre, farthest.max(0.5 * case.net().designed_area.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_breaks_every_bound() {
        assert!(larger(larger(1.0, f64::NAN), 2.0).is_nan());
        let measured = Measured {
            failure: None,
            numbers: Numbers { energy: Some(f64::NAN), ..Numbers::default() },
            step_s: 1.0,
            steps: 1,
            contacts: 0,
            wall_s: 0.0,
        };
        assert_eq!(measured.broken(&Numbers::BOUNDS).len(), 1);
    }
}
