//! The model card: training data and accuracy of a bundle, in Markdown.

use crate::dataset::{Dataset, Truth};
use crate::decide;
use crate::learn::{FEWEST_SLIPS, Learned, at_fault, j_over_s, ln_s};
use crate::measure::{
    Detection, QUANTIFIED, Share, THRESHOLDS, detection, estimates, estimation, is_quantified,
    judge,
};
use crate::members::Both;
use crate::mistakes;
use anyhow::Result;
use std::collections::BTreeMap;
use std::fmt::Write;
use stiction_diagnose::fusion::{COVERAGE, LIMIT, Weighed};

/// Results on the test loops for the card.
pub struct Test<'a> {
    /// As recorded, and with the OP alone.
    pub data: &'a Both,
    pub seed: u64,
    pub members: u64,
}

/// The card of a bundle whose file has this checksum.
pub fn card(learned: &Learned, sha256: &str, train: &Dataset, test: &Test<'_>) -> Result<String> {
    let bundle = &learned.bundle;
    let from = &bundle.provenance;
    let mut out = String::new();
    writeln!(
        out,
        "# The model of the verdict\n\n\
         `verdict.bin` holds the frozen model that turns evidence into probabilities and intervals. The model \
         has sums of boosted trees, their calibration, the shifts of their intervals, the detection limit, and a \
         description of the training loops. `net.bin` holds the nets that read the raw signals; their output is \
         part of the evidence. Model and nets were trained only on simulated loops, never on a real recording. \
         `addons/stiction-train/train.sh` runs the training, and its last step writes this card.\n"
    )?;
    writeln!(out, "| | |\n|---|---|")?;
    writeln!(out, "| command | `{}` |", from.command)?;
    writeln!(out, "| SHA-256 of `verdict.bin` | `{sha256}` |")?;
    writeln!(out, "| population | version {} |", from.population)?;
    writeln!(
        out,
        "| trees trained on | seed {}, members 0 to {} |\n\
         | calibration and intervals from | seed {}, the {} members after those |\n\
         | figures below from | seed {}, members 0 to {} |",
        from.seed, from.trained, from.seed, from.calibrated, test.seed, test.members
    )?;
    writeln!(
        out,
        "| features | {}, {} of which need only the OP |",
        train.columns.len(),
        train.columns.iter().filter(|column| column.op_only).count()
    )?;
    for (name, data) in [("training", train), ("test", &test.data.full)] {
        let without: Vec<String> =
            data.abstained.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
        if !without.is_empty() {
            writeln!(out, "| {name} loops without evidence | {} |", without.join(", "))?;
        }
    }
    writeln!(
        out,
        "\nA fault is a valve that sticks or does not respond, if the record can show this. Other faults \
         are left out unless stated otherwise. Brackets are 95 % intervals (Wilson)."
    )?;
    for (title, op_only) in [("OP and PV", false), ("OP alone", true)] {
        let data = if op_only { &test.data.alone } else { &test.data.full };
        let weighed = judge(bundle, data, op_only)?;
        writeln!(out, "\n## {title}")?;
        detected(&mut out, &detection(&data.truth, &weighed))?;
        extent(&mut out, data, &weighed)?;
        if !op_only {
            limited(&mut out, data, &weighed)?;
            let mistaken = &test.data.mistaken;
            let of_mistaken = judge(bundle, mistaken, false)?;
            out += &mistakes::table((mistaken, &of_mistaken), (data, &weighed))?;
        }
        if let Some(families) = &learned.families {
            let said = "Each family of loops in turn was left out of the training of smaller models, which \
                then judged this family. A family with only faulty or only healthy valves is completed by loops \
                of the other class, weighted to the population's shares. Brackets give 95 % intervals and plain \
                counts. The columns \"reported\" and \"stretched\" use bounds and stretch factors found on the other families.";
            writeln!(out, "\n### Families left out\n\n{said}\n")?;
            out += &families[usize::from(op_only)].table();
        }
    }
    writeln!(out, "\n## Decisions\n\n{}", decide::table(bundle, &test.data.full)?)?;
    writeln!(
        out,
        "The next table shows the search for the thresholds on the calibration loops. The columns of wrong decisions, \
         wrong accusations and accused healthy loops give upper ends of one-sided 90 % intervals.\n\n{}",
        learned.choice.table()
    )?;
    let share = "The table gives each feature's share of the total gain of all splits, for models of OP and PV.";
    writeln!(out, "## Main features\n\n{share}\n\n| fault | | median of S | |\n|---|---|---|---|")?;
    let ranked = |gains: &[f64]| {
        let mut ranked: Vec<(f64, &str)> =
            gains.iter().zip(&bundle.features).map(|(gain, name)| (*gain, &name[..])).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        ranked.truncate(25);
        ranked
    };
    for ((a, fault), (b, s)) in ranked(&learned.fault_gains).iter().zip(ranked(&learned.s_gains)) {
        writeln!(out, "| {fault} | {a:.3} | {s} | {b:.3} |")?;
    }
    writeln!(
        out,
        "\n## Models\n\n| model | trees | loss on the early-stopping loops |\n|---|---|---|"
    )?;
    for (name, trees, loss) in &learned.notes {
        writeln!(out, "| {name} | {trees} | {loss:.4} |")?;
    }
    Ok(out)
}

