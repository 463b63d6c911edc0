//! Whether a valve sticks, from OP and a recorded position that lags.
//!
//! # What it measures
//! Which of three valves leads from OP to the recorded position VP: one that follows, one with a dead band, or one that
//! sticks. A lag of the stem comes before or after the valve. The result includes S and J with their intervals, and the
//! largest S that the recording allows.
//!
//! # Assumptions
//! OP and VP are percent of the same span, except for an offset and a gain of 0.85 to 1.18. The valve does not
//! change within the recording. The first position of the stem follows from the means or the middles of OP and VP, or
//! both have one zero and span, whichever explains VP best. A VP that only repeats the OP, up to two samples later, is
//! refused.
//!
//! # Equations
//! ```text
//! after:   x = valve(u; fs, fd),  y = L_T x          before:  x = valve(L_T u),  y = x
//! L_T:     l(k) = l(k-1) + (1 - e^(-1/T)) (x(k) - l(k-1)),   and a second one of r T behind it, r up to 1
//! VP(k) = o + g0 y(k-d) + g1 y(k-d-1) + e(k),    d = 0, 1, 2;  g0, g1 >= 0: dead time and sampling instant
//! loss  = sum Huber(e(k) - rho e(k-1))
//! ```
//! Both fits are of the output: the recorded position does not correct an error of the simulated one. Losses are
//! summed over 40 blocks; a candidate is worse than the best by
//!
//! ```text
//! t = sum D / sqrt(40/39 sum (D - mean D)^2),    D = its loss less that of the best, in a block
//! ```
//! which counts events and not samples.
//!
//! ```text
//! 90 % interval of S: every S with t <= 2, wider by 3 % and 0.02 %;  of J: t <= 5
//! sticks            t above the threshold for every candidate with S <= max(0.3, quantum of VP), and S >= 0.4
//! follows           else, t <= 2.5, and the upper end for S is below 1 % and a quarter of the range of the OP
//! open              otherwise
//!
//! threshold = 5     if S < 1.5 w: unrecorded moves, or the noise of the OP, may look alike
//!             2     if S >= 3 w, and of n samples n ln(loss of the best healthy / least loss) > 3 ln n
//!             2.5   else
//! ```
//! with w the root of a third of the mean square of the OP's second differences, which for white noise is the
//! standard deviation of its changes. The second line is for few slips: blocks without a slip lower t, but not the
//! likelihood.
//!
//! If the controller may have acted between two samples ([`Moves::MayBeMissed`]), the stem has followed unrecorded
//! moves: the upper end for S is then 1.5 w higher, and the thresholds of 2 and 2.5 are 2.5 and 3.5.
//!
//! # Parameters
//! None. The widths of the intervals are quantiles over simulated recordings (conformal: the smallest t at which an
//! interval contains the truth). With these thresholds, none of 434 simulated healthy valves is accused. Both are
//! ours.
//!
//! # Limits
//! If a band shows equally in m of the 40 blocks, t is at most sqrt(0.975 m / (1 - m/40)), so t > 2.5 needs six blocks.
//! J is at most S: a slip that overshoots the input is not among the candidates. A recording longer than 16,000 samples
//! is reduced to eight evenly spread pieces.
//!
//! # References
//! The models: see [`crate::valve`]. Everything else is ours.

mod between;
mod candidate;
mod evaluate;
mod recorded;
mod search;

pub use candidate::{Friction, Place};
pub use recorded::{Moves, moves};

use crate::finding::Abstention;
use crate::series::{quantile, span};
use crate::spoken::{counted, rough, time};
use candidate::worse_by;

/// Smallest number of samples for a judgement: forty blocks of five.
pub const FEWEST_SAMPLES: usize = 200;
/// Largest S of a healthy valve, percent.
pub const HEALTHY_UP_TO: f64 = 0.3;
/// Smallest S of an accused valve, percent; between this and a healthy S nothing is decided.
pub const ACCUSED_FROM: f64 = 0.4;
/// A valve is cleared if S is below this, percent, and below this share of the OP's range: of 236 undecided simulated loops
/// cleared with a smaller range of the OP, 29 stuck by more than the limit; of 303 others, 13.
pub const CLEARED_BELOW: f64 = 1.0;
const OF_RANGE: f64 = 0.25;

