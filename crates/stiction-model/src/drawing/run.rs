//! Figures of simulated runs.

use crate::closed_loop::{CascadeRun, OpenLoopRun, Run};
use crate::compensate::CompensatedRun;
use stiction_figure::figure::{Annotation, Figure, Panel, Series, colour};

/// The times of `samples` samples, s.
pub fn times(samples: usize, sample_time: f64) -> Vec<f64> {
    (0..samples).map(|k| k as f64 * sample_time).collect()
}

/// Controller output and valve position over time.
pub(crate) fn valve_panel(t: &[f64], op: &[f64], vp: &[f64]) -> Panel {
    Panel::new("time (s)", "OP, VP (% of span)")
        .with(Series::line("valve position VP", t, vp).colour(colour::VP))
        .with(Series::dashed("controller output OP", t, op).colour(colour::OP))
}

/// Set point and PV over time. `what` is the name of the PV with its unit.
pub(crate) fn pv_panel(t: &[f64], sp: &[f64], pv: &[f64], what: &str) -> Panel {
    Panel::new("time (s)", what)
        .with(Series::line("PV", t, pv).colour(colour::PV))
        .with(Series::dashed("set point SP", t, sp).colour(colour::SP))
}

/// Position against input.
fn map_panel(op: &[f64], vp: &[f64]) -> Panel {
    Panel::new("controller output OP (% of span)", "valve position VP (% of span)")
        .with(Series::line("VP", op, vp).colour(colour::VP))
}

/// A valve on a test signal, with both signals over time, and the position over the input.
pub fn open_loop(title: &str, run: &OpenLoopRun) -> Figure {
    let t = times(run.op.len(), run.sample_time);
    Figure::new(title)
        .with(valve_panel(&t, &run.op, &run.vp))
        .with(map_panel(&run.op, &run.vp))
        .columns(2)
        .width(1000.0)
}

/// A loop, with set point and PV above OP and VP.
pub fn closed_loop(title: &str, run: &Run) -> Figure {
    let t = times(run.op.len(), run.sample_time);
    Figure::new(title)
        .with(pv_panel(&t, &run.sp, &run.pv, "PV, SP (PV units)"))
        .with(valve_panel(&t, &run.op, &run.vp))
}

/// A loop before and after its compensator is switched on at `on_s`, from `from_s` to `to_s`, s. Set point and PV are
/// above OP, the signal to the valve, and VP. Times outside the run are left out.
pub fn compensated(
    title: &str,
    done: &CompensatedRun,
    on_s: f64,
    from_s: f64,
    to_s: f64,
) -> Figure {
    let run = &done.run;
    let index = |time_s: f64| ((time_s / run.sample_time).max(0.0) as usize).min(run.pv.len());
    let shown = index(from_s)..index(to_s);
    let t: Vec<f64> = times(run.pv.len(), run.sample_time)[shown.clone()].to_vec();
    let of = |signal: &[f64]| signal[shown.clone()].to_vec();
    let pv = pv_panel(&t, &of(&run.sp), &of(&run.pv), "PV, SP (PV units)")
        .note(Annotation::vertical_line(on_s, "compensator on"));
    let valve = Panel::new("time (s)", "OP, signal, VP (% of span)")
        .with(Series::line("signal to the valve", &t[..], of(&done.signal)).colour(colour::SKY))
        .with(Series::line("valve position VP", &t[..], of(&run.vp)).colour(colour::VP))
        .with(Series::dashed("controller output OP", &t[..], of(&run.op)).colour(colour::OP))
        .note(Annotation::vertical_line(on_s, ""));
    Figure::new(title).with(pv).with(valve)
}

/// A cascade, with the master above the slave above OP and VP.
pub fn cascade(title: &str, run: &CascadeRun) -> Figure {
    let t = times(run.pv.len(), run.slave.sample_time);
    Figure::new(title)
        .with(pv_panel(&t, &run.sp, &run.pv, "master (its PV units)"))
        .with(pv_panel(&t, &run.slave.sp, &run.slave.pv, "slave (its PV units)"))
        .with(valve_panel(&t, &run.slave.op, &run.slave.vp))
}
