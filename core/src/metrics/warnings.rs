//! When not to believe a run: what the model is too coarse for, said with its price.
//!
//! | warning | known |
//! |---|---|
//! | knots are farther apart than a part of the target is thick, and `cable_contact` is not named | before |
//! | the target's box looks like millimetres read as metres | before |
//! | steps are longer than the time between two frames that was asked for | before |
//! | cables go through the target, and `cable_contact` is not named | after |
//! | a cable bore more than its breaking tension | after |
//! | what an effect has to say against itself | after |
//! | a bullet left the reach of the scene | after |
//! | the solver's implicit rows took more energy than the cables, and much of it; another method took or made much beside the cables' law | after |
//! | the method created energy | after |

use super::capture::Curves;
use super::conservation::{CREATED, Conservation};
use crate::case::Case;
use crate::run::Run;
use crate::target::Target;

/// Least density of a target that is not taken for a slip of units [kg/m^3]: of the built-in ones
/// Envisat with its panel has the least, 19 within its hull.
const LEAST_DENSITY: f64 = 0.05;

/// Time between two frames over that which was asked for, up to which whole steps explain the difference [-].
const ROUNDED: f64 = 1.5;

/// Energy taken by implicit rows over that of the launch, below which none of it is worth a word [-].
const TAKEN_BY_SOLVER: f64 = 0.1;

/// Longest target over the side of the net that is not taken for a slip of units [-].
const LONGEST: f64 = 30.0;

/// What is known before `case` runs.
pub fn before(case: &Case) -> Vec<String> {
    let around = case.target().map(|target| [wide_meshes(case, target), millimetres(case, target)]);
    around.into_iter().flatten().chain([rare_frames(case)]).flatten().collect()
}

/// What is known after it ran, all of it.
pub fn after(case: &Case, run: &Run, curves: &Curves) -> Vec<String> {
    let mut warnings = before(case);
    warnings.extend(cables_inside(case, curves));
    let utilisation = run.extremes.utilisation;
    if utilisation > 1.0 {
        warnings.push(format!(
            "a cable bore {utilisation:.2} times its breaking tension; a cable breaks in a flight, not here"
        ));
    }
    warnings.extend(run.reports.iter().flat_map(|(_, report)| report.warnings.iter().cloned()));
    warnings.extend(out_of_reach(case, run));
    let kept = Conservation::of(case, run);
    warnings.extend(solver_takes(case, &kept, run));
    if kept.is_broken() {
        warnings.push(format!(
            "the method created {:.1e} of the launch energy and the work put in, more than {CREATED}: this run is not to be \
             believed, try a smaller solver.step_s",
            kept.energy_created
        ));
    }
    warnings
}

fn wide_meshes(case: &Case, target: &Target) -> Option<String> {
    let spheres = case.scene().solver.spheres();
    let longest = case.net().cables.iter().map(|cable| cable.rest_length).fold(0.0, f64::max);
    let mesh = longest / f64::from(1 + spheres.unwrap_or(0));
    if case.scene().effects.cable_contact.is_some() {
        return None;
    }
    let thin = |part: &crate::target::parts::ConvexPart| part.primitive.thickness();
    let (part, least) = target.parts.iter().map(thin).enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    (mesh > least).then(|| match spheres {
        Some(_) => format!(
            "what touches on a cable is up to {mesh:.3} m apart, part {part} of the target is {least:.3} m thick: cables may go \
             through. Raise solver.ancf.spheres"
        ),
        None => format!(
            "knots are up to {mesh:.3} m apart, part {part} of the target is {least:.3} m thick, and only knots touch it: \
             cables may go through. Name effects.cable_contact (`--set effects.cable_contact={{}}`), at {}",
            case.scene().solver.cables.cable_contact_price()
        ),
    })
}

