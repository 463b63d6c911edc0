//! Recordings whose columns do not belong together: loops of the population with a mistake in their columns.
//!
//! They show the training false evidence. A column that replaces another keeps its units in some of the recordings.
//! In others it is scaled to its own range, as in an export that scales every column. In the rest the whole recording is
//! in percent, so that the ranges give no hint.

use super::draw::Draw;
use super::{ControllerKind, Simulated, Situation, member};
use std::f64::consts::TAU;
use stiction_diagnose::recording::Recording;
use stiction_diagnose::series::{mean, min, span, std};
use stiction_model::closed_loop::NormalStream;
use stiction_model::error::Result;
use stiction_model::named;

named! {
    /// A mistake in the columns of a recording.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Mistake {
        /// OP and PV are exchanged.
        Exchanged = "OP and PV exchanged",
        /// Noise with the PV's mean and standard deviation, white or of first order, replaces the PV.
        PvNoise = "PV noise",
        /// The samples of the PV are out of order: each by itself, or in blocks.
        PvShuffled = "PV shuffled",
        /// The PV column contains the PV of another loop.
        PvOfAnotherLoop = "PV of another loop",
        /// Noise replaces the OP.
        OpNoise = "OP noise",
        /// The samples of the OP are out of order.
        OpShuffled = "OP shuffled",
        /// The OP column contains the OP of another loop.
        OpOfAnotherLoop = "OP of another loop",
        /// The SP replaces the OP, and the OP replaces the SP or is missing.
        SpAsOp = "SP for OP",
        /// The SP replaces the PV, and the PV replaces the SP or is missing.
        SpAsPv = "SP for PV",
        /// OP and PV are unrelated sines.
        UnrelatedSines = "unrelated sines",
        /// One is a sine, the other noise.
        SineAndNoise = "sine and noise",
        /// Both are white noise.
        WhiteAndWhite = "white noise and white noise",
        /// Both are random walks.
        BrownAndBrown = "random walk and random walk",
        /// The OP moves in steps without any effect on the PV, as for a block valve or a loop in manual.
        ManualSteps = "steps unrelated to the PV",
    }
}

impl Mistake {
    /// Share: exchanged columns, the likeliest mistake of a person, are more than a third of all.
    fn share(self) -> f64 {
        match self {
            Self::Exchanged => 9.0,
            Self::PvNoise | Self::PvShuffled | Self::PvOfAnotherLoop | Self::OpOfAnotherLoop => 2.0,
            _ => 1.0,
        }
    }

    /// Whether it needs a set point that moves.
    fn needs_sp(self) -> bool {
        matches!(self, Self::SpAsOp | Self::SpAsPv)
    }
}

/// Mistaken recording number `index` of `seed`, and the mistake. The loops are [members](member) of the population of
/// that seed. Members with small numbers, which are used for other trainings, are hardly ever among them.
///
/// # Errors
/// As for [`member`]. No error is known.
pub fn mistaken(seed: u64, index: u64) -> Result<(Mistake, Recording)> {
    // Separate from the streams of members.
    let mut draw = Draw::of(&[seed, index, u64::from(super::VERSION), 0x6d69_7374]);
    let mistake = draw.weighted(Mistake::ALL.map(|mistake| (mistake, mistake.share())));
    let mut of = simulated(seed, &mut draw)?;
    // Three in ten exchanged columns are those of controllers that amplify noise.
    if mistake == Mistake::Exchanged && draw.chance(0.3) {
        while !of.passes_noise {
            of = simulated(seed, &mut draw)?;
        }
    }
    while mistake.needs_sp() && !of.sp.as_ref().is_some_and(|sp| moves(sp)) {
        of = simulated(seed, &mut draw)?;
    }
    let other = match mistake {
        Mistake::PvOfAnotherLoop | Mistake::OpOfAnotherLoop => simulated(seed, &mut draw)?,
        _ => of.clone(),
    };
    let n = of.op.len().min(other.op.len());
    of.shorten(n);
    make(mistake, &mut of, &other, &mut draw);
    let name = format!("mistaken {index}");
    let mut recording = Recording::regular(name, of.step, &of.op, Some(&of.pv), of.sp.as_deref())?;
    recording.loop_type = of.loop_type;
    Ok((mistake, recording))
}

