//! How often detectors of stiction are right, on loops with known truth.
//!
//! ```text
//! suite (frozen lists of loops) ──> any detector ──> Answer ──> Board ──> page, tables
//!                                   verdict, methods     └────> bench (results, leaderboard)
//! ```
//!
//! * [`scoreboard`]: counts of the verdict, the methods and any other detector;
//! * [`suite`]: the frozen lists of loops of the benchmark;
//! * [`bench`](mod@bench): lines for any detector, results and the leaderboard;
//! * [`page`]: the scoreboard as tables and as a page;
//! * [`planned_tests`]: the accuracy of valve tests by a simulated operator.
//!
//! It uses the population, the diagnosis and the report. The lab and the plant use it, and never the reverse.
#![forbid(unsafe_code)]

pub mod bench;
pub mod page;
pub mod planned_tests;
pub mod scoreboard;
pub mod suite;

pub use planned_tests::{BANDS, TestTrial, TestTrialOptions, TestedLoops};
pub use stiction_figure::Error;
