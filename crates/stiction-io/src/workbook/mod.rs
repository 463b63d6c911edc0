//! Sheets from the workbooks of Excel (`.xlsx`, `.xlsm`, `.xlsb`, `.xls`) and OpenDocument (`.ods`).
//!
//! Each sheet of a workbook is read like the CSV file that a spreadsheet program would save, with rows at the same
//! lines. So headers, units and titles are found by one code. Then the numbers and times of the workbook replace their
//! text (`grid`). Merged cells are resolved before (`merged`), and `limits` refuses damaged files that would take too
//! much memory.

mod grid;
mod limits;
mod merged;

use crate::budget::{Budget, guarded};
use crate::csv;
use crate::error::{Error, Result};
use crate::sheet::Sheet;
use calamine::{
    Data, Dimensions, Ods, OdsError, Range, Reader, SheetType, Xls, XlsError, Xlsb, Xlsx, XlsxError,
};
use grid::Grid;
use std::io::Cursor;

/// The remedy for a workbook that cannot be read.
const SAVE: &str = "open it, and save it as .xlsx again, or the sheet as CSV";

/// The sheets of a workbook that contain tables, and notes on the remaining sheets. `origin` is the name of the file in
/// errors.
///
/// The `part` of each sheet is its name in the workbook. Columns of numbers and of times become such columns, whatever
/// their format on screen. Days count from 1900 or 1904, as the workbook says. Times of day stay text, and durations
/// become seconds. Error values such as `#N/A` become words, as in a CSV file.
///
/// # Errors
/// If the workbook is damaged or encrypted, or no sheet holds a table.
///
/// # Limits
/// Formulas are not calculated. A cell has the value that was saved. Cells that would take much more memory than the
/// file are refused.
pub fn workbook_sheets(bytes: &[u8], origin: &str) -> Result<(Vec<Sheet>, Vec<String>)> {
    let wrong = |message: String| Error::Table { origin: origin.to_owned(), message };
    let mut budget = Budget::of(bytes.len());
    let kind = limits::check(bytes, &mut budget).map_err(wrong)?;
    let grids = guarded(|| kind.grids(bytes, &mut budget))
        .unwrap_or_else(|| Err(unread("its contents are inconsistent")))
        .map_err(wrong)?;
    let (mut sheets, mut notes, mut refusal) = (vec![], vec![], None);
    let several = grids.len() > 1;
    for (name, grid) in grids {
        match table(&name, grid, origin) {
            Ok((sheet, about)) => {
                sheets.push(sheet);
                notes.extend(about.into_iter().map(|note| match several {
                    true => format!("sheet \"{name}\": {note}"),
                    false => note,
                }));
            }
            Err(error) => {
                notes.push(format!("sheet \"{name}\" holds no table and is not read"));
                refusal.get_or_insert(error);
            }
        }
    }
    match refusal {
        Some(error) if sheets.is_empty() => Err(error),
        None if sheets.is_empty() => Err(wrong("has no sheets with cells".to_owned())),
        _ => Ok((sheets, notes)),
    }
}

/// The table in a sheet, and notes on it.
fn table(name: &str, grid: Grid, origin: &str) -> Result<(Sheet, Vec<String>)> {
    let read = csv::read(grid.text().as_bytes(), &format!("{origin}, sheet \"{name}\""))?;
    let (mut sheet, mut notes) = (read.sheet, read.notes);
    name.clone_into(&mut sheet.part);
    notes.extend(grid.restore(&mut sheet));
    Ok((sheet, notes))
}

/// The kinds of workbooks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Xlsx,
    Xlsb,
    Xls,
    Ods,
}

type Grids = Vec<(String, Grid)>;

