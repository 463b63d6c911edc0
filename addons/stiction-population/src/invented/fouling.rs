//! A heat exchanger that fouls.

use super::parts::Parts;
use super::sketch::Sketch;
use std::f64::consts::TAU;

/// The record is taken as a week of five to nine days, whatever its length. The load swings with the day. Fouling
/// decreases the heat that a percent of the valve transfers, and a cleaning restores it at once.
pub(super) struct Fouling {
    /// Steps of a day and from cleaning to cleaning, and those since the last cleaning at step 0.
    day: f64,
    campaign: f64,
    since: f64,
    /// Resistance of the dirt before a cleaning, relative to the clean exchanger.
    dirt: f64,
    /// The valve's duty at rest, and the daily load, percent.
    duty: f64,
    daily: f64,
}

impl Fouling {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let week = sketch.recorded() as f64;
        let campaign = week / draw.uniform(0.7, 3.0);
        Self {
            day: week / draw.uniform(5.0, 9.0),
            campaign,
            since: campaign * draw.unit(),
            dirt: draw.log(0.3, 1.2),
            duty: (sketch.size * draw.log(0.5, 3.0)).min(15.0),
            daily: (sketch.size * draw.log(0.2, 1.0)).min(10.0),
        }
    }
}

impl Parts for Fouling {
    fn flow(&mut self, k: usize, stem: f64) -> f64 {
        let dirty = ((k as f64 + self.since) / self.campaign).fract();
        let transfers = 1.0 / (1.0 + self.dirt * dirty);
        let load = self.daily * (TAU * k as f64 / self.day).sin();
        transfers * (self.duty + stem) - self.duty + load
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn the_gain_falls_by_the_dirt_and_comes_back_with_a_cleaning() {
        for (seed, sketch) in sketches(Invention::Fouling) {
            let mut parts = Fouling::of(&sketch);
            let gains: Vec<f64> = (0..parts.campaign as usize + 1)
                .map(|k| parts.flow(k, 1.0) - parts.flow(k, 0.0))
                .collect();
            let (least, most) =
                gains.iter().fold((1.0_f64, 0.0_f64), |(a, b), g| (a.min(*g), b.max(*g)));
            let dirt = parts.dirt;
            assert!((most - 1.0).abs() < 0.02 && (least * (1.0 + dirt) - 1.0).abs() < 0.02);
            // It rises once, at the cleaning.
            let rises = gains.windows(2).filter(|g| g[1] > g[0]).count();
            assert_eq!(rises, 1, "{seed}");
        }
    }
}
