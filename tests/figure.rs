//! Figures for print: the right curves on the right axes, labels that tell runs apart, pictures to scale.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use nalgebra::Vector3;
use serde_json::json;
use tumblenet::report::recorded::RecordedRun;

use crate::common::program::{err, printed, tumblenet, with_scene, write_scene};

/// An element of an SVG: its name, its attributes, and the text in it.
#[derive(Debug)]
struct Element {
    name: String,
    attributes: BTreeMap<String, String>,
    text: String,
}

impl Element {
    fn number(&self, attribute: &str) -> f64 {
        self.attributes[attribute].parse().unwrap_or_else(|_| panic!("{attribute} of {self:?}"))
    }

    /// Numbers of a list.
    fn numbers(&self, attribute: &str) -> Vec<f64> {
        let is_end = |c: char| !(c.is_ascii_digit() || ".-e".contains(c));
        let words = self.attributes[attribute].split(is_end).filter(|word| !word.is_empty());
        words.map(|word| word.parse().unwrap()).collect()
    }
}

/// The elements of `svg` in their order; it is well-formed, or this fails.
fn elements(svg: &str) -> Vec<Element> {
    let (mut found, mut open): (Vec<Element>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        if let Some(&inner) = open.last() {
            found[inner].text.push_str(rest[..start].trim());
        }
        let end = rest.find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        assert!(!tag.contains('<'), "{tag}");
        if let Some(name) = tag.strip_prefix('/') {
            let last = open.pop().expect("a tag was open");
            assert_eq!(found[last].name, name);
            continue;
        }
        let body = tag.trim_end_matches('/');
        let (name, attributes) = body.split_once(' ').unwrap_or((body, ""));
        let parts: Vec<&str> = attributes.split('"').collect();
        let pairs = parts.chunks(2).filter(|pair| pair.len() == 2);
        let attributes =
            pairs.map(|pair| (pair[0].trim().trim_end_matches('=').to_owned(), pair[1].to_owned()));
        let attributes = attributes.collect();
        found.push(Element { name: name.to_owned(), attributes, text: String::new() });
        if !tag.ends_with('/') {
            open.push(found.len() - 1);
        }
    }
    assert!(open.is_empty() && found[0].name == "svg", "{} left open", open.len());
    found
}

fn drawn(folder: &Path, name: &str) -> Vec<Element> {
    elements(&std::fs::read_to_string(folder.join(format!("figure-{name}.svg"))).unwrap())
}

fn texts(elements: &[Element]) -> Vec<&str> {
    elements.iter().filter(|element| element.name == "text").map(|element| element.text.as_str()).collect()
}

/// Curves with a name: points in places of the drawing.
fn curves(elements: &[Element]) -> Vec<(&str, Vec<[f64; 2]>)> {
    let mut found = Vec::new();
    for pair in elements.windows(2) {
        if pair[0].name == "polyline" && pair[1].name == "title" {
            let points = pair[0].numbers("points").chunks(2).map(|point| [point[0], point[1]]).collect();
            found.push((pair[1].text.as_str(), points));
        }
    }
    found
}

/// From a place along an axis to its number, by two of its labels: places and what stands there.
fn scale(labels: &[(f64, f64)]) -> impl Fn(f64) -> f64 {
    let [first, last] = [labels[0], labels[labels.len() - 1]];
    assert!(first.0 != last.0, "{labels:?}");
    move |place| first.1 + (place - first.0) / (last.0 - first.0) * (last.1 - first.1)
}

/// Each named curve with its points as the axes' labels say they are.
fn read_back(elements: &[Element]) -> BTreeMap<String, Vec<[f64; 2]>> {
    let labels = |anchor: &str| -> Vec<([f64; 2], f64)> {
        let is_label = |element: &&Element| {
            element.name == "text"
                && element.attributes["text-anchor"] == anchor
                && !element.attributes.contains_key("transform")
        };
        let all = elements.iter().filter(is_label);
        all.filter_map(|e| Some(([e.number("x"), e.number("y")], e.text.parse().ok()?))).collect()
    };
    let (below, beside) = (labels("middle"), labels("end"));
    let rows: BTreeSet<i64> = below.iter().map(|(at, _)| at[1] as i64).collect();
    // Labels beside a panel go up; those of the next begin further down.
    let mut panels: Vec<Vec<(f64, f64)>> = Vec::new();
    for (at, value) in beside {
        match panels.last_mut() {
            Some(panel) if panel[panel.len() - 1].0 > at[1] => panel.push((at[1], value)),
            _ => panels.push(vec![(at[1], value)]),
        }
    }
    let mut all = BTreeMap::new();
    for (name, points) in curves(elements) {
        let lowest = points.iter().map(|point| point[1]).fold(0.0, f64::max);
        let highest = points.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
        let middle = 0.5 * (lowest + highest);
        // The labels of the next horizontal axis below, and those of the panel that the curve lies in.
        let row = *rows.iter().find(|row| **row as f64 > lowest).unwrap();
        let x: Vec<(f64, f64)> =
            below.iter().filter(|(at, _)| at[1] as i64 == row).map(|(at, value)| (at[0], *value)).collect();
        let off =
            |panel: &&Vec<(f64, f64)>| (middle - middle.clamp(panel[panel.len() - 1].0, panel[0].0)).abs();
        let y = panels.iter().min_by(|one, other| off(one).total_cmp(&off(other))).unwrap();
        let (x, y) = (scale(&x), scale(y));
        let numbers = points.iter().map(|point| [x(point[0]), y(point[1])]).collect();
        assert!(all.insert(name.to_owned(), numbers).is_none(), "{name} twice");
    }
    all
}

