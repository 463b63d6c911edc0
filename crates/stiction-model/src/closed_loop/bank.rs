//! Closed loops side by side: the arithmetic of one sample, for one loop or for sixteen.

use super::between::{Between, Wire};
use super::controller::{Engaged, PiBank, PidBank};
use super::description::{ClosedLoop, Prepared, Sources};
use super::process::{DelayLine, ProcessBank};
use super::signal::SignalSource;
use crate::simd::{Kernel, Lane, Width};
use crate::valve::{AnyModel, Start, Valve};

/// Valves side by side, each with its own OP.
pub(super) trait ValveBank: Clone {
    /// Steps the valve in lane `l`.
    fn step(&mut self, l: usize, op: f64) -> f64;
}

/// `N` independent valves, stepped one by one.
#[derive(Debug, Clone)]
pub(super) struct Each<V, const N: usize>(pub [V; N]);

impl<V: Valve + Clone, const N: usize> ValveBank for Each<V, N> {
    #[inline(always)]
    fn step(&mut self, l: usize, op: f64) -> f64 {
        self.0[l].step(op)
    }
}

/// A sum of signals for each of `N` loops, computed a few samples ahead.
pub(super) struct Feed<const N: usize> {
    constant: Lane<N>,
    moving: Vec<(usize, SignalSource)>,
    ahead: Vec<Lane<N>>,
}

/// Samples computed ahead, simulated in a row, and then recorded. Sixteen lanes of them fit into the first-level
/// cache.
pub(super) const AHEAD: usize = 32;

impl<const N: usize> Feed<N> {
    fn new(constant: Lane<N>, moving: Vec<(usize, SignalSource)>) -> Self {
        Self { constant, moving, ahead: vec![constant; AHEAD] }
    }

    /// The next samples, at most [`AHEAD`].
    fn draw(&mut self, samples: usize) -> &[Lane<N>] {
        let ahead = &mut self.ahead[..samples];
        if !self.moving.is_empty() {
            ahead.fill(self.constant);
        }
        for (lane, source) in &mut self.moving {
            source.add_to(ahead, |sample| &mut sample[*lane]);
        }
        ahead
    }
}

/// Records `N` loops.
pub(super) trait Recorder<const N: usize> {
    /// The first sample to record.
    fn from(&self) -> usize {
        0
    }

    /// Records some consecutive samples, the first of which is number `k`.
    fn take(&mut self, k: usize, samples: &[Sample<N>]);
}

/// One sample of `N` loops.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<const N: usize> {
    pub sp: Lane<N>,
    pub pv: Lane<N>,
    pub op: Lane<N>,
    pub vp: Lane<N>,
}

/// `N` closed loops with processes of at most `M` states.
#[derive(Debug, Clone)]
pub(super) struct LoopBank<V, const N: usize, const M: usize> {
    state: LoopState<V, N, M>,
    line: DelayLine<N>,
    /// Parts beyond PI control without quantisation, if any lane has them.
    extras: Option<Extras<N>>,
}

/// The part of the loops that changes at every sample. It is copied before a segment and then stays in registers,
/// so it must not contain anything that is rarely used or indexed at run time.
#[derive(Debug, Clone)]
struct LoopState<V, const N: usize, const M: usize> {
    controller: PiBank<N>,
    valve: V,
    process: ProcessBank<N, M>,
    op_rest: Lane<N>,
    pv_rest: Lane<N>,
}

#[derive(Debug, Clone)]
struct Extras<const N: usize> {
    /// The controllers that replace the PI controllers.
    controller: PidBank<N>,
    op_quantum: Lane<N>,
    pv_quantum: Lane<N>,
}

/// `value` in whole multiples of `quantum`, or unchanged for a quantum of 0.
#[inline(always)]
pub fn quantised(value: f64, quantum: f64) -> f64 {
    if quantum > 0.0 { (value / quantum).round_ties_even() * quantum } else { value }
}

