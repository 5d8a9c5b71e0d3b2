//! What a simulation is told between two steps: winches, and thrust on target and chaser.
//!
//! A key that is given replaces what was told before, others stay. Thrust is a force and a torque that hold until they
//! are told anew; in the body frame they turn with the body.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Vector3;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use tumblenet::case::Case;
use tumblenet::interaction::{ForceElement, Interaction};
use tumblenet::problems::{Problems, did_you_mean, join};
use tumblenet::state::{Body, Forces, State, WinchCommand, Wrench};
use tumblenet::target::spec::Motion;

use crate::errors;

/// A thruster's force and torque on a body.
#[derive(Clone, Copy, Default)]
struct Push {
    wrench: Wrench,
    in_body: bool,
}

impl Push {
    /// In the local frame, for `body` as it is turned now.
    fn on(&self, body: &Body) -> Wrench {
        let turned = |vector| if self.in_body { body.attitude * vector } else { vector };
        Wrench { force: turned(self.wrench.force), torque: turned(self.wrench.torque) }
    }
}

/// On both bodies.
#[derive(Clone, Copy, Default)]
struct Pushes {
    target: Push,
    chaser: Push,
}

/// What thrusters do now, told by one and applied by the other.
#[derive(Clone, Default)]
pub struct Thrust(Arc<Mutex<Pushes>>);

impl Thrust {
    /// The effect that applies it.
    pub fn effect(&self) -> Interaction {
        Interaction::force("thrust", "force and torque on target and chaser, told step by step", self.clone())
    }

    fn told(&self) -> Pushes {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, pushes: Pushes) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = pushes;
    }
}

impl ForceElement for Thrust {
    fn add_forces(&mut self, state: &State, forces: &mut Forces) {
        let pushes = self.told();
        for (name, push) in [("target", &pushes.target), ("chaser", &pushes.chaser)] {
            if let Some(index) = state.find_body(name) {
                forces.on_bodies[index] += push.on(&state.bodies[index]);
            }
        }
    }
}

/// What a scene and its simulation can be told.
#[derive(Clone, Copy)]
pub struct Told {
    has_winch: bool,
    target: Result<(), &'static str>,
    chaser: Result<(), &'static str>,
}

/// What numbers of winches may be.
const NUMBER: &str = "a number of at least 0";

/// Where thrust is allowed.
const CLOSED: &str = "a simulation that thrusters belong to: Simulation(scene, thrust=True)";

impl Told {
    /// What a simulation of `case` can be told, `with_thrust` or without.
    pub fn of(case: &Case, with_thrust: bool) -> Told {
        let effects = &case.scene().effects;
        let is_free = case.target().is_some_and(|target| target.motion == Motion::Free);
        let allowed = |is_there: bool, what| match (with_thrust, is_there) {
            (false, _) => Err(CLOSED),
            (true, false) => Err(what),
            (true, true) => Ok(()),
        };
        Told {
            has_winch: effects.closing.is_some(),
            target: allowed(is_free, "a scene with a free target"),
            chaser: allowed(effects.chaser.is_some(), "a scene with a free chaser (effects.chaser)"),
        }
    }

    /// Takes over `controls`, all of them or none.
    ///
    /// # Errors
    /// Every fault at once.
    pub fn take(&self, controls: &Bound<'_, PyAny>, thrust: &Thrust, state: &mut State) -> PyResult<()> {
        let mut reader = Reader { problems: Problems::new("controls") };
        let (mut winch, mut pushes) = (state.winch, thrust.told());
        for (key, value) in reader.entries(controls, "", &["winch", "target", "chaser"])? {
            match key.as_str() {
                "winch" if !self.has_winch => {
                    reader.fault("winch", "winches", "a scene with effects.closing")
                }
                "winch" => winch = reader.winch(&value)?.or(winch),
                "target" => reader.push(&value, &key, self.target, &mut pushes.target)?,
                _ => reader.push(&value, &key, self.chaser, &mut pushes.chaser)?,
            }
        }
        reader.problems.into_result(Some(())).map_err(errors::controls)?;
        state.winch = winch;
        thrust.tell(pushes);
        Ok(())
    }
}

