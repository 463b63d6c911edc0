//! CSV as historians, control systems and spreadsheets export it, read into a [`Sheet`].

mod annotated;
mod encoding;

use crate::budget::Budget;
use crate::cells::number::{self, DecimalMark};
use crate::error::{Error, Result};
use crate::sheet::{Cells, Column, Sheet};
use crate::timestamp;
use csv::StringRecord;
use encoding::decode;
use std::collections::HashSet;
use std::sync::Arc;

/// The notation of a CSV file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dialect {
    /// Name of the encoding, such as `UTF-8`.
    pub encoding: &'static str,
    /// The separator of cells.
    pub delimiter: char,
    /// The decimal mark.
    pub decimal_mark: DecimalMark,
}

/// A CSV file with its cells, its notation, and notes for the user.
#[derive(Debug, Clone, PartialEq)]
pub struct CsvSheet {
    /// The cells.
    pub sheet: Sheet,
    /// Its notation.
    pub dialect: Dialect,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Number of records used to detect the delimiter and the width of the table.
const LOOKED_AT: usize = 200;

/// Reads a CSV file from `bytes`; `origin` is its name in errors.
///
/// The delimiter is the comma, semicolon, tab or bar that divides most lines alike. Lines above the header, and those
/// that begin with `#`, are metadata; a row of units may follow the header. The tables of InfluxDB become one.
///
/// # Errors
/// If it is not text, names no columns, or has a row with more or fewer cells than the header.
///
/// # Limits
/// Cells that would take more than 4 GiB are refused.
pub fn read(bytes: &[u8], origin: &str) -> Result<CsvSheet> {
    read_within(Budget::of(bytes.len()), bytes, origin)
}

fn read_within(mut budget: Budget, bytes: &[u8], origin: &str) -> Result<CsvSheet> {
    let wrong = |message: String| Error::Table { origin: origin.to_owned(), message };
    let decoded = decode(bytes, origin)?;
    let text = &*decoded.text;
    if text.trim().is_empty() {
        return Err(wrong("is empty; a header row and rows of samples are needed".to_owned()));
    }
    let mut notes: Vec<String> = decoded.note.into_iter().collect();
    if annotated::is(text) {
        let sheet = annotated::read(text, &mut budget).map_err(wrong)?;
        let decimal_mark = number::decimal_mark(&sheet.columns);
        let dialect = Dialect { encoding: decoded.encoding, delimiter: ',', decimal_mark };
        return Ok(CsvSheet {
            sheet: Sheet { origin: origin.to_owned(), ..sheet },
            dialect,
            notes,
        });
    }
    let delimiter = told_delimiter(text).unwrap_or_else(|| delimiter(text));
    let mut records = Records::new(text, delimiter);
    let top = Top::find(&mut records, width(text, delimiter), &mut notes).map_err(wrong)?;
    let mut attributes = top.attributes;

    let mut columns: Vec<Vec<Arc<str>>> = top.names.iter().map(|_| vec![]).collect();
    let (mut rows, mut comments) = (vec![], 0);
    let mut units: Option<Vec<String>> = None;
    // A header in a comment is followed by samples that were already read.
    let mut records = Records::new(text, delimiter);
    while records.next().map_err(wrong)?.is_some_and(|(line, _)| line < top.line) {}
    while let Some((line, record)) = records.next().map_err(wrong)? {
        if is_comment(record) {
            comments += 1;
            attributes.extend(attribute(record));
            continue;
        }
        check_width(record, columns.len(), line).map_err(wrong)?;
        if rows.is_empty() && units.is_none() && is_units(record) {
            units = Some(record.iter().map(trimmed).collect());
            continue;
        }
        let text: usize = record.iter().map(str::len).sum();
        let cells = columns.len() * size_of::<Arc<str>>();
        budget.spend(text + cells).map_err(|message| wrong(format!("row {line} {message}")))?;
        for (column, cell) in columns.iter_mut().zip(record.iter()) {
            column.push(cell.trim().into());
        }
        rows.push(line);
    }
    if rows.is_empty() {
        return Err(wrong("has no row of samples below its header".to_owned()));
    }
    if comments > 0 {
        notes.push(format!("{comments} comment lines among the rows are not samples"));
    }

    notes.extend(cut(text, &columns, &rows));

    let unit = |i: usize| {
        let unit = units.as_ref()?.get(i)?.trim_matches(['[', ']', '(', ')']);
        (!unit.is_empty()).then(|| unit.to_owned())
    };
    let columns: Vec<Column> = top
        .names
        .into_iter()
        .zip(columns)
        .enumerate()
        .map(|(i, (name, cells))| Column { name, unit: unit(i), cells: Cells::Text(cells) })
        // A delimiter at the end of every line makes no column.
        .filter(|column| {
            !column.name.is_empty()
                || matches!(&column.cells, Cells::Text(cells) if cells.iter().any(|c| !c.is_empty()))
        })
        .collect();
    let columns = named(columns, origin)?;
    let decimal_mark = number::decimal_mark(&columns);
    let sample_time = sample_time(&attributes, origin)?;
    let sheet = Sheet {
        origin: origin.to_owned(),
        part: String::new(),
        columns,
        sample_time,
        attributes,
        rows,
        ..Sheet::default()
    };
    let dialect = Dialect { encoding: decoded.encoding, delimiter: delimiter.into(), decimal_mark };
    Ok(CsvSheet { sheet, dialect, notes })
}

/// Checks whether a file seems to be cut within its last value. No line break follows that value, and it is shorter
/// than most of the values above, or its decimals end differently.
fn cut(text: &str, columns: &[Vec<Arc<str>>], rows: &[usize]) -> Option<String> {
    /// Number of values above that are compared.
    const ABOVE: usize = 10;
    /// Number of them that counts as most.
    const MOST: usize = 8;
    let (last, above) = columns.last()?.split_last()?;
    if text.ends_with(['\r', '\n']) || above.len() < ABOVE {
        return None;
    }
    let above = &above[above.len() - ABOVE..];
    let shorter = |value: &&Arc<str>| last.chars().count() < value.chars().count();
    let ends_in_zero =
        |value: &Arc<str>| value.contains(['.', ',']) && value.ends_with(['0', '.', ',']);
    let is_cut = above.iter().filter(shorter).count() >= MOST
        || ends_in_zero(last) && !above.iter().any(ends_in_zero);
    is_cut.then(|| {
        format!(
            "the file seems to be cut in row {}, because it does not end with a line break and the last value, \
             \"{last}\", is shorter than those above; copy it again, or remove the row",
            rows.last().unwrap_or(&0)
        )
    })
}

/// The delimiter in Excel's line `sep=;`.
fn told_delimiter(text: &str) -> Option<u8> {
    match *lines(text).next()?.trim_ascii_end().as_bytes() {
        [b's' | b'S', b'e' | b'E', b'p' | b'P', b'=', delimiter] => Some(delimiter),
        _ => None,
    }
}

/// The delimiter, the candidate that divides most lines into equally many parts.
fn delimiter(text: &str) -> u8 {
    let bare = |line: &str, delimiter: u8| {
        line.split('"').step_by(2).flat_map(str::bytes).filter(|b| *b == delimiter).count()
    };
    let alike = |delimiter: &u8| {
        let mut counts: Vec<usize> = lines(text)
            .filter(|line| !line.trim().is_empty() && !line.starts_with('#'))
            .take(LOOKED_AT)
            .map(|line| bare(line, *delimiter))
            .filter(|count| *count > 0)
            .collect();
        counts.sort_unstable();
        counts.chunk_by(|a, b| a == b).map(<[usize]>::len).max().unwrap_or(0)
    };
    // max_by_key keeps the last of equals. A comma may be a decimal mark.
    *[b',', b'|', b';', b'\t']
        .iter()
        .max_by_key(|d| alike(d))
        .filter(|d| alike(d) > 0)
        .unwrap_or(&b',')
}

/// Lines with any line ends.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split(['\r', '\n']).filter(|line| !line.is_empty())
}

