//! Finding the shape that a scene names: built in, in a file, or in the scene itself.

use std::borrow::Cow;

use super::files::Files;
use super::repair;
use super::spec::{Shape, ShapeChoice};
use crate::assets::Kind;
use crate::json;
use crate::limits::Limit;
use crate::problems::Problems;
use crate::read;

/// A shape, where it stands and what its own paths are relative to.
#[derive(Debug)]
pub struct FoundShape<'a> {
    /// The shape.
    pub shape: Cow<'a, Shape>,
    /// The files that it may name.
    pub files: Files<'a>,
    /// Place that its faults are named with, `target.shape(envisat.json)` say.
    pub place: String,
}

/// Finds the shape of a target. A name that ends in `.json` is a file; any other is built in.
pub fn find<'a>(
    choice: &'a ShapeChoice,
    files: &Files<'a>,
    place: &str,
    problems: &mut Problems,
) -> Option<FoundShape<'a>> {
    let name = match choice {
        ShapeChoice::Inline(shape) => {
            return Some(FoundShape {
                shape: Cow::Borrowed(shape),
                files: files.clone(),
                place: place.to_owned(),
            });
        }
        ShapeChoice::Named(name) => name,
    };
    let inner_place = format!("{place}({name})");
    let (text, files) = if name.ends_with(".json") {
        let (bytes, path) = files.read(name, Limit::Text, place, problems)?;
        let Ok(text) = String::from_utf8(bytes) else {
            problems.add(place, format!("{name:?}, which is no text"), "a JSON file");
            return None;
        };
        (Cow::Owned(text), files.named_by(Some(&path)))
    } else if let Some(text) = Kind::Shape.text(name) {
        (Cow::Borrowed(text), files.named_by(None))
    } else {
        let allowed = format!("{}, the path of a .json file, or a shape", Kind::Shape.instead_of(name));
        problems.add(place, format!("{name:?}"), allowed);
        return None;
    };
    let value = json::parse(&text, &inner_place, problems)?;
    let known = problems.list.len();
    let Some(shape) = read::typed(&value, &inner_place, problems) else {
        let faults = problems.list[known..].to_vec();
        repair::check_others(&value, &faults, &files, &inner_place, problems);
        return None;
    };
    Some(FoundShape { shape: Cow::Owned(shape), files, place: inner_place })
}
