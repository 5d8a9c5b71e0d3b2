//! Scenes, shapes, materials and studies that travel inside the program.
//!
//! They are the files of `scenarios/`, `assets/` and `examples/studies/`, embedded as they lie there.

use include_dir::{Dir, include_dir};

use crate::problems::nearest;

static SCENARIOS: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/$TUMBLENET_FILES/scenarios");
static SHAPES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/$TUMBLENET_FILES/assets/shapes");
static MATERIALS: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/$TUMBLENET_FILES/assets/materials");
static STUDIES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/$TUMBLENET_FILES/examples/studies");
static CABINS: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/$TUMBLENET_FILES/assets/cabins");

/// A kind of built-in file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Scenes (`scenarios/`).
    Scene,
    /// Shapes of targets (`assets/shapes/`).
    Shape,
    /// Cable materials (`assets/materials/`).
    Material,
    /// Studies of sweeps (`examples/studies/`).
    Study,
    /// Residual gravity and rotation of a cabin over time (`assets/cabins/`).
    Cabin,
}

impl Kind {
    fn dir(self) -> &'static Dir<'static> {
        match self {
            Kind::Scene => &SCENARIOS,
            Kind::Shape => &SHAPES,
            Kind::Material => &MATERIALS,
            Kind::Study => &STUDIES,
            Kind::Cabin => &CABINS,
        }
    }

    /// How the names of its files end.
    fn ending(self) -> &'static str {
        match self {
            Kind::Cabin => ".csv",
            Kind::Scene | Kind::Shape | Kind::Material | Kind::Study => ".json",
        }
    }

    /// Names of all built-in files of this kind, sorted.
    pub fn names(self) -> Vec<&'static str> {
        let mut names: Vec<_> = self
            .dir()
            .files()
            .filter_map(|file| file.path().file_name()?.to_str()?.strip_suffix(self.ending()))
            .collect();
        names.sort_unstable();
        names
    }

    /// Text of the built-in file called `name`.
    pub fn text(self, name: &str) -> Option<&'static str> {
        self.dir().get_file(format!("{name}{}", self.ending()))?.contents_utf8()
    }

    /// What may stand in the place of the unknown name `name`, for an error message: the one that it is like, or all.
    pub fn instead_of(self, name: &str) -> String {
        match nearest(name, self.names().into_iter()) {
            Some(meant) => format!("did you mean \"{meant}\"? (`tumblenet list` names all)"),
            None => self.choices(),
        }
    }

    /// `a`, `b` or `c`: what a name may be, for an error message.
    fn choices(self) -> String {
        self.names().iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
    }
}
