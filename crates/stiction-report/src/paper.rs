//! The figures of the paper, drawn from the built-in scenarios.

use crate::error::Error;
use crate::figure::{Annotation, Figure, Legend, Panel, Series, colour};
use crate::run;
use stiction::Bands;
use stiction::closed_loop::{CascadeRun, OpenLoopRun, Run};
use stiction::valve::{Start, TwoPhase, Valve};
use stiction_io::scenario::{Scenario, System};

/// Title of the gallery.
pub const TITLE: &str = "Control-valve stiction: the paper's figures";

/// What the gallery shows.
pub const INTRODUCTION: &str = "Every figure with a plot of \u{201c}Modelling and Dynamic Analysis of \
    Pneumatic Control Valve with Stiction\u{201d}, and one it lacks, simulated. The paper prints no \
    values of S and J, so those in the tables are ours; its process and controller are as printed. \
    OP is the controller output and VP the valve position, both in percent of span.";

/// The tool and its version, for the foot of a page.
pub fn tool() -> &'static str {
    concat!("stiction ", env!("CARGO_PKG_VERSION"))
}

/// A figure with what was needed to make it.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Name of its files, without extension.
    pub name: &'static str,
    /// Heading in the gallery.
    pub heading: String,
    /// The figure; its caption is one line.
    pub figure: Figure,
    /// Name, value and unit of every parameter.
    pub parameters: Vec<(String, String, String)>,
}

/// Makes a figure.
pub type Make = fn() -> Result<Drawn, Error>;

/// All figures, in the paper's order.
pub const FIGURES: &[Make] = &[
    figure_3, figure_5, figure_6, figure_7, figure_8, figure_9, figure_10, figure_11, figure_13,
    figure_14, figure_15, figure_16, figure_17,
];

fn drawn(name: &'static str, number: &str, scenario: &Scenario, figure: Figure) -> Drawn {
    let parameters = scenario.settings();
    Drawn {
        name,
        heading: format!("Figure {number}: {}", figure.title),
        figure,
        parameters: parameters.into_iter().map(|(k, v, u)| (k, v, u.to_owned())).collect(),
    }
}

/// The built-in scenario `name` and its valve on a test signal.
fn open_loop(name: &str) -> Result<(Scenario, OpenLoopRun), Error> {
    let scenario = Scenario::open(name, &[])?;
    match &scenario.system {
        System::OpenLoop(system) => {
            let done = system.run()?;
            Ok((scenario, done))
        }
        _ => Err(Error::Scenario(format!("{name} is not a valve on a test signal"))),
    }
}

/// The paper's loop over its first `duration` seconds.
fn closed_loop(duration: f64) -> Result<(Scenario, Run), Error> {
    let set = [format!("duration={duration}")];
    let scenario = Scenario::open("paper/closed-loop", &set)?;
    match &scenario.system {
        System::ClosedLoop(system) => {
            let done = system.run()?;
            Ok((scenario, done))
        }
        _ => Err(Error::Scenario("paper/closed-loop is not a closed loop".to_owned())),
    }
}

fn cascade() -> Result<(Scenario, CascadeRun), Error> {
    let scenario = Scenario::open("paper/flow-cascade", &[])?;
    match &scenario.system {
        System::Cascade(system) => {
            let done = system.run()?;
            Ok((scenario, done))
        }
        _ => Err(Error::Scenario("paper/flow-cascade is not a cascade".to_owned())),
    }
}

