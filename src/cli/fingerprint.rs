//! What tells this very program from others: results of two builds are never mixed.

use std::path::Path;
use std::sync::OnceLock;

use data_encoding::HEXLOWER;
use sha2::{Digest, Sha256};
use tumblenet::report::files::WriteError;

/// Hash of the program's file: a copy of it on another machine is the same, a build of other sources is not, whatever commit
/// or date either has.
///
/// # Errors
/// The file cannot be read.
pub fn fingerprint() -> Result<&'static str, WriteError> {
    static HASH: OnceLock<String> = OnceLock::new();
    if let Some(hash) = HASH.get() {
        return Ok(hash);
    }
    let this = std::env::current_exe().map_err(|error| WriteError::new(Path::new("the program"), error))?;
    let bytes = std::fs::read(&this).map_err(|error| WriteError::new(&this, error))?;
    Ok(HASH.get_or_init(|| HEXLOWER.encode(&Sha256::digest(bytes))))
}
