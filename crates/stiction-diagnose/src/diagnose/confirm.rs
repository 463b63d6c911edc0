//! The manual test that would settle it, sized from the data.
//!
//! With the controller in manual nothing but the valve answers a step of the OP. Steps of a third of
//! the suspected stick band up, and the same down: a valve that sticks does nothing for two or three
//! of them and then jumps, and again after the turn; a healthy one answers every step.

use super::reasons::digits;
use super::verdict::ConfirmingTest;
use crate::detect::Subject;
use crate::series::{mean, noise_std, quantile, span};

/// The smallest step that a positioner can be expected to resolve, percent of span.
const SMALLEST_STEP: f64 = 0.25;
/// The largest step that is asked for, percent of span.
const LARGEST_STEP: f64 = 5.0;
/// Steps a stick band is divided into.
const STEPS_IN_BAND: f64 = 3.0;

/// The test for a loop whose stick band is suspected to be `s` percent; without it, the typical travel
/// of the OP in a cycle stands for it. `None` if the OP never moves.
pub fn confirming_test(subject: &Subject<'_>, s: Option<f64>) -> Option<ConfirmingTest> {
    let segment = subject.segment;
    let travel = quantile(&segment.op, 0.95) - quantile(&segment.op, 0.05);
    let band = s.unwrap_or(0.5 * travel);
    if !(travel > 0.0 && band > 0.0 && band.is_finite()) {
        return None;
    }
    let step = readable((band / STEPS_IN_BAND).clamp(SMALLEST_STEP, LARGEST_STEP));
    // Enough to pass the band and see the valve follow for two steps more.
    let steps = ((band / step).ceil() as usize + 2).clamp(4, 12);
    let middle = mean(&segment.op);
    let up_first = middle < 50.0;
    // Half a cycle is longer than the loop's dead time and its main lag.
    let wait_s = match subject.period {
        Some(period) => (0.5 * period * segment.sample_time).max(10.0 * segment.sample_time),
        None => 60.0 * segment.sample_time,
    };
    let wait_s = readable(wait_s);
    let noise = segment.pv.as_deref().map(noise_std);
    let pv_change = segment.pv.as_deref().and_then(|pv| {
        // A cycle moves the valve by the OP's travel at most, and ends before the PV has answered in full:
        // a step that the valve follows changes the PV by this much or more.
        let change = step * span_without_tails(pv) / travel;
        (change.is_finite() && change > 0.0).then_some(change)
    });
    let (first, back) = if up_first { ("up", "down") } else { ("down", "up") };
    let mut instructions = vec![
        "Agree with the operator; put the controller in manual at its usual output and wait until the \
         PV is calm. If an oscillation dies out now, it was made in this loop."
            .to_owned(),
        format!(
            "Move the output {first} in {steps} steps of {step} %, waiting {} after each.",
            wait(wait_s)
        ),
        format!("Then the same {back}, {steps} steps of {step} %, and once more {first}."),
        match pv_change {
            Some(change) => format!(
                "A healthy valve answers every step, with about {} PV units or more. One that sticks does \
                 nothing for the first {} after each turn, then jumps.",
                digits(change),
                steps_until(band, step),
            ),
            None => format!(
                "A healthy valve answers every step. One that sticks does nothing for the first {} after \
                 each turn, then jumps.",
                steps_until(band, step)
            ),
        },
        "Watch the stem where it can be seen: a stem that moves while the PV does not points to the \
         sensor or the process, a stem that does not move to the valve, its positioner or its air supply."
            .to_owned(),
    ];
    if let (Some(change), Some(noise)) = (pv_change, noise)
        && change < 3.0 * noise
    {
        instructions.push(format!(
            "One step moves the PV by less than three times its noise ({}): average over the wait.",
            digits(noise)
        ));
    }
    Some(ConfirmingTest { step, steps, up_first, wait_s, pv_change, instructions })
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

fn wait(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s} s"),
        s if s < 7_200.0 => format!("{} min", digits(s / 60.0)),
        s => format!("{} h", digits(s / 3_600.0)),
    }
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
    fn numbers_are_readable() {
        assert_eq!(readable(1.37), 1.5);
        assert_eq!(readable(0.29), 0.3);
        assert_eq!(readable(93.0), 100.0);
        assert_eq!(digits(0.01234), "0.012");
        assert_eq!(digits(3.456), "3.5");
        assert_eq!(digits(456.7), "457");
    }
}
