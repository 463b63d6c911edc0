//! The loop in continuous time.

use super::Swing;
use crate::bands::Bands;
use crate::closed_loop::{ClosedLoop, Controller, Process, Signal};
use crate::error::{Error, Result, finite};
use crate::valve::Model;

/// A loop in continuous time at a constant set point and load, without noise.
///
/// ```text
/// e = sp - pv
/// op = kp (b sp - pv) + ki int e dt + kd s / (Tf s + 1) (-pv, or e)
/// vp = valve(op)
/// pv = num(s) / den(s) exp(-theta s) (vp + load)
/// ```
/// Limits of the OP, anti-windup and the start of the controller are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct ContinuousLoop {
    /// The controller.
    pub controller: Controller,
    /// The process, around its operating point.
    pub process: Process,
    /// The valve model.
    pub model: Model,
    /// Bands.
    pub bands: Bands,
    /// Set point, PV units from the operating point.
    pub set_point: f64,
    /// Load, percent.
    pub load: f64,
}

impl ContinuousLoop {
    /// A loop at set point and load 0.
    pub fn new(controller: Controller, process: Process, model: Model, bands: Bands) -> Self {
        Self { controller, process, model, bands, set_point: 0.0, load: 0.0 }
    }

    /// Whether set point and load are numbers.
    ///
    /// # Errors
    /// If not.
    pub fn check(&self) -> Result<()> {
        finite("set point", self.set_point)?;
        finite("load", self.load)?;
        Ok(())
    }

    /// Rest position of the loop if the valve followed the OP: the middle of a symmetric cycle.
    ///
    /// # Errors
    /// If no operating point exists, or the set point or a load is not a number.
    pub fn operating_point(&self) -> Result<Swing> {
        self.check()?;
        let (num, den) = self.process.coefficients();
        let last = |p: &[f64]| p.last().copied().unwrap_or(0.0);
        let (num, den) = (last(&num), last(&den));
        let (kp, ki, _) = self.controller.gains();
        let wanted = self.controller.set_point_weight() * self.set_point;
        // den pv = num (op + load), with either pv = sp or op = kp (b sp - pv).
        let (op, pv) = if ki == 0.0 {
            let pv = num * (kp * wanted + self.load) / (den + num * kp);
            (kp * (wanted - pv), pv)
        } else {
            (den * self.set_point / num - self.load, self.set_point)
        };
        if op.is_finite() && pv.is_finite() {
            Ok(Swing { op, vp: op, pv })
        } else {
            Err(Error::Inconsistent(
                "the loop has no operating point: its controller cannot hold the process anywhere"
                    .to_owned(),
            ))
        }
    }

    /// The limit of a simulated loop as its sample time goes to 0, around its operating point.
    ///
    /// # Errors
    /// If the set point or a load does not settle. A limit cycle needs constant inputs.
    pub fn of(simulated: &ClosedLoop, model: Model, bands: Bands) -> Result<Self> {
        let settled = |name: &str, signal: &Signal| match signal {
            Signal::Constant(value) => Ok(*value),
            Signal::Steps(steps) => Ok(steps.last().map_or(0.0, |step| step.1)),
            _ => Err(Error::Inconsistent(format!(
                "the {name} does not settle; a limit cycle needs a constant {name}"
            ))),
        };
        let mut load = 0.0;
        for signal in &simulated.load {
            load += settled("load", signal)?;
        }
        let set_point = settled("set point", &simulated.set_point)? - simulated.pv_rest;
        let (controller, process) = (simulated.controller.clone(), simulated.process.clone());
        Ok(Self { controller, process, model, bands, set_point, load })
    }
}
