//! Numbers with optional derivatives.

use std::ops::{Add, Mul, Neg, Sub};

/// The number type of the flow: plain numbers, or [`Jet`]s.
pub(super) trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
{
    /// A constant.
    fn of(value: f64) -> Self;

    /// The number without its derivatives.
    fn value(self) -> f64;

    /// The largest of the number and its derivatives, without sign.
    fn size(self) -> f64;
}

impl Number for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn size(self) -> f64 {
        self.abs()
    }
}

/// A number and its derivatives with respect to `K` others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Jet<const K: usize> {
    pub(super) value: f64,
    pub(super) slope: [f64; K],
}

impl<const K: usize> Number for Jet<K> {
    #[inline(always)]
    fn of(value: f64) -> Self {
        Self { value, slope: [0.0; K] }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn size(self) -> f64 {
        self.slope.iter().fold(self.value.abs(), |size, slope| size.max(slope.abs()))
    }
}

impl<const K: usize> Add for Jet<K> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self.value += other.value;
        (0..K).for_each(|i| self.slope[i] += other.slope[i]);
        self
    }
}

impl<const K: usize> Sub for Jet<K> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self.value -= other.value;
        (0..K).for_each(|i| self.slope[i] -= other.slope[i]);
        self
    }
}

impl<const K: usize> Mul for Jet<K> {
    type Output = Self;
    #[inline(always)]
    #[allow(clippy::suspicious_arithmetic_impl)] // The product rule adds.
    fn mul(mut self, other: Self) -> Self {
        (0..K).for_each(|i| {
            self.slope[i] = self.slope[i] * other.value + self.value * other.slope[i];
        });
        self.value *= other.value;
        self
    }
}

impl<const K: usize> Mul<f64> for Jet<K> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, factor: f64) -> Self {
        self.value *= factor;
        self.slope.iter_mut().for_each(|slope| *slope *= factor);
        self
    }
}

impl<const K: usize> Neg for Jet<K> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self * -1.0
    }
}
