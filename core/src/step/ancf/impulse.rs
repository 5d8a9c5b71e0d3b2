//! Impulses on the coordinates: v += M⁻¹ Σ S J, by the same factorised mass matrix as forces.

use nalgebra::Vector3;
use pulp::NullaryFnOnce;

use super::element::COORDINATES;
use super::kernel::AncfNet;

impl AncfNet {
    /// Forgets all forces: those of impulses follow.
    pub fn begin_impulses(&mut self) {
        for coordinates in self.places.iter_mut().chain([&mut self.knots]) {
            coordinates.force.iter_mut().for_each(|axis| axis.fill(0.0));
        }
    }

    /// Adds an impulse on a knot [N s].
    pub fn add_impulse(&mut self, knot: usize, impulse: &Vector3<f64>) {
        for axis in 0..3 {
            self.knots.force[axis][knot] += impulse[axis];
        }
    }

    /// Adds one on a place of an element, Q = S(ξ) J (Eq. 4.31).
    pub fn add_impulse_along(
        &mut self,
        cable: usize,
        element: usize,
        shape: &[f64; COORDINATES],
        impulse: &Vector3<f64>,
    ) {
        for (place, weight) in self.places[2 * element..2 * element + COORDINATES].iter_mut().zip(shape) {
            for axis in 0..3 {
                place.force[axis][cable] += weight * impulse[axis];
            }
        }
    }

    /// Changes all velocities by the impulses so far.
    pub fn answer_impulses(&mut self) {
        self.arch.dispatch(Answer { net: self });
    }
}

/// For the widest vectors of the processor.
struct Answer<'a> {
    net: &'a mut AncfNet,
}

impl NullaryFnOnce for Answer<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for axis in 0..3 {
            self.net.accelerate(axis);
        }
        self.net.speed_up(1.0);
    }
}
