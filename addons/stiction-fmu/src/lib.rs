//! Sticking control valves as functional mock-up units (FMU), for FMI 2.0 and 3.0.
//!
//! One library, the same in every FMU. `resources/stiction.json` beside it gives the model and start values of an
//! instance. An [`Fmu`] writes that file and its `modelDescription.xml`:
//!
//! ```
//! use stiction_fmu::{Fmi, Fmu};
//!
//! let fmu = Fmu::new("valve", "two-phase")?.with("S", 5.0)?.with("J", 2.0)?;
//! let json = fmu.json();                   // resources/stiction.json
//! let xml = fmu.xml(Fmi::V2, None);        // modelDescription.xml
//! assert_eq!(Fmu::from_json(&json)?.json(), json);
//! assert!(xml.contains(r#"name="S" valueReference="5""#));
//! # Ok::<(), String>(())
//! ```
//!
//! The library goes to `binaries/linux64/stiction_valve_two_phase.so` for FMI 2.0 and to
//! `binaries/x86_64-linux/stiction_valve_two_phase.so` for FMI 3.0, and so on for other models and platforms
//! ([`Fmu::binary`]).
//!
//! # Time
//!
//! * A data-driven valve takes one sample in each step: the OP is held over the step, and the VP at the end of the
//!   step is the response to this OP. The step is the sample time, and may change.
//! * A physical stem is integrated over the step with the OP held, and its events are located. The step only
//!   matters for the hold itself. In model exchange the importer integrates, and finds the events by their
//!   indicators; the OP may then vary freely.
//! * A loop runs all of its own samples within the step, including the start but not the end of the step. Its outputs are those
//!   of the last sample.
//!
//! # Structure
//!
//! `variables` is the one table of a model's variables. `model` is the interface of a model, for any version of
//! FMI. `valve`, `stem` and `sticky_loop` are the models. `fmu` chooses one, and `json` and `description` write its
//! files. `instance` checks the permitted calls. `fmi2` and `fmi3` are the functions for an importer; all `unsafe`
//! code is there and in `boundary`.
#![deny(unsafe_code)]

mod boundary;
mod description;
pub mod fmi2;
pub mod fmi3;
mod fmu;
mod instance;
mod json;
mod model;
mod resources;
mod stem;
mod sticky_loop;
mod valve;
mod variables;

pub use description::Fmi;
pub use fmu::{Fmu, ModelEntry, models};
pub use variables::{Causality, Variability, Variable, VariableKind};
