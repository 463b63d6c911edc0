//! Results as tables and as one page.

use super::results::{Compared, Entry, Results};
use crate::Error;
use crate::page::{DASH, percent, roc_panel, share};
use crate::scoreboard::{
    Answer, Errors, GroupMeasure, Interval, KindMeasure, KnownLoop, Quantification,
};
use stiction_figure::figure::{Figure, Legend, Panel, Scale, Series, colour};
use stiction_report::report::layout::{Block, Fact, Report, Table};

/// Detectors that are drawn and have columns of their own; of more, the best by AUC.
const CURVES: usize = 6;
/// Number of rows of a list of loops to look at.
const ROWS: usize = 12;

/// The page as one self-contained HTML document. Equal input gives equal bytes.
///
/// # Errors
/// If a figure cannot be drawn, which is not expected.
pub fn html(results: &Results, asked: &[KnownLoop]) -> Result<String, Error> {
    let report = Report::new(results.loops.title(), &results.tool).introduction(READING);
    let report = report.block(Block::Facts(facts(results)));
    let of_all = [characteristic(results), risk(results)].map(Block::from);
    let by_nats = nats(results).map(|table| (recall_by_nats(results).map(Block::from), table));
    let by_nats = by_nats.map(|(figure, table)| figure.into_iter().chain(captioned([table])));
    report
        .titled("Leaderboard", captioned([leaderboard(results).sortable()]).chain(of_all))
        .titled("Differences", captioned(comparisons(results)))
        .titled("Recall by evidence", by_nats.into_iter().flatten())
        .titled("Calls by kind of loop", captioned(kinds(results).map(Table::sortable)))
        .titled("Ranking by property", captioned(groups(results).map(Table::sortable)))
        .titled("Probabilities", captioned(sure(results)))
        .titled("Size of stiction", captioned(sizes(results)))
        .titled("Missing answers", captioned(failures(results)))
        .titled("Detectors", captioned([detectors(results)]))
        .titled("Loops to look at", captioned(loops(results, asked)))
        .html()
}

/// Tables, each after a paragraph with its caption, so that the caption scrolls with a wide table on a narrow screen.
fn captioned(tables: impl IntoIterator<Item = Table>) -> impl Iterator<Item = Block> {
    tables.into_iter().flat_map(|mut table| {
        let caption = std::mem::take(&mut table.caption);
        [Block::Paragraph(caption), table.into()]
    })
}

/// All tables except the lists of loops, in Markdown.
pub fn markdown(results: &Results) -> String {
    let mut out = format!("# {}\n\n{READING}\n", results.loops.title());
    for table in tables(results) {
        out.push('\n');
        out += &table.markdown();
    }
    out
}

/// The tables that fit a terminal with many detectors.
pub fn summary(results: &Results) -> Vec<Table> {
    let some = [comparisons(results), sure(results), sizes(results), failures(results)];
    std::iter::once(leaderboard(results)).chain(some.into_iter().flatten()).collect()
}

/// All tables except the lists of loops, in their order.
pub fn tables(results: &Results) -> Vec<Table> {
    let of = [comparisons, nats, kinds, groups, sure, sizes, failures];
    let some = of.into_iter().filter_map(|table| table(results));
    [leaderboard(results)].into_iter().chain(some).chain([detectors(results)]).collect()
}

const READING: &str = "Brackets contain 95 % intervals. An abstention lowers recall and raises no alarm, and a missing \
    answer counts as an abstention. Masked stiction is left out, except in recall by evidence.";

fn facts(results: &Results) -> Vec<Fact> {
    let Some(first) = results.entries.first() else { return vec![] };
    let of = &first.measures;
    vec![
        Fact::new("sticking loops", of.sticky, ""),
        Fact::new("healthy loops", of.healthy, ""),
        Fact::new("with masked stiction", of.masked, ""),
        Fact::new("detectors", results.entries.len(), ""),
    ]
}

/// The detectors, the best first by AUC over all loops.
fn ranked(results: &Results) -> Vec<&Entry> {
    let mut entries: Vec<&Entry> = results.entries.iter().collect();
    let value = |entry: &Entry| entry.measures.auc.map_or(0.5, |auc| auc.of_all);
    entries.sort_by(|a, b| value(b).total_cmp(&value(a)));
    entries
}

