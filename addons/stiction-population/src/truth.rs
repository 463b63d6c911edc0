//! The truth about a simulated loop.

use super::{
    ControllerKind, DisturbanceKind, Family, HistorianKind, LoopKind, NoiseKind, ProcessKind,
    SetPointKind, Situation,
};
use std::fmt;
use stiction_diagnose::recording::Recording;
use stiction_model::valve::Model;

/// A simulated loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// The recording of a plant: OP and PV, and the SP of some loops; never the VP.
    pub recording: Recording,
    /// The truth about the loop.
    pub truth: Truth,
}

/// The truth about a simulated loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Kind, as requested or drawn.
    pub kind: LoopKind,
    /// Whether its valve is faulty: it sticks or is stuck.
    pub sticks: bool,
    /// The model of a sticking or stuck valve; `None` for a healthy one.
    pub model: Option<Model>,
    /// Stick band plus dead band, percent of span. For a healthy valve, its harmless dead band, at most 0.25; for a
    /// stuck one 200: no OP moves it.
    pub s: f64,
    /// Slip jump, percent of span; 0 for a healthy or stuck valve.
    pub j: f64,
    /// Whether the record can show the fault. False for healthy valves.
    ///
    /// For a sticking valve it is true if the stem slipped and [`gain`](Self::gain) is at least 15.6 nats. These are 8,
    /// plus 4 by chance, plus `ln 36` for an observer who has to find S and J among 36 pairs instead of knowing the
    /// stem.
    ///
    /// For a sticking valve in the loop below it is true if the stem slipped twice, and the PV differs from that of a
    /// healthy valve with the same OP by at least the noise's standard deviation. The recorded OP is not the valve's
    /// input, so it has no likelihood.
    ///
    /// For a stuck valve, and for a sticking one whose stem never [moves](Self::moves), the PV must differ from
    /// that of a healthy valve with the same OP by a standard deviation of at least three times the noise's and
    /// half the PV's own.
    pub visible: bool,
    /// Gain in log-likelihood of the recorded PV for an observer who knows the true stem besides the OP, nats. It
    /// is robust and for the number of independent samples. Past means of the stem are added to a regression of the
    /// PV on its past and on past means of the OP. 0 for loops whose own valve does not stick.
    pub gain: f64,
    /// Range of the OP over the actual S of the valve, or its S if it stuck.
    pub swing: f64,
    /// Standard deviation of the OP's noise, open loop, over that S.
    pub op_noise: f64,
    /// Number of slips of a sticking valve's stem within the record. A slip is a start after a rest in the step of the
    /// controller before. 0 for a healthy or stuck valve.
    pub slips: usize,
    /// Whether the stem moved at all during the record, by more than 1e-9 % in a step of the controller. True for a
    /// healthy valve.
    pub moves: bool,
    /// Valve position at the recorded times, percent.
    pub vp: Vec<f64>,
    /// Other drawn facts, and results.
    pub facts: Facts,
}

impl Truth {
    /// Whether S and J describe a sticking valve in percent of the recorded OP, so that estimates can be compared with
    /// them. False for a stuck valve, and for one that sticks in the loop below.
    pub fn has_bands(&self) -> bool {
        self.kind == LoopKind::Sticky
    }

    /// The families of the loop, one or several an axis, each of which can be left out of a training.
    pub fn families(&self) -> Vec<Family> {
        let facts = &self.facts;
        let mut families = vec![
            Family::Process(facts.process),
            Family::Controller(facts.controller),
            Family::Noise(facts.noise),
            Family::SetPoint(facts.set_point),
            Family::Situation(facts.situation),
        ];
        families.extend(self.model.map(Family::Valve));
        families.extend(facts.disturbances.iter().copied().map(Family::Disturbance));
        families.extend(facts.historian.iter().copied().map(Family::Historian));
        families
    }
}