impl<V: ValveBank, const N: usize, const M: usize> LoopBank<V, N, M> {
    pub(super) fn new(loops: [&Prepared<'_>; N], valve: V) -> Self {
        let extras = loops.iter().any(|l| {
            let settings = l.settings;
            let quantised = settings.op_quantum > 0.0 || settings.pv_quantum > 0.0;
            quantised || !settings.controller.is_plain_pi()
        });
        Self::with_extras(loops, valve, extras)
    }

    /// Loops whose controllers are of every kind if there are `extras`.
    pub(super) fn with_extras(loops: [&Prepared<'_>; N], valve: V, extras: bool) -> Self {
        let of = |get: fn(&ClosedLoop) -> f64| Lane(loops.map(|l| get(l.settings)));
        let controllers = loops.map(|l| {
            let settings = l.settings;
            let (op, pv) = (settings.op_rest, settings.pv_rest);
            Engaged::new(&settings.controller, settings.sample_time, op, l.first_sp, pv)
        });
        Self {
            state: LoopState {
                controller: PiBank::new(&controllers),
                valve,
                process: ProcessBank::new(loops.map(|l| &l.process)),
                op_rest: of(|l| l.op_rest),
                pv_rest: of(|l| l.pv_rest),
            },
            line: DelayLine::new(loops.map(|l| l.process.delay())),
            extras: extras.then(|| Extras {
                controller: PidBank::new(&controllers),
                op_quantum: of(|l| l.op_quantum),
                pv_quantum: of(|l| l.pv_quantum),
            }),
        }
    }

    /// Whether these loops can be simulated as `PLAIN`: PI control, no quantisation, and the same dead time in all
    /// lanes.
    pub(super) fn is_plain(&self) -> bool {
        self.extras.is_none() && self.line.is_common()
    }

    /// The PV of the process in lane `l`, before measurement.
    pub(super) fn process_value(&self, l: usize) -> f64 {
        self.state.process.output(l) + self.state.pv_rest[l]
    }

    /// Simulates one sample of any loops.
    pub(super) fn step(
        &mut self,
        sp: &Lane<N>,
        load: &Lane<N>,
        measurement: &Lane<N>,
    ) -> Sample<N> {
        self.step_between(&mut Wire, sp, load, measurement)
    }

    /// Simulates one sample of any loops with something between; see [`LoopState::step`].
    pub(super) fn step_between(
        &mut self,
        between: &mut (impl Between + ?Sized),
        sp: &Lane<N>,
        load: &Lane<N>,
        measurement: &Lane<N>,
    ) -> Sample<N> {
        let (line, extras) = (&mut self.line, &mut self.extras);
        self.state.step::<false, _>(line, extras, between, sp, load, measurement)
    }
}

impl<V, const M: usize> LoopBank<Each<V, 1>, 1, M> {
    /// The valve of the loop.
    pub(super) fn valve(&self) -> &V {
        &self.state.valve.0[0]
    }

    pub(super) fn valve_mut(&mut self) -> &mut V {
        &mut self.state.valve.0[0]
    }

    /// Continues from the state of another loop, except for the valve.
    pub(super) fn take_over(&mut self, other: &Self) {
        match (&mut self.extras, &other.extras) {
            (Some(own), Some(other)) => own.controller.recall(other.controller.memory()),
            _ => self.state.controller.set_integral(other.state.controller.integral()),
        }
        let mut states = vec![];
        other.state.process.remember(&mut states);
        self.state.process.recall(&mut states.into_iter());
        let mut line = vec![];
        other.line.remember(&mut line);
        let oldest = line.last().copied().unwrap_or(0.0);
        self.line.recall(&mut line.into_iter().chain(std::iter::repeat(oldest)));
    }

    /// Appends the memory of controller, process and dead time.
    pub(super) fn remember(&self, memory: &mut Vec<f64>) {
        match &self.extras {
            None => memory.push(self.state.controller.integral()),
            Some(extras) => memory.extend(extras.controller.memory()),
        }
        self.state.process.remember(memory);
        self.line.remember(memory);
    }

    /// Restores it.
    pub(super) fn recall(&mut self, memory: &mut impl Iterator<Item = f64>) {
        let mut next = || memory.next().unwrap_or(0.0);
        match &mut self.extras {
            None => self.state.controller.set_integral(next()),
            Some(extras) => extras.controller.recall(std::array::from_fn(|_| next())),
        }
        self.state.process.recall(memory);
        self.line.recall(memory);
    }
}

impl<V: ValveBank, const N: usize, const M: usize> LoopState<V, N, M> {
    /// Simulates one sample: `load` adds to the valve position, `measurement` to the PV.
    ///
    /// `PLAIN` leaves out everything else. It is only for [plain](LoopBank::is_plain) banks, because a check at every
    /// sample would cost more than the sample. The element `between` controller and valve can act on the controller
    /// only if there are extras.
    #[inline(always)]
    fn step<const PLAIN: bool, B: Between + ?Sized>(
        &mut self,
        line: &mut DelayLine<N>,
        extras: &mut Option<Extras<N>>,
        between: &mut B,
        sp: &Lane<N>,
        load: &Lane<N>,
        measurement: &Lane<N>,
    ) -> Sample<N> {
        // One loop over the lanes: the compiler turns it into vector code as a whole.
        let zero = Lane::splat(0.0);
        let (mut pv, mut op, mut vp, mut v) = (zero, zero, zero, zero);
        for l in 0..N {
            let signal;
            pv[l] = (self.process.output(l) + self.pv_rest[l]) + measurement[l];
            if let (false, Some(extras)) = (PLAIN, &mut *extras) {
                pv[l] = quantised(pv[l], extras.pv_quantum[l]);
                let integral = between.integral(sp[l], pv[l]);
                op[l] = extras.controller.step_with(l, sp[l], pv[l], integral);
                op[l] = quantised(op[l], extras.op_quantum[l]);
                let sent = between.send(sp[l], pv[l], op[l]);
                if sent.tracked {
                    extras.controller.track(l, sent.signal);
                }
                signal = sent.signal;
            } else {
                op[l] = self.controller.step(l, sp[l], pv[l]);
                signal = op[l];
            }
            vp[l] = self.valve.step(l, signal);
            v[l] = (vp[l] - self.op_rest[l]) + load[l];
        }
        self.process.advance(line.push::<PLAIN>(v));
        Sample { sp: *sp, pv, op, vp }
    }
}

/// External signals of `N` loops.
pub(super) struct Feeds<const N: usize> {
    sp: Feed<N>,
    load: Feed<N>,
    measurement: Feed<N>,
}

impl<const N: usize> Feeds<N> {
    pub(super) fn new(loops: [&Prepared<'_>; N]) -> Self {
        let feed = |get: for<'a> fn(&'a Prepared<'_>) -> &'a Sources| {
            let moving = (0..N).flat_map(|l| get(loops[l]).1.iter().map(move |s| (l, s.clone())));
            Feed::new(Lane(loops.map(|l| get(l).0)), moving.collect())
        };
        Self { sp: feed(|l| &l.sp), load: feed(|l| &l.load), measurement: feed(|l| &l.measurement) }
    }

    /// The next samples of set point, load and measurement, at most [`AHEAD`].
    pub(super) fn draw(&mut self, samples: usize) -> [&[Lane<N>]; 3] {
        [self.sp.draw(samples), self.load.draw(samples), self.measurement.draw(samples)]
    }
}

/// Some consecutive samples: the inner loop. It is compiled by itself, so that registers only hold the state of the
/// loops.
struct Segment<'a, const PLAIN: bool, V, B: ?Sized, const N: usize, const M: usize> {
    bank: &'a mut LoopBank<V, N, M>,
    between: &'a mut B,
    sp: &'a [Lane<N>],
    load: &'a [Lane<N>],
    measurement: &'a [Lane<N>],
    played: &'a mut [Sample<N>],
}

impl<const PLAIN: bool, V: ValveBank, B: Between + ?Sized, const N: usize, const M: usize> Kernel
    for Segment<'_, PLAIN, V, B, N, M>
{
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let LoopBank { state: kept, line, extras } = self.bank;
        let mut state = kept.clone();
        let driven = self.sp.iter().zip(self.load).zip(self.measurement);
        for (sample, ((sp, load), measurement)) in self.played.iter_mut().zip(driven) {
            let Sample { pv, op, vp, .. } =
                state.step::<PLAIN, B>(line, extras, self.between, sp, load, measurement);
            // The arrays alone: a single lane would copy its padding, too.
            (sample.sp.0, sample.pv.0, sample.op.0, sample.vp.0) = (sp.0, pv.0, op.0, vp.0);
        }
        *kept = state;
    }
}

/// Passes some consecutive samples to a recorder.
struct Record<'a, R, const N: usize> {
    recorder: &'a mut R,
    k: usize,
    samples: &'a [Sample<N>],
}

