//! A strip of pictures: a column a time, a row a view and run, all in one scale with a bar of metres.

use std::fmt::Write as _;

use super::seen::{SeenLine, SeenPicture, SeenStroke, View};
use super::{FigureRequest, LEAST_PICTURE, ShownRun};
use crate::report::page::escape;
use crate::report::recorded::RecordedRun;

/// Space between pictures [mm].
pub const GAP: f64 = 2.0;

/// Size of text: 7.5 points [mm].
const TEXT: f64 = 2.65;

/// Room for a line of text [mm].
const LINE: f64 = 4.2;

/// Most height of a picture over the width of the strip.
const TALLEST: f64 = 0.35;

/// Shades of cables, from those far away to those near: grey from 0 to 255, and width [mm].
const SHADES: [(u8, f64); 3] = [(150, 0.13), (90, 0.16), (20, 0.19)];

/// Brightness of the target's faces, from dark to light.
const FACES: [f64; 2] = [140.0, 245.0];

/// Radius of a bullet [mm].
const BULLET: f64 = 0.55;

/// A row of pictures.
struct PictureRow {
    /// What tells it from others; may be empty.
    words: String,
    times: Vec<f64>,
    pictures: Vec<SeenPicture>,
}

/// The strip of `runs` as SVG.
pub fn svg(runs: &[ShownRun], request: &FigureRequest) -> String {
    let rows: Vec<PictureRow> = runs
        .iter()
        .flat_map(|shown| request.views.iter().map(move |&view| row(shown, view, request)))
        .collect();
    let (scale, columns) = layout(&rows, request.width);
    let has_words = rows.iter().any(|row| !row.words.is_empty());
    let mut body = String::new();
    let mut top = GAP;
    for row in &rows {
        if has_words {
            text(&mut body, [GAP, top + 0.75 * LINE], "start", &row.words);
            top += LINE;
        }
        let high = scale * row.pictures.iter().map(|seen| size(seen)[1]).fold(0.0, f64::max) + 2.0 * BULLET;
        let mut left = GAP;
        for ((time, seen), wide) in row.times.iter().zip(&row.pictures).zip(&columns) {
            let middle = [left + 0.5 * wide, top + 0.5 * high];
            body.push_str("<g class=\"picture\">\n");
            picture(&mut body, seen, middle, scale);
            text(&mut body, [middle[0], top + high + 0.8 * LINE], "middle", &format!("{} s", tidy(*time)));
            body.push_str("</g>\n");
            left += wide + GAP;
        }
        top += high + LINE + GAP;
    }
    bar(&mut body, [GAP, top], columns.first().copied().unwrap_or(LEAST_PICTURE), scale);
    let height = top + LINE;
    let width = request.width;
    format!(
        "<svg width=\"{width}mm\" height=\"{height:.2}mm\" viewBox=\"0 0 {width} {height:.2}\" \
         xmlns=\"http://www.w3.org/2000/svg\">\n<rect width=\"{width}\" height=\"{height:.2}\" fill=\"#FFFFFF\"/>\n{body}</svg>\n"
    )
}

/// How wide and high a picture is [m].
fn size(seen: &SeenPicture) -> [f64; 2] {
    [0, 1].map(|axis| seen.bounds[1][axis] - seen.bounds[0][axis])
}

/// Millimetres a metre, and the width of each column [mm]: as large as what is seen in it, but never narrower than its time.
fn layout(rows: &[PictureRow], width: f64) -> (f64, Vec<f64>) {
    let n_columns = rows.iter().map(|row| row.pictures.len()).max().unwrap_or(0);
    let widest = |column: usize| {
        let sizes = rows.iter().filter_map(|row| row.pictures.get(column)).map(|seen| size(seen)[0]);
        sizes.fold(f64::MIN_POSITIVE, f64::max)
    };
    let wanted: Vec<f64> = (0..n_columns).map(widest).collect();
    let highest = rows.iter().flat_map(|row| &row.pictures).map(|seen| size(seen)[1]);
    let most = TALLEST * width / highest.fold(f64::MIN_POSITIVE, f64::max);
    let room = width - GAP * (n_columns as f64 + 1.0);
    // The least width of some columns takes from the others: the scale that fills the room is met from above.
    let filled = |scale: f64| {
        wanted.iter().map(|metres| (scale * metres + 2.0 * BULLET).max(LEAST_PICTURE)).sum::<f64>()
    };
    let (mut low, mut high) = (0.0, most);
    for _ in 0..60 {
        let scale = 0.5 * (low + high);
        if filled(scale) > room { high = scale } else { low = scale }
    }
    let taken: Vec<f64> =
        wanted.iter().map(|metres| (low * metres + 2.0 * BULLET).max(LEAST_PICTURE)).collect();
    let spare = (room - taken.iter().sum::<f64>()).max(0.0) / n_columns.max(1) as f64;
    (low, taken.into_iter().map(|wide| wide + spare).collect())
}

fn row(shown: &ShownRun, view: View, request: &FigureRequest) -> PictureRow {
    let times = request.at.clone().unwrap_or_else(|| moments(&shown.run));
    let view_words = if request.views.len() > 1 { view.name } else { "" };
    let words: Vec<&str> =
        [shown.label.as_str(), view_words].into_iter().filter(|word| !word.is_empty()).collect();
    PictureRow {
        words: words.join(", "),
        pictures: times.iter().map(|&time| SeenPicture::of(&shown.run, time, view)).collect(),
        times,
    }
}

