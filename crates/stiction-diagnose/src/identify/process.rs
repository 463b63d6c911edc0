//! The process between valve position and PV: gain, lag and dead time, in closed loop, under correlated
//! disturbances.
//!
//! # What it measures
//! First order plus dead time, or an integrator plus dead time. The result is not one best process but all that
//! explain the PV nearly as well, each with its weight.
//!
//! # Assumptions
//! A linear process around one operating point. The input is known: a recorded valve position, or the output of a
//! valve model under the OP. The disturbance of the PV is white noise through an autoregression of order [`ORDER`],
//! for the whole record.
//!
//! # Equations
//! ```text
//! z(k) = a z(k-1) + (1 - a) x(k-1),  a = exp(-Ts/tau)          self-regulating
//! z(k) = z(k-1) + Ts x(k-1)                                    integrating
//! A(q) (y(k) - K z(k-d) - c - w a^k) = e(k)                    integrating: w k instead of w a^k
//! ```
//! `A` comes from a regression of y on its own past and on past x, then, twice, from the residual of the best process.
//! For each tau and d of a grid, least squares gives K, c and w. The grid is refined around the likeliest. With the
//! variance of e profiled out, the log-likelihood is `-m/2 ln SSE`. A process has the weight `exp((likelihood - best) /
//! `[`TEMPER`]`)`, because no process is exactly of first order and no disturbance that simple. Intervals are the 5 and
//! 95 % points of the weighted processes, including K's own error.
//!
//! # Limits
//! * The input must move more than the controller's response to the PV's own noise. Otherwise the fit tends to the
//!   inverse of the controller, and the interval is wide.
//! * Second lags count as part of the dead time.
//! * A lag beyond a third of the record cannot be distinguished from an integrator. Then only the ratio of gain and
//!   lag is identified.
//!
//! # References
//! L. Ljung, System Identification: Theory for the User, 2nd ed., Prentice Hall (1999), for direct identification in
//! closed loop with a noise model (recalled, not read). The weighting is ours.

use super::fopdt::ProcessKind;
use crate::estimate::Estimate;
use crate::finding::Abstention;
use crate::numeric::least_squares::{dot, least_squares};
use crate::series::{centred, std};

/// Smallest number of samples for a fit.
pub const FEWEST_SAMPLES: usize = 80;
/// Number of samples above which only the middle is used.
pub const MOST_SAMPLES: usize = 4000;
/// Order of the disturbance.
pub const ORDER: usize = 4;
/// Divisor of log-likelihoods.
pub const TEMPER: f64 = 12.0;
/// Relative standard deviation of gain and dead time in any record, and two thirds of this value for the lag. A process
/// is linear around one point only, and has more than one lag.
pub const NEVER_KNOWN: f64 = 0.23;
/// Nats by which the input must explain the PV better than its own past.
pub const LEAST: f64 = 20.0;
/// Smallest share of the input's innovations that the PV does not explain. Below it the controller only responds,
/// and the process cannot be distinguished from the controller's inverse.
pub const LEAST_EXCITED: f64 = 0.2;
/// Ratio of the ends of an interval above which a number is not identified.
pub const WIDEST: f64 = 6.0;
/// Past inputs in the regression for the first noise model, samples.
const PAST: [usize; 9] = [1, 2, 3, 5, 8, 13, 21, 34, 55];
/// Lags and largest number of delays of the first grid.
const LAGS: usize = 14;
const DELAYS: usize = 26;
/// Lags whose responses are calculated together.
const TOGETHER: usize = 8;

/// A process that explains the PV, with its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Units of PV per percent; for an integrating one, per percent and second.
    pub gain: f64,
    /// Standard error of the gain.
    pub error: f64,
    /// Time constant, s; infinite for an integrating one.
    pub lag_s: f64,
    /// Dead time, s.
    pub dead_time_s: f64,
    /// All weights add up to 1.
    pub weight: f64,
}

impl Candidate {
    /// Initial slope of the PV after a step of one percent, units of PV per second.
    pub fn slope(&self) -> f64 {
        if self.lag_s.is_finite() { self.gain / self.lag_s } else { self.gain }
    }
}

