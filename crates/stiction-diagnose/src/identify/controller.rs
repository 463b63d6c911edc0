//! The controller of the OP: its structure, gain, integral and derivative time, from recorded OP, PV and SP.
//!
//! # What it measures
//! Whether the OP is the output of a P, PI or PID controller on the recorded PV and SP, with its settings,
//! execution interval and limits, or whether none of these fits. It holds for any valve and process, because it
//! only uses the controller.
//!
//! # Assumptions
//! The controller uses the recorded PV, at the time of the sample or one sample before. It executes once a sample,
//! every few samples, or several times within one. Without an SP the set point is assumed constant, and is
//! estimated.
//!
//! # Equations
//! Within every run of samples off the limits,
//! ```text
//! op(k) = level + kp e(k) + ki W(k) + kd D(k) + n(k)          e = sp - pv, or what of it is beyond a gap
//! W(k) = Ts sum_{i<=k} e(i)
//! D(k) = a D(k-1) + (1 - a) (w(k) - w(k-1)) / Ts              w = -pv, or e
//! n(k) = rho n(k-1) + innovation                              Student's t with four degrees of freedom
//! ```
//! `kp`, `ki`, `kd`, the levels and the SP are found by iterated least squares; `rho`, `a`, the gap and the delay over
//! grids, by likelihood. With `rho = 0` the residual is the rounding of the OP. With `rho = 1` it wanders, as the sum
//! of errors of the recorded PV does, or jumps once where the controller tracked a signal. The innovations' heavy tails
//! give such jumps a low cost. `Kc = kp`, `Ti = kp / ki`, `Td = kd / kp`, the filter from `a`. A more complex structure
//! must be likelier by [`WORTH`] nats. Standard errors come from the sums of scores over blocks of the record, so that
//! the residual may be correlated. The variance of `e` is corrected for the PV's rounding. A controller that executes
//! `m` times a sample sums errors that the record does not contain. Then `W` contains only `(m + 1) / 2m` of `e(k)`,
//! which cannot be distinguished from a part of `kp`. It executes once per sample if the residual is only rounding.
//! Otherwise `m` is unknown. `kp` is then the value at the middle of its range, and the range is added to the error.
//!
//! # Parameters
//! None.
//!
//! # Limits
//! A PV that the historian compressed, held or rounded coarsely differs from the controller's input: gains are too
//! low. A filter between the recorded PV and the controller looks like derivative action of the wrong sign, and is
//! not accepted. Other controllers (feedforward, override, a gain that depends on the error) give "none fits".
//!
//! # References
//! D. Cochrane, G. H. Orcutt, J. Am. Stat. Assoc. 44 (1949) 32, for `rho`; K. L. Lange, R. J. A. Little,
//! J. M. G. Taylor, J. Am. Stat. Assoc. 84 (1989) 881, for the t distribution; K.-Y. Liang, S. L. Zeger, Biometrika 73
//! (1986) 13, for the standard errors (all recalled, not read). The combination is ours.

mod law;
mod record;

use crate::closed_loop::DerivativeOn;
use crate::estimate::Estimate;
use crate::finding::Abstention;
use crate::numeric::golden::golden;
use crate::recording::Segment;
use crate::series::{mean, median, quantile, span, variance};
use law::{Fit, Settings};
use record::{Record, Shape, held};

/// Smallest number of samples for a fit of a controller.
pub const FEWEST_SAMPLES: usize = 60;
/// Number of samples above which only the middle of a segment is used.
pub const MOST_SAMPLES: usize = 6000;
/// Nats by which a more complex structure must be likelier.
pub const WORTH: f64 = 12.0;
/// Smallest share of the OP's innovations that a controller must explain.
pub const LEAST_EXPLAINED: f64 = 0.5;
/// Half width of a 90 % interval, standard errors: Student's t of the blocks.
const WIDE: f64 = 1.72;
/// Factor of standard errors if more than rounding remains, so that intervals of simulated loops have their
/// coverage.
const LOOSE: f64 = 2.5;
/// The shortest derivative time that counts, samples: if only rounding remains, and otherwise.
const LEAST_TD: [f64; 2] = [0.03, 0.5];
/// Factor of [`WORTH`] for derivative action if more than rounding remains: changes of a PV by a historian between
/// two samples look similar.
const SLOPE_WORTH: f64 = 4.0;
/// Largest autocorrelation of the residual.
const RHO: [f64; 9] = [0.0, 0.4, 0.7, 0.85, 0.93, 0.97, 0.99, 0.997, 1.0];
/// Largest memory of the derivative, before the search between two of these values.
const KEEP: [f64; 7] = [0.0, 0.2, 0.4, 0.6, 0.75, 0.88, 0.95];

