//! Exact flow of a slip under constant Coulomb and viscous friction.
//!
//! `M x'' + Fv x' + k x = f + q s + c (exp(mu s) - 1)`, where `x` and `s` count from the start of the segment, `f`
//! is the net force there, `q` the slope of the driving force and the last term the settling of a lagged one. The
//! solution is closed: `x = a0 + a1 s + Q exp(mu s) + A C(s) + B S(s)` with the free responses `S(s) = (exp(l1 s) -
//! exp(l2 s)) / (l1 - l2)` and `C(s) = exp(l1 s) - l1 S(s)`, or their oscillating counterparts.

use crate::numeric::roots::{crossing, first_fall};

/// Mass, damping and spring of the moving stem.
#[derive(Debug, Clone, Copy)]
pub(super) struct Oscillator {
    pub(super) mass: f64,
    pub(super) damping: f64,
    pub(super) spring: f64,
}

/// Drive: net force at `s = 0`, its slope, and the part that settles as `settling (exp(decay s) - 1)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forcing {
    pub(super) net: f64,
    pub(super) slope: f64,
    pub(super) settling: f64,
    pub(super) decay: f64,
}

/// The closed solution from given velocity and zero displacement.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinearFlow {
    modes: Modes,
    spring_over_mass: f64,
    offset: f64,
    drift: f64,
    lagged: f64,
    decay: f64,
    by_c: f64,
    by_s: f64,
}

#[derive(Debug, Clone, Copy)]
enum Modes {
    /// `exp(slow s)` and `exp(fast s)`, both negative, `fast <= slow`.
    Real { slow: f64, fast: f64 },
    /// `exp(rate s)` times a sine of angular frequency `omega`.
    Oscillating { rate: f64, omega: f64 },
}

impl Modes {
    /// `C` is not needed alone: the state is `A C + B S`; this gives `(C, S, S')`.
    fn at(self, s: f64) -> (f64, f64, f64) {
        match self {
            Self::Real { slow, fast } => {
                let split = slow - fast;
                let slow_part = (slow * s).exp();
                let impulse = if split == 0.0 {
                    s * slow_part
                } else {
                    slow_part * -(-split * s).exp_m1() / split
                };
                (slow_part - slow * impulse, impulse, (fast * s).exp() + slow * impulse)
            }
            Self::Oscillating { rate, omega } => {
                let envelope = (rate * s).exp();
                let (sin, cos) = (omega * s).sin_cos();
                let impulse = envelope * sin / omega;
                let cos = envelope * cos;
                (cos - rate * impulse, impulse, cos + rate * impulse)
            }
        }
    }
}

impl LinearFlow {
    /// The flow from velocity `v0`; `None` if the lag is so close to a mode of the stem that the closed form would be
    /// inaccurate.
    pub(super) fn new(body: Oscillator, forcing: Forcing, v0: f64) -> Option<Self> {
        const NEAR_RESONANCE: f64 = 1e-3;
        let Oscillator { mass, damping, spring } = body;
        let mu = forcing.decay;
        let lagged = if forcing.settling == 0.0 {
            0.0
        } else {
            let stiffness = (mass * mu + damping) * mu + spring;
            let size = mass * mu * mu - damping * mu + spring;
            if stiffness.abs() < NEAR_RESONANCE * size {
                return None;
            }
            forcing.settling / stiffness
        };
        let drift = forcing.slope / spring;
        let offset = (forcing.net - forcing.settling - damping * drift) / spring;
        let rate = -0.5 * damping / mass;
        let discriminant = rate * rate - spring / mass;
        let modes = if discriminant >= 0.0 {
            let fast = rate - discriminant.sqrt();
            Modes::Real { slow: spring / (mass * fast), fast }
        } else {
            Modes::Oscillating { rate, omega: (-discriminant).sqrt() }
        };
        Some(Self {
            modes,
            spring_over_mass: spring / mass,
            offset,
            drift,
            lagged,
            decay: mu,
            by_c: -offset - lagged,
            by_s: v0 - drift - lagged * mu,
        })
    }

    /// Displacement after `s`.
    pub(super) fn displacement(&self, s: f64) -> f64 {
        let (c, impulse, _) = self.modes.at(s);
        self.offset
            + self.drift * s
            + self.lagged * (self.decay * s).exp()
            + self.by_c * c
            + self.by_s * impulse
    }

    /// Velocity after `s`.
    pub(super) fn velocity(&self, s: f64) -> f64 {
        let (_, impulse, rate) = self.modes.at(s);
        self.drift + self.lagged * self.decay * (self.decay * s).exp()
            - self.by_c * self.spring_over_mass * impulse
            + self.by_s * rate
    }

    /// The free part of the acceleration at `s = 0` and its rate of change there.
    fn free_acceleration(&self) -> (f64, f64) {
        let damping_over_mass = match self.modes {
            Modes::Real { slow, fast } => -(slow + fast),
            Modes::Oscillating { rate, .. } => -2.0 * rate,
        };
        let velocity = self.by_s;
        let acceleration = -self.spring_over_mass * self.by_c - damping_over_mass * velocity;
        let jerk = -self.spring_over_mass * velocity - damping_over_mass * acceleration;
        (acceleration, jerk)
    }

    /// Acceleration after `s`.
    fn acceleration(&self, s: f64) -> f64 {
        let (a, jerk) = self.free_acceleration();
        let (c, impulse, _) = self.modes.at(s);
        self.lagged * self.decay * self.decay * (self.decay * s).exp() + a * c + jerk * impulse
    }

