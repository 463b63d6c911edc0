//! The cycle in which a loop ends, whichever way it is looked for.

use super::exact::{self, Outcome};
use super::harmonic_balance::{Balance, harmonic_balance};
use super::{ContinuousLoop, Cycle, Method};
use crate::error::{Error, Result};

/// The cycle in which a loop ends that starts near its equilibrium; or, in words, why there is none.
///
/// Exactly: the end of one motion ([`exact::cycle`]). By describing function: the stable cycle of the largest OP.
///
/// # Errors
/// If the loop cannot be computed that way, or its end was not found.
pub fn attractor(l: &ContinuousLoop, method: Method) -> Result<std::result::Result<Cycle, String>> {
    let stable = |cycles: Vec<Cycle>| {
        cycles.into_iter().find(|cycle| cycle.stable).ok_or("its cycles do not attract".to_owned())
    };
    match method {
        Method::Exact => match exact::cycle(l)? {
            Outcome::Cycles { cycles, .. } => Ok(stable(cycles)),
            Outcome::None { reasons } => {
                let reasons: Vec<String> = reasons.iter().map(ToString::to_string).collect();
                Ok(Err(reasons.join("; ")))
            }
            Outcome::NotFound { reason } => Err(Error::Inconsistent(reason)),
        },
        Method::DescribingFunction => match harmonic_balance(l)? {
            Balance::Cycles(cycles) => Ok(stable(cycles)),
            Balance::None(reason) => Ok(Err(reason.to_string())),
        },
    }
}
