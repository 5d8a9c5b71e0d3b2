//! Knots that a constraint asks the engine to hold together: the latches of a closing mechanism.
//!
//! A tie is a joint as cables are, as stiff as the engine's arithmetic bears: it takes no energy up that it would give back. What its knots
//! part by all the same, as rows are solved in few passes, a joint would take back within a few steps, against all that pulls at it: work that
//! nobody put in, 0.18 of the energy at hand where one of a Cubesat's latches had come to 13 mm from 7. So a tie takes back nothing by itself. A step in
//! which one gives way is done again in more parts, and where knots come nearer by what else acts, it follows.
//!
//! | Cubesats at 2 rad/s, 3 s, joints+rapier, created in the middle and at most | `tube`, 12 | `cinch` about z, 6 |
//! |---|---|---|
//! | latches of ours, before the engine moves | 0.2, 8e2 | 1.8e-2, 0.28 |
//! | ties that take back what they gave | 5.8e-4, 0.15 | 1.8e-4, 2.6e-4 |
//! | and steps in more parts where one opens by 5 % | 2.3e-4, 1.9e-3 | 1.5e-4, 2.5e-3 |
//! | and follow | 1.5e-4, 2.0e-4 | 1.4e-4, 1.6e-4 |

use crate::state::{Knots, Tie};
use crate::world::{Softness, World};

/// Natural frequency times the step, and damping ratio: a third of what is beyond the distance is taken back in a step, and a tie gives way by less than
/// a thousandth of what it is pulled by. With a tenth and a hundredth of both, latches crept to 1.2 to 3.5 and to 1.4 to 4.8 times their distance.
const STIFF: f64 = 1000.0;

/// A tie may open by so much of its distance.
const OPENS: f64 = 0.05;

/// Beyond that it may open so much further in a step that is not in as many parts as may be. Of 40 latches in two nets each of `tube` and
/// `cinch` eight opened by more than a tenth without such a bound, to 3.3 times the distance at most, five so, to 1.4 times.
const OPENS_FURTHER: f64 = 1e-3;

/// The ties that the engine holds.
pub struct KnotTies {
    softness: Softness,
    ties: Vec<JoinedTie>,
}

/// A tie and its joint.
struct JoinedTie {
    tie: Tie,
    joint: usize,
    /// Beyond which distance it pulls [m].
    rest_length: f64,
}

impl KnotTies {
    /// None yet, for steps of `step` seconds.
    pub fn new(step: f64) -> KnotTies {
        let frequency = STIFF / step / std::f64::consts::TAU;
        KnotTies { softness: Softness { frequency, damping_ratio: STIFF }, ties: Vec::new() }
    }

    /// Ties those of `ties` in `world`.
    pub fn add(&mut self, ties: Vec<Tie>, world: &mut World) {
        self.ties.extend(ties.into_iter().map(|tie| JoinedTie {
            joint: world.tie(tie.knots, tie.distance, self.softness),
            rest_length: tie.distance,
            tie,
        }));
    }

    /// Before a step: those that gave way hold where they are.
    pub fn follow(&mut self, knots: &Knots, world: &mut World) {
        for JoinedTie { tie, joint, rest_length } in &mut self.ties {
            let holds_at = tie.holds_at(knots);
            if std::mem::replace(rest_length, holds_at) != holds_at {
                world.set_rest_length(*joint, holds_at);
            }
        }
    }

