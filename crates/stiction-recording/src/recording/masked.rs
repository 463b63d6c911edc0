//! Values that are no measurements: codes for "no value", isolated spikes, and flat lines far outside the rest.
//!
//! Historians, gateways and converters write numbers such as -9999 or 32767 where there is no value. One such sample
//! shifts every mean, range and relation, so [`Recording::mask`] makes such samples bad before anything is computed.
//! Every masked sample keeps its value and the reason, see [`MaskedSample`].
//!
//! The rule compares a value with the **reach** of its signal, which are the values it can have:
//!
//! * PV: between the quartiles of PV and SP. Values outside are examined from the nearest on, and one that may be a
//!   measurement widens the reach. So a wave, a step or a ramp widens the reach step by step until it holds all of it.
//! * OP and VP: -10 to 110 if the quartiles are percent. Controllers saturate suddenly, so everything between is real.
//!   Otherwise from zero to many times the typical value, because a valve may be nearly closed most of the time.
//! * Every value between the ends of a range that the user or the file gives.
//!
//! A value outside the reach is no measurement if its kind ([`MaskedKind`]) and its distance show it. The distance is
//! in units of the reach, because a process upset of a few times the usual swing is real. Real signals also arrive at
//! a distant value through values between, or remain there and go on to move.

use super::{Channel, Quality, Recording};
use crate::spoken::counted;
use std::borrow::Cow;
use std::collections::HashSet;
use stiction_model::named;

named! {
    /// Why a value is no measurement.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum MaskedKind {
        /// The user names it as bad.
        Named = "named as bad",
        /// A number that programs write instead of a value, outside the plausible range of the signal.
        Code = "code for no value",
        /// It lies far outside for a single sample.
        Spike = "isolated spike",
        /// It repeats exactly, far outside, while the rest of the signal moves.
        FlatLine = "flat line far outside",
        /// Exact zeros, reached by a jump, while the SP stays or the OP is zero, too.
        Zeros = "line of zeros",
    }
}

/// One masked sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaskedSample {
    /// Time, s on the recording's clock.
    pub time: f64,
    /// The recorded value.
    pub value: f64,
    /// Quality before.
    pub quality: Quality,
    /// Why it is no measurement.
    pub kind: MaskedKind,
}

/// The samples of one signal that have the same value and count as missing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Masked {
    /// The signal, such as `PV`.
    pub signal: &'static str,
    /// The recorded value.
    pub value: f64,
    /// Number of samples with this value.
    pub count: usize,
    /// Time of the first sample with this value, s on the recording's clock.
    pub first_s: f64,
    /// Why the value is no measurement.
    pub kind: MaskedKind,
}

impl Masked {
    /// The value with all its digits.
    pub fn written(&self) -> String {
        let single = self.value as f32;
        match self.value.abs() {
            1e9.. => format!("{:e}", self.value),
            _ if f64::from(single) == self.value => single.to_string(),
            _ => self.value.to_string(),
        }
    }

    /// How many values are masked in each signal, and the first few of them, such as `1 value of the PV (-9999)`;
    /// `None` if no value is masked.
    pub fn words(masked: &[Self]) -> Option<String> {
        const MOST: usize = 3;
        let signals = masked.chunk_by(|a, b| a.signal == b.signal).map(|of| {
            let count: usize = of.iter().map(|each| each.count).sum();
            let mut values: Vec<String> = vec![];
            of.iter().map(Self::written).for_each(|value| {
                values.extend((!values.contains(&value)).then_some(value));
            });
            let more = values.len().saturating_sub(MOST);
            values.truncate(MOST);
            let and = if more > 0 { format!(" and {more} more") } else { String::new() };
            format!(
                "{} of the {} ({}{and})",
                counted(count, "value"),
                of[0].signal,
                values.join(", ")
            )
        });
        let signals: Vec<String> = signals.collect();
        (!signals.is_empty()).then(|| signals.join(" and "))
    }
}