/// A column of `series.csv`.
fn column(folder: &Path, name: &str) -> Vec<f64> {
    RecordedRun::read(folder).unwrap().series.column(name).unwrap_or_else(|| panic!("{name}")).to_vec()
}

/// The points of a curve are those of two lists, to the width of its stroke.
#[track_caller]
fn same(points: &[[f64; 2]], x: &[f64], y: &[f64]) {
    assert_eq!([points.len(), points.len()], [x.len(), y.len()]);
    for (axis, wanted) in [x, y].into_iter().enumerate() {
        let span = wanted.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        // Two places of some 2000 along the axis, and as much by the labels that it was read from.
        let apart = points.iter().zip(wanted).map(|(point, wanted)| (point[axis] - wanted).abs());
        let worst = apart.fold(0.0, f64::max);
        assert!(worst < 3e-3 * span, "{worst} of {span}");
    }
}

#[test]
fn a_figure_has_units_at_its_axes_and_the_numbers_of_the_series() {
    let folder = with_scene(|_| {});
    let at = folder.path();
    printed(at, &["run", "scene.json", "--out", "a"]);
    let told = printed(at, &["figure", "a", "--width", "85mm"]);
    let names = ["strip", "deployment", "momentum", "energy", "motion", "impulses", "closing", "tension"];
    assert_eq!(told.lines().collect::<Vec<_>>(), names.map(|name| format!("a/figure-{name}.svg")));
    let a = at.join("a");
    for name in &names[1..] {
        let elements = drawn(&a, name);
        assert_eq!(elements[0].attributes["width"], "85mm", "{name}");
        let turned = elements.iter().filter(|element| element.attributes.contains_key("transform"));
        let beside: Vec<&str> = turned.map(|element| element.text.as_str()).collect();
        assert!(!beside.is_empty() && beside.iter().all(|words| words.ends_with(']')), "{name}: {beside:?}");
        assert!(texts(&elements).iter().any(|words| words.ends_with("[s]")), "{name}");
    }
    let time = column(&a, "t_s");
    let deployment = read_back(&drawn(&a, "deployment"));
    same(&deployment["area of the bullets"], &time, &column(&a, "area_m2"));
    let way: Vec<f64> = deployment["area over distance"].iter().map(|point| point[0]).collect();
    same(&deployment["area over distance"], &way, &column(&a, "area_m2"));
    let summary = RecordedRun::read(&a).unwrap().summary.deployment;
    let longest = way.iter().copied().fold(0.0, f64::max);
    assert!(longest >= 0.999 * summary.travelling_distance_m, "{longest} and {summary:?}");
    let momentum = read_back(&drawn(&a, "momentum"));
    same(&momentum["x, momentum"], &time, &column(&a, "momentum_x_kg_m_s"));
    same(&momentum["x, angular momentum"], &time, &column(&a, "angular_momentum_x_kg_m2_s"));
    let motion = read_back(&drawn(&a, "motion"));
    same(&motion["y, spin, body axes"], &time, &column(&a, "spin_y_rad_s"));
    let start = column(&a, "target_x_m");
    let moved: Vec<f64> = start.iter().map(|x| x - start[0]).collect();
    same(&motion["x, displacement"], &time, &moved);
    let energy = read_back(&drawn(&a, "energy"));
    same(&energy["net, kinetic, energy"], &time, &column(&a, "kinetic_net_j"));
    let tension = read_back(&drawn(&a, "tension"));
    same(&tension["largest tension"], &time, &column(&a, "max_tension_n"));
    let closing = read_back(&drawn(&a, "closing"));
    same(&closing["mouth, share"], &time, &column(&a, "mouth"));
}

