//! Figure of the method: the cross-correlation of OP and PV.

use super::HorchResult;
use crate::drawing::{Scene, TimeAxis, sheet};
use crate::spoken::{number, unparted};
use stiction_figure::figure::{Annotation, Figure, Legend, Panel, Series, colour};

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &HorchResult) -> Option<Figure> {
    let sample_time = scene.segment.sample_time;
    let most = found.correlation.max_lag as isize;
    let axis = TimeAxis::of_lags(
        "lag of the PV behind the OP",
        found.correlation.max_lag as f64 * sample_time,
    );
    let at = |lag: f64| axis.at(lag * sample_time);
    let x: Vec<f64> = (-most..=most).map(|lag| at(lag as f64)).collect();
    let (left, right) = (at(-found.tau_left), at(found.tau_right));
    let zero = at(0.0);
    // The dimensions are below everything, one below the other.
    let (upper, lower) = (-105.0, -135.0);
    let side = |name: &str, samples: f64| format!("{name} = {}", unparted(samples * sample_time));
    let panel = Panel::new(axis.label.clone(), "correlation of OP and PV")
        .y_range(-1.8, 1.08)
        .legend(Legend::Above)
        .with(Series::line("correlation", x, &found.correlation.values[..]).colour(colour::BLUE))
        .with(Series::points("crossings of zero", [left, right], [0.0; 2]).colour(colour::BLACK))
        .with(Series::points("r0, at lag 0", [zero], [found.r0]).colour(colour::VERMILION))
        .with(
            Series::points("r opt, the peak", [at(found.lag_opt as f64)], [found.r_opt])
                .colour(colour::GREEN),
        )
        .note(Annotation::horizontal_line(0.0, ""))
        .note(Annotation::vertical_line(zero, ""))
        .note(Annotation::dimension(
            (left, 0.0),
            (zero, 0.0),
            side("τ left", found.tau_left),
            upper,
        ))
        .note(Annotation::dimension(
            (zero, 0.0),
            (right, 0.0),
            side("τ right", found.tau_right),
            lower,
        ));
    let caption = format!(
        "Cross-correlation of OP and PV. An odd correlation, zero near lag 0, is evidence for stiction. An even \
         correlation, with the peak near lag 0, is evidence against stiction. The asymmetry Δτ of τ left and τ right is {}, the \
         distance Δρ of r0 from r opt is {}, both from 0 to 1.",
        number(found.delta_tau),
        number(found.delta_rho)
    );
    Some(sheet(caption).panel_height(260.0).with(panel))
}