/// The structure of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Structure {
    /// Proportional only.
    P,
    /// Proportional and integral.
    Pi,
    /// Proportional, integral and derivative.
    Pid,
}

impl Structure {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::P => "P",
            Self::Pi => "PI",
            Self::Pid => "PID",
        }
    }
}

/// A controller identified from its output.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct FittedController {
    /// Structure.
    pub structure: Structure,
    /// Gain, percent of OP per unit of PV; negative for a direct-acting controller.
    pub kc: Estimate,
    /// Integral time, s; `None` without integral action.
    #[cfg_attr(feature = "serde", serde(rename = "ti"))]
    pub ti_s: Option<Estimate>,
    /// Derivative time, s; `None` without derivative action.
    #[cfg_attr(feature = "serde", serde(rename = "td"))]
    pub td_s: Option<Estimate>,
    /// Time constant of the derivative's filter, s.
    #[cfg_attr(feature = "serde", serde(rename = "filter"))]
    pub filter_s: Option<f64>,
    /// Input of the derivative; `None` without it, or if the set point never moves.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub derivative_on: Option<DerivativeOn>,
    /// Weight of the set point in the proportional part; `None` if the set point does not move.
    pub set_point_weight: Option<f64>,
    /// The identified constant set point, in PV units; `None` if a set point is recorded.
    pub set_point: Option<Estimate>,
    /// Control error up to which the controller does not act, in PV units; 0 without such a gap.
    pub gap: f64,
    /// Time between executions, s; `None` if this time is shorter than the record can show.
    #[cfg_attr(feature = "serde", serde(rename = "execution"))]
    pub execution_s: Option<f64>,
    /// Delay from the PV to the response of the OP, samples: 0 or 1.
    #[cfg_attr(feature = "serde", serde(rename = "delay_samples"))]
    pub delay: usize,
    /// The lower limit of the OP, percent; `None` if the OP did not reach a lower limit.
    pub low: Option<f64>,
    /// The upper limit of the OP, percent; `None` if the OP did not reach an upper limit.
    pub high: Option<f64>,
    /// The fastest movement of the OP, percent per second; `None` if the OP seldom moved this fast.
    pub rate_limit: Option<f64>,
    /// Resolution of the recorded OP, percent; 0 if none is visible.
    pub op_quantum: f64,
    /// Share of the OP's innovations that the controller explains.
    pub explained: f64,
    /// Share of the samples at which something other than the controller moved the OP, such as an operator, tracking,
    /// or a fault of the record.
    pub otherwise: f64,
}

/// The controller whose output is the OP of a segment.
///
/// # Errors
/// In words: why the OP is not a controller's output, or why the controller cannot be identified.
pub fn fit(segment: &Segment) -> Result<FittedController, Abstention> {
    let pv = segment.pv.as_deref().ok_or_else(|| no("without a PV no controller can be fitted"))?;
    let n = segment.len();
    if n < FEWEST_SAMPLES {
        return Err(Abstention(format!(
            "a controller needs at least {FEWEST_SAMPLES} samples; there are {n}"
        )));
    }
    let (from, until) = match n > MOST_SAMPLES {
        true => ((n - MOST_SAMPLES) / 2, (n + MOST_SAMPLES) / 2),
        false => (0, n),
    };
    let cut = |x: &[f64]| x[from..until].to_vec();
    let (op, pv, sp) = (cut(&segment.op), cut(pv), segment.sp.as_deref().map(cut));
    if !(span(&op) > 0.0 && span(&pv) > 0.0) {
        return Err(no("the OP or the PV does not move"));
    }
    let every = held(&op);
    let thin = |x: Vec<f64>| match every {
        Some((first, every)) => x[first..].iter().step_by(every).copied().collect(),
        None => x,
    };
    let (op, pv, sp) = (thin(op), thin(pv), sp.map(thin));
    let step = segment.sample_time * every.map_or(1.0, |(_, every)| every as f64);
    let record = Record::of(&op, pv, sp, step)?;
    record.controller(every.is_some())
}

fn no(why: &str) -> Abstention {
    Abstention(why.to_owned())
}

