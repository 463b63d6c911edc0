//! Motion under the laws that hold the stem still: classical, Karnopp, Armstrong.
//!
//! The stem is held, breaking away (Karnopp's band only), or sliding. Each mode lasts until a located event, which
//! determines the next mode, so nothing chatters.

use super::body::{Body, Progress, Recorder, State, delayed, direction_of};
use super::equations::{self, Equations, STATES};
use super::linear::{Forcing, LinearFlow, Oscillator};
use super::pressure::Drive;
use super::response::EventKind;
use super::sticking_law::StickingLaw;
use crate::error::Result;
use crate::numeric::radau::{self, GUARDS, Step, System, Tolerance};
use crate::numeric::roots::{crossing, first_fall};
use crate::valve::Direction;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    Held,
    Breaking(Direction),
    Sliding(Direction),
}

/// The equations of a slip: displacement and velocity since its start.
struct Slide<'a> {
    body: &'a Body,
    law: &'a mut StickingLaw,
    drive: &'a Drive,
    net_n: f64,
    sign: f64,
    level: f64,
    room_m: f64,
    start_s: f64,
}

impl System<2> for Slide<'_> {
    fn rate(&self, s: f64, y: &[f64; 2]) -> [f64; 2] {
        let [moved_m, velocity] = *y;
        let stem = &self.body.stem;
        let remembered = self.law.remembered(self.start_s + s, velocity);
        let force_n = self.net_n + stem.area_m2 * self.drive.rise(s)
            - stem.spring_n_per_m * moved_m
            - self.law.sliding_n(self.sign, velocity, remembered);
        [velocity, force_n / stem.mass_kg]
    }

    fn jacobian(&self, _s: f64, y: &[f64; 2]) -> [[f64; 2]; 2] {
        let stem = &self.body.stem;
        let slope = self.law.sliding_slope(self.sign, y[1]);
        [[0.0, 1.0], [-stem.spring_n_per_m / stem.mass_kg, -slope / stem.mass_kg]]
    }

    fn guards(&self, y: &[f64; 2]) -> [f64; GUARDS] {
        let mut guards = [f64::INFINITY; GUARDS];
        guards[0] = speed_left(self.body, self.sign * y[1], self.level);
        guards[1] = self.room_m - self.sign * y[0];
        guards
    }

    /// Armstrong's memory must be known when a step begins. The onset of the slip, remembered after one memory time
    /// and again after the next, must fall between steps.
    fn longest_step(&self, s: f64) -> f64 {
        let memory_s = self.law.memory_s();
        if memory_s == 0.0 {
            return f64::INFINITY;
        }
        let left = memory_s - s % memory_s;
        if left > 1e-6 * memory_s { left } else { memory_s }
    }

    fn accepted(&mut self, step: &Step<2>) {
        self.law.remember(self.start_s + step.start, step);
    }
}

/// Distance of the speed from `level`. A fall below the solver's resolution does not count.
fn speed_left(body: &Body, speed: f64, level: f64) -> f64 {
    speed - level + 1e-2 * body.resolution_m()
}

/// The stem between two moments.
#[derive(Debug, Clone)]
pub(super) struct StickSlip {
    body: Body,
    law: StickingLaw,
    mode: Mode,
    position_m: f64,
    velocity_m_per_s: f64,
}

/// The end of a mode: its time, and the net force then.
struct Ended {
    elapsed: f64,
    net_n: f64,
}

impl StickSlip {
    /// At rest.
    pub(super) fn new(body: Body, law: StickingLaw, position_m: f64) -> Self {
        Self { body, law, mode: Mode::Held, position_m, velocity_m_per_s: 0.0 }
    }

    pub(super) fn position_m(&self) -> f64 {
        self.position_m
    }

    /// The state at `time_s`, when `drive` begins.
    pub(super) fn state(&self, drive: &Drive, time_s: f64) -> State {
        let (velocity_m_per_s, friction_n) = match self.mode {
            Mode::Sliding(direction) => {
                let velocity = self.velocity_m_per_s;
                let remembered = self.law.remembered(time_s, velocity);
                (velocity, self.law.sliding_n(direction.sign(), velocity, remembered))
            }
            Mode::Held | Mode::Breaking(_) => {
                (0.0, self.law.held_n(self.body.net_n(drive, self.position_m)))
            }
        };
        let pressure_pa = drive.pressure_pa;
        State { position_m: self.position_m, velocity_m_per_s, friction_n, pressure_pa }
    }

