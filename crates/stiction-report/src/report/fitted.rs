//! The fitted loop in words, whether its valve explains the recorded swing, and the effects of actions.

use super::layout::{Block, Fact, Section, Table, number};
use crate::words::rough;
use stiction_diagnose::diagnose::{Diagnosis, VerdictClass};
use stiction_diagnose::drawing::WIDTH;
use stiction_diagnose::fit::cycle::{Predicted, Swing};
use stiction_diagnose::fit::{Fit, FitOptions, Prospect, Prospects, fit, prospects};
use stiction_diagnose::fusion::Estimate;
use stiction_diagnose::spoken::set;
use stiction_figure::figure::{Annotation, Figure, Panel, Scale, Series, colour};

/// Names of the rows of the figure.
const ROWS: &[&str] = &["", "PV swing", "OP swing", "period", ""];

/// Explains the table of effects.
const LEGEND: &str = "Ranges are from the 5th to the 95th percentile. Rows are ranked by the upper end of the control \
    error and, if two are about equal, by effort: a setting, a compensator, a repair, a new part. PV swing is half of \
    the PV's peak-to-peak value in a period, without noise. \"× present\" is the ratio to the value of the present loop. Error is the \
    mean absolute control error. Settling is the settling time after a load step (– if the loop does not settle). The \
    benefit is certain if PV swing falls by more than 20 % with a probability of at least 95 %, and probable above 50 \
    %. With 50 % or less the benefit is uncertain.";

/// The fitted loop of a recording, and the effects of actions.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// The fitted loop.
    pub fit: Fit,
    /// The effects of actions, or why they are unknown.
    pub prospects: Result<Prospects, String>,
}

impl Fitted {
    /// Fits the loop of an accused valve, for its report. Other valves need no fit.
    pub fn of_accused(diagnosis: &Diagnosis) -> Option<Self> {
        if diagnosis.verdict.class != VerdictClass::Sticks {
            return None;
        }
        let fit = fit(diagnosis, &FitOptions::default()).ok()?;
        let prospects = prospects(&fit);
        Some(Self { fit, prospects })
    }
}

/// Adds the results of the fit.
pub(super) fn added_to(section: Section, fitted: &Fitted, pv_unit: Option<&str>) -> Section {
    let Fitted { fit, prospects } = fitted;
    let both = fit.cycle.known().and_then(|c| c.recorded.as_ref().zip(c.predicted.as_ref()));
    let caption = "The loop, identified from the recording, with 90 % intervals. S and J are the values with which \
        this process explains the PV. The values at the top are estimated without a process model.";
    let table = Table::new(caption).words("part").words("identified");
    let table = parts(fit, pv_unit)
        .into_iter()
        .fold(table, |table, part| table.row([part.name, part.value]));
    let section = section
        .heading("Does the valve explain the swing?")
        .paragraph(explained(fit))
        .with_all(both.map(|(recorded, predicted)| figure(recorded, predicted)))
        .with(table);
    match prospects {
        Ok(found) => section.with_all(effects(found)),
        Err(why) => section.paragraph(format!(
            "The effects of actions are unknown: {why}. The verdict does not rest on this \
             fit."
        )),
    }
}

/// A value with its 90 % interval.
fn interval(of: &Estimate, unit: &str) -> String {
    let [value, low, high] = [of.value, of.low, of.high].map(|v| set(v).replace('-', "\u{2212}"));
    format!("{value} {unit} ({low} to {high})")
}

fn not(why: Option<&str>) -> String {
    format!("not identified: {}", why.unwrap_or("reason unknown"))
}

/// Whether the valve explains the swing, or why this is unknown.
pub fn explained(fit: &Fit) -> String {
    fit.cycle.known().map_or_else(|| not(fit.cycle.why_not()), |cycle| cycle.sentence.clone())
}

/// Controller, valve and process with their intervals, or why they are not identified.
pub fn parts(fit: &Fit, pv_unit: Option<&str>) -> Vec<Fact> {
    let unit = pv_unit.unwrap_or("PV");
    vec![
        Fact::new("controller", controller(fit, unit), ""),
        Fact::new("valve", valve(fit), ""),
        Fact::new("process", process(fit, unit), ""),
    ]
}

