//! What a valve remembers between samples, as plain numbers: to store it, and to go on with other
//! parameters from where it is.

/// What a model remembers; unused places are 0.
pub(super) type Memory = [f64; 5];

/// A model that can tell what it remembers, and take it back.
pub(super) trait Remember {
    /// Everything that the next sample depends on besides parameters and input.
    fn memory(&self) -> Memory;

    /// Goes on from what a valve of the same model remembered, with any parameters.
    fn recall(&mut self, memory: &Memory);
}

/// A yes or no among numbers.
pub(super) fn flag(yes: bool) -> f64 {
    f64::from(u8::from(yes))
}
