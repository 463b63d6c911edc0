//! One closed loop, driven sample by sample from outside.

use super::bank::{Each, LoopBank, with_order};
use super::between::{Between, Wire};
use super::description::ClosedLoop;
use super::process::{DelayLine, ProcessBank};
use crate::error::{Error, Result, finite};
use crate::simd::Lane;
use crate::valve::{Assembly, Start, Valve};

/// A closed loop whose external signals are given one sample at a time.
///
/// It gives the same bits as [`ClosedLoop::run`], which runs the same code.
///
/// ```
/// use stiction_model::closed_loop::{ClosedLoop, Controller, Process};
/// use stiction_model::{Bands, valve::{Assembly, Model}};
///
/// let mut sticky = ClosedLoop::new(
///     Controller::pi(1.1, 2.5)?,
///     Assembly::new(Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0)?)?),
///     Process::first_order(1.5, 5.93, 1.07)?,
/// );
/// sticky.set_point = 5.0.into();
/// let run = sticky.run()?;
/// let mut player = sticky.player()?;
/// for k in 0..run.pv.len() {
///     let now = player.step(5.0, 0.0, 0.0)?;
///     assert_eq!((now.pv, now.op, now.vp), (run.pv[k], run.op[k], run.vp[k]));
/// }
/// # Ok::<(), stiction_model::Error>(())
/// ```
/// The valve is a data-driven one, or any other given to [`ClosedLoop::player_of`].
#[derive(Debug, Clone)]
pub struct Player<V = Assembly>(Bank<V>);

/// The result of a [`Player`] at one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Played {
    /// Measured process value.
    pub pv: f64,
    /// Controller output, percent.
    pub op: f64,
    /// Valve position, percent.
    pub vp: f64,
}

type One<V, const M: usize> = LoopBank<Each<V, 1>, 1, M>;

/// A loop for the states of its process.
#[derive(Debug, Clone)]
enum Bank<V> {
    Of1(Box<One<V, 1>>),
    Of2(Box<One<V, 2>>),
    Of4(Box<One<V, 4>>),
    Of8(Box<One<V, 8>>),
}

macro_rules! with_bank {
    ($bank:expr, $one:ident => $body:expr) => {
        match $bank {
            Bank::Of1($one) => $body,
            Bank::Of2($one) => $body,
            Bank::Of4($one) => $body,
            Bank::Of8($one) => $body,
        }
    };
}

impl<V> From<One<V, 1>> for Bank<V> {
    fn from(one: One<V, 1>) -> Self {
        Self::Of1(Box::new(one))
    }
}
impl<V> From<One<V, 2>> for Bank<V> {
    fn from(one: One<V, 2>) -> Self {
        Self::Of2(Box::new(one))
    }
}
impl<V> From<One<V, 4>> for Bank<V> {
    fn from(one: One<V, 4>) -> Self {
        Self::Of4(Box::new(one))
    }
}
impl<V> From<One<V, 8>> for Bank<V> {
    fn from(one: One<V, 8>) -> Self {
        Self::Of8(Box::new(one))
    }
}

impl ClosedLoop {
    /// This loop before its first sample. Its signals are left out, except for the first set point, from which a
    /// bumpless controller starts: [`Player::step`] gets them.
    ///
    /// # Errors
    /// As [`ClosedLoop::run`].
    pub fn player(&self) -> Result<Player> {
        let prepared = self.prepare()?;
        let mut valve = self.valve.clone();
        valve.restart(Start::at_rest(self.op_rest));
        Ok(Player(with_order!(prepared.process.order(), M => {
            One::<_, M>::new([&prepared], Each([valve])).into()
        })))
    }

    /// As [`player`](Self::player) with `valve` instead of the loop's own, from rest at [`ClosedLoop::op_rest`]. An
    /// element between controller and valve may act on the controller ([`Player::step_between`]).
    ///
    /// # Errors
    /// As [`ClosedLoop::run`].
    pub fn player_of<V: Valve + Clone>(&self, mut valve: V) -> Result<Player<V>> {
        let prepared = self.prepare()?;
        valve.restart(Start::at_rest(self.op_rest));
        Ok(Player(with_order!(prepared.process.order(), M => {
            One::<V, M>::with_extras([&prepared], Each([valve]), true).into()
        })))
    }
}

