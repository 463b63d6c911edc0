//! Loops that swing together.

/// Loops that swing together, and who of them may be the source.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Group {
    /// Its number, from 1.
    pub id: usize,
    /// The period of their common swing, s.
    pub period_s: f64,
    /// The loops.
    pub members: Vec<Member>,
    /// Whether the source may be among them.
    pub source: Source,
    /// Why, in sentences.
    pub reasons: Vec<String>,
}

/// A loop of a group.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Member {
    /// Its tag.
    #[serde(rename = "loop")]
    pub name: String,
    /// Its coherence with the group at the period.
    pub coherence: f64,
    /// Its place among the candidates for the source, from 1; `None` if it is none.
    pub candidate_rank: Option<usize>,
    /// Why it stands there.
    pub reasons: Vec<String>,
}

/// Whether the source may be among the members.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Candidates are ranked.
    Candidates,
    /// It is not among the recorded loops.
    NotRecorded,
}
