//! Dictionaries for the results of `python/stiction`.

/// A Python dictionary of the given keys and values: `dict!(py, "found": o.found, "period_s": o.period_s)`.
macro_rules! dict {
    ($py:expr $(, $key:literal : $value:expr)* $(,)?) => {{
        let dict = pyo3::types::PyDict::new($py);
        $(pyo3::types::PyDictMethods::set_item(&dict, $key, $value)?;)*
        dict
    }};
}
pub(crate) use dict;