    /// Continues for `duration` from `time_s`, driven by `drive`.
    pub(super) fn advance(
        &mut self,
        drive: &Drive,
        time_s: f64,
        duration: f64,
        recorder: &mut Recorder<'_>,
    ) -> Result<()> {
        let end_s = time_s + duration;
        let mut time_s = time_s;
        let mut drive = *drive;
        let mut progress = Progress::default();
        self.settle_presliding(&drive);
        let mut net_n = self.body.net_n(&drive, self.position_m);
        while time_s < end_s {
            let left = end_s - time_s;
            let ended = match self.mode {
                Mode::Held => self.hold(&drive, net_n, time_s, left, recorder),
                Mode::Breaking(direction) => {
                    self.break_away(&drive, net_n, direction, time_s, left, recorder)
                }
                Mode::Sliding(direction) => {
                    self.slide(&drive, net_n, direction, time_s, left, recorder)?
                }
            };
            let Some(ended) = ended else { return Ok(()) };
            time_s += ended.elapsed;
            progress.note(ended.elapsed, time_s)?;
            drive = drive.later(ended.elapsed);
            net_n = ended.net_n;
        }
        Ok(())
    }

    /// Moves a presliding stem to the balance of its springs and the pressure, which may have jumped.
    fn settle_presliding(&mut self, drive: &Drive) {
        let Some(anchor_m) = self.law.anchor_m() else { return };
        if self.mode != Mode::Held || self.at_end_stop() {
            return;
        }
        let net_n = self.body.net_n(drive, anchor_m);
        let stiffness = self.law.presliding_n_per_m() + self.body.stem.spring_n_per_m;
        let position_m = anchor_m + net_n / stiffness;
        self.position_m = self.body.within(position_m);
    }

    fn at_end_stop(&self) -> bool {
        self.body.blocked(self.position_m, Direction::Up)
            || self.body.blocked(self.position_m, Direction::Down)
    }

