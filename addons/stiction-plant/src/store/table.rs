//! Tables with one declaration. From it follow the struct of a row, its columns in memory and in Parquet, its JSON and
//! CSV, and the table in the documentation.

use crate::report::action::Action;
use crate::report::health::Health;
use crate::report::orders::Status;
use crate::store::trace::TraceSignal;
use std::sync::Arc;
use stiction_diagnose::diagnose::change::Change;
use stiction_diagnose::diagnose::{Cause, Grade, VerdictClass};
use stiction_diagnose::spoken;
use stiction_model::{always_written_by_name, named};

/// The description of a column.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Column {
    /// Name.
    pub name: &'static str,
    /// Unit; empty if the column has none.
    pub unit: &'static str,
    /// The kind of its cells.
    pub kind: Kind,
    /// Whether a cell may be empty.
    pub optional: bool,
    /// Meaning.
    pub meaning: String,
}

named! {
    /// The kind of the cells of a column.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Kind {
        /// Text.
        Text = "text",
        /// Numbers.
        Number = "number",
        /// Whole numbers.
        Count = "count",
        /// True or false.
        Flag = "flag",
        /// Times: whole numbers, ms since 1970-01-01 UTC.
        Time = "time",
        /// Lists of steps: small whole numbers, of which some may be missing.
        Steps = "list",
    }
}

impl Kind {
    /// Name in Spark SQL.
    pub fn sql(self) -> &'static str {
        match self {
            Self::Text => "STRING",
            Self::Number => "DOUBLE",
            Self::Count => "BIGINT",
            Self::Flag => "BOOLEAN",
            Self::Time => "TIMESTAMP",
            Self::Steps => "ARRAY<SMALLINT>",
        }
    }
}

/// The value of a missing step.
pub const MISSING: i16 = i16::MIN;

/// The cells of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Text. Consecutive equal texts should share one allocation.
    Text(Vec<Option<Arc<str>>>),
    /// Numbers.
    Number(Vec<Option<f64>>),
    /// Whole numbers, or times.
    Count(Vec<Option<i64>>),
    /// True or false.
    Flag(Vec<Option<bool>>),
    /// Lists of steps, with [`MISSING`] for a missing one.
    Steps(Vec<Vec<i16>>),
    /// A number of cells of an unknown kind, which no row uses.
    Other(usize),
}

impl Cells {
    /// Their number.
    pub fn len(&self) -> usize {
        match self {
            Self::Text(cells) => cells.len(),
            Self::Number(cells) => cells.len(),
            Self::Count(cells) => cells.len(),
            Self::Flag(cells) => cells.len(),
            Self::Steps(cells) => cells.len(),
            Self::Other(cells) => *cells,
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A table, column by column.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Columns, by name, all of one length.
    pub columns: Vec<(String, Cells)>,
}

impl Table {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, |(_, cells)| cells.len())
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The cells of a column. An optional column may be missing, because an earlier version did not have it.
    ///
    /// # Errors
    /// If a required column is missing, the type is different, or a required cell is empty.
    pub fn column<T: Cell>(&self, name: &str) -> Result<Vec<T>, String> {
        let Some((_, cells)) = self.columns.iter().find(|(own, _)| own == name) else {
            let none = T::none().ok_or_else(|| format!("has no column \"{name}\""))?;
            return Ok(vec![none; self.len()]);
        };
        let wrong = |row| format!("row {}, column \"{name}\" is not a {}", row + 1, T::KIND.name());
        (0..cells.len()).map(|row| T::of(cells, row).ok_or_else(|| wrong(row))).collect()
    }
}

/// A type of cells.
pub trait Cell: Clone {
    /// The kind of its column.
    const KIND: Kind;
    /// An empty cell, if the type allows one.
    fn none() -> Option<Self>;
    /// Cells as a column.
    fn cells(cells: Vec<Self>) -> Cells;
    /// The cell of a row; `None` if the column has a different type, or a required cell is empty.
    fn of(cells: &Cells, row: usize) -> Option<Self>;
    /// The cell as text for CSV; empty for none.
    fn text(&self) -> String;
}

/// Cells of a type, required and optional: how a cell is stored, how it is read again (`None` for a value of a
/// different type), and its text.
macro_rules! cell {
    ($type:ty, $kind:ident, $in:expr, $out:expr, $text:expr) => {
        impl Cell for $type {
            const KIND: Kind = Kind::$kind;
            fn none() -> Option<Self> {
                None
            }
            fn cells(cells: Vec<Self>) -> Cells {
                Cell::cells(cells.into_iter().map(Some).collect::<Vec<_>>())
            }
            fn of(cells: &Cells, row: usize) -> Option<Self> {
                <Option<$type>>::of(cells, row)?
            }
            fn text(&self) -> String {
                $text(self)
            }
        }
        impl Cell for Option<$type> {
            const KIND: Kind = Kind::$kind;
            fn none() -> Option<Self> {
                Some(None)
            }
            fn cells(cells: Vec<Self>) -> Cells {
                let cells = cells.into_iter().map(|cell| cell.map($in));
                Cells::$kind(cells.collect())
            }
            fn of(cells: &Cells, row: usize) -> Option<Self> {
                let Cells::$kind(cells) = cells else { return None };
                cells.get(row)?.as_ref().map_or(Some(None), |cell| $out(cell).map(Some))
            }
            fn text(&self) -> String {
                self.as_ref().map($text).unwrap_or_default()
            }
        }
    };
}
cell!(String, Text, Arc::from, |text: &Arc<str>| Some(text.to_string()), ToString::to_string);
cell!(f64, Number, |number| number, |n: &f64| Some(*n), |number: &f64| spoken::cell(*number));
cell!(i64, Count, |count| count, |count: &i64| Some(*count), ToString::to_string);
cell!(bool, Flag, |flag| flag, |flag: &bool| Some(*flag), ToString::to_string);

impl Cell for Vec<i16> {
    const KIND: Kind = Kind::Steps;
    fn none() -> Option<Self> {
        None
    }
    fn cells(cells: Vec<Self>) -> Cells {
        Cells::Steps(cells)
    }
    fn of(cells: &Cells, row: usize) -> Option<Self> {
        let Cells::Steps(cells) = cells else { return None };
        cells.get(row).cloned()
    }
    fn text(&self) -> String {
        let step = |step: &i16| if *step == MISSING { String::new() } else { step.to_string() };
        self.iter().map(step).collect::<Vec<_>>().join(" ")
    }
}

/// Cells of types whose values are listed in `ALL` and have names.
macro_rules! named_cell {
    ($($type:ty),+) => {$(
        cell!(
            $type,
            Text,
            |one: $type| Arc::from(one.name()),
            |name: &Arc<str>| <$type>::ALL.into_iter().find(|one| one.name() == &**name),
            |one: &$type| one.name().to_owned()
        );
    )+};
}

named_cell!(Grade, Cause, VerdictClass, Change, Action, Health, Status, TraceSignal);

always_written_by_name!(Kind);

/// A row of a table.
pub trait Row: Sized {
    /// All columns, in their order.
    fn columns() -> Vec<Column>;

