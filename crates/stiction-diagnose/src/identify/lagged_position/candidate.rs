//! A candidate: a valve, the position of its lag, and its result.

/// Number of blocks of the scored samples, to compare losses by events and not by samples.
pub(super) const BLOCKS: usize = 40;

/// Position of the stem's lag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Behind the friction: the valve moves at once, and the recorded position lags.
    After,
    /// Before it: the drive of the valve lags, as the pressure in an actuator does.
    Before,
}

/// Movement of the valve once it slips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Friction {
    /// It follows until the input turns: [`TwoPhase`](crate::valve::TwoPhase); with J = 0, a play.
    TwoPhase,
    /// It stops at once, once a sample: [`He`](crate::valve::He); with fd = 0, Stenman's.
    He,
    /// It stops at any time between two samples.
    HeBetween,
}

/// A valve to try.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub place: Place,
    pub friction: Friction,
    pub fs: f64,
    pub fd: f64,
    /// A second lag after all other parts, as a multiple of the first lag.
    pub second: f64,
}

impl Candidate {
    pub fn s(&self) -> f64 {
        self.fs + self.fd
    }

    pub fn j(&self) -> f64 {
        self.fs - self.fd
    }

    /// The valve that follows.
    pub fn ideal(place: Place, second: f64) -> Self {
        Self { place, friction: Friction::TwoPhase, fs: 0.0, fd: 0.0, second }
    }

    pub fn is_ideal(&self) -> bool {
        self.fs == 0.0
    }
}

/// A candidate at its best lag, gain and delay.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fitted {
    pub candidate: Candidate,
    /// Lag, samples.
    pub lag: f64,
    /// Delay of the first tap, samples.
    pub delay: usize,
    /// Gains of two consecutive taps.
    pub taps: [f64; 2],
    /// Sum of the losses.
    pub loss: f64,
    /// The same by block.
    pub blocks: [f64; BLOCKS],
}

impl Fitted {
    pub fn gain(&self) -> f64 {
        self.taps[0] + self.taps[1]
    }
}

/// Standard deviations by which `other` is worse than `best`, with independent blocks.
pub(super) fn worse_by(other: &Fitted, best: &Fitted) -> f64 {
    let differences: [f64; BLOCKS] = std::array::from_fn(|b| other.blocks[b] - best.blocks[b]);
    let n = BLOCKS as f64;
    let sum: f64 = differences.iter().sum();
    let about: f64 = differences.iter().map(|d| (d - sum / n) * (d - sum / n)).sum();
    sum / (n / (n - 1.0) * about).sqrt().max(f64::MIN_POSITIVE)
}
