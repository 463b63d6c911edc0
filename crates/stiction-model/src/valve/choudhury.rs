//! The model of Choudhury, Thornhill and Shah.

use super::published::{Memory, Published, flag};
use super::{Description, Model, Motion, Start, Valve, ValveSpec};
use crate::bands::Bands;
use crate::error::Result;

/// Choudhury, Thornhill and Shah's two-parameter model, revised flow chart.
///
/// # Equations
/// With `v = u(k) - u(k-1)` and `us` the input at which the stem stopped:
/// ```text
/// sgn(v) = sgn(v_prev):
///     moving:                                        x = u - sgn(v) fd
///     stuck, sgn(u - us) sgn(us - x) = 1:            breaks away if |u - us| > J
///     stuck, otherwise:                              breaks away if |u - x| > fs
/// sgn(v) != sgn(v_prev):
///     moving:                                        us = u(k-1)
///     v = 0:                                         stuck
///     otherwise:                                     breaks away if |u - x| > fs, else stuck
/// breaking away:                                     x = u - sgn(v) fd
/// ```
/// A stem that stopped rests at `us - x = d fd`. So for `J <= S` the test `|u - us| > J` is equal to `|u - x| >
/// fs`, and the model equals [`TwoPhase`](super::TwoPhase). For `J > S` the flow chart applies the J test to
/// reversals instead of resumptions, and it is a different model.
///
/// Deviation: a stuck stem stays while the input is constant (`v = 0`). In the flow chart, rounding at an exact tie
/// could break it away there, to `x = u`.
///
/// # Parameters
/// [`Bands`] in percent of span; `J > S` is allowed, with the chart's own behaviour.
///
/// # References
/// M. A. A. S. Choudhury, N. F. Thornhill, S. L. Shah, "Modelling valve stiction", Control
/// Engineering Practice 13 (2005) 641-658; the revised chart as a public program states it.
#[derive(Debug, Clone, PartialEq)]
pub struct Choudhury {
    bands: Bands,
    position: f64,
    op: f64,
    /// Sign of the last change of input.
    trend: f64,
    /// Input at which the stem stopped.
    stop: f64,
    stuck: bool,
}

/// The sign of `v`, with `sgn(0) = 0` as in the flow chart.
fn sgn(v: f64) -> f64 {
    if v == 0.0 { 0.0 } else { 1f64.copysign(v) }
}

impl Choudhury {
    /// A valve with these friction bands, stuck at 0.
    pub fn new(bands: Bands) -> Self {
        let mut valve = Self { bands, position: 0.0, op: 0.0, trend: 0.0, stop: 0.0, stuck: true };
        valve.restart(Start::default());
        valve
    }

    /// The static test of the same-direction branch, `|u - us| > J`, in terms of `e = u - x`.
    fn resumes(&self, e: f64) -> bool {
        let fd = self.bands.fd();
        if fd < 0.0 { e.abs() > self.bands.j() - fd } else { self.bands.breaks(e) }
    }
}

impl Valve for Choudhury {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        let v = op - self.op;
        if !self.stuck && self.trend * v > 0.0 {
            // The most frequent case first: still moving in the same direction.
            self.op = op;
            self.position = op - self.trend * self.bands.fd();
            return self.position;
        }
        let trend = sgn(v);
        let e = op - self.position;
        if trend == self.trend {
            if self.stuck && trend != 0.0 {
                let away = sgn(op - self.stop) * sgn(self.stop - self.position) == 1.0;
                self.stuck = !(if away { self.resumes(e) } else { self.bands.breaks(e) });
            }
        } else {
            if !self.stuck {
                self.stop = self.op;
            }
            self.stuck = trend == 0.0 || !self.bands.breaks(e);
        }
        if !self.stuck {
            self.position = op - trend * self.bands.fd();
        }
        self.op = op;
        self.trend = trend;
        self.position
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn restart(&mut self, start: Start) {
        let direction = start.direction.sign();
        self.position = start.position;
        self.op = start.op;
        self.trend = if start.moving { direction } else { 0.0 };
        self.stop = start.position + direction * self.bands.fd();
        self.stuck = !start.moving;
    }
}

impl Published for Choudhury {
    const DESCRIPTION: Description = Description {
        name: "choudhury",
        aliases: &[],
        summary: "revised flow chart; equals two-phase for J <= S",
        citation: "Choudhury, Thornhill, Shah, Control Eng. Practice 13 (2005) 641-658",
        motion: Motion::Slides,
        uses_s: true,
        uses_j: true,
        uses_k: false,
        uses_rest_tolerance: false,
        same_as: Some(Model::TwoPhase),
    };

    fn build(spec: &ValveSpec, _: Option<f64>) -> Result<Self> {
        Ok(Self::new(spec.bands))
    }

    fn state(&self) -> Option<Start> {
        None
    }

    fn memory(&self) -> Memory {
        [self.position, self.op, self.trend, self.stop, flag(self.stuck)]
    }

    fn recall(&mut self, memory: &Memory) {
        let stuck;
        [self.position, self.op, self.trend, self.stop, stuck] = *memory;
        self.stuck = stuck != 0.0;
    }
}
