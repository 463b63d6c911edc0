//! Figure of the method: steps in which the OP moves and the other rests.

use super::{Follower, YamashitaResult};
use crate::drawing::{Scene, sheet};
use crate::spoken::number;
use stiction_figure::figure::{Figure, Legend, Panel, Scale, Series, colour};

/// Patterns by their symbols: first the OP, then the signal downstream of the valve.
const PATTERNS: [&str; 9] = ["DD", "DS", "DI", "SD", "SS", "SI", "ID", "IS", "II"];

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &YamashitaResult) -> Option<Figure> {
    let (name, label, values) = match found.follower {
        Follower::Vp => ("VP", "VP (% of span)".to_owned(), scene.segment.vp.as_deref()?),
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
    // The patterns of stiction apart from the others.
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
        "Steps that increase (I), stay (S) or decrease (D), with a dead zone of {dead_zone} of all steps. Above: \
         the end of the segment, with the steps in which the OP moves and the {name} stays. Below: how often each \
         pattern occurs. rho1, the share of DS and IS among all steps that are not SS, is {}.",
        number(found.statistic)
    );
    let figure = sheet(caption)
        .with(panel("OP (% of span)", "OP", scene.op(), true, colour::OP))
        .with(panel(&label, name, values, false, colour::PV))
        .with(bars);
    (values.len() >= range.end && !range.is_empty()).then_some(figure)
}
