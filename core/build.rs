//! Tells where the built-in files are: at the root of a checkout; in the package itself once it is published, which takes
//! them along by the links beside this file. Not by the links in a checkout, too: on Windows git makes none.

fn main() {
    let is_checkout = std::path::Path::new("../scenarios").is_dir();
    println!("cargo:rustc-env=TUMBLENET_FILES={}", if is_checkout { ".." } else { "." });
    println!("cargo:rerun-if-changed=build.rs");
}
