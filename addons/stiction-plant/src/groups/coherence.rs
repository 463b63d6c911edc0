//! Whether two loops swing in step all the time.
//!
//! # Coherence
//! Of the pieces `X_k`, `Y_k` of two loops in one band
//! ```text
//! C2 = |sum X_k conj(Y_k)|^2 / (sum |X_k|^2 sum |Y_k|^2)
//! ```
//! A constant phase between them counts, a phase that turns from piece to piece does not. Two valves with periods of 300 s and
//! 301 s are in step for an hour, but not for a day.
//!
//! # By chance
//! For unrelated loops with `K` independent pieces, `P(C2 > c) = (1 - c)^(K - 1)`. The pieces of a steady swing depend
//! on each other. They therefore count as fewer,
//! ```text
//! K' = K / (1 + 2 sum (1 - m/K) |rho_x(m)| |rho_y(m)|)
//! ```
//! after Bartlett's variance of a sum of products, where `rho` are the memories of the two. Two exact clocks count for one piece:
//! if their periods are equal, they are always in step. Then the evidence is that the periods are equal. Periods of unrelated
//! swings are spread over a range `r`, see [`SPREAD`]. Two frequencies differ by less than `x/T` in a share `2 x/(T f r)` of cases,
//! and the coherence of two clocks at that distance is `(sin(pi x) / (pi x))^2`, at most `1 / (pi x)^2`. Wider lines overlap more
//! often in proportion. So
//! ```text
//! p = min(1, K' / (T f r) * 2 / (pi C)) (1 - C2)^(K' - 1)
//! ```

use super::bank::{FEWEST, Pieces};

/// The range of the periods of unrelated loops, as the logarithm of a factor; ours.
pub const SPREAD: f64 = 0.5;

/// What two loops have in common in a band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coherence {
    /// Squared magnitude of the coherence, 0 to 1.
    pub squared: f64,
    /// The number of independent pieces it is worth.
    pub pieces: f64,
    /// The probability of as much or more by chance.
    pub p: f64,
}

/// The coherence of two loops in a band in which they swing `cycles` times in total; `None` if too few pieces of both
/// loops are known.
pub fn coherence(x: &Pieces, y: &Pieces, cycles: f64) -> Option<Coherence> {
    let (mut re, mut im, mut xx, mut yy, mut k) = (0.0f64, 0.0f64, 0.0f64, 0.0f64, 0usize);
    for (a, b) in x.values.iter().zip(&y.values) {
        let (pa, pb) = (a.norm_sqr(), b.norm_sqr());
        // Unknown values are zero.
        if pa > 0.0 && pb > 0.0 {
            let product = a * b.conj();
            re += f64::from(product.re);
            im += f64::from(product.im);
            xx += f64::from(pa);
            yy += f64::from(pb);
            k += 1;
        }
    }
    if k < FEWEST {
        return None;
    }
    let squared = ((re * re + im * im) / (xx * yy)).min(1.0);
    let n = k as f64;
    let mut lags = 0.0f64;
    for (m, (a, b)) in x.memory.iter().zip(&y.memory).enumerate().take(k - 1) {
        lags += (1.0 - (m + 1) as f64 / n) * f64::from(a * b);
    }
    let pieces = (n / (1.0 + 2.0 * lags)).max(1.0);
    let near = 2.0 / (std::f64::consts::PI * squared.sqrt());
    let of_one_period = (pieces / (cycles * SPREAD) * near).min(1.0);
    // Values have this many digits only.
    let p = of_one_period * (1.0 - squared).max(1e-6).powf(pieces - 1.0);
    Some(Coherence { squared, pieces, p })
}

/// The largest p that counts if a share `rate` of the accepted pairs may be chance, by the step-up procedure of
/// Benjamini and Hochberg. `all` is the number of tests, `p` are the probabilities below one.
pub fn threshold(mut p: Vec<f64>, all: usize, rate: f64) -> f64 {
    p.sort_by(f64::total_cmp);
    let allowed = |(k, p): (usize, &f64)| (*p <= rate * (k + 1) as f64 / all as f64).then_some(*p);
    p.iter().enumerate().filter_map(allowed).next_back().unwrap_or(-1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use realfft::num_complex::Complex;
    use stiction_model::closed_loop::NormalStream;

    fn noise(k: usize, seed: u64) -> Vec<Complex<f32>> {
        let mut draws = NormalStream::new(seed);
        (0..k).map(|_| Complex::new(draws.draw() as f32, draws.draw() as f32)).collect()
    }

    #[test]
    fn of_known_parts_it_is_their_share() {
        let (common, own) = (noise(20_000, 1), noise(20_000, 2));
        // Half of the power is common, and late by a right angle.
        let mixed = common.iter().zip(&own).map(|(c, o)| c * Complex::i() + o).collect();
        let found = coherence(&Pieces::of(common), &Pieces::of(mixed), 1e6).unwrap();
        assert!((found.squared - 0.5).abs() < 0.02, "{found:?}");
        assert!(found.p < 1e-100 && found.pieces > 18_000.0, "{found:?}");
    }

    #[test]
    fn by_chance_it_is_as_rare_as_is_reported() {
        for (memory, seed) in [(0.0f32, 1u64), (0.8, 2)] {
            let loops: Vec<Pieces> = (0..400)
                .map(|k| {
                    let mut values = noise(300, 1000 * seed + k);
                    for k in 1..values.len() {
                        values[k] =
                            values[k - 1] * memory + values[k] * (1.0 - memory * memory).sqrt();
                    }
                    Pieces::of(values)
                })
                .collect();
            let mut counts = [0.0; 3];
            let mut all = 0.0;
            for (k, x) in loops.iter().enumerate() {
                for y in &loops[..k] {
                    let p = coherence(x, y, 1.0).unwrap().p;
                    all += 1.0;
                    for (count, level) in counts.iter_mut().zip([0.1, 0.01, 0.001]) {
                        *count += f64::from(u8::from(p <= level));
                    }
                }
            }
            let shares = counts.map(|count| count / all);
            for (share, level) in shares.iter().zip([0.1, 0.01, 0.001]) {
                assert!((0.3 * level..1.3 * level).contains(share), "{memory}: {shares:?}");
            }
        }
    }

    #[test]
    fn clocks_of_nearly_one_period_are_not_in_step() {
        // Steady swings whose phase turns by so much from piece to piece.
        let clock = |turn: f64| {
            let value = |k: usize| Complex::from_polar(1.0f32, (turn * k as f64) as f32);
            Pieces::of((0..300).map(value).collect())
        };
        let apart = coherence(&clock(0.3), &clock(0.35), 2000.0).unwrap();
        assert!(apart.squared < 0.05 && apart.p > 3e-3, "{apart:?}");
        let one = coherence(&clock(0.3), &clock(0.3), 2000.0).unwrap();
        assert!(one.squared > 0.99 && one.pieces < 1.1 && (4e-4..2e-3).contains(&one.p), "{one:?}");
    }

    #[test]
    fn a_tenth_of_what_counts_may_be_chance() {
        // 0.004 and 0.009 are below 0.005 and 0.01; 0.03 is not below 0.015.
        assert_eq!(threshold(vec![0.03, 0.009, 0.004], 20, 0.1), 0.009);
        assert_eq!(threshold(vec![0.9], 20, 0.1), -1.0);
    }
}
