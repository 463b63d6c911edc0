//! How well loops are identified from what a plant would have recorded of them. The tables of
//! `docs/accuracy-tests.md` are what
//! `cargo test --release -p stiction-score --test score fit:: -- --ignored --nocapture` prints.

use rayon::prelude::*;
use std::collections::BTreeMap;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, diagnose};
use stiction_diagnose::fit::prospects::Remedy;
use stiction_diagnose::fit::ring::{Ring, ring};
use stiction_diagnose::fit::without::left;
use stiction_diagnose::fit::{Cycle, Draw, Fit, FitOptions, Prospects, fit, prospects};
use stiction_diagnose::fusion::Estimate;
use stiction_diagnose::identify::controller::{self, FittedController, Structure};
use stiction_diagnose::identify::process::{self, FittedProcess};
use stiction_diagnose::recording::{Grid, Recording};
use stiction_model::Bands;
use stiction_model::closed_loop::{Controller, Process};
use stiction_model::limit_cycle::exact;
use stiction_population::{
    ControllerKind, Facts, LoopKind, ProcessKind, Repaired, SetPointKind, Simulated, Situation,
    member,
};
use stiction_score::scoreboard::{Ranked, auc, logit};

/// Loops of the population on which no constant was chosen: another seed after every change that looks at them.
const SEED: u64 = 20_261_225;
const LOOPS: u64 = 4000;
/// How many are asked what an action would bring: that takes a second each.
const ASKED: u64 = 1500;
/// The first of the seeds of repaired loops; constants were chosen on those from 1,000,000 on.
const REPAIRED: u64 = 2_000_000;

fn members(n: u64) -> Vec<Simulated> {
    (0..n).into_par_iter().map(|k| member(SEED, k).unwrap()).collect()
}

fn covers(of: Estimate, truth: f64) -> bool {
    of.low <= truth && truth <= of.high
}

fn percent(part: usize, of: usize) -> String {
    if of == 0 {
        "-".to_owned()
    } else {
        format!("{:.1} % of {of}", 100.0 * part as f64 / of as f64)
    }
}

fn count<T>(all: &[T], what: impl Fn(&T) -> bool) -> String {
    percent(all.iter().filter(|each| what(each)).count(), all.len())
}

fn at(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get((share * values.len() as f64) as usize).copied().unwrap_or(f64::NAN)
}

/// What the controller is; `None` of one that is neither P, PI nor PID.
fn structure(facts: &Facts) -> Option<Structure> {
    match facts.controller {
        ControllerKind::P => Some(Structure::P),
        ControllerKind::Pi => Some(Structure::Pi),
        ControllerKind::Pid => Some(Structure::Pid),
        ControllerKind::ErrorSquared => None,
    }
}

/// The controller's gain in the units of the recorded PV.
fn gain(facts: &Facts) -> f64 {
    facts.kc * 100.0 / facts.pv_span
}

/// Whether OP and PV are recorded as the controller has them, but for rounding of the OP to 0.01 %, and nothing but the
/// controller moves the OP; and the set point is known or constant.
fn as_it_is(simulated: &Simulated, rounded_pv: bool) -> bool {
    let f = &simulated.truth.facts;
    let op = f.op_quantum <= 0.01 && f.op_compression == 0.0 && f.op_exception == 0.0;
    let pv = f.pv_compression == 0.0 && f.pv_exception == 0.0 && f.held_samples == 1;
    let alone = !matches!(
        f.situation,
        Situation::Feedforward
            | Situation::Override
            | Situation::NoisyControl
            | Situation::ManualSpells
    );
    let sp = simulated.recording.sp.is_some() || f.set_point == SetPointKind::Constant;
    op && pv && alone && sp && (rounded_pv || f.pv_quantum == 0.0)
}

fn fitted_controller(simulated: &Simulated) -> Option<FittedController> {
    let grid = Grid::of(&simulated.recording, &Default::default()).unwrap();
    controller::fit(grid.longest()?).ok()
}

