//! The smallest value of a function of a few numbers between bounds, without derivatives.
//!
//! The simplex of J. A. Nelder and R. Mead, A simplex method for function minimization, The Computer Journal 7 (1965)
//! 308-313 (recalled, not read), with its usual coefficients: reflection 1, expansion 2, contraction and shrinkage one
//! half. A point beyond a bound is moved onto the bound, which may flatten the simplex there. In that case, restart
//! from the result.

/// The result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Minimum<const N: usize> {
    /// Position.
    pub at: [f64; N],
    /// The value there.
    pub value: f64,
}

/// The smallest value of `f` around `start`, each number between its `bounds` (low, high).
///
/// The first simplex extends from `start` by `size` along each number, or in the opposite direction if a bound is too
/// near. The search ends when the simplex is `tolerance` times as large as `size` along every number, or after the
/// iteration in which `evaluations` of `f` are used up. A value that is NaN counts as infinite. The same input gives
/// the same bits.
pub fn minimise<const N: usize>(
    mut f: impl FnMut(&[f64; N]) -> f64,
    start: [f64; N],
    size: [f64; N],
    bounds: [(f64, f64); N],
    tolerance: f64,
    evaluations: usize,
) -> Minimum<N> {
    let asked = std::cell::Cell::new(0);
    let mut ask = |at: [f64; N]| {
        asked.set(asked.get() + 1);
        let at: [f64; N] = std::array::from_fn(|i| at[i].max(bounds[i].0).min(bounds[i].1));
        let value = f(&at);
        Minimum { at, value: if value.is_nan() { f64::INFINITY } else { value } }
    };
    let mut simplex = vec![ask(start)];
    for i in 0..N {
        let mut corner = simplex[0].at;
        let within = (bounds[i].0..=bounds[i].1).contains(&(corner[i] + size[i]));
        corner[i] += if within { size[i] } else { -size[i] };
        simplex.push(ask(corner));
    }
    loop {
        // A stable sort, so that equals keep their order.
        simplex.sort_by(|a, b| a.value.total_cmp(&b.value));
        let (best, second_worst, worst) = (simplex[0], simplex[N - 1], simplex[N]);
        let near = |p: &Minimum<N>| {
            (0..N).all(|i| (p.at[i] - best.at[i]).abs() <= tolerance * size[i].abs())
        };
        if simplex.iter().all(near) || asked.get() >= evaluations {
            return best;
        }
        let middle: [f64; N] =
            std::array::from_fn(|i| simplex[..N].iter().map(|p| p.at[i]).sum::<f64>() / N as f64);
        let along = |by: f64| std::array::from_fn(|i| middle[i] + by * (worst.at[i] - middle[i]));
        let reflected = ask(along(-1.0));
        if reflected.value < best.value {
            let expanded = ask(along(-2.0));
            simplex[N] = if expanded.value < reflected.value { expanded } else { reflected };
        } else if reflected.value < second_worst.value {
            simplex[N] = reflected;
        } else {
            let contracted = ask(along(if reflected.value < worst.value { -0.5 } else { 0.5 }));
            if contracted.value < worst.value.min(reflected.value) {
                simplex[N] = contracted;
            } else {
                for p in &mut simplex[1..] {
                    *p = ask(std::array::from_fn(|i| 0.5 * (best.at[i] + p.at[i])));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: [(f64, f64); 2] = [(-10.0, 10.0); 2];

    fn rosenbrock(x: &[f64; 2]) -> f64 {
        (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2)
    }

    #[test]
    fn the_bottom_of_a_bowl_is_found() {
        let bowl = |x: &[f64; 3]| {
            (x[0] - 1.0).powi(2) + 4.0 * (x[1] + 2.0).powi(2) + 0.25 * (x[2] - x[0]).powi(2) + 7.0
        };
        let found = minimise(bowl, [4.0, 4.0, -4.0], [1.0; 3], [(-10.0, 10.0); 3], 1e-7, 1000);
        for (x, known) in found.at.iter().zip([1.0, -2.0, 1.0]) {
            assert!((x - known).abs() < 1e-5, "{found:?}");
        }
        assert!((found.value - 7.0).abs() < 1e-9);
    }

    #[test]
    fn a_bent_valley_is_followed_to_its_end() {
        let found = minimise(rosenbrock, [-1.2, 1.0], [0.5; 2], FREE, 1e-8, 1000);
        assert!((found.at[0] - 1.0).abs() < 1e-6 && (found.at[1] - 1.0).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_bound_in_the_way_is_kept_and_reached() {
        // On x <= 1/2 the least value is (1 - x)^2 = 1/4, on the bound and at y = x^2.
        let bounds = [(-10.0, 0.5), (-10.0, 10.0)];
        let first = minimise(rosenbrock, [-1.2, 1.0], [0.5; 2], bounds, 1e-8, 1000);
        let found = minimise(rosenbrock, first.at, [0.5; 2], bounds, 1e-8, 1000);
        assert!(found.at[0] <= 0.5);
        assert!((found.at[0] - 0.5).abs() < 1e-6 && (found.at[1] - 0.25).abs() < 1e-6, "{found:?}");
        assert!((found.value - 0.25).abs() < 1e-6);
    }

    #[test]
    fn it_asks_no_oftener_than_allowed_and_takes_nothing_for_a_number_that_is_none() {
        let mut asked = 0;
        let holed = |x: &[f64; 2]| {
            asked += 1;
            if x[0] < 0.0 { f64::NAN } else { rosenbrock(x) }
        };
        let found = minimise(holed, [3.0, 3.0], [0.5; 2], FREE, 0.0, 60);
        // An iteration asks at most four times: reflected, contracted, two shrunk.
        assert!((60..64).contains(&asked), "{asked}");
        assert!(found.value.is_finite() && found.at[0] >= 0.0);
        assert!(found.value < rosenbrock(&[3.0, 3.0]));
    }
}
