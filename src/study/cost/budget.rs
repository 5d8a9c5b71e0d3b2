//! What a study may spend: work that is counted, not a clock that runs.
//!
//! A study that stops when a clock says so measures another thing on a busy machine than on a quiet one. So the
//! seconds of a budget are those of one quiet core of the machine that [`Method::price`] was measured on, and what is
//! taken off are counts: steps, rows, contacts of the runs that were done, and a forecast of those for the runs to
//! come. The same budget then measures the same settings on every machine, however busy; how long that takes
//! there, the study says.
//!
//! [`Method::price`]: crate::step::stepper::Method::price

use crate::case::Case;
use crate::net::Net;
use crate::solver::Solver;
use crate::step;
use crate::work::Work;

/// Seconds that are left to spend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    left: f64,
}

impl Budget {
    /// `seconds` to spend.
    pub fn new(seconds: f64) -> Budget {
        Budget { left: seconds }
    }

    /// What is left of it [s]; never below zero.
    pub fn left(&self) -> f64 {
        self.left.max(0.0)
    }

    /// Whether `seconds` are left.
    pub fn covers(&self, seconds: f64) -> bool {
        seconds <= self.left
    }

    /// Spends `seconds`, whether they are left or not.
    pub fn spend(&mut self, seconds: f64) {
        self.left -= seconds;
    }
}

/// Processor time of what all methods have in common [s], on the core that [`Method::price`] knows. Set by hand so that
/// both together give the capture of the free Cubesat, 0.98 s with joints and 0.12 s explicit (the test below), and that of
/// 120 drawn scenes of 6 to 100 knots, most within a factor of two.
struct Price;

impl Price {
    /// A contact in a step.
    const CONTACT: f64 = 2.5e-7;
    /// A knot looked at by a detection.
    const LOOK: f64 = 1.2e-7;
    /// A knot in a step: audit and record.
    const RECORD: f64 = 2.5e-8;
    /// A step, whatever the net.
    const STEP: f64 = 3e-6;
    /// A cable in a step of the event-located integrator: seven stages, and the search for events.
    const LOCATED: f64 = 2.5e-7;
}

/// What effects make of a run's price, over that of the run without them: the middle of the drawn scenes that name one. It
/// depends on when and where they act, which nothing counts: single scenes have a quarter and four times of it.
struct Burden {
    threads: f64,
    strands: f64,
    cables: f64,
}

impl Burden {
    /// Where they act in every sub-step.
    const IN_SUBSTEPS: Burden = Burden { threads: 2.8, strands: 5.0, cables: 2.0 };
    /// Where they act once a step.
    const IN_STEPS: Burden = Burden { threads: 1.4, strands: 1.5, cables: 1.2 };

    /// That of the effects that `case` names.
    fn of(case: &Case) -> f64 {
        let (options, solver) = (case.scene().effects.options(), &case.scene().solver);
        let each =
            if step::method(solver).acts_in_substeps() { Burden::IN_SUBSTEPS } else { Burden::IN_STEPS };
        let named = [
            (options.has_constraints, each.threads),
            (options.strands_touch.is_some(), each.strands),
            (options.cables_touch, each.cables),
        ];
        named.into_iter().filter(|(is_named, _)| *is_named).map(|(_, burden)| burden).product()
    }
}

/// What a run of `case` that did `work` costs [s].
pub fn price(case: &Case, work: &Work) -> f64 {
    Burden::of(case) * price_without_effects(case, work)
}

fn price_without_effects(case: &Case, work: &Work) -> f64 {
    let (solver, net) = (&case.scene().solver, case.net());
    let n_knots = net.n_knots() as f64;
    step::method(solver).price(solver, net.n_knots(), net.cables.len(), work)
        + Price::CONTACT * work.contacts as f64
        + Price::LOOK * n_knots * work.detections as f64
        + (Price::RECORD * n_knots + Price::STEP) * work.steps as f64
}

/// What a run of `case` will cost [s]; `known` is the work of a run of the scene as written: there are as many
/// contacts at a time, whatever the method, and where the engine moved the cables it cuts as many parts again: a stiff net
/// took fifty times those of a flight.
pub fn forecast(case: &Case, known: &Work) -> f64 {
    let contacts_a_step = known.contacts as f64 / known.steps.max(1) as f64;
    let mut work = work_in_flight(case);
    work.contacts = (contacts_a_step * work.steps as f64) as u64;
    if known.cable_rows > 0 && !step::method(&case.scene().solver).acts_in_substeps() {
        work.substeps = work.substeps.max(known.substeps);
        work.sweeps = work.sweeps.max(known.sweeps);
        work.cable_rows = work.cable_rows.max(known.cable_rows);
    }
    price(case, &work)
}

/// How far runs of settings go.
#[derive(Clone, Copy)]
pub enum Extent<'a> {
    /// To the scene's end; the work of a run of it as written is known.
    Whole(&'a Work),
    /// Until net and target meet.
    Flight,
}

