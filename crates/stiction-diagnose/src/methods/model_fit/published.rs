//! The common inputs and results of the published Hammerstein methods.

use crate::Bands;
use crate::finding::Abstention;
use crate::identify::arx::{Fits, Target};
use crate::series::{decimated, quantile, standardised};
use crate::simd::Width;
use crate::valve::lanes::{LANES, Lane, Laned, follow};
use crate::valve::{Model, Start, Valve};

/// Samples per period after reduction of denser recordings.
pub const SAMPLES_PER_PERIOD: f64 = 60.0;
/// Largest number of samples: the last ones of longer recordings.
pub const MOST_SAMPLES: usize = 1500;
/// Smallest number of samples for a fit.
pub const FEWEST_SAMPLES: usize = 100;
/// Fewest samples per period: with fewer, slips are invisible.
pub const SHORTEST_PERIOD: f64 = 8.0;
/// Delays besides one and two samples, shares of the period.
const DELAYS: [f64; 4] = [0.05, 0.1, 0.16, 0.24];

/// A valve model before a linear process, fitted to OP and PV.
#[derive(Debug, Clone, PartialEq)]
pub struct HammersteinFit {
    /// The valve model.
    pub model: Model,
    /// Stick band plus dead band, percent of span.
    pub s: f64,
    /// Slip jump, percent of span.
    pub j: f64,
    /// Delay from valve to PV, samples of the fit.
    pub delay: usize,
    /// Logarithm of a ratio of mean square errors: a valve that follows over this valve.
    pub gain: f64,
    /// Gain above which the valve sticks.
    pub threshold: f64,
    /// Whether the valve sticks.
    pub sticks: bool,
    /// The tried S with the gain of the best J, ascending in S.
    pub profile: Vec<(f64, f64)>,
    /// Recorded samples per sample of the fit.
    pub factor: usize,
    /// First recorded sample of the fit.
    pub from: usize,
    /// OP, percent.
    pub op: Vec<f64>,
    /// Position of the valve, percent.
    pub vp: Vec<f64>,
    /// PV of mean 0 and variance 1.
    pub pv: Vec<f64>,
    /// PV of the fit; never NaN, the PV itself at samples without a prediction.
    pub fitted: Vec<f64>,
}

/// OP and PV as input of the methods.
pub(super) struct Window {
    pub op: Vec<f64>,
    pub pv: Vec<f64>,
    /// Span of the OP, 1 % to 99 %.
    pub span: f64,
    /// Samples of the window.
    pub period: f64,
    pub factor: usize,
    pub from: usize,
}

/// The tried bands, with their errors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub bands: Bands,
    pub sse: f64,
    pub delay: usize,
}

impl Window {
    /// A window from recorded OP (percent) and PV, with a period in samples.
    pub fn of(op: &[f64], pv: &[f64], period: Option<f64>) -> Result<Self, Abstention> {
        let Some(period) = period.filter(|p| p.is_finite() && *p >= SHORTEST_PERIOD) else {
            return Err(Abstention(format!(
                "needs the period of an oscillation, of at least {SHORTEST_PERIOD} samples"
            )));
        };
        if op.len() != pv.len() || op.iter().chain(pv).any(|v| !v.is_finite()) {
            return Err(Abstention("a sample of OP or PV is not a number".to_owned()));
        }
        let factor = ((period / SAMPLES_PER_PERIOD) as usize).max(1);
        let period = period / factor as f64;
        let n = (op.len() / factor).min(MOST_SAMPLES);
        if n < FEWEST_SAMPLES || period > 0.5 * n as f64 {
            return Err(Abstention(format!(
                "needs {FEWEST_SAMPLES} samples and two periods; there are {n} samples, and the period is \
                 {period:.0} samples"
            )));
        }
        let from = op.len() - n * factor;
        let op = decimated(&op[from..], factor);
        let span = quantile(&op, 0.99) - quantile(&op, 0.01);
        let flat = || Abstention("the OP or the PV does not move".to_owned());
        let pv = standardised(&decimated(&pv[from..], factor)).ok_or_else(flat)?;
        if !(span > 1e-6 && span < 1e9 && pv.iter().all(|v| v.is_finite())) {
            return Err(flat());
        }
        Ok(Self { op, pv, span, period, factor, from })
    }

    /// The delays to try, ascending.
    pub fn delays(&self) -> Vec<usize> {
        let mut delays = vec![1, 2];
        delays.extend(DELAYS.map(|share| (share * self.period).round() as usize));
        delays.retain(|delay| *delay > 0);
        delays.sort_unstable();
        delays.dedup();
        delays
    }

    /// The PV, prepared for the fit.
    pub fn target(&self) -> Result<Target, Abstention> {
        Target::new(&self.pv, &self.delays())
            .ok_or_else(|| Abstention("the PV cannot be predicted from its past".to_owned()))
    }

