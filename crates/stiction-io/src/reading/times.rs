//! The times of a sheet's rows, from a column or a sample time.

use crate::cells::number::{self, DecimalMark};
use crate::columns::layout::{Place, Plan};
use crate::columns::options::ReadOptions;
use crate::columns::role::{self, Role};
use crate::error::{Error, Result};
use crate::names::list;
use crate::remedy::{Remedy, Wording};
use crate::sheet::{Cells, Column, Sheet, Viewed};
use crate::texts::Texts;
use crate::timestamp::{self, Clock, StatedBy, Times};
use jiff::ToSpan;
use jiff::civil::Date;
use jiff::tz::Offset;
use std::borrow::Cow;

/// The share by which a given sample time may differ from the times of the file without a note.
const CONTRADICTS: f64 = 0.05;

/// Reads the times of all rows of `sheet`, or computes them from its sample time.
///
/// # Errors
/// If the times are unknown.
pub fn times(
    sheet: &Sheet,
    plan: &Plan,
    options: &ReadOptions,
    mark: DecimalMark,
) -> Result<Times> {
    let wrong = |message: String| Error::Table { origin: sheet.origin.clone(), message };
    let check_sample_time = |seconds: f64, told: StatedBy| {
        timestamp::check_sample_time(seconds, told, &sheet.origin, options.wording)
    };
    let by_rows = matches!(plan.place, Place::Rows { .. });
    let mut series = vec![0; sheet.len()];
    if let Place::Rows { tags, .. } = &plan.place {
        for (place, tag) in tags.iter().enumerate() {
            for row in &tag.rows {
                series[*row] = place;
            }
        }
    }
    let context = timestamp::Context {
        sheet,
        mark,
        format: options.time_format.as_ref(),
        zone: options.zone.as_ref(),
        date: options.date,
        series: &series,
        is_long: by_rows,
        wording: options.wording,
    };
    let column = plan.time.map(|time| &sheet.columns[time]);
    let joined = plan.date.zip(column).and_then(|(date, time)| joined(sheet, date, time));
    if let Some(sample_time) = options.sample_time {
        if by_rows {
            let message = "has one row per sample, so a sample time cannot replace its times";
            return Err(wrong(message.to_owned()));
        }
        check_sample_time(sample_time, StatedBy::User)?;
        let mut times = evenly(sheet.len(), sample_time);
        if let Some(column) = column {
            let own = timestamp::unchecked(joined.as_ref().unwrap_or(column), &context).ok();
            // A clock that begins again has no mean step.
            let own = own
                .filter(|own| own.seconds.is_sorted() || own.seconds.is_sorted_by(|a, b| a >= b));
            let own = own.and_then(|own| timestamp::mean_step_of_all(&own.seconds));
            let other = own.filter(|own| (sample_time / own - 1.0).abs() > CONTRADICTS).map(|own| {
                let remedy = options.wording.of(Remedy::SampleTime(own));
                format!("; its times are {own} s apart on average, so if they are right, give {remedy}")
            });
            times.notes.push(format!(
                "\"{}\" is not used, because a sample time is given{}",
                column.name,
                other.unwrap_or_default()
            ));
        }
        return Ok(times);
    }
    let Some(column) = column else {
        return match sheet.sample_time {
            Some(sample_time) if sample_time > 0.0 && sample_time.is_finite() && !by_rows => {
                check_sample_time(sample_time, StatedBy::File)?;
                Ok(evenly(sheet.len(), sample_time))
            }
            _ => Err(wrong(no_times(sheet, by_rows, options.wording))),
        };
    };
    if let Some(joined) = joined {
        return timestamp::read(&joined, &context);
    }
    let mut times = timestamp::read(column, &context)?;
    let Some(date) = plan.date else { return Ok(times) };
    times.notes.push(format!(
        "\"{}\" is not used, because \"{}\" is the time without it",
        sheet.columns[date].name, column.name
    ));
    Ok(times)
}

/// The message that nothing in a sheet is its time.
fn no_times(sheet: &Sheet, by_rows: bool, wording: Wording) -> String {
    let left_out = sheet.left_out.iter().find(|each| role::of_rows(&each.name) == Some(Role::Time));
    let why = left_out.map_or(String::new(), |each| format!(" (\"{}\" {})", each.name, each.why));
    let known = list(&sheet.columns.iter().map(|c| &*c.name).collect::<Vec<_>>());
    let name = wording.of(Remedy::map_some("time"));
    let sample_time = match by_rows {
        true => String::new(),
        false => format!(
            ", or give the time between rows, as in {}",
            wording.of(Remedy::SampleTime(1.0))
        ),
    };
    format!(
        "has no column of times{why}; its columns are {known}; name the column, as in {name}{sample_time}"
    )
}