fn controller(fit: &Fit, unit: &str) -> String {
    let Some(c) = fit.controller.known() else { return not(fit.controller.why_not()) };
    let mut words = format!("{}, Kc {}", c.structure.name(), interval(&c.kc, &format!("%/{unit}")));
    for (name, time) in [("Ti", &c.ti_s), ("Td", &c.td_s)] {
        words += &time.as_ref().map_or(String::new(), |t| format!(", {name} {}", interval(t, "s")));
    }
    words += &match c.execution_s {
        Some(every) => format!("; executes every {} s", number(every)),
        None => "; the execution interval cannot be determined".to_owned(),
    };
    if let Some(sp) = &c.set_point {
        words += &format!("; SP not recorded, assumed constant at {}", interval(sp, unit));
    }
    if c.gap > 0.0 {
        words += &format!("; gap of ±{} {unit}", number(c.gap));
    }
    let limits: Vec<String> = [c.low, c.high].iter().flatten().map(|v| number(*v)).collect();
    if !limits.is_empty() {
        words += &format!("; saturates at {} %", limits.join(" and "));
    }
    // Rounded down, because 1 would claim too much.
    let r2 = (c.explained * 1e5).floor() / 1e5;
    words + &format!("; fits the OP increments with R² = {r2}")
}

fn valve(fit: &Fit) -> String {
    let Some(valve) = fit.valve.known() else { return not(fit.valve.why_not()) };
    let s = interval(&valve.s, "%");
    if valve.follows > 0.5 {
        return format!(
            "probably follows its OP ({:.0} % of the fitted loops); if it sticks, S {s}",
            100.0 * valve.follows
        );
    }
    let model = valve.model.as_deref().unwrap_or("as measured");
    format!("{model}, S {s}, J {}, by {}", interval(&valve.j, "%"), valve.from)
}

fn process(fit: &Fit, unit: &str) -> String {
    let Some(p) = fit.process.known() else { return not(fit.process.why_not()) };
    let gain = p.gain.as_ref().map(|gain| format!("gain {}", interval(gain, &format!("{unit}/%"))));
    let lag = p.lag_s.as_ref().map(|lag| format!("time constant {}", interval(lag, "s")));
    let slope = || format!("initial slope {}", interval(&p.slope, &format!("{unit}/s per %")));
    let slope = (gain.is_none() && lag.is_none()).then(slope);
    let dead_time = format!("dead time {}", interval(&p.dead_time_s, "s"));
    let mut words = vec![p.kind.name().to_owned()];
    words.extend([gain, lag, slope, Some(dead_time)].into_iter().flatten());
    let jointly = p.jointly.as_ref().map_or(String::new(), |jointly| format!("; {jointly}"));
    words.join(", ") + &jointly
}

/// The effects of actions, and the recommended action.
pub fn effects(found: &Prospects) -> Vec<Block> {
    let caption = format!("{} loops agree with the recording.", found.loops);
    let table = Table::new(caption).columns(
        "action | #error, × present | #PV swing, × present | #PV swing, ± | #error | #valve travel [%/h] | #settling [s] | benefit",
    );
    let range = |of: &Estimate| format!("{} to {}", rough(of.low), rough(of.high));
    let table = found.actions.iter().fold(table, |table, row| {
        table.row([
            row.action.name().to_owned(),
            Prospect::range(&row.error_ratio, &row.error_ratio),
            Prospect::range(&row.pv_swing_ratio, &row.pv_swing_ratio),
            Prospect::range(&row.pv_swing, &row.pv_swing_ratio),
            Prospect::range(&row.error, &row.error_ratio),
            range(&row.travel),
            row.settling_s.as_ref().map_or("–".to_owned(), range),
            row.benefit().to_owned(),
        ])
    });
    let heading = |text: &str| Block::Heading(text.to_owned());
    let mut blocks =
        vec![heading("Effects of actions"), table.into(), Block::Paragraph(LEGEND.to_owned())];
    if !found.advice.is_empty() {
        let items = found.advice.clone();
        blocks.extend([heading("Actions"), Block::List { ordered: false, items }]);
    }
    blocks
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
             slip sooner than without noise and loads.",
        )
        .with(panel)
        .width(WIDTH)
}
