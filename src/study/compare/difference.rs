//! How far two runs are apart, and until when they tell the same story.
//!
//! The difference at a time is the distance between the same bullet in two runs (Section 4.5.1). Box
//! plots are Tukey's: quartiles, and whiskers to the furthest value within 1.5 interquartile ranges
//! of the box. The largest of the four distances, as the median over the pairs of runs, decides the
//! trust horizon: until then it stays below a stated distance.
//!
//! Where two runs were recorded at other times, the second is interpolated by straight pieces, which is off by up
//! to a Δt² / 8; give both the same `output.sample_s`, a multiple of both steps, to avoid it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::study::ensemble::Quartiles;

/// Reach of a whisker in interquartile ranges.
const WHISKER: f64 = 1.5;

/// The path of a net: where its bullets were.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// Times [s], T.
    pub time_s: Vec<f64>,
    /// The bullets [m], T × 4 × 3.
    pub bullets_m: Vec<[[f64; 3]; 4]>,
    /// Way of the net's centre of mass up to each time [m], T.
    pub travel_m: Vec<f64>,
}

/// A box plot in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BoxPlot {
    /// Least value within 1.5 interquartile ranges below the lower quartile.
    pub lower_whisker: f64,
    /// Lower quartile.
    pub lower: f64,
    /// Median.
    pub median: f64,
    /// Upper quartile.
    pub upper: f64,
    /// Largest value within 1.5 interquartile ranges above the upper quartile.
    pub upper_whisker: f64,
    /// Mean.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
    /// Number of values.
    pub count: usize,
}

impl BoxPlot {
    /// That of `values`, of which there is at least one.
    pub fn of(values: Vec<f64>) -> BoxPlot {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let Quartiles { lower, median, upper, max, count, .. } = Quartiles::of(values.clone());
        let reach = WHISKER * (upper - lower);
        // Quartiles lie between values: with few of them no value may be within reach on one side, and the whisker
        // then has no length.
        let within = |value: &&f64| (lower - reach..=upper + reach).contains(*value);
        let (least, most) = values
            .iter()
            .filter(within)
            .fold((lower, upper), |(least, most), &value| (least.min(value), most.max(value)));
        BoxPlot { lower_whisker: least, lower, median, upper, upper_whisker: most, mean, max, count }
    }
}

/// The bullets' differences over some span of time [m].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Differences {
    /// Of each bullet, over times and pairs of runs.
    pub bullets_m: [BoxPlot; 4],
    /// Of all four together.
    pub all_m: BoxPlot,
    /// Way of the net's centre of mass in that span, median over the pairs [m].
    pub travel_m: f64,
    /// Mean difference over that way [-]; null for a net that went nowhere.
    pub mean_over_travel: Option<f64>,
}

/// The largest difference of a bullet at each time, over the pairs of runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OverTime {
    /// Times [s].
    pub time_s: Vec<f64>,
    /// Lower quartile [m].
    pub lower_m: Vec<f64>,
    /// Median [m].
    pub median_m: Vec<f64>,
    /// Upper quartile [m].
    pub upper_m: Vec<f64>,
}

/// Until when runs agree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Horizon {
    /// Last time up to which the difference always stayed below the distance [s].
    pub time_s: f64,
    /// Whether that is the end of the run.
    pub to_the_end: bool,
}

/// How far runs are apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Separation {
    /// Pairs of runs.
    pub pairs: usize,
    /// Over the whole run.
    pub whole: Differences,
    /// Up to the trust horizon.
    pub trusted: Differences,
    /// The largest bullet difference over time.
    pub over_time: OverTime,
    /// Until when its median stays below the trust distance.
    pub trust_horizon: Horizon,
}

