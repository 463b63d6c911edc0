//! The initial state of a stem simulation, and its result.

use crate::valve::Direction;

/// The initial state of a simulation: at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StemStart {
    /// Position, m.
    pub position_m: f64,
    /// Acting air pressure, Pa; `None` for the first demanded one. It is unused without an air lag.
    pub pressure_pa: Option<f64>,
    /// Whether the bristles of Dahl, LuGre and GMS friction start relaxed, so that the stem first settles onto them, or
    /// start with the largest part of the net force that they can carry.
    pub relaxed: bool,
}

impl StemStart {
    /// At rest at `position_m`, with friction carrying the net force as far as it can.
    pub fn at_rest(position_m: f64) -> Self {
        Self { position_m, pressure_pa: None, relaxed: false }
    }
}

/// The stem at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub time_s: f64,
    /// Position, m.
    pub position_m: f64,
    /// Velocity, m/s.
    pub velocity_m_per_s: f64,
    /// Friction force, N; positive if it opposes upward motion. At an end stop this is the share of the net force
    /// that the packing could carry; the stop carries the rest.
    pub friction_n: f64,
    /// Acting air pressure, Pa.
    pub pressure_pa: f64,
}

/// The kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// The stem broke away from rest, or left an end stop.
    Slip,
    /// It came to rest.
    Stop,
    /// Its velocity changed sign without a rest. Stems with Dahl, LuGre or GMS friction never rest, so this is
    /// their only event besides end stops.
    Reversal,
    /// It met an end stop.
    EndStop,
}

impl EventKind {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Slip => "slip",
            Self::Stop => "stop",
            Self::Reversal => "reversal",
            Self::EndStop => "end stop",
        }
    }
}

/// An event with its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Time, s.
    pub time_s: f64,
    /// Kind.
    pub kind: EventKind,
    /// Direction of the motion that begins (slip, reversal) or ends (stop, end stop).
    pub direction: Direction,
    /// Position, m.
    pub position_m: f64,
}

/// The result of a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// The stem at the requested times.
    pub samples: Vec<Sample>,
    /// All events, in order of time.
    pub events: Vec<Event>,
}

impl Response {
    /// The slips among the events.
    pub fn slips(&self) -> impl Iterator<Item = &Event> {
        self.events.iter().filter(|e| e.kind == EventKind::Slip)
    }

    /// The stops among the events.
    pub fn stops(&self) -> impl Iterator<Item = &Event> {
        self.events.iter().filter(|e| e.kind == EventKind::Stop)
    }
}