/// A row of the table of controllers: structure, Kc and Ti within so much, and how often intervals cover.
fn row(name: &str, loops: &[&Simulated], within: f64) -> [f64; 3] {
    let found: Vec<(&Facts, FittedController)> = loops
        .par_iter()
        .filter_map(|one| Some((&one.truth.facts, fitted_controller(one)?)))
        .collect();
    let right = |(f, c): &(&Facts, FittedController)| Some(c.structure) == structure(f);
    let near = |value: f64, truth: f64| (value / truth - 1.0).abs() <= within;
    let kc = |(f, c): &(&Facts, FittedController)| near(c.kc.value, gain(f));
    let with_ti: Vec<&(&Facts, FittedController)> =
        found.iter().filter(|(f, c)| f.ti_s > 0.0 && c.ti_s.is_some()).collect();
    let ti = |(f, c): &(&Facts, FittedController)| c.ti_s.is_some_and(|ti| near(ti.value, f.ti_s));
    println!(
        "| {name} | {} | {} | {} | {} | {} | {} | {} |",
        percent(found.len(), loops.len()),
        count(&found, right),
        count(&found, kc),
        count(&found, |(f, c)| covers(c.kc, gain(f))),
        count(&with_ti, |both| ti(both)),
        count(&with_ti, |(f, c)| c.ti_s.is_some_and(|ti| covers(ti, f.ti_s))),
        format_args!("{:.0} %", 100.0 * within),
    );
    let share = |n: usize, of: usize| n as f64 / of.max(1) as f64;
    [
        share(found.iter().filter(|both| right(both)).count(), found.len()),
        share(found.iter().filter(|both| kc(both)).count(), found.len()),
        share(with_ti.iter().filter(|both| ti(both)).count(), with_ti.len()),
    ]
}

fn controllers(n: u64) -> [f64; 3] {
    let all = members(n);
    let of = |what: &(dyn Fn(&Simulated) -> bool + Sync)| -> Vec<&Simulated> {
        all.iter().filter(|one| what(one)).collect()
    };
    let steps = |one: &Simulated| one.truth.facts.steps_per_sample;
    println!("| recorded | fitted | structure | Kc | Kc covered | Ti | Ti covered | within |");
    println!("|---|---|---|---|---|---|---|---|");
    let exact = row("every execution", &of(&|one| steps(one) == 1 && as_it_is(one, false)), 0.03);
    row(
        "every execution, PV rounded or not",
        &of(&|one| steps(one) == 1 && as_it_is(one, true)),
        0.03,
    );
    row("every fifth", &of(&|one| steps(one) == 5 && as_it_is(one, true)), 0.10);
    row("all loops", &of(&|_| true), 0.10);
    exact
}

#[test]
fn controllers_of_the_population_are_found() {
    // Some hundred of them are recorded as the controller has them; 96 % are right on 4,000 loops.
    let [structure, kc, ti] = controllers(1200);
    assert!(structure >= 0.9 && kc >= 0.9 && ti >= 0.9, "{structure} {kc} {ti}");
}

#[test]
#[ignore = "measures, a minute"]
fn table_of_controllers() {
    controllers(LOOPS);
}

