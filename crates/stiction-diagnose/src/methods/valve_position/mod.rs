//! Stiction measured on the valve itself, where its position is recorded.
//!
//! # What it measures
//! From OP and measured valve position (VP): dead band, S, J, offset, travel and reversals. With the position known,
//! nothing has to be inferred. As a detector it judges all other detectors. A [fit](crate::identify::lagged_position)
//! that allows for lags and noise gives its decision, and S and J of a diagnosis. Measurements of rests and slips are
//! reported beside it.
//!
//! # Assumptions
//! OP and VP are percent of the same span and sampled at the same times, densely enough to distinguish the stem's
//! motion from noise.
//!
//! # Equations
//! The stem *rests* while VP stays within a tolerance of its level and the OP travels by more than three
//! tolerances; the tolerance is four standard deviations of the noise, at least a quantum. With
//! `e = OP - VP`:
//! ```text
//! dead band = median e of a rising stem - median e of a falling one = 2 fd,  where motion ends
//!             in a rest, or, if there are few rests, while the stem moves; then less T times the rate
//!             of the OP, with the lag T that fits best
//! S = travel of the OP from the beginning of a rest to the slip that ends it, where the stem goes
//!     back (definition of S = fs + fd)
//! J = S - dead band for each of these; where the stem goes on in the same direction, the travel itself
//! offset = mean of the two medians of e
//! ```
//! A slip occurs between two samples: the OP half-way between them counts, but at least its previous extreme.
//! Medians, with quartiles and counts.
//!
//! # Parameters
//! None.
//!
//! # Limits
//! The error of a single S is half of the OP movement in a sample, plus half a quantum of VP. An S below three
//! tolerances shows no rest; then S is the dead band. A stem that moves up and down within a few samples cannot be
//! distinguished from noise, and is not judged. A lag of the stem makes rests begin late and S small. Different
//! spans of OP and VP look like S.
//!
//! # Deviations from the paper
//! None; everything is ours. ISA-75.25.01 uses "dead band" for our S, and "resolution" for our J (recalled, not
//! read).
//!
//! # References
//! None.

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::stuck::{StuckSpan, find_rests};
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::identify::lagged_position::{
    ACCUSED_FROM, Behaviour, CLEARED_BELOW, HEALTHY_UP_TO, Judgement,
};
use crate::series::{median, quantile};
use nalgebra::{Matrix3, Vector3};

/// Smallest number of rests in each direction for the dead band. Ours.
const LEAST_RESTS: usize = 3;

/// The measurement on the valve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ValvePosition {}

/// A quantity measured on several events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Lower quartile of the events.
    pub lower_quartile: f64,
    /// Upper quartile of the events.
    pub upper_quartile: f64,
    /// Number of events.
    pub count: usize,
}

impl Spread {
    /// Statistics of these events; `None` without events.
    fn of(events: &[f64]) -> Option<Self> {
        (!events.is_empty()).then(|| Self {
            median: median(events),
            lower_quartile: quantile(events, 0.25),
            upper_quartile: quantile(events, 0.75),
            count: events.len(),
        })
    }
}

/// A measurement on a valve, or why it is missing.
pub type Measured = Result<Spread, Abstention>;

/// A rest with the motion before and after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// Time and position of the rest.
    pub span: StuckSpan,
    /// OP when the stem came to rest; `None` if the recording begins at rest.
    pub op_stop: Option<f64>,
    /// OP when it slipped; `None` if the recording ends at rest.
    pub op_slip: Option<f64>,
    /// Whether the motion before was upwards.
    pub came_up: bool,
    /// Whether the motion after was upwards.
    pub went_up: bool,
}

impl Rest {
    /// OP travel from stop to slip, percent.
    pub fn travel(&self) -> Option<f64> {
        let travel = self.op_slip? - self.op_stop?;
        Some(if self.went_up { travel } else { -travel })
    }

    /// Whether the stem reversed.
    pub fn reverses(&self) -> bool {
        self.came_up != self.went_up
    }
}

