//! The replay: one run in motion, as one self-contained HTML page.
//!
//! The page (in `replay/`: its frame, its look, and its script in the order of `SCRIPTS`) draws with the
//! browser's own WebGL, or with a plain canvas where there is none, and loads nothing from anywhere. Here the run
//! is put into it. The address may say where to start: `#t=1.5&view=side&paused&speed=0.5&show=bullet-paths,-grid`; views are `overview`, `side`, `front`,
//! `top`, `net` and `target`. Further runs are shown in step with the first, as ghosts within it or beside it
//! ([`together`]).
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
use serde_json::Value;

use super::template::fill;

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
    /// Threads and winches, if there are any.
    pub closing: Option<ReplayClosing>,
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

/// The closing mechanism.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ReplayClosing {
    /// When the winches started; null: never. [s]
    pub start_s: Option<f64>,
    /// Largest tension of a thread. [N]
    pub limit_n: f64,
    /// Where a thread that is wound outside of the net ends, without a body to end at. [m]
    pub anchor_m: [f64; 3],
    /// Name of that body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub port_of: Option<&'static str>,
    /// The threads.
    pub threads: Vec<ReplayThread>,
}

/// A closing thread.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ReplayThread {
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
            way: self.way.clone(),
            stop_m: self.stop_m,
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
    closing: Option<ReplayClosing>,
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

const TEMPLATE: &str = include_str!("replay/page.html");

const STYLE: &str = include_str!("replay/page.css");

/// The page's script, one subject a file. They share one scope: what stands in a file is known to those after it.
const SCRIPTS: [&str; 16] = [
    include_str!("replay/run.js"),
    include_str!("replay/maths.js"),
    include_str!("replay/ghosts.js"),
    include_str!("replay/loads.js"),
    include_str!("replay/camera.js"),
    include_str!("replay/compose.js"),
    include_str!("replay/webgl.js"),
    include_str!("replay/canvas.js"),
    include_str!("replay/picture.js"),
    include_str!("replay/panel.js"),
    include_str!("replay/winches.js"),
    include_str!("replay/strip.js"),
    include_str!("replay/play.js"),
    include_str!("replay/controls.js"),
    include_str!("replay/save.js"),
    include_str!("replay/start.js"),
];

/// The page as text.
pub fn html(replay: &Replay) -> String {
    let data = serde_json::to_string(&Page::of(replay)).expect("plain numbers and text always serialise");
    page(replay.title, &data)
}

/// Where the data stand in a page.
const DATA: [&str; 2] = ["<script type=\"application/json\" id=\"data\">", "</script>"];

/// The data in the text of a page; none where it is no page of ours.
pub fn data(page: &str) -> Option<Value> {
    let (_, rest) = page.split_once(DATA[0])?;
    let (json, _) = rest.split_once(DATA[1])?;
    let data: Value = serde_json::from_str(json).ok()?;
    let has = |key: &str, is: fn(&Value) -> bool| data.get(key).is_some_and(is);
    let is_ours = has("times", Value::is_array)
        && has("knots", Value::is_string)
        && has("cables", Value::is_array)
        && has("curves", Value::is_array);
    is_ours.then_some(data)
}

/// The page of several runs, each with its name and the data of its own page: the first as in its own, the others in step
/// with it.
pub fn together(runs: Vec<(String, Value)>) -> String {
    let mut runs = runs.into_iter().map(|(label, mut data)| {
        data["label"] = label.into();
        data
    });
    let Some(mut first) = runs.next() else { return String::new() };
    // What a ghost shows no more than its first shows, it need not carry.
    let others: Vec<Value> = runs
        .map(|mut other| {
            for unused in ["loads", "closing", "warnings", "rest_lengths", "perimeter", "marks", "source"] {
                other.as_object_mut().map(|map| map.remove(unused));
            }
            other
        })
        .collect();
    let names = std::iter::once(&first).chain(&others).filter_map(|data| data["label"].as_str());
    let title = names.collect::<Vec<_>>().join(", ");
    if !others.is_empty() {
        first["others"] = others.into();
        first["title"] = title.clone().into();
    }
    page(first["title"].as_str().unwrap_or(&title), &first.to_string())
}

