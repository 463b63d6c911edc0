//! The paper's loop against an independent simulation of the same recursion, and against its limit
//! for ever shorter sample times.

use crate::common;

use common::{Table, model_named, valve};
use stiction_model::closed_loop::{ClosedLoop, Controller, DeadTime, Process, Run};
use stiction_model::valve::Model;

/// The paper's loop over 600 s, its set point stepping to 5 at the beginning.
fn paper_loop(model: Model, s: f64, j: f64, sample_time: f64) -> ClosedLoop {
    let mut sticky = ClosedLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        valve(model, s, j),
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
    );
    sticky.set_point = 5.0.into();
    sticky.dead_time = DeadTime::Nearest;
    sticky.sample_time = sample_time;
    sticky.samples = (600.0 / sample_time).round() as usize;
    sticky
}

fn relative(found: f64, expected: f64) -> f64 {
    (found - expected).abs() / expected.abs().max(1.0)
}

/// Periods, amplitudes and last samples of all models in the table. The recursions are the same,
/// so only rounding may differ, and the loop's feedback keeps it small.
#[test]
fn sampled_loops_reproduce_the_reference() {
    let table = Table::fixture("seed_loop_sampled.csv");
    let (mut worst_last, mut worst_cycle): (f64, f64) = (0.0, 0.0);
    for row in 0..table.len() {
        let number = |column| table.number(row, column);
        let name = table.text(row, "model");
        let (s, j, ts) = (number("S"), number("J"), number("Ts"));
        let what = format!("{name} S={s} J={j} Ts={ts}");
        let run = paper_loop(model_named(name), s, j, ts).run().unwrap();

        for (signal, column) in [(&run.op, "u_last"), (&run.vp, "x_last"), (&run.pv, "y_last")] {
            let difference = (signal[signal.len() - 1] - number(column)).abs();
            assert!(difference <= 1e-10, "{what}: {column} differs by {difference:e}");
            worst_last = worst_last.max(difference);
        }
        let cycle = [
            (Some(run.half_pp(&run.op)), "op_halfpp"),
            (Some(run.half_pp(&run.vp)), "mv_halfpp"),
            (Some(run.half_pp(&run.pv)), "pv_halfpp"),
            (run.period_s(), "period_s"),
        ];
        for (found, column) in cycle {
            let expected = Some(number(column)).filter(|v| v.is_finite());
            assert_eq!(found.is_some(), expected.is_some(), "{what}: {column} {found:?}");
            let Some((found, expected)) = found.zip(expected) else { continue };
            let difference = relative(found, expected);
            assert!(difference <= 1e-9, "{what}: {column} is {found}, expected {expected}");
            worst_cycle = worst_cycle.max(difference);
        }
    }
    assert_eq!(table.len(), 100);
    println!("largest difference: last samples {worst_last:e}, cycles {worst_cycle:e} relative");
}

/// Every tenth sample of the run at 0.01 s, over the first 120 s.
#[test]
fn trace_reproduces_the_reference() {
    let table = Table::fixture("seed_loop_trace_S5_J3.csv");
    let run = paper_loop(Model::Kano, 5.0, 3.0, 0.01).run().unwrap();
    let mut worst: f64 = 0.0;
    for row in 0..table.len() {
        let k = (table.number(row, "t") / 0.01).round() as usize;
        assert_eq!(k, 10 * row);
        for (signal, column) in [(&run.sp, "sp"), (&run.op, "op"), (&run.vp, "mv"), (&run.pv, "pv")]
        {
            worst = worst.max((signal[k] - table.number(row, column)).abs());
        }
    }
    assert!(worst <= 1e-9, "{worst:e}");
    println!("largest difference: {worst:e}");
}

/// Samples at which the stem slips (sets off) and at which it stops, with the position after.
fn events(run: &Run) -> Vec<(&'static str, f64, f64)> {
    let mut events = vec![];
    let (mut before, mut moving) = (0.0, false);
    for (k, x) in run.vp.iter().enumerate() {
        let moves = *x != before;
        if moves != moving {
            let kind = if moves { "slip" } else { "stop" };
            events.push((kind, k as f64 * run.sample_time, *x));
        }
        (before, moving) = (*x, moves);
    }
    events
}

/// The slips and stops of the loop in continuous time: sampled, each is late by a few samples and
/// off by what the OP travels meanwhile.
#[test]
fn events_come_near_those_in_continuous_time() {
    let table = Table::fixture("seed_loop_events_S5_J3.csv");
    let run = paper_loop(Model::TwoPhase, 5.0, 3.0, 0.001).run().unwrap();
    let found = events(&run);
    for (row, (kind, time, after)) in (0..table.len()).zip(&found) {
        assert_eq!(table.text(row, "kind"), *kind, "event {row}");
        let late = (time - table.number(row, "t")).abs();
        assert!(late < 0.03, "event {row} is off by {late} s");
        let off = (after - table.number(row, "x_after")).abs();
        assert!(off < 0.02, "event {row} is off by {off} %");
    }
    assert!(found.len() >= table.len());
}

/// The run at two sample times, extrapolated to 0. What remains of the error, relative to the table,
/// is that slips and stops fall on samples: it is not smooth in the sample time, and shrinks with it.
#[test]
fn cycles_approach_those_in_continuous_time() {
    let table = Table::fixture("seed_loop_limit_cycles_continuous.csv");
    let cycle = |s, j, dead_time, ts: f64| {
        let mut sticky = paper_loop(Model::TwoPhase, s, j, ts);
        sticky.dead_time = dead_time;
        let run = sticky.run().unwrap();
        let period = run.period_s().unwrap();
        [period, run.half_pp(&run.op), run.half_pp(&run.vp), run.half_pp(&run.pv)]
    };
    let columns = ["period_s", "op_halfpp", "mv_halfpp", "pv_halfpp"];
    // The dead time of 1.07 s is 133.75 and 267.5, and 1337.5 and 2675 samples of the exact cases.
    for (dead_time, coarse, tolerance) in [
        (DeadTime::Nearest, 0.01, [5e-4, 5e-3]),
        (DeadTime::Exact, 0.008, [5e-4, 5e-3]),
        (DeadTime::Exact, 0.0008, [5e-5, 5e-4]),
    ] {
        let mut worst = [0f64; 4];
        for row in 0..table.len() {
            let (s, j) = (table.number(row, "S"), table.number(row, "J"));
            let fine = cycle(s, j, dead_time, coarse / 2.0);
            let coarse = cycle(s, j, dead_time, coarse);
            for (i, column) in columns.iter().enumerate() {
                let limit = 2.0 * fine[i] - coarse[i];
                worst[i] = worst[i].max((limit / table.number(row, column) - 1.0).abs());
            }
        }
        println!("{dead_time:?} from Ts = {coarse} s, relative error of {columns:?}: {worst:?}");
        assert!(worst[0] < tolerance[0], "{worst:?}");
        assert!(worst[1..].iter().all(|error| *error < tolerance[1]), "{worst:?}");
    }
}
