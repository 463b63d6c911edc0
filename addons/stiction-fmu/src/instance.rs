//! One instance: the calls permitted in each mode, and their effect.

use crate::fmu::{AnyFmuModel, Fmu, accept, hash};
use crate::model::Continuous;
use crate::variables::{Causality, Numbers, Set, Values, Variability, Variable, VariableKind};

/// Why a call was refused, in a sentence.
pub(crate) type Result<T> = std::result::Result<T, String>;

/// A set of modes. An instance is in one mode at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Modes(u8);

impl Modes {
    pub(crate) const INSTANTIATED: Self = Self(1);
    pub(crate) const INITIALIZATION: Self = Self(2);
    pub(crate) const STEP: Self = Self(4);
    pub(crate) const EVENT: Self = Self(8);
    pub(crate) const CONTINUOUS: Self = Self(16);
    pub(crate) const TERMINATED: Self = Self(32);
    pub(crate) const ERROR: Self = Self(64);

    /// Between start and end.
    pub(crate) const RUNNING: Self = Self::STEP.or(Self::EVENT).or(Self::CONTINUOUS);
    const BEFORE: Self = Self::INSTANTIATED.or(Self::INITIALIZATION);
    const SETTABLE: Self = Self::BEFORE.or(Self::RUNNING);
    const READABLE: Self =
        Self::INITIALIZATION.or(Self::RUNNING).or(Self::TERMINATED).or(Self::ERROR);

    const NAMES: [&str; 7] = [
        "instantiated",
        "initialization mode",
        "step mode",
        "event mode",
        "continuous-time mode",
        "terminated",
        "in error",
    ];

    pub(crate) const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    const fn has(self, mode: Self) -> bool {
        self.0 & mode.0 != 0
    }

    fn names(self) -> String {
        let names = Self::NAMES.iter().enumerate();
        let names: Vec<_> =
            names.filter(|(i, _)| self.0 & (1 << i) != 0).map(|(_, name)| *name).collect();
        names.join(", ")
    }
}

/// Pending work before outputs can be read or the next step taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stale {
    Nothing,
    /// Start with new parameters.
    Restart,
    /// Apply tuned parameters.
    Tune,
    /// Move to the solver's time and states.
    Place,
}

/// When inputs and parameters may be set.
const INPUT: Modes = Modes::SETTABLE;
const TUNABLE: Modes = Modes::BEFORE.or(Modes::STEP).or(Modes::EVENT);
const FIXED: Modes = Modes::BEFORE;

/// When a variable may be set; never if it is computed.
fn settable(variable: &Variable) -> Modes {
    match (variable.causality, variable.variability) {
        (Causality::Input, _) => INPUT,
        (Causality::Parameter, Variability::Tunable) => TUNABLE,
        (Causality::Parameter, _) => FIXED,
        _ => Modes(0),
    }
}

/// The calls that can be done without checks at present. Kept by [`Instance::stand`].
#[derive(Debug, Clone, Copy, Default)]
struct Open {
    /// Readable numbers.
    readable: Set,
    /// Numbers that can be set and matter only for the next step.
    held: Set,
    /// Whether a step can be taken.
    step: bool,
}

/// Variables with a common property.
#[derive(Debug, Clone, Copy)]
struct Groups {
    /// By [`VariableKind`].
    kinds: [Set; 3],
    inputs: Set,
    tunable: Set,
    fixed: Set,
}

impl Groups {
    fn of(fmu: &Fmu) -> Self {
        let those = |wanted: &dyn Fn(&Variable) -> bool| {
            let all = fmu.variables().iter().zip(0..);
            all.filter(|(variable, _)| wanted(variable)).map(|(_, reference)| reference).collect()
        };
        Self {
            kinds: [VariableKind::Float64, VariableKind::Int32, VariableKind::Boolean]
                .map(|kind| those(&|variable| variable.kind == kind)),
            inputs: those(&|variable| settable(variable) == INPUT),
            tunable: those(&|variable| settable(variable) == TUNABLE),
            fixed: those(&|variable| settable(variable) == FIXED),
        }
    }
}

