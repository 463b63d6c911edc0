//! The arguments of `stiction limit-cycle`.

use crate::files::Out;
use crate::valve;
use anyhow::{Context, Result, bail, ensure};
use clap::{Parser, ValueEnum};
use stiction::Bands;
use stiction::closed_loop::{Controller, Process};
use stiction::drawing::limit_cycle::Quantity;
use stiction::limit_cycle::map::{Axis, Parameter};
use stiction::limit_cycle::{ContinuousLoop, Method, tuning};
use stiction::valve::Model;

/// Predict the limit cycle of a loop with a sticking valve, exactly and by describing function.
///
/// The loop is a scenario, or flags describe it. The prediction holds in continuous time, at the last set point and
/// load, without noise and far from the limits of the OP. If the loop does not cycle, the command reports the reason.
/// docs/limit-cycles.md explains the numbers.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction limit-cycle paper/closed-loop --set valve.J=2 --plot cycle.svg
  stiction limit-cycle --gain 1.5 --tau 5.93 --dead-time 1.07 --kc 1.1 --ti 2.5 --S 5 --J 3 --retune
  stiction limit-cycle paper/closed-loop --map S=1:10:200 J=0:6:200 --show period --plot map.png
  stiction limit-cycle choudhury/level --all --sensitivity --json")]
pub struct Args {
    /// Name of a built-in scenario, or a TOML file
    #[arg(required_unless_present_any = ["gain", "kc"])]
    pub scenario: Option<String>,
    /// Change a key of the scenario, such as valve.S=4; may be given several times
    #[arg(long, value_name = "KEY=VALUE", requires = "scenario")]
    pub set: Vec<String>,
    #[command(flatten)]
    pub flags: Flags,
    /// Use only the exact method
    #[arg(long)]
    exact: bool,
    /// Use only the describing function; with --exact, both are used, as by default
    #[arg(long)]
    describing_function: bool,
    /// Show every cycle found, even unstable ones, and other final states of the loop
    #[arg(long)]
    pub all: bool,
    /// Map the cycles over two of S, J, J/S, Kc, Ti, Kp, theta, tau, theta/tau, each as
    /// NAME=FROM:TO or NAME=FROM:TO:POINTS
    #[arg(long, num_args = 2, value_names = ["X", "Y"])]
    map: Option<Vec<String>>,
    /// The quantity that the picture of the map shows
    #[arg(long, value_enum, default_value = "pv", requires = "map")]
    pub show: Show,
    /// Write the map, or the exact cycle over one period, to this CSV file; - is standard output
    #[arg(long, value_name = "FILE")]
    pub csv: Option<Out>,
    /// Draw the map, or the exact cycle over time, to this file, .svg or .png
    #[arg(long, value_name = "FILE")]
    pub plot: Option<Out>,
    /// Draw the loop's frequency response and -1/N(X) of its valve to this file, .svg or .png
    #[arg(long, value_name = "FILE")]
    pub nyquist: Option<Out>,
    /// Show the change of the cycle in percent per percent of each parameter
    #[arg(long)]
    pub sensitivity: bool,
    /// Find the robust PI tuning with the smallest swing of the PV, and its cost
    #[arg(long)]
    pub retune: bool,
    /// Largest peak of the sensitivity function that --retune allows
    #[arg(long, default_value_t = tuning::PEAK_SENSITIVITY, requires = "retune")]
    pub ms: f64,
    /// Print the results as JSON
    #[arg(long)]
    pub json: bool,
}

