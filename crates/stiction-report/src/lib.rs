//! Pictures and pages for people: figures as SVG and PNG, galleries as self-contained HTML.
//!
//! * [`figure`]: figures as plain data, drawn as SVG text or PNG bytes;
//! * [`page`]: an HTML page that shows figures with their captions and parameters.
//!
//! Nothing here touches a file: functions return strings and bytes, and equal input gives equal
//! output.
#![forbid(unsafe_code)]

mod error;
mod escape;
pub mod figure;

pub use error::Error;
pub use figure::{Annotation, Figure, Legend, Panel, Series, Style};
