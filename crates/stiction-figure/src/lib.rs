//! Figures for people, as SVG and PNG, and galleries of them as self-contained HTML.
//!
//! * [`figure`]: figures as plain data, drawn as SVG text or PNG bytes;
//! * [`page`]: an HTML page that shows figures with their captions and parameters.
//!
//! It knows no valve, loop or recording: who computes a result draws it. Nothing here reads or writes files. Functions
//! return strings and bytes, and equal input gives equal output.
//!
//! ```
//! use stiction_figure::{Annotation, Entry, Figure, Page, Panel, Picture, Series};
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
//! # Ok::<(), stiction_figure::Error>(())
//! ```
#![forbid(unsafe_code)]

mod error;
pub mod figure;
pub mod page;
mod setters;

pub use error::Error;
pub use figure::{
    Along, Annotation, Figure, Heat, Legend, Live, Panel, Scale, Series, Span, Strip, Style, Tile,
};
pub use page::{Entry, Page, Parameter, Picture};