impl Extent<'_> {
    /// What a run of `case` that goes so far will cost [s].
    pub fn forecast(self, case: &Case) -> f64 {
        match self {
            Extent::Whole(known) => forecast(case, known),
            Extent::Flight => forecast_flight(case),
        }
    }

    /// What one cost that did `work` [s].
    pub fn price(self, case: &Case, work: &Work) -> f64 {
        match self {
            Extent::Whole(_) => price(case, work),
            Extent::Flight => price_without_effects(case, work),
        }
    }
}

/// What a run of `case` will cost that ends before net and target meet, where effects have little to do [s].
pub fn forecast_flight(case: &Case) -> f64 {
    price_without_effects(case, &work_in_flight(case))
}

/// What the method of `case` will count if nothing touches.
fn work_in_flight(case: &Case) -> Work {
    step::method(&case.scene().solver).forecast(case.net().cables.len(), case.n_steps(), case.time_step())
}

/// Steps of the event-located flight of `net` that `seconds` pay for.
pub fn located_steps(net: &Net, seconds: f64) -> u64 {
    (seconds / (Price::LOCATED * net.cables.len() as f64)) as u64
}

/// The shortest step of a flight of `net` with the explicit method of `solver` for `duration` seconds that `seconds`
/// pay for [s].
pub fn shortest_step(net: &Net, duration: f64, solver: &Solver, seconds: f64) -> f64 {
    let one = Work { substeps: 1, ..Work::default() };
    duration * step::method(solver).price(solver, net.n_knots(), net.cables.len(), &one) / seconds.max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPLICIT: [&str; 2] = ["solver.cables=explicit", "solver.contact=impulse"];

    /// The free Cubesat with `changes`.
    fn cubesat(changes: &[&str]) -> Case {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
        Case::load("cubesat-free", &changes).unwrap()
    }

    /// What the capture of the free Cubesat counted, and about what it cost on a quiet core: 0.98 and 0.12 s.
    #[test]
    fn prices_are_those_of_a_quiet_core() {
        let joints = Work {
            steps: 6000,
            substeps: 6893,
            sweeps: 37_174,
            cable_rows: 893_367,
            snaps: 45_407,
            detections: 5448,
            contacts: 223_302,
            ..Work::default()
        };
        let as_written = cubesat(&[]);
        let price_of_joints = price(&as_written, &joints);
        assert!((0.65..1.5).contains(&price_of_joints), "{price_of_joints} s");
        let explicit =
            Work { steps: 6000, substeps: 42_000, detections: 359, contacts: 257_069, ..Work::default() };
        let case = cubesat(&EXPLICIT);
        let price_of_explicit = price(&case, &explicit);
        assert!((0.08..0.2).contains(&price_of_explicit), "{price_of_explicit} s");
        // A forecast knows how often the scene touches, and no more.
        for (case, price) in [(&as_written, price_of_joints), (&case, price_of_explicit)] {
            let ratio = forecast(case, &joints) / price;
            assert!((0.5..2.0).contains(&ratio), "{ratio}");
        }
    }

    /// What small nets counted: mostly sub-steps, whatever the net, and a thread's. 0.68 and 0.98 s of a core twice as slow.
    #[test]
    fn a_small_net_has_its_price_too() {
        let thread = r#"effects.closing={"layout": "tube", "trigger": {"on": "contact"}, "reel_speed_m_s": 0.5, "max_tension_n": 1}"#;
        for (changes, substeps, seconds) in
            [(vec!["net.meshes=[6,1]"], 1_250_400, 0.3), (vec!["net.meshes=[1,7]", thread], 585_000, 0.5)]
        {
            let work = Work { steps: 2400, substeps, ..Work::default() };
            let ratio = price(&cubesat(&[EXPLICIT.as_slice(), &changes].concat()), &work) / seconds;
            assert!((0.5..2.0).contains(&ratio), "{ratio}");
        }
    }

    /// What a stiff net was cut into is foreseen for its other steps, and not for explicit cables.
    #[test]
    fn parts_that_were_cut_will_be_cut_again() {
        let flown =
            Work { steps: 6000, substeps: 6893, sweeps: 37_174, cable_rows: 893_367, ..Work::default() };
        let cut = Work { substeps: 300_000, sweeps: 1_300_000, cable_rows: 40_000_000, ..flown.clone() };
        let grows =
            |changes: &[&str]| forecast(&cubesat(changes), &cut) / forecast(&cubesat(changes), &flown);
        assert!(grows(&["solver.step_s=0.00025"]) > 10.0);
        assert_eq!(grows(&EXPLICIT), 1.0);
    }

    #[test]
    fn a_budget_is_spent_and_never_comes_back() {
        let mut budget = Budget::new(2.0);
        assert!(budget.covers(2.0) && !budget.covers(2.1));
        budget.spend(3.0);
        assert_eq!(budget.left(), 0.0);
        assert!(!budget.covers(0.1));
    }
}
