//! A run as an animation in one file, `run.glb` (glTF 2.0), for Blender and other tools that draw.
//!
//! | node | what moves it |
//! |---|---|
//! | `knot 0`, `knot 1`, … | its path; the bullets carry a body to be seen |
//! | `net` | a line a cable, each end with the weight 1 on its knot's node: a skin, so that lines follow |
//! | `target`, `chaser` and the like | pose by pose, triangles of their parts |
//!
//! Metres and seconds, in the local frame (X along the flight); numbers of 32 bits, as glTF has them.

use std::io::Write;
use std::path::{Path, PathBuf};

use nalgebra::{UnitQuaternion, Vector3};
use serde_json::{Value, json};

use super::files::{self, WriteError};
use crate::case::Case;
use crate::geometry::Hull;
use crate::run::Run;
use crate::state::Body;
use crate::target::parts::ConvexPart;

const FILE: &str = "run.glb";

// Kinds of numbers, as glTF counts them.
const FLOAT: u32 = 5126;
const WHOLE: u32 = 5125;
const SHORT: u32 = 5123;

const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// Writes `run` to `run.glb` in the folder `out`.
///
/// # Errors
/// It cannot be written.
pub fn write(out: &Path, case: &Case, run: &Run) -> Result<PathBuf, WriteError> {
    let mut scene = GltfScene::default();
    let times: Vec<f32> = run.frames.time.iter().map(|time| *time as f32).collect();
    let bounds = [times[0], times[times.len() - 1]];
    scene.times = scene.array(&times, "SCALAR", Some(json!({ "min": [bounds[0]], "max": [bounds[1]] })));
    net(&mut scene, case, run);
    if let Some(target) = case.target() {
        let parts = target.parts.iter().filter_map(ConvexPart::hull);
        scene.body("target", parts, &run.frames.target, [0.35, 0.4, 0.5]);
    }
    for track in &run.frames.brought {
        let block = Hull::of(&track.model.corners());
        scene.body(&track.model.name, block.into_iter(), &track.frames, [0.6, 0.6, 0.6]);
    }
    let place = out.join(FILE);
    files::write(&place, |file| scene.write(&case.scene().title, file))?;
    Ok(place)
}

/// A glTF as it grows.
#[derive(Default)]
struct GltfScene {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    skins: Vec<Value>,
    samplers: Vec<Value>,
    channels: Vec<Value>,
    /// Those that nothing else carries.
    roots: Vec<usize>,
    /// The accessor of the times.
    times: usize,
}

/// Three numbers of 32 bits.
fn single(vector: &Vector3<f64>) -> [f32; 3] {
    [vector.x as f32, vector.y as f32, vector.z as f32]
}

impl GltfScene {
    /// Numbers, as entries of the kind `shape`; `more` goes into the accessor.
    fn array(&mut self, numbers: &[f32], shape: &str, more: Option<Value>) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let components = match shape {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(&bytes, FLOAT, shape, numbers.len() / components, more)
    }

    fn accessor(&mut self, bytes: &[u8], kind: u32, shape: &str, count: usize, more: Option<Value>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        let mut accessor = json!({ "bufferView": self.views.len() - 1, "componentType": kind, "type": shape, "count": count });
        if let (Value::Object(accessor), Some(Value::Object(more))) = (&mut accessor, more) {
            accessor.extend(more);
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Corners of a mesh, with the bounds that glTF wants of them.
    fn positions(&mut self, points: &[Vector3<f64>]) -> usize {
        let numbers: Vec<f32> = points.iter().flat_map(single).collect();
        let bound = |pick: fn(f32, f32) -> f32, start: f32| -> Vec<f32> {
            (0..3).map(|axis| numbers.iter().skip(axis).step_by(3).copied().fold(start, pick)).collect()
        };
        let bounds = json!({ "min": bound(f32::min, f32::MAX), "max": bound(f32::max, f32::MIN) });
        self.array(&numbers, "VEC3", Some(bounds))
    }

    fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor(&bytes, WHOLE, "SCALAR", indices.len(), None)
    }

    fn mesh(&mut self, name: &str, attributes: &Value, indices: usize, mode: u32, colour: [f32; 3]) -> usize {
        let [red, green, blue] = colour;
        self.materials.push(json!({ "name": name, "doubleSided": true,
            "pbrMetallicRoughness": { "baseColorFactor": [red, green, blue, 1.0], "metallicFactor": 0.1 } }));
        let primitive = json!({ "attributes": attributes, "indices": indices, "mode": mode,
            "material": self.materials.len() - 1 });
        self.meshes.push(json!({ "name": name, "primitives": [primitive] }));
        self.meshes.len() - 1
    }

    /// A mesh of hulls.
    fn hulls(&mut self, name: &str, hulls: impl Iterator<Item = Hull>, colour: [f32; 3]) -> usize {
        let (mut points, mut corners) = (Vec::new(), Vec::new());
        for hull in hulls {
            let first = points.len() as u32;
            points.extend(&hull.vertices);
            corners.extend(hull.triangles.iter().flatten().map(|corner| first + corner));
        }
        let (positions, indices) = (self.positions(&points), self.indices(&corners));
        self.mesh(name, &json!({ "POSITION": positions }), indices, TRIANGLES, colour)
    }

    fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.roots.push(self.nodes.len() - 1);
        self.nodes.len() - 1
    }