/// A loop given by flags.
#[derive(clap::Args)]
#[group(id = "loop", multiple = true, conflicts_with = "scenario")]
pub struct Flags {
    /// Gain of the process, PV units per percent; of an integrating process, per percent and second
    #[arg(long, value_name = "GAIN", allow_negative_numbers = true)]
    gain: Option<f64>,
    /// Time constant of the process, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    tau: Option<f64>,
    /// Second time constant, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    tau2: Option<f64>,
    /// The process integrates
    #[arg(long, conflicts_with = "tau2")]
    integrating: bool,
    /// Dead time of the process, s [default: 0]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    dead_time: Option<f64>,
    /// Gain of the controller, percent per PV unit
    #[arg(long, value_name = "GAIN", allow_negative_numbers = true)]
    kc: Option<f64>,
    /// Integral time, s [default: no integral action]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    ti: Option<f64>,
    /// Derivative time, s; the time constant of the filter is a tenth of the derivative time
    #[arg(long, value_name = "S", requires = "ti", allow_negative_numbers = true)]
    td: Option<f64>,
    /// Name of the valve model [default: two-phase]
    #[arg(long, value_name = "NAME")]
    model: Option<String>,
    /// Stick band plus dead band, percent of span
    #[arg(long = "S", value_name = "PERCENT", allow_negative_numbers = true)]
    s: Option<f64>,
    /// Slip jump, percent of span
    #[arg(long = "J", value_name = "PERCENT", allow_negative_numbers = true)]
    j: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Show {
    Period,
    Op,
    Vp,
    Pv,
}

impl Show {
    /// The quantity as the picture names it.
    pub fn quantity(self) -> Quantity {
        match self {
            Self::Period => Quantity::Period,
            Self::Op => Quantity::Op,
            Self::Vp => Quantity::Vp,
            Self::Pv => Quantity::Pv,
        }
    }
}

impl Args {
    /// The methods, the exact one first.
    pub fn methods(&self) -> Vec<Method> {
        match (self.exact, self.describing_function) {
            (true, false) => vec![Method::Exact],
            (false, true) => vec![Method::DescribingFunction],
            _ => vec![Method::Exact, Method::DescribingFunction],
        }
    }

    /// The axes of the map, if one is requested.
    pub fn axes(&self) -> Result<Option<(Axis, Axis)>> {
        let axes = self.map.as_deref().map(|texts| Ok((axis(&texts[0])?, axis(&texts[1])?)));
        axes.transpose()
    }
}

impl Flags {
    /// The loop.
    pub fn continuous(&self) -> Result<ContinuousLoop> {
        let gain = self.gain.context("the loop lacks --gain, the gain of the process")?;
        let kc = self.kc.context("the loop lacks --kc, the gain of the controller")?;
        let dead_time = self.dead_time.unwrap_or(0.0);
        let process = match (self.integrating, self.tau, self.tau2) {
            (false, None, _) => bail!("the loop lacks --tau, the time constant, or --integrating"),
            (false, Some(tau), None) => Process::first_order(gain, tau, dead_time),
            (false, Some(tau), Some(tau2)) => Process::second_order(gain, tau, tau2, dead_time),
            (true, None, _) => Process::integrator(gain, dead_time),
            (true, Some(tau), _) => {
                ensure!(tau > 0.0, "--tau is {tau}, but must be above 0");
                Process::transfer_function(&[gain], &[tau, 1.0, 0.0], dead_time)
            }
        }?;
        let controller = match self.ti {
            None => Controller::p(kc),
            Some(ti) => Controller::pid(kc, ti, self.td.unwrap_or(0.0)),
        }?;
        let model = Model::by_name(self.model.as_deref().unwrap_or("two-phase"))?;
        let bands: Bands = valve::bands(model, self.s, self.j)?;
        model.build(bands)?;
        Ok(ContinuousLoop::new(controller, process, model, bands))
    }
}

/// The axis of a map from `NAME=FROM:TO` or `NAME=FROM:TO:POINTS`.
fn axis(text: &str) -> Result<Axis> {
    const POINTS: usize = 100;
    const MOST: usize = 2_000;
    let wrong = || format!("--map {text}: write NAME=FROM:TO:POINTS, such as S=1:10:200");
    let (name, range) = text.split_once('=').with_context(wrong)?;
    let parameter = Parameter::by_name(name).with_context(|| format!("--map {text}"))?;
    let parts: Vec<&str> = range.split(':').collect();
    let (from, to, points) = match parts[..] {
        [from, to] => (from, to, None),
        [from, to, points] => (from, to, Some(points)),
        _ => bail!(wrong()),
    };
    let number = |text: &str| text.trim().parse::<f64>().ok().with_context(wrong);
    let points =
        points.map_or(Some(POINTS), |text| text.trim().parse().ok()).with_context(wrong)?;
    let (from, to) = (number(from)?, number(to)?);
    ensure!(from != to, "--map {text}: the range is empty");
    ensure!((2..=MOST).contains(&points), "--map {text}: {points} points, but must be 2 to {MOST}");
    Axis::even(parameter, from, to, points).with_context(|| format!("--map {text}"))
}