/// A column of days and one of times of day, combined. `None` if the second column is complete without the first.
fn joined(sheet: &Sheet, date: usize, time: &Column) -> Option<Column> {
    let date = &sheet.columns[date];
    let (days, times) = (date.cells.view(), time.cells.view());
    let cells = (0..sheet.len()).map(|row| {
        let (day, time) = (day(&days, row)?, time_of_day(&times, row)?);
        let is_empty = day.is_empty() || time.is_empty();
        Some(Cow::Owned(if is_empty { String::new() } else { format!("{day} {time}") }))
    });
    Some(Column {
        name: format!("{} {}", date.name, time.name),
        unit: None,
        cells: Cells::Text(cells.collect::<Option<Texts>>()?),
    })
}

/// The day in a cell, without a time of day at its end.
fn day<'v>(cells: &'v Viewed<'_>, row: usize) -> Option<Cow<'v, str>> {
    let of_number = |number: f64| {
        let day = match number {
            20_000.0..80_000.0 => {
                Date::new(1899, 12, 30).ok()?.checked_add((number as i64).days()).ok()?
            }
            19_700_101.0..21_000_101.0 => {
                let [year, month, day] =
                    [number as i32 / 10_000, number as i32 / 100 % 100, number as i32 % 100];
                Date::new(year as i16, month as i8, day as i8).ok()?
            }
            _ => return None,
        };
        Some(Cow::Owned(day.to_string()))
    };
    match cells {
        Viewed::Text(cells) => {
            let cell = cells[row].trim();
            let is_midnight = |(_, time): &(&str, &str)| {
                timestamp::time_of_day(time).and_then(|time| time.of_day()) == Some(0.0)
            };
            let parts = cell.split_once(' ').or_else(|| cell.split_once('T'));
            let day = parts.filter(is_midnight).map_or(cell, |(day, _)| day);
            number::parse(day, DecimalMark::Point).and_then(of_number).or(Some(Cow::Borrowed(day)))
        }
        Viewed::Numbers(numbers) => of_number(numbers[row]),
        Viewed::Times(seconds) => {
            let at = jiff::Timestamp::from_second(seconds[row].floor() as i64).ok()?;
            Some(Cow::Owned(Offset::UTC.to_datetime(at).date().to_string()))
        }
    }
}

/// The time of day in a cell: as text, as a part of a day, or behind the day zero of a spreadsheet. `None` if it
/// includes a day of its own.
fn time_of_day<'v>(cells: &'v Viewed<'_>, row: usize) -> Option<Cow<'v, str>> {
    let of_seconds = |seconds: f64| {
        let millis = (seconds * 1e3).round() as u64;
        let (minutes, rest) = (millis / 60_000, millis % 60_000);
        let (hours, minutes) = (minutes / 60, minutes % 60);
        Some(Cow::Owned(format!("{hours:02}:{minutes:02}:{:02}.{:03}", rest / 1000, rest % 1000)))
    };
    let of_number =
        |number: f64| (0.0..1.0).contains(&number).then(|| of_seconds(number * 86_400.0))?;
    match cells {
        Viewed::Text(cells) => {
            let cell = cells[row].trim();
            if cell.contains([':', 'h']) || cell.is_empty() {
                let zero_days = [
                    "1899-12-30",
                    "1899-12-31",
                    "1900-01-00",
                    "1900-01-01",
                    "1904-01-01",
                    "1970-01-01",
                ];
                let (day, time) = cell.split_once([' ', 'T']).unwrap_or(("", cell));
                let time = if zero_days.contains(&day) { time } else { cell };
                return (!timestamp::looks_like(time)).then_some(Cow::Borrowed(time));
            }
            match number::parse(cell, DecimalMark::Point) {
                Some(number) if cell.contains('.') => of_number(number),
                // As in 060000.
                Some(_) if cell.len() == 6 || cell.len() == 4 => Some(Cow::Borrowed(cell)),
                Some(number) => of_number(number),
                None => (!timestamp::looks_like(cell)).then_some(Cow::Borrowed(cell)),
            }
        }
        Viewed::Numbers(numbers) => of_number(numbers[row]),
        Viewed::Times(seconds) => {
            let is_zero_day = seconds[row] < -2.0e9 || (0.0..86_400.0).contains(&seconds[row]);
            is_zero_day.then(|| of_seconds(seconds[row].rem_euclid(86_400.0)))?
        }
    }
}

/// Times at a fixed distance.
fn evenly(rows: usize, sample_time: f64) -> Times {
    Times {
        start: None,
        seconds: (0..rows).map(|k| k as f64 * sample_time).collect(),
        format: format!("every {sample_time} s"),
        clock: Clock::Elapsed,
        notes: vec![],
    }
}
