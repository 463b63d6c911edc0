//! The motion of the loop from event to event.

use super::Trajectory;
use super::number::Number;
use super::plant::{Plant, STATES};
use super::series::Series;
use nalgebra::Complex;
use std::collections::VecDeque;

/// Behaviour of a stem at a slip, in units of `fs`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stem {
    /// It lands `fd` behind the OP and follows it until the OP turns.
    Follows { fd: f64 },
    /// It moves on by `jump` and sticks at once.
    Jumps { jump: f64 },
}

/// The VP over a segment until the next begins.
#[derive(Debug, Clone, Copy)]
enum Course<T> {
    Held(T),
    Following(Series<T>),
}

#[derive(Debug, Clone, Copy)]
struct Piece<T> {
    start: T,
    vp: Course<T>,
}

/// The highest and lowest values so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Range {
    const EMPTY: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };

    fn take(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }

    /// Includes all extremes of `signal` on `0..=end`.
    fn sweep(&mut self, signal: &Series<f64>, end: f64) {
        self.take(signal.0[0]);
        self.take(signal.at(end));
        let slope = signal.slope();
        for slope in [slope, slope.times(-1.0)] {
            // A segment has at most a few turns; each search continues behind the last one.
            let (mut from, mut rest) = (0.0, slope);
            for _ in 0..8 {
                let Some(s) = rest.rises(end - from) else { break };
                from += s;
                self.take(signal.at(from));
                rest = slope.from(from);
                rest.0[0] = rest.0[0].max(f64::MIN_POSITIVE);
            }
        }
    }
}

/// The ranges of the signals.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ranges {
    pub(super) op: Range,
    pub(super) vp: Range,
    pub(super) pv: Range,
}

/// Signals over time, in the units of the plant.
#[derive(Debug, Clone)]
struct Record {
    begin: f64,
    interval: f64,
    /// Number of samples, without samples at events.
    taken: usize,
    trajectory: Trajectory,
}

impl Record {
    fn take(&mut self, time: f64, op: f64, vp: f64, pv: f64) {
        let into = &mut self.trajectory;
        into.time_s.push(time - self.begin);
        into.op.push(op);
        into.vp.push(vp);
        into.pv.push(pv);
    }

    /// Adds the samples within a segment of `length` that begins at `time`, its end excluded.
    fn sweep(&mut self, time: f64, length: f64, signals: [&Series<f64>; 3]) {
        loop {
            let s = self.begin + self.taken as f64 * self.interval - time;
            if !(s < length) {
                return;
            }
            self.taken += 1;
            // The first is the slip itself.
            if self.taken > 1 {
                let [op, vp, pv] = signals.map(|signal| signal.at(s));
                self.take(time + s, op, vp, pv);
            }
        }
    }
}

/// The end of a segment of motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Event {
    /// The stem breaks away; it has not moved yet.
    Slips,
    /// Nothing moves any more.
    Rests { moving: bool },
    /// The signals have left every bound.
    Diverges,
    /// More steps than allowed.
    Exhausted,
}

/// The motion of a loop.
#[derive(Debug, Clone)]
pub(super) struct Flow<'a, T> {
    pub(super) plant: &'a Plant,
    stem: Stem,
    pub(super) time: T,
    pub(super) state: [T; STATES],
    /// The VP at the last slip or stop.
    pub(super) position: T,
    /// Direction of motion, 0 while stuck.
    motion: f64,
    /// Direction of the next slip if it is due, or else of the last one.
    pub(super) direction: f64,
    /// Time at which the stem began to stick.
    pub(super) stuck_since: T,
    /// Pieces of the VP, the first of them at `time - theta`.
    past: VecDeque<Piece<T>>,
    /// Remaining steps.
    pub(super) steps: usize,
    /// The last slip or stop.
    last_event: f64,
    pub(super) ranges: Option<Ranges>,
    record: Option<Box<Record>>,
    /// The states over the present segment.
    course: Vec<Series<T>>,
}

/// Nodes and weights of Gauss's quadrature with six nodes, on one side of the middle.
const GAUSS: [(f64, f64); 3] = [
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_35),
];