/// Figure 3: input against position, with the bands marked.
fn figure_3() -> Result<Drawn, Error> {
    let (s, j) = (5.0, 2.0);
    let bands = Bands::from_s_j(s, j)?;
    // Down to the left end, up and through the middle, back: one loop from turning point to
    // turning point, with a pause on the way up.
    let pause = 52.0;
    let leg = |from: f64, to: f64| {
        let n = ((to - from).abs() / 0.02).round() as usize;
        (0..n).map(move |k| from + (to - from) * k as f64 / n as f64).collect::<Vec<_>>()
    };
    let op: Vec<f64> = [leg(50.0, 60.0), leg(60.0, 40.0), leg(40.0, pause)]
        .concat()
        .into_iter()
        .chain([pause, pause])
        .chain(leg(pause, 60.0))
        .collect();
    let mut valve = TwoPhase::new(bands);
    valve.restart(Start::at_rest(50.0));
    let mut vp = vec![0.0; op.len()];
    valve.run(&op, &mut vp)?;
    // From the upper turning point on, the start no longer matters.
    let from = leg(50.0, 60.0).len();
    let (op, vp) = (&op[from..], &vp[from..]);

    let low = 40.0 + bands.fd();
    let (a, b, c) = ((40.0, low), (40.0 + s - j, low), (40.0 + s, low));
    let d = (40.0 + s, low + j);
    let at_pause = pause - bands.fd();
    let panel = Panel::new("controller output OP (% of span)", "valve position VP (% of span)")
        .with(Series::line("sticking valve", op, vp).colour(colour::VERMILION))
        .with(
            Series::dotted("valve without friction", [38.0, 62.0], [38.0, 62.0])
                .colour(colour::BLACK),
        )
        .note(Annotation::dimension(a, b, "dead band", -22.0))
        .note(Annotation::dimension(b, c, "stick band", -22.0))
        .note(Annotation::dimension(a, c, "S", -52.0))
        .note(Annotation::dimension(c, d, "slip jump J", 26.0))
        .note(Annotation::arrow("moving phase", (53.0, 46.5), (49.0, 49.0 - bands.fd())))
        .note(Annotation::arrow(
            "pause: stuck again, only J to overcome",
            (52.5, 44.0),
            (pause + j / 2.0, at_pause),
        ))
        .note(Annotation::text("A", (39.5, low + 0.7)))
        .note(Annotation::text("B", (b.0, low + 0.7)))
        .note(Annotation::text("C", (c.0 - 0.4, low + 0.7)))
        .note(Annotation::text("D", (d.0 - 0.5, d.1 + 0.4)))
        .note(Annotation::text("E", (pause - 0.6, at_pause + 0.5)))
        .note(Annotation::text("F", (pause + j + 0.5, at_pause - 0.5)))
        .note(Annotation::text("G", (60.4, 60.0 - bands.fd() + 0.4)))
        .x_range(37.0, 63.0)
        .y_range(37.0, 63.0)
        .equal_aspect()
        .legend(Legend::TopLeft);
    let figure = Figure::new("Typical behaviour of a sticking valve")
        .caption(
            "After a reversal the input must cross dead band and stick band (A to C) before the \
             stem jumps by J (C to D) and moves (D to E); after a pause in the same direction it \
             must cross the stick band only (E to F).",
        )
        .width(760.0)
        .panel_height(560.0)
        .with(panel);
    let unit = "% of span".to_owned();
    Ok(Drawn {
        name: "figure-03-typical-behaviour",
        heading: "Figure 3: Typical behaviour of a sticking valve".to_owned(),
        figure,
        parameters: vec![
            ("valve.model".to_owned(), "\"two-phase\"".to_owned(), String::new()),
            ("valve.S".to_owned(), s.to_string(), unit.clone()),
            ("valve.J".to_owned(), j.to_string(), unit),
        ],
    })
}

fn figure_5() -> Result<Drawn, Error> {
    let (scenario, done) = open_loop("paper/open-loop-linear")?;
    let figure = run::open_loop("Valve behaviour in the absence of stiction", &done)
        .caption("Without friction the position follows a periodic ramp exactly.");
    Ok(drawn("figure-05-no-stiction", "5", &scenario, figure))
}

fn figure_6() -> Result<Drawn, Error> {
    let (scenario, done) = open_loop("paper/step-linear")?;
    let figure = step_figure("Step response of the valve in the absence of stiction", &done)
        .caption("With a first-order stem lag the step response has no offset.");
    Ok(drawn("figure-06-step-no-stiction", "6", &scenario, figure))
}

fn figure_7() -> Result<Drawn, Error> {
    let (scenario, done) = open_loop("paper/open-loop-deadband")?;
    let figure = run::open_loop("Valve with dead band", &done).caption(
        "With J = 0 the position waits for the input to cross the dead band S at every reversal, \
         and does not jump.",
    );
    Ok(drawn("figure-07-dead-band", "7", &scenario, figure))
}

fn figure_8() -> Result<Drawn, Error> {
    let (scenario, done) = open_loop("paper/open-loop-stiction")?;
    let figure = run::open_loop("Valve with stiction and dead band", &done)
        .caption("With J above 0 the stem jumps by J as it breaks away at every reversal.");
    Ok(drawn("figure-08-stiction", "8", &scenario, figure))
}

fn figure_9() -> Result<Drawn, Error> {
    let (scenario, done) = open_loop("paper/step-stiction")?;
    let figure = step_figure("Step response of a valve under stiction and dead band", &done)
        .caption("The stem stops short of the input by the dynamic friction band fd = (S - J)/2.");
    Ok(drawn("figure-09-step-stiction", "9", &scenario, figure))
}

