//! Reads a cell with a date and a time of day in the usual notations: all of ISO 8601 with a day, the formats of
//! spreadsheets, data bases and programs, and names of months in six languages.

use super::format::DateOrder;
use jiff::civil::{Date, DateTime, ISOWeekDate, Time, Weekday};
use jiff::tz::Offset;
use jiff::{SignedDuration, ToSpan};

/// A date and time as written. Only the whole column shows which number is the day.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stamp {
    pub date: [Part; 3],
    /// Separator of the parts of the date.
    separator: u8,
    pub time: Time,
    /// Time beyond `time`, s: of 24:00 and of a leap second.
    more: i64,
    pub offset: Option<Offset>,
    /// Whether it ends with the abbreviation of a zone, such as CET, which is not unique.
    pub is_abbreviated: bool,
}

/// A part of a date.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    value: i32,
    digits: u8,
    is_name: bool,
}

impl Part {
    fn number(value: i32, digits: u8) -> Self {
        Self { value, digits, is_name: false }
    }
}

/// Whether `cell` is a date, optionally with a time.
pub fn looks_like(cell: &str) -> bool {
    scan(cell).is_some()
}

/// Reads a cell; `None` if it is not a date and time.
pub fn scan(cell: &str) -> Option<Stamp> {
    let cell = cell.trim();
    if cell.is_ascii() {
        return scan_plain(cell);
    }
    scan_plain(plain(cell).trim())
}

/// The cell with ASCII letters, spaces and signs only.
pub fn plain(cell: &str) -> String {
    let each = |c: char| match c {
        '\u{a0}' | '\u{2009}' | '\u{202f}' | '日' => ' ',
        '\u{2010}'..='\u{2013}' | '\u{2212}' | '年' | '月' => '-',
        'ä' | 'á' | 'Ä' => 'a',
        'é' | 'è' | 'É' => 'e',
        'û' | 'Û' => 'u',
        'ç' => 'c',
        c => c,
    };
    cell.chars().map(each).collect()
}

fn scan_plain(cell: &str) -> Option<Stamp> {
    if let Some(stamp) = common(cell.as_bytes()) {
        return Some(stamp);
    }
    let begins = cell.as_bytes().first()?;
    let at = || Cursor { rest: cell.as_bytes() };
    if begins.is_ascii_digit() || matches!(begins, b'+' | b'-') {
        return at().stamp();
    }
    // A word before the date is a weekday or, first, a month: mar is March or, in French, Tuesday.
    at().stamp().or_else(|| at().without_weekday()?.stamp())
}

/// The most frequent notation, as in 2025-03-14 06:00:00 or 2025-03-14T06:00:00.250, for speed.
fn common(cell: &[u8]) -> Option<Stamp> {
    const SEPARATORS: [(usize, u8); 4] = [(4, b'-'), (7, b'-'), (13, b':'), (16, b':')];
    let is_common = matches!(cell.len(), 19 | 23)
        && SEPARATORS.iter().all(|(at, separator)| cell[*at] == *separator)
        && matches!(cell[10], b' ' | b'T')
        && cell.get(19).is_none_or(|point| *point == b'.');
    if !is_common {
        return None;
    }
    let number = |from: usize, to: usize| {
        cell[from..to].iter().try_fold(0i32, |number, digit| {
            digit.is_ascii_digit().then(|| 10 * number + i32::from(digit - b'0'))
        })
    };
    let small = |from: usize| number(from, from + 2).map(|number| number as i8);
    let nanos = if cell.len() == 23 { 1_000_000 * number(20, 23)? } else { 0 };
    Some(Stamp {
        date: [
            Part::number(number(0, 4)?, 4),
            Part::number(number(5, 7)?, 2),
            Part::number(number(8, 10)?, 2),
        ],
        separator: b'-',
        time: Time::new(small(11)?, small(14)?, small(17)?, nanos).ok()?,
        more: 0,
        offset: None,
        is_abbreviated: false,
    })
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
        let civil = self.day(order)?.to_datetime(self.time);
        if self.more == 0 {
            return Some(civil);
        }
        civil.checked_add(SignedDuration::from_secs(self.more)).ok()
    }

    /// Whether it has no time of day, or midnight.
    pub fn is_day(&self) -> bool {
        self.time == Time::midnight() && self.more == 0
    }
}

