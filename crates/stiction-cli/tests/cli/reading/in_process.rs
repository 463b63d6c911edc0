//! Loops of the population as text, read and judged in process.

use rayon::prelude::*;
use stiction::diagnose::{Detectors, DiagnoseOptions, Grade, diagnose};
use stiction::io::{ReadOptions, reading};
use stiction::population::member;

/// Random numbers that depend on the seed alone.
pub struct Random(u64);

impl Random {
    pub fn of(seed: u64, index: usize) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ ((index as u64) << 20));
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    pub fn of_these<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }
}

/// A loop of the population, rounded as a historian rounds it.
#[derive(Clone)]
pub struct Sampled {
    pub step: f64,
    pub pv: Vec<f64>,
    pub sp: Vec<f64>,
    pub op: Vec<f64>,
}

impl Sampled {
    pub fn member(seed: u64, index: usize) -> Self {
        let recording = member(seed, index as u64).expect("a member").recording;
        let step =
            (1000.0 * (recording.op.time[1] - recording.op.time[0])).round().max(1.0) / 1000.0;
        let pv = recording.pv.expect("a PV").values;
        let unit = unit(&pv);
        let level = pv.iter().sum::<f64>() / pv.len() as f64;
        let sp = recording.sp.map_or_else(|| vec![level; pv.len()], |sp| sp.values);
        Self {
            step,
            pv: rounded(&pv, unit),
            sp: rounded(&sp, unit),
            op: rounded(&recording.op.values, 0.01),
        }
    }

    pub fn len(&self) -> usize {
        self.op.len()
    }

    /// The same on coarser steps, which many samples share.
    pub fn coarse(&self) -> Self {
        let of = |x: &[f64]| rounded(x, 100.0 * unit(x));
        let step = 100.0 * unit(&self.pv);
        Self { step: self.step, pv: of(&self.pv), sp: rounded(&self.sp, step), op: of(&self.op) }
    }

    /// A wide table in seconds.
    pub fn wide(&self) -> String {
        let mut text = "t,pv,sp,op\n".to_owned();
        for k in 0..self.len() {
            let (t, pv) = (shown(k as f64 * self.step), shown(self.pv[k]));
            text += &format!("{t},{pv},{},{}\n", shown(self.sp[k]), shown(self.op[k]));
        }
        text
    }
}

/// A power of ten: a ten thousandth of the span, or less.
fn unit(x: &[f64]) -> f64 {
    let (low, high) = x.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
    10f64.powf((1e-4 * (high - low).max(1e-6)).log10().floor())
}

fn rounded(x: &[f64], unit: f64) -> Vec<f64> {
    x.iter().map(|v| (v / unit).round() * unit).collect()
}

/// A number without the noise of binary fractions.
pub fn shown(x: f64) -> String {
    let text = format!("{x:.8}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// What was made of a file in process.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    pub grade: Grade,
    pub probability: Option<f64>,
    pub s: Option<f64>,
    /// Samples that are not usable, or are bridged.
    pub lost: usize,
    pub samples: usize,
    /// Notes, repairs and measures that are not fit.
    pub said: Vec<String>,
}

impl Judged {
    /// Whether it accuses a valve that the other clears, or the reverse.
    pub fn is_opposite(&self, other: &Self) -> bool {
        let (one, two) = (self.grade, other.grade);
        (one.accuses() && two.spares()) || (one.spares() && two.accuses())
    }

    /// What it says and the other does not.
    pub fn new_words(&self, other: &Self) -> Vec<String> {
        self.said.iter().filter(|word| !other.said.contains(word)).cloned().collect()
    }
}

/// Reads and judges a file with one loop. A refusal is its message.
pub fn judged(bytes: &[u8], name: &str) -> Result<Judged, String> {
    let read = reading::parse(bytes, name, &ReadOptions::default()).map_err(|e| e.to_string())?;
    let [recording] = &read.recordings[..] else {
        return Err(format!("read as {} loops", read.recordings.len()));
    };
    let channels = [Some(&recording.op), recording.pv.as_ref(), recording.sp.as_ref()];
    let unusable = |channel: &stiction::recording::Channel| {
        channel.quality.iter().filter(|quality| !quality.is_usable()).count()
    };
    let lost: usize = channels.into_iter().flatten().map(unusable).sum();
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let found = diagnose(recording, &options).map_err(|e| e.to_string())?;
    let mut said = read.notes.clone();
    said.extend(found.notes.iter().cloned());
    said.extend(found.grid.repairs.iter().map(|repair| repair.done.clone()));
    said.extend(found.fitness.reasons.iter().cloned());
    let masked = found.fitness.measures.iter().filter(|measure| {
        format!("{:?}", measure.id).contains("Masked")
            && measure.value.is_some_and(|share| share > 0.0)
    });
    // The conclusion of mistaken columns names them.
    let mistaken = found.mistaken().and(found.relation.as_ref());
    said.extend(mistaken.map(|relation| format!("mistaken columns: {}", relation.because)));
    said.extend(masked.map(|measure| format!("masked: {}", measure.reason)));
    said.extend(read.missing.iter().map(|missing| missing.reason.clone()));
    Ok(Judged {
        grade: found.verdict.grade,
        probability: found.verdict.probability,
        s: found.stiction.s.map(|s| s.value),
        lost: lost + found.judged.as_ref().map_or(0, |judged| judged.bridged),
        samples: found.judged.as_ref().map_or(0, |judged| judged.samples),
        said,
    })
}

/// Does it for each number below `count`, on all threads, in order.
pub fn for_each<T: Send>(count: usize, of: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    (0..count).into_par_iter().map(of).collect()
}
