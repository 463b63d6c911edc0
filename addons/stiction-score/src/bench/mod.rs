//! The benchmark of detectors: the format of its lines, its results and its page.
//!
//! ```text
//! recording ──> line ──> any detector ──> line ──> Answer ──> Results ──> JSON, Markdown, page
//! ```
//!
//! * [`exchange`]: recordings and answers as lines of JSON;
//! * [`results`]: the measures of one or several detectors as a document;
//! * [`key`]: the key of a hidden half;
//! * [`leaderboard`]: the document as tables and as a page;
//! * [`datasheet`]: the content of a suite.

pub mod datasheet;
pub mod exchange;
pub mod key;
pub mod leaderboard;
pub mod results;