/// Fewer equal values than this number are not a rest with which others can be compared.
const FEWEST: usize = 8;
/// Distance of a code from the reach of a PV, in its widths. Codes are far outside by design, and a value within one
/// width may be a measurement.
const CODE: f64 = 1.0;
/// This distance for the limit of a whole number, which may also be the full scale of a signal in counts. The other
/// values then lie within a small part of that scale.
const LIMIT: f64 = 3.0;
/// Least distance of a code as a share of itself: 9999 beside 9990 is a measurement. It does not count if the signal
/// jumps to the code and back at least [`OFTEN`] times.
const OWN_SIZE: f64 = 0.05;
const OFTEN: usize = 3;
/// Distance of a spike in widths. An upset of a few times the usual swing is real.
const SPIKE: f64 = 10.0;
/// Distance of a flat line in widths. It needs more than a spike, because a signal may also move to a new level.
const FLAT: f64 = 30.0;
/// Distance of zeros in widths: a few, because the SP or the OP shows that the loop did not go there.
const ZEROS: f64 = 3.0;
/// Spikes above this share of the samples are a property of the signal.
const MOST_SPIKES: f64 = 0.05;
/// A spike lasts at most this many mean sample times. A value stored on change may hold much longer.
const SPIKE_STEPS: f64 = 4.0;
/// The reach of a valve signal in percent; controllers allow some percent more than their range.
const PERCENT: [f64; 2] = [-10.0, 110.0];
/// Full scale of a valve signal in other units, in typical values: an opening of 5 % may be typical.
const FULL_SCALE: f64 = 20.0;
/// As [`SPIKE`] and [`FLAT`], for a valve signal, whose reach is its whole range.
const VALVE_SPIKE: f64 = 0.5;
const VALVE_FLAT: f64 = 5.0;
/// The search ends after this many changes of a decision, because the values are then too close to each other.
const MOST_TURNS: usize = 50;

impl Recording {
    /// Masks samples that are no measurements; see the module. A second call changes nothing more.
    pub fn mask(&mut self) {
        // What is masked first may bare more.
        for _ in 0..MOST_TURNS {
            let found = found(self);
            if found.is_empty() {
                return;
            }
            for (signal, samples) in found {
                let channel = match signal {
                    Signal::Op => Some(&mut self.op),
                    Signal::Pv => self.pv.as_mut(),
                    Signal::Sp => self.sp.as_mut(),
                    Signal::Vp => self.vp.as_mut(),
                };
                if let Some(channel) = channel {
                    samples.into_iter().for_each(|(place, kind)| channel.mask(place, kind));
                }
            }
        }
    }

    /// The recording with masked samples; see [`Recording::mask`].
    pub fn masked(&self) -> Cow<'_, Self> {
        if found(self).is_empty() {
            return Cow::Borrowed(self);
        }
        let mut masked = self.clone();
        masked.mask();
        Cow::Owned(masked)
    }

    /// The recording before [`Recording::mask`]; values that the user names stay masked.
    pub fn unmasked(&self) -> Cow<'_, Self> {
        let found = |channel: &Channel| channel.masked.iter().any(|m| m.kind != MaskedKind::Named);
        if !self.channels().into_iter().any(|(_, channel)| found(channel)) {
            return Cow::Borrowed(self);
        }
        let mut whole = self.clone();
        let Self { op, pv, sp, vp, .. } = &mut whole;
        for channel in [Some(op), pv.as_mut(), sp.as_mut(), vp.as_mut()].into_iter().flatten() {
            channel.unmask();
        }
        Cow::Owned(whole)
    }

    /// The values of all masked samples, by signal and then the most frequent first.
    pub fn masked_values(&self) -> Vec<Masked> {
        self.channels()
            .into_iter()
            .flat_map(|(signal, channel)| channel.masked_values(signal))
            .collect()
    }

    fn channels(&self) -> Vec<(&'static str, &Channel)> {
        let all = [
            ("OP", Some(&self.op)),
            ("PV", self.pv.as_ref()),
            ("SP", self.sp.as_ref()),
            ("VP", self.vp.as_ref()),
        ];
        all.into_iter().filter_map(|(signal, channel)| Some((signal, channel?))).collect()
    }
}

impl Channel {
    /// Masks every usable sample whose value is one of these.
    pub fn mask_named(&mut self, values: &[f64]) {
        if values.is_empty() {
            return;
        }
        for place in 0..self.values.len() {
            if self.usable(place) && values.iter().any(|v| same(self.values[place], *v)) {
                self.mask(place, MaskedKind::Named);
            }
        }
    }

    /// The values of the masked samples, the most frequent first. `signal` is the name of the signal.
    pub fn masked_values(&self, signal: &'static str) -> Vec<Masked> {
        let mut samples: Vec<&MaskedSample> = self.masked.iter().collect();
        samples.sort_by(|a, b| {
            a.kind.cmp(&b.kind).then(a.value.total_cmp(&b.value)).then(a.time.total_cmp(&b.time))
        });
        let mut all: Vec<Masked> = samples
            .chunk_by(|a, b| a.kind == b.kind && a.value == b.value)
            .map(|group| Masked {
                signal,
                value: group[0].value,
                count: group.len(),
                first_s: group[0].time,
                kind: group[0].kind,
            })
            .collect();
        all.sort_by_key(|masked| std::cmp::Reverse(masked.count));
        all
    }

    fn usable(&self, place: usize) -> bool {
        self.quality[place].is_usable()
    }

    fn mask(&mut self, place: usize, kind: MaskedKind) {
        let (time, value, quality) = (self.time[place], self.values[place], self.quality[place]);
        self.masked.push(MaskedSample { time, value, quality, kind });
        (self.values[place], self.quality[place]) = (f64::NAN, Quality::Bad);
    }

