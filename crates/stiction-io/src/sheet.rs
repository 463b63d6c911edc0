//! What every file format is read into: named columns of cells, before anyone asks what they mean.

use std::sync::Arc;

/// A table from a file, whatever its format.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sheet {
    /// The file, as it is named in messages.
    pub origin: String,
    /// Which part of the file, such as `cdata.chemicals.loop2` of a MATLAB file; empty if it has one
    /// part only.
    pub part: String,
    /// The columns in the order of the file, all of one length.
    pub columns: Vec<Column>,
    /// Time between rows in s, where the file tells it beside the columns.
    pub sample_time: Option<f64>,
    /// What else the file says of the whole, such as `("type", "1")`.
    pub attributes: Vec<(String, String)>,
    /// What the file has beside them that could not be made a column.
    pub left_out: Vec<LeftOut>,
    /// What the user should know of how the columns were made.
    pub notes: Vec<String>,
    /// The row of the file that each cell of a column comes from, from 1, as a spreadsheet or editor
    /// counts; empty where rows have no number of their own, and the index from 1 is used.
    pub rows: Vec<usize>,
}

/// What could not be made a column: it is named, not dropped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Its name.
    pub name: String,
    /// Why, as the end of a sentence that begins with the name.
    pub why: String,
    /// Whether it holds samples, or could: what is empty or a single number does not.
    pub holds_samples: bool,
}

/// A named column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name, trimmed.
    pub name: String,
    /// Its unit, where the file names one.
    pub unit: Option<String>,
    /// Its cells.
    pub cells: Cells,
}

/// The cells of a column, as the format stores them.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Numbers; NaN where there is none.
    Numbers(Vec<f64>),
    /// Text as it was written; empty where there is none. Of words that come again, such as tags, there is one each.
    Text(Vec<Arc<str>>),
    /// Times, s since 1970-01-01; NaN where there is none. Without a zone they are local, and so are
    /// these.
    Times {
        /// The times.
        seconds: Vec<f64>,
        /// Whether they are UTC, not local in an unknown zone.
        utc: bool,
    },
}

impl Cells {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(cells) => cells.len(),
            Self::Text(cells) => cells.len(),
            Self::Times { seconds, .. } => seconds.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Sheet {
    /// How many rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, |column| column.cells.len())
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number by which the file counts the row at `index`.
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
                Cells::Text(cells) => {
                    Cells::Text(places.iter().map(|row| Arc::clone(&cells[*row])).collect())
                }
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

    /// Appends the rows of another sheet of the same columns.
    pub fn append(&mut self, other: Self) {
        self.rows = (0..self.len())
            .map(|row| self.row(row))
            .chain((0..other.len()).map(|row| other.row(row)))
            .collect();
        for (own, more) in self.columns.iter_mut().zip(other.columns) {
            match (&mut own.cells, more.cells) {
                (Cells::Numbers(own), Cells::Numbers(more)) => own.extend(more),
                (Cells::Text(own), Cells::Text(more)) => own.extend(more),
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
    /// Its name and unit.
    fn clone_without_cells(&self) -> Self {
        Self { name: self.name.clone(), unit: self.unit.clone(), cells: Cells::Numbers(vec![]) }
    }
}
