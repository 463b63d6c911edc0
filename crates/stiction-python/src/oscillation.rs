//! Whether a signal cycles.

use crate::dict::dict;
use crate::errors::refused;
use crate::long::long;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::oscillation::{self, Basis, Oscillation};

/// An oscillation, with its times as of a signal whose first sample is at `from` s.
pub fn oscillation_dict<'py>(
    py: Python<'py>,
    found: &Oscillation,
    from: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let basis = found.basis.map(|basis| match basis {
        Basis::Autocorrelation => "autocorrelation",
        Basis::SpectralPeak => "spectral peak",
    });
    let supervised = found.supervised.map(|supervised| {
        Ok::<_, PyErr>(dict!(py,
            "threshold": supervised.threshold,
            "disturbances": supervised.disturbances,
            "half_waves": supervised.half_waves,
            "counter": supervised.counter,
            "alarm_s": supervised.alarm_s.map(|at| from + at),
            "oscillates": supervised.oscillates(),
        ))
    });
    let peak = |peak: &oscillation::Peak| {
        Ok(dict!(py,
            "period_s": peak.period_s,
            "amplitude": peak.amplitude,
            "share": peak.share,
            "regularity": peak.regularity,
            "decay_ratio": peak.decay_ratio,
            "chance": peak.chance,
            "over_background": peak.over_background,
            "harmonic": peak.harmonic,
            "band": peak.band,
            "is_oscillation": peak.is_oscillation(),
        ))
    };
    let episode = |episode: &oscillation::Episode| {
        Ok(dict!(py,
            "from_s": from + episode.from_s,
            "to_s": from + episode.to_s,
            "half_waves": episode.half_waves,
            "amplitude": episode.amplitude,
        ))
    };
    Ok(dict!(py,
        "found": found.found,
        "basis": basis,
        "period_s": found.period_s,
        "amplitude": found.amplitude,
        "cycles": found.cycles,
        "regularity": found.regularity,
        "intervals": found.intervals,
        "decay_ratio": found.decay_ratio,
        "supervision": supervised.transpose()?,
        "peaks": found.peaks.iter().map(peak).collect::<PyResult<Vec<_>>>()?,
        "episodes": found.episodes.iter().map(episode).collect::<PyResult<Vec<_>>>()?,
        "reasons": found.reasons.clone(),
    ))
}

/// Refuses a sample that is not finite.
pub fn all_finite(signal: &'static str, values: &[f64]) -> PyResult<()> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => {
            Err(refused(stiction::Error::NonFinite { signal, index, value: values[index] }))
        }
    }
}

/// Whether a signal oscillates.
#[pyfunction]
fn oscillation_of<'py>(
    py: Python<'py>,
    signal: PyReadonlyArray1<'py, f64>,
    sample_time: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let signal = signal.as_slice()?.to_vec();
    all_finite("signal", &signal)?;
    let found = long(py, None, move |_| oscillation::analyse(&signal, sample_time))?;
    oscillation_dict(py, &found, 0.0)
}

pub fn register(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_function(wrap_pyfunction!(oscillation_of, m)?)
}
