//! Figures of the recorded signals: trends, maps, correlation, spectrum and histograms.
//!
//! Each figure is made from segments of a recording. If a signal that it needs is not recorded or does not move,
//! there is no figure.

use std::f64::consts::TAU;

use super::layout::number;
use crate::valve_test_page;
use crate::words::{rough, spoken};
use stiction_diagnose::drawing::{TimeAxis, WIDTH, histogram};
use stiction_diagnose::methods::{Ellipse, ErrorSource, Subject, bicoherence::Bicoherence};
use stiction_diagnose::oscillation::separate::separate;
use stiction_diagnose::recording::{LoopType, Mode, Modes, Segment};
use stiction_diagnose::series::{
    Periodogram, autocorrelation, cross_correlation, detrended, mean, periodogram, span, std,
    zero_crossings,
};
use stiction_diagnose::valve_test::TestReading;
use stiction_figure::figure::{
    Along, Annotation, Figure, Legend, Panel, Scale, Series, Span, Strip, colour,
};

pub use stiction_diagnose::drawing::Context;

/// Trends with more samples are reduced before they are drawn.
const REDUCED_FROM: usize = 1_500;
/// The panels of this group share the time axis.
const TIME: &str = "time";

/// The panels of this group share the time axis of the first screen.
const HEAD: &str = "head";
/// Height of its panels, and width of its map, px.
const HEAD_HEIGHT: f64 = 118.0;
const HEAD_MAP_WIDTH: f64 = 430.0;
/// Names of the series of a map.
const ELLIPSE: &str = "fitted ellipse";
const SAMPLES: &str = "samples";

/// SP and PV above OP and valve position, as far as recorded, on one time axis.
///
/// Between segments, lines are interrupted and the background is shaded. If there are several segments, the bounds of
/// the segment at `judged`, on which the report rests, are marked. A strip above shows the mode.
///
/// `None` without samples.
pub fn trends(segments: &[Segment], judged: usize, context: &Context<'_>) -> Option<Figure> {
    let segments: Vec<&Segment> = segments.iter().filter(|s| !s.is_empty()).collect();
    let (first, last) = (segments.first()?, segments.last()?);
    let (from, to) = (first.from, last.from + last.duration());
    let axis = context.time_axis(to);
    let at = |t: f64| axis.at(t);

    // All segments form one series, with a break between them.
    let joined = |signal: &dyn Fn(&Segment) -> Option<Vec<f64>>| {
        let (mut x, mut y, mut breaks) = (Vec::new(), Vec::new(), Vec::new());
        for segment in &segments {
            if let Some(values) = signal(segment) {
                breaks.push(x.len());
                x.extend(segment.times().into_iter().map(at));
                y.extend(values);
            }
        }
        (!x.is_empty()).then_some((x, y, breaks))
    };
    let pv = joined(&|s| s.pv.clone());
    let sp = joined(&|s| s.sp.clone());
    let op = joined(&|s| Some(s.op.clone()));
    let vp = joined(&|s| s.vp.clone());

    let panel = |y_label: String| {
        let mut panel =
            Panel::new(axis.label.clone(), y_label).x_scale(axis.scale).group(TIME).height(170.0);
        for pair in segments.windows(2) {
            let gap = (at(pair[0].from + pair[0].duration()), at(pair[1].from));
            panel = panel.note(Annotation::x_band(gap.0, gap.1, ""));
        }
        panel
    };
    let mut panels = Vec::new();
    if pv.is_some() || sp.is_some() {
        let mut upper = panel(context.pv_label(if sp.is_some() { "PV, SP" } else { "PV" }));
        if let Some((x, y, breaks)) = pv {
            upper = upper.with(Series::line("PV", x, y).breaks(breaks).colour(colour::PV));
        }
        if let Some((x, y, breaks)) = sp {
            upper = upper.with(Series::steps("SP", x, y).breaks(breaks).colour(colour::SP));
        }
        panels.push(upper);
    }
    let mut lower =
        panel(if vp.is_some() { "OP, VP (% of span)" } else { "OP (% of span)" }.into());
    if let Some((x, y, breaks)) = op {
        lower = lower.with(Series::steps("OP", x, y).breaks(breaks).colour(colour::OP));
    }
    if let Some((x, y, breaks)) = vp {
        lower = lower.with(Series::line("VP", x, y).breaks(breaks).colour(colour::VP));
    }
    panels.push(lower);

    if let Some(strip) = context.modes.and_then(|modes| mode_strip(modes, from, to, &axis)) {
        panels[0].strip = Some(strip);
    }
    if segments.len() > 1
        && let Some(judged) = segments.get(judged)
    {
        let ends = (at(judged.from), at(judged.from + judged.duration()));
        let top = panels.remove(0);
        let top = top.note(Annotation::vertical_line(ends.0, "longest segment"));
        panels.insert(0, top.note(Annotation::vertical_line(ends.1, "its end")));
    }

    let samples: usize = segments.iter().map(|s| s.len()).sum();
    let mut caption = format!(
        "Trends of {samples} samples, every {} s, over {}.",
        number(first.sample_time),
        spoken(to - from)
    );
    if segments.len() > 1 {
        caption.push_str(
            " Shaded times are outside the segments, because of a gap or because the controller was not in command.",
        );
    }
    if samples > REDUCED_FROM {
        caption.push_str(" Lines are reduced to the visible resolution, with every extreme kept.");
    }
    let figure = Figure::new("").caption(caption).width(WIDTH);
    Some(panels.into_iter().fold(figure, Figure::with))
}

