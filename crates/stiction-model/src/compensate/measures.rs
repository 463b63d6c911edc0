//! Comparable measures of a compensator's effect on a loop.

use super::CompensatedRun;
use crate::error::{Error, Result, finite, non_negative};
use crate::numeric::summary::{reversals, span, std};

/// Measures over a window of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Measures {
    /// Standard deviation of the PV, in its units.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub pv_std: f64,
    /// Integral of the absolute control error per second, in PV units: its mean.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub iae_per_s: f64,
    /// Travel of the signal for the valve, percent per second.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub op_travel_per_s: f64,
    /// Travel of the stem, percent per second: it wears packing and seat.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub vp_travel_per_s: f64,
    /// Reversals of the stem per hour.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub reversals_per_h: f64,
    /// Half the peak-to-peak value of the PV, in its units.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub pv_half_pp: f64,
    /// Half the peak-to-peak value of the signal for the valve, percent.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub op_half_pp: f64,
    /// Half the peak-to-peak value of the valve position, percent.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub vp_half_pp: f64,
}

impl Measures {
    /// Measures from the sample at `from_s` to the last sample before `to_s`, s.
    ///
    /// # Errors
    /// If the window is not within the run, or shorter than two samples.
    pub fn of(compensated: &CompensatedRun, from_s: f64, to_s: f64) -> Result<Self> {
        let run = &compensated.run;
        let window = window(run.pv.len(), run.sample_time, from_s, to_s)?;
        let (sp, pv) = (&run.sp[window.clone()], &run.pv[window.clone()]);
        let (op, vp) = (&compensated.signal[window.clone()], &run.vp[window]);
        let n = pv.len() as f64;
        let seconds = n * run.sample_time;
        let travel = |x: &[f64]| x.windows(2).map(|w| (w[1] - w[0]).abs()).sum::<f64>() / seconds;
        Ok(Self {
            pv_std: std(pv),
            iae_per_s: sp.iter().zip(pv).map(|(sp, pv)| (sp - pv).abs()).sum::<f64>() / n,
            op_travel_per_s: travel(op),
            vp_travel_per_s: travel(vp),
            reversals_per_h: reversals(vp, 0.0) as f64 * 3600.0 / seconds,
            pv_half_pp: 0.5 * span(pv),
            op_half_pp: 0.5 * span(op),
            vp_half_pp: 0.5 * span(vp),
        })
    }
}

/// Time after `from_s` from which the control error stays within `band` until `to_s`, s; `None` if it has not
/// stayed there for the last tenth of the time.
///
/// # Errors
/// If the window is not within the run, or `band` is negative.
pub fn settling_s(
    compensated: &CompensatedRun,
    from_s: f64,
    to_s: f64,
    band: f64,
) -> Result<Option<f64>> {
    non_negative("settling band", band)?;
    let run = &compensated.run;
    let window = window(run.pv.len(), run.sample_time, from_s, to_s)?;
    let n = window.len();
    let outside = |k: &usize| !((run.sp[*k] - run.pv[*k]).abs() <= band);
    let settled = window.clone().rev().find(outside).map_or(0, |k| k + 1 - window.start);
    Ok((10 * settled <= 9 * n).then_some(settled as f64 * run.sample_time))
}

/// The samples from `from_s` to before `to_s`.
fn window(samples: usize, ts: f64, from_s: f64, to_s: f64) -> Result<std::ops::Range<usize>> {
    finite("beginning of the window", from_s)?;
    finite("end of the window", to_s)?;
    // A time at a whole number of samples must not shift by rounding.
    let index = |time: f64| (time / ts - 1e-9).ceil();
    let (from, to) = (index(from_s), index(to_s));
    if !(from >= 0.0 && to <= samples as f64 && to >= from + 2.0) {
        return Err(Error::Inconsistent(format!(
            "the window from {from_s} s to {to_s} s must hold two samples or more of a run of {} s",
            samples as f64 * ts
        )));
    }
    Ok(from as usize..to as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::Run;

    fn moved(pv: Vec<f64>, vp: Vec<f64>) -> CompensatedRun {
        let sp = vec![0.0; pv.len()];
        let op = vec![0.0; pv.len()];
        let run = Run { sample_time: 0.5, noise_band: 0.0, sp, pv, op, vp: vp.clone() };
        CompensatedRun { run, signal: vp }
    }

    #[test]
    fn a_square_wave_has_closed_forms() {
        let wave: Vec<f64> = (0..40).map(|k| if k % 10 < 5 { 1.0 } else { -1.0 }).collect();
        let run = moved(wave.clone(), wave);
        let m = Measures::of(&run, 0.0, 20.0).unwrap();
        assert_eq!((m.pv_std, m.iae_per_s, m.pv_half_pp), (1.0, 1.0, 1.0));
        // Seven edges of 2 %, of which all but the first turn back.
        assert_eq!((m.vp_travel_per_s, m.reversals_per_h), (14.0 / 20.0, 6.0 * 180.0));
        for (from, to) in [(-1.0, 5.0), (0.0, 21.0), (3.0, 3.5), (f64::NAN, 1.0)] {
            assert!(Measures::of(&run, from, to).is_err());
        }
    }

    #[test]
    fn settling_is_the_last_time_outside() {
        let decay: Vec<f64> = (0..100).map(|k| 4.0 * 0.9f64.powi(k)).collect();
        let run = moved(decay.clone(), decay);
        // 4 0.9^k <= 1 from k = 14 on.
        assert_eq!(settling_s(&run, 0.0, 50.0, 1.0).unwrap(), Some(7.0));
        assert_eq!(settling_s(&run, 0.0, 50.0, 1e-9).unwrap(), None);
        assert_eq!(settling_s(&run, 20.0, 50.0, 1.0).unwrap(), Some(0.0));
        assert!(settling_s(&run, 0.0, 50.0, -1.0).is_err());
    }
}
