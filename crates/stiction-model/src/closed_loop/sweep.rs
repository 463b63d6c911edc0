//! Many closed loops at once.

use super::bank::{Each, Feeds, LoopBank, Recorder, Sample, ValveBank, play, play_one, with_order};
use super::cycle::Crossings;
use super::description::{ClosedLoop, Prepared};
use crate::bands::Bands;
use crate::error::{Error, Result};
use crate::parallel::*;
use crate::simd::{LANES, Lane, Width};
use crate::valve::lanes::{HeLanes, LaneValve, TwoPhaseLanes};
use crate::valve::{AnyModel, Assembly, Start, Valve};

/// The statistics of a loop over the last half of its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Mean time between upward crossings of the set point by the PV, s; `None` if there are fewer
    /// than three. In a cycle it is the period.
    pub period_s: Option<f64>,
    /// Half the peak-to-peak value of the controller output, percent.
    pub op_half_pp: f64,
    /// Half the peak-to-peak value of the valve position, percent.
    pub vp_half_pp: f64,
    /// Half the peak-to-peak value of the PV.
    pub pv_half_pp: f64,
    /// Mean control error, `sp - pv`.
    pub error_mean: f64,
    /// Root mean square of the control error.
    pub error_rms: f64,
    /// Mean absolute control error: IAE per second.
    pub error_abs: f64,
    /// Valve travel, percent per second.
    pub travel_per_s: f64,
}

/// Gathers the statistics of `N` loops.
struct Gather<const N: usize> {
    /// Samples before this one do not count.
    from: usize,
    crossings: Crossings<N>,
    op: [Lane<N>; 2],
    vp: [Lane<N>; 2],
    pv: [Lane<N>; 2],
    sum: Lane<N>,
    sum_sq: Lane<N>,
    sum_abs: Lane<N>,
    travel: Lane<N>,
    previous: Lane<N>,
}

impl<const N: usize> Gather<N> {
    fn new(loops: [&Prepared<'_>; N]) -> Self {
        let empty = [Lane::splat(f64::INFINITY), Lane::splat(f64::NEG_INFINITY)];
        Self {
            from: loops[0].settings.samples / 2,
            // The control error crosses downwards where the PV crosses the set point upwards.
            crossings: Crossings::new(
                Lane::splat(0.0),
                Lane(loops.map(|l| l.settings.noise_band())),
            ),
            op: empty,
            vp: empty,
            pv: empty,
            sum: Lane::splat(0.0),
            sum_sq: Lane::splat(0.0),
            sum_abs: Lane::splat(0.0),
            travel: Lane::splat(0.0),
            previous: Lane::splat(f64::NAN),
        }
    }

    fn statistics(&self, lane: usize, settings: &ClosedLoop) -> Statistics {
        let count = (settings.samples - self.from) as f64;
        let half_pp = |range: &[Lane<N>; 2]| {
            let width = (range[1][lane] - range[0][lane]) / 2.0;
            if width > 0.0 { width } else { 0.0 }
        };
        let mean = |sum: f64| if count > 0.0 { sum / count } else { 0.0 };
        Statistics {
            period_s: self.crossings.period(lane).map(|samples| samples * settings.sample_time),
            op_half_pp: half_pp(&self.op),
            vp_half_pp: half_pp(&self.vp),
            pv_half_pp: half_pp(&self.pv),
            error_mean: mean(self.sum[lane]),
            error_rms: mean(self.sum_sq[lane]).sqrt(),
            error_abs: mean(self.sum_abs[lane]),
            travel_per_s: mean(self.travel[lane]) / settings.sample_time,
        }
    }
}

impl<const N: usize> Recorder<N> for Gather<N> {
    fn from(&self) -> usize {
        self.from
    }

