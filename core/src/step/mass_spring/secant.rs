//! The explicit net's own integrator: a force that is the difference of stored energy, and books for every cable.
//!
//! Over a step of h a cable that goes from length r₀ to r₁, stretched by s = max(0, r − l₀), gives
//!
//! T = max(0, (k (s₁² − s₀²) / 2 + c (s₁ − s₀) (r₁ − r₀) / h) / (r₁ − r₀)),
//!
//! along (d₀ + d₁) / (r₀ + r₁), with d the vector between its ends: Eq. 3.3 with the difference of stored
//! energy for its spring, and the dashpot for that share of the step in which it is taut. So the work −T (r₁ − r₀) is right to the last digit
//! wherever within the step the cable goes taut or slack. (Gonzalez 1996 names such forces discrete
//! gradients.) An explicit step knows only where its knots would go without it: it takes d₁ = d₀ + h u₀.
//! Velocities change by h F / m, positions by the mean of both velocities: in the linear range leapfrog,
//! stable as semi-implicit Euler is.
//!
//! What the step errs in is then known, cable by cable: the work that the law asks for over the path that
//! was in fact taken, less the work that was done. Each cable keeps that sum as its debt δ and pays it
//! back by the further force δ Δ / (Δ² + (|δ| + ε) h² β / mₑ), Δ = r₁ − r₀: the whole debt where the ends
//! move fast enough, and never so much that it turns their motion around. Debts are forces along a
//! cable: momentum and angular momentum are kept. A step after which debts have grown too much is
//! taken back and done again in two; parts grow again by an eighth.
//!
//! Energy made or lost, of 10 x 10 meshes of Table 3.2 over 1 s, over the launch energy (the damping
//! ratio, the energy that semi-implicit Euler makes or loses, this method's, its parts per step): 0, 3e-2, 3e-4, 1.9;
//! 0.003, 4e-2, 3e-4, 1.7; 0.1, 2e-2, 3e-4, 1.02; 5, -, 2e-4, 1.0. Bullets at 0.5 s and damping 0.1 are 2e-4 to 4e-4 m off.
//!
//! This holds for a net in flight. From the first contact or thread on the net is integrated by semi-implicit
//! Euler, see [`ExplicitNet::drift`](super::kernel::ExplicitNet::drift), until it has come away from its target, see
//! [`ExplicitNet::fly_again`](super::kernel::ExplicitNet::fly_again).
//!
//! Forces of the lines along Y and of those along Z are added up apart: a net that mirrors itself then does so
//! to the last bit.

use pulp::{Arch, NullaryFnOnce};

use super::kernel::{CableRun, CableRuns, Components, slices};
use crate::cable::{Cable, stored_between, taut_force, work_by_law};

/// β: how much of the motion of its ends a cable's debt may take.
const GENTLE: f64 = 2.0;

/// Growth of all debts within a part that has to do, over the largest energy that the net has had.
const TOLERANCE: f64 = 1e-4;

/// ε over that energy: smaller debts are paid in proportion. A force that goes with the root of a debt would
/// make rounding errors visible.
const LINEAR: f64 = 1e-8;

/// Debts over that energy that are forgiven, so that a cable comes to rest.
const FORGIVEN: f64 = 1e-11;

/// Most parts of a step.
const MOST: u32 = 256;

/// Cables that are looked at together, and passed over while none of them is taut.
const CHUNK: usize = 16;

/// What the integrator keeps from part to part.
pub struct Secant {
    now: Books,
    next: Books,
    position: Components,
    velocity: Components,
    /// Force on the first end [N].
    pull: Components,
    /// Tension of the law, without the payment of debts [N].
    law: Vec<f64>,
    /// Whether any cable of each chunk may act, in the order of runs and chunks.
    active: Vec<bool>,
    /// Forces of the lines along Y and of those along Z [N].
    force: [Components; 2],
    last: Last,
    parts: u32,
    /// Largest energy of the net so far [J].
    scale: f64,
    /// Taken by the cables' dashpots since it was last asked for [J].
    pub dissipated: f64,
    /// Parts taken since the start, those taken back among them.
    pub n_parts: u64,
    stale: bool,
}

/// Every cable's vector between its ends [m], its length [m] and its debt [J].
#[derive(Default)]
struct Books {
    across: Components,
    length: Vec<f64>,
    debt: Vec<f64>,
}

