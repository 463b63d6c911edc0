//! Any bytes are a table or an error; a table that was read and written reads back the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use stiction_io::Table;

fuzz_target!(|bytes: &[u8]| {
    let Ok(table) = Table::parse(bytes, "fuzz.csv") else { return };
    let values: Vec<f64> = (0..table.len()).map(|k| k as f64 / 3.0).collect();
    let Ok(text) = table.with_column("a new column", &values) else { return };
    // A signal has two samples or more.
    if values.len() < 2 {
        return;
    }
    let again = Table::parse(text.as_bytes(), "written.csv").expect("what was written reads");
    assert_eq!(again.column("a new column").expect("the column is there"), values);
    for name in table.header() {
        if let Ok(column) = table.column(name) {
            assert_eq!(again.column(name).expect("the column is still there"), column);
        }
    }
});
