//! The figures of the paper, drawn from the built-in scenarios.

use anyhow::{Result, bail};
use stiction::Bands;
use stiction::closed_loop::{CascadeRun, OpenLoopRun, Run};
use stiction::drawing::run;
use stiction::stem::{PressureSignal, Response, Sample, Stem, StemStart};
use stiction::valve::{Model, Start, TwoPhase, Valve};
use stiction_figure::figure::colour;
use stiction_figure::{Annotation, Figure, Legend, Panel, Series};
use stiction_io::scenario::{Scenario, System};

/// Title of the gallery.
pub const TITLE: &str = "Control-valve stiction: the paper's figures";

/// Introduction of the gallery.
pub const INTRODUCTION: &str = "This page shows simulations of every plotted figure of \u{201c}Modelling and Dynamic Analysis of \
    Pneumatic Control Valve with Stiction\u{201d}, and one that the paper lacks. The paper prints no values of S and \
    J, so the tables show ours. Process and controller are as printed in the paper. OP is the controller output and VP the valve \
    position, both in percent of span.";

/// A figure with its parameters.
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
    /// A command that simulates the same.
    pub command: String,
    /// The scenario and settings that the lab opens to animate the figure. `stem` among them means the physical
    /// valve.
    pub moving: (&'static str, Vec<String>),
}

/// A function that makes a figure.
pub type Make = fn() -> Result<Drawn>;

/// Scenario and settings of the paper's loop as in the figures.
const PAPER_LOOP: (&str, &[&str]) = ("paper/closed-loop", &["duration=120"]);

/// All figures, in the paper's order.
pub const FIGURES: &[Make] = &[
    figure_2,
    figure_3,
    figure_5,
    figure_6,
    figure_7,
    figure_8,
    figure_9,
    figure_10,
    figure_11,
    figure_13,
    figure_14,
    figure_15,
    figure_16,
    figure_17,
    figure_physical,
];

/// The command that draws a scenario with these settings.
fn simulate(scenario: &str, set: &[&str], name: &str) -> String {
    let set: String = set.iter().map(|each| format!(" --set {each}")).collect();
    format!("stiction simulate {scenario}{set} --plot {name}.svg")
}