/// The signals of a loop.
#[derive(Clone)]
struct Signals {
    step: f64,
    loop_type: stiction_diagnose::recording::LoopType,
    op: Vec<f64>,
    pv: Vec<f64>,
    sp: Option<Vec<f64>>,
    /// The PV at 0 % of its span, and the span, in its units.
    range: (f64, f64),
    /// Whether its control is noisy, or proportional only.
    passes_noise: bool,
}

impl Signals {
    /// PV and SP in percent of the span.
    fn in_percent(&mut self) {
        let (low, span) = self.range;
        let values = self.pv.iter_mut().chain(self.sp.iter_mut().flatten());
        values.for_each(|v| *v = 100.0 * (*v - low) / span);
        self.range = (0.0, 100.0);
    }

    fn shorten(&mut self, n: usize) {
        self.op.truncate(n);
        self.pv.truncate(n);
        self.sp.iter_mut().for_each(|sp| sp.truncate(n));
    }
}

/// Any loop of the population.
fn simulated(seed: u64, draw: &mut Draw) -> Result<Signals> {
    let Simulated { recording, truth } = member(seed, draw.seed())?;
    let Recording { op, pv, sp, loop_type, .. } = recording;
    let facts = truth.facts;
    let step = match op.time[..] {
        [first, second, ..] => second - first,
        _ => 1.0,
    };
    let pv = pv.map_or_else(|| op.values.clone(), |pv| pv.values);
    Ok(Signals {
        step,
        loop_type,
        op: op.values,
        pv,
        sp: sp.map(|sp| sp.values),
        range: (facts.pv_low, facts.pv_span),
        passes_noise: facts.situation == Situation::NoisyControl
            || facts.controller == ControllerKind::P,
    })
}

/// Makes the mistake. The other loop is at least as long.
fn make(mistake: Mistake, of: &mut Signals, other: &Signals, draw: &mut Draw) {
    let n = of.op.len();
    match mistake {
        Mistake::Exchanged => {
            // In percent both columns are in the range of an OP.
            let percent = draw.chance(0.4);
            if percent {
                of.in_percent();
            }
            std::mem::swap(&mut of.op, &mut of.pv);
            if !percent {
                rescale(of, draw);
            }
        }
        Mistake::PvNoise => of.pv = like(&of.pv, noise(n, draw)),
        Mistake::PvShuffled => of.pv = shuffled(&of.pv, draw),
        Mistake::PvOfAnotherLoop => {
            of.pv = other.pv[..n].to_vec();
            // A set point of the first loop would reveal it by its range.
            of.sp = match draw.chance(0.5) {
                true => other.sp.as_ref().map(|sp| sp[..n].to_vec()),
                false => None,
            };
        }
        Mistake::OpNoise => of.op = like(&of.op, noise(n, draw)),
        Mistake::OpShuffled => of.op = shuffled(&of.op, draw),
        Mistake::OpOfAnotherLoop => of.op = other.op[..n].to_vec(),
        Mistake::SpAsOp | Mistake::SpAsPv => {
            let Some(sp) = of.sp.take() else { return };
            let column = if mistake == Mistake::SpAsOp { &mut of.op } else { &mut of.pv };
            let replaced = std::mem::replace(column, sp);
            of.sp = draw.chance(0.5).then_some(replaced);
            if mistake == Mistake::SpAsOp {
                rescale(of, draw);
            }
        }
        Mistake::UnrelatedSines => both(of, [sine(n, draw), sine(n, draw)]),
        Mistake::SineAndNoise => {
            let two = [sine(n, draw), noise(n, draw)];
            both(of, two);
            if draw.chance(0.5) {
                let (op, pv) = (like(&of.op, of.pv.clone()), like(&of.pv, of.op.clone()));
                (of.op, of.pv) = (op, pv);
            }
        }
        Mistake::WhiteAndWhite => both(of, [coloured(n, 0.0, draw), coloured(n, 0.0, draw)]),
        Mistake::BrownAndBrown => both(of, [coloured(n, 1.0, draw), coloured(n, 1.0, draw)]),
        Mistake::ManualSteps => of.op = like(&of.op, steps(n, draw)),
    }
}