/// A process identified from the PV and from OP or valve position.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct FittedProcess {
    /// Behaviour under a constant input.
    pub kind: ProcessKind,
    /// Gain, PV units per percent; `None` for an integrating process, or if the data do not separate gain and lag.
    pub gain: Option<Estimate>,
    /// Time constant, s; `None` if the gain is `None`.
    #[cfg_attr(feature = "serde", serde(rename = "tau"))]
    pub lag_s: Option<Estimate>,
    /// Initial slope of the PV after a step of one percent, PV units per second. The slope is gain over lag, and may be
    /// known even if gain and lag are not.
    pub slope: Estimate,
    /// Dead time with all small lags, s.
    #[cfg_attr(feature = "serde", serde(rename = "delay"))]
    pub dead_time_s: Estimate,
    /// Share of the PV's innovations that the input explains.
    pub explained: f64,
    /// What the data cannot identify, in a sentence; `None` if everything is identified.
    pub jointly: Option<String>,
    /// Standard deviation of the disturbance of the PV, in PV units.
    pub disturbance_sd: f64,
    /// Standard deviation of the disturbance's innovations from sample to sample, in PV units.
    pub innovation_sd: f64,
    /// The processes that explain the PV nearly as well, the likeliest first.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub candidates: Vec<Candidate>,
    /// The noise model of the PV: its coefficients on its own last [`ORDER`] samples.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub noise: [f64; ORDER],
    /// Log-likelihood of the best process over the log-likelihood without an input, nats.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub gained: f64,
}

/// Fits the process between `input`, percent, and `pv`, sampled every `step` seconds. `sign` is the sign of the gain,
/// if known, for example from the controller.
///
/// # Errors
/// In words: why it cannot be identified.
pub fn fit(
    input: &[f64],
    pv: &[f64],
    step: f64,
    sign: Option<f64>,
) -> Result<FittedProcess, Abstention> {
    let n = input.len();
    if n != pv.len() || n < FEWEST_SAMPLES {
        return Err(Abstention(format!(
            "a process fit needs at least {FEWEST_SAMPLES} samples of both OP and PV; there are {n} and {}",
            pv.len()
        )));
    }
    let still = || Abstention("the OP or the PV does not move".to_owned());
    let (x, of_x) = of_variance_one(input).ok_or_else(still)?;
    let (y, of_y) = of_variance_one(pv).ok_or_else(still)?;
    let bench = Bench { x: &x, y: &y, sign };
    let mut found = bench.best()?;
    found.scale(of_y / of_x, of_y, step);
    Ok(found.summarised(step))
}

/// The middle of a signal, at most [`MOST_SAMPLES`] samples, with mean 0 and variance 1, and its standard deviation;
/// `None` for a constant signal.
fn of_variance_one(x: &[f64]) -> Option<(Vec<f64>, f64)> {
    let spare = x.len().saturating_sub(MOST_SAMPLES);
    let mut middle = centred(&x[spare / 2..x.len() - spare.div_ceil(2)]);
    let sd = std(&middle);
    middle.iter_mut().for_each(|v| *v /= sd);
    (sd > 0.0).then_some((middle, sd))
}

impl FittedProcess {
    /// The process with the numbers of these processes, such as those behind several valves.
    pub(crate) fn over(self, mut points: Vec<Candidate>, step: f64) -> Self {
        points.retain(|point| point.weight > 1e-4);
        if points.is_empty() {
            return self;
        }
        points.sort_by(|p, q| q.weight.total_cmp(&p.weight));
        let settles: Vec<Candidate> =
            points.iter().copied().filter(|p| p.lag_s.is_finite()).collect();
        let all = if settles.is_empty() { &points } else { &settles };
        Self {
            gain: self.gain.map(|_| of_gain(all)).filter(|of| of.low * of.high > 0.0),
            lag_s: self.lag_s.map(|_| of_lag(all)),
            slope: of_slope(&points),
            dead_time_s: of_dead_time(&points, step),
            candidates: points,
            ..self
        }
    }