/// A valve measured by its recorded position.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredValve {
    /// Stick band plus dead band S, percent.
    pub s: Measured,
    /// Slip jump J, percent.
    pub j: Measured,
    /// Dead band `2 fd = S - J`, percent. Its quartiles are the quartiles of `e` while rising less those while falling.
    pub dead_band: Measured,
    /// OP less VP, midway between rising and falling, percent.
    pub offset: Measured,
    /// Smallest change of VP above noise and quantum, percent.
    pub resolution: f64,
    /// Standard deviation of the noise on VP, percent.
    pub noise: f64,
    /// Common divisor of all steps of VP, percent; 0 for none up to 1 %.
    pub quantum: f64,
    /// Travel of the stem, percent of span per hour.
    pub travel_per_hour: f64,
    /// Reversals per hour.
    pub reversals_per_hour: f64,
    /// Share of the time in which it rests while the OP travels.
    pub stuck_share: f64,
    /// The rests.
    pub rests: Vec<Rest>,
    /// The result of the fit, or why there is none.
    pub judgement: Result<Judgement, Abstention>,
    /// Decision of the fit; undecided without a certain result.
    pub decision: Decision,
    /// Cautions.
    pub caveats: Vec<String>,
}

/// The turning points of `x`: reversals by more than `threshold`, with the first and last sample.
fn turning_points(x: &[f64], threshold: f64) -> Vec<usize> {
    let mut turns = vec![0];
    let (mut low, mut high) = (0, 0);
    let mut rising: Option<bool> = None;
    for (k, &v) in x.iter().enumerate() {
        if v > x[high] {
            high = k;
        }
        if v < x[low] {
            low = k;
        }
        if rising != Some(true) && v - x[low] > threshold {
            if rising.is_some() {
                turns.push(low);
            }
            (rising, high) = (Some(true), k);
        } else if rising != Some(false) && x[high] - v > threshold {
            if rising.is_some() {
                turns.push(high);
            }
            (rising, low) = (Some(false), k);
        }
    }
    match rising {
        Some(true) => turns.push(high),
        Some(false) => turns.push(low),
        None => {}
    }
    turns
}

/// Finds how a span begins and ends.
fn rest(span: &StuckSpan, u: &[f64], x: &[f64], tolerance: f64) -> Rest {
    let StuckSpan { first, end, level } = *span;
    let rounding = 1e-9 * level.abs().max(tolerance);
    let came_up = first > 0 && x[first - 1] < level;
    let went_up = end < x.len() && x[end] > level;
    let sign = |up: bool| if up { 1.0 } else { -1.0 };
    let op_stop = (first > 0).then(|| {
        let mut at = first;
        if (x[first - 1] - level).abs() <= 2.0 * tolerance {
            // It creeps in: the rest begins when it first reaches the level.
            let way = sign(came_up);
            at = (first..end).find(|&i| way * (x[i] - level) >= -rounding).unwrap_or(first);
        }
        u[at]
    });
    let op_slip = (end < x.len()).then(|| {
        let way = sign(went_up);
        let mut last = end - 1;
        if (x[end] - level).abs() <= 2.0 * tolerance {
            // It creeps out: the rest ends when it last was on the other side of the level.
            last = (first..end).rfind(|&i| way * (x[i] - level) <= rounding).unwrap_or(end - 1);
        }
        let before = u[first..=last].iter().map(|u| way * u).fold(f64::NEG_INFINITY, f64::max);
        way * (0.5 * (way * (u[last] + u[last + 1]))).max(before)
    });
    Rest { span: *span, op_stop, op_slip, came_up, went_up }
}

