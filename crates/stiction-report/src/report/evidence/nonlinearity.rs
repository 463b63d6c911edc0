//! Tests for a loop that is not linear: bicoherence and surrogate data.

use super::{Scene, dashed, line_at, sheet, solid, thinned};
use crate::report::layout::number;
use crate::report::views::{WIDTH, histogram, outline};
use stiction_diagnose::detect::{BicoherencePlane, BicoherenceResult, Bin, SurrogatesResult};
use stiction_diagnose::series::{max, mean, sample_std};
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Series, colour};

/// Points of the phase plot at most.
const MOST: usize = 800;

pub fn bicoherence(scene: &Scene<'_>, found: &BicoherenceResult) -> Option<Figure> {
    let (panel, mut caption) = plane(scene, &found.plane, "control error")?;
    let mut figure = sheet("").width(480.0).panel_height(300.0).with(panel);
    if !found.op.is_empty() && found.op.len() == found.pv.len() {
        let ((op, stride), (pv, _)) = (thinned(&found.op, MOST), thinned(&found.pv, MOST));
        let mut map = Panel::new(
            "OP about its mean, filtered (%)",
            scene.context.pv_label("PV about its mean, filtered"),
        )
        .legend(Legend::Above)
        .with(Series::points("samples", op, pv).colour(colour::BLUE));
        caption.push_str(" Right: OP and PV about the oscillation's frequency.");
        if stride > 1 {
            caption.push_str(&format!(" One sample in {stride} is drawn."));
        }
        match &found.ellipse {
            Some(ellipse) => {
                let (x, y) = outline(ellipse);
                let ([middle, level], half) = (ellipse.centre, ellipse.op_width() / 2.0);
                map = map
                    .with(Series::line("fitted ellipse", x, y).colour(colour::VERMILION))
                    .note(Annotation::dimension(
                        (middle - half, level),
                        (middle + half, level),
                        format!("{} %", number(2.0 * half)),
                        0.0,
                    ));
                caption.push_str(
                    " The width of the ellipse along the OP is the apparent stiction: what the loop \
                     shows, not the valve's S.",
                );
            }
            None => caption.push_str(" They do not move along an ellipse."),
        }
        figure = figure.columns(2).width(WIDTH).with(map);
    }
    Some(figure.caption(caption))
}

pub fn bicoherence_op(scene: &Scene<'_>, found: &BicoherencePlane) -> Option<Figure> {
    let (panel, caption) = plane(scene, found, "OP")?;
    Some(sheet(caption).width(480.0).panel_height(300.0).with(panel))
}

/// The bins of a bicoherence by their frequencies, and what to say of them.
fn plane(scene: &Scene<'_>, plane: &BicoherencePlane, signal: &str) -> Option<(Panel, String)> {
    let per_sample = 1.0 / (plane.segment * plane.factor) as f64;
    // In multiples of the oscillation's frequency, or, without one, in Hz.
    let (unit, scale) = match scene.subject.period.filter(|p| p.is_finite() && *p > 0.0) {
        Some(period) => ("multiples of 1/period", period),
        None => ("Hz", 1.0 / scene.subject.segment.sample_time),
    };
    let at = |bin: usize| bin as f64 * per_sample * scale;
    let mut panel =
        Panel::new(format!("one frequency ({unit})"), format!("another frequency ({unit})"))
            .legend(Legend::Above);
    let strong = plane.critical.max(0.5);
    let classes = [
        ("not significant", colour::SKY, (f64::NEG_INFINITY, plane.critical)),
        ("significant", colour::BLUE, (plane.critical, strong)),
        ("significant, above 0.5", colour::VERMILION, (strong, f64::INFINITY)),
    ];
    let mut significant = 0;
    for (name, colour, (low, high)) in classes {
        let bins: Vec<&Bin> =
            plane.bins.iter().filter(|bin| bin.value > low && bin.value <= high).collect();
        if bins.is_empty() {
            continue;
        }
        if name != "not significant" {
            significant += bins.len();
        }
        let x: Vec<f64> = bins.iter().map(|bin| at(bin.i)).collect();
        let y: Vec<f64> = bins.iter().map(|bin| at(bin.j)).collect();
        panel = panel.with(Series::points(name, x, y).colour(colour));
    }
    if panel.series.is_empty() {
        return None;
    }
    let mut caption = format!(
        "Bicoherence of the {signal}: pairs of frequencies whose sum has a phase that is bound to theirs. \
         Of {} pairs with power {significant} are significant, from a squared bicoherence of {}",
        plane.bins.len(),
        number(plane.critical)
    );
    if let Some(peak) = plane.peak {
        if peak.value > plane.critical {
            // From the corner where there are no pairs.
            let most = |frequency: fn(&Bin) -> usize| {
                at(plane.bins.iter().map(frequency).max().unwrap_or(0))
            };
            let corner = (0.12 * most(|bin| bin.i), 0.95 * most(|bin| bin.j));
            panel =
                panel.note(Annotation::arrow(number(peak.value), corner, (at(peak.i), at(peak.j))));
        }
        caption.push_str(&format!("; the largest is {}", number(peak.value)));
    }
    caption.push('.');
    if let Some(cubic) = plane.cubic {
        caption.push_str(&format!(
            " The strongest binding of a frequency to its threefold is {}, significant from {}.",
            number(cubic.value),
            number(plane.cubic_critical)
        ));
    }
    Some((panel, caption))
}

pub fn surrogates(found: &SurrogatesResult) -> Option<Figure> {
    let (x, shares) = histogram(&found.surrogates);
    let limit = mean(&found.surrogates) - 3.0 * found.limit * sample_std(&found.surrogates);
    let panel =
        Panel::new("squared prediction error Γ (variances, summed)", "share of the surrogates (%)")
            .legend(Legend::Above)
            .with(Series::bars("surrogates", x, &shares[..]).colour(colour::SKY))
            .with(line_at(dashed, "limit", limit, max(&shares)).colour(colour::BLACK))
            .with(line_at(solid, "this loop", found.gamma, max(&shares)).colour(colour::VERMILION));
    let caption = format!(
        "How well the control error can be predicted from its own past, against {} surrogates with the \
         same spectrum and the same values but random phases. To the left of the limit it is more \
         predictable than a linear loop would be: N is {}, nonlinear from {}.",
        found.surrogates.len(),
        number(found.n),
        number(found.limit)
    );
    Some(sheet(caption).with(panel))
}
