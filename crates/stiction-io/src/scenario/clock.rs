//! Time base of a scenario.

use crate::fields::{Fields, Wrong};

/// Time base of a scenario.
#[derive(Clone, Copy)]
pub struct Clock {
    pub sample_time: f64,
    pub samples: usize,
}

/// The longest run allowed. A run of this length takes gigabytes.
const MAX_SAMPLES: f64 = 1e8;

impl Clock {
    pub fn of(top: &Fields<'_, '_>) -> Result<Self, Wrong> {
        let sample_time = top.required_number("sample_time")?;
        if !(sample_time > 0.0) {
            return Err(top.wrong("sample_time", format!("is {sample_time} s; it must be above 0")));
        }
        let duration = top.required_number("duration")?;
        let samples = (duration / sample_time).round();
        if !(2.0..=MAX_SAMPLES).contains(&samples) {
            return Err(top.wrong(
                "duration",
                format!("gives {samples} samples, but must give between 2 and {MAX_SAMPLES}"),
            ));
        }
        Ok(Self { sample_time, samples: samples as usize })
    }
}