impl ValvePosition {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "direct",
        title: "Direct measurement on the valve position",
        source: "ours",
        statistic: "t of the best valve without stiction",
        rule: "sticks if every valve with S up to 0.3 %, behind any lag, fits worse than the best by a threshold. \
               The threshold is 2.5 standard deviations, 5 if S is small beside the OP's changes, 2 if S is large and likely",
        applies: Applies::AnyLoop,
        decides: Decides::Stiction,
        needs: Needs::OpAndVp,
        family: Family::Measured,
        explains_oscillation: false,
    };

    /// Measures the valve.
    ///
    /// # Errors
    /// If no valve position is recorded, or the OP never moves.
    pub fn run(&self, subject: &Subject<'_>) -> Result<MeasuredValve, Abstention> {
        let caveats = subject.check(&Self::METHOD)?;
        let (u, x) = (&subject.segment.op, subject.segment.vp.as_deref().unwrap_or_default());
        if u.len() != x.len() || !u.iter().chain(x).all(|v| v.abs() < 1e100) {
            return Err(Abstention(
                "the valve position does not have one number per sample".to_owned(),
            ));
        }
        let found = find_rests(u, x, 0.0);
        let tolerance = found.tolerance;
        let rests: Vec<Rest> = found.spans.iter().map(|span| rest(span, u, x, tolerance)).collect();

        let turns = turning_points(x, 2.0 * tolerance);
        let legs: Vec<(usize, usize)> = turns.windows(2).map(|pair| (pair[0], pair[1])).collect();
        let travel = legs.iter().fold(0.0, |sum, (from, to)| sum + (x[*to] - x[*from]).abs());
        let hours = subject.segment.duration() / 3600.0;

        let (up, down) = distances(u, x, &rests, &legs);
        let few = |what: &str| {
            Abstention(format!(
                "the stem does not move in both directions by more than {:.3} % (the noise), so its {what} is not \
                 known",
                2.0 * tolerance
            ))
        };
        let both = Spread::of(&up).zip(Spread::of(&down));
        let count = up.len().min(down.len());
        let dead_band = both.ok_or_else(|| few("dead band")).map(|(up, down)| Spread {
            median: up.median - down.median,
            lower_quartile: up.lower_quartile - down.upper_quartile,
            upper_quartile: up.upper_quartile - down.lower_quartile,
            count,
        });
        let offset = both.ok_or_else(|| few("offset")).map(|(up, down)| Spread {
            median: 0.5 * (up.median + down.median),
            lower_quartile: 0.5 * (up.lower_quartile + down.lower_quartile),
            upper_quartile: 0.5 * (up.upper_quartile + down.upper_quartile),
            count,
        });

        let travels = |reverses: bool| -> Vec<f64> {
            let rests = rests.iter().filter(|rest| rest.reverses() == reverses);
            rests.filter_map(Rest::travel).filter(|travel| *travel >= 0.0).collect()
        };
        let (back, onward) = (travels(true), travels(false));
        // If the stem reverses without a visible rest, the dead band is the only measurement.
        let s = match (Spread::of(&back), &dead_band) {
            (Some(s), _) => Ok(s),
            (None, Ok(band)) => Ok(Spread { median: band.median.max(0.0), ..*band }),
            (None, Err(why)) => Err(why.clone()),
        };
        let mut jumps = onward;
        if let Ok(band) = &dead_band {
            jumps.extend(back.iter().map(|s| (s - band.median).max(0.0)));
        }
        let j = Spread::of(&jumps).ok_or_else(|| {
            Abstention(format!(
                "no rest was detected, so a slip jump must be below {:.3} %",
                3.0 * tolerance
            ))
        });

        let judgement = subject.position().cloned();
        let decision = match judgement.as_ref().map(|judged| judged.behaviour) {
            Ok(Behaviour::Sticks | Behaviour::DoesNotMove) => Decision::Sticks,
            Ok(Behaviour::Follows) => Decision::DoesNotStick,
            Ok(Behaviour::Open) | Err(_) => Decision::Undecided,
        };
        let stuck: usize = rests.iter().map(|rest| rest.span.end - rest.span.first).sum();
        Ok(MeasuredValve {
            s,
            j,
            dead_band,
            offset,
            resolution: 2.0 * tolerance,
            noise: found.noise,
            quantum: found.quantum,
            travel_per_hour: travel / hours,
            reversals_per_hour: legs.len().saturating_sub(1) as f64 / hours,
            stuck_share: stuck as f64 / x.len() as f64,
            rests,
            judgement,
            decision,
            caveats,
        })
    }
}

