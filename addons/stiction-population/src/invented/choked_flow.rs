//! A choked flow.

use super::parts::Parts;
use super::sketch::Sketch;
use stiction_model::closed_loop::NormalStream;

/// Above an opening the valve adds only a small share to the flow; the opening wanders with the pressure upstream.
pub(super) struct ChokedFlow {
    /// The mean opening, percent from rest, and its present value.
    mean: f64,
    at: f64,
    /// Its deviation, and the share that remains from step to step.
    size: f64,
    keep: f64,
    noise: NormalStream,
    /// Flow per percent of opening above the wandering opening.
    share: f64,
    /// Start of the record, number of its steps, and number of its choked steps.
    begins: usize,
    recorded: usize,
    choked: usize,
}

impl ChokedFlow {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let mean = sketch.size * draw.uniform(0.0, 1.0);
        Self {
            mean,
            at: mean,
            size: sketch.size * draw.log(0.05, 0.4),
            keep: 1.0 - 1.0 / (sketch.period * draw.log(0.5, 5.0)),
            noise: NormalStream::new(draw.seed()),
            share: draw.log(0.03, 0.3),
            begins: sketch.warm_up(),
            recorded: sketch.recorded(),
            choked: 0,
        }
    }
}

impl Parts for ChokedFlow {
    fn flow(&mut self, k: usize, stem: f64) -> f64 {
        let push = (1.0 - self.keep * self.keep).sqrt() * self.size * self.noise.draw();
        self.at = self.mean + self.keep * (self.at - self.mean) + push;
        let beyond = (stem - self.at).max(0.0);
        self.choked += usize::from(beyond > 0.0 && k >= self.begins);
        stem - beyond + self.share * beyond
    }

    fn shows(&self) -> bool {
        let share = self.choked as f64 / self.recorded as f64;
        (0.03..0.5).contains(&share)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketch, sketches};
    use super::*;

    #[test]
    fn what_opens_further_than_the_choke_adds_little() {
        for (_, sketch) in sketches(Invention::ChokedFlow) {
            let mut parts = ChokedFlow::of(&sketch);
            parts.size = 0.0;
            let mut slope = |from: f64| {
                let low = parts.flow(0, parts.mean + from);
                parts.flow(0, parts.mean + from + 1.0) - low
            };
            let (below, above) = (slope(-2.0), slope(1.0));
            assert!(
                (below - 1.0).abs() < 1e-9 && (0.029..0.31).contains(&above),
                "{below} {above}"
            );
        }
    }

    #[test]
    fn the_choke_wanders_by_as_much_as_is_drawn() {
        let sketch = sketch(Invention::ChokedFlow, 3);
        let mut parts = ChokedFlow::of(&sketch);
        parts.keep = 0.99;
        let n = 200_000;
        let square = (0..n).map(|k| {
            parts.flow(k, 0.0);
            (parts.at - parts.mean).powi(2)
        });
        let spread = (square.sum::<f64>() / n as f64).sqrt();
        assert!((spread / parts.size - 1.0).abs() < 0.1, "{spread} for {}", parts.size);
    }
}
