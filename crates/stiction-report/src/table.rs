//! Diagnoses as a table with one row per loop, and the same columns for CSV, Arrow and Parquet.

use crate::document::Loop;
use crate::words;
use stiction_diagnose::diagnose::{Alternative, Estimate, Override};
use stiction_diagnose::oscillation::Oscillation;
use stiction_diagnose::spoken;

/// A column of the table.
#[derive(Debug, Clone, Copy)]
pub struct LoopColumn {
    /// Name.
    pub name: &'static str,
    /// Content and type.
    pub cells: Cells,
}

/// Functions from a loop to the content of a cell. `None` is an empty cell.
#[derive(Debug, Clone, Copy)]
pub enum Cells {
    /// Text.
    Texts(fn(&Loop<'_>) -> Option<String>),
    /// Numbers. A number that is not finite gives an empty cell, see [`number`](Self::number).
    Numbers(fn(&Loop<'_>) -> Option<f64>),
    /// Whole numbers.
    Counts(fn(&Loop<'_>) -> Option<usize>),
    /// Truth values.
    Flags(fn(&Loop<'_>) -> Option<bool>),
}

impl Cells {
    /// A number for a cell, if it is finite.
    pub fn number(value: Option<f64>) -> Option<f64> {
        value.filter(|value| value.is_finite())
    }

    /// The cell of a loop as text; empty for none.
    pub fn text(self, of: &Loop<'_>) -> String {
        let text = match self {
            Self::Texts(cell) => cell(of),
            Self::Numbers(cell) => Self::number(cell(of)).map(spoken::cell),
            Self::Counts(cell) => cell(of).map(|value| value.to_string()),
            Self::Flags(cell) => cell(of).map(|value| value.to_string()),
        };
        text.unwrap_or_default()
    }
}

/// All columns, in order.
pub const COLUMNS: [LoopColumn; 30] = {
    use Cells::{Counts, Flags, Numbers, Texts};
    const fn column(name: &'static str, cells: Cells) -> LoopColumn {
        LoopColumn { name, cells }
    }
    [
        column("loop", Texts(|l| Some(l.diagnosis.name.clone()))),
        column("file", Texts(|l| Some(l.source.file.clone()))),
        column("type", Texts(|l| name(l.diagnosis.loop_type.name()))),
        column("fitness", Texts(|l| name(l.diagnosis.fitness.class.name()))),
        column("samples", Counts(|l| Some(l.diagnosis.judged.as_ref()?.samples))),
        column("sample_time_s", Numbers(|l| Some(l.diagnosis.judged.as_ref()?.sample_time_s))),
        column("oscillates", Flags(|l| Some(oscillation(l)?.found))),
        column("period_s", Numbers(|l| oscillation(l)?.period_s)),
        column("regularity", Numbers(|l| oscillation(l)?.regularity)),
        column("amplitude", Numbers(|l| oscillation(l)?.amplitude)),
        column("verdict", Texts(|l| name(l.diagnosis.verdict.class.name()))),
        column("grade", Texts(|l| name(l.diagnosis.verdict.grade.name()))),
        column("probability", Numbers(|l| l.diagnosis.verdict.shown_probability())),
        column("basis", Texts(|l| name(l.diagnosis.verdict.basis.name()))),
        column("votes_sticks", Counts(|l| Some(l.diagnosis.verdict.votes.sticks))),
        column("votes_does_not_stick", Counts(|l| Some(l.diagnosis.verdict.votes.does_not_stick))),
        column("S", Numbers(|l| Some(s(l)?.value))),
        column("S_low", Numbers(|l| Some(s(l)?.low))),
        column("S_high", Numbers(|l| Some(s(l)?.high))),
        column("J", Numbers(|l| Some(j(l)?.value))),
        column("J_low", Numbers(|l| Some(j(l)?.low))),
        column("J_high", Numbers(|l| Some(j(l)?.high))),
        column("S_below", Numbers(|l| Some(l.diagnosis.verdict.s_below?.value))),
        column("guessed_range", Texts(|l| words::guessed_range(l.diagnosis))),
        column("alternative", Texts(|l| name(likeliest(l)?.cause.name()))),
        column("alternative_likelihood", Numbers(|l| Some(likeliest(l)?.likelihood))),
        column("masked", Counts(|l| Some(l.diagnosis.masked_count()))),
        column("masked_values", Texts(|l| l.diagnosis.masked_words())),
        column("override", Texts(|l| name(overruled(l)?.verdict.name()))),
        column("override_reason", Texts(|l| Some(overruled(l)?.reason.clone()))),
    ]
};

fn name(name: &str) -> Option<String> {
    Some(name.to_owned())
}

fn oscillation<'a>(of: &Loop<'a>) -> Option<&'a Oscillation> {
    of.diagnosis.oscillation().map(|(_, found)| found)
}

fn s(of: &Loop<'_>) -> Option<Estimate> {
    of.diagnosis.stiction.s
}

fn j(of: &Loop<'_>) -> Option<Estimate> {
    of.diagnosis.stiction.j
}

fn likeliest<'a>(of: &Loop<'a>) -> Option<&'a Alternative> {
    of.diagnosis.verdict.alternatives.first()
}

fn overruled<'a>(of: &Loop<'a>) -> Option<&'a Override> {
    of.diagnosis.verdict.overruled.as_ref()
}
