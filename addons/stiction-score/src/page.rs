//! The accuracy of the verdict and the published methods, as tables and as one page.
//!
//! The same tables serve the page and the terminal. They name methods by [`MethodRow::name`] or [`MethodRow::title`].

use crate::Error;
use crate::scoreboard::{
    Auc, Band, Board, Counts, Errors, FoundBand, KindRow, MethodRow, Outcomes, Quantification,
    Scored, Share, VERDICT,
};
use std::sync::LazyLock;
use stiction_diagnose::finding::Decides;
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Scale, Series, colour};
use stiction_population::LoopKind;
use stiction_report::report::layout::{Badge, Block, Fact, Report, Table, number};

/// The content of a page.
#[derive(Debug, Clone, Copy)]
pub struct Scoreboard<'a> {
    /// Title, such as `100 simulated loops`.
    pub title: &'a str,
    /// Where the loops come from, a paragraph.
    pub introduction: &'a str,
    /// The counts.
    pub board: &'a Board,
    /// The loops behind the counts.
    pub loops: &'a [Scored],
    /// Paths of the reports of the loops, relative to the page; empty for none.
    pub reports: &'a [String],
    /// Median time per loop of each method, microseconds; empty if not measured.
    pub times: &'a [(String, f64)],
    /// Name and version of the program.
    pub tool: &'a str,
}

/// A function that names methods, by [`MethodRow::name`] or [`MethodRow::title`].
pub type Names = fn(&MethodRow) -> &'static str;

/// The page as one self-contained HTML document. Equal input gives equal bytes.
///
/// # Errors
/// If a figure cannot be drawn, which is not expected.
pub fn html(of: &Scoreboard<'_>) -> Result<String, Error> {
    let board = of.board;
    let names: Names = MethodRow::title;
    let mut report = Report::new(of.title, of.tool).introduction(of.introduction);
    report = report.block(Block::Facts(facts(board)));
    report = report.block(Block::Paragraph(READING.to_owned()));

    let of_valves = has_valves(board).then(|| decisions_on_valves(board, names));
    report = report.titled("Decisions", [decisions(board, names)].into_iter().chain(of_valves));
    let ranked = [Block::Paragraph(RANKING.to_owned()), ranking(board, names).into()];
    let curves = characteristic(board).map(Block::from);
    report = report.titled("Ranking", ranked.into_iter().chain(curves));
    if let Some(kinds) = by_kind(board) {
        let figure = false_alarms(board).map(Block::from);
        let methods = methods_by_kind(board, names)
            .map(|table| Block::details("Every method on every kind", table));
        let blocks = figure.into_iter().chain([kinds.into()]).chain(methods);
        report = report.titled("By kind of loop", blocks);
    }
    let none = "No loop has a probability, so there is nothing to compare.";
    let probabilities = match (reliability(board), calibration(board)) {
        (Some(figure), Some(table)) => vec![Block::from(figure), table.into()],
        _ => vec![Block::Paragraph(none.to_owned())],
    };
    report
        .titled("Probabilities", probabilities)
        .titled("Size of stiction", quantification(board))
        .titled("Confident errors", sureness(board))
        .titled("Sticking valves found", found(board))
        .titled("Undecided loops", undecided(board))
        .titled("Time", (!of.times.is_empty()).then(|| times(of.times)))
        .titled("Loops", [loops(of.loops, of.reports)])
        .html()
}

const READING: &str = "Brackets contain 95 % intervals. An abstention or an open decision is neither right nor \
    wrong. Both lower recall and raise no alarm. \"Does not respond\" counts as an accusation, just as \"sticks\" \
    does. No threshold was fitted to any of these loops.";

const RANKING: &str = "The AUC (area under the receiver operating characteristic) compares all pairs of a sticking and \
    a healthy recording. The AUC is the share of pairs in which the sticking recording has the larger statistic \
    or, for the verdict, probability. Ties count half, and 0.5 is chance. Recordings on which a method abstains are left out, and the table \
    shows how many remain. Under \"of all\", a pair with an omitted recording counts half. Intervals come \
    from 2,000 bootstrap draws of valves within each class.";