impl Kind {
    /// The cells of all sheets.
    fn grids(self, bytes: &[u8], budget: &mut Budget) -> std::result::Result<Grids, String> {
        let input = Cursor::new(bytes);
        let mut grids = vec![];
        match self {
            Self::Xlsx => {
                let mut book = Xlsx::new(input).map_err(|error| match error {
                    XlsxError::Password => limits::PASSWORD.to_owned(),
                    error => unread(error),
                })?;
                let is_1904 = book.has_1904_epoch();
                for name in worksheets(&book) {
                    let about = |error| of_sheet(&name, error);
                    let merged = book.merge_cells_by_sheet_name(&name).map_err(about)?;
                    let mut grid = Grid::new(is_1904);
                    let mut cells = book.worksheet_cells_reader(&name).map_err(about)?;
                    while let Some(cell) = cells.next_cell().map_err(about)? {
                        grid.set(cell.get_position(), cell.get_value().clone().into(), budget)?;
                    }
                    grids.push((name, merged::resolved(grid, &merged)));
                }
            }
            Self::Xlsb => {
                let mut book = Xlsb::new(input).map_err(unread)?;
                let is_1904 = book.has_1904_epoch();
                for name in worksheets(&book) {
                    let about = |error| of_sheet(&name, error);
                    let mut grid = Grid::new(is_1904);
                    let mut cells = book.worksheet_cells_reader(&name).map_err(about)?;
                    while let Some(cell) = cells.next_cell().map_err(about)? {
                        grid.set(cell.get_position(), cell.get_value().clone().into(), budget)?;
                    }
                    let spans = merged::apparent(&grid);
                    grids.push((name, merged::resolved(grid, &spans)));
                }
            }
            Self::Xls => {
                let mut book = Xls::new(input).map_err(|error| match error {
                    XlsError::Password => limits::PASSWORD.to_owned(),
                    error => unread(error),
                })?;
                let is_1904 = book.has_1904_epoch();
                for name in worksheets(&book) {
                    let range = book.worksheet_range(&name).map_err(|e| of_sheet(&name, e))?;
                    let merged: Vec<Dimensions> =
                        book.merge_cells_by_sheet_name(&name).map_err(|e| of_sheet(&name, e))?;
                    let grid = of_range(&range, is_1904, budget)?;
                    grids.push((name, merged::resolved(grid, &merged)));
                }
            }
            Self::Ods => {
                let mut book = Ods::new(input).map_err(|error| match error {
                    OdsError::Password => limits::PASSWORD.to_owned(),
                    error => unread(error),
                })?;
                for name in worksheets(&book) {
                    let range = book.worksheet_range(&name).map_err(|e| of_sheet(&name, e))?;
                    let grid = of_range(&range, false, budget)?;
                    let spans = merged::apparent(&grid);
                    grids.push((name, merged::resolved(grid, &spans)));
                }
            }
        }
        grids.retain(|(_, grid)| !grid.is_empty());
        Ok(grids)
    }
}

/// The names of the sheets of cells. Others are charts and macros.
fn worksheets<'b>(book: &impl Reader<Cursor<&'b [u8]>>) -> Vec<String> {
    let cells = book.sheets_metadata().iter().filter(|sheet| sheet.typ == SheetType::WorkSheet);
    cells.map(|sheet| sheet.name.clone()).collect()
}

fn of_range(
    range: &Range<Data>,
    is_1904: bool,
    budget: &mut Budget,
) -> std::result::Result<Grid, String> {
    let mut grid = Grid::new(is_1904);
    let (top, left) = range.start().unwrap_or_default();
    for (row, column, value) in range.used_cells() {
        grid.set((top + row as u32, left + column as u32), value.clone(), budget)?;
    }
    Ok(grid)
}

/// The message for an error of a workbook.
fn unread(error: impl std::fmt::Display) -> String {
    format!("cannot be read as a workbook ({error}); {SAVE}")
}

fn of_sheet(name: &str, error: impl std::fmt::Display) -> String {
    format!("sheet \"{name}\" cannot be read ({error}); {SAVE}")
}
