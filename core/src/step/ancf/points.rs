//! Where a net of elements touches: its knots, and virtual spheres along its cables (Section 4.4).
//!
//! A sphere stands at place ξ of an element. A force f on it is the generalized force Q = S(ξ) f (Eq. 4.31), an impulse
//! likewise; its velocity is that of r(ξ). So the coordinates answer an impulse J on point p by M⁻¹ S_p J, and point q by
//!
//! D_qp J,  D_qp = S_qᵀ M⁻¹ S_p   [1/kg],
//!
//! one number for all axes, constant for the whole run. D_pp is one over the mass that a point answers with: of an inner
//! knot of four cables of two elements each 7 % of the mass that is lumped on it, as an impulse sets only the nearest of a
//! flexible cable in motion. D falls by 1/50 from knot to knot (1/16 with one element a cable), so a point keeps what of
//! it is above `NEGLIGIBLE`; only the solver of contacts reads that, to foresee velocities. What it finds is given to
//! the coordinates by the whole mass matrix, which keeps momentum to rounding.

use std::sync::Arc;

use nalgebra::Vector3;

use super::element::{COORDINATES, Condensation};
use super::kernel::{AncfNet, element_net};
use crate::contact::NetMotion;
use crate::net::Net;
use crate::solver::Ancf;
use crate::state::elements::{ElementNet, NodeList, blend, shape};
use crate::state::{Along, Contact, Knots};

/// Share of D_pp below which D_qp is left out.
const NEGLIGIBLE: f64 = 1e-7;

/// A sphere on a cable.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    along: Along,
    element: usize,
    /// S(ξ).
    shape: [f64; COORDINATES],
}

/// Points that an impulse on one moves, each with D [1/kg].
type Moved = Box<[(usize, f64)]>;

/// The points of a net of elements that touch: its knots first, then the spheres.
pub struct TouchPoints {
    n_knots: usize,
    /// The first knot of the cable of each sphere, and the sphere.
    spheres: Vec<(usize, Sphere)>,
    /// For each point that was watched so far, the points that it moves with D [1/kg].
    answers: Vec<Option<Moved>>,
    /// D_pp of those [1/kg].
    own: Vec<f64>,
    /// Change of velocity of each point by the impulses of this sub-step [m/s], and which are not zero.
    change: Vec<Vector3<f64>>,
    changed: Vec<usize>,
    /// Impulses on the points [N s], and on which.
    impulse: Vec<Vector3<f64>>,
    pushed: Vec<usize>,
}

/// The spheres of `net`, cable by cable.
fn spheres(net: &Net, ancf: &Ancf) -> Vec<(usize, Sphere)> {
    let (n, elements) = (f64::from(ancf.spheres), f64::from(ancf.elements));
    let mut spheres = Vec::new();
    for (cable, ends) in net.cables.iter().enumerate() {
        for i in 1..=ancf.spheres {
            let share = f64::from(i) / (n + 1.0);
            let element = (share * elements).floor().min(elements - 1.0);
            let along = Along { cable, end: ends.b, share };
            let shape = shape(share * elements - element);
            spheres.push((ends.a, Sphere { along, element: element as usize, shape }));
        }
    }
    spheres
}

/// Knots and spheres of `net` as knots without cables: what detection and contact forces need to know of them. The mass of
/// a sphere is its share of the cable, as Eq. 3.2 has it for middle knots.
pub fn point_net(net: &Net, ancf: &Ancf) -> Net {
    let mut points = Net { cables: Arc::new([]), ..net.clone() };
    for (a, sphere) in spheres(net, ancf) {
        let Along { cable, end: b, share } = sphere.along;
        let between = |of: &[Vector3<f64>]| (1.0 - share) * of[a] + share * of[b];
        points.mass.push(net.cables[cable].mass / f64::from(ancf.spheres + 1));
        points.radius.push(net.cable_radius(cable));
        points.young_modulus.push(net.young_modulus[a].min(net.young_modulus[b]));
        points.folded.push(between(&net.folded));
        points.launch_velocity.push(between(&net.launch_velocity));
    }
    points
}