/// The numbers of loops and the main results.
fn facts(board: &Board) -> Vec<Fact> {
    let mut facts = vec![
        Fact::new("sticking recordings", board.sticky, ""),
        Fact::new("healthy recordings", board.healthy, ""),
    ];
    if has_valves(board) {
        facts.push(Fact::new("sticking valves", board.sticky_valves, ""));
        facts.push(Fact::new("healthy valves", board.healthy_valves, ""));
    }
    if board.hidden.k > 0 {
        facts.push(Fact::new("with masked stiction, left out", board.hidden.k, ""));
    }
    let Some(verdict) = board.methods.first() else { return facts };
    facts.push(Fact::new("recall of the verdict", share(verdict.recordings.recall()), ""));
    facts.push(Fact::new(
        "false alarms of the verdict",
        share(verdict.recordings.false_alarms()),
        "",
    ));
    if let Some(auc) = &verdict.auc {
        facts.push(Fact::new("AUC of the probability", area(auc), ""));
    }
    if let Some(calibration) = &board.calibration {
        facts.push(Fact::new("Brier score", number(calibration.brier), ""));
    }
    facts
}

/// Whether some valves have several recordings.
pub fn has_valves(board: &Board) -> bool {
    board.sticky_valves + board.healthy_valves < board.sticky + board.healthy
}

/// The decisions of each method on recordings.
pub fn decisions(board: &Board, names: Names) -> Table {
    let hidden = match board.hidden.k {
        0 => String::new(),
        n => format!(" {n} with masked stiction are left out."),
    };
    let caption = format!(
        "{} sticking and {} healthy recordings.{hidden}{}",
        board.sticky,
        board.healthy,
        star_note(board)
    );
    outcomes(board, names, caption, |row| &row.recordings)
}

/// The decisions of each method on valves, by the majority of a valve's recordings.
pub fn decisions_on_valves(board: &Board, names: Names) -> Table {
    let caption = format!(
        "{} sticking and {} healthy valves, each judged by the majority of its recordings.",
        board.sticky_valves, board.healthy_valves
    );
    outcomes(board, names, caption, |row| &row.valves)
}

fn outcomes(
    board: &Board,
    names: Names,
    caption: String,
    of: fn(&MethodRow) -> &Outcomes,
) -> Table {
    let table = Table::new(caption).columns(
        "method | #recall | #false alarms | #precision | #no decision | #right if decided",
    );
    board.methods.iter().fold(table, |table, row| {
        let outcomes = of(row);
        table.row([
            starred(row, names),
            share(outcomes.recall()),
            share(outcomes.false_alarms()),
            share(outcomes.precision()),
            percent(outcomes.without_decision().value()),
            share(outcomes.accuracy()),
        ])
    })
}

/// The ranking by each statistic.
pub fn ranking(board: &Board, names: Names) -> Table {
    let valves = has_valves(board);
    let mut table =
        Table::new("").columns("method | #AUC of recordings | #sticking + healthy | #of all");
    if valves {
        table = table.columns("#AUC of valves | #sticking + healthy | #of all");
    }
    let cells = |auc: &Option<Auc>| match auc {
        Some(auc) => {
            [area(auc), format!("{} + {}", auc.sticky, auc.healthy), format!("{:.3}", auc.of_all)]
        }
        None => [DASH, DASH, DASH].map(str::to_owned),
    };
    board.methods.iter().fold(table, |table, row| {
        let mut line = vec![starred(row, names)];
        line.extend(cells(&row.auc));
        if valves {
            line.extend(cells(&row.auc_of_valves));
        }
        table.row(line)
    })
}

