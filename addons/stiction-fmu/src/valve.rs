//! A data-driven valve: one sample a step.

use stiction_model::Bands;
use stiction_model::valve::{AnyModel, Assembly, HeWang, Model as Law, Start, Valve, ValveSpec};

use crate::model::{FmuModel, Moves, Result};
use crate::variables::{MOVES, Numbers, Variable};

/// Value references.
const OP: usize = 1;
const VP: usize = 2;
const MOVED: std::ops::Range<usize> = 3..5;
const PARAMETERS: usize = 5;
const STEM_LAG: usize = PARAMETERS + 4;
const LIMITED: usize = PARAMETERS + 5;
const VP_START: usize = PARAMETERS + SETTINGS;

/// Number of variables in [`settings`].
pub(crate) const SETTINGS: usize = 8;

/// The parameters of any valve, alone or in a loop.
pub(crate) fn settings() -> [Variable; SETTINGS] {
    let p = Variable::parameter;
    [
        p("S", "%", 5.0, "Stick band plus dead band").tunable(),
        p("J", "%", 2.0, "Slip jump").tunable(),
        p("K", "1", HeWang::TYPICAL_OVERSHOOT, "Overshoot of a slip, 1 to 2; law he-wang only")
            .tunable(),
        p(
            "rest_tolerance",
            "%/s",
            0.0,
            "OP speed at which a moving stem stops; law two-phase only",
        ),
        p("stem_lag", "s", 0.0, "Time constant of the lag from the law to VP; 0 for no lag"),
        p("limited", "", 0.0, "Whether OP and VP are limited").boolean(),
        p("low", "%", 0.0, "Lower limit of OP and VP, if they are limited"),
        p("high", "%", 100.0, "Upper limit of OP and VP, if they are limited"),
    ]
}

/// A valve with the [`settings`] in `values`, sampled every `sample_time` seconds, stuck at 0.
pub(crate) fn build(
    law: Law,
    values: &[f64],
    sample_time: f64,
) -> stiction_model::Result<Assembly> {
    let [s, j, k, rest, lag, limited, low, high] = *values else {
        unreachable!("one value is given for each setting of a valve")
    };
    let uses = law.describe();
    ValveSpec {
        model: law,
        bands: Bands::from_s_j(s, j)?,
        overshoot: uses.uses_k.then_some(k),
        rest_tolerance: uses.uses_rest_tolerance.then_some(rest),
        limits: (limited != 0.0).then_some((low, high)),
        lag_s: lag,
    }
    .build(Some(sample_time))
}

/// The table of a valve.
pub(crate) fn variables() -> Vec<Variable> {
    let mut table = vec![
        Variable::TIME,
        Variable::input("OP", "%", 50.0, "Controller output, held over each step"),
        Variable::output("VP", "%", "Valve position").sampled().depends_on(&[]),
    ];
    table.extend(MOVES);
    table.extend(settings());
    table.push(Variable::parameter(
        "VP_start",
        "%",
        50.0,
        "Valve position and OP before the start",
    ));
    table
}

#[derive(Debug, Clone)]
#[repr(C)]
pub(crate) struct ValveModel {
    /// Sample time, s: the last step.
    sample_time: f64,
    /// Position of the model, before limits and lag.
    position: f64,
    moves: Moves,
    valve: Assembly,
    /// Whether there are neither limits nor lag.
    bare: bool,
    law: Law,
}

impl ValveModel {
    pub(crate) fn new(law: Law) -> Self {
        let valve = Assembly::new(AnyModel::Ideal(Default::default()));
        Self { law, valve, sample_time: 1.0, position: 0.0, bare: true, moves: Moves::default() }
    }

    /// Replaces the valve by one with the settings in `values`, which starts as in `begin`.
    #[cold]
    fn rebuild(
        &mut self,
        values: &[f64],
        sample_time: f64,
        begin: impl FnOnce(&mut Assembly),
    ) -> Result<()> {
        let mut valve = build(self.law, &values[PARAMETERS..VP_START], sample_time)
            .map_err(|e| e.to_string())?;
        begin(&mut valve);
        self.position = valve.model().position();
        self.bare = values[LIMITED] == 0.0 && values[STEM_LAG] == 0.0;
        self.valve = valve;
        self.sample_time = sample_time;
        Ok(())
    }

    /// The first step with a different length.
    #[cold]
    #[inline(never)]
    fn step_anew(&mut self, values: &mut Numbers, step: f64) -> Result<()> {
        self.change(values, step)?;
        self.step(values, 0.0, step)
    }

    /// Continues with other settings or another sample time.
    #[cold]
    fn change(&mut self, values: &Numbers, sample_time: f64) -> Result<()> {
        let memory = self.valve.memory();
        self.rebuild(values, sample_time, |valve| valve.recall(&memory))
    }
}

#[cold]
fn too_great(op: f64) -> String {
    format!("with OP = {op} the VP is too large to compute")
}

impl FmuModel for ValveModel {
    fn restart(&mut self, values: &mut Numbers, _time: f64) -> Result<()> {
        let start = Start::at_rest(values[VP_START]);
        self.rebuild(values, self.sample_time, |valve| valve.restart(start))?;
        values[VP] = self.valve.position();
        self.moves = Moves::begin(&mut values[MOVED]);
        Ok(())
    }

    fn tune(&mut self, values: &Numbers) -> Result<()> {
        self.change(values, self.sample_time)
    }

    #[inline(always)]
    fn step(&mut self, values: &mut Numbers, _time: f64, step: f64) -> Result<()> {
        if step != self.sample_time {
            return self.step_anew(values, step);
        }
        let vp = self.valve.step(values[OP]);
        if !(vp.abs() <= f64::MAX) {
            return Err(too_great(values[OP]));
        }
        let position = if self.bare { vp } else { self.valve.model().position() };
        self.moves.note(self.position, position, &mut values[MOVED]);
        self.position = position;
        values[VP] = vp;
        Ok(())
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = self.valve.memory().to_vec();
        memory.extend([self.moves.direction, self.sample_time]);
        memory
    }

    fn recall(&mut self, values: &Numbers, memory: &[f64]) -> Result<()> {
        let Ok([a, b, c, d, e, f, g, direction, sample_time]) = <[f64; 9]>::try_from(memory) else {
            return Err("this is not the state of a valve".to_owned());
        };
        let memory = [a, b, c, d, e, f, g];
        self.rebuild(values, sample_time, |valve| valve.recall(&memory))?;
        self.moves.direction = direction;
        Ok(())
    }

    fn copy(&self) -> Box<dyn FmuModel> {
        Box::new(self.clone())
    }
}
