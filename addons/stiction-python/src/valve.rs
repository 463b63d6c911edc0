//! Valve models, sample by sample and over arrays.

use crate::arguments::{finite, mismatch, number};
use crate::bands::Bands;
use crate::dict::{dict, plain};
use crate::errors::refused;
use crate::table::{ArrowTable, flags, texts};
use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::valve::{Assembly, Direction, Model, Start, Valve as _, ValveSpec};

/// Samples between two checks for a signal.
const STRIDE: usize = 1 << 20;

/// A sticking valve that follows its controller output (OP) sample by sample.
///
/// Parameters
/// ----------
/// S : float
///     Stick band plus dead band, percent of span.
/// J : float
///     Slip jump, percent of span.
/// model : str, default "two-phase"
///     Name of a valve model, see `valve_models`.
/// position : float, default 0
///     Initial valve position (VP), percent of span.
/// op : float, optional
///     OP before the first sample, percent of span; by default `position`.
/// direction : {1, -1}, default 1
///     Direction of the last motion before the first sample.
/// moving : bool, default False
///     Whether the stem initially moves in that direction.
/// K : float, optional
///     Overshoot of a slip, 1 (none) to 2 (no damping), for models that use it; by default 1.99.
/// rest_tolerance : float, optional
///     Speed of the OP that counts as a pause, percent of span per second, for models that use it; by default 0.
/// limits : tuple of float, optional
///     Lowest and highest OP and VP, percent of span, such as ``(0, 100)``; by default none.
/// lag_s : float, default 0
///     Time constant of a first-order lag of the stem, s.
/// sample_time : float, optional
///     Time between samples, s; needed only with `lag_s` or `rest_tolerance`.
///
/// Raises
/// ------
/// ValueError
///     If a value is out of its range, there is no such model, or the model does not use a given parameter.
///
/// Examples
/// --------
/// >>> import stiction
/// >>> valve = stiction.valves.Valve(S=5, J=2, position=50)
/// >>> valve.step(54)
/// 52.5
/// >>> valve.position
/// 52.5
#[pyclass(module = "stiction.valves", subclass)]
#[derive(Debug, Clone)]
pub struct Valve {
    assembly: Assembly,
    start: Start,
    spec: ValveSpec,
    sample_time: Option<f64>,
}

/// A refusal of the library for a valve, with the keywords of this package.
fn worded(error: stiction::Error) -> PyErr {
    let stiction::Error::Missing { needed_by, .. } = error else { return refused(error) };
    let keyword = if needed_by == "stem lag" { "lag_s" } else { "rest_tolerance" };
    let words = format!("{keyword} needs sample_time, the time between samples in s");
    PyValueError::new_err(words)
}

