//! The physical valve with mass, spring, air pressure and friction.

use crate::arguments::{finite, mismatch, number};
use crate::bands::Bands;
use crate::dict::{dict, plain};
use crate::errors::refused;
use crate::long::long;
use crate::series::finite as all_finite;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use stiction::stem::friction::LAWS;
use stiction::stem::{
    self, FrictionLaw, ParameterSet, PressureSignal, SETS, Sample, StemParameters, StemStart,
};
use stiction::valve::{Start, Valve as _};

/// The physical valve: a mass on a spring, moved by air pressure against friction.
///
/// Parameters
/// ----------
/// set : str, default "cts"
///     Name of a set of parameters, see `stem_sets`.
/// friction : str, optional
///     Name of a friction law, see `friction_laws`; by default the law of the set.
/// parameters : mapping, optional
///     Changes to parameters of stem and friction by name, such as ``{"coulomb_n": 900}``.
/// tolerance : float, default 1e-8
///     Relative tolerance of the solver, 1e-12 to 1e-3. It has no effect on motion with a closed-form solution.
///
/// Raises
/// ------
/// ValueError
///     If there is no such set, law or parameter, a parameter is missing, or a value is out of its range.
///
/// Examples
/// --------
/// >>> import stiction
/// >>> stem = stiction.Stem("cts-stribeck")
/// >>> stem.friction, stem.equivalent().sliding
/// ('classical', 'staircase')
/// >>> stiction.Stem("usp", friction="lugre").parameters["stiffness_n_per_m"]
/// 26000000.0
#[pyclass(frozen, eq, module = "stiction.stem", subclass)]
#[derive(Debug, Clone, PartialEq)]
pub struct Stem {
    stem: stem::Stem,
    set: &'static str,
}

/// The parameters of stem and friction by name.
fn parameter_dict<'py>(
    py: Python<'py>,
    p: &StemParameters,
    friction: &FrictionLaw,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (name, value) in p.values().into_iter().chain(friction.values()) {
        all.set_item(name, value)?;
    }
    all.set_item("end_stops", p.end_stops)?;
    Ok(all)
}

/// A named set with another friction law and changes.
fn build(
    set: &ParameterSet,
    friction: Option<&str>,
    changes: &[(String, f64)],
) -> PyResult<stem::Stem> {
    set.stem_with(friction, changes).map_err(|error| match error {
        stiction::Error::Missing { name, needed_by } => PyValueError::new_err(format!(
            "friction law \"{needed_by}\" needs {name}, which set \"{}\" lacks; give them in parameters",
            set.name
        )),
        error => refused(error),
    })
}

impl Stem {
    /// The stem.
    pub fn stem(&self) -> &stem::Stem {
        &self.stem
    }
}

