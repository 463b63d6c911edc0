//! What changed about a valve, and when.
//!
//! # Rule
//! A change is a step between two windows of a valve. For each window the rule uses log-odds `l` of the probability
//! that the valve sticks, limited to those of 99 %. Where they are known, it also uses the logarithms of the loop's
//! amplitude, period, OP travel and OP reversals. Windows are added in order of time. With each, every place `k` of a
//! step since the last change, 28 days back at most, gets the gain in log-likelihood of a step with unknown noise. On
//! each side are windows of at least [`SIDE`] days, or at least two that hold [`MANY`] windows of a diagnosis.
//!
//! ```text
//! gain = (NU + n)/2 ln((NU s^2 + SS)/(NU s^2 + SS_before + SS_after))
//! ```
//!
//! `n` is the number of windows, `SS` their sum of squares about the mean, `SS_before` and `SS_after` those about the
//! means of the two sides. The noise has a prior of [`NU`] degrees of freedom about `s`: [`NOISE`] for log-odds,
//! [`MOVES`] for logarithms. The score of `k` is the gain of the log-odds plus the gains of the four logarithms, which
//! add [`MOVES_MOST`] at most: a repaired valve moves its loop differently. The change is at the `k` of the largest
//! score. All `k` whose score is within [`WITHIN`] of the best are its 95 % interval.
//!
//! The valve began or ceased to stick under three conditions. The score reaches [`THRESHOLD`], the mean log-odds differ
//! by [`FARTHEST`], and all windows of one side, combined, accuse the valve while all windows of the other side do not.
//! Up is *new*, or *returned* if the valve stuck before. Down is *gone*. Otherwise the valve is *worse* or *better* if
//! the gain of `ln S`, with noise [`S_NOISE`], reaches [`S_THRESHOLD`] and S grows or shrinks by [`GROWTH`]. Later
//! windows place the change better, until the next one is found.
//!
//! A single day never makes a change, because a day that is unlike all others comes and goes.
//!
//! # Limits
//! The threshold is set by false alarms on demo plants, see `docs/plant.md`. A valve that sticks too little to be accused
//! changes unseen.

use super::history::together;
use super::observation::Observation;
use super::weighing::log_odds;
use crate::series::mean;
use stiction_model::named;

/// The least score of a change by log-odds.
pub const THRESHOLD: f64 = 6.0;
/// The least score of a change of S. It is lower, because the noise of S is better known.
pub const S_THRESHOLD: f64 = 4.0;
/// Days of windows on each side of a change, at least, if there are not [`MANY`].
pub const SIDE: f64 = 2.0;
/// Windows of a diagnosis on each side of a change, at least, if there are not [`SIDE`] days. `docs/accuracy.md` reports
/// how often the result is wrong.
pub const MANY: f64 = 5.0;
/// The least change of the mean log-odds: odds of 9 to 1.
pub const FARTHEST: f64 = 2.2;
/// Least share by which S grows or shrinks.
pub const GROWTH: f64 = 0.25;
/// Degrees of freedom of the prior of the noise.
pub const NU: f64 = 3.0;
/// The noise of log-odds.
pub const NOISE: f64 = 0.8;
/// The noise of the logarithms of amplitude, period, OP travel and OP reversals.
pub const MOVES: f64 = 0.1;
/// What these four add at most.
pub const MOVES_MOST: f64 = 3.0;
/// The noise of the logarithm of S.
pub const S_NOISE: f64 = 0.08;
/// How far below the best the scores of an interval go: half the 95 % quantile of chi-squared with one degree of freedom.
pub const WITHIN: f64 = 1.92;
/// How long before, s.
const MEMORY: f64 = 28.0 * 86_400.0;

named! {
    /// What changed, the worst first.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    pub enum Change {
        /// The valve sticks, and did not before.
        New = "new",
        /// The valve sticks again.
        Returned = "returned",
        /// The valve sticks after a repair as it did before.
        StillSticks = "still sticks",
        /// S grew.
        Worse = "worse",
        /// S shrank.
        Better = "better",
        /// The valve no longer shows stiction.
        Gone = "gone",
        /// Nothing.
        #[default]
        None = "none",
    }
}

impl Change {
    /// The change with its day: `new since 2026-03-06`.
    pub fn since(self, day: &str) -> String {
        match self {
            Self::StillSticks => format!("still sticks after the repair of {day}"),
            _ => format!("{} since {day}", self.name()),
        }
    }

    /// Whether the valve began or ceased to stick, so that windows before say nothing about the present state.
    pub fn begins_anew(self) -> bool {
        !matches!(self, Self::Worse | Self::Better | Self::None)
    }