/// A number with its 90 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The value of the best fit.
    pub value: f64,
    /// Lower end; never negative.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Behaviour of a valve by its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Behaviour {
    /// It sticks, or has a dead band, by at least [`ACCUSED_FROM`].
    Sticks,
    /// It follows, except for a band below [`CLEARED_BELOW`].
    Follows,
    /// It does not move although the OP does.
    DoesNotMove,
    /// None of the three valves is certain.
    Open,
}

/// The judgement of a valve from OP and position. S, J, and VP in percent of span of the OP; lags in samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Behaviour.
    pub behaviour: Behaviour,
    /// Stick band plus dead band, with the interval; 0 to infinity for a valve that does not move.
    pub s: Interval,
    /// Slip jump, at most S.
    pub j: Interval,
    /// S is below this with 95 % confidence; infinite for a valve that does not move.
    pub s_limit: f64,
    /// Standard deviations by which every healthy valve is worse than the best.
    pub t: f64,
    /// The t from which the valve sticks.
    pub threshold: f64,
    /// Whether the record contains every move of the controller.
    pub moves: Moves,
    /// Standard deviation of the OP's changes from sample to sample, except for straight lines, percent.
    pub op_change: f64,
    /// Movement of the best valve.
    pub friction: Friction,
    /// Position of its lag.
    pub place: Place,
    /// Lag, samples.
    pub lag: f64,
    /// The lag behind that, samples.
    pub second_lag: f64,
    /// Delay, samples.
    pub delay: f64,
    /// Percent of VP per percent of position.
    pub gain: f64,
    /// Share of the variance of VP that it explains.
    pub explained: f64,
    /// Standard deviation of the residual of VP, robust, percent.
    pub left: f64,
    /// Standard deviation of the noise of VP, percent.
    pub noise: f64,
    /// Step in which VP is recorded, percent; 0 without a step.
    pub quantum: f64,
    /// OP travel, percent.
    pub op_travel: f64,
    /// Range of the OP without the highest and lowest hundredth of its values, percent.
    pub op_range: f64,
    /// VP travel, except for a hundredth at either end, percent.
    pub vp_travel: f64,
}

impl Judgement {
    /// The result in a sentence without a full stop.
    pub fn sentence(&self, sample_time: f64) -> String {
        let lag = match (self.lag + self.second_lag) * sample_time {
            lag if lag > 0.0 => format!(" behind a lag of {}", time(lag)),
            _ => String::new(),
        };
        match self.behaviour {
            Behaviour::Sticks => format!(
                "fitted to the measured position, S = {} % ({} to {}) and J = {} % ({} to {}){lag}. Every model of \
                 a valve that follows the OP fits worse by at least {:.1} standard deviations (limit {})",
                rough(self.s.value),
                rough(self.s.low),
                rough(self.s.high),
                rough(self.j.value),
                rough(self.j.low),
                rough(self.j.high),
                self.t,
                self.threshold
            ),
            Behaviour::Follows => format!(
                "the measured position follows the OP{lag}; with 95 % confidence S is below {} %",
                rough(self.s_limit)
            ),
            Behaviour::DoesNotMove => format!(
                "the OP travels {} %, but the measured position only {} %",
                rough(self.op_travel),
                rough(self.vp_travel)
            ),
            Behaviour::Open => format!(
                "by the measured position, S may be up to {} %{}",
                rough(self.s_limit),
                match self.moves {
                    Moves::Recorded => "",
                    Moves::MayBeMissed =>
                        ", because the controller may have acted between two samples of the record",
                }
            ),
        }
    }
}

/// Largest t of a possible S, and of a possible J.
const POSSIBLE_S: f64 = 2.0;
const POSSIBLE_J: f64 = 5.0;

/// Addition to the upper end of S if moves may be missed, in standard deviations of the OP's changes.
fn unseen(moves: Moves) -> f64 {
    match moves {
        Moves::Recorded => 0.0,
        Moves::MayBeMissed => 1.5,
    }
}

/// The t from which a valve sticks.
const STICKS: f64 = 2.5;
/// The t from which a valve sticks if moves may be missed.
const STICKS_MISSED: f64 = 3.5;

