//! Dates and times along an axis, from seconds since 1970-01-01 on the displayed clock.

use super::axis::Tick;
use jiff::Timestamp;

const MINUTE: i64 = 60;
const HOUR: i64 = 60 * MINUTE;
const DAY: i64 = 24 * HOUR;

/// Usual distances between ticks, s.
const STEPS: [i64; 19] = [
    1,
    2,
    5,
    10,
    15,
    30,
    MINUTE,
    2 * MINUTE,
    5 * MINUTE,
    10 * MINUTE,
    15 * MINUTE,
    30 * MINUTE,
    HOUR,
    2 * HOUR,
    3 * HOUR,
    6 * HOUR,
    12 * HOUR,
    DAY,
    2 * DAY,
];

/// Seconds whose years have four digits.
const CALENDAR: std::ops::RangeInclusive<f64> = -6e10..=2.5e11;

/// Ticks between `lo` and `hi`, about `count` at most, and the date of the first. `None` if they are
/// too close for whole seconds, or beyond the calendar.
pub(super) fn ticks(lo: f64, hi: f64, count: usize) -> Option<(Vec<Tick>, String)> {
    if hi - lo < 3.0 || !CALENDAR.contains(&lo) || !CALENDAR.contains(&hi) {
        return None;
    }
    let wanted = (hi - lo) / count.max(1) as f64;
    let days = (wanted / DAY as f64).ceil() as i64 * DAY;
    let mut step = STEPS.into_iter().find(|s| *s as f64 >= wanted).unwrap_or(days);
    let places = |step: i64| {
        let (first, last) = ((lo / step as f64).ceil() as i64, (hi / step as f64).floor() as i64);
        (first..=last).map(move |i| i * step)
    };
    while places(step).count() < 2 {
        step = STEPS.into_iter().rev().find(|s| *s < step)?;
    }
    let tick = |at: i64| Tick { at: at as f64, label: label(at, step) };
    let first = places(step).next()?;
    Some((places(step).map(tick).collect(), date(first)))
}

/// The label of a tick: the time, or at midnight the day.
fn label(at: i64, step: i64) -> String {
    match (at.rem_euclid(DAY), step) {
        (0, _) => written(at, "%-d %b"),
        (_, ..MINUTE) => written(at, "%H:%M:%S"),
        _ => written(at, "%H:%M"),
    }
}

/// The date in ISO 8601.
fn date(at: i64) -> String {
    written(at, "%Y-%m-%d")
}

/// Date and time to the second in ISO 8601 with a blank between, and the name of the clock if it has one; `None` beyond
/// the calendar. `seconds` count on this clock.
pub fn instant(seconds: f64, clock: &str) -> Option<String> {
    let text = CALENDAR
        .contains(&seconds)
        .then(|| written(seconds.round() as i64, "%Y-%m-%d %H:%M:%S"))?;
    Some(format!("{text} {clock}").trim_end().to_owned())
}

/// An instant of the [`CALENDAR`] in UTC, in a format of `strftime`.
fn written(at: i64, format: &str) -> String {
    Timestamp::from_second(at).map_or_else(|_| String::new(), |at| at.strftime(format).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_those_of_the_calendar() {
        for (seconds, want) in [
            (0, "1970-01-01"),
            (951_782_400, "2000-02-29"),
            (1_709_164_800, "2024-02-29"),
            (1_735_689_599, "2024-12-31"),
            (-1, "1969-12-31"),
        ] {
            assert_eq!(date(seconds), want);
        }
    }

    #[test]
    fn ticks_are_at_round_times() {
        let start = 1_735_689_600.0 - 5_400.0;
        let (ticks, date) = ticks(start, start + 10_800.0, 6).unwrap();
        let labels: Vec<&str> = ticks.iter().map(|t| t.label.as_str()).collect();
        assert_eq!(labels, ["22:30", "23:00", "23:30", "1 Jan", "00:30", "01:00", "01:30"]);
        assert_eq!(date, "2024-12-31");
        // The margin before midnight is not the day of the data.
        let midnight = 1_735_689_600.0;
        let (_, date) = super::ticks(midnight - 600.0, midnight + 86_400.0, 9).unwrap();
        assert_eq!(date, "2025-01-01");
    }

    #[test]
    fn any_range_of_the_calendar_has_two_ticks() {
        for span in [3.0, 10.0, 61.0, 3_000.0, 86_400.0, 2e5, 1e7, 1e9] {
            for lo in [0.0, 1.7e9 + 0.3, -1e9] {
                let count = ticks(lo, lo + span, 6).unwrap().0.len();
                assert!((2..=9).contains(&count), "{lo} {span}: {count}");
            }
        }
    }
}
