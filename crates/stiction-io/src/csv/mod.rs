//! CSV as historians, control systems and spreadsheets export it, read into a [`Sheet`].

mod annotated;
mod encoding;
mod input;
mod odd;
mod top;

use crate::budget::Budget;
use crate::cells::number::{self, DecimalMark};
use crate::columns::layout::side_by_side;
use crate::columns::options::ReadOptions;
use crate::columns::role::{self, Role, Signal};
use crate::error::{Error, Result};
use crate::sheet::{Cells, Column, Sheet};
use crate::texts::{self, Filling, Texts};
use csv::StringRecord;
use encoding::decode;
use input::Input;
use odd::Odd;
use std::collections::{HashMap, HashSet};
use std::path::Path;
use top::{Line, Top};

/// The notation of a CSV file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dialect {
    /// Name of the encoding, such as `UTF-8`.
    pub encoding: &'static str,
    /// The separator of cells.
    pub delimiter: char,
    /// The decimal mark.
    pub decimal_mark: DecimalMark,
    /// Whether some cell is a number only with this mark.
    pub mark_is_sure: bool,
}

/// A CSV file with its cells, its notation, and notes for the user.
#[derive(Debug, Clone, PartialEq)]
pub struct CsvSheet {
    /// The cells.
    pub sheet: Sheet,
    /// Notation.
    pub dialect: Dialect,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Number of records used to detect the delimiter and the width of the table.
const LOOKED_AT: usize = 200;

/// The smallest size, in bytes, of a file that is read in pieces.
const LARGE: u64 = 64 << 20;

/// The most records up to the end of the header.
const LONGEST_TOP: usize = 1000;

/// Reads a CSV file from `bytes`; `origin` is its name in errors.
///
/// The delimiter is the comma, semicolon, tab or bar that divides most lines alike. Lines above the header, and those
/// that begin with `#`, are metadata. The header may have several rows: of groups, names, units and descriptions. Rows
/// that are torn and lines at the end are counted in notes. The tables of InfluxDB become one.
///
/// # Errors
/// If the bytes are not text, name no columns, or have many rows with more or fewer cells than the header.
///
/// # Limits
/// Cells that would take more than 4 GiB are refused.
pub fn read(bytes: &[u8], origin: &str) -> Result<CsvSheet> {
    let decoded = decode(bytes, origin)?;
    let (encoding, notes) = (decoded.encoding, decoded.note.into_iter().collect());
    let budget = Budget::of(bytes.len());
    read_within(budget, texts::MOST_HELD, Input::whole(decoded.text), encoding, notes, origin)
}

/// Reads a large text file in UTF-8 piece by piece, and also returns the SHA-256 of its bytes. `None` for any other
/// file.
///
/// # Errors
/// As for [`read`].
pub(crate) fn read_large(path: &Path, origin: &str) -> Result<Option<(CsvSheet, String)>> {
    let Some((input, sha256)) = input::large(path, LARGE)? else { return Ok(None) };
    let budget = Budget::new(usize::MAX);
    let read = read_within(budget, texts::MOST_HELD, input, "UTF-8", vec![], origin)?;
    Ok(Some((read, sha256)))
}

/// Reads an `input`, of whose cells `most` bytes stay in memory.
fn read_within(
    mut budget: Budget,
    most: usize,
    mut input: Input<'_>,
    encoding: &'static str,
    mut notes: Vec<String>,
    origin: &str,
) -> Result<CsvSheet> {
    let wrong = |message: String| Error::Table { origin: origin.to_owned(), message };
    let is_looked_at = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
    while input.goes_on() && lines(&input.text).filter(is_looked_at).nth(LOOKED_AT).is_none() {
        input.pass(0).map_err(wrong)?;
    }
    if input.text.trim().is_empty() {
        return Err(wrong("is empty; a header row and rows of samples are needed".to_owned()));
    }
    if annotated::is(&input.text) {
        while input.goes_on() {
            input.pass(0).map_err(wrong)?;
        }
        let sheet = annotated::read(&input.text, &mut budget).map_err(wrong)?;
        let found = number::decimal_mark(&sheet.columns);
        let dialect = Dialect {
            encoding,
            delimiter: ',',
            decimal_mark: found.mark,
            mark_is_sure: found.is_sure,
        };
        return Ok(CsvSheet {
            sheet: Sheet { origin: origin.to_owned(), ..sheet },
            dialect,
            notes,
        });
    }
    let delimiter = stated_delimiter(&input.text).unwrap_or_else(|| delimiter(&input.text));
    let first = loop {
        match beginning(&input, delimiter).map_err(wrong)? {
            Some(first) => break first,
            None => input.pass(0).map_err(wrong)?,
        }
    };
    let mut top = Top::find(&first, width(&first)).map_err(wrong)?;
    notes.append(&mut top.notes);
    let mut attributes = std::mem::take(&mut top.attributes);
    let named_by: Vec<&str> = top.names.iter().map(|name| &**name).collect();
    // Where signals have clocks of their own, shorter ones end before the others.
    let pads = side_by_side::has_clocks(&named_by, &ReadOptions::default());

    let mut filling = Filling::new(top.names.len(), most);
    let (mut rows, mut comments, mut odd) = (vec![], 0, Odd::default());
    let mut line = 1;
    loop {
        let mut records = Records::of(&input, delimiter, line);
        while let Some((line, record)) = records.next().map_err(wrong)? {
            if line < top.first {
                continue;
            }
            if is_comment(record) {
                comments += 1;
                attributes.extend(attribute(record));
                continue;
            }
            if odd.takes(line, record, &top, pads) {
                continue;
            }
            let cells = record.as_slice().len() + top.names.len() * texts::BESIDE;
            budget.spend(cells).map_err(|message| wrong(format!("row {line} {message}")))?;
            filling.push(record.iter().map(str::trim)).map_err(wrong)?;
            rows.push(line);
        }
        if !input.goes_on() {
            break;
        }
        line = records.line;
        let passed = records.at;
        input.pass(passed).map_err(wrong)?;
    }
    let mut columns = filling.end().map_err(wrong)?;
    notes.extend(odd.notes(&mut columns, &mut rows).map_err(wrong)?);
    if rows.is_empty() {
        let message = "has no row of samples below its header".to_owned();
        let is = |role: Role| top.names.iter().any(|name| role::of_rows(name) == Some(role));
        let is_op = |name: &String| {
            let split = role::split(name, &[]);
            split.is_some_and(|split| split.role == Role::Signal(Signal::Op))
        };
        let (has_times, origin) = (is(Role::Time) || is(Role::Date), origin.to_owned());
        return Err(match has_times || top.names.iter().any(is_op) {
            true => wrong(message),
            false => Error::NoOp { origin, has_times, message },
        });
    }
    if comments > 0 {
        notes.push(format!("{comments} comment lines among the rows are not samples"));
    }

    notes.extend(cut(&input.text, &columns, &rows));

    let unit = |i: usize| {
        let unit = top.units.as_ref()?.get(i)?.trim_matches(['[', ']', '(', ')']);
        (!unit.is_empty()).then(|| unit.to_owned())
    };
    let columns: Vec<Column> = std::mem::take(&mut top.names)
        .into_iter()
        .zip(columns)
        .enumerate()
        .map(|(i, (name, cells))| Column { name, unit: unit(i), cells: Cells::Text(cells) })
        // A delimiter at the end of every line makes no column.
        .filter(|column| {
            !column.name.is_empty()
                || matches!(&column.cells, Cells::Text(cells) if cells.view().iter().any(|c| !c.is_empty()))
        })
        .collect();
    let mut columns = named(columns, &mut notes);
    columns.iter_mut().for_each(take_percent);
    let found = number::decimal_mark(&columns);
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
    let dialect = Dialect {
        encoding,
        delimiter: delimiter.into(),
        decimal_mark: found.mark,
        mark_is_sure: found.is_sure,
    };
    Ok(CsvSheet { sheet, dialect, notes })
}

/// Makes `%` the unit of a column whose numbers all end with it.
fn take_percent(column: &mut Column) {
    fn number(cell: &str) -> Option<&str> {
        cell.strip_suffix('%').map(str::trim_end).filter(|cell| number::looks_like(cell))
    }
    let Cells::Text(texts) = &column.cells else { return };
    let cells = texts.view();
    let is_one = |cell: &str| number(cell).is_some() || number::word(cell).is_some();
    if column.unit.is_none()
        && cells.iter().all(is_one)
        && cells.iter().any(|cell| number(cell).is_some())
    {
        let bare = cells.iter().map(|cell| number(cell).unwrap_or(cell)).collect();
        drop(cells);
        column.cells = Cells::Text(bare);
        column.unit = Some("%".to_owned());
    }
}

/// Checks whether a file seems to be cut within its last value. No line break follows that value, and it is shorter
/// than most of the values above, or its decimals end differently.
fn cut(text: &str, columns: &[Texts], rows: &[usize]) -> Option<String> {
    /// Number of values above that are compared.
    const ABOVE: usize = 10;
    /// Number of columns that counts as most.
    const MOST: usize = 8;
    if text.ends_with(['\r', '\n']) || rows.len() <= ABOVE {
        return None;
    }
    let values = columns.last()?.view();
    let last = values.last()?;
    let above = || values.iter().rev().skip(1).take(ABOVE);
    let shorter = |value: &&str| last.chars().count() < value.chars().count();
    let ends_in_zero = |value: &str| value.contains(['.', ',']) && value.ends_with(['0', '.', ',']);
    let is_cut =
        above().filter(shorter).count() >= MOST || ends_in_zero(last) && !above().any(ends_in_zero);
    is_cut.then(|| {
        format!(
            "row {} seems to be cut short, because it has no line break and its last value, \"{last}\", is shorter \
             than the values above; copy the file again, or remove the row",
            rows.last().unwrap_or(&0)
        )
    })
}

/// The delimiter in Excel's line `sep=;`.
fn stated_delimiter(text: &str) -> Option<u8> {
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
    /// Whether text follows that may belong to the last record.
    goes_on: bool,
    reader: csv::Reader<&'t [u8]>,
    record: StringRecord,
    /// The place up to which lines are counted, and its line.
    at: usize,
    line: usize,
}

impl<'t> Records<'t> {
    fn new(text: &'t str, delimiter: u8) -> Self {
        let text = text.as_bytes();
        let reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .from_reader(text);
        Self { text, goes_on: false, reader, record: StringRecord::new(), at: 0, line: 1 }
    }