/// Mass with which each of them answers an impulse while the knots around it are held [kg].
pub fn answering_mass(net: &Net, ancf: &Ancf) -> Vec<f64> {
    let ElementNet { layout, element_mass, mut answering_mass, .. } = element_net(net, ancf);
    let condensed = Condensation::new(layout);
    let of_spheres: Vec<f64> = spheres(net, ancf)
        .iter()
        .map(|(a, sphere)| {
            let loads = Loads::of(*a, sphere, layout, &condensed);
            let by_knots = loads.ends.iter().map(|&(knot, load)| load * load / answering_mass[knot]);
            let by_own = loads.along(&loads, &condensed) / element_mass[sphere.along.cable];
            1.0 / (by_knots.sum::<f64>() + by_own)
        })
        .collect();
    answering_mass.extend(of_spheres);
    answering_mass
}

impl TouchPoints {
    /// Those of `net`.
    pub fn new(net: &Net, ancf: &Ancf) -> TouchPoints {
        let spheres = spheres(net, ancf);
        let n = net.n_knots() + spheres.len();
        TouchPoints {
            n_knots: net.n_knots(),
            spheres,
            answers: vec![None; n],
            own: vec![0.0; n],
            change: vec![Vector3::zeros(); n],
            changed: Vec::new(),
            impulse: vec![Vector3::zeros(); n],
            pushed: Vec::new(),
        }
    }

    /// Positions and velocities of all points.
    pub fn place(&self, net: &AncfNet, points: &mut Knots) {
        points.position.clear();
        points.velocity.clear();
        for point in 0..self.own.len() {
            let [x, v] = self.motion(net, point);
            points.position.push(x);
            points.velocity.push(v);
        }
    }

    fn motion(&self, net: &AncfNet, point: usize) -> [Vector3<f64>; 2] {
        let Some((_, sphere)) = point.checked_sub(self.n_knots).map(|at| self.spheres[at]) else {
            return net.knots.get(point);
        };
        let nodes: [_; COORDINATES] =
            std::array::from_fn(|i| net.places[2 * sphere.element + i].get(sphere.along.cable));
        [0, 1].map(|of| blend(&sphere.shape, &nodes.map(|node| node[of])))
    }

    /// Learns how `points` answer, where it does not know.
    pub fn watch(&mut self, net: &mut AncfNet, points: impl Iterator<Item = usize>) {
        for point in points {
            if self.answers[point].is_none() {
                self.learn(net, point);
            }
        }
    }

    /// D of `point` with all others.
    fn learn(&mut self, net: &mut AncfNet, point: usize) {
        let mut at_knots = vec![0.0; self.n_knots];
        let loads = self.loads(net, point);
        for (knot, load) in loads.ends {
            at_knots[knot] += load;
        }
        net.knot_mass.solve(&mut at_knots);
        let with = |other: usize| {
            let others = self.loads(net, other);
            let mut answer: f64 = others.ends.iter().map(|&(knot, load)| load * at_knots[knot]).sum();
            if let Some(cable) = loads.cable.filter(|_| loads.cable == others.cable) {
                answer += loads.along(&others, &net.condensed) * net.law.inverse_mass[cable];
            }
            answer
        };
        let own = with(point);
        let all = (0..self.own.len()).map(|other| (other, with(other)));
        let answers = all.filter(|(_, answer)| answer.abs() > NEGLIGIBLE * own).collect();
        self.own[point] = own;
        self.answers[point] = Some(answers);
    }

    /// What a unit impulse on `point` is on its cable's own coordinates, and on the condensed knots.
    fn loads(&self, net: &AncfNet, point: usize) -> Loads {
        match point.checked_sub(self.n_knots).map(|at| &self.spheres[at]) {
            None => Loads { cable: None, own: Vec::new(), ends: [(point, 1.0), (point, 0.0)] },
            Some((a, sphere)) => Loads::of(*a, sphere, net.layout, &net.condensed),
        }
    }