#[test]
fn runs_in_the_same_axes_have_labels_and_lines_that_differ() {
    let folder = with_scene(|_| {});
    let at = folder.path();
    for speed in ["1.9", "2.1"] {
        let change = format!("launch.speed_m_s={speed}");
        printed(at, &["run", "scene.json", "--set", &change, "--out", &format!("speed-{speed}")]);
    }
    let runs = ["figure", "speed-1.9", "speed-2.1", "--of", "momentum,tension,strip"];
    let told = printed(at, &runs);
    assert!(told.contains("results/figures/figure-momentum.svg"), "{told}");
    let elements = drawn(&at.join("results/figures"), "momentum");
    let words = texts(&elements);
    for label in ["1.9", "2.1"] {
        assert_eq!(words.iter().filter(|words| **words == label).count(), 1, "{words:?}");
    }
    let names: Vec<&str> = curves(&elements).iter().map(|(name, _)| *name).collect();
    assert_eq!(names.len(), 12, "{names:?}");
    assert!(names.contains(&"1.9, momentum, x") && names.contains(&"2.1, angular momentum, z"), "{names:?}");
    // Each run has its own dashes, in every panel: they are told apart without colours.
    let dashes = |run: &str| -> BTreeSet<Option<&String>> {
        let of_run =
            elements.windows(2).filter(|pair| pair[1].name == "title" && pair[1].text.starts_with(run));
        of_run.map(|pair| pair[0].attributes.get("stroke-dasharray")).collect()
    };
    let [one, other] = [dashes("1.9"), dashes("2.1")];
    assert!(one.len() == 1 && other.len() == 1 && one != other, "{one:?} {other:?}");
    let numbers = read_back(&drawn(&at.join("results/figures"), "tension"));
    let faster = at.join("speed-2.1");
    same(&numbers["2.1, largest tension"], &column(&faster, "t_s"), &column(&faster, "max_tension_n"));
    // A row of pictures each.
    let strip = drawn(&at.join("results/figures"), "strip");
    assert!(texts(&strip).starts_with(&["1.9"]) && texts(&strip).contains(&"2.1"), "{:?}", texts(&strip));
    let named = printed(at, &[&runs[..], &["--label", "slow,fast", "--out", "named"]].concat());
    assert!(named.contains("named/figure-tension.svg"), "{named}");
    assert!(texts(&drawn(&at.join("named"), "tension")).contains(&"fast"));
}

#[test]
fn a_strip_has_a_picture_for_each_time_and_view_to_one_scale() {
    let folder = with_scene(|_| {});
    let at = folder.path();
    printed(at, &["run", "scene.json", "--out", "a"]);
    let views = "side,front,oblique";
    printed(at, &["figure", "a", "--of", "strip", "--at", "0.05,0.1,0.2", "--view", views]);
    let a = at.join("a");
    let elements = drawn(&a, "strip");
    let pictures = elements.iter().filter(|element| element.name == "g").count();
    assert_eq!(pictures, 9);
    let words = texts(&elements);
    assert_eq!(words.iter().filter(|words| **words == "0.05 s").count(), 3, "{words:?}");
    assert!(views.split(',').all(|view| words.contains(&view)), "{words:?}");
    // The bar is as long as it says: by it, two bullets are as far apart as in the run.
    let bar =
        elements.iter().find(|element| element.attributes.get("class").is_some_and(|c| c == "bar")).unwrap();
    let path = &bar.attributes["d"];
    let after = |mark: char| -> f64 {
        let rest = &path[path.find(mark).unwrap() + 1..];
        rest[..rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap()].parse().unwrap()
    };
    let said: f64 = words.last().unwrap().strip_suffix(" m").unwrap().parse().unwrap();
    let scale = (after('H') - after('M')) / said;
    let run = RecordedRun::read(&a).unwrap();
    let knots: Vec<Vector3<f64>> =
        run.net.bullets.iter().map(|&knot| run.paths.at(knot, 0.1).position).collect();
    let first = elements.iter().position(|element| element.name == "g").unwrap();
    let is_picture = |element: &Element| element.name == "g";
    let second = first + 1 + elements[first + 1..].iter().position(is_picture).unwrap();
    let third = second + 1 + elements[second + 1..].iter().position(is_picture).unwrap();
    let circles: Vec<[f64; 2]> = elements[second..third]
        .iter()
        .filter(|element| element.name == "circle")
        .map(|circle| [circle.number("cx"), circle.number("cy")])
        .collect();
    assert!(circles.len() >= 2, "{circles:?}");
    let longest = |points: &[[f64; 2]]| {
        let pairs = points.iter().flat_map(|a| points.iter().map(move |b| (a[0] - b[0]).hypot(a[1] - b[1])));
        pairs.fold(0.0, f64::max)
    };
    let wide = longest(&knots.iter().map(|at| [at.x, at.z]).collect::<Vec<_>>());
    assert!((longest(&circles) / scale - wide).abs() < 0.01 * wide, "{} {wide}", longest(&circles) / scale);
}

