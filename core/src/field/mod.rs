//! Fields: what gravity and a turning frame do to everything that is free.
//!
//! The local frame may be one of an orbit or of a cabin: it turns at Ω about a point c, whose own
//! acceleration is in g. A free knot at r with velocity v then follows
//!
//! v̇ = g(r, t) − 2 Ω × v − Ω × (Ω × (r − c)) − Ω̇ × (r − c)
//!
//! and a free body of inertia I (in the local frame) with the rate ω relative to that frame
//!
//! I ω̇ + ω × I ω = τ − ((tr I) Ω − 2 I Ω) × ω − Ω × I Ω − I Ω̇,
//!
//! with τ the torque of the gravity gradient: the second equation is the first, summed over the
//! body's mass. The terms in v and ω do no work. The others, for a steady field, are the gradient of
//!
//! Φ = m φ(r) − ½ m |Ω × (r − c)|² + φ_τ − ½ Ω · I Ω,
//!
//! so that kinetic energy + Φ (the Jacobi integral) is kept.
//!
//! # Integration
//!
//! Half a kick, the whole step of the method without the field, half a kick. A kick leaves positions
//! alone and takes the terms in v and ω at the mean of before and after (Cayley's form, as Boris
//! does for a magnetic force), so they do no work to rounding, whatever the step. Euler's term is
//! taken as the change of Ω over the span, at the very start and at the very end of the step: so a
//! jump between two steps, over which Ω × v must not be averaged, is exact. The whole is symmetric,
//! hence of second order: relative errors of (Ω h)² / 12, 1e-8 at 0.3 rad/s and 0.5 ms. A force
//! frozen over the step would be of first order, lag by half a sub-step, and gain energy by −2 Ω × v.
//!
//! Limits: fields are felt at knots, along cables with mass of their own, and at centres of mass; over a body they vary by their gradient
//! (torque), not beyond (relative error: its size over the orbit's radius).

pub mod orbit;
pub mod profile;

use nalgebra::{Matrix3, Vector3};

use crate::interaction::Half;
use crate::state::{Body, EffectWork, State};

/// What the frame does at any time.
pub trait Field: Send {
    /// At `time` [s].
    fn at(&self, time: f64) -> Frame;

    /// From `start` to `end` [s].
    fn over(&self, start: f64, end: f64) -> Span;
}

/// A frame and the gravity within, at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Angular velocity Ω [rad/s].
    pub rate: Vector3<f64>,
    /// Where the gravity is felt undisturbed by the turn, c [m].
    pub centre: Vector3<f64>,
    /// Gravity, less the acceleration of c.
    pub gravity: Gravity,
}

/// A frame over a span of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Its length [s].
    pub length: f64,
    /// The frame in its mean.
    pub mean: Frame,
    /// Change of Ω from its start to its end [rad/s].
    pub rate_change: Vector3<f64>,
}

/// Gravity in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gravity {
    /// The same everywhere [m/s^2].
    Uniform(Vector3<f64>),
    /// That of a distant centre, less that at the origin, which falls freely.
    Tidal {
        /// μ / R³ [1/s^2].
        strength: f64,
        /// From the attracting centre to the origin, R [m].
        radius: Vector3<f64>,
    },
}

