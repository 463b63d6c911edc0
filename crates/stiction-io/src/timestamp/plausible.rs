//! Checks whether times are plausible for a recording, and finds other interpretations of their numbers.
//!
//! Numbers misread by a factor of 86,400 would still give a diagnosis, but a wrong one. So if nobody gives the
//! meaning of the numbers, an unusual sample time leads to a question to the user.

use super::clock::Clock;
use super::column::unit_of_column;
use super::context::{Context, PLAUSIBLE, Times};
use super::format::{TimeFormat, is_plain_name, unit_name};
use super::rounded::Regular;
use crate::cells::number;
use crate::error::{Error, Result};
use crate::remedy::{Remedy, Wording};
use crate::sheet::{Cells, Column, Viewed};
use jiff::tz::Offset;
use std::ops::{Range, RangeInclusive};
use stiction_recording::{series, spoken};

/// Sample times of controllers and historians, s: 10 ms, minus rounding, to a day. Other sample times must be given.
const USUAL: RangeInclusive<f64> = 0.009_9..=86_400.0;

/// Sample times that are accepted if given, s: a microsecond to a year.
const POSSIBLE: RangeInclusive<f64> = 1e-6..=366.0 * 86_400.0;

/// Dates outside these years mean "no date", such as 9999-12-31.
pub const YEARS: RangeInclusive<i16> = 1900..=2200;
/// These years, in s since 1970.
const OF_RECORDINGS: RangeInclusive<f64> = -2_208_988_800.0..=7_289_654_400.0;

/// Whether recordings can have all of these times, s since 1970.
pub fn are_of_recordings(seconds: &[f64]) -> bool {
    seconds.iter().all(|s| OF_RECORDINGS.contains(s))
}

/// Dates accepted without a question if another interpretation also gives a date, s since 1970: 1995 to 2050.
const RECENT: Range<f64> = 788_918_400.0..2_524_608_000.0;

/// A clock with more counts than this has a different unit, s, because it would have started in the ice age.
const LONGEST: f64 = 2.5e11;

/// Share of rows that may have the time of the row before with other values. A clock with jitter has a few such rows,
/// a clock with too few digits has many.
pub const MOST_COLLAPSED: f64 = 0.1;

/// Refuses `times` that no recording can have: beyond the calendar, all the same, too close or too far apart, or with
/// too few digits to separate rows.
pub fn check(times: &Times, column: &Column, context: &Context<'_>) -> Result<()> {
    for (i, seconds) in times.seconds.iter().enumerate() {
        let is_possible = match times.start {
            Some(start) => OF_RECORDINGS.contains(&(start + seconds)),
            None => seconds.abs() <= LONGEST,
        };
        if !is_possible {
            return Err(beyond(column, i, &times.format, context));
        }
    }
    let rows = context.rows_of_series();
    let collapsed = collapsed(&rows, times, column, context);
    let remedy = between_rows(context, mean_step_of_all(&times.seconds).unwrap_or(1.0));
    let Some(step) = median(steps(&rows, &times.seconds)) else {
        let Some(rows) = rows.iter().find(|rows| rows.len() > 1) else { return Ok(()) };
        let message = format!(
            "has the same time \"{}\" as all rows before; write times that differ{remedy}",
            shown(column, rows[1])
        );
        return Err(context.wrong(column, rows[1], message));
    };
    if let [first, ..] = collapsed[..]
        && collapsed.len() as f64 > MOST_COLLAPSED * times.seconds.len() as f64
    {
        let ends = |of: &mut dyn Iterator<Item = f64>| {
            of.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)))
        };
        let (from, to) = ends(&mut collapsed.iter().map(|row| times.seconds[*row]));
        let (begin, end) = ends(&mut times.seconds.iter().copied());
        // Too few digits concern all hours.
        let is_one_hour =
            (1800.0..3600.0).contains(&(to - from)) && end - begin > 2.0 * (to - from);
        let why = match is_one_hour && times.start.is_some() && times.clock != Clock::Utc {
            true => format!(
                "all in one hour, as at the end of summer time; export the rows in the order in which they were \
                 recorded and give {}, or export times in UTC",
                context.wording.of(Remedy::Zone(Some("Europe/Berlin".to_owned())))
            ),
            false => format!("because the times have too few digits; write more digits{remedy}"),
        };
        let message = format!(
            "has the time \"{}\" of the row before but other values, like {} of {} rows, {why}",
            shown(column, first),
            collapsed.len(),
            times.seconds.len()
        );
        return Err(context.wrong(column, first, message));
    }
    if !POSSIBLE.contains(&step) {
        let message = format!(
            "steps by {}, interpreted as {}, which is not plausible; correct the times{remedy}",
            span(step),
            times.format
        );
        return Err(context.wrong_column(column, message));
    }
    Ok(())
}

