//! What the house rests on: data flows one way, one word has one meaning, methods are told apart in one place.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Files of both packages of the library, by path from their `src/`, without tests and comments.
fn sources() -> Vec<(String, String)> {
    ["core/src", "src"].into_iter().flat_map(sources_of).collect()
}

fn sources_of(folder: &str) -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let (mut folders, mut files): (Vec<PathBuf>, Vec<PathBuf>) = (vec![root.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => folders.push(path),
                false => files.push(path),
            }
        }
    }
    files.sort();
    let name = |path: &PathBuf| path.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
    let is_library = |name: &String| name.ends_with(".rs") && name != "main.rs" && !name.starts_with("cli/");
    let code = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
    };
    files.iter().map(|path| (name(path), code(path))).filter(|(name, _)| is_library(name)).collect()
}

/// Modules in the reading order: that of the physics' `lib.rs`, then that of the root's.
fn reading_order(sources: &[(String, String)]) -> Vec<String> {
    let libs = sources.iter().filter(|(name, _)| name == "lib.rs").flat_map(|(_, lib)| lib.lines());
    let modules = libs.filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    modules.map(str::to_owned).collect()
}

/// The word at the start of `text`.
fn word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// Imports that climb above the reading order, as `file -> module`.
fn climbing(sources: &[(String, String)]) -> Vec<String> {
    let order = reading_order(sources);
    // One that has parts in both packages stands where the root has it.
    let rank = |module: &str| order.iter().rposition(|known| known == module);
    let mut found = Vec::new();
    for (name, code) in sources {
        let Some(own) = rank(word(name)) else { continue };
        for used in code.replace("tumblenet_core::", "crate::").split("crate::").skip(1) {
            // A group names several modules: each stands after a brace or a comma.
            let group = used.strip_prefix('{').map(|group| group.split("};").next().unwrap_or_default());
            let modules = match group {
                Some(group) => group.split(',').map(|module| word(module.trim())).collect(),
                None => vec![word(used)],
            };
            let climbs = modules.into_iter().filter(|module| rank(module).is_some_and(|rank| rank > own));
            found.extend(climbs.map(|module| format!("{name} -> {module}")));
        }
    }
    found.sort();
    found.dedup();
    found
}

#[test]
fn imports_go_down_the_reading_order() {
    let sources = sources();
    assert!(reading_order(&sources).len() > 25 && sources.len() > 100);
    assert_eq!(climbing(&sources), [""; 0], "imports that climb");
}

/// The check itself sees a climb.
#[test]
fn an_import_that_climbs_is_found() {
    let mut sources = sources();
    sources.push(("state.rs".to_owned(), "use crate::run::Run;".to_owned()));
    sources.push(("net/mod.rs".to_owned(), "use crate::{cable, report::table};".to_owned()));
    sources.push(("metrics/mod.rs".to_owned(), "pub use tumblenet_core::{run, study};".to_owned()));
    assert_eq!(climbing(&sources).len(), 3);
}

/// Names of types, and the files that declare them.
fn types(sources: &[(String, String)]) -> BTreeMap<String, Vec<String>> {
    let mut types: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (file, code) in sources {
        for line in code.lines() {
            let declared = line.trim_start();
            let declared =
                declared.strip_prefix("pub ").or(declared.strip_prefix("pub(crate) ")).unwrap_or(declared);
            let kinds = ["struct ", "enum ", "trait ", "type "];
            // Types associated with a trait are its own: `type Output = ();` within a block.
            let is_own = !(declared.starts_with("type ") && line.starts_with(' '));
            let name = kinds.iter().find_map(|kind| declared.strip_prefix(kind)).map(word);
            if let Some(name) = name.filter(|_| is_own) {
                types.entry(name.to_owned()).or_default().push(file.clone());
            }
        }
    }
    types
}

/// Files that may name a type again: both builds of the engine stand behind one name.
const TWO_BUILDS: &str = "world/";

#[test]
fn no_type_name_occurs_twice() {
    let twice = |(name, files): (String, Vec<String>)| {
        let others = files.iter().filter(|file| !file.starts_with(TWO_BUILDS)).count();
        let in_world = usize::from(others < files.len());
        (others + in_world > 1).then(|| format!("{name}: {}", files.join(", ")))
    };
    let twice: Vec<String> = types(&sources()).into_iter().filter_map(twice).collect();
    assert_eq!(twice, [""; 0], "type names that occur twice");
}

/// Cable models are told apart where a scene is read and where a method is chosen.
#[test]
fn cable_models_are_told_apart_in_one_place() {
    let allowed = |file: &str| file == "solver.rs" || file == "step/mod.rs" || file.starts_with("scene/");
    let names = |code: &str| code.contains("CableModel::");
    let files: Vec<String> = sources()
        .into_iter()
        .filter(|(file, code)| names(code) && !allowed(file))
        .map(|(file, _)| file)
        .collect();
    assert_eq!(files, [""; 0], "files that name cable models");
}

/// What runs, judges, studies and shows a scene hears of an effect by what that does and tells: it imports none, nor the
/// mechanism behind one.
#[test]
fn no_study_and_no_report_knows_an_effect() {
    let sources = sources();
    let effects = sources.iter().filter_map(|(file, _)| file.strip_prefix("effects/")?.strip_suffix(".rs"));
    let effects =
        effects.filter(|name| !["mod", "blocks"].contains(name)).map(|name| format!("effects::{name}"));
    let known: Vec<String> = effects.chain(["crate::closing".to_owned()]).collect();
    let is_meant = |file: &str| {
        ["metrics/", "study/", "report/"].iter().any(|folder| file.starts_with(folder))
            || ["run.rs", "simulation.rs", "audit.rs"].contains(&file)
    };
    let meant: Vec<_> = sources.iter().filter(|(file, _)| is_meant(file)).collect();
    assert!(known.len() > 8 && meant.len() > 40, "{} effects, {} files", known.len(), meant.len());
    let naming = meant.iter().filter(|(_, code)| known.iter().any(|name| code.contains(name)));
    let naming: Vec<&String> = naming.map(|(file, _)| file).collect();
    assert!(naming.is_empty(), "files that name an effect: {naming:?}");
}

/// No trait of the library has more than six methods.
#[test]
fn traits_are_narrow() {
    for (file, code) in sources() {
        for body in code.split("\npub trait ").skip(1) {
            let body = body.split("\n}").next().unwrap_or_default();
            let methods = body.lines().filter(|line| line.starts_with("    fn ")).count();
            assert!(methods <= 6, "{file}: trait {} has {methods} methods", word(body));
        }
    }
}

/// A file of tests that nothing names would never run.
#[test]
fn every_file_of_tests_is_run() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |name: &str| std::fs::read_to_string(root.join(name)).unwrap();
    let (suite, manifest) = (read("tests/suite.rs"), read("Cargo.toml"));
    for entry in std::fs::read_dir(root.join("tests")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "rs") {
            let name = path.file_stem().unwrap().to_str().unwrap();
            let own = manifest.contains(&format!("[[test]]\nname = \"{name}\"\n"));
            assert!(own != suite.contains(&format!("\nmod {name};\n")), "{name} is run once");
        }
    }
}
