//! The times of a sheet's rows, from a column or a sample time.

use crate::cells::number::DecimalMark;
use crate::columns::layout::{Place, Plan};
use crate::columns::options::ReadOptions;
use crate::error::{Error, Result};
use crate::names::list;
use crate::remedy::{Remedy, Wording};
use crate::sheet::{Cells, Column, Sheet};
use crate::timestamp::{self, Clock, Times, Told};
use std::sync::Arc;

/// Reads the times of all rows of `sheet`, or computes them from its sample time.
///
/// # Errors
/// If they are unknown.
pub fn times(
    sheet: &Sheet,
    plan: &Plan,
    options: &ReadOptions,
    mark: DecimalMark,
) -> Result<Times> {
    let wrong = |message: String| Error::Table { origin: sheet.origin.clone(), message };
    let check_told = |seconds: f64, told: Told| {
        timestamp::check_told(seconds, told, &sheet.origin, options.wording)
    };
    let by_rows = matches!(plan.place, Place::Rows { .. });
    if let Some(sample_time) = options.sample_time {
        if by_rows {
            let message = "has one row per sample, so a sample time cannot replace its times";
            return Err(wrong(message.to_owned()));
        }
        check_told(sample_time, Told::ByUser)?;
        let mut times = evenly(sheet.len(), sample_time);
        if let Some(column) = plan.time {
            let name = &sheet.columns[column].name;
            times.notes.push(format!("\"{name}\" is not used, because a sample time is given"));
        }
        return Ok(times);
    }
    let Some(time) = plan.time else {
        return match sheet.sample_time {
            Some(sample_time) if sample_time > 0.0 && sample_time.is_finite() && !by_rows => {
                check_told(sample_time, Told::ByFile)?;
                Ok(evenly(sheet.len(), sample_time))
            }
            _ => Err(wrong(format!(
                "has no column of times; its columns are {}; name the column, as in {}, or give the time between \
                 rows, as in {}",
                list(&sheet.columns.iter().map(|c| &*c.name).collect::<Vec<_>>()),
                options.wording.of(Remedy::map_some("time")),
                options.wording.of(Remedy::SampleTime(1.0))
            ))),
        };
    };
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
        series: &series,
        is_long: by_rows,
        wording: options.wording,
    };
    let column = &sheet.columns[time];
    let Some(date) = plan.date else { return timestamp::read(column, &context) };
    let is_full = match &column.cells {
        Cells::Text(cells) => cells.first().is_some_and(|cell| timestamp::looks_like(cell)),
        _ => true,
    };
    if !is_full {
        return timestamp::read(&joined(sheet, date, column, options.wording)?, &context);
    }
    let mut times = timestamp::read(column, &context)?;
    times.notes.push(format!(
        "\"{}\" is not used, because \"{}\" includes the day",
        sheet.columns[date].name, column.name
    ));
    Ok(times)
}

/// A column of days and one of times of day, combined.
fn joined(sheet: &Sheet, date: usize, time: &Column, wording: Wording) -> Result<Column> {
    let date = &sheet.columns[date];
    let (Cells::Text(dates), Cells::Text(times)) = (&date.cells, &time.cells) else {
        return Err(Error::Table {
            origin: sheet.origin.clone(),
            message: format!(
                "\"{}\" and \"{}\" are both times; choose one, as in {}",
                date.name,
                time.name,
                wording.of(Remedy::map("ignore", &date.name))
            ),
        });
    };
    let join = |(date, time): (&Arc<str>, &Arc<str>)| match (date.is_empty(), time.is_empty()) {
        (false, false) => format!("{date} {time}").into(),
        _ => "".into(),
    };
    Ok(Column {
        name: format!("{} {}", date.name, time.name),
        unit: None,
        cells: Cells::Text(dates.iter().zip(times).map(join).collect()),
    })
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