#[test]
#[ignore = "measures, a minute"]
fn table_of_processes() {
    let one = |k: u64| {
        let simulated = member(SEED, k).unwrap();
        let facts = &simulated.truth.facts;
        let apart = facts.process == ProcessKind::Unstable
            || simulated.truth.s > 100.0
            || facts.situation == Situation::OuterLoop;
        let grid = Grid::of(&simulated.recording, &Default::default()).unwrap();
        let segment =
            grid.longest().filter(|segment| !apart && segment.len() == simulated.truth.vp.len())?;
        let pv = segment.pv.as_deref()?;
        let found = process::fit(&simulated.truth.vp, pv, segment.sample_time, Some(facts.gain));
        Some((facts.clone(), found.ok()))
    };
    let all: Vec<(Facts, Option<FittedProcess>)> =
        (0..LOOPS).into_par_iter().filter_map(one).collect();
    println!("Processes behind the true valve position:");
    println!("| process | identified | known | error, median | covered |");
    println!("|---|---|---|---|---|");
    for integrating in [false, true] {
        let of: Vec<&(Facts, Option<FittedProcess>)> = all
            .iter()
            .filter(|(f, _)| (f.process == ProcessKind::Integrating) == integrating)
            .collect();
        let found: Vec<(&Facts, &FittedProcess)> =
            of.iter().filter_map(|(f, p)| Some((f, p.as_ref()?))).collect();
        let identified = percent(found.len(), of.len());
        let name = if integrating { "integrating" } else { "self-regulating" };
        let tell = |what: &str, values: Vec<(Estimate, f64, f64)>| {
            let known = values.len();
            let covered = count(&values, |(e, truth, _)| {
                e.low.min(e.high) <= *truth && *truth <= e.low.max(e.high)
            });
            let mut off: Vec<f64> =
                values.iter().map(|(e, truth, by)| ((e.value - truth) / by).abs()).collect();
            println!(
                "| {name}: {what} | {identified} | {known} | {:.1} % | {covered} |",
                100.0 * at(&mut off, 0.5)
            );
        };
        let unit = |f: &Facts| f.gain * f.pv_span / 100.0;
        if integrating {
            let slope = |(f, p): &(&Facts, &FittedProcess)| {
                let truth = unit(f) / f.tau_s;
                (p.slope, truth, truth)
            };
            tell("initial slope", found.iter().map(slope).collect());
        } else {
            let of_gain = |(f, p): &(&Facts, &FittedProcess)| Some((p.gain?, unit(f), unit(f)));
            tell("gain", found.iter().filter_map(of_gain).collect());
            // All lags and dead times together, a sample at least.
            let lags = |(f, p): &(&Facts, &FittedProcess)| {
                let (lag, dead) = (p.lag_s?, p.dead_time_s);
                let truth = f.tau_s + f.tau2_s + f.dead_time_s + f.valve_lag_s + f.pv_filter_s;
                let sum = Estimate {
                    value: lag.value + dead.value,
                    low: lag.low + dead.low,
                    high: lag.high + dead.high,
                };
                Some((sum, truth, truth.max(f.sample_time_s)))
            };
            tell("lags and dead time", found.iter().filter_map(lags).collect());
        }
    }
}

#[test]
#[ignore = "measures, some minutes"]
fn table_of_explanations() {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let one = |k: u64| {
        let simulated = member(SEED, k).unwrap();
        let found = diagnose(&simulated.recording, &options).unwrap();
        let oscillates = found.oscillation().is_some_and(|(_, o)| o.found);
        let fitted = oscillates.then(|| fit(&found, &FitOptions::default()).ok()).flatten();
        let cycle = fitted.and_then(|fitted| fitted.cycle.known().cloned());
        (simulated.truth, oscillates, cycle)
    };
    let all: Vec<_> = (0..LOOPS).into_par_iter().map(one).collect();
    let mut kinds: BTreeMap<&str, (usize, Vec<Cycle>)> = BTreeMap::new();
    for (truth, oscillates, cycle) in all {
        let name = match truth.kind.name() {
            "sticky valve" if truth.visible && truth.slips > 5 => "sticky valve, visible",
            "sticky valve" => "sticky valve, not visible",
            other => other,
        };
        let row = kinds.entry(name).or_default();
        row.0 += usize::from(oscillates);
        row.1.extend(cycle);
    }
    println!("| kind | oscillates | tested | explained | period off, median |");
    println!("|---|---|---|---|---|");
    for (name, (oscillates, cycles)) in kinds {
        let explained: Vec<&Cycle> =
            cycles.iter().filter(|cycle| cycle.explained == Some(true)).collect();
        let off = |cycle: &&Cycle| {
            Some((cycle.predicted?.period_s.value / cycle.recorded?.period_s - 1.0).abs())
        };
        let mut off: Vec<f64> = explained.iter().filter_map(off).collect();
        println!(
            "| {name} | {oscillates} | {} | {} | {:.0} % |",
            cycles.len(),
            percent(explained.len(), cycles.len()),
            100.0 * at(&mut off, 0.5)
        );
    }
}

