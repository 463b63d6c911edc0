//! Slugs from a riser.

use super::parts::Parts;
use super::sketch::Sketch;
use stiction_model::closed_loop::NormalStream;

/// Gas and liquid come up a pipe through the valve. Beyond an opening the liquid gathers at the foot of the pipe until
/// the gas blows it out, over and over. A smaller opening chokes the pipe, and the slugs fade away. It is van der
/// Pol's oscillator, whose growth depends on the opening: a limit cycle of the process.
pub(super) struct Slugging {
    /// The opening at which slugs begin, and the further opening to the largest slugs, percent from rest.
    onset: f64,
    width: f64,
    /// Angular frequency, radians a step, growth, and half the amplitude of the largest slugs, percent.
    w: f64,
    growth: f64,
    half: f64,
    /// Present flow of the slugs, and its change per step.
    slug: f64,
    speed: f64,
    noise: NormalStream,
    /// Start of the record, number of its steps, and number of its steps with an opening beyond the onset.
    begins: usize,
    recorded: usize,
    slugging: usize,
}

impl Slugging {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        Self {
            onset: sketch.size * draw.uniform(-0.7, 0.3),
            width: sketch.size * draw.log(0.2, 1.0),
            w: std::f64::consts::TAU / sketch.period,
            growth: draw.log(0.2, 1.5),
            half: 0.5 * sketch.size * draw.log(0.2, 1.0),
            slug: 0.0,
            speed: 0.0,
            noise: NormalStream::new(draw.seed()),
            begins: sketch.warm_up(),
            recorded: sketch.recorded(),
            slugging: 0,
        }
    }
}

impl Parts for Slugging {
    fn flow(&mut self, k: usize, stem: f64) -> f64 {
        let grows = ((stem - self.onset) / self.width).clamp(-1.0, 1.0);
        self.slugging += usize::from(grows > 0.0 && k >= self.begins);
        let (w, size) = (self.w, self.slug / self.half);
        // Bubbles start it. Semi-implicit Euler keeps the frequency.
        self.speed += w * self.growth * (grows - size * size) * self.speed - w * w * self.slug
            + 0.01 * w * self.half * self.noise.draw();
        self.slug += self.speed;
        stem + self.slug
    }

    fn shows(&self) -> bool {
        self.slugging as f64 >= 0.15 * self.recorded as f64
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn slugs_of_one_size_come_at_a_large_opening_and_fade_at_a_small_one() {
        for (seed, sketch) in sketches(Invention::Slugging) {
            let mut parts = Slugging::of(&sketch);
            let cycles = |n: f64| (n * sketch.period) as usize;
            // The largest slug in some cycles after twenty others.
            let mut largest = |stem: f64| {
                (0..cycles(20.0)).for_each(|k| {
                    parts.flow(k, stem);
                });
                let slug = (0..cycles(3.0)).map(|k| (parts.flow(k, stem) - stem).abs());
                slug.fold(0.0, f64::max) / parts.half
            };
            let (large, small) = (sketch.size * 3.0, sketch.size * -3.0);
            let (open, shut, again) = (largest(large), largest(small), largest(large));
            assert!((1.8..2.4).contains(&open) && shut < 0.5, "{seed}: {open} {shut}");
            assert!((again - open).abs() < 0.3, "{seed}: {again} after {open}");
        }
    }
}
