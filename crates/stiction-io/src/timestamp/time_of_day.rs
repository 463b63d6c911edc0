//! Times of day without a date, and times since a start written with colons.

use super::column::Written;
use super::context::{Context, Times};
use super::scan::plain;
use super::{clock::Clock, plausible};
use crate::cells::number;
use crate::error::Result;
use crate::remedy::Remedy;
use crate::sheet::Column;
use crate::texts::View;
use jiff::SignedDuration;

const MINUTE: f64 = 60.0;
const HOUR: f64 = 3600.0;
const DAY: f64 = 86_400.0;

/// A cell such as 06:00:00.5, 6:00 PM, 06h00, 40:00.0 or 1:02:03:04.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockTime {
    /// The numbers between the colons, from the largest unit.
    fields: [f64; 4],
    count: usize,
    /// Whether it ends with a.m. or p.m., or has an h behind the hours, so that the first number is the hour.
    has_hours: bool,
    /// Whether the last number has decimals.
    has_decimals: bool,
    /// Whether it names days, as in "1 days 02:03:04".
    has_days: bool,
}

/// What the numbers of a column of such cells are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Parts {
    HoursMinutes,
    MinutesSeconds,
    HoursMinutesSeconds,
    DaysToSeconds,
}

/// Reads a cell; `None` if it is not of this kind.
pub fn scan(cell: &str) -> Option<ClockTime> {
    let cell = cell.trim();
    if cell.is_ascii() { scan_plain(cell) } else { scan_plain(plain(cell).trim()) }
}

fn scan_plain(cell: &str) -> Option<ClockTime> {
    if !cell.as_bytes().first()?.is_ascii_digit() {
        return None;
    }
    if let Some((days, rest)) = cell.split_once(" day") {
        let rest = rest.trim_start_matches(['s', ',', ' ', '+']);
        let rest = if rest.is_empty() { "0:00:00" } else { rest };
        let time = scan_plain(rest).filter(|time| time.count == 3 && !time.has_days)?;
        let [h, m, s, _] = time.fields;
        let days = days.trim().parse::<u32>().ok()?;
        return Some(ClockTime {
            fields: [f64::from(days), h, m, s],
            count: 4,
            has_days: true,
            ..time
        });
    }
    let lower = cell.to_ascii_lowercase();
    let half =
        [("am", 0.0), ("pm", 12.0), ("a.m.", 0.0), ("p.m.", 12.0), ("a. m.", 0.0), ("p. m.", 12.0)];
    let half = half
        .into_iter()
        .find_map(|(end, hours)| Some((lower.strip_suffix(end)?.trim_end(), hours)));
    let digits = half.map_or(&*lower, |(digits, _)| digits);
    let in_words = digits.contains('h');
    let spelled;
    let digits = if in_words {
        spelled = digits.replace(['h', 'm'], ":");
        spelled.trim_end_matches('s').trim_end_matches(':')
    } else {
        digits
    };
    let mut parts: Vec<&str> = digits.split(':').collect();
    let all_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let millis = parts
        .pop_if(|last| last.len() == 3 && all_digits(last) && digits.matches(':').count() == 3);
    let (last, whole) = parts.split_last()?;
    let (seconds, decimals) = last.split_once(['.', ',']).unwrap_or((last, "0"));
    let shape = whole.iter().copied().chain([seconds]).enumerate();
    if parts.len() > 4
        || !all_digits(decimals)
        || !shape
            .clone()
            .all(|(i, part)| all_digits(part) && part.len() <= if i == 0 { 6 } else { 2 })
    {
        return None;
    }
    let mut fields = [0.0; 4];
    for (i, part) in shape {
        fields[i] = part.parse().ok()?;
    }
    let count = parts.len();
    let last = &mut fields[count - 1];
    *last = format!("{last}.{decimals}").parse().ok()?;
    *last += millis.map_or(0.0, |text| text.parse().unwrap_or(0.0)) / 1e3;
    let has_decimals = decimals != "0" || millis.is_some();
    let most = if count == 4 { [1e6, 24.0, 60.0, 61.0] } else { [1e6, 60.0, 61.0, 61.0] };
    if !fields.iter().zip(most).all(|(field, most)| *field < most) {
        return None;
    }
    if let Some((_, hours)) = half {
        if !(1.0..13.0).contains(&fields[0]) {
            return None;
        }
        fields[0] = fields[0] % 12.0 + hours;
    }
    let has_hours = half.is_some() || in_words;
    (count > 1 || has_hours).then_some(ClockTime {
        fields,
        count,
        has_hours,
        has_decimals,
        has_days: false,
    })
}