/// OP less VP of a rising stem and of a falling one: at the start of rests or, if these are few, during motion,
/// less the effect of a lag of the stem.
fn distances(
    u: &[f64],
    x: &[f64],
    rests: &[Rest],
    legs: &[(usize, usize)],
) -> (Vec<f64>, Vec<f64>) {
    let at_stops = |up: bool| -> Vec<f64> {
        let stops = rests.iter().filter(|rest| rest.came_up == up);
        stops.filter_map(|rest| Some(rest.op_stop? - rest.span.level)).collect()
    };
    let (up, down) = (at_stops(true), at_stops(false));
    if up.len().min(down.len()) >= LEAST_RESTS {
        return (up, down);
    }
    let mut resting = vec![false; x.len()];
    for rest in rests {
        // The first sample at rest is the last of the motion before.
        resting[rest.span.first..rest.span.end].fill(true);
        resting[rest.span.first] = rest.span.first == 0;
    }
    let last = x.len().saturating_sub(1);
    let moving: Vec<(bool, f64, f64)> = legs
        .iter()
        .flat_map(|&(from, to)| (from + 1..=to).map(move |k| (x[to] > x[from], k)))
        .filter(|&(_, k)| !resting[k] && k < last)
        .map(|(up, k)| (up, u[k] - x[k], 0.5 * (u[k + 1] - u[k - 1])))
        .collect();
    let lag = lag(&moving);
    let side = |wanted: bool| -> Vec<f64> {
        let side = moving.iter().filter(|(up, ..)| *up == wanted);
        side.map(|(_, distance, rate)| distance - lag * rate).collect()
    };
    (side(true), side(false))
}

/// Samples by which a moving stem follows the OP: the lag `T` of `e = offset + fd direction + T rate`, by least squares
/// over direction, distance and rate of moving samples; 0 without a lag.
fn lag(moving: &[(bool, f64, f64)]) -> f64 {
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for &(up, distance, rate) in moving {
        let row = Vector3::new(1.0, if up { 1.0 } else { -1.0 }, rate);
        normal += row * row.transpose();
        right += row * distance;
    }
    let solution = normal.cholesky().map(|factor| factor.solve(&right));
    solution.map_or(0.0, |found| found[2]).max(0.0)
}

impl Detector for ValvePosition {
    fn method(&self) -> &'static Method {
        &Self::METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![
            Number::new("healthy up to", HEALTHY_UP_TO, "%"),
            Number::new("accused from", ACCUSED_FROM, "%"),
            Number::new("cleared below", CLEARED_BELOW, "%"),
        ]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let judged = match &r.judgement {
            Ok(judged) => judged,
            Err(why) => {
                let finding = Finding::abstains(&Self::METHOD, why.clone());
                return Ok(Finding { looked_at: Some(LookedAt::new(r)), ..finding });
            }
        };
        let reason = judged.sentence(subject.segment.sample_time);
        let mut numbers = vec![];
        if judged.behaviour == Behaviour::Sticks {
            numbers.extend([
                Number::new("S", judged.s.value, "%"),
                Number::new("J", judged.j.value, "%"),
            ]);
        }
        if judged.s_limit.is_finite() {
            numbers.push(Number::new("S below", judged.s_limit, "%"));
        }
        numbers.push(Number::new("lag", judged.lag * subject.segment.sample_time, "s"));
        for (name, measured) in [("dead band", &r.dead_band), ("offset", &r.offset)] {
            if let Ok(spread) = measured {
                numbers.push(Number::new(name, spread.median, "%"));
            }
        }
        numbers.extend([
            Number::new("resolution", r.resolution, "%"),
            Number::new("travel", r.travel_per_hour, "%/h"),
            Number::new("reversals", r.reversals_per_hour, "1/h"),
            Number::new("stuck share", r.stuck_share, ""),
        ]);
        let finding =
            Finding::new(&Self::METHOD, r.decision, judged.t, judged.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
