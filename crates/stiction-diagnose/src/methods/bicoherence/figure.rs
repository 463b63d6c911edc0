//! Figure of the method: the bicoherence of the error, and the ellipse of PV and OP.

use super::{BicoherencePlane, BicoherenceResult, Bin};
use crate::drawing::{Scene, WIDTH, sheet, thinned};
use crate::spoken::number;
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Series, colour};

/// Largest number of points of the phase plot.
const MOST: usize = 800;

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &BicoherenceResult) -> Option<Figure> {
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
        caption.push_str(" Right: OP and PV, filtered around the oscillation's frequency.");
        if stride > 1 {
            caption.push_str(&format!(" One sample in {stride} is drawn."));
        }
        match &found.ellipse {
            Some(ellipse) => {
                let (x, y) = ellipse.closed_outline();
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
                    " The width of the ellipse along the OP is the apparent stiction of the loop, not the valve's \
                     S.",
                );
            }
            None => caption.push_str(" OP and PV do not move along an ellipse."),
        }
        figure = figure.columns(2).width(WIDTH).with(map);
    }
    Some(figure.caption(caption))
}

/// The bins of a bicoherence by their frequencies, and their caption.
pub(in crate::methods) fn plane(
    scene: &Scene<'_>,
    plane: &BicoherencePlane,
    signal: &str,
) -> Option<(Panel, String)> {
    let per_sample = 1.0 / (plane.segment * plane.factor) as f64;
    // In multiples of the oscillation's frequency, or, without one, in Hz.
    let (unit, scale) = match scene.period.filter(|p| p.is_finite() && *p > 0.0) {
        Some(period) => ("multiples of 1/period", period),
        None => ("Hz", 1.0 / scene.segment.sample_time),
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
        "Bicoherence of the {signal}: pairs of frequencies whose phases are coupled to that of their sum. Of {} \
         pairs with power, {significant} are significant (squared bicoherence above {})",
        plane.bins.len(),
        number(plane.critical)
    );
    if let Some(peak) = plane.peak {
        if peak.value > plane.critical {
            // From the corner without pairs.
            let most = |frequency: fn(&Bin) -> usize| {
                at(plane.bins.iter().map(frequency).max().unwrap_or(0))
            };
            let corner = (0.12 * most(|bin| bin.i), 0.95 * most(|bin| bin.j));
            panel =
                panel.note(Annotation::arrow(number(peak.value), corner, (at(peak.i), at(peak.j))));
        }
        caption.push_str(&format!(". The largest is {}", number(peak.value)));
    }
    caption.push('.');
    if let Some(cubic) = plane.cubic {
        caption.push_str(&format!(
            " The strongest coupling of a frequency with its third harmonic is {}, significant from {}.",
            number(cubic.value),
            number(plane.cubic_critical)
        ));
    }
    Some((panel, caption))
}
