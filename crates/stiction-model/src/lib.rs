//! Sticking control valves: models with known truth, and the loops around them.
//!
//! * [`Bands`]: the stiction of a valve; S and J against static and dynamic friction bands.
//! * [`valve`]: from controller output to valve position, sample by sample; every published
//!   data-driven model behind one trait, by name, and many candidates at once.
//! * [`stem`]: the physical valve, its friction laws, and the map to S and J.
//! * [`closed_loop`]: signals, processes, controllers, loops, cascades, and sweeps of loops.
//! * [`limit_cycle`]: the limit cycles of a loop, by describing function and exactly.
//! * [`compensate`]: compensators between controller and sticking valve, and their benefit.
//! * `drawing`, with the feature `figure`: figures of runs, cycles and actions.
//! * [`numeric`], [`simd`]: the underlying numerical methods, and the stepping of many loops at once.
//!
//! Controller output (OP), valve position (VP), S and J are in percent of span, times in seconds, the process value
//! (PV) in its own units. The crate only computes: no files, no clock, no panics on bad input, and the same bytes
//! for the same input on any number of threads.
//!
//! ```
//! use stiction_model::Bands;
//! use stiction_model::valve::{Start, TwoPhase, Valve};
//!
//! // |54 - 50| exceeds fs = 3.5, so it slips, and then trails the input by fd = 1.5.
//! let mut valve = TwoPhase::new(Bands::from_s_j(5.0, 2.0)?);
//! valve.restart(Start::at_rest(50.0));
//! assert_eq!(valve.step(54.0), 52.5);
//! # Ok::<(), stiction_model::Error>(())
//! ```

pub mod bands;
pub mod closed_loop;
pub mod compensate;
#[cfg(feature = "figure")]
pub mod drawing;
pub mod error;
#[cfg(feature = "serde")]
pub mod finite;
pub mod limit_cycle;
mod named;
mod number;
pub mod numeric;
pub mod parallel;
pub mod simd;
pub mod stem;
pub mod valve;

pub use bands::Bands;
pub use error::{Error, Result};
pub use number::Number;