/// The decisions of the verdict on each kind of loop; `None` if kinds are unknown.
pub fn by_kind(board: &Board) -> Option<Table> {
    let table = Table::new("The verdict on each kind of loop.")
        .columns("kind | #loops | valve | #called sticking | #called not sticking | #no decision");
    let row = |table: Table, kind: &KindRow| {
        let counts = kind.counts.get(VERDICT).copied().unwrap_or_default();
        let open = Share { k: counts.undecided + counts.abstains, n: counts.all() };
        table.row([
            kind.kind.clone(),
            kind.loops.to_string(),
            if kind.sticks { "sticks" } else { "healthy" }.to_owned(),
            share(called(counts)),
            share(Share { k: counts.negative, n: counts.all() }),
            percent(open.value()),
        ])
    };
    (!board.kinds.is_empty()).then(|| board.kinds.iter().fold(table, row))
}

/// The share of each kind of loop that each method calls sticking; `None` if kinds are unknown.
pub fn methods_by_kind(board: &Board, names: Names) -> Option<Table> {
    let caption = format!(
        "Share of the loops called sticking. Brackets contain the share without a decision, if any.{}",
        star_note(board)
    );
    let table = board
        .kinds
        .iter()
        .fold(Table::new(caption).words("method"), |table, kind| table.numbers(&kind.kind, ""));
    let rows = board.methods.iter().fold(table, |table, row| {
        let cell = |kind: &KindRow| {
            let counts = kind.counts.get(row.name).copied().unwrap_or_default();
            let open = counts.undecided + counts.abstains;
            let text = percent(called(counts).value());
            if open == 0 {
                return text;
            }
            let open = Share { k: open, n: counts.all() };
            format!("{text} ({})", percent(open.value()))
        };
        table.row(std::iter::once(starred(row, names)).chain(board.kinds.iter().map(cell)))
    });
    (!board.kinds.is_empty()).then_some(rows)
}

/// Calibration of the probabilities; `None` without probabilities.
pub fn calibration(board: &Board) -> Option<Table> {
    let calibration = board.calibration.as_ref()?;
    let caption = format!(
        "{} probabilities: Brier score {:.3}, expected calibration error {:.3}.",
        calibration.n, calibration.brier, calibration.error
    );
    let table = Table::new(caption).columns("from | to | #loops | #predicted | #observed");
    Some(calibration.bins.iter().fold(table, |table, bin| {
        table.row([
            percent(Some(bin.from)),
            percent(Some(bin.to)),
            bin.observed.n.to_string(),
            bin.predicted.map_or(DASH.to_owned(), |p| format!("{:.1} %", 100.0 * p)),
            share(bin.observed),
        ])
    }))
}

/// The accuracy of estimates of S and J; `None` if the truth is unknown.
pub fn quantification(board: &Board) -> Option<Table> {
    let table = Table::new(
        "Sticking loops: share with an estimate, errors of the estimates, and share of intervals that contain the \
         true value.",
    )
    .columns("| #quantified | #error, median [% of span] | #90 % below [% of span] | #relative, median | #90 % below \
         | #coverage");
    let row = |table: Table, name: &str, of: &Option<Quantification>| {
        let Some(of) = of else { return table };
        let cells = |errors: Option<Errors>, write: fn(Option<f64>) -> String| {
            [write(errors.map(|e| e.median)), write(errors.map(|e| e.p90))]
        };
        let mut line = vec![name.to_owned(), share(of.quantified)];
        line.extend(cells(of.absolute, |v| v.map_or(DASH.to_owned(), |v| format!("{v:.2}"))));
        line.extend(cells(of.relative, percent));
        line.push(share(of.covered));
        table.row(line)
    };
    let table = row(row(table, "S", &board.s), "J", &board.j);
    (!table.rows.is_empty()).then_some(table)
}

/// The confident errors of the verdict; `None` if it is never confident.
pub fn sureness(board: &Board) -> Option<Table> {
    let of = board.sureness?;
    let table = Table::new(
        "Limits of S, and probabilities near 0 and 1, compared with the truth. Masked stiction counts in the first \
         three rows, because a limit must hold for masked stiction, too.",
    )
    .columns("of | those | #share");
    let row = |table: Table, of: &str, those: &str, is: Share| {
        table.row([of.to_owned(), those.to_owned(), share(is)])
    };
    let sticking = "sticking loops";
    let table = row(table, "sticking loops with a limit", "whose S exceeds it", of.above);
    let table = row(table, sticking, "that are cleared", of.cleared);
    let table = row(table, "these", "whose S exceeds the reported limit, if any", of.cleared_above);
    let table = row(table, "visible and healthy loops", "with p up to 2 % or from 98 %", of.sure);
    let table = row(table, "these", "that are wrong", of.wrong);
    let limit = of.limit.map_or(DASH.to_owned(), |limit| format!("{limit:.2} %"));
    Some(table.row(["healthy loops that are cleared".to_owned(), "median limit".to_owned(), limit]))
}