fn millimetres(case: &Case, target: &Target) -> Option<String> {
    let side = case.net().designed_area.sqrt();
    let density = target.mass / target.hull_volume;
    let box_of = |axis: usize| {
        let ends = target.parts.iter().flat_map(|part| part.hull_points().collect::<Vec<_>>());
        let [low, high] =
            ends.fold([f64::MAX, f64::MIN], |[low, high], p| [low.min(p[axis]), high.max(p[axis])]);
        high - low
    };
    let sides = [0, 1, 2].map(box_of);
    let longest = sides.iter().copied().fold(0.0, f64::max);
    (density < LEAST_DENSITY || longest > LONGEST * side).then(|| {
        format!(
            "the target's box is {:.4} x {:.4} x {:.4} m with {} kg before a net of {side:.3} m: millimetres read as metres?",
            sides[0], sides[1], sides[2], target.mass
        )
    })
}

/// A frame is taken after a whole step at the earliest.
fn rare_frames(case: &Case) -> Option<String> {
    let scene = case.scene();
    let (step, asked) = (case.time_step().step, scene.output.sample_s.0);
    (step > ROUNDED * asked).then(|| {
        format!(
            "output.sample_s asks for a frame every {asked:.3e} s, and a step of the method takes {step:.3e} s: there is one \
             frame a step. Name solver.step_s (`--set solver.step_s={asked:.3e}`) for more of them"
        )
    })
}

fn cables_inside(case: &Case, curves: &Curves) -> Option<String> {
    let (last, most) = (*curves.cables_inside.last()?, *curves.cables_inside.iter().max()?);
    (most > 0 && case.scene().effects.cable_contact.is_none()).then(|| match case.scene().solver.spheres() {
        Some(spheres) => format!(
            "{last} cables go through the target at the end, {most} at most: of each its {spheres} spheres touch it and its two \
             knots, and what is between them cuts corners. Raise solver.ancf.spheres"
        ),
        None => format!(
            "{last} cables go through the target at the end, {most} at most: only knots touch it, and a net hooked inside \
             holds what a real one does not. Name effects.cable_contact (`--set effects.cable_contact={{}}`), at {}",
            case.scene().solver.cables.cable_contact_price()
        ),
    })
}

/// Rows that took more than the cables' law, or another method that took or made much beside it.
fn solver_takes(case: &Case, kept: &Conservation, run: &Run) -> Option<String> {
    let ledger = run.frames.ledger.last()?;
    let (share, taken) = (kept.energy_taken_by_solver?, ledger.solver?);
    if !case.scene().solver.cables.is_of_rows() {
        return (share.abs() > TAKEN_BY_SOLVER).then(|| {
            format!(
                "among contacts the method {} {:.0} % of the launch energy beside the cables' law, less in shorter steps \
                 (`--set solver.step_s`)",
                if share > 0.0 { "took" } else { "made" },
                100.0 * share.abs()
            )
        });
    }
    (share > TAKEN_BY_SOLVER && taken > ledger.cables).then(|| {
        format!(
            "implicit rows of the solver took {:.0} % of the launch energy and the cables by their law {:.0} %: bullets and knots \
             rebound less than they should. Less in shorter steps (`--set solver.step_s`), none with explicit cables \
             (`--set solver.cables=explicit --set solver.contact=impulse`)",
            100.0 * share,
            100.0 * share * ledger.cables / taken
        )
    })
}

/// A bullet farther from the start than the target and the whole net reach.
fn out_of_reach(case: &Case, run: &Run) -> Option<String> {
    let target = case.target()?;
    let reach = target.position.norm() + target.bounding_radius + (2.0 * case.net().designed_area).sqrt();
    let frames = run.frames.time.iter().zip(&run.frames.knots).zip(&run.frames.target);
    frames
        .map(|((time, knots), body)| {
            // A target that was pushed takes the reach along.
            let pushed = body.position - target.position;
            let far = case.net().bullets.map(|bullet| (knots[bullet] - pushed).norm());
            (time, far.into_iter().fold(0.0, f64::max))
        })
        .find(|(_, far)| *far > reach)
        .map(|(time, far)| {
            format!(
                "a bullet is {far:.1} m from where it was shot at {time:.2} s, beyond target and net ({reach:.1} m): \
                 what the net does from then on has nothing to do with the target"
            )
        })
}