    /// Of these processes, the likeliest to explain `pv` in response to other inputs, at most this many; `None` for a
    /// PV that does not move.
    pub fn explaining(&self, pv: &[f64], step: f64, most: usize) -> Option<Explaining<'_>> {
        let (y, of_y) = of_variance_one(pv)?;
        let last = most_delay(&delays(y.len()));
        let candidates = &self.candidates[..most.min(self.candidates.len())];
        let mut by_lag: Vec<(Ground, Vec<usize>)> = vec![];
        for (k, candidate) in candidates.iter().enumerate() {
            let lag = candidate.lag_s / step;
            match by_lag.iter_mut().find(|(ground, _)| ground.lag == lag) {
                Some((_, of_lag)) => of_lag.push(k),
                None => by_lag.push((Ground::of(&y, lag, last, &self.noise), vec![k])),
            }
        }
        Some(Explaining { candidates, noise: &self.noise, step, of_y, last, by_lag, y })
    }
}

/// Processes that may explain a PV behind several inputs.
pub struct Explaining<'a> {
    candidates: &'a [Candidate],
    noise: &'a [f64; ORDER],
    step: f64,
    y: Vec<f64>,
    of_y: f64,
    /// The longest delay, samples.
    last: f64,
    /// Their lags, and the candidates with each.
    by_lag: Vec<(Ground, Vec<usize>)>,
}

impl Explaining<'_> {
    /// How well they explain the PV behind an `input`, such as the path of a valve. Each process has its best gain. The
    /// log-likelihood is in nats, up to a constant. Empty for an input that does not move.
    pub fn behind(&self, input: &[f64]) -> Vec<(Candidate, f64)> {
        let Some((x, of_x)) = of_variance_one(input) else { return vec![] };
        let bench = Bench { x: &x, y: &self.y, sign: None };
        let m = self.y.len() as f64 - ORDER as f64 - self.last;
        let mut found: Vec<(Candidate, f64)> =
            self.candidates.iter().map(|candidate| (*candidate, f64::NAN)).collect();
        let lags: Vec<f64> = self.by_lag.iter().map(|(ground, _)| ground.lag).collect();
        for ((ground, of_lag), answer) in self.by_lag.iter().zip(answers(&x, &lags)) {
            let delay = |k: &usize| self.candidates[*k].dead_time_s / self.step;
            let delays: Vec<f64> = of_lag.iter().map(delay).collect();
            let per = self.of_y / of_x / if ground.lag.is_finite() { 1.0 } else { self.step };
            for (k, point) in of_lag.iter().zip(bench.on(ground, &answer, &delays, self.noise)) {
                let (candidate, likelihood) = &mut found[*k];
                candidate.gain = point.gain * per;
                candidate.error = TEMPER.sqrt() * point.error * per;
                *likelihood = -0.5 * m * point.sse.ln();
            }
        }
        found
    }
}

/// What the fit of a lag needs of the PV alone.
struct Ground {
    lag: f64,
    /// Samples that are left out at the beginning, the same for all delays.
    skip: usize,
    /// The part of the PV that its past does not predict.
    w: Vec<f64>,
    /// Level and decay of the first state, orthonormal.
    basis: Vec<Vec<f64>>,
    of_w: Vec<f64>,
    /// Squares of `w` that the basis leaves.
    free: f64,
}

impl Ground {
    /// For delays up to `last`, samples.
    fn of(y: &[f64], lag: f64, last: f64, a: &[f64; ORDER]) -> Self {
        let n = y.len();
        let mut w = whitened(y, a);
        let along: Vec<f64> = match lag.is_finite() {
            true => (0..n).map(|k| (-(k as f64) / lag).exp()).collect(),
            false => (0..n).map(|k| k as f64 / n as f64).collect(),
        };
        let basis = orthonormal(vec![whitened(&vec![1.0; n], a), whitened(&along, a)]);
        let skip = (last as usize).min(w.len() / 2);
        let basis = orthonormal(basis.iter().map(|b| b[skip..].to_vec()).collect());
        w.drain(..skip);
        let of_w: Vec<f64> = basis.iter().map(|b| dot(b, &w)).collect();
        let free = dot(&w, &w) - dot(&of_w, &of_w);
        Self { lag, skip, w, basis, of_w, free }
    }
}

