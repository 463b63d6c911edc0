//! The picture of a model: its response to an oscillating OP, or the cycle of a loop.

use stiction_figure::figure::colour;
use stiction_figure::{Figure, Panel, Series};
use stiction_fmu::Fmu;

use crate::Error;

/// Number of steps in a picture.
const STEPS: usize = 1_200;

/// The picture as SVG, and its caption.
pub fn picture(fmu: &Fmu) -> Result<(String, &'static str), Error> {
    let (figure, caption) = if fmu.model() == "loop" { cycle(fmu)? } else { answer(fmu)? };
    let svg = figure.columns(2).width(960.0).svg();
    Ok((svg.map_err(|e| Error::Model(e.to_string()))?, caption))
}

/// VP for an OP that swings by a quarter of the span around 50 % with a period of 60 s.
fn answer(fmu: &Fmu) -> Result<(Figure, &'static str), Error> {
    const STEP_S: f64 = 0.1;
    let time: Vec<f64> = (1..=STEPS).map(|k| k as f64 * STEP_S).collect();
    let op: Vec<f64> =
        time.iter().map(|t| 50.0 + 25.0 * (std::f64::consts::TAU * t / 60.0).sin()).collect();
    let vp = fmu.follow(STEP_S, &op, &["VP"]).map_err(Error::Model)?.remove(0);
    let map = Panel::new("controller output OP (%)", "valve position VP (%)")
        .with(Series::line("VP", &op[..], &vp[..]).colour(colour::VERMILION));
    let trend = Panel::new("time (s)", "OP, VP (%)")
        .with(Series::line("valve position VP", &time[..], vp).colour(colour::VERMILION))
        .with(Series::dashed("controller output OP", time, op).colour(colour::BLUE));
    let caption = "With its start values: VP while OP swings by \u{b1}25 % around 50 % in 60 s, over time and over \
                   OP.";
    Ok((Figure::new("").with(trend).with(map), caption))
}

/// The undisturbed loop.
fn cycle(fmu: &Fmu) -> Result<(Figure, &'static str), Error> {
    let start = |name: &str| {
        fmu.variables().iter().find(|v| v.name == name).and_then(|v| v.start).unwrap_or_default()
    };
    // A cycle is several times as long as the response time of the loop.
    let sample_time = start("sample_time");
    let length_s = 20.0 * (start("Ti") + start("tau") + start("tau2") + start("dead_time"));
    let step_s = (length_s / STEPS as f64).clamp(sample_time, 100.0 * sample_time);
    let time: Vec<f64> = (1..=STEPS).map(|k| k as f64 * step_s).collect();
    let sp = vec![start("SP"); STEPS];
    let found = fmu.follow(step_s, &sp, &["PV", "OP", "VP"]).map_err(Error::Model)?;
    let [pv, op, vp] = <[Vec<f64>; 3]>::try_from(found).unwrap_or_default();
    let above = Panel::new("time (s)", "PV, SP (%)")
        .with(Series::line("PV", &time[..], pv).colour(colour::GREEN))
        .with(Series::dashed("set point SP", &time[..], sp).colour(colour::BLACK));
    let below = Panel::new("time (s)", "OP, VP (%)")
        .with(Series::line("valve position VP", &time[..], vp).colour(colour::VERMILION))
        .with(Series::dashed("controller output OP", time, op).colour(colour::BLUE));
    Ok((Figure::new("").with(above).with(below), "With its start values: the undisturbed loop."))
}