    /// Positions of up to sixteen valves.
    pub fn follow<M: Laned>(&self, bands: &[Bands]) -> Vec<Lane> {
        let lanes = std::array::from_fn(|l| bands[l.min(bands.len() - 1)]);
        let mut vp = vec![Lane::splat(0.0); self.op.len()];
        follow::<M>(&lanes, Start::at_rest(self.op[0]), &self.op, &mut vp, Width::widest());
        vp
    }

    /// The errors of linear models of order five behind valves with each of `bands`, at the best delay.
    pub fn try_all<M: Laned>(&self, target: &Target, bands: &[Bands]) -> Vec<Candidate> {
        let mut tried = vec![];
        for bands in bands.chunks(LANES) {
            let Fits { sse, delay } =
                target.fit(&self.centred(self.follow::<M>(bands)), Width::widest());
            let found = bands.iter().zip(sse.iter().zip(delay));
            tried.extend(found.map(|(&bands, (&sse, delay))| Candidate { bands, sse, delay }));
        }
        tried
    }

    /// Positions less the first OP, in spans: as large as the PV.
    fn centred(&self, mut vp: Vec<Lane>) -> Vec<Lane> {
        let (level, scale) = (self.op[0], 1.0 / self.span);
        for x in &mut vp {
            *x = Lane::from_fn(|l| (x[l] - level) * scale);
        }
        vp
    }

    /// Positions of one valve that begins at the OP, percent.
    pub fn positions(&self, model: Model, bands: Bands) -> Result<Vec<f64>, Abstention> {
        self.positions_from(model, bands, self.op[0])
    }

    /// Positions of one valve that begins at `position`, percent.
    pub fn positions_from(
        &self,
        model: Model,
        bands: Bands,
        position: f64,
    ) -> Result<Vec<f64>, Abstention> {
        let refuse = |why: crate::Error| Abstention(why.to_string());
        let mut valve = model.build(bands).map_err(refuse)?;
        valve.restart(Start { op: self.op[0], ..Start::at_rest(position) });
        let mut vp = vec![0.0; self.op.len()];
        valve.run(&self.op, &mut vp).map_err(refuse)?;
        Ok(vp)
    }

    /// Positions as inputs: in spans, of mean about 0.
    pub fn input(&self, vp: &[f64]) -> Vec<f64> {
        vp.iter().map(|x| (x - self.op[0]) / self.span).collect()
    }

    /// Bands with S and J as shares of the span and of S.
    pub fn bands(&self, s: f64, ratio: f64) -> Bands {
        let s = s * self.span;
        Bands::from_s_j(s, (ratio * s).min(s)).unwrap_or(Bands::NONE)
    }
}

/// `ln(a / b)` of two mean square errors, always finite.
pub(super) fn gain(a: f64, b: f64) -> f64 {
    let floor = 1e-9;
    ((a.max(0.0) + floor) / (b.max(0.0) + floor)).ln()
}

/// The best gain at each S, ascending.
pub(super) fn profile(tried: impl IntoIterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut by_s: Vec<(f64, f64)> = tried.into_iter().collect();
    by_s.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    by_s.dedup_by_key(|point| point.0);
    by_s
}

/// `values` from `first` on, and `before` until then.
pub(super) fn behind(before: &[f64], first: usize, values: impl Iterator<Item = f64>) -> Vec<f64> {
    before[..first].iter().copied().chain(values).collect()
}

#[cfg(test)]
pub(super) mod samples {
    use crate::Bands;
    use crate::closed_loop::{ClosedLoop, Controller, Process, Signal, Wave};
    use crate::valve::{Assembly, Model};

    /// OP, PV and period of a loop at 0.36 s a sample; a valve with S = 0 follows, and a wave disturbs it.
    pub fn recorded(model: Model, s: f64, j: f64, noise: f64) -> (Vec<f64>, Vec<f64>, f64) {
        let valve = model.build(Bands::from_s_j(s, j).unwrap()).unwrap();
        let mut plant = ClosedLoop::new(
            Controller::pi(1.1, 2.5).unwrap(),
            Assembly::new(valve),
            Process::first_order(1.5, 5.93, 1.07).unwrap(),
        );
        plant.set_point = 5.0.into();
        (plant.sample_time, plant.samples) = (0.36, 1200);
        plant.measurement = vec![Signal::Noise { sd: noise, tau_s: 0.0, seed: 1 }];
        let run = plant.run().unwrap();
        if s > 0.0 {
            let period = run.period_s().unwrap() / 0.36;
            return (run.op[200..].to_vec(), run.pv[200..].to_vec(), period);
        }
        plant.load = vec![Signal::Periodic {
            mean: 0.0,
            wave: Wave::Sine,
            amplitude: 2.0,
            period_s: 18.0,
            phase: 0.0,
        }];
        let run = plant.run().unwrap();
        (run.op[200..].to_vec(), run.pv[200..].to_vec(), 50.0)
    }
}