    /// In words, before its time.
    pub fn words(self) -> &'static str {
        match self {
            Self::New => "the valve began to stick",
            Self::Returned => "the valve began to stick again",
            Self::StillSticks => "the valve sticks as before the repair",
            Self::Worse => "S grew",
            Self::Better => "S shrank",
            Self::Gone => "the valve ceased to stick visibly",
            Self::None => "nothing changed",
        }
    }
}

/// A change of a valve between two windows.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, schemars::JsonSchema),
    schemars(rename = "ValveChange")
)]
pub struct Event {
    /// The kind of change.
    pub change: Change,
    /// Time of the first window after the change, s.
    #[cfg_attr(feature = "serde", serde(rename = "time_s"))]
    pub time: f64,
    /// The 95 % interval of the time of the change, s.
    #[cfg_attr(feature = "serde", serde(rename = "interval_s"), schemars(with = "[f64; 2]"))]
    pub interval: (f64, f64),
    /// Time of the window with which the change was found, s.
    #[cfg_attr(feature = "serde", serde(rename = "found_s"))]
    pub found: f64,
}

/// A window: its observation of the valve, and how the loop moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// The observation of the valve.
    pub valve: Observation,
    /// Days of the window; 0 where its duration is not known.
    pub days: f64,
    /// Logarithms of amplitude, period, OP travel and OP reversals, where they are known.
    pub moves: [Option<f64>; 4],
}

impl Seen {
    fn log_odds(&self) -> Option<f64> {
        self.valve.probability.map(log_odds)
    }

    fn log_s(&self) -> Option<f64> {
        self.valve.s.map(|s| s.value).filter(|s| *s > 0.0).map(f64::ln)
    }
}

/// All changes of a valve, from its windows in order of time and the times of its known repairs.
pub fn events(windows: &[Seen], repairs: &[f64]) -> Vec<Event> {
    let mut events: Vec<Event> = vec![];
    let mut since = 0;
    // The window from which on the last change by log-odds was found, and that change.
    let mut last: Option<(usize, Change)> = None;
    for end in 0..windows.len() {
        let now = windows[end].valve.time;
        let first = windows.partition_point(|seen| now - seen.valve.time > MEMORY).max(since);
        let by_odds = step(&windows[first..=end], (odds_score, THRESHOLD), moved);
        let change = by_odds.or_else(|| step(&windows[first..=end], (s_score, S_THRESHOLD), grown));
        let Some((change, best)) = change else {
            // With more windows the last change is placed better.
            if let (Some((from, change)), Some(event)) = (last, events.last_mut())
                && let Some((again, best)) =
                    step(&windows[from..=end], (odds_score, THRESHOLD), moved)
                && again == change
            {
                event.place(windows, from, best);
                since = from + best.at;
            }
            continue;
        };
        let mut event = Event { change, time: now, interval: (now, now), found: now };
        event.place(windows, first, best);
        let stuck_before = events.iter().any(|event| event.change == Change::Gone)
            || repairs.iter().any(|repair| *repair <= event.time);
        if change == Change::New && stuck_before {
            event.change = Change::Returned;
        }
        events.push(event);
        last = by_odds.map(|(change, _)| (first, change));
        since = first + best.at;
    }
    events
}

impl Event {
    /// The change in words, such as "the valve began to stick at about 2 h (between 1 h and 3 h)"; `moment` writes a
    /// time. All times are times of windows, so their resolution is one window.
    pub fn words(&self, moment: impl Fn(f64) -> String) -> String {
        let (what, at, (from, to)) = (self.change.words(), moment(self.time), self.interval);
        match from == to {
            true => format!("{what} at about {at}"),
            false => format!("{what} at about {at} (between {} and {})", moment(from), moment(to)),
        }
    }

    /// Sets the time and its interval from the place of the step; places count from window `first`.
    fn place(&mut self, windows: &[Seen], first: usize, best: Best) {
        let time = |k: usize| windows[first + k].valve.time;
        (self.time, self.interval) = (time(best.at), (time(best.first), time(best.last)));
    }
}

/// Since when the valve is in its present state, s: the last time it began or ceased to stick.
pub fn present_since(events: &[Event]) -> f64 {
    let other = events.iter().rev().find(|event| event.change.begins_anew());
    other.map_or(f64::NEG_INFINITY, |event| event.time)
}

/// The change at the likeliest place of a step, if its score reaches a threshold.
fn step(
    windows: &[Seen],
    (score, threshold): (impl Fn(&[Seen], &[Seen]) -> f64, f64),
    change: impl Fn(&[Seen], &[Seen]) -> Option<Change>,
) -> Option<(Change, Best)> {
    let best = best(windows, score).filter(|best| best.score >= threshold)?;
    let (before, after) = windows.split_at(best.at);
    Some((change(before, after)?, best))
}

