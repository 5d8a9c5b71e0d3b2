//! Tells the program what it was built from: commit, compiler, engine version.

use std::process::Command;

fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.lines().next().map(str::to_owned).filter(|line| output.status.success() && !line.is_empty())
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
    println!("cargo:rerun-if-changed=.git/HEAD");
    println!("cargo:rerun-if-changed=.git/refs/heads");
    println!("cargo:rerun-if-changed=Cargo.lock");
}
