//! What could be done about a sticking valve, as a chart.

use crate::figure::{Annotation, Figure, Legend, Panel, Scale, Series, colour};
use std::sync::LazyLock;
use stiction_model::compensate::{Method, Row};

/// Travel beyond this multiple of the present one is drawn at the edge; the number beside it is the true one.
const MOST_TRAVEL: f64 = 5.0;

/// The compensators in the order in which they are drawn, from below, and the loop as it is.
static COMPENSATORS: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let methods = Method::ALL.iter().rev().map(|method| method.describe().name);
    methods.chain(["as it is"]).collect()
});

/// The same with what else could be done.
static ACTIONS: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let mut names = COMPENSATORS.clone();
    let last = names.len() - 1;
    names.splice(last..last, ["positioner", "retuned", "valve repaired"]);
    names
});

/// The control error and the stem's travel of the loop as it is, `present`, and of what could be done, by name and in
/// the order of their rank; the rank stands beside each.
///
/// Names that are neither those of an action nor of a compensator are left out.
pub fn actions(title: &str, present: &Row, rows: &[(&'static str, &Row)]) -> Figure {
    let now = present.nominal().measures;
    let all = |names: &[&str]| rows.iter().all(|(name, _)| names.contains(name));
    let names: &'static [&'static str] =
        if all(&COMPENSATORS) { COMPENSATORS.as_slice() } else { ACTIONS.as_slice() };
    let (mut at, mut nominal, mut worst, mut travel) = (vec![], vec![], vec![], vec![]);
    let mut marks = vec![];
    for (rank, (name, row)) in rows.iter().enumerate() {
        let Some(place) = names.iter().position(|known| known == name) else { continue };
        let most = row.worst(|outcome| outcome.measures.iae_per_s);
        let measures = row.nominal().measures;
        if !most.is_finite() {
            continue;
        }
        at.push(place as f64);
        nominal.push(measures.iae_per_s);
        worst.push(most);
        travel.push(measures.vp_travel_per_s);
        marks.push((rank + 1, place as f64, most));
    }
    let widest = worst.iter().copied().fold(1e-9, f64::max);
    let rows_high = (-0.7, names.len() as f64 - 0.3);
    let height = 26.0 * names.len() as f64;
    let span = |ends: &[(f64, f64)]| -> (Vec<f64>, Vec<f64>, Vec<usize>) {
        let x = ends.iter().flat_map(|(from, to)| [*from, *to]).collect();
        let y = at.iter().flat_map(|at| [*at, *at]).collect();
        (x, y, (2..2 * ends.len()).step_by(2).collect())
    };
    let pairs: Vec<(f64, f64)> = nominal.iter().copied().zip(worst.iter().copied()).collect();
    let (x, y, breaks) = span(&pairs);
    let mut errors = Panel::new("mean control error (PV units), with its rank", "")
        .x_range(-0.03 * widest, 1.12 * widest)
        .y_range(rows_high.0, rows_high.1)
        .y_scale(Scale::Names(names))
        .legend(Legend::Above)
        .height(height)
        .with(Series::line("", x, y).colour(colour::BLACK).breaks(breaks))
        .with(Series::points("S and J right", nominal, &at[..]).colour(colour::BLUE))
        .with(
            Series::points("worst case of S and J wrong", worst, &at[..]).colour(colour::VERMILION),
        )
        .note(Annotation::vertical_line(now.iae_per_s, ""));
    for (rank, place, most) in marks {
        let text = Annotation::text(rank.to_string(), (most + 0.05 * widest, place));
        errors = errors.note(text);
    }
    let unit = now.vp_travel_per_s;
    let times: Vec<f64> = travel
        .iter()
        .map(|travel| if unit > 0.0 { travel / unit } else { 60.0 * travel })
        .collect();
    let edge = if unit > 0.0 { MOST_TRAVEL } else { times.iter().copied().fold(1e-9, f64::max) };
    let bars: Vec<(f64, f64)> = times.iter().map(|times| (0.0, times.min(edge))).collect();
    let (x, y, breaks) = span(&bars);
    let ends: Vec<f64> = bars.iter().map(|bar| bar.1).collect();
    let what = if unit > 0.0 {
        "stem travel, times that of the loop as it is"
    } else {
        "stem travel (% per min)"
    };
    let mut travels = Panel::new(what, "")
        .x_range(-0.05 * edge, 1.25 * edge)
        .y_range(rows_high.0, rows_high.1)
        .y_scale(Scale::Names(&[]))
        .legend(Legend::Hidden)
        .height(height)
        .with(Series::line("", x, y).colour(colour::BLACK).breaks(breaks))
        .with(Series::points("stem travel", ends.clone(), &at[..]).colour(colour::GREEN));
    for ((times, end), at) in times.iter().zip(ends).zip(at) {
        let text = if *times < 9.95 { format!("{times:.1}") } else { format!("{times:.0}") };
        travels = travels.note(Annotation::text(text, (end + 0.12 * edge, at)));
    }
    let caption = format!(
        "Mean control error of each action with S and J right and in the worst case of them being wrong, its rank \
         beside it; the line is the loop as it is. Right, the travel of the stem with S and J right; beyond {MOST_TRAVEL} \
         the mark stands at the edge."
    );
    Figure::new(title).caption(caption).with(errors).with(travels).columns(2).width(1000.0)
}
