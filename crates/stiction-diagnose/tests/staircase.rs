//! Staircases in manual: the usual test of a valve, with straight and curved characteristics.

use stiction_diagnose::diagnose::{Basis, VerdictClass};
use stiction_diagnose::recording::{ByHand, Channel, Mode, Modes, Recording};
use stiction_diagnose::series::median;
use stiction_diagnose::valve_test::{ReadOptions, TestReading, read};
use stiction_model::Bands;
use stiction_model::closed_loop::NormalStream;
use stiction_model::valve::{Start, TwoPhase, Valve};

/// The PV over the position of the stem, with its name.
pub type Characteristic = (&'static str, fn(f64) -> f64);

pub const CHARACTERISTICS: [Characteristic; 3] = [
    ("straight", |x| x),
    ("equal percentage", |x| 100.0 * 30f64.powf(x / 100.0 - 1.0)),
    ("S-shaped", |x| 100.0 / (1.0 + (-(x - 50.0) / 12.0).exp())),
];

/// Holds of operators who wait until the PV has settled, and who do not.
const SETTLED: (f64, f64) = (4.0, 8.0);
const HURRIED: (f64, f64) = (0.5, 3.0);

/// Size of a bump in steps of a staircase.
const BUMP: f64 = 3.0;

/// A test of the valve: its truth and its recording in manual.
struct Staircase {
    /// S and J, percent; `None` if it follows.
    bands: Option<(f64, f64)>,
    recording: Recording,
}

/// Uniform numbers in a range.
pub fn uniform(draw: &mut NormalStream, from: f64, to: f64) -> f64 {
    from + (to - from) * (0.5 + draw.draw() / 5.0).clamp(0.0, 1.0)
}

/// Shape of a test.
#[derive(Clone, Copy)]
enum Shape {
    /// Equal steps up and back down, so many times.
    Stairs(usize),
    /// One large step up and back, so many times.
    Bump(usize),
}

/// Holds are in time constants of the process, with eight samples more.
fn staircase(
    seed: u64,
    of: fn(f64) -> f64,
    sticks: bool,
    shape: Shape,
    holds: (f64, f64),
) -> Staircase {
    let mut draw = NormalStream::new(seed);
    let d = &mut draw;
    let s = uniform(d, 0.0, 10f64.ln()).exp();
    let j = s * uniform(d, 0.0, 0.8);
    let (size, tau) = (uniform(d, 3.0, 8.0), uniform(d, 0.0, 20f64.ln()).exp());
    let hold = (uniform(d, holds.0, holds.1) * tau + 8.0).round() as usize;
    let low = uniform(d, 20.0, 35.0);
    let (once, cycles) = match shape {
        Shape::Stairs(cycles) => {
            let rungs = (40.0 / size) as i32;
            let up = (0..rungs).map(|k| low + size * f64::from(k));
            let down = (0..rungs).rev().map(|k| low + size * f64::from(k + 1));
            (up.chain(down).collect(), cycles)
        }
        Shape::Bump(times) => (vec![low, low + BUMP * size], times),
    };
    let levels = once.iter().cycle().take(cycles * once.len()).chain([&low]);
    let mut valve = TwoPhase::new(Bands::from_s_j(s, j).unwrap());
    let mut start = Start::at_rest(low);
    if let Shape::Bump(_) = shape {
        // The last move before the test is unknown.
        start.position += 0.5 * (s - j) * uniform(d, -1.0, 1.0);
    }
    valve.restart(start);
    // Noise and wandering, as shares of the answer to a step in the middle.
    let answer = (of(low + 20.0 + 0.5 * size) - of(low + 20.0 - 0.5 * size)).abs();
    let noise = answer * uniform(d, 0.003, 0.05);
    let wander = answer * uniform(d, 0.0, 0.01);
    let load = answer * uniform(d, -1.0, 1.0) / (cycles * once.len() * hold) as f64;
    let (mut flow, mut drift) = (of(low), 0.0);
    let (mut op, mut pv): (Vec<f64>, Vec<f64>) = (vec![], vec![]);
    for level in levels {
        for _ in 0..hold {
            let stem = if sticks { valve.step(*level) } else { *level };
            flow += (1.0 - (-1.0 / tau).exp()) * (of(stem) - flow);
            drift = 0.98 * drift + wander * d.draw();
            pv.push(flow + drift + load * op.len() as f64 + noise * d.draw());
            op.push(*level);
        }
    }
    let mut recording = Recording::regular("FIC1", 1.0, &op, Some(&pv), None).unwrap();
    recording.mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Manual] });
    Staircase { bands: sticks.then_some((s, j)), recording }
}

