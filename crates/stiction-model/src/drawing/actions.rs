//! A chart of the actions against a sticking valve.

use crate::compensate::Row;
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Scale, Series, colour};

/// Smallest stem travel in the drawing, relative to the present loop. Smaller values are drawn at the edge.
const LEAST_TRAVEL: f64 = 0.01;

/// Approximate width of a letter, relative to the largest error.
const LETTER: f64 = 0.022;

/// The control error and the stem travel of the `present` loop and of each action, by name and in ranked order, the
/// best on top.
pub fn actions(title: &str, present: &Row, rows: &[(&'static str, &Row)]) -> Figure {
    let now = present.nominal().measures;
    let (mut at, mut nominal, mut worst, mut travel) = (vec![], vec![], vec![], vec![]);
    let mut names = vec![];
    for (rank, (name, row)) in rows.iter().enumerate() {
        let most = row.worst(|outcome| outcome.measures.iae_per_s);
        let measures = row.nominal().measures;
        if !most.is_finite() {
            continue;
        }
        at.push((rows.len() - rank) as f64);
        nominal.push(measures.iae_per_s);
        worst.push(most);
        travel.push(measures.vp_travel_per_s);
        names.push(format!("{} {name}", rank + 1));
    }
    let widest = worst.iter().copied().fold(1e-9, f64::max);
    let rows_high = (0.3, rows.len() as f64 + 0.7);
    let height = 26.0 * rows.len() as f64;
    let span = |ends: &[(f64, f64)]| -> (Vec<f64>, Vec<f64>, Vec<usize>) {
        let x = ends.iter().flat_map(|(from, to)| [*from, *to]).collect();
        let y = at.iter().flat_map(|at| [*at, *at]).collect();
        (x, y, (2..2 * ends.len()).step_by(2).collect())
    };
    let pairs: Vec<(f64, f64)> = nominal.iter().copied().zip(worst.iter().copied()).collect();
    let (x, y, breaks) = span(&pairs);
    let mut errors = Panel::new("mean control error (PV units)", "")
        .x_range(-0.03 * widest, 1.6 * widest)
        .y_range(rows_high.0, rows_high.1)
        .y_scale(Scale::Names(&[]))
        .legend(Legend::Above)
        .height(height)
        .with(Series::line("", x, y).colour(colour::BLACK).breaks(breaks))
        .with(
            Series::points("worst case of wrong S and J", &worst[..], &at[..])
                .colour(colour::VERMILION),
        )
        // Drawn above the other series, which it covers if both are equal.
        .with(Series::points("S and J right", nominal, &at[..]).colour(colour::BLUE))
        .note(Annotation::vertical_line(now.iae_per_s, ""));
    for ((name, place), most) in names.into_iter().zip(&at).zip(&worst) {
        // A text is centred on its point.
        let half = 0.5 * LETTER * name.chars().count() as f64 * widest;
        errors = errors.note(Annotation::text(name, (most + 0.04 * widest + half, *place)));
    }
    let unit = now.vp_travel_per_s;
    let times: Vec<f64> = travel
        .iter()
        .map(|travel| if unit > 0.0 { travel / unit } else { 60.0 * travel })
        .collect();
    let most = times.iter().copied().fold(1.0, f64::max);
    let ends: Vec<f64> = times.iter().map(|times| times.max(LEAST_TRAVEL)).collect();
    let bars: Vec<(f64, f64)> = ends.iter().map(|end| (1.0, *end)).collect();
    let (x, y, breaks) = span(&bars);
    let what = if unit > 0.0 { "stem travel, ratio to present" } else { "stem travel (% per min)" };
    let mut travels = Panel::new(what, "")
        .x_scale(Scale::Log)
        .x_range(0.6 * LEAST_TRAVEL, 10.0 * most)
        .y_range(rows_high.0, rows_high.1)
        .y_scale(Scale::Names(&[]))
        .legend(Legend::Hidden)
        .height(height)
        .with(Series::line("", x, y).colour(colour::BLACK).breaks(breaks))
        .with(Series::points("stem travel", ends.clone(), &at[..]).colour(colour::GREEN));
    for (times, at) in times.iter().zip(at) {
        let text = match *times {
            times if times < LEAST_TRAVEL => "0".to_owned(),
            times if times < 0.95 => format!("{times:.2}"),
            times if times < 9.95 => format!("{times:.1}"),
            times => format!("{times:.0}"),
        };
        travels = travels.note(Annotation::text(text, (4.0 * most, at)));
    }
    let caption = format!(
        "Left: mean control error of each action with S and J right and in the worst case of wrong S and J, the best \
         action on top. The line marks the present loop. Right: stem travel with S and J right. Values below \
         {LEAST_TRAVEL} are drawn at the edge."
    );
    Figure::new(title).caption(caption).with(errors).with(travels).columns(2).width(1000.0)
}
