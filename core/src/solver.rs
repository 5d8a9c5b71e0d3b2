//! The numerical method as a user writes it: which cables, which contact, which step.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::quantity::Positive;

/// The numerical method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// How cable tension acts.
    pub cables: CableModel,
    /// How a contact is answered.
    pub contact: ContactModel,
    /// Time step [s]: of the engine with `joints`, of the integration with `explicit` and `ancf` cables;
    /// left out, one that suits the scene. With the integrator `implicit` that of its steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_s: Option<Positive>,
    /// `joints`: sub-steps of the engine within a step, at which cables and contacts act; contacts
    /// are found once a step.
    #[schemars(range(min = 1, max = 1000))]
    pub substeps: u32,
    /// `joints`: Gauss-Seidel sweeps over all cable and contact rows in each sub-step: at least so many.
    #[schemars(range(min = 1, max = 1000))]
    pub sweeps: u32,
    /// `joints`: at most so many, while a step gains energy (see `step::iterations`).
    #[schemars(range(min = 1, max = 1000))]
    pub sweeps_max: u32,
    /// `joints`: passes over the cables that snap taut within a step, one for those that do at once; 0: snaps are left to the engine.
    #[schemars(range(max = 1000))]
    pub snap_passes: u32,
    /// `joints`: what the engine's implicit rows may take beyond the cables' own law, over the largest energy of the net so far [-]: steps in which
    /// they would take more are cut, as far as that helps. Until net and target meet 0.008, or a twentieth of it if that is more. Not in
    /// steps in which contacts of effects, or of knots by impulses, act.
    pub loss_tolerance: Positive,
    /// `joints`: how the net flies while its box and the target's are apart.
    pub flight: Flight,
    /// `explicit`, and `implicit` with `ancf`: how the net is integrated.
    pub integrator: Integrator,
    /// `explicit` with the integrator `located`: local error of a step of its own [m].
    pub tolerance_m: Positive,
    /// `ancf`: the elements of the cables; left out, two a cable without bending, with three spheres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ancf: Option<Ancf>,
    /// `impulse` and `penalty`: distance from which a knot and a part are watched [m]; contacts are
    /// looked for anew before any knot can have come so far. Left out: 4 % of the target's thinnest part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reach_m: Option<Positive>,
    /// Coefficient of restitution e of a contact (Eq. 4.11) [-]; not with `penalty`.
    #[schemars(range(min = 0, max = 1))]
    pub restitution: f64,
    /// `penalty`: the contact force.
    pub penalty: Penalty,
    /// Width of the engine's numbers. With `explicit` cables the engine finds contacts and no more;
    /// net, target and responses of our own always count in 64 bits.
    pub precision: Precision,
}

impl Default for Solver {
    /// Measured on the free-floating Cubesat (wall time for 3 s; angular momentum residual) and the
    /// Table 3.2 net (bullets against RK4 at 0.5 s): one sub-step of 0.5 ms 0.48 s, 3e-7, 0.9 mm;
    /// two of 1 ms 0.40 s, 5e-5, 0.8 mm; four of 1 ms 0.50 s, 1e-4, 0.8 mm. The engine freezes the
    /// lever arms of contacts over a step, so sub-steps lose angular momentum where knots slide.
    fn default() -> Self {
        Solver {
            cables: CableModel::Joints,
            contact: ContactModel::Rapier,
            step_s: None,
            substeps: 1,
            sweeps: 2,
            sweeps_max: 64,
            // Passes end when nothing snaps any more, so more cost nothing where 4 suffice. Table 3.2's net takes more than
            // 16 in some steps, and none more than 32 where it is undamped.
            snap_passes: 64,
            // A free Cubesat's rows take 0.11 without a bound at Table 3.2's damping, 0.47 at a thirtieth of it: 0.23 so, in three times the time.
            loss_tolerance: Positive(0.15),
            flight: Flight::Cables,
            integrator: Integrator::Auto,
            tolerance_m: Positive(1e-9),
            ancf: None,
            reach_m: None,
            restitution: 0.0,
            penalty: Penalty::default(),
            precision: Precision::F64,
        }
    }
}

/// Step of the engine where a scene leaves it out [s].
pub const JOINTS_STEP: f64 = 5e-4;

/// Pairs of cables and contact that studies run where no other is named, with the names that the program uses.
pub const PAIRS: [(CableModel, ContactModel, &str); 5] = [
    (CableModel::Joints, ContactModel::Rapier, "joints+rapier"),
    (CableModel::Joints, ContactModel::Impulse, "joints+impulse"),
    (CableModel::Joints, ContactModel::Penalty, "joints+penalty"),
    (CableModel::Explicit, ContactModel::Impulse, "explicit+impulse"),
    (CableModel::Explicit, ContactModel::Penalty, "explicit+penalty"),
];

/// Pairs whose steps are so short that a study runs them only where they are named.
pub const ELEMENT_PAIRS: [(CableModel, ContactModel, &str); 2] = [
    (CableModel::Ancf, ContactModel::Impulse, "ancf+impulse"),
    (CableModel::Ancf, ContactModel::Penalty, "ancf+penalty"),
];

impl Solver {
    /// The same with the cables and the contact of a pair of [`PAIRS`]; unchanged by any other name.
    #[must_use]
    pub fn with_pair(self, name: &str) -> Solver {
        let pair = PAIRS.iter().find(|(.., known)| *known == name);
        pair.map_or(self, |&(cables, contact, _)| Solver { cables, contact, ..self })
    }