/// The records of a text, and the lines on which they begin. The reader's own count knows only `\n`, and stops before
/// blank lines.
struct Records<'t> {
    text: &'t [u8],
    reader: csv::Reader<&'t [u8]>,
    record: StringRecord,
    at: usize,
    line: usize,
}

impl<'t> Records<'t> {
    fn new(text: &'t str, delimiter: u8) -> Self {
        let reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .from_reader(text.as_bytes());
        Self { text: text.as_bytes(), reader, record: StringRecord::new(), at: 0, line: 1 }
    }

    /// The next record that is not blank, and its line, from 1.
    fn next(&mut self) -> std::result::Result<Option<(usize, &StringRecord)>, String> {
        loop {
            let start = self.reader.position().byte() as usize;
            if !self.reader.read_record(&mut self.record).map_err(|e| e.to_string())? {
                return Ok(None);
            }
            let is_end = |b: &&u8| matches!(**b, b'\r' | b'\n');
            let begin = start + self.text[start..].iter().take_while(is_end).count();
            for i in self.at..begin {
                let pair = self.text[i] == b'\r' && self.text.get(i + 1) == Some(&b'\n');
                self.line += usize::from(is_end(&&self.text[i]) && !pair);
            }
            self.at = begin;
            if filled(&self.record) > 0 {
                return Ok(Some((self.line, &self.record)));
            }
        }
    }
}