    /// Rows as a table.
    fn table(rows: &[Self]) -> Table;

    /// The rows of a table. Columns are found by name, and unknown columns are ignored. An optional column may be missing, because an
    /// earlier version did not have it.
    ///
    /// # Errors
    /// If a required column is missing, a type is different, or a required cell is empty.
    fn rows(table: &Table) -> Result<Vec<Self>, String>;

    /// The cells of the row as text, in the order of the columns.
    fn cells(&self) -> Vec<String>;

    /// The columns as Spark declares them.
    fn ddl() -> String {
        let column = |column: Column| format!("`{}` {}", column.name, column.kind.sql());
        Self::columns().into_iter().map(column).collect::<Vec<_>>().join(", ")
    }
}

/// Declares a table: the struct of its rows, with columns in memory and in Parquet, JSON and documentation.
macro_rules! columns {
    (
        $(#[$attribute:meta])*
        pub struct $row:ident;
        $($(#[doc = $meaning:literal])+ $name:tt [$unit:literal] $field:ident: $type:ty;)+
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, PartialEq, Default, serde::Serialize, schemars::JsonSchema)]
        pub struct $row {
            $($(#[doc = $meaning])+ #[serde(rename = $name)] pub $field: $type,)+
        }

        impl $crate::store::table::Row for $row {
            fn columns() -> Vec<$crate::store::table::Column> {
                use $crate::store::table::{Cell, Column};
                vec![$(Column {
                    name: $name,
                    unit: $unit,
                    kind: <$type as Cell>::KIND,
                    optional: <$type as Cell>::none().is_some(),
                    meaning: [$($meaning),+].concat().trim().to_owned(),
                }),+]
            }

            fn table(rows: &[Self]) -> $crate::store::table::Table {
                let columns = vec![$((
                    $name.to_owned(),
                    $crate::store::table::Cell::cells(
                        rows.iter().map(|row| row.$field.clone()).collect::<Vec<$type>>()
                    ),
                )),+];
                $crate::store::table::Table { columns }
            }

            fn rows(table: &$crate::store::table::Table) -> std::result::Result<Vec<Self>, String> {
                let mut rows = vec![Self::default(); table.len()];
                $(for (row, cell) in rows.iter_mut().zip(table.column::<$type>($name)?) {
                    row.$field = cell;
                })+
                Ok(rows)
            }

            fn cells(&self) -> Vec<String> {
                use $crate::store::table::Cell;
                vec![$(Cell::text(&self.$field)),+]
            }
        }
    };
}
pub(crate) use columns;
