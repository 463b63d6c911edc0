//! A volume booster on one side of the stroke.

use super::parts::{Friction, Parts};
use super::sketch::Sketch;

/// A booster, or a quick exhaust, moves the valve one way at once. The other way all air passes the small port of the
/// positioner, and the pressure follows the OP with a lag. Friction acts between the pressure and the stem.
pub(super) struct OneSidedBooster {
    /// Whether opening is the fast way.
    opens: bool,
    /// Time constant of the slow way, steps, and its ratio to the waiting time of the controller.
    slow: f64,
    ratio: f64,
    /// Pressure in the actuator, percent.
    pressure: f64,
    /// The farthest that it was behind the OP, and the least that shows.
    behind: f64,
    least: f64,
}

impl OneSidedBooster {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let ratio = draw.log(0.5, 3.0);
        Self {
            opens: draw.chance(0.5),
            slow: ratio * sketch.waiting(),
            ratio,
            pressure: sketch.rest,
            behind: 0.0,
            least: 0.1 * sketch.size,
        }
    }
}

impl Parts for OneSidedBooster {
    fn steepest(&self) -> f64 {
        1.0 + 0.5 * self.ratio
    }

    fn stem(&mut self, valve: &mut Friction, op: f64) -> f64 {
        let away = op - self.pressure;
        let fast = (away > 0.0) == self.opens;
        self.pressure += if fast { away } else { away * (1.0 - (-1.0 / self.slow).exp()) };
        self.behind = self.behind.max((op - self.pressure).abs());
        valve.step(self.pressure)
    }

    fn shows(&self) -> bool {
        self.behind > self.least
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn one_way_is_at_once_and_the_other_takes_its_time() {
        let mut opening = 0;
        for (seed, sketch) in sketches(Invention::OneSidedBooster) {
            let mut parts = OneSidedBooster::of(&sketch);
            let mut valve = Friction::of(&sketch, false).unwrap();
            let slow = parts.slow.round() as usize;
            let fast_way = if parts.opens { 1.0 } else { -1.0 };
            let there = sketch.rest + fast_way * sketch.s;
            assert!((parts.stem(&mut valve, there) - there).abs() < 1e-9);
            let back: Vec<f64> = (0..slow).map(|_| parts.stem(&mut valve, sketch.rest)).collect();
            let left = (back.last().unwrap() - sketch.rest) * fast_way / sketch.s;
            // 37 % are left after a time constant.
            assert!((0.2..0.55).contains(&left), "{seed}: {left} after {slow}");
            opening += usize::from(parts.opens);
        }
        assert!((10..30).contains(&opening), "{opening} of 40");
    }
}
