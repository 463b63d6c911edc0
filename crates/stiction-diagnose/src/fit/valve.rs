//! The possible valves, and how well the PV follows from each.

use crate::bands::Bands;
use crate::diagnose::{Diagnosis, Weighing};
use crate::fusion::Estimate;
use crate::identify::process::{Candidate, FittedProcess, TEMPER};
use crate::recording::Segment;
use crate::valve::{Model, Start, Valve};

/// S at multiples of this, in standard deviations of its logarithm, up to two of them. A stem with an S too large by one
/// percent may miss a slip, and then many, so a coarse grid compares values of J at random.
const PLACE: f64 = 0.1;
/// Divisor of log-likelihoods of valves: one missed slip costs a valve tens of nats.
const BETWEEN: f64 = 100.0;
/// J over S.
const JUMPS: [f64; 6] = [0.02, 0.2, 0.4, 0.6, 0.8, 1.0];
/// The smallest standard deviation of the logarithm of S, and of J over S, before the PV is used.
const LEAST_OF_S: f64 = 0.1;
const LEAST_SPREAD: f64 = 0.2;
/// Initial positions of a stem, stick bands from the OP.
const STARTS: [f64; 5] = [0.0, -0.45, 0.45, -0.9, 0.9];
/// The smallest weight of a valve that follows, and of one that does not, before the PV is used.
const LEAST_WEIGHT: f64 = 0.03;
/// Number of processes to try with each valve.
const TRIED: usize = 10;

/// A valve identified from a recording.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct FittedValve {
    /// Valve model; `None` if all possible valves follow the OP.
    pub model: Option<String>,
    /// Stick band plus dead band if the valve sticks, percent of span.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Estimate,
    /// Slip jump if the valve sticks, percent of span.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Estimate,
    /// Weight of the valves that follow the OP among all possible valves, from 0 to 1.
    pub follows: f64,
    /// Source of S and J.
    pub from: &'static str,
}

/// A possible valve.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Possible {
    pub model: Model,
    pub bands: Bands,
    /// Its weight, before the PV is used.
    pub weight: f64,
    /// Position, at every sample.
    pub path: Vec<f64>,
    /// Standard deviations of S and J within its cell of the grid.
    pub cell: (f64, f64),
    /// Whether the process is identified behind it.
    pub first: bool,
    pub from: &'static str,
}

/// A valve before a process, and the weight of the two together; all weights add up to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weighed {
    pub model: Model,
    pub bands: Bands,
    pub process: Candidate,
    pub weight: f64,
    pub cell: (f64, f64),
    pub from: &'static str,
}

/// The path of a valve that follows this OP. Its initial position is not recorded, and a stem with a wrong one may
/// never slip. So the result is the path with the most slips among several initial positions.
pub(super) fn path(model: Model, bands: Bands, op: &[f64]) -> Option<Vec<f64>> {
    let first = op.first().copied()?;
    let mut best: Option<(usize, Vec<f64>)> = None;
    let places = if model == Model::Ideal { &STARTS[..1] } else { &STARTS };
    for place in places {
        let mut valve = model.build(bands).ok()?;
        valve.restart(Start { op: first, ..Start::at_rest(first + place * bands.fs()) });
        let path: Vec<f64> = op.iter().map(|u| valve.step(*u)).collect();
        let slips = path.windows(3).filter(|w| w[0] == w[1] && w[1] != w[2]).count();
        if best.as_ref().is_none_or(|(most, _)| slips > *most) {
            best = Some((slips, path));
        }
    }
    best.map(|(_, path)| path)
}

