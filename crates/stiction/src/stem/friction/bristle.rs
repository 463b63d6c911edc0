//! What the laws with an inner deflection (Dahl, LuGre, GMS) have in common.

/// Most elements a law may have.
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
/// `direction` (+1 or -1) stands for `sgn v`, so that each formula is smooth through zero velocity;
/// the simulation changes it when the velocity does change sign.
pub(crate) trait BristleLaw<const N: usize> {
    fn response(&self, y: &[f64; N], direction: f64) -> Response<N>;

    fn gradient(&self, y: &[f64; N], direction: f64) -> Gradient<N>;

    /// The deflections (in a state otherwise zero) that carry `force_n` at rest, as far as they can.
    fn carrying(&self, force_n: f64) -> [f64; N];

    /// Typical size of each deflection, m: the scale of its error tolerance.
    fn deflection_scale(&self) -> [f64; N];

    /// How far each sticking element is from slipping, N; infinite where there is none.
    fn stick_margins(&self, _y: &[f64; N], _direction: f64) -> [f64; ELEMENTS] {
        [f64::INFINITY; ELEMENTS]
    }

    /// Lets an element slip.
    fn loosen(&mut self, _element: usize) {}

    /// Makes all elements stick, as they do when the velocity changes sign.
    fn stick_all(&mut self) {}
}