impl Gravity {
    /// Acceleration at `position` [m/s^2].
    ///
    /// Tidal: −μ (R + r) / |R + r|³ + μ R / |R|³, without the cancellation of twelve digits that
    /// this form suffers (Encke): with q = r · (r + 2 R) / R² and s = √(1 + q),
    ///
    /// −(μ / R³) (r − (s³ − 1) R) / s³,  s³ − 1 = q (3 + 3 q + q²) / (1 + s³)
    fn acceleration(&self, position: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Gravity::Uniform(gravity) => *gravity,
            Gravity::Tidal { strength, radius } => {
                let (q, s) = encke(position, radius);
                let cube = s * s * s;
                let grown = q * (3.0 + q * (3.0 + q)) / (1.0 + cube);
                -(strength / cube) * (position - grown * radius)
            }
        }
    }

    /// Potential of a unit mass [J/kg], zero at the origin.
    ///
    /// Tidal: −μ (1 / |R + r| − 1 / R + R · r / R³) = −(μ / R³) (R² (s − 1)² (s + 2) / (2 s) − r² / 2).
    fn potential(&self, position: &Vector3<f64>) -> f64 {
        match self {
            Gravity::Uniform(gravity) => -gravity.dot(position),
            Gravity::Tidal { strength, radius } => {
                let (q, s) = encke(position, radius);
                let less_one = q / (1.0 + s);
                let drop = less_one * less_one * (s + 2.0) / (2.0 * s);
                -strength * (radius.norm_squared() * drop - 0.5 * position.norm_squared())
            }
        }
    }

    /// Torque of its gradient on a body of `inertia` (local frame) at `position` [N m]:
    /// 3 μ / |R + r|³ n × I n with n along R + r.
    fn torque(&self, position: &Vector3<f64>, inertia: &Matrix3<f64>) -> Vector3<f64> {
        match self {
            Gravity::Uniform(_) => Vector3::zeros(),
            Gravity::Tidal { strength, radius } => {
                let (_, s) = encke(position, radius);
                let n = (radius + position).normalize();
                3.0 * strength / (s * s * s) * n.cross(&(inertia * n))
            }
        }
    }

    /// Energy of that torque [J]: (3 n · I n − tr I) μ / (2 |R + r|³).
    fn torque_potential(&self, position: &Vector3<f64>, inertia: &Matrix3<f64>) -> f64 {
        match self {
            Gravity::Uniform(_) => 0.0,
            Gravity::Tidal { strength, radius } => {
                let (_, s) = encke(position, radius);
                let n = (radius + position).normalize();
                0.5 * strength / (s * s * s) * (3.0 * n.dot(&(inertia * n)) - inertia.trace())
            }
        }
    }
}

/// q and s of Encke's form.
fn encke(position: &Vector3<f64>, radius: &Vector3<f64>) -> (f64, f64) {
    let q = position.dot(&(position + 2.0 * radius)) / radius.norm_squared();
    (q, (1.0 + q).sqrt())
}

impl Frame {
    /// Acceleration of a knot at rest at `position` [m/s^2], without Euler's term.
    pub fn acceleration(&self, position: &Vector3<f64>) -> Vector3<f64> {
        let arm = position - self.centre;
        self.gravity.acceleration(position) - self.rate.cross(&self.rate.cross(&arm))
    }

    /// Φ of a unit mass at `position` [J/kg].
    pub fn potential(&self, position: &Vector3<f64>) -> f64 {
        let arm = position - self.centre;
        self.gravity.potential(position) - 0.5 * self.rate.cross(&arm).norm_squared()
    }

    /// Torque on a body at rest, of `inertia` in the local frame [N m], without Euler's term.
    pub fn torque(&self, position: &Vector3<f64>, inertia: &Matrix3<f64>) -> Vector3<f64> {
        self.gravity.torque(position, inertia) - self.rate.cross(&(inertia * self.rate))
    }

    /// Φ of a body [J]; `inertia` in the local frame.
    pub fn potential_of_body(&self, position: &Vector3<f64>, mass: f64, inertia: &Matrix3<f64>) -> f64 {
        mass * self.potential(position) + self.gravity.torque_potential(position, inertia)
            - 0.5 * self.rate.dot(&(inertia * self.rate))
    }
}

impl Span {
    /// Change of the velocity of a knot [m/s].
    pub fn kick(&self, half: Half, position: &Vector3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
        let jump = -self.rate_change.cross(&(position - self.mean.centre));
        jump + match half {
            Half::First => self.push(position, &(velocity + jump)),
            Half::Second => self.push(position, velocity),
        }
    }

    /// The same without Euler's term.
    ///
    /// With τ the length, b = τ a(r) − 2 τ Ω × v and s = τ Ω:
    /// Δv + s × Δv = b, that is Δv = (b + (s · b) s − s × b) / (1 + s²).
    fn push(&self, position: &Vector3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
        let s = self.length * self.mean.rate;
        let b = self.length * self.mean.acceleration(position) - 2.0 * s.cross(velocity);
        (b + s.dot(&b) * s - s.cross(&b)) / (1.0 + s.norm_squared())
    }

    /// Change of the rate of a body [rad/s]; `inertia` in the local frame.
    pub fn twist(&self, half: Half, body: &Body, inertia: &Matrix3<f64>) -> Vector3<f64> {
        let jump = -self.rate_change;
        jump + match half {
            Half::First => self.turn(body, &(body.rate + jump), inertia),
            Half::Second => self.turn(body, &body.rate, inertia),
        }
    }

