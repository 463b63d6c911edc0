//! Whether a recording can answer.

/// How well a recording, or one measure of it, suits the question.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Nothing stands against it.
    Fit,
    /// Results must be read with a caveat.
    Caveats,
    /// The data cannot answer.
    Unfit,
}

impl Class {
    /// Its name: `fit`, `caveats` or `unfit`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fit => "fit",
            Self::Caveats => "caveats",
            Self::Unfit => "unfit",
        }
    }
}

/// One thing that was measured about the data.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// A short name, such as `samples per cycle`.
    pub name: &'static str,
    /// What was found; `None` where it could not be measured.
    pub value: Option<f64>,
    /// Unit of value and thresholds; empty for a ratio.
    pub unit: &'static str,
    /// Where caveats begin, by the measure's own sense (less or more is worse).
    pub caveat_at: Option<f64>,
    /// Where the data become unfit.
    pub unfit_at: Option<f64>,
    /// What it means here.
    pub class: Class,
    /// A sentence with the numbers, for any class.
    pub reason: String,
}

/// Whether a recording can answer, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitness {
    /// The worst class of the measures.
    pub class: Class,
    /// All that was measured.
    pub measures: Vec<Measure>,
}

impl Fitness {
    /// The verdict over some measures.
    pub fn of(measures: Vec<Measure>) -> Self {
        let class = measures.iter().map(|m| m.class).max().unwrap_or(Class::Unfit);
        Self { class, measures }
    }

    /// Why the class is not [`Class::Fit`]: the sentences of the measures that are worse, worst
    /// first.
    pub fn reasons(&self) -> Vec<&str> {
        let mut worse: Vec<&Measure> =
            self.measures.iter().filter(|m| m.class != Class::Fit).collect();
        worse.sort_by_key(|m| std::cmp::Reverse(m.class));
        worse.iter().map(|m| m.reason.as_str()).collect()
    }
}