fn drawn(
    name: &'static str,
    number: &str,
    scenario: &Scenario,
    figure: Figure,
    (source, set): (&'static str, &[&str]),
) -> Drawn {
    let parameters = scenario.settings();
    Drawn {
        name,
        heading: format!("Figure {number}: {}", figure.title),
        figure,
        parameters: parameters.into_iter().map(|(k, v, u)| (k, v, u.to_owned())).collect(),
        command: simulate(source, set, name),
        moving: (source, set.iter().map(|&each| each.to_owned()).collect()),
    }
}

/// The slave of a cascade as a separate loop, at its final set point.
fn slave_alone(scenario: &Scenario) -> (&'static str, Vec<String>) {
    let settings = scenario.settings().into_iter().map(|(key, value, _)| (key, value));
    let own = settings.filter(|(key, _)| {
        !["master", "duration", "set_point"].contains(&key.split('.').next().unwrap_or_default())
    });
    let mut set: Vec<String> = own.map(|(key, value)| format!("{key}={value}")).collect();
    set.push("set_point.value=44".to_owned());
    ("lab/flow", set)
}

/// The built-in scenario `name`, and its valve on a test signal.
fn open_loop(name: &str) -> Result<(Scenario, OpenLoopRun)> {
    let scenario = Scenario::open(name, &[])?;
    match &scenario.system {
        System::OpenLoop(system) => {
            let done = system.run()?;
            Ok((scenario, done))
        }
        _ => bail!("{name} is not a valve on a test signal"),
    }
}

/// The paper's loop over its first two minutes.
fn closed_loop() -> Result<(Scenario, Run)> {
    let (name, set) = PAPER_LOOP;
    let set: Vec<String> = set.iter().map(|&each| each.to_owned()).collect();
    let scenario = Scenario::open(name, &set)?;
    match &scenario.system {
        System::ClosedLoop(system) => {
            let done = system.run()?;
            Ok((scenario, done))
        }
        _ => bail!("{name} is not a closed loop"),
    }
}

fn cascade() -> Result<(Scenario, CascadeRun)> {
    let scenario = Scenario::open("paper/flow-cascade", &[])?;
    match &scenario.system {
        System::Cascade(system) => {
            let done = system.run()?;
            Ok((scenario, done))
        }
        _ => bail!("paper/flow-cascade is not a cascade"),
    }
}

/// The stem of parameter set `name` on a slow triangle from 0 to 100 % in 200 s, with times and response.
fn slow_triangle(name: &str) -> Result<(Stem, Vec<f64>, Response)> {
    let stem = Stem::named(name)?;
    let pressure = |op| stem.parameters().pressure_pa(op);
    let points = vec![(0.0, pressure(0.0)), (100.0, pressure(100.0)), (200.0, pressure(0.0))];
    let times = run::times(8_001, 0.025);
    let response =
        stem.simulate(&PressureSignal::from_points(points)?, StemStart::at_rest(0.0), &times)?;
    Ok((stem, times, response))
}

/// Parameters of a stem, for the gallery.
fn stem_parameters(name: &str, stem: &Stem) -> Vec<(String, String, String)> {
    let p = stem.parameters();
    let own = [
        ("mass", p.mass_kg, "kg"),
        ("spring", p.spring_n_per_m, "N/m"),
        ("diaphragm area", p.area_m2, "m2"),
        ("stroke", p.stroke_m, "m"),
    ];
    let of = |what: &str| format!("{name}: {what}");
    let own = own.map(|(what, value, unit)| (of(what), value.to_string(), unit.to_owned()));
    let law = stem.friction().values().into_iter();
    let friction = law.map(|(what, value)| (of(what), value.to_string(), String::new()));
    own.into_iter().chain(friction).collect()
}

/// Figure 2: the spring force while the stem moves in steps.
fn figure_2() -> Result<Drawn> {
    let name = "cts-stribeck";
    let (stem, times, response) = slow_triangle(name)?;
    let force = |s: &Sample| stem.parameters().net_force_n(s.pressure_pa, s.position_m);
    let shown: Vec<usize> =
        (0..times.len()).filter(|k| (30.0..=60.0).contains(&times[*k])).collect();
    let t: Vec<f64> = shown.iter().map(|k| times[*k]).collect();
    let forces: Vec<f64> = shown.iter().map(|k| force(&response.samples[*k])).collect();
    let (fs, fc) = (stem.friction().static_n(), stem.friction().coulomb_n());
    let at = |time: f64| {
        let k = t.iter().position(|t| *t >= time).unwrap_or(0);
        (t[k], forces[k])
    };
    let slips: Vec<f64> = response.slips().map(|e| e.time_s).take(3).collect();
    let stops: Vec<f64> = response.stops().map(|e| e.time_s).take(3).collect();
    let (a, b, c) = (at(31.5), (slips[0], fs), at(stops[0] + 0.025));
    let (d, e) = ((slips[1], fs), at(stops[1] + 0.025));
    let panel = Panel::new("time (s)", "spring force on the stem (N)")
        .with(Series::line("spring force", &t[..], &forces[..]).colour(colour::VERMILION))
        .note(Annotation::horizontal_line(fs, "static friction Fs"))
        .note(Annotation::horizontal_line(fc, "Coulomb friction Fc"))
        .note(Annotation::text("a", (a.0 - 0.5, a.1 + 8.0)))
        .note(Annotation::text("b", (b.0 - 0.4, b.1 + 14.0)))
        .note(Annotation::text("c", (c.0 + 0.4, c.1 - 14.0)))
        .note(Annotation::text("d", (d.0 - 0.4, d.1 + 14.0)))
        .note(Annotation::text("e", (e.0 + 0.4, e.1 - 14.0)))
        .x_range(30.0, 60.0)
        .y_range(fc - 120.0, fs + 60.0);
    let figure = Figure::new("Force profile during stiction")
        .caption(
            "The force rises while the stem sticks (a-b), falls as the stem slips at Fs (b-c), and rises again \
             (c-d-e). This is the stick-slip of a physical valve on a slow ramp.",
        )
        .with(panel);
    Ok(Drawn {
        name: "figure-02-force-profile",
        heading: "Figure 2: Force profile during stiction".to_owned(),
        figure,
        parameters: stem_parameters(name, &stem),
        command: format!(
            "stiction stem --parameters {name} --period 200 --duration 200 --sample-time 0.025 -o stem.csv --events slips.csv"
        ),
        moving: ("lab/flow", vec!["stem".to_owned()]),
    })
}

/// A figure that the paper lacks, with its data-driven model beside the corresponding physical one.
fn figure_physical() -> Result<Drawn> {
    let mut figure = Figure::new("Data-driven against physical model on the same input")
        .caption(
            "If static friction acts only at rest, the stem slides as in the two-phase model (left). If friction \
             falls with velocity, the stem moves in steps, as in He's model (right).",
        )
        .columns(2)
        .width(1000.0);
    let mut parameters = vec![];
    for (name, title, model) in [
        ("cts", "static friction only at rest", Model::TwoPhase),
        ("cts-stribeck", "Stribeck friction", Model::He),
    ] {
        let (stem, _, response) = slow_triangle(name)?;
        let p = stem.parameters();
        // The position of the stem without friction, in percent of stroke.
        let demand: Vec<f64> = response
            .samples
            .iter()
            .map(|s| p.percent(p.net_force_n(s.pressure_pa, 0.0) / p.spring_n_per_m))
            .collect();
        let physical: Vec<f64> = response.samples.iter().map(|s| p.percent(s.position_m)).collect();
        let bands = stem.equivalent()?.bands;
        let mut valve = model.build(bands)?;
        let mut vp = vec![0.0; demand.len()];
        valve.run(&demand, &mut vp)?;
        let label = format!("{} model", model.describe().name);
        figure = figure.with(
            Panel::new("position without friction (% of stroke)", "stem position (% of stroke)")
                .title(title)
                .with(Series::line("physical stem", &demand[..], physical).colour(colour::SKY))
                .with(Series::dashed(&label, &demand[..], vp).colour(colour::VERMILION)),
        );
        let unit = "% of stroke".to_owned();
        parameters.extend(stem_parameters(name, &stem));
        parameters.push((format!("{label}: S"), format!("{:.3}", bands.s()), unit.clone()));
        parameters.push((format!("{label}: J"), format!("{:.3}", bands.j()), unit));
    }
    Ok(Drawn {
        name: "figure-18-data-driven-and-physical",
        heading: "Data-driven against physical model".to_owned(),
        figure,
        parameters,
        command: "stiction stem --parameters cts --period 200 --duration 200 --sample-time 0.025 -o cts.csv\n\
            stiction stem --parameters cts-stribeck --period 200 --duration 200 --sample-time 0.025 -o cts-stribeck.csv"
            .to_owned(),
        moving: ("lab/flow", vec!["stem".to_owned()]),
    })
}

/// Figure 3: input against position, with the bands marked.
fn figure_3() -> Result<Drawn> {
    let (s, j) = (10.0, 4.0);
    let bands = Bands::from_s_j(s, j)?;
    // The signal moves up, down, and up again with a pause. The figure begins at the upper turning point.
    let (low, high, pause) = (30.0, 70.0, 52.0);
    let leg = |from: f64, to: f64| {
        let n = (f64::abs(to - from) / 0.02).round() as usize;
        (0..n).map(move |k| from + (to - from) * k as f64 / n as f64).collect::<Vec<_>>()
    };
    let first = leg(50.0, high);
    let pausing = vec![pause, pause];
    let legs = [first.clone(), leg(high, low), leg(low, pause), pausing, leg(pause, high)];
    let op = legs.concat();
    let mut valve = TwoPhase::new(bands);
    valve.restart(Start::at_rest(50.0));
    let mut vp = vec![0.0; op.len()];
    valve.run(&op, &mut vp)?;
    let (op, vp) = (&op[first.len()..], &vp[first.len()..]);

    let level = low + bands.fd();
    let (a, b, c) = ((low, level), (low + s - j, level), (low + s, level));
    let d = (low + s, level + j);
    let e = (pause, pause - bands.fd());
    let f = (pause + j, e.1);
    let panel = Panel::new("controller output OP (% of span)", "valve position VP (% of span)")
        .with(Series::line("sticking valve", op, vp).colour(colour::VERMILION))
        .with(
            Series::dotted("valve without friction", [26.0, 74.0], [26.0, 74.0])
                .colour(colour::BLACK),
        )
        .note(Annotation::dimension(a, b, "dead band", -18.0))
        .note(Annotation::dimension(b, c, "stick band", -46.0))
        .note(Annotation::dimension(a, c, "S", -74.0))
        .note(Annotation::dimension(c, d, "slip jump J", 26.0))
        .note(Annotation::arrow("moving phase", (53.0, 40.0), (45.5, 45.5 - bands.fd())))
        .note(Annotation::arrow("only J after a pause", (60.0, 44.5), (f.0 - 1.0, f.1)))
        .note(Annotation::text("A", (a.0 - 1.2, a.1)))
        .note(Annotation::text("B", (b.0, b.1 + 1.2)))
        .note(Annotation::text("C", (c.0 - 1.2, c.1 + 1.2)))
        .note(Annotation::text("D", (d.0 - 1.0, d.1 + 1.0)))
        .note(Annotation::text("E", (e.0 - 0.6, e.1 + 1.4)))
        .note(Annotation::text("F", (f.0 + 1.2, f.1)))
        .note(Annotation::text("G", (high + 1.2, high - bands.fd())))
        .x_range(24.0, 76.0)
        .y_range(24.0, 76.0)
        .equal_aspect()
        .legend(Legend::TopLeft);
    let figure = Figure::new("Typical behaviour of a sticking valve")
        .caption(
            "After a reversal the input must cross dead band and stick band (A to C) before the stem jumps by J (C \
             to D) and moves (D to E). After a pause in the same direction the input must cross only the stick band \
             (E to F).",
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
        command: simulate(
            "paper/open-loop-stiction",
            &[&format!("valve.S={s}"), &format!("valve.J={j}"), "input.amplitude=20"],
            "figure-03-typical-behaviour",
        ),
        moving: (
            "paper/open-loop-stiction",
            vec![format!("valve.S={s}"), format!("valve.J={j}"), "input.amplitude=20".to_owned()],
        ),
    })
}

