//! Rows of a sweep, kept as they end: a sweep that was killed goes on where it was, and shards need not know each other.
//!
//! A program keeps its rows in one file, which is written anew beside and renamed as rows are added, until it has a
//! thousand; then comes the next. A file's name is the hash of its content: machines that write the same rows write the
//! same file, and one that was damaged gives itself away. Rows that are there twice are the same, or the table is refused.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use data_encoding::HEXLOWER;
use sha2::{Digest, Sha256};

use super::files::{self, WriteError};
use crate::limits;
use crate::study::sweep::{Row, SweepPlan};

/// Rows of a file.
const MOST_ROWS: usize = 1000;

/// Most bytes of a file that is read: a thousand rows have some megabytes.
pub const MOST_BYTES: u64 = 256 << 20;

/// Between two writes is at least so long, and so many times as long as the last write took: they cost 2 %.
const AT_LEAST: Duration = Duration::from_secs(1);
const TIMES: u32 = 50;

/// Keeps the rows that this program adds.
pub struct RowKeeper {
    folder: PathBuf,
    header: Vec<u8>,
    held: Mutex<Held>,
}

/// The file that rows are added to.
#[derive(Default)]
struct Held {
    text: Vec<u8>,
    n_rows: usize,
    /// Where it was last written to.
    written: Option<PathBuf>,
    is_saved: bool,
    /// When that is to be done again; at once at first.
    next: Option<Instant>,
    /// Why it could not be.
    fault: Option<WriteError>,
    /// Whether nothing is added any more.
    is_closed: bool,
}

impl RowKeeper {
    /// Keeps rows of `plan` in the folder `out`.
    ///
    /// # Errors
    /// The folder cannot be made.
    pub fn open(out: &Path, plan: &SweepPlan) -> Result<RowKeeper, WriteError> {
        let folder = folder(out, plan);
        files::make_folder(&folder)?;
        let header = line(&plan.columns);
        let held = Mutex::new(Held { is_saved: true, ..Held::default() });
        Ok(RowKeeper { folder, header, held })
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a row. A fault is told by [`RowKeeper::close`], so that other members go on.
    pub fn keep(&self, row: &Row) {
        let mut held = self.held();
        if held.is_closed {
            return;
        }
        held.text.extend(line(&row.fields));
        held.n_rows += 1;
        held.is_saved = false;
        let is_full = held.n_rows >= MOST_ROWS;
        if is_full || held.next.is_none_or(|next| Instant::now() >= next) {
            self.save(&mut held);
        }
        // What could not be written is tried again with the rows to come.
        if is_full && held.is_saved {
            *held = Held { is_saved: true, next: held.next, fault: held.fault.take(), ..Held::default() };
        }
    }

    /// Writes what is not yet written; nothing is added any more.
    ///
    /// # Errors
    /// It could not be.
    pub fn close(&self) -> Result<(), WriteError> {
        let mut held = self.held();
        held.is_closed = true;
        self.save(&mut held);
        if held.is_saved { Ok(()) } else { held.fault.take().map_or(Ok(()), Err) }
    }

    fn save(&self, held: &mut Held) {
        if held.is_saved {
            return;
        }
        let begun = Instant::now();
        let text = [self.header.as_slice(), &held.text].concat();
        let place = self.folder.join(format!("{}.csv", digest(&text)));
        match files::write(&place, |file| file.write_all(&text)) {
            Ok(()) => {
                // Its rows are all in the new one.
                if let Some(before) =
                    held.written.replace(place).filter(|before| Some(before) != held.written.as_ref())
                {
                    std::fs::remove_file(before).ok();
                }
                held.is_saved = true;
            }
            Err(error) => held.fault = Some(error),
        }
        held.next = Some(Instant::now() + AT_LEAST.max(TIMES * begun.elapsed()));
    }
}

/// Where the rows of `plan` are.
fn folder(out: &Path, plan: &SweepPlan) -> PathBuf {
    out.join("rows").join(&plan.key)
}

/// `fields` as a line of CSV.
pub fn line<T: AsRef<[u8]>>(fields: &[T]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Into memory nothing fails.
    writer.write_record(fields).ok();
    writer.into_inner().unwrap_or_default()
}

fn digest(text: &[u8]) -> String {
    HEXLOWER.encode(&Sha256::digest(text)[..8])
}

/// Where a row is, and how its member ended.
#[derive(Clone, Debug)]
pub struct KeptRow {
    file: usize,
    from: usize,
    to: usize,
    digest: u64,
    /// Whether the target was captured; nothing without a verdict.
    pub captured: Option<bool>,
    /// The verdict; empty where there is none.
    pub verdict: Box<str>,
    /// Whether the member failed.
    pub failed: bool,
}

/// The rows that are kept.
#[derive(Debug, Default)]
pub struct KeptRows {
    files: Vec<PathBuf>,
    /// By member.
    pub rows: BTreeMap<u64, KeptRow>,
    /// Files that are not what they were when they were written; their rows do not count.
    pub damaged: Vec<PathBuf>,
    /// Members of whom there are two different rows, with the file that differs from one before.
    pub contradicted: Vec<(u64, PathBuf)>,
    /// The last file that was read again.
    open: RefCell<Option<(usize, Vec<u8>)>>,
}

/// Where columns are that say how a member ended.
struct EndColumns {
    captured: usize,
    verdict: usize,
    failure: usize,
}

impl KeptRows {
    /// The rows of `plan` in the folder `out`: none where there is nothing.
    pub fn read(out: &Path, plan: &SweepPlan) -> KeptRows {
        let mut kept = KeptRows::default();
        let column = |name: &str| plan.columns.iter().position(|known| known == name);
        let (Some(captured), Some(verdict), Some(failure)) =
            (column("captured"), column("verdict"), column("failure"))
        else {
            return kept;
        };
        let (ends, header) = (EndColumns { captured, verdict, failure }, line(&plan.columns));
        let entries = std::fs::read_dir(folder(out, plan)).into_iter().flatten().flatten();
        let is_ours = |path: &PathBuf| {
            let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
            !hidden && path.extension().is_some_and(|ending| ending == "csv")
        };
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_ours).collect();
        paths.sort();
        for path in paths {
            match whole(&path, &header) {
                FoundFile::Whole(text) => kept.add(path, &text, header.len(), &ends, plan.members),
                FoundFile::Damaged => kept.damaged.push(path),
                // Another program has just put a longer one in its place.
                FoundFile::Gone => {}
            }
        }
        kept
    }