    /// Whether one gave way in a step that led from knots at `start` to `end`.
    pub fn give_way(&self, start: &Knots, end: &Knots) -> bool {
        self.ties.iter().any(|JoinedTie { tie, .. }| {
            let open = tie.apart(end) / tie.distance;
            open > 1.0 + OPENS && open > tie.apart(start) / tie.distance + OPENS_FURTHER
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::net::Net;
    use crate::problems::Problems;
    use crate::state::State;
    use crate::world::Setup;
    use nalgebra::Vector3;

    const STEP: f64 = 5e-4;

    /// One mesh at rest, so folded that its cables are slack, and its world.
    fn mesh() -> (State, World) {
        let spec = serde_json::json!({ "meshes": [1, 1], "mesh_length_m": 1.0, "bullet_mass_kg": 0.1,
            "cable": { "material": "kevlar", "diameter_m": 0.001, "damping_ratio": 0.1 } });
        let launch =
            serde_json::from_value(serde_json::json!({ "speed_m_s": 1.0, "angle_deg": 30.0 })).unwrap();
        let net =
            Net::build(&serde_json::from_value(spec).unwrap(), &launch, &mut Problems::new("test")).unwrap();
        let knots = Knots { position: net.folded.clone(), velocity: vec![Vector3::zeros(); net.n_knots()] };
        let state = State { knots, ..State::default() };
        let mut world = World::new(&net, None, &Setup { step: STEP, ..Setup::default() });
        world.write(&state);
        (state, world)
    }

    fn advance(ties: &mut KnotTies, state: &mut State, world: &mut World) {
        ties.follow(&state.knots, world);
        world.advance(state, STEP, 4);
    }

    /// Two knots that fly apart are caught at the distance, and go on with the motion of their centre.
    #[test]
    fn tied_knots_do_not_part() {
        let (mut state, mut world) = mesh();
        let tie =
            Tie { knots: [0, 1], distance: 1.1 * (state.knots.position[1] - state.knots.position[0]).norm() };
        let along = (state.knots.position[1] - state.knots.position[0]).normalize();
        state.knots.velocity = vec![-along, 3.0 * along, Vector3::zeros(), Vector3::zeros()];
        world.write(&state);
        let mut ties = KnotTies::new(STEP);
        ties.add(vec![tie], &mut world);
        for _ in 0..400 {
            advance(&mut ties, &mut state, &mut world);
            assert!(tie.apart(&state.knots) < 1.001 * tie.distance, "{}", tie.apart(&state.knots));
        }
        assert!((state.knots.velocity[0] - along).norm() < 1e-3, "{}", state.knots.velocity[0]);
    }

    /// One that has given way takes nothing back: its knots stay where they are, and come nearer when something moves them.
    #[test]
    fn a_tie_that_gave_way_takes_nothing_back() {
        let (mut state, mut world) = mesh();
        let apart = (state.knots.position[1] - state.knots.position[0]).norm();
        let tie = Tie { knots: [0, 1], distance: 0.5 * apart };
        let mut ties = KnotTies::new(STEP);
        ties.add(vec![tie], &mut world);
        for _ in 0..100 {
            advance(&mut ties, &mut state, &mut world);
        }
        assert!((tie.apart(&state.knots) - apart).abs() < 1e-9);
        let towards = (state.knots.position[1] - state.knots.position[0]).normalize();
        for velocity in [towards, -towards] {
            state.knots.velocity[0] = velocity;
            world.write(&state);
            for _ in 0..20 {
                advance(&mut ties, &mut state, &mut world);
            }
        }
        let nearer = apart - tie.apart(&state.knots);
        assert!((nearer - 20.0 * STEP).abs() < 1e-3 * nearer, "it holds where it came to: {nearer}");
    }

    #[test]
    fn a_tie_that_opens_asks_for_shorter_parts() {
        let (state, mut world) = mesh();
        let apart = (state.knots.position[1] - state.knots.position[0]).norm();
        let mut ties = KnotTies::new(STEP);
        ties.add(vec![Tie { knots: [0, 1], distance: apart / 1.2 }], &mut world);
        let moved = |way: f64| {
            let mut knots = state.knots.clone();
            let along = (knots.position[1] - knots.position[0]).normalize();
            knots.position[1] += way * along;
            knots
        };
        assert!(!ties.give_way(&state.knots, &state.knots), "as open as it was");
        assert!(ties.give_way(&state.knots, &moved(0.01 * apart)));
        assert!(!ties.give_way(&moved(-0.5 * apart), &moved(-0.2 * apart)), "within its distance");
    }
}