/// Reads controls and gathers their faults.
struct Reader {
    problems: Problems,
}

impl Reader {
    fn fault(&mut self, place: &str, found: impl std::fmt::Display, allowed: &str) {
        self.problems.add(place, found, allowed);
    }

    /// Keys and values of the dict at `place`, those that are known.
    fn entries<'py>(
        &mut self,
        value: &Bound<'py, PyAny>,
        place: &str,
        known: &[&str],
    ) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        // What a controller gives at every step is a dict; any mapping will do.
        let items = match (value.cast::<PyDict>(), value.cast::<PyMapping>()) {
            (Ok(dict), _) => dict.items(),
            (_, Ok(mapping)) => mapping.items()?,
            _ => {
                self.fault(place, value.repr()?, &format!("a dict of {}", known.join(", ")));
                return Ok(Vec::new());
            }
        };
        let mut entries = Vec::new();
        for item in items.iter() {
            let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            let key = key.str()?.extract::<String>()?;
            if known.contains(&key.as_str()) {
                entries.push((key, value));
            } else {
                let allowed = format!("{}{}", did_you_mean(&key, known.iter().copied()), known.join(", "));
                self.fault(&join(place, &key), "an unknown key", &allowed);
            }
        }
        Ok(entries)
    }

    /// A number of at least zero.
    fn number(&mut self, value: &Bound<'_, PyAny>, above: &str, key: &str) -> PyResult<Option<f64>> {
        match value.extract::<f64>() {
            Ok(number) if number.is_finite() && number >= 0.0 => return Ok(Some(number)),
            _ => self.fault(&join(above, key), value.repr()?, NUMBER),
        }
        Ok(None)
    }

    /// Three numbers.
    fn vector(&mut self, value: &Bound<'_, PyAny>, above: &str, key: &str) -> PyResult<Vector3<f64>> {
        match value.extract::<[f64; 3]>() {
            Ok(numbers) if numbers.iter().all(|number| number.is_finite()) => return Ok(numbers.into()),
            _ => self.fault(&join(above, key), value.repr()?, "three numbers"),
        }
        Ok(Vector3::zeros())
    }

    fn winch(&mut self, value: &Bound<'_, PyAny>) -> PyResult<Option<WinchCommand>> {
        let known = ["start", "reel_speed_m_s", "max_tension_n"];
        let (mut start, mut speed, mut tension) = (true, None, None);
        for (key, value) in self.entries(value, "winch", &known)? {
            match key.as_str() {
                "reel_speed_m_s" => speed = Some(self.number(&value, "winch", &key)?),
                "max_tension_n" => tension = Some(self.number(&value, "winch", &key)?),
                _ => match value.extract::<bool>() {
                    Ok(told) => start = told,
                    Err(_) => self.fault("winch.start", value.repr()?, "True or False"),
                },
            }
        }
        for (key, value) in [("winch.reel_speed_m_s", speed), ("winch.max_tension_n", tension)] {
            if value.is_none() {
                self.fault(key, "nothing", NUMBER);
            }
        }
        Ok(match (speed.flatten(), tension.flatten()) {
            (Some(reel_speed), Some(max_tension)) => Some(WinchCommand { start, reel_speed, max_tension }),
            _ => None,
        })
    }

    fn push(
        &mut self,
        value: &Bound<'_, PyAny>,
        body: &str,
        allowed: Result<(), &str>,
        push: &mut Push,
    ) -> PyResult<()> {
        if let Err(allowed) = allowed {
            self.fault(body, "thrust", allowed);
            return Ok(());
        }
        *push = Push::default();
        if value.is_none() {
            return Ok(());
        }
        for (key, value) in self.entries(value, body, &["force_n", "torque_n_m", "frame"])? {
            match key.as_str() {
                "force_n" => push.wrench.force = self.vector(&value, body, &key)?,
                "torque_n_m" => push.wrench.torque = self.vector(&value, body, &key)?,
                _ => match value.extract::<String>().as_deref() {
                    Ok(frame @ ("local" | "body")) => push.in_body = frame == "body",
                    _ => self.fault(&join(body, &key), value.repr()?, "\"local\" or \"body\""),
                },
            }
        }
        Ok(())
    }
}
