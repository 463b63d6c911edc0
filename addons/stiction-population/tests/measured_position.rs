//! The verdict on valves whose position is recorded: against the truth, and against itself.

use rayon::prelude::*;
use stiction_diagnose::diagnose::{
    Basis, Detectors, DiagnoseOptions, Diagnosis, VerdictClass, by_position, diagnose,
};
use stiction_diagnose::finding::Decision;
use stiction_diagnose::methods::{MethodId, Subject};
use stiction_diagnose::recording::{Channel, Recording};
use stiction_population::position::{Positioned, observed, positioned};
use stiction_population::{LoopKind, member};

fn diagnosed(recording: &Recording) -> Diagnosis {
    diagnose(
        recording,
        &DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() },
    )
    .unwrap()
}

/// Verdict, S, J, limit, finding and words of one diagnosis, which must say the same.
fn contradictions(d: &Diagnosis) -> Vec<String> {
    let mut wrong = vec![];
    let mut must = |holds: bool, what: &str| {
        if !holds {
            wrong.push(format!("{}: {what}; {:?} {:?}", d.name, d.verdict, d.stiction));
        }
    };
    let subject = Subject::new(d.segment().unwrap(), d.loop_type, None);
    let direct = d.findings.iter().find(|f| f.method == MethodId::Direct.method()).unwrap();
    let Some(Ok(said)) = by_position(&subject, &d.fitness) else {
        must(d.verdict.basis != Basis::ValvePosition, "no position, yet it is the basis");
        must(!matches!(direct.decision, Decision::Sticks | Decision::DoesNotStick), "who decided?");
        return wrong;
    };
    if said.class == VerdictClass::CannotTell && d.verdict.basis == Basis::Evidence {
        must(d.verdict.class == VerdictClass::Sticks, "OP and PV may only accuse");
        must(d.verdict.reasons.contains(&direct.reason), "the position is not told");
        return wrong;
    }
    must(d.verdict.basis == Basis::ValvePosition, "the position is not the basis");
    must(d.verdict.class == said.class, "two verdicts");
    must(d.verdict.reasons[0] == direct.reason, "verdict and finding say different things");
    let cleared = d.verdict.class == VerdictClass::DoesNotStick;
    // A position that clears a valve does not hide that OP and PV accuse it.
    let accusation =
        |text: &String| cleared && text.starts_with("by OP and PV alone the valve sticks");
    must(d.verdict.contradictions.iter().all(accusation), "contradictions");
    must(d.stiction.s == said.stiction.s && d.stiction.j == said.stiction.j, "two estimates");
    let reason = &d.verdict.reasons[0];
    let (s, j) = (d.stiction.s, d.stiction.j);
    let defined = d.stiction.definitions.iter().find(|d| d.name == "S").and_then(|d| d.value);
    must(defined == s.map(|s| s.value), "two definitions of S");
    match d.verdict.class {
        VerdictClass::Sticks => {
            must(direct.decision == Decision::Sticks, "the finding disagrees");
            must(said.s_limit.is_none(), "a limit of what sticks");
            must(reason.contains("S = "), "words");
            if let (Some(s), Some(j)) = (s, j) {
                must(0.0 < s.low && s.low <= s.value && s.value <= s.high, "interval of S");
                must(0.0 <= j.low && j.low <= j.value && j.value <= j.high, "interval of J");
                must(s.value >= 0.4 && s.high.is_finite(), "S of a healthy valve");
                must(j.value <= s.value && j.high <= s.high, "J above S");
            } else {
                let why = d.stiction.why_not.as_deref().unwrap_or_default();
                must(why.contains("too wide for a number"), "no S or J");
            }
        }
        VerdictClass::DoesNotStick => {
            must(direct.decision == Decision::DoesNotStick, "the finding disagrees");
            must(s.is_none() && j.is_none(), "an S of a valve that does not stick");
            must(said.s_limit.is_some_and(|limit| limit < 1.0), "cleared without a limit");
            must(reason.contains("follows"), "words");
        }
        VerdictClass::DoesNotRespond => {
            must(direct.decision == Decision::Sticks, "the finding disagrees");
            must(
                s.is_none() && j.is_none() && said.s_limit.is_none(),
                "numbers of what never moved",
            );
            must(reason.contains("but the measured position"), "words");
        }
        _ => {
            must(direct.decision == Decision::Undecided, "the finding disagrees");
            must(s.is_none() && j.is_none(), "an S of what cannot be told");
            must(reason.contains("S may be up to"), "words");
        }
    }
    must(s.is_some() == d.stiction.why_not.is_none(), "why there is no number");
    wrong
}

