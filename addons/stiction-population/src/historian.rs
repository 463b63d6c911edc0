//! Processing of a signal by a historian.

use super::draw::Draw;
use super::families::HistorianKind;
use stiction_diagnose::series::std;
use stiction_model::closed_loop::quantised;

/// The recording of a loop.
#[derive(Debug, Clone)]
pub(super) struct Historian {
    /// The average over the sample, not the value at its end.
    pub averaged: bool,
    /// The PV is updated every this many samples and held in between.
    pub hold: usize,
    /// Resolution of the OP, percent; 0 for none.
    pub op_quantum: f64,
    /// Resolution of the PV, in standard deviations of the PV; 0 without quantisation.
    pub pv_quantum: f64,
    /// Deviation of the swinging door on OP and on PV, in standard deviations; 0 for none.
    pub doors: [f64; 2],
    /// Changes of OP and PV that are reported, in standard deviations; 0 for all.
    pub exceptions: [f64; 2],
}

impl Historian {
    /// A random historian. Loops near their limit are compressed more often.
    pub fn draw(near_limit: bool, draw: &mut Draw) -> Self {
        let (compressed, reports) = if near_limit { (0.36, 0.16) } else { (0.22, 0.1) };
        let averaged = draw.chance(0.2);
        let hold = draw.count(2, 6);
        let held = draw.chance(0.12);
        let op_quantum = draw.one_of([0.01, 0.05, 0.1, 0.25, 0.5, 1.0]);
        let op_quantised = draw.chance(0.4);
        let pv_quantum = draw.log(0.01, 0.4);
        let pv_quantised = draw.chance(0.4);
        let door = draw.unit();
        let doors = doors(draw, 0.02);
        let exception = draw.unit();
        let exceptions = [draw.log(0.02, 0.5), draw.log(0.02, 0.5)];
        let reported = draw.weighted([([1.0, 1.0], 1.0), ([1.0, 0.0], 0.5), ([0.0, 1.0], 0.5)]);
        Self {
            averaged,
            hold: if held { hold } else { 1 },
            op_quantum: if op_quantised { op_quantum } else { 0.0 },
            pv_quantum: if pv_quantised { pv_quantum } else { 0.0 },
            doors: if door < compressed { doors } else { [0.0; 2] },
            exceptions: match exception < reports && door >= compressed {
                true => [exceptions[0] * reported[0], exceptions[1] * reported[1]],
                false => [0.0; 2],
            },
        }
    }

    /// The historian without compression, averages and holds: a trend opened for a test.
    pub fn trend(&self) -> Self {
        Self { averaged: false, hold: 1, doors: [0.0; 2], exceptions: [0.0; 2], ..self.clone() }
    }

    /// Compresses the OP, the PV or both, more than usual.
    pub fn compress(&mut self, draw: &mut Draw) {
        self.doors = doors(draw, 0.1);
        self.exceptions = [0.0; 2];
    }

    /// Processing.
    pub fn kinds(&self, steps: usize) -> Vec<HistorianKind> {
        let any = |x: [f64; 2]| x.iter().any(|v| *v > 0.0);
        let all = [
            (self.averaged, HistorianKind::Averaging),
            (self.hold > 1, HistorianKind::Holding),
            (any([self.op_quantum, self.pv_quantum]), HistorianKind::Rounding),
            (any(self.doors), HistorianKind::SwingingDoor),
            (any(self.exceptions), HistorianKind::Exception),
            (steps >= 20, HistorianKind::Slow),
        ];
        let mut kinds: Vec<_> = all.iter().filter(|(is, _)| *is).map(|(_, kind)| *kind).collect();
        if kinds.is_empty() {
            kinds.push(HistorianKind::Plain);
        }
        kinds
    }

    /// The recorded OP, with `steps` steps a sample.
    pub fn op(&self, op: &[f64], steps: usize) -> Vec<f64> {
        let mut op = self.sampled(op, steps);
        op.iter_mut().for_each(|v| *v = quantised(*v, self.op_quantum));
        Self::kept(op, self.doors[0], self.exceptions[0])
    }

    /// The recorded PV, with `steps` steps a sample.
    pub fn pv(&self, pv: &[f64], steps: usize) -> Vec<f64> {
        let mut pv = self.sampled(pv, steps);
        for k in 0..pv.len() {
            pv[k] = pv[k - k % self.hold];
        }
        let quantum = if self.pv_quantum > 0.0 { self.pv_quantum * std(&pv) } else { 0.0 };
        pv.iter_mut().for_each(|v| *v = quantised(*v, quantum));
        Self::kept(pv, self.doors[1], self.exceptions[1])
    }