impl Separation {
    /// How far the two paths of each of `pairs` are apart, at the times of the first; nothing without pairs.
    pub fn of(pairs: &[(&Path, &Path)], trust_distance: f64) -> Option<Separation> {
        let apart: Vec<Vec<[f64; 4]>> = pairs.iter().map(|(one, other)| distances(one, other)).collect();
        // Runs of one case share their times; the shortest decides.
        let count = apart.iter().map(Vec::len).min().filter(|&count| count > 0)?;
        let mut over_time = OverTime { time_s: pairs[0].0.time_s[..count].to_vec(), ..OverTime::default() };
        for frame in 0..count {
            let largest = apart.iter().map(|run| run[frame].into_iter().fold(0.0, f64::max)).collect();
            let quartiles = Quartiles::of(largest);
            over_time.lower_m.push(quartiles.lower);
            over_time.median_m.push(quartiles.median);
            over_time.upper_m.push(quartiles.upper);
        }
        let (trust_horizon, trusted) = horizon(&over_time, trust_distance);
        let travel =
            |frames: usize| Quartiles::of(pairs.iter().map(|pair| pair.0.travel_m[frames - 1]).collect());
        Some(Separation {
            pairs: pairs.len(),
            whole: Differences::of(&apart, count, travel(count).median),
            trusted: Differences::of(&apart, trusted, travel(trusted).median),
            over_time,
            trust_horizon,
        })
    }
}

impl Differences {
    fn of(apart: &[Vec<[f64; 4]>], frames: usize, travel: f64) -> Differences {
        let bullet = |bullet: usize| -> Vec<f64> {
            apart.iter().flat_map(|run| run[..frames].iter().map(move |four| four[bullet])).collect()
        };
        let all_m = BoxPlot::of((0..4).flat_map(bullet).collect());
        Differences {
            bullets_m: [0, 1, 2, 3].map(|number| BoxPlot::of(bullet(number))),
            all_m,
            travel_m: travel,
            mean_over_travel: (travel > 0.0).then(|| all_m.mean / travel),
        }
    }
}

/// Until when the median stays below `distance`, and how many frames that are: at least the first, which is where
/// both were put.
fn horizon(over_time: &OverTime, distance: f64) -> (Horizon, usize) {
    let count = over_time.time_s.len();
    let frames = over_time.median_m.iter().position(|&median| median >= distance).unwrap_or(count).max(1);
    (Horizon { time_s: over_time.time_s[frames - 1], to_the_end: frames == count }, frames)
}

/// Distances of the four bullets of `one` and `other` at the times of `one` that `other` covers [m].
fn distances(one: &Path, other: &Path) -> Vec<[f64; 4]> {
    let Some(&end) = other.time_s.last() else { return Vec::new() };
    // A last time that differs by rounding is the same time.
    let slack = 1e-9 * end.abs();
    let covered = one.time_s.partition_point(|&time| time <= end + slack);
    (0..covered)
        .map(|frame| {
            let there = bullets_at(other, one.time_s[frame]);
            std::array::from_fn(|bullet| distance(&one.bullets_m[frame][bullet], &there[bullet]))
        })
        .collect()
}