/// Moments worth a picture [s]: half of the way to the target, first contact, held, settled, the end; of a run that meets none,
/// four in equal steps.
fn moments(run: &RecordedRun) -> Vec<f64> {
    let [start, end] = [run.paths.time[0], run.end()];
    let first = run.summary.contact.and_then(|contact| contact.first_contact_s);
    let mut moments: Vec<f64> = match first {
        None => (1..=4).map(|quarter| start + 0.25 * f64::from(quarter) * (end - start)).collect(),
        Some(first) => {
            let capture = run.summary.capture;
            let held = capture.and_then(|capture| capture.captured_at_s.or(capture.enclosed_at_s));
            let settled = capture.and_then(|capture| capture.settled_at_s);
            let between = first + 0.25 * (end - first);
            [Some(0.6 * first), Some(first), held.or(Some(between)), settled, Some(end)]
                .into_iter()
                .flatten()
                .collect()
        }
    };
    moments.retain(|time| (start..=end).contains(time));
    moments.sort_by(f64::total_cmp);
    moments.dedup_by(|later, earlier| *later - *earlier < 0.03 * (end - start));
    moments
}

/// A time with no more digits than it needs.
fn tidy(time: f64) -> String {
    let text = format!("{time:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn text(body: &mut String, at: [f64; 2], anchor: &str, words: &str) {
    let _ = writeln!(
        body,
        "<text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"{anchor}\" font-family=\"sans-serif\" font-size=\"{TEXT}\" \
         fill=\"#17202B\">{}</text>",
        at[0],
        at[1],
        escape(words)
    );
}

/// A bar of a round length, and how long that is.
fn bar(body: &mut String, at: [f64; 2], wide: f64, scale: f64) {
    let most = 0.6 * wide / scale;
    let ten = 10_f64.powf(most.log10().floor());
    let metres = [5.0, 2.0, 1.0].iter().map(|step| step * ten).find(|length| *length <= most).unwrap_or(ten);
    let [x, y] = [at[0] + 0.2, at[1] + 0.4 * LINE];
    let end = x + metres * scale;
    let _ = writeln!(
        body,
        "<path class=\"bar\" fill=\"none\" stroke=\"#17202B\" stroke-width=\"0.25\" \
         d=\"M{x:.2} {:.2}v1.6M{x:.2} {y:.2}H{end:.2}M{end:.2} {:.2}v1.6\"/>",
        y - 0.8,
        y - 0.8
    );
    text(body, [end + 1.2, y + 0.35 * TEXT], "start", &format!("{} m", tidy(metres)));
}

/// What is seen, its middle at `middle` [mm], so many `scale` millimetres a metre.
fn picture(body: &mut String, seen: &SeenPicture, middle: [f64; 2], scale: f64) {
    let [low, high] = seen.bounds;
    let centre = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
    let at = |point: &[f64; 2]| {
        [middle[0] + scale * (point[0] - centre[0]), middle[1] - scale * (point[1] - centre[1])]
    };
    faces(body, seen, &at);
    let is_edge = |stroke: &&SeenStroke| stroke.line == SeenLine::BodyEdge;
    strokes(body, seen.strokes.iter().filter(is_edge), &at, 50, 0.18);
    for (shade, (grey, width)) in SHADES.iter().enumerate() {
        let of = |line: SeenLine| {
            seen.strokes.iter().filter(move |stroke| {
                stroke.line == line
                    && ((stroke.near * SHADES.len() as f64) as usize).min(SHADES.len() - 1) == shade
            })
        };
        strokes(body, of(SeenLine::Cable), &at, *grey, *width);
        strokes(body, of(SeenLine::NetEdge), &at, *grey, 1.8 * width);
    }
    let is_thread = |stroke: &&SeenStroke| stroke.line == SeenLine::Thread;
    strokes(body, seen.strokes.iter().filter(is_thread), &at, 0, 0.32);
    for bullet in &seen.bullets {
        let [x, y] = at(bullet);
        let _ = writeln!(body, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{BULLET}\" fill=\"#000000\"/>");
    }
}

/// Faces that follow each other in one grey become one path.
fn faces(body: &mut String, seen: &SeenPicture, at: &impl Fn(&[f64; 2]) -> [f64; 2]) {
    let mut grey = None;
    for face in &seen.faces {
        let shade = (FACES[0] + (FACES[1] - FACES[0]) * face.light).round() as u8;
        if grey != Some(shade) {
            body.push_str(if grey.is_some() { "\"/>\n" } else { "" });
            let hex = format!("#{shade:02X}{shade:02X}{shade:02X}");
            // The stroke closes the seams between neighbours.
            let _ = write!(
                body,
                "<path fill=\"{hex}\" stroke=\"{hex}\" stroke-width=\"0.06\" stroke-linejoin=\"round\" d=\""
            );
            grey = Some(shade);
        }
        let [a, b, c] = face.corners.each_ref().map(at);
        let _ = write!(body, "M{:.2} {:.2}L{:.2} {:.2} {:.2} {:.2}Z", a[0], a[1], b[0], b[1], c[0], c[1]);
    }
    body.push_str(if grey.is_some() { "\"/>\n" } else { "" });
}

/// Strokes of one look as one path.
fn strokes<'a>(
    body: &mut String,
    strokes: impl Iterator<Item = &'a SeenStroke>,
    at: &impl Fn(&[f64; 2]) -> [f64; 2],
    grey: u8,
    width: f64,
) {
    let mut path = String::new();
    for stroke in strokes {
        let [from, to] = stroke.ends.each_ref().map(at);
        let _ = write!(path, "M{:.2} {:.2}L{:.2} {:.2}", from[0], from[1], to[0], to[1]);
    }
    if !path.is_empty() {
        let _ = writeln!(
            body,
            "<path fill=\"none\" stroke=\"#{grey:02X}{grey:02X}{grey:02X}\" stroke-width=\"{width:.2}\" \
             stroke-linecap=\"round\" d=\"{path}\"/>"
        );
    }
}
