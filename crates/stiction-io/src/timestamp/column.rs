//! A whole column of times.

use super::clock::Clock;
use super::context::{Context, PLAUSIBLE, Times};
use super::format::{DateOrder, TimeFormat, is_plain_name, unit_of};
use super::plausible;
use super::rounded;
use super::scan::{Stamp, scan};
use super::time_of_day;
use super::zone::Zone;
use crate::cells::number;
use crate::error::Result;
use crate::remedy::Remedy;
use crate::sheet::{Cells, Column};
use crate::texts::View;
use jiff::civil::DateTime;
use jiff::fmt::strtime::BrokenDownTime;
use jiff::tz::{AmbiguousOffset, Offset};

/// Seconds from 1970 to the end of year 9999, and back.
const CALENDAR: f64 = 2.5e11;

const NANOS: f64 = 1e9;

/// Reads the times of `column`.
///
/// # Errors
/// If a cell is empty or not a time, if the order of day and month is ambiguous, if a local time does not exist in
/// the zone, or if no recording can have such times.
pub fn read(column: &Column, context: &Context<'_>) -> Result<Times> {
    let mut times = unchecked(column, context)?;
    plausible::check(&times, column, context)?;
    rounded::restore(&mut times, column, context);
    Ok(times)
}

/// The times of `column`, even if no recording can have them.
pub fn unchecked(column: &Column, context: &Context<'_>) -> Result<Times> {
    match &column.cells {
        Cells::Times { seconds, utc } => {
            check_present(column, seconds, context)?;
            let nanos = context.nanos(column, seconds, 1.0)?;
            let format = "times of the file";
            if *utc {
                Ok(context.since_start(nanos, format, Clock::Utc))
            } else if context.zone.is_none() && plausible::are_of_recordings(seconds) {
                Ok(context.local(nanos, format))
            } else {
                let civil = context.civil(column, &nanos)?;
                context.resolve(column, &civil, format.to_owned())
            }
        }
        Cells::Numbers(numbers) => {
            check_present(column, numbers, context)?;
            context.numbers(column, numbers)
        }
        Cells::Text(cells) => context.text(column, &cells.view()),
    }
}

fn check_present(column: &Column, numbers: &[f64], context: &Context<'_>) -> Result<()> {
    match numbers.iter().position(|number| !number.is_finite()) {
        None => Ok(()),
        Some(i) => {
            let message =
                format!("is not a time; every row needs a time{}", plausible::sample_time(context));
            Err(context.wrong(column, i, message))
        }
    }
}

/// A local time, or one with an offset.
pub(super) type Written = (DateTime, Option<Offset>);

fn as_utc(local: DateTime) -> i128 {
    Offset::UTC.to_timestamp(local).map_or(0, |timestamp| timestamp.as_nanosecond())
}

/// The order of the dates and all times of a column whose first row decides the order and whose other rows fit. Most
/// columns are like this, and then no stamps need to be kept.
fn plain(cells: &View<'_>) -> Option<(DateOrder, Vec<Written>)> {
    let first = scan(cells.first()?)?;
    let mut orders = first.orders();
    let (Some(order), None) = (orders.next(), orders.next()) else { return None };
    let mut date = first.date;
    let written = |cell: &str| {
        let stamp = scan(cell).filter(|stamp| !stamp.is_abbreviated)?;
        if stamp.date != date && stamp.orders().all(|possible| possible != order) {
            return None;
        }
        date = stamp.date;
        Some((stamp.civil(order)?, stamp.offset))
    };
    Some((order, cells.iter().map(written).collect::<Option<_>>()?))
}

