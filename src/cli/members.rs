//! Members of an ensemble, kept as they end: an interrupted ensemble goes on where it was.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::Serialize;
use serde::de::DeserializeOwned;
use tumblenet::case::Case;
use tumblenet::limits;
use tumblenet::report::files::{self, WriteError};
use tumblenet::report::results;
use tumblenet::study::ensemble::EnsembleRequest;

use super::fingerprint::fingerprint;

/// Most bytes of a kept file that is read again; the largest are some megabytes.
pub const MOST_KEPT: u64 = 256 << 20;

/// The kept members of one case and request.
pub struct Kept {
    folder: PathBuf,
    unwritten: Mutex<Option<WriteError>>,
}

impl Kept {
    /// The place of members of this case, request and program in the folder `out`; `kind` tells apart what is kept. Who
    /// changes a solver and runs again wants new members.
    pub fn open(out: &Path, kind: &str, case: &Case, request: &EnsembleRequest) -> Result<Kept, WriteError> {
        let until = request.at_most_s.map_or_else(String::new, |at_most| format!("-{at_most}"));
        let program = &fingerprint()?[..16];
        let key = format!("{}-{:e}-{}{until}-{program}", case.hash(), request.perturb_m, request.seed);
        let folder = out.join(kind).join(key);
        files::make_folder(&folder)?;
        Ok(Kept { folder, unwritten: Mutex::new(None) })
    }

    /// The first `count` members, those that are there and whole; `number` tells one's own number, which a file
    /// that was copied by hand does not have.
    pub fn known<T: DeserializeOwned>(&self, count: usize, number: impl Fn(&T) -> usize) -> Vec<T> {
        (0..count).filter_map(|member| self.one(member).filter(|kept| number(kept) == member)).collect()
    }

    /// One member, if it is there and whole.
    pub fn one<T: DeserializeOwned>(&self, member: usize) -> Option<T> {
        serde_json::from_slice(&limits::read_file(&self.place(member), MOST_KEPT).ok()?).ok()
    }

    /// Keeps a member; a failure is told by [`Kept::finish`], so that the other members go on.
    pub fn keep(&self, number: usize, member: &impl Serialize) {
        if let Err(error) = results::json(&self.place(number), member) {
            self.unwritten.lock().unwrap_or_else(|poison| poison.into_inner()).get_or_insert(error);
        }
    }

    /// Whether every member could be kept.
    pub fn finish(self) -> Result<(), WriteError> {
        self.unwritten.into_inner().unwrap_or_else(|poison| poison.into_inner()).map_or(Ok(()), Err)
    }

    fn place(&self, member: usize) -> PathBuf {
        self.folder.join(format!("{member:06}.json"))
    }
}
