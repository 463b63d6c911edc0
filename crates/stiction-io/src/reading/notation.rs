//! The decimal mark of a sheet, where single cells leave it open.
//!
//! `1.001` is 1.001 or 1001. Each signal is judged as a whole. If `999` stands beside `1.001`, successive values are
//! near each other in one reading, and differ by a factor of 1000 in the other.

use crate::cells::number::{self, DecimalMark, Found, Shows};
use crate::columns::layout::{Place, Plan};
use crate::columns::options::ReadOptions;
use crate::columns::role::Signal;
use crate::error::{Error, Result};
use crate::remedy::Remedy;
use crate::sheet::{Cells, Sheet};
use crate::texts::{Texts, View};

/// Successive values are near each other if they differ by less than this factor, the fourth root of 1000.
const NEAR: f64 = 5.623;
/// A reading is certain if it brings successive values together this many times as often as the other does.
const CERTAIN: usize = 20;

/// The cells of a signal or of the times.
struct Source<'a> {
    /// Name, of the column or the tag.
    name: &'a str,
    column: &'a str,
    cells: &'a Texts,
    /// Rows; all if none.
    rows: Option<&'a [usize]>,
}

impl Source<'_> {
    /// Rows and cells, from a `view` of the column.
    fn cells<'v>(&self, view: &'v View<'_>) -> impl Iterator<Item = (usize, &'v str)> {
        let count = self.rows.map_or(view.len(), <[usize]>::len);
        (0..count).map(|k| self.rows.map_or(k, |rows| rows[k])).map(|row| (row, &view[row]))
    }
}

/// A source whose cells all leave the mark open.
struct Open<'a> {
    source: Source<'a>,
    /// The mark before three digits.
    mark: DecimalMark,
    /// The first row with the mark.
    row: usize,
    meaning: Meaning,
}

/// The meaning of a mark that always stands before three digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Meaning {
    /// It is the decimal mark.
    Decimal,
    /// It separates thousands.
    Thousands,
    /// Whole numbers below 1000 are beside it, but no neighbours show the meaning.
    Unclear,
    /// All numbers have it.
    Unknown,
}

/// The decimal mark of `sheet`, and notes on it. `found` contains the findings for its cells, one by one.
///
/// # Errors
/// If both readings are possible.
pub fn settle(
    sheet: &Sheet,
    plan: &Plan,
    options: &ReadOptions,
    found: Found,
) -> Result<(DecimalMark, Vec<String>)> {
    if let Some(given) = options.decimal_mark {
        return Ok((given, vec![]));
    }
    let open: Vec<Open<'_>> = sources(sheet, plan, options).filter_map(Open::of).collect();
    let decided = open.iter().find_map(Open::decided);
    let mark = match (found.is_sure, decided) {
        (false, Some(mark)) => mark,
        _ => found.mark,
    };
    let is_decided = found.is_sure || decided.is_some();
    let parts_thousands = |mark: DecimalMark| {
        open.iter().any(|each| each.mark == mark && each.meaning == Meaning::Thousands)
            || sheet.columns.iter().any(|column| parts_thousands(&column.cells, mark))
    };
    for each in &open {
        let fits = match each.meaning {
            Meaning::Decimal => each.mark == mark,
            Meaning::Thousands => each.mark != mark,
            Meaning::Unclear if !is_decided => false,
            Meaning::Unclear | Meaning::Unknown => each.mark == mark || parts_thousands(each.mark),
        };
        if !fits {
            return Err(each.ask(sheet, options, found));
        }
    }
    let thousands = open.iter().filter(|each| each.meaning == Meaning::Thousands);
    Ok((mark, thousands.map(|each| each.note(options, found)).collect()))
}