/// Loops of both sources, by number.
fn loop_of(seed: u64, index: u64) -> Recording {
    match index % 3 {
        0 => observed(&member(seed, index).unwrap(), index).unwrap(),
        _ => positioned(seed, index).unwrap().recording,
    }
}

fn no_contradictions(seed: u64, count: u64) {
    let wrong: Vec<String> = (0..count)
        .into_par_iter()
        .flat_map_iter(|k| contradictions(&diagnosed(&loop_of(seed, k))))
        .collect();
    assert!(wrong.is_empty(), "{} of {count}: {:#?}", wrong.len(), &wrong[..wrong.len().min(5)]);
}

#[test]
fn verdict_numbers_and_words_agree() {
    no_contradictions(3, 200);
}

#[test]
#[ignore = "twenty minutes on two cores: the same over 20,000 loops, or as many as COUNT says"]
fn verdict_numbers_and_words_agree_on_thousands() {
    let count = std::env::var("COUNT").map_or(20_000, |n| n.parse().expect("a number"));
    no_contradictions(4, count);
}

/// A recording of every `by`th sample.
fn thinned(recording: &Recording, by: usize) -> Recording {
    let thin = |channel: &Channel| {
        let every = |x: &[f64]| x.iter().step_by(by).copied().collect();
        Channel::new("", every(&channel.time), every(&channel.values)).unwrap()
    };
    let [pv, sp, vp] = [&recording.pv, &recording.sp, &recording.vp].map(|c| c.as_ref().map(thin));
    Recording { op: thin(&recording.op), pv, sp, vp, ..recording.clone() }
}

#[test]
#[ignore = "minutes: the verdict with and without a position that is sampled more slowly than the controller acts"]
fn figures_by_steps_of_the_controller() {
    println!(
        "| steps | found, without VP | found | S within 15 % | limits broken | healthy: accused | healthy: cleared |"
    );
    println!("|---|---|---|---|---|---|---|");
    for steps in [1, 2, 4, 8] {
        let one = |k: u64| {
            let Positioned { recording, truth } = positioned(777_001, k).unwrap();
            let by = steps / truth.acts.min(steps);
            let serves = by * truth.acts == steps && recording.op.values.len() / by >= 200;
            serves.then(|| {
                let with = thinned(&recording, by);
                let without = diagnosed(&Recording { vp: None, ..with.clone() });
                (truth, diagnosed(&with), without)
            })
        };
        let seen: Vec<_> = (0..400).into_par_iter().filter_map(one).collect();
        let (sticks, healthy): (Vec<_>, Vec<_>) = seen.iter().partition(|(truth, ..)| truth.sticks);
        let found = |d: &Diagnosis| d.verdict.class == VerdictClass::Sticks;
        let cleared = |d: &Diagnosis| d.verdict.class == VerdictClass::DoesNotStick;
        let hits: Vec<_> = sticks.iter().filter(|(_, d, _)| found(d)).collect();
        let errors: Vec<f64> = hits
            .iter()
            .filter_map(|(truth, d, _)| Some((d.stiction.s?.value / truth.s - 1.0).abs()))
            .collect();
        let near = errors.iter().filter(|error| **error <= 0.15).count();
        let limits: Vec<bool> = sticks
            .iter()
            .filter_map(|(truth, d, _)| Some(d.verdict.s_below?.value < truth.s))
            .collect();
        let broken = limits.iter().filter(|is| **is).count();
        println!(
            "| {steps} | {} | {} of {} | {near} of {} | {broken} of {} | {} of {} | {} |",
            sticks.iter().filter(|(.., without)| found(without)).count(),
            hits.len(),
            sticks.len(),
            errors.len(),
            limits.len(),
            healthy.iter().filter(|(_, d, _)| found(d)).count(),
            healthy.len(),
            healthy.iter().filter(|(_, d, _)| cleared(d)).count(),
        );
    }
}

