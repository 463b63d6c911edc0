//! The test that would settle it, sized from the data so that a plant can carry it out.
//!
//! # The kinds
//! * **Steps.** With the controller in manual nothing but the valve answers a step of the OP. Steps of a third of the
//!   suspected stick band up, and the same down: a valve that sticks does nothing for two or three of them and then
//!   jumps, and again after the turn; a healthy one answers every step.
//! * **Pulses**, for a loop that integrates: a level that is left with a step runs away. The OP goes away and back, each
//!   time further; the smallest pulse to which the level bends tells the stick band, and it is back where it was.
//! * **Set-point bumps**, where steps would take longer than a shift or further than the process bears: in automatic, and
//!   the OP's travel between the turn and the PV's answer is the stick band.
//! * **None in operation**, where even that would take longer than a day.
//!
//! # Limits
//! What the process bears is not known: the PV is kept within what was recorded and half as much again.

use super::verdict::{ConfirmingTest, TestKind};
use crate::methods::Subject;
use crate::recording::LoopType;
use crate::series::{max, mean, min, noise_std, quantile, span};
use crate::spoken::{range, rough, time};

/// The smallest step that a positioner can be expected to resolve, percent of span.
const SMALLEST_STEP: f64 = 0.25;
/// The largest step that is asked for, percent of span.
const LARGEST_STEP: f64 = 5.0;
/// Steps a stick band is divided into.
const STEPS_IN_BAND: f64 = 3.0;
/// The furthest that all steps together go, percent of span.
const FURTHEST: f64 = 15.0;
/// The longest that a test in manual takes, and one in automatic, s: half a shift, and a day.
const LONGEST: f64 = 4.0 * 3600.0;
const LONGEST_IN_AUTOMATIC: f64 = 24.0 * 3600.0;
/// The longest that a level is left with a pulse, s.
const LONGEST_PULSE: f64 = 600.0;
/// Set-point bumps, up and down.
const BUMPS: usize = 4;

/// The test for a loop whose stick band is suspected to be `s` percent; without it, the typical travel
/// of the OP in a cycle stands for it. `None` if the OP never moves.
pub fn confirming_test(subject: &Subject<'_>, s: Option<f64>) -> Option<ConfirmingTest> {
    let segment = subject.segment;
    let travel = quantile(&segment.op, 0.95) - quantile(&segment.op, 0.05);
    let band = s.unwrap_or(0.5 * travel);
    if !(travel > 0.0 && band > 0.0 && band.is_finite()) {
        return None;
    }
    let integrates = matches!(subject.loop_type, LoopType::Level | LoopType::OtherIntegrating);
    let step = readable((band / STEPS_IN_BAND).clamp(SMALLEST_STEP, LARGEST_STEP));
    // Enough to pass the band and see the valve follow for two steps more.
    let steps = ((band / step).ceil() as usize + 2).clamp(4, 12);
    let up_first = mean(&segment.op) < 50.0;
    // Half a cycle is longer than the loop's dead time and its main lag.
    let half_cycle_s = match subject.period {
        Some(period) => (0.5 * period * segment.sample_time).max(10.0 * segment.sample_time),
        None => 60.0 * segment.sample_time,
    };
    let far = steps as f64 * step;
    let in_manual_s = 2.0 * steps as f64 * half_cycle_s;
    let kind = match integrates {
        true if far <= FURTHEST => TestKind::Pulses,
        false if far <= FURTHEST && in_manual_s <= LONGEST => TestKind::Steps,
        _ if 2.0 * BUMPS as f64 * half_cycle_s <= LONGEST_IN_AUTOMATIC => TestKind::SetPointBumps,
        _ => TestKind::NoneInOperation,
    };
    let wait_s = readable(match kind {
        TestKind::Pulses => half_cycle_s.min(LONGEST_PULSE),
        TestKind::Steps | TestKind::NoneInOperation => half_cycle_s,
        TestKind::SetPointBumps => 2.0 * half_cycle_s,
    });
    let total_s = match kind {
        // A pulse, and as long again until the loop is calm.
        TestKind::Pulses => 3.0 * steps as f64 * wait_s,
        TestKind::Steps => 2.0 * steps as f64 * wait_s,
        TestKind::SetPointBumps => BUMPS as f64 * wait_s,
        TestKind::NoneInOperation => 0.0,
    };
    let pv_change = segment.pv.as_deref().and_then(|pv| {
        // A cycle moves the valve by the OP's travel at most, and ends before the PV has answered in full:
        // a step that the valve follows changes the PV by this much or more.
        let change = step * span_without_tails(pv) / travel;
        (change.is_finite() && change > 0.0).then_some(change)
    });
    let pv_within = segment.pv.as_deref().map(|pv| {
        let more = 0.5 * span(pv);
        [min(pv) - more, max(pv) + more]
    });
    let mut test = ConfirmingTest {
        kind,
        step,
        steps,
        up_first,
        wait_s,
        total_s,
        pv_change,
        pv_low: pv_within.map(|[low, _]| low),
        pv_high: pv_within.map(|[_, high]| high),
        instructions: vec![],
    };
    test.instructions = instructions(&test, band, segment.pv.as_deref().map(noise_std));
    Some(test)
}