/// Limit of divergence, in units of `fs`.
const FAR: f64 = 1e5;
/// Largest speed of a loop at rest, per unit of time.
const REST: f64 = 1e-12;

impl<'a, T: Number> Flow<'a, T> {
    /// The stem stuck at `position` for longer than the dead time.
    pub(super) fn stuck(
        plant: &'a Plant,
        stem: Stem,
        state: [T; STATES],
        position: T,
        steps: usize,
    ) -> Self {
        let long_ago = T::of(-plant.dead_time - 1.0);
        let past = VecDeque::from([Piece { start: long_ago, vp: Course::Held(position) }]);
        Self {
            plant,
            stem,
            time: T::of(0.0),
            state,
            position,
            motion: 0.0,
            direction: 1.0,
            stuck_since: long_ago,
            past,
            steps,
            last_event: 0.0,
            ranges: None,
            record: None,
            course: vec![Series::constant(T::of(0.0)); plant.order],
        }
    }

    /// The stem about to slip upward, after it was stuck for longer than the dead time.
    pub(super) fn slipping(plant: &'a Plant, stem: Stem, state: [T; STATES], steps: usize) -> Self {
        let position = plant.op(&state) + T::of(-1.0);
        Self::stuck(plant, stem, state, position, steps)
    }

    /// Starts recording the ranges of the signals.
    pub(super) fn watch(&mut self) {
        let empty = Range::EMPTY;
        self.ranges = Some(Ranges { op: empty, vp: empty, pv: empty });
        self.note_position();
    }

    /// Starts recording the signals, every `interval` and at events.
    pub(super) fn record(&mut self, interval: f64) {
        let begin = self.time.value();
        let record = Record { begin, interval, taken: 0, trajectory: Trajectory::default() };
        self.record = Some(Box::new(record));
        self.take();
    }

    /// The recorded signals, in units, `op_unit` percent to 1.
    pub(super) fn recorded(self, op_unit: f64) -> Option<Trajectory> {
        let plant = self.plant;
        let Trajectory { time_s, op, vp, pv } = self.record?.trajectory;
        let scaled = |values: Vec<f64>, unit: f64, rest: f64| -> Vec<f64> {
            values.into_iter().map(|value| rest + unit * value).collect()
        };
        Some(Trajectory {
            time_s: scaled(time_s, plant.time_s, 0.0),
            op: scaled(op, op_unit, plant.op_rest),
            vp: scaled(vp, op_unit, plant.op_rest),
            pv: scaled(pv, plant.pv_unit, plant.pv_rest),
        })
    }

    /// Records the present values.
    fn take(&mut self) {
        let (time, op) = (self.time.value(), self.plant.op(&self.state).value());
        let (vp, pv) = (self.position.value(), self.state[0].value());
        if let Some(record) = &mut self.record {
            record.take(time, op, vp, pv);
        }
    }

    fn note_position(&mut self) {
        let position = self.position.value();
        if let Some(ranges) = &mut self.ranges {
            ranges.vp.take(position);
        }
    }

    /// Whether the process input equals the stem position, now and before.
    pub(super) fn is_clean(&self) -> bool {
        self.motion == 0.0
            && self.time.value() - self.stuck_since.value() >= self.plant.dead_time * (1.0 - 1e-12)
    }

    /// Scales the motion by `factor`, including its past.
    pub(super) fn enlarge(&mut self, factor: f64) {
        self.state = self.state.map(|w| w * factor);
        self.position = self.position * factor;
        for piece in &mut self.past {
            piece.vp = match &piece.vp {
                Course::Held(position) => Course::Held(*position * factor),
                Course::Following(series) => Course::Following(series.times(factor)),
            };
        }
    }

    /// The slip that is due.
    pub(super) fn slip(&mut self) {
        let op = self.plant.op(&self.state);
        let d = self.direction;
        match self.stem {
            Stem::Follows { fd } => {
                self.motion = d;
                self.position = op + T::of(-d * fd);
            }
            Stem::Jumps { jump } => {
                self.position = self.position + T::of(d * jump);
                self.stick();
            }
        }
        self.last_event = self.time.value();
        self.note_position();
        self.take();
    }