/// Signals of variance one.
struct Bench<'a> {
    x: &'a [f64],
    y: &'a [f64],
    sign: Option<f64>,
}

/// A process on the grid; times in samples.
#[derive(Debug, Clone, Copy)]
struct Point {
    /// Infinite of an integrator.
    lag: f64,
    delay: f64,
    gain: f64,
    error: f64,
    sse: f64,
}

/// The result of the search.
struct Found {
    points: Vec<Candidate>,
    kind: ProcessKind,
    explained: f64,
    noise: [f64; ORDER],
    gained: f64,
    disturbance_sd: f64,
    innovation_sd: f64,
}

/// The coefficients of a regression of the series on its own past: `x(k) = sum a(i) x(k - i)`.
fn regression(x: &[f64], inputs: &[Vec<f64>], from: usize) -> Option<[f64; ORDER]> {
    let columns: Vec<&[f64]> = (1..=ORDER)
        .map(|i| &x[from - i..x.len() - i])
        .chain(inputs.iter().map(|column| &column[..]))
        .collect();
    let solved = least_squares(&columns, &x[from..])?;
    solved.coefficients[..ORDER].try_into().ok()
}

/// `A x`, from the sample [`ORDER`] on.
fn whitened(x: &[f64], a: &[f64; ORDER]) -> Vec<f64> {
    let n = x.len().saturating_sub(ORDER);
    let before = |by: usize| x.get(ORDER - by..).map_or(x, |x| &x[..n]);
    let (now, past): (_, [&[f64]; ORDER]) = (before(0), std::array::from_fn(|i| before(i + 1)));
    let predicted = |k: usize| (0..ORDER).map(|i| a[i] * past[i][k]).sum::<f64>();
    (0..n).map(|k| now[k] - predicted(k)).collect()
}

/// The responses of processes with these lags and without delay, their gain 1. One sample of a response waits for the
/// last, so all advance together.
fn answers(x: &[f64], lags: &[f64]) -> Vec<Vec<f64>> {
    let of = |lag: &f64| {
        if lag.is_finite() {
            let keep = (-1.0 / lag).exp();
            (keep, 1.0 - keep)
        } else {
            (1.0, 1.0)
        }
    };
    let steps: Vec<(f64, f64)> = lags.iter().map(of).collect();
    let mut all: Vec<Vec<f64>> = lags.iter().map(|_| vec![0.0; x.len()]).collect();
    for (steps, all) in steps.chunks(TOGETHER).zip(all.chunks_mut(TOGETHER)) {
        let mut states = [0.0; TOGETHER];
        let mut before = 0.0;
        for (k, v) in x.iter().enumerate() {
            for ((state, (keep, add)), z) in states.iter_mut().zip(steps).zip(&mut *all) {
                *state = keep * *state + add * before;
                z[k] = *state;
            }
            before = *v;
        }
    }
    all
}

/// Orthonormalises the columns, and drops columns that nearly depend on others.
fn orthonormal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = vec![];
    for mut column in columns {
        let size = dot(&column, &column);
        for unit in &basis {
            let share = dot(&column, unit);
            column.iter_mut().zip(unit).for_each(|(c, u)| *c -= share * u);
        }
        let left = dot(&column, &column);
        if left > 1e-9 * size && left > 0.0 {
            let scale = left.sqrt().recip();
            column.iter_mut().for_each(|c| *c *= scale);
            basis.push(column);
        }
    }
    basis
}