fn instructions(test: &ConfirmingTest, band: f64, noise: Option<f64>) -> Vec<String> {
    let ConfirmingTest { step, steps, wait_s, pv_change, .. } = *test;
    let (first, back) = if test.up_first { ("up", "down") } else { ("down", "up") };
    let first_steps = steps_until(band, step);
    let last = rough(steps as f64 * step);
    let manual = "Agree with the operator; put the controller in manual at its usual output and wait until the \
                  PV is calm. If an oscillation dies out now, it was made in this loop.";
    let mut all = match test.kind {
        TestKind::Steps => vec![
            manual.to_owned(),
            format!(
                "Move the output {first} in {steps} steps of {step} %, waiting {} after each.",
                time(wait_s)
            ),
            format!(
                "Then the same {back}, {steps} steps of {step} %. All of it takes about {}.",
                time(test.total_s)
            ),
            match pv_change {
                Some(change) => format!(
                    "A healthy valve answers every step, with about {} PV units or more. One that sticks does \
                     nothing for the first {first_steps} after each turn, then jumps.",
                    rough(change),
                ),
                None => format!(
                    "A healthy valve answers every step. One that sticks does nothing for the first \
                     {first_steps} after each turn, then jumps."
                ),
            },
        ],
        TestKind::Pulses => vec![
            "Agree with the operator; put the controller in manual at its usual output while the PV is calm near \
             its set point. This loop integrates: no step is left standing."
                .to_owned(),
            format!(
                "Pulse the output {first} by {step} %: hold it for {} at most, go back, and see whether the PV \
                 bends. In automatic again until it is calm.",
                time(wait_s)
            ),
            format!(
                "The same with pulses {step} % higher each time, up to {last} %. All of it takes about {}.",
                time(test.total_s)
            ),
            format!(
                "A healthy valve bends the PV with every pulse. One that sticks does not answer the first \
                 {first_steps}; the smallest pulse that it answers is about as high as it sticks."
            ),
        ],
        TestKind::SetPointBumps => vec![
            format!(
                "Steps in manual would {} here. Stay in automatic; agree with the operator.",
                match steps as f64 * step > FURTHEST {
                    true => format!("move the output by {last} %, too far"),
                    false => "take longer than half a shift".to_owned(),
                }
            ),
            format!(
                "Move the set point {first} by {}, wait {}, then back; twice. All of it takes about {}.",
                pv_change.map_or("a little more than the PV swings".to_owned(), |change| format!(
                    "about {} PV units",
                    rough(STEPS_IN_BAND * change)
                )),
                time(wait_s),
                time(test.total_s)
            ),
            format!(
                "After each turn see how far the output travels before the PV begins to answer: nothing to speak of with \
                 a healthy valve, about {} % with one that sticks.",
                rough(band)
            ),
        ],
        TestKind::NoneInOperation => vec![format!(
            "This loop cannot be tested in normal operation: one answer takes about {}. Record the valve position, \
             or stroke the valve at the next stop in steps of {step} %.",
            time(wait_s)
        )],
    };
    if test.kind == TestKind::NoneInOperation {
        return all;
    }
    if let (Some(low), Some(high)) = (test.pv_low, test.pv_high) {
        all.push(format!(
            "Stop and go back to automatic if the PV leaves {}, or before an alarm does.",
            range(low, high)
        ));
    }
    all.push(
        "Watch the stem where it can be seen: a stem that moves while the PV does not points to the \
         sensor or the process, a stem that does not move to the valve, its positioner or its air supply."
            .to_owned(),
    );
    if let (Some(change), Some(noise)) = (pv_change, noise)
        && change < 3.0 * noise
    {
        all.push(format!(
            "One step moves the PV by less than three times its noise ({}): average over the wait.",
            rough(noise)
        ));
    }
    all
}

fn steps_until(band: f64, step: f64) -> String {
    match (band / step).round() as usize {
        0 | 1 => "step".to_owned(),
        n => format!("{n} steps"),
    }
}