impl Record<'_> {
    fn controller(&self, held: bool) -> Result<FittedController, Abstention> {
        let nothing = || no("no control law fits: OP and PV do not move enough together");
        let plain = Shape { integral: true, derivative: None, gap: 0.0, weighted: false, delay: 0 };
        let mut best = self.fitted(plain, &RHO).ok_or_else(nothing)?;
        let near = |rho: f64| -> Vec<f64> {
            let at = RHO.iter().position(|r| *r == rho).unwrap_or(0);
            RHO[at.saturating_sub(1)..(at + 2).min(RHO.len())].to_vec()
        };
        if self.sp_moves {
            let shape = Shape { weighted: true, ..best.shape };
            let weighted = self.fitted(shape, &near(best.rho));
            let odd = weighted.as_ref().is_some_and(|fit| {
                let found = self.settings(fit);
                let b = found.of_sp.unwrap_or(found.kp) / found.kp;
                (b - 1.0).abs() > 0.1 && (-0.1..=1.5).contains(&b)
            });
            if odd {
                best = self.better(best, weighted, 2.0 * WORTH);
            }
        }
        if self.sp.is_some() && !best.shape.weighted {
            best = self.with_gap(best, &near);
        }
        // An OP that responds to the PV of the sample before is rare.
        let late = Shape { delay: 1, ..best.shape };
        best = self.better(best.clone(), self.fitted(late, &RHO), WORTH);
        let on = match self.sp_moves {
            true => &[DerivativeOn::Pv, DerivativeOn::Error][..],
            false => &[DerivativeOn::Pv][..],
        };
        let exactly = self.quantum + 1e-4 * span(self.op);
        for on in on {
            for keep in KEEP {
                let shape = Shape { derivative: Some((keep, *on)), ..best.shape };
                let by = match best.shape.derivative {
                    Some(_) => 0.0,
                    None if best.scale <= exactly => WORTH,
                    None => SLOPE_WORTH * WORTH,
                };
                best = self.better(best.clone(), self.fitted(shape, &near(best.rho)), by);
            }
        }
        if let Some((keep, on)) = best.shape.derivative {
            // Between the values of the grid.
            let of = |keep: f64| Shape { derivative: Some((keep, on)), ..best.shape };
            let tried = |keep: f64| self.fitted(of(keep), &[best.rho]);
            let unlikely = |keep: f64| tried(keep).map_or(f64::INFINITY, |fit| -fit.likelihood);
            let at = KEEP.iter().position(|k| *k == keep).unwrap_or(0);
            let (low, high) =
                (KEEP[at.saturating_sub(1)], KEEP.get(at + 1).copied().unwrap_or(0.99));
            best = self.better(best.clone(), tried(golden(unlikely, low, high)), 0.0);
        }
        let Settings { kp, kd, .. } = self.settings(&best);
        let exact = best.scale <= exactly;
        if kd / kp < LEAST_TD[usize::from(!exact)] * self.step && best.shape.derivative.is_some() {
            best =
                self.fitted(Shape { derivative: None, ..best.shape }, &RHO).ok_or_else(nothing)?;
        }
        // Without integral action, if the fit is as good.
        let shape = Shape { integral: false, derivative: None, ..best.shape };
        if let Some(proportional) = self.fitted(shape, &RHO) {
            let found = self.settings(&best);
            let wrong = found.kp * found.ki <= 0.0;
            if wrong || proportional.likelihood > best.likelihood - WORTH {
                best = proportional;
            }
        }
        let all = best.explained.max(self.level_explained(&best));
        if best.explained < LEAST_EXPLAINED && (all < 0.9 || best.explained < 0.3) {
            return Err(Abstention(format!(
                "no control law fits (the best explains {:.0} % of the OP's innovations). Possible reasons: \
                 feedforward, an override, another kind of controller, or a different PV",
                100.0 * best.explained.max(0.0)
            )));
        }
        if let Some(why) = self.refuted(&best) {
            return Err(why);
        }
        self.with_errors(&best, held)
    }

    /// The fit with a gap, if one is likelier.
    fn with_gap(&self, best: Fit, near: &dyn Fn(f64) -> Vec<f64>) -> Fit {
        let Some(sp) = &self.sp else { return best };
        let sizes: Vec<f64> = sp.iter().zip(&self.pv).map(|(s, p)| (s - p).abs()).collect();
        let mut found = best.clone();
        for share in [0.1, 0.25, 0.4, 0.55, 0.7, 0.8, 0.88, 0.94, 0.97] {
            let shape = Shape { gap: quantile(&sizes, share), ..best.shape };
            let by = if found.shape.gap > 0.0 { 0.0 } else { 2.0 * WORTH };
            found = self.better(found.clone(), self.fitted(shape, &near(found.rho)), by);
        }
        if found.shape.gap > 0.0 {
            let tried = |gap: f64| self.fitted(Shape { gap, ..found.shape }, &[found.rho]);
            let unlikely = |gap: f64| tried(gap).map_or(f64::INFINITY, |fit| -fit.likelihood);
            let near = golden(unlikely, 0.7 * found.shape.gap, 1.4 * found.shape.gap);
            found = self.better(found.clone(), tried(near), 0.0);
        }
        found
    }

    /// Why the controller is none of these: its gain depends on the size of the error, or an unrecorded set point
    /// moves.
    fn refuted(&self, best: &Fit) -> Option<Abstention> {
        let columns = self.columns(best.shape);
        let worse_than = |more: Vec<Vec<f64>>| {
            let all: Vec<Vec<f64>> = columns.iter().cloned().chain(more).collect();
            let other = self.with_rho(best.shape, &all, best.rho, false)?;
            let gained = other.likelihood - best.likelihood;
            Some(gained > 3.0 * WORTH && (best.scale / other.scale).ln() > 0.25)
        };
        let error: Vec<f64> = match &self.sp {
            Some(sp) => sp.iter().zip(&self.pv).map(|(s, p)| s - p).collect(),
            None => {
                let Settings { ki, slope, .. } = self.settings(best);
                let away = slope.filter(|_| ki != 0.0).map_or(0.0, |slope| slope / ki);
                let set_point = mean(&self.pv) + away;
                self.pv.iter().map(|v| set_point - v).collect()
            }
        };
        if self.sp.is_none() {
            // A separate set point in every sixth of the record.
            let n = self.op.len();
            let inside = |part: usize| -> Vec<f64> {
                (0..n).map(|k| f64::from(u8::from(6 * k / n == part))).collect()
            };
            let sixth = |part: usize| match best.shape.integral {
                true => self.summed(&inside(part)),
                false => inside(part),
            };
            if worse_than((0..5).map(sixth).collect()) == Some(true) {
                return Some(no("the SP is not recorded and moves: export the set point"));
            }
        }
        let sizes: Vec<f64> = error.iter().map(|e| e.abs()).collect();
        let typical = median(&sizes).max(f64::MIN_POSITIVE);
        // Bounded, so that a few large errors do not dominate.
        let bent = [1.0, 4.0].map(|from| -> Vec<f64> {
            error.iter().map(|e| e * (e.abs() / (from * typical)).min(1.0)).collect()
        });
        let mut more = bent.to_vec();
        if best.shape.integral {
            more.extend(bent.iter().map(|bent| self.summed(bent)));
        }
        (worse_than(more) == Some(true)).then(|| {
            no("no P, PI or PID controller fits: the gain depends on the size of the error")
        })
    }

    /// Share of the OP itself, in runs, that a fit explains.
    fn level_explained(&self, fit: &Fit) -> f64 {
        let columns = self.columns(fit.shape);
        let (mut left, mut all) = (0.0, 0.0);
        for run in &self.runs {
            let made = |k: usize| -> f64 {
                columns.iter().zip(&fit.coefficients).map(|(column, c)| c * column[k]).sum()
            };
            let rest: Vec<f64> = run.clone().map(|k| self.op[k] - made(k)).collect();
            left += rest.len() as f64 * variance(&rest);
            all += rest.len() as f64 * variance(&self.op[run.clone()]);
        }
        1.0 - left / all.max(f64::MIN_POSITIVE)
    }

    /// The sum of a signal over time, from the first sample on.
    fn summed(&self, x: &[f64]) -> Vec<f64> {
        let mut sum = 0.0;
        let add = |v: &f64| {
            sum += self.step * v;
            sum
        };
        x.iter().map(add).collect()
    }

    /// The fit with its standard errors, as settings.
    fn with_errors(&self, best: &Fit, held: bool) -> Result<FittedController, Abstention> {
        let columns = self.columns(best.shape);
        let lost = || no("the controller's settings could not be separated");
        let fit = self.with_rho(best.shape, &columns, best.rho, true).ok_or_else(lost)?;
        let Settings { kp, of_sp, ki, slope, kd } = self.settings(&fit);
        let of_kp = 0;
        let of_ki = 1 + usize::from(fit.shape.weighted);
        let of_kd = fit.coefficients.len() - 1;
        let variance = |i: usize, j: usize| fit.covariance[(i, j)];
        // If it executes once a sample, the residual is rounding.
        let of_pv = (kp.abs() + ki.abs() * self.step) * self.pv_quantum;
        let rounding = (self.quantum.powi(2) + of_pv.powi(2)) * (1.0 + fit.rho.powi(2)) / 12.0;
        let fine = if fit.shape.derivative.is_some() { 1e-6 } else { 1e-8 } * span(self.op);
        let executes = held || fit.scale <= fine;
        // Rounding hides the difference.
        let perhaps = fit.scale <= 1.3 * rounding.sqrt() + fine;
        let unknown = if executes { 0.0 } else { 0.5 * self.step * ki };
        let kp = if perhaps { kp } else { kp + 0.5 * unknown };
        let loose = if executes { 1.15 } else { LOOSE };
        let spread = if perhaps { 0.0 } else { (unknown / 3.5).powi(2) };
        let spread = spread + if executes { 0.0 } else { (0.01 * kp).powi(2) };
        let kc_error = loose * (variance(of_kp, of_kp) + spread).sqrt();
        let mut kc = interval(kp, kc_error);
        if perhaps && unknown * kp > 0.0 {
            let end = if kp > 0.0 { &mut kc.high } else { &mut kc.low };
            *end += unknown;
        }
        let ratio = |v: f64| v.max(0.0).sqrt();
        let ti = fit.shape.integral.then(|| {
            let relative = (variance(of_kp, of_kp) + spread) / (kp * kp)
                + variance(of_ki, of_ki) / (ki * ki)
                - 2.0 * variance(of_kp, of_ki) / (kp * ki);
            let mut ti = log_interval(kp / ki, loose * ratio(relative));
            if perhaps {
                ti.high += unknown / ki;
            }
            ti
        });
        let td = fit.shape.derivative.map(|_| {
            let relative = variance(of_kp, of_kp) / (kp * kp) + variance(of_kd, of_kd) / (kd * kd)
                - 2.0 * variance(of_kp, of_kd) / (kp * kd);
            log_interval(kd / kp, loose * ratio(relative))
        });
        let structure = match (ti, td) {
            (_, Some(_)) => Structure::Pid,
            (Some(_), None) => Structure::Pi,
            (None, None) => Structure::P,
        };
        let filter = fit.shape.derivative.map(|(keep, _)| match keep {
            keep if keep <= 0.0 => 0.0,
            keep if executes => self.step * keep / (1.0 - keep),
            keep => -self.step / keep.ln(),
        });
        let middle = mean(&self.pv);
        let set_point = slope.filter(|_| ki != 0.0).map(|slope| {
            let of_slope = of_ki + 1;
            let away = slope / ki;
            let error = (variance(of_slope, of_slope) / (ki * ki)
                + variance(of_ki, of_ki) * (away / ki).powi(2)
                - 2.0 * variance(of_slope, of_ki) * away / (ki * ki))
                .max(0.0)
                .sqrt();
            interval(middle + away, error)
        });
        Ok(FittedController {
            structure,
            kc,
            ti_s: ti,
            td_s: td,
            filter_s: filter,
            derivative_on: fit.shape.derivative.map(|(_, on)| on).filter(|_| self.sp_moves),
            set_point_weight: self.sp_moves.then(|| of_sp.map_or(1.0, |of_sp| of_sp / kp)),
            set_point,
            gap: fit.shape.gap,
            execution_s: executes.then_some(self.step),
            delay: fit.shape.delay,
            low: self.low,
            high: self.high,
            rate_limit: self.rate,
            op_quantum: self.quantum,
            explained: fit.explained,
            otherwise: fit.outliers,
        })
    }
}

