//! The results for other programs, with every loop as CSV and the counts as JSON.

use super::About;
use super::measure::Measured;
use crate::output::{self, Sheet};
use anyhow::Result;
use schemars::JsonSchema;
use serde::Serialize;
use stiction::diagnose::Estimate;
use stiction::scoreboard::{Board, Scored, VERDICT};

/// Version of the document. A change that breaks its readers gets a new one.
const VERSION: u32 = 1;

/// One row per loop and method, the verdict first.
pub fn csv(loops: &[Scored]) -> Result<String> {
    let columns = "loop,valve,kind,sticks,visible,true_S,true_J,method,statistic,threshold,\
        decision,probability,S,S_low,S_high,J,J_low,J_high,S_below,undecided_by,gain,\
        slips";
    let mut sheet = Sheet::new(columns.split(','))?;
    let say = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
    for each in loops {
        let truth = &each.truth;
        let known = [
            each.name.clone(),
            truth.valve.clone(),
            truth.kind.clone(),
            truth.sticks.to_string(),
            truth.visible.to_string(),
            say(truth.s),
            say(truth.j),
        ];
        let mut row = known.to_vec();
        row.extend([VERDICT, "", "", each.verdict.name()].map(str::to_owned));
        row.push(say(each.probability));
        for estimate in [each.s, each.j] {
            let of = |part: fn(Estimate) -> f64| say(estimate.map(part));
            row.extend([of(|e| e.value), of(|e| e.low), of(|e| e.high)]);
        }
        row.push(say(each.s_below));
        row.push(each.undecided_by.map_or(String::new(), |ruling| ruling.name().to_owned()));
        row.push(say(truth.member.map(|member| member.gain)));
        row.push(truth.member.map_or(String::new(), |member| member.slips.to_string()));
        sheet.row(&row)?;
        for said in &each.methods {
            let mut row = known.to_vec();
            row.extend([
                said.method.name.to_owned(),
                say(said.statistic),
                say(said.threshold),
                said.decision.name().to_owned(),
            ]);
            row.resize(22, String::new());
            sheet.row(&row)?;
        }
    }
    Ok(sheet.text()?)
}

/// What `stiction bench --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    /// Name and version of the program.
    tool: &'static str,
    /// Version of this form.
    version: u32,
    /// Title of the measurement.
    title: String,
    /// Where the loops come from, in sentences.
    origin: String,
    #[serde(flatten)]
    board: Board,
    /// Median times, if they were requested.
    times: Vec<Time>,
}

/// The time of the diagnosis or of a method.
#[derive(Serialize, JsonSchema)]
struct Time {
    /// Name of the method, or of the diagnosis.
    name: String,
    /// Median time per loop, microseconds.
    #[serde(with = "stiction::finite::Finite")]
    median_us: f64,
}

/// The JSON document with all counts.
pub fn document(about: About, board: Board, measured: &Measured) -> Document {
    let times = measured.times.iter();
    let times = times.map(|(name, time)| Time { name: name.clone(), median_us: *time });
    Document {
        tool: output::TOOL,
        version: VERSION,
        title: about.title,
        origin: about.origin,
        board,
        times: times.collect(),
    }
}
