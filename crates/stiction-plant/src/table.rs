//! Tables that are declared once: the struct of a row, its columns in Arrow and Parquet, its JSON and CSV, and the
//! table of documentation come from one declaration.

use crate::action::Action;
use crate::change::Change;
use crate::health::Health;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{
    Array, ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray,
};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::{WriterProperties, WriterPropertiesBuilder};
use std::sync::Arc;
use stiction_diagnose::diagnose::{Cause, Grade, VerdictClass};

/// What a column is.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// Its unit; empty for what has none.
    pub unit: &'static str,
    /// Its type: `text`, `number`, `count` or `flag`.
    pub kind: &'static str,
    /// Whether a cell may be empty.
    pub optional: bool,
    /// What it means.
    pub meaning: String,
}

/// What a cell of a column can be.
pub trait Cell: Sized {
    /// Its type in words, in Arrow, and in the language of Spark.
    const KIND: (&'static str, DataType, &'static str);
    /// Whether it may be empty.
    const OPTIONAL: bool;
    /// Cells as a column.
    fn array(cells: Vec<Self>) -> ArrayRef;
    /// The cell of a row; `None` if the column is of another type, or the cell empty that must not be.
    fn of(array: &dyn Array, row: usize) -> Option<Self>;
    /// The cell as text for people's tables; empty for none.
    fn text(&self) -> String;
}

/// A type of cells that are always there, and the same that may be empty.
macro_rules! cell {
    ($type:ty, $kind:literal, $sql:literal, $arrow:expr, $array:ty, $cast:expr) => {
        impl Cell for $type {
            const KIND: (&'static str, DataType, &'static str) = ($kind, $arrow, $sql);
            const OPTIONAL: bool = false;
            fn array(cells: Vec<Self>) -> ArrayRef {
                Arc::new(<$array>::from(cells))
            }
            fn of(array: &dyn Array, row: usize) -> Option<Self> {
                Option::<$type>::of(array, row)?
            }
            fn text(&self) -> String {
                self.to_string()
            }
        }
        impl Cell for Option<$type> {
            const KIND: (&'static str, DataType, &'static str) = ($kind, $arrow, $sql);
            const OPTIONAL: bool = true;
            fn array(cells: Vec<Self>) -> ArrayRef {
                Arc::new(<$array>::from(cells))
            }
            fn of(array: &dyn Array, row: usize) -> Option<Self> {
                let cast = $cast;
                let array = cast(array)?;
                Some(array.is_valid(row).then(|| array.value(row).into()))
            }
            fn text(&self) -> String {
                self.as_ref().map(ToString::to_string).unwrap_or_default()
            }
        }
    };
}

cell!(
    String,
    "text",
    "STRING",
    DataType::Utf8,
    StringArray,
    |a| <dyn Array>::as_string_opt::<i32>(a)
);
cell!(f64, "number", "DOUBLE", DataType::Float64, Float64Array, |a| {
    <dyn Array>::as_primitive_opt::<Float64Type>(a)
});
cell!(i64, "count", "BIGINT", DataType::Int64, Int64Array, |a| {
    <dyn Array>::as_primitive_opt::<Int64Type>(a)
});
cell!(bool, "flag", "BOOLEAN", DataType::Boolean, BooleanArray, |a| <dyn Array>::as_boolean_opt(a));

/// A type of cells that has names for its values, `ALL` of them known, and the same that may be empty.
macro_rules! named_cell {
    ($type:ty) => {
        impl Cell for $type {
            const KIND: (&'static str, DataType, &'static str) = ("text", DataType::Utf8, "STRING");
            const OPTIONAL: bool = false;
            fn array(cells: Vec<Self>) -> ArrayRef {
                Arc::new(cells.iter().map(|cell| Some(cell.name())).collect::<StringArray>())
            }
            fn of(array: &dyn Array, row: usize) -> Option<Self> {
                Option::<$type>::of(array, row)?
            }
            fn text(&self) -> String {
                self.name().to_owned()
            }
        }
        impl Cell for Option<$type> {
            const KIND: (&'static str, DataType, &'static str) = ("text", DataType::Utf8, "STRING");
            const OPTIONAL: bool = true;
            fn array(cells: Vec<Self>) -> ArrayRef {
                let name = |cell: &Option<$type>| cell.map(<$type>::name);
                Arc::new(cells.iter().map(name).collect::<StringArray>())
            }
            fn of(array: &dyn Array, row: usize) -> Option<Self> {
                match Option::<String>::of(array, row)? {
                    None => Some(None),
                    Some(name) => <$type>::ALL.into_iter().find(|one| one.name() == name).map(Some),
                }
            }
            fn text(&self) -> String {
                self.map_or(String::new(), |one| one.name().to_owned())
            }
        }
    };
}

named_cell!(Grade);
named_cell!(Cause);
named_cell!(Action);
named_cell!(Change);
named_cell!(Health);
named_cell!(VerdictClass);

