//! The evidence of a segment, window by window, weighed by the frozen model.
//!
//! A long segment is divided into [`windows`]. What they say together is a [`Pool`], from which the model of [`Valves`]
//! gives probability and S. A single window keeps probability and S of its own model. Without a PV, for which that
//! model is not trained, the log-odds are averaged and S is the median, on a logarithmic scale, of the windows that
//! have one. If the valve began or ceased to stick within the segment, only the windows since then count.

use super::by_evidence::{thresholds, thresholds_of_several};
use super::change::{Event, Seen, events, present_since};
use super::combined_limit::combined_limit;
use super::observation::Observation;
use super::steps::Stops;
#[cfg(feature = "serde")]
use super::verdict::Limit;
use super::window::Window;
use crate::evidence::{Evidence, Line, features, windows};
use crate::finding::Abstention;
use crate::fusion::{self, Cause, Decision, Estimate, Pool, Valves, Weighed, logit, sigmoid};
use crate::parallel::*;
use crate::recording::fitness::levels;
use crate::recording::{Doubt, Segment};
use crate::series::{median, quantile, span};

/// S is a number, and not only a bound, if its interval extends on average at most this share of S to either side.
pub const WIDEST: f64 = 0.35;
/// J is known if its interval is at most this wide, in S.
pub const WIDEST_J: f64 = 0.5;

/// The combined result of the windows of a segment.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Weighing {
    /// The windows, in order of time.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub windows: Vec<Window>,
    /// The evidence of each window.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub evidence: Vec<Evidence>,
    /// Share of each window that does not overlap earlier windows; 0 before the last change.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub shares: Vec<f64>,
    /// The changes of the valve within the segment. The windows before the last time it began or ceased to stick do not count.
    pub changes: Vec<Event>,
    /// The combined evidence of the windows, to which evidence of other recordings can be added; `None` without a PV.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub pool: Option<Pool>,
    /// The probability that the valve is at fault: that it sticks or does not respond.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub probability: f64,
    /// The probability from each line of evidence alone.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "testimony"),
        schemars(with = "Vec<Testimony>")
    )]
    pub lines: Vec<(Line, f64)>,
    /// The probability of every cause. The probabilities add up to one.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub causes: Vec<(Cause, f64)>,
    /// S if the valve sticks, percent of span, with its 90 % interval of any width.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub s: Estimate,
    /// J over S if the valve sticks, with its 90 % interval of any width.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub j_over_s: Estimate,
    /// The detection limit, percent of span: an S above it would have been visible in the windows; `None` if S of any
    /// size could have been missed.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "S_below", serialize_with = "Limit::of_evidence"),
        schemars(with = "Option<Limit>")
    )]
    pub limit: Option<f64>,
    /// Standard errors by which a sticking valve predicts the PV better than one that follows the OP, for all windows
    /// together. This is the sum over the windows divided by the root of their number; 0 if nothing can be predicted.
    pub z: f64,
    /// Range of the OP in the window where it is widest, percent of span.
    pub op_range: f64,
    /// Distance of the windows from the training loops, the median: above 1 they are unlike all of them.
    pub distance: f64,
    /// Whether OP and PV look like signals of one loop, the median over the windows; above 1 they do not.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub mismatch: f64,
    /// The features farthest outside the training loops, in words.
    pub strangest: Vec<String>,
    /// The doubt about the span of the OP. The limit and the amounts of the windows already allow for this.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub doubt: Doubt,
}

/// A line of evidence, in documents.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
#[schemars(rename = "Line")]
struct Testimony {
    /// Name.
    name: Line,
    /// The probability of a fault by this line alone.
    probability: f64,
}

