//! Control loops around a sticking valve, in discrete time.
//!
//! ```text
//! sp ──> controller ── op ──> valve ── vp ──(+)──> process, dead time ──(+)──> pv
//!            ^                               load                measurement    │
//!            └──────────────────────────────────────────────────────────────────┘
//! ```
//! One sample: the PV is read, the controller computes its output, the valve moves, and the process advances to the
//! next sample with the valve position held. With a PI controller, a first-order process and no disturbance the
//! loop is
//! ```text
//! e = sp - pv,  I = I + Kc/Ti Ts e,  op = Kc e + I,  vp = valve(op)
//! pv(k+1) = a pv(k) + Kp (1 - a) vp(k - n),   a = exp(-Ts/tau),  n = theta/Ts
//! ```

mod bank;
mod between;
mod cascade;
mod controller;
mod cycle;
mod description;
mod manual;
mod open_loop;
mod own;
mod player;
mod process;
mod random;
mod signal;
mod simulate;
mod sweep;

pub use bank::quantised;
pub use between::{Between, IntegralAction, Sent};
pub use cascade::{Cascade, CascadeRun};
pub use controller::{AntiWindup, Controller, DerivativeOn, Form, Handover};
pub use controller::{Engaged, PidBank};
pub use cycle::period;
pub use description::ClosedLoop;
pub use manual::Manual;
pub use open_loop::{OpenLoop, OpenLoopRun};
pub use own::{Own, OwnController, OwnProcess};
pub use player::{Played, Player};
pub use process::{DeadTime, Process, SampledProcess};
pub use process::{DelayLine, ProcessBank};
pub use random::NormalStream;
pub use signal::{Signal, SignalSource, Wave};
pub use simulate::Run;
pub use sweep::{Statistics, sweep};