impl Books {
    /// Enters vectors and lengths of the cables of `run`, whose knots are at `position`.
    #[inline(always)]
    fn measure(&mut self, run: &CableRun, position: &Components) {
        let &CableRun { first, length: n, a, b, .. } = run;
        let ([xa, ya, za], [xb, yb, zb]) = (slices(position, a, n), slices(position, b, n));
        // In memory of its own first: the loop is one of wide vectors where nothing may overlap.
        let mut found = [[0.0; CHUNK]; 4];
        let [dx, dy, dz, length] = &mut found;
        let (dx, dy, dz, length) = (&mut dx[..n], &mut dy[..n], &mut dz[..n], &mut length[..n]);
        for i in 0..n {
            (dx[i], dy[i], dz[i]) = (xb[i] - xa[i], yb[i] - ya[i], zb[i] - za[i]);
            length[i] = squared([dx[i], dy[i], dz[i]]).sqrt();
        }
        for (across, found) in self.across.iter_mut().zip([&*dx, &*dy, &*dz]) {
            across[first..first + n].copy_from_slice(found);
        }
        self.length[first..first + n].copy_from_slice(length);
    }
}

impl Secant {
    pub(super) fn new(strands: &CableRuns, n_knots: usize) -> Secant {
        let n_cables = strands.stiffness.len();
        let knots = || [(); 3].map(|()| vec![0.0; n_knots]);
        let cables = || [(); 3].map(|()| vec![0.0; n_cables]);
        let books = || Books { across: cables(), length: vec![0.0; n_cables], debt: vec![0.0; n_cables] };
        let n_chunks = strands.runs.iter().map(|run| run.length.div_ceil(CHUNK)).sum();
        Secant {
            now: books(),
            next: books(),
            position: knots(),
            velocity: knots(),
            pull: cables(),
            law: vec![0.0; n_cables],
            active: vec![false; n_chunks],
            force: [knots(), knots()],
            last: Last::default(),
            parts: 1,
            scale: 0.0,
            dissipated: 0.0,
            n_parts: 0,
            stale: true,
        }
    }

    /// Takes note that knots were moved other than by their own velocities.
    pub fn displace(&mut self) {
        self.stale = true;
    }

    /// Takes in the kinetic energy of the net [J].
    pub fn observe_kinetic(&mut self, kinetic: f64) {
        self.scale = self.scale.max(kinetic);
    }

    /// The sub-step of `step` seconds; leaves in `position` what a drift at `velocity` takes to its end.
    pub(super) fn kick(
        &mut self,
        arch: &Arch,
        step: f64,
        strands: &mut CableRuns,
        [position, velocity]: [&mut Components; 2],
        inverse_mass: &[f64],
        push: &Components,
    ) {
        if self.stale {
            self.begin(strands, position);
        }
        let mut left = step;
        while left > 1e-9 * step {
            let part = (step / f64::from(self.parts)).min(left);
            self.n_parts += 1;
            let outcome = arch.dispatch(SecantPart {
                secant: self,
                strands,
                position,
                velocity,
                inverse_mass,
                push,
                step: part,
            });
            if outcome.debts - self.last.debts > TOLERANCE * self.scale && self.parts < MOST {
                self.parts *= 2;
                continue;
            }
            self.dissipated += outcome.dissipated;
            self.last = outcome;
            std::mem::swap(position, &mut self.position);
            std::mem::swap(velocity, &mut self.velocity);
            std::mem::swap(&mut self.now, &mut self.next);
            for (largest, law) in strands.tension.iter_mut().zip(&self.law) {
                *largest = largest.max(*law);
            }
            left -= part;
        }
        if self.parts > 1 {
            self.parts -= (self.parts / 8).max(1);
        }
        for (x, v) in position.iter_mut().zip(&*velocity) {
            for (x, v) in x.iter_mut().zip(v) {
                *x -= step * v;
            }
        }
    }

    /// Vectors and lengths at the start, where nothing is owed.
    fn begin(&mut self, strands: &CableRuns, position: &Components) {
        for run in &strands.runs {
            for start in (0..run.length).step_by(CHUNK) {
                self.now.measure(&run.piece(start, CHUNK), position);
            }
        }
        self.now.debt.fill(0.0);
        self.last = Last::default();
        self.stale = false;
    }
}