#[cfg(feature = "serde")]
fn testimony<S: serde::Serializer>(lines: &[(Line, f64)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(
        lines
            .iter()
            .map(|(name, probability)| Testimony { name: *name, probability: *probability }),
    )
}

impl Weighing {
    /// Weighs a segment in its [`windows`]. Without a PV, only the shape of the OP counts.
    ///
    /// # Errors
    /// If nothing can be measured in any window, or the frozen model does not fit the evidence.
    pub fn of(segment: &Segment) -> Result<Self, Abstention> {
        Self::of_windows(&windows(segment), &|| false)
    }

    /// Weighs windows of one loop, in order of time.
    ///
    /// # Errors
    /// If nothing can be measured in any window, or the frozen model does not fit the evidence.
    pub(super) fn of_windows(windows: &[Segment], stops: Stops<'_>) -> Result<Self, Abstention> {
        let measure = |part: &Segment| match stops() {
            true => Err(Abstention("the diagnosis was cancelled".to_owned())),
            false => Evidence::of(part),
        };
        // For the first loop, reading the models takes a third of the time of a window.
        let (measured, models) = crate::parallel::join(
            || windows.par_iter().map(measure).collect::<Vec<_>>(),
            || (fusion::shipped(), Valves::shipped()),
        );
        let bundle = models.0.map_err(|error| Abstention(error.to_string()))?;
        let valves = models.1.map_err(|error| Abstention(error.to_string()))?;
        let weigh = |(part, evidence): (&Segment, Result<Evidence, Abstention>)| {
            let evidence = evidence?;
            let says = bundle
                .weigh(&evidence.values, evidence.op_span, part.pv.is_none())
                .map_err(|error| Abstention(error.to_string()))?;
            let window = Window {
                from: part.from,
                duration: part.duration(),
                probability: says.probability,
                s: quantified(says.s),
                j: jump(says.s, says.j_over_s),
                limit: says.limit.map(|limit| limit.max(resolved(part))),
            };
            Ok((window, evidence, says))
        };
        let all: Vec<Result<_, Abstention>> =
            windows.par_iter().zip(measured.into_par_iter()).map(weigh).collect();
        let (mut weighed, mut why) = (vec![], None);
        for each in all {
            match each {
                Ok(each) => weighed.push(each),
                Err(abstention) => why = why.or(Some(abstention)),
            }
        }
        if weighed.is_empty() {
            return Err(why.unwrap_or(Abstention("there is no window to evaluate".to_owned())));
        }
        let mut shares =
            own_shares(weighed.iter().map(|(window, ..)| (window.from, window.duration)));
        let with_pv = windows.iter().all(|part| part.pv.is_some());
        let seen: Vec<Seen> = weighed
            .iter()
            .zip(&shares)
            .map(|((window, evidence, says), share)| {
                let features = &valves.features;
                let pool = Pool::of(says, evidence.op_span, &evidence.values, *share, features);
                let valve = Observation {
                    windows: *share,
                    pool: Some(pool).filter(|_| with_pv),
                    ..window.observation()
                };
                Seen { valve, days: 0.0, moves: [None; 4] }
            })
            .collect();
        let changes = events(&seen, &[]);
        let first = seen.partition_point(|seen| seen.valve.time < present_since(&changes));
        shares[..first].fill(0.0);
        let says: Vec<&Weighed> = weighed[first..].iter().map(|(.., says)| says).collect();
        let average = |of: &dyn Fn(&Weighed) -> f64| match &says[..] {
            [only] => of(only),
            _ => mean_log_odds(says.iter().zip(&shares[first..]).map(|(says, w)| (of(says), *w))),
        };
        let pool = Pool::merged(seen[first..].iter().filter_map(|seen| seen.valve.pool.as_ref()));
        // The model of a window was trained on ten times as many loops: alone it knows more.
        let several = pool.as_ref().filter(|_| says.len() > 1);
        let together = several.map(|pool| valves.weigh(pool));
        let probability =
            together.map_or_else(|| average(&|says| says.probability), |all| all.probability);
        let mut lines: Vec<(Line, f64)> = (0..says[0].lines.len())
            .map(|k| (says[0].lines[k].0, average(&|says| says.lines[k].1)))
            .collect();
        // Valve models without a gain are no evidence for sticking, even if other signs are similar.
        let now = &weighed[first..];
        let gains = now.iter().any(|(_, evidence, _)| evidence.finds_gain());
        let models = lines.iter_mut().filter(|(line, _)| *line == Line::Model && !gains);
        models.for_each(|(_, probability)| *probability = probability.min(0.5));
        // The shares of each window among faults, and among the rest.
        let share = |cause: Cause| {
            let of = |says: &&Weighed| {
                let whole =
                    if cause.is_fault() { says.probability } else { 1.0 - says.probability };
                if whole > 0.0 { says.of(cause) / whole } else { 0.0 }
            };
            let total: f64 = shares.iter().sum();
            let each = says.iter().zip(&shares[first..]).map(|(says, w)| w * of(says));
            let mean = each.sum::<f64>() / total;
            mean * if cause.is_fault() { probability } else { 1.0 - probability }
        };
        let causes = Cause::ALL.map(|cause| (cause, share(cause))).to_vec();
        // If some windows indicate stiction and quantify S, the others are left out.
        let sure = |says: &&&Weighed| says.probability >= 0.5;
        let known = |says: &&&Weighed| quantified(says.s).is_some();
        let both: Vec<&Weighed> =
            says.iter().filter(|says| sure(says) && known(says)).copied().collect();
        let of_known: Vec<&Weighed> = says.iter().filter(known).copied().collect();
        let counted =
            [both, of_known].into_iter().find(|some| !some.is_empty()).unwrap_or(says.clone());
        let of_s = |of: fn(&Estimate) -> f64| {
            quantile(&counted.iter().map(|says| of(&says.s).ln()).collect::<Vec<_>>(), 0.5).exp()
        };
        let of_j = |of: fn(&Estimate) -> f64| {
            median(&counted.iter().map(|says| of(&says.j_over_s)).collect::<Vec<_>>())
        };
        let of_windows =
            || Estimate { value: of_s(|e| e.value), low: of_s(|e| e.low), high: of_s(|e| e.high) };
        let s = together.map_or_else(of_windows, |all| all.s);
        let j_over_s =
            Estimate { value: of_j(|e| e.value), low: of_j(|e| e.low), high: of_j(|e| e.high) };
        let limits: Vec<Option<f64>> =
            weighed[first..].iter().map(|(window, ..)| window.limit).collect();
        let told: Vec<_> = now.iter().filter_map(|(_, e, _)| e.information.as_ref()).collect();
        let z = told.iter().map(|of| of.z()).sum::<f64>() / (told.len().max(1) as f64).sqrt();
        let op_range = told.iter().map(|of| of.op_range).fold(0.0, f64::max);
        let distance = median(&says.iter().map(|says| says.distance).collect::<Vec<_>>());
        let mismatch = median(&says.iter().map(|says| says.mismatch).collect::<Vec<_>>());
        let (windows, evidence): (Vec<Window>, Vec<Evidence>) =
            weighed.into_iter().map(|(window, evidence, _)| (window, evidence)).unzip();
        let mut weighing = Self {
            windows,
            evidence,
            shares,
            changes,
            pool,
            probability,
            lines,
            causes,
            s,
            j_over_s,
            limit: combined_limit(&limits),
            z,
            op_range,
            distance,
            mismatch,
            strangest: vec![],
            doubt: Doubt::default(),
        };
        weighing.strangest = strangest(bundle, weighing.typical());
        Ok(weighing)
    }

    /// The result for an OP whose span is in doubt. Limit and amounts then hold for every plausible span.
    pub(super) fn in_doubt(mut self, doubt: Doubt) -> Self {
        let most = |limit: &mut Option<f64>| *limit = limit.map(|limit| limit * doubt.most);
        most(&mut self.limit);
        for window in &mut self.windows {
            most(&mut window.limit);
            window.s = window.s.map(|s| doubt.widen(s));
            window.j = window.j.map(|j| doubt.widen(j));
        }
        Self { doubt, ..self }
    }

    /// The thresholds of the model that gave the probability.
    pub fn thresholds(&self) -> Decision {
        match self.pool {
            Some(_) if self.present().count() > 1 => thresholds_of_several(),
            _ => thresholds(),
        }
    }

    /// The windows of the present state of the valve, with their evidence.
    pub fn present(&self) -> impl Iterator<Item = (&Window, &Evidence)> {
        let since = present_since(&self.changes);
        self.windows.iter().zip(&self.evidence).filter(move |(window, _)| window.from >= since)
    }

    /// The part of a segment since the valve last began or ceased to stick. It is empty if that happened later, and
    /// `None` if it is the whole segment.
    pub(crate) fn since_change(&self, segment: &Segment) -> Option<Segment> {
        let before = (present_since(&self.changes) - segment.from) / segment.sample_time;
        (before > 0.0).then(|| segment.part(before.round() as usize, segment.len()))
    }

    /// Number of windows, with overlaps counted once.
    pub fn number(&self) -> f64 {
        self.shares.iter().sum()
    }

    /// Duration of the windows, s, with overlaps counted once.
    pub(super) fn covered(&self) -> f64 {
        let each = self.windows.iter().zip(&self.shares);
        each.map(|(window, share)| share * window.duration).sum()
    }

    /// The probability of a cause.
    pub fn likelihood(&self, cause: Cause) -> f64 {
        self.causes.iter().find(|(each, _)| *each == cause).map_or(0.0, |(_, share)| *share)
    }

    /// The most typical window: the one with the weighted median of the probability.
    pub fn typical(&self) -> &Evidence {
        let mut order: Vec<usize> = (0..self.windows.len()).collect();
        order.sort_by(|a, b| self.windows[*a].probability.total_cmp(&self.windows[*b].probability));
        let half = self.shares.iter().sum::<f64>() / 2.0;
        let mut gone = 0.0;
        let middle = order.iter().find(|k| {
            gone += self.shares[**k];
            gone > half
        });
        &self.evidence[*middle.unwrap_or(&0)]
    }
}

/// The smallest S that a coarse PV can show, percent of span. A slip must move the PV by two of its steps. With the
/// ratio of the ranges of PV and OP as gain, these are twice the range of the OP over the number of steps.
fn resolved(part: &Segment) -> f64 {
    let levels = part.pv.as_deref().and_then(levels);
    levels.map_or(0.0, |levels| 2.0 * span(&part.op) / (levels - 1.0))
}

/// The probability of the mean of [`log_odds`], of `(probability, weight)`; a half if all weights are zero.
pub(super) fn mean_log_odds(each: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (probability, weight) in each {
        sum += weight * log_odds(probability);
        total += weight;
    }
    if total > 0.0 { sigmoid(sum / total) } else { 0.5 }
}

/// The highest probability that one of several windows may have; ours.
const SUREST: f64 = 0.99;

/// Log-odds, limited to the log-odds of [`SUREST`].
pub(super) fn log_odds(probability: f64) -> f64 {
    logit(probability.clamp(1.0 - SUREST, SUREST))
}

/// Largest number of features to list of a recording that is unlike the training loops.
const NAMED: usize = 3;

/// The features farthest outside the training loops.
fn strangest(bundle: &fusion::Bundle, evidence: &Evidence) -> Vec<String> {
    let Some(reference) = &bundle.full.reference else { return vec![] };
    let meaning = |feature: usize| features().nth(feature).map_or("", |feature| feature.meaning);
    let words = |unlike: fusion::Unlike| {
        let fusion::Unlike { feature, value, range: (low, high), .. } = unlike;
        let meaning = meaning(feature);
        format!("{meaning} = {value:.2}, but {low:.2} to {high:.2} for 99 % of the training loops")
    };
    reference.unlike(&evidence.values).into_iter().take(NAMED).map(words).collect()
}

/// The share of each of the spans `(from, duration)`, in order of time, that overlaps no earlier span.
pub fn own_shares(spans: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
    let mut end = f64::NEG_INFINITY;
    let share = |(from, duration): (f64, f64)| {
        let until = from + duration;
        let own = (until - from.max(end)).clamp(0.0, duration);
        end = end.max(until);
        if duration > 0.0 { own / duration } else { 1.0 }
    };
    spans.map(share).collect()
}

/// An S that is a number.
pub(super) fn quantified(s: Estimate) -> Option<Estimate> {
    (s.high - s.low <= 2.0 * WIDEST * s.value).then_some(s)
}

/// A J that is a number, percent of span.
pub(super) fn jump(s: Estimate, j_over_s: Estimate) -> Option<Estimate> {
    quantified(s)?;
    let known = j_over_s.high - j_over_s.low <= WIDEST_J;
    known.then_some(Estimate {
        value: j_over_s.value * s.value,
        low: j_over_s.low * s.low,
        high: j_over_s.high * s.high,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Grid, GridOptions, Recording};

    #[test]
    fn windows_that_overlap_are_fewer() {
        let of = |from: &[f64]| own_shares(from.iter().map(|from| (*from, 100.0)));
        assert_eq!(of(&[0.0, 100.0, 200.0]), [1.0; 3]);
        assert_eq!(of(&[0.0, 50.0]), [1.0, 0.5]);
        // Gaps make no more of them, and hide no overlap.
        assert_eq!(of(&[0.0, 1_000.0, 1_050.0, 1_060.0]), [1.0, 1.0, 0.5, 0.1]);
        assert_eq!(of(&[0.0, 0.0]), [1.0, 0.0]);
        assert_eq!(of(&[]), [0.0; 0]);
    }

    #[test]
    fn a_coarse_pv_hides_what_moves_it_by_less_than_two_of_its_steps() {
        let op: Vec<f64> = (0..400).map(|k| 50.0 + (f64::from(k) * 0.1).sin()).collect();
        let of = |step: f64| {
            let pv: Vec<f64> = op.iter().map(|v| step * (3.0 * v / step).round()).collect();
            let recording = Recording::regular("", 1.0, &op, Some(&pv), None).unwrap();
            let grid = Grid::of(&recording, &GridOptions::default()).unwrap();
            resolved(grid.longest().unwrap())
        };
        // Three, 13 and hundreds of levels.
        assert!((of(3.0) - 2.0).abs() < 0.01 && (of(0.5) - 1.0 / 3.0).abs() < 0.01);
        assert!(of(0.01) < 0.1);
    }

    #[test]
    fn only_narrow_intervals_are_numbers() {
        let of = |low, high| Estimate { value: 4.0, low, high };
        assert!(quantified(of(3.0, 5.7)).is_some() && quantified(of(3.0, 5.9)).is_none());
        let j_over_s = Estimate { value: 0.5, low: 0.3, high: 0.7 };
        let j = jump(of(3.5, 4.5), j_over_s).unwrap();
        assert!((j.value - 2.0).abs() < 1e-12 && (j.low - 1.05).abs() < 1e-12);
        assert_eq!(jump(of(1.0, 9.0), j_over_s), None);
        assert_eq!(jump(of(3.5, 4.5), Estimate { low: 0.1, ..j_over_s }), None);
    }
}
