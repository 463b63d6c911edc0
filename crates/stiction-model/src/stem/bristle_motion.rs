//! Motion under the laws with bristles: Dahl, LuGre, GMS.
//!
//! The stem never sticks fully, so its motion is one smooth stiff flow between reversals of velocity, changes
//! inside a GMS law, and contacts with an end stop.

use super::body::{Body, Progress, Recorder, State, delayed, direction_of};
use super::equations::{self, Equations, STATES};
use super::friction::bristle::{BristleLaw, ELEMENTS};
use super::pressure::Drive;
use super::response::EventKind;
use crate::error::Result;
use crate::numeric::radau::{self, GUARDS, System, Tolerance};
use crate::numeric::roots::first_fall;
use crate::valve::Direction;

/// The guard of the [`Gait`], the last.
const GAIT: usize = equations::GUARDS - 1;

/// The stem between two moments; `state` is position, velocity, deflections.
#[derive(Debug, Clone)]
pub(super) struct BristleMotion<L, const N: usize> {
    body: Body,
    law: L,
    state: [f64; N],
    direction: Direction,
    /// Pressed against an end stop.
    held: bool,
    gait: Gait,
}

/// Whether a stem on bristles counts as stuck or as moving; this does not affect its motion.
///
/// It moves once it has left its position by more than the bristles yield, and faster than creep. It is stuck again
/// once its speed has fallen to half of that.
#[derive(Debug, Clone, Copy)]
struct Gait {
    moves: bool,
    /// Last stuck position, m.
    place_m: f64,
    /// Yield of the bristles from end to end, m.
    yield_m: f64,
    /// The speed of creep, m/s.
    creep_m_per_s: f64,
}

impl Gait {
    fn new(body: &Body, place_m: f64, deflection_m: f64) -> Self {
        /// Strokes per second: this project's choice.
        const CREEP: f64 = 1e-3;
        Self {
            moves: false,
            place_m,
            yield_m: 2.0 * deflection_m,
            creep_m_per_s: CREEP * body.stem.stroke_m,
        }
    }

    /// At least 0 until it changes.
    fn guard(self, position_m: f64, velocity_m_per_s: f64) -> f64 {
        let speed = velocity_m_per_s.abs() / self.creep_m_per_s;
        if self.moves {
            return speed - 0.5;
        }
        let away = (position_m - self.place_m).abs() / self.yield_m;
        (1.0 - away).max(1.0 - speed)
    }

    fn change(&mut self, position_m: f64, recorder: &mut Recorder<'_>) {
        self.moves = !self.moves;
        if self.moves {
            recorder.slips += 1;
        } else {
            self.place_m = position_m;
        }
    }

    fn note(&mut self, position_m: f64, velocity_m_per_s: f64, recorder: &mut Recorder<'_>) {
        if self.guard(position_m, velocity_m_per_s) < 0.0 {
            self.change(position_m, recorder);
        }
    }
}

impl<L: BristleLaw<N>, const N: usize> BristleMotion<L, N> {
    /// At rest with bristles that carry the net force at `drive` as far as they can, or relaxed.
    pub(super) fn new(body: Body, law: L, position_m: f64, drive: &Drive, balanced: bool) -> Self {
        let carried_n = if balanced { body.net_n(drive, position_m) } else { 0.0 };
        let mut state = law.carrying(carried_n);
        state[0] = position_m;
        // Unused elements have any scale.
        let scales = law.deflection_scale().into_iter().skip(2);
        let deflection_m = scales.filter(|scale| *scale < body.stem.stroke_m).fold(0.0, f64::max);
        let gait = Gait::new(&body, position_m, deflection_m);
        Self { body, law, state, direction: Direction::Up, held: false, gait }
    }

    pub(super) fn position_m(&self) -> f64 {
        self.state[0]
    }

    /// The state when `drive` begins.
    pub(super) fn state(&self, drive: &Drive) -> State {
        State {
            position_m: self.state[0],
            velocity_m_per_s: self.state[1],
            friction_n: self.law.response(&self.state, self.direction.sign()).force_n,
            pressure_pa: drive.pressure_pa,
        }
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
        self.take_direction(&drive);
        while time_s < end_s {
            let left = end_s - time_s;
            let elapsed = if self.held {
                self.hold(&drive, time_s, left, recorder)
            } else {
                self.flow(&drive, time_s, left, recorder)?
            };
            let Some(elapsed) = elapsed else { return Ok(()) };
            time_s += elapsed;
            progress.note(elapsed, time_s)?;
            drive = drive.later(elapsed);
        }
        Ok(())
    }

