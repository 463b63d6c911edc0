//! Dictionaries for the results of `python/stiction`.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use serde::Serialize;

/// A result as plain Python values: dictionaries, lists, text and numbers. The result equals its JSON, so a number that
/// is not finite is None.
pub fn plain<'py>(py: Python<'py>, result: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(result).map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// A Python dictionary of the given keys and values: `dict!(py, "found": o.found, "period_s": o.period_s)`.
macro_rules! dict {
    ($py:expr $(, $key:literal : $value:expr)* $(,)?) => {{
        let dict = pyo3::types::PyDict::new($py);
        $(pyo3::types::PyDictMethods::set_item(&dict, $key, $value)?;)*
        dict
    }};
}
pub(crate) use dict;