    /// Stays at rest until the net force exceeds static friction in a direction that is free.
    fn hold(
        &mut self,
        drive: &Drive,
        net_n: f64,
        time_s: f64,
        left: f64,
        recorder: &mut Recorder<'_>,
    ) -> Option<Ended> {
        let area = self.body.stem.area_m2;
        // A presliding stem yields a little, and its own spring carries that share of the force.
        let yielding = if self.at_end_stop() {
            0.0
        } else {
            1.0 / (self.law.presliding_n_per_m() + self.body.stem.spring_n_per_m)
        };
        let carried = 1.0 - self.body.stem.spring_n_per_m * yielding;
        let held_n = |s: f64| net_n + carried * area * drive.rise(s);
        let breakaway = |direction: Direction| {
            if self.body.blocked(self.position_m, direction) {
                return None;
            }
            let margin = |s: f64| self.law.static_n(time_s + s) - direction.sign() * held_n(s);
            let turn = drive.turning_point();
            match &self.law {
                StickingLaw::Classical(_) => first_fall(margin, turn, left),
                // Rising friction against a lagged pressure may turn in between, so check more often.
                StickingLaw::Armstrong { .. } => {
                    let mut nodes: [f64; 64] =
                        std::array::from_fn(|i| left * ((i + 1) as f64 / 64.0).powi(3));
                    nodes[63] = turn.unwrap_or(left);
                    nodes.sort_unstable_by(f64::total_cmp);
                    first_fall(margin, nodes, left)
                }
            }
            .map(|s| (s, direction))
        };
        let up = breakaway(Direction::Up);
        let down = breakaway(Direction::Down);
        let first = [up, down].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));

        let lasted = first.map_or(left, |(s, _)| s);
        let (body, from_m) = (self.body, self.position_m);
        let place = |s: f64| body.within(from_m + yielding * area * drive.rise(s));
        recorder.until(time_s, time_s + lasted, |s| State {
            position_m: place(s),
            velocity_m_per_s: 0.0,
            friction_n: self.law.held_n(held_n(s)),
            pressure_pa: drive.pressure_pa + drive.rise(s),
        });
        self.position_m = place(lasted);
        let (elapsed, direction) = first?;
        if self.body.blocked(self.position_m, direction) {
            // Presliding has carried the stem to its end stop.
            recorder.event(time_s + elapsed, EventKind::EndStop, direction, self.position_m);
            let net_n = self.body.net_n(&drive.later(elapsed), self.position_m);
            return Some(Ended { elapsed, net_n });
        }
        // Exactly the threshold, without rounding, unless the pressure jumped beyond it.
        let limit_n = self.law.static_n(time_s + elapsed);
        let net_n = direction.sign() * limit_n.max(direction.sign() * held_n(elapsed));
        self.break_loose(direction, time_s + elapsed, recorder);
        Some(Ended { elapsed, net_n })
    }

    /// Static friction breaks in `direction`.
    fn break_loose(&mut self, direction: Direction, time_s: f64, recorder: &mut Recorder<'_>) {
        self.velocity_m_per_s = 0.0;
        self.law.break_loose(time_s);
        if self.law.band() > 0.0 {
            self.mode = Mode::Breaking(direction);
        } else {
            self.begin_slip(direction, time_s, recorder);
        }
    }

    fn begin_slip(&mut self, direction: Direction, time_s: f64, recorder: &mut Recorder<'_>) {
        self.mode = Mode::Sliding(direction);
        recorder.slips += 1;
        recorder.event(time_s, EventKind::Slip, direction, self.position_m);
    }

    /// Accumulates momentum within Karnopp's band without moving: `M v' = net - Fs`.
    fn break_away(
        &mut self,
        drive: &Drive,
        net_n: f64,
        direction: Direction,
        time_s: f64,
        left: f64,
        recorder: &mut Recorder<'_>,
    ) -> Option<Ended> {
        let area = self.body.stem.area_m2;
        let sign = direction.sign();
        let static_n = self.law.static_n(time_s);
        let excess = |s: f64| sign * (net_n + area * drive.rise(s)) - static_n;
        let speed = |s: f64| {
            let impulse = (sign * net_n - static_n) * s + sign * area * drive.rise_integral(s);
            sign * self.velocity_m_per_s + impulse / self.body.stem.mass_kg
        };
        // The speed turns where the excess vanishes: at most once on either side of the pressure's own turn.
        let middle = drive.turning_point().filter(|s| *s < left).unwrap_or(left);
        let turns = [(0.0, middle), (middle, left)]
            .map(|(from, to)| crossing(excess, from, to).unwrap_or(left));
        let freed = first_fall(|s| self.law.band() - speed(s), turns, left);
        let caught = first_fall(speed, turns, left);
        let first = match (freed, caught) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        let lasted = first.unwrap_or(left);
        recorder.until(time_s, time_s + lasted, |s| State {
            position_m: self.position_m,
            velocity_m_per_s: 0.0,
            friction_n: sign * static_n,
            pressure_pa: drive.pressure_pa + drive.rise(s),
        });
        let velocity_m_per_s = sign * speed(lasted);
        self.velocity_m_per_s = velocity_m_per_s;
        let elapsed = first?;
        if freed == first {
            self.leave_band(direction, time_s + elapsed, recorder);
        } else {
            self.fall_back();
        }
        Some(Ended { elapsed, net_n: net_n + area * drive.rise(elapsed) })
    }

    /// The stem has enough momentum to slip.
    fn leave_band(&mut self, direction: Direction, time_s: f64, recorder: &mut Recorder<'_>) {
        self.velocity_m_per_s = direction.sign() * self.law.band();
        self.begin_slip(direction, time_s, recorder);
    }

    /// The stem loses its momentum before it slips.
    fn fall_back(&mut self) {
        self.velocity_m_per_s = 0.0;
        self.mode = Mode::Held;
    }

    /// Slides until the speed falls to zero (or to Karnopp's band), or an end stop is met.
    fn slide(
        &mut self,
        drive: &Drive,
        net_n: f64,
        direction: Direction,
        time_s: f64,
        left: f64,
        recorder: &mut Recorder<'_>,
    ) -> Result<Option<Ended>> {
        let from_m = self.position_m;
        let slid = match self.exact_flow(drive, net_n, direction) {
            Some(flow) => self.slide_exactly(&flow, drive, direction, time_s, left, recorder),
            None => self.slide_stepwise(drive, net_n, direction, time_s, left, recorder)?,
        };
        self.position_m = self.body.within(from_m + slid.displacement_m);
        self.velocity_m_per_s = slid.velocity_m_per_s;
        let Some(end) = slid.end else { return Ok(None) };

        let elapsed = slid.elapsed;
        if end == SlideEnd::EndStop {
            self.position_m = self.body.stop_m(direction);
        }
        let moved_m = self.position_m - from_m;
        let area = self.body.stem.area_m2;
        let net_n = net_n + area * drive.rise(elapsed) - self.body.stem.spring_n_per_m * moved_m;
        self.end_slide(end, direction, net_n, time_s + elapsed, recorder);
        Ok(Some(Ended { elapsed, net_n }))
    }

    /// The mode after a slide that ended under this net force.
    fn end_slide(
        &mut self,
        end: SlideEnd,
        direction: Direction,
        net_n: f64,
        now_s: f64,
        recorder: &mut Recorder<'_>,
    ) {
        let kind = match end {
            SlideEnd::EndStop => EventKind::EndStop,
            SlideEnd::Slow => EventKind::Stop,
        };
        self.velocity_m_per_s = 0.0;
        self.law.come_to_rest(now_s, self.position_m, net_n);
        let heading = direction_of(net_n);
        let held = net_n.abs() <= self.law.static_n(now_s);
        if kind == EventKind::EndStop || held || self.body.blocked(self.position_m, heading) {
            self.mode = Mode::Held;
            recorder.event(now_s, kind, direction, self.position_m);
        } else if self.law.band() > 0.0 {
            self.mode = Mode::Breaking(heading);
            recorder.event(now_s, kind, direction, self.position_m);
        } else {
            self.mode = Mode::Sliding(heading);
            recorder.slips += 1;
            recorder.event(now_s, EventKind::Reversal, heading, self.position_m);
        }
    }

    /// The closed solution, if friction is constant except for its viscous part.
    fn exact_flow(&self, drive: &Drive, net_n: f64, direction: Direction) -> Option<LinearFlow> {
        let StickingLaw::Classical(law) = &self.law else { return None };
        let steady = law.steady();
        if steady.stribeck_m_per_s() > 0.0 && steady.static_n() > steady.coulomb_n() {
            return None;
        }
        let stem = &self.body.stem;
        let body = Oscillator {
            mass: stem.mass_kg,
            damping: steady.viscous_n_s_per_m(),
            spring: stem.spring_n_per_m,
        };
        let forcing = Forcing {
            net: net_n - direction.sign() * steady.coulomb_n(),
            slope: stem.area_m2 * drive.slope,
            settling: stem.area_m2 * drive.decaying,
            decay: drive.decay,
        };
        LinearFlow::new(body, forcing, self.velocity_m_per_s)
    }

    fn slide_exactly(
        &self,
        flow: &LinearFlow,
        drive: &Drive,
        direction: Direction,
        time_s: f64,
        left: f64,
        recorder: &mut Recorder<'_>,
    ) -> Slid {
        let sign = direction.sign();
        let slow = flow.velocity_falls(sign, self.law.band(), left);
        let room = self.body.room_m(self.position_m, direction);
        // Up to that point the stem moves in one direction, so it meets an end stop at most once.
        let until = slow.unwrap_or(left);
        let met = first_fall(|s| room - sign * flow.displacement(s), [], until);
        let elapsed = met.unwrap_or(until);
        recorder.until(time_s, time_s + elapsed, |s| {
            let velocity = flow.velocity(s);
            State {
                position_m: self.body.within(self.position_m + flow.displacement(s)),
                velocity_m_per_s: velocity,
                friction_n: self.law.sliding_n(sign, velocity, velocity),
                pressure_pa: drive.pressure_pa + drive.rise(s),
            }
        });
        Slid {
            elapsed,
            displacement_m: flow.displacement(elapsed),
            velocity_m_per_s: flow.velocity(elapsed),
            end: if met.is_some() { Some(SlideEnd::EndStop) } else { slow.map(|_| SlideEnd::Slow) },
        }
    }

    fn slide_stepwise(
        &mut self,
        drive: &Drive,
        net_n: f64,
        direction: Direction,
        time_s: f64,
        left: f64,
        recorder: &mut Recorder<'_>,
    ) -> Result<Slid> {
        let sign = direction.sign();
        let from_m = self.position_m;
        let level = self.law.band();
        let resolution = self.body.resolution_m();
        let tolerance =
            Tolerance { relative: self.body.tolerance, absolute: [resolution, resolution] };
        let mut system = Slide {
            body: &self.body,
            law: &mut self.law,
            drive,
            net_n,
            sign,
            level,
            room_m: self.body.room_m(from_m, direction),
            start_s: time_s,
        };
        let outcome = radau::integrate(
            &mut system,
            [0.0, self.velocity_m_per_s],
            left,
            &tolerance,
            |system, step| {
                recorder.until(time_s, time_s + step.start + step.length, |s| {
                    let [moved_m, velocity] = step.at(s);
                    let remembered = system.law.remembered(time_s + s, velocity);
                    State {
                        position_m: system.body.within(from_m + moved_m),
                        velocity_m_per_s: velocity,
                        friction_n: system.law.sliding_n(sign, velocity, remembered),
                        pressure_pa: drive.pressure_pa + drive.rise(s),
                    }
                });
            },
        )
        .map_err(|e| delayed(e, time_s))?;
        Ok(Slid {
            elapsed: outcome.elapsed,
            displacement_m: outcome.y[0],
            velocity_m_per_s: outcome.y[1],
            end: outcome.guard.map(|guard| match guard {
                0 => SlideEnd::Slow,
                _ => SlideEnd::EndStop,
            }),
        })
    }
}

