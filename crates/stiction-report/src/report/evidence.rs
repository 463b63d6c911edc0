//! What each method says, with a figure of what it says it by.
//!
//! One file a family of methods, by what their figures show. A method with a figure here is called
//! by its name in the registry; the figure is made from its typed result.

mod correlation;
mod distributions;
mod models;
mod nonlinearity;
mod phase;
mod shapes;
mod windows;

use super::layout::{Card, Fact, number};
use super::time_axis::TimeAxis;
use super::views::{self, Context};
use std::ops::Range;
use stiction_diagnose::detect::{Decision, Finding, FittedBy, SteadinessTest, Subject};
use stiction_figure::figure::{Figure, Panel, Series};

/// What a method says of a loop, with its figure and its numbers; of one that abstains, why.
pub fn card(finding: &Finding, subject: Option<&Subject<'_>>, context: &Context<'_>) -> Card {
    let mut card =
        Card::new(finding.method.title, sentence(&finding.reason)).badge(finding.decision);
    card.caveats = finding.caveats.iter().map(|caveat| sentence(caveat)).collect();
    if finding.decision != Decision::Abstains {
        card.figure = subject.and_then(|subject| figure(finding.method.name, subject, context));
    }
    let numbers = finding.numbers.iter();
    card.facts.extend(numbers.map(|each| Fact::new(each.name, number(each.value), each.unit)));
    card
}

/// The figure of the evidence of the method of that name; `None` if it abstains, has seen too little
/// to draw or values beyond what can be drawn, or is not known.
pub fn figure(method: &str, subject: &Subject<'_>, context: &Context<'_>) -> Option<Figure> {
    let scene = Scene { subject, context };
    let figure = match method {
        "direct" => phase::direct(&scene),
        "yamashita-vp" => windows::patterns(&scene, stiction_diagnose::detect::Follower::Vp),
        "horch" => correlation::horch(&scene),
        "horch-density" => distributions::horch_density(&scene),
        "area-ratio" => shapes::area_ratio(&scene),
        "curve-fit" => shapes::curve_fit(&scene),
        "relay-fit" => shapes::relay_fit(&scene),
        "square-wave" => shapes::square_wave(&scene),
        "yamashita" => windows::patterns(&scene, stiction_diagnose::detect::Follower::Pv),
        "yamashita-level" => distributions::yamashita_level(&scene),
        "kano" => phase::kano(&scene),
        "sharp-corner" => phase::sharp_corner(&scene),
        "butterfly" => phase::butterfly(&scene),
        "damarla-regression" => windows::regression(&scene),
        "damarla-f-test" => windows::steadiness(&scene, SteadinessTest::FTest),
        "damarla-t-test" => windows::steadiness(&scene, SteadinessTest::TTest),
        "damarla-hotelling" => windows::steadiness(&scene, SteadinessTest::Hotelling),
        "damarla-reverse-arrangements" => {
            windows::steadiness(&scene, SteadinessTest::ReverseArrangements)
        }
        "damarla-sigmoid" => phase::sigmoid(&scene),
        "srinivasan" => models::fit(&scene, FittedBy::Srinivasan),
        "lee" => models::fit(&scene, FittedBy::Lee),
        "jelali" => models::fit(&scene, FittedBy::Jelali),
        "karra-karim" => models::fit(&scene, FittedBy::KarraKarim),
        "bicoherence" => nonlinearity::bicoherence(&scene),
        "bicoherence-op" => nonlinearity::bicoherence_op(&scene),
        "surrogates" => nonlinearity::surrogates(&scene),
        _ => None,
    };
    figure.filter(|figure| figure.check().is_ok())
}

/// A sentence of its own: with a capital and a full stop.
pub(crate) fn sentence(clause: &str) -> String {
    let mut chars = clause.chars();
    let first = chars.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    let stop = if clause.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{first}{}{stop}", chars.as_str())
}

/// What a figure is made from.
struct Scene<'a> {
    subject: &'a Subject<'a>,
    context: &'a Context<'a>,
}

impl Scene<'_> {
    fn op(&self) -> &[f64] {
        &self.subject.stretch.op
    }

    /// The PV; empty if it is not recorded.
    fn pv(&self) -> &[f64] {
        self.subject.stretch.pv.as_deref().unwrap_or_default()
    }

    fn unit(&self) -> &str {
        self.context.pv_unit.unwrap_or("units of the PV")
    }

    fn time(&self) -> TimeAxis {
        let stretch = self.subject.stretch;
        TimeAxis::of_times(self.context.start, stretch.from + stretch.duration())
    }

    /// Times of some places, in samples, as they stand along [`Scene::time`].
    fn times(&self, places: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let (axis, stretch) = (self.time(), self.subject.stretch);
        let at = |k: f64| axis.at(stretch.from + k * stretch.sample_time);
        places.into_iter().map(at).collect()
    }

    /// The last few periods of the stretch.
    fn end(&self) -> Range<usize> {
        let stretch = self.subject.stretch;
        views::last_periods(stretch, self.context)..stretch.len()
    }

    /// A panel along time that zooms with the others of its figure.
    fn trend(&self, y_label: impl Into<String>, group: &str) -> Panel {
        let axis = self.time();
        Panel::new(axis.label, y_label).x_scale(axis.scale).group(group).height(130.0)
    }

    /// Samples of a signal over time, each held until the next if `held`.
    fn samples(&self, name: &str, values: &[f64], range: Range<usize>, held: bool) -> Series {
        let y = values.get(range.clone()).unwrap_or_default();
        let x = self.times(range.map(|k| k as f64));
        if held { Series::steps(name, x, y) } else { Series::line(name, x, y) }
    }
}

/// At most `most` of some samples, evenly spaced, and how many one stands for.
fn thinned(values: &[f64], most: usize) -> (Vec<f64>, usize) {
    let stride = values.len().div_ceil(most).max(1);
    (values.iter().copied().step_by(stride).collect(), stride)
}

/// An upright line up to a height, with its name in the legend: there names cannot cover each other.
fn line_at(series: fn(&str, Vec<f64>, Vec<f64>) -> Series, name: &str, x: f64, top: f64) -> Series {
    series(name, vec![x; 2], vec![0.0, top])
}

fn solid(name: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series::line(name, x, y)
}

fn dashed(name: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series::dashed(name, x, y)
}

fn dotted(name: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series::dotted(name, x, y)
}

/// A sheet as wide as the page, with a caption.
fn sheet(caption: impl Into<String>) -> Figure {
    Figure::new("").caption(caption).width(views::WIDTH).panel_height(200.0)
}
