//! Simulated loops as rows of features and truth.

use std::collections::BTreeMap;
use std::ops::Range;
use stiction_diagnose::evidence::Line;
use stiction_diagnose::fusion::Cause;

/// A column of features.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    pub name: String,
    /// 1 if larger values can only be evidence for stiction, -1 if only against, 0 if either.
    pub monotone: i8,
    /// Line of evidence.
    pub line: Line,
    /// Whether it needs the OP only.
    pub op_only: bool,
}

/// The truth about a loop, and the scale of its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Number in the population.
    pub index: u64,
    /// The name of its kind.
    pub kind: String,
    /// Cause.
    pub cause: Cause,
    /// Whether the fault is visible; false without a fault.
    pub visible: bool,
    /// Number of slips of the valve.
    pub slips: u64,
    /// Gain of an observer who knows the stem, nats; see `stiction_population::Truth::gain`.
    pub nats: f64,
    /// Range of the OP over the actual S of the valve, or its S if it stuck.
    pub swing: f64,
    /// Percent of span.
    pub s: f64,
    pub j: f64,
    /// The name of the valve model, empty for a healthy valve.
    pub model: String,
    /// The process, in words.
    pub process: String,
    /// Steps of controller and valve per recorded sample.
    pub steps: u64,
    /// Span of the OP, percent.
    pub op_span: f64,
    /// The families it belongs to, such as `noise: spikes`.
    pub families: Vec<String>,
}

/// Rows of features and truth, in the order of their index.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dataset {
    pub columns: Vec<Column>,
    /// For each column, the value of each row; NaN where the feature could not be measured.
    pub values: Vec<Vec<f32>>,
    pub truth: Vec<Truth>,
    /// Number of loops of each kind without evidence, such as loops whose OP never moves.
    pub abstained: BTreeMap<String, u64>,
}

impl Dataset {
    /// Puts rows together.
    pub fn new(columns: Vec<Column>, rows: impl IntoIterator<Item = (Truth, Vec<f32>)>) -> Self {
        let mut values = vec![vec![]; columns.len()];
        let mut truth = vec![];
        for (what, row) in rows {
            truth.push(what);
            values.iter_mut().zip(row).for_each(|(column, value): (&mut Vec<f32>, f32)| {
                column.push(value);
            });
        }
        Self { columns, values, truth, abstained: BTreeMap::new() }
    }

    /// The features of a row.
    pub fn row(&self, row: usize) -> Vec<f64> {
        self.values.iter().map(|column| f64::from(column[row])).collect()
    }

    /// The directions of all columns.
    pub fn monotone(&self) -> Vec<i8> {
        self.columns.iter().map(|column| column.monotone).collect()
    }

    /// The rows whose index lies in a range.
    pub fn rows(&self, range: Range<u64>) -> Vec<u32> {
        let rows = self.truth.iter().enumerate();
        rows.filter(|(_, truth)| range.contains(&truth.index)).map(|(row, _)| row as u32).collect()
    }
}