/// The share of sticking valves found, by the clarity of their records; `None` without members of a mixed population.
pub fn found(board: &Board) -> Option<Table> {
    let of = board.found.as_ref()?;
    let table = Table::new(
        "Sticking valves found, among members of the mixed population whose records show slips. Rows group these \
         valves by the information gain of an observer who knows the stem, and by the number of slips.",
    )
    .columns("by | from | below | #loops | #called sticking | #called not sticking | #p from 90 % | #p from 80 %");
    let rows = |table: Table, by: &str, bands: &[FoundBand]| {
        bands.iter().fold(table, |table, of| {
            let Band { from, to } = of.band;
            table.row([
                by.to_owned(),
                number(from),
                to.map_or(DASH.to_owned(), number),
                of.called.n.to_string(),
                share(of.called),
                share(of.cleared),
                share(of.p90),
                share(of.p80),
            ])
        })
    };
    Some(rows(rows(table, "nats", &of.by_gain), "slips", &of.by_slips))
}

/// The rules that suppress decisions; `None` without members of a mixed population.
pub fn undecided(board: &Board) -> Option<Table> {
    let of = board.undecided.as_ref()?;
    let caption = format!(
        "Undecided loops, {} of {} members of the mixed population, by the rule that suppresses the decision and by \
         their probability. Loops with masked faults are left out.",
        of.all.k, of.all.n
    );
    let table = Table::new(caption)
        .columns("suppressed by | p from | below | #loops | #of all | #at fault | #share at fault");
    Some(of.rows.iter().fold(table, |table, held| {
        table.row([
            held.ruling.map_or("no evidence", |ruling| ruling.name()).to_owned(),
            percent(held.probability.map(|band| band.from)),
            percent(held.probability.and_then(|band| band.to)),
            held.loops.k.to_string(),
            held.loops.value().map_or(DASH.to_owned(), |v| format!("{:.1} %", 100.0 * v)),
            held.at_fault.k.to_string(),
            share(held.at_fault),
        ])
    }))
}

/// The times of the diagnosis and its methods.
pub fn times(times: &[(String, f64)]) -> Table {
    let table =
        Table::new("Median time per loop, including loops on which a method abstains at once. Times vary between \
            runs and between machines.")
            .columns("part | #time [µs]");
    times.iter().fold(table, |table, (name, time)| table.row([name.clone(), number(*time)]))
}

/// Every loop with its truth and its verdict.
fn loops(loops: &[Scored], reports: &[String]) -> Table {
    let kinds = loops.iter().any(|each| !each.truth.kind.is_empty());
    let valves = loops.iter().any(|each| each.truth.valve != each.name);
    let mut table = Table::new("").words("loop");
    if valves {
        table = table.words("valve");
    }
    if kinds {
        table = table.words("kind");
    }
    table = table.columns("truth | verdict | #probability [%] | #S [%] | #true S [%]").sortable();
    table.links = reports.to_vec();
    loops.iter().fold(table, |table, each| {
        let truth = &each.truth;
        let said = match (truth.sticks, truth.visible) {
            (true, true) => "sticks",
            (true, false) => "sticks, masked",
            (false, _) => "healthy",
        };
        let optional = |value: Option<f64>| value.map_or(DASH.to_owned(), number);
        let mut line = vec![each.name.clone()];
        if valves {
            line.push(truth.valve.clone());
        }
        if kinds {
            line.push(truth.kind.clone());
        }
        line.extend([
            said.to_owned(),
            Badge::from(each.verdict).text(),
            each.probability.map_or(DASH.to_owned(), |p| format!("{:.1}", 100.0 * p)),
            each.s.map_or(DASH.to_owned(), |s| number(s.value)),
            optional(truth.s),
        ]);
        table.row(line)
    })
}