fn figure_5() -> Result<Drawn> {
    let (scenario, done) = open_loop("paper/open-loop-linear")?;
    let figure = run::open_loop("Valve behaviour in the absence of stiction", &done)
        .caption("Without friction the position follows a periodic ramp exactly.");
    Ok(drawn("figure-05-no-stiction", "5", &scenario, figure, ("paper/open-loop-linear", &[])))
}

fn figure_6() -> Result<Drawn> {
    let (scenario, done) = open_loop("paper/step-linear")?;
    let figure = step_figure("Step response of the valve in the absence of stiction", &done)
        .caption("With a first-order stem lag the step response has no offset.");
    Ok(drawn("figure-06-step-no-stiction", "6", &scenario, figure, ("paper/step-linear", &[])))
}

fn figure_7() -> Result<Drawn> {
    let (scenario, done) = open_loop("paper/open-loop-deadband")?;
    let figure = run::open_loop("Valve with dead band", &done).caption(
        "With J = 0 the position waits at every reversal until the input has crossed the dead band S. It does not \
         jump.",
    );
    Ok(drawn("figure-07-dead-band", "7", &scenario, figure, ("paper/open-loop-deadband", &[])))
}

fn figure_8() -> Result<Drawn> {
    let (scenario, done) = open_loop("paper/open-loop-stiction")?;
    let figure = run::open_loop("Valve with stiction and dead band", &done)
        .caption("With J above 0 the stem jumps by J when it breaks away at every reversal.");
    Ok(drawn("figure-08-stiction", "8", &scenario, figure, ("paper/open-loop-stiction", &[])))
}