impl<R: Recorder<N>, const N: usize> Kernel for Record<'_, R, N> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        self.recorder.take(self.k, self.samples);
    }
}

/// Simulates `samples` samples of `bank` and passes the requested ones to `recorder`. Only
/// [plain](LoopBank::is_plain) banks may be simulated as `PLAIN`.
pub(super) fn play<
    const PLAIN: bool,
    V: ValveBank,
    R: Recorder<N>,
    const N: usize,
    const M: usize,
>(
    width: Width,
    bank: LoopBank<V, N, M>,
    feeds: Feeds<N>,
    samples: usize,
    recorder: R,
) -> R {
    play_between::<PLAIN, V, _, R, N, M>(width, bank, &mut Wire, feeds, samples, recorder)
}

/// Plays the loops with `between` controllers and valves; see [`LoopState::step`].
fn play_between<
    const PLAIN: bool,
    V: ValveBank,
    B: Between + ?Sized,
    R: Recorder<N>,
    const N: usize,
    const M: usize,
>(
    width: Width,
    mut bank: LoopBank<V, N, M>,
    between: &mut B,
    mut feeds: Feeds<N>,
    samples: usize,
    mut recorder: R,
) -> R {
    let zero = Lane::splat(0.0);
    let mut played = [Sample { sp: zero, pv: zero, op: zero, vp: zero }; AHEAD];
    let from = recorder.from();
    for k in (0..samples).step_by(AHEAD) {
        let played = &mut played[..AHEAD.min(samples - k)];
        let [sp, load, measurement] = feeds.draw(played.len());
        width.run(Segment::<PLAIN, V, B, N, M> {
            bank: &mut bank,
            between: &mut *between,
            sp,
            load,
            measurement,
            played,
        });
        let unseen = from.saturating_sub(k);
        if unseen < played.len() {
            let samples = &played[unseen..];
            width.run(Record { recorder: &mut recorder, k: k + unseen, samples });
        }
    }
    recorder
}