    #[inline(always)]
    fn take(&mut self, k: usize, samples: &[Sample<N>]) {
        // Local copies stay in registers.
        let (mut op, mut vp, mut pv) = (self.op, self.vp, self.pv);
        let (mut sum, mut sum_sq, mut sum_abs) = (self.sum, self.sum_sq, self.sum_abs);
        let (mut travel, mut previous) = (self.travel, self.previous);
        for sample in samples {
            for l in 0..N {
                widen(&mut op, l, sample.op[l]);
                widen(&mut vp, l, sample.vp[l]);
                widen(&mut pv, l, sample.pv[l]);
                let e = sample.sp[l] - sample.pv[l];
                sum[l] += e;
                sum_sq[l] += e * e;
                sum_abs[l] += e.abs();
                let step = (sample.vp[l] - previous[l]).abs();
                // The first sample has no predecessor.
                travel[l] += if step >= 0.0 { step } else { 0.0 };
                previous[l] = sample.vp[l];
            }
        }
        (self.op, self.vp, self.pv) = (op, vp, pv);
        (self.sum, self.sum_sq, self.sum_abs) = (sum, sum_sq, sum_abs);
        (self.travel, self.previous) = (travel, previous);

        self.crossings.take(k, samples, |sample, l| sample.pv[l] - sample.sp[l]);
    }
}

/// Widens the range in lane `l` by `value`.
#[inline(always)]
fn widen<const N: usize>(range: &mut [Lane<N>; 2], l: usize, value: f64) {
    range[0][l] = if value < range[0][l] { value } else { range[0][l] };
    range[1][l] = if value > range[1][l] { value } else { range[1][l] };
}

impl ClosedLoop {
    /// Simulates the loop and keeps only its statistics.
    ///
    /// # Errors
    /// As [`ClosedLoop::run`].
    pub fn statistics(&self) -> Result<Statistics> {
        let prepared = self.prepare()?;
        let gathered = play_one(&prepared, Gather::new([&prepared]));
        Ok(gathered.statistics(0, self))
    }
}

/// Kind of valve bank that a loop needs, so that loops of one kind can share a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    TwoPhase,
    He,
    Other,
}

fn kind(valve: &Assembly) -> Kind {
    match valve.bare_model() {
        Some(AnyModel::TwoPhase(valve)) if valve.is_laned() => Kind::TwoPhase,
        Some(AnyModel::He(_)) => Kind::He,
        _ => Kind::Other,
    }
}

impl<L: LaneValve> ValveBank for L {
    #[inline(always)]
    fn step(&mut self, l: usize, op: f64) -> f64 {
        LaneValve::step(self, l, op)
    }
}

