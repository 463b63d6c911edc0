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
use stiction::population::{self, Fact, LoopKind, Simulated, Truth};

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
        let facts = |entries: &[(&str, Fact)]| {
            let facts = PyDict::new(py);
            for (name, fact) in entries {
                match *fact {
                    Fact::Number(value) => facts.set_item(name, value)?,
                    Fact::Count(value) => facts.set_item(name, value)?,
                    Fact::Flag(value) => facts.set_item(name, value)?,
                    Fact::Text(value) => facts.set_item(name, value)?,
                }
            }
            PyResult::Ok(facts)
        };
        let truth_dict = facts(&truth.entries())?;
        truth_dict.set_item("facts", facts(&truth.facts.entries())?)?;
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
        let facts = |truth: &Truth| [&truth.entries()[..], &truth.facts.entries()].concat();
        let rows: Vec<_> = self.0.iter().map(|loop_| facts(&loop_.truth)).collect();
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
                Fact::Count(_) => column!(counts, Count, |count: usize| Some(count as i64)),
                Fact::Flag(_) => column!(flags, Flag, Some),
                Fact::Text(_) => column!(texts, Text, std::convert::identity),
            });
        }
        ArrowTable::of(columns)
    }
}

/// Loops `first` to `first + n` of the population of `seed`, or of one kind.
#[pyfunction]
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