impl ClockTime {
    fn seconds(&self, parts: Parts) -> f64 {
        let [a, b, c, d] = self.fields;
        match parts {
            Parts::HoursMinutes | Parts::HoursMinutesSeconds => a * HOUR + b * MINUTE + c,
            Parts::MinutesSeconds => a * MINUTE + b,
            Parts::DaysToSeconds => a * DAY + b * HOUR + c * MINUTE + d,
        }
    }

    /// Time on any clock, s: in order, but for the unit of two numbers.
    pub fn rough(&self) -> f64 {
        self.seconds(match self.count {
            4 => Parts::DaysToSeconds,
            3 => Parts::HoursMinutesSeconds,
            _ => Parts::HoursMinutes,
        })
    }

    /// The seconds since midnight, if it is a time of day with an hour.
    pub fn of_day(&self) -> Option<f64> {
        let parts = if self.count == 3 { Parts::HoursMinutesSeconds } else { Parts::HoursMinutes };
        (self.count < 4 && self.fields[0] < 24.0).then(|| self.seconds(parts))
    }
}

impl Context<'_> {
    /// The times of a column whose cells are times of day, or times since a start.
    pub fn times_of_day(&self, column: &Column, cells: &View<'_>) -> Result<Times> {
        let read = |(i, cell): (usize, &str)| {
            scan(cell).ok_or_else(|| {
                let message = format!(
                    "\"{}\" is not a time of day, but the rows above are; correct it{}",
                    number::shown(cell),
                    plausible::sample_time(self)
                );
                self.wrong(column, i, message)
            })
        };
        let times = cells.iter().enumerate().map(read).collect::<Result<Vec<_>>>()?;
        let parts = self.parts(column, cells, &times)?;
        let seconds = times.iter().map(|time| time.seconds(parts)).collect();
        let (format, turn) = match parts {
            Parts::HoursMinutes => ("time of day, hours and minutes", Some(DAY)),
            Parts::HoursMinutesSeconds => ("time of day", Some(DAY)),
            Parts::MinutesSeconds => ("minutes and seconds", Some(HOUR)),
            Parts::DaysToSeconds => ("days, hours, minutes and seconds", None),
        };
        self.of_day(column, seconds, turn, format)
    }

    /// What the numbers between the colons are.
    fn parts(&self, column: &Column, cells: &View<'_>, times: &[ClockTime]) -> Result<Parts> {
        let count = times.first().map_or(3, |time| time.count);
        if let Some(i) = times.iter().position(|time| time.count != count) {
            let message = format!(
                "\"{}\" does not have as many parts as the times above; write all times alike{}",
                number::shown(&cells[i]),
                plausible::sample_time(self)
            );
            return Err(self.wrong(column, i, message));
        }
        match count {
            4 => return Ok(Parts::DaysToSeconds),
            3 => return Ok(Parts::HoursMinutesSeconds),
            _ => {}
        }
        if times.iter().any(|time| time.has_hours) {
            return Ok(Parts::HoursMinutes);
        }
        // Hours end at 23 and have no decimals of a minute.
        if times.iter().any(|time| time.fields[0] >= 24.0 || time.has_decimals) {
            return Ok(Parts::MinutesSeconds);
        }
        let turns = |pair: &[ClockTime]| pair[0].fields[0] == 23.0 && pair[1].fields[0] == 0.0;
        if times.windows(2).any(turns) {
            return Ok(Parts::HoursMinutes);
        }
        let formats = vec!["%H:%M".to_owned(), "%M:%S".to_owned()];
        let message = format!(
            "times such as \"{}\" can be hours and minutes or minutes and seconds, and no row decides; give {}{}",
            cells.first().unwrap_or(""),
            self.wording.of(Remedy::TimeFormat(formats)),
            plausible::sample_time(self)
        );
        Err(self.wrong_column(column, message))
    }

    /// Times of day, s since midnight, on a clock that runs on over midnight. `turn` is the time after which they
    /// begin again, s. With a given day they are dates, else the first of them is time zero.
    pub fn of_day(
        &self,
        column: &Column,
        mut seconds: Vec<f64>,
        turn: Option<f64>,
        format: &str,
    ) -> Result<Times> {
        let turn = turn.filter(|turn| seconds.iter().all(|at| *at < *turn + 1.0));
        let turns = turn.map_or(0, |turn| self.run_on(&mut seconds, turn));
        let first = seconds.iter().copied().fold(f64::INFINITY, f64::min);
        let is_day = turn == Some(DAY);
        if let Some(day) = self.date.filter(|_| is_day) {
            let midnight = day.0.at(0, 0, 0, 0);
            let written = |(i, at): (usize, &f64)| {
                let nanos = SignedDuration::from_nanos((at * 1e9).round() as i64);
                let at = midnight.checked_add(nanos).ok();
                let at = at.ok_or_else(|| plausible::beyond(column, i, format, self))?;
                Ok((at, None))
            };
            let written =
                seconds.iter().enumerate().map(written).collect::<Result<Vec<Written>>>()?;
            return self.resolve(column, &written, format!("{format}, from {} on", day.0));
        }
        let mut notes = vec![];
        if let Some(turn) = turn {
            let over = match (is_day, turns) {
                (_, 0) => String::new(),
                (true, 1) => "; they pass midnight once".to_owned(),
                (true, _) => format!("; they pass midnight {turns} times"),
                (false, _) => format!("; they pass the full hour {turns} times"),
            };
            let shown = |at: f64| {
                let whole = at as u32;
                let text = format!("{:02}:{:02}", whole / 60 % 60, whole % 60);
                if turn == DAY { format!("{:02}:{text}", whole / 3600) } else { text }
            };
            let date = match is_day {
                true => format!(
                    "; for dates give {}",
                    self.wording.of(Remedy::Date(Some("2025-03-14".to_owned())))
                ),
                false => String::new(),
            };
            notes.push(format!(
                "the times in \"{}\" have no date and count from {}{over}{date}",
                column.name,
                shown(first)
            ));
            seconds.iter_mut().for_each(|at| *at -= first);
        }
        Ok(Times { start: None, seconds, format: format.to_owned(), clock: Clock::Elapsed, notes })
    }

    /// Lets times run on where they begin again, and returns how often at most.
    fn run_on(&self, seconds: &mut [f64], turn: f64) -> usize {
        let begin = seconds.first().copied().unwrap_or(0.0);
        let mut most = 0;
        for rows in self.rows_of_series() {
            let Some(first) = rows.first().map(|row| seconds[*row]) else { continue };
            let falls = rows.windows(2).filter(|pair| seconds[pair[1]] < seconds[pair[0]]).count();
            let descends = 2 * falls > rows.len();
            // A tag may begin somewhat earlier than the first, or any time later.
            let mut turns = i32::from(!descends && first < begin - 0.25 * turn);
            let mut last = first;
            for row in rows {
                let at = seconds[row];
                if last - at > 0.5 * turn {
                    turns += 1;
                } else if at - last > 0.5 * turn && (turns > 0 || descends) {
                    turns -= 1;
                }
                last = at;
                seconds[row] = at + f64::from(turns) * turn;
                most = most.max(turns.unsigned_abs() as usize);
            }
        }
        let first = seconds.iter().copied().fold(f64::INFINITY, f64::min);
        let days = (first / turn).floor();
        seconds.iter_mut().for_each(|at| *at -= days * turn);
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_ways_of_writing() {
        for (cell, seconds) in [
            ("06:00:00", 21_600.0),
            ("6:00:00 AM", 21_600.0),
            ("11:40:00 PM", 85_200.0),
            ("12:00:00 AM", 0.0),
            ("06:00:00.250", 21_600.25),
            ("06:00:00,250", 21_600.25),
            ("06:00:00:250", 21_600.25),
            ("23:40", 85_200.0),
            ("6h05", 21_900.0),
            ("06h05m07s", 21_907.0),
            ("6:00\u{202f}PM", 64_800.0),
        ] {
            assert_eq!(scan(cell).and_then(|time| time.of_day()), Some(seconds), "{cell}");
        }
        let days = scan("1 days 02:03:04.5").unwrap();
        assert_eq!(days.seconds(Parts::DaysToSeconds), 93_784.5);
        assert_eq!(scan("1:02:03:04").unwrap().seconds(Parts::DaysToSeconds), 93_784.0);
        assert_eq!(scan("40:00.5").unwrap().seconds(Parts::MinutesSeconds), 2_400.5);
        for cell in [
            "",
            "12",
            "12.5",
            "1:2:3:4:5",
            "13:00 PM",
            "a:b",
            "6:75",
            "-1:00",
            "1.5:00",
            "h",
            "6 o'clock",
        ] {
            assert_eq!(scan(cell), None, "{cell}");
        }
    }
}
