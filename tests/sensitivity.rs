//! What matters: shares of variance against closed forms, and from a sweep.

use std::f64::consts::PI;

use crate::common::program::{folder_with, printed, tumblenet, write_json};
use crate::common::{small_scene, within};
use serde_json::{Value, json};
use tumblenet::parameter::spec::Varied;
use tumblenet::parameter::{Own, Parameter};
use tumblenet::problems::Problems;
use tumblenet::study::sweep::design::Points;
use tumblenet::study::sweep::sensitivity::OutputShares;
use tumblenet::study::sweep::spec::Design;

/// Values of `f` over so many blocks of a design whose inputs are uniform between `ends`.
fn blocks(base: u64, n_inputs: usize, ends: [f64; 2], f: impl Fn(&[f64]) -> f64) -> Vec<Vec<f64>> {
    let mut problems = Problems::new("test");
    let parameter = |i: usize| {
        let varied: Varied =
            serde_json::from_value(json!({ "path": format!("p{i}"), "uniform": ends })).unwrap();
        Parameter::read(&varied, &Own::Nothing, "p", &mut problems)
    };
    let parameters: Vec<Parameter> = (0..n_inputs).filter_map(parameter).collect();
    let points = Points::new(Design::Saltelli { base }, 1, parameters, &[], &mut Problems::new("test"));
    let in_block = points.block().unwrap();
    let value = |point: u64| {
        let picks = points.at(point, point).into_iter().flatten();
        f(&picks.map(|pick| pick.value.as_f64().unwrap()).collect::<Vec<f64>>())
    };
    (0..base).map(|block| (0..in_block).map(|i| value(block * in_block + i)).collect()).collect()
}

/// Asserts shares against closed forms, and that intervals hold them; largest error printed.
fn compare(shares: &OutputShares, alone: &[f64], total: &[f64], bound: f64) {
    for (i, input) in shares.inputs.iter().enumerate() {
        for (what, found, expected) in [("alone", input.alone, alone[i]), ("total", input.total, total[i])] {
            println!("{what} {i}: {:.4}, {expected:.4}, {:?}", found.value, found.interval_95);
            assert!((found.value - expected).abs() < bound, "{what} {i}: {found:?}, {expected}");
            let [low, high] = found.interval_95;
            assert!((low - bound..=high + bound).contains(&expected), "{what} {i}: {found:?}, {expected}");
        }
    }
}

/// Ishigami and Homma: sin x + a sin² y + b z⁴ sin x, with a = 7 and b = 0.1.
///
/// V = a²/8 + b π⁴/5 + b² π⁸/18 + 1/2; V₁ = (1 + b π⁴/5)²/2, V₂ = a²/8, V₁₃ = 8 b² π⁸/225, all others 0.
#[test]
fn shares_of_the_ishigami_function_are_those_of_its_closed_form() {
    let (a, b) = (7.0, 0.1);
    let f = |x: &[f64]| x[0].sin() + a * x[1].sin().powi(2) + b * x[2].powi(4) * x[0].sin();
    let p4 = PI.powi(4);
    let (v1, v2, v13) = (0.5 * (1.0 + b * p4 / 5.0).powi(2), a * a / 8.0, 8.0 * (b * p4).powi(2) / 225.0);
    let v = a * a / 8.0 + b * p4 / 5.0 + (b * p4).powi(2) / 18.0 + 0.5;
    assert!((v - v1 - v2 - v13).abs() < 1e-12 * v);
    let shares = OutputShares::of(&blocks(4096, 3, [-PI, PI], f), 1).unwrap();
    compare(&shares, &[v1 / v, v2 / v, 0.0], &[(v1 + v13) / v, v2 / v, v13 / v], 0.05);
    within("mean", shares.mean, [0.98 * a / 2.0, 1.02 * a / 2.0]);
    within("variance", shares.deviation.powi(2) / v, [0.97, 1.03]);
}

/// Sobol's g function: Π (|4 xᵢ − 2| + aᵢ) / (1 + aᵢ), whose Vᵢ = 1 / (3 (1 + aᵢ)²) and V = Π (1 + Vᵢ) − 1.
#[test]
fn shares_of_the_g_function_are_those_of_its_closed_form() {
    let a = [0.0, 1.0, 4.5, 9.0];
    let f = |x: &[f64]| x.iter().zip(a).map(|(x, a)| ((4.0 * x - 2.0).abs() + a) / (1.0 + a)).product();
    let parts = a.map(|a| 1.0 / (3.0 * (1.0 + a).powi(2)));
    let all: f64 = parts.iter().map(|part| 1.0 + part).product();
    let v = all - 1.0;
    let total = parts.map(|part| part * all / (1.0 + part) / v);
    let shares = OutputShares::of(&blocks(4096, 4, [0.0, 1.0], f), 1).unwrap();
    compare(&shares, &parts.map(|part| part / v), &total, 0.05);
}