/// Width, height, dots a metre, and the brightness of each pixel.
fn pixels(path: &Path) -> (usize, usize, u32, Vec<u8>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    let grey = data.chunks_exact(3).map(|rgb| *rgb.iter().max().unwrap()).collect();
    let dots = reader.info().pixel_dims.unwrap();
    assert_eq!((dots.xppu, dots.unit), (dots.yppu, png::Unit::Meter));
    (info.width as usize, info.height as usize, dots.xppu, grey)
}

#[test]
fn a_png_is_the_drawing_with_the_dots_that_are_asked_for() {
    let folder = with_scene(|_| {});
    let at = folder.path();
    printed(at, &["run", "scene.json", "--out", "a"]);
    let of = ["figure", "a", "--of", "strip,energy", "--at", "0.1,0.2", "--width", "85mm"];
    let told = printed(at, &[&of[..], &["--format", "svg,png", "--dpi", "150"]].concat());
    let files = ["strip.svg", "strip.png", "energy.svg", "energy.png"];
    assert_eq!(told.lines().collect::<Vec<_>>(), files.map(|name| format!("a/figure-{name}")));
    let a = at.join("a");
    for name in ["strip", "energy"] {
        let svg = drawn(&a, name);
        let (wide, high, dots, grey) = pixels(&a.join(format!("figure-{name}.png")));
        let length = |side: &str| -> f64 { svg[0].attributes[side].trim_end_matches("mm").parse().unwrap() };
        assert_eq!((wide, dots), (502, 5906)); // 85 mm at 150 dots an inch
        assert!((high as f64 / wide as f64 - length("height") / length("width")).abs() < 0.003, "{high}");
        // Where a text begins there are letters; round about the figure there is paper.
        let scale =
            wide as f64 / svg[0].attributes["viewBox"].split(' ').nth(2).unwrap().parse::<f64>().unwrap();
        let dark = |x: f64, y: f64, half: f64| {
            let near = |to: f64, most: usize| {
                ((to - half).max(0.0) as usize)..(((to + half).ceil() as usize).min(most))
            };
            let rows = near(y, high).map(|row| row * wide);
            rows.flat_map(|row| near(x, wide).map(move |column| row + column))
                .filter(|at| grey[*at] < 128)
                .count()
        };
        let is_turned = |element: &&Element| element.attributes.contains_key("transform");
        let written = svg
            .iter()
            .filter(|element| element.name == "text" && !element.text.is_empty() && !is_turned(element));
        for element in written {
            let [x, y] = ["x", "y"].map(|place| scale * element.number(place));
            assert!(dark(x, y, 12.0) > 5, "{name}: no letters of {} at {x}, {y}", element.text);
        }
        for circle in svg.iter().filter(|element| element.name == "circle") {
            let [x, y] = ["cx", "cy"].map(|place| scale * circle.number(place));
            assert!(dark(x, y, 1.0) >= 2, "{name}: no bullet at {x}, {y}");
        }
        assert!((0..wide).all(|column| grey[column] == 255) && (0..high).all(|row| grey[row * wide] == 255));
    }
    let refused = |arguments: &[&str]| err(&tumblenet(at, &[&of[..], arguments].concat()));
    assert!(refused(&["--format", "pgn"]).contains("--format: found pgn; allowed: one of svg, png"));
    assert!(refused(&["--dpi", "300"]).contains("--dpi: found 300; allowed: --format png"));
    assert!(refused(&["--format", "png", "--dpi", "5"]).contains("allowed: 72 to 1200 dots an inch"));
}

/// Grey faces of a strip's picture, as how many paths and points.
fn faces(picture: &[Element]) -> usize {
    let faces = picture.iter().filter(|element| {
        element.name == "path" && element.attributes.get("fill").is_some_and(|fill| fill != "none")
    });
    faces.map(|element| element.attributes["d"].matches('M').count()).sum()
}

