//! The windows of a long segment.
//!
//! A long segment is not one experiment: sticking comes and goes, loads drift, and days follow nights. Slow
//! movement dominates the spectrum of the whole segment and would mask the valve. So the segment is divided into
//! windows of many cycles of the loop.
//!
//! A window has [`WINDOW_SAMPLES`] samples or, if the loop cycles slowly, [`WINDOW_CYCLES`] cycles. To detect that,
//! windows of growing length are tried. Cycles count as cycles of the loop if windows contain [`FEWEST_CYCLES`] or more
//! of them. Drift has no period, so a longer window then shows a longer period. A day is not a cycle of the loop, hence
//! [`SLOWEST_S`].

use super::recorded_period;
use crate::parallel::*;
use crate::recording::Segment;
use crate::series::median;

/// Largest number of windows: three quarters of a week at 5 s.
const MOST_WINDOWS: usize = 60;
/// Number of samples of a window, unless its cycles are long: as many as the training loops have, 300 to 2,000. Of
/// 2,000 valves with long records, pools of windows of 1,500 samples separate the sticking ones better than those of
/// 4,000 (AUC 0.911 and 0.890).
pub const WINDOW_SAMPLES: usize = 1_500;
/// A segment of up to this many samples is one window. It is hardly longer than a training loop.
const UNDIVIDED: usize = 2_500;
/// Cycles of a window, if they are long.
pub const WINDOW_CYCLES: f64 = 25.0;
/// Fewest cycles in a window for its period to count as the loop's period.
pub const FEWEST_CYCLES: f64 = 12.0;
/// The longest period of a cycle of the loop that needs longer windows, s.
pub const SLOWEST_S: f64 = 4.0 * 3600.0;
/// Smallest number of samples of a segment beside the longest.
const SHORTEST: usize = 300;
/// The shortest length in which cycles are looked for.
const SHORTEST_TRIED: usize = 4_000;
/// Factor between the tried lengths of windows.
const LONGER: usize = 4;
/// Number of windows whose period is computed.
const ASKED: usize = 5;

/// The windows of a segment in order of time: the segment itself if it is short, else evenly spread ones.
pub fn windows(segment: &Segment) -> Vec<Segment> {
    spread(segment, length(segment), MOST_WINDOWS)
}

/// The windows of several segments in order of time, at most as many as of one: evenly spread ones. Segments of less than
/// 300 samples, the shortest of training loops, have none, except the longest of all.
pub fn windows_of_all(segments: &[Segment]) -> Vec<Segment> {
    let least = segments.iter().map(Segment::len).max().unwrap_or(0).min(SHORTEST);
    let counts = |segment: &&Segment| segment.len() >= least;
    let all: Vec<Segment> = segments.iter().filter(counts).flat_map(windows).collect();
    match all.len() {
        n if n <= MOST_WINDOWS => all,
        n => (0..MOST_WINDOWS).map(|k| all[(n - 1) * k / (MOST_WINDOWS - 1)].clone()).collect(),
    }
}

/// Samples of a window.
fn length(segment: &Segment) -> usize {
    let n = segment.len();
    if n <= UNDIVIDED {
        return n;
    }
    let shortest = SHORTEST_TRIED.min(n);
    let mut tried = shortest;
    // Longer ones would show only slower cycles.
    let longest = LONGER as f64 * FEWEST_CYCLES * SLOWEST_S / segment.sample_time;
    while tried <= n && (tried == shortest || tried as f64 <= longest) {
        let period = typical_period(segment, tried);
        let short_enough = tried == shortest || period * segment.sample_time <= SLOWEST_S;
        if FEWEST_CYCLES * period <= tried as f64 && short_enough {
            return WINDOW_SAMPLES.max((WINDOW_CYCLES * period).round() as usize).min(n);
        }
        tried = tried.saturating_mul(LONGER);
    }
    WINDOW_SAMPLES.min(n)
}

