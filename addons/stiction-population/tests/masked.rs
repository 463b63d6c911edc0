//! Values that are no measurements do not change a verdict.

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, Grade, diagnose};
use stiction_diagnose::recording::{MaskedKind, Recording};
use stiction_population::member;

const SEED: u64 = 20_261_126;
const CODES: [f64; 6] = [-9999.0, 9999.0, -999.25, 1e31, 327.67, -32768.0];

fn grade(recording: &Recording) -> Grade {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    diagnose(recording, &options).unwrap().verdict.grade
}

/// The recording with a code at 1 to 20 places of the OP, the PV or both; each place has 1 to `longest` samples.
fn with_code(clean: &Recording, code: f64, longest: u64, random: &mut impl Rng) -> Recording {
    let mut below = |n: u64| random.next_u64() % n;
    let mut recording = clean.clone();
    let (which, places) = (below(3), 1 + below(20));
    for _ in 0..places {
        let n = recording.op.values.len();
        let (from, length) = (below(n as u64) as usize, 1 + below(longest) as usize);
        let fill = |values: &mut [f64]| values[from..(from + length).min(n)].fill(code);
        if which != 1 {
            fill(&mut recording.op.values);
        }
        if which != 0 {
            recording.pv.iter_mut().for_each(|pv| fill(&mut pv.values));
        }
    }
    recording
}

/// Clean grades and grades with a code, for each loop and code.
fn grades(loops: u64, longest: u64) -> Vec<(u64, f64, Grade, Grade)> {
    let of_loop = |k: u64| {
        let clean = member(SEED, k).unwrap().recording;
        let right = grade(&clean);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(k);
        CODES.map(|code| (k, code, right, grade(&with_code(&clean, code, longest, &mut random))))
    };
    (0..loops).into_par_iter().flat_map_iter(of_loop).collect()
}

fn opposite(a: Grade, b: Grade) -> bool {
    a.accuses() && b.spares() || a.spares() && b.accuses()
}

#[test]
fn no_sample_of_the_population_is_masked() {
    let found = (0..600u64).into_par_iter().filter_map(|k| {
        let recording = member(SEED, k).unwrap().recording;
        let masked = recording.masked().masked_values();
        (!masked.is_empty()).then_some((k, masked))
    });
    assert_eq!(found.collect::<Vec<_>>(), []);
}

#[test]
fn codes_are_found_at_their_places() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let (mut exact, mut all) = (0, 0);
    for k in 0..200 {
        let clean = member(SEED, k).unwrap().recording;
        for code in CODES {
            let raw = with_code(&clean, code, 5, &mut random);
            let found = raw.masked().into_owned();
            // Never anything else.
            assert!(
                found.masked_values().iter().all(|m| m.value == code && m.kind == MaskedKind::Code)
            );
            let count: usize = found.masked_values().iter().map(|m| m.count).sum();
            let equal = |x: &[f64]| x.iter().filter(|v| **v == code).count();
            let of_pv = raw.pv.as_ref().map_or(0, |pv| equal(&pv.values));
            exact += usize::from(count == equal(&raw.op.values) + of_pv);
            all += 1;
        }
    }
    // 327.67 may be a value of the PV.
    assert!(exact * 100 >= all * 99, "{exact} of {all}");
}

#[test]
fn a_code_does_not_turn_a_verdict() {
    for (k, code, right, found) in grades(15, 1) {
        assert!(!opposite(right, found), "loop {k} with {code}: {found} for {right}");
    }
}