/// Above this number, slips are not marked, because they would cover the trend.
const MOST_SLIPS: usize = 300;

/// Trends for the first screen, as in [`trends`] but lower, with the slips of a suspected valve.
pub(super) fn head_trend(
    segments: &[Segment],
    judged: usize,
    slips: Option<&[usize]>,
    context: &Context<'_>,
) -> Option<Figure> {
    let mut figure = trends(segments, judged, context)?;
    let marked = slips.filter(|slips| (1..=MOST_SLIPS).contains(&slips.len()));
    // The OP's panel is the last.
    if let (Some(slips), Some(segment)) = (marked, segments.get(judged))
        && let Some(panel) = figure.panels.pop()
    {
        let axis = axis_of(segments, context)?;
        let times = segment.times();
        let (x, y): (Vec<f64>, Vec<f64>) =
            slips.iter().map(|k| (axis.at(times[*k]), segment.op[*k])).unzip();
        let slips = Series::points("slips", x, y).colour(colour::VERMILION);
        figure = figure.with(panel.with(slips));
        figure.caption += " Points mark the slips of the valve model that explains the PV best.";
    }
    for panel in &mut figure.panels {
        if context.pv_unit.is_none() && panel.y_label.starts_with("PV") {
            // There is no room for a note on the unknown unit.
            panel.y_label.truncate(panel.y_label.find(" (").unwrap_or(panel.y_label.len()));
        }
        panel.height = Some(HEAD_HEIGHT);
        panel.group = Some(HEAD.to_owned());
    }
    if let (Some(period), Some(segment)) = (context.period_s, segments.get(judged)) {
        let axis = axis_of(segments, context)?;
        let end = segment.from + segment.duration();
        if period < segment.duration() {
            let cycle = Annotation::x_band(axis.at(end - period), axis.at(end), "");
            let panels = figure.panels.into_iter();
            figure.panels = panels.map(|panel| panel.note(cycle.clone())).collect();
            figure.caption += " The shaded end is one cycle.";
        }
    }
    Some(figure)
}

/// Length of a cycle in the units of the trend's axis; `None` if unknown.
pub(super) fn cycle_on_axis(segments: &[Segment], context: &Context<'_>) -> Option<f64> {
    let axis = axis_of(segments, context)?;
    context.period_s.map(|period| axis.at(period) - axis.at(0.0))
}

