//! A temperature behind a pipe with the flow that controls it.

use super::parts::{Line, Parts};
use super::sketch::Sketch;
use std::collections::VecDeque;

/// A heater heats the total flow, so the temperature is inverse to the flow. It is measured behind a pipe whose
/// transport time is the dead time at rest, and shorter with a larger flow.
pub(super) struct TransportByFlow {
    rest: f64,
    /// The flow, relative to the flow at rest.
    flow: f64,
    /// The total flow, in steps at rest, at which each value in the pipe entered, and the volume of the pipe.
    pipe: VecDeque<(f64, f64)>,
    flowed: f64,
    holds: f64,
    /// The last output value.
    out: f64,
    /// Start of the record, steps, and the smallest and largest flow since.
    begins: usize,
    range: (f64, f64),
}

impl TransportByFlow {
    pub fn of(sketch: &Sketch) -> Self {
        Self {
            rest: sketch.rest,
            flow: 1.0,
            pipe: VecDeque::new(),
            flowed: 0.0,
            holds: sketch.dead as f64,
            out: 0.0,
            begins: sketch.warm_up(),
            range: (f64::INFINITY, 0.0),
        }
    }
}

impl Parts for TransportByFlow {
    fn steepest(&self) -> f64 {
        1.5
    }

    fn flow(&mut self, k: usize, stem: f64) -> f64 {
        // A shut valve leaks.
        self.flow = (1.0 + stem / self.rest).max(0.2);
        if k >= self.begins {
            self.range = (self.range.0.min(self.flow), self.range.1.max(self.flow));
        }
        self.rest * (1.0 - 1.0 / self.flow)
    }

    fn late(&mut self, _line: &mut Line, value: f64) -> f64 {
        self.flowed += self.flow;
        self.pipe.push_back((self.flowed, value));
        while let Some((came, value)) = self.pipe.front()
            && *came <= self.flowed - self.holds
        {
            self.out = *value;
            self.pipe.pop_front();
        }
        self.out
    }

    fn shows(&self) -> bool {
        self.range.1 >= 1.15 * self.range.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketch};
    use super::*;

    /// Steps until a value comes out, and what a percent more of flow does, with this opening, percent from rest.
    fn delay_and_gain(stem: f64) -> (usize, f64, usize) {
        let sketch = sketch(Invention::TransportByFlow, 5);
        let mut parts = TransportByFlow::of(&sketch);
        let stem = stem * sketch.rest;
        let gain = (parts.flow(0, stem + 0.01) - parts.flow(0, stem)) / 0.01;
        let mut line = Line::of(0);
        for _ in 0..1000 {
            parts.flow(0, stem);
            parts.late(&mut line, 1.0);
        }
        let after = (0..).find(|_| {
            parts.flow(0, stem);
            parts.late(&mut line, 2.0) == 2.0
        });
        (after.unwrap(), gain, sketch.dead)
    }

    #[test]
    fn half_the_flow_takes_twice_the_time_and_does_four_times_as_much() {
        let (at_rest, gain, dead) = delay_and_gain(0.0);
        assert!(at_rest.abs_diff(dead) <= 1 && (gain - 1.0).abs() < 0.01, "{at_rest} {gain}");
        let (at_half, gain, _) = delay_and_gain(-0.5);
        assert!(at_half.abs_diff(2 * dead) <= 1 && (gain - 4.0).abs() < 0.05, "{at_half} {gain}");
        let (at_double, gain, _) = delay_and_gain(1.0);
        assert!(at_double.abs_diff(dead / 2) <= 1 && (gain - 0.25).abs() < 0.01);
    }
}