    /// Net force less friction, N.
    fn surplus_n(&self, drive: &Drive) -> f64 {
        let friction_n = self.law.response(&self.state, self.direction.sign()).force_n;
        self.body.net_n(drive, self.state[0]) - friction_n
    }

    /// Direction of motion of a stem at rest when the pressure takes a new course.
    fn take_direction(&mut self, drive: &Drive) {
        if self.held || self.state[1].abs() > self.body.resolution_m() {
            return;
        }
        let surplus_n = self.surplus_n(drive);
        self.direction = direction_of(if surplus_n == 0.0 { drive.slope } else { surplus_n });
        if self.body.blocked(self.state[0], self.direction) {
            self.state[1] = 0.0;
            self.held = true;
        }
    }

    /// Stays at the end stop in `direction` until the net force pulls away from it.
    fn hold(
        &mut self,
        drive: &Drive,
        time_s: f64,
        left: f64,
        recorder: &mut Recorder<'_>,
    ) -> Option<f64> {
        let area = self.body.stem.area_m2;
        let surplus_n = self.surplus_n(drive);
        let pressed = |s: f64| self.direction.sign() * (surplus_n + area * drive.rise(s));
        let freed = first_fall(pressed, drive.turning_point(), left);
        let state = self.state(drive);
        recorder.until(time_s, time_s + freed.unwrap_or(left), |s| State {
            pressure_pa: drive.pressure_pa + drive.rise(s),
            ..state
        });
        let elapsed = freed?;
        self.leave_stop(time_s + elapsed, recorder);
        Some(elapsed)
    }

    /// Moves until the velocity changes sign, an element slips, or an end stop is met.
    fn flow(
        &mut self,
        drive: &Drive,
        time_s: f64,
        left: f64,
        recorder: &mut Recorder<'_>,
    ) -> Result<Option<f64>> {
        let resolution = self.body.resolution_m();
        let mut absolute = self.law.deflection_scale().map(|scale| scale * self.body.tolerance);
        absolute[0] = resolution;
        absolute[1] = resolution;
        let tolerance = Tolerance { relative: self.body.tolerance, absolute };
        let sign = self.direction.sign();
        let mut gait = self.gait;
        let mut system =
            Flow { body: &self.body, law: &self.law, drive, direction: self.direction };
        let outcome =
            radau::integrate(&mut system, self.state, left, &tolerance, |system, step| {
                recorder.until(time_s, time_s + step.start + step.length, |s| {
                    let y = step.at(s);
                    State {
                        position_m: system.body.within(y[0]),
                        velocity_m_per_s: y[1],
                        friction_n: system.law.response(&y, sign).force_n,
                        pressure_pa: drive.pressure_pa + drive.rise(s),
                    }
                });
                let [position_m, velocity_m_per_s, ..] = step.at(step.start + step.length)[..]
                else {
                    return;
                };
                gait.note(position_m, velocity_m_per_s, recorder);
            })
            .map_err(|e| delayed(e, time_s))?;
        self.state = outcome.y;
        self.gait = gait;
        let Some(guard) = outcome.guard else { return Ok(None) };
        self.pass_guard(guard, time_s + outcome.elapsed, recorder);
        Ok(Some(outcome.elapsed))
    }

    /// The next mode once a guard of the flow has fallen below 0.
    fn pass_guard(&mut self, guard: usize, now_s: f64, recorder: &mut Recorder<'_>) {
        match guard {
            0 => {
                // The condition of the guard, without the solver's noise, so that it holds next time.
                self.state[1] = -self.direction.sign() * self.body.resolution_m();
                self.direction = opposite(self.direction);
                self.law.stick_all();
                recorder.event(now_s, EventKind::Reversal, self.direction, self.state[0]);
            }
            1 => {
                self.state[0] = self.body.stop_m(self.direction);
                self.state[1] = 0.0;
                self.held = true;
                self.gait.note(self.state[0], 0.0, recorder);
                self.law.stick_all();
                recorder.event(now_s, EventKind::EndStop, self.direction, self.state[0]);
            }
            element => self.law.loosen(element - 2),
        }
    }

    /// The force away from the end stop exceeds the force that holds the stem there.
    fn leave_stop(&mut self, now_s: f64, recorder: &mut Recorder<'_>) {
        self.held = false;
        self.direction = opposite(self.direction);
        recorder.event(now_s, EventKind::Slip, self.direction, self.state[0]);
    }

    /// The equations of motion in the present direction.
    fn flow_equations<'a>(&'a self, drive: &'a Drive) -> Flow<'a, L> {
        Flow { body: &self.body, law: &self.law, drive, direction: self.direction }
    }
}