/// The main measures of each detector.
pub fn leaderboard(results: &Results) -> Table {
    let table = Table::new(
        "Detectors, by the AUC over all loops, in which a pair counts half if one of its loops has no score. The risk is \
         the share of errors among the accepted loops, averaged over all numbers of accepted loops.",
    )
    .columns("detector | #AUC of all | #AUC of scored | #recall at 1 % false alarms | #recall | #false alarms | \
         #right if decided | #no decision | #mean risk | #median time [ms] | #no answer");
    ranked(results).into_iter().fold(table, |table, entry| {
        let of = &entry.measures;
        let decided = of.decisions;
        table.row([
            entry.detector.name.clone(),
            of.auc.map_or(DASH.to_owned(), |auc| format!("{:.3}", auc.of_all)),
            of.auc.map_or(DASH.to_owned(), |auc| {
                format!("{:.3} ({:.3} to {:.3})", auc.value, auc.low, auc.high)
            }),
            percents(of.recall_at_1_percent),
            share(decided.recall()),
            share(decided.false_alarms()),
            share(decided.accuracy()),
            percent(decided.without_decision().value()),
            of.risk.as_ref().map_or(DASH.to_owned(), |risk| percents(Some(risk.area))),
            time(entry.time),
            (of.answered.n - of.answered.k).to_string(),
        ])
    })
}

fn time(errors: Option<Errors>) -> String {
    errors.map_or(DASH.to_owned(), |e| {
        let [median, low, high] = [e.median, e.median_low, e.median_high].map(|t| 1e3 * t);
        format!("{median:.1} ({low:.1} to {high:.1})")
    })
}

fn percents(interval: Option<Interval>) -> String {
    interval.map_or(DASH.to_owned(), |of| {
        let [value, low, high] = [of.value, of.low, of.high].map(|v| 100.0 * v);
        format!("{value:.0} % ({low:.0} to {high:.0})")
    })
}

fn p_value(p: f64) -> String {
    if p < 1e-4 { "< 0.0001".to_owned() } else { format!("{p:.4}") }
}

/// Two detectors on the same loops; `None` without two.
pub fn comparisons(results: &Results) -> Option<Table> {
    let table = Table::new(
        "Two detectors on the same loops. The AUC is over all loops, with interval and p-value by DeLong. The other \
         columns count loops that only one of the two detectors calls sticking, with the p-value of McNemar's exact test.",
    )
    .columns("first | second | #AUC, first less second | #p")
    .columns("#sticking: only first | #only second | #p")
    .columns("#healthy: only first | #only second | #p");
    let row = |table: Table, compared: &Compared| {
        let of = &compared.comparison;
        let mut line = vec![compared.first.clone(), compared.second.clone()];
        line.extend(match of.auc {
            Some(auc) => {
                let Interval { value, low, high } = auc.difference;
                [format!("{value:+.3} ({low:+.3} to {high:+.3})"), p_value(auc.p_value)]
            }
            None => [DASH, DASH].map(str::to_owned),
        });
        for each in [of.recall, of.false_alarms] {
            let counts = [each.only_first, each.only_second].map(|n| n.to_string());
            line.extend(counts);
            line.push(p_value(each.p_value));
        }
        table.row(line)
    };
    let rows = results.comparisons.iter().fold(table, row);
    (!rows.rows.is_empty()).then_some(rows)
}

/// Recall by the gain of the observer who knows the stem; `None` without such loops.
pub fn nats(results: &Results) -> Option<Table> {
    let bands = &results.entries.first()?.measures.nats;
    let table = Table::new(of_drawn(
        results,
        "Sticking loops of the population, masked ones included, by the information gain in nats of an observer who \
         knows the stem. The observer's recall at 1 % false alarms is the ceiling. Each detector has two columns: the \
         share that it calls sticking, and its recall at its own threshold with 1 % false alarms.",
    ))
    .columns("nats from | below | #loops | #observer");
    let shown = drawn(results);
    let table = shown.iter().fold(table, |table, entry| {
        let name = &entry.detector.name;
        table.numbers(format!("{name}: called"), "").numbers("at 1 %", "")
    });
    let rows = bands.iter().enumerate().fold(table, |table, (k, row)| {
        let mut line = vec![
            row.band.from.to_string(),
            row.band.to.map_or(DASH.to_owned(), |to| to.to_string()),
            row.called.n.to_string(),
            percent(row.observer),
        ];
        for entry in &shown {
            let of = &entry.measures.nats[k];
            line.extend([share(of.called), share(of.at_1_percent)]);
        }
        table.row(line)
    });
    (!bands.is_empty()).then_some(rows)
}

