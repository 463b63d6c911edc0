//! The parts of a loop, with ordinary defaults.

use super::sketch::Sketch;
use std::collections::VecDeque;
use stiction_model::bands::Bands;
use stiction_model::error::Result;
use stiction_model::stem::{ParameterSet, StemValve};
use stiction_model::valve::{Start, Valve};

/// The behaviour of a loop's parts in a step; a kind replaces some of the ordinary ones. Positions, flows and loads
/// are in percent from rest, the PV and its set point in percent of span from rest.
pub(super) trait Parts {
    /// The largest gain relative to the gain of the process, for the tuning.
    fn steepest(&self) -> f64 {
        1.0
    }

    /// The set point at step `k`.
    fn set_point(&mut self, _k: usize) -> f64 {
        0.0
    }

    /// The output of the transmitter under this noise.
    fn sensed(&mut self, _k: usize, pv: f64, noise: f64) -> f64 {
        pv + noise
    }

    /// The OP, percent, for this difference of set point and PV.
    fn op(&mut self, _k: usize, pi: &mut Pi, error: f64) -> f64 {
        pi.step(error)
    }

    /// The stem position, percent, for this OP.
    fn stem(&mut self, valve: &mut Friction, op: f64) -> f64 {
        valve.step(op)
    }

    /// The flow at this stem position.
    fn flow(&mut self, _k: usize, stem: f64) -> f64 {
        stem
    }

    /// Additional load from the PV.
    fn load(&mut self, _pv: f64) -> f64 {
        0.0
    }

    /// Output of the dead time for this input.
    fn late(&mut self, line: &mut Line, value: f64) -> f64 {
        line.step(value)
    }

    /// The PV, from the output of the lags.
    fn pv(&mut self, lagged: f64) -> f64 {
        lagged
    }

    /// Whether the record shows the peculiarity of the kind so far.
    fn shows(&self) -> bool {
        true
    }
}

/// A loop without a peculiarity.
pub(super) struct Ordinary;

impl Parts for Ordinary {}

/// A PI controller, tuned by internal model control.
pub(super) struct Pi {
    pub kc: f64,
    pub ti: f64,
    /// Without integral action.
    proportional_only: bool,
    /// The OP at rest, percent.
    pub rest: f64,
    /// The integral part.
    pub integral: f64,
}

impl Pi {
    /// For a process whose gain is at most `steepest` times the drawn one.
    pub fn of(sketch: &Sketch, steepest: f64) -> Self {
        let slow = sketch.lags[0];
        let waiting = sketch.waiting();
        let wanted = sketch.slowness * waiting;
        Self {
            kc: slow / (sketch.gain * steepest * (wanted + waiting)),
            ti: slow.min(4.0 * (wanted + waiting)),
            proportional_only: sketch.proportional_only,
            rest: sketch.rest,
            integral: 0.0,
        }
    }

    /// The OP, percent.
    pub fn step(&mut self, error: f64) -> f64 {
        if !self.proportional_only {
            self.integral = (self.integral + self.kc * error / self.ti).clamp(-60.0, 60.0);
        }
        (self.rest + self.kc * error + self.integral).clamp(0.0, 100.0)
    }

    /// Continues without a bump from an OP of another source.
    pub fn track(&mut self, op: f64, error: f64) {
        self.integral = (op - self.rest - self.kc * error).clamp(-60.0, 60.0);
    }
}

/// A valve: it sticks, or its stem is at the OP.
pub(super) struct Friction {
    model: Option<Box<dyn Valve>>,
    /// The stem position, percent.
    pub stem: f64,
}

impl Friction {
    /// At rest.
    ///
    /// # Errors
    /// If the bands are invalid.
    pub fn of(sketch: &Sketch, sticks: bool) -> Result<Self> {
        let bands = Bands::from_s_j(sketch.s, sketch.j)?;
        let mut model: Option<Box<dyn Valve>> = match (sticks, sketch.physical) {
            (false, _) => None,
            (true, None) => Some(Box::new(sketch.model.build(bands)?)),
            (true, Some(set)) => {
                let set = ParameterSet::named(set)?;
                let stem = &set.stem;
                let newton = stem.area_m2 * (stem.pressure_max_pa - stem.pressure_min_pa) / 100.0;
                let friction =
                    [("static_n", newton * bands.fs()), ("coulomb_n", newton * bands.fd())];
                let stem = set.stem_with(None, &friction)?;
                let step = sketch.sample_time / sketch.steps as f64;
                Some(Box::new(StemValve::new(stem, step)?))
            }
        };
        if let Some(model) = &mut model {
            model.restart(Start::at_rest(sketch.rest));
        }
        Ok(Self { model, stem: sketch.rest })
    }

    pub fn sticks(&self) -> bool {
        self.model.is_some()
    }

    /// The stem position for this OP.
    pub fn step(&mut self, op: f64) -> f64 {
        self.stem = self.model.as_mut().map_or(op, |model| model.step(op));
        self.stem
    }

    /// The stem position without friction.
    pub fn slide(&mut self, op: f64) -> f64 {
        if let Some(model) = &mut self.model {
            model.restart(Start::at_rest(op));
        }
        self.stem = op;
        op
    }
}

/// A dead time.
pub(super) struct Line(VecDeque<f64>);

impl Line {
    /// Of this many steps.
    pub fn of(steps: usize) -> Self {
        Self(vec![0.0; steps].into())
    }

    /// Output for this input.
    pub fn step(&mut self, value: f64) -> f64 {
        self.0.push_back(value);
        self.0.pop_front().unwrap_or(value)
    }
}
