//! The catalogue of hard cases holds, and tells when one does not.

use tumblenet::report::stress::{markdown, text};
use tumblenet::study::stress::hard::StressCase;
use tumblenet::study::stress::measure::Measured;
use tumblenet::study::stress::{Stress, StressVerdict, all_pairs, catalogue, pairs, run};

fn named(name: &str) -> StressCase {
    catalogue::all().into_iter().find(|case| case.name == name).unwrap_or_else(|| panic!("no {name}"))
}

fn all_hold(stress: &Stress) {
    println!("{}", text(stress));
    let broken: Vec<String> =
        stress.broken().map(|row| format!("{} {}: {}", row.case, row.pair, row.notes.join("; "))).collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Cases that take as long as half of all others, or minutes: `tumblenet stress` runs them.
const LONG: [&str; 5] =
    ["ten-thousand-knots", "million-steps", "middle-axis-300-s", "clamped-between-threads", "300-m-net"];

/// All other cases under the default pair; the other pairs by `tumblenet stress`.
#[test]
fn the_default_pair_holds_every_hard_case() {
    let cases: Vec<StressCase> =
        catalogue::all().into_iter().filter(|case| !LONG.contains(&case.name)).collect();
    let stress = run(&cases, &pairs()[..1], 1, |_| None, |_, _| {});
    all_hold(&stress);
    let held = |verdict| matches!(verdict, StressVerdict::Holds | StressVerdict::Refused);
    let not_held = stress.rows.iter().filter(|row| !held(row.verdict));
    let names: Vec<&str> = not_held.map(|row| row.case.as_str()).collect();
    assert!(names.is_empty(), "{names:?}\n{}", text(&stress));
}

#[test]
fn names_of_cases_are_unique_and_limits_name_pairs() {
    let cases = catalogue::all();
    for (index, case) in cases.iter().enumerate() {
        assert!(cases[..index].iter().all(|other| other.name != case.name), "{} twice", case.name);
        assert!(case.limits.iter().all(|limit| all_pairs().contains(&limit.pair)), "{}", case.name);
    }
}

#[test]
fn a_broken_bound_a_wrong_refusal_and_a_limit_are_told_apart() {
    let pair = &pairs()[..1];
    let verdict = |case: StressCase| run(&[case], pair, 1, |_| None, |_, _| {}).rows.remove(0);

    let strict = named("one-point").bounded(|bounds| bounds.strain = Some(-1.0));
    let row = verdict(strict.clone());
    assert_eq!(row.verdict, StressVerdict::Breaks);
    assert!(row.notes.iter().any(|note| note.starts_with("strain")), "{:?}", row.notes);
    assert!(row.halved.is_some(), "measured at half the step, too");

    // Foretold, without a limit and with one that does not help.
    let strain = [("strain", -0.5, 2.0)];
    let foretold = strict.clone().limited(pair[0], "it cannot", &[], &strain);
    assert_eq!(verdict(foretold).verdict, StressVerdict::DoesNotHold);
    let helpless = strict.clone().limited(pair[0], "it cannot", &["solver.sweeps=4"], &strain);
    assert_eq!(verdict(helpless).verdict, StressVerdict::Breaks);

    // Worse than foretold, another number than foretold, and a limit that nothing needs any more.
    for (case, band, words) in [
        (&strict, ("strain", -1.0, -0.5), "foretold at most"),
        (&strict, ("energy", 0.0, 1.0), "no word of it in the limit"),
        (&named("one-point"), ("energy", 0.1, 1.0), "no longer needed"),
    ] {
        let row = verdict(case.clone().limited(pair[0], "it cannot", &[], &[band]));
        assert_eq!(row.verdict, StressVerdict::Breaks, "{words}");
        assert!(row.notes.iter().any(|note| note.contains(words)), "{words}: {:?}", row.notes);
    }
    let skipped = named("one-point").not_run(pair[0], "too long");
    assert_eq!(verdict(skipped).verdict, StressVerdict::NotRun);

    let mut inside = named("knots-inside");
    assert_eq!(verdict(inside.clone()).verdict, StressVerdict::Refused);
    inside.refusals = vec!["net.meshes"];
    assert_eq!(verdict(inside).verdict, StressVerdict::Breaks, "refused, but not where the case says");
}

/// After contact one run is a coin: of further members, whose knots are moved a little, the worst counts.
#[test]
fn the_worst_of_the_members_counts() {
    let pair = &["explicit+impulse"];
    let of = |case: &StressCase, members| {
        run(std::slice::from_ref(case), pair, members, |_| None, |_, _| {}).rows.remove(0)
    };
    let case = named("pressed-whole");
    let alone = of(&case, 1);
    assert!(alone.members.is_empty());
    let row = of(&case, 4);
    assert_eq!(row.members.len(), 3);
    let same = |a: &Measured, b: &Measured| (a.numbers, a.steps) == (b.numbers, b.steps);
    assert!(
        same(row.measured.as_ref().unwrap(), alone.measured.as_ref().unwrap()),
        "the first is the case itself"
    );
    let strains: Vec<f64> = row.as_it_is().map(|run| run.numbers.strain.unwrap()).collect();
    for (index, strain) in strains.iter().enumerate() {
        assert!(!strains[..index].contains(strain), "two members are the same: {strains:?}");
    }
    // A bound that the first keeps and another does not.
    let [least, most] = [f64::min, f64::max].map(|which| strains.iter().copied().reduce(which).unwrap());
    assert_eq!(
        of(&case.clone().bounded(|bounds| bounds.strain = Some(most)), 4).verdict,
        StressVerdict::Holds
    );
    let between = 0.5 * (least + most);
    assert_eq!(of(&case.bounded(|bounds| bounds.strain = Some(between)), 4).verdict, StressVerdict::Breaks);
}

/// Cases that held in their one run, and made 6e-2 of the energy at hand in one of eight.
#[test]
fn bounces_and_pressed_cables_hold_in_every_member() {
    let names = [
        "strands-bounce",
        "strands-bounce-0.9",
        "strands-and-cables",
        "pressed-whole",
        "restitution-1-friction-1",
    ];
    all_hold(&run(&names.map(named), &["joints+rapier", "explicit+impulse"], 6, |_| None, |_, _| {}));
}

#[test]
fn the_table_has_a_row_a_case_and_says_why() {
    let cases = [named("one-point"), named("knots-inside")];
    let page = markdown(&run(&cases, &pairs()[..1], 1, |_| None, |_, _| {}));
    assert!(page.contains("| many contacts | one-point | holds |"), "{page}");
    assert!(page.contains("| knots-inside | refused (1) |"), "{page}");
    assert!(page.contains("1. target.distance_m"), "{page}");
}
