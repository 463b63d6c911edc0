//! The final cycle of a loop, by either method.

use super::exact::{self, CycleOutcome};
use super::harmonic_balance::{Balance, harmonic_balance};
use super::{ContinuousLoop, Cycle, Method};
use crate::error::{Error, Result};

/// The final cycle of a loop that starts near its equilibrium, or a sentence with the reason why it has none.
///
/// Exactly: the end of one motion ([`exact::cycle`]). By describing function: the stable cycle with the largest OP.
///
/// # Errors
/// If the method cannot treat the loop, or its final motion was not found.
pub fn attractor(l: &ContinuousLoop, method: Method) -> Result<std::result::Result<Cycle, String>> {
    let stable = |cycles: Vec<Cycle>| {
        cycles.into_iter().find(|cycle| cycle.stable).ok_or("its cycles do not attract".to_owned())
    };
    match method {
        Method::Exact => match exact::cycle(l)? {
            CycleOutcome::Cycles { cycles, .. } => Ok(stable(cycles)),
            CycleOutcome::None { reasons } => {
                let reasons: Vec<String> = reasons.iter().map(ToString::to_string).collect();
                Ok(Err(reasons.join("; ")))
            }
            CycleOutcome::NotFound { reason } => Err(Error::Inconsistent(reason)),
        },
        Method::DescribingFunction => match harmonic_balance(l)? {
            Balance::Cycles(cycles) => Ok(stable(cycles)),
            Balance::None(reason) => Ok(Err(reason.to_string())),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bands::Bands;
    use crate::closed_loop::{Controller, Process};
    use crate::valve::Model;

    fn looped(kc: f64, ti: f64, model: Model, j: f64) -> ContinuousLoop {
        let process = Process::first_order(1.5, 5.93, 1.07).unwrap();
        let bands = Bands::from_s_j(5.0, j).unwrap();
        ContinuousLoop::new(Controller::pi(kc, ti).unwrap(), process, model, bands)
    }

    #[test]
    fn both_methods_know_the_cycle_of_the_papers_loop() {
        for (method, period) in [(Method::Exact, 18.04367), (Method::DescribingFunction, 19.2292)] {
            let cycle =
                attractor(&looped(1.1, 2.5, Model::TwoPhase, 3.0), method).unwrap().unwrap();
            assert!(
                (cycle.period_s - period).abs() < 1e-4 && cycle.stable && cycle.method == method
            );
        }
    }

    #[test]
    fn the_describing_function_misses_a_cycle_of_slow_integral_action() {
        let slow = looped(1.3, 10.5, Model::TwoPhase, 3.0);
        assert!(attractor(&slow, Method::Exact).unwrap().is_ok());
        assert!(attractor(&slow, Method::DescribingFunction).unwrap().is_err());
    }

    #[test]
    fn without_a_cycle_there_is_a_reason() {
        for (l, reason) in [
            (looped(1.1, 2.5, Model::TwoPhase, 0.0), "comes to rest"),
            (looped(8.0, 2.5, Model::TwoPhase, 3.0), "unstable"),
            (looped(1.1, 2.5, Model::Ideal, 3.0), "does not stick"),
        ] {
            let found = attractor(&l, Method::Exact).unwrap().unwrap_err();
            assert!(found.contains(reason) || found.contains("decays"), "{found}");
            assert!(!attractor(&l, Method::DescribingFunction).unwrap().unwrap_err().is_empty());
        }
        assert!(attractor(&looped(1.1, 2.5, Model::Chen, 3.0), Method::Exact).is_err());
    }
}
