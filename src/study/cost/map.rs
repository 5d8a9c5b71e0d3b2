//! Where a method stays stable: step against cable stiffness.
//!
//! Each cell is one run of the net without its target, up to the time of its first full opening,
//! with every cable's stiffness scaled and its damping ratio kept. The checks of a scene refuse an
//! explicit step above the limit; here such runs are made on purpose, to show that the limit is where
//! it is said to be. What is told is how much energy the run gained.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::budget::{Budget, Extent};
use super::timing::timed_while;
use crate::cable::Cable;
use crate::case::Case;
use crate::net::Net;
use crate::options::TimeStep;
use crate::problems::Problems;
use crate::solver::{Flight, JOINTS_STEP, Solver};
use crate::step::mass_spring::stability::stable_step;

/// Factors on the stiffness.
const STIFFNESS: [f64; 7] = [1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3];

/// Steps of the explicit net over its stable step with the stiffness as written.
const SHARES: [f64; 12] = [0.03, 0.06, 0.1, 0.2, 0.4, 0.7, 1.4, 2.5, 5.0, 10.0, 20.0, 40.0];

/// Steps of the engine [s].
const STEPS: [f64; 6] = [2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2];

/// Cells that are run beside each other, for at most all of what is left.
const TOGETHER: usize = 2;

/// Gain over the launch energy from which a run counts as unstable [-].
pub const UNSTABLE: f64 = 0.1;

/// A map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Map {
    /// The method.
    pub method: String,
    /// Its cells.
    pub cells: Vec<Cell>,
    /// The analytic limit: (factor on the stiffness, stable step [s]); empty for a method without one.
    pub limit: Vec<(f64, f64)>,
}

/// One run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cell {
    /// Factor on the stiffness [-].
    pub stiffness: f64,
    /// Step [s].
    pub step_s: f64,
    /// Most energy above that of the launch at any time, over it [-]; null when the run ended in no number.
    pub gain: Option<f64>,
}

/// The maps of the two cable models for the net of `base`, as far as `seconds` pay for them: cells
/// that were not run are left out.
///
/// # Errors
/// The base cannot fly so, or with a pair of the maps.
pub fn maps(base: &Case, opened_s: f64, seconds: f64) -> Result<Vec<Map>, Problems> {
    let free = free_flight(base, opened_s)?;
    let stable = stable_step(free.net());
    let explicit = |share: f64| -> Result<(f64, Case), Problems> {
        let step = share * stable;
        Ok((step, with_method(&free, "explicit+impulse", step)?))
    };
    let joints = |step: f64| -> Result<(f64, Case), Problems> {
        Ok((step, with_method(&free, "joints+rapier", step)?))
    };
    let limit = STIFFNESS.map(|factor| (factor, stable_step(&stiffened(free.net(), factor))));
    let explicit: Vec<_> = SHARES.into_iter().map(explicit).collect::<Result<_, Problems>>()?;
    let joints: Vec<_> = STEPS.into_iter().map(joints).collect::<Result<_, Problems>>()?;
    let map = |method: &str, cases: &[(f64, Case)], limit: Vec<(f64, f64)>| {
        // Long steps first: they are cheap, and the limit lies among them.
        let order: Vec<(&(f64, Case), f64)> =
            cases.iter().rev().flat_map(|case| STIFFNESS.map(|factor| (case, factor))).collect();
        Map { method: method.to_owned(), cells: cells(&order, Budget::new(0.5 * seconds)), limit }
    };
    Ok(vec![map("explicit, symplectic", &explicit, limit.to_vec()), map("joints", &joints, Vec::new())])
}

/// The cells of step and case, and factor on the stiffness, in this `order`, as far as the `budget` goes.
fn cells(order: &[(&(f64, Case), f64)], mut budget: Budget) -> Vec<Cell> {
    let mut cells = Vec::new();
    for together in order.chunks(TOGETHER) {
        // Of a stiff net nothing foretells into how many parts steps are cut.
        let allowed = budget.left() / TOGETHER as f64;
        let run = |&((step, case), stiffness): &(&(f64, Case), f64)| {
            let (gain, cost) = gain(case, stiffness, allowed);
            (gain.map(|gain| Cell { stiffness, step_s: *step, gain }), cost)
        };
        let run: Vec<(Option<Cell>, f64)> = together.par_iter().with_max_len(1).map(run).collect();
        for (cell, cost) in run {
            cells.extend(cell);
            budget.spend(cost);
        }
    }
    cells
}

/// The net of `base` without target and effects.
fn free_flight(base: &Case, duration: f64) -> Result<Case, Problems> {
    base.clone().changed(|built| built.target = None)?.with_scene(|scene| {
        scene.target = None;
        scene.effects = Default::default();
        scene.expect = Default::default();
        scene.duration_s.0 = duration;
        scene.output.sample_s.0 = scene.output.sample_s.0.min(duration);
    })
}

fn with_method(free: &Case, pair: &str, step: f64) -> Result<Case, Problems> {
    let solver = Solver { flight: Flight::Cables, ..free.scene().solver.with_pair(pair) };
    let time_step = if crate::step::method(&solver).acts_in_substeps() {
        // Many sub-steps to a step: energy need not be looked at after each.
        let substeps = (JOINTS_STEP / step).ceil().max(1.0);
        TimeStep { step: substeps * step, substeps: substeps as u32 }
    } else {
        TimeStep { step, substeps: 1 }
    };
    free.clone().with_scene(|scene| scene.solver = solver)?.changed(|built| built.time_step = time_step)
}

fn stiffened(net: &Net, factor: f64) -> Net {
    // c = 2 ξ √(m k)
    let stiffer = |cable: &Cable| Cable {
        stiffness: factor * cable.stiffness,
        damping: factor.sqrt() * cable.damping,
        ..*cable
    };
    Net { cables: net.cables.iter().map(stiffer).collect(), ..net.clone() }
}

/// What the net of `case` gains with so many times its `stiffness`, none where that ends in no number, and what the run cost [s];
/// nothing where that is more than `allowed`.
fn gain(case: &Case, stiffness: f64, allowed: f64) -> (Option<Option<f64>>, f64) {
    let Ok(case) = case.clone().changed(|built| built.net = stiffened(&built.net, stiffness)) else {
        return (Some(None), 0.0);
    };
    if Extent::Flight.forecast(&case) > allowed {
        return (None, 0.0);
    }
    let (done, _) = timed_while(&case, |work| Extent::Flight.price(&case, work) <= allowed);
    let run = match done {
        Ok((run, true)) => run,
        Ok(_) => return (None, allowed),
        Err(_) => return (Some(None), Extent::Flight.forecast(&case)),
    };
    let launch = case.net().launch_energy().max(f64::MIN_POSITIVE);
    let gains = run.frames.ledger.iter().map(|ledger| ledger.own() / launch - 1.0);
    let gain = gains.fold(0.0, f64::max);
    (Some(Some(gain).filter(|gain| gain.is_finite())), Extent::Flight.price(&case, &run.work))
}