#[pymethods]
impl Valve {
    #[new]
    #[pyo3(signature = (S, J, *, model = None, position = None, op = None, direction = None,
                        moving = false, K = None, rest_tolerance = None, limits = None, lag_s = None,
                        sample_time = None),
           text_signature = "(S, J, *, model='two-phase', position=0.0, op=None, direction=1, \
                             moving=False, K=None, rest_tolerance=None, limits=None, lag_s=0.0, \
                             sample_time=None)")]
    #[expect(non_snake_case, reason = "the field's names")]
    #[expect(clippy::too_many_arguments, reason = "keywords of one constructor")]
    fn new(
        S: &Bound<'_, PyAny>,
        J: &Bound<'_, PyAny>,
        model: Option<&Bound<'_, PyAny>>,
        position: Option<&Bound<'_, PyAny>>,
        op: Option<&Bound<'_, PyAny>>,
        direction: Option<&Bound<'_, PyAny>>,
        moving: bool,
        K: Option<&Bound<'_, PyAny>>,
        rest_tolerance: Option<&Bound<'_, PyAny>>,
        limits: Option<&Bound<'_, PyAny>>,
        lag_s: Option<&Bound<'_, PyAny>>,
        sample_time: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let bands = stiction::Bands::from_s_j(number("S", S)?, number("J", J)?).map_err(refused)?;
        let model = match model {
            None => Model::TwoPhase,
            Some(name) => {
                let known: &str =
                    name.extract().map_err(|_| mismatch("model", name, "the name of a model"))?;
                Model::by_name(known).map_err(refused)?
            }
        };
        let given = |name, value: Option<&Bound<'_, PyAny>>| {
            value.map(|value| finite(name, value)).transpose()
        };
        let pair = |limits: &Bound<'_, PyAny>| {
            let words = "a pair of numbers such as (0, 100)";
            limits.extract().map_err(|_| mismatch("limits", limits, words))
        };
        let spec = ValveSpec {
            model,
            bands,
            overshoot: given("K", K)?,
            rest_tolerance: given("rest_tolerance", rest_tolerance)?,
            limits: limits.map(pair).transpose()?,
            lag_s: given("lag_s", lag_s)?.unwrap_or(0.0),
        };
        let sample_time = given("sample_time", sample_time)?;
        let mut assembly = spec.build(sample_time).map_err(worded)?;
        let direction = match direction.map_or(Ok(1.0), |value| number("direction", value))? {
            1.0 => Direction::Up,
            -1.0 => Direction::Down,
            sign => {
                let words = format!("direction is {sign}, but must be 1 or -1");
                return Err(PyValueError::new_err(words));
            }
        };
        let position = position.map_or(Ok(0.0), |value| finite("position", value))?;
        let op = op.map_or(Ok(position), |value| finite("op", value))?;
        let start = Start { position, op, direction, moving };
        assembly.restart(start);
        Ok(Self { assembly, start, spec, sample_time })
    }

    /// S and J.
    #[getter]
    fn bands(&self) -> Bands {
        Bands(self.spec.bands)
    }

    /// The name of its model.
    #[getter]
    fn model(&self) -> &'static str {
        self.spec.model.describe().name
    }

    /// The present valve position, percent of span.
    #[getter]
    fn position(&self) -> f64 {
        self.assembly.position()
    }

    /// Return the valve position (VP) for one new sample of the OP.
    ///
    /// Parameters
    /// ----------
    /// op : float
    ///     The new OP, percent of span.
    ///
    /// Returns
    /// -------
    /// float
    ///     The valve position, percent of span.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If `op` is not finite.
    fn step(&mut self, op: &Bound<'_, PyAny>) -> PyResult<f64> {
        Ok(self.assembly.step(finite("op", op)?))
    }

    /// Return to its initial state.
    fn restart(&mut self) {
        self.assembly.restart(self.start);
    }

    /// Position, OP, direction, and whether the valve moves. A new valve continues from this state like this one. It is
    /// `None` if the valve has more memory.
    fn _state(&self) -> Option<(f64, f64, f64, bool)> {
        let Start { position, op, direction, moving } = self.assembly.state()?;
        Some((position, op, direction.sign(), moving))
    }

    /// Complete memory between samples.
    fn _memory(&self) -> [f64; 7] {
        self.assembly.memory()
    }

    /// Continues from the memory of an equal valve.
    fn _recall(&mut self, memory: [f64; 7]) {
        self.assembly.recall(&memory);
    }

    /// The arguments with which it was made.
    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((f64, f64), Bound<'py, PyDict>)> {
        let Self { start, spec, sample_time, .. } = self;
        let keywords = dict!(py,
            "model": self.model(),
            "position": start.position,
            "op": start.op,
            "direction": start.direction.sign(),
            "moving": start.moving,
            "K": spec.overshoot,
            "rest_tolerance": spec.rest_tolerance,
            "limits": spec.limits,
            "lag_s": spec.lag_s,
            "sample_time": sample_time,
        );
        Ok(((spec.bands.s(), spec.bands.j()), keywords))
    }

    /// Follows all of `op`, writing the position to `vp`, which has the same length. NumPy has allocated it, so its
    /// memory need not be cleared, and is reused for the next result.
    fn _follow(
        &mut self,
        py: Python<'_>,
        op: PyReadonlyArray1<'_, f64>,
        mut vp: PyReadwriteArray1<'_, f64>,
    ) -> PyResult<()> {
        let (op, vp) = (op.as_slice()?, vp.as_slice_mut()?);
        // Refused as a whole, so the valve has not moved after an error. The valve ensures this for a single stride.
        if op.len() > STRIDE
            && let Some(index) = op.iter().position(|value| !value.is_finite())
        {
            let value = op[index];
            return Err(refused(stiction::Error::NonFinite { signal: "op", index, value }));
        }
        for (op, vp) in op.chunks(STRIDE).zip(vp.chunks_mut(STRIDE)) {
            py.detach(|| self.assembly.run(op, vp)).map_err(refused)?;
            py.check_signals()?;
        }
        Ok(())
    }

    fn __repr__(&self) -> String {
        format!(
            "Valve(S={:?}, J={:?}, model=\"{}\", position={:?})",
            self.spec.bands.s(),
            self.spec.bands.j(),
            self.model(),
            self.position()
        )
    }
}

impl Valve {
    /// The valve.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }
}

/// Names and descriptions of the valve models.
#[pyfunction]
pub fn valve_models(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    plain(py, &Model::ALL.map(Model::describe))
}

/// The valve models as a table.
#[pyfunction]
pub fn valve_table() -> PyResult<ArrowTable> {
    let all: Vec<_> = Model::ALL.iter().map(|model| model.describe()).collect();
    ArrowTable::of(vec![
        texts("name", all.iter().map(|d| Some(d.name))),
        texts("summary", all.iter().map(|d| Some(d.summary))),
        texts("citation", all.iter().map(|d| Some(d.citation))),
        flags("uses_s", all.iter().map(|d| Some(d.uses_s))),
        flags("uses_j", all.iter().map(|d| Some(d.uses_j))),
        flags("uses_k", all.iter().map(|d| Some(d.uses_k))),
        flags("uses_rest_tolerance", all.iter().map(|d| Some(d.uses_rest_tolerance))),
    ])
}
