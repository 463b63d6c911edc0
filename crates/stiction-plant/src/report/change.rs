//! What changed about a valve, and on which day.
//!
//! # Rule
//! Windows are taken one after the other. The last two are held against those before them, of four weeks at most and
//! since the last change, three at least. With log-odds `l` of the probability that the valve sticks, none beyond those
//! of 99 %,
//!
//! ```text
//! d = mean(l of the two) - mean(l before)
//! z = d/(s sqrt(1/2 + 1/n)),   s = max(standard deviation of l before, 1)
//! ```
//!
//! there is a change if both windows lie on one side of the mean before by [`EACH`] at least, the means lie on two sides of 50 %, `|d|` is at
//! least [`FARTHEST`], and either `|z|` is at least [`DECISIVE`], or at least [`NOTABLE`] and the loop moves otherwise, too.
//! Up is *new*, or *returned* if it had stuck before; down is *gone*. What shakes by itself has a large `s`, and must go
//! farther.
//!
//! A loop moves otherwise if the logarithm of its amplitude, its period, or the travel or turns of its output lies, in both
//! windows, on one side of the mean before by at least [`OTHERWISE`] of its standard deviations, which are held to be
//! [`STEADIEST`] at least. A valve that was repaired moves its loop otherwise; a verdict that merely shakes does not.
//!
//! Else, a valve is *worse* if the whole intervals of S of the last two windows that have one lie above the typical upper end
//! before, and by more than [`GROWTH`] above the typical S; *better* the other way round. So what merely shook within its
//! interval, or was rounded by an export, is no change.
//!
//! One window is not enough: a day that is unlike all others comes and goes. So a change is told with the second day of
//! data after it.
//!
//! # Limits
//! The constants were chosen on demo plants, see `docs/plant.md`. A valve that sticks too little to be likely on most days
//! changes unseen.

use crate::log::{Entry, Kind};
use crate::store::table::{named_cell, written_by_name};
use crate::store::window::WindowRow;
use stiction_diagnose::diagnose::{Estimate, Observation};
use stiction_diagnose::series::{mean, median};

/// How many standard errors a change goes that needs no other sign.
pub const DECISIVE: f64 = 3.5;
/// How many it goes at least.
pub const NOTABLE: f64 = 1.75;
/// How far log-odds go at least: odds of 4.5 to 1.
pub const FARTHEST: f64 = 1.5;
/// How far log-odds of each of the two windows go at least.
pub const EACH: f64 = 0.75;
/// How many standard deviations off what a loop does is another way.
pub const OTHERWISE: f64 = 1.5;
/// The least that the ways of a loop are held to scatter, as a share.
pub const STEADIEST: f64 = 0.05;
/// By what share S grows or shrinks at least.
pub const GROWTH: f64 = 0.25;
/// Windows after a change that tell it.
const AFTER: usize = 2;
/// Windows before it, at least.
const BEFORE: usize = 3;
/// How long before, s.
const MEMORY: f64 = 28.0 * 86_400.0;
/// The surest a window may be, as a probability.
const SUREST: f64 = 0.99;
/// The least that log-odds of windows are held to scatter.
const SCATTER: f64 = 1.0;

/// What changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Change {
    /// It sticks, and did not before.
    New,
    /// It sticks again.
    Returned,
    /// It sticks more.
    Worse,
    /// It sticks less.
    Better,
    /// It stuck, and is not seen to any more.
    Gone,
    /// Nothing.
    #[default]
    None,
}

named_cell!(Change);
written_by_name!(Change);

impl Change {
    /// All of them, the worst first.
    pub const ALL: [Self; 6] =
        [Self::New, Self::Returned, Self::Worse, Self::Better, Self::Gone, Self::None];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::New => "new",
            Self::Returned => "returned",
            Self::Worse => "worse",
            Self::Better => "better",
            Self::Gone => "gone",
            Self::None => "none",
        }
    }
}

/// A change of a valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// What changed.
    pub change: Change,
    /// When: the time of the first window after it, s.
    pub time: f64,
    /// The time of the window that told it.
    pub told: f64,
}

/// What a window says of a valve, and how its loop moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// What it says of the valve.
    pub valve: Observation,
    /// Logarithms of amplitude, period, travel and turns, where there are any.
    ways: [Option<f64>; 4],
}

impl Seen {
    /// What a row says; `None` if nothing was judged.
    pub fn of(row: &WindowRow) -> Option<Self> {
        let ways = [row.amplitude, row.period_s, row.travel_per_hour, row.reversals_per_hour];
        let ways = ways.map(|way| way.filter(|value| *value > 0.0).map(f64::ln));
        Some(Self { valve: row.observation()?, ways })
    }
}