    fn stick(&mut self) {
        self.motion = 0.0;
        self.stuck_since = self.time;
        if self.plant.dead_time > 0.0 {
            self.past.push_back(Piece { start: self.time, vp: Course::Held(self.position) });
        }
        self.last_event = self.time.value();
        self.note_position();
    }

    /// Continues to the next slip, which is then due.
    pub(super) fn run_to_slip(&mut self) -> Event {
        let mut still = 0;
        while self.steps > 0 {
            self.steps -= 1;
            let before = self.state;
            let (length, slips) = self.step();
            if slips {
                return Event::Slips;
            }
            let (mut change, mut size) = (0f64, 0f64);
            for i in 0..self.plant.order {
                let now = self.state[i].value();
                change = change.max((now - before[i].value()).abs());
                size = size.max(now.abs());
            }
            let op = self.plant.op(&self.state).value();
            if !(op.abs() < FAR && self.position.value().abs() < FAR) {
                return Event::Diverges;
            }
            let patience = self.plant.dead_time + 10.0;
            let settled = change <= REST * length * size.clamp(1e-3, 1.0);
            still = if settled && length > 0.0 { still + 1 } else { 0 };
            if still > 2 && self.time.value() - self.last_event > patience {
                return Event::Rests { moving: self.motion != 0.0 };
            }
        }
        Event::Exhausted
    }

    /// The present VP at the process, and the end of that piece of it.
    fn delayed(&mut self) -> (Course<T>, Option<T>) {
        let delay = T::of(self.plant.dead_time);
        while let Some(next) = self.past.get(1) {
            if (next.start + delay).value() > self.time.value() {
                break;
            }
            self.past.pop_front();
        }
        let piece = &self.past[0];
        let vp = match &piece.vp {
            Course::Held(position) => Course::Held(*position),
            Course::Following(series) => {
                let into = self.time - delay - piece.start;
                Course::Following(if into.value() == 0.0 { *series } else { series.from(into) })
            }
        };
        (vp, self.past.get(1).map(|next| next.start + delay))
    }

    /// The integral of `e^(rate s) x` over the last dead time, with the VP `x` of `s` ago.
    pub(super) fn way(&self, rate: Complex<f64>) -> Complex<f64> {
        let now = self.time.value();
        let begin = now - self.plant.dead_time;
        let mut sum = Complex::new(0.0, 0.0);
        for (k, piece) in self.past.iter().enumerate() {
            let start = piece.start.value();
            let end = self.past.get(k + 1).map_or(now, |next| next.start.value());
            let from = start.max(begin);
            if !(end > from) {
                continue;
            }
            let parts = (rate.norm() * (end - from)).ceil().max(1.0);
            let half = 0.5 * (end - from) / parts;
            for part in 0..parts as usize {
                let middle = from + half * (2 * part + 1) as f64;
                for (node, share) in GAUSS {
                    for time in [middle - node * half, middle + node * half] {
                        let vp = match &piece.vp {
                            Course::Held(position) => position.value(),
                            Course::Following(series) => series.values().at(time - start),
                        };
                        sum += (rate * (now - time)).exp() * (vp * share * half);
                    }
                }
            }
        }
        sum
    }

