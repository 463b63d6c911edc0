//! Shared by the commands on scenarios and actions: opening a scenario and its loop, and the table of measures as
//! text, JSON and CSV.

use crate::files::In;
use crate::output::{self, Sheet};
use crate::text;
use anyhow::{Result, bail};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::collections::BTreeMap;
use stiction::Bands;
use stiction::closed_loop::ClosedLoop;
use stiction::compensate::Row;
use stiction::spoken::cell;
use stiction::valve::Model;
use stiction_io::scenario::{Scenario, System, built_in_text};

/// The scenario of that name or file with its settings. Settings without effect are reported.
pub fn scenario(name: &str, settings: &[String]) -> Result<Scenario> {
    let scenario = Scenario::open(name, settings)?;
    if built_in_text(name).is_none() {
        In::also(name)?;
    }
    scenario.files.iter().try_for_each(|file| In::also(file).map(drop))?;
    scenario.notes.iter().for_each(output::note);
    Ok(scenario)
}

/// The single loop of a scenario.
pub fn single_loop<'a>(name: &str, scenario: &'a Scenario) -> Result<&'a ClosedLoop> {
    match &scenario.system {
        System::ClosedLoop(plant) => Ok(plant),
        System::Cascade(_) => bail!(
            "{name} is a cascade, and this command needs a single loop; leave out [master], and give the slave a \
             set point of its own"
        ),
        System::OpenLoop(_) => bail!(
            "{name} is a valve on a test signal, and this command needs a loop; give it [controller] and [process] \
             instead of [input]"
        ),
    }
}

/// Column titles of [`cells`].
const HEADS: [&str; 8] =
    ["error", "worst", "PV std", "OP %/min", "stem %/min", "rev./h", "SP s", "load s"];

/// The measures of a row. The mean control error is given nominally and for the worst case, the other measures
/// nominally.
fn cells(row: &Row) -> [String; 8] {
    let outcome = row.nominal();
    let m = &outcome.measures;
    let settled = |time: Option<f64>| time.map_or("-".to_owned(), short);
    [
        short(m.iae_per_s),
        short(row.worst_iae_per_s()),
        short(m.pv_std),
        short(60.0 * m.op_travel_per_s),
        short(60.0 * m.vp_travel_per_s),
        short(m.reversals_per_h),
        settled(outcome.set_point_settling_s),
        settled(outcome.load_settling_s),
    ]
}

/// Explains the columns of [`table`].
pub const LEGEND: &str = "Error is the mean absolute control error in PV units (IAE per s). Rows are ranked by the \
    largest error with correct or wrong S and J. OP is the signal that the valve receives. Rev./h are stem reversals per hour. SP s \
    and load s are the settling times after a set-point and a load step, in s (- if the loop does not settle).";

/// Rows as columns of text. `more` is the title of the last column.
pub fn table(rows: &[(&str, &Row, String)], more: &str) -> String {
    let head = ["action"].into_iter().chain(HEADS).chain([more]).map(str::to_owned).collect();
    let mut lines: Vec<Vec<String>> = vec![head];
    for (name, row, last) in rows {
        let mut line = vec![(*name).to_owned()];
        line.extend(cells(row));
        line.push(last.clone());
        lines.push(line);
    }
    let mut right = vec![true; HEADS.len() + 2];
    right[0] = false;
    if more.is_empty() {
        right.pop();
        lines.iter_mut().for_each(|line| line.truncate(HEADS.len() + 1));
    }
    text::columns(&lines, &right)
}

/// Three digits for a table. Negligible values become 0.
pub fn short(value: f64) -> String {
    match value {
        v if !v.is_finite() => "unbounded".to_owned(),
        v if v.abs() < 5e-4 => "0".to_owned(),
        v if v.abs() >= 99.95 => format!("{v:.0}"),
        v if v.abs() >= 9.995 => format!("{v:.1}"),
        v if v.abs() >= 0.9995 => format!("{v:.2}"),
        v => format!("{v:.3}"),
    }
}

/// The beginning of documents on a scenario.
#[derive(Serialize, JsonSchema)]
pub struct Head {
    /// Name and version of the program.
    tool: &'static str,
    /// Name of the scenario, as given.
    scenario: String,
    /// Title.
    title: String,
    /// SHA-256 of the scenario with all changes, hexadecimal.
    scenario_sha256: String,
}

/// The settings of a scenario, key by key.
#[derive(Serialize)]
#[serde(transparent)]
pub struct Settings(toml::Table);

impl JsonSchema for Settings {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Settings".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        BTreeMap::<String, serde_json::Value>::json_schema(generator)
    }
}

/// The valve of a loop.
#[derive(Serialize, JsonSchema)]
pub struct Valve {
    /// Name of its model.
    model: &'static str,
    #[serde(flatten)]
    bands: Bands,
}

impl Valve {
    /// A valve of this model with these bands.
    pub fn new(model: Model, bands: Bands) -> Self {
        Self { model: model.describe().name, bands }
    }
}

impl Head {
    /// The head of a scenario, with its settings.
    pub fn of(name: &str, scenario: &Scenario) -> Result<(Self, Settings)> {
        let head = Self {
            tool: output::TOOL,
            scenario: name.to_owned(),
            title: scenario.title.clone(),
            scenario_sha256: format!("{:x}", Sha256::digest(&scenario.text)),
        };
        Ok((head, Settings(scenario.text.parse()?)))
    }
}

/// Rows as CSV, with all cases of each.
pub fn csv(rows: &[(&str, &Row)]) -> Result<String> {
    let columns = "rank,action,s_factor,j_factor,noise,iae_per_s,pv_std,op_travel_per_s,\
        vp_travel_per_s,reversals_per_h,set_point_settling_s,load_settling_s,\
        set_point_iae_per_s,load_iae_per_s";
    let mut sheet = Sheet::new(columns.split(','))?;
    for (rank, (name, row)) in rows.iter().enumerate() {
        for outcome in &row.outcomes {
            let m = &outcome.measures;
            let settled = |time: Option<f64>| time.map_or(String::new(), cell);
            sheet.row([
                (rank + 1).to_string(),
                (*name).to_owned(),
                outcome.case.s_factor.to_string(),
                outcome.case.j_factor.to_string(),
                u8::from(outcome.case.noise).to_string(),
                cell(m.iae_per_s),
                cell(m.pv_std),
                cell(m.op_travel_per_s),
                cell(m.vp_travel_per_s),
                cell(m.reversals_per_h),
                settled(outcome.set_point_settling_s),
                settled(outcome.load_settling_s),
                cell(outcome.set_point_iae_per_s),
                cell(outcome.load_iae_per_s),
            ])?;
        }
    }
    Ok(sheet.text()?)
}