fn axis_of(segments: &[Segment], context: &Context<'_>) -> Option<TimeAxis> {
    let last = segments.iter().rfind(|segment| !segment.is_empty())?;
    Some(context.time_axis(last.from + last.duration()))
}

/// VP or, where no position is recorded, PV over OP for the first screen, with `s` drawn on it.
///
/// `None` as for [`pv_op_map`].
pub fn head_map(segment: &Segment, s: Option<f64>, context: &Context<'_>) -> Option<Figure> {
    let (name, y, label) = match &segment.vp {
        Some(vp) => ("VP", vp, "VP (% of span)".to_owned()),
        None => ("PV", segment.pv.as_ref()?, context.pv_label("PV")),
    };
    let mut figure = op_map(segment, name, y, label, context)?;
    let panel = figure.panels.first_mut()?;
    let from = context.last_periods(segment);
    let (op, y) = (&segment.op[from..], &y[from..]);
    // The ellipse is shown with the other definitions.
    panel.series.retain(|series| ![ELLIPSE, SAMPLES].contains(&&*series.label));
    panel.annotations.retain(|note| !matches!(note, Annotation::Dimension { .. }));
    panel.height = Some(2.0 * HEAD_HEIGHT - 40.0);
    let lasting = spoken((segment.len() - from) as f64 * segment.sample_time);
    figure.caption = format!("{name} over OP in the last {lasting}. Arrows point forward in time.");
    if let Some(s) = s.filter(|s| *s > 0.0 && *s < 2.0 * span(op)) {
        let (middle, low) = (mean(op), stiction_diagnose::series::min(y));
        let bar = Annotation::dimension((middle - s / 2.0, low), (middle + s / 2.0, low), "S", 0.0);
        *panel = panel.clone().note(bar);
        figure.caption += &format!(" The bar is as long as S, {} %.", rough(s));
    }
    (figure.width, figure.panel_height) = (HEAD_MAP_WIDTH, None);
    Some(figure)
}

/// The answers of a valve test for the first screen.
pub(super) fn head_answers(test: &TestReading, context: &Context<'_>) -> Figure {
    let mut figure = valve_test_page::answers(test, context);
    for panel in &mut figure.panels {
        panel.height = Some(2.0 * HEAD_HEIGHT - 40.0);
    }
    figure.width(HEAD_MAP_WIDTH)
}

/// The modes between two times.
fn mode_strip(modes: &Modes, from: f64, to: f64, axis: &TimeAxis) -> Option<Strip> {
    let starts = modes.time.iter().zip(&modes.modes);
    let ends = modes.time.iter().skip(1).copied().chain([f64::INFINITY]);
    let mut spans: Vec<Span> = Vec::new();
    for ((&start, &mode), end) in starts.zip(ends) {
        let (start, end) = (start.max(from), end.min(to));
        if !(end > start) {
            continue;
        }
        let (word, shade) = match mode {
            Mode::Automatic => ("auto", 0.0),
            Mode::Cascade => ("cascade", 0.3),
            Mode::Manual => ("manual", 1.0),
            Mode::Other => ("other", 0.7),
        };
        match spans.last_mut() {
            Some(last) if last.word == word => last.to = axis.at(end),
            _ => spans.push(Span {
                from: axis.at(start),
                to: axis.at(end),
                word: word.into(),
                shade,
            }),
        }
    }
    (!spans.is_empty()).then(|| Strip { name: "mode".to_owned(), spans })
}

/// PV over OP for the last few periods, with arrows along the path. If the samples lie along an ellipse, its best fit
/// is drawn with its width in the direction of the OP.
///
/// `None` if the PV is not recorded or either does not move.
pub fn pv_op_map(segment: &Segment, context: &Context<'_>) -> Option<Figure> {
    op_map(segment, "PV", segment.pv.as_ref()?, context.pv_label("PV"), context)
}