    /// Restores what [`Recording::mask`] found.
    fn unmask(&mut self) {
        let (named, mut found): (Vec<_>, Vec<_>) =
            self.masked.drain(..).partition(|masked| masked.kind == MaskedKind::Named);
        self.masked = named;
        found.sort_by(|a, b| b.time.total_cmp(&a.time));
        let mut places: Vec<usize> =
            (0..self.time.len()).filter(|k| self.quality[*k] == Quality::Bad).collect();
        places.sort_by(|a, b| self.time[*a].total_cmp(&self.time[*b]));
        for place in places {
            while found.last().is_some_and(|masked| masked.time < self.time[place]) {
                found.pop();
            }
            if found.last().is_some_and(|masked| masked.time == self.time[place])
                && let Some(masked) = found.pop()
            {
                (self.values[place], self.quality[place]) = (masked.value, masked.quality);
            }
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Signal {
    Op,
    Pv,
    Sp,
    Vp,
}

/// Samples by their place in the channel.
type Places = Vec<(usize, MaskedKind)>;

/// The samples that are no measurements, by signal; signals without such samples are left out. Channels of unequal
/// length, which the grid refuses, are left alone.
fn found(recording: &Recording) -> Vec<(Signal, Places)> {
    let sound = |c: &&Channel| c.time.len() == c.values.len() && c.quality.len() == c.values.len();
    let op = Some(&recording.op).filter(sound);
    let [pv, sp, vp] =
        [&recording.pv, &recording.sp, &recording.vp].map(|channel| channel.as_ref().filter(sound));
    let mut of_op = op.map_or(vec![], of_valve);
    let Process { of_pv, of_sp, zeros } = Process::of(pv, sp, op);
    if let (Some(op), false) = (op, zeros.is_empty()) {
        of_op.extend(zeros_at(op, &zeros));
    }
    let all = [
        (Signal::Op, of_op),
        (Signal::Pv, of_pv),
        (Signal::Sp, of_sp),
        (Signal::Vp, vp.map_or(vec![], of_valve)),
    ];
    all.into_iter().filter(|(_, places)| !places.is_empty()).collect()
}

/// The masked samples of OP or VP.
fn of_valve(channel: &Channel) -> Places {
    let Some((low, high)) = ends(channel) else { return vec![] };
    if low >= PERCENT[0] && high <= PERCENT[1] {
        return vec![];
    }
    let samples = Samples::of(channel);
    let Some([low, high]) = samples.quartiles() else {
        // Of codes alone, those below zero and beyond all numbers of a range are no outputs.
        let impossible = |(k, v): (usize, &f64)| {
            (*v < -PERCENT[1] || *v >= HUGE).then_some((samples.places[k], MaskedKind::Code))
        };
        return samples.values.iter().enumerate().filter_map(impossible).collect();
    };
    let typical = high.abs().max(low.abs());
    let full = FULL_SCALE * typical;
    let (low, high, unit) = if low >= PERCENT[0] && high <= PERCENT[1] {
        (PERCENT[0], PERCENT[1], PERCENT[1] - PERCENT[0])
    } else if typical <= PERCENT[1] {
        // Deviations from a mean, in percent.
        (-PERCENT[1], PERCENT[1], 2.0 * PERCENT[1])
    } else {
        (if low < 0.0 { -full } else { 0.0 }, if high > 0.0 { full } else { 0.0 }, typical)
    };
    let reach = Reach { low, high }.with(given(channel));
    let rules = Rules { code: 0.0, spike: VALVE_SPIKE, flat: VALVE_FLAT, unit: Some(unit) };
    samples.examine(reach, &rules, &|_| false).0
}

/// The masked samples of PV and SP.
#[derive(Default)]
struct Process {
    of_pv: Places,
    of_sp: Places,
    /// The times, as bits, of the masked zeros of the PV.
    zeros: HashSet<u64>,
}

impl Process {
    fn of(pv: Option<&Channel>, sp: Option<&Channel>, op: Option<&Channel>) -> Self {
        let sp = sp.filter(|sp| ends(sp).is_some());
        let Some(pv) = pv.filter(|pv| ends(pv).is_some()) else {
            let of_sp = sp.map_or(vec![], |sp| of_set_point(sp, None, &HashSet::new()).0);
            return Self { of_sp, ..Self::default() };
        };
        if plain(pv) && sp.is_none_or(|sp| plain(sp) || without_codes(sp)) {
            return Self::default();
        }
        let samples = Samples::of(pv);
        let Some([low, high]) = samples.quartiles() else { return Self::default() };
        let zero = |time: f64, of: &HashSet<u64>| of.contains(&time.to_bits());
        // Times at which PV and OP are zero; a set point of zero at such a time is nothing, too.
        let of_op = op.map_or_else(HashSet::new, times_of_zeros);
        let mut both = times_of_zeros(pv);
        let zeros = both.len();
        both.retain(|time| of_op.contains(time));
        let set = sp.and_then(|sp| {
            let values = sp.values.iter().zip(&sp.time).filter(|(v, _)| v.is_finite());
            let real = values.filter(|(v, t)| !(is_code(**v) || **v == 0.0 && zero(**t, &both)));
            Reach::around(real.map(|(v, _)| *v))
        });
        let together = zeros > 0 && 10 * both.len() >= 9 * zeros;
        let no_zero =
            |unit: f64| together || set.is_some_and(|set| set.distance(0.0) > ZEROS * unit);
        let reach = Reach { low, high }.with(given(pv));
        let (_, reach) = samples.examine(reach, &Rules::PROCESS, &no_zero);
        // The SP goes where the PV can go, and the PV follows it, so the PV is examined again with the reach of both.
        let (mut of_sp, reach) = match sp {
            Some(sp) => of_set_point(sp, Some(reach), &both),
            None => (vec![], reach),
        };
        let (of_pv, _) = samples.examine(reach, &Rules::PROCESS, &no_zero);
        let zeros = of_pv.iter().filter(|(_, kind)| *kind == MaskedKind::Zeros);
        let zeros: HashSet<u64> = zeros.map(|(place, _)| pv.time[*place].to_bits()).collect();
        if let Some(sp) = sp {
            both.retain(|time| zeros.contains(time));
            of_sp.extend(zeros_at(sp, &both));
        }
        Self { of_pv, of_sp, zeros }
    }
}

/// The masked samples of an SP, and the reach of the SP together with the reach of the PV. Only codes are masked,
/// because an SP may jump anywhere. Zeros at the times `nothing` do not count.
fn of_set_point(sp: &Channel, pv: Option<Reach>, nothing: &HashSet<u64>) -> (Places, Reach) {
    let mut samples = Samples::of(sp);
    samples.retain(|place, value| value != 0.0 || !nothing.contains(&sp.time[place].to_bits()));
    let typical = samples.quartiles().map(|[low, high]| Reach { low, high });
    let Some(reach) = typical.map_or(pv, |typical| Some(typical.with(pv))) else {
        return (vec![], Reach { low: 0.0, high: 0.0 });
    };
    samples.examine(reach.with(given(sp)), &Rules::SET_POINT, &|_| false)
}

/// The usable zeros of a channel at these times.
fn zeros_at<'a>(
    channel: &'a Channel,
    times: &'a HashSet<u64>,
) -> impl Iterator<Item = (usize, MaskedKind)> + 'a {
    let zero = |k: &usize| channel.values[*k] == 0.0 && times.contains(&channel.time[*k].to_bits());
    (0..channel.values.len()).filter(zero).map(|k| (k, MaskedKind::Zeros))
}

fn times_of_zeros(channel: &Channel) -> HashSet<u64> {
    let each = channel.values.iter().zip(&channel.time);
    each.filter(|(value, _)| **value == 0.0).map(|(_, time)| time.to_bits()).collect()
}

/// The smallest and the largest usable value. NaN is neither.
fn ends(channel: &Channel) -> Option<(f64, f64)> {
    let (low, high) =
        channel.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (if *value < low { *value } else { low }, if *value > high { *value } else { high })
        });
    (low <= high).then_some((low, high))
}

