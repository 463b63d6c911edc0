//! Does this valve stick? Diagnosis of a valve from a recorded control loop.
//!
//! * [`methods`]: the methods, a folder each, behind one registry.
//! * [`identify`]: linear models of the loop, and valve models fitted to OP and PV or a valve position.
//! * [`evidence`]: the evidence in a window of data, as numbers without units.
//! * [`fusion`]: the frozen model from evidence to probabilities and intervals.
//! * [`diagnose`]: from a recording to a verdict with its evidence.
//! * `drawing`, with the feature `figure`: the common parts of the methods' figures.
//! * [`valve_test`]: a test that shows whether a valve sticks, with its plan, its search and its judgement.
//! * [`what_if`]: the effect of repair, retuning, a compensator or a positioner on a loop.
//!
//! [`recording`], [`oscillation`], [`finding`], [`series`] and [`spoken`] are the modules of [`stiction_recording`].
//!
//! Controller output (OP), valve position (VP), S and J are in percent of span, times in seconds, the process value
//! (PV) in its own units. The crate only computes: no files, no clock, no panics on bad input, and the same bytes
//! for the same input on any number of threads. The valves and loops themselves are [`stiction_model`].
//!
//! ```
//! use stiction_diagnose::diagnose::{DiagnoseOptions, diagnose};
//! use stiction_diagnose::recording::Recording;
//! use stiction_model::closed_loop::{ClosedLoop, Controller, Process};
//! use stiction_model::valve::{Assembly, Model};
//! use stiction_model::Bands;
//!
//! // A loop whose valve sticks: it cycles.
//! let model = Model::by_name("two-phase")?.build(Bands::from_s_j(5.0, 2.0)?)?;
//! let mut sticky = ClosedLoop::new(
//!     Controller::pi(1.1, 2.5)?,
//!     Assembly::new(model),
//!     Process::first_order(1.5, 5.93, 1.07)?,
//! );
//! sticky.set_point = 5.0.into();
//! let run = sticky.run()?;
//! assert!(run.period_s().is_some_and(|period| (21.0..24.0).contains(&period)));
//!
//! // Diagnose a recording of it.
//! let recording = Recording::regular("FIC101", 0.1, &run.op, Some(&run.pv), Some(&run.sp))?;
//! let diagnosis = diagnose(&recording, &DiagnoseOptions::default())?;
//! let (_, oscillation) = diagnosis.oscillation().expect("there is a segment to judge");
//! assert!(oscillation.found);
//! # Ok::<(), stiction_model::Error>(())
//! ```
#![forbid(unsafe_code)]

mod cause;
pub mod diagnose;
#[cfg(feature = "figure")]
pub mod drawing;
pub mod evidence;
pub mod fit;
pub mod fusion;
pub mod identify;
pub mod methods;
#[cfg(test)]
#[path = "../../stiction-recording/src/oscillation/test_signals.rs"]
mod test_signals;
pub mod valve_test;
pub mod what_if;

pub use stiction_model::Number;
pub use stiction_recording::{finding, oscillation, recording, series, spoken};
stiction_model::written_by_name!(
    diagnose::Basis,
    diagnose::Cause,
    diagnose::change::Change,
    diagnose::Grade,
    diagnose::Mismatch,
    diagnose::RepairOutcome,
    diagnose::Ruling,
    diagnose::Silence,
    diagnose::VerdictClass,
    evidence::Line,
    identify::controller::Structure,
    identify::fopdt::ProcessKind,
    valve_test::Effect,
);
use stiction_model::{
    Bands, Error, bands, closed_loop, compensate, error, limit_cycle, numeric, parallel, simd,
    stem, valve,
};
use stiction_recording::estimate;
