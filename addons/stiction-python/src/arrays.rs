//! Columns of numbers from any Arrow data.

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef};
use arrow_cast::cast;
use arrow_schema::{ArrowError, DataType};
use numpy::PyArray1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3_arrow::PyChunkedArray;
use pyo3_arrow::input::AnyArray;

/// The values of an array as numbers, with NaN for null.
pub fn as_numbers(array: &ArrayRef) -> Result<Vec<f64>, ArrowError> {
    let numbers = cast(array, &DataType::Float64)?;
    Ok(numbers
        .as_primitive::<Float64Type>()
        .iter()
        .map(|value| value.unwrap_or(f64::NAN))
        .collect())
}

/// The numbers of an Arrow array, with NaN for null; `None` if it holds something else.
pub fn numbers(array: &ArrayRef) -> Option<Vec<f64>> {
    let kind = array.data_type();
    let plain = matches!(kind, DataType::Float32 | DataType::Float64 | DataType::Null);
    if plain || kind.is_integer() { as_numbers(array).ok() } else { None }
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