/// The same of the signal `y` with this name and axis label.
fn op_map(
    segment: &Segment,
    name: &str,
    y: &[f64],
    label: String,
    context: &Context<'_>,
) -> Option<Figure> {
    const MOST: usize = 1_500;
    if span(y) == 0.0 || span(&segment.op) == 0.0 {
        return None;
    }
    let from = context.last_periods(segment);
    let stride = (segment.len() - from).div_ceil(MOST);
    let thinned = |x: &[f64]| -> Vec<f64> { x[from..].iter().copied().step_by(stride).collect() };
    let ellipse = Ellipse::fit(&segment.op[from..], &y[from..])
        .filter(|ellipse| ellipse.residual <= Bicoherence::default().most_residual);
    let (op, y) = (thinned(&segment.op), thinned(y));
    let axis = context.time_axis(segment.from + segment.duration());
    let times: Vec<f64> = segment.times().into_iter().map(|t| axis.at(t)).collect();
    let time = Along { label: axis.label, scale: axis.scale, values: thinned(&times) };

    let over = format!("{name} over OP");
    let mut panel = Panel::new("OP (% of span)", label)
        .legend(Legend::Above)
        .with(Series::line(&over, &op[..], &y[..]).colour(colour::SKY).along(time))
        .with(Series::points(SAMPLES, &op[..], &y[..]).colour(colour::BLUE));
    for (tail, tip) in directions(&op, &y) {
        panel = panel.note(Annotation::arrow("", tail, tip));
    }
    let mut caption = format!(
        "{over} in the last {} of the segment. Arrows point forward in time.",
        spoken((segment.len() - from) as f64 * segment.sample_time)
    );
    if stride > 1 {
        caption.push_str(&format!(" One sample in {stride} is drawn."));
    }
    if let Some(ellipse) = ellipse {
        let (x, outline) = ellipse.closed_outline();
        let (width, [middle, level]) = (ellipse.op_width(), ellipse.centre);
        panel = panel.with(Series::dashed(ELLIPSE, x, outline).colour(colour::VERMILION)).note(
            Annotation::dimension(
                (middle - width / 2.0, level),
                (middle + width / 2.0, level),
                format!("{} %", number(width)),
                0.0,
            ),
        );
        caption.push_str(&format!(
            " The ellipse is fitted to these samples. The width of the ellipse in the direction of the OP, {} %, \
             depends on the controller and is not S.",
            number(width)
        ));
    } else {
        caption.push_str(" The samples do not lie along an ellipse.");
    }
    Some(Figure::new("").caption(caption).width(620.0).panel_height(380.0).with(panel))
}

/// A point in data coordinates.
type Place = (f64, f64);

/// Arrows along the path of a map, where it moves far enough to have a direction. Neighbouring points are averaged,
/// so that noise does not turn the arrows.
fn directions(x: &[f64], y: &[f64]) -> Vec<(Place, Place)> {
    const ARROWS: usize = 10;
    let n = x.len();
    let half = (n / 200).max(1);
    if n < 20 * half {
        return Vec::new();
    }
    let smooth = |at: usize| {
        let range = at.saturating_sub(half)..(at + half + 1).min(n);
        (mean(&x[range.clone()]), mean(&y[range]))
    };
    let (width, height) = (span(x), span(y));
    let length = |a: Place, b: Place| ((b.0 - a.0) / width).hypot((b.1 - a.1) / height);
    // Each begins a tenth of the samples after the last one, or later, at the next segment of path that is long
    // enough.
    let mut arrows: Vec<(Place, Place)> = Vec::new();
    let mut next = half;
    for tail in half..n.saturating_sub(half) {
        let ahead = (tail + 1..(tail + n / 20).min(n - half))
            .find(|tip| length(smooth(tail), smooth(*tip)) >= 0.12);
        if tail >= next
            && let Some(tip) = ahead
        {
            arrows.push((smooth(tail), smooth(tip)));
            next = tail + n / ARROWS;
        }
    }
    arrows
}