fn right(of: &Staircase, reading: &TestReading) -> bool {
    match (reading.class, of.bands) {
        (VerdictClass::Sticks, bands) => bands.is_some(),
        (VerdictClass::DoesNotStick, Some((s, _))) => reading.s_below.is_some_and(|b| s <= b),
        (class, None) => class == VerdictClass::DoesNotStick,
        _ => false,
    }
}

/// What is known of the tests of one characteristic.
#[derive(Default)]
struct Counts {
    tests: usize,
    decided: usize,
    right: usize,
    accused: usize,
    found: usize,
    errors: Vec<f64>,
    held: usize,
}

impl Counts {
    fn of(
        characteristic: fn(f64) -> f64,
        shape: Shape,
        holds: (f64, f64),
        seeds: std::ops::Range<u64>,
    ) -> Self {
        let mut counts = Self::default();
        for seed in seeds {
            let test = staircase(seed, characteristic, seed.is_multiple_of(2), shape, holds);
            let without = Recording { mode: None, ..test.recording.clone() };
            counts.tests += 1;
            counts.found += usize::from(ByHand::of(&without).is_some());
            let Ok(reading) = read(&test.recording, &ReadOptions::default()) else { continue };
            let sure = reading.class != VerdictClass::CannotTell;
            counts.decided += usize::from(sure);
            counts.right += usize::from(sure && right(&test, &reading));
            let accused = reading.class == VerdictClass::Sticks;
            counts.accused += usize::from(test.bands.is_none() && accused);
            if let (Some((s, _)), Some(estimate)) = (test.bands, reading.s) {
                counts.errors.push((estimate.value / s - 1.0).abs());
                counts.held += usize::from(estimate.low <= s && s <= estimate.high);
            }
        }
        counts
    }
}

/// `STICTION_TESTS=200 cargo test -p stiction-diagnose --test diagnose staircase -- --nocapture` prints the table of
/// `docs/test.md`.
#[test]
fn staircases_are_read_with_any_characteristic() {
    let n = std::env::var("STICTION_TESTS").map_or(16, |n| n.parse().unwrap());
    let mut sums = [0; 6];
    for ((name, of), cycles) in CHARACTERISTICS.into_iter().flat_map(|of| [(of, 1), (of, 2)]) {
        let counts = Counts::of(of, Shape::Stairs(cycles), SETTLED, 400_000..400_000 + n);
        let (tests, decided, given) = (counts.tests, counts.decided, counts.errors.len());
        println!(
            "{name}, up and down {cycles}: decided {decided} of {tests}, right {}; healthy accused {}; found without a mode {}; S \
             median error {:.0} %, intervals hold {} of {given}",
            counts.right,
            counts.accused,
            counts.found,
            100.0 * median(&counts.errors),
            counts.held
        );
        for (sum, count) in
            sums.iter_mut().zip([tests, decided, counts.right, counts.found, given, counts.held])
        {
            *sum += count;
        }
    }
    let [tests, decided, right, found, given, held] = sums;
    assert!(5 * decided >= 4 * tests && 50 * (decided - right) <= decided, "{sums:?}");
    // The same eight valves stick in each.
    assert!(10 * found >= 9 * tests && 4 * held >= 3 * given, "{sums:?}");
}

/// After each turn of one size the stem moves by the size less S, and the gain is not known: only turns of other sizes
/// distinguish a sticking valve from a smaller gain.
#[test]
fn bumps_of_one_size_decide_nothing_and_ask_for_smaller_turns() {
    for ((_, of), times) in CHARACTERISTICS.into_iter().flat_map(|of| [(of, 1), (of, 3)]) {
        for seed in 600_000..600_008_u64 {
            let sticks = seed.is_multiple_of(2);
            let test = staircase(seed, of, sticks, Shape::Bump(times), SETTLED);
            let reading = read(&test.recording, &ReadOptions::default()).unwrap();
            assert_eq!(reading.class, VerdictClass::CannotTell, "{seed} {times}");
            let advice = reading.advice.unwrap();
            assert!(advice.contains("smaller turns") || advice.contains("larger"), "{advice}");
            if let (Some((s, _)), Some(limit)) = (test.bands, reading.s_below) {
                assert!(s <= limit, "{seed} {times}: {s} {limit}");
            }
        }
    }
}

