//! Tells the program what it was built from: commit, compiler, engine version.

use std::path::Path;
use std::process::Command;

fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.lines().next().map(str::to_owned).filter(|line| output.status.success() && !line.is_empty())
}

/// Looks again when the file changes. One that is not there would make every build look again: in a linked work
/// tree `.git` is a file, and a packed branch has none of its own.
fn watch(path: &str) {
    if Path::new(path).exists() {
        println!("cargo:rerun-if-changed={path}");
    }
}

fn main() {
    let unknown = || "unknown".to_owned();
    let commit = first_line("git", &["describe", "--always", "--dirty", "--abbrev=12"]);
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let compiler = first_line(&rustc, &["--version"]);
    let lock = std::fs::read_to_string("Cargo.lock").unwrap_or_default();
    let engine = lock.split("name = \"rapier3d-f64\"\nversion = \"").nth(1);
    let engine = engine.and_then(|rest| rest.split('"').next()).map(|version| format!("rapier3d {version}"));
    println!("cargo:rustc-env=TUMBLENET_COMMIT={}", commit.unwrap_or_else(unknown));
    println!("cargo:rustc-env=TUMBLENET_COMPILER={}", compiler.unwrap_or_else(unknown));
    println!("cargo:rustc-env=TUMBLENET_ENGINE={}", engine.unwrap_or_else(unknown));
    watch("build.rs");
    watch("Cargo.lock");
    // The commit of a program that is handed on has to be right; a commit alone is no reason to compile the tests anew.
    if std::env::var("PROFILE").is_ok_and(|profile| profile == "release") {
        let branch = first_line("git", &["symbolic-ref", "-q", "HEAD"]);
        for name in ["HEAD".to_owned()].into_iter().chain(branch) {
            if let Some(path) = first_line("git", &["rev-parse", "--git-path", &name]) {
                watch(&path);
            }
        }
    }
}