/// An instance of a model. The data of each step come first, so that they are together in the cache.
#[repr(C, align(64))]
pub(crate) struct Instance {
    open: Open,
    state: State,
    groups: Groups,
    /// For model exchange, not co-simulation.
    exchange: bool,
    fmu: Fmu,
}

/// A copy of the state of an instance.
#[derive(Clone)]
#[repr(C)]
pub(crate) struct State {
    values: Values,
    model: AnyFmuModel,
    mode: Modes,
    stale: Stale,
    /// Whether the model has been started.
    started: bool,
    token: u64,
}

impl Instance {
    /// A fresh instance.
    ///
    /// # Errors
    /// If the token belongs to a different description, or the FMU is for model exchange and an external solver cannot
    /// compute the model.
    pub(crate) fn new(fmu: Fmu, token: &str, exchange: bool) -> Result<Self> {
        let own = fmu.token();
        if token != own {
            return Err(format!(
                "the description belongs to another model or another version of the library: its token is \
                 {token}, but the token of {} {} is {own}",
                fmu.model(),
                fmu.law()
            ));
        }
        if exchange && !fmu.is_continuous() {
            return Err(format!(
                "the model {} {} can be used for co-simulation only, not for model exchange",
                fmu.model(),
                fmu.law()
            ));
        }
        let state = State {
            token: hash(format!("{own} {exchange}").bytes()),
            model: fmu.build(),
            values: fmu.starts(),
            mode: Modes::INSTANTIATED,
            stale: Stale::Restart,
            started: false,
        };
        let (open, groups) = (Open::default(), Groups::of(&fmu));
        let mut instance = Self { open, groups, state, exchange, fmu };
        instance.stand(Modes::INSTANTIATED, Stale::Restart);
        Ok(instance)
    }

    /// Enters this mode, with this pending work.
    fn stand(&mut self, mode: Modes, stale: Stale) {
        (self.state.mode, self.state.stale) = (mode, stale);
        let numbers = self.groups.kinds[VariableKind::Float64 as usize];
        let current = matches!(stale, Stale::Nothing | Stale::Tune);
        let steps = mode == Modes::STEP && !self.exchange;
        self.open = Open {
            readable: numbers.only_if(current && Modes::READABLE.has(mode)),
            held: (numbers & self.groups.inputs).only_if(steps),
            step: steps && stale == Stale::Nothing,
        };
    }

    /// The settable variables in this mode.
    fn settable(&self) -> Set {
        let mode = self.state.mode;
        self.groups.inputs.only_if(INPUT.has(mode))
            | self.groups.tunable.only_if(TUNABLE.has(mode))
            | self.groups.fixed.only_if(FIXED.has(mode))
    }

    /// Refuses `call` outside these modes.
    #[inline]
    pub(crate) fn permit(&self, call: &str, modes: Modes) -> Result<()> {
        if modes.has(self.state.mode) { Ok(()) } else { Err(self.out_of_order(call, modes)) }
    }

    #[cold]
    fn out_of_order(&self, call: &str, modes: Modes) -> String {
        format!(
            "{call} is permitted in these modes: {}. The mode of the instance is {}",
            modes.names(),
            self.state.mode.names()
        )
    }

    /// Refuses `call` unless the instance is for model exchange, or not.
    pub(crate) fn permit_exchange(&self, call: &str, exchange: bool) -> Result<()> {
        if self.exchange == exchange {
            return Ok(());
        }
        let words = |exchange| if exchange { "model exchange" } else { "co-simulation" };
        Err(format!(
            "{call} is for {}, but the instance is for {}",
            words(exchange),
            words(self.exchange)
        ))
    }

    /// Sets the start time.
    pub(crate) fn set_up(&mut self, call: &str, start: f64, stop: Option<f64>) -> Result<()> {
        self.permit(call, Modes::INSTANTIATED)?;
        if !start.is_finite() || stop.is_some_and(|stop| !(stop > start)) {
            return Err(format!(
                "{call}: the start time is {start} s and the stop time {}, but both must be finite, the \
                 stop later than the start",
                stop.map_or("not given".to_owned(), |stop| format!("{stop} s"))
            ));
        }
        self.set_clock(start);
        Ok(())
    }

