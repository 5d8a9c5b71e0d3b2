//! What a comparison keeps of a run: its summary and the curves that are set side by side.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::statistics::{Data, Median};

use super::difference::Path;
use crate::case::Case;
use crate::metrics::capture::Curves;
use crate::metrics::summary::Summary;
use crate::run::Run;
use crate::study::ensemble::Quartiles;

/// One run of one variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackMember {
    /// Its number, from 0: the same number is the same perturbation in every variant.
    pub member: usize,
    /// How many runs shared the machine with it, itself included.
    pub at_once: usize,
    /// What it did, or why it failed.
    pub outcome: Result<Track, String>,
}

/// What a run did; a value a frame in every list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Its numbers.
    pub summary: Summary,
    /// Where the bullets were.
    pub path: Path,
    /// Projected area of the bullets over the designed area [-].
    pub area: Vec<f64>,
    /// Enclosed share of the target [-]; empty without one.
    pub enclosed: Vec<f64>,
    /// Mouth over designed area [-]; empty without a target.
    pub mouth: Vec<f64>,
    /// Largest impulse of one contact within a step since the frame before [N s].
    pub impulse_n_s: Vec<f64>,
    /// Linear momentum of the net [kg m/s], T × 3.
    pub momentum_net: Vec<[f64; 3]>,
    /// Linear momentum of a free target [kg m/s], T × 3; empty without one.
    pub momentum_target: Vec<[f64; 3]>,
    /// Energy, a row each of [`ROWS`] [J].
    pub energy_j: Vec<Vec<f64>>,
    /// Threads on winches; empty curves without any.
    pub threads: Threads,
}

/// Curves of threads on winches.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Threads {
    /// What is off the reels, all threads together [m].
    pub off_reels_m: Vec<f64>,
    /// Largest tension of any since the frame before [N].
    pub tension_n: Vec<f64>,
    /// Work of the winches since the start [J].
    pub work_j: Vec<f64>,
}

impl Threads {
    fn of(run: &Run) -> Threads {
        let joined = |columns: &mut dyn Iterator<Item = &str>, join: fn(f64, f64) -> f64| {
            let curves = columns.map(|column| run.reading(column));
            curves
                .reduce(|sum, one| sum.iter().zip(one).map(|(a, b)| join(*a, b)).collect())
                .unwrap_or_default()
        };
        let add = |a, b| a + b;
        let of_threads = |column: usize| run.threads().map(move |thread| thread.columns[column].as_str());
        Threads {
            off_reels_m: joined(&mut of_threads(1), add),
            tension_n: joined(&mut of_threads(2), f64::max),
            work_j: joined(&mut run.reports.iter().filter_map(|(_, report)| report.work), add),
        }
    }
}

/// The rows of the energy ledger, in the order of [`Track::energy_j`]: what there is, then where the rest went.
pub const ROWS: [&str; 10] = [
    "kinetic, net",
    "kinetic, target",
    "elastic",
    "stored by effects",
    "taken by cables",
    "taken by the solver",
    "taken by contact",
    "put in by the drive",
    "put in by effects",
    "residual",
];

/// How many of [`ROWS`], from the first, are energy that net and target have.
pub const ROWS_HELD: usize = 4;

/// How many of [`ROWS`], after those, were taken.
pub const ROWS_TAKEN: usize = 3;

impl Track {
    /// What is kept of `run`, whose capture curves are `curves`.
    pub fn of(case: &Case, run: &Run, curves: Curves) -> Track {
        let frames = &run.frames;
        let momentum_target: Vec<Vector3<f64>> = match case.target() {
            Some(target) if target.motion == crate::target::spec::Motion::Free => {
                frames.target.iter().map(|body| target.mass * body.velocity).collect()
            }
            _ => Vec::new(),
        };
        let momentum_net =
            frames.momentum.iter().enumerate().map(|(frame, total)| {
                (total - momentum_target.get(frame).copied().unwrap_or_default()).into()
            });
        let ledger = frames.ledger.iter();
        let rows: Vec<[f64; ROWS.len()]> = ledger
            .map(|l| {
                let effects = l.effects.iter().sum();
                let held = [l.kinetic_net, l.kinetic_target, l.elastic, l.stored];
                let gone = [l.cables, l.solver.unwrap_or(0.0), l.contact, l.drive, effects, l.residual()];
                std::array::from_fn(|row| if row < ROWS_HELD { held[row] } else { gone[row - ROWS_HELD] })
            })
            .collect();
        let area_at =
            |time: &f64| run.mouth_area[(time / run.step).round() as usize] / case.net().designed_area;
        Track {
            summary: Summary::of(case, run, &curves),
            path: path(case, run),
            area: frames.time.iter().map(area_at).collect(),
            enclosed: curves.enclosed,
            mouth: curves.mouth,
            impulse_n_s: frames.impulse.clone(),
            momentum_net: momentum_net.collect(),
            momentum_target: momentum_target.into_iter().map(Into::into).collect(),
            energy_j: (0..ROWS.len()).map(|row| rows.iter().map(|rows| rows[row]).collect()).collect(),
            threads: Threads::of(run),
        }
    }
}