/// The range that the user or the file gives; every value in it may be a measurement.
fn given(channel: &Channel) -> Option<Reach> {
    let range = channel.range.filter(|range| !range.source.is_guess())?;
    Some(Reach { low: range.low, high: range.high })
}

fn without_codes(channel: &Channel) -> bool {
    // Values of an SP mostly repeat.
    let mut last = f64::NAN;
    !channel.values.iter().any(|value| {
        let changed = *value != last;
        last = *value;
        changed && is_code(*value)
    })
}

/// Whether nothing can be far outside. Some values then fill the span between the smallest and the largest of all
/// without a wide gap, and do not crowd in a small part of it. It is quick, because most signals are so.
fn plain(channel: &Channel) -> bool {
    const BINS: usize = 64;
    const ENOUGH: usize = 1024;
    /// A masked value leaves a gap of its whole width beside the rest; several may share the span.
    const GAP: usize = BINS / 5;
    let Some((low, high)) = ends(channel) else { return true };
    let scale = BINS as f64 / (high - low);
    if !(scale.is_finite() && scale > 0.0) {
        // All values are equal, or their distance overflows.
        return high == low;
    }
    let mut bins = [0usize; BINS];
    (bins[0], bins[BINS - 1]) = (1, 1);
    let some = channel.values.iter().step_by(1 + channel.values.len() / ENOUGH);
    for value in some.filter(|value| value.is_finite()) {
        bins[(((value - low) * scale) as usize).min(BINS - 1)] += 1;
    }
    let all: usize = bins.iter().sum();
    let gaps = bins.chunk_by(|a, b| (*a == 0) == (*b == 0)).filter(|run| run[0] == 0);
    let crowded = bins.windows(3).any(|three| 10 * three.iter().sum::<usize>() > 9 * all);
    gaps.map(<[usize]>::len).max().unwrap_or(0) < GAP && !crowded
}

