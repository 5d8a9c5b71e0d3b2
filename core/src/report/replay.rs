//! What the page of a replay reads: the run in motion, as JSON.
//!
//! **Positions travel as base64 of little-endian f32.** Quantising to 16 bits would halve the page, but a
//! scene of 30 m then resolves 0.5 mm, and the page decides from a cable's length whether it is slack or
//! taut: a taut nylon cable of 70 mm stretches by less than that. f32 resolves 2 um at 30 m.
//!
//! **Frames are thinned** to [`MAX_FRAMES`], and further on large nets so that the knots never take more than
//! [`MAX_KNOT_BYTES`]. The page interpolates between frames and says what was left out.

use std::borrow::Cow;

use data_encoding::BASE64;
use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;

/// Frames kept at most: 10 s of motion at 60 frames per second.
pub const MAX_FRAMES: usize = 600;

/// Bytes of base64 that the knots may take: 600 frames of 441 knots take 4.2 MB, of 937 knots all of it.
pub const MAX_KNOT_BYTES: usize = 9_000_000;

/// What the replay shows. Frames are numbered alike in `times`, `knots`, the target and the curves.
pub struct Replay<'a> {
    /// Title of the scene.
    pub title: &'a str,
    /// Where the scene comes from.
    pub source: Option<&'a str>,
    /// When not to believe it.
    pub warnings: &'a [String],
    /// What the verdict was from when on, in order, if the run was judged.
    pub verdicts: Option<Vec<ReplayVerdict<'a>>>,
    /// Time of each frame, rising. [s]
    pub times: &'a [f64],
    /// Positions in the local frame O-XYZ: frame, then knot. [m]
    pub knots: &'a [Vec<Vector3<f64>>],
    /// The two knots of each cable.
    pub cables: &'a [(usize, usize)],
    /// Rest length of each cable. [m]
    pub rest_lengths: &'a [f64],
    /// The four corner knots that are bullets.
    pub bullets: [usize; 4],
    /// Knots along the net's edge, in order round the mouth; cables between two of them are drawn stronger.
    pub perimeter: &'a [usize],
    /// The target, if there is one.
    pub target: Option<ReplayTarget<'a>>,
    /// Bodies that effects brought, such as a free chaser.
    pub blocks: Vec<ReplayBlock<'a>>,
    /// Numbers that change with time, in the order they are listed.
    pub curves: Vec<Curve<'a>>,
    /// Threads that are wound on winches.
    pub threads: Vec<ReplayThread>,
    /// What cables and knots bore, if that was recorded.
    pub loads: Option<ReplayLoads<'a>>,
    /// Moments worth jumping to: time [s] and a word, such as "first contact".
    pub marks: Vec<(f64, String)>,
}

/// What the verdict was from a time on.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ReplayVerdict<'a> {
    /// From then on. [s]
    pub from_s: f64,
    /// In words, such as `held so far`.
    pub words: &'a str,
    /// Whether the net holds the target; none: nothing is decided yet.
    pub held: Option<bool>,
}

/// A body without a shape, drawn as a block.
pub struct ReplayBlock<'a> {
    /// Its name.
    pub name: &'a str,
    /// The eight corners, and where a tether leaves it, per frame. [m]
    pub places: Vec<[Vector3<f64>; 9]>,
}

/// The target and its motion.
pub struct ReplayTarget<'a> {
    /// One mesh per convex part, in the body frame.
    pub parts: Vec<ReplayMesh>,
    /// Centre of mass in the local frame, per frame. [m]
    pub positions: &'a [Vector3<f64>],
    /// Local frame from body frame, per frame.
    pub attitudes: &'a [UnitQuaternion<f64>],
}

/// Triangles of a convex part.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ReplayMesh {
    /// Corners. [m]
    pub vertices: Vec<[f32; 3]>,
    /// Three corners each.
    pub triangles: Vec<[u32; 3]>,
}

