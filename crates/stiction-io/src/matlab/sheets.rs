//! Finds the sheets in the content of a MATLAB file.

use super::simulink;
use super::value::{Fields, Message, Value};
use crate::columns::role::{self, Role};
use crate::names::list;
use crate::sheet::{Cells, Column, LeftOut, Sheet};
use std::collections::{BTreeMap, HashMap};

/// Names of a number that is the time between samples, in s.
const SAMPLE_TIMES: [&str; 6] = ["ts", "dt", "tsamp", "sampling_time", "sample_time", "sampletime"];

/// Names of a column of times.
const TIMES: [&str; 5] = ["t", "time", "datenum", "date", "timestamp"];

/// Range of MATLAB's days since the year 0, from 1642 to 2464.
const DATENUMS: std::ops::RangeInclusive<f64> = 6e5..=9e5;

/// Names of a cell array of the names of a matrix's columns.
const HEADERS: [&str; 6] = ["colheaders", "names", "tags", "columns", "headers", "varnames"];

/// Reasons why data without samples are not a column.
const EMPTY: &str = "is empty";
const SINGLE: &str = "is a single number";

/// Numbers of names and of reasons in the message that nothing could be read.
const MOST_NAMES: usize = 5;
const MOST_REASONS: usize = 3;

/// A matrix with more columns is not a table of signals.
const MAX_MATRIX_COLUMNS: usize = 64;

/// The sheets among `variables`.
pub(super) fn find<'o>(variables: &'o Fields, origin: &'o str) -> Result<Vec<Sheet>, Message> {
    let times = variables.iter().find_map(|(name, value)| match value {
        Value::Numbers { data, .. } if name == "tout" => Some(&data[..]),
        _ => None,
    });
    let mut found = Found { origin, times, sheets: vec![], loose: vec![] };
    found.search(variables, String::new());
    let Found { mut sheets, mut loose, .. } = found;
    // A struct with a single vector may hold settings, such as a pair of limits.
    if sheets.iter().any(|sheet| sheet.columns.len() > 1) {
        for sheet in sheets.extract_if(.., |sheet| sheet.columns.len() < 2) {
            loose.push((sheet.part, "is a struct with a single vector".to_owned()));
        }
    }
    sheets.iter_mut().for_each(name_apart);
    if let Some(sheet) = sheets.first_mut() {
        let note = |(path, why): (String, String)| format!("{path} {why} and is not used");
        sheet.notes.extend(loose.into_iter().map(note));
        return Ok(sheets);
    }
    let names: Vec<&str> = variables.iter().map(|(name, _)| &**name).collect();
    if names.is_empty() {
        return Err("has no variables; save some with save(..., '-v7')".to_owned());
    }
    let mut message = format!(
        "has no vectors of two or more numbers, alone or in a struct; its variables are {}",
        few(&names)
    );
    let mut reasons: Vec<(&str, Vec<&str>)> = vec![];
    for (path, why) in &loose {
        match reasons.iter_mut().find(|(reason, _)| reason == why) {
            Some((_, paths)) => paths.push(path),
            None => reasons.push((why.as_str(), vec![path.as_str()])),
        }
    }
    for (why, paths) in reasons.iter().take(MOST_REASONS) {
        message += &match &paths[..] {
            [only] => format!("; {only} {why}"),
            several => format!("; {}: {why}", few(several)),
        };
    }
    if reasons.len() > MOST_REASONS {
        message += &format!(
            "; {} more have other reasons",
            loose.len()
                - reasons[..MOST_REASONS].iter().map(|(_, paths)| paths.len()).sum::<usize>()
        );
    }
    Err(message)
}

/// The first names of a list.
fn few(names: &[&str]) -> String {
    match names.len().saturating_sub(MOST_NAMES) {
        0 => list(names),
        more => format!("{} and {more} more", list(&names[..MOST_NAMES])),
    }
}

/// Numbers the columns that share a name, so that each has its own name.
fn name_apart(sheet: &mut Sheet) {
    let mut seen: HashMap<String, usize> = HashMap::new();
    for column in &mut sheet.columns {
        let count = seen.entry(column.name.clone()).or_default();
        *count += 1;
        if *count > 1 {
            column.name = format!("{}({count})", column.name);
        }
    }
}