    /// The same without Euler's term.
    ///
    /// With κ = (tr I) Ω − 2 I Ω: (I + ½ τ [κ×]) Δω = τ T − τ κ × ω.
    fn turn(&self, body: &Body, rate: &Vector3<f64>, inertia: &Matrix3<f64>) -> Vector3<f64> {
        let kappa = inertia.trace() * self.mean.rate - 2.0 * inertia * self.mean.rate;
        let b = self.length * (self.mean.torque(&body.position, inertia) - kappa.cross(rate));
        let matrix = inertia + 0.5 * self.length * kappa.cross_matrix();
        // Its symmetric part is the inertia, which is positive definite.
        matrix.lu().solve(&b).unwrap_or_default()
    }
}

/// Kicks all knots, of the masses `net_mass` [kg], and free bodies of `state`; returns the work and the impulses.
pub fn kick(span: &Span, half: Half, state: &mut State, net_mass: &[f64]) -> EffectWork {
    let mut posting = EffectWork::default();
    if state.elements.is_some() {
        posting = kick_elements(span, half, state);
    } else {
        kick_knots(span, half, state, net_mass, &mut posting);
    }
    for (model, body) in state.each_body_mut().filter(|(model, _)| model.is_free()) {
        let inertia = in_local_frame(body, model.inertia());
        let change = span.kick(half, &body.position, &body.velocity);
        let impulse = model.mass * change;
        let turn = span.twist(half, body, &inertia);
        let moment = inertia * turn;
        posting.work += impulse.dot(&(body.velocity + 0.5 * change)) + moment.dot(&(body.rate + 0.5 * turn));
        posting.impulse += impulse;
        posting.angular_impulse += body.position.cross(&impulse) + moment;
        body.velocity += change;
        body.rate += turn;
    }
    posting
}

/// Kicks elements as a whole. The field is linear over a net but for 1e-6 of a tide's.
fn kick_elements(span: &Span, half: Half, state: &mut State) -> EffectWork {
    let Some(elements) = state.elements.clone() else { return EffectWork::default() };
    let before = elements.motion(&state.knots, &state.inner);
    elements.kick(&mut state.knots, &mut state.inner, |x, v| span.kick(half, x, v));
    state.renew_totals();
    let after = elements.motion(&state.knots, &state.inner);
    EffectWork {
        work: after.kinetic - before.kinetic,
        impulse: after.momentum - before.momentum,
        angular_impulse: after.angular_momentum - before.angular_momentum,
        ..EffectWork::default()
    }
}

fn kick_knots(span: &Span, half: Half, state: &mut State, net_mass: &[f64], posting: &mut EffectWork) {
    let knots = &mut state.knots;
    for ((position, velocity), mass) in knots.position.iter().zip(&mut knots.velocity).zip(net_mass) {
        let change = span.kick(half, position, velocity);
        let impulse = *mass * change;
        posting.work += impulse.dot(&(*velocity + 0.5 * change));
        posting.impulse += impulse;
        posting.angular_impulse += position.cross(&impulse);
        *velocity += change;
    }
}

/// Energy Φ of all knots, of the masses `net_mass` [kg], and free bodies of `state` [J].
pub fn stored_energy(frame: &Frame, state: &State, net_mass: &[f64]) -> f64 {
    let mut energy = match &state.elements {
        Some(elements) => {
            let mut energy = 0.0;
            elements
                .mass_points(&state.knots, &state.inner, |mass, x, _| energy += mass * frame.potential(x));
            energy
        }
        None => {
            let knots = state.knots.position.iter().zip(net_mass);
            knots.map(|(position, mass)| mass * frame.potential(position)).sum()
        }
    };
    for (model, body) in state.each_body().filter(|(model, _)| model.is_free()) {
        let inertia = in_local_frame(body, model.inertia());
        energy += frame.potential_of_body(&body.position, model.mass, &inertia);
    }
    energy
}

/// Inertia of the body frame, turned to the local frame.
fn in_local_frame(body: &Body, inertia: &Matrix3<f64>) -> Matrix3<f64> {
    let turn = body.attitude.to_rotation_matrix();
    turn.matrix() * inertia * turn.matrix().transpose()
}