/// The remaining characters.
#[derive(Clone, Copy)]
struct Cursor<'c> {
    rest: &'c [u8],
}

/// How the parts of a date are written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Notation {
    /// Digits without separators.
    Compact,
    /// The basic format of ISO 8601 with a day of the year, which only a time distinguishes from a number.
    Ordinal,
    /// With separators.
    Separated,
}

impl Cursor<'_> {
    /// A whole cell.
    fn stamp(mut self) -> Option<Stamp> {
        if let Some(stamp) = self.year_last() {
            return Some(stamp);
        }
        let (date, separator, notation) = self.date()?;
        let (mut time, mut more) = (Time::midnight(), 0);
        if self.rest.is_empty() {
            if notation == Notation::Ordinal {
                return None;
            }
        } else {
            let mut joint = b' ';
            if notation != Notation::Compact || !self.rest[0].is_ascii_digit() {
                // DB2 joins date and time by a hyphen.
                let joints: &[u8] = if separator == b'-' { b"Tt_, :-" } else { b"Tt_, :" };
                joint = self.any(joints)?;
            }
            self.spaces();
            if self.rest.is_empty() && joint != b'T' && joint != b't' {
                // A sign of the day at its end, as in Chinese.
            } else {
                (time, more) = self.time(joint)?;
            }
        }
        let (offset, is_abbreviated) = self.zone()?;
        self.rest.is_empty().then_some(Stamp {
            date,
            separator,
            time,
            more,
            offset,
            is_abbreviated,
        })
    }

    /// As of C's `asctime` and the command `date`: Mar 14 06:00:00 CET 2025.
    fn year_last(mut self) -> Option<Stamp> {
        let month = self.month()?;
        self.spaces();
        let day = self.number(2)?;
        self.any(b" ")?;
        self.spaces();
        let (time, more) = self.time(b' ')?;
        self.spaces();
        let (mut offset, mut is_abbreviated) = (None, false);
        if !self.rest.first()?.is_ascii_digit() {
            let end = self.rest.iter().position(|b| *b == b' ')?;
            (offset, is_abbreviated) = Cursor { rest: &self.rest[..end] }.zone()?;
            self.rest = &self.rest[end..];
            self.spaces();
        }
        let year = self.number(4).filter(|year| year.digits == 4)?;
        let date = [month, day, year];
        self.rest.is_empty().then_some(Stamp {
            date,
            separator: b' ',
            time,
            more,
            offset,
            is_abbreviated,
        })
    }

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

    /// The number of digits that follow.
    fn digits(&self) -> usize {
        self.rest.iter().take_while(|b| b.is_ascii_digit()).count()
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
        Some(Part::number(value, digits.len() as u8))
    }

    /// A word of at least two letters, in lower case, and at most its first four letters.
    fn word(&mut self) -> Option<[u8; 4]> {
        let letters = self.rest.iter().take_while(|b| b.is_ascii_alphabetic()).count();
        let (word, rest) = self.rest.split_at(letters);
        if letters < 2 {
            return None;
        }
        self.rest = rest;
        let mut start = [b' '; 4];
        for (to, from) in start.iter_mut().zip(word) {
            *to = from.to_ascii_lowercase();
        }
        Some(start)
    }

    /// The cell without a weekday at its beginning.
    fn without_weekday(mut self) -> Option<Self> {
        /// In English, German, French, Spanish, Italian and Portuguese.
        const DAYS: [&str; 36] = [
            "mon", "tue", "wed", "thu", "fri", "sat", "sun", "mo ", "di ", "mi ", "do ", "fr ",
            "sa ", "so ", "lun", "mar", "mer", "jeu", "ven", "sam", "dim", "mie", "jue", "vie",
            "sab", "dom", "gio", "seg", "ter", "qua", "qui", "sex", "die", "mit", "don", "son",
        ];
        let word = self.word()?;
        DAYS.iter().any(|day| word.starts_with(day.as_bytes())).then_some(())?;
        while self.any(b" ,.").is_some() {}
        Some(self)
    }

    fn month(&mut self) -> Option<Part> {
        /// In English, German, French, Spanish, Italian and Portuguese.
        const MONTHS: [&[&str]; 12] = [
            &["jan", "ene", "gen"],
            &["feb", "fev"],
            &["mar", "mrz", "mae"],
            &["apr", "abr", "avr"],
            &["may", "mai", "mag"],
            &["jun", "juin", "giu"],
            &["jul", "juil", "lug"],
            &["aug", "ago", "aou"],
            &["sep", "set"],
            &["oct", "okt", "ott", "out"],
            &["nov"],
            &["dec", "dez", "dic"],
        ];
        let mut ahead = *self;
        let word = ahead.word()?;
        let is_it = |names: &&[&str]| names.iter().any(|name| word.starts_with(name.as_bytes()));
        let index = MONTHS.iter().position(is_it)?;
        *self = ahead;
        Some(Part { value: index as i32 + 1, digits: 2, is_name: true })
    }

    /// The parts of a date, their separator, and their notation.
    fn date(&mut self) -> Option<([Part; 3], u8, Notation)> {
        let sign = match self.any(b"+-") {
            Some(_) if self.digits() < 4 || self.rest.get(self.digits()) != Some(&b'-') => {
                return None;
            }
            Some(b'-') => -1,
            _ => 1,
        };
        let run = self.digits();
        if matches!(run, 8 | 14 | 17) || (run == 12 && self.rest.len() == run) {
            let date = [self.number(4)?, self.number(2)?, self.number(2)?];
            return Some((date, b'-', Notation::Compact));
        }
        if (4..=7).contains(&run) {
            let mut ahead = *self;
            if let Some(date) = ahead.day_of_week_or_year() {
                *self = ahead;
                let notation = if run == 7 { Notation::Ordinal } else { Notation::Separated };
                return Some((date, b'-', notation));
            }
        }
        let longest = if run == 5 || run == 6 { run } else { 4 };
        let part = |at: &mut Self| at.month().or_else(|| at.number(longest));
        let mut a = part(self)?;
        a.value *= sign;
        let separator = self.any(b"-/. ")?;
        self.joining(b". ");
        let b = part(self)?;
        let has_name = a.is_name || b.is_name;
        if has_name {
            self.any(b",.");
        }
        self.any(b"-/. ").filter(|s| *s == separator || has_name)?;
        if has_name {
            self.joining(b" ");
        }
        let c = self.number(4)?;
        // Exactly one part may be a name, and the year must not stand between the others.
        let fits = !(a.is_name && b.is_name) && b.digits <= 2;
        fits.then_some(([a, b, c], separator, Notation::Separated))
    }

    /// Skips spaces and, as in Spanish, the word "de" between the parts of a date with a name.
    fn joining(&mut self, set: &[u8]) {
        let mut ahead = *self;
        while ahead.any(set).is_some() {}
        if ahead.rest.len() > 3 && ahead.rest[..3].eq_ignore_ascii_case(b"de ") {
            ahead.rest = &ahead.rest[3..];
        }
        // Two numbers need exactly one separator.
        if !ahead.rest.first().is_some_and(u8::is_ascii_digit) || set == b" " {
            *self = ahead;
        }
    }

    /// A date of ISO 8601 by its week, as 2025-W11-5, or by its day of the year, as 2025-073.
    fn day_of_week_or_year(&mut self) -> Option<[Part; 3]> {
        let year = self.number(4).filter(|year| year.digits == 4)?.value;
        let year = i16::try_from(year).ok()?;
        let is_extended = self.any(b"-").is_some();
        let day = if self.any(b"Ww").is_some() {
            let week = self.number(2).filter(|week| week.digits == 2)?.value;
            if is_extended {
                self.any(b"-")?;
            }
            let day = Weekday::from_monday_one_offset(self.number(1)?.value as i8).ok()?;
            ISOWeekDate::new(year, week as i8, day).ok()?.date()
        } else {
            if self.digits() != 3 {
                return None;
            }
            let day = self.number(3)?.value;
            let first = Date::new(year, 1, 1).ok()?;
            let date = first.checked_add((day - 1).days()).ok()?;
            (day > 0 && date.year() == year).then_some(date)?
        };
        Some([
            Part::number(day.year().into(), 4),
            Part::number(day.month().into(), 2),
            Part::number(day.day().into(), 2),
        ])
    }

    /// A time of day behind a date and this joint, and the seconds beyond it.
    fn time(&mut self, joint: u8) -> Option<(Time, i64)> {
        let is_iso = matches!(joint, b'T' | b't');
        let hour = self.number(2)?.value;
        let (mut minute, mut second, mut unit) = (0, 0, 3600);
        let separator = match joint {
            b'-' => self.any(b".:"),
            _ => self.any(b":hH"),
        };
        match separator {
            Some(b'h' | b'H') => {
                if let Some(part) = self.number(2) {
                    (minute, unit) = (part.value, 60);
                    if self.any(b"m:").is_some()
                        && let Some(part) = self.number(2)
                    {
                        (second, unit) = (part.value, 1);
                        self.any(b"s");
                    }
                }
            }
            Some(separator) => {
                (minute, unit) = (self.number(2)?.value, 60);
                if self.any(&[separator]).is_some() {
                    (second, unit) = (self.number(2)?.value, 1);
                }
            }
            None if self.digits() >= 2 => {
                (minute, unit) = (self.number(2)?.value, 60);
                if self.digits() > 0 {
                    (second, unit) = (self.number(2)?.value, 1);
                }
            }
            None if is_iso => {}
            None => return None,
        }
        let nanos = self.fraction(unit, is_iso)?;
        self.spaces();
        let hour = match self.half_day() {
            None => hour,
            Some(_) if !(1..=12).contains(&hour) => return None,
            Some(afternoon) => hour % 12 + if afternoon { 12 } else { 0 },
        };
        let (hour, second, more) = match (hour, minute, second) {
            (24, 0, 0) if nanos == 0 => (0, 0, 86_400),
            (_, 59, 60) => (hour, 59, 1),
            _ => (hour, second, 0),
        };
        let nanos = nanos + 1_000_000_000 * (i64::from(minute) * 60 + i64::from(second));
        if !(0..60).contains(&minute) || !(0..60).contains(&second) || nanos >= 3_600_000_000_000 {
            return None;
        }
        let begin = Time::new(i8::try_from(hour).ok()?, 0, 0, 0).ok()?;
        Some((begin.checked_add(SignedDuration::from_nanos(nanos)).ok()?, more))
    }

    /// A decimal fraction of a second, or of ISO 8601's last unit of this many seconds, in ns.
    fn fraction(&mut self, unit: i64, is_iso: bool) -> Option<i64> {
        let is_millis = unit == 1 && self.rest.first() == Some(&b':');
        let is_run = unit == 1 && self.digits() == 3;
        if is_millis {
            self.any(b":");
            return (self.digits() == 3)
                .then(|| self.number(3))?
                .map(|part| i64::from(part.value) * 1_000_000);
        }
        if !is_run && self.any(b".,").is_none() {
            return Some(0);
        }
        if unit > 1 && !is_iso {
            return None;
        }
        let part = self.number(9)?;
        // Finer than nanoseconds.
        while self.number(9).is_some() {}
        let share = i128::from(part.value) * i128::from(unit) * 1_000_000_000;
        i64::try_from(share / 10i128.pow(u32::from(part.digits))).ok()
    }

    /// Whether it is p.m.; `None` without a.m. or p.m.
    fn half_day(&mut self) -> Option<bool> {
        for (word, afternoon) in [
            (&b"am"[..], false),
            (b"pm", true),
            (b"a.m.", false),
            (b"p.m.", true),
            (b"a. m.", false),
            (b"p. m.", true),
        ] {
            if self.rest.len() >= word.len() && self.rest[..word.len()].eq_ignore_ascii_case(word) {
                self.rest = &self.rest[word.len()..];
                return Some(afternoon);
            }
        }
        None
    }

    /// The offset from UTC, and whether a zone is abbreviated. `None` if it cannot be read.
    fn zone(&mut self) -> Option<(Option<Offset>, bool)> {
        self.spaces();
        let (mut offset, mut is_abbreviated) = (None, false);
        for name in [&b"UTC"[..], b"GMT", b"Z", b"z"] {
            if let Some(rest) = self.rest.strip_prefix(name) {
                (self.rest, offset) = (rest, Some(Offset::UTC));
                break;
            }
        }
        if let Some(sign) = self.any(b"+-") {
            let sign = if sign == b'-' { -1 } else { 1 };
            let hours = self.number(2)?.value;
            self.any(b":");
            let minutes = self.number(2).map_or(0, |part| part.value);
            let fits = hours < 24 && minutes < 60;
            let found = Offset::from_seconds(sign * (hours * 60 + minutes) * 60).ok();
            offset = Some(found.filter(|_| fits)?);
        }
        self.spaces();
        // The name of a zone: beside an offset it adds nothing, alone its abbreviation is not unique.
        let letters = self.rest.iter().take_while(|b| b.is_ascii_uppercase()).count();
        if (2..=5).contains(&letters) {
            is_abbreviated = offset.is_none();
            self.rest = &self.rest[letters..];
            self.spaces();
        }
        let is_named = offset.is_some() || is_abbreviated;
        if is_named
            && (self.rest.ends_with(b"]") || self.rest.ends_with(b")"))
            && self.any(b"[(").is_some()
        {
            self.rest = &[];
        }
        Some((offset, is_abbreviated))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use DateOrder::{DayFirst, MonthFirst, YearFirst};

    #[test]
    fn the_most_frequent_notation_is_read_as_all_others() {
        for cell in [
            "2025-03-14 06:00:00",
            "2025-03-14T23:59:59.250",
            "0000-99-99 00:00:00",
            "2025-03-14 24:00:00",
            "2025-03-14 23:59:60",
            "2025-03-14 06:00:0x",
            "2025-03-14 06:00:00Z",
            "2025-03-14 06:00:00,250",
        ] {
            let slow = Cursor { rest: cell.as_bytes() }.stamp();
            assert_eq!(scan(cell), slow, "{cell}");
            let fast = common(cell.as_bytes());
            assert!(fast.is_none() || fast == slow, "{cell}");
        }
        assert!(common(b"2025-03-14 06:00:00").is_some());
    }

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
            // ISO 8601.
            ("2025-W11-5T06:00:00Z", YearFirst, "2025-03-14T06:00:00", Some(0)),
            ("2025W115T060000", YearFirst, "2025-03-14T06:00:00", None),
            ("2025-W11-5", YearFirst, "2025-03-14T00:00:00", None),
            ("2025-073T06:00:00", YearFirst, "2025-03-14T06:00:00", None),
            ("2025-073", YearFirst, "2025-03-14T00:00:00", None),
            ("2025073T0600", YearFirst, "2025-03-14T06:00:00", None),
            ("2024-366T06", YearFirst, "2024-12-31T06:00:00", None),
            ("2025-03-14T06", YearFirst, "2025-03-14T06:00:00", None),
            ("2025-03-14T06Z", YearFirst, "2025-03-14T06:00:00", Some(0)),
            ("2025-03-14T06.5", YearFirst, "2025-03-14T06:30:00", None),
            ("20250314T06,25", YearFirst, "2025-03-14T06:15:00", None),
            ("2025-03-14T06:30.5", YearFirst, "2025-03-14T06:30:30", None),
            ("20250314T0630,1", YearFirst, "2025-03-14T06:30:06", None),
            ("2025-03-14T06:00:00,123", YearFirst, "2025-03-14T06:00:00.123", None),
            ("2025-03-14T24:00:00", YearFirst, "2025-03-15T00:00:00", None),
            ("2025-12-31T24:00", YearFirst, "2026-01-01T00:00:00", None),
            ("2016-12-31T23:59:60Z", YearFirst, "2017-01-01T00:00:00", Some(0)),
            ("2017-01-01T00:59:60.5+01:00", YearFirst, "2017-01-01T01:00:00.5", Some(3600)),
            ("2025-03-14T06:00:00+01", YearFirst, "2025-03-14T06:00:00", Some(3600)),
            ("2025-03-14T06:00:00+0100", YearFirst, "2025-03-14T06:00:00", Some(3600)),
            ("2025-03-14T06:00:00\u{2212}03:30", YearFirst, "2025-03-14T06:00:00", Some(-12600)),
            ("+2025-03-14T06:00:00Z", YearFirst, "2025-03-14T06:00:00", Some(0)),
            ("+002025-03-14T06:00:00Z", YearFirst, "2025-03-14T06:00:00", Some(0)),
            // Of data bases, programs and spreadsheets.
            ("2025-03-14-06.00.00.250000", YearFirst, "2025-03-14T06:00:00.25", None),
            ("14-Mar-2025 06:00:00.000", DayFirst, "2025-03-14T06:00:00", None),
            ("20250314 060000", YearFirst, "2025-03-14T06:00:00", None),
            ("202503140600", YearFirst, "2025-03-14T06:00:00", None),
            ("20250314060000250", YearFirst, "2025-03-14T06:00:00.25", None),
            ("2025-03-14 06:00:00:250", YearFirst, "2025-03-14T06:00:00.25", None),
            ("Fri Mar 14 06:00:00 2025", MonthFirst, "2025-03-14T06:00:00", None),
            ("Tue Mar  4 06:00:00 2025", MonthFirst, "2025-03-04T06:00:00", None),
            ("Fri Mar 14 06:00:00 UTC 2025", MonthFirst, "2025-03-14T06:00:00", Some(0)),
            ("Fri Mar 14 06:00:00 +0100 2025", MonthFirst, "2025-03-14T06:00:00", Some(3600)),
            (
                "Fri Mar 14 2025 06:00:00 GMT+0100 (CET)",
                MonthFirst,
                "2025-03-14T06:00:00",
                Some(3600),
            ),
            ("2025-03-14 06:00:00 +0100 CET", YearFirst, "2025-03-14T06:00:00", Some(3600)),
            ("2025-03-14T06:00+01:00[Europe/Berlin]", YearFirst, "2025-03-14T06:00:00", Some(3600)),
            ("14/03/2025 06h00", DayFirst, "2025-03-14T06:00:00", None),
            ("14/03/2025 06h05m07s", DayFirst, "2025-03-14T06:05:07", None),
            ("3/14/2025 6:00:00\u{202f}PM", MonthFirst, "2025-03-14T18:00:00", None),
            ("14/03/2025 6:00:00 p. m.", DayFirst, "2025-03-14T18:00:00", None),
            // In other languages.
            ("14-Mrz-2025 06:00", DayFirst, "2025-03-14T06:00:00", None),
            ("14. März 2025 06:00", DayFirst, "2025-03-14T06:00:00", None),
            ("Fr. 14 Dez 2025 06:00", DayFirst, "2025-12-14T06:00:00", None),
            ("14 mars 2025 06:00", DayFirst, "2025-03-14T06:00:00", None),
            ("mar. 4 mars 2025 06:00", DayFirst, "2025-03-04T06:00:00", None),
            ("14 févr. 2025 06:00", DayFirst, "2025-02-14T06:00:00", None),
            ("14 juil. 2025 06:00", DayFirst, "2025-07-14T06:00:00", None),
            ("14 juin 2025 06:00", DayFirst, "2025-06-14T06:00:00", None),
            ("14-ene-2025 06:00", DayFirst, "2025-01-14T06:00:00", None),
            ("14 de agosto de 2025 06:00", DayFirst, "2025-08-14T06:00:00", None),
            ("14-gen-2025 06:00", DayFirst, "2025-01-14T06:00:00", None),
            ("14 ott 2025 06:00", DayFirst, "2025-10-14T06:00:00", None),
            ("2025年3月14日 06:00:00", YearFirst, "2025-03-14T06:00:00", None),
        ] {
            let stamp = scan(cell).unwrap_or_else(|| panic!("{cell}"));
            assert_eq!(stamp.orders().collect::<Vec<_>>(), [order], "{cell}");
            assert_eq!(stamp.civil(order).unwrap().to_string(), expected, "{cell}");
            assert_eq!(stamp.offset.map(Offset::seconds), offset, "{cell}");
        }
    }

    #[test]
    fn abbreviated_zones_are_known_as_such() {
        for cell in
            ["2025-03-14 06:00:00 CET", "Fri Mar 14 06:00:00 CEST 2025", "14/03/2025 6:00 PM EST"]
        {
            let stamp = scan(cell).unwrap_or_else(|| panic!("{cell}"));
            assert!(stamp.is_abbreviated && stamp.offset.is_none(), "{cell}");
        }
        assert!(!scan("2025-03-14 06:00:00 UTC").unwrap().is_abbreviated);
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
            "2024-12-31 23:59:58 Xyz",
            "2024-12-31 13:00 PM",
            "2024-12-31 23:59:58 +99:00",
            "31-Foo-2024",
            "12/2024/31",
            "Bad",
            "FIC101.PV",
            "2024-12-31T",
            "é",
            "2024-12-31 23:",
            "2024-12-31 23",
            "2024-12-31 24:00:01",
            "2024-12-31 23:30:60",
            "2024-12-31 06:30.5",
            "2025073",
            "2025-W54-1",
            "2025-W11",
            "2025-366",
            "2025-000",
            "-3-1-2024",
            "out 1",
            "mode 2025",
        ] {
            assert_eq!(scan(cell), None, "{cell}");
        }
    }
}
