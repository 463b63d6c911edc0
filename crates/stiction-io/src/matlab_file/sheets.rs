//! Finds the sheets in what a MATLAB file holds.

use super::{Fields, Message, Value};
use crate::sheet::{Cells, Column, Sheet};
use std::collections::BTreeMap;

/// Names of a number that is the time between samples, in s.
const SAMPLE_TIMES: [&str; 6] = ["ts", "dt", "tsamp", "sampling_time", "sample_time", "sampletime"];

/// Names of a column of times.
const TIMES: [&str; 5] = ["t", "time", "datenum", "date", "timestamp"];

/// MATLAB's days since the year 0 are about so many in 1642 to 2464.
const DATENUMS: std::ops::RangeInclusive<f64> = 6e5..=9e5;

/// Names of a cell array of the names of a matrix's columns.
const HEADERS: [&str; 6] = ["colheaders", "names", "tags", "columns", "headers", "varnames"];

/// A matrix with more columns is no table of signals.
const MAX_MATRIX_COLUMNS: usize = 64;

/// The sheets among `variables`.
pub(super) fn find(variables: &Fields, origin: &str) -> Result<Vec<Sheet>, Message> {
    let mut sheets = vec![];
    search(variables, String::new(), origin, &mut sheets);
    // A struct with a single vector may be one of settings, such as a pair of limits.
    if sheets.iter().any(|sheet| sheet.columns.len() > 1) {
        sheets.retain(|sheet| sheet.columns.len() > 1);
    }
    let unread = variables.iter().filter_map(|(name, value)| match value {
        Value::Other(what) => Some(format!("{name} is {what}; left out")),
        _ => None,
    });
    if let Some(sheet) = sheets.first_mut() {
        // The sheet of the variables themselves has said so already.
        if !sheet.part.is_empty() {
            unread.for_each(|text| note(sheet, text));
        }
        return Ok(sheets);
    }
    let names: Vec<_> = variables.iter().map(|(name, _)| format!("\"{name}\"")).collect();
    if names.is_empty() {
        return Err("has no variables; save some with save(..., '-v7')".to_owned());
    }
    let mut message = format!(
        "has no vectors of two or more numbers, alone or in a struct; its variables are {}",
        names.join(", ")
    );
    unread.for_each(|text| message += &format!("; {text}"));
    Err(message)
}

/// Appends the sheet that `fields` are, if they are one, and those within them.
fn search(fields: &Fields, part: String, origin: &str, sheets: &mut Vec<Sheet>) {
    sheets.extend(sheet(fields, &part, origin));
    for (name, value) in fields {
        let path = if part.is_empty() { name.clone() } else { format!("{part}.{name}") };
        within(value, path, origin, sheets);
    }
}

/// Appends the sheets within the `value` at `path`.
fn within(value: &Value, path: String, origin: &str, sheets: &mut Vec<Sheet>) {
    match value {
        Value::Structs(structs) => match &structs[..] {
            [only] => search(only, path, origin, sheets),
            several => {
                for (i, fields) in several.iter().enumerate() {
                    search(fields, format!("{path}({})", i + 1), origin, sheets);
                }
            }
        },
        Value::Cell(cells) => {
            for (i, cell) in cells.iter().enumerate() {
                if matches!(cell, Value::Structs(_) | Value::Cell(_)) {
                    within(cell, format!("{path}{{{}}}", i + 1), origin, sheets);
                }
            }
        }
        _ => {}
    }
}