/// Values from here on are codes: the largest numbers of a format, or powers of ten near them.
const HUGE: f64 = 1e20;

/// Limits of whole numbers of 16, 24 and 32 bits, without their signs.
const LIMITS: [f64; 9] = [
    32767.0,
    32768.0,
    65535.0,
    8388607.0,
    8388608.0,
    16777215.0,
    2147483647.0,
    2147483648.0,
    4294967295.0,
];

/// Other numbers that programs write instead of a value, without their signs: only nines, the null value of well
/// logs, limits of whole numbers with decimals, and large powers of ten.
const CODES: [f64; 38] = [
    999.0,
    9999.0,
    99999.0,
    999999.0,
    9999999.0,
    99999999.0,
    999999999.0,
    999.9,
    9999.9,
    99999.9,
    999.99,
    9999.99,
    99999.99,
    999.999,
    9999.999,
    99999.999,
    999.25,
    9999.25,
    8888.0,
    88888.0,
    3276.7,
    3276.8,
    6553.5,
    327.67,
    327.68,
    655.35,
    1e9,
    1e10,
    1e11,
    1e12,
    1e13,
    1e14,
    1e15,
    1e16,
    1e17,
    1e18,
    1e19,
    9999999999.0,
];

/// Whether programs write this number instead of a value. Spreadsheets export their errors as numbers from
/// -2146826288 on.
fn is_code(value: f64) -> bool {
    let size = value.abs();
    size >= 300.0
        && (size >= HUGE
            || CODES.iter().chain(&LIMITS).any(|code| same(size, *code))
            || ((-2_146_826_288.0..=-2_146_826_245.0).contains(&value) && value.fract() == 0.0))
}

/// Whether a value is this number, also if it was stored with single precision.
fn same(value: f64, number: f64) -> bool {
    value == number || value == f64::from(number as f32)
}

/// Values that a signal can have.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reach {
    low: f64,
    high: f64,
}

impl Reach {
    fn around(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        values.for_each(|value| (low, high) = (low.min(value), high.max(value)));
        (low <= high).then_some(Self { low, high })
    }

    fn with(self, other: Option<Self>) -> Self {
        other.map_or(self, |other| Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        })
    }

    fn distance(self, value: f64) -> f64 {
        (self.low - value).max(value - self.high)
    }

    fn holds(self, value: f64) -> bool {
        self.distance(value) <= 0.0
    }
}

/// At which distance from the reach a value of each kind is no measurement, in units.
struct Rules {
    code: f64,
    spike: f64,
    flat: f64,
    /// The unit; by default the width of the reach.
    unit: Option<f64>,
}

impl Rules {
    const PROCESS: Self = Self { code: CODE, spike: SPIKE, flat: FLAT, unit: None };
    const SET_POINT: Self =
        Self { code: CODE, spike: f64::INFINITY, flat: f64::INFINITY, unit: None };
}

/// The usable samples of a channel, in the order of the file.
struct Samples<'a> {
    channel: &'a Channel,
    places: Vec<usize>,
    values: Vec<f64>,
}

impl<'a> Samples<'a> {
    fn of(channel: &'a Channel) -> Self {
        let places: Vec<usize> =
            (0..channel.values.len()).filter(|place| channel.usable(*place)).collect();
        let values = places.iter().map(|place| channel.values[*place]).collect();
        Self { channel, places, values }
    }

    /// The lower and the upper quartile of the values that are no codes; `None` if there are too few.
    fn quartiles(&self) -> Option<[f64; 2]> {
        let mut rest: Vec<f64> = self.values.iter().copied().filter(|v| !is_code(*v)).collect();
        let n = rest.len();
        (n >= FEWEST).then(|| {
            [n / 4, n - 1 - n / 4].map(|rank| *rest.select_nth_unstable_by(rank, f64::total_cmp).1)
        })
    }

    fn retain(&mut self, keep: impl Fn(usize, f64) -> bool) {
        let kept: Vec<bool> = self
            .places
            .iter()
            .zip(&self.values)
            .map(|(place, value)| keep(*place, *value))
            .collect();
        let mut each = kept.iter();
        self.places.retain(|_| *each.next().unwrap_or(&true));
        let mut each = kept.iter();
        self.values.retain(|_| *each.next().unwrap_or(&true));
    }

