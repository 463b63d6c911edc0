//! Reads a cell with a date and a time of day in the usual notations.

use super::format::DateOrder;
use jiff::civil::{Date, DateTime, Time};
use jiff::tz::Offset;

/// A date and time as written. Only the whole column shows which number is the day.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stamp {
    pub date: [Part; 3],
    /// Separator of the parts of the date.
    separator: u8,
    pub time: Time,
    pub offset: Option<Offset>,
}

/// A part of a date.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    value: i32,
    digits: u8,
    is_name: bool,
}

/// Whether `cell` is a date, optionally with a time.
pub fn looks_like(cell: &str) -> bool {
    scan(cell).is_some()
}

/// Reads a cell; `None` if it is not a date and time.
pub fn scan(cell: &str) -> Option<Stamp> {
    let mut at = Cursor { rest: cell.trim().as_bytes() };
    at.weekday();
    let (date, separator, compact) = at.date()?;
    let time = if at.rest.is_empty() {
        Time::midnight()
    } else {
        if !compact || !at.rest[0].is_ascii_digit() {
            at.any(b"Tt_, :")?;
        }
        at.spaces();
        at.time()?
    };
    at.spaces();
    let offset = at.offset()?;
    at.rest.is_empty().then_some(Stamp { date, separator, time, offset })
}

impl Stamp {
    /// The possible orders of its date, which give an existing day.
    pub fn orders(&self) -> impl Iterator<Item = DateOrder> + '_ {
        use DateOrder::{DayFirst, MonthFirst, YearFirst};
        let [a, b, c] = self.date;
        let possible: &[DateOrder] = if a.digits > 2 {
            &[YearFirst]
        } else if a.is_name {
            &[MonthFirst]
        } else if b.is_name || self.separator == b'.' {
            &[DayFirst]
        } else if c.digits > 2 {
            &[DayFirst, MonthFirst]
        } else {
            &[DayFirst, MonthFirst, YearFirst]
        };
        possible.iter().copied().filter(|order| self.day(*order).is_some())
    }

    fn day(&self, order: DateOrder) -> Option<Date> {
        let [a, b, c] = self.date;
        let (year, month, day) = match order {
            DateOrder::YearFirst => (a, b, c),
            DateOrder::DayFirst => (c, b, a),
            DateOrder::MonthFirst => (c, a, b),
        };
        let century = match (year.digits, year.value) {
            (3.., _) => 0,
            (_, ..70) => 2000,
            _ => 1900,
        };
        let small = |part: Part| i8::try_from(part.value).ok();
        Date::new(i16::try_from(year.value + century).ok()?, small(month)?, small(day)?).ok()
    }

    /// The date and time, with its date in this `order`.
    pub fn civil(&self, order: DateOrder) -> Option<DateTime> {
        Some(self.day(order)?.to_datetime(self.time))
    }
}

/// The remaining characters.
struct Cursor<'c> {
    rest: &'c [u8],
}