/// Of healthy valves behind any lag fewer than a hundredth may be accused; of 60 there is none.
#[test]
fn lags_are_not_taken_for_stiction() {
    let accused: Vec<String> = (0..150)
        .into_par_iter()
        .filter_map(|k| {
            let Positioned { recording, truth } = positioned(5, k).unwrap();
            let accused =
                !truth.sticks && diagnosed(&recording).verdict.class == VerdictClass::Sticks;
            accused.then(|| format!("{} {:?} lag {}", recording.name, truth.model, truth.lag))
        })
        .collect();
    assert!(accused.is_empty(), "{accused:?}");
}

/// Of valves whose band shows, nine of ten are found where every move is recorded, and S, where it is a number, is in its interval.
#[test]
fn bands_that_show_are_found() {
    let seen: Vec<(bool, Option<bool>)> = (0..150)
        .into_par_iter()
        .filter_map(|k| {
            let Positioned { recording, truth } = positioned(6, k).unwrap();
            let noise = truth.transmitter.noise.max(truth.op_noise);
            let noise = noise.max(truth.transmitter.quantum / 12f64.sqrt());
            let shows = truth.sticks && truth.acts == 1 && truth.slips >= 10;
            (shows && truth.s >= 3.0 * noise && truth.s >= 0.5).then(|| {
                let d = diagnosed(&recording);
                let inside = d.stiction.s.map(|s| s.low <= truth.s && truth.s <= s.high);
                (d.verdict.class == VerdictClass::Sticks, inside)
            })
        })
        .collect();
    let found = seen.iter().filter(|(found, _)| *found).count();
    let inside: Vec<bool> = seen.iter().filter_map(|(_, inside)| *inside).collect();
    let held = inside.iter().filter(|is| **is).count();
    assert!(seen.len() >= 20 && 3 * inside.len() >= 2 * found, "{} {found}", seen.len());
    assert!(10 * found >= 9 * seen.len(), "{found} of {}", seen.len());
    assert!(20 * held >= 17 * inside.len(), "{held} of {}", inside.len());
}

#[test]
fn a_position_that_never_moves_does_not_respond() {
    let loop_of = LoopKind::Sticky.simulate(11).unwrap();
    let n = loop_of.recording.op.values.len();
    let op: Vec<f64> = (0..n).map(|k| 50.0 + 15.0 * (0.02 * k as f64).sin()).collect();
    for noise in [0.0, 0.2] {
        let mut stream = stiction_model::closed_loop::NormalStream::new(1);
        let vp: Vec<f64> = (0..n).map(|_| 42.0 + noise * stream.draw()).collect();
        let mut recording = Recording::regular("still", 1.0, &op, None, None).unwrap();
        recording.vp = Some(Channel::new("VP", recording.op.time.clone(), vp).unwrap());
        let d = diagnosed(&recording);
        assert_eq!(d.verdict.class, VerdictClass::DoesNotRespond, "{:?}", d.verdict.reasons);
        assert_eq!(contradictions(&d), Vec::<String>::new());
    }
}

/// A position that belongs to another valve is not judged.
#[test]
fn a_position_of_another_valve_is_not_followed() {
    let (one, other) = (positioned(1, 0).unwrap().recording, positioned(1, 1).unwrap().recording);
    let n = one.op.values.len().min(other.op.values.len());
    let mut mixed = Recording::regular("mixed", 1.0, &one.op.values[..n], None, None).unwrap();
    let vp = other.vp.unwrap().values[..n].to_vec();
    mixed.vp = Some(Channel::new("VP", mixed.op.time.clone(), vp).unwrap());
    let d = diagnosed(&mixed);
    assert!(d.verdict.class != VerdictClass::Sticks, "{:?}", d.verdict.reasons);
    assert!(d.stiction.s.is_none());
}
