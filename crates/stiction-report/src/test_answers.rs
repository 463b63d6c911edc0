//! The figure of a valve test: the PV change with each turn of the OP.

use stiction_diagnose::series::{max, min};
use stiction_diagnose::valve_test::{Step, TestReading};
use stiction_figure::{Annotation, Figure, Panel, Series};

const CAPTION: &str = "A sticking valve does not answer turns smaller than S.";

/// Answers over turns. `unit` is the unit of the PV.
pub fn figure(name: &str, unit: Option<&str>, test: &TestReading) -> Figure {
    Figure::new(format!("{name}: turns of the OP and answers of the {}", test.who()))
        .caption(CAPTION)
        .with(panel(unit, test))
}

/// The tests before and after a repair, one above the other with the same axes. Each has a title; `unit` is the unit of
/// the PV.
pub fn beside(tests: [(&str, &TestReading); 2], unit: Option<&str>) -> Figure {
    let mut panels =
        tests.map(|(title, test)| Panel { title: title.to_owned(), ..panel(unit, test) });
    let ends = |of: fn(&Series) -> &Vec<f64>| {
        let all = panels.iter().flat_map(|panel| &panel.series).flat_map(of);
        let all: Vec<f64> = all.copied().filter(|v| v.is_finite()).collect();
        let (low, high) = (min(&all), max(&all));
        (high > low).then_some((low - 0.05 * (high - low), high + 0.05 * (high - low)))
    };
    let (x_range, y_range) = (ends(|series| &series.x), ends(|series| &series.y));
    for panel in &mut panels {
        (panel.x_range, panel.y_range) = (x_range, y_range);
    }
    let figure = Figure::new("").caption(format!("Both tests with the same axes. {CAPTION}"));
    panels.into_iter().fold(figure, Figure::with)
}

fn panel(unit: Option<&str>, test: &TestReading) -> Panel {
    let answer = format!("answer of the {} ({})", test.who(), test.unit(unit));
    let mut panel = Panel::new("turn of the OP (%)", answer);
    let of = |wanted: bool| -> (Vec<f64>, Vec<f64>) {
        let seen = |step: &&Step| step.answered == wanted;
        let points = test.steps.iter().filter(seen);
        points.filter_map(|step| Some((step.travel?, step.answer?.abs()))).unzip()
    };
    // A line from two standard deviations below each answer to two above.
    let bars = test.steps.iter().filter_map(|step| {
        let (travel, answer, error) = (step.travel?, step.answer?.abs(), step.error?);
        Some([(travel, answer - 2.0 * error), (travel, answer + 2.0 * error)])
    });
    let (x, y): (Vec<f64>, Vec<f64>) = bars.flatten().unzip();
    if !x.is_empty() {
        let breaks: Vec<usize> = (2..x.len()).step_by(2).collect();
        panel = panel.with(Series::line("2 standard deviations", x, y).breaks(breaks).colour(3));
    }
    for (wanted, label, colour) in [(true, "answered", 0), (false, "not answered", 1)] {
        let (x, y) = of(wanted);
        if !x.is_empty() {
            panel = panel.with(Series::points(label, x, y).colour(colour));
        }
    }
    if let Some(s) = test.s {
        panel = panel.note(Annotation::x_band(s.low, s.high, "S"));
    } else if let Some(limit) = test.s_below {
        panel = panel.note(Annotation::vertical_line(limit, "S is below"));
    }
    panel
}
