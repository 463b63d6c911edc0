//! A recording beside its fitted loop.

use super::run::times;
use crate::closed_loop::Run;
use stiction_figure::figure::{Figure, Panel, Series, colour};

/// Number of samples shown.
const SHOWN: usize = 1200;

/// The recorded PV and OP above, and the fitted loop's own motion below, on equal scales, with at most 1,200 samples
/// of each, from the middle.
pub fn fitted(title: &str, op: &[f64], pv: &[f64], sample_time: f64, simulated: &Run) -> Figure {
    let from = op.len().saturating_sub(SHOWN) / 2;
    let until = (from + SHOWN).min(op.len());
    let (op, pv) = (&op[from..until], &pv[from..until]);
    let duration = op.len() as f64 * sample_time;
    let wanted = ((duration / simulated.sample_time) as usize).min(simulated.op.len());
    // The end of the run, after it has settled, with samples thinned to the visible resolution.
    let first = simulated.op.len() - wanted;
    let every = wanted.div_ceil(2 * SHOWN).max(1);
    let thin = |x: &[f64]| x[first..].iter().step_by(every).copied().collect::<Vec<f64>>();
    let (own_op, own_vp, own_pv) = (thin(&simulated.op), thin(&simulated.vp), thin(&simulated.pv));
    let t = times(op.len(), sample_time);
    let own_t = times(own_op.len(), simulated.sample_time * every as f64);
    let ends = |a: &[f64], b: &[f64]| {
        let all = || a.iter().chain(b).copied();
        let (low, high) =
            (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        let room = 0.05 * (high - low).max(1e-9);
        (low - room, high + room)
    };
    let (of_pv, of_op) = (ends(pv, &own_pv), ends(op, &own_op));
    let panel = |what: &str, (low, high): (f64, f64)| {
        Panel::new("time (s)", what).y_range(low, high).x_range(0.0, duration)
    };
    Figure::new(title)
        .with(
            panel("recorded PV (PV units)", of_pv)
                .with(Series::line("recorded PV", &t[..], pv).colour(colour::PV)),
        )
        .with(
            panel("recorded OP (%)", of_op)
                .with(Series::line("recorded OP", &t[..], op).colour(colour::OP)),
        )
        .with(
            panel("fitted PV (PV units)", of_pv)
                .with(Series::line("PV of the fitted loop", &own_t[..], own_pv).colour(colour::PV)),
        )
        .with(
            panel("fitted OP, VP (%)", of_op)
                .with(
                    Series::dashed("OP of the fitted loop", &own_t[..], own_op).colour(colour::OP),
                )
                .with(Series::line("VP", &own_t[..], own_vp).colour(colour::VP)),
        )
        .columns(1)
        .panel_height(150.0)
}
