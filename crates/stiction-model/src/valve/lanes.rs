//! Many candidates over one input: (S, J) pairs stepped together.
//!
//! Sixteen valves of one model advance side by side in vector registers; blocks of sixteen share
//! the processor's cores. Every lane gives the same bits as the scalar model.

use super::{He, Start, TwoPhase, Valve};
use crate::bands::Bands;
use crate::error::{Result, all_finite};
use crate::parallel::*;
use crate::simd::{Kernel, Width};
// Not `if`: a branch can become masked loads, which keep the state of the lanes out of registers.
use std::hint::select_unpredictable as select;

pub use crate::simd::{LANES, Lane};

/// Valves of one model, one a lane.
pub trait LaneValve: Copy + Send {
    /// One valve per lane. Each has its own bands and its own start.
    fn starting(bands: &[Bands; LANES], starts: [Start; LANES]) -> Self;

    /// The position of the valve in lane `l` once its controller output has become `op`.
    ///
    /// To be called for all lanes in turn, in one loop, which the compiler can vectorise.
    fn step(&mut self, l: usize, op: f64) -> f64;
}

/// [`TwoPhase`] valves, one a lane. Some may be [`He`]'s, which is a two-phase valve that forgets its motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoPhaseLanes {
    fs: Lane,
    fd: Lane,
    position: Lane,
    op: Lane,
    motion: Lane,
    /// 0 for He's valve, else 1.
    remembers: Lane,
}

impl TwoPhaseLanes {
    /// These valves, with He's valve in some lanes.
    #[must_use]
    pub fn with_he(self, is_he: [bool; LANES]) -> Self {
        Self { remembers: Lane(is_he.map(|is_he| if is_he { 0.0 } else { 1.0 })), ..self }
    }
}

impl LaneValve for TwoPhaseLanes {
    fn starting(bands: &[Bands; LANES], starts: [Start; LANES]) -> Self {
        Self {
            fs: Lane(bands.map(|b| b.fs())),
            fd: Lane(bands.map(|b| b.fd())),
            position: Lane(starts.map(|s| s.position)),
            op: Lane(starts.map(|s| s.op)),
            motion: Lane(starts.map(|s| if s.moving { s.direction.sign() } else { 0.0 })),
            remembers: Lane::splat(1.0),
        }
    }

    #[inline(always)]
    fn step(&mut self, l: usize, op: f64) -> f64 {
        let du = op - self.op[l];
        let e = op - self.position[l];
        let keeps_moving = self.motion[l] * du > 0.0;
        let moves = keeps_moving | (e.abs() > self.fs[l]);
        let direction = 1f64.copysign(select(keeps_moving, du, e));
        let moved = op - direction * self.fd[l];
        self.position[l] = select(moves, moved, self.position[l]);
        self.motion[l] = select(moves, direction * self.remembers[l], 0.0);
        self.op[l] = op;
        self.position[l]
    }
}

/// [`He`] valves, one a lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeLanes {
    fs: Lane,
    fd: Lane,
    position: Lane,
}

impl LaneValve for HeLanes {
    fn starting(bands: &[Bands; LANES], starts: [Start; LANES]) -> Self {
        Self {
            fs: Lane(bands.map(|b| b.fs())),
            fd: Lane(bands.map(|b| b.fd())),
            position: Lane(starts.map(|s| s.position)),
        }
    }

    #[inline(always)]
    fn step(&mut self, l: usize, op: f64) -> f64 {
        let e = op - self.position[l];
        let moved = op - 1f64.copysign(e) * self.fd[l];
        self.position[l] = select(e.abs() > self.fs[l], moved, self.position[l]);
        self.position[l]
    }
}

/// A model that exists both as a scalar [`Valve`] and in lanes.
pub trait Laned: Valve {
    /// The same model in lanes.
    type Lanes: LaneValve;
}

impl Laned for TwoPhase {
    type Lanes = TwoPhaseLanes;
}

impl Laned for He {
    type Lanes = HeLanes;
}

/// All lanes over a segment of one input.
struct Run<'a, L> {
    valves: L,
    op: &'a [f64],
    vp: &'a mut [Lane],
}

impl<L: LaneValve> Kernel for Run<'_, L> {
    type Output = L;
    #[inline(always)]
    fn run(self) -> L {
        // A local copy, so that the state stays in registers.
        let mut valves = self.valves;
        for (u, x) in self.op.iter().zip(self.vp) {
            // Through an array that cannot overlap the input: otherwise an extra loop for overlap keeps the state
            // out of registers.
            *x = Lane::from_fn(|l| valves.step(l, *u));
        }
        valves
    }
}

