//! A net of cable elements as its coordinates say it: where its mass lies, and how it takes a change of velocities.
//!
//! Cables with mass all along have coordinates beyond the positions of the knots (Eq. 3.7 to 3.9): on an element
//! r(ξ) = S₁ r₀ + S₂ σ₀ + S₃ r₁ + S₄ σ₁, with the positions r₀, r₁ of its nodes and σ₀, σ₁ their slopes times its
//! length. A cable of n elements lists them node by node, position then slope: the positions of its ends are knots,
//! all others its own, listed in `State::inner` cable by cable.
//!
//! Mass points: four points of Gauss's quadrature on each element integrate ρ A S Sᵀ, of degree six, exactly, so
//! kinetic energy and momenta are those of Eq. 3.11.
//!
//! A velocity field that is linear in position and velocity (gravity, a frame that turns) moves r as a whole: nodes by
//! the field, slopes by the difference of it between the ends of the slope. The mass matrix then has nothing to say: it is
//! M⁻¹ ∫ ρ A Sᵀ a dx to rounding, and no element is strained.

use nalgebra::Vector3;

use super::{Knots, NetTotals};

/// Coordinates of an element: position and slope of its first node, of its second.
pub const COORDINATES: usize = 4;

/// Straight pieces that stand for a cable where it is looked at from outside of the method.
pub const PIECES: usize = 8;

/// S(ξ) (Eq. 3.9), the slopes times the length of the element.
pub fn shape(xi: f64) -> [f64; COORDINATES] {
    let (square, cube) = (xi * xi, xi * xi * xi);
    [1.0 - 3.0 * square + 2.0 * cube, xi - 2.0 * square + cube, 3.0 * square - 2.0 * cube, cube - square]
}

/// The coordinates of a cable of several elements, as places in its list: node by node, position then slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeList {
    /// Elements of a cable.
    pub elements: usize,
}

impl NodeList {
    /// Entries in the list.
    pub fn size(self) -> usize {
        2 * self.elements + 2
    }

    /// The positions of the two ends, which are knots and shared with other cables.
    pub fn ends(self) -> [usize; 2] {
        [0, 2 * self.elements]
    }

    /// How many others there are.
    pub fn n_inner(self) -> usize {
        2 * self.elements
    }

    /// All others: they are the cable's own.
    pub fn inner(self) -> impl Iterator<Item = usize> {
        (1..self.size()).filter(move |place| *place != 2 * self.elements)
    }
}

/// The elements of a net.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementNet {
    /// Coordinates of each cable.
    pub layout: NodeList,
    /// The knots at both ends of each cable.
    pub ends: Vec<[usize; 2]>,
    /// Mass of an element of each cable [kg].
    pub element_mass: Vec<f64>,
    /// Mass of each knot beside its cables [kg].
    pub own_mass: Vec<f64>,
    /// Mass with which each knot answers an impulse while its neighbours are held [kg]: what is left of its cables at it
    /// when all their own coordinates are free. Neighbours change it by some percent.
    pub answering_mass: Vec<f64>,
}

/// Where a coordinate stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Among the knots.
    Knot(usize),
    /// Among the cables' own.
    Own(usize),
}

/// Places and weights of the quadrature on [0, 1].
fn gauss() -> [(f64, f64); 4] {
    let root = (6.0_f64 / 5.0).sqrt() * 2.0 / 7.0;
    let [near, far] = [3.0 / 7.0 - root, 3.0 / 7.0 + root].map(|square| 0.5 * square.sqrt());
    let [of_near, of_far] = [18.0 + 30.0_f64.sqrt(), 18.0 - 30.0_f64.sqrt()].map(|weight| weight / 72.0);
    [(0.5 - far, of_far), (0.5 - near, of_near), (0.5 + near, of_near), (0.5 + far, of_far)]
}

impl ElementNet {
    /// Where entry `place` in the list of a cable stands.
    pub fn coordinate(&self, cable: usize, place: usize) -> Coordinate {
        let [first, last] = self.layout.ends();
        match place {
            _ if place == first => Coordinate::Knot(self.ends[cable][0]),
            _ if place == last => Coordinate::Knot(self.ends[cable][1]),
            _ => Coordinate::Own(cable * self.layout.n_inner() + place - 1 - usize::from(place > last)),
        }
    }

    /// Value of a coordinate, given those of all knots and of all cables' own.
    pub fn value(of_knots: &[Vector3<f64>], own: &[Vector3<f64>], coordinate: Coordinate) -> Vector3<f64> {
        match coordinate {
            Coordinate::Knot(knot) => of_knots[knot],
            Coordinate::Own(index) => own[index],
        }
    }

    /// The coordinates of element `element` of `cable`.
    pub fn of_element(&self, cable: usize, element: usize) -> [Coordinate; COORDINATES] {
        std::array::from_fn(|i| self.coordinate(cable, 2 * element + i))
    }

