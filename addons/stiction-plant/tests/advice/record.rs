//! Advice on a recording, followed by the same loop recorded better.

use stiction_diagnose::diagnose::{
    Basis, Detectors, DiagnoseOptions, Diagnosis, Mismatch, VerdictClass, diagnose,
};
use stiction_diagnose::recording::fitness::{Class, MeasureId};
use stiction_diagnose::recording::{Mode, Modes, Recording};
use stiction_diagnose::series::{max, mean, min, quantile, span, std};
use stiction_model::closed_loop::NormalStream;
use stiction_population::position::{observed, positioned};
use stiction_population::{LoopKind, swinging_door};
use stiction_report::words::what_would_answer;

/// Sticking loops of the population whose plain recordings are accused.
const STICKING: [u64; 10] = [512, 538, 563, 595, 603, 617, 620, 636, 643, 646];

pub fn judged(recording: &Recording) -> Diagnosis {
    let detectors = Detectors::Only(vec![]);
    diagnose(recording, &DiagnoseOptions { detectors, ..DiagnoseOptions::default() }).unwrap()
}

/// The recordings of [`STICKING`] and what is found in them.
fn good() -> Vec<(Recording, Diagnosis)> {
    let of = |seed: u64| LoopKind::Sticky.simulate(seed).unwrap().recording;
    let all: Vec<_> = STICKING.into_iter().map(of).map(|good| (judged(&good), good)).collect();
    assert!(all.iter().all(|(found, _)| found.verdict.class == VerdictClass::Sticks));
    all.into_iter().map(|(found, good)| (good, found)).collect()
}

/// A sample of the documents: its SP is recorded and far from its OP.
fn sample() -> Recording {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/FIC101-sticky.csv");
    let read = stiction_io::reading::read(file.as_ref(), &Default::default()).unwrap();
    read.recordings.into_iter().next().unwrap()
}

fn values(of: &mut Option<stiction_diagnose::recording::Channel>) -> &mut Vec<f64> {
    &mut of.as_mut().unwrap().values
}

/// The recording with the mistake.
fn mistaken(mistake: Mismatch, mut of: Recording) -> Recording {
    let (op, pv) = (of.op.values.clone(), values(&mut of.pv).clone());
    let sp = values(&mut of.sp).clone();
    match mistake {
        Mismatch::Exchanged => (of.op.values, *values(&mut of.pv)) = (pv, op),
        Mismatch::SameSignal => {
            of.sp = None;
            *values(&mut of.pv) = op;
        }
        Mismatch::PvIsOp => *values(&mut of.pv) = op,
        Mismatch::OpIsPv => {
            // One sample late, as archived by another system.
            of.op.values[1..].copy_from_slice(&pv[..pv.len() - 1]);
        }
        Mismatch::SpAndOpExchanged => (of.op.values, *values(&mut of.sp)) = (sp, op),
        Mismatch::SpAndPvExchanged => (*values(&mut of.pv), *values(&mut of.sp)) = (sp, pv),
        Mismatch::Unrelated => {
            let mut noise = NormalStream::new(1);
            let (level, sd) = (mean(&pv), std(&pv));
            values(&mut of.pv).fill_with(|| level + sd * noise.draw());
        }
    }
    of
}

#[test]
fn right_columns_are_judged() {
    let right = judged(&sample());
    assert_eq!((right.verdict.class, right.mistaken()), (VerdictClass::Sticks, None));
    for mistake in Mismatch::ALL {
        let wrong = judged(&mistaken(mistake, sample()));
        assert_eq!(wrong.mistaken(), Some(mistake));
        let advice = what_would_answer(&wrong).unwrap().to_lowercase();
        assert!(
            advice.starts_with(mistake.remedy().to_lowercase().trim_end_matches('.')),
            "{advice}"
        );
    }
}

/// A recording with the defect that a measure finds, and the request for a better one.
fn spoilt(
    measure: MeasureId,
    good: &Recording,
    period_s: f64,
) -> Option<(Recording, &'static str)> {
    let mut of = good.clone();
    let dt = of.op.time[1] - of.op.time[0];
    let first = |seconds: f64| good.part(0.0, seconds, 0.0);
    // One sample in so many is kept, or held.
    let every = |per_cycle: f64| (period_s / dt / per_cycle).ceil().max(2.0) as usize;
    let pv = values(&mut of.pv);
    let words = match measure {
        MeasureId::Samples => return Some((first(150.0 * dt)?, "at least 200 samples")),
        MeasureId::Cycles => return Some((first(6.0 * period_s)?, "over at least ten cycles")),
        MeasureId::SamplesPerCycle => {
            let thin = |x: &[f64]| -> Vec<f64> { x.iter().step_by(every(6.0)).copied().collect() };
            let (op, pv) = (thin(&good.op.values), thin(pv));
            let thinned = Recording::regular("FIC1", dt * every(6.0) as f64, &op, Some(&pv), None);
            return Some((thinned.ok()?, "sampled at least every"));
        }
        MeasureId::OpMoves => {
            of.op.values.fill(50.0);
            "another time, in which the OP moves"
        }
        MeasureId::OpLevels => {
            let step = span(&of.op.values) / 6.0;
            of.op.values.iter_mut().for_each(|v| *v = (*v / step).round() * step);
            "with more digits"
        }
        MeasureId::PvLevels => {
            let step = span(pv) / 6.0;
            pv.iter_mut().for_each(|v| *v = (*v / step).round() * step);
            "with more digits"
        }
        MeasureId::OpAtLimit => {
            let [low, high] = [0.2, 0.8].map(|share| quantile(&of.op.values, share));
            of.op.values.iter_mut().for_each(|v| *v = v.clamp(low, high));
            "within their limits"
        }
        MeasureId::ClippedPv => {
            let [low, high] = [0.2, 0.8].map(|share| quantile(pv, share));
            pv.iter_mut().for_each(|v| *v = v.clamp(low, high));
            "within their limits"
        }
        MeasureId::CompressionFactor => {
            *pv = swinging_door(pv, 0.2 * span(pv));
            "without compression"
        }
        MeasureId::LongestFrozenPv => {
            let (from, length) = (pv.len() / 2, pv.len() / 6);
            let frozen = pv[from];
            pv[from..from + length].fill(frozen);
            "without compression"
        }
        MeasureId::PvUpdatesPerCycle => {
            *pv = (0..pv.len()).map(|k| pv[k / every(5.0) * every(5.0)]).collect();
            "without compression"
        }
        MeasureId::SetPoint => {
            let size = 2.0 * (max(pv) - min(pv));
            let step = |k: usize, n: usize| if (k * 4 / n).is_multiple_of(2) { size } else { 0.0 };
            let n = pv.len();
            pv.iter_mut().enumerate().for_each(|(k, v)| *v += step(k, n));
            of.sp.as_mut()?.values.iter_mut().enumerate().for_each(|(k, v)| *v += step(k, n));
            "with the set point at rest"
        }
        _ => return None,
    };
    Some((of, words))
}