impl Context<'_> {
    /// Times on a clock whose zero is the earliest of them.
    fn since_start(&self, nanos: Vec<i128>, format: &str, clock: Clock) -> Times {
        let start = nanos.iter().copied().min().unwrap_or(0);
        Times {
            start: Some(start as f64 / NANOS),
            seconds: nanos.iter().map(|t| (t - start) as f64 / NANOS).collect(),
            format: format.to_owned(),
            clock,
            notes: vec![],
        }
    }

    /// Numbers in units of this many seconds, as nanoseconds. Whole units are converted separately, so that an epoch
    /// keeps its digits.
    fn nanos(&self, column: &Column, numbers: &[f64], unit: f64) -> Result<Vec<i128>> {
        let per_unit = (unit * NANOS).round();
        let nanos = |(i, number): (usize, &f64)| {
            if !((number * unit).abs() <= CALENDAR) {
                let message = format!("{number} is a time beyond the calendar; correct it");
                return Err(self.wrong(column, i, message));
            }
            let whole = number.floor();
            Ok(whole as i128 * per_unit as i128 + ((number - whole) * per_unit).round() as i128)
        };
        numbers.iter().enumerate().map(nanos).collect()
    }

    /// Local times given since 1970.
    fn civil(&self, column: &Column, nanos: &[i128]) -> Result<Vec<Written>> {
        let civil = |(i, nanos): (usize, &i128)| {
            jiff::Timestamp::from_nanosecond(*nanos)
                .map(|timestamp| (Offset::UTC.to_datetime(timestamp), None))
                .map_err(|e| self.wrong(column, i, e.to_string()))
        };
        nanos.iter().enumerate().map(civil).collect()
    }

    /// Local times since 1970 of an unknown zone.
    fn local(&self, nanos: Vec<i128>, format: &str) -> Times {
        let jump = self.jump(&nanos);
        let mut times = self.since_start(nanos, format, Clock::Local);
        times.notes.push(format!(
            "the times have no zone and are interpreted as UTC; if this is wrong, give {}",
            self.wording.of(Remedy::Zone(None))
        ));
        times.notes.extend(jump);
        times
    }

    fn text(&self, column: &Column, cells: &View<'_>) -> Result<Times> {
        if let Some(i) = cells.iter().position(str::is_empty) {
            // Beside other times, the row is rather a total than a sample.
            let is_rare = 2 * cells.iter().filter(|cell| cell.is_empty()).count() < cells.len();
            let other = if is_rare { String::new() } else { plausible::sample_time(self) };
            let message =
                format!("is empty; every row needs a time; give one or remove the row{other}");
            return Err(self.wrong(column, i, message));
        }
        match self.format {
            Some(TimeFormat::Pattern(pattern)) => return self.by_pattern(column, cells, pattern),
            Some(TimeFormat::Date(order)) => {
                let stamps = self.stamps(column, cells)?;
                return self.dates(column, cells, &stamps, *order);
            }
            _ => {}
        }
        let first = cells.first().unwrap_or("");
        let is_stamp = scan(first).is_some();
        if self.format.is_none() && !is_stamp && time_of_day::scan(first).is_some() {
            return self.times_of_day(column, cells);
        }
        let numeric = number::parse(first, self.mark).is_some() && !is_stamp;
        if numeric || self.format.is_some() {
            let number = |(i, cell): (usize, &str)| {
                number::parse(cell, self.mark).ok_or_else(|| {
                    let message = format!(
                        "\"{}\" is not a number, as this time format requires; correct it{}",
                        number::shown(cell),
                        plausible::sample_time(self)
                    );
                    self.wrong(column, i, message)
                })
            };
            let numbers = cells.iter().enumerate().map(number).collect::<Result<Vec<_>>>()?;
            return self.numbers(column, &numbers);
        }
        if let Some((order, written)) = plain(cells) {
            return self.resolve(column, &written, TimeFormat::Date(order).describe());
        }
        let stamps = self.stamps(column, cells)?;
        let order = self.order(column, cells, &stamps)?;
        self.dates(column, cells, &stamps, order)
    }

    fn by_pattern(&self, column: &Column, cells: &View<'_>, pattern: &str) -> Result<Times> {
        let wrong = |i: usize, e: jiff::Error| {
            let cell = number::shown(&cells[i]);
            let given = self.wording.of(Remedy::TimeFormat(vec![pattern.to_owned()]));
            let message = format!(
                "\"{cell}\" is not a time in the format {given}: {e}; correct the cell or the format{}",
                plausible::sample_time(self)
            );
            self.wrong(column, i, message)
        };
        let parts = |(i, cell): (usize, &str)| {
            BrokenDownTime::parse(pattern, cell).map_err(|e| wrong(i, e))
        };
        let parts = cells.iter().enumerate().map(parts).collect::<Result<Vec<_>>>()?;
        let has_no_day = |parts: &BrokenDownTime| {
            parts.to_date().is_err() && (parts.hour().is_some() || parts.minute().is_some())
        };
        if parts.first().is_some_and(has_no_day) {
            let seconds = |parts: &BrokenDownTime| {
                let fraction = f64::from(parts.subsec_nanosecond().unwrap_or(0)) / NANOS;
                let of = |part: Option<i8>| f64::from(part.unwrap_or(0));
                // Only the time of day knows of a.m. and p.m.
                let hour = parts.to_time().map_or(parts.hour(), |time| Some(time.hour()));
                of(hour) * 3600.0 + of(parts.minute()) * 60.0 + of(parts.second()) + fraction
            };
            let turn = if parts[0].hour().is_some() { 86_400.0 } else { 3600.0 };
            return self.of_day(column, parts.iter().map(seconds).collect(), Some(turn), pattern);
        }
        let written = |(i, parts): (usize, &BrokenDownTime)| {
            let local = match parts.hour() {
                Some(_) => parts.to_datetime(),
                None => parts.to_date().map(|day| day.to_datetime(jiff::civil::Time::midnight())),
            };
            Ok((local.map_err(|e| wrong(i, e))?, parts.offset()))
        };
        let written = parts.iter().enumerate().map(written).collect::<Result<Vec<_>>>()?;
        self.resolve(column, &written, pattern.to_owned())
    }

    fn stamps(&self, column: &Column, cells: &View<'_>) -> Result<Vec<Stamp>> {
        let stamp = |(i, cell): (usize, &str)| {
            scan(cell).ok_or_else(|| {
                let cell = number::shown(cell);
                let other = match i {
                    0 => format!(
                        "give its format as a pattern with {}",
                        self.wording.of(Remedy::TimeFormat(vec![]))
                    ),
                    _ => "correct it, or remove the row".to_owned(),
                };
                let message = format!(
                    "\"{cell}\" is not understood as a time; {other}{}",
                    plausible::sample_time(self)
                );
                self.wrong(column, i, message)
            })
        };
        cells.iter().enumerate().map(stamp).collect()
    }

    /// The only order of year, month and day in which every date exists.
    fn order(&self, column: &Column, cells: &View<'_>, stamps: &[Stamp]) -> Result<DateOrder> {
        let mut orders: Vec<DateOrder> = stamps.first().map_or(vec![], |s| s.orders().collect());
        for (i, stamp) in stamps.iter().enumerate() {
            // Most dates equal those of the row above.
            if i == 0 || stamp.date != stamps[i - 1].date {
                let possible: Vec<_> = stamp.orders().collect();
                orders.retain(|order| possible.contains(order));
            }
            if orders.is_empty() {
                let rows = plausible::sample_time(self);
                let message = if stamp.orders().next().is_none() {
                    format!("\"{}\" is not a day of the calendar; correct it{rows}", &cells[i])
                } else {
                    format!(
                        "\"{}\" has a different order of day and month from the rows above; write all dates \
                         alike{rows}",
                        &cells[i]
                    )
                };
                return Err(self.wrong(column, i, message));
            }
        }
        match orders[..] {
            [order] => Ok(order),
            _ => Err(self.wrong_column(
                column,
                format!(
                    "dates such as \"{}\" can be {}, and no row decides; give {}",
                    cells.first().unwrap_or(""),
                    orders.iter().map(|o| o.name()).collect::<Vec<_>>().join(" or "),
                    self.wording.of(Remedy::TimeFormat(
                        orders.iter().map(|order| order.name().replace(' ', "-")).collect()
                    ))
                ),
            )),
        }
    }

    fn dates(
        &self,
        column: &Column,
        cells: &View<'_>,
        stamps: &[Stamp],
        order: DateOrder,
    ) -> Result<Times> {
        let written = |(i, stamp): (usize, &Stamp)| {
            let local = stamp.civil(order).ok_or_else(|| {
                let message = format!(
                    "\"{}\" is not a day when read as {}; leave {} out{}",
                    &cells[i],
                    order.name(),
                    self.wording.of(Remedy::TimeFormat(vec![])),
                    plausible::sample_time(self)
                );
                self.wrong(column, i, message)
            })?;
            Ok((local, stamp.offset))
        };
        let abbreviated = stamps.iter().position(|stamp| stamp.is_abbreviated);
        if let Some(i) = abbreviated.filter(|_| self.zone.is_none()) {
            let message = format!(
                "\"{}\" ends with the abbreviation of a zone, which is not unique; give the zone, as in {}",
                &cells[i],
                self.wording.of(Remedy::Zone(Some("Europe/Berlin".to_owned())))
            );
            return Err(self.wrong(column, i, message));
        }
        let written = stamps.iter().enumerate().map(written).collect::<Result<Vec<_>>>()?;
        let mut times = self.resolve(column, &written, TimeFormat::Date(order).describe())?;
        if abbreviated.is_some() {
            let note =
                "the abbreviations of zones are not read; the times are those of the given zone";
            times.notes.push(note.to_owned());
        }
        Ok(times)
    }

    /// Times that are numbers, interpreted by magnitude as an epoch, as spreadsheet days, or as plain seconds.
    fn numbers(&self, column: &Column, numbers: &[f64]) -> Result<Times> {
        let guessed = self.format.is_none();
        let format = match self.format {
            Some(TimeFormat::Pattern(_) | TimeFormat::Date(_)) => {
                let numbers = ["seconds", "epoch-s", "epoch-ms", "excel", "datenum"];
                let message = format!(
                    "holds numbers, not dates; leave {} out, or give a format of numbers, as in {}",
                    self.wording.of(Remedy::TimeFormat(vec![])),
                    self.wording.of(Remedy::TimeFormat(numbers.map(str::to_owned).to_vec()))
                );
                return Err(self.wrong_column(column, message));
            }
            Some(format) => format.clone(),
            None => {
                let format = guess(column, numbers);
                plausible::question(&format, numbers, column, self)?;
                format
            }
        };
        let unit = format.unit();
        let mut times = match format.zero() {
            Some(zero) if format.is_local() => {
                // Days have too many digits to resolve a few microseconds.
                let seconds = |day: &f64| ((day + zero / unit) * unit * 1e3).round() / 1e3;
                let seconds: Vec<f64> = numbers.iter().map(seconds).collect();
                let civil = self.civil(column, &self.nanos(column, &seconds, 1.0)?)?;
                self.resolve(column, &civil, format.describe())?
            }
            Some(zero) => {
                let mut nanos = self.nanos(column, numbers, unit)?;
                let zero = (zero * NANOS) as i128;
                nanos.iter_mut().for_each(|at| *at += zero);
                self.since_start(nanos, &format.describe(), Clock::Utc)
            }
            None => Times {
                start: None,
                seconds: numbers.iter().map(|n| n * unit).collect(),
                format: format.describe(),
                clock: Clock::Elapsed,
                notes: vec![],
            },
        };
        let plain = times.clock == Clock::Elapsed && format == TimeFormat::Elapsed(1.0);
        if guessed && !(plain && is_seconds(&column.name)) {
            times.notes.push(self.taken(&format, times.start, column, numbers));
        }
        Ok(times)
    }

    /// The interpretation of `numbers`, and possible alternatives.
    fn taken(
        &self,
        format: &TimeFormat,
        start: Option<f64>,
        column: &Column,
        numbers: &[f64],
    ) -> String {
        let from = start.map_or(String::new(), |at| format!(", from {} on", plausible::date(at)));
        let others = plausible::of_the_same_size(format, numbers);
        let such = match others[..] {
            [] => String::new(),
            _ => format!(", such as {}", others.join(" or ")),
        };
        format!(
            "the numbers in \"{}\" are interpreted as {}{from}; if they are not, give {}{such}",
            column.name,
            format.describe(),
            self.wording.of(Remedy::TimeFormat(vec![]))
        )
    }

    /// Converts written times to a clock that runs evenly.
    pub(super) fn resolve(
        &self,
        column: &Column,
        written: &[Written],
        format: String,
    ) -> Result<Times> {
        let is_of_recording = |(local, _): &Written| plausible::YEARS.contains(&local.year());
        if let Some(i) = written.iter().position(|each| !is_of_recording(each)) {
            return Err(plausible::beyond(column, i, &format, self));
        }
        let has_offset = written.first().is_some_and(|(_, offset)| offset.is_some());
        let mixed = written.iter().position(|(_, offset)| offset.is_some() != has_offset);
        let in_zone: Vec<Written>;
        let written = match (mixed, self.zone) {
            (None, _) => written,
            (Some(i), None) => {
                let (this, others) = if has_offset { ("no", "an") } else { ("an", "no") };
                let message = format!(
                    "has {this} offset from UTC, but the rows above have {others} offset; give the zone of times \
                     without an offset, as in {}, or write all times alike",
                    self.wording.of(Remedy::Zone(Some("Europe/Berlin".to_owned())))
                );
                return Err(self.wrong(column, i, message));
            }
            (Some(_), Some(zone)) => {
                let local = |(local, offset): &Written| {
                    let at = offset.and_then(|offset| offset.to_timestamp(*local).ok());
                    (at.map_or(*local, |at| zone.zone.to_datetime(at)), None)
                };
                in_zone = written.iter().map(local).collect();
                &in_zone
            }
        };
        if has_offset && mixed.is_none() {
            let nanos = written.iter().map(|(local, offset)| {
                as_utc(*local) - i128::from(offset.map_or(0, Offset::seconds)) * 1_000_000_000
            });
            let mut times = self.since_start(nanos.collect(), &format, Clock::Utc);
            if let Some(zone) = self.zone {
                times.notes.push(format!(
                    "the times have offsets of their own; the zone {} is not used",
                    zone.name()
                ));
            }
            return Ok(times);
        }
        let Some(zone) = self.zone else {
            let nanos = written.iter().map(|(local, _)| as_utc(*local)).collect();
            return Ok(self.local(nanos, &format));
        };
        let (nanos, notes) = self.zoned(column, written, zone)?;
        let mut times = self.since_start(nanos, &format, Clock::Zone(zone.name().to_owned()));
        times.notes = notes;
        Ok(times)
    }

    /// The rows of each series in order of time, reversed if most steps go back.
    fn in_order(&self, local: impl Fn(usize) -> i128) -> Vec<Vec<usize>> {
        let mut rows = self.rows_of_series();
        for rows in &mut rows {
            let falling = rows.windows(2).filter(|pair| local(pair[1]) < local(pair[0])).count();
            if falling * 2 > rows.len() {
                rows.reverse();
            }
        }
        rows
    }

    /// Local times in a zone. The hour that occurs twice in autumn is resolved by the order of the rows. It is the
    /// first occurrence until the clock goes back, then the second.
    fn zoned(
        &self,
        column: &Column,
        written: &[Written],
        zone: &Zone,
    ) -> Result<(Vec<i128>, Vec<String>)> {
        let local: Vec<i128> = written.iter().map(|(local, _)| as_utc(*local)).collect();
        let mut nanos = vec![0; written.len()];
        let (mut passes, mut first) = ([0, 0], None);
        for rows in self.in_order(|row| local[row]) {
            let (mut second_pass, mut previous) = (false, None);
            for row in rows {
                let offset = match zone.zone.to_ambiguous_timestamp(written[row].0).offset() {
                    AmbiguousOffset::Unambiguous { offset } => {
                        second_pass = false;
                        offset
                    }
                    AmbiguousOffset::Fold { before, after } => {
                        second_pass |= previous.is_some_and(|previous| local[row] < previous);
                        passes[usize::from(second_pass)] += 1;
                        first.get_or_insert(row);
                        if second_pass { after } else { before }
                    }
                    AmbiguousOffset::Gap { before, .. } => {
                        let message = format!(
                            "{} does not exist in {}, because clocks were put forward; if this clock was not put \
                             forward, give its offset, as in {}",
                            written[row].0,
                            zone.name(),
                            self.wording.of(Remedy::Zone(Some(before.to_string())))
                        );
                        return Err(self.wrong(column, row, message));
                    }
                };
                nanos[row] = local[row] - i128::from(offset.seconds()) * 1_000_000_000;
                previous = Some(local[row]);
            }
        }
        let note = first.map(|row| {
            format!(
                "from row {} on, {} has an hour twice in autumn; by the order of the rows, {} rows count as its first \
                 pass and {} as its second",
                self.sheet.row(row),
                zone.name(),
                passes[0],
                passes[1]
            )
        });
        Ok((nanos, note.into_iter().collect()))
    }

    /// A note if the clock jumps by exactly an hour in addition to its step, as with daylight saving.
    fn jump(&self, local: &[i128]) -> Option<String> {
        const HOUR: i128 = 3600 * 1_000_000_000;
        for rows in self.in_order(|row| local[row]) {
            let steps: Vec<i128> = rows.windows(2).map(|w| local[w[1]] - local[w[0]]).collect();
            let mut sorted = steps.clone();
            sorted.sort_unstable();
            let Some(&common) = sorted.get(sorted.len() / 2) else { continue };
            let jumps = |step: &i128| 0 < common && common < HOUR && (step - common).abs() == HOUR;
            if let Some(i) = steps.iter().position(jumps) {
                let back = if steps[i] < common { "back" } else { "forward" };
                return Some(format!(
                    "in row {} the clock jumps {back} by exactly an hour, which looks like daylight \
                     saving; give {}, as in {}",
                    self.sheet.row(rows[i + 1]),
                    self.wording.of(Remedy::Zone(None)),
                    self.wording.of(Remedy::Zone(Some("Europe/Berlin".to_owned())))
                ));
            }
        }
        None
    }
}

