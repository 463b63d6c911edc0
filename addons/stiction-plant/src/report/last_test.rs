//! The last test of a valve in its windows, and how long it counts.
//!
//! A test counts in the week in which it ends and in the four weeks after, but not beyond a repair, which changes the valve. An
//! inconclusive test does not replace a decisive one. The conclusion of a person has precedence over the test, and the test over the
//! verdict on operation.

use crate::day;
use crate::store::window::WindowRow;
use stiction_diagnose::diagnose::VerdictClass;
use stiction_diagnose::spoken::rough;
use stiction_io::timestamp::Zone;

/// How long a test counts after its week began, days.
const COUNTS: i64 = 28;

/// The last test of a valve that counts in a week.
#[derive(Debug, Clone, PartialEq)]
pub struct LastTest<'a> {
    /// Result.
    pub class: VerdictClass,
    /// The day on which it ended, such as `2026-03-04`.
    pub day: String,
    /// Window.
    pub window: &'a WindowRow,
}

impl<'a> LastTest<'a> {
    /// From windows in order of time, for a week that begins on the day `first`, after the last repair.
    pub fn of(
        windows: &[&'a WindowRow],
        first: i64,
        repaired: Option<i64>,
        zone: &Zone,
    ) -> Option<Self> {
        let counts = |day: i64| day >= first - COUNTS && repaired.is_none_or(|r| day > r);
        let all = windows.iter().rev().filter_map(|window| {
            let class = VerdictClass::by_name(window.test.as_deref()?).ok()?;
            let day = day::of(window.test_to? as f64, zone);
            counts(day).then(|| Self { class, day: day::date(day), window })
        });
        // A decisive test has precedence over later inconclusive ones.
        let all: Vec<Self> = all.collect();
        let settled = all.iter().find(|test| test.class != VerdictClass::CannotTell);
        settled.or(all.first()).cloned()
    }
}

/// S by a test: `S 3.2 % (3 to 3.5)`, `S below 0.6 %`; empty without S.
pub fn s_in_words(
    s: Option<f64>,
    low: Option<f64>,
    high: Option<f64>,
    below: Option<f64>,
) -> String {
    let s = size_in_words("S", s, low, high);
    s.or(below.map(|limit| format!("S below {} %", rough(limit)))).unwrap_or_default()
}

/// S or J with its interval: `S 3.2 % (3 to 3.5)`.
pub fn size_in_words(
    name: &str,
    value: Option<f64>,
    low: Option<f64>,
    high: Option<f64>,
) -> Option<String> {
    let range = low.zip(high).map(|(low, high)| format!(" ({} to {})", rough(low), rough(high)));
    Some(format!("{name} {} %{}", rough(value?), range.unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant_file::Plant;

    #[test]
    fn a_test_counts_four_weeks_and_not_beyond_a_repair() {
        let row = |day: i64, test: &str| WindowRow {
            test: Some(test.to_owned()),
            test_to: Some(86_400 * day + 3600),
            test_s_below: Some(0.6),
            ..WindowRow::default()
        };
        let (old, new) = (row(100, "sticks"), row(105, "does not stick"));
        let all = [&old, &new];
        fn last<'a>(of: &[&'a WindowRow], first: i64, after: Option<i64>) -> Option<LastTest<'a>> {
            LastTest::of(
                of,
                first,
                after,
                &Plant::parse("name = \"N\"", "plant.toml").unwrap().zone,
            )
        }
        let found = last(&all, 105, None).unwrap();
        assert_eq!((found.class, &*found.day), (VerdictClass::DoesNotStick, "1970-04-16"));
        assert!(last(&all, 133, None).is_some() && last(&all, 134, None).is_none());
        assert!(last(&all, 105, Some(104)).is_some() && last(&all, 105, Some(105)).is_none());
        let unsettled = row(106, "cannot tell");
        let found = last(&[&old, &new, &unsettled], 105, None).unwrap();
        assert_eq!(found.class, VerdictClass::DoesNotStick);
        assert_eq!(last(&[&unsettled], 105, None).unwrap().class, VerdictClass::CannotTell);
        assert_eq!(last(&all[..1], 105, None).unwrap().class, VerdictClass::Sticks);
        assert_eq!(s_in_words(None, None, None, Some(0.6)), "S below 0.6 %");
        assert_eq!(s_in_words(Some(3.2), Some(3.0), Some(3.5), None), "S 3.2 % (3 to 3.5)");
    }
}
