//! Loops drawn from all possible ones.

use super::FitOptions;
use super::valve::Weighed;
use crate::bands::Bands;
use crate::closed_loop::{Controller, NormalStream, Process};
use crate::fusion::Estimate;
use crate::identify::controller::FittedController;
use crate::limit_cycle::ContinuousLoop;
use crate::valve::Model;

/// A loop that agrees with the recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    /// The controller.
    pub controller: Controller,
    /// The process behind the valve.
    pub process: Process,
    /// The valve's model.
    pub model: Model,
    /// Bands, percent of span.
    pub bands: Bands,
    /// Time between two executions of the controller, s, or half of that between two samples if it is not known.
    pub execution_s: f64,
}

impl Draw {
    /// Static gain from stem to PV, in units of the PV per percent; `None` for an integrating process.
    pub fn lasting_gain(&self) -> Option<f64> {
        let (above, below) = self.process.coefficients();
        let (above, below) = (above.last()?, below.last()?);
        (*below != 0.0).then(|| above / below)
    }

    /// The loop in continuous time. A controller with an execution interval responds half that time later.
    pub fn continuous(&self) -> ContinuousLoop {
        let process = self.process.clone().delayed(0.5 * self.execution_s);
        ContinuousLoop::new(self.controller.clone(), process, self.model, self.bands)
    }
}

/// A number within an interval, from a standard normal one: 90 % are within.
fn within(of: Estimate, z: f64) -> f64 {
    let reach = if z > 0.0 { of.high - of.value } else { of.value - of.low };
    of.value + z / 1.645 * reach
}

/// The loop with this valve. Each number differs from its middle by a standard normal number. It is `None` if the loop
/// is invalid, for example if the gain has the wrong sign.
pub(super) fn made(
    controller: &FittedController,
    valve: &Weighed,
    step: f64,
    z: [f64; 8],
) -> Option<Draw> {
    let kc = within(controller.kc, z[0]);
    let td = controller.td_s.map_or(0.0, |td| within(td, z[2]).max(0.0));
    let made = match controller.ti_s {
        None => Controller::p(kc),
        Some(ti) => {
            let factor = if z[1] > 0.0 { ti.high / ti.value } else { ti.value / ti.low };
            Controller::pid(kc, ti.value * factor.powf(z[1] / 1.645), td)
        }
    };
    let mut made = made.ok()?;
    if let Some(filter) = controller.filter_s.filter(|_| td > 0.0) {
        made = made.with_filter(filter.max(0.02 * td)).ok()?;
    }
    if let Some(weight) = controller.set_point_weight {
        made = made.with_set_point_weight(weight).ok()?;
    }
    if let Some(on) = controller.derivative_on {
        made = made.with_derivative_on(on);
    }
    let s = (valve.bands.s() + z[6] * valve.cell.0).max(0.0);
    let j = (valve.bands.j() + z[7] * valve.cell.1).clamp(0.0, s.max(valve.bands.j()));
    let bands =
        if valve.model == Model::Ideal { valve.bands } else { Bands::from_s_j(s, j).ok()? };
    let process = valve.process;
    let gain = process.gain + z[3] * process.error;
    // The grid of dead times leaves a third of a sample open to either side.
    let dead = (process.dead_time_s + 0.3 * step * z[4]).max(0.0);
    let process = match process.lag_s.is_finite() {
        true => Process::first_order(gain, process.lag_s * (0.06 * z[5]).exp(), dead),
        false => Process::integrator(gain, dead),
    };
    let process = process.ok()?;
    (gain * valve.process.gain > 0.0 && kc * controller.kc.value > 0.0).then_some(Draw {
        controller: made,
        process,
        model: valve.model,
        bands,
        execution_s: controller.execution_s.unwrap_or(0.5 * step),
    })
}

/// Draws loops. The same seed gives the same loops. Invalid loops are drawn again.
pub(super) fn drawn(
    controller: &FittedController,
    valves: &[Weighed],
    step: f64,
    options: &FitOptions,
) -> Vec<Draw> {
    let mut stream = NormalStream::new(options.seed);
    let mut one = |place: f64| -> Option<Draw> {
        let z = [(); 8].map(|()| stream.draw());
        let mut sum = 0.0;
        let valve = valves.iter().find(|one| {
            sum += one.weight;
            sum >= place
        })?;
        made(controller, valve, step, z)
    };
    let n = options.draws;
    let place = |i: usize| (i as f64 + 0.5) / n as f64;
    (0..n).filter_map(|i| (0..4).find_map(|_| one(place(i)))).collect()
}