/// What the explanation tells beyond the probability of the verdict: nothing, if in every row of the table the share of
/// sticking valves is the same in all columns.
#[test]
#[ignore = "measures, some minutes"]
fn table_of_the_explanation_as_evidence() {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let one = |k: u64| {
        let simulated = member(SEED, k).unwrap();
        let truth = &simulated.truth;
        let found = diagnose(&simulated.recording, &options).unwrap();
        let judged = found.evidence.as_ref().filter(|_| truth.visible || !truth.sticks)?;
        let probability = judged.probability;
        let fitted = fit(&found, &FitOptions::default()).ok();
        let explained = fitted.and_then(|fitted| fitted.cycle.known()?.explained);
        Some((probability, explained, truth.sticks))
    };
    let all: Vec<_> = (0..LOOPS).into_par_iter().filter_map(one).collect();
    println!("| probability | explained | not explained | not tested |");
    println!("|---|---|---|---|");
    for (from, to) in [(0.0, 0.2), (0.2, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 1.01)] {
        let sticking = |what: Option<bool>| {
            let of: Vec<bool> = all
                .iter()
                .filter(|(p, explained, _)| (from..to).contains(p) && *explained == what)
                .map(|(.., sticks)| *sticks)
                .collect();
            count(&of, |sticks| *sticks)
        };
        let columns = [Some(true), Some(false), None].map(sticking);
        println!("| {from} to {:.2} | {} |", f64::min(to, 1.0), columns.join(" | "));
    }
    // The best shifts of the logit, by half of the loops, tried on the other half.
    let (tuned_on, tried_on) = all.split_at(all.len() / 2);
    let score = |(p, explained, _): &(f64, Option<bool>, bool), shifts: [f64; 2]| {
        logit(*p)
            + match explained {
                Some(true) => shifts[0],
                Some(false) => shifts[1],
                None => 0.0,
            }
    };
    let surprise = |shifts: [f64; 2]| -> f64 {
        let one = |each: &(f64, Option<bool>, bool)| {
            let sign = if each.2 { -1.0 } else { 1.0 };
            (sign * score(each, shifts)).exp().ln_1p()
        };
        tuned_on.iter().map(one).sum()
    };
    let steps = || (-20..=20).map(|k| f64::from(k) / 10.0);
    let best = steps()
        .flat_map(|a| steps().map(move |b| [a, b]))
        .min_by(|a, b| surprise(*a).total_cmp(&surprise(*b)))
        .unwrap();
    for (name, shifts) in [("the probability alone", [0.0; 2]), ("with the explanation", best)] {
        let ranked: Vec<Ranked> = tried_on
            .iter()
            .enumerate()
            .map(|(k, each)| Ranked { valve: k, sticks: each.2, score: Some(score(each, shifts)) })
            .collect();
        let decided = tried_on.iter().filter(|each| score(each, shifts).abs() > logit(0.95));
        println!(
            "{name}, shifts {shifts:?}: AUC {:.4}, beyond 5 and 95 %: {} of {}",
            auc(&ranked, 1).unwrap().value,
            decided.count(),
            tried_on.len()
        );
    }
}

