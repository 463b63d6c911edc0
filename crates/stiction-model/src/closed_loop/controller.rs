//! P, PI and PID controllers in discrete time.

use super::IntegralAction;
use crate::error::{Error, Result, finite, non_negative, positive};
use crate::simd::Lane;

/// Protection against integral windup at a limit of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AntiWindup {
    /// None.
    None,
    /// The integral stops while it would drive the output further past its limit.
    Clamping,
    /// The integral is driven back with this time constant, s.
    BackCalculation(f64),
}

/// Form of the algorithm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// From the whole error and integral.
    #[default]
    Positional,
    /// From their changes, added to the last output. At a limit the last output is the limit itself, so the
    /// integral cannot wind up.
    Velocity,
}

/// Input of the derivative.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DerivativeOn {
    /// The PV, so that set-point steps do not kick.
    #[default]
    Pv,
    /// The control error.
    Error,
}

/// Initial state of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Handover {
    /// An empty integral: an initial control error kicks the output.
    #[default]
    Cold,
    /// Bumpless: the first output is the operating point, except for one sample's integral action.
    Bumpless,
}

/// A P, PI or PID controller. It works with gains `kp`, `ki`, `kd` whose output is percent of span.
///
/// # Equations
/// With the error `e = sp - pv`, every sample:
/// ```text
/// I = I + ki Ts e
/// D = (Tf D_prev + kd (w - w_prev)) / (Tf + Ts)     w = -pv, or e
/// positional:  u = kp (b sp - pv) + I + D
/// velocity:    u = u_prev + kp (change of b sp - pv) + ki Ts e + (D - D_prev)
/// ```
/// The integral is updated before it is used (backward Euler). ISA form: `kp = Kc`, `ki = Kc / Ti`,
/// `kd = Kc Td`. A negative gain makes a direct-acting controller.
///
/// ```
/// use stiction_model::closed_loop::{AntiWindup, Controller};
/// let flow = Controller::pi(0.6, 8.0)?.with_limits(0.0, 100.0, AntiWindup::Clamping)?;
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # References
/// K. J. Åström, T. Hägglund, "Advanced PID Control", ISA, 2006.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    kp: f64,
    ki: f64,
    kd: f64,
    filter_s: f64,
    set_point_weight: f64,
    derivative_on: DerivativeOn,
    form: Form,
    limits: Option<(f64, f64)>,
    anti_windup: AntiWindup,
    handover: Handover,
}

impl Controller {
    /// Default filter factor of the derivative: `Tf = Td / 10`.
    pub const FILTER_FACTOR: f64 = 10.0;

    /// Proportional only: `kc` in percent per PV unit.
    ///
    /// # Errors
    /// If `kc` is not finite.
    pub fn p(kc: f64) -> Result<Self> {
        Self::parallel(kc, 0.0, 0.0)
    }

    /// PI in ISA form: gain `kc` in percent per PV unit, integral time `ti` in s.
    ///
    /// # Errors
    /// If `kc` is not finite or `ti` not positive.
    pub fn pi(kc: f64, ti: f64) -> Result<Self> {
        Self::pid(kc, ti, 0.0)
    }

    /// PID in ISA form: gain `kc` in percent per PV unit, integral time `ti` and derivative time
    /// `td` in s; the derivative is filtered with `Tf = td / 10`.
    ///
    /// # Errors
    /// If `kc` is not finite, `ti` not positive, or `td` negative.
    pub fn pid(kc: f64, ti: f64, td: f64) -> Result<Self> {
        finite("Kc", kc)?;
        positive("Ti", ti)?;
        non_negative("Td", td)?;
        Self::parallel(kc, kc / ti, kc * td)?.with_filter(td / Self::FILTER_FACTOR)
    }

    /// PID in parallel form: `kp` in percent per PV unit, `ki` in percent per PV unit and second,
    /// `kd` in percent seconds per PV unit; the derivative is not filtered.
    ///
    /// # Errors
    /// If a gain is not finite.
    pub fn parallel(kp: f64, ki: f64, kd: f64) -> Result<Self> {
        Ok(Self {
            kp: finite("Kp", kp)?,
            ki: finite("Ki", ki)?,
            kd: finite("Kd", kd)?,
            filter_s: 0.0,
            set_point_weight: 1.0,
            derivative_on: DerivativeOn::default(),
            form: Form::default(),
            limits: None,
            anti_windup: AntiWindup::None,
            handover: Handover::default(),
        })
    }

    /// Filters the derivative with the time constant `tf`, s.
    ///
    /// # Errors
    /// If `tf` is negative.
    pub fn with_filter(mut self, tf: f64) -> Result<Self> {
        self.filter_s = non_negative("derivative filter time", tf)?;
        Ok(self)
    }