fn interval(value: f64, error: f64) -> Estimate {
    let reach = WIDE * error + 1e-6 * value.abs();
    Estimate { value, low: value - reach, high: value + reach }
}

/// The interval of a positive value by its relative error.
fn log_interval(value: f64, relative: f64) -> Estimate {
    let factor = (WIDE * relative + 1e-6).min(20.0).exp();
    Estimate { value, low: value / factor, high: value * factor }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::{ClosedLoop, Controller, Process, Signal};
    use crate::valve::{Assembly, Model};
    use crate::{Bands, series};

    /// A sticking loop under this controller, its set point stepping.
    fn recorded(controller: Controller, gain: f64) -> Segment {
        let bands = Bands::from_s_j(4.0, 2.0).unwrap();
        let valve = Assembly::new(Model::TwoPhase.build(bands).unwrap());
        let process = Process::first_order(gain, 8.0, 2.0).unwrap();
        let mut plant = ClosedLoop::new(controller, valve, process);
        plant.set_point = Signal::Steps(vec![(0.0, 3.0), (500.0, -2.0)]);
        plant.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: 3 }];
        (plant.sample_time, plant.samples) = (1.0, 1200);
        let run = plant.run().unwrap();
        Segment {
            from: 0.0,
            sample_time: 1.0,
            op: run.op,
            pv: Some(run.pv),
            sp: Some(run.sp),
            vp: None,
            bridged: 0,
        }
    }

    fn near(found: f64, truth: f64, within: f64) -> bool {
        (found / truth - 1.0).abs() <= within
    }

    #[test]
    fn settings_are_exact_where_every_execution_is_recorded() {
        let pi = fit(&recorded(Controller::pi(0.6, 9.0).unwrap(), 1.2)).unwrap();
        assert_eq!((pi.structure, pi.execution_s, pi.delay), (Structure::Pi, Some(1.0), 0));
        assert!(near(pi.kc.value, 0.6, 1e-6) && near(pi.ti_s.unwrap().value, 9.0, 1e-6), "{pi:?}");
        assert!(pi.explained > 0.999_999 && pi.low.is_none() && pi.gap == 0.0);
        let p = fit(&recorded(Controller::p(1.5).unwrap(), 0.5)).unwrap();
        assert!(p.structure == Structure::P && near(p.kc.value, 1.5, 1e-6), "{p:?}");
        let pid = fit(&recorded(Controller::pid(0.6, 9.0, 2.0).unwrap(), 1.2)).unwrap();
        assert_eq!(pid.structure, Structure::Pid);
        assert!(near(pid.td_s.unwrap().value, 2.0, 1e-2), "{pid:?}");
        let direct = fit(&recorded(Controller::pi(-0.6, 9.0).unwrap(), -1.2)).unwrap();
        assert!(near(direct.kc.value, -0.6, 1e-6), "{direct:?}");
    }

    #[test]
    fn a_constant_set_point_is_found_and_one_that_moves_is_missed() {
        let segment = Segment { sp: None, ..recorded(Controller::pi(0.6, 9.0).unwrap(), 1.2) };
        let why = fit(&segment).unwrap_err();
        assert!(why.0.contains("SP is not recorded and moves"), "{why}");
        let found = fit(&segment.part(550, 650)).unwrap();
        assert!(near(found.set_point.unwrap().value, -2.0, 1e-4), "{found:?}");
    }

    #[test]
    fn units_do_not_matter_and_rounding_widens() {
        let segment = recorded(Controller::pi(0.6, 9.0).unwrap(), 1.2);
        let scaled = Segment {
            pv: segment.pv.as_ref().map(|x| x.iter().map(|v| 40.0 * v + 7.0).collect()),
            sp: segment.sp.as_ref().map(|x| x.iter().map(|v| 40.0 * v + 7.0).collect()),
            ..segment.clone()
        };
        let found = fit(&scaled).unwrap();
        assert!(near(found.kc.value * 40.0, 0.6, 1e-6), "{found:?}");
        let round = |x: &[f64]| x.iter().map(|v| (v / 0.1).round() * 0.1).collect::<Vec<f64>>();
        let rounded = fit(&Segment { op: round(&segment.op), ..segment.clone() }).unwrap();
        assert!(rounded.kc.low < 0.6 && 0.6 < rounded.kc.high, "{rounded:?}");
        assert!(near(rounded.op_quantum, 0.1, 1e-9));
    }

    #[test]
    fn what_is_no_controller_is_none() {
        let segment = recorded(Controller::pi(0.6, 9.0).unwrap(), 1.2);
        let mut stream = crate::closed_loop::NormalStream::new(9);
        let op: Vec<f64> = (0..segment.len()).map(|_| stream.draw()).collect();
        assert!(fit(&Segment { op, ..segment.clone() }).is_err());
        let still = Segment { op: vec![50.0; segment.len()], ..segment.clone() };
        assert!(fit(&still).unwrap_err().0.contains("does not move"));
        assert!(fit(&Segment { pv: None, ..segment.clone() }).is_err());
        assert!(fit(&segment.part(0, 20)).unwrap_err().0.contains("at least"));
        assert_eq!(series::span(&still.op), 0.0);
    }
}
