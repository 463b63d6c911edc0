//! What the verdict must not depend on, and what it must hold to.

use stiction_diagnose::diagnose::{
    Basis, Detectors, DiagnoseOptions, Diagnosis, NAMED_FROM, Ruling, VerdictClass, diagnose,
    thresholds,
};
use stiction_diagnose::recording::{Channel, Recording};
use stiction_population::LoopKind;

/// The diagnosis, without the published methods, which the verdict on OP and PV does not ask.
fn judged(recording: &Recording) -> Diagnosis {
    diagnose(
        recording,
        &DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() },
    )
    .unwrap()
}

fn members(seed: u64, n: u64) -> impl Iterator<Item = Recording> {
    (0..n).map(move |k| stiction_population::member(seed, k).unwrap().recording)
}

fn mapped(channel: &Channel, f: impl Fn(f64) -> f64) -> Channel {
    Channel { values: channel.values.iter().map(|v| f(*v)).collect(), ..channel.clone() }
}

/// The same loop as another plant would have recorded it: units, offset and sign of the PV, a valve that closes
/// on a rising output, another clock.
fn elsewhere(recording: &Recording) -> Recording {
    let mut other = recording.clone();
    let unit = |v: f64| -3.7 * v + 120.0;
    other.pv = other.pv.as_ref().map(|pv| mapped(pv, unit));
    other.sp = other.sp.as_ref().map(|sp| mapped(sp, unit));
    other.op = mapped(&other.op, |v| 100.0 - v);
    let slower = |channel: &mut Channel| channel.time.iter_mut().for_each(|t| *t *= 60.0);
    slower(&mut other.op);
    [&mut other.pv, &mut other.sp].into_iter().flatten().for_each(slower);
    other.mode.iter_mut().for_each(|mode| mode.time.iter_mut().for_each(|t| *t *= 60.0));
    other
}

#[test]
fn units_direction_and_clock_do_not_matter() {
    for (k, recording) in members(901, 40).enumerate() {
        let (here, there) = (judged(&recording), judged(&elsewhere(&recording)));
        match (here.verdict.probability, there.verdict.probability) {
            // Trees split in single precision: a value on a threshold may fall to either side.
            (Some(a), Some(b)) => {
                assert!((a - b).abs() < 0.05, "loop {k}: {a} {b}");
                let limits = [thresholds().accuse, thresholds().clear];
                let near = limits.iter().any(|limit| (a - limit).abs() < 0.05);
                assert!(near || here.verdict.class == there.verdict.class, "loop {k}: {a} {b}");
            }
            (a, b) => assert_eq!(a, b, "loop {k}"),
        }
    }
}

#[test]
fn a_verdict_follows_from_its_probability_and_adds_up() {
    let mut classes = std::collections::HashSet::new();
    for recording in members(902, 80) {
        let diagnosis = judged(&recording);
        let verdict = &diagnosis.verdict;
        classes.insert(verdict.class);
        if verdict.basis != Basis::Evidence {
            continue;
        }
        let p = verdict.probability.expect("evidence has a probability");
        let limits = diagnosis.evidence.as_ref().expect("the evidence").thresholds();
        match verdict.class {
            VerdictClass::Sticks => assert!(p >= limits.accuse),
            VerdictClass::DoesNotRespond => assert!(p >= NAMED_FROM),
            VerdictClass::DoesNotStick => {
                assert!(p <= limits.clear && verdict.s_below.is_some());
                assert!(diagnosis.stiction.s.is_none() && diagnosis.stiction.why_not.is_some());
            }
            // Whatever keeps a decisive probability from deciding is told.
            _ if p <= limits.clear || p >= limits.accuse => {
                assert!(diagnosis.undecided_by().is_some_and(|ruling| ruling != Ruling::Open));
            }
            _ => {
                let before = [Ruling::Mistaken, Ruling::Strange, Ruling::Open];
                assert!(diagnosis.undecided_by().is_some_and(|ruling| before.contains(&ruling)));
            }
        }
        assert!(!verdict.reasons.is_empty());
        let others: f64 = verdict.alternatives.iter().map(|other| other.likelihood).sum();
        assert!(others <= 1.0 + 1e-9, "{others}");
        assert!(verdict.alternatives.is_sorted_by(|a, b| a.likelihood >= b.likelihood));
        if let Some(s) = diagnosis.stiction.s {
            assert!(s.low <= s.value && s.value <= s.high && s.low > 0.0);
            assert_eq!(diagnosis.stiction.coverage, Some(0.9));
            assert!(diagnosis.stiction.model.is_some());
        }
        if diagnosis.stiction.j.is_none() {
            assert!(diagnosis.stiction.why_not.is_some());
        }
    }
    assert!(classes.len() >= 3, "{classes:?}");
}