/// All changes of a valve, from its windows in order of time and what people say of it; `begin` tells when a day begins.
pub fn events(windows: &[Seen], said: &[&Entry], begin: impl Fn(i64) -> f64) -> Vec<Event> {
    let repairs: Vec<f64> =
        said.iter().filter(|entry| entry.kind == Kind::Repair).map(|e| begin(e.day)).collect();
    let mut events: Vec<Event> = vec![];
    let mut since = 0;
    for end in AFTER..=windows.len() {
        let start = end - AFTER;
        let after = &windows[start..end];
        let time = after[0].valve.time;
        let before: Vec<&Seen> = windows[since.min(start)..start]
            .iter()
            .filter(|each| time - each.valve.time <= MEMORY)
            .collect();
        let change = match moved(&before, after) {
            Some(true) => {
                let had_stuck = events.iter().any(|event| event.change == Change::Gone)
                    || repairs.iter().any(|repair| *repair <= time);
                Some(if had_stuck { Change::Returned } else { Change::New })
            }
            Some(false) => Some(Change::Gone),
            None => grown(&before, after),
        };
        if let Some(change) = change {
            events.push(Event { change, time, told: after[AFTER - 1].valve.time });
            since = start;
        }
    }
    events
}

fn log_odds(probability: f64) -> f64 {
    let p = probability.clamp(1.0 - SUREST, SUREST);
    (p / (1.0 - p)).ln()
}

/// Whether it began to stick (true) or ceased to (false).
fn moved(before: &[&Seen], after: &[Seen]) -> Option<bool> {
    let odds = |seen: &Seen| seen.valve.probability.map(log_odds);
    let old: Vec<f64> = before.iter().filter_map(|seen| odds(seen)).collect();
    let new: Vec<f64> = after.iter().filter_map(odds).collect();
    if old.len() < BEFORE || new.len() < AFTER {
        return None;
    }
    let (from, to) = (mean(&old), mean(&new));
    let error: f64 =
        scatter(&old).max(SCATTER) * (1.0 / new.len() as f64 + 1.0 / old.len() as f64).sqrt();
    let up = to > from;
    // Both, or one day that is unlike all others would do.
    let same_side = new.iter().all(|l| (*l > from) == up && (l - from).abs() >= EACH);
    let crosses = if up { from <= 0.0 && to >= 0.0 } else { from >= 0.0 && to <= 0.0 };
    let far = (to - from).abs();
    let sure = far >= DECISIVE * error
        || (far >= NOTABLE * error && (0..4).any(|way| moves_otherwise(before, after, way)));
    (same_side && crosses && far >= FARTHEST && sure).then_some(up)
}

/// Whether the loop moves otherwise than before, in one way.
fn moves_otherwise(before: &[&Seen], after: &[Seen], way: usize) -> bool {
    let old: Vec<f64> = before.iter().filter_map(|seen| seen.ways[way]).collect();
    let new: Vec<f64> = after.iter().filter_map(|seen| seen.ways[way]).collect();
    if old.len() < BEFORE || new.len() < AFTER {
        return false;
    }
    let from = mean(&old);
    let far = OTHERWISE * scatter(&old).max(STEADIEST);
    new.iter().all(|value| *value >= from + far) || new.iter().all(|value| *value <= from - far)
}

/// The standard deviation of two values or more.
fn scatter(of: &[f64]) -> f64 {
    let middle = mean(of);
    let squares: f64 = of.iter().map(|value| (value - middle).powi(2)).sum();
    (squares / (of.len() - 1) as f64).sqrt()
}