impl Equations for StickSlip {
    fn order(&self) -> Option<usize> {
        // Armstrong's presliding has no inertia, and its memory has infinitely many states.
        matches!(self.law, StickingLaw::Classical(_)).then_some(2)
    }

    fn states(&self) -> [f64; STATES] {
        [self.position_m, self.velocity_m_per_s, 0.0, 0.0, 0.0]
    }

    fn place(&mut self, states: &[f64; STATES]) {
        [self.position_m, self.velocity_m_per_s, ..] = *states;
    }

    fn rates(&self, drive: &Drive, time_s: f64) -> [f64; STATES] {
        let velocity = self.velocity_m_per_s;
        let (moving, friction_n) = match self.mode {
            Mode::Held => return [0.0; STATES],
            Mode::Breaking(direction) => (0.0, direction.sign() * self.law.static_n(time_s)),
            Mode::Sliding(direction) => {
                (1.0, self.law.sliding_n(direction.sign(), velocity, velocity))
            }
        };
        let force_n = self.body.net_n(drive, self.position_m) - friction_n;
        [moving * velocity, force_n / self.body.stem.mass_kg, 0.0, 0.0, 0.0]
    }

    fn guards(&self, drive: &Drive, time_s: f64) -> [f64; equations::GUARDS] {
        let mut guards = [f64::INFINITY; equations::GUARDS];
        let velocity = self.velocity_m_per_s;
        match self.mode {
            Mode::Held => {
                let net_n = self.body.net_n(drive, self.position_m);
                for (guard, direction) in guards.iter_mut().zip([Direction::Up, Direction::Down]) {
                    if !self.body.blocked(self.position_m, direction) {
                        *guard = self.law.static_n(time_s) - direction.sign() * net_n;
                    }
                }
            }
            Mode::Breaking(direction) => {
                guards[0] = self.law.band() - direction.sign() * velocity;
                guards[1] = speed_left(&self.body, direction.sign() * velocity, 0.0);
            }
            Mode::Sliding(direction) => {
                guards[0] = speed_left(&self.body, direction.sign() * velocity, self.law.band());
                guards[1] = self.body.room_m(self.position_m, direction);
            }
        }
        guards
    }

