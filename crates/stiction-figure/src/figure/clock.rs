//! Dates and times along an axis: seconds since 1970-01-01 UTC.

use super::axis::Tick;

const MINUTE: i64 = 60;
const HOUR: i64 = 60 * MINUTE;
const DAY: i64 = 24 * HOUR;

/// Distances between ticks that people count in, s.
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

const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

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
    Some((places(step).map(tick).collect(), date(lo.floor() as i64)))
}

/// What is written at a tick: the time, or at midnight the day.
fn label(at: i64, step: i64) -> String {
    let second = at.rem_euclid(DAY);
    let (h, m, s) = (second / HOUR, second % HOUR / MINUTE, second % MINUTE);
    if second == 0 {
        let (_, month, day) = civil(at.div_euclid(DAY));
        format!("{day} {}", MONTHS[month as usize - 1])
    } else if step < MINUTE {
        format!("{h:02}:{m:02}:{s:02}")
    } else {
        format!("{h:02}:{m:02}")
    }
}

/// The date as ISO 8601 writes it.
fn date(at: i64) -> String {
    let (year, month, day) = civil(at.div_euclid(DAY));
    format!("{year:04}-{month:02}-{day:02}")
}

/// Date and time to the second as ISO 8601 writes them but for a blank between, with the time zone;
/// `None` beyond the calendar.
pub fn instant(seconds: f64) -> Option<String> {
    let at = seconds.round() as i64;
    let second = at.rem_euclid(DAY);
    let (h, m, s) = (second / HOUR, second % HOUR / MINUTE, second % MINUTE);
    CALENDAR.contains(&seconds).then(|| format!("{} {h:02}:{m:02}:{s:02} UTC", date(at)))
}

/// Year, month and day of a day counted from 1970-01-01 (proleptic Gregorian; Hinnant's algorithm,
/// recalled: eras of 400 years that begin in March).
fn civil(day: i64) -> (i64, i64, i64) {
    let day = day + 719_468;
    let era = day.div_euclid(146_097);
    let of_era = day.rem_euclid(146_097);
    let year = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let march = (5 * of_year + 2) / 153;
    let month = if march < 10 { march + 3 } else { march - 9 };
    let day = of_year - (153 * march + 2) / 5 + 1;
    (era * 400 + year + i64::from(month <= 2), month, day)
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
