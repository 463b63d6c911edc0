//! A small convolutional net over raw signals.
//!
//! # Shape
//! ```text
//! signals (samples x 8) ─> convolution of 9, every 2nd ─> 7 residual blocks ─> mean and maximum over time ─┐
//! scalars (8) ─────────────────────────────────────────────────────────────────────────────────────────────┴─> 128 ─> outputs
//! ```
//! A block adds two separable convolutions of 9 to its input (one filter per channel, then a matrix over channels).
//! Activations are `x min(max(x + 3, 0), 6) / 6`. The signals are padded with zeros at their end. Several nets,
//! each trained on different loops, are averaged.
//!
//! Weights were trained by `addons/stiction-train/net/train.py` (its card names the command) on simulated loops only.
//! They are kept as the upper halves of 32-bit numbers. Every sum has a fixed order, so the same signals give the same
//! bits on every processor.
//!
//! # References
//! A. Howard et al., "Searching for MobileNetV3", ICCV 2019 (the activation; recalled, not read); K. He et al., "Deep
//! residual learning for image recognition", CVPR 2016 (recalled, not read). The shape is ours.

use super::input::{CHANNELS, Input, SCALARS};
use crate::cause::Cause;
use crate::error::{Error, Result};
use crate::simd::{Kernel, Width};
use std::sync::OnceLock;

/// The first bytes of a file.
const MAGIC: [u8; 8] = *b"STICNET1";
/// Number of samples of a filter.
const TAPS: usize = 9;
/// Channels of the first convolution, and the spacing of its output samples.
const FIRST: (usize, usize) = (32, 2);
/// Blocks: channels, spacing of the filter's samples, and spacing of the output samples.
const BLOCKS: [(usize, usize, usize); 7] =
    [(32, 1, 1), (64, 1, 4), (64, 2, 1), (96, 1, 2), (96, 2, 1), (128, 1, 2), (128, 2, 1)];
/// Channels of the last block.
const LAST: usize = 128;
const HIDDEN: usize = 128;
/// Outputs of the nets: the logit of a fault, `ln(S / OP span)`, J/S, and the margin of each cause.
pub const OUTPUTS: usize = 3 + Cause::ALL.len();
/// Channels that are summed at once: with four samples they fit the registers of four numbers.
const WIDE: usize = 16;

/// Nets that are averaged.
#[derive(Debug, Clone, PartialEq)]
pub struct Net {
    members: Vec<Member>,
}

/// A net: its layers in order.
#[derive(Debug, Clone, PartialEq)]
struct Member {
    first: Matrix,
    blocks: Vec<Block>,
    hidden: Matrix,
    output: Matrix,
}

#[derive(Debug, Clone, PartialEq)]
struct Block {
    filters: [Filters; 2],
    mixes: [Matrix; 2],
    /// The bypass; `None` if the output has the same samples and channels.
    around: Option<Matrix>,
}

/// One filter a channel: sample by sample, channels side by side.
#[derive(Debug, Clone, PartialEq)]
struct Filters {
    weights: Vec<f32>,
    spacing: usize,
    every: usize,
}

/// Input by input, outputs side by side, and the bias of the outputs.
#[derive(Debug, Clone, PartialEq)]
struct Matrix {
    weights: Vec<f32>,
    bias: Vec<f32>,
}

/// The nets in the library, read once; `None` if their file is invalid.
pub fn shipped() -> Option<&'static Net> {
    static SHIPPED: OnceLock<Option<Net>> = OnceLock::new();
    let read = || Net::from_bytes(include_bytes!("../../../model/net.bin")).ok();
    SHIPPED.get_or_init(read).as_ref()
}

impl Net {
    /// Reads a file.
    ///
    /// # Errors
    /// If the file is not a net, ends early, continues after its end, or has a weight that is not finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let rest = bytes.strip_prefix(&MAGIC).ok_or_else(|| damaged("is not a net"))?;
        let (count, rest) = rest.split_first().ok_or_else(|| damaged("ends too early"))?;
        let mut from = Weights(rest);
        let members: Vec<Member> =
            (0..*count).map(|_| Member::read(&mut from)).collect::<Result<_>>()?;
        match from.0.is_empty() && !members.is_empty() {
            true => Ok(Self { members }),
            false => Err(damaged("has no net, or too many")),
        }
    }

    /// The nets one by one.
    pub fn members(&self) -> impl Iterator<Item = Self> {
        self.members.iter().map(|member| Self { members: vec![member.clone()] })
    }

    /// The mean output of the nets.
    pub fn outputs(&self, input: &Input) -> [f32; OUTPUTS] {
        let width = Width::widest();
        let mut sum = [0.0; OUTPUTS];
        for member in &self.members {
            let said = width.run(Forward { member, input });
            sum.iter_mut().zip(said).for_each(|(sum, said)| *sum += said);
        }
        sum.map(|value| value / self.members.len() as f32)
    }
}

fn damaged(what: &str) -> Error {
    Error::Bundle(format!("the net {what}"))
}

/// Takes weights from the front of bytes.
struct Weights<'a>(&'a [u8]);