#[test]
fn hurried_staircases_accuse_no_healthy_valve() {
    let n = std::env::var("STICTION_TESTS").map_or(16, |n| n.parse().unwrap());
    for (name, of) in CHARACTERISTICS {
        let counts = Counts::of(of, Shape::Stairs(1), HURRIED, 500_000..500_000 + n);
        let Counts { tests, decided, right, accused, .. } = counts;
        println!(
            "{name}, hurried: decided {decided} of {tests}, right {right}; healthy accused {accused}"
        );
        assert!(50 * accused <= tests && 20 * (decided - right) <= tests, "{name}");
    }
}

const STAIRS: [f64; 13] =
    [40.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 65.0, 60.0, 55.0, 50.0, 45.0, 40.0];

/// Levels held for 60 samples, of a valve whose stem slid up before, and of a process with a lag of 5 samples. With
/// `position`, its noise, the stem is recorded too.
fn held(levels: &[f64], bands: (f64, f64), position: Option<f64>, seed: u64) -> Recording {
    let mut draw = NormalStream::new(seed);
    let (s, j) = bands;
    let mut valve = TwoPhase::new(Bands::from_s_j(s, j).unwrap());
    let mut start = Start::at_rest(levels[0]);
    start.position -= 0.5 * (s - j);
    valve.restart(start);
    let op: Vec<f64> = levels.iter().flat_map(|level| [*level; 60]).collect();
    let stem: Vec<f64> = op.iter().map(|op| valve.step(*op)).collect();
    let mut flow = stem[0];
    let mut lagging = |x: &f64| {
        flow += 0.18 * (x - flow);
        flow + 0.05 * draw.draw()
    };
    let pv: Vec<f64> = stem.iter().map(&mut lagging).collect();
    let mut recording = Recording::regular("FIC1", 1.0, &op, Some(&pv), None).unwrap();
    recording.mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Manual] });
    recording.vp = position.map(|noise| {
        let vp = stem.iter().map(|x| x + noise * draw.draw()).collect();
        Channel::new("VP", recording.op.time.clone(), vp).unwrap()
    });
    recording
}

fn read_held(levels: &[f64], bands: (f64, f64), position: Option<f64>, seed: u64) -> TestReading {
    read(&held(levels, bands, position, seed), &ReadOptions::default()).unwrap()
}

#[test]
fn a_limit_of_s_needs_a_reversal() {
    for (levels, bands, seed) in
        [(&STAIRS[..7], (12.0, 2.0)), (&STAIRS[..5], (20.0, 0.0)), (&STAIRS[..7], (0.0, 0.0))]
            .into_iter()
            .flat_map(|(levels, bands)| (0..3).map(move |seed| (levels, bands, seed)))
            .chain([(&[40.0, 50.0][..], (12.0, 2.0), 0)])
    {
        let reading = read_held(levels, bands, None, seed);
        assert_eq!(reading.class, VerdictClass::CannotTell, "{bands:?} {reading:?}");
        assert_eq!(reading.s_below, None, "{bands:?} {reading:?}");
        assert!(reading.advice.unwrap().contains("one direction only"));
    }
    // A limit stands beside no probable stiction.
    let bumps: Vec<f64> = [50.0, 52.0, 50.0, 48.0].into_iter().cycle().take(17).collect();
    for seed in 0..3 {
        let reading = read_held(&bumps, (6.0, 1.0), None, seed);
        assert!(reading.s_below.is_none_or(|limit| limit > 6.0), "{reading:?}");
    }
}

#[test]
fn bumps_that_decide_are_the_test_of_the_diagnosis() {
    for (bands, seed) in [(5.0, 2.5), (0.0, 0.0)].into_iter().flat_map(|s| [(s, 1), (s, 2)]) {
        let bumps = [40.0, 45.0, 40.0, 35.0].into_iter().cycle().take(13).collect::<Vec<_>>();
        let mut recording = held(&bumps, bands, None, seed);
        recording.mode =
            Some(Modes { time: vec![0.0, 5.0], modes: vec![Mode::Automatic, Mode::Manual] });
        assert!(!ByHand::of(&recording).unwrap().is_test());
        let reading = read(&recording, &ReadOptions::default()).unwrap();
        let found = crate::ramps::diagnosed(&recording);
        let decides = reading.class != VerdictClass::CannotTell;
        assert!(decides || bands.0 == 0.0, "{reading:?}");
        assert_eq!(found.verdict.basis == Basis::ValveTest, decides, "{:?}", found.verdict);
        assert!(!decides || found.verdict.class == reading.class && found.stiction.s == reading.s);
    }
}