    /// Weights the set point by `b` in the proportional part.
    ///
    /// # Errors
    /// If `b` is not finite.
    pub fn with_set_point_weight(mut self, b: f64) -> Result<Self> {
        self.set_point_weight = finite("set-point weight", b)?;
        Ok(self)
    }

    /// Sets the input of the derivative.
    pub fn with_derivative_on(mut self, what: DerivativeOn) -> Self {
        self.derivative_on = what;
        self
    }

    /// Sets the form of the algorithm.
    pub fn with_form(mut self, form: Form) -> Self {
        self.form = form;
        self
    }

    /// The limits of the output, percent; infinite without limits.
    pub(super) fn output_range(&self) -> (f64, f64) {
        self.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY))
    }

    /// Keeps the output within `low..=high`, percent of span.
    ///
    /// # Errors
    /// If `low` is not below `high`, or a tracking time is not positive.
    pub fn with_limits(mut self, low: f64, high: f64, anti_windup: AntiWindup) -> Result<Self> {
        if !(low < high) {
            return Err(Error::Inconsistent(format!(
                "the lower limit of the controller output is {low}, but must be below the upper \
                 limit, {high}"
            )));
        }
        if let AntiWindup::BackCalculation(time) = anti_windup {
            positive("tracking time", time)?;
        }
        self.limits = Some((low, high));
        self.anti_windup = anti_windup;
        Ok(self)
    }

    /// Sets the initial state.
    pub fn with_handover(mut self, handover: Handover) -> Self {
        self.handover = handover;
        self
    }

    /// This controller with different gains, as in [`Controller::parallel`].
    ///
    /// # Errors
    /// If a gain is not finite.
    pub fn with_gains(mut self, kp: f64, ki: f64, kd: f64) -> Result<Self> {
        self.kp = finite("proportional gain", kp)?;
        self.ki = finite("integral gain", ki)?;
        self.kd = finite("derivative gain", kd)?;
        Ok(self)
    }

    /// Proportional, integral and derivative gain.
    pub fn gains(&self) -> (f64, f64, f64) {
        (self.kp, self.ki, self.kd)
    }

    /// Time constant of the derivative's filter, s; 0 for none.
    pub fn filter_s(&self) -> f64 {
        self.filter_s
    }

    /// Weight of the set point in the proportional part.
    pub fn set_point_weight(&self) -> f64 {
        self.set_point_weight
    }

    /// Whether it has only proportional and integral action.
    pub(super) fn is_plain_pi(&self) -> bool {
        self.kd == 0.0
            && self.set_point_weight == 1.0
            && self.form == Form::Positional
            && self.limits.is_none()
    }
}

/// A controller at its start, with its settings, its sample time and its initial state.
pub struct Engaged<'a> {
    settings: &'a Controller,
    sample_time: f64,
    op: f64,
    /// Proportional part before the first sample.
    proportional: f64,
    integral: f64,
}

impl<'a> Engaged<'a> {
    /// `settings` starting at output `op`, set point `sp` and `pv`.
    pub fn new(settings: &'a Controller, sample_time: f64, op: f64, sp: f64, pv: f64) -> Self {
        let proportional = match settings.handover {
            Handover::Cold => 0.0,
            Handover::Bumpless => settings.kp * (settings.set_point_weight * sp - pv),
        };
        Self { settings, sample_time, op, proportional, integral: op - proportional }
    }
}

/// PI controllers side by side, one a lane.
#[derive(Debug, Clone)]
pub(super) struct PiBank<const N: usize> {
    kp: Lane<N>,
    ki_ts: Lane<N>,
    integral: Lane<N>,
}

impl<const N: usize> PiBank<N> {
    pub(super) fn new(controllers: &[Engaged<'_>; N]) -> Self {
        Self {
            kp: Lane(controllers.each_ref().map(|c| c.settings.kp)),
            ki_ts: Lane(controllers.each_ref().map(|c| c.settings.ki * c.sample_time)),
            integral: Lane(controllers.each_ref().map(|c| c.integral)),
        }
    }

    /// The output in lane `l` for the present set point and PV.
    #[inline(always)]
    pub(super) fn step(&mut self, l: usize, sp: f64, pv: f64) -> f64 {
        let e = sp - pv;
        self.integral[l] += self.ki_ts[l] * e;
        self.kp[l] * e + self.integral[l]
    }
}

impl PiBank<1> {
    pub(super) fn integral(&self) -> f64 {
        self.integral[0]
    }