    /// The samples that are no measurements, and the reach of the remaining samples. `no_zero` states whether a zero is
    /// no measurement at a given distance from the other samples.
    fn examine(
        &self,
        mut reach: Reach,
        rules: &Rules,
        no_zero: &dyn Fn(f64) -> bool,
    ) -> (Places, Reach) {
        // The samples outside, on each side from the nearest on.
        let (mut low, mut high): (Vec<usize>, Vec<usize>) = (0..self.values.len())
            .filter(|k| !reach.holds(self.values[*k]))
            .partition(|k| self.values[*k] < reach.low);
        // Stable, so samples of one value stay in the order of the file.
        low.sort_by(|a, b| self.values[*b].total_cmp(&self.values[*a]));
        high.sort_by(|a, b| self.values[*a].total_cmp(&self.values[*b]));
        let same = |a: &usize, b: &usize| self.values[*a] == self.values[*b];
        let (low, high): (Vec<&[usize]>, Vec<&[usize]>) =
            (low.chunk_by(same).collect(), high.chunk_by(same).collect());
        for _ in 0..MOST_TURNS {
            let (mut l, mut h, mut spikes) = (0, 0, 0);
            let mut masked: Vec<(&[usize], MaskedKind)> = vec![];
            let turned = loop {
                let side = |groups: &[&'_ [usize]], place: usize| {
                    groups.get(place).map(|group| reach.distance(self.values[group[0]]))
                };
                let group = match (side(&low, l), side(&high, h)) {
                    (None, None) => break false,
                    (Some(below), above) if above.is_none_or(|above| below <= above) => {
                        l += 1;
                        low[l - 1]
                    }
                    _ => {
                        h += 1;
                        high[h - 1]
                    }
                };
                if reach.holds(self.values[group[0]]) {
                    continue;
                }
                match self.kind(group, reach, rules, no_zero, spikes) {
                    Some(kind) => {
                        spikes += if kind == MaskedKind::Spike { group.len() } else { 0 };
                        masked.push((group, kind));
                    }
                    None => {
                        let value = self.values[group[0]];
                        reach = reach.with(Some(Reach { low: value, high: value }));
                        if !masked.is_empty() {
                            break true;
                        }
                    }
                }
            };
            // A wider reach changes what is far outside.
            if !turned {
                let places = |(group, kind): (&[usize], MaskedKind)| {
                    group.iter().map(|k| (self.places[*k], kind)).collect::<Vec<_>>()
                };
                return (masked.into_iter().flat_map(places).collect(), reach);
            }
        }
        (vec![], Reach::around(self.values.iter().copied()).unwrap_or(reach))
    }

    /// Why the samples of one value are no measurements; `None` if they may be measurements.
    fn kind(
        &self,
        group: &[usize],
        reach: Reach,
        rules: &Rules,
        no_zero: &dyn Fn(f64) -> bool,
        spikes: usize,
    ) -> Option<MaskedKind> {
        let value = self.values[group[0]];
        let distance = reach.distance(value);
        let unit = rules.unit.unwrap_or(reach.high - reach.low);
        // Whether the signal is back in its reach, at a sample beside; `None` beyond the first and the last one.
        let inside = |k: usize| {
            let near = self.values.get(k)?;
            Some(reach.holds(*near) || is_code(*near))
        };
        let runs: Vec<&[usize]> = group.chunk_by(|a, b| a + 1 == *b).collect();
        let before = |run: &[usize]| run[0].checked_sub(1).and_then(inside);
        let after = |run: &[usize]| inside(run[0] + run.len());
        let jumps = || runs.iter().all(|run| before(run) == Some(true) && after(run) == Some(true));
        if is_code(value) {
            let factor =
                if LIMITS.iter().any(|limit| same(value.abs(), *limit)) { LIMIT } else { 1.0 };
            let far = distance >= OWN_SIZE * value.abs() || (runs.len() >= OFTEN && jumps());
            if far && distance >= factor * rules.code * unit {
                return Some(MaskedKind::Code);
            }
        }
        if value == 0.0
            && distance >= ZEROS * unit
            && no_zero(unit)
            && runs.iter().all(|run| before(run) != Some(false) && after(run) != Some(false))
        {
            return Some(MaskedKind::Zeros);
        }
        // Nothing is far from a signal that never moves.
        if unit <= 0.0 || distance < rules.spike * unit {
            return None;
        }
        if !jumps() {
            return None;
        }
        let longest = runs.iter().map(|run| run.len()).max()?;
        if longest == 1 {
            let few = (spikes + group.len()) as f64 <= MOST_SPIKES * self.values.len() as f64;
            let short = group.iter().all(|k| self.lasts(*k) <= SPIKE_STEPS);
            return (few && short).then_some(MaskedKind::Spike);
        }
        let rest = self.values.chunk_by(|a, b| a == b).filter(|run| reach.holds(run[0]));
        let flattest = rest.map(<[f64]>::len).max().unwrap_or(0);
        (distance >= rules.flat * unit && longest > flattest).then_some(MaskedKind::FlatLine)
    }

