//! Weeks of ISO 8601, from Monday to Sunday, such as `2026-W10`.

use crate::day;
use jiff::civil::{Date, ISOWeekDate, Weekday};
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A week of the plant's calendar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Week {
    /// Monday, days since 1970-01-01.
    monday: i64,
}

impl Week {
    /// The week of a day, days since 1970-01-01.
    pub fn of(day: i64) -> Self {
        // 1970-01-01 was a Thursday.
        Self { monday: day - (day + 3).rem_euclid(7) }
    }

    /// Days, from Monday to Sunday, since 1970-01-01.
    pub fn days(self) -> RangeInclusive<i64> {
        self.monday..=self.monday + 6
    }
}

impl fmt::Display for Week {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let monday: Result<Date, _> = day::date(self.monday).parse();
        // A day beyond the calendar has neither week nor samples.
        let week = monday.map(|date| date.iso_week_date()).unwrap_or_default();
        write!(to, "{:04}-W{:02}", week.year(), week.week())
    }
}

impl FromStr for Week {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("\"{text}\" is not a week; write it like 2026-W10");
        let (year, week) = text.trim().split_once("-W").ok_or_else(wrong)?;
        let (year, week) = (year.parse().map_err(|_| wrong())?, week.parse().map_err(|_| wrong())?);
        let monday = ISOWeekDate::new(year, week, Weekday::Monday).map_err(|_| wrong())?;
        Ok(Self { monday: day::parse(&monday.date().to_string())? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weeks_are_those_of_iso_8601() {
        for (text, first, last) in [
            ("2026-W10", "2026-03-02", "2026-03-08"),
            ("2026-W01", "2025-12-29", "2026-01-04"),
            ("2020-W53", "2020-12-28", "2021-01-03"),
            ("1969-W52", "1969-12-22", "1969-12-28"),
        ] {
            let week: Week = text.parse().unwrap();
            assert_eq!(day::date(*week.days().start()), first);
            assert_eq!(day::date(*week.days().end()), last);
            assert_eq!(week.to_string(), text);
            assert!(week.days().all(|day| Week::of(day) == week));
        }
        for text in ["2026-10", "2026-W54", "2021-W53", "W10", "2026-W1x"] {
            assert!(text.parse::<Week>().is_err(), "{text}");
        }
    }
}