    /// `what` of `node` is `numbers` frame by frame.
    fn animate(&mut self, node: usize, what: &str, numbers: &[f32]) {
        let shape = if what == "rotation" { "VEC4" } else { "VEC3" };
        let output = self.array(numbers, shape, None);
        self.samplers.push(json!({ "input": self.times, "output": output, "interpolation": "LINEAR" }));
        let target = json!({ "node": node, "path": what });
        self.channels.push(json!({ "sampler": self.samplers.len() - 1, "target": target }));
    }

    fn body(&mut self, name: &str, hulls: impl Iterator<Item = Hull>, poses: &[Body], colour: [f32; 3]) {
        let Some(first) = poses.first() else { return };
        let mesh = self.hulls(name, hulls, colour);
        let turn = |attitude: &UnitQuaternion<f64>| -> [f32; 4] {
            std::array::from_fn(|part| attitude.coords[part] as f32)
        };
        let node = self.node(json!({ "name": name, "mesh": mesh, "translation": single(&first.position),
            "rotation": turn(&first.attitude) }));
        let positions: Vec<f32> = poses.iter().flat_map(|body| single(&body.position)).collect();
        self.animate(node, "translation", &positions);
        let mut turns = Vec::with_capacity(4 * poses.len());
        let mut before = first.attitude;
        for body in poses {
            // The shorter way from pose to pose: both signs are the same attitude.
            let attitude = if before.coords.dot(&body.attitude.coords) < 0.0 {
                UnitQuaternion::new_unchecked(-body.attitude.into_inner())
            } else {
                body.attitude
            };
            turns.extend(turn(&attitude));
            before = attitude;
        }
        self.animate(node, "rotation", &turns);
    }

    fn write(&self, title: &str, file: &mut impl Write) -> std::io::Result<()> {
        let length = self.bytes.len().next_multiple_of(4);
        let mut all = json!({
            "asset": { "version": "2.0", "generator": concat!("tumblenet ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "name": title, "nodes": self.roots }],
            "nodes": self.nodes, "meshes": self.meshes, "materials": self.materials,
            "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{ "byteLength": length }],
            "skins": self.skins,
        });
        // A run of one frame has no motion, and glTF no animation without it.
        if !self.channels.is_empty() {
            all["animations"] =
                json!([{ "name": title, "samplers": self.samplers, "channels": self.channels }]);
        }
        let mut text = all.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunk = |bytes: usize, kind: &[u8; 4]| [&(bytes as u32).to_le_bytes()[..], kind].concat();
        let whole = 12 + 8 + text.len() + 8 + length;
        file.write_all(b"glTF")?;
        file.write_all(&2_u32.to_le_bytes())?;
        file.write_all(&(whole as u32).to_le_bytes())?;
        file.write_all(&chunk(text.len(), b"JSON"))?;
        file.write_all(&text)?;
        file.write_all(&chunk(length, b"BIN\0"))?;
        file.write_all(&self.bytes)?;
        file.write_all(&[0; 4][..length - self.bytes.len()])
    }
}

/// Nodes of the knots, and the cables between them.
fn net(scene: &mut GltfScene, case: &Case, run: &Run) {
    let (net, frames) = (case.net(), &run.frames);
    let start = &frames.knots[0];
    let radius = net.bullets.iter().map(|&bullet| net.radius[bullet]).fold(0.0, f64::max);
    let tips = [Vector3::x(), Vector3::y(), Vector3::z()];
    let tips: Vec<_> = tips.into_iter().flat_map(|axis| [radius * axis, -radius * axis]).collect();
    let bullet = scene.hulls("bullet", Hull::of(&tips).into_iter(), [0.9, 0.5, 0.1]);
    let mut joints = Vec::new();
    for (knot, place) in start.iter().enumerate() {
        let mut node = json!({ "name": format!("knot {knot}"), "translation": single(place) });
        if net.bullets.contains(&knot) {
            node["mesh"] = json!(bullet);
        }
        let node = scene.node(node);
        let path: Vec<f32> = frames.knots.iter().flat_map(|knots| single(&knots[knot])).collect();
        scene.animate(node, "translation", &path);
        joints.push(node);
    }
    // From the place of a corner at the start to its knot's frame.
    let back: Vec<f32> = start
        .iter()
        .flat_map(|place| {
            let [x, y, z] = single(place);
            [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -x, -y, -z, 1.0]
        })
        .collect();
    let back = scene.array(&back, "MAT4", None);
    scene.skins.push(json!({ "name": "net", "joints": joints, "inverseBindMatrices": back }));
    let bones: Vec<u8> =
        (0..start.len()).flat_map(|knot| [knot as u16, 0, 0, 0]).flat_map(u16::to_le_bytes).collect();
    let weights: Vec<f32> = start.iter().flat_map(|_| [1.0, 0.0, 0.0, 0.0]).collect();
    let attributes = json!({
        "POSITION": scene.positions(start),
        "JOINTS_0": scene.accessor(&bones, SHORT, "VEC4", start.len(), None),
        "WEIGHTS_0": scene.array(&weights, "VEC4", None),
    });
    let ends: Vec<u32> = net.cables.iter().flat_map(|cable| [cable.a as u32, cable.b as u32]).collect();
    let indices = scene.indices(&ends);
    let mesh = scene.mesh("net", &attributes, indices, LINES, [0.1, 0.1, 0.1]);
    scene.node(json!({ "name": "net", "mesh": mesh, "skin": 0 }));
}
