//! Exact limit cycles against closed forms, reference cycles and simulations.

mod common;

use common::Table;
use stiction::Bands;
use stiction::closed_loop::{Controller, Process};
use stiction::limit_cycle::exact::{NoCycle, Outcome, cycle, cycles, member};
use stiction::limit_cycle::{ContinuousLoop, Cycle};
use stiction::valve::Model;

fn looped(
    controller: Controller,
    process: Process,
    model: Model,
    s: f64,
    j: f64,
) -> ContinuousLoop {
    ContinuousLoop::new(controller, process, model, Bands::from_s_j(s, j).unwrap())
}

/// The paper's loop.
fn paper_loop(model: Model, s: f64, j: f64) -> ContinuousLoop {
    let controller = Controller::pi(1.1, 2.5).unwrap();
    let process = Process::first_order(1.5, 5.93, 1.07).unwrap();
    ContinuousLoop { set_point: 5.0, ..looped(controller, process, model, s, j) }
}

/// The attractor, which must be the only one.
fn only(outcome: Outcome) -> Cycle {
    outcome.attractor().unwrap_or_else(|| panic!("{outcome:?}")).clone()
}

fn near(found: f64, expected: f64, relative: f64, what: &str) {
    let error = (found / expected - 1.0).abs();
    assert!(error <= relative, "{what}: {found}, not {expected}; off by {error:.2e}");
}

#[test]
fn the_closed_form_is_met() {
    let table = Table::fixture("exact_pole_cancel.csv");
    for row in 0..table.len() {
        let n = |column| table.number(row, column);
        let of = |model| {
            let controller = Controller::pi(n("Kc"), n("tau")).unwrap();
            let process = Process::first_order(n("Kp"), n("tau"), n("theta")).unwrap();
            only(cycle(&looped(controller, process, model, n("S"), n("J"))).unwrap())
        };
        let found = of(Model::TwoPhase);
        near(found.period_s, n("T_exact"), 1e-9, "period");
        near(found.half_pp.op, n("op_exact"), 1e-9, "OP");
        near(found.half_pp.vp, n("mv_exact"), 1e-9, "VP");
        near(found.half_pp.pv, n("pv_event"), 2e-9, "PV");
        // Half a period leaves -(1 - q) of a deviation of the stuck position.
        let left = (1.0 - n("q")).powi(2);
        assert!(found.multipliers.iter().any(|m| (m - left).norm() < 1e-9), "{found:?}");
        let found = of(Model::He);
        near(found.period_s, n("T_he_exact"), 1e-9, "period of He's valve");
        near(found.half_pp.op, n("op_he_exact"), 1e-9, "OP of He's valve");
    }
}

#[test]
fn the_cycles_of_the_papers_loop_are_met() {
    let table = Table::fixture("seed_loop_limit_cycles_continuous.csv");
    for row in 0..table.len() {
        let n = |column| table.number(row, column);
        let found = only(cycle(&paper_loop(Model::TwoPhase, n("S"), n("J"))).unwrap());
        near(found.period_s, n("period_s"), 1e-5, "period");
        near(found.half_pp.op, n("op_halfpp"), 1e-5, "OP");
        near(found.half_pp.vp, n("mv_halfpp"), 1e-5, "VP");
        near(found.half_pp.pv, n("pv_halfpp"), 1e-5, "PV");
        near(found.middle.op, n("op_mid"), 1e-5, "middle of OP");
        near(found.middle.vp, n("mv_mid"), 1e-5, "middle of VP");
        near(found.middle.pv, n("pv_mid"), 1e-5, "middle of PV");
        assert_eq!(found.slips, 2);
    }
}

#[test]
fn the_family_of_hes_valve_is_met() {
    let table = Table::fixture("he_model_tsypkin_seed_loop.csv");
    for row in 0..table.len() {
        let n = |column| table.number(row, column);
        let l = paper_loop(Model::He, n("S"), n("J"));
        let found = only(member(&l, n("delta")).unwrap());
        near(found.period_s, n("period_s"), 1e-6, "period");
        near(found.half_pp.vp, n("mv_halfpp"), 1e-6, "VP");
        // The table's extremes are those on a grid, a little inside of the true ones.
        near(found.half_pp.op, n("op_halfpp"), 4e-6, "OP");
        near(found.half_pp.pv, n("pv_halfpp"), 4e-6, "PV");
        let fall = |column| -(-n(column) / 5.93f64).exp_m1();
        let whole = -(-n("period_s") / 5.93f64).exp_m1();
        let closed = 1.5 * n("J") / 2.0 * fall("h_high") * fall("h_low") / whole;
        near(found.half_pp.pv, closed, 1e-9, "PV in closed form");
        assert!(found.multipliers.iter().any(|m| (m - 1.0).norm() < 1e-9), "{found:?}");
        near(found.middle.vp - 10.0 / 3.0 + 1.0, n("delta") + 1.0, 1e-9, "offset");
    }
}

#[test]
fn concentration_and_level_loops_are_met() {
    let table = Table::fixture("cts_loops_limit_cycles.csv");
    for row in 0..table.len() {
        let n = |column| table.number(row, column);
        let (controller, process) = match table.text(row, "loop") {
            "concentration" => (Controller::pi(0.2, 10.0), Process::first_order(3.0, 10.0, 10.0)),
            _ => (Controller::pi(0.4, 2.0), Process::integrator(1.0, 0.0)),
        };
        let l = looped(controller.unwrap(), process.unwrap(), Model::TwoPhase, n("S"), n("J"));
        let relay = table.text(row, "loop") == "level" && n("J") > n("S");
        let outcome = if relay { cycle(&l).unwrap() } else { cycles(&l).unwrap() };
        if table.text(row, "behaviour") == "decays" {
            let Outcome::None { reasons } = &outcome else { panic!("{outcome:?}") };
            let quiet =
                |r: &NoCycle| matches!(r, NoCycle::Decays { .. } | NoCycle::Rests { moving: true });
            assert!(reasons.iter().all(quiet), "{reasons:?}");
            continue;
        }
        let found = only(outcome);
        if relay {
            // The OP turns at the slip itself, so that the stem is a relay, with a family of cycles.
            // The table has one of those; this is the symmetric one.
            near(found.half_pp.op, n("S") / 2.0, 1e-12, "OP of a relay");
            near(found.half_pp.vp, n("J") / 2.0, 1e-12, "VP of a relay");
            near(found.period_s, 10.0 * n("S") / n("J"), 1e-12, "period of a relay");
            continue;
        }
        // The table's turns fall on steps; where the stem moves without a jump, that is felt.
        let tolerance = if n("J") == 0.0 { 1e-4 } else { 1e-6 };
        near(found.period_s, n("period_s"), tolerance, "period");
        near(found.half_pp.op, n("op_halfpp"), tolerance, "OP");
        near(found.half_pp.vp, n("mv_halfpp"), tolerance, "VP");
        near(found.half_pp.pv, n("pv_halfpp"), tolerance, "PV");
        if n("J") == 0.0 && n("S") == 5.0 {
            // The two phases solved by hand: exp(-t/5) (cos, sin)(2t/5), and a parabola.
            near(found.period_s, 18.442_389_449_488_62, 1e-13, "period without a jump");
            near(found.half_pp.vp, 1.725_440_131_376_068, 1e-13, "VP without a jump");
        }
    }
}
