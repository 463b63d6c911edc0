//! Pictures and pages for people: figures as SVG and PNG, galleries as self-contained HTML.
//!
//! * [`figure`]: figures as plain data, drawn as SVG text or PNG bytes;
//! * [`page`]: an HTML page that shows figures with their captions and parameters;
//! * [`report`]: the report on recorded loops, which can be read with a pointer;
//! * [`scoreboard`]: how right the verdict and the methods are, as tables and as a page;
//! * [`run`]: figures of simulated runs;
//! * [`limit_cycle`]: a cycle over time, and maps of cycles over two parameters;
//! * [`nyquist`]: harmonic balance as a picture;
//! * [`actions`]: what could be done about a sticking valve, as a chart;
//! * [`words`]: a verdict in words;
//! * [`paper`]: the figures of the paper.
//!
//! Nothing here touches a file: functions return strings and bytes, and equal input gives equal
//! output.
//!
//! ```
//! use stiction_report::{Annotation, Entry, Figure, Page, Panel, Picture, Series};
//!
//! let t: Vec<f64> = (0..200).map(f64::from).collect();
//! let pv: Vec<f64> = t.iter().map(|t| 50.0 + (0.2 * t).sin()).collect();
//! let panel = Panel::new("time (s)", "PV (%)")
//!     .with(Series::line("PV", &t[..], pv))
//!     .with(Series::dashed("SP", [0.0, 199.0], [50.0, 50.0]))
//!     .note(Annotation::dimension((7.9, 51.0), (39.3, 51.0), "period", 0.0));
//! let figure = Figure::new("A cycling loop").caption("PV swings about its set point.").with(panel);
//!
//! let svg = figure.svg()?;
//! let png = figure.png()?;
//! let entry = Entry::new("Figure 1", Picture::Inline(svg), figure.caption).parameter("T", 31.4, "s");
//! let html = Page::new("Gallery", "All figures.", "stiction 0.1.0").with(entry).html();
//! # assert!(png.starts_with(b"\x89PNG") && html.contains("31.4"));
//! # Ok::<(), stiction_report::Error>(())
//! ```
#![forbid(unsafe_code)]

pub mod actions;
pub mod document;
mod error;
mod escape;
pub mod figure;
pub mod limit_cycle;
pub mod nyquist;
pub mod page;
pub mod paper;
pub mod report;
pub mod run;
pub mod scoreboard;
pub mod words;

pub use error::Error;
pub use figure::{
    Along, Annotation, Figure, Heat, Legend, Live, Panel, Scale, Series, Span, Strip, Style, Tile,
};
pub use page::{Entry, Page, Parameter, Picture};