#[pymethods]
impl Stem {
    #[new]
    #[pyo3(signature = (set = None, *, friction = None, parameters = None, tolerance = None),
           text_signature = "(set='cts', *, friction=None, parameters=None, tolerance=1e-08)")]
    fn new(
        set: Option<&Bound<'_, PyAny>>,
        friction: Option<&Bound<'_, PyAny>>,
        parameters: Option<&Bound<'_, PyAny>>,
        tolerance: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let text = |name: &str, value: &Bound<'_, PyAny>| {
            value.extract::<String>().map_err(|_| mismatch(name, value, "a name"))
        };
        let set = set.map_or(Ok("cts".to_owned()), |set| text("set", set))?;
        let set = ParameterSet::named(&set).map_err(refused)?;
        let friction = friction.map(|friction| text("friction", friction)).transpose()?;
        let mut changes = vec![];
        if let Some(parameters) = parameters {
            let mapping = parameters
                .cast::<PyMapping>()
                .map_err(|_| mismatch("parameters", parameters, "a mapping"))?;
            for pair in mapping.items()?.iter() {
                let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = pair.extract()?;
                let name = text("a key of parameters", &name)?;
                let value = number(&name, &value)?;
                changes.push((name, value));
            }
        }
        let mut stem = build(&set, friction.as_deref(), &changes)?;
        if let Some(tolerance) = tolerance {
            stem = stem.with_tolerance(number("tolerance", tolerance)?).map_err(refused)?;
        }
        Ok(Self { stem, set: set.name })
    }

    /// The name of its initial set.
    #[getter]
    fn set(&self) -> &'static str {
        self.set
    }

    /// The name of its friction law.
    #[getter]
    fn friction(&self) -> &'static str {
        self.stem.friction().name()
    }

    /// All parameters of stem and friction by name, units in the names.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        parameter_dict(py, self.stem.parameters(), self.stem.friction())
    }

    /// Relative tolerance of the solver.
    #[getter]
    fn tolerance(&self) -> f64 {
        self.stem.tolerance()
    }

    /// Return the lag of a moving stem behind a ramp.
    ///
    /// Parameters
    /// ----------
    /// rate_m_per_s : float
    ///     Rate of the ramp, m/s of position.
    ///
    /// Returns
    /// -------
    /// float
    ///     The distance, m.
    fn trailing_m(&self, rate_m_per_s: &Bound<'_, PyAny>) -> PyResult<f64> {
        let rate = finite("rate_m_per_s", rate_m_per_s)?;
        Ok(self.stem.equivalent().map_err(refused)?.trailing_m(rate))
    }

    /// The stem in terms of the data-driven models.
    fn _equivalent<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = self.stem.equivalent().map_err(refused)?;
        Ok(dict!(py,
            "bands": Bands(found.bands),
            "signal_bands": Bands(found.signal_bands),
            "fs_m": found.fs_m,
            "fd_m": found.fd_m,
            "S_m": found.s_m,
            "J_m": found.j_m,
            "damping_ratio": found.damping_ratio,
            "overshoot": found.overshoot,
            "viscous_lag_s": found.viscous_lag_s,
            "sliding": found.sliding.name(),
        ))
    }

    /// Moves under `signal`, an OP in percent or a pressure in Pa. It is interpolated linearly between the times of
    /// its samples or, with a sample time, held over each sample.
    #[expect(clippy::too_many_arguments, reason = "called by one method only")]
    fn _follow<'py>(
        &self,
        py: Python<'py>,
        signal: PyReadonlyArray1<'py, f64>,
        time_s: PyReadonlyArray1<'py, f64>,
        is_pressure: bool,
        held_s: Option<f64>,
        at_s: PyReadonlyArray1<'py, f64>,
        position: Option<f64>,
        acting_pa: Option<f64>,
        relaxed: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let stem = self.stem;
        let p = *stem.parameters();
        let signal = all_finite(if is_pressure { "pressure_pa" } else { "op" }, &signal)?;
        let time_s = all_finite("time_s", &time_s)?;
        let pressure = match held_s {
            Some(sample_time) => PressureSignal::held_op(signal, sample_time, &p),
            None => {
                let pa = |value: f64| if is_pressure { value } else { p.pressure_pa(value) };
                let points = time_s.iter().zip(signal).map(|(t, value)| (*t, pa(*value)));
                PressureSignal::from_points(points.collect())
            }
        }
        .map_err(refused)?;
        let start = StemStart {
            position_m: match position {
                Some(percent) => p.position_m(percent),
                None => p.balance_m(pressure.first_pa()),
            },
            pressure_pa: acting_pa,
            relaxed,
        };
        let at_s = at_s.as_slice()?.to_vec();
        let run = move |_: &_| stem.simulate(&pressure, start, &at_s);
        let response = long(py, None, run)?.map_err(refused)?;
        let column =
            |of: &dyn Fn(&Sample) -> f64| PyArray1::from_iter(py, response.samples.iter().map(of));
        let events = response.events.iter().map(|event| {
            Ok(dict!(py,
                "time_s": event.time_s,
                "kind": event.kind.name(),
                "direction": event.direction.sign() as i8,
                "vp": p.percent(event.position_m),
                "position_m": event.position_m,
            ))
        });
        Ok(dict!(py,
            "time_s": column(&|s| s.time_s),
            "pressure_pa": column(&|s| s.pressure_pa),
            "vp": column(&|s| p.percent(s.position_m)),
            "position_m": column(&|s| s.position_m),
            "velocity_m_per_s": column(&|s| s.velocity_m_per_s),
            "friction_n": column(&|s| s.friction_n),
            "slips": response.slips().count(),
            "stops": response.stops().count(),
            "events": events.collect::<PyResult<Vec<_>>>()?,
        ))
    }

    fn __repr__(&self) -> String {
        format!("<Stem \"{}\", {} friction>", self.set, self.friction())
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((&'static str,), Bound<'py, PyDict>)> {
        let keywords = dict!(py,
            "friction": self.friction(),
            "parameters": self.parameters(py)?,
            "tolerance": self.tolerance(),
        );
        Ok(((self.set,), keywords))
    }
}

/// A physical valve that follows its controller output (OP) sample by sample.
///
/// Each OP is held for a sample, and the result is the position at its end. So it responds a sample later than the
/// data-driven models, which respond at once.
///
/// Parameters
/// ----------
/// stem : Stem
///     The physical valve.
/// sample_time : float
///     Time between samples, s.
/// position : float, default 0
///     Position to begin with, at rest, percent of stroke.
/// op : float, optional
///     OP before the first sample, percent; by default `position`.
///
/// Raises
/// ------
/// ValueError
///     If a value is out of its range, or the position is beyond an end stop.
///
/// Examples
/// --------
/// >>> import stiction
/// >>> valve = stiction.stem.StemValve(stiction.Stem("usp"), sample_time=5, position=50)
/// >>> round(valve.step(55), 2), round(valve.step(90), 2)
/// (50.0, 66.56)
#[pyclass(module = "stiction.stem", subclass)]
#[derive(Debug, Clone)]
pub struct StemValve {
    valve: stem::StemValve,
    start: Start,
}

impl StemValve {
    /// Refuses to continue after an error of the library.
    fn checked(&self) -> PyResult<()> {
        self.valve.fault().map_or(Ok(()), |fault| Err(refused(fault.clone())))
    }
}

#[pymethods]
impl StemValve {
    #[new]
    #[pyo3(signature = (stem, sample_time, *, position = None, op = None),
           text_signature = "(stem, sample_time, *, position=0.0, op=None)")]
    fn new(
        stem: &Bound<'_, PyAny>,
        sample_time: &Bound<'_, PyAny>,
        position: Option<&Bound<'_, PyAny>>,
        op: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let stem = stem.cast::<Stem>().map_err(|_| mismatch("stem", stem, "a Stem"))?.get().stem;
        let sample_time = number("sample_time", sample_time)?;
        let mut valve = stem::StemValve::new(stem, sample_time).map_err(refused)?;
        let position = position.map_or(Ok(0.0), |value| finite("position", value))?;
        let op = op.map_or(Ok(position), |value| finite("op", value))?;
        let start = Start { op, ..Start::at_rest(position) };
        valve.restart(start);
        let valve = Self { valve, start };
        valve.checked()?;
        Ok(valve)
    }

    /// The present position, percent of stroke.
    #[getter]
    fn position(&self) -> f64 {
        self.valve.position()
    }

    /// Time between samples, s.
    #[getter]
    fn sample_time(&self) -> f64 {
        self.valve.sample_time_s()
    }

    /// Return the valve position (VP) for one new sample of the OP.
    ///
    /// Parameters
    /// ----------
    /// op : float
    ///     The new OP, percent.
    ///
    /// Returns
    /// -------
    /// float
    ///     The position at the end of the sample, percent of stroke.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If `op` is not finite, or the solver cannot continue.
    fn step(&mut self, op: &Bound<'_, PyAny>) -> PyResult<f64> {
        let position = self.valve.step(finite("op", op)?);
        self.checked().map(|()| position)
    }

    /// Return to its initial state.
    fn restart(&mut self) {
        self.valve.restart(self.start);
    }

    fn __repr__(&self) -> String {
        format!("<StemValve at {:?} %, sample time {:?} s>", self.position(), self.sample_time())
    }
}

/// The sets of parameters.
#[pyfunction]
pub fn stem_sets(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    SETS.iter()
        .map(|name| {
            let set = ParameterSet::named(name).map_err(refused)?;
            Ok(dict!(py,
                "name": set.name,
                "summary": set.summary,
                "source": set.source,
                "friction": set.friction.name(),
                "parameters": parameter_dict(py, &set.stem, &set.friction)?,
            ))
        })
        .collect()
}

/// The friction laws.
#[pyfunction]
pub fn friction_laws(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    plain(py, &LAWS)
}