/// The sheets found in a file.
struct Found<'o> {
    origin: &'o str,
    /// The times of a simulation, which Simulink saves beside its signals.
    times: Option<&'o [f64]>,
    sheets: Vec<Sheet>,
    /// Data left out where there is no sheet, as paths with reasons.
    loose: Vec<(String, String)>,
}

impl Found<'_> {
    /// Appends the sheet of `fields`, if they form a sheet, and the sheets of nested structs.
    fn search(&mut self, fields: &Fields, part: String) {
        if let Some(sheet) = simulink::sheet(fields, &part, self.origin, self.times) {
            self.sheets.push(sheet);
            return;
        }
        let path = |name: &str| match &*part {
            "" => name.to_owned(),
            part => format!("{part}.{name}"),
        };
        match sheet(fields, &part, self.origin) {
            Some(sheet) => self.sheets.push(sheet),
            None => {
                let other = fields.iter().filter_map(|(name, value)| match value {
                    Value::Other(what) => Some((path(name), format!("is {what}"))),
                    _ => None,
                });
                self.loose.extend(other);
            }
        }
        for (name, value) in fields {
            self.within(value, path(name));
        }
    }

    /// Appends the sheets within the `value` at `path`.
    fn within(&mut self, value: &Value, path: String) {
        match value {
            Value::Structs(structs) => match &structs[..] {
                [only] => self.search(only, path),
                several => {
                    for (i, fields) in several.iter().enumerate() {
                        self.search(fields, format!("{path}({})", i + 1));
                    }
                }
            },
            Value::Cell(cells) => {
                for (i, cell) in cells.iter().enumerate() {
                    if matches!(cell, Value::Structs(_) | Value::Cell(_)) {
                        self.within(cell, format!("{path}{{{}}}", i + 1));
                    }
                }
            }
            _ => {}
        }
    }
}

/// The sheet of a struct, if it has vectors.
fn sheet(fields: &Fields, part: &str, origin: &str) -> Option<Sheet> {
    let rows = usual_length(fields)?;
    let mut sheet = Sheet { origin: origin.to_owned(), part: part.to_owned(), ..Sheet::default() };
    let headers = headers(fields);
    for (name, value) in fields {
        match value {
            Value::Numbers { data, .. } if data.is_empty() => leave_out(&mut sheet, name, EMPTY),
            Value::Numbers { data, .. } if data.len() == 1 => {
                add_number(&mut sheet, name, data[0], rows)
            }
            Value::Numbers { rows: r, cols, data } => match length(*r, *cols) {
                Some(length) if length == rows => {
                    let names = column_names(name, data.len() / rows, &headers);
                    for (name, data) in names.into_iter().zip(data.chunks_exact(rows)) {
                        add_column(&mut sheet, name, Cells::Numbers(data.to_vec()));
                    }
                }
                Some(length) => {
                    let why = format!("has {length} values where most have {rows}");
                    leave_out(&mut sheet, name, &why);
                }
                None => {
                    let why = format!("is a matrix of {r} rows and {cols} columns, not a vector");
                    leave_out(&mut sheet, name, &why);
                }
            },
            // An empty comment was never a signal, unless it has the name of one.
            Value::Text(text) if text.is_empty() => leave_out_signal(&mut sheet, name, EMPTY),
            Value::Text(text) => sheet.attributes.push((name.clone(), text.clone())),
            Value::Cell(cells) if cells.is_empty() => leave_out_signal(&mut sheet, name, EMPTY),
            Value::Cell(cells) => match texts(cells) {
                Some(texts) if texts.len() == rows => {
                    add_column(
                        &mut sheet,
                        name.clone(),
                        Cells::Text(texts.iter().map(|text| &**text).collect()),
                    );
                }
                Some(texts) => {
                    let why = format!("has {} texts where most have {rows}", texts.len());
                    leave_out_signal(&mut sheet, name, &why);
                    sheet.attributes.push((name.clone(), texts.join("; ")));
                }
                None if cells.iter().any(|cell| matches!(cell, Value::Structs(_))) => {}
                None => leave_out(&mut sheet, name, "is a cell array"),
            },
            // They have sheets of their own.
            Value::Structs(structs) if !structs.is_empty() => {}
            Value::Structs(_) => leave_out_signal(&mut sheet, name, EMPTY),
            Value::Other(what) => leave_out(&mut sheet, name, &format!("is {what}")),
        }
    }
    Some(sheet)
}