    fn pass(&mut self, guard: usize, drive: &Drive, time_s: f64, recorder: &mut Recorder<'_>) {
        match (self.mode, guard) {
            (Mode::Held, 0) => self.break_loose(Direction::Up, time_s, recorder),
            (Mode::Held, _) => self.break_loose(Direction::Down, time_s, recorder),
            (Mode::Breaking(direction), 0) => self.leave_band(direction, time_s, recorder),
            (Mode::Breaking(_), _) => self.fall_back(),
            (Mode::Sliding(direction), guard) => {
                let end = if guard == 0 { SlideEnd::Slow } else { SlideEnd::EndStop };
                self.position_m = match end {
                    SlideEnd::EndStop => self.body.stop_m(direction),
                    SlideEnd::Slow => self.body.within(self.position_m),
                };
                let net_n = self.body.net_n(drive, self.position_m);
                self.end_slide(end, direction, net_n, time_s, recorder);
            }
        }
    }

    fn is_stuck(&self) -> bool {
        !matches!(self.mode, Mode::Sliding(_))
    }

    fn remember(&self, memory: &mut Vec<f64>) {
        let mode = match self.mode {
            Mode::Held => 0.0,
            Mode::Breaking(direction) => direction.sign(),
            Mode::Sliding(direction) => 2.0 * direction.sign(),
        };
        memory.extend([self.position_m, self.velocity_m_per_s, mode]);
        self.law.remember_all(memory);
    }

    fn recall(&mut self, memory: &mut dyn Iterator<Item = f64>) -> Option<()> {
        self.position_m = memory.next()?;
        self.velocity_m_per_s = memory.next()?;
        let mode = memory.next()?;
        self.mode = match mode.abs() {
            1.0 => Mode::Breaking(direction_of(mode)),
            2.0 => Mode::Sliding(direction_of(mode)),
            _ => Mode::Held,
        };
        self.law.recall(memory)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SlideEnd {
    Slow,
    EndStop,
}

struct Slid {
    elapsed: f64,
    displacement_m: f64,
    velocity_m_per_s: f64,
    end: Option<SlideEnd>,
}