/// The numeric sources in text that `plan` uses.
fn sources<'a>(
    sheet: &'a Sheet,
    plan: &'a Plan,
    options: &ReadOptions,
) -> impl Iterator<Item = Source<'a>> {
    let source = move |name: &'a str, column: usize, rows: Option<&'a [usize]>| {
        let column = &sheet.columns[column];
        let Cells::Text(cells) = &column.cells else { return None };
        Some(Source { name, column: &column.name, cells, rows })
    };
    let signal = move |place: usize| match &plan.place {
        Place::Columns => source(&sheet.columns[place].name, place, None),
        Place::Rows { tags, value, .. } => {
            source(&tags[place].name, *value, Some(&tags[place].rows))
        }
    };
    let numeric = [Signal::Op, Signal::Pv, Signal::Sp, Signal::Vp];
    let time = plan.time.filter(|_| options.sample_time.is_none());
    plan.loops
        .iter()
        .flat_map(move |each| numeric.into_iter().filter_map(move |signal| each.signal(signal)))
        .filter_map(signal)
        .chain(time.and_then(|time| source(&sheet.columns[time].name, time, None)))
}

/// Whether `mark` certainly separates thousands in one of the `cells`, as in 1.234,5 or 1.234.567.
fn parts_thousands(cells: &Cells, mark: DecimalMark) -> bool {
    let Cells::Text(cells) = cells else { return false };
    let is_it =
        |cell: &str| cell.contains(mark.mark()) && number::shows(cell) == Shows::Mark(mark.other());
    cells.view().iter().any(is_it)
}

impl<'a> Open<'a> {
    /// The meaning of the marks in `source`. The result is `None` without marks, or if some cell determines its mark.
    fn of(source: Source<'a>) -> Option<Self> {
        let mut first: Option<(DecimalMark, usize)> = None;
        let (mut is_mixed, mut whole, mut decimal, mut thousands) = (false, false, 0, 0);
        // The last number, and whether it has a mark.
        let mut last: Option<(&str, bool)> = None;
        let view = source.cells.view();
        for (row, cell) in source.cells(&view) {
            let has_mark = match number::shows(cell) {
                Shows::Mark(_) => return None,
                Shows::NoNumber if last.is_none() && number::starts_otherwise(cell) => return None,
                Shows::NoNumber => continue,
                Shows::Nothing => false,
                Shows::Either(mark) => {
                    is_mixed = is_mixed || first.is_some_and(|(other, _)| other != mark);
                    first = first.or(Some((mark, row)));
                    true
                }
            };
            if let Some((before, had_mark)) = last
                && had_mark != has_mark
            {
                let (marked, whole) = if has_mark { (cell, before) } else { (before, cell) };
                let (near, near_thousand) = compared(marked, whole);
                decimal += usize::from(near);
                thousands += usize::from(near_thousand);
            }
            if !has_mark {
                let value = number::parse(cell, DecimalMark::Point).unwrap_or(0.0).abs();
                whole = whole || value > 0.0;
                // A file that separates thousands separates them everywhere.
                decimal += usize::from(value >= 1000.0);
            }
            last = Some((cell, has_mark));
        }
        let (mark, row) = first?;
        let meaning = match (decimal, thousands) {
            _ if is_mixed => Meaning::Unclear,
            (0, 0) if whole => Meaning::Unclear,
            (0, 0) => Meaning::Unknown,
            (decimal, thousands) if decimal >= CERTAIN * thousands => Meaning::Decimal,
            (decimal, thousands) if thousands >= CERTAIN * decimal => Meaning::Thousands,
            _ => Meaning::Unclear,
        };
        Some(Self { source, mark, row, meaning })
    }

    /// The decimal mark by the meaning, if it is clear.
    fn decided(&self) -> Option<DecimalMark> {
        match self.meaning {
            Meaning::Decimal => Some(self.mark),
            Meaning::Thousands => Some(self.mark.other()),
            Meaning::Unclear | Meaning::Unknown => None,
        }
    }

    /// The lowest and highest value with this decimal mark.
    fn values(&self, mark: DecimalMark) -> String {
        let view = self.source.cells.view();
        let values = self.source.cells(&view).filter_map(|(_, cell)| number::parse(cell, mark));
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        format!("{low} to {high}")
    }

