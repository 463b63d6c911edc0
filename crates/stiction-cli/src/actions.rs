//! What the commands on scenarios and actions share: which scenario, which loop, the table of measures, its JSON and its CSV.

use crate::text;
use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use stiction::closed_loop::ClosedLoop;
use stiction::compensate::{Options, Outcome, Row};
use stiction::detect::Number;
use stiction_io::scenario::{Scenario, System};

/// The scenario of that name or file with its settings; what of it has no effect is told.
pub fn scenario(name: &str, settings: &[String]) -> Result<Scenario> {
    let scenario = Scenario::open(name, settings)?;
    scenario.notes.iter().for_each(crate::output::note);
    Ok(scenario)
}

/// The single loop that a scenario simulates.
pub fn single_loop<'a>(name: &str, scenario: &'a Scenario) -> Result<&'a ClosedLoop> {
    match &scenario.system {
        System::ClosedLoop(plant) => Ok(plant),
        System::Cascade(_) => bail!(
            "{name} is a cascade, and this command asks about a single loop; leave out [master], and give the \
             slave the set point that its master gives it"
        ),
        System::OpenLoop(_) => bail!(
            "{name} is a valve on a test signal, and this command asks about a loop; give it [controller] and \
             [process] in place of [input]"
        ),
    }
}

/// Heads of the columns of [`cells`].
const HEADS: [&str; 8] =
    ["error", "worst", "PV std", "OP %/min", "stem %/min", "turns/h", "SP s", "load s"];

/// The measures of a row: mean control error, nominal and worst, and the rest nominally.
fn cells(row: &Row) -> [String; 8] {
    let outcome = row.nominal();
    let m = &outcome.measures;
    let settled = |time: Option<f64>| time.map_or("-".to_owned(), short);
    [
        short(m.iae_per_s),
        short(row.worst(|outcome| outcome.measures.iae_per_s)),
        short(m.pv_std),
        short(60.0 * m.op_travel_per_s),
        short(60.0 * m.vp_travel_per_s),
        short(m.reversals_per_h),
        settled(outcome.set_point_settling_s),
        settled(outcome.load_settling_s),
    ]
}

/// What [`table`] means.
pub const LEGEND: &str = "error: mean absolute control error in PV units (IAE per s), ranked by its worst case of S \
     and J being wrong; travel of OP (what the valve receives) and stem; turns of the stem; seconds to settle after a \
     set-point and a load step, - if it does not.";

/// Rows as columns of text; `more` names a last column.
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

/// Three digits for a table; nothing to speak of is 0.
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

/// Numbers by name, each with its unit.
pub fn parameters(numbers: &[Number]) -> Value {
    numbers.iter().map(|n| json!({ "name": n.name, "value": n.value, "unit": n.unit })).collect()
}

fn outcome(outcome: &Outcome) -> Value {
    let m = &outcome.measures;
    json!({
        "s_factor": outcome.case.s_factor,
        "j_factor": outcome.case.j_factor,
        "noise": outcome.case.noise,
        "iae_per_s": m.iae_per_s,
        "pv_std": m.pv_std,
        "pv_half_pp": m.pv_half_pp,
        "op_travel_per_s": m.op_travel_per_s,
        "vp_travel_per_s": m.vp_travel_per_s,
        "reversals_per_h": m.reversals_per_h,
        "set_point_settling_s": outcome.set_point_settling_s,
        "load_settling_s": outcome.load_settling_s,
        "set_point_iae_per_s": outcome.set_point_iae_per_s,
        "load_iae_per_s": outcome.load_iae_per_s,
    })
}

/// A row with all its cases.
pub fn row(name: &str, row: &Row) -> Value {
    json!({
        "action": name,
        "parameters": parameters(&row.parameters),
        "worst_iae_per_s": row.worst(|outcome| outcome.measures.iae_per_s),
        "worst_pv_std": row.worst_pv_std(),
        "cases": row.outcomes.iter().map(outcome).collect::<Value>(),
    })
}

/// The protocol that all rows went through.
pub fn protocol(options: &Options) -> Value {
    json!({
        "on_s": options.from_s,
        "settle_s": options.settle_s,
        "window_s": options.window_s,
        "step_s": options.step_s,
        "set_point_step": options.set_point_step,
        "load_step": options.load_step,
        "settling_band": options.settling_band,
        "error_of_s_and_j": options.error,
        "noise_sd": options.noise_sd,
        "seed": options.seed,
    })
}

/// What every JSON document begins with.
pub fn head(name: &str, scenario: &Scenario) -> Result<serde_json::Map<String, Value>> {
    let settings: toml::Table = scenario.text.parse()?;
    let (model, bands) = scenario.valve;
    let head = json!({
        "tool": concat!("stiction ", env!("CARGO_PKG_VERSION")),
        "scenario": name,
        "title": scenario.title,
        "scenario_sha256": format!("{:x}", Sha256::digest(&scenario.text)),
        "valve": { "model": model.describe().name, "S": bands.s(), "J": bands.j() },
        "settings": settings,
    });
    head.as_object().cloned().context("a JSON object")
}

/// Rows as CSV, all cases of each.
pub fn csv(rows: &[(&str, &Row)]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(vec![]);
    writer.write_record([
        "rank",
        "action",
        "s_factor",
        "j_factor",
        "noise",
        "iae_per_s",
        "pv_std",
        "op_travel_per_s",
        "vp_travel_per_s",
        "reversals_per_h",
        "set_point_settling_s",
        "load_settling_s",
        "set_point_iae_per_s",
        "load_iae_per_s",
    ])?;
    for (rank, (name, row)) in rows.iter().enumerate() {
        for outcome in &row.outcomes {
            let m = &outcome.measures;
            let settled = |time: Option<f64>| time.map_or(String::new(), |t| t.to_string());
            writer.write_record([
                (rank + 1).to_string(),
                (*name).to_owned(),
                outcome.case.s_factor.to_string(),
                outcome.case.j_factor.to_string(),
                u8::from(outcome.case.noise).to_string(),
                m.iae_per_s.to_string(),
                m.pv_std.to_string(),
                m.op_travel_per_s.to_string(),
                m.vp_travel_per_s.to_string(),
                m.reversals_per_h.to_string(),
                settled(outcome.set_point_settling_s),
                settled(outcome.load_settling_s),
                outcome.set_point_iae_per_s.to_string(),
                outcome.load_iae_per_s.to_string(),
            ])?;
        }
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}
