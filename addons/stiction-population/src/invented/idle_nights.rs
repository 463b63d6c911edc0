//! A plant that runs by day.

use super::parts::{Parts, Pi};
use super::sketch::Sketch;

/// The record is taken as three to nine days, whatever its length. At night the pump is off: the valve has no effect,
/// and the PV falls to the value without flow. The OP stays where it was, or is parked, and the controller continues
/// from there in the morning. Turbulence makes a part of the noise, and stops with the pump.
pub(super) struct IdleNights {
    /// Steps of a day, of which the last steps are the night, and the step of the day at step 0.
    day: usize,
    night: usize,
    since: usize,
    /// OP at night, percent; `None` if the OP stays unchanged.
    parked: Option<f64>,
    /// Whether the controller continues from there. A P controller has its own bias.
    continues: bool,
    /// The flow that stops, percent, and the share of the noise that remains.
    stops: f64,
    quiet: f64,
    /// The last OP.
    last: f64,
}

impl IdleNights {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let day = (sketch.recorded() as f64 / draw.uniform(3.0, 9.0)) as usize;
        Self {
            day,
            night: (day as f64 * draw.uniform(0.3, 0.6)) as usize,
            since: draw.count(0, day - 1),
            parked: draw.chance(0.5).then(|| draw.uniform(5.0, 25.0)),
            continues: !sketch.proportional_only,
            stops: (sketch.size * draw.log(0.5, 4.0)).min(25.0),
            quiet: draw.log(0.1, 1.0),
            last: sketch.rest,
        }
    }

    fn idle(&self, k: usize) -> bool {
        (k + self.since) % self.day >= self.day - self.night
    }
}

impl Parts for IdleNights {
    fn sensed(&mut self, k: usize, pv: f64, noise: f64) -> f64 {
        pv + if self.idle(k) { self.quiet * noise } else { noise }
    }

    fn op(&mut self, k: usize, pi: &mut Pi, error: f64) -> f64 {
        if self.idle(k) {
            self.last = self.parked.unwrap_or(self.last);
            if self.continues {
                pi.track(self.last, error);
            }
        } else {
            self.last = pi.step(error);
        }
        self.last
    }

    fn flow(&mut self, k: usize, stem: f64) -> f64 {
        if self.idle(k) { -self.stops } else { stem }
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn at_night_nothing_moves_and_in_the_morning_nothing_jumps() {
        let mut parked = 0;
        for (seed, mut sketch) in sketches(Invention::IdleNights) {
            (sketch.rest, sketch.proportional_only) = (40.0, false);
            let mut parts = IdleNights::of(&sketch);
            let days = sketch.recorded() as f64 / parts.day as f64;
            assert!((3.0..9.2).contains(&days), "{days}");
            parts.since = 0;
            let mut pi = Pi::of(&sketch, 1.0);
            // Of an error whose proportional part is 1 %.
            let error = 1.0 / pi.kc;
            let op: Vec<f64> = (0..=parts.day).map(|k| parts.op(k, &mut pi, error)).collect();
            let evening = parts.day - parts.night;
            assert!(op[evening..parts.day].iter().all(|u| *u == op[evening]));
            assert!((op[parts.day] - op[evening]).abs() <= 1.0 / pi.ti + 1e-9, "{seed}");
            assert_eq!(op[evening] == op[evening - 1], parts.parked.is_none(), "{seed}");
            assert_eq!(parts.flow(evening, 5.0), parts.flow(evening, -5.0));
            assert_eq!(parts.flow(evening - 1, 5.0), 5.0);
            parked += usize::from(parts.parked.is_some());
        }
        assert!((10..30).contains(&parked), "{parked} of 40");
    }
}
