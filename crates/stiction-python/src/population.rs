//! Simulated loops with known truth.

use crate::dict::dict;
use crate::errors::refused;
use crate::long::long;
use crate::table::{self, ArrowTable};
use numpy::PyArray1;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use stiction::population::{self, LoopKind, Simulated, Truth};

/// Loops simulated between two checks for an interrupt.
const CHUNK: u64 = 64;

/// The loops of a population.
#[pyclass(frozen, module = "stiction._core")]
#[derive(Debug)]
pub struct Loops(Vec<Simulated>);

#[pymethods]
impl Loops {
    fn __len__(&self) -> usize {
        self.0.len()
    }

    /// Signals and truth of a loop.
    fn member<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        let Some(Simulated { recording, truth }) = self.0.get(index) else {
            return Err(PyIndexError::new_err("no such loop"));
        };
        let array = |values: &[f64]| PyArray1::from_slice(py, values);
        let channel = |of: &Option<stiction::recording::Channel>| {
            of.as_ref().map(|channel| array(&channel.values))
        };
        let facts = PyDict::new(py);
        let all = facts_of(truth);
        for (name, fact) in &all[FIXED..] {
            match fact {
                Fact::Number(value) => facts.set_item(name, value)?,
                Fact::Count(value) => facts.set_item(name, value)?,
                Fact::Flag(value) => facts.set_item(name, value)?,
                Fact::Text(value) => facts.set_item(name, value)?,
            }
        }
        let truth_dict = dict!(py,
            "kind": truth.kind.name(),
            "sticks": truth.sticks,
            "visible": truth.visible,
            "model": truth.model.map(|model| model.describe().name),
            "S": truth.s,
            "J": truth.j,
            "slips": truth.slips,
            "evidence_nats": truth.gain,
            "swing": truth.swing,
            "op_noise": truth.op_noise,
            "facts": facts,
        );
        Ok(dict!(py,
            "name": &recording.name,
            "loop_type": recording.loop_type.name(),
            "sample_time": truth.facts.sample_time_s,
            "op": array(&recording.op.values),
            "pv": channel(&recording.pv),
            "sp": channel(&recording.sp),
            "vp": array(&truth.vp),
            "truth": truth_dict,
        ))
    }

    /// The truth about the loops, one row per loop.
    fn truth(&self) -> PyResult<ArrowTable> {
        let names = self.0.iter().map(|loop_| Some(&loop_.recording.name));
        let mut columns = vec![table::texts("name", names)];
        let rows: Vec<_> = self.0.iter().map(|loop_| facts_of(&loop_.truth)).collect();
        for (k, (name, like)) in rows.first().into_iter().flatten().enumerate() {
            /// The column of facts of one kind.
            macro_rules! column {
                ($make:ident, $kind:ident, $some:expr) => {
                    table::$make(
                        name,
                        rows.iter().map(|row| match row[k].1 {
                            Fact::$kind(value) => $some(value),
                            _ => None,
                        }),
                    )
                };
            }
            columns.push(match like {
                Fact::Number(_) => column!(numbers, Number, Some),
                Fact::Count(_) => column!(counts, Count, Some),
                Fact::Flag(_) => column!(flags, Flag, Some),
                Fact::Text(_) => column!(texts, Text, std::convert::identity),
            });
        }
        ArrowTable::of(columns)
    }
}

/// A value of the truth.
enum Fact {
    Number(f64),
    Count(i64),
    Flag(bool),
    Text(Option<&'static str>),
}

/// Number of columns before those of `Facts`.
const FIXED: usize = 10;

/// The complete truth about a loop, by name, in the order of the command line's table.
fn facts_of(truth: &Truth) -> Vec<(&'static str, Fact)> {
    let facts = &truth.facts;
    /// Names that equal those of the fields.
    macro_rules! facts {
        (@ text $name:ident) => { Fact::Text(Some(facts.$name.name())) };
        (@ number $name:ident) => { Fact::Number(facts.$name) };
        (@ count $name:ident) => { Fact::Count(facts.$name as i64) };
        (@ flag $name:ident) => { Fact::Flag(facts.$name) };
        ($($kind:ident $name:ident),* $(,)?) => {
            [$((stringify!($name), facts!(@ $kind $name))),*]
        };
    }
    let mut all = vec![
        ("kind", Fact::Text(Some(truth.kind.name()))),
        ("sticks", Fact::Flag(truth.sticks)),
        ("visible", Fact::Flag(truth.visible)),
        ("model", Fact::Text(truth.model.map(|model| model.describe().name))),
        ("S", Fact::Number(truth.s)),
        ("J", Fact::Number(truth.j)),
        ("slips", Fact::Count(truth.slips as i64)),
        ("evidence_nats", Fact::Number(truth.gain)),
        ("swing", Fact::Number(truth.swing)),
        ("op_noise", Fact::Number(truth.op_noise)),
    ];
    all.extend(facts!(
        text process, number gain, number tau_s, number tau2_s, number dead_time_s,
        number valve_lag_s, number pv_filter_s, number kc, number ti_s, number td_s,
        number gain_margin, text situation, text controller, number own_noise, number coupling, number op_low, number op_high, number sample_time_s,
        count steps_per_sample, number activity, text noise, number noise_ratio,
        flag non_stationary, text set_point, number sensor_play, number controller_gap,
        number transmitter_quantum, flag averaged, count held_samples, number op_quantum,
        number pv_quantum, number op_compression, number pv_compression, number op_exception,
        number pv_exception, number faulty_share, number op_travel, number at_limit, number pv_span, count redrawn,
    ));
    let names =
        |all: &[(&'static str, Fact)]| all.iter().map(|(name, _)| *name).collect::<Vec<_>>();
    debug_assert!(
        names(&all[FIXED..]).into_iter().eq(facts.entries().iter().map(|(name, _)| *name))
    );
    all
}

/// Loops `first` to `first + n` of the population of `seed`, or of one kind.
#[pyfunction]
#[pyo3(signature = (n, seed, kind = None, first = 0, told = None))]
pub fn population_loops(
    py: Python<'_>,
    n: u64,
    seed: u64,
    kind: Option<&str>,
    first: u64,
    told: Option<&Bound<'_, PyAny>>,
) -> PyResult<Loops> {
    let kind = kind.map(LoopKind::by_name).transpose().map_err(refused)?;
    let one = move |k: u64| match kind {
        Some(kind) => kind.simulate(seed.wrapping_add(k)),
        None => population::member(seed, k),
    };
    long(py, told, move |progress| {
        let mut all = vec![];
        for from in (0..n).step_by(CHUNK as usize) {
            let chunk: Vec<Option<Simulated>> = (from..n.min(from + CHUNK))
                .into_par_iter()
                .map(|k| {
                    if progress.is_cancelled() {
                        return Ok(None);
                    }
                    let simulated = one(first.wrapping_add(k))?;
                    progress.one();
                    Ok(Some(simulated))
                })
                .collect::<stiction::Result<_>>()?;
            all.extend(chunk.into_iter().flatten());
            if progress.is_cancelled() {
                break;
            }
        }
        Ok(Loops(all))
    })?
    .map_err(refused)
}

/// Names of the kinds, with their shares of the population.
#[pyfunction]
pub fn population_kinds() -> Vec<(&'static str, f64)> {
    LoopKind::ALL.map(|kind| (kind.name(), kind.share())).to_vec()
}
