//! A fitted loop as a scenario for `simulate`, `limit-cycle`, `compensate`, `what-if` and `fmu`.

use stiction_diagnose::fit::Fit;
use stiction_diagnose::fusion::Estimate;
use stiction_diagnose::identify::controller::FittedController;
use stiction_diagnose::identify::process::FittedProcess;
use stiction_model::closed_loop::DerivativeOn;

/// Limit for the number of samples of the scenario.
const MOST_SAMPLES: f64 = 20_000.0;

/// The scenario of a fitted loop in TOML, with the source of each value. `duration_s` is the duration of the
/// recording.
///
/// # Errors
/// A sentence with the missing part of the loop, and the reason.
pub fn scenario(name: &str, fit: &Fit, duration_s: f64) -> Result<String, String> {
    let missing = |part: &str, why: Option<&str>| {
        format!("{name}: no scenario without a {part} ({})", why.unwrap_or("it is not identified"))
    };
    let controller =
        fit.controller.known().ok_or_else(|| missing("controller", fit.controller.why_not()))?;
    let process = fit.process.known().ok_or_else(|| missing("process", fit.process.why_not()))?;
    let valve = fit.valve.known().ok_or_else(|| missing("valve", fit.valve.why_not()))?;
    let likeliest = process.candidates.first().ok_or_else(|| missing("process", None))?;
    // Separate medians of S, J, gain and lag would make a loop that the recording does not support.
    let nearest = fit.cycle.known().and_then(|cycle| cycle.nearest.as_ref());
    let (s, j) = nearest.map_or((valve.s.value, valve.j.value.min(valve.s.value)), |draw| {
        (draw.bands.s(), draw.bands.j())
    });
    let [gain, lag_s, dead_time_s] =
        nearest.map_or([likeliest.gain, likeliest.lag_s, likeliest.dead_time_s], |draw| {
            // First order, or an integrator with this slope.
            let (above, below) = draw.process.coefficients();
            let gain = draw.lasting_gain().unwrap_or(above[0] / below[0]);
            [gain, below[0] / below[1], draw.process.dead_time()]
        });
    let sample = controller.execution_s.unwrap_or(fit.sample_time_s / 2.0);
    let samples = (duration_s / sample).clamp(100.0, MOST_SAMPLES).round();

    let mut out = Lines(String::new());
    let mut line = |text: String| out.line(text);
    line(format!("title = {:?}", format!("{name}, as fitted to its recording")));
    let known = match controller.execution_s {
        Some(_) => "execution interval of the controller",
        None => "half a sample, because the controller executes more often than the record shows",
    };
    line(format!("sample_time = {}  # s; {known}", float(sample)));
    line(format!("duration = {}  # s", float(samples * sample)));
    line("\n[operating_point]  # means of the recording".to_owned());
    line(format!("op = {}", float(fit.resting.op)));
    let set_point = controller.set_point.map_or(fit.resting.pv, |sp| sp.value);
    line(format!("pv = {}", float(set_point)));
    // At rest within its stick band the valve would stay there.
    let push = fit.cycle.known().and_then(|cycle| cycle.recorded).map_or_else(
        || (likeliest.gain.abs() * valve.s.value.max(1.0), 0.1 * samples * sample),
        |recorded| (2.0 * recorded.pv, recorded.period_s),
    );
    line("\n[set_point]  # one step, because a valve at rest would stay there".to_owned());
    line("signal = \"steps\"".to_owned());
    line(format!(
        "steps = [[0.0, {}], [{}, {}]]",
        float(set_point + push.0),
        float(push.1),
        float(set_point)
    ));
    write_controller(&mut out, controller);
    let mut line = |text: String| out.line(text);
    line(format!("\n[valve]  # by {}", valve.from));
    let model = nearest.map(|draw| draw.model.describe().name);
    let model = model.or(valve.model.as_deref()).unwrap_or("two-phase");
    line(format!("model = {model:?}"));
    line(format!("S = {}  # % of span; {}", float(s), between(&valve.s)));
    line(format!("J = {}  # % of span; {}", float(j), between(&valve.j)));
    write_process(&mut out, process, nearest.is_some(), [gain, lag_s, dead_time_s]);
    Ok(out.0)
}

/// Text, line by line.
struct Lines(String);

impl Lines {
    fn line(&mut self, text: String) {
        self.0 += &text;
        self.0.push('\n');
    }
}

fn write_controller(out: &mut Lines, controller: &FittedController) {
    let mut line = |text: String| out.line(text);
    line(format!(
        "\n[controller]  # {}, from OP, PV and SP; 90 % intervals",
        controller.structure.name()
    ));
    line(format!(
        "kc = {}  # % per PV unit; {}",
        float(controller.kc.value),
        between(&controller.kc)
    ));
    if let Some(ti) = &controller.ti_s {
        line(format!("ti = {}  # s; {}", float(ti.value), between(ti)));
    }
    if let Some(td) = &controller.td_s {
        line(format!("td = {}  # s; {}", float(td.value), between(td)));
    }
    if let Some(filter) = controller.filter_s {
        line(format!("filter = {}  # s", float(filter)));
    }
    if let Some(weight) = controller.set_point_weight.filter(|weight| *weight != 1.0) {
        line(format!("set_point_weight = {}", float(weight)));
    }
    if controller.derivative_on == Some(DerivativeOn::Error) {
        line("derivative_on = \"error\"".to_owned());
    }
    if controller.gap > 0.0 {
        line(format!("# the gap of ±{} PV units is not part of a scenario", float(controller.gap)));
    }
    let (low, high) = (controller.low.unwrap_or(0.0), controller.high.unwrap_or(100.0));
    let reached = if controller.low.or(controller.high).is_some() { "as reached" } else { "usual" };
    line(format!("limits = [{}, {}]  # {reached}", float(low), float(high)));
    line("handover = \"bumpless\"".to_owned());
}

/// The process with these values, which are the values `nearest` to the swing or the likeliest ones.
fn write_process(
    out: &mut Lines,
    process: &FittedProcess,
    nearest: bool,
    [gain, lag_s, dead_time_s]: [f64; 3],
) {
    let mut line = |text: String| out.line(text);
    let which = match nearest {
        true => {
            "the values nearest to the recorded swing, among those that explain the PV with this valve"
        }
        false => "the likeliest values that explain the PV with this valve",
    };
    line(format!("\n[process]  # {which}"));
    if lag_s.is_finite() {
        let known = process
            .gain
            .as_ref()
            .map_or("only the ratio of gain and lag is known".to_owned(), between);
        line(format!("gain = {}  # PV units per %; {known}", float(gain)));
        let known = process
            .lag_s
            .as_ref()
            .map_or("only the ratio of gain and lag is known".to_owned(), between);
        line(format!("tau = {}  # s; {known}", float(lag_s)));
    } else {
        line("type = \"integrator\"".to_owned());
        line(format!(
            "gain = {}  # PV units per % and s; {}",
            float(gain),
            between(&process.slope)
        ));
    }
    line(format!("delay = {}  # s; {}", float(dead_time_s), between(&process.dead_time_s)));
    line("\n[noise]  # random change of the PV from sample to sample".to_owned());
    line(format!("sd = {}", float(process.innovation_sd)));
}

/// Six digits, in the notation of TOML for a number that may be whole.
fn float(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

fn between(of: &Estimate) -> String {
    let three = |v: f64| {
        let rounded: f64 = format!("{v:.2e}").parse().unwrap_or(v);
        format!("{rounded}")
    };
    format!("{} to {}", three(of.low), three(of.high))
}