/// What has names is written by them.
macro_rules! written_by_name {
    ($($type:ty),+) => {$(
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
                to.serialize_str(self.name())
            }
        }
        impl schemars::JsonSchema for $type {
            fn inline_schema() -> bool {
                true
            }
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($type).into()
            }
            fn json_schema(of: &mut schemars::SchemaGenerator) -> schemars::Schema {
                <str as schemars::JsonSchema>::json_schema(of)
            }
        }
    )+};
}

written_by_name!(Action, Change, Health);

/// Declares a table: the struct of its rows, with columns in Arrow and Parquet, JSON and documentation.
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

        impl $row {
            /// All columns, in their order.
            pub fn columns() -> Vec<$crate::table::Column> {
                use $crate::table::{Cell, Column};
                vec![$(Column {
                    name: $name,
                    unit: $unit,
                    kind: <$type as Cell>::KIND.0,
                    optional: <$type as Cell>::OPTIONAL,
                    meaning: [$($meaning),+].concat().trim().to_owned(),
                }),+]
            }

            /// The schema of a table of these rows; the metadata of a field tell unit and meaning.
            pub fn schema() -> std::sync::Arc<arrow_schema::Schema> {
                use $crate::table::Cell;
                $crate::table::schema(Self::columns(), &[$(<$type as Cell>::KIND.1),+])
            }

            /// The columns as Spark declares them.
            pub fn ddl() -> String {
                use $crate::table::Cell;
                let columns = [$(($name, <$type as Cell>::KIND.2)),+];
                columns.map(|(name, kind)| format!("`{name}` {kind}")).join(", ")
            }

            /// Rows as a table.
            ///
            /// # Errors
            /// None is known: all columns are of one length.
            pub fn batch(
                rows: &[Self],
            ) -> std::result::Result<arrow_array::RecordBatch, arrow_schema::ArrowError> {
                use $crate::table::Cell;
                let columns: Vec<arrow_array::ArrayRef> =
                    vec![$(Cell::array(rows.iter().map(|row| row.$field.clone()).collect::<Vec<$type>>())),+];
                arrow_array::RecordBatch::try_new(Self::schema(), columns)
            }

            /// The rows of a table; columns are found by name, and others than these are left alone. One whose cells may be
            /// empty may be missing: an earlier version did not know it.
            ///
            /// # Errors
            /// If another column is not there, one is of another type, or lacks a cell that it must have.
            pub fn rows(batch: &arrow_array::RecordBatch) -> std::result::Result<Vec<Self>, String> {
                use $crate::table::Cell;
                let column = |name: &str, optional: bool| match batch.column_by_name(name) {
                    None if !optional => Err(format!("has no column \"{name}\"")),
                    column => Ok(column),
                };
                $(let $field = column($name, <$type as Cell>::OPTIONAL)?;)+
                (0..batch.num_rows())
                    .map(|row| {
                        Ok(Self { $($field: match $field {
                            None => Default::default(),
                            Some(column) => <$type as Cell>::of(column, row).ok_or_else(|| {
                                format!("row {}, column \"{}\" is not a {}", row + 1, $name, <$type as Cell>::KIND.0)
                            })?,
                        },)+ })
                    })
                    .collect()
            }

            /// The cells of the row as text, in the order of the columns.
            pub fn cells(&self) -> Vec<String> {
                use $crate::table::Cell;
                vec![$(Cell::text(&self.$field)),+]
            }
        }
    };
}
pub(crate) use columns;

/// The schema of columns of these types.
pub fn schema(columns: Vec<Column>, types: &[DataType]) -> Arc<Schema> {
    let field = |(column, data_type): (Column, &DataType)| {
        let told = [("unit", column.unit.to_owned()), ("meaning", column.meaning)];
        let told = told.into_iter().filter(|(_, text)| !text.is_empty());
        Field::new(column.name, data_type.clone(), column.optional)
            .with_metadata(told.map(|(key, text)| (key.to_owned(), text)).collect())
    };
    Arc::new(Schema::new(columns.into_iter().zip(types).map(field).collect::<Vec<_>>()))
}

/// How tables are written.
pub fn properties() -> WriterPropertiesBuilder {
    WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by("stiction".to_owned())
}

/// A table as Parquet; equal tables give equal bytes.
///
/// # Errors
/// None is known.
pub fn parquet(batch: &RecordBatch) -> parquet::errors::Result<Vec<u8>> {
    parquet_with(batch, properties())
}

/// A table as Parquet, written so.
///
/// # Errors
/// None is known.
pub fn parquet_with(
    batch: &RecordBatch,
    properties: WriterPropertiesBuilder,
) -> parquet::errors::Result<Vec<u8>> {
    let mut writer = ArrowWriter::try_new(vec![], batch.schema(), Some(properties.build()))?;
    writer.write(batch)?;
    writer.into_inner()
}