/// Cross-correlation of OP and PV over the lag of the PV behind the OP.
///
/// `None` if the PV is not recorded or either does not move.
pub fn op_pv_correlation(segment: &Segment, context: &Context<'_>) -> Option<Figure> {
    let pv = segment.pv.as_ref()?;
    let most = most_lag(segment, context);
    let correlation = cross_correlation(&segment.op, pv, most)?;
    let most = correlation.max_lag as isize;
    let seconds = |lag: f64| lag * segment.sample_time;
    let axis = TimeAxis::of_lags("lag of the PV behind the OP", seconds(most as f64));
    let x: Vec<f64> = (-most..=most).map(|lag| axis.at(seconds(lag as f64))).collect();
    // Among equal extremes, the one nearest to zero is shown.
    let extreme = (-most + 1..most)
        .filter(|&lag| {
            let (a, b, c) = (correlation.at(lag - 1), correlation.at(lag), correlation.at(lag + 1));
            b.abs() >= a.abs() && b.abs() > c.abs() && b.abs() > 0.2
        })
        .max_by(|a, b| correlation.at(*a).abs().total_cmp(&correlation.at(*b).abs()));
    let zero = correlation.at(0);
    let mut panel = Panel::new(axis.label.clone(), "correlation of OP and PV")
        .y_range(-1.05, 1.05)
        .with(Series::line("correlation", x, &correlation.values[..]).colour(colour::BLUE))
        .note(Annotation::horizontal_line(0.0, ""))
        .note(Annotation::vertical_line(0.0, format!("{} at lag 0", number(zero))));
    let mut caption = format!("Cross-correlation of OP and PV: {} at lag zero", number(zero));
    if let Some(lag) = extreme {
        let (value, at) = (correlation.at(lag), axis.at(seconds(lag as f64)));
        panel = panel.with(Series::points("largest", [at], [value]).colour(colour::VERMILION));
        caption.push_str(&format!(
            " and largest, {}, at a lag of {}",
            number(value),
            spoken(seconds(lag as f64))
        ));
    }
    caption.push('.');
    Some(Figure::new("").caption(caption).width(WIDTH).panel_height(240.0).with(panel))
}

/// Autocorrelation of the control error and of the OP, with their zero crossings.
///
/// `None` if neither moves.
pub fn autocorrelations(segment: &Segment, context: &Context<'_>) -> Option<Figure> {
    let most = most_lag(segment, context);
    let axis = TimeAxis::of_lags("lag", most as f64 * segment.sample_time);
    let at = |lag: f64| axis.at(lag * segment.sample_time);
    let mut panel = Panel::new(axis.label.clone(), "autocorrelation")
        .y_range(-1.05, 1.05)
        .legend(Legend::Above)
        .note(Annotation::horizontal_line(0.0, ""));
    let mut crossings = Vec::new();
    let mut found = Vec::new();
    for (name, values, colour) in signals(segment) {
        let Some(acf) = autocorrelation(&values, most) else { continue };
        let places: Vec<f64> = zero_crossings(&acf).iter().map(|c| c.place).collect();
        if places.len() > 2 {
            let apart: Vec<f64> = places.windows(2).map(|p| p[1] - p[0]).collect();
            let half = mean(&apart) * segment.sample_time;
            found.push(format!("{name} {}", spoken(2.0 * half)));
        }
        crossings.push((format!("zeros, {name}"), places));
        let x: Vec<f64> = (0..acf.len()).map(|lag| at(lag as f64)).collect();
        panel = panel.with(Series::line(name, x, acf).colour(colour));
    }
    for (label, places) in crossings {
        if !places.is_empty() {
            let x: Vec<f64> = places.iter().map(|p| at(*p)).collect();
            let zeros = vec![0.0; x.len()];
            panel = panel.with(Series::points(label, x, zeros).colour(colour::BLACK));
        }
    }
    if panel.series.is_empty() {
        return None;
    }
    let mut caption =
        "Autocorrelation with its zero crossings, which are equally spaced if the loop cycles \
        regularly."
            .to_owned();
    if !found.is_empty() {
        caption.push_str(&format!(" Twice the mean spacing is {}.", found.join(", ")));
    }
    Some(Figure::new("").caption(caption).width(WIDTH).panel_height(240.0).with(panel))
}