impl Bench<'_> {
    /// Lags of a grid, samples: from a third of a sample to a third of the record.
    fn lags(&self) -> Vec<f64> {
        let (low, high) = (0.35_f64, self.x.len() as f64 / 3.0);
        (0..LAGS).map(|i| low * (high / low).powf(i as f64 / (LAGS - 1) as f64)).collect()
    }

    /// Gain and residual for every lag at every delay.
    fn at(&self, lags: &[f64], delays: &[f64], a: &[f64; ORDER]) -> Vec<Point> {
        let last = most_delay(delays);
        let one = |(lag, answer): (&f64, Vec<f64>)| {
            self.on(&Ground::of(self.y, *lag, last, a), &answer, delays, a)
        };
        lags.iter().zip(answers(self.x, lags)).flat_map(one).collect()
    }

    /// Gain and residual on a basis that was computed for these delays or longer ones.
    fn on(&self, ground: &Ground, answer: &[f64], delays: &[f64], a: &[f64; ORDER]) -> Vec<Point> {
        let Ground { lag, skip, w, basis, of_w, free } = ground;
        let (lag, skip, free) = (*lag, *skip, *free);
        let all = whitened(answer, a);
        let m = w.len() as f64;
        let mut moved = Vec::with_capacity(w.len());
        let one = |delay: &f64| {
            let whole = (delay.floor() as usize).min(skip);
            let share = delay - delay.floor();
            let mut z = &all[skip - whole..][..w.len()];
            if share > 0.0 && whole < skip {
                // Between two samples the held input is a mixture of both.
                let later = &all[skip - whole - 1..][..w.len()];
                moved.clear();
                moved.extend(
                    z.iter().zip(later).map(|(z, later)| (1.0 - share) * z + share * later),
                );
                z = &moved;
            }
            let of_z: Vec<f64> = basis.iter().map(|b| dot(b, z)).collect();
            let square = dot(z, z) - dot(&of_z, &of_z);
            let product = dot(z, w) - dot(&of_z, of_w);
            let mut gain = if square > 0.0 { product / square } else { 0.0 };
            if self.sign.is_some_and(|sign| sign * gain < 0.0) {
                gain = 0.0;
            }
            let sse = (free - gain * (2.0 * product - gain * square)).max(1e-12 * m);
            let error = (sse / m / square.max(1e-300)).sqrt();
            Point { lag, delay: *delay, gain, error, sse }
        };
        delays.iter().map(one).collect()
    }

    /// The residual of the PV for a process.
    fn left(&self, point: &Point) -> Vec<f64> {
        let z = answers(self.x, &[point.lag]).swap_remove(0);
        let whole = point.delay.floor() as usize;
        let share = point.delay - point.delay.floor();
        let before = |k: usize, by: usize| if k < by { 0.0 } else { z[k - by] };
        let made = |k: usize| (1.0 - share) * before(k, whole) + share * before(k, whole + 1);
        let rest: Vec<f64> = (0..self.y.len()).map(|k| self.y[k] - point.gain * made(k)).collect();
        crate::series::detrended(&rest)
    }

    fn best(&self) -> Result<Found, Abstention> {
        let lost = || Abstention("the PV cannot be regressed on its past".to_owned());
        let n = self.y.len();
        let from = PAST.iter().copied().filter(|lag| lag * 8 < n).max().unwrap_or(1).max(ORDER);
        let inputs: Vec<Vec<f64>> = PAST
            .iter()
            .filter(|lag| **lag <= from)
            .map(|lag| self.x[from - lag..n - lag].to_vec())
            .collect();
        let mut a = regression(self.y, &inputs, from).ok_or_else(lost)?;
        let (lags, delays) = (self.lags(), delays(self.x.len()));
        let mut best: Option<Point> = None;
        let mut all = vec![];
        for round in 0..3 {
            all.clear();
            if round == 0 {
                all = self.at(&[&lags[..], &[f64::INFINITY]].concat(), &delays, &a);
            } else if let Some(point) = best {
                all = self.finer(&point, &lags, &delays, &a);
            }
            best = all.iter().copied().min_by(|p, q| p.sse.total_cmp(&q.sse));
            if let Some(point) = &best
                && round < 2
            {
                a = regression(&self.left(point), &[], ORDER).ok_or_else(lost)?;
            }
        }
        let best = best.filter(|point| point.gain != 0.0).ok_or_else(|| {
            Abstention(
                "the process gain would have the wrong sign for the action of the controller"
                    .to_owned(),
            )
        })?;
        let skip = most_delay(&delays) as usize;
        let m = (n - ORDER - skip.min((n - ORDER) / 2)) as f64;
        let without = {
            let a = regression(self.y, &[], ORDER).ok_or_else(lost)?;
            let w = whitened(&crate::series::detrended(self.y), &a);
            dot(&w, &w) / w.len() as f64
        };
        let likelihood = |sse: f64| -0.5 * m * (sse / m).ln();
        let top = likelihood(best.sse);
        let gained = top + 0.5 * m * without.ln();
        if gained < LEAST {
            return Err(Abstention(
                "the OP or valve position explains nothing of the PV beyond the PV's own past; record a set-point step, \
                 or a period with more movement"
                    .to_owned(),
            ));
        }
        let weigh = |point: &Point| ((likelihood(point.sse) - top) / TEMPER).exp();
        // On a grid even in the logarithm of the lag, an integrator represents all slower processes.
        let mut points: Vec<Candidate> = all
            .iter()
            .map(|point| Candidate {
                gain: point.gain,
                error: point.error * TEMPER.sqrt(),
                lag_s: point.lag,
                dead_time_s: point.delay,
                weight: weigh(point),
            })
            .filter(|candidate| candidate.weight > 1e-4 && candidate.gain != 0.0)
            .collect();
        let total: f64 = points.iter().map(|point| point.weight).sum();
        points.iter_mut().for_each(|point| point.weight /= total);
        points.sort_by(|p, q| q.weight.total_cmp(&p.weight));
        let integrates: f64 =
            points.iter().filter(|p| p.lag_s.is_infinite()).map(|p| p.weight).sum();
        if self.excited() < LEAST_EXCITED {
            return Err(Abstention(
                "the OP or valve position only responds to the PV, so process and controller cannot be separated; \
                 record a set-point step"
                    .to_owned(),
            ));
        }
        let left = self.left(&best);
        Ok(Found {
            kind: match integrates > 0.5 {
                true => ProcessKind::Integrating,
                false => ProcessKind::SelfRegulating,
            },
            points,
            explained: 1.0 - best.sse / m / without,
            noise: a,
            gained,
            disturbance_sd: std(&left),
            innovation_sd: (best.sse / m).sqrt(),
        })
    }

    /// The grid around a point: intermediate lags, and neighbouring delays.
    fn finer(&self, point: &Point, lags: &[f64], delays: &[f64], a: &[f64; ORDER]) -> Vec<Point> {
        let near: Vec<f64> = match point.lag.is_finite() {
            true => (-14..=14).map(|i| point.lag * 1.14_f64.powi(i)).collect(),
            false => lags[lags.len() - 3..].to_vec(),
        };
        let longest = self.x.len() as f64;
        let near = near.into_iter().filter(|lag| (0.25..longest).contains(lag));
        let near: Vec<f64> = near.chain([f64::INFINITY]).collect();
        let reach = 2.0 + 0.5 * point.delay;
        let apart = (reach / 10.0).max(0.25);
        // The compared samples are those of the coarse grid.
        let last = delays[delays.len() - 1];
        let mut around: Vec<f64> = (-10..=10)
            .map(|i| point.delay + f64::from(i) * apart)
            .filter(|delay| (0.0..last).contains(delay))
            .collect();
        around.push(last);
        self.at(&near, &around, a)
    }

    /// Share of the input's innovations that the PV does not explain: nearly zero if a linear controller only
    /// responds to the PV.
    fn excited(&self) -> f64 {
        let from = ORDER;
        let n = self.x.len();
        let past: Vec<&[f64]> = (1..=ORDER).map(|i| &self.x[from - i..n - i]).collect();
        let seen = (0..=ORDER).map(|i| &self.y[from - i..n - i]);
        let both: Vec<&[f64]> = past.iter().copied().chain(seen).collect();
        let left = |columns: &[&[f64]]| least_squares(columns, &self.x[from..]).map(|s| s.sse);
        match (left(&past), left(&both)) {
            (Some(alone), Some(with)) if alone > 0.0 => with / alone,
            _ => 1.0,
        }
    }
}