    /// The records that are complete in the text of an `input`, which begins on this line.
    fn of(input: &'t Input<'_>, delimiter: u8, line: usize) -> Self {
        Self { goes_on: input.goes_on(), line, ..Self::new(&input.text, delimiter) }
    }

    /// The next record that is not blank, and its line, from 1.
    fn next(&mut self) -> std::result::Result<Option<(usize, &StringRecord)>, String> {
        loop {
            let start = self.reader.position().byte() as usize;
            let is_record = self.reader.read_record(&mut self.record).map_err(|e| e.to_string())?;
            let is_at_end = self.reader.position().byte() as usize == self.text.len();
            if !is_record || (is_at_end && self.goes_on) {
                self.count_to(start);
                return Ok(None);
            }
            let is_end = |b: &&u8| matches!(**b, b'\r' | b'\n');
            self.count_to(start + self.text[start..].iter().take_while(is_end).count());
            if filled(&self.record) > 0 {
                return Ok(Some((self.line, &self.record)));
            }
        }
    }

    /// Counts the lines up to a place.
    fn count_to(&mut self, place: usize) {
        for i in self.at..place {
            let pair = self.text[i] == b'\r' && self.text.get(i + 1) == Some(&b'\n');
            self.line += usize::from(matches!(self.text[i], b'\r' | b'\n') && !pair);
        }
        self.at = place;
    }
}

fn trimmed(cell: &str) -> String {
    cell.trim().to_owned()
}

/// The first records that are not blank, with their lines; `None` if the `input` must be read on for them.
fn beginning(input: &Input<'_>, delimiter: u8) -> std::result::Result<Option<Vec<Line>>, String> {
    let mut records = Records::of(input, delimiter, 1);
    let mut first = vec![];
    while first.len() < LONGEST_TOP {
        match records.next()? {
            Some((line, record)) => first.push((line, record.clone())),
            None if input.goes_on() => return Ok(None),
            None => break,
        }
    }
    Ok(Some(first))
}

/// The most frequent number of filled cells of the records that are not comments; the larger of equals.
fn width(records: &[Line]) -> usize {
    let records = records.iter().filter(|(_, record)| !is_comment(record));
    let mut widths: Vec<usize> =
        records.take(LOOKED_AT).map(|(_, record)| filled(record)).collect();
    widths.sort_unstable();
    widths.chunk_by(|a, b| a == b).max_by_key(|same| same.len()).map_or(1, |same| same[0])
}

/// Number of cells of a record, without empty ones at its end.
fn filled(record: &StringRecord) -> usize {
    (0..record.len()).rfind(|i| !record[*i].trim().is_empty()).map_or(0, |last| last + 1)
}

/// Whether a record is a comment. `#N/A` is not one, because Excel writes it for a missing value. A line of `#` is one.
fn is_comment(record: &StringRecord) -> bool {
    let first = record[0].trim();
    let is_line = first.bytes().all(|b| b == b'#');
    first.starts_with('#') && (is_line || number::word(first).is_none())
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

/// The columns. A column without a name is named after its place, and so are columns of one name, as in
/// `Conf (column 3)`. A column that repeats another is left out, with a note.
fn named(mut columns: Vec<Column>, notes: &mut Vec<String>) -> Vec<Column> {
    for (i, column) in columns.iter_mut().enumerate() {
        if column.name.is_empty() {
            column.name = format!("column {}", i + 1);
        }
    }
    let mut of_name: HashMap<String, Vec<usize>> = HashMap::with_capacity(columns.len());
    for (i, column) in columns.iter().enumerate() {
        of_name.entry(column.name.clone()).or_default().push(i);
    }
    if of_name.len() == columns.len() {
        return columns;
    }
    let mut repeated = HashSet::new();
    for places in of_name.into_values().filter(|places| places.len() > 1) {
        let first = &columns[places[0]];
        // Equal times, values or qualities may belong to different signals.
        let is_signal = role::of_rows(&first.name).is_none();
        let equal: Vec<usize> = places[1..]
            .iter()
            .copied()
            .filter(|i| is_signal && columns[*i].cells == first.cells)
            .collect();
        if places.len() > 1 + equal.len() {
            for i in places.iter().filter(|i| !equal.contains(i)) {
                columns[*i].name = format!("{} (column {})", columns[*i].name, i + 1);
            }
        }
        repeated.extend(equal);
    }
    let mut names: Vec<String> = repeated.iter().map(|i| columns[*i].name.clone()).collect();
    names.sort();
    names.dedup();
    for name in names {
        notes.push(format!(
            "the file has the column \"{name}\" twice, with the same cells; it is read once"
        ));
    }
    let mut place = 0;
    columns.retain(|_| {
        place += 1;
        !repeated.contains(&(place - 1))
    });
    columns
}

/// The sample time in s, from the lines above the table.
fn sample_time(attributes: &[(String, String)], origin: &str) -> Result<Option<f64>> {
    let is_it = |key: &str| {
        let key = key.to_ascii_lowercase().replace([' ', '-'], "_");
        matches!(&*key, "sample_time" | "sampling_time" | "sample_time_s" | "sampling_interval")
    };
    let Some((key, value)) = attributes.iter().find(|(key, _)| is_it(key)) else { return Ok(None) };
    let number = value.trim_end_matches(" s").trim_end_matches('s').trim();
    // Without neighbours, 1,500 may be 1.5 or 1500.
    let number = Some(number).filter(|number| !number.contains(','));
    match number.and_then(|number| number::parse(number, DecimalMark::Point)) {
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
    use sha2::{Digest, Sha256};
    use std::borrow::Cow;

    /// Texts that are longer than the header may be, with all that may stand at the border of two parts.
    fn texts() -> Vec<String> {
        let row = |k: usize, end: &str| {
            let (minute, second) = (k / 60, k % 60);
            format!("2025-03-01 00:{minute:02}:{second:02},{}.5,60{end}", 40 + k % 200)
        };
        let rows = |end: &str| -> String { (0..LONGEST_TOP + 60).map(|k| row(k, end)).collect() };
        let with = |header: &str, end: &str| format!("{header}{end}{}", rows(end));
        let plain = with("time,op,pv", "\n");
        vec![
            plain.clone(),
            with("time,op,pv", "\r\n"),
            with("time,op,pv", "\r"),
            with("time,op,pv", "\n\n\r\n"),
            plain.trim_end().to_owned(),
            plain.trim_end().trim_end_matches('0').to_owned(),
            format!("{plain}Total,9\n\nend of file\n"),
            format!("{plain}{plain}# a: comment\n{}", rows("\n")),
            format!("sep=;\n{}", plain.replace(',', ";")),
            plain.replace(",60", ",\"60\""),
            plain.replace("60\n", "\"6\r\n0\"\n"),
            plain.replace("55.5,60", "55.5"),
            plain.replace("time", "Zeit \u{e4}\u{20ac}").replace("60\n", "60 \u{1f600}\n"),
            plain.replace("0,239", "0,\"239"),
            format!("\n,,\n \n{plain}\n,,\n"),
            "no,table".to_owned(),
            " \n \r\n".to_owned(),
            format!("#datatype,dateTime,double\n{}", plain.replace("time,op", "_time,_value")),
        ]
    }

    #[test]
    fn a_file_read_in_parts_is_the_same() {
        let read = |input: Input<'_>, most| {
            let read = read_within(Budget::new(usize::MAX), most, input, "UTF-8", vec![], "f.csv");
            read.map_err(|error| error.to_string())
        };
        for text in texts() {
            let whole = read(Input::whole(Cow::Borrowed(&text)), usize::MAX);
            for chunk in [1, 3, 50] {
                let parted = read(Input::parted(text.as_bytes(), chunk), 10 * chunk);
                assert_eq!(parted, whole, "{chunk}: {text}");
            }
        }
        assert!(texts().iter().filter(|text| csv_of(text).is_ok()).count() > 12);
    }

    fn csv_of(text: &str) -> Result<CsvSheet> {
        super::read(text.as_bytes(), "f.csv")
    }

    #[test]
    fn only_large_text_in_utf_8_is_read_in_parts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f.csv");
        let plain = "time,op\n0,50 \u{b0}\n".repeat(3);
        let utf_16 = plain.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let latin = plain.chars().map(|c| c as u8).collect();
        for (bytes, expected) in [
            (plain.clone().into_bytes(), Some(&*plain)),
            (format!("\u{feff}{plain}").into_bytes(), Some(&*plain)),
            (utf_16, None),
            (latin, None),
            (b"PAR1,time".to_vec(), None),
            (b"time,op\n0,\0\n".to_vec(), None),
        ] {
            std::fs::write(&path, &bytes).unwrap();
            let large = input::large(&path, 0).unwrap();
            let read = large.map(|(mut input, sha256)| {
                while input.goes_on() {
                    input.pass(0).unwrap();
                }
                assert_eq!(sha256, format!("{:x}", Sha256::digest(&bytes)));
                input.text.into_owned()
            });
            assert_eq!(read.as_deref(), expected);
            assert!(input::large(&path, 1000).unwrap().is_none());
        }
    }

    #[test]
    fn what_would_take_too_much_is_refused_at_its_row() {
        let text = "t,op\n0,50\n1,51\n2,52\n";
        let row = 3 + 2 * texts::BESIDE;
        let within = |bytes| {
            let input = Input::whole(Cow::Borrowed(text));
            read_within(Budget::new(bytes), bytes, input, "UTF-8", vec![], "f.csv")
        };
        assert!(within(3 * row).is_ok());
        let message = within(2 * row).unwrap_err().to_string();
        assert!(message.starts_with("f.csv: row 4 would take more than"), "{message}");
    }
}
