//! What is true of a simulated loop.

use super::{Kind, NoiseKind, ProcessKind, SetPointKind};
use crate::recording::Recording;
use crate::valve::Model;

/// A simulated loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// What a plant would have recorded: OP and PV, and the SP of some loops; never the VP.
    pub recording: Recording,
    /// What is true of the loop.
    pub truth: Truth,
}

/// What is true of a simulated loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// The kind it was asked for or drawn as.
    pub kind: Kind,
    /// Whether its valve is at fault: it sticks or is stuck.
    pub sticks: bool,
    /// The model of a sticking or stuck valve; `None` of a healthy one.
    pub model: Option<Model>,
    /// Stick band plus dead band, percent of span. Of a healthy valve, its harmless dead band, at most
    /// 0.25; of a stuck one 200: no OP moves it.
    pub s: f64,
    /// Slip jump, percent of span; 0 of a healthy or stuck valve.
    pub j: f64,
    /// Whether the record can show the fault. False of healthy valves.
    ///
    /// Of a sticking valve it is false if any of these holds over the record, at the rate of the
    /// controller:
    /// * OP less stem position has a standard deviation below 0.35 of the OP's;
    /// * the OP travels less than S, and the standard deviation of PV less SP is at most 1.05 times that
    ///   of the twin: the same loop, noise and disturbances with the healthy valve;
    /// * the stem never slips, and the OP travels less than half of S;
    /// * the PV that a healthy valve, given the same OP, would have made differs from the PV by a standard
    ///   deviation below the noise's: what sticking does is drowned.
    ///
    /// Of a stuck valve it is true if the PV that a healthy valve, given the same OP, would have made
    /// differs from the PV by a standard deviation of at least three times the noise's and half the
    /// PV's own.
    pub visible: bool,
    /// How often the stem of a sticking valve began to move within the record, having been at rest one
    /// step of the controller before. 0 of a healthy or stuck valve.
    pub slips: usize,
    /// Valve position at the recorded times, percent.
    pub vp: Vec<f64>,
    /// What else was drawn, and what came of it.
    pub facts: Facts,
}

/// What was drawn of a loop, and what came of it. PV in percent of the transmitter's span.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Facts {
    /// What the process is.
    pub process: ProcessKind,
    /// Process gain, percent of span per percent of OP; of an integrator, after one time constant.
    pub gain: f64,
    /// First time constant of the process, s; of an integrator, the time in which a percent of OP moves
    /// the PV by the gain.
    pub tau_s: f64,
    /// Second time constant, s, or 0.
    pub tau2_s: f64,
    /// Dead time, s.
    pub dead_time_s: f64,
    /// Lag of the stem, s.
    pub valve_lag_s: f64,
    /// Time constant of the PV's filter, s, or 0.
    pub pv_filter_s: f64,
    /// Controller gain, percent of OP per percent of span.
    pub kc: f64,
    /// Integral time, s.
    pub ti_s: f64,
    /// Derivative time, s, or 0.
    pub td_s: f64,
    /// Ultimate gain over controller gain.
    pub gain_margin: f64,
    /// Whether the loop was drawn slow for its record, so that little happens.
    pub few_events: bool,
    /// Lower limit of the OP, percent.
    pub op_low: f64,
    /// Upper limit of the OP, percent.
    pub op_high: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Steps of the controller a sample.
    pub steps_per_sample: usize,
    /// The scale of everything that happens to the loop, percent of OP.
    pub activity: f64,
    /// What the noise is like.
    pub noise: NoiseKind,
    /// Standard deviation of the noise over gain times activity.
    pub noise_ratio: f64,
    /// Whether the noise grows or shrinks.
    pub non_stationary: bool,
    /// What the set point does.
    pub set_point: SetPointKind,
    /// Play of the transmitter, percent of span, or 0.
    pub sensor_play: f64,
    /// Half the gap of the controller, percent of span, or 0.
    pub controller_gap: f64,
    /// Resolution of the PV that the controller sees, percent of span, or 0.
    pub transmitter_quantum: f64,
    /// Whether the historian averages over the sample.
    pub averaged: bool,
    /// The historian holds the PV for so many samples.
    pub held_samples: usize,
    /// Resolution of the recorded OP, percent, or 0.
    pub op_quantum: f64,
    /// Resolution of the recorded PV in its standard deviations, or 0.
    pub pv_quantum: f64,
    /// Deviation of the swinging door in standard deviations, or 0.
    pub compression: f64,
    /// Share of the record in which a valve at fault has its S and J; 0 of a healthy valve.
    pub faulty_share: f64,
    /// Range of the OP over the record, percent.
    pub op_travel: f64,
    /// Share of the record in which the OP is at a limit.
    pub at_limit: f64,
    /// Standard deviation of PV less SP over that of the twin with the healthy valve; 1 of a healthy
    /// valve and of a stuck one, which has no such twin.
    pub twin_ratio: f64,
    /// How many draws were given up before this one.
    pub redrawn: usize,
}

impl Facts {
    /// All facts by name, as a table shows them.
    pub fn entries(&self) -> Vec<(&'static str, String)> {
        /// Names that are those of the fields.
        macro_rules! entries {
            ($($name:ident)*) => { vec![$((stringify!($name), Cell::cell(&self.$name))),*] };
        }
        entries!(process gain tau_s tau2_s dead_time_s valve_lag_s pv_filter_s kc ti_s td_s gain_margin
            few_events op_low op_high sample_time_s steps_per_sample activity noise noise_ratio
            non_stationary set_point sensor_play controller_gap transmitter_quantum averaged held_samples
            op_quantum pv_quantum compression faulty_share op_travel at_limit twin_ratio redrawn)
    }
}

/// A fact as a table shows it.
trait Cell {
    fn cell(&self) -> String;
}

impl Cell for f64 {
    fn cell(&self) -> String {
        self.to_string()
    }
}

impl Cell for usize {
    fn cell(&self) -> String {
        self.to_string()
    }
}

impl Cell for bool {
    fn cell(&self) -> String {
        self.to_string()
    }
}

impl Cell for ProcessKind {
    fn cell(&self) -> String {
        self.name().to_owned()
    }
}

impl Cell for NoiseKind {
    fn cell(&self) -> String {
        self.name().to_owned()
    }
}

impl Cell for SetPointKind {
    fn cell(&self) -> String {
        self.name().to_owned()
    }
}