/// The longest of some delays, whole samples. Delays of a grid for a record with this number of samples: every delay at
/// first, then larger steps.
fn delays(samples: usize) -> Vec<f64> {
    let longest = (samples / 8).max(4);
    let mut delays = vec![0];
    while delays.len() < DELAYS && delays[delays.len() - 1] < longest {
        let last = delays[delays.len() - 1];
        delays.push(last + 1 + last / 6);
    }
    delays.into_iter().map(|delay| delay as f64).collect()
}

fn most_delay(delays: &[f64]) -> f64 {
    delays.iter().fold(0.0, |most: f64, delay| most.max(*delay)).ceil()
}

impl Found {
    /// Converts samples and standard deviations to seconds and units.
    fn scale(&mut self, gain: f64, of_y: f64, step: f64) {
        for point in &mut self.points {
            let per = if point.lag_s.is_finite() { 1.0 } else { step };
            point.gain *= gain / per;
            point.error *= gain / per;
            point.lag_s *= step;
            point.dead_time_s *= step;
        }
        self.disturbance_sd *= of_y;
        self.innovation_sd *= of_y;
    }

    fn summarised(self, step: f64) -> FittedProcess {
        let settles: Vec<Candidate> =
            self.points.iter().copied().filter(|p| p.lag_s.is_finite()).collect();
        let share: f64 = settles.iter().map(|p| p.weight).sum();
        let (mut gain, mut lag, mut jointly) = (None, None, None);
        if self.kind == ProcessKind::SelfRegulating && !settles.is_empty() {
            let (of_gain, of_lag) = (of_gain(&settles), of_lag(&settles));
            let wide = |e: &Estimate| {
                !(e.low * e.high > 0.0 && (e.high / e.low).max(e.low / e.high) < WIDEST)
            };
            if share < 0.95 || wide(&of_gain) || wide(&of_lag) {
                jointly = Some(
                    "only the initial slope of the PV after a step (gain/lag) can be identified, not its final \
                     value; the record has no settled step"
                        .to_owned(),
                );
            }
            if share >= 0.95 && !wide(&of_gain) {
                gain = Some(of_gain);
            }
            if share >= 0.95 && !wide(&of_lag) {
                lag = Some(of_lag);
            }
        }
        FittedProcess {
            kind: self.kind,
            gain,
            lag_s: lag,
            slope: of_slope(&self.points),
            dead_time_s: of_dead_time(&self.points, step),
            explained: self.explained,
            jointly,
            disturbance_sd: self.disturbance_sd,
            innovation_sd: self.innovation_sd,
            candidates: self.points,
            gained: self.gained,
            noise: self.noise,
        }
    }
}