    /// The time to the next sample, in mean sample times.
    fn lasts(&self, k: usize) -> f64 {
        let time = |k: usize| self.channel.time[self.places[k]];
        let last = self.places.len() - 1;
        let mean = (time(last) - time(0)).abs() / last.max(1) as f64;
        (time((k + 1).min(last)) - time(k)).abs() / mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oscillation::test_signals::{noise, sine};

    const N: usize = 600;

    /// A loop that swings by ±2 about 60, with the OP by ±3 about 45.
    fn swinging() -> [Vec<f64>; 3] {
        let wave = |of: f64, seed| {
            let wave = sine(N, 40.0).into_iter().zip(noise(N, seed));
            wave.map(|(s, e)| of * s + 0.1 * e).collect::<Vec<f64>>()
        };
        let about = |x: Vec<f64>, middle: f64| x.into_iter().map(|v| middle + v).collect();
        [about(wave(3.0, 1), 45.0), about(wave(2.0, 2), 60.0), vec![60.0; N]]
    }

    fn recording([op, pv, sp]: &[Vec<f64>; 3]) -> Recording {
        Recording::regular("A", 1.0, op, Some(pv), Some(sp)).unwrap()
    }

    /// What is masked in a loop with other values.
    fn masked(change: impl Fn(&mut [Vec<f64>; 3])) -> Vec<(&'static str, f64, usize, MaskedKind)> {
        let mut signals = swinging();
        change(&mut signals);
        let raw = recording(&signals);
        let mut found = raw.clone();
        found.mask();
        assert_eq!(found.masked().into_owned().masked_values(), found.masked_values());
        assert_eq!(found.unmasked().into_owned(), raw);
        let usable = |channel: &Channel| channel.quality.iter().filter(|q| q.is_usable()).count();
        assert_eq!(usable(&found.op), N - found.op.masked.len());
        found.masked_values().iter().map(|m| (m.signal, m.value, m.count, m.kind)).collect()
    }

    #[test]
    fn codes_are_masked_wherever_they_are() {
        use MaskedKind::Code;
        for code in [-9999.0, 9999.0, -999.25, 1e31, 327.67, -32768.0, 65535.0, f64::MAX] {
            for (from, length) in [(0, 1), (N - 1, 1), (200, 1), (200, 7), (0, N / 5)] {
                for signal in 0..3 {
                    let name = ["OP", "PV", "SP"][signal];
                    let found = masked(|s| s[signal][from..from + length].fill(code));
                    assert_eq!(found, [(name, code, length, Code)], "{code} {from} {length}");
                }
            }
        }
        let found = masked(|[op, pv, _]| {
            (pv[10], pv[11], pv[300], op[10], op[599]) = (-9999.0, 32767.0, -9999.0, 1e38, -9999.0);
        });
        let expected = [
            ("OP", -9999.0, 1, Code),
            ("OP", 1e38, 1, Code),
            ("PV", -9999.0, 2, Code),
            ("PV", 32767.0, 1, Code),
        ];
        assert_eq!(found, expected);
        // As single precision stores it.
        let single = f64::from(327.67f32);
        assert_eq!(masked(|s| s[1][50] = single), [("PV", single, 1, Code)]);
    }

    #[test]
    fn isolated_and_flat_values_far_outside_are_masked() {
        use MaskedKind::{FlatLine, Spike};
        assert_eq!(masked(|s| s[1][50] = 150.0), [("PV", 150.0, 1, Spike)]);
        assert_eq!(masked(|s| s[0][50] = -300.0), [("OP", -300.0, 1, Spike)]);
        assert_eq!(masked(|s| s[1][50..60].fill(-500.0)), [("PV", -500.0, 10, FlatLine)]);
        // A few times the usual swing is an upset, and one that lasts is a movement.
        assert_eq!(masked(|s| s[1][50] = 80.0), []);
        assert_eq!(masked(|s| (s[1][50], s[1][51]) = (150.0, 120.0)), []);
        // A long and flat rest shows nothing by being flat.
        assert_eq!(
            masked(|s| {
                s[1].iter_mut().for_each(|v| *v = v.round());
                s[1][100..400].fill(60.0);
                s[1][450..460].fill(-500.0);
            }),
            []
        );
    }

    #[test]
    fn a_line_of_zeros_is_masked_if_the_set_point_or_the_output_shows_it() {
        use MaskedKind::Zeros;
        let found = masked(|[op, pv, sp]| {
            for signal in [op, pv, sp] {
                signal[400..450].fill(0.0);
            }
        });
        assert_eq!(found, ["OP", "PV", "SP"].map(|name| (name, 0.0, 50, Zeros)));
        assert_eq!(masked(|s| s[1][400..450].fill(0.0)), [("PV", 0.0, 50, Zeros)]);
        assert_eq!(masked(|s| s[0][400..450].fill(0.0)), [], "a saturated output");
        // The set point went there, too.
        let stopped = masked(|[_, pv, sp]| {
            pv[400..].fill(0.0);
            sp[390..].fill(0.0);
        });
        assert_eq!(stopped, []);
        let ramp = masked(|[op, pv, _]| {
            for k in 0..50 {
                pv[400 + k] *= 1.0 - k as f64 / 50.0;
            }
            pv[450..500].fill(0.0);
            op[400..500].fill(0.0);
        });
        assert_eq!(ramp, []);
    }

    #[test]
    fn measurements_stay() {
        let all = |x: &mut [f64], f: &dyn Fn(f64) -> f64| x.iter_mut().for_each(|v| *v = f(*v));
        type Change<'a> = (&'a str, &'a dyn Fn(&mut [Vec<f64>; 3]));
        let cases: [Change<'_>; 12] = [
            ("as it is", &|_| {}),
            ("a step of the set point", &|[_, pv, sp]| {
                all(&mut pv[300..], &|v| v + 200.0);
                sp[300..].fill(260.0);
            }),
            ("a step without it", &|[_, pv, _]| all(&mut pv[300..], &|v| v + 200.0)),
            ("a set point near a code", &|[_, pv, sp]| {
                all(&mut pv[300..], &|v| v + 939.0);
                sp[300..].fill(999.0);
            }),
            ("an output at its limits", &|[op, ..]| {
                (op[40], op[90]) = (100.0, 0.0);
                op[200..300].fill(100.0);
            }),
            ("an output in counts at full scale", &|[op, ..]| {
                all(op, &|v| 276.48 * v);
                op[200] = 27648.0;
                op[300..350].fill(27648.0);
            }),
            ("values beside a code", &|[_, pv, sp]| {
                all(pv, &|v| (v + 9935.0).round());
                sp.fill(9995.0);
                pv[77] = 9999.0;
            }),
            ("counts at full scale", &|[_, pv, sp]| {
                all(pv, &|v| (65535.0 * ((v - 57.0) / 4.5).clamp(0.0, 1.0)).round());
                sp.fill(40000.0);
            }),
            ("counts at both ends", &|[_, pv, sp]| {
                all(pv, &|v| (40000.0 * (v - 60.0) / 2.0).clamp(-32768.0, 32767.0).round());
                sp.fill(0.0);
            }),
            ("two levels", &|[_, pv, _]| all(pv, &|v| if v > 61.9 { 80.0 } else { 40.0 })),
            ("hardly a movement", &|[_, pv, _]| {
                pv.fill(60.0);
                pv[77] = 61.0;
            }),
            ("no movement", &|[op, pv, sp]| {
                op.fill(9999.0);
                pv.fill(9999.0);
                sp.fill(9999.0);
            }),
        ];
        for (name, change) in cases {
            assert_eq!(masked(change), [], "{name}");
        }
    }

    #[test]
    fn a_given_range_protects_its_values() {
        let mut found = recording(&swinging());
        let pv = found.pv.as_mut().unwrap();
        pv.values[50] = 9999.0;
        pv.range =
            Some(super::super::Range::new(0.0, 1e4, super::super::RangeSource::Given).unwrap());
        assert!(found.masked().masked_values().is_empty());
        found.pv.as_mut().unwrap().mask_named(&[9999.0]);
        assert_eq!(found.masked_values()[0].kind, MaskedKind::Named);
        assert_eq!(found.unmasked().masked_values().len(), 1);
    }

    #[test]
    fn a_part_keeps_what_is_masked_in_it() {
        let mut whole = recording(&swinging());
        let pv = whole.pv.as_mut().unwrap();
        (pv.values[50], pv.values[350]) = (-9999.0, -9999.0);
        whole.mask();
        let count = |part: &Recording| part.masked_values().iter().map(|m| m.count).sum::<usize>();
        let parts = whole.split(300.0).unwrap();
        assert_eq!(parts.iter().map(count).collect::<Vec<_>>(), [1, 1]);
    }

    #[test]
    fn words_name_signals_and_values() {
        let mut found = recording(&swinging());
        let pv = found.pv.as_mut().unwrap();
        for (k, value) in [-9999.0, -9999.0, 1e31, 327.67, -999.25].into_iter().enumerate() {
            pv.values[100 + 9 * k] = value;
        }
        found.op.values[7] = -9999.0;
        let words = Masked::words(&found.masked().masked_values()).unwrap();
        assert_eq!(
            words,
            "1 value of the OP (-9999) and 5 values of the PV (-9999, -999.25, 327.67 and 1 more)"
        );
        assert_eq!(Masked::words(&[]), None);
    }
}