/// The page with `data`, which is JSON.
fn page(title: &str, data: &str) -> String {
    let parts = [
        ("title", text_safe(title)),
        ("style", STYLE.to_owned()),
        ("data", script_safe(data)),
        ("script", SCRIPTS.join("\n")),
    ];
    fill(TEMPLATE, &parts.each_ref().map(|(name, text)| (*name, text.as_str())))
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
            closing: replay.closing.as_ref().map(|closing| ReplayClosing {
                threads: closing.threads.iter().map(|thread| thread.thinned(&kept)).collect(),
                ..closing.clone()
            }),
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

/// JSON that may stand in a script element: `</script>` and `<!--` cannot occur in it. Outside of strings JSON
/// has none of these characters, so that each stands in a string, where the escape means the same.
fn script_safe(json: &str) -> String {
    json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

/// Text that may stand in an element.
fn text_safe(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A net that unfolds, flies at a tumbling box and closes round it: made up, so that the page can be looked
    /// at without a simulation.
    struct Demo {
        times: Vec<f64>,
        knots: Vec<Vec<Vector3<f64>>>,
        cables: Vec<(usize, usize)>,
        rest_lengths: Vec<f64>,
        bullets: [usize; 4],
        perimeter: Vec<usize>,
        positions: Vec<Vector3<f64>>,
        attitudes: Vec<UnitQuaternion<f64>>,
        curves: Vec<(&'static str, &'static str, Vec<f64>)>,
    }

    impl Demo {
        #[expect(clippy::too_many_lines, reason = "a made-up capture, told in one piece")]
        fn new(side: usize, n_frames: usize) -> Demo {
            let length = 0.7 / (side - 1) as f64;
            let at = |row: usize, column: usize| row * side + column;
            let mut cables = Vec::new();
            for row in 0..side {
                for column in 0..side {
                    if row + 1 < side {
                        cables.push((at(row, column), at(row + 1, column)));
                    }
                    if column + 1 < side {
                        cables.push((at(row, column), at(row, column + 1)));
                    }
                }
            }
            let last = side - 1;
            let perimeter = (0..last)
                .map(|k| at(k, 0))
                .chain((0..last).map(|k| at(last, k)))
                .chain((0..last).map(|k| at(last - k, last)))
                .chain((0..last).map(|k| at(0, last - k)))
                .collect();
            let times: Vec<f64> = (0..n_frames).map(|k| 3.0 * k as f64 / (n_frames - 1) as f64).collect();
            let ease = |t: f64, from: f64, to: f64| {
                let u = ((t - from) / (to - from)).clamp(0.0, 1.0);
                u * u * (3.0 - 2.0 * u)
            };
            let knots = times
                .iter()
                .map(|&t| {
                    let (open, wrap) = (0.1 + 0.9 * ease(t, 0.0, 0.7), ease(t, 0.75, 1.9));
                    let centre = 1.3 * ease(t, -0.4, 1.1) - 0.1;
                    (0..side * side)
                        .map(|k| {
                            let (y, z) = (
                                (k / side) as f64 / last as f64 - 0.5,
                                (k % side) as f64 / last as f64 - 0.5,
                            );
                            let (radius, angle) = (0.7 * y.hypot(z), z.atan2(y));
                            // Wrapped, the sheet bends into a bag whose arc length is the radius on the sheet.
                            let bend = wrap * radius / 0.19 + 1e-9;
                            let ripple =
                                0.012 * (1.0 - open + 0.3 * wrap) * (9.0 * angle + 40.0 * radius).sin();
                            let lead = 0.12 * (1.0 - wrap) * ease(t, 0.0, 0.5) * (radius / 0.5).powi(2);
                            let ring = open * radius * bend.sin() / bend;
                            let forth = radius * (1.0 - bend.cos()) / bend + lead + ripple;
                            Vector3::new(centre + forth, ring * angle.cos(), ring * angle.sin())
                        })
                        .collect()
                })
                .collect();
            let turned = |t: f64| 2.0 * t - 0.15 * ease(t, 0.8, 3.0);
            let enclosed: Vec<f64> = times.iter().map(|&t| 0.87 * ease(t, 0.8, 1.6)).collect();
            let mouth =
                times.iter().map(|&t| 0.01 + 0.99 * ease(t, 0.0, 0.7) - 0.96 * ease(t, 0.8, 1.9)).collect();
            let separation: Vec<f64> = times.iter().map(|&t| 4.2 - 4.0 * ease(t, -0.4, 1.1)).collect();
            let cqi = separation.iter().map(|s| if *s > 3.3 { f64::NAN } else { 0.1 + 0.8 * s }).collect();
            Demo {
                rest_lengths: vec![length; cables.len()],
                cables,
                bullets: [at(0, 0), at(last, 0), at(last, last), at(0, last)],
                perimeter,
                positions: times
                    .iter()
                    .map(|&t| Vector3::new(1.3 + 0.1 * ease(t, 0.8, 3.2), 0.0, 0.0))
                    .collect(),
                attitudes: times
                    .iter()
                    .map(|&t| UnitQuaternion::from_euler_angles(turned(t), 0.1 * t, 0.0))
                    .collect(),
                curves: vec![
                    ("enclosed", "", enclosed),
                    ("mouth", "", mouth),
                    ("separation", "", separation),
                    ("CQI", "", cqi),
                    ("target spin", "rad/s", times.iter().map(|&t| 2.0 - 0.3 * ease(t, 0.8, 3.0)).collect()),
                ],
                times,
                knots,
            }
        }

        /// Four threads along the sides, reeled in from 0.8 s to 1.9 s.
        fn closing(&self) -> ReplayClosing {
            let side = self.perimeter.len() / 4;
            let knot = |i: usize| self.perimeter[i % self.perimeter.len()];
            let wound = |t: f64| 0.7 - 0.6 * ((t - 0.8) / 1.1).clamp(0.0, 1.0);
            let off: Vec<f64> = self.times.iter().map(|&t| wound(t)).collect();
            let tension = |&t: &f64| if t > 0.8 { (2.0 * (t - 0.8)).min(1.0) } else { 0.0 };
            let thread = |n: usize| ReplayThread {
                way: (n * side..=(n + 1) * side).map(|i| Some(knot(i))).collect(),
                stop_m: 0.1,
                length_m: off.clone(),
                off_reels_m: off.clone(),
                tension_n: self.times.iter().map(tension).collect(),
            };
            ReplayClosing {
                start_s: Some(0.8),
                limit_n: 1.0,
                anchor_m: [0.0; 3],
                port_of: None,
                threads: (0..4).map(thread).collect(),
            }
        }

        fn replay<'a>(&'a self, title: &'a str, parts: Option<Vec<ReplayMesh>>) -> Replay<'a> {
            Replay {
                title,
                source: Some("made up, to look at the page"),
                warnings: &[],
                verdicts: parts.is_some().then(|| {
                    vec![
                        ReplayVerdict { from_s: 0.0, words: "not held yet", held: None },
                        ReplayVerdict { from_s: 1.9, words: "held so far", held: Some(true) },
                    ]
                }),
                times: &self.times,
                knots: &self.knots,
                cables: &self.cables,
                rest_lengths: &self.rest_lengths,
                bullets: self.bullets,
                perimeter: &self.perimeter,
                blocks: Vec::new(),
                marks: if parts.is_some() {
                    vec![(0.8, "first contact".into()), (1.9, "captured".into())]
                } else {
                    vec![(0.7, "largest area".into())]
                },
                closing: parts.is_some().then(|| self.closing()),
                loads: None,
                curves: self
                    .curves
                    .iter()
                    .filter(|(name, ..)| parts.is_some() || *name == "mouth")
                    .map(|(name, unit, values)| Curve {
                        name,
                        unit,
                        values: values.into(),
                        along_slider: ["enclosed", "mouth"].contains(name),
                    })
                    .collect(),
                target: parts.map(|parts| ReplayTarget {
                    parts,
                    positions: &self.positions,
                    attitudes: &self.attitudes,
                }),
            }
        }
    }

    fn cuboid(sides: [f32; 3], centre: [f32; 3]) -> ReplayMesh {
        let vertices = (0..8)
            .map(|corner| [0, 1, 2].map(|k| centre[k] + ((corner >> k & 1) as f32 - 0.5) * sides[k]))
            .collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        ReplayMesh { vertices, triangles }
    }

    /// A closed cylinder along y.
    fn cylinder(radius: f32, length: f32, centre: [f32; 3]) -> ReplayMesh {
        let n = 32;
        let mut mesh = ReplayMesh::default();
        for k in 0..n {
            let (sin, cos) = (TAU as f32 * k as f32 / n as f32).sin_cos();
            for y in [-0.5, 0.5] {
                mesh.vertices.push([
                    centre[0] + radius * cos,
                    centre[1] + y * length,
                    centre[2] + radius * sin,
                ]);
            }
        }
        for k in 0..n {
            let (a, b) = (2 * k, 2 * ((k + 1) % n));
            mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
            if k > 0 {
                mesh.triangles.extend([[0, a, b], [1, b + 1, a + 1]]);
            }
        }
        mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        mesh
    }

    fn cubesat() -> Vec<ReplayMesh> {
        vec![
            cuboid([0.1, 0.3, 0.1], [0.0; 3]),
            cuboid([0.22, 0.08, 0.004], [0.0, 0.1, 0.052]),
            cylinder(0.03, 0.04, [0.0, -0.17, 0.0]),
        ]
    }

    /// What stands in the page as data, read the way a browser reads it: up to the first closing tag.
    fn data_of(page: &str) -> serde_json::Value {
        let open = r#"<script type="application/json" id="data">"#;
        let start = page.find(open).unwrap() + open.len();
        let end = start + page[start..].find("</script").unwrap();
        serde_json::from_str(&page[start..end]).unwrap()
    }

    fn numbers(value: &serde_json::Value) -> Vec<f32> {
        let bytes = BASE64.decode(value.as_str().unwrap().as_bytes()).unwrap();
        bytes.chunks_exact(4).map(|word| f32::from_le_bytes(word.try_into().unwrap())).collect()
    }

    #[test]
    fn a_title_cannot_break_out_of_the_page() {
        let title = r#"</script><script>alert(1)</script><!-- "it's" {{data}} & {{title}}"#;
        let demo = Demo::new(3, 4);
        let page = html(&demo.replay(title, None));
        assert!(!page.contains("alert(1)</script"));
        assert_eq!(page.matches("</script>").count(), TEMPLATE.matches("</script>").count());
        assert!(SCRIPTS.iter().all(|script| !script.contains("</script")));
        assert!(page.contains("<title>&lt;/script&gt;&lt;script&gt;alert(1)"));
        assert_eq!(data_of(&page)["title"], title);
    }

    #[test]
    fn every_number_arrives_within_f32() {
        let demo = Demo::new(4, 7);
        let data = data_of(&html(&demo.replay("t", Some(cubesat()))));
        let knots = numbers(&data["knots"]);
        assert_eq!(knots.len(), 7 * 16 * 3);
        for (frame, recorded) in demo.knots.iter().enumerate() {
            for (knot, point) in recorded.iter().enumerate() {
                for axis in 0..3 {
                    assert!((knots[(frame * 16 + knot) * 3 + axis] as f64 - point[axis]).abs() < 1e-7);
                }
            }
        }
        assert_eq!(numbers(&data["target"]["positions"]).len(), 7 * 3);
        let attitudes = numbers(&data["target"]["attitudes"]);
        assert_eq!(attitudes.len(), 7 * 4);
        assert_eq!(attitudes[4 * 6], demo.attitudes[6].w as f32, "w comes first");
        assert_eq!(data["cables"].as_array().unwrap().len(), data["rest_lengths"].as_array().unwrap().len());
    }

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
    fn several_runs_are_one_page_and_what_is_no_page_is_told() {
        let demo = Demo::new(3, 4);
        let pages = ["</script>a", "b"].map(|title| html(&demo.replay(title, Some(cubesat()))));
        let runs = pages.iter().zip(["1.0", "{{data}}"]);
        let runs = runs.map(|(page, label)| (label.to_owned(), data(page).unwrap())).collect();
        let page = together(runs);
        let both = data_of(&page);
        assert_eq!((&both["title"], &both["label"]), (&"1.0, {{data}}".into(), &"1.0".into()));
        assert_eq!(both["others"][0]["label"], "{{data}}");
        assert_eq!(both["others"][0]["knots"], both["knots"]);
        assert!(both["others"][0].get("closing").is_none() && both.get("closing").is_some());
        let alone = together(vec![("1.0".to_owned(), data(&pages[0]).unwrap())]);
        assert_eq!(data_of(&alone)["title"], "</script>a");
        assert!(data("<html></html>").is_none() && data(&pages[0].replace("\"knots\"", "\"no\"")).is_none());
    }

    #[test]
    fn a_value_that_is_not_finite_becomes_a_gap() {
        let demo = Demo::new(3, 4);
        let data = data_of(&html(&demo.replay("t", Some(cubesat()))));
        assert!(data["curves"][3]["values"][0].is_null());
        assert!(data["curves"][3]["values"][3].is_number());
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

    #[test]
    fn a_large_run_stays_below_ten_megabytes() {
        let demo = Demo::new(21, 1201);
        let page = html(&demo.replay("21 by 21 knots", Some(cubesat())));
        let data = data_of(&page);
        assert_eq!(data["stride"], 3);
        assert_eq!(data["times"].as_array().unwrap().len(), 401);
        assert_eq!(data["times"][400], 3.0);
        assert!(page.len() < 10_000_000, "{} bytes", page.len()); // measured 2.94 MB
    }

    #[test]
    fn a_run_without_frames_still_makes_a_page() {
        let mut demo = Demo::new(3, 2);
        demo.times.clear();
        demo.knots.clear();
        let mut replay = demo.replay("nothing", None);
        replay.curves.clear();
        assert_eq!(data_of(&html(&replay))["n_recorded"], 0);
    }

    /// Writes pages to look at; prints where.
    #[test]
    #[ignore = "writes files to look at"]
    fn pages_to_look_at() {
        let directory = std::env::temp_dir().join("tumblenet-replay");
        std::fs::create_dir_all(&directory).unwrap();
        let (small, large) = (Demo::new(11, 301), Demo::new(21, 1201));
        let title = "3U Cubesat tumbling at 2 rad/s about x, closing thread";
        for (name, replay) in [
            ("capture", small.replay(title, Some(cubesat()))),
            ("deployment", small.replay("Deployment only", None)),
            ("large", large.replay("21 by 21 knots", Some(cubesat()))),
        ] {
            let (path, page) = (directory.join(name).with_extension("html"), html(&replay));
            std::fs::write(&path, &page).unwrap();
            println!("{} {:.2} MB", path.display(), page.len() as f64 / 1e6);
        }
    }
}