    /// The own coordinates of all cables where every cable lies straight between its knots and moves with them.
    pub fn straight(&self, knots: &Knots) -> Knots {
        let own = |of: &[Vector3<f64>]| {
            let mut inner = Vec::with_capacity(self.ends.len() * self.layout.n_inner());
            for &[a, b] in &self.ends {
                let piece = (of[b] - of[a]) / self.layout.elements as f64;
                inner.extend(self.layout.inner().map(|place| match place % 2 {
                    1 => piece,
                    _ => of[a] + (place / 2) as f64 * piece,
                }));
            }
            inner
        };
        Knots { position: own(&knots.position), velocity: own(&knots.velocity) }
    }

    /// The same where cables hang, folded at their middle: each element of cable i falls by `fall[i]`, which is across the line
    /// between its ends, from its first node to its second in the first half, and rises so in the other [m].
    ///
    /// An element has one slope at each node, so none can kink there. Where the fold is a node, its slope is that across
    /// the fold alone and the node stands `fall` / 3 higher: along the fall |r′| is then 1 − ξ² of a straight leg's, no
    /// point is stretched, and a third of the element's length is pressed together at the fold. Where it is within an element,
    /// |r′| is 1 − 2ξ of it there.
    pub fn folded(&self, knots: &Knots, fall: &[Vector3<f64>]) -> Knots {
        let mut inner = self.straight(knots);
        let n = self.layout.elements;
        let own = self.layout.n_inner();
        for (nodes, fall) in inner.position.chunks_mut(own).zip(fall) {
            for (place, coordinate) in self.layout.inner().zip(nodes) {
                let node = place / 2;
                let (half, at_fold) = (node.min(n - node) as f64, 2 * node == n);
                *coordinate += fall
                    * match place % 2 {
                        1 if at_fold => 0.0,
                        1 if 2 * node < n => 1.0,
                        1 => -1.0,
                        _ if at_fold => half - 1.0 / 3.0,
                        _ => half,
                    };
            }
        }
        inner
    }

    /// Places along `cable` from end to end, [`PIECES`] of equal share apart [m].
    pub fn line(&self, cable: usize, knots: &Knots, inner: &Knots) -> Vec<Vector3<f64>> {
        let place = |i: usize| {
            let along = (i * self.layout.elements) as f64 / PIECES as f64;
            let element = (along as usize).min(self.layout.elements - 1);
            let nodes = self.of_element(cable, element);
            let nodes = nodes.map(|at| Self::value(&knots.position, &inner.position, at));
            blend(&shape(along - element as f64), &nodes)
        };
        (0..=PIECES).map(place).collect()
    }

    /// Shows `see` every mass point: its mass [kg], position [m] and velocity [m/s].
    pub fn mass_points(
        &self,
        knots: &Knots,
        inner: &Knots,
        mut see: impl FnMut(f64, &Vector3<f64>, &Vector3<f64>),
    ) {
        for (mass, (x, v)) in self.own_mass.iter().zip(knots.position.iter().zip(&knots.velocity)) {
            see(*mass, x, v);
        }
        let points = gauss().map(|(place, weight)| (shape(place), weight));
        for (cable, &mass) in self.element_mass[..self.ends.len()].iter().enumerate() {
            for element in 0..self.layout.elements {
                let coordinates = self.of_element(cable, element);
                let x = coordinates.map(|at| Self::value(&knots.position, &inner.position, at));
                let v = coordinates.map(|at| Self::value(&knots.velocity, &inner.velocity, at));
                for (shape, weight) in &points {
                    see(weight * mass, &blend(shape, &x), &blend(shape, &v));
                }
            }
        }
    }

    /// Kinetic energy and momenta of all of it; no elastic energy.
    pub fn motion(&self, knots: &Knots, inner: &Knots) -> NetTotals {
        let mut totals = NetTotals::default();
        self.mass_points(knots, inner, |mass, x, v| {
            totals.kinetic += 0.5 * mass * v.norm_squared();
            totals.momentum += mass * v;
            totals.angular_momentum += mass * x.cross(v);
        });
        totals
    }

    /// Changes the velocities of all coordinates as `kick` changes that of a point at a position with a velocity, which
    /// it does linearly.
    pub fn kick(
        &self,
        knots: &mut Knots,
        inner: &mut Knots,
        kick: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>,
    ) {
        let at_knots: Vec<_> = knots.position.iter().zip(&knots.velocity).map(|(x, v)| kick(x, v)).collect();
        let mut at_own = vec![Vector3::zeros(); inner.position.len()];
        for cable in 0..self.ends.len() {
            for node in 0..=self.layout.elements {
                let [position, slope] = [2 * node, 2 * node + 1].map(|place| self.coordinate(cable, place));
                let x = Self::value(&knots.position, &inner.position, position);
                let v = Self::value(&knots.velocity, &inner.velocity, position);
                let change = kick(&x, &v);
                if let Coordinate::Own(index) = position {
                    at_own[index] = change;
                }
                if let Coordinate::Own(index) = slope {
                    at_own[index] = kick(&(x + inner.position[index]), &(v + inner.velocity[index])) - change;
                }
            }
        }
        for (list, changes) in [(knots, at_knots), (inner, at_own)] {
            for (velocity, change) in list.velocity.iter_mut().zip(changes) {
                *velocity += change;
            }
        }
    }
}