fn bullets_at(path: &Path, time: f64) -> [[f64; 3]; 4] {
    let times = &path.time_s;
    if times.len() < 2 {
        return path.bullets_m[0];
    }
    let after = times.partition_point(|&t| t < time).clamp(1, times.len() - 1);
    let share = ((time - times[after - 1]) / (times[after] - times[after - 1])).clamp(0.0, 1.0);
    let (from, to) = (&path.bullets_m[after - 1], &path.bullets_m[after]);
    std::array::from_fn(|bullet| {
        std::array::from_fn(|axis| (1.0 - share) * from[bullet][axis] + share * to[bullet][axis])
    })
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Flies along X at 1 m/s; its bullets are aside by `offset` of the time.
    fn path(times: &[f64], offset: impl Fn(f64) -> f64) -> Path {
        Path {
            time_s: times.to_vec(),
            bullets_m: times
                .iter()
                .map(|&t| std::array::from_fn(|b| [t, b as f64 + offset(t), 0.0]))
                .collect(),
            travel_m: times.to_vec(),
        }
    }

    fn tenths(count: usize) -> Vec<f64> {
        (0..count).map(|i| 0.1 * i as f64).collect()
    }

    /// Quartiles as statrs gives them (median-unbiased, Hyndman and Fan's type 8): for 1 to 11 at
    /// 1/4 (n + 1/3) + 1/3 = 3 1/6.
    #[test]
    fn box_plot_of_known_data() {
        let mut values: Vec<f64> = (1..=10).map(f64::from).collect();
        values.push(100.0);
        let plot = BoxPlot::of(values);
        assert!((plot.lower - (3.0 + 1.0 / 6.0)).abs() < 1e-12, "{plot:?}");
        assert!((plot.upper - (8.0 + 5.0 / 6.0)).abs() < 1e-12, "{plot:?}");
        assert_eq!((plot.median, plot.max, plot.count), (6.0, 100.0, 11));
        assert_eq!((plot.lower_whisker, plot.upper_whisker), (1.0, 10.0), "100 is an outlier");
        assert!((plot.mean - 155.0 / 11.0).abs() < 1e-12);
    }

    #[test]
    fn box_plot_of_one_value_is_that_value() {
        let plot = BoxPlot::of(vec![2.0]);
        let numbers = [plot.lower_whisker, plot.lower, plot.median, plot.upper, plot.upper_whisker];
        assert_eq!(numbers, [2.0; 5]);
    }

    #[test]
    fn the_horizon_is_the_last_time_below_the_distance() {
        let times = tenths(11);
        let (base, drifting) = (path(&times, |_| 0.0), path(&times, |t| 0.01 * t));
        let apart = Separation::of(&[(&base, &drifting)], 0.0055).unwrap();
        assert!((apart.trust_horizon.time_s - 0.5).abs() < 1e-12, "{:?}", apart.trust_horizon);
        assert!(!apart.trust_horizon.to_the_end);
        assert!(
            (apart.trusted.all_m.max - 0.005).abs() < 1e-12 && (apart.whole.all_m.max - 0.01).abs() < 1e-12
        );
        assert!((apart.whole.mean_over_travel.unwrap() - 0.005).abs() < 1e-12, "mean 5 mm over 1 m");
        assert!(Separation::of(&[(&base, &drifting)], 0.1).unwrap().trust_horizon.to_the_end);
        assert_eq!(Separation::of(&[(&base, &drifting)], 0.0).unwrap().trust_horizon.time_s, 0.0);
        assert!(Separation::of(&[], 0.1).is_none());
    }

    /// A difference that comes back below the distance is no agreement.
    #[test]
    fn the_horizon_ends_at_the_first_crossing() {
        let times = tenths(11);
        let bump = path(&times, |t| if (0.25..0.35).contains(&t) { 1.0 } else { 0.0 });
        let apart = Separation::of(&[(&path(&times, |_| 0.0), &bump)], 0.1).unwrap();
        assert!((apart.trust_horizon.time_s - 0.2).abs() < 1e-12);
    }

    #[test]
    fn one_run_in_three_that_goes_astray_does_not_end_the_horizon() {
        let times = tenths(11);
        let (base, near, far) = (path(&times, |_| 0.0), path(&times, |_| 1e-3), path(&times, |_| 1.0));
        let apart = Separation::of(&[(&base, &near), (&base, &near), (&base, &far)], 0.1).unwrap();
        assert!(apart.trust_horizon.to_the_end);
        assert_eq!(apart.pairs, 3);
    }

    #[test]
    fn runs_recorded_at_other_times_and_shorter_are_compared_where_both_were() {
        let (base, other) = (path(&tenths(11), |_| 0.0), path(&[0.0, 0.25, 0.5], |_| 0.002));
        let apart = Separation::of(&[(&base, &other)], 0.1).unwrap();
        assert_eq!(apart.over_time.time_s.len(), 6);
        assert!(
            (apart.whole.all_m.max - 0.002).abs() < 1e-12 && (apart.whole.all_m.mean - 0.002).abs() < 1e-12
        );
    }
}