/// The error for a time that, interpreted as `format`, is implausible.
pub fn beyond(column: &Column, row: usize, format: &str, context: &Context<'_>) -> Error {
    let message = format!(
        "\"{}\", interpreted as {format}, is not a time of a recording; correct it or remove the row, or give the \
         format with {}{}",
        shown(column, row),
        context.wording.of(Remedy::TimeFormat(vec![])),
        sample_time(context)
    );
    context.wrong(column, row, message)
}

/// Asks for the meaning of `numbers` that were interpreted as `format` by their magnitude. The reasons are an unusual
/// sample time, days as likely as seconds, dates of another age, or fractions of a minute, hour or day.
pub fn question(
    format: &TimeFormat,
    numbers: &[f64],
    column: &Column,
    context: &Context<'_>,
) -> Result<()> {
    let steps = steps(&context.rows_of_series(), numbers);
    let Some(step) = median(steps.clone()) else { return Ok(()) };
    let is_usual = |format: &TimeFormat| USUAL.contains(&(step * format.unit()));
    let mut readings = better_dates(format, numbers);
    if !readings.is_empty() {
        readings.push(format.clone());
        return Err(ambiguous(&readings, step, numbers, column, context));
    }
    if *format == TimeFormat::Elapsed(1.0) && is_usual(format) && unit_of_column(column).is_none() {
        readings = larger_units(numbers, &steps, step).into_iter().filter(is_usual).collect();
        if !readings.is_empty() {
            readings.insert(0, format.clone());
            return Err(ambiguous(&readings, step, numbers, column, context));
        }
    }
    let others: Vec<TimeFormat> =
        candidates(numbers).into_iter().filter(|each| each != format && is_usual(each)).collect();
    // The names t and time do not distinguish seconds from days.
    let days = [TimeFormat::Spreadsheet, TimeFormat::Datenum];
    let plain = TimeFormat::Elapsed(1.0);
    let is_doubtful = is_plain_name(&column.name)
        && (days.contains(format) && is_usual(&plain)
            || *format == plain && others.iter().any(|each| days.contains(each)));
    // A clock that would have run for more than a century counts from 1970 in another unit.
    let is_epoch = matches!(format, TimeFormat::Elapsed(_))
        && numbers.iter().all(|n| n * format.unit() > PLAUSIBLE.end)
        && others.iter().any(|each| each.zero().is_some() && !each.is_local());
    if is_usual(format) && !is_doubtful && !is_epoch {
        return Ok(());
    }
    let other = match others.first() {
        _ if days.contains(format) && is_doubtful => Some(&plain),
        // Impossible interpretations are left out.
        None if !POSSIBLE.contains(&(step * format.unit())) => return Ok(()),
        other => other,
    };
    let mut readings: Vec<TimeFormat> = [format].into_iter().chain(other).cloned().collect();
    // Interpretations that fit the magnitude come first.
    if other.is_some_and(|other| !matches!(other, TimeFormat::Elapsed(_))) {
        readings.reverse();
    }
    Err(ambiguous(&readings, step, numbers, column, context))
}