/// Power of the control error and of the OP over the period, with the highest peaks.
///
/// `None` if neither moves, or for fewer than 16 samples.
pub fn spectrum(segment: &Segment, context: &Context<'_>) -> Option<Figure> {
    if segment.len() < 16 {
        return None;
    }
    let longest = segment.duration();
    let usual = context.period_of(segment).unwrap_or(longest / 10.0);
    let axis = TimeAxis::of_lags("period", usual);
    let mut panel = Panel::new(axis.label.clone(), "share of the variance in each bin")
        .x_scale(Scale::Log)
        .y_scale(Scale::Log)
        .legend(Legend::Above);
    let (mut found, mut marks) = (Vec::new(), Vec::new());
    for (name, values, colour) in signals(segment) {
        if span(&values) == 0.0 {
            continue;
        }
        let lines = periodogram(&values);
        let all: f64 = lines.power.iter().sum();
        let highest = lines.power.iter().skip(1).fold(0.0, |m: f64, p| m.max(*p));
        if !(all > 0.0 && highest > 0.0) {
            continue;
        }
        let tops = oscillations(&values, &lines, segment.sample_time);
        let period = |bin: usize| segment.sample_time / lines.frequency[bin];
        if !tops.is_empty() {
            let listed: Vec<String> = tops.iter().map(|(_, p)| spoken(*p)).collect();
            found.push(format!("{name} {}", listed.join(", ")));
        }
        // Peaks a million times weaker are rounding noise.
        let share = |bin: usize| lines.power[bin].max(1e-6 * highest) / all;
        let bins = (1..lines.power.len()).rev().filter(|bin| period(*bin) <= longest);
        let (x, y): (Vec<f64>, Vec<f64>) =
            bins.map(|bin| (axis.at(period(bin)), share(bin))).unzip();
        if x.is_empty() {
            continue;
        }
        panel = panel.with(Series::line(name, x, y).colour(colour));
        if !tops.is_empty() {
            let (x, y): (Vec<f64>, Vec<f64>) =
                tops.iter().map(|&(bin, _)| (axis.at(period(bin)), share(bin))).unzip();
            // Several names would cover each other.
            let marked = |x: f64| marks.iter().any(|m: &f64| (x / m).ln().abs() < 0.2);
            if !marked(x[0]) {
                marks.push(x[0]);
                panel = panel.note(Annotation::vertical_line(x[0], spoken(tops[0].1)));
            }
            panel = panel
                .with(Series::points(format!("oscillations, {name}"), x, y).colour(colour::BLACK));
        }
    }
    if panel.series.is_empty() {
        return None;
    }
    // Room for the names of the peaks.
    let shares = || panel.series.iter().flat_map(|s| s.y.iter().copied());
    let (low, high) =
        shares().fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), v| (a.min(v), b.max(v)));
    panel.y_range = Some((low / 2.0, high * 12.0));
    let mut caption = "Spectrum with a Hann window. Each signal has a total power of 1.".to_owned();
    if !found.is_empty() {
        caption.push_str(&format!(
            " Oscillations above the background, strongest first: {}.",
            found.join("; ")
        ));
    }
    Some(Figure::new("").caption(caption).width(WIDTH).panel_height(260.0).with(panel))
}