/// The share of each kind that each detector calls sticking; `None` if kinds are unknown.
pub fn kinds(results: &Results) -> Option<Table> {
    let kinds = &results.entries.first()?.measures.kinds;
    let table = Table::new(of_drawn(
        results,
        "Share of each kind of loop that a detector calls sticking: recall of sticking valves, false alarms of healthy \
         valves.",
    ))
    .columns("kind | valve | #loops");
    let shown = drawn(results);
    let table =
        shown.iter().fold(table, |table, entry| table.numbers(entry.detector.name.clone(), ""));
    let rows = kinds.iter().enumerate().fold(table, |table, (k, kind)| {
        let state = if kind.sticks { "sticks" } else { "healthy" };
        let mut line = vec![kind.kind.clone(), state.to_owned(), kind.called.n.to_string()];
        let of = |entry: &Entry| -> Option<KindMeasure> { entry.measures.kinds.get(k).cloned() };
        let cell = |entry: &Entry| of(entry).map_or(DASH.to_owned(), |kind| share(kind.called));
        line.extend(shown.iter().map(|entry| cell(entry)));
        table.row(line)
    });
    (!kinds.is_empty()).then_some(rows)
}

/// The AUC of each detector on loops that share a property; `None` without properties.
pub fn groups(results: &Results) -> Option<Table> {
    let groups = &results.entries.first()?.measures.groups;
    let table = Table::new(of_drawn(results, "AUC over all loops that share a property."))
        .columns("property | value | #sticking + healthy");
    let shown = drawn(results);
    let table =
        shown.iter().fold(table, |table, entry| table.numbers(entry.detector.name.clone(), ""));
    let rows = groups.iter().enumerate().fold(table, |table, (k, group)| {
        let sizes = (group.decisions.sticky.all(), group.decisions.healthy.all());
        let mut line = vec![
            group.property.to_owned(),
            group.value.clone(),
            format!("{} + {}", sizes.0, sizes.1),
        ];
        let auc = |group: &GroupMeasure| {
            group.auc.map(|auc| format!("{:.2} ({:.2} to {:.2})", auc.value, auc.low, auc.high))
        };
        let cell = |entry: &Entry| entry.measures.groups.get(k).and_then(auc);
        line.extend(shown.iter().map(|e| cell(e).unwrap_or(DASH.to_owned())));
        table.row(line)
    });
    (!groups.is_empty()).then_some(rows)
}

/// Sure probabilities and their quality; `None` if no detector has probabilities.
pub fn sure(results: &Results) -> Option<Table> {
    let table = Table::new("Detectors that give a probability.")
        .columns("detector | #p up to 2 % or from 98 % | #wrong at these p | #Brier score | #expected calibration \
             error");
    let row =
        |table: Table, entry: &Entry| match (&entry.measures.sure, &entry.measures.calibration) {
            (Some(sure), Some(calibration)) => table.row([
                entry.detector.name.clone(),
                share(sure.sure),
                share(sure.wrong),
                format!("{:.3}", calibration.brier),
                format!("{:.3}", calibration.error),
            ]),
            _ => table,
        };
    let rows = results.entries.iter().fold(table, row);
    (!rows.rows.is_empty()).then_some(rows)
}

/// Estimates of S and J; `None` if no detector gives any.
pub fn sizes(results: &Results) -> Option<Table> {
    let table = Table::new("Estimates of S and J of sticking loops whose truth is known.")
        .columns("detector |  | #quantified | #error, median [% of span] | #90 % below [% of span] | #relative, \
             median | #intervals that contain the truth");
    let row = |table: Table, name: &str, what: &str, of: &Option<Quantification>| match of {
        Some(of) if of.quantified.k > 0 => {
            let [median, p90] = [|e: Errors| e.median, |e: Errors| e.p90]
                .map(|part| of.absolute.map_or(DASH.to_owned(), |e| format!("{:.2}", part(e))));
            let median = of.absolute.map_or(median.clone(), |e| {
                format!("{median} ({:.2} to {:.2})", e.median_low, e.median_high)
            });
            table.row([
                name.to_owned(),
                what.to_owned(),
                share(of.quantified),
                median,
                p90,
                percent(of.relative.map(|e| e.median)),
                share(of.covered),
            ])
        }
        _ => table,
    };
    let rows = results.entries.iter().fold(table, |table, entry| {
        let (name, of) = (&entry.detector.name, &entry.measures);
        row(row(table, name, "S", &of.s), name, "J", &of.j)
    });
    (!rows.rows.is_empty()).then_some(rows)
}