/// Whether a column of this name holds plain seconds.
fn is_seconds(name: &str) -> bool {
    is_plain_name(name) || unit_in(name) == Some(1.0)
}

/// The unit at the end of a column's name, such as `time_ms` or `t [min]`.
fn unit_in(name: &str) -> Option<f64> {
    let word = name.trim_end_matches([']', ')']).rsplit([' ', '_', '[', '(', '.', '/']).next()?;
    unit_of(&word.to_lowercase())
}

/// The unit that a column gives, s.
pub(super) fn unit_of_column(column: &Column) -> Option<f64> {
    let told = column.unit.as_deref().map(str::to_lowercase);
    told.and_then(|unit| unit_of(&unit)).or_else(|| unit_in(&column.name))
}

/// The kind of numbers, by the name and unit of their column and by their magnitude.
fn guess(column: &Column, numbers: &[f64]) -> TimeFormat {
    let is_dated = |format: &TimeFormat| plausible::all_within(&PLAUSIBLE, format, numbers);
    if let Some(unit) = unit_of_column(column) {
        let epoch = TimeFormat::Epoch(unit);
        return if is_dated(&epoch) { epoch } else { TimeFormat::Elapsed(unit) };
    }
    let epochs = [1.0, 1e-3, 1e-6, 1e-9].map(TimeFormat::Epoch);
    let has_parts_of_days = numbers.iter().any(|n| n.fract() != 0.0);
    let days = [TimeFormat::Spreadsheet, TimeFormat::Datenum]
        .into_iter()
        .filter(|_| has_parts_of_days && !column.name.eq_ignore_ascii_case("t"));
    let mut likely = epochs.into_iter().chain(days);
    likely.find(is_dated).unwrap_or(TimeFormat::Elapsed(1.0))
}