/// Histograms of the control error and the OP, with Gaussians of the same mean and standard deviation.
///
/// `None` if neither moves.
pub fn histograms(segment: &Segment, context: &Context<'_>) -> Option<Figure> {
    let mut figure = Figure::new("")
        .columns(2)
        .width(WIDTH)
        .panel_height(230.0)
        .caption("Histograms, with dashed Gaussians of the same mean and standard deviation.");
    for (name, values, colour) in signals(segment) {
        if !(span(&values) > 0.0) {
            continue;
        }
        let (centres, shares) = histogram(&values);
        let width = centres[1] - centres[0];
        let (m, s) = (mean(&values), std(&values));
        let (low, high) = (centres[0] - width / 2.0, centres[centres.len() - 1] + width / 2.0);
        let x: Vec<f64> = (0..=120).map(|i| low + (high - low) * f64::from(i) / 120.0).collect();
        let density =
            |x: &f64| 100.0 * width * (-0.5 * ((x - m) / s).powi(2)).exp() / (s * TAU.sqrt());
        let gaussian: Vec<f64> = x.iter().map(density).collect();
        let label = if name == "OP" { "OP (% of span)".into() } else { context.pv_label(name) };
        let panel = Panel::new(label, "share of the samples (%)")
            .legend(Legend::Above)
            .with(Series::bars("samples", centres, shares).colour(colour))
            .with(Series::dashed("Gaussian", x, gaussian).colour(colour::BLACK));
        figure = figure.with(panel);
    }
    (!figure.panels.is_empty()).then_some(figure)
}

/// The control error, if there is a PV, and the OP, with their colours.
fn signals(segment: &Segment) -> Vec<(&'static str, Vec<f64>, usize)> {
    let subject = Subject::new(segment, LoopType::Unknown, None);
    let mut signals = Vec::new();
    if let Some(error) = subject.error() {
        let name = match error.source {
            ErrorSource::SetPoint => "error SP − PV",
            ErrorSource::MeanPv => "error, mean PV − PV",
        };
        signals.push((name, error.values.clone(), colour::VERMILION));
    }
    signals.push(("OP", segment.op.clone(), colour::BLUE));
    signals
}

/// Range of lags in samples: four periods, or a quarter of the segment if nothing cycles.
fn most_lag(segment: &Segment, context: &Context<'_>) -> usize {
    let n = segment.len();
    let periods = context.period_of(segment).map(|p| (4.0 * p / segment.sample_time).ceil());
    let wanted = periods.unwrap_or(n as f64 / 4.0);
    (wanted.clamp(4.0, 1e7) as usize).min(n / 2).max(1)
}

/// The oscillations found in a signal, strongest first, each with its bin and its period in s.
fn oscillations(values: &[f64], lines: &Periodogram, sample_time: f64) -> Vec<(usize, f64)> {
    let peaks = separate(&detrended(values), sample_time);
    let bins = peaks.iter().map(|peak| {
        let frequency = sample_time / peak.period_s;
        let next = lines.frequency.partition_point(|f| *f < frequency);
        // The highest bin nearby, because the period of a band is not exactly that of its peak.
        let near = next.saturating_sub(2).max(1)..(next + 2).min(lines.power.len());
        let bin = near.max_by(|a, b| lines.power[*a].total_cmp(&lines.power[*b]))?;
        Some((bin, peak.period_s))
    });
    bins.flatten().collect()
}

/// All figures of one segment of a recording, in reading order.
pub fn all(segments: &[Segment], judged: usize, context: &Context<'_>) -> Vec<Figure> {
    let Some(segment) = segments.get(judged) else { return Vec::new() };
    [
        pv_op_map(segment, context),
        op_pv_correlation(segment, context),
        autocorrelations(segment, context),
        spectrum(segment, context),
        histograms(segment, context),
    ]
    .into_iter()
    .flatten()
    .collect()
}
