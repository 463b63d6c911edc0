//! What the tests share: reference tables, inputs, and comparison to the bit.
#![allow(dead_code)]

use std::collections::HashMap;
use std::io::Read;
use std::path::PathBuf;
use stiction_model::Bands;
use stiction_model::closed_loop::NormalStream;
use stiction_model::valve::{Assembly, Model, Valve};

/// A table with named columns.
pub struct Table {
    columns: HashMap<String, usize>,
    rows: Vec<csv::StringRecord>,
}

impl Table {
    /// The fixture `name`, gzipped or not.
    pub fn fixture(name: &str) -> Self {
        let path: PathBuf =
            [env!("CARGO_MANIFEST_DIR"), "tests", "fixtures", name].iter().collect();
        let file = std::fs::File::open(path).unwrap();
        let text: Box<dyn Read> = if name.ends_with(".gz") {
            Box::new(flate2::read::GzDecoder::new(file))
        } else {
            Box::new(file)
        };
        let mut reader = csv::Reader::from_reader(text);
        let headers = reader.headers().unwrap().clone();
        let columns = headers.iter().enumerate().map(|(i, name)| (name.to_owned(), i)).collect();
        Self { columns, rows: reader.records().map(Result::unwrap).collect() }
    }

    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn text(&self, row: usize, column: &str) -> &str {
        &self.rows[row][self.columns[column]]
    }

    pub fn number(&self, row: usize, column: &str) -> f64 {
        self.text(row, column).parse().unwrap()
    }

    /// Row numbers for which `keep` holds.
    pub fn rows(&self, keep: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.len()).filter(|row| keep(*row)).collect()
    }

    pub fn column(&self, rows: &[usize], column: &str) -> Vec<f64> {
        rows.iter().map(|row| self.number(*row, column)).collect()
    }
}

/// The library's name for a column of the reference tables.
pub fn model_named(column: &str) -> Model {
    Model::by_name(column).unwrap()
}

/// A valve of `model`, at rest at 0.
pub fn valve(model: Model, s: f64, j: f64) -> Assembly {
    model.build(Bands::from_s_j(s, j).unwrap()).unwrap().into()
}

/// The positions of `valve` over `op`.
pub fn follow(valve: &mut impl Valve, op: &[f64]) -> Vec<f64> {
    let mut vp = vec![0.0; op.len()];
    valve.run(op, &mut vp).unwrap();
    vp
}

/// The positions of a valve of `model` over `op`, from rest at 0.
pub fn positions(model: Model, s: f64, j: f64, op: &[f64]) -> Vec<f64> {
    follow(&mut valve(model, s, j), op)
}

pub fn bits(samples: &[f64]) -> Vec<u64> {
    samples.iter().map(|v| v.to_bits()).collect()
}

pub fn max_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

pub fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len() as f64
}

pub fn deviation(samples: &[f64]) -> f64 {
    let m = mean(samples);
    (samples.iter().map(|v| (v - m) * (v - m)).sum::<f64>() / samples.len() as f64).sqrt()
}

pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (ma, mb) = (mean(a), mean(b));
    let product: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).collect();
    mean(&product) / (deviation(a) * deviation(b))
}

/// Kinds of random input; all but [`WALK_WITH_PAUSES`] are free of pauses.
pub const KINDS: u8 = 4;
pub const WALK_WITH_PAUSES: u8 = 1;

/// A random input, printed by what it is made of.
#[derive(Clone)]
pub struct Input {
    kind: u8,
    seed: u64,
    samples: Vec<f64>,
}

impl std::fmt::Debug for Input {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Input::new({}, {}, {})", self.kind, self.seed, self.samples.len())
    }
}

impl std::ops::Deref for Input {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.samples
    }
}

impl Input {
    /// `n` random samples.
    pub fn new(kind: u8, seed: u64, n: usize) -> Self {
        let mut noise = NormalStream::new(seed);
        // A binary fraction, so that a walk comes back to the very same values.
        let pace = 0.0625 * (16.0 + 16.0 * noise.draw().abs()).round();
        let mut u = 0.0;
        let mut sample = |k: usize| {
            match kind {
                // A Gaussian walk.
                0 => u += noise.draw(),
                // A walk in steps of a certain size, with pauses.
                WALK_WITH_PAUSES => u += pace * noise.draw().round_ties_even(),
                // A sine with noise.
                2 => u = 10.0 * (0.05 * pace * k as f64).sin() + 0.2 * noise.draw(),
                // White noise.
                _ => u = 6.0 * noise.draw(),
            }
            u
        };
        Self { kind, seed, samples: (0..n).map(&mut sample).collect() }
    }
}