pub(crate) const DASH: &str = "–";

/// A share in percent with its 95 % interval; a dash without loops.
pub fn share(share: Share) -> String {
    let Some(value) = share.value() else { return DASH.to_owned() };
    let (low, high) = share.interval();
    format!("{} ({:.0} to {:.0})", percent(Some(value)), 100.0 * low, 100.0 * high)
}

pub(crate) fn percent(value: Option<f64>) -> String {
    value.map_or(DASH.to_owned(), |v| format!("{:.0} %", 100.0 * v))
}

/// An area with its interval.
fn area(auc: &Auc) -> String {
    format!("{:.3} ({:.2} to {:.2})", auc.value, auc.low, auc.high)
}

fn called(counts: Counts) -> Share {
    Share { k: counts.positive, n: counts.all() }
}

fn decides_on_linearity(row: &MethodRow) -> bool {
    row.method.is_some_and(|method| method.decides == Decides::Nonlinearity)
}

fn starred(row: &MethodRow, names: Names) -> String {
    format!("{}{}", names(row), if decides_on_linearity(row) { " *" } else { "" })
}

fn star_note(board: &Board) -> &'static str {
    match board.methods.iter().any(decides_on_linearity) {
        true => " Methods marked * detect nonlinearity from any cause.",
        false => "",
    }
}

/// Number of methods drawn beside the verdict.
const CURVES: usize = 4;

/// The axes of receiver operating characteristics.
pub(crate) fn roc_panel() -> Panel {
    Panel::new("false-alarm rate", "recall")
        .x_range(0.0, 1.0)
        .y_range(0.0, 1.0)
        .equal_aspect()
        .legend(Legend::BottomRight)
}

/// The receiver operating characteristics of the verdict and of the best methods.
fn characteristic(board: &Board) -> Option<Figure> {
    // A method that judges only a few loops does not rank all of them.
    let speaks = |row: &&MethodRow| {
        row.auc.is_some_and(|a| 2 * a.sticky >= board.sticky && 2 * a.healthy >= board.healthy)
    };
    let value = |row: &MethodRow| row.auc.map_or(0.0, |auc| auc.value);
    let mut best: Vec<&MethodRow> =
        board.methods.iter().filter(|row| row.method.is_some()).filter(speaks).collect();
    best.sort_by(|a, b| value(b).total_cmp(&value(a)));
    let verdict = board.methods.iter().filter(|row| row.method.is_none() && !row.roc.is_empty());
    let curves: Vec<&MethodRow> = verdict.chain(best.into_iter().take(CURVES)).collect();
    if curves.is_empty() {
        return None;
    }
    let mut panel = roc_panel();
    for row in &curves {
        let (x, y): (Vec<f64>, Vec<f64>) = row.roc.iter().copied().unzip();
        let label = format!("{} ({:.3})", row.title(), value(row));
        panel = panel.with(Series::line(label, x, y));
    }
    let panel = panel.with(Series::dotted("chance", [0.0, 1.0], [0.0, 1.0]).colour(colour::BLACK));
    let caption = "Recall over false-alarm rate at every threshold, for the recordings on which a method does not \
        abstain, with the AUC in brackets. The curves show the verdict's probability, if available, and the \
        best methods that judge at least half of each class.";
    Some(Figure::new("").caption(caption).with(panel).width(640.0))
}