/// What the loop as it truly is would tell: how far its own exact cycle is from the recorded period, and what is left of
/// the swing behind a valve that follows.
#[test]
#[ignore = "measures, a minute"]
fn table_of_true_loops() {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let one = |k: u64| {
        let simulated = member(SEED, k).unwrap();
        let truth = &simulated.truth;
        if truth.kind != LoopKind::Sticky || !truth.visible || truth.slips <= 5 {
            return None;
        }
        let found = diagnose(&simulated.recording, &options).unwrap();
        let period = found.oscillation().filter(|(_, found)| found.found)?.1.period_s?;
        let draw = truly(&simulated)?;
        let cycle = match exact::cycle(&draw.continuous()) {
            Ok(exact::CycleOutcome::Cycles { cycles, .. }) => {
                cycles.into_iter().find(|cycle| cycle.stable)
            }
            _ => None,
        };
        let off = cycle.map(|cycle| (cycle.period_s / period).ln().abs());
        let mut segment = found.segment()?.clone();
        let whole = segment.len() == truth.vp.len();
        segment.vp = whole.then(|| truth.vp.clone());
        let left = whole.then(|| left(&[draw], &segment, period)).flatten();
        Some((off, left.map(|left| left.value)))
    };
    let all: Vec<_> = (0..LOOPS).into_par_iter().filter_map(one).collect();
    println!("Visible sticking loops that oscillate, by their true loop: {}", all.len());
    for within in [1.07, 1.15, 1.3] {
        let near =
            |(off, _): &(Option<f64>, Option<f64>)| off.is_some_and(|off| off <= f64::ln(within));
        println!("exact cycle within {within} times the recorded period: {}", count(&all, near));
    }
    let lefts: Vec<f64> = all.iter().filter_map(|(_, left)| *left).collect();
    println!("more than half of the swing is left: {}", count(&lefts, |left| *left > 0.5));
}

/// The loop as it truly is, as a drawn one.
fn truly(simulated: &Simulated) -> Option<Draw> {
    let f = &simulated.truth.facts;
    let unit = f.pv_span / 100.0;
    let dead = f.dead_time_s + f.valve_lag_s + f.pv_filter_s;
    let process = match f.process {
        ProcessKind::FirstOrder => Process::first_order(f.gain * unit, f.tau_s, dead),
        ProcessKind::SecondOrder => Process::second_order(f.gain * unit, f.tau_s, f.tau2_s, dead),
        ProcessKind::Integrating => Process::integrator(f.gain * unit / f.tau_s, dead),
        ProcessKind::Unstable => return None,
    };
    let controller = match f.controller {
        ControllerKind::P => Controller::p(gain(f)),
        ControllerKind::Pi | ControllerKind::Pid => Controller::pid(gain(f), f.ti_s, f.td_s),
        ControllerKind::ErrorSquared => return None,
    };
    Some(Draw {
        controller: controller.ok()?,
        process: process.ok()?,
        model: simulated.truth.model?,
        bands: Bands::from_s_j(simulated.truth.s, simulated.truth.j).ok()?,
        execution_s: f.sample_time_s / f.steps_per_sample as f64,
    })
}

/// What is touched.
fn kind(of: Remedy) -> &'static str {
    match of {
        Remedy::AsItIs => "nothing",
        Remedy::Retune => "tuning",
        Remedy::Compensate(_) => "compensator",
        Remedy::Repair | Remedy::RepairAndRetune | Remedy::Positioner => "valve",
    }
}