impl<V: Valve + Clone> Player<V> {
    /// Simulates one sample: `load` adds to the valve position, `measurement` to the PV.
    ///
    /// # Errors
    /// If an argument is not finite. The state is then unchanged.
    pub fn step(&mut self, sp: f64, load: f64, measurement: f64) -> Result<Played> {
        self.step_between(sp, load, measurement, &mut Wire)
    }

    /// Simulates one sample with an element between controller and valve, such as a compensator, or manual control.
    /// It can act on the controller only of a player from [`ClosedLoop::player_of`].
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn step_between(
        &mut self,
        sp: f64,
        load: f64,
        measurement: f64,
        between: &mut dyn Between,
    ) -> Result<Played> {
        let sp = Lane([finite("set point", sp)?]);
        let load = Lane([finite("load", load)?]);
        let measurement = Lane([finite("measurement", measurement)?]);
        let sample =
            with_bank!(&mut self.0, one => one.step_between(between, &sp, &load, &measurement));
        Ok(Played { pv: sample.pv[0], op: sample.op[0], vp: sample.vp[0] })
    }

    /// The valve.
    pub fn valve(&self) -> &V {
        with_bank!(&self.0, one => one.valve())
    }

    /// The valve, for replacing it.
    pub fn valve_mut(&mut self) -> &mut V {
        with_bank!(&mut self.0, one => one.valve_mut())
    }

    /// Continues from the state of a loop with other settings, except for the valve: the integral of its
    /// controller, the states of its process, the contents of the dead time. Returns false, and changes nothing, if
    /// the process has a different number of states.
    pub fn take_over(&mut self, other: &Self) -> bool {
        match (&mut self.0, &other.0) {
            (Bank::Of1(own), Bank::Of1(other)) => own.take_over(other),
            (Bank::Of2(own), Bank::Of2(other)) => own.take_over(other),
            (Bank::Of4(own), Bank::Of4(other)) => own.take_over(other),
            (Bank::Of8(own), Bank::Of8(other)) => own.take_over(other),
            _ => return false,
        }
        true
    }
}

impl Player {
    /// The memory of the loop between samples, as plain numbers.
    pub fn memory(&self) -> Vec<f64> {
        let mut memory = self.valve().memory().to_vec();
        with_bank!(&self.0, one => one.remember(&mut memory));
        memory
    }

    /// Continues from the memory of a loop with the same settings.
    ///
    /// # Errors
    /// If that was a different kind of loop.
    pub fn recall(&mut self, memory: &[f64]) -> Result<()> {
        let expected = self.memory().len();
        let Some((valve, rest)) =
            memory.split_first_chunk::<7>().filter(|_| memory.len() == expected)
        else {
            return Err(Error::Length {
                name: "memory of the loop",
                found: memory.len(),
                expected,
            });
        };
        self.valve_mut().recall(valve);
        let mut rest = rest.iter().copied();
        with_bank!(&mut self.0, one => one.recall(&mut rest));
        Ok(())
    }
}

impl<const M: usize> ProcessBank<1, M> {
    pub(super) fn remember(&self, memory: &mut Vec<f64>) {
        memory.extend(self.states().map(|state| state[0]));
    }

    pub(super) fn recall(&mut self, memory: &mut impl Iterator<Item = f64>) {
        for state in self.states_mut() {
            state[0] = memory.next().unwrap_or(0.0);
        }
    }
}

impl DelayLine<1> {
    pub(super) fn remember(&self, memory: &mut Vec<f64>) {
        memory.extend(self.newest_first().map(|v| v[0]));
    }

    pub(super) fn recall(&mut self, memory: &mut impl Iterator<Item = f64>) {
        self.refill(|| Lane([memory.next().unwrap_or(0.0)]));
    }
}
