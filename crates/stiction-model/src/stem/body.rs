//! Common parts of every kind of motion: the moving body, its travel, and the recorder.

use super::parameters::StemParameters;
use super::pressure::Drive;
use super::response::{Event, EventKind, Sample};
use crate::error::{Error, Result};
use crate::valve::Direction;

/// The moving body with its travel, unbounded without end stops, and the solver's tolerance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    pub(super) stem: StemParameters,
    pub(super) lower_m: f64,
    pub(super) upper_m: f64,
    pub(super) tolerance: f64,
}

impl Body {
    pub(super) fn new(parameters: &StemParameters, tolerance: f64) -> Self {
        let (lower_m, upper_m) = if parameters.end_stops {
            (0.0, parameters.stroke_m)
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        };
        Self { stem: *parameters, lower_m, upper_m, tolerance }
    }

    /// Absolute tolerance of positions, m; per second, the tolerance of velocities.
    pub(super) fn resolution_m(&self) -> f64 {
        self.tolerance * self.stem.stroke_m
    }

    /// Remaining distance to the end stop ahead, m; infinite without end stops.
    pub(super) fn room_m(&self, position_m: f64, direction: Direction) -> f64 {
        match direction {
            Direction::Up => self.upper_m - position_m,
            Direction::Down => position_m - self.lower_m,
        }
    }

    /// `position_m`, but not beyond an end stop by rounding.
    pub(super) fn within(&self, position_m: f64) -> f64 {
        position_m.clamp(self.lower_m, self.upper_m)
    }

    /// Whether an end stop forbids motion in `direction`.
    pub(super) fn blocked(&self, position_m: f64, direction: Direction) -> bool {
        self.room_m(position_m, direction) <= 0.0
    }

    /// The end stop ahead, m.
    pub(super) fn stop_m(&self, direction: Direction) -> f64 {
        match direction {
            Direction::Up => self.upper_m,
            Direction::Down => self.lower_m,
        }
    }

    /// Net force without friction, N.
    pub(super) fn net_n(&self, drive: &Drive, position_m: f64) -> f64 {
        self.stem.net_force_n(drive.pressure_pa, position_m)
    }
}

/// The direction of a force or velocity; up for 0.
pub(super) fn direction_of(value: f64) -> Direction {
    if value < 0.0 { Direction::Down } else { Direction::Up }
}

/// Collects samples at given times, and events.
#[derive(Debug, Clone, Default)]
pub(super) struct Recorder<'a> {
    times_s: &'a [f64],
    pub(super) samples: Vec<Sample>,
    pub(super) events: Vec<Event>,
    /// Number of motion starts and reversals of the stem.
    pub(super) slips: usize,
}

impl<'a> Recorder<'a> {
    /// For samples at ascending `times_s`.
    pub(super) fn new(times_s: &'a [f64]) -> Self {
        Self { times_s, samples: Vec::with_capacity(times_s.len()), ..Self::default() }
    }

    /// Records the samples due before `end_s`; `at` gives the state at a time since `start_s`.
    pub(super) fn until(&mut self, start_s: f64, end_s: f64, mut at: impl FnMut(f64) -> State) {
        while let Some(&time_s) = self.times_s.get(self.samples.len()) {
            if time_s >= end_s {
                return;
            }
            self.samples.push(at((time_s - start_s).max(0.0)).sampled(time_s));
        }
    }

    /// Records the remaining samples.
    pub(super) fn finish(&mut self, state: State) {
        for time_s in &self.times_s[self.samples.len()..] {
            self.samples.push(state.sampled(*time_s));
        }
    }

    /// Resets the record.
    pub(super) fn clear(&mut self) {
        self.events.clear();
        self.slips = 0;
    }

    pub(super) fn event(
        &mut self,
        time_s: f64,
        kind: EventKind,
        direction: Direction,
        position_m: f64,
    ) {
        self.events.push(Event { time_s, kind, direction, position_m });
    }
}

/// A sample without its time.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub(super) position_m: f64,
    pub(super) velocity_m_per_s: f64,
    pub(super) friction_n: f64,
    pub(super) pressure_pa: f64,
}

impl State {
    pub(super) fn sampled(self, time_s: f64) -> Sample {
        Sample {
            time_s,
            position_m: self.position_m,
            velocity_m_per_s: self.velocity_m_per_s,
            friction_n: self.friction_n,
            pressure_pa: self.pressure_pa,
        }
    }
}

/// Counts changes of mode without time in between; too many would be chattering.
#[derive(Debug, Default)]
pub(super) struct Progress {
    without: u32,
}

impl Progress {
    /// Records a mode that lasted `elapsed` and ended at `time_s`.
    pub(super) fn note(&mut self, elapsed: f64, time_s: f64) -> Result<()> {
        const MOST: u32 = 64;
        self.without = if elapsed > 0.0 { 0 } else { self.without + 1 };
        if self.without < MOST {
            return Ok(());
        }
        Err(Error::Solver {
            method: "stick-slip event logic",
            time_s,
            reason: "the stem changed between sticking and slipping without time passing"
                .to_owned(),
        })
    }
}

/// A solver's error, with its time counted from the start of the simulation.
pub(super) fn delayed(error: Error, start_s: f64) -> Error {
    match error {
        Error::Solver { method, time_s, reason } => {
            Error::Solver { method, time_s: start_s + time_s, reason }
        }
        other => other,
    }
}