fn figure_10() -> Result<Drawn, Error> {
    let (scenario, done) = open_loop("paper/open-loop-high")?;
    let n = (60.0 / done.sample_time) as usize;
    let t = run::times(n, done.sample_time);
    let panel = Panel::new("time (s)", "OP, VP (% of span)")
        .with(Series::line("valve position VP", &t[..], &done.vp[..n]).colour(colour::VERMILION))
        .with(Series::dashed("controller output OP", &t[..], &done.op[..n]).colour(colour::BLUE));
    let figure = Figure::new("Jumpy valve movement due to stiction")
        .caption("Under high stiction a slow ramp moves the stem in jumps, with stops in between.")
        .with(panel);
    Ok(drawn("figure-10-jumpy-movement", "10", &scenario, figure))
}

fn figure_11() -> Result<Drawn, Error> {
    let (scenario, done) = open_loop("paper/open-loop-high")?;
    let figure = run::open_loop("Valve response in the presence of high stiction", &done).caption(
        "Position against input is a staircase: flats of S at a reversal, then jumps of J.",
    );
    Ok(drawn("figure-11-high-stiction", "11", &scenario, figure))
}

fn figure_13() -> Result<Drawn, Error> {
    let (scenario, done) = closed_loop(120.0)?;
    let figure = run::closed_loop("Closed-loop response in the presence of stiction", &done)
        .caption("The loop cycles: rectangular valve movement, triangular OP and PV.");
    Ok(drawn("figure-13-closed-loop", "13", &scenario, figure))
}

/// The last two thirds of a run, past its beginning.
fn settled(signal: &[f64]) -> &[f64] {
    &signal[signal.len() / 3..]
}

fn figure_14() -> Result<Drawn, Error> {
    let (scenario, done) = closed_loop(120.0)?;
    let panel = Panel::new("controller output OP (% of span)", "valve position VP (% of span)")
        .with(Series::line("VP", settled(&done.op), settled(&done.vp)).colour(colour::VERMILION))
        .equal_aspect();
    let figure = Figure::new("Controller output against valve position")
        .caption("The map shows the valve alone: flats while it sticks, jumps of J.")
        .width(640.0)
        .panel_height(460.0)
        .with(panel);
    Ok(drawn("figure-14-op-vp", "14", &scenario, figure))
}

fn figure_15() -> Result<Drawn, Error> {
    let (scenario, done) = closed_loop(120.0)?;
    let figure = op_pv_figure("Controller output against process output", &done).caption(
        "Seen through the process the parallelogram becomes an ellipse with sharp turning points.",
    );
    Ok(drawn("figure-15-op-pv", "15", &scenario, figure))
}

fn figure_16() -> Result<Drawn, Error> {
    let (scenario, done) = cascade()?;
    let figure = run::cascade(
        "Step response of a flow loop with stiction, slave of a temperature",
        &done,
    )
    .caption(
        "A simulated laboratory flow loop: 1,100 samples of 0.01 s; the temperature steps at \
             1 s, the flow follows and cycles.",
    );
    Ok(drawn("figure-16-flow-step", "16", &scenario, figure))
}

fn figure_17() -> Result<Drawn, Error> {
    let (scenario, done) = cascade()?;
    let figure = op_pv_figure("Controller output against flow of the laboratory loop", &done.slave)
        .caption("The recorded loop's map resembles that of the simulated one in Figure 15.");
    Ok(drawn("figure-17-flow-op-pv", "17", &scenario, figure))
}

/// OP and VP over time.
fn step_figure(title: &str, done: &OpenLoopRun) -> Figure {
    let t = run::times(done.op.len(), done.sample_time);
    let panel = Panel::new("time (s)", "OP, VP (% of span)")
        .with(Series::line("valve position VP", &t[..], &done.vp[..]).colour(colour::VERMILION))
        .with(Series::dashed("controller output OP", &t[..], &done.op[..]).colour(colour::BLUE))
        .legend(Legend::BottomRight);
    Figure::new(title).with(panel)
}

/// PV against OP, past the beginning.
fn op_pv_figure(title: &str, done: &Run) -> Figure {
    let panel = Panel::new("controller output OP (% of span)", "PV (units of the PV)")
        .with(Series::line("PV", settled(&done.op), settled(&done.pv)).colour(colour::GREEN));
    Figure::new(title).width(640.0).panel_height(460.0).with(panel)
}
