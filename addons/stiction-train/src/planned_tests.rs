//! The calibration of valve tests: how likely a valve sticks, given the log-odds of a test and of the operation before it.

use crate::calibrate::logistic;
use anyhow::Result;
use stiction_diagnose::fusion::logit;
use stiction_diagnose::valve_test::TestReading;
use stiction_population::{Operator, Trend};
use stiction_score::{TestTrial, TestTrialOptions, TestedLoops};

/// Fits the constants of `valve_test/probability.rs` to simulated tests of `n` loops of the population by a careful
/// operator and of a third as many by a careless one, and prints the constants.
pub fn fit(seed: u64, n: u64, done: impl Fn() + Sync) -> Result<()> {
    let read = |operator: Operator, seed: u64, n: u64| {
        let loops = TestedLoops::Population;
        let options = TestTrialOptions { loops, operator, trend: Trend::AsPlanned };
        TestTrial::readings(seed, n, options, &done)
    };
    let mut all = read(Operator::Careful, seed, n)?;
    all.extend(read(Operator::Careless, seed.wrapping_add(1), n / 3)?);
    let operation = |reading: &TestReading| reading.by_operation.map_or(0.0, logit);
    let rows: Vec<[f64; 3]> =
        all.iter().map(|(_, reading)| [1.0, reading.log_odds, operation(reading)]).collect();
    let truth: Vec<bool> = all.iter().map(|(sticks, _)| *sticks).collect();
    let aim = [0.0, 1.0, 1.0];
    let [a, b, _] = logistic(&rows, &truth, aim, [true, true, false]);
    println!("{} tests", all.len());
    println!("ALONE: [{a:.3}, {b:.3}]");
    let before: Vec<bool> = all.iter().map(|(_, reading)| reading.by_operation.is_some()).collect();
    let kept = || before.iter().enumerate().filter_map(|(k, known)| known.then_some(k));
    let rows: Vec<[f64; 3]> = kept().map(|k| rows[k]).collect();
    let truth: Vec<bool> = kept().map(|k| truth[k]).collect();
    let joined = logistic(&rows, &truth, aim, [true; 3]);
    println!("JOINED: [{}]", joined.map(|x| format!("{x:.3}")).join(", "));
    Ok(())
}