impl<L: BristleLaw<N>, const N: usize> Equations for BristleMotion<L, N> {
    fn order(&self) -> Option<usize> {
        Some(N)
    }

    fn states(&self) -> [f64; STATES] {
        let mut states = [0.0; STATES];
        states[..N].copy_from_slice(&self.state);
        states
    }

    fn place(&mut self, states: &[f64; STATES]) {
        self.state.copy_from_slice(&states[..N]);
    }

    fn rates(&self, drive: &Drive, _time_s: f64) -> [f64; STATES] {
        let mut rates = [0.0; STATES];
        if !self.held {
            rates[..N].copy_from_slice(&self.flow_equations(drive).rate(0.0, &self.state));
        }
        rates
    }

    fn guards(&self, drive: &Drive, _time_s: f64) -> [f64; equations::GUARDS] {
        let mut guards = [f64::INFINITY; equations::GUARDS];
        if self.held {
            guards[0] = self.direction.sign() * self.surplus_n(drive);
        } else {
            guards[..GUARDS].copy_from_slice(&self.flow_equations(drive).guards(&self.state));
            guards[GAIT] = self.gait.guard(self.state[0], self.state[1]);
        }
        guards
    }

    fn pass(&mut self, guard: usize, _drive: &Drive, time_s: f64, recorder: &mut Recorder<'_>) {
        if guard == GAIT {
            self.gait.change(self.state[0], recorder);
        } else if self.held {
            self.leave_stop(time_s, recorder);
        } else {
            self.pass_guard(guard, time_s, recorder);
        }
    }

    fn is_stuck(&self) -> bool {
        !self.gait.moves
    }

    fn begin(&mut self, drive: &Drive) {
        self.take_direction(drive);
    }

    fn remember(&self, memory: &mut Vec<f64>) {
        memory.extend(self.state);
        memory.extend([self.direction.sign(), f64::from(u8::from(self.held))]);
        memory.extend([f64::from(u8::from(self.gait.moves)), self.gait.place_m]);
        memory.extend(self.law.slipping().map(|slips| f64::from(u8::from(slips))));
    }

    fn recall(&mut self, memory: &mut dyn Iterator<Item = f64>) -> Option<()> {
        for state in &mut self.state {
            *state = memory.next()?;
        }
        self.direction = direction_of(memory.next()?);
        self.held = memory.next()? != 0.0;
        self.gait.moves = memory.next()? != 0.0;
        self.gait.place_m = memory.next()?;
        self.law.stick_all();
        for element in 0..ELEMENTS {
            if memory.next()? != 0.0 {
                self.law.loosen(element);
            }
        }
        Some(())
    }
}

fn opposite(direction: Direction) -> Direction {
    match direction {
        Direction::Up => Direction::Down,
        Direction::Down => Direction::Up,
    }
}

/// The equations of motion in one direction.
struct Flow<'a, L> {
    body: &'a Body,
    law: &'a L,
    drive: &'a Drive,
    direction: Direction,
}

impl<L: BristleLaw<N>, const N: usize> System<N> for Flow<'_, L> {
    fn rate(&self, s: f64, y: &[f64; N]) -> [f64; N] {
        let stem = &self.body.stem;
        let response = self.law.response(y, self.direction.sign());
        let pressure_pa = self.drive.pressure_pa + self.drive.rise(s);
        let mut rate = response.rates;
        rate[0] = y[1];
        rate[1] = (stem.net_force_n(pressure_pa, y[0]) - response.force_n) / stem.mass_kg;
        rate
    }

    fn jacobian(&self, _s: f64, y: &[f64; N]) -> [[f64; N]; N] {
        let stem = &self.body.stem;
        let gradient = self.law.gradient(y, self.direction.sign());
        let mut jacobian = gradient.rates;
        jacobian[0][1] = 1.0;
        jacobian[1] = gradient.force.map(|by| -by / stem.mass_kg);
        jacobian[1][0] -= stem.spring_n_per_m / stem.mass_kg;
        jacobian
    }

    fn guards(&self, y: &[f64; N]) -> [f64; GUARDS] {
        let sign = self.direction.sign();
        let mut guards = [f64::INFINITY; GUARDS];
        // A velocity below the solver's resolution is not a reversal.
        guards[0] = sign * y[1] + self.body.resolution_m();
        guards[1] = self.body.room_m(y[0], self.direction);
        guards[2..2 + ELEMENTS].copy_from_slice(&self.law.stick_margins(y, sign));
        guards
    }
}