/// A thread that is wound on a winch.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ReplayThread {
    /// When the winch started; null: never. [s]
    pub start_s: Option<f64>,
    /// Its largest tension. [N]
    pub limit_n: f64,
    /// Where it ends if it is wound outside of the net, without a body to end at. [m]
    pub anchor_m: [f64; 3],
    /// Name of that body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub port_of: Option<&'static str>,
    /// The knots it passes, in order; null: the anchor.
    pub way: Vec<Option<usize>>,
    /// What is off the reels where winding ends. [m]
    pub stop_m: f64,
    /// Its length in the net, per frame. [m]
    pub length_m: Vec<f64>,
    /// What is off its reels, per frame. [m]
    pub off_reels_m: Vec<f64>,
    /// Its largest tension since the frame before, per frame. [N]
    pub tension_n: Vec<f64>,
}

impl ReplayThread {
    /// With the frames `kept` alone.
    fn thinned(&self, kept: &[usize]) -> ReplayThread {
        let only = |values: &[f64]| kept.iter().map(|&frame| values[frame]).collect();
        ReplayThread {
            length_m: only(&self.length_m),
            off_reels_m: only(&self.off_reels_m),
            // The largest since the frame kept before.
            tension_n: kept
                .iter()
                .enumerate()
                .map(|(i, &frame)| {
                    let since = if i == 0 { frame } else { kept[i - 1] + 1 };
                    self.tension_n[since..=frame].iter().copied().fold(0.0, f64::max)
                })
                .collect(),
            ..self.clone()
        }
    }
}

/// What cables bore, and how hard contacts were.
pub struct ReplayLoads<'a> {
    /// Largest tension of each cable since the frame before [N]: frame, then cable.
    pub tensions: &'a [Vec<f64>],
    /// Breaking tension of each cable [N].
    pub breaking: &'a [f64],
    /// Contact impulse on each knot since the frame before [N s]: frame, then knot.
    pub impulses: &'a [Vec<Vector3<f64>>],
}

/// Factors of ten between what breaks a cable (the largest impulse of a contact) and the least that is told from nothing.
const DECADES: f64 = 5.0;

/// `share` of the largest in a byte: 0 is nothing, 255 the largest, and equal steps are equal ratios.
fn level(share: f64) -> u8 {
    // A share that is none is nothing.
    if share.is_nan() || share <= 0.0 {
        return 0;
    }
    (255.0 * (1.0 + share.log10() / DECADES)).round().clamp(1.0, 255.0) as u8
}

impl ReplayLoads<'_> {
    /// For the page, with the frames `kept` alone: the largest since the frame kept before.
    fn thinned(&self, kept: &[usize]) -> PageLoads {
        let since = |i: usize| if i == 0 { kept[0] } else { kept[i - 1] + 1 };
        let size = |impulse: &Vector3<f64>| if impulse.norm().is_finite() { impulse.norm() } else { 0.0 };
        let largest = self.impulses.iter().flatten().map(size).fold(0.0, f64::max);
        let (mut tensions, mut hits) = (Vec::new(), Vec::new());
        for (i, &frame) in kept.iter().enumerate() {
            let frames = since(i)..=frame;
            tensions.extend(self.breaking.iter().enumerate().map(|(cable, breaking)| {
                level(
                    self.tensions[frames.clone()].iter().map(|all| all[cable]).fold(0.0, f64::max) / breaking,
                )
            }));
            hits.extend((0..self.impulses[frame].len()).map(|knot| {
                level(
                    self.impulses[frames.clone()].iter().map(|all| size(&all[knot])).fold(0.0, f64::max)
                        / largest,
                )
            }));
        }
        let ends = self.breaking.iter().fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], breaking| {
            [low.min(*breaking), high.max(*breaking)]
        });
        PageLoads {
            tensions: BASE64.encode(&tensions),
            breaking_n: ends,
            hits: BASE64.encode(&hits),
            largest_n_s: largest,
            decades: DECADES,
        }
    }
}

/// A number that changes with time.
pub struct Curve<'a> {
    /// Its name, such as "mouth".
    pub name: &'a str,
    /// Its unit; empty for a share, which is drawn on a scale from 0 to 1.
    pub unit: &'a str,
    /// A value per frame; a value that is not finite shows as a gap.
    pub values: Cow<'a, [f64]>,
    /// Whether it is also drawn along the time slider.
    pub along_slider: bool,
}