    pub(super) fn set_integral(&mut self, integral: f64) {
        self.integral[0] = integral;
    }
}

/// Controllers of every kind side by side, one a lane. A PI controller gives the same bits here as
/// in a `PiBank`.
#[derive(Debug, Clone)]
pub struct PidBank<const N: usize>([Pid; N]);

#[derive(Debug, Clone)]
struct Pid {
    kp: f64,
    ki_ts: f64,
    /// `kd / (Tf + Ts)` and `Tf / (Tf + Ts)`.
    derive: f64,
    keep: f64,
    weight: f64,
    derivative_on: DerivativeOn,
    form: Form,
    low: f64,
    high: f64,
    clamping: bool,
    /// `Ts / Tt`, or 0.
    tracking: f64,
    integral: f64,
    derivative: f64,
    proportional: f64,
    /// Last input of the derivative, if there was a sample.
    slope_of: Option<f64>,
    output: f64,
}

impl<const N: usize> PidBank<N> {
    /// This many controllers side by side.
    pub fn new(controllers: &[Engaged<'_>; N]) -> Self {
        Self(controllers.each_ref().map(Pid::new))
    }

    /// The output in lane `l` for the present set point and PV.
    #[inline(always)]
    pub fn step(&mut self, l: usize, sp: f64, pv: f64) -> f64 {
        self.step_with(l, sp, pv, IntegralAction::Acts)
    }

    /// A step with this permission of the integral action.
    #[inline(always)]
    pub(super) fn step_with(
        &mut self,
        l: usize,
        sp: f64,
        pv: f64,
        integral: IntegralAction,
    ) -> f64 {
        self.0[l].step(sp, pv, integral)
    }

    /// Lets the controller in lane `l` continue from `output` instead of its own last output.
    pub fn track(&mut self, l: usize, output: f64) {
        self.0[l].track(output);
    }
}

impl PidBank<1> {
    /// The part that changes from sample to sample. The input of the derivative is NaN before the first.
    pub(super) fn memory(&self) -> [f64; 5] {
        let [pid] = &self.0;
        let slope_of = pid.slope_of.unwrap_or(f64::NAN);
        [pid.integral, pid.derivative, pid.proportional, slope_of, pid.output]
    }

    pub(super) fn recall(&mut self, memory: [f64; 5]) {
        let [pid] = &mut self.0;
        let slope_of;
        [pid.integral, pid.derivative, pid.proportional, slope_of, pid.output] = memory;
        pid.slope_of = (!slope_of.is_nan()).then_some(slope_of);
    }
}

impl Pid {
    fn new(engaged: &Engaged<'_>) -> Self {
        let (c, ts) = (engaged.settings, engaged.sample_time);
        let (low, high) = c.output_range();
        Self {
            kp: c.kp,
            ki_ts: c.ki * ts,
            derive: c.kd / (c.filter_s + ts),
            keep: c.filter_s / (c.filter_s + ts),
            weight: c.set_point_weight,
            derivative_on: c.derivative_on,
            form: c.form,
            low,
            high,
            clamping: c.anti_windup == AntiWindup::Clamping,
            tracking: match c.anti_windup {
                // Without integral action the integral is the operating point, which is constant.
                AntiWindup::BackCalculation(time) if c.ki != 0.0 => ts / time,
                _ => 0.0,
            },
            integral: engaged.integral,
            derivative: 0.0,
            proportional: engaged.proportional,
            slope_of: None,
            output: engaged.op,
        }
    }

    #[inline(always)]
    fn step(&mut self, sp: f64, pv: f64, integral: IntegralAction) -> f64 {
        let e = sp - pv;
        let slope_of = match self.derivative_on {
            DerivativeOn::Error => e,
            DerivativeOn::Pv => -pv,
        };
        let change = self.slope_of.map_or(0.0, |before| slope_of - before);
        let derivative = self.keep * self.derivative + self.derive * change;
        let proportional = self.kp * (self.weight * sp - pv);
        let increment = match integral {
            IntegralAction::Acts => self.ki_ts * e,
            IntegralAction::Within { low, high } if self.ki_ts != 0.0 => {
                // The output without an error.
                let rest = self.integral + self.kp * (self.weight - 1.0) * sp;
                (rest + self.ki_ts * e).max(low).min(high) - rest
            }
            IntegralAction::Stops | IntegralAction::Within { .. } => 0.0,
        };
        let grown = self.integral + increment;

        let wanted = match self.form {
            Form::Positional => proportional + grown + derivative,
            Form::Velocity => {
                let change = (proportional - self.proportional) + (derivative - self.derivative);
                self.output + change + increment
            }
        };
        self.output = wanted.max(self.low).min(self.high);
        let excess = wanted - self.output;
        if !(self.clamping && excess * increment > 0.0) {
            self.integral = grown - self.tracking * excess;
        }
        self.derivative = derivative;
        self.proportional = proportional;
        self.slope_of = Some(slope_of);
        self.output
    }

    /// Continues from `output`, within its limits, if there is integral action.
    fn track(&mut self, output: f64) {
        if self.ki_ts != 0.0 {
            let output = output.max(self.low).min(self.high);
            self.integral += output - self.output;
            self.output = output;
        }
    }
}
