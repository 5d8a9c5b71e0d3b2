//! What a run is written as for other programs. `tests/exchange.py` reads it back with theirs.

use crate::common::program::{printed, tumblenet, with_scene};
use data_encoding::BASE64;
use ndarray::{Array3, Axis};
use ndarray_npy::NpzReader;
use serde_json::{Value, json};

/// The numbers of the first array `name` in a `.vtp` file.
fn vtk_numbers(text: &str, name: &str) -> Vec<f64> {
    let (_, after) = text.split_once(&format!("Name=\"{name}\"")).unwrap();
    let (_, after) = after.split_once('>').unwrap();
    let bytes = BASE64.decode(after.split_once('<').unwrap().0.as_bytes()).unwrap();
    let [count, numbers] = [&bytes[..8], &bytes[8..]];
    assert_eq!(u64::from_le_bytes(count.try_into().unwrap()) as usize, numbers.len());
    numbers.chunks(8).map(|number| f64::from_le_bytes(number.try_into().unwrap())).collect()
}

#[test]
fn other_programs_are_told_the_same_numbers() {
    let folder = with_scene(|_| {});
    let folder = folder.path();
    printed(folder, &["run", "scene.json", "--out", "o", "--export", "vtk,gltf"]);
    let out = folder.join("o");
    let mut arrays = NpzReader::new(std::fs::File::open(out.join("trajectory.npz")).unwrap()).unwrap();
    let knots: Array3<f64> = arrays.by_name("knots").unwrap();

    let list = std::fs::read_to_string(out.join("vtk/run.pvd")).unwrap();
    let n_frames = knots.len_of(Axis(0));
    assert_eq!(list.matches("name=\"net\"").count(), n_frames);
    assert_eq!(list.matches("name=\"target\"").count(), n_frames);
    for frame in 0..n_frames {
        let text = std::fs::read_to_string(out.join(format!("vtk/net_{frame:06}.vtp"))).unwrap();
        let here = knots.index_axis(Axis(0), frame);
        assert_eq!(vtk_numbers(&text, "points"), here.iter().copied().collect::<Vec<_>>());
    }

    let bytes = std::fs::read(out.join("run.glb")).unwrap();
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], number(8)), (&b"glTF"[..], bytes.len()));
    let text: Value = serde_json::from_slice(&bytes[20..20 + number(12)]).unwrap();
    let blob = 20 + number(12) + 8;
    for knot in 0..knots.len_of(Axis(1)) {
        let node = text["nodes"].as_array().unwrap().iter().position(|n| n["name"] == format!("knot {knot}"));
        let motion = &text["animations"][0];
        let is_its = |channel: &&Value| channel["target"]["node"] == json!(node);
        let channel = motion["channels"].as_array().unwrap().iter().find(is_its).unwrap();
        let at = |value: &Value| value.as_u64().unwrap() as usize;
        let accessor = &text["accessors"][at(&motion["samplers"][at(&channel["sampler"])]["output"])];
        let begin = blob + at(&text["bufferViews"][at(&accessor["bufferView"])]["byteOffset"]);
        let path = bytes[begin..].chunks(4).map(|number| f32::from_le_bytes(number.try_into().unwrap()));
        let path: Vec<f32> = path.take(3 * n_frames).collect();
        let there: Vec<f32> = knots.index_axis(Axis(1), knot).iter().map(|number| *number as f32).collect();
        assert_eq!(path, there, "knot {knot}");
    }
}

/// Frames of an earlier run, which had more of them, do not stay beside those of a shorter one.
#[test]
fn a_shorter_run_leaves_no_frame_of_a_longer_one() {
    let folder = with_scene(|_| {});
    let folder = folder.path();
    let files = || std::fs::read_dir(folder.join("o/vtk")).unwrap().count();
    printed(folder, &["run", "scene.json", "--out", "o", "--export", "vtk"]);
    let before = files();
    printed(folder, &["run", "scene.json", "--out", "o", "--export", "vtk", "--set", "duration_s=0.1"]);
    assert!(files() < before, "{} of {before}", files());
    let refused = tumblenet(folder, &["run", "scene.json", "--export", "stl"]);
    assert_eq!(refused.status.code(), Some(2));
}