/// Runs `$body` with the constant `$m` bound to the number of states reserved for `$order`.
macro_rules! with_order {
    ($order:expr, $m:ident => $body:expr) => {
        match $order {
            0 | 1 => {
                const $m: usize = 1;
                $body
            }
            2 => {
                const $m: usize = 2;
                $body
            }
            3 | 4 => {
                const $m: usize = 4;
                $body
            }
            _ => {
                const $m: usize = 8;
                $body
            }
        }
    };
}
pub(super) use with_order;

/// Simulates one loop and passes its samples to `recorder`.
pub(super) fn play_one<R: Recorder<1>>(prepared: &Prepared<'_>, recorder: R) -> R {
    let settings = prepared.settings;
    let mut valve = settings.valve.clone();
    valve.restart(Start::at_rest(settings.op_rest));
    with_order!(prepared.process.order(), M => match valve.into_bare_model() {
        // The most common valve without a dispatch at every sample.
        Ok(AnyModel::TwoPhase(valve)) => play_with::<_, _, M>(prepared, valve, recorder),
        Ok(model) => play_with::<_, _, M>(prepared, model, recorder),
        Err(valve) => play_with::<_, _, M>(prepared, *valve, recorder),
    })
}

/// Simulates one loop with `between` controller and valve, and passes its samples to `recorder`.
pub(super) fn play_one_between<R: Recorder<1>>(
    prepared: &Prepared<'_>,
    between: &mut dyn Between,
    recorder: R,
) -> R {
    let settings = prepared.settings;
    let mut valve = settings.valve.clone();
    valve.restart(Start::at_rest(settings.op_rest));
    with_order!(prepared.process.order(), M => {
        let bank = LoopBank::<_, 1, M>::with_extras([prepared], Each([valve]), true);
        let (width, feeds) = (Width::widest(), Feeds::new([prepared]));
        play_between::<false, _, _, _, 1, M>(width, bank, between, feeds, settings.samples, recorder)
    })
}

fn play_with<V: Valve + Clone, R: Recorder<1>, const M: usize>(
    prepared: &Prepared<'_>,
    valve: V,
    recorder: R,
) -> R {
    let bank = LoopBank::<Each<V, 1>, 1, M>::new([prepared], Each([valve]));
    let (feeds, samples) = (Feeds::new([prepared]), prepared.settings.samples);
    if bank.is_plain() {
        play::<true, _, _, 1, M>(Width::widest(), bank, feeds, samples, recorder)
    } else {
        play::<false, _, _, 1, M>(Width::widest(), bank, feeds, samples, recorder)
    }
}
