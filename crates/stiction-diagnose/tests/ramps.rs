//! Slow ramps in manual, read from the PV alone.

use crate::staircase::{CHARACTERISTICS, uniform};
use stiction_diagnose::diagnose::{
    Basis, Detectors, DiagnoseOptions, Diagnosis, VerdictClass, diagnose,
};
use stiction_diagnose::recording::{GridOptions, Mode, Modes, Recording};
use stiction_diagnose::series::median;
use stiction_diagnose::valve_test::{Signature, signature};
use stiction_model::Bands;
use stiction_model::closed_loop::NormalStream;
use stiction_model::valve::{Start, TwoPhase, Valve};

/// A recording of ramps over 15 to 40 % in 40 to 120 time constants each, and S of its valve; half of the valves stick.
fn ramped(seed: u64, of: fn(f64) -> f64, runs: usize) -> (f64, Recording) {
    let mut draw = NormalStream::new(seed);
    let d = &mut draw;
    let s = if seed.is_multiple_of(2) { uniform(d, 0.0, 10f64.ln()).exp() } else { 0.0 };
    let j = s * uniform(d, 0.0, 1.0);
    let (span, low) = (uniform(d, 15.0, 40.0), uniform(d, 20.0, 40.0));
    let (tau, dead) = (uniform(d, 0.0, 20f64.ln()).exp(), uniform(d, 0.0, 4.0) as usize);
    let length = (uniform(d, 40.0, 120.0) * tau).max(200.0) as usize;
    let rest = (5.0 * tau) as usize + 20;
    let mut op = vec![low; rest];
    for _ in 0..runs {
        op.extend((0..length).map(|k| low + span * k as f64 / length as f64));
        op.extend(vec![low + span; rest]);
        op.extend((0..length).map(|k| low + span - span * k as f64 / length as f64));
        op.extend(vec![low; rest]);
    }
    let mut valve = TwoPhase::new(Bands::from_s_j(s, j).unwrap());
    valve.restart(Start::at_rest(low));
    // Noise, wandering and a load, as shares of the answer to 5 % in the middle.
    let middle = low + 0.5 * span;
    let answer = (of(middle + 2.5) - of(middle - 2.5)).abs();
    let noise = answer * uniform(d, 0.003, 0.05);
    let wander = answer * uniform(d, 0.0, 0.01);
    let load = answer * uniform(d, -0.5, 0.5) / op.len() as f64;
    let stem: Vec<f64> = op.iter().map(|op| valve.step(*op)).collect();
    let (mut flow, mut drift) = (of(low), 0.0);
    let pv: Vec<f64> = (0..op.len())
        .map(|k| {
            flow += (1.0 - (-1.0 / tau).exp()) * (of(stem[k.saturating_sub(dead)]) - flow);
            drift = 0.98 * drift + wander * d.draw();
            flow + drift + load * k as f64 + noise * d.draw()
        })
        .collect();
    let mut recording = Recording::regular("FIC1", 1.0, &op, Some(&pv), None).unwrap();
    recording.mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Manual] });
    (s, recording)
}

fn read(recording: &Recording) -> Signature {
    signature(recording, &GridOptions::default()).unwrap()
}

/// `STICTION_TESTS=200 cargo test -p stiction-diagnose --test diagnose ramps -- --nocapture` prints the table of
/// `docs/test.md`.
#[test]
fn ramps_are_read_from_the_pv_with_any_characteristic() {
    let n = std::env::var("STICTION_TESTS").map_or(16, |n| n.parse().unwrap());
    let mut sums = [0; 6];
    for ((name, of), runs) in CHARACTERISTICS.into_iter().flat_map(|of| [(of, 1), (of, 2)]) {
        let (mut decided, mut right, mut accused, mut missed, mut held) = (0, 0, 0, 0, 0);
        let mut errors = vec![];
        for seed in 700_000..700_000 + n {
            let (s, recording) = ramped(seed, of, runs);
            let found = read(&recording);
            let sticks = found.class == VerdictClass::Sticks;
            let cleared = found.class == VerdictClass::DoesNotStick;
            decided += u64::from(sticks || cleared);
            missed += u64::from(cleared && s > 0.0);
            let is_right = sticks && s > 0.0 || cleared && found.s.is_some_and(|of| s <= of.high);
            right += u64::from(is_right);
            accused += u64::from(sticks && s == 0.0);
            if let Some(of) = found.s.filter(|_| sticks && s > 0.0) {
                errors.push((of.value / s - 1.0).abs());
                held += usize::from(of.low <= s && s <= of.high);
            }
        }
        println!(
            "{name}, up and down {runs}: decided {decided} of {n}, right {right}; healthy accused {accused}; sticking cleared {missed}; S median error {:.0} \
             %, intervals hold {held} of {}",
            100.0 * median(&errors),
            errors.len()
        );
        let counts = [decided, right, accused, missed, held as u64, errors.len() as u64];
        sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
    }
    let [decided, right, accused, missed, held, given] = sums;
    // Both directions twice decide two tests in three; once they decide few.
    assert!(5 * decided >= 2 * 6 * n && 50 * (decided - right) <= decided, "{sums:?}");
    assert!(50 * accused <= 3 * n && 20 * missed <= 3 * n && 5 * held >= 4 * given, "{sums:?}");
}

#[test]
fn ramps_that_decide_are_the_test_of_the_diagnosis() {
    for seed in [700_000, 700_001, 700_002, 700_003] {
        let (_, mut recording) = ramped(seed, CHARACTERISTICS[0].1, 2);
        recording.mode =
            Some(Modes { time: vec![0.0, 10.0], modes: vec![Mode::Automatic, Mode::Manual] });
        let (by_ramps, found) = (read(&recording), diagnosed(&recording));
        assert_ne!(by_ramps.class, VerdictClass::CannotTell);
        assert_eq!((found.verdict.basis, found.verdict.class), (Basis::ValveTest, by_ramps.class));
        assert_eq!(found.stiction.s, by_ramps.s.filter(|_| by_ramps.class == VerdictClass::Sticks));
        recording.mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Automatic] });
        assert_ne!(diagnosed(&recording).verdict.basis, Basis::ValveTest);
    }
}

pub fn diagnosed(recording: &Recording) -> Diagnosis {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    diagnose(recording, &options).unwrap()
}

#[test]
fn a_ramp_of_a_controller_is_no_test() {
    let (_, mut recording) = ramped(2, CHARACTERISTICS[0].1, 1);
    for mode in [None, Some(Modes { time: vec![0.0], modes: vec![Mode::Automatic] })] {
        recording.mode = mode;
        let refused = signature(&recording, &GridOptions::default()).unwrap_err();
        assert!(refused.0.contains("only in manual"), "{refused:?}");
    }
    // In automatic before, as most recordings begin.
    recording.mode =
        Some(Modes { time: vec![0.0, 10.0], modes: vec![Mode::Automatic, Mode::Manual] });
    assert_ne!(read(&recording).class, VerdictClass::DoesNotRespond);
}
