//! Figures of runs, cycles and actions, with the feature `figure`.
//!
//! * [`run`]: simulated runs;
//! * [`limit_cycle`]: a cycle over time, and maps of cycles over two parameters;
//! * [`nyquist`]: harmonic balance as a picture;
//! * [`actions`]: a chart of the actions against a sticking valve;
//! * [`fitted`]: a fitted loop beside its recording.

pub mod actions;
pub mod fitted;
pub mod limit_cycle;
pub mod nyquist;
pub mod run;