impl Cursor<'_> {
    fn any(&mut self, set: &[u8]) -> Option<u8> {
        let (first, rest) = self.rest.split_first()?;
        set.contains(first).then(|| {
            self.rest = rest;
            *first
        })
    }

    fn spaces(&mut self) {
        while self.any(b" ").is_some() {}
    }

    /// A number with at most `most` digits.
    fn number(&mut self, most: usize) -> Option<Part> {
        let digits = self.rest.iter().take(most).take_while(|b| b.is_ascii_digit()).count();
        let (digits, rest) = self.rest.split_at(digits);
        if digits.is_empty() {
            return None;
        }
        self.rest = rest;
        let value = digits.iter().fold(0, |n, d| n * 10 + i32::from(d - b'0'));
        Some(Part { value, digits: digits.len() as u8, is_name: false })
    }

    /// The first three letters of a word, in lower case.
    fn word(&mut self) -> Option<[u8; 3]> {
        let letters = self.rest.iter().take_while(|b| b.is_ascii_alphabetic()).count();
        let (word, rest) = self.rest.split_at(letters);
        let start: [u8; 3] = word.get(..3)?.try_into().ok()?;
        self.rest = rest;
        Some(start.map(|b| b.to_ascii_lowercase()))
    }

    fn weekday(&mut self) {
        const DAYS: [&[u8; 3]; 7] = [b"mon", b"tue", b"wed", b"thu", b"fri", b"sat", b"sun"];
        let before = self.rest;
        match self.word() {
            Some(word) if DAYS.contains(&&word) => while self.any(b" ,.").is_some() {},
            _ => self.rest = before,
        }
    }

    fn month(&mut self) -> Option<Part> {
        const MONTHS: [&[u8; 3]; 12] = [
            b"jan", b"feb", b"mar", b"apr", b"may", b"jun", b"jul", b"aug", b"sep", b"oct", b"nov",
            b"dec",
        ];
        let before = self.rest;
        let index = self.word().and_then(|word| MONTHS.iter().position(|month| **month == word));
        match index {
            Some(index) => Some(Part { value: index as i32 + 1, digits: 2, is_name: true }),
            None => {
                self.rest = before;
                None
            }
        }
    }

    /// The parts of a date, their separator, and whether it is written without separators.
    fn date(&mut self) -> Option<([Part; 3], u8, bool)> {
        let run = self.rest.iter().take_while(|b| b.is_ascii_digit()).count();
        if run == 8 || run == 14 {
            let date = [self.number(4)?, self.number(2)?, self.number(2)?];
            return Some((date, b'-', true));
        }
        let part = |at: &mut Self| at.month().or_else(|| at.number(4));
        let a = part(self)?;
        let separator = self.any(b"-/. ")?;
        let b = part(self)?;
        if a.is_name {
            self.any(b",");
        }
        self.any(b"-/. ").filter(|s| *s == separator || a.is_name)?;
        let c = self.number(4)?;
        // Exactly one part may be a name, and the year must not stand between the others.
        let fits = !(a.is_name && b.is_name) && b.digits <= 2;
        fits.then_some(([a, b, c], separator, false))
    }

    fn time(&mut self) -> Option<Time> {
        let hour = self.number(2)?.value;
        let colon = self.any(b":").is_some();
        let minute = self.number(2)?.value;
        let (mut second, mut nanos) = (0, 0);
        if (colon && self.any(b":").is_some()) || (!colon && !self.rest.is_empty()) {
            second = self.number(2)?.value;
            if self.any(b".,").is_some() {
                let part = self.number(9)?;
                nanos = part.value * 10i32.pow(9 - u32::from(part.digits));
                // Finer than nanoseconds.
                while self.number(9).is_some() {}
            }
        }
        self.spaces();
        let hour = match self.half_day() {
            None => hour,
            Some(_) if !(1..=12).contains(&hour) => return None,
            Some(afternoon) => hour % 12 + if afternoon { 12 } else { 0 },
        };
        let small = |value: i32| i8::try_from(value).ok();
        Time::new(small(hour)?, small(minute)?, small(second)?, nanos).ok()
    }

    /// Whether it is p.m.; `None` without a.m. or p.m.
    fn half_day(&mut self) -> Option<bool> {
        let text = self.rest.to_ascii_lowercase();
        for (word, afternoon) in [("am", false), ("pm", true), ("a.m.", false), ("p.m.", true)] {
            if text.starts_with(word.as_bytes()) {
                self.rest = &self.rest[word.len()..];
                return Some(afternoon);
            }
        }
        None
    }

    /// The offset from UTC. The inner `None` means no offset, the outer one an unreadable offset.
    #[allow(clippy::option_option)]
    fn offset(&mut self) -> Option<Option<Offset>> {
        if self.rest.is_empty() {
            return Some(None);
        }
        for name in [&b"UTC"[..], b"GMT", b"Z", b"z"] {
            if self.rest == name {
                self.rest = &[];
                return Some(Some(Offset::UTC));
            }
        }
        let sign = if self.any(b"+-")? == b'-' { -1 } else { 1 };
        let hours = self.number(2)?.value;
        self.any(b":");
        let minutes = self.number(2).map_or(0, |part| part.value);
        let fits = hours < 24 && minutes < 60;
        Some(Some(Offset::from_seconds(sign * (hours * 60 + minutes) * 60).ok().filter(|_| fits)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use DateOrder::{DayFirst, MonthFirst, YearFirst};

    #[test]
    fn common_ways_of_writing() {
        for (cell, order, expected, offset) in [
            ("2024-12-31T23:59:58Z", YearFirst, "2024-12-31T23:59:58", Some(0)),
            ("2024-12-31 23:59:58.25", YearFirst, "2024-12-31T23:59:58.25", None),
            ("2024-12-31T23:59:58,25+01:00", YearFirst, "2024-12-31T23:59:58.25", Some(3600)),
            ("2024-12-31 23:59 -0530", YearFirst, "2024-12-31T23:59:00", Some(-19800)),
            ("2024-12-31 23:59:58 UTC", YearFirst, "2024-12-31T23:59:58", Some(0)),
            ("2024/12/31", YearFirst, "2024-12-31T00:00:00", None),
            ("20241231T235958", YearFirst, "2024-12-31T23:59:58", None),
            ("20241231235958", YearFirst, "2024-12-31T23:59:58", None),
            ("31/12/2024 23:59:58", DayFirst, "2024-12-31T23:59:58", None),
            ("31.12.2024 23:59", DayFirst, "2024-12-31T23:59:00", None),
            ("12/31/2024 11:59:58 PM", MonthFirst, "2024-12-31T23:59:58", None),
            ("12/31/2024 12:00:00 AM", MonthFirst, "2024-12-31T00:00:00", None),
            ("31-Dec-24 23:59:58", DayFirst, "2024-12-31T23:59:58", None),
            ("31-DEC-2024 23:59:58.123456789012", DayFirst, "2024-12-31T23:59:58.123456789", None),
            ("31 December 2024, 23:59", DayFirst, "2024-12-31T23:59:00", None),
            ("Tue, 31 Dec 2024 23:59:58 GMT", DayFirst, "2024-12-31T23:59:58", Some(0)),
            ("Dec 31, 2024 11:59 p.m.", MonthFirst, "2024-12-31T23:59:00", None),
            ("31/Dec/2024:23:59:58 +0100", DayFirst, "2024-12-31T23:59:58", Some(3600)),
            ("31-Dec-99 00:00:00", DayFirst, "1999-12-31T00:00:00", None),
        ] {
            let stamp = scan(cell).unwrap_or_else(|| panic!("{cell}"));
            assert_eq!(stamp.orders().collect::<Vec<_>>(), [order], "{cell}");
            assert_eq!(stamp.civil(order).unwrap().to_string(), expected, "{cell}");
            assert_eq!(stamp.offset.map(Offset::seconds), offset, "{cell}");
        }
    }

    #[test]
    fn what_may_be_several_days() {
        let orders = |cell| scan(cell).unwrap().orders().collect::<Vec<_>>();
        assert_eq!(orders("05/06/2024 00:00"), [DayFirst, MonthFirst]);
        assert_eq!(orders("05/06/07 00:00"), [DayFirst, MonthFirst, YearFirst]);
        assert_eq!(orders("05.06.07 00:00"), [DayFirst]);
        assert_eq!(orders("99/06/07"), [YearFirst]);
        assert_eq!(orders("2023-02-29"), []);
        assert_eq!(orders("31/31/2024"), []);
    }

    #[test]
    fn what_is_no_time() {
        for cell in [
            "",
            "12.5",
            "12",
            "-3",
            "auto",
            "2024",
            "2024-12",
            "1-2",
            "2024-12-31 25:00",
            "2024-12-31 23:59:58 XYZ",
            "2024-12-31 13:00 PM",
            "2024-12-31 23:59:58 +99:00",
            "31-Foo-2024",
            "12/2024/31",
            "Bad",
            "FIC101.PV",
            "2024-12-31T",
            "é",
            "2024-12-31 23:",
        ] {
            assert_eq!(scan(cell), None, "{cell}");
        }
    }
}
