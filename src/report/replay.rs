//! The replay: one run in motion, as one self-contained HTML page.
//!
//! The page (in `replay/`: its frame, its look, and its script in the order of `SCRIPTS`) draws with the
//! browser's own WebGL, or with a plain canvas where there is none, and loads nothing from anywhere. Here the run
//! is put into it. The address may say where to start: `#t=1.5&view=side&paused&speed=0.5&show=bullet-paths,-grid`; views are `overview`, `side`, `front`,
//! `top`, `net` and `target`. Further runs are shown in step with the first, as ghosts within it or beside it
//! ([`together`]).

use serde_json::Value;

use super::template::fill;

#[doc(inline)]
pub use tumblenet_core::report::replay::*;

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
    page(replay.title, &json(replay))
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
    // What a ghost shows no more than its first shows, it need not carry; older pages have their threads as `closing`.
    let others: Vec<Value> = runs
        .map(|mut other| {
            for unused in
                ["loads", "threads", "closing", "warnings", "rest_lengths", "perimeter", "marks", "source"]
            {
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
    use data_encoding::BASE64;
    use nalgebra::{UnitQuaternion, Vector3};
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
        fn threads(&self) -> Vec<ReplayThread> {
            let side = self.perimeter.len() / 4;
            let knot = |i: usize| self.perimeter[i % self.perimeter.len()];
            let wound = |t: f64| 0.7 - 0.6 * ((t - 0.8) / 1.1).clamp(0.0, 1.0);
            let off: Vec<f64> = self.times.iter().map(|&t| wound(t)).collect();
            let tension = |&t: &f64| if t > 0.8 { (2.0 * (t - 0.8)).min(1.0) } else { 0.0 };
            let thread = |n: usize| ReplayThread {
                start_s: Some(0.8),
                limit_n: 1.0,
                anchor_m: [0.0; 3],
                port_of: None,
                way: (n * side..=(n + 1) * side).map(|i| Some(knot(i))).collect(),
                stop_m: 0.1,
                length_m: off.clone(),
                off_reels_m: off.clone(),
                tension_n: self.times.iter().map(tension).collect(),
            };
            (0..4).map(thread).collect()
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
                threads: if parts.is_some() { self.threads() } else { Vec::new() },
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
        assert!(both["others"][0].get("threads").is_none() && both.get("threads").is_some());
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