/// The likeliest place of a step.
#[derive(Clone, Copy)]
struct Best {
    score: f64,
    /// The first window after the step.
    at: usize,
    /// The first and the last window of its interval.
    first: usize,
    last: usize,
}

/// The place of a step in windows with the largest score.
fn best(windows: &[Seen], score: impl Fn(&[Seen], &[Seen]) -> f64) -> Option<Best> {
    let scores: Vec<(usize, f64)> =
        (1..windows.len()).map(|k| (k, score(&windows[..k], &windows[k..]))).collect();
    let (at, most) = scores.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let mut near = scores.iter().filter(|(_, score)| *score >= most - WITHIN).map(|(k, _)| *k);
    let first = near.next()?;
    Some(Best { score: most, at, first, last: near.next_back().unwrap_or(first) })
}

fn odds_score(before: &[Seen], after: &[Seen]) -> f64 {
    let moves: f64 = (0..4).map(|of| gain(before, after, |seen| seen.moves[of], MOVES)).sum();
    gain(before, after, Seen::log_odds, NOISE) + moves.min(MOVES_MOST)
}

fn s_score(before: &[Seen], after: &[Seen]) -> f64 {
    gain(before, after, Seen::log_s, S_NOISE)
}

/// The gain in log-likelihood of a step; 0 with too few values on a side.
fn gain(
    before: &[Seen],
    after: &[Seen],
    of: impl Fn(&Seen) -> Option<f64> + Copy,
    noise: f64,
) -> f64 {
    let is_enough = |side: &[Seen]| {
        let (mut number, mut days, mut many) = (0, 0.0, 0.0);
        for seen in side.iter().filter(|seen| of(seen).is_some()) {
            (number, days, many) = (number + 1, days + seen.days, many + seen.valve.windows);
        }
        // Days of the plant's clock have 23 to 25 hours. Windows that overlap count once.
        days >= SIDE - 0.1 || number > 1 && many >= MANY - 0.1
    };
    if !is_enough(before) || !is_enough(after) {
        return 0.0;
    }
    let [old, new] = [before, after].map(|side| side.iter().filter_map(of).collect::<Vec<f64>>());
    let rest = NU * noise * noise + squares(&old) + squares(&new);
    let n = (old.len() + new.len()) as f64;
    let step = (mean(&new) - mean(&old)).powi(2) * old.len() as f64 * new.len() as f64 / n;
    (NU + n) / 2.0 * (step / rest).ln_1p()
}

/// The sum of squares about the mean.
fn squares(of: &[f64]) -> f64 {
    let middle = mean(of);
    of.iter().map(|value| (value - middle).powi(2)).sum()
}

/// Whether the valve began to stick or ceased to.
fn moved(before: &[Seen], after: &[Seen]) -> Option<Change> {
    let middle = |side: &[Seen]| mean(&side.iter().filter_map(Seen::log_odds).collect::<Vec<_>>());
    let (from, to) = (middle(before), middle(after));
    if (to - from).abs() < FARTHEST {
        return None;
    }
    match (accused(before), accused(after)) {
        (false, true) if to > from => Some(Change::New),
        (true, false) if to < from => Some(Change::Gone),
        _ => None,
    }
}

/// Whether windows, combined, accuse the valve.
fn accused(windows: &[Seen]) -> bool {
    let seen: Vec<Observation> = windows.iter().map(|seen| seen.valve.clone()).collect();
    together(&seen).is_ok_and(|history| history.grade.accuses())
}