/// The part above the samples.
struct Top {
    names: Vec<String>,
    /// Line of the header.
    line: usize,
    attributes: Vec<(String, String)>,
}

impl Top {
    /// Finds the header, which is the first record as wide as the table that is not a comment. If that is a row of
    /// samples, the comment above it may be the header.
    fn find(
        records: &mut Records<'_>,
        width: usize,
        notes: &mut Vec<String>,
    ) -> std::result::Result<Self, String> {
        let mut attributes = vec![];
        let mut comment: Option<(usize, StringRecord)> = None;
        while let Some((line, record)) = records.next()? {
            let first = record[0].trim();
            if line == 1 && first.to_ascii_lowercase().starts_with("sep=") {
                continue;
            }
            if is_comment(record) {
                attributes.extend(attribute(record));
                comment = Some((line, record.clone()));
            } else if filled(record) < width || first.ends_with(':') {
                // Titles and settings above the table.
                attributes.extend(attribute(record));
            } else if !is_samples(record) {
                return Ok(Self { names: record.iter().map(trimmed).collect(), line, attributes });
            } else {
                let Some((line, header)) = comment.filter(|(_, text)| filled(text) == width) else {
                    return Err(format!(
                        "row {line} must name the columns, but reads \"{}\"; add a header such as \
                         \"time,pv,op\"",
                        number::shown(&record.iter().collect::<Vec<_>>().join(","))
                    ));
                };
                notes.push(format!("the comment in row {line} is used as the header"));
                let mut names: Vec<String> = header.iter().map(trimmed).collect();
                names[0] = names[0].trim_start_matches(['#', ' ']).to_owned();
                return Ok(Self { names, line, attributes });
            }
        }
        Err("names no columns; a header such as \"time,pv,op\" and rows of samples are needed"
            .to_owned())
    }
}

fn trimmed(cell: &str) -> String {
    cell.trim().to_owned()
}

/// The most frequent number of filled cells of the records that are not comments; the larger of equals.
fn width(text: &str, delimiter: u8) -> usize {
    let mut records = Records::new(text, delimiter);
    let mut widths = vec![];
    while widths.len() < LOOKED_AT
        && let Ok(Some((_, record))) = records.next()
    {
        if !is_comment(record) {
            widths.push(filled(record));
        }
    }
    widths.sort_unstable();
    widths.chunk_by(|a, b| a == b).max_by_key(|same| same.len()).map_or(1, |same| same[0])
}

/// Number of cells of a record, without empty ones at its end.
fn filled(record: &StringRecord) -> usize {
    (0..record.len()).rfind(|i| !record[*i].trim().is_empty()).map_or(0, |last| last + 1)
}

/// Whether a record is a comment. `#N/A` is not one, because Excel writes it for a missing value.
fn is_comment(record: &StringRecord) -> bool {
    let first = record[0].trim();
    first.starts_with('#') && number::word(first).is_none()
}

/// Whether a record holds samples and not names, that is only numbers, or a date and time.
fn is_samples(record: &StringRecord) -> bool {
    let cells = || record.iter().map(str::trim).filter(|cell| !cell.is_empty());
    cells().all(number::looks_like) || cells().any(timestamp::looks_like)
}

