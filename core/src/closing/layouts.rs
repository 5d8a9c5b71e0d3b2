//! Which way the thread takes: layouts, as data for one and the same constraint.
//!
//! | layout | threads | passes | wound |
//! |---|---|---|---|
//! | `tube` | four, one a side | every knot of the perimeter between two bullets | at both ends, in the bullets |
//! | `interlaced` | four, one a side | every other knot of the perimeter between two bullets | likewise |
//! | `free` | four, one a side | the two bullets only | likewise |
//! | `cinch` | one | the centre knot, the knots of a middle row out to the perimeter, once around it and back to where it met it | at the chaser |
//!
//! `tube` is the design of Section 5.4.1: the perimeter is a flexible tube with the thread inside.
//! The other two with winches in the bullets are those of Benvenuto et al. (Fig. 5.14), `cinch` is
//! that of Sharf et al. (Fig. 5.15), as the source describes them. Our choices, where it leaves
//! them open: a thread interlaced with the perimeter is held by every other knot; the cord runs from the
//! centre to the perimeter along the net, so that it goes around the target and not through it; the
//! chaser stays at the origin of the local frame.

use std::collections::VecDeque;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::thread::{Ends, Node};
use crate::net::Net;

/// Layouts of the closing thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// Through every knot of the perimeter, wound in the bullets.
    #[default]
    Tube,
    /// Through every other knot of the perimeter, wound in the bullets.
    Interlaced,
    /// From bullet to bullet, wound in the bullets.
    Free,
    /// Around the mouth and through the net's centre to the chaser, wound there.
    Cinch,
}

/// The way of one thread.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// The points it passes.
    pub nodes: Vec<Node>,
    /// Where it is wound.
    pub ends: Ends,
    /// Number of winches.
    pub winches: u32,
    /// Its length in the net when that is fully deployed, without a tether to the chaser [m].
    pub full_length: f64,
}

impl Layout {
    /// The threads of this layout in `net`.
    pub fn routes(self, net: &Net) -> Vec<Route> {
        match self {
            Layout::Tube => sides(net).into_iter().map(|side| between_bullets(net, &side, &side)).collect(),
            Layout::Interlaced => sides(net)
                .into_iter()
                .map(|side| between_bullets(net, &side, &every_other(net, &side)))
                .collect(),
            Layout::Free => sides(net)
                .into_iter()
                .map(|side| between_bullets(net, &side, &[side[0], side[side.len() - 1]]))
                .collect(),
            Layout::Cinch => vec![cinch(net)],
        }
    }
}

/// The perimeter from each bullet to the next, both included.
fn sides(net: &Net) -> Vec<Vec<usize>> {
    let around = &net.perimeter;
    let place = |bullet| around.iter().position(|&knot| knot == bullet).unwrap_or(0);
    let starts = net.bullets.map(place);
    (0..4)
        .map(|side| {
            let (from, to) = (starts[side], starts[(side + 1) % 4]);
            let count = (to + around.len() - from) % around.len();
            (0..=count).map(|i| around[(from + i) % around.len()]).collect()
        })
        .collect()
}

/// Every other grid knot of `side`, and both ends.
fn every_other(net: &Net, side: &[usize]) -> Vec<usize> {
    let n_grid = net.grid[0] * net.grid[1];
    let grid: Vec<usize> = side.iter().copied().filter(|&knot| knot < n_grid).collect();
    let last = grid.len() - 1;
    (0..=last).filter(|i| i % 2 == 0 || *i == last).map(|i| grid[i]).collect()
}

fn between_bullets(net: &Net, side: &[usize], knots: &[usize]) -> Route {
    Route {
        nodes: knots.iter().map(|&knot| Node::Knot(knot)).collect(),
        ends: Ends::Both,
        winches: 2,
        full_length: deployed(net, side),
    }
}

fn cinch(net: &Net) -> Route {
    let [rows, columns] = net.grid;
    let way = shortest(net, net.middle_knot(), (rows / 2) * columns);
    let start = net.perimeter.iter().position(|knot| Some(knot) == way.last()).unwrap_or(0);
    let around = (1..=net.perimeter.len()).map(|i| net.perimeter[(start + i) % net.perimeter.len()]);
    let knots: Vec<usize> = way.into_iter().chain(around).collect();
    Route {
        full_length: deployed(net, &knots),
        nodes: std::iter::once(Node::Anchor).chain(knots.into_iter().map(Node::Knot)).collect(),
        ends: Ends::First,
        winches: 1,
    }
}

