//! Steps and windows in which the OP moves and the PV does not.

use super::{Scene, sheet};
use crate::report::layout::number;
use std::ops::Range;
use stiction_diagnose::detect::{
    DamarlaRegressionResult, DamarlaTestResult, Follower, SteadinessTest, YamashitaResult,
};
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Scale, Series, colour};

/// Windows shown at most.
const SHOWN: usize = 100;

/// Patterns by their symbols: of the OP, then of what follows the valve.
const PATTERNS: [&str; 9] = ["DD", "DS", "DI", "SD", "SS", "SI", "ID", "IS", "II"];

pub fn patterns(scene: &Scene<'_>, found: &YamashitaResult) -> Option<Figure> {
    let (name, label, values) = match found.follower {
        Follower::Vp => ("VP", "VP (% of span)".to_owned(), scene.subject.segment.vp.as_deref()?),
        Follower::Pv => ("PV", scene.context.pv_label("PV"), scene.pv()),
    };
    // The symbol at k is of the step from sample k to the next.
    let range = scene.end();
    let sticky: Vec<usize> = range
        .clone()
        .filter(|k| {
            let symbols = (k
                .checked_sub(1)
                .map(|step| (found.op_symbols.get(step), found.follower_symbols.get(step))))
            .unwrap_or_default();
            matches!(symbols, (Some(-1 | 1), Some(0)))
        })
        .collect();
    let panel = |label: &str, name: &str, values: &[f64], held: bool, colour: usize| {
        let mut panel = scene
            .trend(label)
            .with(scene.samples(name, values, range.clone(), held).colour(colour));
        if !sticky.is_empty() {
            let y: Vec<f64> = sticky.iter().map(|k| values[*k]).collect();
            let points = Series::points(
                "OP moves, the other rests",
                scene.times(sticky.iter().map(|k| *k as f64)),
                y,
            );
            panel = panel.with(points.colour(colour::VERMILION));
        }
        panel.legend(Legend::Above)
    };
    let all: usize = found.patterns.iter().flatten().sum();
    let shares: Vec<f64> = found
        .patterns
        .iter()
        .flatten()
        .map(|count| 100.0 * *count as f64 / all.max(1) as f64)
        .collect();
    let places: Vec<f64> = (0..PATTERNS.len()).map(|i| i as f64).collect();
    // Those that speak for stiction apart from the others.
    let is_sticky = |i: &usize| matches!(PATTERNS[*i], "DS" | "IS");
    let bars = |name: &str, sticky: bool| {
        let y: Vec<f64> = (0..PATTERNS.len())
            .map(|i| if is_sticky(&i) == sticky { shares[i] } else { 0.0 })
            .collect();
        Series::bars(name, &places[..], y)
    };
    let bars = Panel::new(
        format!("pattern: step of the OP, then of the {name}"),
        "share of the steps (%)",
    )
    .x_scale(Scale::Names(&PATTERNS))
    .legend(Legend::Above)
    .height(130.0)
    .with(bars("OP moves, the other rests", true).colour(colour::VERMILION))
    .with(bars("other patterns", false).colour(colour::SKY));
    let dead_zone = match found.dead_zone {
        0.5 => "half a standard deviation".to_owned(),
        other => format!("{} standard deviations", number(other)),
    };
    let caption = format!(
        "Steps that increase (I), stay (S) or decrease (D), against {dead_zone} of all steps. \
         Above: the end of the segment, with the steps in which the OP moves and the {name} stays; below: \
         how often each pattern is. rho1, the share of these two among all steps that are not SS, is {}.",
        number(found.statistic)
    );
    let figure = sheet(caption)
        .with(panel("OP (% of span)", "OP", scene.op(), true, colour::BLUE))
        .with(panel(&label, name, values, false, colour::GREEN))
        .with(bars);
    (values.len() >= range.end && !range.is_empty()).then_some(figure)
}

pub fn regression(scene: &Scene<'_>, found: &DamarlaRegressionResult) -> Option<Figure> {
    let lead = format!(
        "Windows of {} samples; shaded where the OP's slope is at least {} times the PV's, both in their \
         standard deviations",
        found.window,
        number(found.eta)
    );
    marked(scene, &lead, &found.sticky, found.window)
}

pub fn steadiness(scene: &Scene<'_>, found: &DamarlaTestResult) -> Option<Figure> {
    let what = match found.test {
        SteadinessTest::FTest => "variance",
        SteadinessTest::TTest | SteadinessTest::Hotelling => "mean",
        SteadinessTest::ReverseArrangements => "level",
    };
    let lead = format!(
        "Windows of {} samples; shaded where the PV keeps its {what} and the OP does not",
        found.window
    );
    marked(scene, &lead, &found.marked, found.window)
}

/// OP and PV where most windows are marked.
fn marked(scene: &Scene<'_>, lead: &str, marked: &[bool], window: usize) -> Option<Figure> {
    let periods = scene.end().len();
    let shown = (periods / window.max(1)).clamp(20, SHOWN).min(marked.len());
    let windows = busiest(marked, shown);
    let range = windows.start * window..(windows.end * window).min(scene.op().len());
    if range.is_empty() || scene.pv().len() < range.end {
        return None;
    }
    let mut panels = [
        scene
            .trend("OP (% of span)")
            .with(scene.samples("OP", scene.op(), range.clone(), true).colour(colour::BLUE)),
        scene
            .trend(scene.context.pv_label("PV"))
            .with(scene.samples("PV", scene.pv(), range.clone(), false).colour(colour::GREEN)),
    ];
    for run in runs(marked, &windows) {
        let ends = [run.start * window, (run.end * window - 1).min(range.end - 1)];
        let ends = scene.times(ends.map(|k| k as f64));
        panels = panels.map(|panel| panel.note(Annotation::x_band(ends[0], ends[1], "")));
    }
    let count = marked.iter().filter(|m| **m).count();
    let caption = format!(
        "{lead}: {count} of {} windows. Shown are those {shown} windows in a row that hold most of them.",
        marked.len()
    );
    let [op, pv] = panels;
    Some(sheet(caption).with(op).with(pv))
}

/// The first so many neighbours among which most are marked.
fn busiest(marked: &[bool], length: usize) -> Range<usize> {
    let length = length.min(marked.len());
    let mut now = marked[..length].iter().filter(|m| **m).count();
    let (mut best, mut first) = (now, 0);
    for end in length..marked.len() {
        now = now + usize::from(marked[end]) - usize::from(marked[end - length]);
        if now > best {
            (best, first) = (now, end + 1 - length);
        }
    }
    first..first + length
}

/// Runs of marked neighbours in a range.
fn runs(marked: &[bool], range: &Range<usize>) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = vec![];
    for i in range.clone().filter(|i| marked[*i]) {
        match runs.last_mut() {
            Some(last) if last.end == i => last.end = i + 1,
            _ => runs.push(i..i + 1),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_marks_in_a_row() {
        let marked = [false, true, false, true, true, false, true, false];
        assert_eq!(busiest(&marked, 4), 1..5);
        assert_eq!(busiest(&marked, 2), 3..5);
        assert_eq!(busiest(&marked, 99), 0..8);
        assert_eq!(busiest(&[], 3), 0..0);
        assert_eq!(runs(&marked, &(1..7)), [1..2, 3..5, 6..7]);
    }
}