/// The t from which a valve sticks. It depends on the ratio of S to the OP's changes, and on the gain of its likelihood
/// over `n` samples.
fn threshold(s: f64, op_change: f64, gained: f64, n: usize, moves: Moves) -> f64 {
    let clear = s >= 3.0 * op_change && gained > 3.0 * (n as f64).ln();
    match (s < 1.5 * op_change, clear, moves) {
        (true, ..) => 5.0,
        (false, true, Moves::Recorded) => 2.0,
        (false, true, Moves::MayBeMissed) | (false, false, Moves::Recorded) => STICKS,
        (false, false, Moves::MayBeMissed) => STICKS_MISSED,
    }
}

/// Judges a valve by OP and position, both in percent of span and sampled at the same times.
///
/// ```
/// use stiction_model::Bands;
/// use stiction_diagnose::identify::lagged_position::{Behaviour, Moves, judge};
/// use stiction_model::valve::{Model, Valve};
/// let op: Vec<f64> = (0..1500).map(|k| 50.0 + 8.0 * (0.05 * k as f64).sin()).collect();
/// let mut stem = Model::TwoPhase.build(Bands::from_s_j(3.0, 1.0)?)?;
/// let mut x = vec![0.0; op.len()];
/// stem.run(&op, &mut x)?;
/// // The transmitter is behind by four samples.
/// let mut seen = op[0];
/// let vp: Vec<f64> = x.iter().map(|x| { seen += 0.22 * (x - seen); seen }).collect();
/// let judged = judge(&op, &vp, Moves::Recorded).expect("it moves");
/// assert_eq!(judged.behaviour, Behaviour::Sticks);
/// assert!((judged.s.value - 3.0).abs() < 0.15 && (judged.j.value - 1.0).abs() < 0.3);
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # Errors
/// If the signals have fewer than [`FEWEST_SAMPLES`] samples or differ in length, a sample is not finite or beyond 1e9
/// percent, the OP is constant, the position only repeats the OP, or no valve leads from the OP to the position.
pub fn judge(op: &[f64], vp: &[f64], moves: Moves) -> Result<Judgement, Abstention> {
    let refuse = |why: String| Err(Abstention(why));
    if op.len() != vp.len() || op.len() < FEWEST_SAMPLES {
        return refuse(format!(
            "a judgement by position needs at least {FEWEST_SAMPLES} samples of both signals; there are {} of OP \
             and {} of the position",
            op.len(),
            vp.len()
        ));
    }
    if !op.iter().chain(vp).all(|v| v.abs() < 1e9) {
        return refuse("a sample of OP or valve position is not a percentage".to_owned());
    }
    let op_travel = span(op);
    if !(op_travel > 1e-9) {
        return refuse("the OP never moves".to_owned());
    }
    if let Some(delay) = recorded::copied(op, vp) {
        let of = match delay {
            0 => "in every sample".to_owned(),
            delay => format!("of {} before", counted(delay, "sample")),
        };
        return refuse(format!("it equals the OP {of}, so it is a copy and not a measurement"));
    }
    let (noise, quantum) = (recorded::noise(vp), recorded::quantum(vp));
    let most = |x: &[f64]| quantile(x, 0.99) - quantile(x, 0.01);
    let (op_range, vp_travel) = (most(op), most(vp));
    let found = search::search(op, vp);
    let best = &found.all[found.best];
    let op_change = restlessness(op);
    let t: Vec<f64> = found.all.iter().map(|other| worse_by(other, best)).collect();
    let range = |within: f64, of: fn(&candidate::Candidate) -> f64| {
        let possible = found.all.iter().zip(&t).filter(|(_, t)| **t <= within);
        let values = possible.map(|(fitted, _)| of(&fitted.candidate));
        values.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)))
    };
    let ends = |(low, high): (f64, f64)| ((0.97 * low - 0.02).max(0.0), 1.03 * high + 0.02);
    let (s_low, s_high) = ends(range(POSSIBLE_S, candidate::Candidate::s));
    let (j_low, j_high) = ends(range(POSSIBLE_J, candidate::Candidate::j));
    let healthy = found.all.iter().zip(&t);
    let healthy = healthy.filter(|(fitted, _)| fitted.candidate.s() <= HEALTHY_UP_TO.max(quantum));
    let (t, healthiest) = healthy
        .fold((f64::INFINITY, f64::INFINITY), |(least, loss), (fitted, t)| {
            (least.min(*t), loss.min(fitted.loss))
        });
    let n = op.len().min(search::MOST_SAMPLES);
    let gained = n as f64 * (healthiest / best.loss.max(f64::MIN_POSITIVE)).ln();
    let (s, j) = (best.candidate.s(), best.candidate.j());
    let high = s_high + unseen(moves) * op_change;
    let mut judged = Judgement {
        behaviour: Behaviour::Open,
        s: Interval { value: s, low: s_low, high },
        j: Interval { value: j, low: j_low, high: j_high.min(high) },
        s_limit: high,
        t,
        threshold: threshold(s, op_change, gained, n, moves),
        moves,
        op_change,
        friction: best.candidate.friction,
        place: best.candidate.place,
        lag: best.lag,
        second_lag: best.lag * best.candidate.second,
        delay: best.delay as f64 + best.taps[1] / best.gain(),
        gain: best.gain(),
        explained: found.explained,
        left: found.left,
        noise,
        quantum,
        op_travel,
        op_range,
        vp_travel,
    };
    judged.behaviour = behaviour(&judged, found.free_gain);
    if judged.behaviour == Behaviour::DoesNotMove {
        judged.s_limit = f64::INFINITY;
        judged.s = Interval { value: f64::INFINITY, low: 0.0, high: f64::INFINITY };
        judged.j = Interval { value: 0.0, low: 0.0, high: f64::INFINITY };
    } else if judged.explained < LEAST_EXPLAINED && judged.left > FAR * noise {
        return refuse(format!(
            "no valve model explains the recorded position (the best explains {:.0} %), which may be of another \
             valve or another time",
            100.0 * judged.explained.max(0.0)
        ));
    }
    Ok(judged)
}

