//! The stem, moved piece by piece from outside.

use super::body::Recorder;
use super::equations::GUARDS;
use super::pressure::{Drive, Segment};
use super::response::{Event, Sample, StemStart};
use super::simulate::{Run, Stem};
use crate::error::{Error, Result, finite, require};

/// A stem that gets its pressure piece by piece.
///
/// It can be moved in two ways, with the same equations and events. [`MovingStem::hold`] computes the motion under
/// a held pressure, as [`Stem::simulate`] does. Or an external solver does: it calls [rates](MovingStem::rates),
/// watches the [guards](MovingStem::guards), and calls [`pass_events`](MovingStem::pass_events) once one has fallen
/// below 0.
///
/// ```
/// use stiction_model::stem::{MovingStem, Stem, StemStart};
///
/// let mut stem = MovingStem::new(&Stem::named("cts")?, StemStart::at_rest(0.0), 0.0, 0.0)?;
/// stem.hold(20_000.0, 1.0)?; // 1,290 N do not overcome 1,708 N
/// assert!(stem.is_stuck());
/// stem.hold(40_000.0, 2.0)?;
/// assert_eq!(stem.events().len(), 1);
/// assert!(stem.sample().position_m > 0.02);
/// # Ok::<(), stiction_model::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct MovingStem {
    run: Run,
    time_s: f64,
    recorder: Recorder<'static>,
}

impl MovingStem {
    /// Most guards.
    pub const GUARDS: usize = GUARDS;

    /// At rest at `time_s` under this demanded pressure.
    ///
    /// # Errors
    /// If the start is not finite or lies beyond an end stop.
    pub fn new(stem: &Stem, start: StemStart, pressure_pa: f64, time_s: f64) -> Result<Self> {
        let pressure_pa = finite("air pressure", pressure_pa)?;
        let time_s = finite("time", time_s)?;
        let mut run = Run::new(stem, start, pressure_pa)?;
        let drive = Drive::resting(run.pressure_pa);
        run.equations_mut().begin(&drive);
        Ok(Self { run, time_s, recorder: Recorder::default() })
    }

    /// Continues until `until_s`, with the demanded pressure held.
    ///
    /// # Errors
    /// If the pressure is not finite, no time passes, or the solver cannot continue; in the last case the stem is
    /// unchanged.
    pub fn hold(&mut self, pressure_pa: f64, until_s: f64) -> Result<()> {
        let later = until_s > self.time_s;
        require("end of the step", until_s, later, "later than the present time")?;
        let segment = Segment::held(self.time_s, until_s, pressure_pa)?;
        let mut run = self.run.clone();
        self.recorder.clear();
        run.advance(&segment, &mut self.recorder)?;
        (self.run, self.time_s) = (run, until_s);
        Ok(())
    }

    /// The events of the last [`MovingStem::hold`] or [`MovingStem::pass_events`].
    pub fn events(&self) -> &[Event] {
        &self.recorder.events
    }

    /// Number of starts of motion and reversals in the last [`MovingStem::hold`] or [`MovingStem::pass_events`]. A
    /// stem on bristles begins to move when it is no longer [stuck](MovingStem::is_stuck).
    pub fn slips(&self) -> usize {
        self.recorder.slips
    }

    /// The stem at the present time.
    pub fn sample(&self) -> Sample {
        self.run.state(self.time_s).sampled(self.time_s)
    }

    /// Whether the stem rests. A stem on bristles (Dahl, LuGre, GMS) never quite does. It counts as moving once it has
    /// left its position by more than the bristles yield, faster than a thousandth of its stroke per second. It counts
    /// as stuck once its speed has fallen to half of this speed.
    pub fn is_stuck(&self) -> bool {
        self.run.equations().is_stuck()
    }

    /// Position, velocity, deflections of bristles, and the acting pressure if it lags, in SI units; `None` for
    /// Armstrong's law, which is not an ordinary differential equation.
    pub fn states(&self) -> Option<Vec<f64>> {
        let order = self.run.equations().order()?;
        let mut states = self.run.equations().states()[..order].to_vec();
        if self.run.lag_s > 0.0 {
            states.push(self.run.pressure_pa);
        }
        Some(states)
    }

    /// Sets the stem to a solver's state at `time_s`, under this demanded pressure. The mode of motion and missing
    /// states are kept.
    pub fn place(&mut self, time_s: f64, pressure_pa: f64, states: &[f64]) {
        let Some(order) = self.run.equations().order() else { return };
        let mut all = self.run.equations().states();
        for (state, given) in all[..order].iter_mut().zip(states) {
            *state = *given;
        }
        self.run.equations_mut().place(&all);
        self.run.pressure_pa = if self.run.lag_s > 0.0 {
            states.get(order).copied().unwrap_or(self.run.pressure_pa)
        } else {
            pressure_pa
        };
        self.time_s = time_s;
    }

    /// Rates of [`MovingStem::states`] under a demanded pressure; empty for Armstrong's law.
    pub fn rates(&self, pressure_pa: f64) -> Vec<f64> {
        let Some(order) = self.run.equations().order() else { return vec![] };
        let mut rates = self.run.equations().rates(&self.drive(), self.time_s)[..order].to_vec();
        if self.run.lag_s > 0.0 {
            rates.push((pressure_pa - self.run.pressure_pa) / self.run.lag_s);
        }
        rates
    }

    /// Values that stay at least 0 until the present mode of motion ends; unused ones are infinite.
    pub fn guards(&self) -> [f64; GUARDS] {
        self.run.equations().guards(&self.drive(), self.time_s)
    }

    /// Changes to the next mode of motion, while there is a guard at or below 0.
    ///
    /// # Errors
    /// If the modes do not settle.
    pub fn pass_events(&mut self) -> Result<bool> {
        self.recorder.clear();
        for passed in 0..16 {
            let Some(guard) = self.guards().iter().position(|guard| *guard <= 0.0) else {
                return Ok(passed > 0);
            };
            let drive = self.drive();
            self.run.equations_mut().pass(guard, &drive, self.time_s, &mut self.recorder);
        }
        Err(Error::Solver {
            method: "stick-slip event logic",
            time_s: self.time_s,
            reason: "the stem changed between sticking and slipping without time passing"
                .to_owned(),
        })
    }

    /// Everything that determines the motion besides parameters and pressure, as plain numbers.
    pub fn memory(&self) -> Vec<f64> {
        let mut memory = vec![self.time_s, self.run.pressure_pa];
        self.run.equations().remember(&mut memory);
        memory
    }

    /// Continues from the memory of a stem with the same parameters.
    ///
    /// # Errors
    /// If that was a different kind of stem.
    pub fn recall(&mut self, memory: &[f64]) -> Result<()> {
        let mut numbers = memory.iter().copied();
        let mut run = self.run.clone();
        let recalled = (|| {
            let (time_s, pressure_pa) = (numbers.next()?, numbers.next()?);
            run.pressure_pa = pressure_pa;
            run.equations_mut().recall(&mut numbers)?;
            numbers.next().is_none().then_some(time_s)
        })();
        let Some(time_s) = recalled else {
            return Err(Error::Inconsistent(
                "this state does not belong to a stem with this friction law".to_owned(),
            ));
        };
        (self.run, self.time_s) = (run, time_s);
        self.recorder.clear();
        Ok(())
    }

    fn drive(&self) -> Drive {
        Drive::resting(self.run.pressure_pa)
    }
}