#[test]
#[ignore = "measures, some minutes"]
fn table_of_prospects() {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let one = |k: u64| {
        let simulated = member(SEED, k).unwrap();
        if simulated.truth.kind != LoopKind::Sticky || !simulated.truth.visible {
            return None;
        }
        let fitted =
            fit(&diagnose(&simulated.recording, &options).ok()?, &FitOptions::default()).ok()?;
        let expected = prospects(&fitted);
        if fitted.process.known().is_none() || fitted.controller.known().is_none() {
            return None;
        }
        let mut known = Fit { draws: vec![truly(&simulated)?; 5], ..fitted };
        // The stem as it truly moved.
        let whole = simulated.truth.vp.len() == known.segment.len();
        known.segment.vp = whole.then(|| simulated.truth.vp.clone());
        Some((expected.ok(), prospects(&known).ok()?))
    };
    let all: Vec<_> = (0..ASKED).into_par_iter().filter_map(one).collect();
    let told: Vec<_> = all.iter().filter_map(|(e, t)| Some((e.as_ref()?, t))).collect();
    let best = |of: &Prospects| of.actions.first().map(|row| row.action);
    let row =
        |of: &Prospects, what: Remedy| of.actions.iter().find(|row| row.action == what).cloned();
    let helps = |of: &Prospects| row(of, Remedy::Repair).is_some_and(|row| row.sure > 0.5);
    println!("Sticking loops whose controller and process are identified: {}", all.len());
    println!("something can be told of {}", percent(told.len(), all.len()));
    let truly_best =
        |of: &Prospects| of.actions.iter().map(|row| row.error.value).fold(f64::INFINITY, f64::min);
    let brings = |(expected, truth): &(&Prospects, &Prospects),
                  most: &dyn Fn(&Prospects) -> f64| {
        let chosen = best(expected).and_then(|what| row(truth, what));
        chosen.is_some_and(|chosen| chosen.error.value <= most(truth))
    };
    let alone = |of: &Prospects| row(of, Remedy::AsItIs).map_or(0.0, |row| row.error.value);
    println!("the same best action: {}", count(&told, |(e, t)| best(e) == best(t)));
    println!(
        "of the same kind (valve, tuning, compensator, nothing): {}",
        count(&told, |(e, t)| best(e).map(kind) == best(t).map(kind))
    );
    println!(
        "the best action told leaves at most 1.15 times the least error: {}",
        count(&told, |both| brings(both, &|truth| 1.15 * truly_best(truth)))
    );
    println!(
        "and at most 1.02 times that of the loop as it is: {}",
        count(&told, |both| brings(both, &|truth| 1.02 * alone(truth)))
    );
    println!("repair helps, or does not, as said: {}", count(&told, |(e, t)| helps(e) == helps(t)));
}

/// What became of loops with and without a repair, beside its prediction: those of the first `n` seeds from this one on
/// for which there is a prediction.
fn rings(seed: u64, n: usize) -> Vec<[Ring; 2]> {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let one = |seed: u64| {
        let made = Repaired::simulate(seed).unwrap()?;
        let fitted = fit(&diagnose(&made.before, &options).ok()?, &FitOptions::default()).ok()?;
        let expected = prospects(&fitted).ok()?;
        let after = |action: Remedy, after: &Recording| {
            let grid = Grid::of(after, &Default::default()).ok()?;
            ring(&expected, action, &fitted, grid.longest()?).ok()
        };
        Some([after(Remedy::Repair, &made.after)?, after(Remedy::AsItIs, &made.unrepaired)?])
    };
    let mut all = vec![];
    for from in (seed..).step_by(20) {
        all.par_extend((from..from + 20).into_par_iter().filter_map(one));
        if all.len() >= n {
            break;
        }
    }
    all.truncate(n);
    all
}

/// Of how many loops the swing after an action lies in its interval. `STICTION_LOOPS=300` measures more of them.
#[test]
fn swings_after_a_repair_lie_in_their_intervals() {
    let n = std::env::var("STICTION_LOOPS").ok().and_then(|n| n.parse().ok()).unwrap_or(20);
    let all = rings(REPAIRED, n);
    for k in 0..2 {
        let action = all[0][k].action.name();
        let of = || all.iter().map(|rings| &rings[k]);
        let inside = of().filter(|ring| covers(ring.predicted, ring.after)).count();
        let mut widths: Vec<f64> = of().map(|r| r.predicted.high / r.predicted.low).collect();
        println!(
            "{action}: within the interval {}, high over low {:.1} in the median",
            percent(inside, all.len()),
            at(&mut widths, 0.5)
        );
        assert!(inside as f64 >= 0.85 * n as f64, "{action}: {inside} of {n}");
    }
}