    fn set_clock(&mut self, time: f64) {
        self.state.values[0] = time;
    }

    pub(crate) fn enter_initialization(&mut self, call: &str) -> Result<()> {
        self.permit(call, Modes::INSTANTIATED)?;
        self.stand(Modes::INITIALIZATION, Stale::Restart);
        Ok(())
    }

    pub(crate) fn exit_initialization(&mut self, call: &str) -> Result<()> {
        self.permit(call, Modes::INITIALIZATION)?;
        self.refresh(call)?;
        self.stand(if self.exchange { Modes::EVENT } else { Modes::STEP }, Stale::Nothing);
        Ok(())
    }

    pub(crate) fn terminate(&mut self, call: &str) -> Result<()> {
        self.permit(call, Modes::RUNNING)?;
        self.stand(Modes::TERMINATED, self.state.stale);
        Ok(())
    }

    /// Resets the instance to its first state.
    pub(crate) fn reset(&mut self) {
        self.state.model = self.fmu.build();
        self.state.values = self.fmu.starts();
        self.state.started = false;
        self.stand(Modes::INSTANTIATED, Stale::Restart);
    }

    /// The present time of the instance.
    pub(crate) fn time(&self) -> f64 {
        self.state.values[0]
    }

    /// Ends the instance after an internal defect.
    pub(crate) fn fail(&mut self) {
        self.stand(Modes::ERROR, self.state.stale);
    }

    /// Updates the outputs.
    fn refresh(&mut self, call: &str) -> Result<()> {
        let time = self.time();
        let State { model, values, stale, started, .. } = &mut self.state;
        match *stale {
            Stale::Nothing | Stale::Tune => return Ok(()),
            Stale::Restart => {
                model.restart(values, time).map_err(|why| format!("{call}: {why}"))?;
                if self.exchange {
                    let rates = self.fmu.variables().iter().filter(|v| v.rate_of.is_some()).count();
                    let states = model.continuous().map_or(0, |model| model.states().len());
                    if states != rates {
                        return Err(format!(
                            "{call}: in model exchange air_lag_s cannot change between 0 and other values, because \
                             the description states whether the pressure is a state"
                        ));
                    }
                }
                *started = true;
            }
            Stale::Place => {
                if let Some(model) = model.continuous() {
                    model.place(values, time, None);
                }
            }
        }
        self.stand(self.state.mode, Stale::Nothing);
        Ok(())
    }

    /// Why this reference is not valid for this call.
    #[cold]
    pub(crate) fn foreign(&self, call: &str, reference: u32) -> String {
        match self.fmu.variables().get(reference as usize) {
            None => format!(
                "{call}: there is no variable with the value reference {reference}; the range is 0 to {}",
                self.fmu.variables().len() - 1
            ),
            Some(variable) => format!(
                "{call}: the variable {} (value reference {reference}) is of the type {:?}, which this function \
                 does not support",
                variable.name, variable.kind
            ),
        }
    }

    /// The value of a number, if it is available without an update.
    #[inline(always)]
    pub(crate) fn number(&self, reference: u32) -> Option<f64> {
        self.open.readable.has(reference).then(|| self.state.values[reference as usize])
    }

    /// Passes the values of some variables of one kind to `put`.
    pub(crate) fn get(
        &mut self,
        call: &str,
        kind: VariableKind,
        references: &[u32],
        mut put: impl FnMut(usize, f64),
    ) -> Result<()> {
        self.permit(call, Modes::READABLE)?;
        self.refresh(call)?;
        for (i, reference) in references.iter().enumerate() {
            if !self.groups.kinds[kind as usize].has(*reference) {
                return Err(self.foreign(call, *reference));
            }
            put(i, self.state.values[*reference as usize]);
        }
        Ok(())
    }

    /// Sets a number if the number only matters for the next step. Returns whether it was set.
    #[inline(always)]
    pub(crate) fn hold(&mut self, reference: u32, value: f64) -> bool {
        let held = self.open.held.has(reference) && value.is_finite();
        if held {
            self.state.values[reference as usize] = value;
        }
        held
    }

