//! The figures of a valve test: the PV change with each turn of the OP, and the stem on a ramp.

use stiction_diagnose::recording::{Grid, GridOptions, Recording, Segment};
use stiction_diagnose::series::{max, min};
use stiction_diagnose::valve_test::{Place, Signature, Step, TestReading};
use stiction_figure::{Annotation, Figure, Panel, Series};

const CAPTION: &str = "A sticking valve does not answer turns smaller than S.";
const BRANCHES: &str = "The sum of the answers over the OP. A sticking valve separates the rising and falling branches.";

/// Answers over turns. `unit` is the unit of the PV.
pub fn figure(name: &str, unit: Option<&str>, test: &TestReading) -> Figure {
    Figure::new(format!("{name}: turns of the OP and answers of the {}", test.who()))
        .caption(if is_staircase(test) { BRANCHES } else { CAPTION })
        .with(panel(unit, test))
}

/// Whether most turns go on in the direction of the last one, so that their sizes show nothing.
fn is_staircase(test: &TestReading) -> bool {
    let turns = || test.steps.windows(3).map(|of| [of[1].op - of[0].op, of[2].op - of[1].op]);
    2 * turns().filter(|[last, this]| last * this > 0.0).count() > turns().count()
}

/// The sum of the answers over the OP, rising and falling.
fn branches(unit: Option<&str>, test: &TestReading) -> Panel {
    let answers = format!("sum of the answers of the {} ({})", test.who(), test.unit(unit));
    let mut panel = Panel::new("OP (%)", answers);
    let mut sides: [(Vec<f64>, Vec<f64>); 2] = Default::default();
    let mut sum = 0.0;
    for two in test.steps.windows(2) {
        sum += two[1].answer.unwrap_or(0.0);
        let (x, y) = &mut sides[usize::from(two[1].op < two[0].op)];
        x.push(two[1].op);
        y.push(sum);
    }
    for ((x, y), label) in sides.into_iter().zip(["rising", "falling"]) {
        if !x.is_empty() {
            panel = panel.with(Series::points(label, x, y));
        }
    }
    panel
}

/// The tests before and after a repair, above each other with the same axes. Each has a title; `unit` is the unit of
/// the PV.
pub fn before_and_after(tests: [(&str, &TestReading); 2], unit: Option<&str>) -> Figure {
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
    let stairs = tests.iter().all(|(_, test)| is_staircase(test));
    let caption = if stairs { BRANCHES } else { CAPTION };
    let figure = Figure::new("").caption(format!("Both tests with the same axes. {caption}"));
    panels.into_iter().fold(figure, Figure::with)
}

/// OP less stem position, rising and falling, and S along the stroke.
pub fn signature(name: &str, of: &Ramped<'_>) -> Figure {
    let caption =
        "The curves of rising and falling ramps are S \u{2212} J apart, and J shows in the jumps.";
    let places = places(&[("S", of.signature)]);
    let figure = Figure::new(format!("{name}: signature of the valve"))
        .caption(with_bars(caption, &places))
        .with(of.loops());
    places.into_iter().fold(figure, Figure::with)
}

/// A caption that explains the bars, if a panel has any.
fn with_bars(caption: &str, places: &Option<Panel>) -> String {
    let bars = if places.is_some() { " The bars are 90 % intervals." } else { "" };
    format!("{caption}{bars}")
}