/// Drawn facts about a loop, and results. PV in percent of the transmitter's span.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Facts {
    /// Kind of process.
    pub process: ProcessKind,
    /// Process gain, percent of span per percent of OP; for an integrator, after one time constant.
    pub gain: f64,
    /// First time constant of the process, s; for an integrator, the time in which a percent of OP moves the PV by
    /// the gain.
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
    /// Integral time, s; 0 without integral action.
    pub ti_s: f64,
    /// Derivative time, s, or 0.
    pub td_s: f64,
    /// Ultimate gain over controller gain.
    pub gain_margin: f64,
    /// The situation of the loop.
    pub situation: Situation,
    /// Kind of controller.
    pub controller: ControllerKind,
    /// Standard deviation of the controller's own noise on the OP, percent, or 0.
    pub own_noise: f64,
    /// Effect of another loop's valve or PV on this one's load, or 0.
    pub coupling: f64,
    /// Lower limit of the OP, percent.
    pub op_low: f64,
    /// Upper limit of the OP, percent.
    pub op_high: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Steps of the controller a sample.
    pub steps_per_sample: usize,
    /// The scale of all events in the loop, percent of OP.
    pub activity: f64,
    /// Kind of noise.
    pub noise: NoiseKind,
    /// Standard deviation of the noise over gain times activity.
    pub noise_ratio: f64,
    /// Whether the noise grows or shrinks.
    pub non_stationary: bool,
    /// Kind of set point.
    pub set_point: SetPointKind,
    /// Play of the transmitter, percent of span, or 0.
    pub sensor_play: f64,
    /// Half the gap of the controller, percent of span, or 0.
    pub controller_gap: f64,
    /// Resolution of the PV that the controller sees, percent of span, or 0.
    pub transmitter_quantum: f64,
    /// Whether the historian averages over the sample.
    pub averaged: bool,
    /// Samples for which the historian holds the PV.
    pub held_samples: usize,
    /// Resolution of the recorded OP, percent; 0 without quantisation.
    pub op_quantum: f64,
    /// Resolution of the recorded PV, in standard deviations of the PV; 0 without quantisation.
    pub pv_quantum: f64,
    /// Deviation of the swinging door on the OP, in standard deviations of the OP; 0 without compression.
    pub op_compression: f64,
    /// Deviation of the swinging door on the PV, in standard deviations of the PV; 0 without compression.
    pub pv_compression: f64,
    /// Smallest reported change of the OP, in standard deviations of the OP; 0 without exception reporting.
    pub op_exception: f64,
    /// Smallest reported change of the PV, in standard deviations of the PV; 0 without exception reporting.
    pub pv_exception: f64,
    /// Processing of the historian.
    pub historian: Vec<HistorianKind>,
    /// Disturbances of the loop from outside, without the cause of its kind.
    pub disturbances: Vec<DisturbanceKind>,
    /// Share of the record in which a faulty valve has its S and J; 0 for a healthy valve.
    pub faulty_share: f64,
    /// Range of the OP over the record, percent.
    pub op_travel: f64,
    /// Share of the record in which the OP is at a limit.
    pub at_limit: f64,
    /// Units of the recorded PV in 100 percent of its span.
    pub pv_span: f64,
    /// The recorded PV at 0 % of its span, in its units.
    pub pv_low: f64,
    /// Number of rejected draws before this one.
    pub redrawn: usize,
}

/// A value of the truth, for tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fact {
    /// A number.
    Number(f64),
    /// A whole number.
    Count(usize),
    /// Whether something holds.
    Flag(bool),
    /// A name, or none.
    Text(Option<&'static str>),
}

impl fmt::Display for Fact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => value.fmt(f),
            Self::Count(value) => value.fmt(f),
            Self::Flag(value) => value.fmt(f),
            Self::Text(value) => value.unwrap_or_default().fmt(f),
        }
    }
}

impl Truth {
    /// Properties by name, for tables, before the properties of its [`Facts`].
    pub fn entries(&self) -> [(&'static str, Fact); 10] {
        [
            ("kind", Fact::Text(Some(self.kind.name()))),
            ("sticks", Fact::Flag(self.sticks)),
            ("visible", Fact::Flag(self.visible)),
            ("model", Fact::Text(self.model.map(|model| model.describe().name))),
            ("S", Fact::Number(self.s)),
            ("J", Fact::Number(self.j)),
            ("slips", Fact::Count(self.slips)),
            ("evidence_nats", Fact::Number(self.gain)),
            ("swing", Fact::Number(self.swing)),
            ("op_noise", Fact::Number(self.op_noise)),
        ]
    }
}

impl Facts {
    /// All facts by name, for tables, except the historian and the disturbances. Disturbances with numbers are
    /// included, and all disturbances are in [`Truth::families`].
    pub fn entries(&self) -> Vec<(&'static str, Fact)> {
        /// The names equal the names of the fields.
        macro_rules! entries {
            (@ text $name:ident) => { Fact::Text(Some(self.$name.name())) };
            (@ number $name:ident) => { Fact::Number(self.$name) };
            (@ count $name:ident) => { Fact::Count(self.$name) };
            (@ flag $name:ident) => { Fact::Flag(self.$name) };
            ($($kind:ident $name:ident,)*) => {
                vec![$((stringify!($name), entries!(@ $kind $name))),*]
            };
        }
        entries!(
            text process, number gain, number tau_s, number tau2_s, number dead_time_s, number valve_lag_s,
            number pv_filter_s, number kc, number ti_s, number td_s, number gain_margin, text situation, text controller,
            number own_noise, number coupling, number op_low, number op_high, number sample_time_s,
            count steps_per_sample, number activity, text noise, number noise_ratio, flag non_stationary, text set_point,
            number sensor_play, number controller_gap, number transmitter_quantum, flag averaged, count held_samples,
            number op_quantum, number pv_quantum, number op_compression, number pv_compression, number op_exception,
            number pv_exception, number faulty_share, number op_travel, number at_limit, number pv_span, count redrawn,
        )
    }
}
