//! The results for other programs: every loop as CSV, what was counted as JSON.

use super::About;
use super::measure::Measured;
use anyhow::Result;
use serde_json::{Value, json};
use stiction::diagnose::Estimate;
use stiction::scoreboard::{
    Auc, Board, Calibration, Counts, Errors, Outcomes, Quantification, Scored, Share, Sureness,
    VERDICT,
};

/// Version of what is printed; a change that breaks its readers is a new one.
const VERSION: u32 = 1;

/// One row a loop and method, the verdict first.
pub fn csv(loops: &[Scored]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(vec![]);
    writer.write_record([
        "loop",
        "valve",
        "kind",
        "sticks",
        "visible",
        "true_S",
        "true_J",
        "method",
        "statistic",
        "threshold",
        "decision",
        "probability",
        "S",
        "S_low",
        "S_high",
        "J",
        "J_low",
        "J_high",
        "S_below",
    ])?;
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
        writer.write_record(&row)?;
        for said in &each.methods {
            let mut row = known.to_vec();
            row.extend([
                said.method.name.to_owned(),
                say(said.statistic),
                say(said.threshold),
                said.decision.name().to_owned(),
            ]);
            row.resize(19, String::new());
            writer.write_record(&row)?;
        }
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

/// What was counted, indented.
pub fn json(about: &About, board: &Board, measured: &Measured) -> Result<String> {
    let methods = board.methods.iter().map(|row| {
        json!({
            "name": row.name(),
            "title": row.title(),
            "recordings": outcomes(&row.recordings),
            "valves": outcomes(&row.valves),
            "auc": row.auc.as_ref().map(auc),
            "auc_of_valves": row.auc_of_valves.as_ref().map(auc),
        })
    });
    let kinds = board.kinds.iter().map(|kind| {
        let methods: serde_json::Map<String, Value> = board
            .methods
            .iter()
            .zip(&kind.counts)
            .map(|(row, of)| (row.name().to_owned(), counts(of)))
            .collect();
        json!({ "kind": kind.kind, "sticks": kind.sticks, "loops": kind.loops, "methods": methods })
    });
    let times =
        measured.times.iter().map(|(name, time)| json!({ "name": name, "median_us": time }));
    let document = json!({
        "tool": crate::diagnose::tool(),
        "version": VERSION,
        "title": about.title,
        "origin": about.origin,
        "sticky": board.sticky,
        "healthy": board.healthy,
        "hidden": board.hidden.k,
        "sticky_valves": board.sticky_valves,
        "healthy_valves": board.healthy_valves,
        "methods": methods.collect::<Vec<_>>(),
        "kinds": kinds.collect::<Vec<_>>(),
        "calibration": board.calibration.as_ref().map(calibration),
        "S": board.s.as_ref().map(quantification),
        "J": board.j.as_ref().map(quantification),
        "sureness": board.sureness.as_ref().map(sureness),
        "times": times.collect::<Vec<_>>(),
    });
    Ok(serde_json::to_string_pretty(&document)?)
}

fn outcomes(of: &Outcomes) -> Value {
    json!({
        "sticky": counts(&of.sticky),
        "healthy": counts(&of.healthy),
        "recall": share(of.recall()),
        "false_alarms": share(of.false_alarms()),
        "precision": share(of.precision()),
        "without_decision": share(of.without_decision()),
        "accuracy_of_decided": share(of.accuracy()),
    })
}

fn counts(of: &Counts) -> Value {
    json!({
        "positive": of.positive,
        "negative": of.negative,
        "undecided": of.undecided,
        "abstains": of.abstains,
    })
}

fn share(of: Share) -> Value {
    let (low, high) = of.interval();
    json!({ "k": of.k, "n": of.n, "value": of.value(), "low": low, "high": high })
}

fn auc(of: &Auc) -> Value {
    json!({
        "value": of.value,
        "low": of.low,
        "high": of.high,
        "sticky": of.sticky,
        "healthy": of.healthy,
        "of_all": of.of_all,
    })
}

fn calibration(of: &Calibration) -> Value {
    let bins = of.bins.iter().map(|bin| {
        json!({
            "from": bin.from,
            "to": bin.to,
            "predicted": bin.predicted,
            "observed": share(bin.observed),
        })
    });
    json!({
        "n": of.n,
        "brier": of.brier,
        "expected_error": of.error,
        "bins": bins.collect::<Vec<_>>(),
    })
}

fn sureness(of: &Sureness) -> Value {
    json!({
        "S_above_limit": share(of.above),
        "cleared_above_limit": share(of.cleared_above),
        "sticking_cleared": share(of.cleared),
        "median_limit_of_cleared_healthy": of.limit,
        "sure": share(of.sure),
        "sure_and_wrong": share(of.wrong),
    })
}

fn quantification(of: &Quantification) -> Value {
    let errors =
        |errors: Option<Errors>| errors.map(|e| json!({ "median": e.median, "p90": e.p90 }));
    json!({
        "quantified": share(of.quantified),
        "absolute": errors(of.absolute),
        "relative": errors(of.relative),
        "covered": share(of.covered),
    })
}