/// The question which of `readings` applies.
fn ambiguous(
    readings: &[TimeFormat],
    step: f64,
    numbers: &[f64],
    column: &Column,
    context: &Context<'_>,
) -> Error {
    // If all give a date, the dates distinguish them.
    let dated = readings.iter().all(|each| each.zero().is_some());
    let first = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let told = readings.iter().enumerate().map(|(i, each)| {
        let would = if i == 0 { "the sample time would be " } else { "" };
        let from = match each.zero().filter(|_| dated) {
            Some(zero) => format!(" from {} on", date(zero + first * each.unit())),
            None => String::new(),
        };
        format!("as {} {would}{}{from}", each.describe(), span(step * each.unit()))
    });
    let told = told.collect::<Vec<_>>().join(", ");
    let unit = readings.first().map_or(1.0, TimeFormat::unit);
    let formats: Vec<String> = readings
        .iter()
        .map(|each| each.name().to_owned())
        // Days since 1970 have no name, because nobody uses them.
        .filter(|name| !name.is_empty())
        .collect();
    context.wrong_column(
        column,
        format!(
            "steps by {}: {told}; choose one, as in {}{}",
            digits(step),
            context.wording.of(Remedy::TimeFormat(formats)),
            between_rows(context, digits(step * unit).parse().unwrap_or(1.0))
        ),
    )
}

/// The date of a time in s since 1970.
pub fn date(seconds: f64) -> String {
    let at = jiff::Timestamp::from_second(seconds.floor() as i64);
    at.map_or("?".to_owned(), |at| Offset::UTC.to_datetime(at).date().to_string())
}

/// Whether all `numbers`, read in a format with dates, lie within a period, s since 1970.
pub fn all_within(time: &Range<f64>, format: &TimeFormat, numbers: &[f64]) -> bool {
    let Some(zero) = format.zero() else { return false };
    numbers.iter().all(|n| time.contains(&(zero + n * format.unit())))
}

/// Whether all numbers are recent dates in units of time since 1970.
pub fn is_epoch(numbers: &[f64]) -> bool {
    let epochs = [1.0, 1e-3, 1e-6, 1e-9].map(TimeFormat::Epoch);
    !numbers.is_empty() && epochs.iter().any(|epoch| all_within(&RECENT, epoch, numbers))
}

/// The formats in which numbers are recent dates, if `format` gives other dates, such as .NET ticks that would be
/// nanoseconds of the year 1990.
fn better_dates(format: &TimeFormat, numbers: &[f64]) -> Vec<TimeFormat> {
    let is_recent = |format: &TimeFormat| all_within(&RECENT, format, numbers);
    if format.zero().is_none() || is_recent(format) {
        return vec![];
    }
    let same_size = [TimeFormat::Gps, TimeFormat::Spreadsheet1904];
    let others = TimeFormat::DATED.into_iter().filter(|each| !same_size.contains(each));
    others.filter(is_recent).collect()
}

/// The names of formats in which the numbers are equally plausible dates, some years apart.
pub fn of_the_same_size(format: &TimeFormat, numbers: &[f64]) -> Vec<&'static str> {
    let pairs = [
        (TimeFormat::Epoch(1.0), TimeFormat::Gps, "gps"),
        (TimeFormat::Spreadsheet, TimeFormat::Spreadsheet1904, "excel-1904"),
    ];
    let fits = pairs
        .iter()
        .filter(|(known, other, _)| known == format && all_within(&RECENT, other, numbers));
    fits.map(|(_, _, name)| *name).collect()
}

/// The units in which `numbers` are whole seconds, minutes or quarters of an hour, although they are uneven as seconds:
/// minutes, hours or days. Samples of a clock in seconds are even or have jitter, and do not match.
fn larger_units(numbers: &[f64], steps: &[f64], step: f64) -> Vec<TimeFormat> {
    /// With fewer rows, a match by chance is too likely.
    const LEAST_ROWS: usize = 8;
    /// The share of a grid step by which a time may deviate.
    const OFF: f64 = 0.05;
    /// Half a unit of the last digit of numbers stored in 32 bits.
    const SINGLE: f64 = 1.2e-7;
    if numbers.len() < LEAST_ROWS {
        return vec![];
    }
    let first = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let last = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let is_multiple = |of: f64, unit: f64, off: f64| {
        numbers.iter().all(|n| {
            let count = (n - first) * unit / of;
            (count - count.round()).abs() * of <= off
        })
    };
    if is_short(mean_step(steps, step)) {
        return vec![];
    }
    let decimals = decimals(numbers);
    if decimals.is_some_and(|decimals| is_multiple(step, 1.0, 0.1 * 10f64.powi(-decimals))) {
        return vec![];
    }
    let rounded = match decimals {
        Some(decimals) => 0.5 * 10f64.powi(-decimals),
        None => SINGLE * first.abs().max(last.abs()),
    };
    let is_whole = |unit: f64| {
        let off = rounded * unit;
        let grid = [1.0, 60.0, 900.0].into_iter().find(|grid| off <= OFF * grid);
        grid.is_some_and(|grid| is_multiple(grid, unit, 2.0 * off + 1e-9))
    };
    let units = [60.0, 3600.0, 86_400.0].into_iter().filter(|unit| is_whole(*unit));
    units.map(TimeFormat::Elapsed).collect()
}

