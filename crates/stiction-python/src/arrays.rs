//! Columns of numbers from any Arrow data.

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type};
use arrow_array::types::{UInt8Type, UInt16Type, UInt32Type, UInt64Type};
use arrow_array::{Array, ArrayRef, ArrowPrimitiveType};
use arrow_schema::DataType;
use numpy::PyArray1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3_arrow::PyChunkedArray;
use pyo3_arrow::input::AnyArray;

/// The values of a primitive array, with NaN for null.
fn values<P: ArrowPrimitiveType>(array: &ArrayRef, of: impl Fn(P::Native) -> f64) -> Vec<f64> {
    array.as_primitive::<P>().iter().map(|value| value.map_or(f64::NAN, &of)).collect()
}

/// The numbers of an Arrow array, with NaN for null; `None` if it holds something else.
pub fn numbers(array: &ArrayRef) -> Option<Vec<f64>> {
    Some(match array.data_type() {
        DataType::Float64 => values::<Float64Type>(array, |v| v),
        DataType::Float32 => values::<Float32Type>(array, f64::from),
        DataType::Int8 => values::<Int8Type>(array, f64::from),
        DataType::Int16 => values::<Int16Type>(array, f64::from),
        DataType::Int32 => values::<Int32Type>(array, f64::from),
        DataType::Int64 => values::<Int64Type>(array, |v| v as f64),
        DataType::UInt8 => values::<UInt8Type>(array, f64::from),
        DataType::UInt16 => values::<UInt16Type>(array, f64::from),
        DataType::UInt32 => values::<UInt32Type>(array, f64::from),
        DataType::UInt64 => values::<UInt64Type>(array, |v| v as f64),
        DataType::Null => vec![f64::NAN; array.len()],
        _ => return None,
    })
}

/// A column of numbers given through the Arrow capsule interface, as float64 with NaN for null.
#[pyfunction]
pub fn arrow_column<'py>(
    py: Python<'py>,
    name: &str,
    column: AnyArray,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let chunked: PyChunkedArray = column.into_chunked_array()?;
    let mut all = vec![];
    for chunk in chunked.chunks() {
        let Some(numbers) = numbers(chunk) else {
            return Err(PyTypeError::new_err(format!(
                "{name} must hold numbers, but its Arrow type is {}",
                chunk.data_type()
            )));
        };
        all.extend(numbers);
    }
    Ok(PyArray1::from_vec(py, all))
}