/// The positions of sixteen valves over the whole of `op`, all starting from `start`, on this thread.
pub fn follow<M: Laned>(
    bands: &[Bands; LANES],
    start: Start,
    op: &[f64],
    vp: &mut [Lane],
    width: Width,
) {
    let valves = M::Lanes::starting(bands, [start; LANES]);
    width.run(Run { valves, op, vp });
}

/// Samples per hand-over of positions: few enough to stay in the first-level cache.
const SEGMENT: usize = 128;

/// Drives every candidate in `bands` with the same `op`, starting from `start`, and returns the result of `take`
/// for each block of [`LANES`] candidates, in their order.
///
/// `begin` creates the accumulator for the block whose first candidate has the given index. `take` receives it with
/// the index of a sample and the positions from that sample on, one [`Lane`] a sample; candidate `first + l` is in
/// lane `l`. Segments come in order, and together they cover all of `op`. Lanes after the last candidate repeat it.
///
/// Blocks run on all threads of the current rayon pool; the result does not depend on their number.
///
/// ```
/// use stiction_model::{Bands, valve::{Start, TwoPhase, lanes}};
/// let op: Vec<f64> = (0..1000).map(|k| 20.0 * (k as f64 * 0.01).sin()).collect();
/// let bands: Vec<Bands> =
///     (0..40).map(|i| Bands::from_s_j(0.1 * i as f64, 0.05 * i as f64)).collect::<Result<_, _>>()?;
/// // How well each candidate's position correlates with the input.
/// let products = lanes::run::<TwoPhase, _>(
///     &bands,
///     Start::default(),
///     &op,
///     |_| [0.0; lanes::LANES],
///     |sums, at, vp| {
///         for (x, u) in vp.iter().zip(&op[at..]) {
///             for l in 0..lanes::LANES {
///                 sums[l] += x[l] * u;
///             }
///         }
///     },
/// )?
/// .concat();
/// assert!(products[0] > products[39]);
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # Errors
/// If a sample of `op` or the start is NaN or infinite.
pub fn run<M: Laned, A: Send>(
    bands: &[Bands],
    start: Start,
    op: &[f64],
    begin: impl Fn(usize) -> A + Sync,
    take: impl Fn(&mut A, usize, &[Lane]) + Sync,
) -> Result<Vec<A>> {
    start.checked()?;
    all_finite("op", op)?;
    let width = Width::widest();
    let block = |(block, bands): (usize, &[Bands])| {
        // Lanes after the last candidate repeat it.
        let lanes = std::array::from_fn(|l| bands[l.min(bands.len() - 1)]);
        let mut valves = M::Lanes::starting(&lanes, [start; LANES]);
        let mut vp = [Lane::splat(0.0); SEGMENT];
        let mut gathered = begin(block * LANES);
        for (i, op) in op.chunks(SEGMENT).enumerate() {
            let vp = &mut vp[..op.len()];
            valves = width.run(Run { valves, op, vp });
            take(&mut gathered, i * SEGMENT, vp);
        }
        gathered
    };
    Ok(bands.par_chunks(LANES).enumerate().map(block).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

    /// Positions to the bit, for vectors of some width.
    fn positions<L: LaneValve>(width: Width, op: &[f64]) -> Vec<[u64; LANES]> {
        // Dead band alone, both, and slips that overshoot.
        let bands = std::array::from_fn(|l| Bands::from_s_j(3.0, 0.4 * l as f64).unwrap());
        let mut vp = vec![Lane::splat(0.0); op.len()];
        let valves = L::starting(&bands, [Start::default(); LANES]);
        width.run(Run { valves, op, vp: &mut vp });
        vp.iter().map(|x| x.map(f64::to_bits)).collect()
    }

    #[test]
    fn all_widths_give_the_same_bits() {
        let mut stream = NormalStream::new(1);
        let op: Vec<f64> = (0..2_000).map(|_| 5.0 * stream.draw()).collect();
        for width in Width::available() {
            let (two_phase, he) = (
                positions::<TwoPhaseLanes>(Width::Baseline, &op),
                positions::<HeLanes>(Width::Baseline, &op),
            );
            assert!(positions::<TwoPhaseLanes>(width, &op) == two_phase, "{width:?}");
            assert!(positions::<HeLanes>(width, &op) == he, "{width:?}");
        }
    }
}
