//! The common result of all file formats: named columns of cells, not yet interpreted.

use crate::texts::{Texts, View};
use std::borrow::Cow;

/// A table from a file of any format.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sheet {
    /// The name of the file in messages.
    pub origin: String,
    /// The part of the file, such as `cdata.chemicals.loop2` of a MATLAB file; empty if the file has only one.
    pub part: String,
    /// The columns in the order of the file, all of one length.
    pub columns: Vec<Column>,
    /// Time between rows in s, if the file gives it beside the columns.
    pub sample_time: Option<f64>,
    /// Other information of the file on the whole table, such as `("type", "1")`.
    pub attributes: Vec<(String, String)>,
    /// Data of the file that could not become a column.
    pub left_out: Vec<LeftOut>,
    /// Notes for the user on how the columns were made.
    pub notes: Vec<String>,
    /// The row in the file of each cell of a column, from 1, as a spreadsheet or editor counts. It is empty if rows
    /// have no numbers of their own, and then the index from 1 is used.
    pub rows: Vec<usize>,
}

/// Data that could not become a column. They are listed, not dropped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Name.
    pub name: String,
    /// The reason, as the end of a sentence that begins with the name.
    pub why: String,
    /// Whether they hold samples, or could. Empty data and single numbers do not.
    pub holds_samples: bool,
}

/// A named column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name, trimmed.
    pub name: String,
    /// Unit, if the file gives one.
    pub unit: Option<String>,
    /// Cells.
    pub cells: Cells,
}

/// The cells of a column, as the format stores them.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Numbers, with NaN for missing ones.
    Numbers(Vec<f64>),
    /// Text as written, empty if missing.
    Text(Texts),
    /// Times, s since 1970-01-01, with NaN for missing ones. Times without a zone are local.
    Times {
        /// The times.
        seconds: Vec<f64>,
        /// Whether they are UTC. Otherwise they are local times of an unknown zone.
        utc: bool,
    },
}

/// The cells of a column, to be read row by row.
#[derive(Debug)]
pub(crate) enum Viewed<'a> {
    Numbers(&'a [f64]),
    Text(View<'a>),
    Times(&'a [f64]),
}

impl Viewed<'_> {
    /// A cell as text, empty if missing.
    pub(crate) fn text(&self, row: usize) -> Cow<'_, str> {
        match self {
            Self::Text(cells) => Cow::Borrowed(&cells[row]),
            Self::Numbers(numbers) | Self::Times(numbers) if numbers[row].is_nan() => {
                Cow::Borrowed("")
            }
            Self::Numbers(numbers) | Self::Times(numbers) => Cow::Owned(numbers[row].to_string()),
        }
    }
}

impl Cells {
    /// The cells, fetched if they are stored.
    pub(crate) fn view(&self) -> Viewed<'_> {
        match self {
            Self::Numbers(numbers) => Viewed::Numbers(numbers),
            Self::Text(texts) => Viewed::Text(texts.view()),
            Self::Times { seconds, .. } => Viewed::Times(seconds),
        }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(cells) => cells.len(),
            Self::Text(cells) => cells.len(),
            Self::Times { seconds, .. } => seconds.len(),
        }
    }

    /// Whether there are no cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Sheet {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, |column| column.cells.len())
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Why stored cells could not be fetched, if so. All columns of a file are in one store.
    pub(crate) fn failure(&self) -> Option<String> {
        match &self.columns.first()?.cells {
            Cells::Text(texts) => texts.failure(),
            _ => None,
        }
    }

    /// The number in the file of the row at `index`.
    pub fn row(&self, index: usize) -> usize {
        self.rows.get(index).copied().unwrap_or(index + 1)
    }

    /// The rows at these indices, in their order.
    pub fn rows_at(&self, places: &[usize]) -> Self {
        let numbers = |cells: &[f64]| places.iter().map(|row| cells[*row]).collect();
        let column = |column: &Column| Column {
            cells: match &column.cells {
                Cells::Numbers(cells) => Cells::Numbers(numbers(cells)),
                Cells::Times { seconds, utc } => {
                    Cells::Times { seconds: numbers(seconds), utc: *utc }
                }
                Cells::Text(cells) => Cells::Text(cells.at(places)),
            },
            ..column.clone_without_cells()
        };
        Self {
            columns: self.columns.iter().map(column).collect(),
            rows: places.iter().map(|row| self.row(*row)).collect(),
            origin: self.origin.clone(),
            part: self.part.clone(),
            sample_time: self.sample_time,
            attributes: self.attributes.clone(),
            left_out: self.left_out.clone(),
            notes: self.notes.clone(),
        }
    }

    /// Appends the rows of another sheet with the same columns.
    pub fn append(&mut self, other: Self) {
        self.rows = (0..self.len())
            .map(|row| self.row(row))
            .chain((0..other.len()).map(|row| other.row(row)))
            .collect();
        for (own, more) in self.columns.iter_mut().zip(other.columns) {
            match (&mut own.cells, more.cells) {
                (Cells::Numbers(own), Cells::Numbers(more)) => own.extend(more),
                (Cells::Text(own), Cells::Text(more)) => own.append(more),
                (Cells::Times { seconds: own, .. }, Cells::Times { seconds: more, .. }) => {
                    own.extend(more);
                }
                // Sheets of the same columns have cells of the same kinds.
                _ => {}
            }
        }
    }
}

impl Column {
    /// A copy with name and unit, without cells.
    fn clone_without_cells(&self) -> Self {
        Self { name: self.name.clone(), unit: self.unit.clone(), cells: Cells::Numbers(vec![]) }
    }
}