/// The verdict of the good recording is known, so it is enough that the poor one asks for what the good one has.
#[test]
fn a_recording_without_the_defect_decides() {
    let good = good();
    for measure in MeasureId::ALL {
        let mut tried = 0;
        let asks = good.iter().find_map(|(good, found)| {
            let period_s = found.oscillation()?.1.period_s?;
            let (poor, words) = spoilt(*measure, good, period_s)?;
            tried += 1;
            let poor = judged(&poor);
            let advice = what_would_answer(&poor).filter(|advice| advice.contains(words))?;
            let is_worse = |of: &Diagnosis| {
                of.fitness.measures.iter().any(|m| m.id == *measure && m.class != Class::Fit)
            };
            assert!(is_worse(&poor) && !is_worse(found), "{}", measure.name());
            Some(advice)
        });
        match asks {
            // Where the record is unfit, the advice makes it fit; else nothing is promised.
            Some(advice) => {
                let imperative = advice.starts_with("Choose") || advice.starts_with("Record");
                assert!(imperative || advice.contains("may decide"), "{advice}");
            }
            None => assert_eq!(tried, 0, "{} asks for nothing", measure.name()),
        }
    }
}

#[test]
fn what_lacks_the_pv_or_automatic_is_judged_with_it() {
    let alone = Recording { pv: None, ..sample() };
    let advice = what_would_answer(&judged(&alone)).unwrap();
    assert!(advice.contains("with the PV") && advice.contains("may decide"), "{advice}");
    let mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Manual] });
    let advice = what_would_answer(&judged(&Recording { mode, ..sample() })).unwrap();
    assert!(advice.starts_with("Record OP, PV and SP in automatic"), "{advice}");
}

/// Eight times the record: the advice says "may", because some remain open.
#[test]
fn a_longer_record_decides_most_open_positions() {
    let (mut open, mut decided) = (0, 0);
    for index in 0..60 {
        let whole = positioned(33, index).unwrap();
        let end = whole.recording.op.time[whole.recording.op.time.len() - 1];
        let short = judged(&whole.recording.part(0.0, end / 8.0, 0.0).unwrap());
        let advice = what_would_answer(&short).unwrap_or_default();
        if short.verdict.basis != Basis::ValvePosition || !advice.starts_with("A longer record") {
            continue;
        }
        assert!(advice.contains("may decide"), "{advice}");
        let verdict = judged(&whole.recording).verdict;
        assert!(verdict.class != VerdictClass::Sticks || whole.truth.sticks);
        open += 1;
        decided += usize::from(verdict.class != VerdictClass::CannotTell);
    }
    assert!(open > 0 && 2 * decided > open, "{decided} of {open}");
}

#[test]
fn a_position_decides_many_open_loops() {
    let (mut open, mut decided, mut right) = (0, 0, 0);
    for k in 0..40 {
        let simulated = LoopKind::at((f64::from(k) + 0.5) / 40.0).simulate(500 + k as u64).unwrap();
        let found = judged(&simulated.recording);
        let advice = what_would_answer(&found).filter(|advice| advice.contains("valve position"));
        let Some(advice) = advice else { continue };
        assert!(["may decide", "can decide"].iter().any(|said| advice.contains(said)), "{advice}");
        let verdict = judged(&observed(&simulated, 500 + k as u64).unwrap()).verdict;
        open += 1;
        decided += usize::from(verdict.class != VerdictClass::CannotTell);
        right += usize::from(match verdict.class {
            VerdictClass::Sticks | VerdictClass::DoesNotRespond => simulated.truth.sticks,
            VerdictClass::DoesNotStick => {
                verdict.s_below.is_some_and(|limit| simulated.truth.s <= limit.value)
            }
            VerdictClass::CannotTell => false,
        });
    }
    assert!(3 * decided > open && 10 * right >= 9 * decided, "{right} of {decided} of {open}");
}