/// x² + (y² + z²): the same when y and z change places.
#[inline(always)]
fn squared([x, y, z]: [f64; 3]) -> f64 {
    x * x + (y * y + z * z)
}

/// What a part of a sub-step came to.
#[derive(Default)]
struct Last {
    /// Sum of the sizes of all debts at its end [J].
    debts: f64,
    /// Taken by the dashpots in it [J].
    dissipated: f64,
}

/// A part of a sub-step, for the widest vectors of the processor.
struct SecantPart<'a> {
    secant: &'a mut Secant,
    strands: &'a CableRuns,
    position: &'a Components,
    velocity: &'a Components,
    inverse_mass: &'a [f64],
    push: &'a Components,
    step: f64,
}

impl NullaryFnOnce for SecantPart<'_> {
    type Output = Last;

    #[inline(always)]
    fn call(self) -> Last {
        let SecantPart { secant, strands, position, velocity, inverse_mass, push, step } = self;
        for force in secant.force.iter_mut().flatten() {
            force.fill(0.0);
        }
        let mut chunk = 0;
        for run in &strands.runs {
            for start in (0..run.length).step_by(CHUNK) {
                let piece = run.piece(start, CHUNK);
                secant.active[chunk] = secant.pull(&piece, strands, velocity, step);
                chunk += 1;
            }
        }
        for axis in 0..3 {
            let knots = position[axis].iter().zip(&velocity[axis]).zip(inverse_mass.iter().zip(&push[axis]));
            let forces = secant.force[0][axis].iter().zip(&secant.force[1][axis]);
            let ends = secant.position[axis].iter_mut().zip(&mut secant.velocity[axis]);
            for (((x1, v1), (fy, fz)), ((x, v), (im, push))) in ends.zip(forces).zip(knots) {
                *v1 = v + step * ((fy + fz) * im + push);
                *x1 = x + 0.5 * step * (v + *v1);
            }
        }
        secant.settle_all(strands, step)
    }
}

#[inline(always)]
fn slices_mut(of: &mut Components, start: usize, length: usize) -> [&mut [f64]; 3] {
    let [x, y, z] = of;
    [&mut x[start..start + length], &mut y[start..start + length], &mut z[start..start + length]]
}

impl Secant {
    /// Forces of the cables of `run` over the coming part; whether any of them acts.
    #[inline(always)]
    fn pull(&mut self, run: &CableRun, strands: &CableRuns, velocity: &Components, step: f64) -> bool {
        let &CableRun { first, length: n, a, b, family } = run;
        let cables = first..first + n;
        let [ua, va, wa] = slices(velocity, a, n);
        let [ub, vb, wb] = slices(velocity, b, n);
        let [dx, dy, dz] = slices(&self.now.across, first, n);
        let rest_length = &strands.rest_length[cables.clone()];
        let length = &self.now.length[cables.clone()];
        let debt = &self.now.debt[cables.clone()];
        let mut ends = [[0.0; CHUNK]; 4];
        let [ex, ey, ez, end] = &mut ends;
        let (ex, ey, ez, end) = (&mut ex[..n], &mut ey[..n], &mut ez[..n], &mut end[..n]);
        let mut acting = [0.0_f64; CHUNK];
        let acting = &mut acting[..n];
        for i in 0..n {
            ex[i] = dx[i] + step * (ub[i] - ua[i]);
            ey[i] = dy[i] + step * (vb[i] - va[i]);
            ez[i] = dz[i] + step * (wb[i] - wa[i]);
            end[i] = ex[i] * ex[i] + (ey[i] * ey[i] + ez[i] * ez[i]);
            let taut = end[i] > rest_length[i] * rest_length[i] || length[i] > rest_length[i];
            acting[i] = if taut { 1.0 } else { debt[i].abs() };
        }
        let law = &mut self.law[cables.clone()];
        if acting.iter().all(|acts| *acts == 0.0) {
            law.fill(0.0);
            return false;
        }
        let [px, py, pz] = slices_mut(&mut self.pull, first, n);
        let (stiffness, damping) = (&strands.stiffness[cables.clone()], &strands.damping[cables.clone()]);
        let gentle = &strands.gentle[cables];
        // Not 0 where nothing has moved yet, or rest over rest would be no number.
        let floor = LINEAR * self.scale + 1e-30;
        let over_step = 1.0 / step;
        for i in 0..n {
            let r1 = end[i].sqrt();
            let change = r1 - length[i];
            let s0 = (length[i] - rest_length[i]).max(0.0);
            let s1 = (r1 - rest_length[i]).max(0.0);
            let moves = change.abs() > 1e-14 * r1;
            let always = if s0 > 0.0 { 1.0 } else { 0.0 };
            let share = if moves { (s1 - s0) / change } else { always };
            let mean = taut_force(stiffness[i], damping[i], 0.5 * (s0 + s1), change, over_step);
            let tension = (share * mean).max(0.0);
            let room = change * change + (debt[i].abs() + floor) * step * step * gentle[i];
            // Knots at one place have no direction, and nothing to pull along it.
            let along = (tension + debt[i] * change / room) / (length[i] + r1).max(f64::MIN_POSITIVE);
            law[i] = tension;
            px[i] = along * (dx[i] + ex[i]);
            py[i] = along * (dy[i] + ey[i]);
            pz[i] = along * (dz[i] + ez[i]);
        }
        for (forces, pull) in self.force[family].iter_mut().zip([&*px, &*py, &*pz]) {
            for (f, p) in forces[a..a + n].iter_mut().zip(pull) {
                *f += p;
            }
            for (f, p) in forces[b..b + n].iter_mut().zip(pull) {
                *f -= p;
            }
        }
        true
    }