    /// Sets the values of some variables of one kind. If one value is invalid, none is set.
    pub(crate) fn set(
        &mut self,
        call: &str,
        kind: VariableKind,
        references: &[u32],
        value: impl Fn(usize) -> f64,
    ) -> Result<()> {
        self.permit(call, Modes::SETTABLE)?;
        let settable = self.settable() & self.groups.kinds[kind as usize];
        for (i, reference) in references.iter().enumerate() {
            let value = value(i);
            // Integers and Booleans are passed unchanged.
            if !(settable.has(*reference) && (kind != VariableKind::Float64 || value.is_finite())) {
                return Err(self.unsettable(call, kind, *reference, value));
            }
        }
        for (i, reference) in references.iter().enumerate() {
            self.state.values[*reference as usize] = value(i);
        }
        if references.iter().any(|reference| !self.open.held.has(*reference)) {
            self.touched(references);
        }
        Ok(())
    }

    /// Why a variable cannot have this value now.
    #[cold]
    fn unsettable(&self, call: &str, kind: VariableKind, reference: u32, value: f64) -> String {
        let Some(variable) =
            self.fmu.variables().get(reference as usize).filter(|variable| variable.kind == kind)
        else {
            return self.foreign(call, reference);
        };
        let modes = settable(variable);
        if modes == Modes(0) {
            format!("{call}: {} is computed and cannot be set", variable.name)
        } else if !modes.has(self.state.mode) {
            self.out_of_order(&format!("{call}: setting {}", variable.name), modes)
        } else {
            format!("{call}: {}", accept(variable, value).err().unwrap_or_default())
        }
    }

    /// Records the pending work after these have been set.
    fn touched(&mut self, references: &[u32]) {
        let parameters = self.groups.tunable | self.groups.fixed;
        let State { mode, stale, .. } = self.state;
        let stale = match stale {
            _ if Modes::BEFORE.has(mode) => Stale::Restart,
            _ if self.exchange => Stale::Place,
            _ if references.iter().any(|reference| parameters.has(*reference)) => Stale::Tune,
            stale => stale,
        };
        self.stand(mode, stale);
    }

    /// Continues from `time` by `step`. A refusal is boxed, so that the usual result fits a register.
    #[inline(always)]
    pub(crate) fn do_step(
        &mut self,
        call: &str,
        time: f64,
        step: f64,
    ) -> std::result::Result<(), Box<str>> {
        let end = time + step;
        if self.open.step && time == self.time() && end > time && end <= f64::MAX {
            self.advance(call, time, step)
        } else {
            self.step_with_care(call, time, step)
        }
    }

    #[inline(always)]
    fn advance(&mut self, call: &str, time: f64, step: f64) -> std::result::Result<(), Box<str>> {
        let State { model, values, .. } = &mut self.state;
        values[0] = time + step;
        model.step(values, time, step).map_err(|why| self.stopped(call, time, why))
    }

    /// Ends the instance, because the model cannot continue.
    #[cold]
    fn stopped(&mut self, call: &str, time: f64, why: String) -> Box<str> {
        self.set_clock(time);
        self.fail();
        format!("{call} at {time} s: {why}").into()
    }

    /// Checks that a step can be taken, applies tuned parameters, and takes the step.
    #[cold]
    #[inline(never)]
    fn step_with_care(
        &mut self,
        call: &str,
        time: f64,
        step: f64,
    ) -> std::result::Result<(), Box<str>> {
        self.permit_exchange(call, false)?;
        self.permit(call, Modes::STEP)?;
        let end = time + step;
        // Sums of times by importers differ by rounding from ours.
        let slack = (1e-6 * step + 1e-9 * time.abs()).min(0.5 * step);
        let near = (time - self.time()).abs() <= slack;
        if !(step > 0.0 && end > time && end.is_finite() && near) {
            return Err(self.bad_step(call, time, step).into());
        }
        if self.state.stale == Stale::Tune {
            let State { model, values, .. } = &mut self.state;
            model.tune(values).map_err(|why| format!("{call}: {why}"))?;
            self.stand(self.state.mode, Stale::Nothing);
        }
        self.advance(call, time, step)
    }