    fn sampled(&self, x: &[f64], steps: usize) -> Vec<f64> {
        let value = |sample: &[f64]| match self.averaged {
            true => sample.iter().sum::<f64>() / steps as f64,
            false => sample[steps - 1],
        };
        x.chunks_exact(steps).map(value).collect()
    }

    /// The signal restored from the kept samples.
    fn kept(x: Vec<f64>, door: f64, exception: f64) -> Vec<f64> {
        match (door > 0.0, exception > 0.0) {
            (true, _) => swinging_door(&x, door * std(&x)),
            (_, true) => reported(&x, exception * std(&x)),
            _ => x,
        }
    }
}

/// Deviations of the swinging door of OP and PV, each lu(`least`, 1.5) standard deviations: on both, or one.
fn doors(draw: &mut Draw, least: f64) -> [f64; 2] {
    let deviations = [draw.log(least, 1.5), draw.log(least, 1.5)];
    match draw.unit() {
        place if place < 0.4 => deviations,
        place if place < 0.6 => [deviations[0], 0.0],
        _ => [0.0, deviations[1]],
    }
}

/// The last value that differed by more than `change` from the one before it: exception reporting.
fn reported(x: &[f64], change: f64) -> Vec<f64> {
    let mut last = f64::NAN;
    let keep = |v: &f64| {
        if !((v - last).abs() <= change) {
            last = *v;
        }
        last
    };
    x.iter().map(keep).collect()
}

/// The samples kept by a swinging-door compression with the given deviation, with straight lines between them: the
/// output of a historian that interpolates. The first and last samples are kept; every other one is within
/// `deviation` of the restored signal.
///
/// Source: E. H. Bristol, "Swinging door trending: adaptive trend recording?", ISA National
/// Conference 1990 (recalled, not read).
pub fn swinging_door(x: &[f64], deviation: f64) -> Vec<f64> {
    let mut back = Vec::with_capacity(x.len());
    let Some(&first) = x.first() else { return back };
    back.push(first);
    let mut anchor = 0;
    // The steepest and the flattest line from the anchor that pass within the deviation of every sample since.
    let (mut steepest, mut flattest) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 1..x.len() {
        let run = (k - anchor) as f64;
        let slope = (x[k] - x[anchor]) / run;
        if slope > steepest || slope < flattest {
            extend(&mut back, x, anchor, k - 1);
            anchor = k - 1;
            (steepest, flattest) = (f64::INFINITY, f64::NEG_INFINITY);
        }
        let run = (k - anchor) as f64;
        steepest = steepest.min((x[k] + deviation - x[anchor]) / run);
        flattest = flattest.max((x[k] - deviation - x[anchor]) / run);
    }
    extend(&mut back, x, anchor, x.len() - 1);
    back
}

/// The straight line from sample `from`, which already exists, to sample `to`.
fn extend(back: &mut Vec<f64>, x: &[f64], from: usize, to: usize) {
    for k in from + 1..=to {
        let share = (k - from) as f64 / (to - from) as f64;
        back.push(if k == to { x[to] } else { x[from] + share * (x[to] - x[from]) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_reported_is_within_the_change() {
        let x: Vec<f64> = (0..300).map(|k| (f64::from(k) * 0.1).sin()).collect();
        let held = reported(&x, 0.3);
        assert!(x.iter().zip(&held).all(|(a, b)| (a - b).abs() <= 0.3));
        assert!(held.windows(2).filter(|w| w[0] == w[1]).count() > 150);
        assert_eq!(reported(&x, 0.0), x);
    }

    #[test]
    fn what_comes_back_is_within_the_deviation() {
        let x: Vec<f64> = (0..500).map(|k| (f64::from(k * k) * 0.01).sin() * 3.0).collect();
        let back = swinging_door(&x, 0.2);
        assert_eq!(back.len(), x.len());
        assert!(x.iter().zip(&back).all(|(a, b)| (a - b).abs() <= 0.2 + 1e-12));
        let kept = x.iter().zip(&back).filter(|(a, b)| a == b).count();
        assert!((50..450).contains(&kept), "{kept}");
        assert_eq!(swinging_door(&x, 0.0).len(), x.len());
        assert!(swinging_door(&[], 1.0).is_empty());
    }
}