/// All valves that the evidence allows.
pub(super) fn possible(diagnosis: &Diagnosis, segment: &Segment) -> Result<Vec<Possible>, String> {
    let op = &segment.op;
    let ideal = Bands::NONE;
    if let (Some(vp), Some(s)) = (&segment.vp, diagnosis.stiction.s) {
        let j = diagnosis.stiction.j.map_or(0.5 * s.value, |j| j.value);
        let bands = Bands::from_s_j(s.value, j.min(s.value)).map_err(|e| e.to_string())?;
        let path = vp.clone();
        let from = "the measured position";
        let (model, weight, first) = (Model::TwoPhase, 1.0, true);
        let sd = |of: Option<Estimate>| of.map_or(0.2 * s.value, |e| (e.high - e.low) / 3.29);
        let cell = (sd(Some(s)), sd(diagnosis.stiction.j));
        return Ok(vec![Possible { model, bands, weight, path, cell, first, from }]);
    }
    let weighing =
        diagnosis.evidence.as_ref().ok_or("S and J are unknown without evidence in OP and PV")?;
    let model = model_of(weighing);
    let (s, share) = (weighing.s, weighing.j_over_s);
    let mut all = vec![];
    let follows = path(Model::Ideal, ideal, op).unwrap_or_else(|| op.clone());
    let (from, first) = ("the evidence in OP and PV", true);
    // Weights start from the verdict.
    let fault = weighing.probability.clamp(LEAST_WEIGHT, 1.0 - LEAST_WEIGHT);
    all.push(Possible {
        model: Model::Ideal,
        bands: ideal,
        weight: 1.0 - fault,
        path: follows,
        cell: (0.0, 0.0),
        first,
        from,
    });
    let spread = ((s.high / s.low).ln() / (2.0 * 1.645)).clamp(LEAST_OF_S, 1.0);
    let places = (-20..=20).map(|k| PLACE * f64::from(k));
    let bell = |z: f64| (-0.5 * z * z).exp();
    let of_share = ((share.high - share.low) / (2.0 * 1.645)).max(LEAST_SPREAD);
    let of_jump = JUMPS.map(|jump| bell((jump - share.value) / of_share));
    let total = places.clone().map(bell).sum::<f64>() * of_jump.iter().sum::<f64>();
    for z in places {
        let width = s.value * (spread * z).exp();
        for (over, of_jump) in JUMPS.into_iter().zip(of_jump) {
            let Ok(bands) = Bands::from_s_j(width, over * width) else { continue };
            let Some(path) = path(model, bands, op) else { continue };
            let weight = fault * bell(z) * of_jump / total;
            // Half of the distance to its neighbours; S is never known better than to 4 %.
            let cell = ((0.5 * PLACE * spread).max(0.04) * width, 0.1 * width);
            all.push(Possible { model, bands, weight, path, cell, first: false, from });
        }
    }
    // Those that explained the PV best when the evidence was gathered.
    for (model, s, j) in found_best(weighing) {
        let Ok(bands) = Bands::from_s_j(s, j.min(s)) else { continue };
        let Some(path) = path(model, bands, op) else { continue };
        let weight = fault * bell(2.0) / total;
        let cell = (0.05 * s, 0.1 * s);
        all.push(Possible { model, bands, weight, path, cell, first: true, from });
    }
    // Of the paths that move at all, the one nearest to the middle.
    let moves =
        |one: &&mut Possible| one.model != Model::Ideal && crate::series::span(&one.path) > 0.0;
    let jump = 0.5 * (share.low + share.high.min(1.0));
    let apart = |one: &Possible| {
        let of_j = one.bands.j() / one.bands.s().max(f64::MIN_POSITIVE) - jump;
        (one.bands.s() / s.value).ln().abs() + 0.1 * of_j.abs()
    };
    if let Some(one) = all.iter_mut().filter(moves).min_by(|a, b| apart(a).total_cmp(&apart(b))) {
        one.first = true;
    }
    Ok(all)
}

/// Model, S and J, percent, of the valves that explain the PV best, one for each kind of fit.
fn found_best(weighing: &Weighing) -> Vec<(Model, f64, f64)> {
    let evidence = weighing.typical();
    let fits = [&evidence.model, &evidence.dense].into_iter().flatten().map(|fits| {
        let (best, s) = (fits.best(), fits.best().s_over_span * evidence.op_span);
        (best.model, s, best.j_over_s * s)
    });
    let told = evidence.information.iter().map(|told| {
        let (model, s, j, _) = told.best;
        (model, s * told.op_range, j * s * told.op_range)
    });
    let mut all: Vec<(Model, f64, f64)> = fits.chain(told).filter(|(_, s, _)| *s > 0.0).collect();
    all.dedup();
    all
}

/// The model that explains the PV best, among those tried by the evidence.
fn model_of(weighing: &Weighing) -> Model {
    let evidence = weighing.typical();
    let fits = evidence.dense.as_ref().or(evidence.model.as_ref());
    fits.map_or(Model::TwoPhase, |fits| fits.best().model)
}

