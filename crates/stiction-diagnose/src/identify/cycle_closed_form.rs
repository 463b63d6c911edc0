//! S and J from the period and the amplitude of a cycle, in closed form.
//!
//! # What it measures
//! S and J of a valve in a loop with known process and controller, from two numbers of its limit cycle: its period
//! and the amplitude of the OP.
//!
//! # Assumptions
//! A two-phase valve (equal to Kano's and Choudhury's) before a process of first order with dead time,
//! under a PI controller whose integral time is the time constant. The cycle has no noise and no disturbance.
//! Samples are much shorter than the dead time, and `0 < q < 1`.
//!
//! # Equations
//! As for [`CancelledLoop::cycle`], solved for S and J. With `kappa = Kp Kc / tau`, `q = kappa theta`, OP amplitude A
//! and period T, the amplitude of the VP is
//! ```text
//! a = 2 A / (kappa (T - 4 theta) / 2 + q (2 - q / 2)),    J = (2 - q) a,    S = 2 A - 2 a + J
//! ```
//!
//! # Limits
//! Any difference between integral time and time constant, and any noise, moves both. J may exceed S.
//!
//! # Deviations from the paper
//! None. The closed form was derived for this project and confirmed by simulation.
//!
//! # References
//! None.

use crate::Bands;
use crate::finding::Abstention;

pub use crate::limit_cycle::CancelledLoop;

/// S and J, percent of span, from the period (s) and half of the peak-to-peak value of the OP (percent).
///
/// ```
/// use stiction_diagnose::identify::cycle_closed_form::{CancelledLoop, bands};
/// let known = CancelledLoop {
///     process_gain: 3.0,
///     controller_gain: 0.2,
///     time_constant_s: 10.0,
///     dead_time_s: 10.0,
/// };
/// let found = bands(&known, 218.0 / 3.0, 25.0 / 7.0).expect("it cycles");
/// assert!((found.s() - 5.0).abs() < 1e-9 && (found.j() - 5.0).abs() < 1e-9);
/// ```
///
/// # Errors
/// If a number is not positive and finite, q is not below 1, or no valve makes such a cycle: the period is too
/// short, or S would be negative.
pub fn bands(known: &CancelledLoop, period_s: f64, op_amplitude: f64) -> Result<Bands, Abstention> {
    let CancelledLoop { time_constant_s, dead_time_s, .. } = *known;
    let (kappa, q) = known.rate();
    let numbers = [kappa, time_constant_s, dead_time_s, period_s, op_amplitude];
    if !numbers.iter().all(|v| *v > 0.0 && v.is_finite()) || !(q < 1.0) {
        return Err(Abstention(
            "the closed form needs positive numbers and a loop gain of Kp Kc theta / tau below 1"
                .to_owned(),
        ));
    }
    let (s, j) = known.s_j(period_s, op_amplitude);
    if !(period_s > 4.0 * dead_time_s && s >= 0.0) {
        return Err(Abstention(format!(
            "no sticking valve makes this loop cycle with a period of {period_s} s and an OP amplitude of \
             {op_amplitude} %"
        )));
    }
    Bands::from_s_j(s, j).map_err(|e| Abstention(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::{ClosedLoop, Controller, Process};
    use crate::series::span;
    use crate::valve::{Assembly, Model};

    const KNOWN: CancelledLoop = CancelledLoop {
        process_gain: 3.0,
        controller_gain: 0.2,
        time_constant_s: 10.0,
        dead_time_s: 10.0,
    };

    #[test]
    fn exact_cycles_give_exact_bands() {
        for (s, j, period, amplitude) in [
            (5.0, 1.0, 778.0 / 3.0, 19.0 / 7.0),
            (5.0, 2.0, 428.0 / 3.0, 41.0 / 14.0),
            (5.0, 3.0, 934.0 / 9.0, 22.0 / 7.0),
            (5.0, 7.0, 178.0 / 3.0, 4.0),
            (3.0, 3.5, 66.0, 2.25),
        ] {
            let found = bands(&KNOWN, period, amplitude).unwrap();
            assert!((found.s() - s).abs() < 1e-9 && (found.j() - j).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn a_simulated_cycle_gives_its_bands() {
        let valve = Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0).unwrap()).unwrap();
        let mut plant = ClosedLoop::new(
            Controller::pi(0.2, 10.0).unwrap(),
            Assembly::new(valve),
            Process::first_order(3.0, 10.0, 10.0).unwrap(),
        );
        plant.set_point = 6.0.into();
        (plant.sample_time, plant.samples) = (0.05, 40_000);
        let run = plant.run().unwrap();
        let amplitude = 0.5 * span(&run.op[20_000..]);
        let found = bands(&KNOWN, run.period_s().unwrap(), amplitude).unwrap();
        assert!((found.s() - 5.0).abs() < 0.05 && (found.j() - 3.0).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn impossible_cycles_are_refused() {
        assert!(bands(&KNOWN, 30.0, 3.0).is_err());
        assert!(bands(&KNOWN, f64::NAN, 3.0).is_err());
        let fast = CancelledLoop { controller_gain: 2.0, ..KNOWN };
        assert!(bands(&fast, 100.0, 3.0).is_err());
    }
}