/// The content of a comment or a line above the table, such as `key: value`, `key = value` or two cells.
fn attribute(record: &StringRecord) -> Option<(String, String)> {
    let key_of =
        |key: &str| key.trim().trim_start_matches(['#', ' ']).trim_end_matches(':').to_owned();
    let (key, value) = if filled(record) == 2 {
        (key_of(&record[0]), trimmed(&record[1]))
    } else {
        let (key, value) = record[0].split_once([':', '='])?;
        let rest: String = record
            .iter()
            .skip(1)
            .take(filled(record).max(1) - 1)
            .map(|c| format!(",{c}"))
            .collect();
        (key_of(key), format!("{}{rest}", value.trim()))
    };
    (!key.is_empty() && !value.is_empty()).then_some((key, value))
}

/// Whether a record below the header holds units. It has no sample, and something that is certainly a unit.
fn is_units(record: &StringRecord) -> bool {
    const UNITS: [&str; 44] = [
        "%", "s", "sec", "ms", "min", "h", "hr", "°c", "°f", "k", "degc", "deg c", "degf", "deg f",
        "m3/h", "m³/h", "nm3/h", "l/h", "l/min", "l/s", "kg/h", "kg/s", "t/h", "bar", "barg",
        "bara", "mbar", "pa", "kpa", "mpa", "psi", "psig", "kg/cm2", "ma", "v", "mm", "cm", "m",
        "in", "ph", "ppm", "gpm", "rpm", "pct",
    ];
    let cells = || record.iter().map(str::trim).filter(|cell| !cell.is_empty());
    let bracketed = |cell: &str| {
        [('[', ']'), ('(', ')')].iter().any(|(a, b)| cell.starts_with(*a) && cell.ends_with(*b))
    };
    let unit = |cell: &str| {
        UNITS.contains(&cell.to_lowercase().trim_matches(['[', ']', '(', ')']))
            || (bracketed(cell) && number::word(cell).is_none())
    };
    cells().any(unit)
        && !cells().any(|cell| number::looks_like(cell) || timestamp::looks_like(cell))
}

/// Checks that a row has as many cells as the header, except for empty ones at its end.
fn check_width(
    record: &StringRecord,
    columns: usize,
    line: usize,
) -> std::result::Result<(), String> {
    if record.len() < columns || filled(record) > columns {
        return Err(format!(
            "row {line} has {} cells, but the header has {columns} columns; give every row the same number of cells, \
             and put cells that contain the delimiter in quotes",
            record.len()
        ));
    }
    Ok(())
}

/// The columns. A column without a name is named after its place.
///
/// # Errors
/// If two have the same name.
fn named(mut columns: Vec<Column>, origin: &str) -> Result<Vec<Column>> {
    let mut seen = HashSet::with_capacity(columns.len());
    for (i, column) in columns.iter_mut().enumerate() {
        if column.name.is_empty() {
            column.name = format!("column {}", i + 1);
        }
        if !seen.insert(column.name.clone()) {
            let message = format!("has two columns named \"{}\"; rename one", column.name);
            return Err(Error::Table { origin: origin.to_owned(), message });
        }
    }
    Ok(columns)
}

/// The sample time in s, from the lines above the table.
fn sample_time(attributes: &[(String, String)], origin: &str) -> Result<Option<f64>> {
    let is_it = |key: &str| {
        let key = key.to_ascii_lowercase().replace([' ', '-'], "_");
        matches!(&*key, "sample_time" | "sampling_time" | "sample_time_s" | "sampling_interval")
    };
    let Some((key, value)) = attributes.iter().find(|(key, _)| is_it(key)) else { return Ok(None) };
    let number = value.trim_end_matches(" s").trim_end_matches('s').trim();
    match number::parse(number, DecimalMark::Point) {
        Some(seconds) if seconds > 0.0 => Ok(Some(seconds)),
        _ => Err(Error::Table {
            origin: origin.to_owned(),
            message: format!(
                "has \"{key}: {value}\" above the table, which is not a time above 0 s; write it in seconds, such as \
                 \"{key}: 1.5\""
            ),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_take_too_much_is_refused_at_its_row() {
        let text = b"t,op\n0,50\n1,51\n2,52\n";
        let row = 3 + 2 * size_of::<String>();
        assert!(read_within(Budget::new(3 * row), text, "f.csv").is_ok());
        let message = read_within(Budget::new(2 * row), text, "f.csv").unwrap_err().to_string();
        assert!(message.starts_with("f.csv: row 4 would take more than"), "{message}");
    }
}
