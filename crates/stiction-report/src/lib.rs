//! A diagnosis for people and programs: in words, as JSON, and as self-contained HTML.
//!
//! * [`words`]: a verdict in words;
//! * [`document`]: a diagnosis as JSON, with its schema;
//! * [`table`]: diagnoses as a table, one row a loop;
//! * [`report`]: the report on recorded loops, which can be read with a pointer;
//! * [`sheet`]: tables as CSV that are safe in spreadsheets;
//! * [`test_sheet`]: the sheet of a valve test, to print and to fill in; [`test_answers`]: its figure;
//!   [`test_page`]: the page of a test, and of two with a repair between them;
//! * [`scoreboard`]: how right the verdict and the methods are, as tables and as a page.
//!
//! Nothing here touches a file: functions return strings and bytes, and equal input gives equal
//! output.
#![forbid(unsafe_code)]

pub mod document;
pub mod report;
pub mod scoreboard;
pub mod sheet;
pub mod table;
pub mod test_answers;
pub mod test_page;
pub mod test_sheet;
pub mod words;

pub use stiction_figure::Error;
