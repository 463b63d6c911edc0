//! The families of a loop's circumstances, each of which can be left out of a training.

use stiction_model::named;
use stiction_model::valve::Model;

named! {
    /// The kind of simulated process.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum ProcessKind {
        /// First order plus dead time.
        FirstOrder = "first order",
        /// Second order, without oscillation, plus dead time.
        SecondOrder = "second order",
        /// An integrator plus dead time.
        Integrating = "integrating",
        /// First order plus dead time, unstable: `gain exp(-theta s) / (tau s - 1)`.
        Unstable = "unstable",
    }
}

named! {
    /// The kind of controller.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum ControllerKind {
        /// Proportional only.
        P = "P",
        /// Proportional and integral.
        Pi = "PI",
        /// Proportional, integral and derivative.
        Pid = "PID",
        /// PI or PID whose gain grows with the error, for example for levels that may float.
        ErrorSquared = "error-squared",
    }
}

named! {
    /// The kind of noise of a simulated PV.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum NoiseKind {
        /// White and Gaussian.
        White = "white",
        /// Gaussian, of the first order.
        Correlated = "correlated",
        /// White, of Student's t distribution with 2.5 to 5 degrees of freedom.
        HeavyTailed = "heavy-tailed",
        /// White and Gaussian, 3 to 10 times larger in bursts.
        Bursts = "bursts",
        /// White and Gaussian, with single outliers of 4 to 15 standard deviations.
        Spikes = "spikes",
    }
}

named! {
    /// The kind of set point.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum SetPointKind {
        /// It is constant.
        Constant = "constant",
        /// It steps.
        Steps = "steps",
        /// It moves from value to value in ramps.
        Ramps = "ramps",
        /// It wanders, as from a controller above.
        Wandering = "wandering",
        /// It comes from a simulated controller above.
        Cascade = "cascade",
    }
}

named! {
    /// External disturbances of a loop besides its cause.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum DisturbanceKind {
        /// A random walk.
        Drift = "drift",
        /// Steps.
        Steps = "steps",
        /// One ramp.
        Ramp = "ramp",
        /// Pulses.
        Pulses = "pulses",
        /// A sine.
        Oscillation = "oscillation",
        /// Isolated disturbances of the PV that decay.
        Isolated = "isolated",
        /// Noise whose power falls with a power of the frequency: its memory is infinite.
        LongMemory = "long memory",
        /// A ramp that resets, repeatedly.
        RampAndReset = "ramp and reset",
        /// A slow ramp over the whole record.
        OneWay = "one-way ramp",
        /// A disturbance that is switched on and off.
        OnOff = "on and off",
    }
}

named! {
    /// Processing of the signals by a historian.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum HistorianKind {
        /// Only sampling, once a step of the controller or every few.
        Plain = "plain",
        /// It averaged over the sample.
        Averaging = "averaging",
        /// It held the PV for several samples.
        Holding = "holding",
        /// It rounded the OP or the PV.
        Rounding = "rounding",
        /// Swinging-door compression, interpolated to a regular grid by straight lines.
        SwingingDoor = "swinging door",
        /// It reported a value only after a sufficient change, and held it in between.
        Exception = "exception reporting",
        /// It recorded one of 20 steps of the controller.
        Slow = "slow",
    }
}

named! {
    /// The special situation of a loop and its surroundings, for any kind.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Situation {
        /// Nothing.
        Ordinary = "ordinary",
        /// It is slow for its record: hardly anything happens.
        FewEvents = "few events",
        /// Its gain margin is 1.02 to 1.3: it rings after a disturbance.
        NearLimit = "near its limit",
        /// Its OP is noisy, up to four times the band of its valve if it sticks.
        NoisyControl = "noisy control",
        /// It writes the set point of a loop below, whose valve moves.
        OuterLoop = "outer loop",
        /// It and another loop act on each other.
        Coupled = "coupled",
        /// Its disturbance is measured and added to its OP.
        Feedforward = "feedforward",
        /// Another controller sometimes takes over through a selector.
        Override = "override",
        /// An operator sometimes takes over.
        ManualSpells = "manual spells",
        /// Its actuator moves at a limited rate.
        SlowActuator = "slow actuator",
        /// An analyser measures its PV at intervals.
        Analyser = "analyser",
        /// The range of its transmitter ends slightly above or below the PV's range.
        NarrowTransmitter = "narrow transmitter",
        /// Its OP drives two valves, with a gap or an overlap between them.
        SplitRange = "split range",
    }
}

/// A family that a loop belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// Process.
    Process(ProcessKind),
    /// The model of its valve, if that is faulty.
    Valve(Model),
    /// Controller.
    Controller(ControllerKind),
    /// The noise of its PV.
    Noise(NoiseKind),
    /// Set point.
    SetPoint(SetPointKind),
    /// A disturbance.
    Disturbance(DisturbanceKind),
    /// The processing of the historian.
    Historian(HistorianKind),
    /// Situation.
    Situation(Situation),
}

impl Family {
    /// Axis.
    pub fn axis(self) -> &'static str {
        match self {
            Self::Process(_) => "process",
            Self::Valve(_) => "valve",
            Self::Controller(_) => "controller",
            Self::Noise(_) => "noise",
            Self::SetPoint(_) => "set point",
            Self::Disturbance(_) => "disturbance",
            Self::Historian(_) => "historian",
            Self::Situation(_) => "situation",
        }
    }

    /// Its name on that axis.
    pub fn name(self) -> &'static str {
        match self {
            Self::Process(kind) => kind.name(),
            Self::Valve(model) => model.describe().name,
            Self::Controller(kind) => kind.name(),
            Self::Noise(kind) => kind.name(),
            Self::SetPoint(kind) => kind.name(),
            Self::Disturbance(kind) => kind.name(),
            Self::Historian(kind) => kind.name(),
            Self::Situation(situation) => situation.name(),
        }
    }
}
