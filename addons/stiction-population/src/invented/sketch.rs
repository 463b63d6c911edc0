//! A drawn loop.

use super::Invention;
use crate::draw::Draw;
use stiction_model::valve::Model;

/// A drawn loop. One step is a step of the controller, unless the controller moves less often.
pub(super) struct Sketch {
    pub samples: usize,
    /// Steps a recorded sample.
    pub steps: usize,
    pub sample_time: f64,
    pub s: f64,
    pub j: f64,
    pub model: Model,
    /// The parameter set of a physical stem in place of the model.
    pub physical: Option<&'static str>,
    /// Process: two lags and a dead time, steps; percent per percent.
    pub gain: f64,
    pub lags: [f64; 2],
    pub dead: usize,
    /// The closed loop's time constant over the dead time and small lag.
    pub slowness: f64,
    pub proportional_only: bool,
    /// Steps between moves of a predictive controller, and the error of its model.
    pub every: usize,
    pub wrong: f64,
    pub rest: f64,
    pub noise: f64,
    pub load: f64,
    pub load_keep: f64,
    pub steps_of_load: usize,
    /// Quantities of the kind: a size in percent, a period in steps (of a beat, in samples), a share.
    pub size: f64,
    pub period: f64,
    pub share: f64,
    pub unit: (f64, f64),
    pub seed: u64,
}

/// Quantities with different ranges in each set, uniform in the logarithm.
struct Ranges {
    slowness: (f64, f64),
    /// Standard deviation of the noise over gain times S.
    noise: (f64, f64),
    /// Duration of the load, over the large lag.
    load_lasts: (f64, f64),
}

const FIRST: Ranges = Ranges { slowness: (0.8, 5.0), noise: (0.01, 0.4), load_lasts: (1.0, 30.0) };
/// Few sticking valves of the first set were visible, because loads changed as fast as the loop.
const SECOND: Ranges =
    Ranges { slowness: (0.6, 3.0), noise: (0.003, 0.08), load_lasts: (20.0, 300.0) };

impl Sketch {
    pub fn draw(what: Invention, draw: &mut Draw) -> Self {
        let ranges = if Invention::FIRST.contains(&what) { FIRST } else { SECOND };
        let s = draw.log(0.5, 9.0);
        let steps = draw.one_of([1, 1, 1, 2, 4]);
        let slow = draw.log(2.0, 40.0);
        let period = match what {
            Invention::RingingPositioner => draw.log(5.0, 25.0),
            // Beats of 20 to 300 samples.
            Invention::Aliasing => 1.0 + draw.sign() / draw.log(20.0, 300.0),
            _ => draw.log(40.0, 400.0),
        };
        Self {
            samples: draw.log(500.0, 4000.0) as usize,
            steps,
            sample_time: draw.one_of([0.5, 1.0, 2.0, 5.0, 10.0, 30.0]),
            s,
            j: s * match what {
                // Without a jump it would not be one-sided, and would not age.
                Invention::OneSidedFriction | Invention::AgeingFriction => draw.uniform(0.3, 0.9),
                _ => draw.uniform(0.05, 1.0),
            },
            model: draw.weighted([(Model::TwoPhase, 0.6), (Model::He, 0.4)]),
            physical: None,
            gain: draw.log(0.4, 2.5) * draw.sign(),
            lags: [slow, slow * draw.uniform(0.05, 0.6)],
            dead: match what {
                Invention::TransportByFlow => {
                    draw.count(2 + (0.3 * slow) as usize, 3 + (1.2 * slow) as usize)
                }
                _ => draw.count(1, 1 + (0.7 * slow) as usize),
            },
            slowness: draw.log(ranges.slowness.0, ranges.slowness.1),
            proportional_only: draw.chance(0.1),
            every: draw.count(2, 10) * steps,
            wrong: draw.log(0.5, 2.0),
            rest: match what {
                Invention::NearTheSeat => draw.uniform(6.0, 14.0),
                // Moves of S are then a relevant part of the flow.
                Invention::TransportByFlow => (s * draw.uniform(2.5, 8.0)).clamp(6.0, 40.0),
                Invention::SurgeControl => draw.uniform(15.0, 35.0),
                _ => draw.uniform(30.0, 70.0),
            },
            noise: s * draw.log(ranges.noise.0, ranges.noise.1),
            load: s * draw.log(0.1, 1.5),
            load_keep: 1.0 - 1.0 / (slow * draw.log(ranges.load_lasts.0, ranges.load_lasts.1)),
            steps_of_load: draw.count(0, 4),
            size: s * draw.log(0.4, 3.0),
            period,
            share: draw.uniform(0.15, 0.4),
            unit: (draw.uniform(-50.0, 300.0), draw.log(0.05, 30.0)),
            seed: draw.seed(),
        }
    }

    /// The loop, recorded for `factor` times as many samples.
    pub fn lasting(self, factor: f64) -> Self {
        let times = |n: usize| (n as f64 * factor).round() as usize;
        Self { samples: times(self.samples), steps_of_load: times(self.steps_of_load), ..self }
    }

    /// The random stream of the kind alone.
    pub fn of_kind(&self) -> Draw {
        Draw::of(&[self.seed, 1])
    }

    /// Waiting time of the controller: dead time, small lag and one step.
    pub fn waiting(&self) -> f64 {
        self.dead as f64 + self.lags[1] + 1.0
    }

    /// Steps before the record begins.
    pub fn warm_up(&self) -> usize {
        400 + 20 * self.lags[0] as usize
    }

    /// Steps of the record.
    pub fn recorded(&self) -> usize {
        self.samples * self.steps
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub use crate::Invention;

    /// The first sketch of this kind and seed.
    pub fn sketch(what: Invention, seed: u64) -> Sketch {
        Sketch::draw(what, &mut Draw::of(&[what as u64, seed]))
    }

    /// Forty sketches of a kind, with their seeds.
    pub fn sketches(what: Invention) -> impl Iterator<Item = (u64, Sketch)> {
        (0..40).map(move |seed| (seed, sketch(what, seed)))
    }
}