/// Length along the unstretched cables through neighbouring `knots` [m].
fn deployed(net: &Net, knots: &[usize]) -> f64 {
    let length = |a: usize, b: usize| {
        let between = |c: &&crate::cable::Cable| [c.a, c.b] == [a, b] || [c.b, c.a] == [a, b];
        net.cables.iter().find(between).map_or(0.0, |cable| cable.rest_length)
    };
    knots.windows(2).map(|pair| length(pair[0], pair[1])).sum()
}

/// The way of fewest cables; along a row of the grid it is that row.
fn shortest(net: &Net, from: usize, to: usize) -> Vec<usize> {
    let mut before: Vec<Option<usize>> = vec![None; net.n_knots()];
    let mut neighbours = vec![Vec::new(); net.n_knots()];
    for cable in net.cables.iter() {
        neighbours[cable.a].push(cable.b);
        neighbours[cable.b].push(cable.a);
    }
    // From the end, so that the way comes out in order.
    let mut queue = VecDeque::from([to]);
    before[to] = Some(to);
    while let Some(knot) = queue.pop_front() {
        for &next in &neighbours[knot] {
            if before[next].is_none() {
                before[next] = Some(knot);
                queue.push_back(next);
            }
        }
    }
    let mut way = vec![from];
    while let (Some(&here), true) = (way.last(), way.last() != Some(&to)) {
        match before[here] {
            Some(next) => way.push(next),
            None => break, // a net is connected
        }
    }
    way
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::net::spec::Launch;
    use crate::problems::Problems;
    use serde_json::json;

    fn net(middle: u32) -> Net {
        let spec = json!({ "meshes": [10, 6], "mesh_length_m": 0.5, "bullet_mass_kg": 1.0, "middle_knots": middle,
            "cable": { "material": "kevlar", "diameter_m": 0.001 } });
        let launch = Launch { speed_m_s: 10.0, angle_deg: 30.0, bullets: Default::default() };
        Net::build(&serde_json::from_value(spec).unwrap(), &launch, &mut Problems::new("test")).unwrap()
    }

    fn counts(layout: Layout, middle: u32) -> Vec<usize> {
        layout.routes(&net(middle)).iter().map(|route| route.nodes.len()).collect()
    }

    #[test]
    fn side_threads_run_from_bullet_to_bullet() {
        assert_eq!(counts(Layout::Tube, 0), [11, 7, 11, 7]);
        assert_eq!(counts(Layout::Tube, 1), [21, 13, 21, 13]);
        assert_eq!(counts(Layout::Interlaced, 0), [6, 4, 6, 4]);
        assert_eq!(counts(Layout::Interlaced, 1), [6, 4, 6, 4]);
        assert_eq!(counts(Layout::Free, 0), [2, 2, 2, 2]);
        for layout in [Layout::Tube, Layout::Interlaced, Layout::Free] {
            for middle in [0, 1] {
                let net = net(middle);
                for (side, route) in layout.routes(&net).iter().enumerate() {
                    assert_eq!(route.nodes[0], Node::Knot(net.bullets[side]));
                    assert_eq!(route.nodes[route.nodes.len() - 1], Node::Knot(net.bullets[(side + 1) % 4]));
                    assert!((route.full_length - [5.0, 3.0, 5.0, 3.0][side]).abs() < 1e-12);
                }
            }
        }
    }

    /// Centre, out along the middle row, once around and back: 3 cables out, 32 around.
    #[test]
    fn the_cinch_goes_once_around_the_mouth() {
        for middle in [0, 1] {
            let net = net(middle);
            let route = &Layout::Cinch.routes(&net)[0];
            let pieces = 1 + middle as usize;
            assert_eq!(route.nodes.len(), 2 + pieces * (3 + 32));
            assert_eq!(route.nodes[..2], [Node::Anchor, Node::Knot(net.middle_knot())]);
            assert_eq!(route.nodes[1 + 3 * pieces], route.nodes[route.nodes.len() - 1]);
            assert!((route.full_length - 35.0 * 0.5).abs() < 1e-12);
        }
    }
}
