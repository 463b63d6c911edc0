//! The physical stem: mass, spring, air pressure and friction.
//!
//! # Equations
//!
//! ```text
//! M x'' = Sa p - k x - Finit - F          force balance of stem and actuator
//! tau p' = demand - p                     air lag, if tau > 0
//! F = [Fc + (Fs - Fc) exp(-(v/vs)^2)] sgn v + Fv v     moving
//! F = Sa p - k x - Finit, at most Fs in size           at rest
//! ```
//!
//! `x` is the position of the stem in m (0 closed), `p` the air pressure in Pa. The friction above is the classical
//! law; [`FrictionLaw`] lists the others. Seat force and fluid force are neglected, as in the paper.
//!
//! # Corrections
//!
//! These are equations (1)-(6) of "Modelling and Dynamic Analysis of Pneumatic Control Valve with Stiction" with
//! its misprints corrected:
//!
//! * (2)-(3) read `M x1'' = x2''`, `M x2'' = ...` instead of `x1' = x2`, `M x2' = Sa u - k x1 - F`.
//! * (5) compares `Fc` instead of the net applied force: a resting stem is held by a friction equal to that force,
//!   up to `Fs`.
//! * (6), `Fv sgn v + (Fc - Fs) exp(-v/vs) sgn v`, has no Coulomb level, the wrong sign, a viscous part without
//!   velocity, and an exponent that grows for `v < 0`. The usual Stribeck form is used above.
//!
//! # Method
//!
//! Sticking and slipping are modes. The event that ends a mode is located by bracketed root-finding, and determines
//! the next mode, so the stem never chatters between the two. A slip under constant Coulomb and viscous friction is
//! advanced by its closed solution, all other motion by a Radau IIA integrator of order 5 with dense output.
//! Nothing depends on a sample time.
//!
//! # Example
//!
//! ```
//! use stiction_model::stem::{PressureSignal, Stem, StemStart};
//!
//! let stem = Stem::named("cts")?;
//! assert!((stem.equivalent()?.bands.j() - 5.343).abs() < 1e-3);
//!
//! let ramp = PressureSignal::from_points(vec![(0.0, 0.0), (100.0, 68_948.0)])?;
//! let response = stem.simulate(&ramp, StemStart::at_rest(0.0), &[50.0, 100.0])?;
//! let slip = response.slips().next().expect("the ramp overcomes static friction");
//! assert!((slip.time_s - 38.407).abs() < 1e-3);
//! # Ok::<(), stiction_model::Error>(())
//! ```
//!
//! # Contents
//!
//! * [`Stem`] and [`Stem::simulate`]: one valve, one pressure signal, samples and events.
//! * [`StemValve`]: the same behind [`crate::valve::Valve`], for loops.
//! * [`MovingStem`]: the same piece by piece, or as equations for an external solver.
//! * [`StemParameters`], [`ParameterSet`]: numbers, and sets of them by name.
//! * [`friction`]: one law, one file.
//! * [`Equivalent`]: S, J, overshoot, and whether the valve slides or moves in steps.

mod body;
mod bristle_motion;
mod equations;
mod equivalent;
pub mod friction;
mod linear;
mod moving_stem;
mod parameters;
mod pressure;
mod response;
mod simulate;
mod stem_valve;
mod stick_slip;
mod sticking_law;

pub use equivalent::{Equivalent, SlidingKind};
pub use friction::FrictionLaw;
pub use moving_stem::MovingStem;
pub use parameters::{ParameterSet, SETS, StemParameters};
pub use pressure::PressureSignal;
pub use response::{Event, EventKind, Response, Sample, StemStart};
pub use simulate::Stem;
pub use stem_valve::StemValve;
