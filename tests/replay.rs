//! The replay page in a real browser: it draws, it moves, and it has nothing to complain about.
//!
//! Needs Chromium in the path, or its path in `TUMBLENET_BROWSER`; `.ci/run` installs one. Elsewhere the test
//! says that it was skipped.

use crate::common::{self, program};

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tumblenet::metrics::capture::Curves;
use tumblenet::metrics::summary::Summary;
use tumblenet::report::results;

fn browser() -> Option<PathBuf> {
    if let Some(given) = std::env::var_os("TUMBLENET_BROWSER") {
        return Some(given.into());
    }
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)))
        .find(|path| path.is_file())
}

/// Takes a picture of `page` at `moment` (as after `#t=`); returns the picture's bytes and what the
/// browser wrote to its log.
fn picture(browser: &Path, page: &Path, moment: &str) -> (Vec<u8>, String) {
    let folder = tempfile::tempdir().unwrap();
    let (shot, log) = (folder.path().join("shot.png"), folder.path().join("log"));
    let mut child = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync"])
        .args(["--disable-background-networking", "--disable-component-update", "--enable-logging=stderr"])
        // Shaders without a graphics card, which the browser may refuse unasked, however long a busy machine takes.
        .args(["--enable-unsafe-swiftshader", "--disable-gpu-watchdog", "--disable-gpu-process-crash-limit"])
        .args(["--window-size=1280,720", "--virtual-time-budget=4000"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("--screenshot={}", shot.display()))
        .arg(format!("file://{}#t={moment}&paused", page.display()))
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(&log).unwrap())
        .spawn()
        .expect("the browser starts");
    // Its clock is virtual, so that a busy machine changes nothing.
    child.wait().unwrap();
    let log = String::from_utf8_lossy(&std::fs::read(&log).unwrap()).into_owned();
    let picture = std::fs::read(&shot).unwrap_or_else(|error| panic!("no picture: {error}\n{log}"));
    (picture, log)
}

/// The pixels of the scene: right of the panel, above the time line.
fn scene_pixels(picture: &[u8]) -> Vec<[u8; 3]> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(picture)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    let (width, depth) = (frame.width as usize, frame.color_type.samples());
    assert!(width >= 1280 && frame.height >= 560, "{frame:?}");
    let pixel = |x: usize, y: usize| {
        let start = (y * width + x) * depth;
        [bytes[start], bytes[start + 1], bytes[start + 2]]
    };
    (100..540).flat_map(|y| (300..1270).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
}

#[test]
fn a_replay_opens_in_a_browser_without_complaint() {
    let Some(browser) = common::tool("a browser (Chromium in the path, or TUMBLENET_BROWSER)", browser())
    else {
        return;
    };
    let case = common::scene("cubesat-free", &["duration_s=1.0"]);
    let run = common::run(&case);
    let curves = Curves::of(&case, &run);
    let folder = tempfile::tempdir().unwrap();
    results::write(folder.path(), &case, &run, &curves, &Summary::of(&case, &run, &curves)).unwrap();
    let page = folder.path().join("replay.html");
    let (early, early_log) = picture(&browser, &page, "0.2");
    let (late, late_log) = picture(&browser, &page, "0.9");
    let moved = changed(&early, &late);
    assert!(moved > 1000, "{moved} pixels changed between 0.2 s and 0.9 s");
    // Without a graphics card the page draws on a canvas; the shaders draw the same.
    let card = folder.path().join("card.html");
    let text = std::fs::read_to_string(&page).unwrap();
    std::fs::write(&card, text.replacen("/swiftshader|", "/", 1)).unwrap();
    // A browser whose graphics process died draws on the canvas too, and says so in its log; another is asked then.
    let by_other = (0..3).map(|_| picture(&browser, &card, "0.9")).find(|(picture, log)| {
        let differs = changed(&late, picture) > 1000;
        if !differs {
            println!("both pictures are by the canvas, or both by shaders: {log}");
        }
        differs
    });
    let (by_shaders, log) = by_other.expect("a picture by shaders, which differs from that of the canvas");
    no_complaints(&[early_log, late_log, log]);
    let apart = unlike(&late, &by_shaders);
    assert!(apart < 4000, "{apart} pixels of 430 000 by canvas and shaders are unlike"); // measured 413
}

/// Pixels of the scene that are far from each other in two pictures.
fn unlike(one: &[u8], other: &[u8]) -> usize {
    let pairs = scene_pixels(one).into_iter().zip(scene_pixels(other));
    pairs.filter(|(a, b)| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 60)).count()
}

/// The browser had nothing to say of the page.
fn no_complaints(logs: &[String]) {
    for log in logs {
        // A machine without a graphics card is told so; that is no fault of the page.
        let chatter = |line: &&str| line.contains("GL Driver Message") || line.contains("software WebGL");
        let said = log.lines().filter(|line| line.contains("CONSOLE"));
        let complaints: Vec<&str> = said.filter(|line| !chatter(line)).collect();
        assert!(complaints.is_empty(), "{complaints:#?}");
    }
}

/// Pixels of the scene that differ between two pictures, neither of which is blank.
fn changed(one: &[u8], other: &[u8]) -> usize {
    let (one, other) = (scene_pixels(one), scene_pixels(other));
    for pixels in [&one, &other] {
        let colours: HashSet<&[u8; 3]> = pixels.iter().collect();
        assert!(colours.len() > 200, "a blank scene of {} colours", colours.len());
    }
    one.iter().zip(&other).filter(|(a, b)| a != b).count()
}

#[test]
fn runs_in_one_page_are_seen_in_each_other_and_side_by_side() {
    let folder = program::with_scene(|_| {});
    let at = folder.path();
    program::printed(at, &["run", "scene.json", "--out", "speed-2.0"]);
    program::printed(at, &["run", "scene.json", "--set", "launch.speed_m_s=2.6", "--out", "speed-2.6"]);
    let told = program::printed(at, &["replay", "speed-2.0", "speed-2.6"]);
    assert_eq!(told.trim(), "results/replay/replay.html");
    let page = std::fs::read_to_string(at.join("results/replay/replay.html")).unwrap();
    let data = tumblenet::report::replay::data(&page).unwrap();
    assert_eq!([&data["label"], &data["others"][0]["label"]], ["2.0", "2.6"]);

    let refused = |arguments: &[&str]| {
        let output = program::tumblenet(at, &[&["replay"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        program::err(&output)
    };
    std::fs::create_dir(at.join("other")).unwrap();
    std::fs::write(at.join("other/replay.html"), "<html></html>").unwrap();
    let told = refused(&["nowhere", "other", "--label", "a"]);
    for words in
        ["nowhere: found ", "other/replay.html: found a page of another kind", "one for each of 2 runs"]
    {
        assert!(told.contains(words), "{words} not in {told}");
    }

    let Some(browser) = common::tool("a browser (Chromium in the path, or TUMBLENET_BROWSER)", browser())
    else {
        return;
    };
    let alone = picture(&browser, &at.join("speed-2.0/replay.html"), "0.15&view=side");
    let both = at.join("results/replay/replay.html");
    let within = picture(&browser, &both, "0.15&view=side");
    let beside = picture(&browser, &both, "0.15&view=side&show=beside");
    no_complaints(&[alone.1, within.1, beside.1]);
    for (what, moved) in [("ghost", changed(&alone.0, &within.0)), ("beside", changed(&within.0, &beside.0))]
    {
        assert!(moved > 500, "{what}: {moved} pixels changed");
    }
}
