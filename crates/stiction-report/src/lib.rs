//! Presents a diagnosis in words, as JSON, and as self-contained HTML.
//!
//! * [`words`]: a verdict in words;
//! * [`document`]: a diagnosis as JSON, with its schema;
//! * [`table`]: diagnoses as a table with one row per loop;
//! * [`fitted_scenario`]: a fitted loop as a scenario;
//! * [`report`]: the interactive report on recorded loops;
//! * [`sheet`]: tables as CSV, safe for spreadsheets;
//! * [`valve_test_sheet`]: the sheet of a valve test, to print and to fill in;
//! * [`valve_test_figure`]: the figure of the PV's responses;
//! * [`valve_test_page`]: the page of a test, and of two with a repair between them.
//!
//! Nothing here reads or writes files. Functions return strings and bytes, and equal input gives equal output.
#![forbid(unsafe_code)]

pub mod document;
pub mod fitted_scenario;
pub mod report;
pub mod sheet;
pub mod table;
pub mod valve_test_figure;
pub mod valve_test_page;
pub mod valve_test_sheet;
pub mod words;

pub use stiction_figure::Error;