/// The signatures before and after a repair.
pub fn signatures(tests: [(&str, &Ramped<'_>); 2]) -> Figure {
    let places = places(&tests.map(|(title, of)| (title, of.signature)));
    let caption = match &places {
        Some(_) => "OP less stem position before and after, and S along the stroke.",
        None => "OP less stem position before and after.",
    };
    let figure = Figure::new("").caption(with_bars(caption, &places));
    let figure = tests.iter().fold(figure, |figure, (title, of)| {
        figure.with(Panel { title: (*title).to_owned(), ..of.loops() })
    });
    places.into_iter().fold(figure, Figure::with)
}

/// A signature with the recorded OP and VP of its ramps.
#[derive(Debug, Clone)]
pub struct Ramped<'a> {
    signature: &'a Signature,
    op: Vec<f64>,
    vp: Vec<f64>,
}

/// Largest number of points of a signature that are drawn.
const POINTS: usize = 1500;

impl<'a> Ramped<'a> {
    /// Of a recording with this signature.
    pub fn of(recording: &Recording, signature: &'a Signature) -> Self {
        let whole = Recording { mode: None, ..recording.clone() };
        let grid = Grid::of(&whole, &GridOptions::default()).ok();
        let segments = grid.map_or(vec![], |grid| grid.segments);
        let inside = |t: f64| (signature.from_s..=signature.to_s).contains(&t);
        let position = |segment: &Segment| match &signature.characteristic {
            None => segment.vp.clone().unwrap_or_default(),
            Some(of) => segment.pv.iter().flatten().map(|pv| of.position(*pv)).collect(),
        };
        let samples = segments.iter().flat_map(|segment| {
            let both = segment.op.iter().copied().zip(position(segment));
            segment.times().into_iter().zip(both).filter(|(t, _)| inside(*t)).map(|(_, of)| of)
        });
        let (op, vp): (Vec<f64>, Vec<f64>) = samples.unzip();
        let every = op.len().div_ceil(POINTS).max(1);
        let some = |x: Vec<f64>| x.into_iter().step_by(every).collect();
        Self { signature, op: some(op), vp: some(vp) }
    }

    /// OP minus position over the position, by the direction of the ramp.
    fn loops(&self) -> Panel {
        let mut panel = match self.signature.characteristic {
            None => Panel::new("valve position (%)", "OP \u{2212} valve position (%)"),
            Some(_) => Panel::new("PV as a position (%)", "OP \u{2212} PV as a position (%)"),
        };
        let mut up = true;
        let mut sides: [(Vec<f64>, Vec<f64>, Vec<usize>); 2] = Default::default();
        let mut last = None;
        for (k, (op, vp)) in self.op.iter().zip(&self.vp).enumerate() {
            let before = self.op[k.saturating_sub(1)];
            up = if *op == before { up } else { *op > before };
            let (x, y, breaks) = &mut sides[usize::from(!up)];
            if last.is_some_and(|last| last != up) {
                breaks.push(x.len());
            }
            last = Some(up);
            x.push(*vp);
            y.push(op - vp);
        }
        for ((x, y, breaks), label) in sides.into_iter().zip(["rising", "falling"]) {
            if !x.is_empty() {
                let breaks: Vec<usize> = breaks.into_iter().filter(|at| *at > 0).collect();
                panel = panel.with(Series::line(label, x, y).breaks(breaks));
            }
        }
        panel
    }
}

/// S along the stroke; `None` if no signature has it.
fn places(tests: &[(&str, &Signature)]) -> Option<Panel> {
    let mut panel = Panel::new("valve position (%)", "S (%)");
    for (colour, (label, of)) in tests.iter().enumerate() {
        let middle = |place: &Place| 0.5 * (place.from + place.to);
        let points = of.places.iter().map(|place| (middle(place), place.s.value));
        let (x, y): (Vec<f64>, Vec<f64>) = points.unzip();
        let bars = of
            .places
            .iter()
            .flat_map(|place| [(middle(place), place.s.low), (middle(place), place.s.high)]);
        let (bar_x, bar_y): (Vec<f64>, Vec<f64>) = bars.unzip();
        if bar_x.is_empty() {
            continue;
        }
        let breaks: Vec<usize> = (2..bar_x.len()).step_by(2).collect();
        let interval = Series::line("90 % interval", bar_x, bar_y).breaks(breaks).colour(3);
        panel = panel.with(interval).with(Series::points(*label, x, y).colour(colour));
    }
    tests.iter().any(|(_, of)| !of.places.is_empty()).then_some(panel)
}

fn panel(unit: Option<&str>, test: &TestReading) -> Panel {
    if is_staircase(test) {
        return branches(unit, test);
    }
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