/// The data of the page of `replay`, as JSON.
pub fn json(replay: &Replay) -> String {
    serde_json::to_string(&Page::of(replay)).expect("plain numbers and text always serialise")
}

/// What the page's script reads.
#[derive(Serialize)]
struct Page<'a> {
    title: &'a str,
    source: Option<&'a str>,
    verdicts: Option<&'a [ReplayVerdict<'a>]>,
    warnings: &'a [String],
    n_recorded: usize,
    stride: usize,
    times: Vec<f64>,
    n_knots: usize,
    knots: String,
    cables: &'a [(usize, usize)],
    rest_lengths: Vec<f32>,
    bullets: [usize; 4],
    perimeter: &'a [usize],
    target: Option<PageTarget<'a>>,
    blocks: Vec<PageBlock<'a>>,
    curves: Vec<PageCurve<'a>>,
    threads: Vec<ReplayThread>,
    #[serde(skip_serializing_if = "Option::is_none")]
    loads: Option<PageLoads>,
    marks: &'a [(f64, String)],
}

/// Levels of cables and knots as base64: frame, then cable or knot.
#[derive(Serialize)]
struct PageLoads {
    tensions: String,
    breaking_n: [f64; 2],
    hits: String,
    largest_n_s: f64,
    decades: f64,
}

#[derive(Serialize)]
struct PageTarget<'a> {
    parts: &'a [ReplayMesh],
    positions: String,
    attitudes: String,
}

#[derive(Serialize)]
struct PageBlock<'a> {
    name: &'a str,
    places: String,
}

impl<'a> ReplayBlock<'a> {
    fn on_page(&self, kept: &[usize]) -> PageBlock<'a> {
        let shown = kept.iter().flat_map(|&frame| self.places[frame]);
        PageBlock { name: self.name, places: base64(shown.flat_map(|p| [p.x, p.y, p.z]), kept.len() * 27) }
    }
}

#[derive(Serialize)]
struct PageCurve<'a> {
    name: &'a str,
    unit: &'a str,
    values: Vec<f32>,
    along_slider: bool,
}

