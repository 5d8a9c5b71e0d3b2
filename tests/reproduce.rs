//! What the source says beside what is found: every claim has its row, and what was run is kept.

use std::path::Path;

use serde_json::{Value, json};
use tumblenet::case::Case;
use tumblenet::limits::Limits;
use tumblenet::problems::Problems;
use tumblenet::read::schema;
use tumblenet::report::dependency;
use tumblenet::report::figure::FigureWords;
use tumblenet::report::reproduce::{StudyRows, summary, text};
use tumblenet::report::rows::{KeptRows, RowKeeper};
use tumblenet::report::sweep;
use tumblenet::study::reproduce::finding::{ClaimAgreement, ClaimMeasure, Finding};
use tumblenet::study::reproduce::spec::{Claim, Claims};
use tumblenet::study::reproduce::{ReproducedRow, Reproduction, tables};
use tumblenet::study::sweep::Sweep;
use tumblenet::study::sweep::dependency::Dependencies;

/// Rows of a study of two speeds with two members each, run now.
fn rows(folder: &Path) -> StudyRows {
    let study = json!({ "title": "speeds", "scene": "cubesat-free", "set": { "duration_s": 0.9 },
        "solver": "explicit+impulse", "members": 2, "design": { "kind": "grid" },
        "parameters": [{ "path": "launch.speed_m_s", "values": [1.8, 2.0] }] });
    let path = folder.join("speeds.json");
    std::fs::write(&path, study.to_string()).unwrap();
    let sweep = Sweep::load(path.to_str().unwrap(), Limits::default()).unwrap();
    let plan = sweep.plan("test");
    sweep::write_plan(folder, &plan).unwrap();
    let keeper = RowKeeper::open(folder, &plan).unwrap();
    sweep.run_all((0..4).collect(), |row| keeper.keep(&row));
    keeper.close().unwrap();
    let kept = KeptRows::read(folder, &plan);
    assert_eq!(kept.rows.len(), 4);
    StudyRows { plan, kept }
}

fn claim(of: Value, source: Value) -> Claim {
    serde_json::from_value(
        json!({ "place": "Section 5.2.1", "says": "it", "of": of, "source": source, "why": "chance" }),
    )
    .unwrap()
}

#[test]
fn a_claim_is_answered_from_the_rows_of_its_study_alone() {
    let folder = tempfile::tempdir().unwrap();
    let rows = rows(folder.path());
    let contact = "contact.first_contact_s";
    let number = |speed: &str, source: Value| {
        let of = json!({ "number": { "study": "speeds", "name": contact, "unit": "s", "at": { "launch.speed_m_s": speed } } });
        rows.answer(&claim(of, source)).unwrap()
    };
    let [slow, fast] = ["1.8", "2.0"].map(|speed| number(speed, json!("not_asked")));
    let median = |finding: &Finding| match &finding.measured {
        ClaimMeasure::Number { quartiles, .. } => {
            assert_eq!(quartiles.count, 2);
            quartiles.median
        }
        other => panic!("{other:?}"),
    };
    // The way is the same: what is found is that of each point's own members.
    let ratio = median(&slow) * 1.8 / (median(&fast) * 2.0);
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    assert_eq!(slow.agreement, ClaimAgreement::Open);
    let at_most = |value: f64| json!({ "at_most": { "value": value, "unit": "s" } });
    assert_eq!(number("1.8", at_most(median(&slow) + 0.01)).agreement, ClaimAgreement::Agrees);
    assert_eq!(number("1.8", at_most(median(&slow) - 0.01)).agreement, ClaimAgreement::Differs);

    let trend = |values: [&str; 2]| {
        let of = json!({ "trend": { "study": "speeds", "name": contact, "unit": "s", "over": "launch.speed_m_s",
            "values": values, "at": {} } });
        rows.answer(&claim(of, json!("falls"))).unwrap().agreement
    };
    assert_eq!(
        [trend(["1.8", "2.0"]), trend(["2.0", "1.8"])],
        [ClaimAgreement::Agrees, ClaimAgreement::Differs]
    );

    let outcome =
        json!({ "outcome": { "study": "speeds", "is": "captured", "at": { "launch.speed_m_s": "1.8" } } });
    // Half a second after the first contact nothing is held.
    assert_eq!(rows.answer(&claim(outcome, json!("yes"))).unwrap().agreement, ClaimAgreement::Differs);
    let faults = rows
        .answer(&claim(
            json!({ "number": { "study": "speeds", "name": "capture.colour", "unit": "", "at": {} } }),
            json!("yes"),
        ))
        .unwrap_err();
    assert!(faults.to_string().contains("capture.colour"), "{faults}");
}

