//! A run for ParaView and other tools that read VTK: `run.pvd` with a `.vtp` file for each body and frame, in the
//! folder `vtk`.
//!
//! | file | geometry | data |
//! |---|---|---|
//! | `net_*` | a line a cable | of points: `velocity_m_s`, `contact_impulse_n_s`, `mass_kg`; of cells: `tension_n`, `strain` |
//! | `threads_*` | a line a thread, over the knots it passes | of cells: `tension_n`, `length_m`, `off_reels_m` |
//! | `target_*`, `chaser_*` | triangles of the parts | of cells: `part` |
//!
//! Lengths in metres, local frame. The format is the XML of VTK's file formats: arrays in base64, each after the number
//! of its bytes.

use std::io::Write;
use std::path::{Path, PathBuf};

use data_encoding::BASE64;
use nalgebra::{Isometry3, Translation3, Vector3};

use super::files::{self, WriteError};
use super::packed;
use crate::case::Case;
use crate::geometry::Hull;
use crate::interaction::DrawnThread;
use crate::run::Run;
use crate::state::Body;
use crate::target::parts::ConvexPart;

/// The folder within a run's results.
const FOLDER: &str = "vtk";

/// Its list of all files and their times.
const LIST: &str = "run.pvd";

/// Writes `run` to the folder `vtk` in `out`, in place of an earlier one; the list comes last.
///
/// # Errors
/// The first file or folder that cannot be written.
pub fn write(out: &Path, case: &Case, run: &Run) -> Result<PathBuf, WriteError> {
    let folder = out.join(FOLDER);
    if folder.exists() {
        // Frames of an earlier run, which may have had more of them.
        std::fs::remove_dir_all(&folder).map_err(|error| WriteError::new(&folder, error))?;
    }
    files::make_folder(&folder)?;
    let bodies = bodies(case, run);
    let mut list = String::new();
    for (frame, time) in run.frames.time.iter().enumerate() {
        let mut pieces = vec![("net", net(case, run, frame))];
        pieces.extend(threads(run, frame).map(|piece| ("threads", piece)));
        pieces.extend(bodies.iter().map(|body| (body.name, body.at(frame))));
        for (part, (name, piece)) in pieces.iter().enumerate() {
            let file = format!("{name}_{frame:06}.vtp");
            files::write(&folder.join(&file), |target| target.write_all(piece.xml().as_bytes()))?;
            list += &format!(
                "    <DataSet timestep=\"{time}\" group=\"\" part=\"{part}\" name=\"{name}\" file=\"{file}\"/>\n"
            );
        }
    }
    let list = format!("{}  <Collection>\n{list}  </Collection>\n</VTKFile>\n", head("Collection"));
    let place = folder.join(LIST);
    files::write(&place, |file| file.write_all(list.as_bytes()))?;
    Ok(place)
}

fn head(kind: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
    )
}

/// Points, lines or polygons over them, and numbers of both.
#[derive(Default)]
struct Piece {
    points: Vec<Vector3<f64>>,
    lines: Vec<Vec<usize>>,
    polygons: Vec<Vec<usize>>,
    of_points: Vec<Array>,
    of_cells: Vec<Array>,
}

/// An array with its name: as many components an entry.
struct Array {
    name: &'static str,
    components: usize,
    values: Vec<f64>,
}

impl Array {
    fn numbers(name: &'static str, values: Vec<f64>) -> Array {
        Array { name, components: 1, values }
    }

    fn vectors(name: &'static str, vectors: &[Vector3<f64>]) -> Array {
        Array { name, components: 3, values: packed::components(vectors) }
    }

    fn xml(&self) -> String {
        array("Float64", self.name, self.components, &packed::double(&self.values))
    }
}

fn array(kind: &str, name: &str, components: usize, bytes: &[u8]) -> String {
    let all = [&(bytes.len() as u64).to_le_bytes()[..], bytes].concat();
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">{}</DataArray>\n",
        BASE64.encode(&all)
    )
}

/// Cells by the points of each: `connectivity`, and `offsets` where each ends.
fn cells(name: &str, cells: &[Vec<usize>]) -> String {
    let mut end = 0;
    let ends = cells.iter().map(|cell| {
        end += cell.len();
        end
    });
    let arrays = [("connectivity", cells.concat()), ("offsets", ends.collect())];
    let arrays: String =
        arrays.iter().map(|(name, numbers)| array("Int64", name, 1, &packed::whole(numbers))).collect();
    format!("<{name}>\n{arrays}</{name}>\n")
}