impl<'a> Page<'a> {
    /// What the page shows of `replay`: every so many frames, and always the last.
    fn of(replay: &'a Replay) -> Page<'a> {
        let n_recorded = replay.times.len();
        let n_knots = replay.knots.first().map_or(0, Vec::len);
        debug_assert_eq!(replay.knots.len(), n_recorded);
        debug_assert_eq!(replay.cables.len(), replay.rest_lengths.len());

        let stride = stride(n_recorded, n_knots);
        let kept = kept_frames(n_recorded, stride);
        Page {
            title: replay.title,
            source: replay.source,
            verdicts: replay.verdicts.as_deref(),
            warnings: replay.warnings,
            n_recorded,
            stride,
            times: kept.iter().map(|&frame| replay.times[frame]).collect(),
            n_knots,
            knots: base64(
                kept.iter().flat_map(|&frame| &replay.knots[frame]).flat_map(|p| [p.x, p.y, p.z]),
                kept.len() * n_knots * 3,
            ),
            cables: replay.cables,
            rest_lengths: replay.rest_lengths.iter().map(|&length| length as f32).collect(),
            bullets: replay.bullets,
            perimeter: replay.perimeter,
            target: replay.target.as_ref().map(|target| PageTarget {
                parts: &target.parts,
                positions: base64(
                    kept.iter().map(|&frame| target.positions[frame]).flat_map(|p| [p.x, p.y, p.z]),
                    kept.len() * 3,
                ),
                attitudes: base64(
                    kept.iter().map(|&frame| target.attitudes[frame]).flat_map(|q| [q.w, q.i, q.j, q.k]),
                    kept.len() * 4,
                ),
            }),
            blocks: replay.blocks.iter().map(|block| block.on_page(&kept)).collect(),
            curves: replay
                .curves
                .iter()
                .map(|curve| PageCurve {
                    name: curve.name,
                    unit: curve.unit,
                    values: kept.iter().map(|&frame| curve.values[frame] as f32).collect(),
                    along_slider: curve.along_slider,
                })
                .collect(),
            threads: replay.threads.iter().map(|thread| thread.thinned(&kept)).collect(),
            loads: replay.loads.as_ref().filter(|_| !kept.is_empty()).map(|loads| loads.thinned(&kept)),
            marks: &replay.marks,
        }
    }
}

/// Every how many frames one is kept, so that frames and bytes stay within their limits.
fn stride(n_frames: usize, n_knots: usize) -> usize {
    // A knot is 12 bytes, 16 in base64. Two frames always remain, first and last.
    let affordable = (MAX_KNOT_BYTES / (16 * n_knots.max(1))).clamp(2, MAX_FRAMES);
    n_frames.saturating_sub(1).div_ceil(affordable - 1).max(1)
}

/// Every `stride`-th frame and always the last.
fn kept_frames(n_frames: usize, stride: usize) -> Vec<usize> {
    let Some(last) = n_frames.checked_sub(1) else { return Vec::new() };
    (0..last).step_by(stride).chain([last]).collect()
}

/// Base64 of the numbers as little-endian f32.
fn base64(numbers: impl Iterator<Item = f64>, n_numbers: usize) -> String {
    let mut bytes = Vec::with_capacity(4 * n_numbers);
    bytes.extend(numbers.flat_map(|number| (number as f32).to_le_bytes()));
    BASE64.encode(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tension is a peak between frames: what is left out must not hide it.
    #[test]
    fn thinning_keeps_the_peaks_of_a_tension() {
        let values = vec![0.0, 5.0, 1.0, 0.0, 2.0, 3.0];
        let thread = ReplayThread {
            length_m: values.clone(),
            off_reels_m: values.clone(),
            tension_n: values,
            ..ReplayThread::default()
        };
        let thinned = thread.thinned(&[0, 3, 5]);
        assert_eq!(thinned.tension_n, [0.0, 5.0, 3.0]);
        assert_eq!(thinned.length_m, [0.0, 0.0, 3.0]);
    }

    #[test]
    fn loads_are_told_by_their_ratio_and_thinning_keeps_the_largest() {
        assert_eq!([0.0, f64::NAN, 1e-9, 1.0, 2.0].map(level), [0, 0, 1, 255, 255]);
        assert!((f64::from(level(0.1)) - 255.0 * 0.8).abs() <= 0.5);
        let tensions = vec![vec![0.0], vec![100.0], vec![1.0]];
        let impulses = vec![vec![Vector3::zeros()], vec![Vector3::x()], vec![Vector3::zeros()]];
        let loads = ReplayLoads { tensions: &tensions, breaking: &[100.0], impulses: &impulses };
        let kept = loads.thinned(&[0, 2]);
        assert_eq!(BASE64.decode(kept.tensions.as_bytes()).unwrap(), [0, 255]);
        assert_eq!(BASE64.decode(kept.hits.as_bytes()).unwrap(), [0, 255]);
        assert_eq!((kept.breaking_n, kept.largest_n_s), ([100.0, 100.0], 1.0));
    }

    #[test]
    fn thinning_keeps_the_first_and_the_last_frame() {
        assert!(kept_frames(0, 1).is_empty());
        assert_eq!(kept_frames(1, 1), [0]);
        for n_frames in [2, 3, 599, 600, 601, 1200, 3001, 100_000] {
            for n_knots in [0, 4, 441, 10_000, 1_000_000] {
                let stride = stride(n_frames, n_knots);
                let kept = kept_frames(n_frames, stride);
                assert_eq!((kept[0], kept[kept.len() - 1]), (0, n_frames - 1));
                assert!(kept.len() <= MAX_FRAMES, "{n_frames} frames of {n_knots} knots: {}", kept.len());
                assert!(kept.len() * n_knots * 16 <= MAX_KNOT_BYTES.max(2 * 16 * n_knots));
                assert!(kept.is_sorted_by(|a, b| a < b), "no frame twice");
            }
        }
        assert_eq!(stride(600, 441), 1);
    }
}
