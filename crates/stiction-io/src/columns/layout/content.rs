//! Uses the cells of a column or tag to recognise its role.

use super::plan::Place;
use crate::cells::mode::{self, Codes, ModeCell};
use crate::cells::number::{self, DecimalMark};
use crate::cells::quality;
use crate::columns::role::Signal;
use crate::sheet::{Cells, Sheet, Viewed};
use stiction_recording::recording::{Mode, Quality};

/// The cells of the names of a sheet, either columns or tags.
pub struct Content<'a> {
    /// The sheet.
    pub sheet: &'a Sheet,
    /// Where its names are.
    pub place: &'a Place,
}

impl Content<'_> {
    /// Whether all cells of `name` satisfy one of the tests for their kind. Without cells it is false.
    fn all(&self, name: usize, text: impl Fn(&str) -> bool, number: impl Fn(f64) -> bool) -> bool {
        let (column, rows) = match self.place {
            Place::Columns => (name, None),
            Place::Rows { tags, value, .. } => (*value, Some(&tags[name].rows)),
        };
        let cells = self.sheet.columns[column].cells.view();
        let is = |row: usize| match &cells {
            Viewed::Text(cells) => text(&cells[row]),
            Viewed::Numbers(cells) => number(cells[row]),
            Viewed::Times(_) => false,
        };
        match rows {
            Some(rows) => rows.iter().all(|row| is(*row)),
            None => (0..self.sheet.columns[column].cells.len()).all(is),
        }
    }

    fn some(&self, name: usize, text: impl Fn(&str) -> bool, number: impl Fn(f64) -> bool) -> bool {
        !self.all(name, |cell| !text(cell), |cell| !number(cell))
    }

    /// Whether `name` holds numbers, possibly with bad or missing ones.
    pub fn is_numeric(&self, name: usize) -> bool {
        let by = |mark| {
            let is = move |cell: &str| number::parse(cell, mark).is_some();
            self.some(name, is, |cell| !cell.is_nan())
                && self.all(name, |cell| is(cell) || number::word(cell).is_some(), |_| true)
        };
        by(DecimalMark::Point) || by(DecimalMark::Comma)
    }

    /// The least and the greatest number of `name`.
    pub fn ends(&self, name: usize) -> (f64, f64) {
        let ends = std::cell::Cell::new((f64::INFINITY, f64::NEG_INFINITY));
        let take = |number: f64| {
            let (low, high) = ends.get();
            ends.set((low.min(number), high.max(number)));
            true
        };
        let parse = |cell: &str| {
            number::parse(cell, DecimalMark::Point)
                .or_else(|| number::parse(cell, DecimalMark::Comma))
        };
        self.all(name, |cell| take(parse(cell).unwrap_or(f64::NAN)), take);
        ends.get()
    }

    /// Whether an unused `name` can be `signal` by its numbers: a mode is a switch, and only an SP may rest. Some of
    /// its values are between the values of `near`.
    pub fn can_be(&self, name: usize, signal: Signal, near: (f64, f64)) -> bool {
        if self.is_switch(name) != (signal == Signal::Mode) {
            return false;
        }
        let (low, high) = self.ends(name);
        let may_rest = signal == Signal::Sp || self.sheet.len() == 1;
        (low < high || may_rest) && high >= near.0 && low <= near.1
    }

    /// Whether `name` holds the positions of a switch, possibly with bad or missing ones.
    pub fn is_switch(&self, name: usize) -> bool {
        let is = |cell: &str| mode::is_on(cell).is_some();
        let is_number = |cell: f64| cell == 0.0 || cell == 1.0;
        self.some(name, is, is_number)
            && self.all(
                name,
                |cell| is(cell) || number::word(cell).is_some(),
                |cell| cell.is_nan() || is_number(cell),
            )
    }

    /// Whether `name` holds words of modes, possibly with missing ones. Single letters count only if they show both
    /// automatic and manual, because a single letter may be a unit.
    pub fn is_modes(&self, name: usize) -> bool {
        let mode = |cell: &str| mode::of_cell(cell, &[], Codes::Common, DecimalMark::Point);
        let is = |cell: &str, of: Mode| mode(cell) == Some(ModeCell::Mode(of));
        let some = |of: Mode, least| {
            self.some(name, |cell| cell.len() >= least && is(cell, of), |_| false)
        };
        self.all(
            name,
            |cell| matches!(mode(cell), Some(ModeCell::Mode(_) | ModeCell::Nothing)),
            |_| false,
        ) && ([Mode::Automatic, Mode::Manual, Mode::Cascade].into_iter().any(|of| some(of, 2))
            || (some(Mode::Automatic, 1) && some(Mode::Manual, 1)))
    }

    /// Whether `name`, written as `title`, holds words of qualities, or true and false, that are not all good.
    pub fn is_qualities(&self, name: usize, title: &str) -> bool {
        let said = |cell: &str| quality::of_text(title, cell);
        let is_fault = |cell: &str| {
            cell.len() > 1 && matches!(said(cell), Some(Quality::Bad | Quality::Uncertain))
        };
        self.all(name, |cell| said(cell).is_some(), |_| false)
            && self.some(name, is_fault, |_| false)
    }

    /// Whether `name` only counts rows or holds times.
    pub fn is_about_rows(&self, name: usize) -> bool {
        let Place::Columns = self.place else { return false };
        let counts = |value: Option<f64>, row: usize, first: f64| value == Some(first + row as f64);
        let whole = |cell: &str| number::parse(cell, DecimalMark::Point);
        match &self.sheet.columns[name].cells {
            Cells::Times { .. } => true,
            Cells::Numbers(cells) => {
                let first = cells.first().copied().unwrap_or(f64::NAN);
                matches!(first, 0.0 | 1.0)
                    && cells.iter().enumerate().all(|(row, cell)| counts(Some(*cell), row, first))
            }
            Cells::Text(cells) => {
                let cells = cells.view();
                let first = cells.first().and_then(whole).unwrap_or(f64::NAN);
                matches!(first, 0.0 | 1.0)
                    && cells.iter().enumerate().all(|(row, cell)| counts(whole(cell), row, first))
            }
        }
    }
}