/// Reasons for missing answers; `None` if none is missing.
pub fn failures(results: &Results) -> Option<Table> {
    let table =
        Table::new("Loops without an answer.").columns("detector | #loops | first | reason");
    let rows = results.entries.iter().fold(table, |table, entry| {
        let failures = &entry.measures.failures;
        let table = failures.iter().take(ROWS).fold(table, |table, each| {
            let name = entry.detector.name.clone();
            table.row([name, each.loops.to_string(), each.first.clone(), each.reason.clone()])
        });
        match failures.iter().skip(ROWS).map(|each| each.loops).sum::<usize>() {
            0 => table,
            more => table.row([&entry.detector.name, &more.to_string(), DASH, "other reasons"]),
        }
    });
    (!rows.rows.is_empty()).then_some(rows)
}

/// The detectors with their commands and the hashes of their answers.
pub fn detectors(results: &Results) -> Table {
    let table = Table::new("Commands, and SHA-256 of the answers.")
        .columns("detector | version | command | SHA-256");
    results.entries.iter().fold(table, |table, entry| {
        let of = &entry.detector;
        table.row([&of.name, &of.version, &of.command, &entry.sha256])
    })
}

/// Lists of loops: where two detectors differ, or where one is wrong.
fn loops(results: &Results, asked: &[KnownLoop]) -> Vec<Table> {
    let answers: Vec<Vec<Answer>> = ranked(results)
        .iter()
        .map(|entry| entry.answers.iter().map(|said| said.answer()).collect())
        .collect();
    let names: Vec<&str> = ranked(results).iter().map(|entry| &entry.detector.name[..]).collect();
    let (Some(first), Some(name)) = (answers.first(), names.first()) else { return vec![] };
    let called = |answer: &Answer| answer.decision == stiction_diagnose::finding::Decision::Sticks;
    let list = |caption: String, of: Vec<usize>| {
        let table = Table::new(caption)
            .columns("loop | kind | #S [%] | #nats")
            .numbers(format!("score, {name}"), "");
        of.into_iter().take(ROWS).fold(table, |table, k| {
            let truth = &asked[k].truth;
            let number = |v: Option<f64>| v.map_or(DASH.to_owned(), |v| format!("{v:.1}"));
            let score = first[k].rank().map_or(DASH.to_owned(), |v| format!("{v:.3}"));
            table.row([
                asked[k].id.clone(),
                truth.kind.clone(),
                number(truth.s),
                number(truth.member.map(|m| m.gain)),
                score,
            ])
        })
    };
    let sorted = |is: &dyn Fn(usize) -> bool, by: &dyn Fn(usize) -> f64| -> Vec<usize> {
        let mut of: Vec<usize> =
            (0..asked.len()).filter(|k| asked[*k].counts() && is(*k)).collect();
        of.sort_by(|a, b| by(*b).total_cmp(&by(*a)));
        of
    };
    let gain = |k: usize| asked[k].truth.member.map_or(0.0, |member| member.gain);
    let score = |k: usize| first[k].rank().unwrap_or(f64::NEG_INFINITY);
    let sticks = |k: usize| asked[k].truth.sticks;
    let mut tables = vec![
        list(
            format!("Sticking loops that {name} does not call sticking, the clearest first."),
            sorted(&|k| sticks(k) && !called(&first[k]), &gain),
        ),
        list(
            format!("Healthy loops with the largest scores of {name}."),
            sorted(&|k| !sticks(k) && first[k].rank().is_some(), &score),
        ),
    ];
    if let (Some(second), Some(other)) = (answers.get(1), names.get(1)) {
        tables.push(list(
            format!("Sticking loops that {name} calls sticking and {other} does not, the clearest first."),
            sorted(&|k| sticks(k) && called(&first[k]) && !called(&second[k]), &gain),
        ));
        tables.push(list(
            format!("Sticking loops that {other} calls sticking and {name} does not, the clearest first."),
            sorted(&|k| sticks(k) && called(&second[k]) && !called(&first[k]), &gain),
        ));
        tables.push(list(
            format!("Healthy loops that only one of {name} and {other} calls sticking."),
            sorted(&|k| !sticks(k) && called(&first[k]) != called(&second[k]), &score),
        ));
    }
    tables.into_iter().filter(|table| !table.rows.is_empty()).collect()
}