/// Predicted probabilities over the observed shares, with the number of loops of each.
fn reliability(board: &Board) -> Option<Figure> {
    let calibration = board.calibration.as_ref()?;
    let label = "probability that the valve sticks";
    let (mut x, mut y, mut bar_x, mut bar_y) = (vec![], vec![], vec![], vec![]);
    for bin in &calibration.bins {
        let (Some(predicted), Some(observed)) = (bin.predicted, bin.observed.value()) else {
            continue;
        };
        let (low, high) = bin.observed.interval();
        x.push(predicted);
        y.push(observed);
        bar_x.extend([predicted, predicted]);
        bar_y.extend([low, high]);
    }
    let breaks: Vec<usize> = (2..bar_x.len()).step_by(2).collect();
    let points = Panel::new(label, "share that sticks")
        .with(Series::dashed("as predicted", [0.0, 1.0], [0.0, 1.0]).colour(colour::BLACK))
        .with(Series::line("95 % interval", bar_x, bar_y).colour(colour::BLUE).breaks(breaks))
        .with(Series::points("observed", x, y).colour(colour::VERMILION))
        .x_range(0.0, 1.0)
        // Points at the ends are drawn whole.
        .y_range(-0.02, 1.02)
        .legend(Legend::TopLeft)
        .height(360.0);
    let middles: Vec<f64> = calibration.bins.iter().map(|bin| 0.5 * (bin.from + bin.to)).collect();
    let counts: Vec<f64> = calibration.bins.iter().map(|bin| bin.observed.n as f64).collect();
    let histogram = Panel::new(label, "loops")
        .with(Series::bars("loops", middles, counts).colour(colour::SKY))
        .x_range(0.0, 1.0)
        .height(110.0);
    let caption = "Share of sticking loops among all loops with about this probability, with 95 % intervals \
        (Wilson). The lower panel shows the number of loops.";
    Some(Figure::new("").caption(caption).with(points).with(histogram).width(640.0))
}

/// Names of all kinds of simulated loops, for an axis.
static KINDS: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| LoopKind::ALL.iter().rev().map(|kind| kind.name()).collect());

/// The share of each kind of loop that the verdict calls sticking.
fn false_alarms(board: &Board) -> Option<Figure> {
    let place = |row: &KindRow| KINDS.iter().position(|name| *name == row.kind);
    let shares: Vec<(f64, bool, Share)> = board
        .kinds
        .iter()
        .filter_map(|row| Some((place(row)? as f64, row.sticks, called(*row.counts.get(VERDICT)?))))
        .collect();
    if shares.is_empty() {
        return None;
    }
    let mut panel = Panel::new("called sticking (%)", "")
        // Points at the ends are drawn whole.
        .x_range(-1.0, 101.0)
        .y_range(-0.6, KINDS.len() as f64 + 0.2)
        .y_scale(Scale::Names(KINDS.as_slice()))
        .legend(Legend::Above)
        .height(24.0 * KINDS.len() as f64 + 20.0);
    let (mut at, mut ends, mut stems) = (vec![], vec![], vec![]);
    for (place, _, share) in &shares {
        let (low, high) = share.interval();
        at.extend([*place, *place]);
        ends.extend([100.0 * low, 100.0 * high]);
        stems.extend([0.0, 100.0 * share.value().unwrap_or(0.0)]);
    }
    let breaks: Vec<usize> = (2..at.len()).step_by(2).collect();
    panel = panel
        .with(
            Series::line("95 % interval", ends, &at[..]).colour(colour::BLACK).breaks(&breaks[..]),
        )
        .with(Series::dotted("", stems, at).colour(colour::BLACK).breaks(breaks));
    for (label, sticks, hue) in [
        ("healthy valve: false alarms", false, colour::VERMILION),
        ("sticking valve: found", true, colour::GREEN),
    ] {
        let of: Vec<_> = shares.iter().filter(|(_, each, _)| *each == sticks).collect();
        if !of.is_empty() {
            let x: Vec<f64> =
                of.iter().map(|(_, _, share)| 100.0 * share.value().unwrap_or(0.0)).collect();
            let y: Vec<f64> = of.iter().map(|(place, _, _)| *place).collect();
            panel = panel.with(Series::points(label, x, y).colour(hue));
        }
    }
    let panel = panel.note(Annotation::vertical_line(5.0, "5 %"));
    let caption =
        "The share of each kind of loop that the verdict calls sticking, with 95 % intervals.";
    Some(Figure::new("").caption(caption).with(panel).width(760.0))
}
