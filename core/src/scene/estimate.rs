//! What a run will take, before anything of it is built: memory, and cable steps.
//!
//! Memory is measured, not derived: bytes a thing, of resident memory of the whole program (x86-64, release).

use crate::contact::strands;
use crate::net::Net;
use crate::options::TimeStep;
use crate::scene::schema::Scene;
use crate::solver::{CableModel, ContactModel};
use crate::state::elements::PIECES;
use crate::step::ancf;
use crate::step::limits::Demands;
use crate::target::Target;
use crate::target::parts::{ConvexPart, Primitive};

/// The program itself [bytes].
const PROGRAM: f64 = 20e6;

/// A cable with its joint and its share of the knots: 2.0 kB in a net of 250 000 knots, 2.3 kB of 40 000 [bytes].
const JOINT: f64 = 2400.0;

/// The same as an explicit net: 0.4 kB [bytes].
const EXPLICIT: f64 = 500.0;

/// Two boxes that the engine sees overlap: 8.1 to 8.8 [bytes].
const NEAR: f64 = 9.0;

/// A knot or cable near a part, as the engine keeps it [bytes].
const TOUCHING: f64 = 600.0;

/// What a sphere on a cable of elements keeps of how others answer it: some 300 points [bytes].
const ANSWER: f64 = 5000.0;

/// A recorded position: three numbers, twice while the files are written, and the replay's copy: 62 [bytes].
const POSITION: f64 = 64.0;

/// What a recorded frame takes beside its knots (ledger, target, readings), in knots.
pub const FRAME_KNOTS: usize = 16;

/// A round part with the points that stand for it in the target's hull: 59 kB; any other 3 kB [bytes].
const ROUND_PART: f64 = 60e3;
const PART: f64 = 4e3;

/// A corner of a convex part [bytes].
const CORNER: f64 = 1500.0;

/// Positions that are recorded a frame: of knots, and along cables of elements where they may touch.
pub fn positions(scene: &Scene, net: &Net) -> f64 {
    let lines =
        scene.target.as_ref().and(scene.solver.spheres()).map_or(0, |_| (PIECES + 1) * net.cables.len());
    (net.n_knots().max(FRAME_KNOTS) + lines) as f64
}

/// Memory that each place of a scene asks for [bytes].
pub fn memory(scene: &Scene, demands: &Demands<'_>, time_step: TimeStep) -> Vec<(&'static str, f64)> {
    let Demands { net, target, .. } = *demands;
    let (n_knots, n_cables) = (net.n_knots() as f64, net.cables.len() as f64);
    let a_cable = match scene.solver.cables {
        CableModel::Joints => JOINT,
        CableModel::Explicit => EXPLICIT,
        CableModel::Ancf => ancf::memory(net, &scene.solver) / n_cables.max(1.0),
    };
    let n_steps = scene.duration_s.0 / time_step.step;
    let n_frames = scene.duration_s.0 / scene.output.sample_s.0.max(time_step.step);
    let mut all = vec![
        ("net.meshes", PROGRAM + a_cable * n_cables),
        ("output.sample_s", POSITION * n_frames * positions(scene, net)),
        ("duration_s", size_of::<f64>() as f64 * n_steps),
    ];
    if scene.effects.self_contact.is_some() {
        all.push(("effects.self_contact", strands::memory(net)));
    }
    let Some(target) = target else { return all };
    all.push(("target.shape", target.parts.iter().map(a_part).sum()));
    // A detection sees as far as the reach, and as a snap may throw a knot within a step.
    let reach = demands.contact_margin() + 2.0 * time_step.step * demands.fastest();
    let touching = TOUCHING * covering(target, reach);
    let n_spheres = scene.solver.spheres().map_or(0.0, f64::from) * n_cables;
    all.push(("net.meshes", touching * n_knots));
    if n_spheres > 0.0 {
        all.push(("solver.ancf.spheres", (touching + ANSWER) * n_spheres));
    }
    if scene.solver.contact != ContactModel::Rapier {
        let size = 2.0 * net.radius.iter().copied().fold(0.0, f64::max);
        all.push(("solver.reach_m", NEAR * near_pairs(n_knots + n_spheres, size, net, reach)));
    }
    if scene.effects.cable_contact.is_some() {
        let longest = net.cables.iter().map(|cable| (net.folded[cable.b] - net.folded[cable.a]).norm());
        let boxes = NEAR * near_pairs(n_cables, longest.fold(0.0, f64::max), net, reach);
        all.push(("effects.cable_contact", boxes + touching * n_cables));
    }
    all
}

fn a_part(part: &ConvexPart) -> f64 {
    match &part.primitive {
        Primitive::Cuboid { .. } => PART,
        Primitive::Cylinder { .. } | Primitive::Capsule { .. } | Primitive::Ball { .. } => ROUND_PART,
        Primitive::Convex { hull } => PART + CORNER * hull.vertices.len() as f64,
    }
}

/// Pairs of boxes of `size` around `n` places of the folded net that overlap when each is larger by `reach` at all
/// sides [m]. The net is folded densest; the engine keeps every such pair, though no two of them touch.
///
/// Two places spread evenly over a length L are nearer than d with the probability 2 d / L - (d / L)^2.
fn near_pairs(n: f64, size: f64, net: &Net, reach: f64) -> f64 {
    let Some(first) = net.folded.first() else { return 0.0 };
    let (low, high) = net.folded.iter().fold((*first, *first), |(low, high), x| (low.inf(x), high.sup(x)));
    let near = |length: f64| {
        let share = ((size + 2.0 * reach) / length).min(1.0);
        share * (2.0 - share)
    };
    let sides = high - low;
    0.5 * n * n * sides.iter().map(|&side| if side > 0.0 { near(side) } else { 1.0 }).product::<f64>()
}

/// In how many parts' boxes, larger by `reach`, a place near the target is, on average: at least one.
fn covering(target: &Target, reach: f64) -> f64 {
    let whole = 2.0 * (target.bounding_radius + reach);
    // A ball around the part, in a box.
    let share = |part: &ConvexPart| {
        let centre = part.pose.translation.vector;
        let size = part
            .primitive
            .reach_from(&nalgebra::Vector3::zeros())
            .min(target.bounding_radius + centre.norm());
        (2.0 * (size + reach) / whole).min(1.0).powi(3)
    };
    target.parts.iter().map(share).sum::<f64>().max(1.0)
}

/// Cables, or elements of theirs, summed over all (sub-)steps that are foreseen.
pub fn cable_steps(scene: &Scene, net: &Net, time_step: TimeStep) -> f64 {
    let n_steps = scene.duration_s.0 / time_step.step;
    let pieces = match scene.solver.cables {
        CableModel::Ancf => scene.solver.ancf.unwrap_or_default().elements,
        CableModel::Joints | CableModel::Explicit => 1,
    };
    n_steps * f64::from(time_step.substeps) * f64::from(pieces) * net.cables.len() as f64
}

/// Bytes in words: `3.2 GB`.
pub fn in_words(bytes: f64) -> String {
    match bytes {
        huge if huge >= 1e12 => format!("{:.1e} GB", huge / 1e9),
        large if large >= 1e9 => format!("{:.1} GB", large / 1e9),
        small => format!("{:.0} MB", small / 1e6),
    }
}
