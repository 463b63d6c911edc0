//! The report on recorded loops is one HTML file that works without a network, with pointer, keys and on paper. It
//! also shows everything without scripts.
//!
//! * [`layout`]: the parts of the page, and their HTML;
//! * [`views`]: figures of the recorded signals;
//! * [`evidence`]: a card for each method;
//! * [`fitted`]: a fitted loop in words;
//! * [`history`]: the history of a valve;
//! * [`first_screen()`]: the content as data.
//!
//! ```
//! use stiction_diagnose::finding::Decision;
//! use stiction_diagnose::diagnose::VerdictClass;
//! use stiction_figure::{Figure, Panel, Series};
//! use stiction_report::report::layout::{Badge, Card, Fact, Report, Section, Table, number};
//!
//! let t: Vec<f64> = (0..200).map(f64::from).collect();
//! let op: Vec<f64> = t.iter().map(|t| 50.0 + (0.2 * t).sin()).collect();
//! let panel = Panel::new("time (s)", "OP (% of span)").with(Series::line("OP", t, op));
//! let card = Card::new("A method", "the OP swings by 2 %")
//!     .badge(Decision::Undecided)
//!     .figure(Figure::new("").caption("OP over time.").with(panel.group("time")))
//!     .table(Table::new("Numbers").words("number").numbers("value", "%").row(["swing", "2"]));
//! let section = Section::new("FIC-101", Badge::from(VerdictClass::CannotTell), "one method only")
//!     .fact(Fact::new("J", number(1.0), "%"))
//!     .heading("Evidence")
//!     .with(card);
//! let html = Report::new("One loop", "stiction 0.1.0").with(section).html()?;
//! assert!(html.contains("cannot tell") && html.contains("<svg"));
//! # Ok::<(), stiction_report::Error>(())
//! ```

mod diagnosis;
pub mod evidence;
pub mod first_screen;
pub mod fitted;
pub mod folder;
mod head;
pub mod history;
pub mod layout;
pub(crate) mod moment;
mod over_time;
mod small_trend;
mod verdict;
pub mod views;

pub use diagnosis::html;
pub use first_screen::{FirstScreen, Folds, first_screen};
pub use fitted::Fitted;
pub use folder::{Folder, Heading};
pub use history::history_html;
pub use layout::{Badge, Block, Card, Column, Fact, Report, Section, Table, Tone};
pub use small_trend::{Small, small_trend};
pub use verdict::plan;
pub use views::Context;
