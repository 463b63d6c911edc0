//! Times of a recording as dates.

use crate::words::spoken;
use stiction_diagnose::diagnose::Diagnosis;
use stiction_diagnose::drawing::Context;

/// The date and time of the plant at `at` s after the recording's zero, if known.
pub(super) fn date(diagnosis: &Diagnosis, at: f64) -> Option<String> {
    Context::of(diagnosis).date(at)
}

/// A time on the recording's clock as a date, if known.
pub(crate) fn moment(diagnosis: &Diagnosis, at: f64) -> String {
    date(diagnosis, at).unwrap_or_else(|| spoken(at))
}
