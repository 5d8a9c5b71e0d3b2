//! Work of a contact's impulses within a step.

use nalgebra::Vector3;

use crate::state::{Contact, Knots};

/// Impulses of a contact within a step, and the work of the target's surface against them.
///
/// Work on the net is impulse times the mean of a knot's velocity before and after the sub-step: with all
/// impulses of the sub-step so weighed, cables' among them, it is exactly the change of kinetic energy.
/// Over single kicks it would count as lost whatever cables press into a contact at rest; over the whole of a step
/// what knots give back and forth within it would count as of the wrong one of the two, and undamped explicit cables
/// seemed to take a tenth of the launch energy. Forces, after which rows of effects act, are weighed at the end of the sub-step; where
/// the engine moves the cables after contacts the whole step it is. The target, which contacts alone move, is weighed kick by kick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactWork {
    /// Along the normals [N s].
    along: Vector3<f64>,
    /// Across them [N s].
    across: Vector3<f64>,
    /// Work of both that the surface gives [J].
    from_surface: [f64; 2],
    /// Work of both on the net [J], where it is known sub-step by sub-step.
    on_net: Option<[f64; 2]>,
}

impl ContactWork {
    /// Adds impulses on the net along and across the normal, while the surface has the mean velocity `surface` [m/s].
    pub fn add(&mut self, along: &Vector3<f64>, across: &Vector3<f64>, surface: &Vector3<f64>) {
        self.along += along;
        self.across += across;
        self.from_surface[0] += along.dot(surface);
        self.from_surface[1] += across.dot(surface);
    }

    /// Adds the work of such impulses on the net, which has the mean velocity `net` over the sub-step [m/s].
    pub fn weigh(&mut self, along: &Vector3<f64>, across: &Vector3<f64>, net: &Vector3<f64>) {
        let on_net = self.on_net.get_or_insert_default();
        on_net[0] += along.dot(net);
        on_net[1] += across.dot(net);
    }

    /// Direction and length of the impulses along the normals together [-, N s]; none of what is too small to be squared, as an
    /// impulse is that every sub-step left a share of.
    pub fn mean_normal(&self) -> Option<(Vector3<f64>, f64)> {
        let squared = self.along.norm_squared();
        squared.is_normal().then(|| (self.along / squared.sqrt(), squared.sqrt()))
    }

    /// Writes work and losses within a step from `before` to `after` to `contact`.
    pub fn write_to(&self, contact: &mut Contact, before: &Knots, after: &Knots) {
        let [along, across] = self.on_net.unwrap_or_else(|| {
            let mean = 0.5 * (contact.at_place(&before.velocity) + contact.at_place(&after.velocity));
            [self.along.dot(&mean), self.across.dot(&mean)]
        });
        contact.work_on_knot = along + across;
        contact.loss = self.from_surface[0] - along;
        contact.friction_loss = self.from_surface[1] - across;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::vector;

    use super::*;

    #[test]
    fn impulses_have_a_mean_direction_where_their_squares_are_numbers() {
        let of = |size: f64| {
            let mut work = ContactWork::default();
            work.add(&vector![0.6 * size, 0.0, 0.8 * size], &Vector3::zeros(), &Vector3::zeros());
            work.mean_normal()
        };
        for size in [1e-150, 1e-9, 1.0] {
            let Some((normal, length)) = of(size) else { panic!("{size:e} N s have a direction") };
            assert!((normal - vector![0.6, 0.0, 0.8]).norm() < 1e-12 && (length / size - 1.0).abs() < 1e-12);
        }
        // Lengths of 0 and of half the digits once gave directions that are no numbers, and no unit vectors.
        for size in [0.0, 1e-185, 1e-161] {
            assert_eq!(of(size), None, "{size:e} N s");
        }
    }
}
