//! Common parts of the laws with an inner deflection (Dahl, LuGre, GMS).

/// Largest number of elements of a law.
pub(crate) const ELEMENTS: usize = 3;

/// Friction force and rates of deflection; `rates[0]` and `rates[1]` are not used.
pub(crate) struct Response<const N: usize> {
    pub(crate) force_n: f64,
    pub(crate) rates: [f64; N],
}

/// Derivatives of a [`Response`] with respect to the state.
pub(crate) struct Gradient<const N: usize> {
    pub(crate) force: [f64; N],
    pub(crate) rates: [[f64; N]; N],
}

/// A friction law over the state `[position, velocity, deflections...]`.
///
/// `direction` (+1 or -1) replaces `sgn v`, so that each formula is smooth through zero velocity. The simulation
/// changes it when the velocity changes sign.
pub(crate) trait BristleLaw<const N: usize> {
    fn response(&self, y: &[f64; N], direction: f64) -> Response<N>;

    fn gradient(&self, y: &[f64; N], direction: f64) -> Gradient<N>;

    /// The deflections (in a state otherwise zero) that carry `force_n` at rest, as far as they can.
    fn carrying(&self, force_n: f64) -> [f64; N];

    /// Typical size of each deflection, m: the scale of its error tolerance.
    fn deflection_scale(&self) -> [f64; N];

    /// Distance of each sticking element from slipping, N; infinite for other elements.
    fn stick_margins(&self, _y: &[f64; N], _direction: f64) -> [f64; ELEMENTS] {
        [f64::INFINITY; ELEMENTS]
    }

    /// Lets an element slip.
    fn loosen(&mut self, _element: usize) {}

    /// Which elements slip.
    fn slipping(&self) -> [bool; ELEMENTS] {
        [false; ELEMENTS]
    }

    /// Makes all elements stick, as they do when the velocity changes sign.
    fn stick_all(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::super::{Classical, Dahl, Gms, GmsElement, GmsInUse, LuGre};
    use super::BristleLaw;

    /// Compares the gradient with central differences at a state of typical size.
    fn check<const N: usize>(law: &impl BristleLaw<N>) {
        for direction in [1.0, -1.0] {
            let mut y = law.deflection_scale().map(|z| 0.6 * direction * z);
            y[1] = 4e-4 * direction;
            let gradient = law.gradient(&y, direction);
            for j in 1..N {
                let h = 1e-5 * y[j].abs();
                let at = |shift: f64| {
                    let mut y = y;
                    y[j] += shift;
                    law.response(&y, direction)
                };
                let (above, below) = (at(h), at(-h));
                let close = |found: f64, expected: f64, what: &str| {
                    let error = (found - expected).abs();
                    assert!(error <= 1e-5 * expected.abs(), "{what} {j}: {found} {expected}");
                };
                let slope = (above.force_n - below.force_n) / (2.0 * h);
                close(slope, gradient.force[j], "force");
                for i in 2..N {
                    let slope = (above.rates[i] - below.rates[i]) / (2.0 * h);
                    close(slope, gradient.rates[i][j], "rate");
                }
            }
        }
    }

    #[test]
    fn gradients_are_derivatives() {
        let steady = Classical::new(780.0, 700.0, 125_000.0, 5e-4).unwrap();
        check(&Dahl::new(700.0, 2.6e7, 125_000.0).unwrap());
        check(&LuGre::new(steady, 2.6e7, 2e4).unwrap());
        let element = |stiffness_n_per_m: f64, share: f64| GmsElement {
            stiffness_n_per_m,
            damping_n_s_per_m: 2e3,
            share,
        };
        let elements = [element(2.9e7, 0.5), element(1.5e7, 0.3), element(3e6, 0.2)];
        let mut gms = GmsInUse::new(Gms::new(steady, 2e4, &elements).unwrap());
        check(&gms);
        gms.loosen(0);
        gms.loosen(2);
        check(&gms);
        gms.stick_all();
        check(&gms);
    }
}
