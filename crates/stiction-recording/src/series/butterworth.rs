//! A low pass of the third order.

/// A Butterworth low pass of the third order by the bilinear transform, run forwards and backwards so that it has
/// no delay (its effective order is six). `cutoff` is a share of the Nyquist frequency, between 0 and 1; otherwise
/// the series is returned unchanged. The series is continued by its first and last sample.
pub fn low_passed(x: &[f64], cutoff: f64) -> Vec<f64> {
    if !(cutoff > 0.0 && cutoff < 1.0) || x.is_empty() {
        return x.to_vec();
    }
    // The analogue prototype 1 / ((s + 1)(s^2 + s + 1)), its frequency warped.
    let k = (std::f64::consts::FRAC_PI_2 * cutoff).tan();
    let first = Section { b: [k / (1.0 + k), k / (1.0 + k), 0.0], a: [(k - 1.0) / (k + 1.0), 0.0] };
    let d = 1.0 + k + k * k;
    let second = Section {
        b: [k * k / d, 2.0 * k * k / d, k * k / d],
        a: [2.0 * (k * k - 1.0) / d, (1.0 - k + k * k) / d],
    };
    let mut y = x.to_vec();
    for _ in 0..2 {
        first.run(&mut y);
        second.run(&mut y);
        y.reverse();
    }
    y
}

/// A filter of the second order, of gain one at frequency zero.
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

impl Section {
    /// Filters in place, from the rest at the first sample.
    fn run(&self, x: &mut [f64]) {
        let ([b0, b1, b2], [a1, a2]) = (self.b, self.a);
        let rest = x.first().copied().unwrap_or(0.0);
        let (mut z2, mut z1) = ((b2 - a2) * rest, (1.0 - b0) * rest);
        for v in x {
            let u = *v;
            *v = b0 * u + z1;
            z1 = b1 * u - a1 * *v + z2;
            z2 = b2 * u - a2 * *v;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_power_at_the_cutoff_each_way() {
        // Forwards and backwards, 1/sqrt(2) twice.
        let x: Vec<f64> =
            (0..4000).map(|k| (std::f64::consts::PI * 0.1 * f64::from(k)).sin()).collect();
        let y = low_passed(&x, 0.1);
        let ratio = y[1000..3000].iter().map(|v| v * v).sum::<f64>()
            / x[1000..3000].iter().map(|v| v * v).sum::<f64>();
        assert!((ratio.sqrt() - 0.5).abs() < 1e-6, "{ratio}");
        assert!(low_passed(&[3.0; 50], 0.1).iter().all(|v| (v - 3.0).abs() < 1e-12));
        assert_eq!(low_passed(&x, 1.0), x);
    }
}
