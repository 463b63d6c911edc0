//! The families that the circumstances of a loop belong to: what can be left out of a training, one after the
//! other.

use stiction_model::valve::Model;

/// An enumeration whose members have names.
macro_rules! named {
    ($(#[$doc:meta])* $name:ident { $($(#[$of:meta])* $member:ident = $text:literal),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
                pub enum $name { $($(#[$of])* $member),* }

        impl $name {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$member),*];

            /// Its name.
            pub fn name(self) -> &'static str {
                match self { $(Self::$member => $text),* }
            }
        }
    };
}

named! {
    /// What a simulated process is.
    ProcessKind {
        /// First order plus dead time.
        FirstOrder = "first order",
        /// Second order, without oscillation, plus dead time.
        SecondOrder = "second order",
        /// An integrator plus dead time.
        Integrating = "integrating",
        /// First order plus dead time that runs away: `gain exp(-theta s) / (tau s - 1)`.
        Unstable = "unstable",
    }
}

named! {
    /// What the controller is.
    ControllerKind {
        /// Proportional only.
        P = "P",
        /// Proportional and integral.
        Pi = "PI",
        /// Proportional, integral and derivative.
        Pid = "PID",
        /// PI or PID whose gain grows with the error, as of levels that may float.
        ErrorSquared = "error-squared",
    }
}

named! {
    /// What the noise of a simulated PV is like.
    NoiseKind {
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
    /// What a simulated set point does.
    SetPointKind {
        /// It stays.
        Constant = "constant",
        /// It steps.
        Steps = "steps",
        /// It goes from value to value in ramps.
        Ramps = "ramps",
        /// It wanders, as a controller above writes it.
        Wandering = "wandering",
        /// A simulated controller above writes it.
        Cascade = "cascade",
    }
}

named! {
    /// What happens to a loop from outside, its cause apart.
    DisturbanceKind {
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
        /// Isolated disturbances of the PV that fade.
        Isolated = "isolated",
        /// Noise whose power falls with a power of the frequency: its memory has no end.
        LongMemory = "long memory",
        /// A ramp that resets, over and over.
        RampAndReset = "ramp and reset",
        /// A slow ramp through all of the record.
        OneWay = "one-way ramp",
        /// Something that is switched on and off.
        OnOff = "on and off",
    }
}

named! {
    /// What a historian did to the signals.
    HistorianKind {
        /// Nothing but to sample them, once a step of the controller or every few.
        Plain = "plain",
        /// It averaged over the sample.
        Averaging = "averaging",
        /// It held the PV for several samples.
        Holding = "holding",
        /// It rounded the OP or the PV.
        Rounding = "rounding",
        /// Swinging-door compression, drawn out to a regular grid by straight lines.
        SwingingDoor = "swinging door",
        /// It reported a value only when it had changed enough, and held it else.
        Exception = "exception reporting",
        /// It recorded one of 20 steps of the controller.
        Slow = "slow",
    }
}

named! {
    /// What is special about a loop and its surroundings, whatever its kind.
    Situation {
        /// Nothing.
        Ordinary = "ordinary",
        /// It is slow for its record: little happens.
        FewEvents = "few events",
        /// Its gain margin is 1.02 to 1.3: it rings when it is pushed.
        NearLimit = "near its limit",
        /// Its OP is noisy, by up to four times the band that its valve has if it sticks.
        NoisyControl = "noisy control",
        /// It writes the set point of a loop below, whose valve is the one that moves.
        OuterLoop = "outer loop",
        /// Another loop acts on it, and it on the other.
        Coupled = "coupled",
        /// What disturbs it is measured and added to its OP.
        Feedforward = "feedforward",
        /// Another controller takes over through a selector now and then.
        Override = "override",
        /// An operator takes over now and then.
        ManualSpells = "manual spells",
        /// Its actuator moves at a limited rate.
        SlowActuator = "slow actuator",
        /// An analyser measures its PV, now and then.
        Analyser = "analyser",
        /// Its transmitter ends a little above or below what the PV does.
        NarrowTransmitter = "narrow transmitter",
        /// Its OP works two valves, with a gap or an overlap where one hands over to the other.
        SplitRange = "split range",
    }
}

/// A family that a loop belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// Its process.
    Process(ProcessKind),
    /// The model of its valve, if that is at fault.
    Valve(Model),
    /// Its controller.
    Controller(ControllerKind),
    /// The noise of its PV.
    Noise(NoiseKind),
    /// What its set point does.
    SetPoint(SetPointKind),
    /// What happens to it.
    Disturbance(DisturbanceKind),
    /// What the historian did.
    Historian(HistorianKind),
    /// What is special about it.
    Situation(Situation),
}

impl Family {
    /// What it is a family of.
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