fn detected(out: &mut String, found: &Detection) -> std::fmt::Result {
    let Detection { auc, brier, log_loss, decided, right, recall, precision, .. } = found;
    writeln!(out, "\n| fault or none | |\n|---|---|")?;
    writeln!(out, "| AUC | {auc:.4} |\n| Brier | {brier:.4} |\n| log loss | {log_loss:.4} |")?;
    writeln!(out, "| decided (at most 0.2 or at least 0.8) | {decided} |")?;
    writeln!(
        out,
        "| right, of the decided | {right} |\n| faults called (at least 0.8) | {recall} |"
    )?;
    writeln!(out, "| precision (at least 0.8) | {precision} |")?;
    writeln!(
        out,
        "| faults invisible in the record, called (at least 0.8) | {} |",
        found.hidden_called
    )?;
    writeln!(out, "| likeliest cause right, for loops without a fault | {} |", found.causes)?;

    writeln!(out, "\n| probability | loops | predicted | observed |\n|---|---|---|---|")?;
    for (range, predicted, observed) in found.deciles.iter().filter(|(.., share)| share.n > 0) {
        let Share { n, .. } = observed;
        writeln!(
            out,
            "| {:.1} to {:.1} | {n} | {predicted:.3} | {observed} |",
            range.start, range.end
        )?;
    }

    let [a, b, c] = THRESHOLDS;
    writeln!(out, "\n| called a fault | at {a} | at {b} | at {c} |\n|---|---|---|---|")?;
    for (kind, [a, b, c]) in &found.called {
        writeln!(out, "| {kind} | {a} | {b} | {c} |")?;
    }
    Ok(())
}