/// The mean of the steps that are not gaps.
fn mean_step(steps: &[f64], step: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for one in steps.iter().filter(|one| **one < 1.5 * step) {
        (sum, count) = (sum + one, count + 1.0);
    }
    if count > 0.0 { sum / count } else { step }
}

/// Whether a step has at most two digits, such as 0.25 or 10, apart from the drift of a clock.
fn is_short(step: f64) -> bool {
    /// Relative drift of a clock.
    const DRIFT: f64 = 1e-4;
    let unit = 10f64.powf(step.log10().floor() - 1.0);
    (step / unit - (step / unit).round()).abs() * unit <= DRIFT * step
}

/// The largest number of decimals of all numbers; none above 9.
fn decimals(numbers: &[f64]) -> Option<i32> {
    let has = |decimals: &i32| {
        let scale = 10f64.powi(*decimals);
        numbers.iter().all(|n| {
            let scaled = n * scale;
            (scaled - scaled.round()).abs() <= (1e-6 + 1e-7 * scaled.abs()).min(0.05)
        })
    };
    (0..=9).find(has)
}

/// Step of a regular clock, s, or else the mean time between rows; none if all times are equal.
pub fn mean_step_of_all(seconds: &[f64]) -> Option<f64> {
    let mean = series::span(seconds) / (seconds.len().max(2) - 1) as f64;
    let regular = Regular::of(seconds).map(|regular| regular.step);
    regular.or((mean > 0.0).then(|| rounded(mean)))
}

/// A hint to give the time between rows, unless rows belong to several tags.
pub fn sample_time(context: &Context<'_>) -> String {
    between_rows(context, 1.0)
}

/// A hint to give the time between rows, with this time as the example, s.
fn between_rows(context: &Context<'_>, seconds: f64) -> String {
    if context.is_long {
        return String::new();
    }
    let seconds = if USUAL.contains(&seconds) { seconds } else { 1.0 };
    let remedy = context.wording.of(Remedy::SampleTime(seconds));
    format!(", or give the time between rows, as in {remedy}")
}

/// The possible formats of numbers: first the formats that fit their magnitude, then plain units.
fn candidates(numbers: &[f64]) -> Vec<TimeFormat> {
    let has_parts = numbers.iter().any(|n| n.fract() != 0.0);
    let dated = TimeFormat::DATED.into_iter().filter(|each| has_parts || !each.is_local());
    let mut found: Vec<_> = dated.filter(|each| all_within(&PLAUSIBLE, each, numbers)).collect();
    found.extend([86_400.0, 3600.0, 60.0, 1.0, 1e-3, 1e-6, 1e-9].map(TimeFormat::Elapsed));
    found
}

/// The steps above 0 between neighbouring times: in the order of the file, or in order of time if many rows are not in
/// order. A clock that begins again has no small steps between the times of its runs.
fn steps(series: &[Vec<usize>], times: &[f64]) -> Vec<f64> {
    /// The share of steps back that shows rows in disorder.
    const DISORDER: f64 = 0.25;
    let mut steps = vec![];
    for rows in series {
        let mut own: Vec<f64> = rows.iter().map(|row| times[*row]).collect();
        let back = own.windows(2).filter(|pair| pair[1] < pair[0]).count();
        if back as f64 > DISORDER * own.len() as f64 {
            own.sort_unstable_by(f64::total_cmp);
        }
        steps.extend(own.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0));
    }
    steps
}