impl Weights<'_> {
    fn take(&mut self, count: usize) -> Result<Vec<f32>> {
        let (front, rest) =
            self.0.split_at_checked(2 * count).ok_or_else(|| damaged("ends too early"))?;
        self.0 = rest;
        let value =
            |two: &[u8]| f32::from_bits(u32::from(u16::from_le_bytes([two[0], two[1]])) << 16);
        let values: Vec<f32> = front.chunks_exact(2).map(value).collect();
        match values.iter().all(|v| v.is_finite()) {
            true => Ok(values),
            false => Err(damaged("has a weight that is not finite")),
        }
    }

    fn matrix(&mut self, inputs: usize, outputs: usize) -> Result<Matrix> {
        Ok(Matrix { weights: self.take(inputs * outputs)?, bias: self.take(outputs)? })
    }
}

impl Member {
    fn read(from: &mut Weights<'_>) -> Result<Self> {
        let first = from.matrix(TAPS * CHANNELS, FIRST.0)?;
        let mut channels = FIRST.0;
        let mut blocks = vec![];
        for (outputs, spacing, every) in BLOCKS {
            let before = Filters { weights: from.take(TAPS * channels)?, spacing, every };
            let mix = from.matrix(channels, outputs)?;
            let behind = Filters { weights: from.take(TAPS * outputs)?, spacing, every: 1 };
            let mix_behind = from.matrix(outputs, outputs)?;
            let around = match every > 1 || outputs != channels {
                true => Some(from.matrix(channels, outputs)?),
                false => None,
            };
            blocks.push(Block { filters: [before, behind], mixes: [mix, mix_behind], around });
            channels = outputs;
        }
        let hidden = from.matrix(2 * LAST + SCALARS, HIDDEN)?;
        let output = from.matrix(HIDDEN, OUTPUTS)?;
        Ok(Self { first, blocks, hidden, output })
    }
}

/// A pass through a net.
struct Forward<'a> {
    member: &'a Member,
    input: &'a Input,
}

impl Kernel for Forward<'_> {
    type Output = [f32; OUTPUTS];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { member, input } = self;
        // The first convolution is a matrix over all samples that a filter sees.
        let samples = input.values.len().div_ceil(FIRST.1);
        let mut seen = vec![0.0; samples * TAPS * CHANNELS];
        for (k, row) in seen.chunks_exact_mut(TAPS * CHANNELS).enumerate() {
            for (tap, part) in row.chunks_exact_mut(CHANNELS).enumerate() {
                let at = (FIRST.1 * k + tap).checked_sub(TAPS / 2);
                if let Some(values) = at.and_then(|at| input.values.get(at)) {
                    part.copy_from_slice(values);
                }
            }
        }
        let mut x = mixed(&seen, &member.first);
        x.iter_mut().for_each(|v| *v = activated(*v));
        for block in &member.blocks {
            let mut y = mixed(&filtered(&x, &block.filters[0]), &block.mixes[0]);
            y.iter_mut().for_each(|v| *v = activated(*v));
            let y = mixed(&filtered(&y, &block.filters[1]), &block.mixes[1]);
            let around = match &block.around {
                None => x,
                Some(around) => mixed(&thinned(&x, around, block.filters[0].every), around),
            };
            x = around.iter().zip(&y).map(|(a, b)| activated(a + b)).collect();
        }
        let (mut mean, mut most) = ([0.0f32; LAST], [f32::NEG_INFINITY; LAST]);
        for row in x.chunks_exact(LAST) {
            for c in 0..LAST {
                mean[c] += row[c];
                most[c] = most[c].max(row[c]);
            }
        }
        let count = (x.len() / LAST) as f32;
        let mut pooled: Vec<f32> = mean.iter().map(|sum| sum / count).collect();
        pooled.extend(most);
        pooled.extend(input.scalars.map(|v| 0.5 * v));
        let mut hidden = member.hidden.applied(&pooled);
        hidden.iter_mut().for_each(|v| *v = activated(*v));
        let said = member.output.applied(&hidden);
        std::array::from_fn(|k| said[k])
    }
}

impl Matrix {
    /// For one row.
    fn applied(&self, row: &[f32]) -> Vec<f32> {
        let mut out = self.bias.clone();
        for (x, weights) in row.iter().zip(self.weights.chunks_exact(self.bias.len())) {
            out.iter_mut().zip(weights).for_each(|(sum, w)| *sum += x * w);
        }
        out
    }
}

#[inline(always)]
fn activated(x: f32) -> f32 {
    x * (x + 3.0).clamp(0.0, 6.0) * (1.0 / 6.0)
}

