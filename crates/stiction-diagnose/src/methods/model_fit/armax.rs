//! An ARX or ARMAX model of one input.
//!
//! ```text
//! y(k) = c + sum_i a_i y(k-i) + sum_j b_j x(k-d-j) + sum_l c_l e(k-l) + e(k)
//! ```
//! The errors of the moving average come from a longer ARX model, so only two least-squares problems remain (E. J.
//! Hannan, J. Rissanen, Biometrika 69 (1982) 81-94; recalled, not read).

use crate::identify::arx::TAPS;
use crate::numeric::least_squares::{Solution, least_squares};

/// Number of past values of PV and input, and of past errors, in a model.
#[derive(Clone, Copy)]
pub(super) struct Orders {
    pub past: usize,
    pub taps: usize,
    pub errors: usize,
}

/// Additional past values, taps and delays of the longer model.
const LONGER: usize = 3;

/// Fits `y` from the sample `first` on; `None` if that fails or there are too few samples.
pub(super) fn armax(
    x: &[f64],
    y: &[f64],
    delay: usize,
    first: usize,
    orders: Orders,
) -> Option<Solution> {
    if orders.errors == 0 {
        return regress(x, y, delay, first, orders, &[]);
    }
    let longer = Orders { past: orders.past + LONGER, taps: orders.taps + LONGER, errors: 0 };
    let residual = regress(x, y, delay, first, longer, &[])?.residual;
    let mut errors = vec![0.0; first];
    errors.extend(residual);
    regress(x, y, delay, first, orders, &errors)
}

/// Of the delays from `delay` on, as many as a model of order five has taps, the delay whose ARX model of these orders
/// has the smallest mean square error, and that error.
pub(super) fn near(
    x: &[f64],
    y: &[f64],
    delay: usize,
    first: usize,
    orders: Orders,
) -> Option<(usize, f64)> {
    let orders = Orders { errors: 0, ..orders };
    let tried = (delay..delay + TAPS).filter_map(|d| {
        let found = armax(x, y, d, first, orders)?;
        Some((d, found.sse / found.residual.len() as f64))
    });
    tried.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The first sample that a model of these orders can predict, up to some delay of a model of order five.
pub(super) fn first(delay: usize, orders: Orders) -> usize {
    let delay = delay + TAPS;
    let longer = if orders.errors > 0 { LONGER } else { 0 };
    (orders.past + longer).max(delay + orders.taps + longer).max(orders.errors)
}

fn regress(
    x: &[f64],
    y: &[f64],
    delay: usize,
    first: usize,
    orders: Orders,
    errors: &[f64],
) -> Option<Solution> {
    let n = y.len();
    let columns = 1 + orders.past + orders.taps + orders.errors;
    if first < orders.past.max(delay + orders.taps - 1) || n < first + 3 * columns {
        return None;
    }
    let constant = vec![1.0; n - first];
    let mut all: Vec<&[f64]> = vec![&constant];
    all.extend((1..=orders.past).map(|i| &y[first - i..n - i]));
    all.extend((delay..delay + orders.taps).map(|i| &x[first - i..n - i]));
    all.extend((1..=orders.errors).map(|i| &errors[first - i..n - i]));
    least_squares(&all, &y[first..])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

    #[test]
    fn known_coefficients_are_found_with_coloured_errors() {
        let mut noise = NormalStream::new(9);
        let x: Vec<f64> = (0..4000).map(|_| noise.draw()).collect();
        let (mut y, mut before) = (vec![0.0; 4000], 0.0);
        for k in 4..4000 {
            let e = 0.3 * noise.draw();
            y[k] = 1.2 * y[k - 1] - 0.4 * y[k - 2] + 0.5 * x[k - 3] - 0.2 * x[k - 4]
                + e
                + 0.7 * before;
            before = e;
        }
        let orders = Orders { past: 2, taps: 2, errors: 1 };
        let found = armax(&x, &y, 3, first(3, orders), orders).unwrap();
        for (found, known) in found.coefficients[1..].iter().zip([1.2, -0.4, 0.5, -0.2, 0.7]) {
            assert!((found - known).abs() < 0.05, "{found} {known}");
        }
        let mse = found.sse / found.residual.len() as f64;
        assert!((mse / 0.09 - 1.0).abs() < 0.1, "{mse}");
    }
}