    /// One segment without an event inside. Returns its length, and whether a slip is due at its end.
    fn step(&mut self) -> (f64, bool) {
        let instant = self.plant.dead_time == 0.0;
        let (seen, end) =
            if instant { (Course::Held(self.position), None) } else { self.delayed() };
        let following = match self.stem {
            Stem::Follows { fd } if self.motion != 0.0 => Some(self.motion * fd),
            _ => None,
        };
        let op = self.expand(&seen, following.filter(|_| instant));

        let mut length = self.reach();
        if following.is_some() && !instant {
            length = self.plant.dead_time.min(length);
        }
        let mut segment = T::of(length);
        if let Some(end) = end {
            let left = end - self.time;
            if left.value() <= length {
                (length, segment) = (left.value(), left);
            }
        }

        // Early ends: the OP turns, or leaves the band of the stuck stem.
        let mut event = None;
        if self.motion != 0.0 {
            let turning = op.slope().times(-self.motion);
            if let Some(s) = turning.values().rise(length) {
                event = Some((s, turning));
            }
        } else if op.range(length) + (op.0[0] + -self.position).value().abs() >= 1.0 {
            for direction in [1.0, -1.0] {
                let excess = op.plus(-self.position).times(direction).plus(T::of(-1.0));
                let within = event.map_or(length, |(s, _)| s);
                if let Some(s) = excess.values().rise(within) {
                    self.direction = direction;
                    event = Some((s, excess));
                }
            }
        }
        if let Some((s, signal)) = event {
            length = s;
            // One step of Newton's method in T: the value stays, the derivatives follow.
            segment = if s == 0.0 && signal.0[0].value() > Series::ROUNDING {
                T::of(0.0)
            } else {
                let at = T::of(s);
                at + signal.at(at) * (-1.0 / signal.slope().at(at).value())
            };
        }

        if let Some(offset) = following {
            // Also without dead time, because the ranges need it.
            let vp = op.plus(T::of(-offset));
            if !instant {
                self.past.push_back(Piece { start: self.time, vp: Course::Following(vp) });
            }
            self.position = vp.at(segment);
        }
        if let Some(record) = &mut self.record {
            let vp = match following {
                Some(offset) => op.plus(T::of(-offset)).values(),
                None => Series::constant(self.position.value()),
            };
            record.sweep(self.time.value(), length, [&op.values(), &vp, &self.course[0].values()]);
        }
        if let Some(ranges) = &mut self.ranges {
            ranges.op.sweep(&op.values(), length);
            ranges.pv.sweep(&self.course[0].values(), length);
        }
        for i in 0..self.plant.order {
            self.state[i] = self.course[i].at(segment);
        }
        self.time = self.time + segment;
        match event {
            None => (length, false),
            Some(_) => {
                self.take();
                let slips = self.motion == 0.0;
                if !slips {
                    self.stick();
                }
                (length, slips)
            }
        }
    }

    /// The states as power series, into `course`, and the OP; `closed` is the lag of a stem without dead time.
    fn expand(&mut self, seen: &Course<T>, closed: Option<f64>) -> Series<T> {
        let zero = T::of(0.0);
        let plant = self.plant;
        let n = plant.order;
        let mut op = Series::constant(zero);
        let mut w = self.state;
        for k in 0..=super::series::DEGREE {
            let u = plant.op(&w);
            op.0[k] = u;
            for i in 0..n {
                self.course[i].0[k] = w[i];
            }
            let input = match (closed, seen) {
                (Some(offset), _) => u + T::of(if k == 0 { -offset } else { 0.0 }),
                (None, Course::Held(position)) => {
                    if k == 0 {
                        *position
                    } else {
                        zero
                    }
                }
                (None, Course::Following(series)) => series.0[k],
            };
            let mut next = w;
            let inverse = 1.0 / (k + 1) as f64;
            for i in 0..n {
                let mut sum = input * plant.b[i];
                for j in 0..n {
                    sum = sum + w[j] * plant.a[i][j];
                }
                next[i] = sum * inverse;
            }
            w = next;
        }
        op
    }

    /// Valid length of a segment for the series in `course`: at least 1, and longer if their last terms allow it.
    fn reach(&self) -> f64 {
        const LONGEST: f64 = 8.0;
        // A term is then below the rounding of a double, and later ones are smaller.
        const NOTHING: f64 = 1e-17;
        let last = super::series::DEGREE;
        let (mut size, mut before, mut end) = (1f64, 0f64, 0f64);
        for state in &self.course {
            size = size.max(state.0[0].size());
            before = before.max(state.0[last - 1].size());
            end = end.max(state.0[last].size());
        }
        let within = |term: f64, power: usize| (NOTHING * size / term).powf(1.0 / power as f64);
        // A term of zero allows any length, and a NaN none beyond 1.
        let reach = within(before, last - 1).min(within(end, last));
        if reach > 1.0 { reach.min(LONGEST) } else { 1.0 }
    }
}