    /// Gives the impulses so far to the coordinates of `net`, and forgets them; whether there were any.
    pub fn release(&mut self, net: &mut AncfNet) -> bool {
        let any = !self.pushed.is_empty();
        if any {
            net.begin_impulses();
            for point in self.pushed.drain(..) {
                let impulse = std::mem::take(&mut self.impulse[point]);
                match point.checked_sub(self.n_knots).map(|at| self.spheres[at].1) {
                    None => net.add_impulse(point, &impulse),
                    Some(Sphere { along, element, shape }) => {
                        net.add_impulse_along(along.cable, element, &shape, &impulse);
                    }
                }
            }
            net.answer_impulses();
        }
        for point in self.changed.drain(..) {
            self.change[point] = Vector3::zeros();
        }
        any
    }

    /// A contact of a point as one of a knot or a cable.
    pub fn named(&self, contact: &Contact) -> Contact {
        match contact.knot.checked_sub(self.n_knots).map(|at| self.spheres[at]) {
            None => *contact,
            Some((knot, sphere)) => Contact { knot, along: Some(sphere.along), ..*contact },
        }
    }
}

/// A unit impulse on a point, as its cable and the knots get it.
struct Loads {
    cable: Option<usize>,
    own: Vec<f64>,
    ends: [(usize, f64); 2],
}

impl Loads {
    /// That on a `sphere` of a cable from knot `a`.
    fn of(a: usize, sphere: &Sphere, layout: NodeList, condensed: &Condensation) -> Loads {
        let weight = |place: usize| {
            let within = place.checked_sub(2 * sphere.element).filter(|i| *i < COORDINATES);
            within.map_or(0.0, |i| sphere.shape[i])
        };
        let own: Vec<f64> = layout.inner().map(weight).collect();
        let [first, last] = layout.ends().map(weight);
        let taken = |end: usize| -> f64 {
            condensed.share.iter().zip(&own).map(|(share, load)| share[end] * load).sum()
        };
        let ends = [(a, first - taken(0)), (sphere.along.end, last - taken(1))];
        Loads { cable: Some(sphere.along.cable), own, ends }
    }

    /// What the own coordinates of a cable of elements of unit mass move under `other` by it [1/kg].
    fn along(&self, other: &Loads, condensed: &Condensation) -> f64 {
        let rows = condensed.inverse.iter().zip(&other.own);
        rows.map(|(row, load)| load * row.iter().zip(&self.own).map(|(a, b)| a * b).sum::<f64>()).sum()
    }
}

/// The points while their contacts are solved.
pub struct PointsInContact<'a> {
    /// The net, whose velocities stay as they are.
    pub net: &'a AncfNet,
    /// The points.
    pub points: &'a mut TouchPoints,
    /// Velocities of all points before the forces of the sub-step acted [m/s]; empty where nothing bounces.
    pub before: &'a [Vector3<f64>],
}

impl NetMotion for PointsInContact<'_> {
    fn position(&self, point: usize) -> Vector3<f64> {
        self.points.motion(self.net, point)[0]
    }

    fn velocity(&self, point: usize) -> Vector3<f64> {
        self.points.motion(self.net, point)[1] + self.points.change[point]
    }

    fn velocity_before(&self, point: usize) -> Vector3<f64> {
        self.before.get(point).copied().unwrap_or_else(|| self.velocity(point))
    }

    fn inverse_mass(&self, point: usize) -> f64 {
        self.points.own[point]
    }

    fn push(&mut self, point: usize, impulse: &Vector3<f64>, weight: f64) {
        let TouchPoints { answers, change, changed, impulse: impulses, pushed, .. } = &mut *self.points;
        let given = weight * impulse;
        if given == Vector3::zeros() {
            return;
        }
        if impulses[point] == Vector3::zeros() {
            pushed.push(point);
        }
        impulses[point] += given;
        for &(other, answer) in answers[point].iter().flat_map(|answers| answers.iter()) {
            if change[other] == Vector3::zeros() {
                changed.push(other);
            }
            change[other] += answer * given;
        }
    }
}
