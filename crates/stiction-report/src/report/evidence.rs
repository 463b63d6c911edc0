//! What each method says, with a figure of what it says it by.
//!
//! One file a family of methods, by what their figures show. A figure is made from what its method
//! [looked at](Finding::evidence).

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
use stiction_diagnose::detect::{Decision, Finding, LookedAt, Subject};
use stiction_figure::figure::{Figure, Panel, Series};

/// What a method says of a loop, with its figure and its numbers; of one that abstains, why.
pub fn card(finding: &Finding, subject: Option<&Subject<'_>>, context: &Context<'_>) -> Card {
    let mut card =
        Card::new(finding.method.title, sentence(&finding.reason)).badge(finding.decision);
    card.caveats = finding.caveats.iter().map(|caveat| sentence(caveat)).collect();
    if finding.decision != Decision::Abstains {
        card.figure = subject.and_then(|subject| figure(finding, subject, context));
    }
    let numbers = finding.numbers.iter();
    card.facts.extend(numbers.map(|each| Fact::new(each.name, number(each.value), each.unit)));
    card
}

/// The figure of what a method looked at; `None` if it abstains, has seen too little to draw or values beyond what can
/// be drawn.
pub fn figure(finding: &Finding, subject: &Subject<'_>, context: &Context<'_>) -> Option<Figure> {
    let looked_at = finding.evidence(subject)?;
    let group = finding.method.name;
    let scene = &Scene { subject, context, group };
    let figure = match &*looked_at {
        LookedAt::ValvePosition(found) => phase::direct(scene, found),
        LookedAt::Yamashita(found) => windows::patterns(scene, found),
        LookedAt::Horch(found) => correlation::horch(scene, found),
        LookedAt::HorchDensity(found) => distributions::horch_density(found),
        LookedAt::AreaRatio(found) => shapes::area_ratio(scene, found),
        LookedAt::CurveFit(found) => shapes::curve_fit(scene, found),
        LookedAt::RelayFit(found) => shapes::relay_fit(scene, found),
        LookedAt::SquareWave(found) => shapes::square_wave(scene, found),
        LookedAt::YamashitaLevel(found) => distributions::yamashita_level(found),
        LookedAt::Kano(found) => phase::kano(scene, found),
        LookedAt::SharpCorner(found) => phase::sharp_corner(scene, found),
        LookedAt::Butterfly(found) => phase::butterfly(found),
        LookedAt::DamarlaRegression(found) => windows::regression(scene, found),
        LookedAt::DamarlaTest(found) => windows::steadiness(scene, found),
        LookedAt::DamarlaSigmoid(found) => phase::sigmoid(found),
        LookedAt::ModelFit(found) => models::fit(scene, &found.fit),
        LookedAt::Bicoherence(found) => nonlinearity::bicoherence(scene, found),
        LookedAt::BicoherenceOp(found) => nonlinearity::bicoherence_op(scene, found),
        LookedAt::Surrogates(found) => nonlinearity::surrogates(found),
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
    /// The panels of a figure share their time axis; it is called like its method.
    group: &'static str,
}

impl Scene<'_> {
    fn op(&self) -> &[f64] {
        &self.subject.segment.op
    }

    /// The PV; empty if it is not recorded.
    fn pv(&self) -> &[f64] {
        self.subject.segment.pv.as_deref().unwrap_or_default()
    }

    fn unit(&self) -> &str {
        self.context.pv_unit.unwrap_or("units of the PV")
    }

    fn time(&self) -> TimeAxis {
        let segment = self.subject.segment;
        self.context.time_axis(segment.from + segment.duration())
    }

    /// Times of some places, in samples, as they stand along [`Scene::time`].
    fn times(&self, places: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let (axis, segment) = (self.time(), self.subject.segment);
        let at = |k: f64| axis.at(segment.from + k * segment.sample_time);
        places.into_iter().map(at).collect()
    }

    /// The last few periods of the segment.
    fn end(&self) -> Range<usize> {
        let segment = self.subject.segment;
        views::last_periods(segment, self.context)..segment.len()
    }

    /// A panel along time that zooms with the others of its figure.
    fn trend(&self, y_label: impl Into<String>) -> Panel {
        let axis = self.time();
        Panel::new(axis.label, y_label).x_scale(axis.scale).group(self.group).height(130.0)
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