fn figure_9() -> Result<Drawn> {
    let (scenario, done) = open_loop("paper/step-stiction")?;
    let figure = step_figure("Step response of a valve under stiction and dead band", &done)
        .caption("The stem stops short of the input by the dynamic friction band fd = (S - J)/2.");
    Ok(drawn("figure-09-step-stiction", "9", &scenario, figure, ("paper/step-stiction", &[])))
}

fn figure_10() -> Result<Drawn> {
    let (scenario, done) = open_loop("paper/open-loop-high")?;
    let n = (60.0 / done.sample_time) as usize;
    let t = run::times(n, done.sample_time);
    let panel = Panel::new("time (s)", "OP, VP (% of span)")
        .with(Series::line("valve position VP", &t[..], &done.vp[..n]).colour(colour::VP))
        .with(Series::dashed("controller output OP", &t[..], &done.op[..n]).colour(colour::OP));
    let figure = Figure::new("Jumpy valve movement due to stiction")
        .caption("Under high stiction a slow ramp moves the stem in jumps, with stops in between.")
        .with(panel);
    Ok(drawn("figure-10-jumpy-movement", "10", &scenario, figure, ("paper/open-loop-high", &[])))
}

fn figure_11() -> Result<Drawn> {
    let (scenario, done) = open_loop("paper/open-loop-high")?;
    let figure = run::open_loop("Valve response in the presence of high stiction", &done).caption(
        "Position over input is a staircase, with flats of S at a reversal, then jumps of J.",
    );
    Ok(drawn("figure-11-high-stiction", "11", &scenario, figure, ("paper/open-loop-high", &[])))
}