/// The median of steps; none if all times are equal.
fn median(mut steps: Vec<f64>) -> Option<f64> {
    let middle = steps.len().checked_sub(1)? / 2;
    Some(*steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The rows with the time of the row before in their series, but other values.
fn collapsed(
    series: &[Vec<usize>],
    times: &Times,
    column: &Column,
    context: &Context<'_>,
) -> Vec<usize> {
    let pairs = series.iter().flat_map(|rows| rows.windows(2)).map(|pair| (pair[0], pair[1]));
    let mut same: Vec<(usize, usize)> =
        pairs.filter(|(a, b)| times.seconds[*a] == times.seconds[*b]).collect();
    let mut rows = vec![];
    for other in context.sheet.columns.iter().filter(|each| each.name != column.name) {
        if same.is_empty() {
            break;
        }
        let cells = other.cells.view();
        same.retain(|(a, b)| {
            let is_equal = match &cells {
                Viewed::Text(cells) => cells[*a] == cells[*b],
                Viewed::Numbers(cells) | Viewed::Times(cells) => {
                    cells[*a].to_bits() == cells[*b].to_bits()
                }
            };
            if !is_equal {
                rows.push(*b);
            }
            is_equal
        });
    }
    rows.sort_unstable();
    rows
}

/// The cell of `column` in a row, as messages show it. For a day and a time of day in two columns, both cells are
/// shown.
fn shown(column: &Column, row: usize) -> String {
    match &column.cells {
        Cells::Text(cells) => number::shown(&cells.view()[row]),
        Cells::Numbers(cells) => cells[row].to_string(),
        Cells::Times { seconds, .. } => Clock::Utc.show(Some(0.0), seconds[row]),
    }
}

/// A time between rows in words, below a second in ms or µs.
fn span(seconds: f64) -> String {
    match seconds {
        0.9995.. => spoken::time(seconds),
        1e-3.. => format!("{} ms", spoken::rough(seconds * 1e3)),
        1e-6.. => format!("{} µs", spoken::rough(seconds * 1e6)),
        _ => format!("{seconds:e} s"),
    }
}

/// A step as in the file, with three digits.
fn digits(step: f64) -> String {
    match step {
        1e-9..1e7 => {
            let decimals = (2.0 - step.log10().floor()).max(0.0) as usize;
            let text = format!("{step:.decimals$}");
            let text = if text.contains('.') { text.trim_end_matches('0') } else { &text };
            text.trim_end_matches('.').to_owned()
        }
        _ => format!("{step:.2e}"),
    }
}

/// The source of the time between rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatedBy {
    /// The user, who is trusted as far as possible.
    User,
    /// The file, whose unit may be different.
    File,
}

/// Refuses an impossible time between rows, in s, and questions an unusual one from a file.
pub fn check_sample_time(
    seconds: f64,
    told: StatedBy,
    origin: &str,
    wording: Wording,
) -> Result<()> {
    let wrong = |message: String| Err(Error::Table { origin: origin.to_owned(), message });
    if !POSSIBLE.contains(&seconds) {
        return wrong(format!(
            "the sample time is given as {seconds:e} s, which is not plausible; give a time from 1 µs to a year, as in \
             {}",
            wording.of(Remedy::SampleTime(1.0))
        ));
    }
    if told == StatedBy::User || USUAL.contains(&seconds) {
        return Ok(());
    }
    let other = [86_400.0, 3600.0, 60.0, 1e-3, 1e-6].map(|unit| (unit, seconds * unit));
    let other = other.into_iter().find(|(_, seconds)| USUAL.contains(seconds));
    let in_other = other.map_or(String::new(), |(unit, other)| {
        let remedy = wording.of(Remedy::SampleTime(rounded(other)));
        format!("{remedy} if it means {} (in {}), or ", span(other), unit_name(unit))
    });
    wrong(format!(
        "the sample time in the file, {}, is unusual; give {in_other}{} if it means {} (in seconds)",
        digits(seconds),
        wording.of(Remedy::SampleTime(seconds)),
        span(seconds)
    ))
}

/// A time with four digits, as a user would write it.
fn rounded(seconds: f64) -> f64 {
    let unit = 10f64.powi(seconds.log10().floor() as i32 - 3);
    let digits = (seconds / unit).round();
    // Dividing by a power of ten above 1 gives a short decimal.
    if unit < 1.0 { digits / (1.0 / unit).round() } else { digits * unit }
}