/// Whether it sticks more or less, by S.
fn grown(before: &[Seen], after: &[Seen]) -> Option<Change> {
    let middle = |side: &[Seen]| mean(&side.iter().filter_map(Seen::log_s).collect::<Vec<_>>());
    let by = (middle(after) - middle(before)).exp();
    match () {
        () if by >= 1.0 + GROWTH => Some(Change::Worse),
        () if by * (1.0 + GROWTH) <= 1.0 => Some(Change::Better),
        () => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::{Estimate, VerdictClass};

    const DAY: f64 = 86_400.0;

    fn seen(days: &[(f64, Option<f64>)]) -> Vec<Seen> {
        let valve = |(day, (p, s)): (usize, &(f64, Option<f64>))| Observation {
            grade: None,
            time: day as f64 * DAY,
            class: VerdictClass::CannotTell,
            probability: Some(*p),
            s: s.map(|value| Estimate { value, low: 0.9 * value, high: 1.1 * value }),
            j: None,
            weight: 1.0,
            windows: 1.0,
            pool: None,
        };
        let each = |of| Seen { valve: valve(of), days: 1.0, moves: [None; 4] };
        days.iter().enumerate().map(each).collect()
    }

    fn found(days: &[(f64, Option<f64>)]) -> Vec<(Change, f64)> {
        let events = events(&seen(days), &[]);
        events.iter().map(|event| (event.change, event.time / DAY)).collect()
    }

    fn by_p(days: &[f64]) -> Vec<(Change, f64)> {
        found(&days.iter().map(|p| (*p, None)).collect::<Vec<_>>())
    }

    fn by_s(days: &[f64]) -> Vec<(Change, f64)> {
        found(&days.iter().map(|s| (0.95, Some(*s))).collect::<Vec<_>>())
    }

    #[test]
    fn onsets_repairs_and_relapses_are_found_with_the_second_day() {
        let days = [0.1, 0.2, 0.97, 0.95, 0.98, 0.96, 0.1, 0.2, 0.1, 0.1, 0.93, 0.97];
        let expected = [(Change::New, 2.0), (Change::Gone, 6.0), (Change::Returned, 10.0)];
        assert_eq!(by_p(&days), expected);
        assert_eq!(by_p(&days[..3]), [], "one day is none");
        assert_eq!(by_p(&days[..4]), expected[..1]);
        // After a repair that is known it has stuck before.
        let all = seen(&days[..4].iter().map(|p| (*p, None)).collect::<Vec<_>>());
        assert_eq!(events(&all, &[0.0])[0].change, Change::Returned);
    }

    #[test]
    fn the_interval_of_a_change_is_wider_where_days_lie_between() {
        let interval = |days: &[f64]| {
            let all = seen(&days.iter().map(|p| (*p, None)).collect::<Vec<_>>());
            events(&all, &[]).last().map(|event| event.interval)
        };
        assert_eq!(interval(&[0.1, 0.1, 0.1, 0.97, 0.97, 0.97]), Some((3.0 * DAY, 3.0 * DAY)));
        let (from, to) = interval(&[0.1, 0.1, 0.1, 0.66, 0.97, 0.97, 0.97]).unwrap();
        assert_eq!((from, to), (3.0 * DAY, 4.0 * DAY));
    }

    #[test]
    fn one_window_of_several_days_is_enough_on_one_side() {
        let mut all = seen(&[0.95, 0.97, 0.93, 0.96, 0.1].map(|p| (p, None)));
        assert!(events(&all, &[]).is_empty());
        all[4].days = 3.0;
        assert_eq!(events(&all, &[])[0].change, Change::Gone);
    }

    #[test]
    fn what_is_less_sure_needs_a_loop_that_moves_differently() {
        let days = [0.1, 0.55, 0.1, 0.5, 0.8, 0.85];
        let mut all = seen(&days.map(|p| (p, None)));
        let count = |all: &[Seen]| events(all, &[]).len();
        assert_eq!(count(&all), 0);
        for (day, each) in all.iter_mut().enumerate() {
            each.moves[2] = Some(if day < 4 { 3.0 } else { 4.0 });
        }
        assert_eq!(count(&all), 1);
        all[5].moves[2] = Some(3.0);
        assert_eq!(count(&all), 0, "not one day up and the other down");
    }

    #[test]
    fn scatter_is_no_change() {
        assert_eq!(by_p(&[0.6, 0.95, 0.3, 0.9, 0.2, 0.97, 0.8, 0.2, 0.3, 0.9]), []);
        assert_eq!(by_p(&[0.1, 0.2, 0.1, 0.1, 0.9, 0.1, 0.2, 0.95, 0.1, 0.1]), []);
        assert_eq!(by_s(&[4.0, 4.3, 3.9, 4.1, 4.4, 4.5, 3.8, 3.7, 4.2]), []);
        // Three decimals of an export moved the probability by up to 0.017.
        let rounded: Vec<f64> = (0..30).map(|k| 0.49 + 0.017 * f64::from(k % 2)).collect();
        assert_eq!(by_p(&rounded), []);
    }

    #[test]
    fn steps_of_s_are_worse_or_better() {
        assert_eq!(by_s(&[4.0, 4.1, 3.9, 5.9, 6.0, 6.1]), [(Change::Worse, 3.0)]);
        assert_eq!(by_s(&[4.0, 4.1, 3.9, 2.0, 2.1, 2.0]), [(Change::Better, 3.0)]);
        assert_eq!(by_s(&[4.0, 4.1, 3.9, 9.0, 4.0, 4.1]), []);
    }
}