/// New signals of a loop, with the old means and spreads.
fn both(of: &mut Signals, [op, pv]: [Vec<f64>; 2]) {
    (of.op, of.pv) = (like(&of.op, op), like(&of.pv, pv));
}

/// Scales the OP to a part of 0 to 100 % in one half of all cases.
fn rescale(of: &mut Signals, draw: &mut Draw) {
    let (low, wide) = (draw.uniform(0.0, 60.0), draw.log(2.0, 40.0));
    if draw.chance(0.5) {
        let (least, range) = (min(&of.op), span(&of.op));
        let scale = if range > 0.0 { wide / range } else { 1.0 };
        of.op.iter_mut().for_each(|v| *v = low + scale * (*v - least));
    }
}

/// A signal scaled to the mean and standard deviation of another signal.
fn like(model: &[f64], mut signal: Vec<f64>) -> Vec<f64> {
    let (from, spread) = (mean(&signal), std(&signal));
    let scale = if spread > 0.0 { std(model) / spread } else { 0.0 };
    let centre = mean(model);
    signal.iter_mut().for_each(|v| *v = centre + scale * (*v - from));
    signal
}

/// White in one half, else of first order, with a time constant up to a twentieth of its length.
fn noise(n: usize, draw: &mut Draw) -> Vec<f64> {
    let memory = match draw.chance(0.5) {
        true => 0.0,
        false => (-1.0 / draw.log(1.0, (n as f64 / 20.0).max(2.0))).exp(),
    };
    coloured(n, memory, draw)
}

/// `x_k = memory x_{k-1} + e_k`.
fn coloured(n: usize, memory: f64, draw: &mut Draw) -> Vec<f64> {
    let mut stream = NormalStream::new(draw.seed());
    let mut x = 0.0;
    (0..n)
        .map(|_| {
            x = memory * x + stream.draw();
            x
        })
        .collect()
}

/// A sine of 6 samples to a third of the record, three quarters of them with some noise.
fn sine(n: usize, draw: &mut Draw) -> Vec<f64> {
    let (period, phase) = (draw.log(6.0, n as f64 / 3.0), draw.uniform(0.0, TAU));
    let noise = if draw.chance(0.25) { 0.0 } else { draw.log(0.01, 0.5) };
    let mut stream = NormalStream::new(draw.seed());
    (0..n).map(|k| (TAU * k as f64 / period + phase).sin() + noise * stream.draw()).collect()
}

/// A signal out of order: every sample, or blocks of up to a hundredth of the record.
fn shuffled(x: &[f64], draw: &mut Draw) -> Vec<f64> {
    let length = match draw.chance(0.6) {
        true => 1,
        false => draw.count(2, (x.len() / 100).max(2)),
    };
    let mut blocks: Vec<&[f64]> = x.chunks(length).collect();
    for k in (1..blocks.len()).rev() {
        blocks.swap(k, draw.count(0, k));
    }
    blocks.concat()
}

/// Two to thirty steps of any size at any time.
fn steps(n: usize, draw: &mut Draw) -> Vec<f64> {
    let mut at: Vec<usize> = (0..draw.count(2, 30)).map(|_| draw.count(1, n - 1)).collect();
    at.sort_unstable();
    let mut level = 0.0;
    let mut next = at.into_iter().peekable();
    (0..n)
        .map(|k| {
            while next.next_if(|step| *step <= k).is_some() {
                level += draw.uniform(-1.0, 1.0);
            }
            level
        })
        .collect()
}