#[test]
fn what_is_clear_is_reported() {
    // Shares of loops that are accused; the full figures stand in docs/accuracy.md.
    let accused = |kind: LoopKind, visible: bool| {
        let loops: Vec<_> = (0..60).map(|seed| kind.simulate(5_000 + seed).unwrap()).collect();
        let counted: Vec<_> = loops.iter().filter(|each| !visible || each.truth.visible).collect();
        let accuses = |recording: &Recording| {
            let class = judged(recording).verdict.class;
            matches!(class, VerdictClass::Sticks | VerdictClass::DoesNotRespond)
        };
        let hits = counted.iter().filter(|each| accuses(&each.recording)).count();
        hits as f64 / counted.len() as f64
    };
    assert!(accused(LoopKind::Sticky, true) > 0.3);
    for kind in
        [LoopKind::Normal, LoopKind::Sine, LoopKind::AggressiveTuning, LoopKind::QuantisedPv]
    {
        let share = accused(kind, false);
        assert!(share < 0.09, "{}: {share}", kind.name());
    }
}

#[test]
fn the_output_alone_never_accuses() {
    let mut probable = 0;
    for mut recording in members(903, 60) {
        (recording.pv, recording.sp) = (None, None);
        let verdict = judged(&recording).verdict;
        assert_eq!(verdict.class, VerdictClass::CannotTell);
        if verdict.basis == Basis::OpAlone {
            let said = verdict.reasons.last().unwrap();
            assert!(said.contains("pattern of the OP"), "{said}");
            probable += usize::from(verdict.probability.is_some_and(|p| p >= 0.8));
        }
    }
    assert!(probable > 0);
}

#[test]
fn a_long_recording_is_looked_at_in_windows() {
    let recording = &stiction_population::LoopKind::Sticky.simulate(5_010).unwrap().recording;
    let again = |x: &[f64]| x.iter().copied().cycle().take(60_000).collect::<Vec<_>>();
    let (op, pv) = (again(&recording.op.values), again(&recording.pv.as_ref().unwrap().values));
    let long = Recording::regular("long", 1.0, &op, Some(&pv), None).unwrap();
    let diagnosis = judged(&long);
    let windows = &diagnosis.windows;
    assert!((2..=60).contains(&windows.len()), "{}", windows.len());
    assert!(windows.is_sorted_by(|a, b| a.from < b.from));
    let probabilities: Vec<f64> = windows.iter().map(|window| window.probability).collect();
    let pooled = diagnosis.evidence.unwrap().probability;
    // Evidence for sticking adds up, evidence against it does not.
    let low = probabilities.iter().fold(1.0, |l: f64, p| l.min(*p));
    assert!(low <= pooled && pooled < 1.0, "{low} {pooled}");
}

/// Samples `from` to `until` of a recording.
fn cut(recording: &Recording, from: usize, until: usize) -> Recording {
    let mut part = recording.clone();
    let keep = |channel: &mut Channel| {
        channel.time = channel.time[from..until].to_vec();
        channel.values = channel.values[from..until].to_vec();
        if channel.quality.len() > until - from {
            channel.quality = channel.quality[from..until].to_vec();
        }
    };
    keep(&mut part.op);
    [&mut part.pv, &mut part.sp].into_iter().flatten().for_each(keep);
    part
}

