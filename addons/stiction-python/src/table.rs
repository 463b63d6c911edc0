//! Tables for the Arrow capsule interface.

use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{Field, Schema};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3_arrow::PyTable;
use std::sync::Arc;

/// A column: its name and its values.
pub type Column = (&'static str, ArrayRef);

/// Numbers; `None` is null.
pub fn numbers(name: &'static str, values: impl IntoIterator<Item = Option<f64>>) -> Column {
    (name, Arc::new(values.into_iter().collect::<Float64Array>()))
}

/// Whole numbers; `None` is null.
pub fn counts(name: &'static str, values: impl IntoIterator<Item = Option<i64>>) -> Column {
    (name, Arc::new(values.into_iter().collect::<Int64Array>()))
}

/// Text; `None` is null.
pub fn texts<T: AsRef<str>>(
    name: &'static str,
    values: impl IntoIterator<Item = Option<T>>,
) -> Column {
    (name, Arc::new(values.into_iter().collect::<StringArray>()))
}

/// Truth values; `None` is null.
pub fn flags(name: &'static str, values: impl IntoIterator<Item = Option<bool>>) -> Column {
    (name, Arc::new(values.into_iter().collect::<BooleanArray>()))
}

/// A table of named columns, for any library with the Arrow capsule interface.
///
/// ``polars.DataFrame(table)`` and ``pyarrow.table(table)`` accept it directly, and ``table.to_pandas()`` returns a
/// data frame. Iteration returns its rows as dictionaries. A notebook shows its first rows.
///
/// Examples
/// --------
/// >>> import stiction
/// >>> table = stiction.valves.valve_table()
/// >>> [row["name"] for row in table if not row["uses_s"]]
/// ['stenman', 'ideal']
#[pyclass(frozen, module = "stiction.valves", name = "Table", mapping)]
#[derive(Debug)]
pub struct ArrowTable(RecordBatch);

impl ArrowTable {
    /// The table of a batch.
    pub fn new(batch: RecordBatch) -> Self {
        Self(batch)
    }

    /// The table of these columns, all of one length.
    pub fn of(columns: Vec<Column>) -> PyResult<Self> {
        let fields: Vec<Field> = columns
            .iter()
            .map(|(name, values)| Field::new(*name, values.data_type().clone(), true))
            .collect();
        let values = columns.into_iter().map(|(_, values)| values).collect();
        RecordBatch::try_new(Arc::new(Schema::new(fields)), values)
            .map(Self)
            .map_err(|e| PyValueError::new_err(e.to_string()))
    }
}

#[pymethods]
impl ArrowTable {
    /// Names of the columns, in their order.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.0.schema().fields().iter().map(|field| field.name().clone()).collect()
    }

    fn __len__(&self) -> usize {
        self.0.num_rows()
    }

    /// The values of a column as a list.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let Some(column) = self.0.column_by_name(name) else {
            return Err(PyKeyError::new_err(format!(
                "no column \"{name}\"; there are {}",
                self.column_names().join(", ")
            )));
        };
        let any = column.as_any();
        if let Some(values) = any.downcast_ref::<Float64Array>() {
            return Ok(values.iter().collect::<Vec<_>>().into_pyobject(py)?.into_any());
        }
        if let Some(values) = any.downcast_ref::<Int64Array>() {
            return Ok(values.iter().collect::<Vec<_>>().into_pyobject(py)?.into_any());
        }
        if let Some(values) = any.downcast_ref::<BooleanArray>() {
            return Ok(values.iter().collect::<Vec<_>>().into_pyobject(py)?.into_any());
        }
        let texts = any.downcast_ref::<StringArray>().map(|texts| texts.iter().collect::<Vec<_>>());
        Ok(texts.into_pyobject(py)?.into_any())
    }

    /// The columns as lists, by name.
    ///
    /// Returns
    /// -------
    /// dict
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyDict>> {
        let all = pyo3::types::PyDict::new(py);
        for name in self.column_names() {
            all.set_item(&name, self.__getitem__(py, &name)?)?;
        }
        Ok(all)
    }

    /// Return it as a pandas data frame.
    ///
    /// Returns
    /// -------
    /// pandas.DataFrame
    ///     The same rows and columns.
    ///
    /// Raises
    /// ------
    /// ImportError
    ///     If pandas is not installed.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("stiction._frames")?.call_method1("frame", (self.to_dict(py)?,))
    }

    /// The rows, each a dictionary.
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("stiction._frames")?.call_method1("rows", (self.to_dict(py)?,))
    }

    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("stiction._html")?.call_method1("table", (self.to_dict(py)?,))
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let table = PyTable::try_new(vec![self.0.clone()], self.0.schema())?;
        Bound::new(py, table)?.call_method1("__arrow_c_stream__", (requested_schema,))
    }

    fn __repr__(&self) -> String {
        format!("<Table of {} rows: {}>", self.0.num_rows(), self.column_names().join(", "))
    }
}

/// A column from Python. NaN and None are null.
#[derive(FromPyObject)]
pub enum Given<'py> {
    Numbers(PyReadonlyArray1<'py, f64>),
    Flags(Vec<bool>),
    Counts(Vec<Option<i64>>),
    Texts(Vec<Option<String>>),
}

/// A table of named columns.
#[pyfunction]
pub fn table_of(columns: Vec<(String, Given<'_>)>) -> PyResult<ArrowTable> {
    let column = |(name, given): (String, Given<'_>)| {
        let values: ArrayRef = match given {
            Given::Numbers(values) => {
                let values = values.as_slice()?.iter().map(|v| Some(*v).filter(|v| !v.is_nan()));
                Arc::new(values.collect::<Float64Array>())
            }
            Given::Flags(values) => Arc::new(BooleanArray::from(values)),
            Given::Counts(values) => Arc::new(Int64Array::from(values)),
            Given::Texts(values) => Arc::new(StringArray::from(values)),
        };
        Ok((name, values, true))
    };
    let columns = columns.into_iter().map(column).collect::<PyResult<Vec<_>>>()?;
    RecordBatch::try_from_iter_with_nullable(columns)
        .map(ArrowTable)
        .map_err(|e| PyValueError::new_err(e.to_string()))
}