/// Intervals hold the truth about as often as they say.
#[test]
fn intervals_hold_as_often_as_they_say() {
    // Of a sum of two: total and alone are 0.8 and 0.2. Random blocks, so that the bootstrap's assumption holds.
    let all = blocks(4000, 2, [0.0, 1.0], |x| 2.0 * x[0] + x[1]);
    let mut held = 0;
    for part in 0..40 {
        // Every fortieth block: far apart in the sequence.
        let own: Vec<Vec<f64>> = all.iter().skip(part).step_by(40).cloned().collect();
        let shares = OutputShares::of(&own, 1).unwrap();
        let [low, high] = shares.inputs[0].total.interval_95;
        held += usize::from((low..=high).contains(&0.8));
    }
    println!("{held} of 40");
    assert!(held >= 30, "{held} of 40");
}

#[test]
fn what_does_not_vary_has_no_shares() {
    assert!(OutputShares::of(&vec![vec![1.0; 4]; 20], 1).is_none());
    assert!(OutputShares::of(&[], 1).is_none());
    assert!(OutputShares::of(&vec![vec![1.0, 2.0, 1.0, 2.0]; 7], 1).is_none(), "too few");
}

/// Of a net in free flight: how far it travels is a matter of its speed, and not of the damping of its cables. One input is
/// the study's, the others are uncertain in the scene.
#[test]
fn a_sweep_tells_what_matters() {
    let mut scene = small_scene();
    scene["duration_s"] = json!(0.05);
    scene["net"]["meshes"] = json!([2, 2]);
    scene["solver"] = json!({ "cables": "explicit", "contact": "impulse" });
    scene["uncertain"] = json!([{ "path": "launch.speed_m_s", "normal": { "relative": 0.1 } },
                                { "path": "launch.bullets.aside_deg", "normal": { "sigma": 1 } }]);
    let mut study = json!({ "title": "t", "scene": "scene.json", "seed": 2,
        "parameters": [{ "path": "net.cable.damping_ratio", "uniform": [0.05, 0.2] }],
        "design": { "kind": "saltelli", "base": 16 } });
    let folder = folder_with(&[("scene.json", &scene), ("study.json", &study)]);
    let folder = folder.path();
    printed(folder, &["sweep", "study.json", "--out", "o"]);
    let text = printed(folder, &["sensitivity", "o", "--format", "json"]);
    let found: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        found["inputs"],
        json!(["net.cable.damping_ratio", "launch.speed_m_s", "launch.bullets.aside_deg"])
    );
    assert_eq!(found["blocks"], json!(16));
    assert!(found.get("of_outcome").is_none(), "without a target nothing is captured");
    let shares = &found["scalars"]["deployment.max_area_m2"]["inputs"];
    let total = |input: usize| shares[input]["total"]["value"].as_f64().unwrap();
    let speed = &shares[1]["total"]["interval_95"];
    let [low, high] = [0, 1].map(|end| speed[end].as_f64().unwrap());
    // All of it, within what 16 blocks tell: measured 1.13.
    assert!((low..=high).contains(&1.0), "{speed}");
    within("of the damping", total(0), [0.0, 0.05]);
    within("of the bullets' way aside", total(2), [0.0, 0.05]);
    for name in ["sensitivity.html", "sensitivity.json"] {
        assert!(folder.join("o").join(name).exists(), "{name}");
    }
    assert!(printed(folder, &["sensitivity", "o"]).contains("16 finished blocks of 5 points"));

    // More blocks leave those that are there; a design without blocks is refused.
    let short = std::fs::read_to_string(folder.join("o/table.csv")).unwrap();
    study["design"]["base"] = json!(17);
    write_json(folder, "study.json", &study);
    printed(folder, &["sweep", "study.json", "--out", "o"]);
    assert!(std::fs::read_to_string(folder.join("o/table.csv")).unwrap().starts_with(&short));
    study["design"] = json!({ "kind": "random", "points": 2 });
    write_json(folder, "study.json", &study);
    printed(folder, &["sweep", "study.json", "--out", "random"]);
    let refused = tumblenet(folder, &["sensitivity", "random"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&refused.stderr).contains("a design without blocks; allowed: \"saltelli\"")
    );
}