/// The sheet that a struct is, if it has vectors.
fn sheet(fields: &Fields, part: &str, origin: &str) -> Option<Sheet> {
    let rows = usual_length(fields)?;
    let mut sheet = Sheet { origin: origin.to_owned(), part: part.to_owned(), ..Sheet::default() };
    for (name, value) in fields {
        match value {
            Value::Numbers { data, .. } if data.is_empty() => {}
            Value::Numbers { data, .. } if data.len() == 1 => {
                add_number(&mut sheet, name, data[0], rows)
            }
            Value::Numbers { rows: r, cols, data } => match length(*r, *cols) {
                Some(length) if length == rows => {
                    let names = column_names(name, data.len() / rows, fields);
                    for (name, data) in names.into_iter().zip(data.chunks_exact(rows)) {
                        add_column(&mut sheet, name, Cells::Numbers(data.to_vec()));
                    }
                }
                Some(length) => note(
                    &mut sheet,
                    format!("{name} has {length} values where most have {rows}; left out"),
                ),
                None => note(
                    &mut sheet,
                    format!("{name} is a matrix of {r} rows and {cols} columns; left out"),
                ),
            },
            Value::Text(text) if text.is_empty() => {}
            Value::Text(text) => sheet.attributes.push((name.clone(), text.clone())),
            Value::Cell(cells) if cells.is_empty() => {}
            Value::Cell(cells) => match texts(cells) {
                Some(texts) if texts.len() == rows => {
                    add_column(&mut sheet, name.clone(), Cells::Text(texts));
                }
                Some(texts) => sheet.attributes.push((name.clone(), texts.join("; "))),
                None if cells.iter().any(|cell| matches!(cell, Value::Structs(_))) => {}
                None => note(&mut sheet, format!("{name} is a cell array; left out")),
            },
            // They have sheets of their own.
            Value::Structs(_) => {}
            Value::Other(what) => note(&mut sheet, format!("{name} is {what}; left out")),
        }
    }
    Some(sheet)
}

/// How many values the columns of a matrix have: a vector is one, whether it stands or lies. None if
/// the matrix is no table of signals.
fn length(rows: usize, cols: usize) -> Option<usize> {
    match (rows, cols) {
        (1, length) | (length, 1) => Some(length),
        _ => (rows > cols && cols <= MAX_MATRIX_COLUMNS).then_some(rows),
    }
}

/// The length that most columns of numbers have; the greater of equally frequent ones, and two only
/// if there is no other, for pairs are limits and ranges.
fn usual_length(fields: &Fields) -> Option<usize> {
    let mut counts = BTreeMap::<usize, usize>::new();
    for (_, value) in fields {
        if let Value::Numbers { rows, cols, data } = value
            // A matrix of many rows and no column has a length, too.
            && !data.is_empty()
            && let Some(length) = length(*rows, *cols).filter(|length| *length >= 2)
        {
            *counts.entry(length).or_default() += data.len() / length;
        }
    }
    counts.into_iter().max_by_key(|(length, count)| (*length > 2, *count, *length)).map(|(n, _)| n)
}

/// What the columns of a matrix are called.
fn column_names(name: &str, count: usize, fields: &Fields) -> Vec<String> {
    if count == 1 {
        return vec![name.to_owned()];
    }
    let header = |(name, value): &(String, Value)| match value {
        Value::Cell(cells) if HEADERS.iter().any(|known| name.eq_ignore_ascii_case(known)) => {
            texts(cells).filter(|texts| texts.len() == count)
        }
        _ => None,
    };
    let numbered = || (1..=count).map(|k| format!("{name}(:,{k})")).collect();
    fields.iter().find_map(header).unwrap_or_else(numbered)
}

/// The cells as text, if that is what they all are.
fn texts(cells: &[Value]) -> Option<Vec<String>> {
    let text = |cell: &Value| match cell {
        Value::Text(text) => Some(text.trim().to_owned()),
        // An empty cell.
        Value::Numbers { data, .. } if data.is_empty() => Some(String::new()),
        _ => None,
    };
    cells.iter().map(text).collect()
}

fn note(sheet: &mut Sheet, text: String) {
    sheet.attributes.push(("note".to_owned(), text));
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
        note(sheet, format!("{name} is a single number, held"));
        add_column(sheet, name.to_owned(), Cells::Numbers(vec![number; rows]));
    }
}
