//! A board in a document.

use super::{
    Auc, Board, Calibration, Counts, Found, KindRow, MethodRow, Outcomes, Quantification, Sureness,
    Undecided,
};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// A [`Board`] in a document.
#[derive(Serialize, JsonSchema)]
struct BoardDocument {
    /// Loops that stick; those that stick invisibly are in neither class.
    sticky: usize,
    /// Loops that do not stick.
    healthy: usize,
    /// Loops that stick invisibly.
    hidden: usize,
    /// Valves that stick.
    sticky_valves: usize,
    /// Valves that do not.
    healthy_valves: usize,
    /// The verdict, then the methods.
    methods: Vec<MethodDocument>,
    /// Loops by kind; empty if no kind is known.
    kinds: Vec<KindDocument>,
    /// Accuracy of the verdict's probability; null if no loop has one.
    calibration: Option<Calibration>,
    /// Accuracy of the estimates of S; null if no S is known.
    #[serde(rename = "S")]
    s: Option<Quantification>,
    /// Accuracy of the estimates of J; null if no J is known.
    #[serde(rename = "J")]
    j: Option<Quantification>,
    /// Accuracy of limits of S and sure probabilities; null without any.
    sureness: Option<Sureness>,
    /// Detected sticking valves by how clearly they show; null if no loop is a member of a mixed population.
    found: Option<Found>,
    /// Reasons for undecided loops; null if no loop is a member of a mixed population.
    undecided: Option<Undecided>,
}

/// Accuracy of a method.
#[derive(Serialize, JsonSchema)]
struct MethodDocument {
    /// Its name in commands and files.
    name: &'static str,
    /// Its title.
    title: &'static str,
    /// Its decisions on recordings.
    recordings: Outcomes,
    /// Its decisions on valves.
    valves: Outcomes,
    /// How well its statistic ranks recordings.
    auc: Option<Auc>,
    /// How well its mean ranks valves.
    auc_of_valves: Option<Auc>,
}

/// The loops of one kind.
#[derive(Serialize, JsonSchema)]
struct KindDocument {
    /// Its name.
    kind: String,
    /// Whether its valves stick.
    sticks: bool,
    /// How many loops there are, less those that stick invisibly.
    loops: usize,
    /// Decisions of the verdict and each method on them, by name.
    methods: BTreeMap<&'static str, Counts>,
}

stiction_model::written_as!(Board, BoardDocument);

impl From<&Board> for BoardDocument {
    fn from(board: &Board) -> Self {
        let method = |row: &MethodRow| MethodDocument {
            name: row.name(),
            title: row.title(),
            recordings: row.recordings,
            valves: row.valves,
            auc: row.auc,
            auc_of_valves: row.auc_of_valves,
        };
        let names = || board.methods.iter().map(MethodRow::name);
        let kind = |row: &KindRow| KindDocument {
            kind: row.kind.clone(),
            sticks: row.sticks,
            loops: row.loops,
            methods: names().zip(row.counts.iter().copied()).collect(),
        };
        Self {
            sticky: board.sticky,
            healthy: board.healthy,
            hidden: board.hidden.k,
            sticky_valves: board.sticky_valves,
            healthy_valves: board.healthy_valves,
            methods: board.methods.iter().map(method).collect(),
            kinds: board.kinds.iter().map(kind).collect(),
            calibration: board.calibration.clone(),
            s: board.s,
            j: board.j,
            sureness: board.sureness,
            found: board.found.clone(),
            undecided: board.undecided.clone(),
        }
    }
}