#[test]
fn a_reason_stands_where_the_answers_differ_and_rows_are_counted_by_chapter() {
    let source = json!({ "at_most": { "value": 1.0, "unit": "m" } });
    let of = json!({ "cannot": { "because": "no tracks" } });
    let rows: Vec<ReproducedRow> = [0.5, 2.0]
        .map(|number| {
            let claim = claim(of.clone(), source.clone());
            let finding = Finding::of_numbers(vec![number], "m", &claim.source);
            ReproducedRow::of(&claim, finding, "tumblenet run".to_owned())
        })
        .into();
    assert_eq!([rows[0].why.as_str(), rows[1].why.as_str()], ["", "chance"]);
    let unexplained = Claim { why: None, ..claim(of, source) };
    let finding = Finding::of_numbers(vec![2.0], "m", &unexplained.source);
    assert_eq!(ReproducedRow::of(&unexplained, finding, String::new()).why, "No reason is known.");
    let provenance = tumblenet::provenance::Provenance::here();
    let all = Reproduction { quick: false, rows, provenance };
    assert!(summary(&all).contains("| 5, capture | 2 | 1 | 1 | 0 |"), "{}", summary(&all));
    let published = jsonschema::validator_for(&schema::<Reproduction>()).unwrap();
    let written = serde_json::to_value(&all).unwrap();
    assert!(published.is_valid(&written), "{:?}", published.iter_errors(&written).next());
    let text = text(&all);
    assert!(text.contains("differs it: 2.00 m (source: at most 1 m)"), "{text}");
}

/// The short form shows what it leaves out: the rows of a published table are there without any member.
#[test]
fn a_table_of_a_study_that_was_not_run_has_its_rows() {
    let plan = Sweep::load("deployment-models", Limits::default()).unwrap().plan("");
    let names = dependency::names(None);
    let rows =
        tables::rows(&Dependencies::of(&plan, &names, &[]).unwrap(), &[], "tumblenet sweep it", "left out");
    assert_eq!(rows.len(), 12, "four numbers over three parameters");
    for row in rows {
        assert_eq!((row.place.as_str(), row.why.as_str()), ("Table 3.4", ""));
        assert_eq!(row.finding, Finding::nothing("left out"));
    }
}

/// Figures of the source are asked for as `tumblenet figure` knows them, of scenes that are built in.
#[test]
fn every_figure_of_the_source_can_be_drawn() {
    let figures = Claims::built_in().figures;
    let mut names: Vec<String> =
        figures.iter().map(|figure| format!("{}-{}", figure.number, figure.of)).collect();
    assert!(names.len() >= 25, "{names:?}");
    names.sort();
    names.dedup();
    assert_eq!(names.len(), figures.len(), "no two have the same name");
    for figure in &figures {
        let mut problems = Problems::new(&figure.number);
        let words =
            FigureWords { of: vec![figure.of.clone()], at: figure.at.clone(), ..FigureWords::default() };
        assert!(words.read(&mut problems).is_some(), "{problems}");
        for run in &figure.runs {
            let case = Case::load_changed(&run.scene, &run.changes(), Limits::default()).unwrap();
            assert!(run.folder().ends_with(case.scene().solver.pair()), "{}", run.folder());
            let end = case.scene().duration_s.0;
            assert!(figure.at.iter().all(|time| time.parse::<f64>().unwrap() <= end), "{:?}", figure.at);
        }
    }
}