/// Every valve before every process, by how well the PV follows. Valves that stick are compared among themselves less
/// sharply, with the same total weight.
pub(super) fn weighed(
    valves: &[Possible],
    process: &FittedProcess,
    pv: &[f64],
    step: f64,
) -> Vec<Weighed> {
    let mut all: Vec<(Weighed, f64, f64)> = vec![];
    let Some(explaining) = process.explaining(pv, step, TRIED) else { return vec![] };
    let mut tops = [f64::NEG_INFINITY; 2];
    for valve in valves {
        let mut behind = explaining.behind(&valve.path);
        behind.retain(|(process, l)| process.gain != 0.0 && l.is_finite());
        let best = behind.iter().map(|(_, l)| *l).fold(f64::NEG_INFINITY, f64::max);
        let top = &mut tops[usize::from(valve.model == Model::Ideal)];
        *top = top.max(best);
        let Possible { model, bands, weight, cell, from, .. } = *valve;
        let one = |(process, l)| (Weighed { model, bands, process, weight, cell, from }, best, l);
        all.extend(behind.into_iter().map(one));
    }
    let top = tops[0].max(tops[1]);
    let sticks = |of: &Weighed| of.model != Model::Ideal;
    let weigh = |of: &Weighed, nats: f64| of.weight * nats.exp();
    let exact = |(of, _, l): &(Weighed, f64, f64)| weigh(of, (l - top) / TEMPER);
    let loose = |(of, best, l): &(Weighed, f64, f64)| {
        weigh(of, (l - best) / TEMPER + (best - tops[0]) / BETWEEN)
    };
    let stuck = || all.iter().filter(|(of, ..)| sticks(of));
    let share = stuck().map(exact).sum::<f64>() / stuck().map(loose).sum::<f64>();
    let mut all: Vec<Weighed> = all
        .iter()
        .map(|one| {
            let weight = if sticks(&one.0) { share * loose(one) } else { exact(one) };
            Weighed { weight, ..one.0 }
        })
        .filter(|one| one.weight > 1e-9)
        .collect();
    let total: f64 = all.iter().map(|one| one.weight).sum();
    all.iter_mut().for_each(|one| one.weight /= total);
    all
}

/// The valve with the largest weight.
pub(super) fn likeliest<'a>(all: &[Weighed], valves: &'a [Possible]) -> Option<&'a Possible> {
    let best = all.iter().max_by(|a, b| a.weight.total_cmp(&b.weight))?;
    valves.iter().find(|one| one.model == best.model && one.bands == best.bands)
}

/// The weighted valves, as numbers with intervals.
pub(super) fn summarised(all: &[Weighed]) -> FittedValve {
    let sticks: Vec<&Weighed> = all.iter().filter(|one| one.model != Model::Ideal).collect();
    let ideal = all.iter().filter(|one| one.model == Model::Ideal).map(|one| one.weight);
    // An empty sum is -0.
    let follows = 0.0 + ideal.sum::<f64>();
    // Every value of the grid represents its cell: a normal distribution, in three points.
    let of = |what: fn(&Weighed) -> (f64, f64)| {
        let around = |one: &&Weighed| {
            let (value, cell) = what(one);
            [(-1.0, 0.3), (0.0, 0.4), (1.0, 0.3)]
                .map(|(z, share)| (value + z * cell, share * one.weight))
        };
        let mut values: Vec<(f64, f64)> = sticks.iter().flat_map(around).collect();
        let all = quantiles(&mut values);
        // No valve moves by more than its span.
        let sound = |value: f64| value.clamp(0.0, 100.0);
        Estimate { value: sound(all.value), low: sound(all.low), high: sound(all.high) }
    };
    let likeliest = sticks.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
    FittedValve {
        model: likeliest.map(|one| one.model.describe().name.to_owned()),
        s: of(|one| (one.bands.s(), one.cell.0)),
        j: of(|one| (one.bands.j(), one.cell.1)),
        follows,
        from: all.first().map_or("nothing", |one| one.from),
    }
}

/// S and J from the evidence alone, without a process that weighs them.
pub(super) fn alone(diagnosis: &Diagnosis) -> Result<FittedValve, String> {
    let weighing = diagnosis.evidence.as_ref().ok_or("OP and PV do not show S and J")?;
    let (s, share) = (weighing.s, weighing.j_over_s);
    let j = |of: f64, s: f64| of.clamp(0.0, 1.0) * s;
    Ok(FittedValve {
        model: Some(model_of(weighing).describe().name.to_owned()),
        s,
        j: Estimate {
            value: j(share.value, s.value),
            low: j(share.low, s.low),
            high: j(share.high, s.high),
        },
        follows: 1.0 - weighing.probability,
        from: "the evidence in OP and PV",
    })
}

/// Median and the 5 and 95 % points of weighted values, each spread to the middles between it and its neighbours.
pub(super) fn quantiles(values: &mut [(f64, f64)]) -> Estimate {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = values.iter().map(|(_, w)| w).sum();
    if !(total > 0.0) {
        return Estimate { value: 0.0, low: 0.0, high: 0.0 };
    }
    // Every value represents its weight, half of it before and half of it after.
    let mut sum = 0.0;
    let places: Vec<(f64, f64)> = values
        .iter()
        .map(|(v, w)| {
            let at = (sum + 0.5 * w) / total;
            sum += w;
            (at, *v)
        })
        .collect();
    let at = |p: f64| {
        let after = places.iter().position(|(at, _)| *at >= p).unwrap_or(places.len() - 1);
        let (b, v) = places[after];
        match after.checked_sub(1).map(|i| places[i]) {
            Some((a, u)) if b > a && b >= p => u + (v - u) * (p - a) / (b - a),
            _ => v,
        }
    };
    Estimate { value: at(0.5), low: at(0.05), high: at(0.95) }
}