    fn add(&mut self, path: PathBuf, text: &[u8], from: usize, ends: &EndColumns, n_members: u64) {
        let file = self.files.len();
        let mut start = from;
        for end in
            text.iter().enumerate().skip(from).filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1)
        {
            let bytes = &text[start..end];
            let place = start..end;
            start = end;
            let fields = fields(bytes);
            let field = |column: usize| fields.get(column).and_then(|bytes| std::str::from_utf8(bytes).ok());
            let Some(member) = field(0).and_then(|text| text.parse().ok()) else { continue };
            // Of a longer study before, whose points are the same.
            if member >= n_members {
                continue;
            }
            let digest =
                Sha256::digest(bytes).iter().take(8).fold(0, |sum, byte| sum << 8 | u64::from(*byte));
            let row = KeptRow {
                file,
                from: place.start,
                to: place.end,
                digest,
                captured: field(ends.captured).and_then(|text| text.parse().ok()),
                verdict: field(ends.verdict).unwrap_or_default().into(),
                failed: field(ends.failure).is_some_and(|text| !text.is_empty()),
            };
            match self.rows.get(&member) {
                None => drop(self.rows.insert(member, row)),
                Some(known) if known.digest != digest => self.contradicted.push((member, path.clone())),
                Some(_) => {}
            }
        }
        self.files.push(path);
    }

    /// The bytes of `row`, with the end of its line.
    ///
    /// # Errors
    /// Its file has changed since.
    pub fn line_of(&self, row: &KeptRow) -> Result<Vec<u8>, WriteError> {
        let mut open = self.open.borrow_mut();
        if open.as_ref().is_none_or(|(file, _)| *file != row.file) {
            let path = &self.files[row.file];
            let text = limits::read_file(path, MOST_BYTES).map_err(|error| WriteError::new(path, error))?;
            *open = Some((row.file, text));
        }
        let bytes = open.as_ref().and_then(|(_, text)| text.get(row.from..row.to));
        bytes
            .map(<[u8]>::to_vec)
            .ok_or_else(|| WriteError::new(&self.files[row.file], "it was changed while it was read"))
    }

    /// Members of `plan` that have no row yet.
    pub fn missing(&self, plan: &SweepPlan) -> Vec<u64> {
        (0..plan.members).filter(|member| !self.rows.contains_key(member)).collect()
    }
}

/// Fields of a line of CSV.
pub fn fields(line: &[u8]) -> csv::ByteRecord {
    // Hardly any line has a quote; a reader of its own for each takes 20 us, three seconds of a hundred thousand.
    if !line.is_empty() && !line.contains(&b'"') {
        let end = line.strip_suffix(b"\n").unwrap_or(line);
        return end.split(|byte| *byte == b',').collect();
    }
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(line);
    let mut record = csv::ByteRecord::new();
    // A line that is none has no fields.
    reader.read_byte_record(&mut record).ok();
    record
}

/// What became of a file that was found.
enum FoundFile {
    Whole(Vec<u8>),
    Damaged,
    Gone,
}

fn whole(path: &Path, header: &[u8]) -> FoundFile {
    let Ok(text) = limits::read_file(path, MOST_BYTES) else {
        return if path.exists() { FoundFile::Damaged } else { FoundFile::Gone };
    };
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let is_whole = name.is_some_and(|name| name == digest(&text)) && text.starts_with(header);
    if is_whole { FoundFile::Whole(text) } else { FoundFile::Damaged }
}

/// Numbers in a row as `0,3,7-9`, which array jobs of clusters take.
pub fn ranges(numbers: &[u64]) -> String {
    let mut runs: Vec<[u64; 2]> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == number => *last = number,
            _ => runs.push([number, number]),
        }
    }
    let words = runs.iter().map(|[first, last]| match first == last {
        true => first.to_string(),
        false => format!("{first}-{last}"),
    });
    words.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_a_row_are_written_as_array_jobs_take_them() {
        assert_eq!(ranges(&[3, 7, 8, 9]), "3,7-9");
        assert_eq!(ranges(&[0, 1, 4]), "0-1,4");
        assert_eq!(ranges(&[]), "");
    }

    #[test]
    fn a_line_is_read_as_it_was_written() {
        let written = line(&["1", "a \"word\", or two", ""]);
        let fields = fields(&written);
        assert_eq!(fields.iter().collect::<Vec<_>>(), [&b"1"[..], b"a \"word\", or two", b""]);
        assert_eq!(written.iter().filter(|byte| **byte == b'\n').count(), 1);
    }

    #[test]
    fn a_line_without_quotes_has_the_fields_that_the_reader_finds() {
        for text in ["1,2.5,,x\n", "1,2.5,,x", ",\n", "one\n", "a b,ä\n"] {
            let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
            let mut expected = csv::ByteRecord::new();
            reader.read_byte_record(&mut expected).unwrap();
            assert_eq!(fields(text.as_bytes()), expected, "{text:?}");
        }
    }
}