fn path(case: &Case, run: &Run) -> Path {
    let frames = &run.frames;
    let mut travel = 0.0;
    let mut last: Option<Vector3<f64>> = None;
    let travel_m = frames.knots.iter().map(|knots| {
        let weighted: Vector3<f64> = case.net().mass.iter().zip(knots).map(|(mass, x)| *mass * x).sum();
        let centre = weighted / case.net().total_mass();
        travel += last.replace(centre).map_or(0.0, |before| (centre - before).norm());
        travel
    });
    Path {
        time_s: frames.time.clone(),
        travel_m: travel_m.collect(),
        bullets_m: frames.knots.iter().map(|knots| case.net().bullets.map(|b| knots[b].into())).collect(),
    }
}

/// A curve of several runs: quartiles at each time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Band {
    /// Lower quartile.
    pub lower: Vec<f64>,
    /// Median.
    pub median: Vec<f64>,
    /// Upper quartile.
    pub upper: Vec<f64>,
    /// Largest.
    pub max: Vec<f64>,
}

impl Band {
    /// That of `curves`, as long as the shortest of them.
    fn of(curves: &[&[f64]]) -> Band {
        let mut band = Band::default();
        for frame in 0..shortest(curves) {
            let quartiles = Quartiles::of(curves.iter().map(|curve| curve[frame]).collect());
            band.lower.push(quartiles.lower);
            band.median.push(quartiles.median);
            band.upper.push(quartiles.upper);
            band.max.push(quartiles.max);
        }
        band
    }
}

/// The curves of a variant over its runs; those that do not apply are empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Bands {
    /// Times [s].
    pub time_s: Vec<f64>,
    /// Projected area of the bullets over the designed area [-].
    pub area: Band,
    /// Enclosed share of the target [-].
    pub enclosed: Band,
    /// Mouth over designed area [-].
    pub mouth: Band,
    /// Largest impulse of one contact within a step since the frame before [N s].
    pub impulse_n_s: Band,
    /// The same over the step, as a force [N].
    pub force_n: Band,
    /// Momentum of the net along X, Y and Z, median over the runs [kg m/s].
    pub momentum_net: [Vec<f64>; 3],
    /// The same of a free target [kg m/s].
    pub momentum_target: [Vec<f64>; 3],
    /// Kinetic, elastic and stored energy of net and target [J].
    pub mechanical_j: Band,
    /// Closing thread off the reels, all threads together [m].
    pub off_reels_m: Band,
    /// Largest tension of a closing thread since the frame before [N].
    pub thread_tension_n: Band,
    /// Work of the winches since the start [J].
    pub winch_work_j: Band,
    /// Rows of the energy ledger by name, median over the runs [J].
    pub energy_j: std::collections::BTreeMap<String, Vec<f64>>,
}

impl Bands {
    /// The curves of `tracks`, which are runs of one case; empty without any.
    pub fn of(tracks: &[&Track]) -> Bands {
        let Some(first) = tracks.first() else { return Bands::default() };
        let over =
            |curve: fn(&Track) -> &[f64]| Band::of(&tracks.iter().map(|t| curve(t)).collect::<Vec<_>>());
        let component = |of: fn(&Track) -> &[[f64; 3]], axis: usize| {
            let runs: Vec<Vec<f64>> =
                tracks.iter().map(|track| of(track).iter().map(|vector| vector[axis]).collect()).collect();
            median(&runs.iter().map(Vec::as_slice).collect::<Vec<_>>())
        };
        let mechanical: Vec<Vec<f64>> = tracks
            .iter()
            .map(|track| {
                let held = &track.energy_j[..ROWS_HELD];
                (0..track.path.time_s.len()).map(|frame| held.iter().map(|row| row[frame]).sum()).collect()
            })
            .collect();
        let impulse_n_s = over(|track| &track.impulse_n_s);
        let step = first.summary.simulated_s / first.summary.work.steps as f64;
        let per_step = |curve: &Vec<f64>| curve.iter().map(|impulse| impulse / step).collect();
        Bands {
            time_s: first.path.time_s.clone(),
            area: over(|track| &track.area),
            enclosed: over(|track| &track.enclosed),
            mouth: over(|track| &track.mouth),
            force_n: Band {
                lower: per_step(&impulse_n_s.lower),
                median: per_step(&impulse_n_s.median),
                upper: per_step(&impulse_n_s.upper),
                max: per_step(&impulse_n_s.max),
            },
            impulse_n_s,
            off_reels_m: over(|track| &track.threads.off_reels_m),
            thread_tension_n: over(|track| &track.threads.tension_n),
            winch_work_j: over(|track| &track.threads.work_j),
            momentum_net: [0, 1, 2].map(|axis| component(|track| &track.momentum_net, axis)),
            momentum_target: [0, 1, 2].map(|axis| component(|track| &track.momentum_target, axis)),
            mechanical_j: Band::of(&mechanical.iter().map(Vec::as_slice).collect::<Vec<_>>()),
            energy_j: ROWS
                .iter()
                .enumerate()
                .map(|(row, name)| {
                    let runs: Vec<&[f64]> =
                        tracks.iter().map(|track| track.energy_j[row].as_slice()).collect();
                    ((*name).to_owned(), median(&runs))
                })
                .collect(),
        }
    }
}

fn median(curves: &[&[f64]]) -> Vec<f64> {
    (0..shortest(curves))
        .map(|frame| Data::new(curves.iter().map(|curve| curve[frame]).collect::<Vec<_>>()).median())
        .collect()
}

fn shortest(curves: &[&[f64]]) -> usize {
    curves.iter().map(|curve| curve.len()).min().unwrap_or(0)
}