/// Shares of the variance that a valve must explain if more than noise remains: to be judged, to be accused.
const LEAST_EXPLAINED: f64 = 0.5;
const WELL_EXPLAINED: f64 = 0.7;
/// Limit of noise, in its standard deviations.
const FAR: f64 = 4.0;
/// A position that travels less than this many standard deviations of its noise does not move.
const STILL: f64 = 6.0;
/// OP travel from which a stem without movement does not respond, percent.
const TOLD: f64 = 2.0;
/// Gain below which a position does not follow.
const NO_GAIN: f64 = 0.05;

/// Standard deviation of the OP's changes from sample to sample, without straight lines: root of a third of the
/// mean square of its second differences, which for white noise gives its own change.
fn restlessness(op: &[f64]) -> f64 {
    let seconds = op.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]);
    (seconds.map(|d| d * d).sum::<f64>() / (3.0 * op.len() as f64)).sqrt()
}

fn behaviour(judged: &Judgement, free_gain: f64) -> Behaviour {
    let still = judged.vp_travel <= STILL * judged.noise.max(judged.quantum);
    if still && free_gain < NO_GAIN {
        let told = judged.op_travel >= TOLD.max(4.0 * judged.vp_travel);
        return if told { Behaviour::DoesNotMove } else { Behaviour::Open };
    }
    let explained = judged.explained >= WELL_EXPLAINED || judged.left <= FAR * judged.noise;
    // A valve with an S beyond the whole OP travel would not have moved.
    let possible = (ACCUSED_FROM..=judged.op_travel).contains(&judged.s.value);
    if judged.t > judged.threshold && explained && possible {
        Behaviour::Sticks
    } else if judged.t <= STICKS && judged.s_limit < CLEARED_BELOW.min(OF_RANGE * judged.op_range) {
        Behaviour::Follows
    } else {
        Behaviour::Open
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bands;
    use crate::closed_loop::NormalStream;
    use crate::valve::{Model, Start, Valve};

    /// An OP that swings by 16 %, unevenly, with a little noise of its controller.
    fn op(n: usize) -> Vec<f64> {
        let mut noise = NormalStream::new(7);
        let wave = |k: f64| 50.0 + 8.0 * (0.041 * k).sin() + 3.0 * (0.0157 * k).sin();
        (0..n).map(|k| wave(k as f64) + 0.1 * noise.draw()).collect()
    }

    /// The position of such a valve, behind or before a lag of `lag` samples, with noise.
    fn seen(model: Model, (s, j): (f64, f64), lag: f64, place: Place, op: &[f64]) -> Vec<f64> {
        let mut valve = model.build(Bands::from_s_j(s, j).unwrap()).unwrap();
        valve.restart(Start::at_rest(op[0]));
        let left = if lag > 0.0 { (-1.0 / lag).exp() } else { 0.0 };
        let (mut held, mut noise) = (op[0], NormalStream::new(3));
        let mut lagged = |x: f64| {
            held = x + left * (held - x);
            held
        };
        let mut position = |u: f64| match place {
            Place::After => lagged(valve.step(u)),
            Place::Before => valve.step(lagged(u)),
        };
        op.iter().map(|u| 2.0 + 0.95 * position(*u) + 0.05 * noise.draw()).collect()
    }

    #[test]
    fn bands_are_found_behind_and_before_any_lag() {
        let op = op(2000);
        let mut missed = vec![];
        for (model, s, j) in
            [(Model::TwoPhase, 4.0, 1.5), (Model::He, 3.0, 2.0), (Model::Play, 1.0, 0.0)]
        {
            for lag in [0.0, 0.7, 4.0, 14.0] {
                for place in [Place::After, Place::Before] {
                    if model == Model::He && place == Place::Before {
                        continue;
                    }
                    let vp = seen(model, (s, j), lag, place, &op);
                    let judged = judge(&op, &vp, Moves::Recorded).unwrap();
                    // Two taps can stand for most of a lag of a sample.
                    let what = format!("{model:?} {lag} {place:?} {judged:?}");
                    assert_eq!(judged.behaviour, Behaviour::Sticks, "{what}");
                    let found = (judged.s.value - s).abs() < 0.06 * s
                        && (judged.s.low <= s && s <= judged.s.high)
                        && (judged.j.low <= j && j <= judged.j.high)
                        && (judged.lag - lag).abs() < 0.15 * lag + 0.8;
                    if !found {
                        missed.push(what);
                    }
                }
            }
        }
        // A stair of He is met only by the right S and J both: the search passes two by.
        assert!(missed.len() <= 2, "{missed:#?}");
    }

    #[test]
    fn a_lag_is_not_taken_for_a_band() {
        let op = op(2000);
        for lag in [0.0, 0.3, 1.0, 3.0, 7.0, 15.0] {
            let vp = seen(Model::Ideal, (0.0, 0.0), lag, Place::After, &op);
            for moves in [Moves::Recorded, Moves::MayBeMissed] {
                let judged = judge(&op, &vp, moves).unwrap();
                assert_eq!(judged.behaviour, Behaviour::Follows, "{lag} {judged:?}");
                assert!(judged.s_limit < 0.5);
            }
        }
    }

    /// In a loop the OP reverses as soon as the stem slips, and a stem that rests at first has another mean than the OP.
    #[test]
    fn jumps_in_a_loop_are_found() {
        let bands = [(4.0, 2.0), (6.0, 3.0), (5.0, 5.0), (3.0, 1.0)];
        for (seed, (s, j)) in bands.into_iter().enumerate() {
            let mut noise = NormalStream::new(seed as u64);
            let mut valve = Model::TwoPhase.build(Bands::from_s_j(s, j).unwrap()).unwrap();
            valve.restart(Start::at_rest(45.0));
            let (mut pv, mut integral, mut op, mut vp) = (0.0, 45.0, vec![], vec![]);
            for _ in 0..2400 {
                let error = -(pv + 0.05 * noise.draw());
                integral += 0.04 * error;
                op.push(((integral + 0.8 * error) * 100.0).round() / 100.0);
                vp.push(valve.step(op[op.len() - 1]));
                pv += 0.3 * (0.8 * (vp[vp.len() - 1] - 45.3) - pv);
            }
            let judged = judge(&op, &vp, Moves::Recorded).unwrap();
            assert_eq!(judged.behaviour, Behaviour::Sticks, "{judged:?}");
            let holds = |of: Interval, truth: f64| of.low <= truth && truth <= of.high;
            assert!(holds(judged.s, s) && holds(judged.j, j), "{s} {j} {judged:?}");
            // With few slips J is known only together with the gain.
            assert!((judged.gain * judged.j.value - j).abs() < 0.15 * j, "{s} {j} {judged:?}");
        }
    }

    #[test]
    fn a_copy_of_the_op_is_no_position() {
        let op = op(1200);
        for delay in 0..3 {
            let copy: Vec<f64> = (0..1200).map(|k| op[k.max(delay) - delay]).collect();
            let Err(Abstention(why)) = judge(&op, &copy, Moves::Recorded) else {
                unreachable!("{delay}")
            };
            assert!(why.contains("copy"), "{why}");
            // With the rounding of a transmitter it may be a valve that follows.
            let rounded: Vec<f64> = copy.iter().map(|x| (20.0 * x).round() / 20.0).collect();
            let judged = judge(&op, &rounded, Moves::Recorded).unwrap();
            assert_eq!(judged.behaviour, Behaviour::Follows, "{delay} {judged:?}");
        }
    }

    #[test]
    fn levels_do_not_matter_and_twice_is_the_same() {
        let op = op(1200);
        let vp = seen(Model::TwoPhase, (3.0, 1.0), 2.0, Place::After, &op);
        let judged = judge(&op, &vp, Moves::Recorded).unwrap();
        assert_eq!(judged, judge(&op, &vp, Moves::Recorded).unwrap());
        let higher = |x: &[f64], by: f64| x.iter().map(|x| x + by).collect::<Vec<f64>>();
        let moved = judge(&higher(&op, 16.0), &higher(&vp, -8.0), Moves::Recorded).unwrap();
        assert!((moved.s.value - judged.s.value).abs() < 1e-6);
        let mirror = |x: &[f64]| x.iter().map(|x| 100.0 - x).collect::<Vec<f64>>();
        let mirrored = judge(&mirror(&op), &mirror(&vp), Moves::Recorded).unwrap();
        assert!((mirrored.s.value - judged.s.value).abs() < 1e-6);
    }

    #[test]
    fn what_cannot_be_judged_is_refused() {
        let op = op(300);
        let refused = |op: &[f64], vp: &[f64]| judge(op, vp, Moves::Recorded).is_err();
        assert!(refused(&op, &op[..299]));
        assert!(refused(&op[..100], &op[..100]));
        assert!(refused(&[50.0; 300], &op));
        assert!(refused(&op, &[f64::NAN; 300]));
        assert!(refused(&op, &[f64::INFINITY; 300]));
        let wild: Vec<f64> = op.iter().map(|u| 1e8 * (u - 50.0)).collect();
        assert!(
            judge(&wild, &op, Moves::Recorded).is_ok_and(|j| j.behaviour != Behaviour::Sticks)
                || refused(&wild, &op)
        );
    }

    /// Of a long record pieces are judged, and the cost is bounded.
    #[test]
    fn a_long_record_is_judged_by_pieces() {
        let op = op(100_000);
        let vp = seen(Model::TwoPhase, (3.0, 1.0), 2.0, Place::After, &op);
        let judged = judge(&op, &vp, Moves::Recorded).unwrap();
        assert_eq!(judged.behaviour, Behaviour::Sticks);
        assert!((judged.s.value - 3.0).abs() < 0.1 && (judged.j.value - 1.0).abs() < 0.2);
    }

    #[test]
    fn a_controller_between_samples_is_noticed() {
        for (acts, expected) in [(1, Moves::Recorded), (2, Moves::MayBeMissed)] {
            let mut stream = NormalStream::new(1);
            let (mut integral, mut filtered) = (50.0, 0.0);
            let (mut op, mut pv) = (vec![], vec![]);
            for k in 0..1000 * acts {
                let error = (0.01 * k as f64).sin() + 0.5 * stream.draw();
                filtered += 0.6 * (error - filtered);
                integral += 0.05 / acts as f64 * filtered;
                if k % acts == 0 {
                    op.push(integral + 1.5 * filtered);
                    pv.push(-((error / 0.01).round() * 0.01));
                }
            }
            assert_eq!(moves(&op, Some(&pv), None), expected, "{acts}");
        }
        assert_eq!(moves(&op(500), None, None), Moves::MayBeMissed);
    }
}