impl Piece {
    fn xml(&self) -> String {
        let all = |arrays: &[Array]| arrays.iter().map(Array::xml).collect::<String>();
        format!(
            "{}<PolyData>\n<Piece NumberOfPoints=\"{}\" NumberOfLines=\"{}\" NumberOfPolys=\"{}\" NumberOfVerts=\"0\" \
             NumberOfStrips=\"0\">\n<Points>\n{}</Points>\n{}{}<PointData>\n{}</PointData>\n<CellData>\n{}</CellData>\n\
             </Piece>\n</PolyData>\n</VTKFile>\n",
            head("PolyData"),
            self.points.len(),
            self.lines.len(),
            self.polygons.len(),
            Array::vectors("points", &self.points).xml(),
            cells("Lines", &self.lines),
            cells("Polys", &self.polygons),
            all(&self.of_points),
            all(&self.of_cells),
        )
    }
}

fn net(case: &Case, run: &Run, frame: usize) -> Piece {
    let (net, frames) = (case.net(), &run.frames);
    let points = &frames.knots[frame];
    let strain = net.cables.iter().map(|cable| {
        let length = (points[cable.b] - points[cable.a]).norm();
        // A slack cable is not shortened.
        (length / cable.rest_length - 1.0).max(0.0)
    });
    Piece {
        points: points.clone(),
        lines: net.cables.iter().map(|cable| vec![cable.a, cable.b]).collect(),
        polygons: Vec::new(),
        of_points: vec![
            Array::vectors("velocity_m_s", &frames.velocities[frame]),
            Array::vectors("contact_impulse_n_s", &frames.contact_impulses[frame]),
            Array::numbers("mass_kg", net.mass.clone()),
        ],
        of_cells: vec![
            Array::numbers("tension_n", frames.tensions[frame].clone()),
            Array::numbers("strain", strain.collect()),
        ],
    }
}

/// The threads, over the knots they pass; a stretch outside of the net is left out.
fn threads(run: &Run, frame: usize) -> Option<Piece> {
    let threads: Vec<&DrawnThread> = run.threads().collect();
    if threads.is_empty() {
        return None;
    }
    let reading = |thread: &DrawnThread, column: usize| {
        let place = run.reading_names.iter().position(|name| *name == thread.columns[column]);
        place.map_or(0.0, |place| run.frames.readings[frame][place])
    };
    let of_all = |column: usize| threads.iter().map(|thread| reading(thread, column)).collect();
    let (mut points, mut lines) = (Vec::new(), Vec::new());
    for thread in &threads {
        let way = thread.way.iter().flatten().map(|&knot| run.frames.knots[frame][knot]);
        let first = points.len();
        points.extend(way);
        lines.push((first..points.len()).collect());
    }
    Some(Piece {
        points,
        lines,
        of_cells: vec![
            Array::numbers("length_m", of_all(0)),
            Array::numbers("off_reels_m", of_all(1)),
            Array::numbers("tension_n", of_all(2)),
        ],
        ..Piece::default()
    })
}

/// A rigid body in the frame of its own, and where it is.
struct MovingHulls<'a> {
    name: &'a str,
    piece: Piece,
    poses: &'a [Body],
}

fn bodies<'a>(case: &Case, run: &'a Run) -> Vec<MovingHulls<'a>> {
    let mut bodies = Vec::new();
    if let Some(target) = case.target() {
        let parts = target.parts.iter().filter_map(ConvexPart::hull);
        bodies.push(MovingHulls { name: "target", piece: of_hulls(parts), poses: &run.frames.target });
    }
    for track in &run.frames.brought {
        let piece = of_hulls(Hull::of(&track.model.corners()).into_iter());
        bodies.push(MovingHulls { name: &track.model.name, piece, poses: &track.frames });
    }
    bodies
}

fn of_hulls(hulls: impl Iterator<Item = Hull>) -> Piece {
    let (mut piece, mut parts) = (Piece::default(), Vec::new());
    for (part, hull) in hulls.enumerate() {
        let first = piece.points.len();
        piece.points.extend(&hull.vertices);
        parts.extend(hull.triangles.iter().map(|_| part as f64));
        piece
            .polygons
            .extend(hull.triangles.iter().map(|corners| corners.map(|at| first + at as usize).to_vec()));
    }
    piece.of_cells.push(Array::numbers("part", parts));
    piece
}

impl MovingHulls<'_> {
    fn at(&self, frame: usize) -> Piece {
        let body = &self.poses[frame];
        let pose = Isometry3::from_parts(Translation3::from(body.position), body.attitude);
        let points = self.piece.points.iter().map(|point| pose.rotation * point + pose.translation.vector);
        let parts = self.piece.of_cells.iter().map(|array| Array::numbers(array.name, array.values.clone()));
        Piece {
            points: points.collect(),
            polygons: self.piece.polygons.clone(),
            of_cells: parts.collect(),
            ..Piece::default()
        }
    }
}
