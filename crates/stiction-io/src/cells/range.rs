//! The range of a signal to a valve, from the user, from the file, or estimated.

use crate::remedy::{Remedy, Wording};
use stiction_diagnose::recording::{Channel, Range, RangeSource};

/// Tolerance, in percent, of a signal in percent below 0 and above 100. Controllers allow a few percent more for
/// their outputs.
const SLACK: f64 = 10.0;

/// The range of OP or VP, with notes for the user. `given` takes precedence over the range in the file, `told`, and
/// that over unit and values. A signal in percent needs no range.
pub fn of_valve_signal(
    name: &'static str,
    channel: &Channel,
    given: Option<(f64, f64)>,
    told: Option<(f64, f64)>,
    wording: Wording,
) -> stiction_model::Result<(Option<Range>, Option<String>)> {
    if let Some((low, high)) = given {
        return Ok((Some(Range::new(low, high, RangeSource::Given)?), None));
    }
    if let Some((low, high)) = told {
        return Ok((Some(Range::new(low, high, RangeSource::Metadata)?), None));
    }
    let unit = channel.unit.as_deref().unwrap_or("").to_lowercase();
    match &*unit {
        "%" | "pct" | "percent" => {
            return Ok((Some(Range::new(0.0, 100.0, RangeSource::Metadata)?), None));
        }
        "ma" => return Ok((Some(Range::new(4.0, 20.0, RangeSource::Metadata)?), None)),
        _ => {}
    }
    let usable = channel.values.iter().filter(|value| value.is_finite());
    let low = usable.clone().copied().fold(f64::INFINITY, f64::min);
    let high = usable.clone().copied().fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return Ok((None, None));
    }
    let give = |ends| wording.of(Remedy::Range { signal: name, ends });
    let between = || usable.clone().any(|value| (0.0..1.0).contains(value) && *value > 0.0);
    if low >= 0.0 && high <= 1.0 && between() {
        let note = format!(
            "{name} is between 0 and 1 and is interpreted as a fraction; if it is in percent, give {}",
            give(Some((0.0, 100.0)))
        );
        return Ok((Some(Range::new(0.0, 1.0, RangeSource::Estimated)?), Some(note)));
    }
    if low >= -SLACK && high <= 100.0 + SLACK {
        let negative = usable.clone().filter(|value| **value < 0.0).count();
        let note = if low >= 4.0 && high <= 20.0 {
            Some(format!(
                "{name} is between 4 and 20 and is interpreted as percent; if it is in mA, give {}",
                give(Some((4.0, 20.0)))
            ))
        } else if negative * 10 > usable.count() {
            Some(format!(
                "{name} is often below 0, like a deviation from its mean, and is interpreted as percent of span; if \
                 its scale is different, give {}",
                give(None)
            ))
        } else {
            None
        };
        return Ok((None, note));
    }
    let (low, high) = outward(low, high);
    let note = format!(
        "{name} is not in percent; its range is estimated from its values as {low} to {high}; if you know the range, \
         give {}",
        give(None)
    );
    Ok((Some(Range::new(low, high, RangeSource::Estimated)?), Some(note)))
}

/// Round limits that include 0 and all values, because instruments rarely have a range that fits the data exactly.
fn outward(low: f64, high: f64) -> (f64, f64) {
    let round = |value: f64| {
        let decade = 10f64.powf(value.abs().log10().floor());
        let steps = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
        let end = steps.iter().map(|step| step * decade).find(|end| *end >= value.abs());
        end.filter(|end| end.is_finite()).unwrap_or(value.abs()).copysign(value)
    };
    (if low < 0.0 { round(low) } else { 0.0 }, if high > 0.0 { round(high) } else { 0.0 })
}

/// The two numbers in a text such as `0..100`, `0 to 100`, `0,100` or `0 - 100`.
pub fn of_text(text: &str) -> Option<(f64, f64)> {
    let text = text.trim().trim_matches(['[', ']', '(', ')']);
    ["..", " to ", ",", ";", " - ", " "].iter().find_map(|between| {
        let (low, high) = text.split_once(between)?;
        let (low, high) = (low.trim().parse::<f64>().ok()?, high.trim().parse::<f64>().ok()?);
        (low.is_finite() && high.is_finite() && high > low).then_some((low, high))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimated(values: &[f64]) -> (Option<(f64, f64)>, bool) {
        let time = (0..values.len()).map(|k| k as f64).collect();
        let channel = Channel::new("OP", time, values.to_vec()).unwrap();
        let (range, note) =
            of_valve_signal("OP", &channel, None, None, Wording::default()).unwrap();
        (range.map(|range| (range.low, range.high)), note.is_some())
    }

    #[test]
    fn ranges_from_values() {
        for (values, range, noted) in [
            (&[20.0, 80.0][..], None, false),
            (&[-5.0, 104.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0], None, false),
            (&[0.2, 0.9], Some((0.0, 1.0)), true),
            (&[0.78, 1.23], None, false),
            (&[0.0, 0.0], None, false),
            (&[4.2, 19.0], None, true),
            (&[-1.0, 0.9], None, true),
            (&[391.2, 380.0], Some((0.0, 400.0)), true),
            (&[-300.0, 1100.0], Some((-300.0, 1500.0)), true),
            (&[f64::NAN], None, false),
        ] {
            assert_eq!(estimated(values), (range, noted), "{values:?}");
        }
    }

    #[test]
    fn ranges_from_text() {
        for text in ["0..100", "0,100", "0 to 100", "[0, 100]", "0 - 100", "0 100"] {
            assert_eq!(of_text(text), Some((0.0, 100.0)), "{text}");
        }
        for text in ["", "100", "100,0", "a,b", "0,inf"] {
            assert_eq!(of_text(text), None, "{text}");
        }
    }
}