    /// Books a part of `step` seconds that ended at `position`.
    #[inline(always)]
    fn settle_all(&mut self, strands: &CableRuns, step: f64) -> Last {
        let (mut debts, mut dissipated) = ([0.0; CHUNK], [0.0; CHUNK]);
        let mut chunk = 0;
        for run in &strands.runs {
            for start in (0..run.length).step_by(CHUNK) {
                let piece = run.piece(start, CHUNK);
                let active = self.active[chunk];
                self.close_part(&piece, strands, step, active, &mut debts, &mut dissipated);
                chunk += 1;
            }
        }
        Last { debts: debts.iter().sum(), dissipated: dissipated.iter().sum() }
    }

    /// Books the part for the cables of `run`: where their ends went, what they owe, what they took.
    #[inline(always)]
    fn close_part(
        &mut self,
        run: &CableRun,
        strands: &CableRuns,
        step: f64,
        active: bool,
        debts: &mut [f64; CHUNK],
        dissipated: &mut [f64; CHUNK],
    ) {
        let &CableRun { first, length: n, .. } = run;
        let cables = first..first + n;
        self.next.measure(run, &self.position);
        let [ex, ey, ez] = slices(&self.next.across, first, n);
        let end = &self.next.length[cables.clone()];
        let rest_length = &strands.rest_length[cables.clone()];
        let owed = &mut self.next.debt[cables.clone()];
        let (debt, length) = (&self.now.debt[cables.clone()], &self.now.length[cables.clone()]);
        // Neighbours may have pulled a resting cable taut.
        if !active && end.iter().zip(rest_length).all(|(end, rest)| *end <= *rest) {
            owed.fill(0.0);
            return;
        }
        let [px, py, pz] = slices(&self.pull, first, n);
        let [dx, dy, dz] = slices(&self.now.across, first, n);
        let (stiffness, damping) = (&strands.stiffness[cables.clone()], &strands.damping[cables]);
        let over_step = 1.0 / step;
        let forgiven = FORGIVEN * self.scale;
        let acted = if active { 1.0 } else { 0.0 };
        for i in 0..n {
            let change = end[i] - length[i];
            let s0 = (length[i] - rest_length[i]).max(0.0);
            let s1 = (end[i] - rest_length[i]).max(0.0);
            let stored = stored_between(stiffness[i], s0, s1);
            let asked = work_by_law(stiffness[i], damping[i], [s0, s1], change, over_step);
            let done = px[i] * (ex[i] - dx[i]) + (py[i] * (ey[i] - dy[i]) + pz[i] * (ez[i] - dz[i]));
            let owes = debt[i] + asked - acted * done;
            let owes = if owes.abs() > forgiven { owes } else { 0.0 };
            owed[i] = owes;
            debts[i] += owes.abs();
            dissipated[i] += asked - stored;
        }
    }
}

/// β / mₑ of a cable, which its debt is weighed by [1/kg].
pub(super) fn gentleness(cable: &Cable) -> f64 {
    GENTLE / cable.reduced_mass
}