/// The median period of some windows, in samples; infinite if no window has a period.
fn typical_period(segment: &Segment, length: usize) -> f64 {
    let asked = spread(segment, length, ASKED);
    let periods: Vec<f64> = asked.par_iter().filter_map(recorded_period).collect();
    if periods.is_empty() { f64::INFINITY } else { median(&periods) }
}

/// Windows of `length` samples, evenly spread over a segment. Their number is at most `most`, and otherwise as many as
/// fit, including the last partial one.
fn spread(segment: &Segment, length: usize, most: usize) -> Vec<Segment> {
    let n = segment.len();
    if n <= length {
        return vec![segment.clone()];
    }
    let count = n.div_ceil(length).min(most);
    let last = n - length;
    let from = |k: usize| if count == 1 { 0 } else { last * k / (count - 1) };
    (0..count).map(|k| segment.part(from(k), length)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::Signal;

    fn segment(n: usize, period: f64) -> Segment {
        let wave = |k: usize| (std::f64::consts::TAU * k as f64 / period).sin();
        Segment {
            from: 100.0,
            sample_time: 2.0,
            op: (0..n).map(|k| 50.0 + wave(k)).collect(),
            pv: Some((0..n).map(|k| wave(k + 3)).collect()),
            sp: None,
            vp: None,
            bridged: 0,
        }
    }

    #[test]
    fn windows_are_spread_over_the_segment() {
        for short in [1, 1_700, 2_500] {
            assert_eq!(windows(&segment(short, 40.0)), [segment(short, 40.0)]);
        }
        let of_long = windows(&segment(30_000, 40.0));
        assert_eq!(of_long.len(), 20);
        assert!(of_long.iter().all(|window| window.len() == WINDOW_SAMPLES));
        assert_eq!(of_long[0].from, 100.0);
        assert_eq!(of_long[19].from, 100.0 + 2.0 * 28_500.0);
        assert_eq!(windows(&segment(500_000, 40.0)).len(), MOST_WINDOWS);
        // Long cycles make long windows.
        let of_slow = windows(&segment(30_000, 500.0));
        assert!(of_slow.len() == 3 && of_slow[0].len() > 12_000, "{}", of_slow[0].len());
    }

    #[test]
    fn all_segments_have_windows() {
        let segments = [9_000, 500, 299, 3_000].map(|n| segment(n, 40.0));
        let all = windows_of_all(&segments);
        let samples: Vec<usize> = all.iter().map(Segment::len).collect();
        assert_eq!(samples, [1_500, 1_500, 1_500, 1_500, 1_500, 1_500, 500, 1_500, 1_500]);
        assert_eq!(windows_of_all(&segments[..1]), windows(&segments[0]));
        assert_eq!(windows_of_all(&segments[2..3]), windows(&segments[2]));
        let many = vec![segment(500, 40.0); 100];
        assert_eq!(windows_of_all(&many).len(), MOST_WINDOWS);
    }

    #[test]
    fn neither_drift_nor_a_day_makes_windows_long() {
        let mut drifting = segment(100_000, 60.0);
        let drift =
            Signal::RandomWalk { sd_per_sqrt_s: 0.1, seed: 3 }.sample(2.0, 100_000).unwrap();
        drifting.op.iter_mut().zip(&drift).for_each(|(op, drift)| *op += drift);
        drifting.pv.iter_mut().flatten().zip(&drift).for_each(|(pv, drift)| *pv += drift);
        assert!(windows(&drifting).iter().all(|window| window.len() <= SHORTEST_TRIED));
        let days = Segment { sample_time: 60.0, ..segment(30_000, 1_000.0) };
        assert!(windows(&days).iter().all(|window| window.len() == WINDOW_SAMPLES));
        let cycles = Segment { sample_time: 5.0, ..segment(30_000, 1_000.0) };
        assert_eq!(windows(&cycles).len(), 2);
    }

    #[test]
    fn what_has_no_period_is_looked_at_all_the_same() {
        let still = Segment { op: vec![50.0; 9_000], ..segment(9_000, 40.0) };
        assert_eq!(windows(&still).len(), 6);
        assert!(windows(&Segment { op: vec![], pv: None, ..still }).len() == 1);
    }
}