/// Whether S is at or below the reported limit, and the distances from the training loops.
fn limited(out: &mut String, test: &Dataset, weighed: &[Weighed]) -> std::fmt::Result {
    let holds =
        |(truth, weighed): &(&Truth, &Weighed)| weighed.limit.is_none_or(|limit| truth.s <= limit);
    let all: Vec<(&Truth, &Weighed)> = test.truth.iter().zip(weighed).collect();
    let faulty: Vec<_> =
        all.iter().filter(|(truth, _)| at_fault(truth).is_some()).copied().collect();
    let mut groups: BTreeMap<&str, Vec<(&Truth, &Weighed)>> = BTreeMap::new();
    for each in &faulty {
        each.0.families.iter().for_each(|name| groups.entry(name).or_default().push(*each));
    }
    writeln!(
        out,
        "\nThe detection limit should hold for {LIMIT} of the valves at fault, visible or not. The limit holds if S \
         is at or below the limit, or if there is no limit.\n\n| valves at fault | limit holds |\n|---|---|"
    )?;
    writeln!(out, "| all | {} |", Share::of(faulty.iter().map(holds)))?;
    let cleared = |(_, weighed): &&(&Truth, &Weighed)| weighed.probability <= 0.2;
    writeln!(
        out,
        "| cleared (at most 0.2) | {} |",
        Share::of(faulty.iter().filter(cleared).map(holds))
    )?;
    for (name, part) in groups {
        writeln!(out, "| {name} | {} |", Share::of(part.iter().map(holds)))?;
    }
    let healthy: Vec<&(&Truth, &Weighed)> =
        all.iter().filter(|(truth, _)| !truth.cause.is_fault()).collect();
    let mut limits: Vec<f64> =
        healthy.iter().map(|(_, weighed)| weighed.limit.unwrap_or(f64::INFINITY)).collect();
    let mut spans: Vec<f64> = healthy
        .iter()
        .map(|(truth, weighed)| weighed.limit.map_or(f64::INFINITY, |l| l / truth.op_span))
        .collect();
    for values in [&mut limits, &mut spans] {
        values.sort_by(f64::total_cmp);
    }
    let median = |values: &[f64]| values.get(values.len() / 2).copied().unwrap_or(f64::NAN);
    writeln!(
        out,
        "\nA limit exists for {} loops without a fault. The median limit of all these loops is {:.2} % of \
         span, or {:.2} times the range of the OP. The limit is below 1 % of span for {} loops. A distance above 1 \
         (unlike all training loops) occurs in {} loops.",
        Share::of(limits.iter().map(|limit| limit.is_finite())),
        median(&limits),
        median(&spans),
        Share::of(limits.iter().map(|limit| *limit < 1.0)),
        Share::of(weighed.iter().map(|weighed| weighed.distance > 1.0))
    )
}

fn extent(out: &mut String, test: &Dataset, weighed: &[Weighed]) -> std::fmt::Result {
    let known = |truth: &Truth| ln_s(truth).map(|_| truth.s);
    let all = estimates(&test.truth, weighed, known, |weighed| weighed.s);
    writeln!(
        out,
        "\nEstimates are for visibly sticking valves with at least {FEWEST_SLIPS} slips. Intervals should contain \
         the true value for {COVERAGE} of these valves. \"Quantified\" means that the half-width of the interval \
         is at most {QUANTIFIED} of the estimate.\n\n\
         | | share | error, median | error, 90 % | coverage | width, median |\n\
         |---|---|---|---|---|---|"
    )?;
    let mut line = |name: &str, part: Vec<_>, of: usize, relative: bool| {
        let found = estimation(&part, relative);
        writeln!(
            out,
            "| {name} | {:.3} | {:.3} | {:.3} | {} | {:.3} |",
            part.len() as f64 / of as f64,
            found.error.0,
            found.error.1,
            found.coverage,
            found.width
        )
    };
    let of = |keep: &dyn Fn(&Weighed) -> bool| -> Vec<_> {
        all.iter().filter(|(.., weighed)| keep(weighed)).map(|(s, truth, _)| (*s, *truth)).collect()
    };
    let called = |weighed: &Weighed| weighed.probability >= THRESHOLDS[0];
    let quantified = |weighed: &Weighed| is_quantified(&weighed.s);
    line("S, relative to S", of(&|_| true), all.len(), true)?;
    line("S, quantified", of(&quantified), all.len(), true)?;
    line("S, called (0.8)", of(&called), all.len(), true)?;
    line("S, called and quantified", of(&|w| called(w) && quantified(w)), all.len(), true)?;
    // The cases of a user: also valves with masked stiction, or with few slips.
    let any = estimates(&test.truth, weighed, |truth| Some(truth.s), |weighed| weighed.s);
    let met: Vec<_> = any
        .iter()
        .filter(|(.., weighed)| called(weighed) && quantified(weighed))
        .map(|(s, truth, _)| (*s, *truth))
        .collect();
    line("S, of all sticking valves", met, any.len(), true)?;
    let ratio = estimates(&test.truth, weighed, j_over_s, |weighed| weighed.j_over_s);
    let ratio: Vec<_> = ratio.iter().map(|(j, truth, _)| (*j, *truth)).collect();
    let n = ratio.len();
    line("J/S", ratio, n, false)
}