/// One filter a channel, over samples with channels side by side.
#[inline(always)]
fn filtered(x: &[f32], filters: &Filters) -> Vec<f32> {
    let channels = filters.weights.len() / TAPS;
    let samples = x.len() / channels;
    let Filters { weights, spacing, every } = filters;
    let mut out = vec![0.0; samples.div_ceil(*every) * channels];
    for (k, out) in out.chunks_exact_mut(channels).enumerate() {
        for (from, out) in (0..channels).step_by(WIDE).zip(out.chunks_exact_mut(WIDE)) {
            let mut sums = [0.0f32; WIDE];
            for (tap, weights) in weights.chunks_exact(channels).enumerate() {
                let at = (k * every + tap * spacing).checked_sub(TAPS / 2 * spacing);
                let Some(at) = at.filter(|at| *at < samples) else { continue };
                let (x, weights) = (&x[at * channels + from..][..WIDE], &weights[from..][..WIDE]);
                for c in 0..WIDE {
                    sums[c] += x[c] * weights[c];
                }
            }
            out.copy_from_slice(&sums);
        }
    }
    out
}

/// Every n-th sample of a matrix's input.
#[inline(always)]
fn thinned(x: &[f32], matrix: &Matrix, every: usize) -> Vec<f32> {
    let channels = matrix.weights.len() / matrix.bias.len();
    x.chunks_exact(channels).step_by(every).flatten().copied().collect()
}

/// A matrix over the channels of every sample.
#[inline(always)]
fn mixed(x: &[f32], matrix: &Matrix) -> Vec<f32> {
    /// Samples per pass through the weights.
    const SIDE: usize = 4;
    let outputs = matrix.bias.len();
    let inputs = matrix.weights.len() / outputs;
    let mut out = vec![0.0; x.len() / inputs * outputs];
    for (x, out) in x.chunks(SIDE * inputs).zip(out.chunks_mut(SIDE * outputs)) {
        let samples = out.len() / outputs;
        // The last rows may be missing; others stand in for them.
        let rows: [&[f32]; SIDE] =
            std::array::from_fn(|k| &x[k.min(samples - 1) * inputs..][..inputs]);
        for from in (0..outputs).step_by(WIDE) {
            let mut sums = [[0.0f32; WIDE]; SIDE];
            for sum in &mut sums {
                sum.copy_from_slice(&matrix.bias[from..from + WIDE]);
            }
            for (i, weights) in matrix.weights.chunks_exact(outputs).enumerate() {
                let weights = &weights[from..from + WIDE];
                for k in 0..SIDE {
                    for c in 0..WIDE {
                        sums[k][c] += rows[k][i] * weights[c];
                    }
                }
            }
            for k in 0..samples {
                out[k * outputs + from..k * outputs + from + WIDE].copy_from_slice(&sums[k]);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights of a net.
    const WEIGHTS: usize = 181_871;

    fn file(members: u8) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.push(members);
        for _ in 0..members {
            for k in 0..WEIGHTS {
                let weight = ((k * 7919 % 1009) as f64 / 1009.0 - 0.5) * 0.25;
                bytes.extend(&(weight as f32).to_le_bytes()[2..]);
            }
        }
        bytes
    }

    fn input(samples: usize) -> Input {
        let wave =
            |k: usize| std::array::from_fn(|c| (0.1 * (c + 1) as f64 * k as f64).sin() as f32);
        Input {
            values: (0..samples).map(wave).collect(),
            scalars: std::array::from_fn(|k| 0.25 * k as f32),
        }
    }

    /// By a program of its own, in double precision.
    #[test]
    fn outputs_are_those_of_plain_convolutions() {
        let expected = [
            -0.097837126,
            -0.106104289,
            0.099703615,
            0.034620242,
            0.051553580,
            -0.001973625,
            -0.035313131,
            -0.079435454,
            -0.110828655,
            0.070674759,
            0.037638876,
            0.028845324,
            -0.009961263,
            -0.066713390,
            -0.103243115,
        ];
        let net = Net::from_bytes(&file(2)).unwrap();
        let found = net.outputs(&input(101));
        for (a, b) in found.iter().zip(expected) {
            assert!((f64::from(*a) - b).abs() < 1e-5, "{found:?}");
        }
        assert_eq!(net.members().count(), 2);
        let [one, other] = [net.members().next(), net.members().last()].map(Option::unwrap);
        assert_eq!(one.outputs(&input(101)), other.outputs(&input(101)));
    }

    #[test]
    fn every_width_gives_the_same() {
        let net = Net::from_bytes(&file(1)).unwrap();
        for samples in [1, 64, 333] {
            let input = input(samples);
            let member = &net.members[0];
            let all: Vec<_> = Width::available()
                .map(|width| width.run(Forward { member, input: &input }))
                .collect();
            assert!(all.iter().all(|each| each == &all[0] && each.iter().all(|v| v.is_finite())));
        }
    }

    #[test]
    fn damaged_files_are_refused() {
        let sound = file(1);
        assert!(Net::from_bytes(&sound).is_ok());
        assert!(Net::from_bytes(&sound[..sound.len() - 1]).is_err());
        assert!(Net::from_bytes(&[&sound[..], &[0]].concat()).is_err());
        assert!(Net::from_bytes(&[]).is_err() && Net::from_bytes(&file(0)).is_err());
        let mut infinite = sound.clone();
        infinite[9..11].copy_from_slice(&[0x80, 0x7f]);
        assert!(Net::from_bytes(&infinite).is_err());
    }
}