    fn ask(&self, sheet: &Sheet, options: &ReadOptions, found: Found) -> Error {
        let (decimal, thousands) = (self.mark, self.mark.other());
        let give = |mark| options.wording.of(Remedy::DecimalMark(mark));
        let remedy = match found.is_sure {
            false => format!(
                "if it is the decimal mark, give {}; if it separates thousands, give {}",
                give(decimal),
                give(thousands)
            ),
            true => format!(
                "other numbers of the file have a decimal \"{}\"; if it separates {} here, give {}, else write all \
                 numbers alike",
                found.mark.mark(),
                if found.mark == decimal { "decimals" } else { "thousands" },
                give(found.mark)
            ),
        };
        let Source { name, column, cells, .. } = &self.source;
        let column =
            if name == column { (*name).to_owned() } else { format!("{column}\" of \"{name}") };
        Error::Cell {
            origin: sheet.origin.clone(),
            row: sheet.row(self.row),
            column,
            message: format!(
                "the \"{}\" in \"{}\" has two readings: the values are {} if it is a decimal mark, or {} if it \
                 separates thousands; {remedy}",
                self.mark.mark(),
                &cells.view()[self.row],
                self.values(decimal),
                self.values(thousands),
            ),
        }
    }

    fn note(&self, options: &ReadOptions, found: Found) -> String {
        let remedy = match found.is_sure {
            true => String::new(),
            false => format!(
                "; if it is the decimal mark, give {}",
                options.wording.of(Remedy::DecimalMark(self.mark))
            ),
        };
        format!(
            "the \"{}\" in \"{}\" separates thousands, because only then are successive values near each other: {}{remedy}",
            self.mark.mark(),
            self.source.name,
            self.values(self.mark.other()),
        )
    }
}

/// Whether a number with a mark is near a `whole` number: as a decimal number, and with thousands.
fn compared(marked: &str, whole: &str) -> (bool, bool) {
    let value = |cell: &str| {
        let by = |mark| number::parse(cell, mark);
        // The smaller reading is the decimal number.
        by(DecimalMark::Point)
            .zip(by(DecimalMark::Comma))
            .map(|(a, b)| if a.abs() < b.abs() { a } else { b })
    };
    let (Some(marked), Some(whole)) = (value(marked), value(whole)) else { return (false, false) };
    let near = |ratio: f64| ratio > 1.0 / NEAR && ratio < NEAR;
    (near(marked / whole), near(1000.0 * marked / whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meaning(cells: &str) -> Option<Meaning> {
        let cells: Texts = cells.split(' ').collect();
        let source = Source { name: "PV", column: "PV", cells: &cells, rows: None };
        Open::of(source).map(|open| open.meaning)
    }

    #[test]
    fn neighbours_show_the_meaning() {
        for (cells, expected) in [
            ("998 999 1.001 1.003 999", Some(Meaning::Thousands)),
            ("-998 -1,002 -1,000", Some(Meaning::Thousands)),
            ("999 Bad 1.002  1.000", Some(Meaning::Thousands)),
            ("1 1.001 1.002 1", Some(Meaning::Decimal)),
            ("45 45,125 45,250 46", Some(Meaning::Decimal)),
            ("1250 3 1.250 2", Some(Meaning::Decimal)),
            ("1250 1.250 1251", Some(Meaning::Unclear)),
            ("30 1.000 1.001 31", Some(Meaning::Unclear)),
            ("999 1.001 1 1.001", Some(Meaning::Unclear)),
            ("1.001 1,002", Some(Meaning::Unclear)),
            ("60.060 44.970", Some(Meaning::Unknown)),
            ("0 1.250 0 1.300", Some(Meaning::Unknown)),
            ("999 1.001 0.998", None),
            ("999 1000 1001", None),
            ("2023-01-01 2023-01-02", None),
            ("Good Bad", None),
        ] {
            assert_eq!(meaning(cells), expected, "{cells}");
        }
    }
}