/// The number of values in the columns of a matrix. A row vector counts as a column. None if the matrix is not a
/// table of signals.
fn length(rows: usize, cols: usize) -> Option<usize> {
    match (rows, cols) {
        (1, length) | (length, 1) => Some(length),
        _ => (rows > cols && cols <= MAX_MATRIX_COLUMNS).then_some(rows),
    }
}

/// The length of most columns of numbers; the greater of equally frequent ones. The length two counts only if there
/// is no other, because pairs are limits and ranges.
fn usual_length(fields: &Fields) -> Option<usize> {
    let mut counts = BTreeMap::<usize, usize>::new();
    for (_, value) in fields {
        if let Value::Numbers { rows, cols, data } = value
            // A matrix with many rows and no column has a length, too.
            && !data.is_empty()
            && let Some(length) = length(*rows, *cols).filter(|length| *length >= 2)
        {
            *counts.entry(length).or_default() += data.len() / length;
        }
    }
    counts.into_iter().max_by_key(|(length, count)| (*length > 2, *count, *length)).map(|(n, _)| n)
}

/// The names of columns beside matrices, by their number.
fn headers(fields: &Fields) -> HashMap<usize, Vec<String>> {
    let mut headers = HashMap::new();
    for (name, value) in fields {
        if let Value::Cell(cells) = value
            && HEADERS.iter().any(|known| name.eq_ignore_ascii_case(known))
            && let Some(texts) = texts(cells)
        {
            headers.entry(texts.len()).or_insert(texts);
        }
    }
    headers
}

/// The names of the columns of a matrix.
fn column_names(name: &str, count: usize, headers: &HashMap<usize, Vec<String>>) -> Vec<String> {
    if count == 1 {
        return vec![name.to_owned()];
    }
    let numbered = || (1..=count).map(|k| format!("{name}(:,{k})")).collect();
    headers.get(&count).cloned().unwrap_or_else(numbered)
}

/// The cells as text, if all are text.
fn texts(cells: &[Value]) -> Option<Vec<String>> {
    let text = |cell: &Value| match cell {
        Value::Text(text) => Some(text.trim().to_owned()),
        // An empty cell.
        Value::Numbers { data, .. } if data.is_empty() => Some(String::new()),
        _ => None,
    };
    cells.iter().map(text).collect()
}

/// Leaves out data that are unusable but have the name of a signal.
fn leave_out_signal(sheet: &mut Sheet, name: &str, why: &str) {
    if matches!(role::split(name, &[]), Some(role::Split { role: Role::Signal(_), .. })) {
        leave_out(sheet, name, why);
    }
}

fn leave_out(sheet: &mut Sheet, name: &str, why: &str) {
    let holds_samples = !matches!(why, EMPTY | SINGLE);
    sheet.left_out.push(LeftOut { name: name.to_owned(), why: why.to_owned(), holds_samples });
}

fn add_column(sheet: &mut Sheet, name: String, cells: Cells) {
    let is_time = TIMES.iter().any(|known| name.eq_ignore_ascii_case(known));
    if let Cells::Numbers(numbers) = &cells
        && is_time
        && numbers.iter().all(|t| DATENUMS.contains(t))
    {
        sheet.attributes.push(("datenum".to_owned(), name.clone()));
    }
    sheet.columns.push(Column { name: name.trim().to_owned(), unit: None, cells });
}

fn add_number(sheet: &mut Sheet, name: &str, number: f64, rows: usize) {
    let is_sample_time = SAMPLE_TIMES.iter().any(|known| name.eq_ignore_ascii_case(known));
    if is_sample_time && sheet.sample_time.is_none() {
        sheet.sample_time = Some(number);
        return;
    }
    sheet.attributes.push((name.to_owned(), number.to_string()));
    if name.eq_ignore_ascii_case("SP") {
        sheet.notes.push(format!("{name} is a single number, used for the whole recording"));
        add_column(sheet, name.to_owned(), Cells::Numbers(vec![number; rows]));
    } else {
        leave_out_signal(sheet, name, SINGLE);
    }
}