fn of_gain(points: &[Candidate]) -> Estimate {
    weighted(points, |p| (p.gain, p.error.hypot(NEVER_KNOWN * p.gain)))
}

fn of_lag(points: &[Candidate]) -> Estimate {
    weighted(points, |p| (p.lag_s, 1.5 * NEVER_KNOWN * p.lag_s))
}

fn of_slope(points: &[Candidate]) -> Estimate {
    let error = |p: &Candidate| (p.error * p.slope() / p.gain).hypot(NEVER_KNOWN * p.slope());
    weighted(points, |p| (p.slope(), error(p)))
}

fn of_dead_time(points: &[Candidate], step: f64) -> Estimate {
    let error = |p: &Candidate| (0.5 * step).hypot(NEVER_KNOWN * p.dead_time_s);
    let found = weighted(points, |p| (p.dead_time_s, error(p)));
    Estimate { low: found.low.max(0.0), value: found.value.max(0.0), ..found }
}

/// Median and the 5 and 95 % points of the candidates, each a normal distribution of this mean and standard
/// deviation.
fn weighted(points: &[Candidate], of: impl Fn(&Candidate) -> (f64, f64)) -> Estimate {
    let all: Vec<(f64, f64, f64)> = points
        .iter()
        .map(|p| {
            let (mean, sd) = of(p);
            (mean, sd.abs(), p.weight)
        })
        .collect();
    let total: f64 = all.iter().map(|(.., weight)| weight).sum();
    let low = all.iter().map(|(m, s, _)| m - 5.0 * s).fold(f64::INFINITY, f64::min);
    let high = all.iter().map(|(m, s, _)| m + 5.0 * s).fold(f64::NEG_INFINITY, f64::max);
    let below = |v: f64| -> f64 {
        let share = |(m, s, w): &(f64, f64, f64)| w * normal((v - m) / s.max(1e-300));
        all.iter().map(share).sum::<f64>() / total
    };
    let at = |p: f64| {
        let (mut low, mut high) = (low, high);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if below(middle) < p { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    Estimate { value: at(0.5), low: at(0.05), high: at(0.95) }
}

/// The normal distribution's cumulative function.
fn normal(z: f64) -> f64 {
    0.5 * statrs::function::erf::erfc(-z / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::{DeadTime, NormalStream, Process, ProcessBank};
    use crate::simd::Lane;

    /// An input that moves in steps, and what a process makes of it under noise that has a memory.
    fn recorded(process: &Process, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let sampled = process.sampled(1.0, DeadTime::Nearest).unwrap();
        let mut bank = ProcessBank::<1, 2>::new([&sampled]);
        let mut stream = NormalStream::new(4);
        let (mut input, mut disturbance) = (0.0, 0.0);
        let mut line = std::collections::VecDeque::from(vec![0.0; sampled.delay()]);
        (0..1500)
            .map(|k| {
                let y = bank.output(0);
                disturbance = 0.9 * disturbance + noise * stream.draw();
                if k % 23 == 0 {
                    input = 2.0 * stream.draw();
                }
                line.push_back(input);
                bank.advance(Lane([line.pop_front().unwrap_or(input)]));
                (input, y + disturbance)
            })
            .unzip()
    }

    #[test]
    fn a_lag_is_found_with_its_gain_and_dead_time() {
        let (x, y) = recorded(&Process::first_order(1.5, 12.0, 4.0).unwrap(), 0.05);
        let found = fit(&x, &y, 1.0, Some(1.0)).unwrap();
        let within = |e: &Estimate, truth: f64| e.low <= truth && truth <= e.high;
        assert_eq!(found.kind, ProcessKind::SelfRegulating);
        assert!(
            within(&found.gain.unwrap(), 1.5) && within(&found.lag_s.unwrap(), 12.0),
            "{found:?}"
        );
        assert!(within(&found.dead_time_s, 4.0), "{:?}", found.dead_time_s);
        assert!(found.jointly.is_none() && found.explained > 0.5);
        let total: f64 = found.candidates.iter().map(|c| c.weight).sum();
        assert!((total - 1.0).abs() < 1e-9);
        // In other units, and slower.
        let y: Vec<f64> = y.iter().map(|v| 30.0 * v - 4.0).collect();
        let scaled = fit(&x, &y, 10.0, Some(1.0)).unwrap();
        let ratio = scaled.gain.unwrap().value / found.gain.unwrap().value;
        assert!((ratio - 30.0).abs() < 1e-6, "{ratio}");
        assert!((scaled.lag_s.unwrap().value / found.lag_s.unwrap().value - 10.0).abs() < 1e-6);
    }

    #[test]
    fn an_integrator_has_a_slope() {
        let (x, y) = recorded(&Process::integrator(0.02, 3.0).unwrap(), 0.02);
        let found = fit(&x, &y, 1.0, None).unwrap();
        assert!(found.slope.low <= 0.02 && 0.02 <= found.slope.high, "{found:?}");
        assert!(found.gain.is_none());
    }

    #[test]
    fn what_explains_nothing_is_not_identified() {
        let (x, _) = recorded(&Process::first_order(1.0, 5.0, 1.0).unwrap(), 0.1);
        let mut stream = NormalStream::new(12);
        let noise: Vec<f64> = x.iter().map(|_| stream.draw()).collect();
        assert!(fit(&x, &noise, 1.0, None).unwrap_err().0.contains("explains nothing"));
        assert!(fit(&x[..40], &noise[..40], 1.0, None).unwrap_err().0.contains("at least"));
        assert!(fit(&vec![1.0; 200], &noise[..200], 1.0, None).is_err());
    }
}
