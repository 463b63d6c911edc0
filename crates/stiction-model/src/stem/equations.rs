//! The motion of a stem for an external solver: states, rates, and the guards that end a mode.

use super::body::Recorder;
use super::pressure::Drive;
use crate::numeric::radau;

/// Largest number of states of a motion: position, velocity, three deflections.
pub(super) const STATES: usize = 5;

/// Guards of a motion: the guards of our own solver, and one more for events that do not change the motion, at which
/// our own solver need not stop.
pub(super) const GUARDS: usize = radau::GUARDS + 1;

/// A motion as equations. Unused states and rates are 0, unused guards infinite.
pub(super) trait Equations {
    /// Number of states; `None` if the motion is not an ordinary differential equation.
    fn order(&self) -> Option<usize>;

    fn states(&self) -> [f64; STATES];

    fn place(&mut self, states: &[f64; STATES]);

    fn rates(&self, drive: &Drive, time_s: f64) -> [f64; STATES];

    /// Values that stay at least 0 until the present mode ends.
    fn guards(&self, drive: &Drive, time_s: f64) -> [f64; GUARDS];

    /// Changes to the next mode when `guard` has fallen below 0.
    fn pass(&mut self, guard: usize, drive: &Drive, time_s: f64, recorder: &mut Recorder<'_>);

    /// Whether the stem rests, or hardly moves.
    fn is_stuck(&self) -> bool;

    /// Sets the first drive.
    fn begin(&mut self, _drive: &Drive) {}

    /// Appends everything that determines the motion besides parameters, as plain numbers.
    fn remember(&self, memory: &mut Vec<f64>);

    /// Restores the motion; `None` if the numbers are too few.
    fn recall(&mut self, memory: &mut dyn Iterator<Item = f64>) -> Option<()>;
}
