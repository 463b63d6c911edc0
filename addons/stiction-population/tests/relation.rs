//! Whether columns belong together, on simulated loops.

use rayon::prelude::*;
use stiction_diagnose::diagnose::{Mismatch, Relation};
use stiction_diagnose::recording::{Channel, Grid, GridOptions, Recording};
use stiction_diagnose::series::{mean, span};
use stiction_model::closed_loop::NormalStream;
use stiction_population::member;

/// Whether a signal moves often enough for its columns to be told apart.
fn is_alive(x: &[f64]) -> bool {
    let flat = 1e-9 * span(x);
    let dead = |w: &&[f64]| {
        let (before, after) = (w[1] - w[0], w[2] - w[1]);
        after == 0.0 || (after - before).abs() <= flat
    };
    4 * x.windows(3).filter(dead).count() < 3 * x.len()
}

fn relation(op: &[f64], pv: &[f64], sp: Option<&[f64]>, sample_time: f64) -> Relation {
    let recording = Recording::regular("", sample_time, op, Some(pv), sp).unwrap();
    Relation::of(Grid::of(&recording, &GridOptions::default()).unwrap().longest().unwrap())
}

/// A recorded loop, and what it is called by its columns.
fn columns(seed: u64, index: u64) -> (Vec<f64>, Vec<f64>, Option<Vec<f64>>) {
    let recording = member(seed, index).unwrap().recording;
    let values = |channel: Channel| channel.values;
    (values(recording.op), values(recording.pv.unwrap()), recording.sp.map(values))
}

/// Scattered without a pattern, and the same every time.
fn shuffled(x: &[f64]) -> Vec<f64> {
    let mut x = x.to_vec();
    let mut state = 88_172_645_463_325_252u64;
    for k in (1..x.len()).rev() {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        x.swap(k, (state % (k as u64 + 1)) as usize);
    }
    x
}

#[test]
fn columns_as_recorded_belong_together() {
    let stopped: usize = (0..300u64)
        .into_par_iter()
        .map(|k| {
            let (op, pv, sp) = columns(901, k);
            usize::from(relation(&op, &pv, sp.as_deref(), 1.0).mismatch.is_some())
        })
        .sum();
    assert!(stopped <= 6, "{stopped} of 300");
}

#[test]
fn copies_are_found() {
    for k in 0..40 {
        let (op, pv, _) = columns(902, k);
        if span(&op) < 1e-3 {
            continue;
        }
        let milliamps: Vec<f64> = op.iter().map(|v| 4.0 + 0.16 * v).collect();
        let n = op.len();
        let (late_op, late_pv) = (&op[..n - 1], &pv[..n - 1]);
        let of = |op: &[f64], pv: &[f64]| relation(op, pv, None, 1.0).mismatch;
        assert_eq!(of(&op, &op), Some(Mismatch::SameSignal));
        assert_eq!(of(&op, &milliamps), Some(Mismatch::SameSignal));
        assert_eq!(of(&op[1..], late_op), Some(Mismatch::PvIsOp));
        assert_eq!(of(late_pv, &pv[1..]), Some(Mismatch::OpIsPv));
    }
}

#[test]
fn a_p_controller_is_no_copy() {
    let (_, pv, _) = columns(903, 3);
    let level = mean(&pv);
    let op: Vec<f64> = pv.iter().map(|v| 50.0 - 1.7 * (v - level)).collect();
    assert_eq!(relation(&op, &pv, None, 1.0).mismatch, None);
}

#[test]
fn a_noise_that_the_controller_filters_hides_no_relation() {
    let mut draws = NormalStream::new(5);
    let mut slow = 0.0;
    let mut next = || {
        slow = 0.99 * slow + 0.14 * draws.draw();
        (50.0 - slow + 0.3 * draws.draw(), slow + 2.5 * draws.draw())
    };
    let (op, pv): (Vec<f64>, Vec<f64>) = (0..3600).map(|_| next()).unzip();
    let found = relation(&op, &pv, None, 1.0);
    assert!(found.mismatch.is_none() && found.op_explained < Some(0.1), "{found:?}");
    assert_eq!(relation(&op, &shuffled(&pv), None, 1.0).mismatch, Some(Mismatch::Unrelated));
}

#[test]
fn a_set_point_tells_whose_column_it_is() {
    let wave = |k: usize| (k as f64 * 0.3).sin() + 0.1 * ((k * k) as f64).sin();
    let op: Vec<f64> = (0..900).map(|k| 40.0 + 3.0 * wave(k)).collect();
    let pv: Vec<f64> = (0..900).map(|k| 70.0 + 0.5 * wave(k + 4)).collect();
    let sp = vec![70.0; 900];
    assert_eq!(relation(&op, &pv, Some(&sp), 1.0).mismatch, None);
    assert_eq!(relation(&pv, &op, Some(&sp), 1.0).mismatch, Some(Mismatch::Exchanged));
    let below: Vec<f64> = (0..900).map(|k| 70.0 + 0.01 * (k as f64 * 0.01).sin()).collect();
    let swapped = relation(&below, &pv, Some(&op), 1.0).mismatch;
    assert_eq!(swapped, Some(Mismatch::SpAndOpExchanged));
}

#[test]
fn what_is_out_of_order_is_unrelated() {
    let counts = |k: u64| {
        let (op, pv, sp) = columns(904, k);
        let both = is_alive(&op) && is_alive(&pv);
        let found = relation(&op, &shuffled(&pv), sp.as_deref(), 1.0).mismatch;
        (usize::from(both), usize::from(both && found == Some(Mismatch::Unrelated)))
    };
    let (all, found) =
        (0..60u64).into_par_iter().map(counts).reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    assert!(all > 20 && 10 * found >= 8 * all, "{found} of {all}");
}

#[test]
fn units_direction_and_time_scale_do_not_matter() {
    for k in 0..30 {
        let (op, pv, sp) = columns(905, k);
        let other = |x: &[f64]| -> Vec<f64> { x.iter().map(|v| 300.0 - 4.0 * v).collect() };
        let shuffled = shuffled(&pv);
        for pv in [&pv, &shuffled] {
            let one = relation(&op, pv, sp.as_deref(), 1.0);
            let sp = sp.as_deref().map(other);
            let two = relation(&op, &other(pv), sp.as_deref(), 60.0);
            assert_eq!(one.mismatch, two.mismatch, "{k}");
        }
    }
}

#[test]
fn malformed_signals_are_unknown() {
    for n in [2, 3, 9, 40] {
        let ramp: Vec<f64> = (0..n).map(f64::from).collect();
        let still = vec![5.0; n as usize];
        assert_eq!(relation(&still, &still, Some(&still), 1.0).mismatch, None);
        assert_eq!(relation(&ramp, &still, Some(&still), 1.0).mismatch, None);
    }
}