/// Simulates a block of loops with these valves.
fn play_with<V: ValveBank, const M: usize>(
    width: Width,
    loops: [&Prepared<'_>; LANES],
    valves: V,
) -> Gather<LANES> {
    let bank = LoopBank::<V, LANES, M>::new(loops, valves);
    let (feeds, samples) = (Feeds::new(loops), loops[0].settings.samples);
    let gather = Gather::new(loops);
    if bank.is_plain() {
        play::<true, _, _, LANES, M>(width, bank, feeds, samples, gather)
    } else {
        play::<false, _, _, LANES, M>(width, bank, feeds, samples, gather)
    }
}

/// Simulates all `loops` and returns their statistics in the same order. The loops may differ in everything except
/// their number of samples. The results equal the results of [`ClosedLoop::statistics`], bit for bit, on any number of
/// threads.
///
/// Sixteen loops at a time share a processor core. Loops with a bare [`TwoPhase`](crate::valve::TwoPhase) or
/// [`He`](crate::valve::He) valve are the fastest. A load or noise that differs from sample to sample needs the time to
/// compute it.
///
/// # Errors
/// If a loop has a setting out of range, which [`Error::InLoop`] names, or the loops differ in their number of samples.
pub fn sweep(loops: &[ClosedLoop]) -> Result<Vec<Statistics>> {
    let in_loop = |index: usize| move |source| Error::InLoop { index, source: Box::new(source) };
    if let Some(index) = loops.iter().position(|l| l.samples != loops[0].samples) {
        return Err(Error::Length {
            name: "a loop of the sweep",
            found: loops[index].samples,
            expected: loops[0].samples,
        });
    }
    let prepared: Vec<Prepared<'_>> = loops
        .par_iter()
        .enumerate()
        .map(|(index, settings)| settings.prepare().map_err(in_loop(index)))
        .collect::<Result<_>>()?;

    // Blocks of similar loops: in valve and order by necessity, in delay because equal delays are read fastest.
    let mut order: Vec<usize> = (0..loops.len()).collect();
    let alike = |i: &usize| {
        let process = &prepared[*i].process;
        let states = with_order!(process.order(), M => M);
        (kind(&loops[*i].valve), states, process.delay())
    };
    order.sort_by_key(alike);
    let blocks: Vec<&[usize]> = order
        .chunk_by(|i, j| {
            let (a, b) = (alike(i), alike(j));
            (a.0, a.1) == (b.0, b.1)
        })
        .flat_map(|group| group.chunks(LANES))
        .collect();

    let results: Vec<Vec<Statistics>> =
        blocks.par_iter().map(|block| play_block(Width::widest(), block, &prepared)).collect();
    let mut statistics: Vec<(usize, Statistics)> =
        order.iter().copied().zip(results.into_iter().flatten()).collect();
    statistics.sort_by_key(|(index, _)| *index);
    Ok(statistics.into_iter().map(|(_, statistics)| statistics).collect())
}

/// Simulates up to sixteen loops of one kind. Lanes without a loop repeat the last one.
fn play_block(width: Width, block: &[usize], prepared: &[Prepared<'_>]) -> Vec<Statistics> {
    let loops: [&Prepared<'_>; LANES] =
        std::array::from_fn(|l| &prepared[block[l.min(block.len() - 1)]]);
    let bands: [Bands; LANES] = loops.map(|l| match l.settings.valve.bare_model() {
        Some(AnyModel::TwoPhase(valve)) => valve.bands(),
        Some(AnyModel::He(valve)) => valve.bands(),
        _ => Bands::NONE,
    });
    let starts = loops.map(|l| Start::at_rest(l.settings.op_rest));
    let gathered = with_order!(loops[0].process.order(), M => {
        match kind(&loops[0].settings.valve) {
            Kind::TwoPhase => play_with::<_, M>(width, loops, TwoPhaseLanes::starting(&bands, starts)),
            Kind::He => play_with::<_, M>(width, loops, HeLanes::starting(&bands, starts)),
            Kind::Other => {
                let mut valves = loops.map(|l| l.settings.valve.clone());
                for (valve, start) in valves.iter_mut().zip(starts) {
                    valve.restart(start);
                }
                play_with::<_, M>(width, loops, Each(valves))
            }
        }
    });
    block.iter().enumerate().map(|(l, i)| gathered.statistics(l, prepared[*i].settings)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::{Controller, Process, Signal};
    use crate::valve::Model;

    /// A block of cycling loops, noisy or not, quantised or not, played with vectors of some width.
    fn played(width: Width, sd: f64, pv_quantum: f64) -> Vec<Statistics> {
        let loops: [ClosedLoop; LANES] = std::array::from_fn(|l| {
            let bands = Bands::from_s_j(5.0, 0.4 * l as f64).unwrap();
            let mut sticky = ClosedLoop::new(
                Controller::pi(1.1, 2.5).unwrap(),
                Model::TwoPhase.build(bands).unwrap().into(),
                Process::first_order(1.5, 5.93, 1.07).unwrap(),
            );
            sticky.set_point = 5.0.into();
            sticky.measurement = vec![Signal::Noise { sd, tau_s: 0.0, seed: l as u64 }];
            sticky.pv_quantum = pv_quantum;
            sticky
        });
        let prepared: Vec<_> = loops.iter().map(|l| l.prepare().unwrap()).collect();
        play_block(width, &std::array::from_fn::<usize, LANES, _>(|l| l), &prepared)
    }

    #[test]
    fn all_widths_give_the_same_bits() {
        for (sd, pv_quantum) in [(0.0, 0.0), (0.2, 0.0), (0.2, 0.05)] {
            let expected = played(Width::Baseline, sd, pv_quantum);
            for width in Width::available() {
                assert_eq!(played(width, sd, pv_quantum), expected, "{width:?}");
            }
        }
    }
}