/// The loop with a tenth more noise on its PV.
fn noisier(recording: &Recording, seed: u64) -> Recording {
    let mut other = recording.clone();
    if let Some(pv) = &mut other.pv {
        let more = (1.1f64 * 1.1 - 1.0).sqrt() * stiction_diagnose::series::noise_std(&pv.values);
        let mut stream = stiction_model::closed_loop::NormalStream::new(seed);
        pv.values.iter_mut().for_each(|v| *v += more * stream.draw());
    }
    other
}

/// How often a decided verdict changes, and how often it turns into its opposite: the figures of
/// docs/accuracy.md.
///
/// `cargo test --release -p stiction-population --test population verdict:: -- --ignored --nocapture`
#[test]
#[ignore = "1,000 loops, diagnosed six times"]
fn decided_verdicts_stay() {
    let mut counts = std::collections::BTreeMap::new();
    let pairs: Vec<Vec<(&str, VerdictClass, VerdictClass)>> = {
        use rayon::prelude::*;
        (0..1_000u64)
            .into_par_iter()
            .map(|k| {
                let recording = stiction_population::member(904, k).unwrap().recording;
                let whole = judged(&recording);
                let n = recording.op.values.len();
                let half = whole.evidence.as_ref().map_or(0, |evidence| {
                    let samples = evidence.typical().period_s / whole.grid.sample_time;
                    (0.5 * samples).round() as usize
                });
                let class = |recording: &Recording| judged(recording).verdict.class;
                let of = whole.verdict.class;
                vec![
                    ("units, offset, direction, clock", of, class(&elsewhere(&recording))),
                    ("a tenth more noise", of, class(&noisier(&recording, k))),
                    (
                        "half a cycle later",
                        class(&cut(&recording, 0, n - half)),
                        class(&cut(&recording, half, n)),
                    ),
                ]
            })
            .collect()
    };
    for (what, before, after) in pairs.into_iter().flatten() {
        let [decided, kept, turned] = counts.entry(what).or_insert([0; 3]);
        let accuses = |class| matches!(class, VerdictClass::Sticks | VerdictClass::DoesNotRespond);
        if before == VerdictClass::CannotTell {
            continue;
        }
        *decided += 1;
        *kept +=
            usize::from(accuses(before) == accuses(after) && after != VerdictClass::CannotTell);
        *turned +=
            usize::from(accuses(before) != accuses(after) && after != VerdictClass::CannotTell);
    }
    for (what, [decided, kept, turned]) in counts {
        println!("{what}: {decided} decided, {kept} kept, {turned} turned into the opposite");
        assert!(turned * 100 <= decided, "{what}");
    }
}

/// The tag of a transmitter that stops in the historian, while the loop goes on: behind a PV that really never moved its
/// controller would wind up.
#[test]
fn a_pv_that_stands_still_while_the_controller_works_on_is_no_verdict() {
    let mut still = 0;
    for k in 0..60 {
        let mut recording = stiction_population::member(20_261_123, k).unwrap().recording;
        let Some(pv) = &mut recording.pv else { continue };
        let held = pv.values[pv.values.len() / 2];
        pv.values.fill(held);
        let diagnosis = judged(&recording);
        let rests = diagnosis.no_response.as_ref().is_some_and(|told| told.rest.is_some());
        let (class, basis) = (diagnosis.verdict.class, diagnosis.verdict.basis);
        still += usize::from(!rests && basis != Basis::ValvePosition);
        assert!(
            rests || basis == Basis::ValvePosition || class == VerdictClass::CannotTell,
            "{k}: {class:?}, {:?}",
            diagnosis.verdict.reasons
        );
    }
    assert!(still > 30, "{still}");
}
