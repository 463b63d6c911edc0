//! The report on recorded loops: one HTML file that works without a network, can be read with a
//! pointer, with keys and on paper, and shows everything without scripts too.
//!
//! * [`layout`]: the pieces of the page, and how they become HTML;
//! * [`views`]: figures of what was recorded.

pub mod layout;
pub mod views;

pub use layout::{Badge, Block, Card, Column, Fact, Report, Section, Source, Table, Tone};
pub use views::{Context, Ellipse};