/// Span of the PV without its rarest values.
fn span_without_tails(pv: &[f64]) -> f64 {
    let inner = quantile(pv, 0.95) - quantile(pv, 0.05);
    if inner > 0.0 { inner } else { span(pv) }
}

/// The nearest number of the series 1, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten.
fn readable(x: f64) -> f64 {
    const SERIES: [f64; 10] = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    let decade = 10f64.powf(x.log10().floor());
    let nearest = |a: &f64, b: &f64| {
        let distance = |v: f64| (x / decade / v).ln().abs();
        distance(*a).total_cmp(&distance(*b))
    };
    let chosen = SERIES.into_iter().min_by(nearest).unwrap_or(1.0) * decade;
    // As it is printed: 0.3, not 0.30000000000000004.
    format!("{chosen:.6}").parse().unwrap_or(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{LoopType, Segment};

    fn segment(amplitude: f64, middle: f64) -> Segment {
        let wave = |k: usize, phase: f64| (std::f64::consts::TAU * k as f64 / 40.0 + phase).sin();
        Segment {
            from: 0.0,
            sample_time: 2.0,
            op: (0..400).map(|k| middle + amplitude * wave(k, 0.0)).collect(),
            pv: Some((0..400).map(|k| 7.0 + 3.0 * wave(k, 1.0)).collect()),
            sp: None,
            vp: None,
            bridged: 0,
        }
    }

    #[test]
    fn steps_divide_the_band_and_go_away_from_the_nearer_limit() {
        let segment = segment(4.0, 30.0);
        let subject = Subject::new(&segment, LoopType::Flow, Some(40.0));
        let test = confirming_test(&subject, Some(6.0)).unwrap();
        assert_eq!((test.step, test.steps, test.up_first, test.wait_s), (2.0, 5, true, 40.0));
        // The PV's span over the OP's travel, for a step.
        let change = test.pv_change.unwrap();
        assert!((change / (2.0 * 6.0 / 8.0) - 1.0).abs() < 0.1, "{change}");
        assert!(test.instructions.len() >= 5);
        let high = self::segment(4.0, 80.0);
        let subject = Subject::new(&high, LoopType::Flow, Some(40.0));
        assert!(!confirming_test(&subject, Some(6.0)).unwrap().up_first);
    }

    #[test]
    fn a_test_is_possible_for_any_band_and_none_without_travel() {
        for s in [None, Some(0.01), Some(0.7), Some(40.0)] {
            let segment = segment(4.0, 50.0);
            let subject = Subject::new(&segment, LoopType::Unknown, None);
            let test = confirming_test(&subject, s).unwrap();
            assert!((SMALLEST_STEP..=LARGEST_STEP).contains(&test.step), "{test:?}");
            assert!(test.wait_s > 0.0 && (4..=12).contains(&test.steps));
        }
        let flat = segment(0.0, 50.0);
        assert_eq!(confirming_test(&Subject::new(&flat, LoopType::Flow, None), None), None);
    }

    #[test]
    fn a_plant_can_carry_it_out() {
        for loop_type in [LoopType::Flow, LoopType::Level, LoopType::Temperature] {
            for sample_time in [0.5, 5.0, 60.0, 600.0, 7_200.0] {
                for s in [0.3, 3.0, 12.0, 60.0] {
                    let segment = Segment { sample_time, ..segment(20.0, 50.0) };
                    let subject = Subject::new(&segment, loop_type, Some(40.0));
                    let test = confirming_test(&subject, Some(s)).unwrap();
                    let far = test.steps as f64 * test.step;
                    match test.kind {
                        TestKind::Steps => {
                            assert!(loop_type != LoopType::Level);
                            // A wait is rounded to a number that is read.
                            assert!(test.total_s <= 1.2 * LONGEST && far <= FURTHEST, "{test:?}");
                        }
                        TestKind::Pulses => {
                            assert_eq!(loop_type, LoopType::Level);
                            assert!(test.wait_s <= LONGEST_PULSE && far <= FURTHEST, "{test:?}");
                        }
                        TestKind::SetPointBumps => {
                            assert!(test.total_s <= 1.2 * LONGEST_IN_AUTOMATIC, "{test:?}");
                        }
                        TestKind::NoneInOperation => {
                            assert!(test.total_s == 0.0 && test.instructions.len() == 1);
                        }
                    }
                    let stops =
                        test.instructions.iter().any(|text| text.contains("back to automatic"));
                    assert_eq!(stops, test.kind != TestKind::NoneInOperation, "{test:?}");
                }
            }
        }
    }

    #[test]
    fn numbers_are_readable() {
        assert_eq!(readable(1.37), 1.5);
        assert_eq!(readable(0.29), 0.3);
        assert_eq!(readable(93.0), 100.0);
    }
}