/// Whether a set point has at least five values: a step or two are not enough for a signal.
fn moves(sp: &[f64]) -> bool {
    sp.windows(2).filter(|two| two[0] != two[1]).take(4).count() == 4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VERSION;

    fn first_of(mistake: Mistake) -> Recording {
        (0..).map(|index| mistaken(3, index).unwrap()).find(|(made, _)| *made == mistake).unwrap().1
    }

    #[test]
    fn it_depends_on_its_numbers_alone() {
        let all: Vec<_> = (0..24).map(|k| mistaken(3, k).unwrap()).collect();
        for (k, one) in all.iter().enumerate().rev() {
            assert_eq!(one, &mistaken(3, k as u64).unwrap());
        }
        assert_ne!(all[0].1.op, mistaken(4, 0).unwrap().1.op);
        assert_eq!(VERSION, 5);
    }

    #[test]
    fn every_mistake_is_made_of_finite_signals_of_one_length() {
        for mistake in Mistake::ALL {
            let Recording { op, pv, sp, .. } = first_of(mistake);
            let pv = pv.unwrap();
            assert_eq!(op.values.len(), pv.values.len(), "{mistake:?}");
            assert!(sp.is_none_or(|sp| sp.values.len() == pv.values.len()), "{mistake:?}");
            assert!(op.values.iter().chain(&pv.values).all(|v| v.is_finite()), "{mistake:?}");
            assert!(op.values.len() >= 300, "{mistake:?}");
        }
        let mut names: Vec<_> = Mistake::ALL.iter().map(|mistake| mistake.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Mistake::ALL.len());
    }

    #[test]
    fn noise_has_the_mean_and_spread_of_what_it_stands_for() {
        let model: Vec<f64> = (0..900).map(|k| 40.0 + 3.0 * (0.1 * f64::from(k)).sin()).collect();
        let mut draw = Draw::of(&[5]);
        for _ in 0..8 {
            let noise = like(&model, noise(900, &mut draw));
            assert!((mean(&noise) - mean(&model)).abs() < 1e-9);
            assert!((std(&noise) - std(&model)).abs() < 1e-9);
        }
    }

    #[test]
    fn what_is_shuffled_holds_the_same_samples() {
        let x: Vec<f64> = (0..1000).map(f64::from).collect();
        let mut draw = Draw::of(&[6]);
        for _ in 0..6 {
            let mut y = shuffled(&x, &mut draw);
            assert_ne!(x, y);
            y.sort_by(f64::total_cmp);
            assert_eq!(x, y);
        }
    }

    #[test]
    fn exchanged_columns_are_sometimes_rescaled() {
        let signals = |pv: Vec<f64>| Signals {
            step: 1.0,
            loop_type: stiction_diagnose::recording::LoopType::default(),
            op: vec![1.0, 2.0, 4.0],
            pv,
            sp: Some(vec![305.0; 3]),
            range: (200.0, 400.0),
            passes_noise: false,
        };
        let (mut kept, mut moved, mut percent) = (0, 0, 0);
        for seed in 0..80 {
            let mut of = signals(vec![300.0, 310.0, 305.0]);
            make(Mistake::Exchanged, &mut of, &signals(vec![]), &mut Draw::of(&[seed]));
            assert_eq!(of.pv, [1.0, 2.0, 4.0]);
            match of.op[0] {
                300.0 => kept += 1,
                25.0 if of.op == [25.0, 27.5, 26.25] => {
                    assert_eq!(of.sp, Some(vec![26.25; 3]));
                    percent += 1;
                }
                _ => {
                    assert!(min(&of.op) >= 0.0 && span(&of.op) <= 40.0);
                    assert!(((of.op[1] - of.op[0]) / (of.op[2] - of.op[0]) - 2.0).abs() < 1e-9);
                    moved += 1;
                }
            }
        }
        assert!(kept > 8 && moved > 8 && percent > 16, "{kept} {moved} {percent}");
    }

    #[test]
    fn a_third_of_the_mistakes_are_exchanged_columns() {
        let all: f64 = Mistake::ALL.iter().map(|mistake| mistake.share()).sum();
        assert!((Mistake::Exchanged.share() / all - 0.35).abs() < 0.01);
        let (mut with_sp, mut exchanged) = (0, 0);
        for (mistake, recording) in (0..150).map(|k| mistaken(3, k).unwrap()) {
            if mistake == Mistake::Exchanged {
                exchanged += 1;
                with_sp += usize::from(recording.sp.is_some());
            }
        }
        assert!((30..76).contains(&exchanged), "{exchanged} of 150");
        assert!(with_sp * 4 > exchanged && with_sp < exchanged, "{with_sp} of {exchanged}");
    }
}
