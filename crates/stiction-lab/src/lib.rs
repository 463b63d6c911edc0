//! The lab: `stiction lab` opens a page that this crate serves, from and to one's own machine only.
//!
//! Rooms, each a module: [`recordings`], [`loops`] (a valve and its loop, live), [`exercise`] (a test to practise) and [`plant`]. The page asks by
//! calls, JSON in and JSON out ([`calls`]); what it gets are the results of the library, as they are. Pages, scripts and
//! styles are built from `web/` and embedded, so that Rust alone builds and runs the lab.
//!
//! # Safety of one's data
//! The server listens on the loopback unless told otherwise; who asks must know the token of its address, from a page of
//! its own ([`guard`]); it opens no connection. Requests, memory and time of each are bounded. It reads the files and
//! folders that it was given, and writes mappings, overrides and the plant's log.
#![forbid(unsafe_code)]

mod assets;
pub mod calls;
pub mod exercise;
pub mod guard;
pub mod guess;
pub mod judgement;
mod lab;
pub mod live;
pub mod loops;
pub mod paper;
mod places;
pub mod plant;
pub mod recordings;
mod server;

pub use lab::{Lab, Options};
pub use server::{Server, bind};
