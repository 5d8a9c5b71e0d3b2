//! The README and the docs say what is true: their commands are understood, their links lead somewhere.

use std::path::{Path, PathBuf};
use std::process::Command;

use tumblenet::case::Case;
use tumblenet::limits::Limits;
use tumblenet::study::stress::catalogue;

/// The README and every page of the docs: path and text.
fn pages() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = std::fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let tops = ["README.md", "CONTRIBUTING.md", "assets/hard-cases.md"].map(|name| root.join(name));
    let is_page = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "md");
    let paths = tops.into_iter().chain(docs).filter(is_page);
    paths.map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
}

/// The words of a command line, as a shell parts them.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in line.chars() {
        match (quote, c) {
            (None, '\'' | '"') => quote = Some(c),
            (Some(open), _) if open == c => quote = None,
            (None, ' ') => words.push(std::mem::take(&mut word)),
            _ => word.push(c),
        }
    }
    words.push(word);
    words.into_iter().filter(|word| !word.is_empty()).collect()
}

/// Commands in a page: inline code and lines of code blocks that begin with the program's name.
fn commands(text: &str) -> Vec<Vec<String>> {
    // A line that ends in a backslash goes on.
    let text = text.replace("\\\n", " ");
    let mut found: Vec<&str> = Vec::new();
    let mut in_block = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            in_block = !in_block;
        } else if in_block {
            found.push(line.split("  #").next().unwrap_or_default());
        } else {
            found.extend(line.split('`').skip(1).step_by(2));
        }
    }
    let of_program = found.into_iter().filter_map(|code| code.trim().strip_prefix("tumblenet "));
    // What may be left out stands in brackets, what is meant by a word in capitals is the reader's.
    let own = of_program.map(|code| code.split(" > ").next().unwrap_or_default());
    own.map(|code| words(&code.replace(['[', ']'], " "))).collect()
}

/// What `mdbook build` makes of the docs: every page is a chapter, once, and every chapter a page. A line of the table of contents is a link by itself,
/// in a list or before it.
#[test]
fn every_page_is_a_chapter_of_the_book() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let summary = std::fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let chapter = |line: &str| {
        let link = line.trim_start().strip_prefix("- ").unwrap_or(line);
        let (title, page) = link.strip_prefix('[')?.strip_suffix(')')?.split_once("](")?;
        (!title.is_empty()).then(|| page.to_owned())
    };
    let lines = summary.lines().filter(|line| !line.is_empty() && *line != "# Summary");
    let mut chapters: Vec<String> =
        lines.map(|line| chapter(line).unwrap_or_else(|| panic!("no chapter: {line}"))).collect();
    chapters.sort();
    let name = |(path, _): (PathBuf, String)| path.strip_prefix(&docs).ok()?.to_str().map(str::to_owned);
    let mut pages: Vec<String> = pages().into_iter().filter_map(name).collect();
    pages.retain(|page| page != "SUMMARY.md");
    pages.sort();
    assert_eq!(chapters, pages);
    let book = std::fs::read_to_string(docs.with_file_name("book.toml")).unwrap();
    assert!(book.contains("src = \"docs\""));
}

/// The program knows the command and every option of it. Values are read, nothing is run: the help comes first.
#[test]
fn every_command_of_the_docs_is_understood() {
    let mut n_commands = 0;
    for (path, text) in pages() {
        for arguments in commands(&text) {
            let arguments: Vec<&str> =
                arguments.iter().map(String::as_str).filter(|word| *word != "…").collect();
            let output = Command::new(env!("CARGO_BIN_EXE_tumblenet"))
                .args(&arguments)
                .arg("--help")
                .output()
                .expect("the program starts");
            let told = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}: {arguments:?}\n{told}", path.display());
            n_commands += 1;
        }
    }
    assert!(n_commands > 15, "{n_commands} commands found");
}

/// A scene that a command of the docs runs is there, and takes the changes that the command makes.
#[test]
fn every_scene_of_the_docs_takes_its_changes() {
    let mut n_scenes = 0;
    for (path, text) in pages() {
        for arguments in commands(&text) {
            let is_built_in = |name: &&String| tumblenet::assets::Kind::Scene.text(name).is_some();
            let Some(scene) = arguments.get(1).filter(is_built_in) else { continue };
            let changes: Vec<String> =
                arguments.windows(2).filter(|pair| pair[0] == "--set").map(|pair| pair[1].clone()).collect();
            if changes.iter().any(|change| change == "…") {
                continue;
            }
            if let Err(problems) = Case::load_changed(scene, &changes, Limits::default()) {
                panic!("{}: {arguments:?}\n{problems}", path.display());
            }
            n_scenes += 1;
        }
    }
    assert!(n_scenes > 10, "{n_scenes} scenes found");
}

#[test]
fn every_link_leads_to_a_file() {
    for (path, text) in pages() {
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = target.split('#').next().unwrap_or_default();
            if file.is_empty() || file.contains("://") {
                continue;
            }
            assert!(path.parent().unwrap().join(file).exists(), "{}: {target}", path.display());
        }
    }
}

#[test]
fn the_readme_is_short_and_counts_its_hard_cases_right() {
    let readme = &pages()[0].1;
    assert!(readme.lines().count() <= 120, "{} lines", readme.lines().count());
    let n_cases = catalogue::all().len();
    assert!(readme.contains(&format!("{n_cases} cases")), "{n_cases} cases in the catalogue");
}
