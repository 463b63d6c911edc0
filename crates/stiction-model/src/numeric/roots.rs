//! Bracketed root-finding.

/// A root of `f` between `a` and `b`, where `f(a)` and `f(b)` differ in sign or one of them is 0.
///
/// Chandrupatla's method (Adv. Eng. Software 28 (1997) 145-149, recalled): inverse quadratic interpolation if that
/// is safe, else bisection, to the last bits of the bracket.
pub fn bracketed(mut f: impl FnMut(f64) -> f64, a: f64, b: f64) -> f64 {
    const MAX_ITERATIONS: usize = 200;
    let (mut x1, mut x2) = (b, a);
    let (mut f1, mut f2) = (f(b), f(a));
    if f2 == 0.0 {
        return a;
    }
    let mut t = 0.5;
    for _ in 0..MAX_ITERATIONS {
        let x = x1 + t * (x2 - x1);
        let fx = f(x);
        let (x3, f3);
        if (fx > 0.0) == (f1 > 0.0) {
            (x3, f3) = (x1, f1);
        } else {
            (x3, f3) = (x2, f2);
            (x2, f2) = (x1, f1);
        }
        (x1, f1) = (x, fx);
        let best = if f2.abs() < f1.abs() { x2 } else { x1 };
        let width = (x2 - x1).abs();
        let limit = f64::EPSILON * best.abs().max(f64::MIN_POSITIVE);
        if fx == 0.0 || width <= 2.0 * limit {
            return best;
        }
        let xi = (x1 - x2) / (x3 - x2);
        let phi = (f1 - f2) / (f3 - f2);
        t = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            f1 / (f2 - f1) * f3 / (f2 - f3)
                + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        } else {
            0.5
        };
        let least = (limit / width).min(0.5);
        t = t.clamp(least, 1.0 - least);
    }
    x1
}

/// The root of `f` between `a` and `b`, if `f` changes sign between them.
pub fn crossing(mut f: impl FnMut(f64) -> f64, a: f64, b: f64) -> Option<f64> {
    (a < b && (f(a) > 0.0) != (f(b) > 0.0)).then(|| bracketed(f, a, b))
}

/// The first point at which `f` falls below 0 on `[0, end]`; 0 if it is below from the start, `None` if never.
///
/// `f` must be monotone between successive `nodes`, which are in ascending order. Points outside `(0, end)` are
/// ignored.
pub fn first_fall(
    mut f: impl FnMut(f64) -> f64,
    nodes: impl IntoIterator<Item = f64>,
    end: f64,
) -> Option<f64> {
    let mut before = 0.0;
    if f(before) < 0.0 {
        return Some(before);
    }
    for node in nodes.into_iter().filter(|s| *s > 0.0 && *s < end).chain([end]) {
        if f(node) < 0.0 {
            return Some(bracketed(&mut f, before, node));
        }
        before = node;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{bracketed, first_fall};

    #[test]
    fn roots_are_found_to_the_last_bits() {
        let root = bracketed(|x| x * x - 2.0, 0.0, 2.0);
        assert!((root - 2.0_f64.sqrt()).abs() <= 4e-16);
        let steep = bracketed(|x| (1e6 * (x - 0.3)).exp_m1().min(1e9), 0.0, 1.0);
        assert!((steep - 0.3).abs() <= 1e-15);
        assert_eq!(bracketed(|x| x, 0.0, 1.0), 0.0);
        let flat = bracketed(|x| (x - 0.7).powi(3), 0.0, 1.0);
        assert!((flat - 0.7).abs() <= 1e-5);
    }

    #[test]
    fn only_falls_count() {
        let wave = |s: f64| (s + 0.1).sin();
        let pi = std::f64::consts::PI;
        let nodes = [pi / 2.0 - 0.1, 1.5 * pi - 0.1];
        let found = first_fall(wave, nodes, 6.0).unwrap();
        assert!((found - (pi - 0.1)).abs() < 1e-14);
        assert_eq!(first_fall(wave, nodes, 2.0), None);
    }
}