/// Whether it sticks more or less, by S.
fn grown(before: &[&Seen], after: &[Seen]) -> Option<Change> {
    let old: Vec<Estimate> = before.iter().filter_map(|seen| seen.valve.s).collect();
    let new: Vec<Estimate> = after.iter().filter_map(|seen| seen.valve.s).collect();
    if old.len() < BEFORE || new.len() < AFTER {
        return None;
    }
    let typical = |of: fn(&Estimate) -> f64| median(&old.iter().map(of).collect::<Vec<_>>());
    let (low, value, high) = (typical(|s| s.low), typical(|s| s.value), typical(|s| s.high));
    let above = |s: &Estimate| s.low > high && s.value > (1.0 + GROWTH) * value;
    let below = |s: &Estimate| s.high < low && (1.0 + GROWTH) * s.value < value;
    match () {
        () if new.iter().all(above) => Some(Change::Worse),
        () if new.iter().all(below) => Some(Change::Better),
        () => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_diagnose::diagnose::VerdictClass;

    const DAY: f64 = 86_400.0;

    fn seen(days: &[(f64, Option<f64>)]) -> Vec<Seen> {
        let valve = |(day, (p, s)): (usize, &(f64, Option<f64>))| Observation {
            time: day as f64 * DAY,
            class: VerdictClass::CannotTell,
            probability: Some(*p),
            s: s.map(|value| Estimate { value, low: 0.9 * value, high: 1.1 * value }),
            j: None,
            weight: 1.0,
            windows: 1.0,
        };
        let each = |of| Seen { valve: valve(of), ways: [None; 4] };
        days.iter().enumerate().map(each).collect()
    }

    fn found(days: &[(f64, Option<f64>)]) -> Vec<(Change, f64)> {
        let events = events(&seen(days), &[], |day| day as f64 * DAY);
        events.iter().map(|event| (event.change, event.time / DAY)).collect()
    }

    fn by_p(days: &[f64]) -> Vec<(Change, f64)> {
        found(&days.iter().map(|p| (*p, None)).collect::<Vec<_>>())
    }

    fn by_s(days: &[f64]) -> Vec<(Change, f64)> {
        found(&days.iter().map(|s| (0.95, Some(*s))).collect::<Vec<_>>())
    }

    #[test]
    fn onsets_repairs_and_relapses_are_told_with_the_second_day() {
        let days = [0.1, 0.2, 0.1, 0.1, 0.97, 0.95, 0.98, 0.96, 0.1, 0.2, 0.1, 0.1, 0.9, 0.97];
        let expected = [(Change::New, 4.0), (Change::Gone, 8.0), (Change::Returned, 12.0)];
        assert_eq!(by_p(&days), expected);
        assert_eq!(by_p(&days[..5]), [], "one day is none");
        assert_eq!(by_p(&days[..6]), expected[..1]);
        // After a repair that is known it has stuck before.
        let repair = Entry {
            kind: Kind::Repair,
            name: String::new(),
            day: 0,
            by: None,
            until: None,
            verdict: None,
            text: String::new(),
        };
        let all = seen(&days[..6].iter().map(|p| (*p, None)).collect::<Vec<_>>());
        assert_eq!(events(&all, &[&repair], |day| day as f64)[0].change, Change::Returned);
    }

    #[test]
    fn what_is_less_sure_needs_a_loop_that_moves_otherwise() {
        let days = [0.3, 0.6, 0.2, 0.4, 0.3, 0.6, 0.85, 0.75];
        let mut all = seen(&days.map(|p| (p, None)));
        let told = |all: &[Seen]| events(all, &[], |day| day as f64).len();
        assert_eq!(told(&all), 0);
        for (day, each) in all.iter_mut().enumerate() {
            each.ways[2] = Some(if day < 6 { 3.0 } else { 3.2 });
        }
        assert_eq!(told(&all), 1);
        all[7].ways[2] = Some(2.8);
        assert_eq!(told(&all), 0, "not one day up and the other down");
    }

    #[test]
    fn what_shakes_is_no_change() {
        assert_eq!(by_p(&[0.6, 0.95, 0.3, 0.9, 0.2, 0.97, 0.8, 0.2, 0.3, 0.9]), []);
        assert_eq!(by_p(&[0.1, 0.2, 0.1, 0.1, 0.9, 0.1, 0.2, 0.95, 0.1, 0.1]), []);
        assert_eq!(by_s(&[4.0, 4.3, 3.9, 4.1, 4.4, 4.5, 3.8, 3.7, 4.2]), []);
        // Three decimals of an export moved the probability by up to 0.017.
        let rounded: Vec<f64> = (0..30).map(|k| 0.49 + 0.017 * f64::from(k % 2)).collect();
        assert_eq!(by_p(&rounded), []);
    }

    #[test]
    fn s_beyond_its_intervals_is_worse_or_better() {
        assert_eq!(by_s(&[4.0, 4.1, 3.9, 5.9, 6.0, 6.1]), [(Change::Worse, 3.0)]);
        assert_eq!(by_s(&[4.0, 4.1, 3.9, 2.0, 2.1, 2.0]), [(Change::Better, 3.0)]);
        assert_eq!(by_s(&[4.0, 4.1, 3.9, 9.0, 4.0, 4.1]), []);
    }
}