fn figure_13() -> Result<Drawn> {
    let (scenario, done) = closed_loop()?;
    let figure = run::closed_loop("Closed-loop response in the presence of stiction", &done)
        .caption("The loop cycles, with rectangular valve movement and triangular OP and PV.");
    Ok(drawn("figure-13-closed-loop", "13", &scenario, figure, PAPER_LOOP))
}

/// The last two thirds of a run, past its beginning.
fn settled(signal: &[f64]) -> &[f64] {
    &signal[signal.len() / 3..]
}

fn figure_14() -> Result<Drawn> {
    let (scenario, done) = closed_loop()?;
    let panel = Panel::new("controller output OP (% of span)", "valve position VP (% of span)")
        .with(Series::line("VP", settled(&done.op), settled(&done.vp)).colour(colour::VP))
        .equal_aspect();
    let figure = Figure::new("Controller output against valve position")
        .caption("The map shows only the valve, with flats while the stem sticks, and jumps of J.")
        .width(640.0)
        .panel_height(460.0)
        .with(panel);
    Ok(drawn("figure-14-op-vp", "14", &scenario, figure, PAPER_LOOP))
}

fn figure_15() -> Result<Drawn> {
    let (scenario, done) = closed_loop()?;
    let figure = op_pv_figure("Controller output against process output", &done).caption(
        "Through the process the parallelogram becomes an ellipse with sharp turning points.",
    );
    Ok(drawn("figure-15-op-pv", "15", &scenario, figure, PAPER_LOOP))
}

fn figure_16() -> Result<Drawn> {
    let (scenario, done) = cascade()?;
    let title = "Step response of a flow loop with stiction, the slave of a temperature loop";
    let mut figure = run::cascade(title, &done).caption(
        "A simulated laboratory flow loop with 1,100 samples of 0.01 s. The temperature set point steps at 1 s, and \
         the flow follows and cycles.",
    );
    for (panel, label) in figure.panels.iter_mut().zip(["temperature (degrees)", "flow (%)"]) {
        panel.y_label = label.to_owned();
    }
    let moving = slave_alone(&scenario);
    let drawn = drawn("figure-16-flow-step", "16", &scenario, figure, ("paper/flow-cascade", &[]));
    Ok(Drawn { moving, ..drawn })
}

fn figure_17() -> Result<Drawn> {
    let (scenario, done) = cascade()?;
    let mut figure =
        op_pv_figure("Controller output against flow of the laboratory loop", &done.slave).caption(
            "The map has sharp turning points, like that of the simulated loop in Figure 15.",
        );
    figure.panels[0].y_label = "flow (%)".to_owned();
    let moving = slave_alone(&scenario);
    let drawn = drawn("figure-17-flow-op-pv", "17", &scenario, figure, ("paper/flow-cascade", &[]));
    Ok(Drawn { moving, ..drawn })
}

/// OP and VP over time.
fn step_figure(title: &str, done: &OpenLoopRun) -> Figure {
    let t = run::times(done.op.len(), done.sample_time);
    let panel = Panel::new("time (s)", "OP, VP (% of span)")
        .with(Series::line("valve position VP", &t[..], &done.vp[..]).colour(colour::VP))
        .with(Series::dashed("controller output OP", &t[..], &done.op[..]).colour(colour::OP))
        .legend(Legend::BottomRight);
    Figure::new(title).with(panel)
}

/// PV against OP, past the beginning.
fn op_pv_figure(title: &str, done: &Run) -> Figure {
    let panel = Panel::new("controller output OP (% of span)", "PV (units of the PV)")
        .with(Series::line("PV", settled(&done.op), settled(&done.pv)).colour(colour::PV));
    Figure::new(title).width(640.0).panel_height(460.0).with(panel)
}