#[test]
fn a_chaser_is_in_the_strip_while_it_is_near_and_its_motion_in_the_figures() {
    let chaser = json!({ "mass_kg": 12.0, "inertia_kg_m2": [0.3, 0.3, 0.3], "centre_m": [-0.2, 0.1, 0.0] });
    let folder = with_scene(|scene| {
        scene["effects"]["chaser"] = chaser.clone();
        scene["duration_s"] = json!(0.5);
    });
    let at = folder.path();
    printed(at, &["run", "scene.json", "--out", "a"]);
    let free = ["run", "scene.json", "--set", "target=null", "--set", "capture=null", "--out", "free"];
    printed(at, &free);
    let run = RecordedRun::read(&at.join("free")).unwrap();
    // The block of that mass and inertia: a side of 0.387 m, its front just behind the net.
    let [block] = &run.brought[..] else { panic!("{} bodies", run.brought.len()) };
    assert_eq!(block.name, "chaser");
    let half = block.points.iter().map(|corner| corner.x).fold(0.0, f64::max);
    assert!((half - 0.5 * (6.0_f64 * 0.3 / 12.0).sqrt()).abs() < 1e-12 && block.triangles.len() == 12);
    printed(at, &["figure", "free", "--of", "strip", "--at", "0,0.5"]);
    let strip = drawn(&at.join("free"), "strip");
    let starts: Vec<usize> = (0..strip.len()).filter(|n| strip[*n].name == "g").collect();
    assert_eq!(faces(&strip[starts[0]..starts[1]]), 2, "the side of the block that is seen");
    assert_eq!(faces(&strip[starts[1]..]), 0, "the net has flown far from it");
    printed(at, &["figure", "a", "--of", "motion"]);
    let motion = read_back(&drawn(&at.join("a"), "motion"));
    let a = at.join("a");
    let start = column(&a, "chaser_x_m");
    let moved: Vec<f64> = start.iter().map(|x| x - start[0]).collect();
    assert!(*moved.last().unwrap() < -1e-3);
    same(&motion["x, chaser, displacement"], &column(&a, "t_s"), &moved);
    same(&motion["z, chaser, spin"], &column(&a, "t_s"), &column(&a, "chaser_spin_z_rad_s"));
}

#[test]
fn what_cannot_be_drawn_is_told_all_at_once() {
    let folder = with_scene(|_| {});
    let at = folder.path();
    write_scene(at, |scene| {
        scene.as_object_mut().unwrap().remove("target");
        scene.as_object_mut().unwrap().remove("capture");
        scene["duration_s"] = json!(0.05);
    });
    printed(at, &["run", "scene.json", "--out", "free"]);
    std::fs::create_dir(at.join("empty")).unwrap();
    let refused = |arguments: &[&str]| {
        let output = tumblenet(at, &[&["figure"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", err(&output));
        err(&output)
    };
    let told = refused(&["empty", "--of", "momentm", "--view", "sid", "--at", "soon", "--width", "85"]);
    for words in [
        "--of: found momentm; allowed: did you mean momentum?",
        "--view: found sid; allowed: did you mean side?",
        "--at: found soon; allowed: times in seconds",
        "--width: found 85; allowed: a width from 60mm to 300mm, as in 85mm",
        "empty.trajectory.npz: found no such file",
        "empty.summary.json: found ",
    ] {
        assert!(told.contains(words), "{words} not in {told}");
    }
    let told = refused(&["free", "--of", "motion,impulses", "--at", "0.01,7"]);
    for words in [
        "--at: found 7; allowed: a time of free: 0 to 0.05 s",
        "--of: found motion; allowed: figures that need no target: free has none",
        "--of: found impulses",
    ] {
        assert!(told.contains(words), "{words} not in {told}");
    }
    assert!(refused(&["nowhere"]).contains("a built-in scene"));
    assert!(refused(&["free", "free", "--label", "one"]).contains("one for each of 2 runs"));
    assert!(refused(&["free", "--set", "duration_s=1"]).contains("runs that are over"));
    std::fs::write(at.join("free/series.csv"), "t_s,area_m2\n0,soon\n").unwrap();
    assert!(refused(&["free"]).contains("series.csv.line 2: found no row of numbers"));
    assert!(!at.join("free/figure-strip.svg").exists(), "nothing was written");
}

#[test]
fn a_scene_is_run_first_and_what_a_run_without_a_target_has_is_drawn() {
    let folder = with_scene(|scene| scene["duration_s"] = json!(0.05));
    let told =
        printed(folder.path(), &["figure", "scene.json", "--set", "target=null", "--set", "capture=null"]);
    let names = ["strip", "deployment", "momentum", "energy", "tension"];
    let places = names.map(|name| format!("results/scene/figure-{name}.svg"));
    assert_eq!(told.lines().collect::<Vec<_>>(), places);
    assert!(folder.path().join("results/scene/replay.html").exists());
}
