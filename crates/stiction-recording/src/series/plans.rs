//! Cached plans of Fourier transforms: making one takes longer than the transform of a short series.
//!
//! Windows of a recording have one length, and so do their spectra. Each thread keeps its plans, because passing them
//! down would put a planner into the signature of every function with a spectrum. Results cannot depend on this cache:
//! a plan follows from its length alone. To ensure that, each plan comes from its own planner. A planner that has
//! planned other lengths reuses their parts, and adds up in a different order.

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// Largest number of samples of all plans that a thread keeps: about 32 MB.
const MOST: usize = 1 << 20;

/// Plans of one direction, by the length of the series.
struct Plans<T: ?Sized> {
    plans: HashMap<usize, Arc<T>>,
    samples: usize,
}

impl<T: ?Sized> Plans<T> {
    fn new() -> Self {
        Self { plans: HashMap::new(), samples: 0 }
    }

    fn of(&mut self, length: usize, make: impl FnOnce(RealFftPlanner<f64>) -> Arc<T>) -> Arc<T> {
        if let Some(plan) = self.plans.get(&length) {
            return Arc::clone(plan);
        }
        let plan = make(RealFftPlanner::new());
        if self.samples + length > MOST {
            self.plans.clear();
            self.samples = 0;
        }
        if length <= MOST {
            self.plans.insert(length, Arc::clone(&plan));
            self.samples += length;
        }
        plan
    }
}

thread_local! {
    static FORWARD: RefCell<Plans<dyn RealToComplex<f64>>> = RefCell::new(Plans::new());
    static INVERSE: RefCell<Plans<dyn ComplexToReal<f64>>> = RefCell::new(Plans::new());
}

/// The plan that transforms series of `length` samples.
pub(super) fn forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    FORWARD.with_borrow_mut(|plans| plans.of(length, |mut new| new.plan_fft_forward(length)))
}

/// The plan that makes series of `length` samples.
pub(super) fn inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    INVERSE.with_borrow_mut(|plans| plans.of(length, |mut new| new.plan_fft_inverse(length)))
}

#[cfg(test)]
mod tests {
    use super::super::{Spectrum, Transform};
    use realfft::RealFftPlanner;

    /// Whatever was planned before, and however often, the bits are those of a new planner.
    #[test]
    fn what_was_planned_before_does_not_show() {
        let lengths = [1, 2, 30, 97, 360, 720, 1_000, 1_024, 4_096, 6_000, 8_192, 12_345, 1 << 20];
        for length in lengths.into_iter().chain(lengths.into_iter().rev()) {
            let x: Vec<f64> = (0..length).map(|k| (0.37 * k as f64).sin()).collect();
            let plan = RealFftPlanner::<f64>::new().plan_fft_forward(length);
            let mut bins = plan.make_output_vec();
            plan.process(&mut x.clone(), &mut bins).unwrap();
            let spectrum = Spectrum::of(&x, length);
            assert!(spectrum.bins == bins, "{length}");
            let mut again = bins.clone();
            let mut transform = Transform::new(length);
            transform.forward(&x, &mut again);
            assert!(again == bins, "{length}");
            let mut back = vec![0.0; length];
            transform.inverse(&mut again, &mut back);
            assert!(spectrum.inverse() == back, "{length}");
        }
    }
}