    fn bad_step(&self, call: &str, time: f64, step: f64) -> String {
        format!(
            "{call}: the step of {step} s from {time} s must begin at the end of the last step, at {} s, and be \
             finite and above 0",
            self.time()
        )
    }

    /// Changes from one mode of model exchange to another.
    pub(crate) fn switch(&mut self, call: &str, from: Modes, to: Modes) -> Result<()> {
        self.permit_exchange(call, true)?;
        self.permit(call, from)?;
        self.stand(to, self.state.stale);
        Ok(())
    }

    /// The model as equations, at the solver's time.
    fn equations(
        &mut self,
        call: &str,
        modes: Modes,
    ) -> Result<(&mut dyn Continuous, &mut Values, f64)> {
        self.permit_exchange(call, true)?;
        self.permit(call, modes)?;
        self.refresh(call)?;
        let time = self.time();
        let State { model, values, .. } = &mut self.state;
        let model = model
            .continuous()
            .ok_or_else(|| format!("{call}: the model has no differential equations"))?;
        Ok((model, values, time))
    }

    pub(crate) fn set_time(&mut self, call: &str, time: f64) -> Result<()> {
        self.permit_exchange(call, true)?;
        self.permit(call, Modes::EVENT.or(Modes::CONTINUOUS))?;
        if !time.is_finite() {
            return Err(format!("{call}: the time is {time}, but must be finite"));
        }
        self.set_clock(time);
        self.stand(self.state.mode, Stale::Place);
        Ok(())
    }

    pub(crate) fn set_states(&mut self, call: &str, states: &[f64]) -> Result<()> {
        let (model, values, time) = self.equations(call, Modes::CONTINUOUS)?;
        check_length(call, "continuous states", states.len(), model.states().len())?;
        if let Some(i) = states.iter().position(|state| !state.is_finite()) {
            return Err(format!(
                "{call}: continuous state {i} is {}, but must be finite",
                states[i]
            ));
        }
        model.place(values, time, Some(states));
        Ok(())
    }

    /// The values of `of`, in the requested number.
    fn tell(
        &mut self,
        call: &str,
        modes: Modes,
        count: usize,
        what: &str,
        of: impl Fn(&dyn Continuous, &Numbers) -> Vec<f64>,
    ) -> Result<Vec<f64>> {
        let (model, values, _) = self.equations(call, modes)?;
        let numbers = of(model, values);
        check_length(call, what, count, numbers.len())?;
        Ok(numbers)
    }

    pub(crate) fn states(&mut self, call: &str, count: usize) -> Result<Vec<f64>> {
        let modes = Modes::READABLE;
        self.tell(call, modes, count, "continuous states", |model, _| model.states())
    }

    pub(crate) fn nominals(&mut self, call: &str, count: usize) -> Result<Vec<f64>> {
        let modes = Modes::READABLE;
        self.tell(call, modes, count, "continuous states", |model, values| model.nominals(values))
    }

    pub(crate) fn rates(&mut self, call: &str, count: usize) -> Result<Vec<f64>> {
        let modes = Modes::READABLE;
        self.tell(call, modes, count, "continuous states", |model, values| model.rates(values))
    }

    pub(crate) fn indicators(&mut self, call: &str, count: usize) -> Result<Vec<f64>> {
        let modes = Modes::READABLE;
        self.tell(call, modes, count, "event indicators", |model, _| model.indicators())
    }

    pub(crate) fn count_states(&mut self, call: &str) -> Result<usize> {
        let modes = Modes::INSTANTIATED.or(Modes::READABLE);
        self.equations(call, modes).map(|(model, ..)| model.states().len())
    }

    pub(crate) fn count_indicators(&mut self, call: &str) -> Result<usize> {
        let modes = Modes::INSTANTIATED.or(Modes::READABLE);
        self.equations(call, modes).map(|(model, ..)| model.indicators().len())
    }

