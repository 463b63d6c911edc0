//! The lab: `stiction lab` opens a page that this crate serves on the user's own machine.
//!
//! Each room is a module: [`recordings`], [`loops`] (a valve and its loop, live), [`exercise`] (a test to practise),
//! [`course`] (six lessons) and [`plant`]. The page asks
//! by [`calls`], JSON in and JSON out. It gets the results of the library unchanged. Pages, scripts and styles are built
//! from `web/` and embedded, so Rust alone builds and runs the lab.
//!
//! # Data safety
//! The server listens on the loopback by default. It answers only requests with the token of its address ([`guard`]), and
//! opens no connection itself. The number, memory and time of requests are bounded ([`turns`]). The lab reads the files and
//! folders that it was given, and writes mappings, overrides and the plant's log.
#![forbid(unsafe_code)]

mod assets;
pub mod calls;
pub mod course;
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
pub mod turns;

pub use lab::{Lab, Options};
pub use server::{Server, bind};