    /// How its pair of cables and contact is called; empty for one that is none.
    pub fn pair(&self) -> &'static str {
        let mut pairs = PAIRS.iter().chain(&ELEMENT_PAIRS);
        let pair = pairs.find(|(cables, contact, _)| (*cables, *contact) == (self.cables, self.contact));
        pair.map_or("", |(.., name)| name)
    }

    /// Spheres that touch on each cable, where cables are elements.
    pub fn spheres(&self) -> Option<u32> {
        (self.cables == CableModel::Ancf).then(|| self.ancf.unwrap_or_default().spheres)
    }
}

/// How cable tension acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CableModel {
    /// Tension-only spring joints of the engine.
    Joints,
    /// The source's mass-spring net in explicit sub-steps.
    Explicit,
    /// The source's finite elements of positions and slopes (Eq. 3.7 to 3.16), in explicit sub-steps.
    Ancf,
}

impl CableModel {
    /// Whether cables are rows that the engine solves implicitly.
    pub fn is_of_rows(self) -> bool {
        self == CableModel::Joints
    }

    /// What contact of whole cables costs beside that of knots, in words.
    pub fn cable_contact_price(self) -> &'static str {
        // Free Cubesat and satellite with panels: 1.3 and 2.0, 2.3 and 2.4 (docs/speed.md); elements as it was with all cables looked at at once.
        match self {
            CableModel::Joints => "1.3 to 2 times the processor time",
            CableModel::Explicit => "2 to 3 times the processor time",
            CableModel::Ancf => "4 to 9 times the processor time",
        }
    }
}

/// How a contact is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactModel {
    /// The engine's own solver.
    Rapier,
    /// The source's simultaneous impulses (Section 4.3).
    Impulse,
    /// The source's penalty force (Section 4.2).
    Penalty,
}

/// How the net flies before it meets the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Flight {
    /// With the same cables as later.
    Cables,
    /// With explicit cables, handed over when the boxes meet.
    Explicit,
}

/// How the explicit net is integrated, and elements other than by leap-frog: in flight. Where contacts or constraints may act on it
/// an explicit net goes on by `symplectic`, whichever was chosen, until it is apart from all again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// `secant` where `symplectic` at its own step would make energy, or take more than the cables' law: damping ratios below 0.1 and above 0.15 of two
    /// knots (Eq. 3.4 gives them 1 to 1.41 times that of the scene), a cable whose own frequency is high among those of the net, or bullets that are
    /// light before the net. `symplectic` elsewhere.
    Auto,
    /// A force that is the difference of stored energy over the step, with books for every cable: keeps energy.
    Secant,
    /// Semi-implicit Euler: velocities first, positions with the new ones.
    Symplectic,
    /// Classical Runge-Kutta of fourth order, the source's choice.
    Rk4,
    /// Dormand and Prince's pair of orders 5 and 4, stopping wherever a cable goes taut or slack.
    Located,
    /// `ancf` only: an implicit step that keeps energy and is stable whatever its length, while nothing touches and no thread
    /// acts; explicit sub-steps else.
    Implicit,
}

/// The elements of `ancf` cables.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Ancf {
    /// Elements of a cable, or of each piece of it between middle knots.
    #[schemars(range(min = 1, max = 32))]
    pub elements: u32,
    /// Whether a cable resists bending (Eq. 3.12); in the source it does not.
    pub bending: bool,
    /// Spheres that touch the target, evenly spaced on a cable between its knots, which touch by themselves (Eq. 4.31).
    #[schemars(range(max = 64))]
    pub spheres: u32,
}

impl Default for Ancf {
    /// The source's: 5280 coordinates for 220 cables; three spheres, which Section 4.4 sets beside three middle knots.
    fn default() -> Self {
        Ancf { elements: 2, bending: false, spheres: 3 }
    }
}

/// The contact force of the penalty method (Section 4.2.1).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Penalty {
    /// The law of Table 4.1.
    pub law: PenaltyLaw,
    /// Stiffness k [N/m^n]; left out: Hertz, Eq. 4.3 and 4.4, from the radius of each knot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Positive>,
    /// Exponent n of the deformation [-]; 1 for `spring-dashpot` whatever stands here.
    #[schemars(range(min = 1, max = 3))]
    pub exponent: f64,
    /// Hunt and Crossley's alpha of Eq. 4.5 [s/m]: 0.08 to 0.32.
    #[schemars(range(min = 0, max = 100))]
    pub alpha_s_m: f64,
    /// Damping d of `spring-dashpot` [N s/m].
    #[schemars(range(min = 0))]
    pub damping_n_s_m: f64,
    /// Young's modulus of the target's surface, for Eq. 4.4 [Pa].
    pub target_young_modulus_pa: Positive,
    /// Poisson's ratios of net and target, for Eq. 4.4 [-].
    #[schemars(inner(range(min = 0, max = 0.5)))]
    pub poisson_ratios: [f64; 2],
}

impl Default for Penalty {
    /// Aluminium and a polymer fibre; the source gives neither its modulus nor its ratio.
    fn default() -> Self {
        Penalty {
            law: PenaltyLaw::HuntCrossley,
            stiffness: None,
            exponent: 1.5,
            alpha_s_m: 0.2,
            damping_n_s_m: 0.0,
            target_young_modulus_pa: Positive(7e10),
            poisson_ratios: [0.4, 0.33],
        }
    }
}

/// Contact forces of Table 4.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PenaltyLaw {
    /// f = k delta + d delta'.
    SpringDashpot,
    /// f = k delta^n.
    Hertz,
    /// f = k delta^n + d delta^n delta', the non-linear damping of Hunt and Crossley.
    HuntCrossley,
}

/// Width of the engine's numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// 64 bits.
    #[default]
    F64,
    /// 32 bits, the engine's usual build: to measure what they save and cost (see [`crate::world`]).
    F32,
}
