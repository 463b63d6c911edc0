//! Chooses the parts of a file that are read, such as the sheets of a workbook.

use crate::columns::layout::{self, side_by_side};
use crate::columns::options::ReadOptions;
use crate::error::{Error, Result};
use crate::names::list;
use crate::remedy::Remedy;
use crate::sheet::Sheet;

/// The part that the user chooses, or all parts.
///
/// # Errors
/// If there is no such part.
pub(super) fn chosen(
    mut sheets: Vec<Sheet>,
    origin: &str,
    options: &ReadOptions,
) -> Result<Vec<Sheet>> {
    let Some(name) = &options.part else { return Ok(sheets) };
    let parts: Vec<String> = sheets.iter().map(|sheet| sheet.part.clone()).collect();
    let exact = parts.contains(name);
    sheets.retain(|sheet| match exact {
        true => sheet.part == *name,
        false => sheet.part.to_lowercase() == name.trim().to_lowercase(),
    });
    if !sheets.is_empty() {
        return Ok(sheets);
    }
    let parts: Vec<&str> =
        parts.iter().map(|part| &**part).filter(|part| !part.is_empty()).collect();
    let message = match &parts[..] {
        [] => "has no sheets to choose from; leave out the name of the sheet".to_owned(),
        parts => format!("has no sheet \"{name}\" with a table; its sheets are {}", list(parts)),
    };
    Err(Error::Table { origin: origin.to_owned(), message })
}

/// The sheets of a workbook with loops and times, and notes on the remaining sheets. If no sheet contains a loop, all
/// sheets are returned.
///
/// # Errors
/// If no sheet has a loop, and a column that the user names is missing in all, or names are in conflict.
pub(super) fn holding_loops(
    sheets: &[Sheet],
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<Sheet>> {
    let (mut holding, mut timeless, mut others, mut refusal) = (vec![], vec![], vec![], None);
    for sheet in sheets {
        let not_read =
            |lacks: &str| format!("sheet \"{}\" has no {lacks} and is not read", sheet.part);
        let unfolded = side_by_side::unfold(sheet, options);
        let (seen, own) = unfolded.as_ref().map_or((sheet, options), |u| (&u.sheet, &u.options));
        match layout::recognise(seen, own) {
            Ok(plan) if plan.loops.is_empty() => others.push(not_read("column known as OP")),
            Ok(plan)
                if plan.time.or(plan.date).is_none()
                    && own.sample_time.or(seen.sample_time).is_none() =>
            {
                timeless.push(not_read("column of times"));
            }
            Ok(_) => holding.push(sheet.clone()),
            Err(error) => {
                others.push(format!("sheet \"{}\" is not read: {error}", sheet.part));
                refusal.get_or_insert(error);
            }
        }
    }
    if let [first, _, ..] = &holding[..] {
        let names: Vec<&str> = holding.iter().map(|sheet| &*sheet.part).collect();
        others.push(format!(
            "the sheets {} are read, each with its own loops; for a single one, give {}",
            list(&names),
            options.wording.of(Remedy::Part(first.part.clone()))
        ));
    }
    match refusal {
        Some(error) if holding.is_empty() => Err(error),
        _ if holding.is_empty() => Ok(sheets.to_vec()),
        _ => {
            notes.extend(timeless.into_iter().chain(others));
            Ok(holding)
        }
    }
}

/// The parts of a file that have the columns that the user names, and notes on the remaining parts.
///
/// # Errors
/// If no part has these columns.
pub(super) fn understood(
    sheets: &[Sheet],
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<Sheet>> {
    let (mut understood, mut others, mut refusal) = (vec![], vec![], None);
    for sheet in sheets {
        match layout::recognise(sheet, options) {
            Ok(_) => understood.push(sheet.clone()),
            Err(error) => {
                let part = match &*sheet.part {
                    "" => "the part of variables outside of structs",
                    part => part,
                };
                others.push(format!("{part} is not read: {error}"));
                refusal.get_or_insert(error);
            }
        }
    }
    match refusal {
        Some(error) if understood.is_empty() => Err(error),
        _ => {
            notes.extend(others);
            Ok(understood)
        }
    }
}