/// A caption, with a note if only some detectors have columns.
fn of_drawn(results: &Results, caption: &str) -> String {
    match results.entries.len() {
        n if n > CURVES => format!("{caption} The best {CURVES} of {n} detectors are shown."),
        _ => caption.to_owned(),
    }
}

/// The drawn detectors.
fn drawn(results: &Results) -> Vec<&Entry> {
    let mut entries = ranked(results);
    entries.truncate(CURVES);
    entries
}

fn characteristic(results: &Results) -> Figure {
    let mut panel = roc_panel();
    for (k, entry) in drawn(results).into_iter().enumerate() {
        let (x, y): (Vec<f64>, Vec<f64>) = entry.measures.roc.iter().map(|[x, y]| (*x, *y)).unzip();
        if !x.is_empty() {
            panel = panel.with(Series::line(&entry.detector.name, x, y).colour(k));
        }
    }
    let panel = panel.with(Series::dotted("chance", [0.0, 1.0], [0.0, 1.0]).colour(colour::BLACK));
    let caption = "Recall over false-alarm rate at every threshold, for loops with a score.";
    Figure::new("").caption(caption).with(panel).width(640.0)
}

fn risk(results: &Results) -> Figure {
    let mut panel = Panel::new("coverage", "risk").x_range(0.0, 1.0).legend(Legend::Above);
    for (k, entry) in drawn(results).into_iter().enumerate() {
        if let Some(risk) = &entry.measures.risk {
            let (x, y): (Vec<f64>, Vec<f64>) = risk.points.iter().map(|[x, y]| (*x, *y)).unzip();
            panel = panel.with(Series::line(&entry.detector.name, x, y).colour(k));
        }
        let of = entry.measures.decisions;
        if let (Some(right), Some(open)) = (of.accuracy().value(), of.without_decision().value()) {
            panel = panel.with(Series::points("", [1.0 - open], [1.0 - right]).colour(k));
        }
    }
    let panel = panel.with(Series::dotted("chance", [0.0, 1.0], [0.5, 0.5]).colour(colour::BLACK));
    let caption = "Share of errors among the accepted loops over the share of loops that are accepted. The loops whose score is most \
        certain are accepted first. Scores are calibrated on the loops of other valves. Points are the detectors' own \
        decisions.";
    Figure::new("").caption(caption).with(panel.height(360.0)).width(760.0)
}

fn recall_by_nats(results: &Results) -> Option<Figure> {
    let bands = &results.entries.first()?.measures.nats;
    let middle = |from: f64, to: Option<f64>| (from.max(0.7) * to.unwrap_or(2.0 * from)).sqrt();
    let at = |of: &[crate::scoreboard::NatsMeasure],
              value: fn(&crate::scoreboard::NatsMeasure) -> Option<f64>| {
        let with =
            of.iter().filter_map(|row| Some((middle(row.band.from, row.band.to), value(row)?)));
        with.unzip::<f64, f64, Vec<f64>, Vec<f64>>()
    };
    let (x, y) = at(bands, |row| row.observer);
    if x.is_empty() {
        return None;
    }
    let mut panel =
        Panel::new("information gain of the observer (nats)", "recall at 1 % false alarms")
            .x_scale(Scale::Log)
            .y_range(0.0, 1.02)
            .legend(Legend::Above)
            .with(Series::dashed("observer who knows the stem", x, y).colour(colour::BLACK))
            .height(320.0);
    for (k, entry) in drawn(results).into_iter().enumerate() {
        let (x, y) = at(&entry.measures.nats, |row| row.at_1_percent.value());
        panel = panel.with(Series::line(&entry.detector.name, x, y).colour(k));
    }
    let caption =
        "Recall at 1 % false alarms of sticking loops, by how clearly the record shows the valve.";
    Some(Figure::new("").caption(caption).with(panel).width(760.0))
}
