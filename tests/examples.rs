//! The programs of `examples/`, which use nothing but the public interface, do what they say.

#[path = "../examples/own_effect.rs"]
mod own_effect;
#[path = "../examples/own_stepper.rs"]
mod own_stepper;
#[path = "../examples/step_by_step.rs"]
mod step_by_step;

use crate::common::below;
use nalgebra::Vector3;
use own_effect::Wind;
use tumblenet::solver::PAIRS;

/// Before contact the target follows v = w (1 − e^(−c t / m)), whatever the method: none drops a force.
#[test]
fn an_effect_from_outside_acts_on_knots_and_target_under_every_pair() {
    for (.., pair) in PAIRS {
        let wind = |on_knot, on_target| Wind { velocity: Vector3::new(-0.5, 0.2, 0.0), on_knot, on_target };
        let (case, run) = own_effect::run(pair, wind(1e-4, 0.7)).unwrap();
        let (_, calm) = own_effect::run(pair, wind(0.0, 0.0)).unwrap();
        let (mass, time) = (case.target().unwrap().mass, *run.frames.time.last().unwrap());
        let expected = Vector3::new(-0.5, 0.2, 0.0) * (1.0 - (-0.7 * time / mass).exp());
        let found = run.frames.target.last().unwrap().velocity;
        // Forces are held over a step: half a step's share of c / m.
        below(&format!("{pair}: target"), (found - expected).norm() / expected.norm(), 1e-3);
        let centre = |run: &tumblenet::run::Run| run.frames.knots.last().unwrap()[case.net().bullets[0]];
        assert!((centre(&run) - centre(&calm)).norm() > 1e-4, "{pair}: the net feels no wind");
        let ledger = run.frames.ledger.last().unwrap();
        assert!(ledger.effects[0] != 0.0, "{pair}");
        below(&format!("{pair}: residual"), ledger.residual().abs() / ledger.start, 1e-9);
        // What came from outside is all that momentum changed by.
        let change = run.frames.momentum.last().unwrap() - run.frames.momentum[0] - run.outside_impulse;
        below(&format!("{pair}: momentum"), change.norm() / run.outside_impulse.norm(), 1e-9);
    }
}

/// The same method twice: but for rounding, and what a net makes of that within so short a time, the same.
#[test]
fn a_method_from_outside_flies_the_net_as_that_of_the_crate() {
    below("knots apart, m", own_stepper::apart(0.2).unwrap(), 1e-9);
}

#[test]
fn a_loop_from_outside_commands_the_winches() {
    let seen = step_by_step::run(1.5).unwrap();
    assert!(seen.started.is_some(), "{seen:?}");
    assert!(seen.off_reels[1] < seen.off_reels[0] - 0.05, "{seen:?}");
    assert!(seen.tension > 0.1 && seen.tension <= 0.5 * (1.0 + 1e-12), "{seen:?}");
}
