//! Tables of a plant as Arrow, for Python and other engines.

use crate::table::ArrowTable;
use arrow_array::builder::{Int16Builder, ListBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int16Type, Int64Type};
use arrow_array::{
    Array, ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray,
    TimestampMillisecondArray,
};
use arrow_schema::{DataType, Field, Schema, TimeUnit};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3_arrow::input::AnyRecordBatch;
use std::sync::Arc;
use stiction_plant::table::{Cells, Column, Kind, MISSING, Row, Table};

/// The schema of rows. The metadata of a field give unit and meaning.
pub fn schema<R: Row>() -> Arc<Schema> {
    let field = |column: Column| {
        let told = [("unit", column.unit.to_owned()), ("meaning", column.meaning)];
        let told = told.into_iter().filter(|(_, text)| !text.is_empty());
        Field::new(column.name, data_type(column.kind), column.optional)
            .with_metadata(told.map(|(key, text)| (key.to_owned(), text)).collect())
    };
    Arc::new(Schema::new(R::columns().into_iter().map(field).collect::<Vec<_>>()))
}

fn data_type(kind: Kind) -> DataType {
    match kind {
        Kind::Text => DataType::Utf8,
        Kind::Number => DataType::Float64,
        Kind::Count => DataType::Int64,
        Kind::Flag => DataType::Boolean,
        Kind::Time => DataType::Timestamp(TimeUnit::Millisecond, Some("UTC".into())),
        Kind::Steps => DataType::List(Arc::new(Field::new("item", DataType::Int16, true))),
    }
}

/// Rows as a table with their schema.
pub fn arrow<R: Row>(rows: &[R]) -> PyResult<ArrowTable> {
    let schema = schema::<R>();
    let columns = R::table(rows).columns.into_iter().zip(schema.fields());
    let columns = columns.map(|((_, cells), field)| array(cells, field.data_type())).collect();
    let batch = RecordBatch::try_new(schema, columns);
    batch.map(ArrowTable::new).map_err(|e| PyRuntimeError::new_err(e.to_string()))
}

fn array(cells: Cells, data_type: &DataType) -> ArrayRef {
    match cells {
        Cells::Text(cells) => Arc::new(StringArray::from_iter(cells)),
        Cells::Number(cells) => Arc::new(Float64Array::from(cells)),
        Cells::Count(cells) => match data_type {
            DataType::Timestamp(..) => {
                Arc::new(TimestampMillisecondArray::from(cells).with_timezone("UTC"))
            }
            _ => Arc::new(Int64Array::from(cells)),
        },
        Cells::Flag(cells) => Arc::new(BooleanArray::from(cells)),
        Cells::Steps(lists) => {
            let mut steps = ListBuilder::new(Int16Builder::new());
            for list in lists {
                steps.append_value(list.iter().map(|v| (*v != MISSING).then_some(*v)));
            }
            Arc::new(steps.finish())
        }
        Cells::Other(rows) => arrow_array::new_null_array(data_type, rows),
    }
}

/// The rows of a table, which is one of `what`. Steps may also be bytes: whole numbers of two bytes, low byte first,
/// with the smallest number for a missing one.
pub fn rows<R: Row>(table: AnyRecordBatch, what: &str) -> PyResult<Vec<R>> {
    let mut rows = vec![];
    for batch in table.into_table()?.into_inner().0 {
        rows.extend(R::rows(&plain(&batch)).map_err(|words| {
            PyValueError::new_err(format!("the table is not one of {what}: it {words}"))
        })?);
    }
    Ok(rows)
}

fn plain(batch: &RecordBatch) -> Table {
    let schema = batch.schema();
    let columns = schema.fields().iter().zip(batch.columns());
    Table { columns: columns.map(|(field, array)| (field.name().clone(), cells(array))).collect() }
}

fn cells(array: &ArrayRef) -> Cells {
    let found = match array.data_type() {
        DataType::Utf8 => array
            .as_string_opt::<i32>()
            .map(|a| Cells::Text(a.iter().map(|v| v.map(Arc::from)).collect())),
        DataType::Float64 => {
            array.as_primitive_opt::<Float64Type>().map(|a| Cells::Number(a.iter().collect()))
        }
        DataType::Int64 => {
            array.as_primitive_opt::<Int64Type>().map(|a| Cells::Count(a.iter().collect()))
        }
        DataType::Boolean => array.as_boolean_opt().map(|a| Cells::Flag(a.iter().collect())),
        DataType::Binary | DataType::List(_) => steps(array).map(Cells::Steps),
        _ => None,
    };
    found.unwrap_or(Cells::Other(array.len()))
}

fn steps(array: &ArrayRef) -> Option<Vec<Vec<i16>>> {
    if let Some(all) = array.as_binary_opt::<i32>() {
        let list = |bytes: Option<&[u8]>| {
            let (whole, rest) = bytes?.as_chunks();
            rest.is_empty().then(|| whole.iter().map(|v| i16::from_le_bytes(*v)).collect())
        };
        return all.iter().map(list).collect();
    }
    let list = |own: Option<ArrayRef>| {
        let own = own?;
        let own = own.as_primitive_opt::<Int16Type>()?;
        Some(own.iter().map(|v| v.unwrap_or(MISSING)).collect())
    };
    array.as_list_opt::<i32>()?.iter().map(list).collect()
}