#[test]
fn an_s_beyond_the_test_is_no_dead_band_elsewhere() {
    for (bands, seed) in [(30.0, 5.0), (40.0, 10.0), (50.0, 0.0), (60.0, 0.0)]
        .into_iter()
        .flat_map(|bands| (0..4).map(move |seed| (bands, seed)))
    {
        let reading = read_held(&STAIRS, bands, None, seed);
        assert_eq!(reading.class, VerdictClass::Sticks, "{bands:?} {reading:?}");
        match reading.s {
            Some(s) => assert!(s.low <= bands.0 && bands.0 <= s.high, "{bands:?} {s:?}"),
            None => assert!(reading.reasons.iter().any(|why| why.starts_with("S is at least"))),
        }
    }
}

#[test]
fn a_position_at_rest_does_not_respond() {
    for (size, noise, seed) in [2.0, 3.0, 5.0, 6.0]
        .into_iter()
        .flat_map(|size| [(size, 0.05), (size, 0.0)])
        .flat_map(|(size, noise)| (0..3).map(move |seed| (size, noise, seed)))
    {
        let levels = STAIRS.map(|level| 40.0 + (level - 40.0) / 5.0 * size);
        let reading = read_held(&levels, (300.0, 200.0), Some(noise), seed);
        assert_eq!(reading.class, VerdictClass::DoesNotRespond, "{size} {noise} {reading:?}");
        assert!(reading.s_below.is_none() && reading.response_s.is_none(), "{reading:?}");
    }
}

#[test]
fn an_exact_position_answers_each_step() {
    let reading = read_held(&STAIRS, (4.0, 1.0), Some(0.0), 0);
    assert_eq!(reading.class, VerdictClass::Sticks, "{reading:?}");
    let answered = reading.steps.iter().filter(|step| step.answered).count();
    assert_eq!((reading.turned, answered), (12, 12));
    assert!(reading.reasons[0].starts_with("the OP was turned 12 times"), "{:?}", reading.reasons);
}

#[test]
fn a_stroke_test_with_a_position_shows_the_dead_band() {
    let strokes: [&[f64]; 3] = [
        &[0.0, 25.0, 50.0, 75.0, 100.0, 75.0, 50.0, 25.0, 0.0],
        &[10.0, 30.0, 50.0, 70.0, 90.0, 70.0, 50.0, 30.0, 10.0],
        &[50.0, 75.0, 50.0, 25.0, 50.0, 75.0, 50.0, 25.0, 50.0],
    ];
    for (levels, noise, seed) in strokes
        .into_iter()
        .flat_map(|levels| [(levels, 0.0), (levels, 0.05)])
        .flat_map(|(levels, noise)| (0..3).map(move |seed| (levels, noise, seed)))
    {
        let reading = read_held(levels, (4.0, 1.0), Some(noise), seed);
        assert_eq!(reading.class, VerdictClass::Sticks, "{noise} {reading:?}");
        assert!(reading.s.is_some_and(|s| s.low <= 4.0 && 4.0 <= s.high), "{:?}", reading.s);
        let free = read_held(levels, (0.0, 0.0), Some(noise), seed);
        assert_ne!(free.class, VerdictClass::Sticks, "{noise} {free:?}");
    }
}

#[test]
fn holds_too_short_for_the_process_are_named() {
    let mut recording = held(&STAIRS, (0.0, 0.0), None, 0);
    let (mut flow, mut draw) = (40.0, NormalStream::new(1));
    let late = |k: usize| recording.op.values[k.saturating_sub(30)];
    let pv = (0..recording.op.values.len()).map(|k| {
        flow += (1.0 - (-1.0f64 / 90.0).exp()) * (late(k) - flow);
        flow + 0.05 * draw.draw()
    });
    let pv: Vec<f64> = pv.collect();
    recording.pv.as_mut().unwrap().values = pv;
    let reading = read(&recording, &ReadOptions::default()).unwrap();
    if reading.class == VerdictClass::CannotTell {
        assert!(reading.advice.unwrap().starts_with("The holds were too short"));
    }
    assert_ne!(reading.class, VerdictClass::Sticks);
}