    /// Processes events, and returns whether an event occurred.
    pub(crate) fn update_discrete_states(&mut self, call: &str) -> Result<bool> {
        let (model, values, _) = self.equations(call, Modes::EVENT)?;
        let passed = model.pass_events(values);
        if passed.is_err() {
            self.fail();
        }
        passed.map_err(|why| format!("{call}: {why}"))
    }

    /// A copy of the state.
    pub(crate) fn state(&self) -> State {
        self.state.clone()
    }

    /// Continues from a copy.
    pub(crate) fn set_state(&mut self, call: &str, state: &State) -> Result<()> {
        if state.token != self.state.token {
            return Err(format!("{call}: the state belongs to another model"));
        }
        self.state = state.clone();
        self.stand(state.mode, state.stale);
        Ok(())
    }

    /// A state from bytes.
    pub(crate) fn deserialised(&self, call: &str, bytes: &[u8]) -> Result<State> {
        let refuse = |why: &str| format!("{call}: the serialised state {why}");
        let sum = bytes.len().checked_sub(8).ok_or_else(|| refuse("is too short"))?;
        let (bytes, sum) = bytes.split_at(sum);
        if hash(bytes.iter().copied()).to_le_bytes() != sum {
            return Err(refuse("is damaged"));
        }
        let mut words = bytes
            .chunks_exact(8)
            .map(|word| u64::from_le_bytes(word.try_into().unwrap_or_default()));
        let mut next = || words.next().ok_or_else(|| refuse("is too short"));
        if next()? != FORMAT {
            return Err(refuse("is of another format"));
        }
        if next()? != self.state.token {
            return Err(refuse("belongs to another model"));
        }
        let (mode, stale, started) = (next()?, next()?, next()? != 0);
        let stale = [Stale::Nothing, Stale::Restart, Stale::Tune, Stale::Place]
            .into_iter()
            .find(|s| *s as u64 == stale)
            .ok_or_else(|| refuse("is damaged"))?;
        let mode = u8::try_from(mode).ok().filter(|m| m.is_power_of_two() && *m < 128);
        let mode = Modes(mode.ok_or_else(|| refuse("is damaged"))?);
        let time = f64::from_bits(next()?);
        let mut values = self.fmu.starts();
        for (variable, place) in self.fmu.variables().iter().zip(values.known_mut()) {
            let value = f64::from_bits(next()?);
            if variable.is_set() {
                accept(variable, value).map_err(|why| refuse(&format!("is damaged: {why}")))?;
            }
            *place = value;
        }
        values[0] = time;
        let memory: Vec<f64> = words.map(f64::from_bits).collect();
        let mut model = self.fmu.build();
        if started {
            model
                .restart(&mut values.clone(), time)
                .and_then(|()| model.recall(&values, &memory))
                .map_err(|why| refuse(&format!("cannot be used: {why}")))?;
        }
        Ok(State { values, model, mode, stale, started, token: self.state.token })
    }
}

fn check_length(call: &str, what: &str, asked: usize, have: usize) -> Result<()> {
    if asked == have {
        Ok(())
    } else {
        Err(format!("{call}: {asked} {what} were requested, but there are {have}"))
    }
}

/// Marks the bytes of a state: `stiction` in ASCII, the last letter replaced by the version.
const FORMAT: u64 = u64::from_le_bytes(*b"stictio2");

impl State {
    /// The state as bytes, for [`Instance::deserialised`].
    pub(crate) fn serialised(&self) -> Vec<u8> {
        let head = [
            FORMAT,
            self.token,
            u64::from(self.mode.0),
            self.stale as u64,
            u64::from(self.started),
            self.values[0].to_bits(),
        ];
        let memory = if self.started { self.model.memory() } else { vec![] };
        let numbers = self.values.known().iter().chain(&memory).map(|number| number.to_bits());
        let mut bytes: Vec<u8> =
            head.into_iter().chain(numbers).flat_map(u64::to_le_bytes).collect();
        let sum = hash(bytes.iter().copied());
        bytes.extend(sum.to_le_bytes());
        bytes
    }
}
