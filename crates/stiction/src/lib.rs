//! Sticking control valves: models with known truth, the loops around them, and the diagnosis of
//! recorded loops.
//!
//! * [`Bands`]: how much a valve sticks; S and J against static and dynamic friction bands.
//! * [`valve`]: from controller output to valve position, sample by sample; every published
//!   data-driven model behind one trait, by name, and many candidates at once.
//! * [`stem`]: the physical valve, its friction laws, and the map to S and J.
//! * [`closed_loop`]: signals, processes, controllers, loops, cascades, and sweeps of loops.
//! * [`limit_cycle`]: the limit cycles of a loop, by describing function and exactly.
//! * [`compensate`]: what can be put between controller and sticking valve, and what it buys.
//! * [`population`]: simulated loops with known truth, to train and to measure on.
//! * [`recording`]: a loop as a plant recorded it; whether it can answer.
//! * [`oscillation`]: whether a loop cycles, how regularly, with what period.
//! * [`detect`]: the published detectors of stiction, behind one trait and one registry.
//! * [`identify`]: linear models of the loop, and valve models fitted to OP and PV or a valve position.
//! * [`evidence`]: what a window of data says about the valve, as numbers free of units.
//! * [`fusion`]: the frozen model that makes probabilities and intervals of evidence.
//! * [`diagnose`]: from a recording to a verdict with its evidence.
//! * [`what_if`]: what repair, retuning, a compensator or a positioner would make of a loop.
//! * [`series`]: moments, correlation, spectra, crossings.
//!
//! Controller output (OP), valve position (VP), S and J are in percent of span, times in seconds,
//! the process value (PV) in its own units. The crate computes and does nothing else: no files, no
//! clock, no panics on bad input, and the same bytes for the same input on any number of threads.
//!
//! ```
//! use stiction::Bands;
//! use stiction::closed_loop::{ClosedLoop, Controller, Process};
//! use stiction::diagnose::{Options, diagnose};
//! use stiction::recording::Recording;
//! use stiction::valve::{Assembly, Model, Start, TwoPhase, Valve};
//!
//! // A valve: |54 - 50| exceeds fs = 3.5, so it slips, and then trails the input by fd = 1.5.
//! let mut valve = TwoPhase::new(Bands::from_s_j(5.0, 2.0)?);
//! valve.restart(Start::at_rest(50.0));
//! assert_eq!(valve.step(54.0), 52.5);
//!
//! // The same in a loop: it cycles.
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
//! // What would a plant's recording of it say?
//! let recording = Recording::regular("FIC101", 0.1, &run.op, Some(&run.pv), Some(&run.sp))?;
//! let diagnosis = diagnose(&recording, &Options::default())?;
//! let (_, oscillation) = diagnosis.oscillation().expect("there is a stretch to judge");
//! assert!(oscillation.found);
//! # Ok::<(), stiction::Error>(())
//! ```

pub mod detect;
pub mod diagnose;
pub mod evidence;
pub mod fusion;
pub mod identify;
pub mod oscillation;
pub mod population;
pub mod recording;
pub mod series;
pub mod what_if;

pub use stiction_model::{Bands, Error, Number, Result};
pub use stiction_model::{bands, closed_loop, compensate, limit_cycle, stem, valve};
use stiction_model::{error, numeric, simd};
