//! What is uncertain in a scene: drawn for each member of an ensemble or a sweep.
//!
//! A member is the scene in which what was drawn stands in the place of what is uncertain, read and checked like any other
//! scene. What is drawn comes from the seed and the member's number alone.

use std::sync::Arc;

use super::Case;
use crate::parameter::{self, Own, Parameter, Pick, Stream, units};
use crate::problems::{Problems, join};
use crate::scene::Source;
use crate::scene::schema::Scene;

/// The key of a scene.
const KEY: &str = "uncertain";

/// What is drawn for each member.
#[derive(Clone, Debug)]
pub struct Uncertain {
    /// The scene in which nothing is uncertain, every default written out.
    source: Source,
    parameters: Vec<Parameter>,
}

impl Uncertain {
    /// What is uncertain in `scene`, which was read from `source`; faults go to `problems`. Of a scene that is not as it
    /// was written, since its faults were mended, nothing is asked.
    pub(super) fn read(
        scene: &Scene,
        as_written: bool,
        source: &Source,
        problems: &mut Problems,
    ) -> Option<Arc<Uncertain>> {
        if scene.uncertain.is_empty() {
            return None;
        }
        let mut json = scene.written_out();
        if let Some(map) = json.as_object_mut() {
            map.shift_remove(KEY);
            // What the scene itself is expected to show is expected of no member.
            map.shift_remove("expect");
        }
        let source = Source { json, ..source.clone() };
        parameter::check_apart(&scene.uncertain, KEY, problems);
        let all = scene.uncertain.iter().enumerate();
        let parameters = all.filter_map(|(number, varied)| {
            if varied.crossed {
                problems.add(
                    format!("{KEY}[{number}].crossed"),
                    true,
                    "a study's parameters: a scene goes through nothing",
                );
            }
            let own = if as_written { source.own(&varied.path) } else { Own::Unknown };
            Parameter::read(varied, &own, &format!("{KEY}[{number}]"), problems)
        });
        let parameters = parameters.collect();
        Some(Arc::new(Uncertain { source, parameters }))
    }

    /// Adds what the scene does not allow at the ends of what is drawn.
    pub(super) fn check_ends(&self, problems: &mut Problems) {
        for (number, parameter) in self.parameters.iter().enumerate() {
            check_ends(&self.source, parameter, &format!("{KEY}[{number}]"), problems);
        }
    }

    /// What is drawn.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Columns of a table that shows what was drawn.
    pub fn columns(&self) -> Vec<String> {
        self.parameters.iter().flat_map(Parameter::columns).collect()
    }

    /// What `member` has, of the seed `seed`.
    pub fn draw(&self, seed: u64, member: u64) -> Vec<Pick> {
        self.draw_from(&mut units(seed, member, Stream::Uncertain))
    }

    /// What the next numbers of `next`, from 0 to below 1, stand for.
    pub fn draw_from(&self, next: &mut dyn FnMut() -> f64) -> Vec<Pick> {
        self.parameters.iter().map(|parameter| parameter.draw(next)).collect()
    }

    /// The scene in which `picks` stand.
    ///
    /// # Errors
    /// Faults that the ends of nothing alone have.
    pub fn with(&self, picks: &[Pick]) -> Result<Case, Problems> {
        let mut source = self.source.clone();
        let all = self.parameters.iter().zip(picks);
        source.set(&all.map(|(parameter, pick)| parameter.change(pick)).collect::<Vec<_>>())?;
        Case::build(&source)
    }
}

/// Adds what the scene `source` does not allow at the ends of `parameter`, which stands at `place`.
pub fn check_ends(source: &Source, parameter: &Parameter, place: &str, problems: &mut Problems) {
    for (end, pick) in parameter.ends() {
        if problems.is_full() {
            return;
        }
        let mut changed = source.clone();
        let faults = changed.set(&[parameter.change(&pick)]).and_then(|()| Case::build(&changed).map(drop));
        for fault in faults.err().into_iter().flat_map(|faults| faults.list) {
            let found = format!("{}, with which {} is {}", pick.value, fault.place, fault.found);
            problems.add(join(place, &end), found, fault.allowed);
        }
    }
}
