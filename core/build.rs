//! Tells where the built-in files are: at the root of a checkout; in the package itself once it is published, which takes
//! them along by the links beside this file. Not by the links in a checkout, too: on Windows git makes none.

use std::path::Path;

fn main() {
    let checkout = Path::new("..").join("scenarios").is_dir();
    let package = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo:rustc-env=TUMBLENET_FILES={package}/{}", if checkout { ".." } else { "." });
    println!("cargo:rerun-if-changed=build.rs");
}