    /// The time at which the velocity in `direction` (+1 or -1), initially not below `level`, first falls below it
    /// on `[0, end]`.
    pub(super) fn velocity_falls(&self, direction: f64, level: f64, end: f64) -> Option<f64> {
        // A velocity that differs from the level by rounding alone has not fallen.
        let rounding =
            1e-14 * (self.drift.abs() + (self.lagged * self.decay).abs() + self.by_s.abs());
        let excess = |s: f64| direction * self.velocity(s) - level + rounding;
        match self.modes {
            Modes::Real { slow, fast } => {
                // An acceleration of real exponentials: times exp(-slow s) it is monotone on either side of one
                // point. So it vanishes at most once on either side, and between its zeros the velocity is
                // monotone. Hence no fall is missed.
                let (a, jerk) = self.free_acceleration();
                let lag_part = self.lagged * self.decay * self.decay * (self.decay - slow);
                let fast_part = jerk - slow * a;
                let bend = (-fast_part / lag_part).ln() / (self.decay - fast);
                let bend = if bend > 0.0 && bend < end { bend } else { end };
                // Multiplied by exp(-slow s), it keeps its sign where it would underflow.
                let acceleration = |s: f64| {
                    let split = slow - fast;
                    let impulse = if split == 0.0 { s } else { -(-split * s).exp_m1() / split };
                    let lag = self.lagged * self.decay * self.decay;
                    let lag = if lag == 0.0 { 0.0 } else { lag * ((self.decay - slow) * s).exp() };
                    lag + a + fast_part * impulse
                };
                let turns = [(0.0, bend), (bend, end)]
                    .map(|(from, to)| crossing(acceleration, from, to).unwrap_or(end));
                first_fall(excess, turns, end)
            }
            Modes::Oscillating { rate, omega } => {
                // Sixteen checks a period, and one at each turn between two of them.
                let look = std::f64::consts::PI / (8.0 * omega);
                let sine = (rate * self.by_s - self.spring_over_mass * self.by_c) / omega;
                let swing = self.by_s.hypot(sine);
                let mut from = 0.0;
                while from < end {
                    let to = (from + look).min(end);
                    let rises = |s: f64| direction * self.acceleration(s);
                    let turn = crossing(rises, from, to).map(|s| s - from);
                    let shifted = |s: f64| excess(from + s);
                    if let Some(s) = first_fall(shifted, turn, to - from) {
                        return Some(from + s);
                    }
                    // Once the transients cannot reach the level any more, no fall is possible.
                    let lag = (self.lagged * self.decay).abs() * (self.decay * to).exp();
                    if direction * self.drift - level > swing * (rate * to).exp() + lag {
                        return None;
                    }
                    from = to;
                }
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Forcing, LinearFlow, Oscillator};

    const DAMPINGS: [f64; 4] = [0.5, 19.9999999, 20.0, 400.0];

    fn flow(damping: f64) -> LinearFlow {
        let body = Oscillator { mass: 2.0, damping, spring: 50.0 };
        let forcing = Forcing { net: 3.0, slope: -4.0, settling: 5.0, decay: -0.7 };
        LinearFlow::new(body, forcing, 0.3).unwrap()
    }

    #[test]
    fn the_flow_solves_its_equation() {
        for damping in DAMPINGS {
            let flow = flow(damping);
            assert!(flow.displacement(0.0).abs() < 1e-15);
            assert!((flow.velocity(0.0) - 0.3).abs() < 1e-15);
            for s in [0.01, 0.3, 2.0] {
                let force = 3.0 - 4.0 * s + 5.0 * (-0.7_f64 * s).exp_m1();
                let balance = 2.0 * flow.acceleration(s)
                    + damping * flow.velocity(s)
                    + 50.0 * flow.displacement(s);
                assert!((balance - force).abs() < 1e-11, "{damping} {s}: {balance} {force}");
                let h = 1e-5;
                let slope = (flow.displacement(s + h) - flow.displacement(s - h)) / (2.0 * h);
                assert!((slope - flow.velocity(s)).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn no_fall_of_velocity_is_overlooked() {
        for damping in DAMPINGS {
            let flow = flow(damping);
            for level in [0.0, 0.1, 0.29] {
                let found = flow.velocity_falls(1.0, level, 10.0).unwrap();
                let scanned =
                    (1..).map(|i| f64::from(i) * 1e-5).find(|s| flow.velocity(*s) < level).unwrap();
                assert!((found - scanned).abs() <= 1e-5, "{damping} {level}: {found} {scanned}");
                assert!((flow.velocity(found) - level).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn a_fall_long_before_the_end_is_found() {
        for direction in [1.0, -1.0] {
            let body = Oscillator { mass: 1.36, damping: 548.9, spring: 52_500.0 };
            let forcing = Forcing { net: 0.0, slope: 0.0, settling: 0.0, decay: 0.0 };
            let flow = LinearFlow::new(body, forcing, 0.5 * direction).unwrap();
            let short = flow.velocity_falls(direction, 0.0, 0.05).unwrap();
            assert_eq!(flow.velocity_falls(direction, 0.0, 50.0), Some(short));
        }
    }

    #[test]
    fn a_lag_in_resonance_is_refused() {
        let body = Oscillator { mass: 1.0, damping: 3.0, spring: 2.0 };
        let forcing = Forcing { net: 0.0, slope: 0.0, settling: 1.0, decay: -1.0 };
        assert!(LinearFlow::new(body, forcing, 0.0).is_none());
    }
}
