//! Whether the fitted valve explains the recorded swing, and the effects of actions.

use super::layout::{Section, Table};
use crate::words::rough;
use stiction_diagnose::diagnose::{Diagnosis, VerdictClass};
use stiction_diagnose::drawing::WIDTH;
use stiction_diagnose::fit::cycle::{Predicted, Swing};
use stiction_diagnose::fit::{Fit, FitOptions, Prospect, Prospects, fit, prospects};
use stiction_diagnose::fusion::Estimate;
use stiction_figure::figure::{Annotation, Figure, Panel, Scale, Series, colour};

/// Names of the rows of the figure.
const ROWS: &[&str] = &["", "PV swing", "OP swing", "period", ""];

/// The fitted loop of a recording, and the effects of actions.
pub(super) struct Fitted {
    pub fit: Fit,
    pub prospects: Result<Prospects, String>,
}

/// The fitted loop of an accused valve. Other valves need none.
pub(super) fn of_accused(diagnosis: &Diagnosis) -> Option<Fitted> {
    if diagnosis.verdict.class != VerdictClass::Sticks {
        return None;
    }
    let fit = fit(diagnosis, &FitOptions::default()).ok()?;
    let prospects = prospects(&fit);
    Some(Fitted { fit, prospects })
}

/// Adds the results of the fit.
pub(super) fn added_to(mut section: Section, Fitted { fit, prospects }: &Fitted) -> Section {
    section = section.heading("Does the valve explain the swing?");
    match (fit.cycle.known(), fit.cycle.why_not()) {
        (Some(cycle), _) => {
            let both = cycle.recorded.as_ref().zip(cycle.predicted.as_ref());
            let figure = both.map(|(recorded, predicted)| figure(recorded, predicted));
            section = section.paragraph(&cycle.sentence).with_all(figure);
        }
        (None, why) => {
            let why = why.unwrap_or("it was not tested");
            section = section.paragraph(format!("Not tested: {why}."));
        }
    }
    section = section.with(parts(fit));
    match prospects {
        Ok(found) => {
            let section = section.heading("Effects of actions").with(actions(found));
            section.list(found.advice.clone())
        }
        Err(why) => section.paragraph(format!(
            "The effects of actions are unknown: {why}. The verdict does not rest on this fit alone. Do the \
             manual test first."
        )),
    }
}

fn range(of: &Estimate) -> String {
    format!("{} to {}", rough(of.low), rough(of.high))
}

/// The parts of the loop with their intervals.
fn parts(fit: &Fit) -> Table {
    let caption = "The loop, identified from the recording: best values with 90 % intervals. S and J are the values \
        with which this process explains the PV. The values without a process model are at the top.";
    let mut table = Table::new(caption).words("part").words("value").words("interval");
    let mut row = |name: &str, of: &Estimate, unit: &str| {
        let value = format!("{} {unit}", rough(of.value));
        let cells = [name.to_owned(), value.trim_end().to_owned(), range(of)];
        table = std::mem::take(&mut table).row(cells);
    };
    if let Some(c) = fit.controller.known() {
        row(&format!("controller ({}): Kc", c.structure.name()), &c.kc, "% per PV unit");
        c.ti_s.iter().for_each(|ti| row("Ti", ti, "s"));
        c.td_s.iter().for_each(|td| row("Td", td, "s"));
        c.set_point.iter().for_each(|sp| row("set point, not recorded", sp, ""));
    }
    if let Some(valve) = fit.valve.known() {
        row("valve: S", &valve.s, "%");
        row("J", &valve.j, "%");
    }
    if let Some(p) = fit.process.known() {
        match &p.gain {
            Some(gain) => row("process: gain", gain, "PV units per %"),
            None => row("process: initial slope", &p.slope, "PV units per % and s"),
        }
        p.lag_s.iter().for_each(|lag| row("lag", lag, "s"));
        row("dead time", &p.dead_time_s, "s");
    }
    let missing = [
        ("controller", fit.controller.why_not()),
        ("valve", fit.valve.why_not()),
        ("process", fit.process.why_not()),
    ];
    for (name, why) in missing {
        if let Some(why) = why {
            table = table.row([name.to_owned(), "not identified".to_owned(), why.to_owned()]);
        }
    }
    table
}

/// The predicted quantities, each relative to the recorded one.
fn figure(recorded: &Swing, predicted: &Predicted) -> Figure {
    let all = [
        (3.0, recorded.period_s, &predicted.period_s),
        (2.0, recorded.op, &predicted.op),
        (1.0, recorded.pv, &predicted.pv),
    ];
    let (mut x, mut y, mut middle, mut at) = (vec![], vec![], vec![], vec![]);
    let mut most: f64 = 1.2;
    for (place, is, of) in all {
        if !(is > 0.0) {
            continue;
        }
        let (low, high) = (of.low / is, (of.high / is).min(4.0));
        x.extend([low, high]);
        y.extend([place, place]);
        middle.push((of.value / is).min(4.0));
        at.push(place);
        most = most.max(1.1 * high);
    }
    let breaks: Vec<usize> = (2..x.len()).step_by(2).collect();
    let panel = Panel::new("predicted / recorded", "")
        .x_range(0.0, most)
        .y_range(0.3, 3.7)
        .y_scale(Scale::Names(ROWS))
        .with(Series::line("90 % of the fitted loops", x, y).colour(colour::BLUE).breaks(breaks))
        .with(Series::points("median", middle, at).colour(colour::VERMILION))
        .note(Annotation::vertical_line(1.0, "as recorded"))
        .height(130.0);
    Figure::new("The limit cycle of the fitted loop beside the recorded swing")
        .caption(
            "If the bars reach the line, the fitted loop cycles by itself as recorded. Noise and loads make a stem \
             slip sooner than it would by itself.",
        )
        .with(panel)
        .width(WIDTH)
}

/// The effects of the actions.
fn actions(found: &Prospects) -> Table {
    let caption = format!(
        "Effects of each action, on {} loops that agree with the recording. Ranges are 5 to 95 % points, ranked by \
         the upper end of the control error. \"x present\" is the ratio to the loop as it is.",
        found.loops
    );
    let table = Table::new(caption)
        .columns("action | control error, x present | PV swing, x present | PV swing, ± | valve travel, %/h | \
             benefit");
    found.actions.iter().fold(table, |table, row| {
        table.row([
            row.action.name().to_owned(),
            Prospect::range(&row.error_ratio, &row.error_ratio),
            Prospect::range(&row.pv_swing_ratio, &row.pv_swing_ratio),
            Prospect::range(&row.pv_swing, &row.pv_swing_ratio),
            range(&row.travel),
            row.benefit().to_owned(),
        ])
    })
}