/// Σ Sᵢ qᵢ.
pub fn blend(shape: &[f64; COORDINATES], of: &[Vector3<f64>; COORDINATES]) -> Vector3<f64> {
    shape[0] * of[0] + shape[1] * of[1] + shape[2] * of[2] + shape[3] * of[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn net() -> ElementNet {
        ElementNet {
            layout: NodeList { elements: 2 },
            ends: vec![[0, 1], [1, 2]],
            element_mass: vec![0.3, 0.2],
            own_mass: vec![1.0, 0.0, 0.5],
            answering_mass: Vec::new(),
        }
    }

    fn somewhere(n: usize, phase: f64) -> Knots {
        let vector = |i: usize, phase: f64| {
            let x = i as f64 + phase;
            Vector3::new((1.3 * x).sin(), (2.1 * x).cos(), (0.7 * x).sin())
        };
        Knots {
            position: (0..n).map(|i| vector(i, phase)).collect(),
            velocity: (0..n).map(|i| vector(i, phase + 50.0)).collect(),
        }
    }

    #[test]
    fn a_cable_that_moves_straight_has_the_momentum_of_its_mass() {
        let net = net();
        let knots =
            Knots { position: somewhere(3, 0.0).position, velocity: vec![Vector3::new(1.0, -2.0, 0.5); 3] };
        let totals = net.motion(&knots, &net.straight(&knots));
        let mass = 1.5 + 2.0 * 0.5;
        assert!((totals.momentum - mass * knots.velocity[0]).norm() < 1e-14);
        assert!((totals.kinetic - 0.5 * mass * knots.velocity[0].norm_squared()).abs() < 1e-14);
    }

    /// A folded cable has nothing stretched in it, hangs as deep as said, and its legs keep their length.
    #[test]
    fn a_folded_cable_is_nowhere_longer_than_itself() {
        for elements in 1..=5 {
            let net = ElementNet { layout: NodeList { elements }, ends: vec![[0, 1]], ..net() };
            let across = Vector3::new(0.0, 0.12, 0.16);
            let knots =
                Knots { position: vec![Vector3::zeros(), across], velocity: vec![Vector3::zeros(); 2] };
            // A cable of 1 m between ends 0.2 m apart.
            let (l, n) = (1.0 / elements as f64, elements as f64);
            let fall = (1.0_f64 - 0.04).sqrt() / n;
            let inner = net.folded(&knots, &[-fall * Vector3::x()]);
            let mut length = 0.0;
            for element in 0..elements {
                let nodes = net.of_element(0, element);
                let nodes = nodes.map(|at| ElementNet::value(&knots.position, &inner.position, at));
                for i in 0..=50 {
                    let xi = f64::from(i) / 50.0;
                    let step = 1e-6;
                    let [behind, ahead] = [xi - step, xi + step].map(|xi| blend(&shape(xi), &nodes));
                    let stretch = (ahead - behind).norm() / (2.0 * step) / l;
                    assert!(stretch < 1.0 + 1e-9, "{elements} {element} {xi}: {stretch}");
                }
                length += (nodes[2] - nodes[0]).norm();
            }
            let line = net.line(0, &knots, &inner);
            let deepest = line.iter().map(|x| -x.x).fold(0.0, f64::max);
            let wanted = fall * if elements % 2 == 0 { 0.5 * n - 1.0 / 3.0 } else { 0.5 * (n - 1.0) + 0.25 };
            println!("{elements}: {deepest}, nodes {length}");
            assert!((deepest - wanted).abs() < 1e-9, "{deepest} {wanted}");
            assert!(length > 1.0 - l && length <= 1.0 + 1e-12);
        }
    }

    /// A field linear in place and velocity changes the velocity of every point of an element by its value there.
    #[test]
    fn a_linear_kick_moves_every_point_by_its_own() {
        let net = net();
        let (mut knots, mut inner) = (somewhere(3, 0.0), somewhere(8, 9.0));
        let rate = Vector3::new(0.2, -0.4, 0.7);
        let field =
            |x: &Vector3<f64>, v: &Vector3<f64>| Vector3::x() + rate.cross(v) + rate.cross(&rate.cross(x));
        let points = |knots: &Knots, inner: &Knots| {
            let mut all = Vec::new();
            net.mass_points(knots, inner, |_, x, v| all.push((*x, *v)));
            all
        };
        let before = points(&knots, &inner);
        net.kick(&mut knots, &mut inner, field);
        for ((x, v), (_, after)) in before.iter().zip(points(&knots, &inner)) {
            assert!((after - v - field(x, v)).norm() < 1e-14);
        }
    }
}
