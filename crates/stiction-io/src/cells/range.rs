//! The range of a signal to a valve, from the user, from the file, or estimated.

use super::signals::{ANALOGUE, SCALED, Values};
use super::unit::{self, Unit};
use crate::remedy::{Remedy, Wording};
use stiction_recording::recording::{Channel, Range, RangeSource};
use stiction_recording::spoken;

/// Tolerance, in percent, of a signal in percent below 0 and above 100. Controllers allow a few percent more for
/// their outputs.
const SLACK: f64 = 10.0;
/// The widest plausible span of a quantity, in estimated spans (ours).
const WIDEST: f64 = 5.0;
/// Tolerance for values beyond the ends of a range whose unit is stated, as a share of its span.
const STATED: f64 = 0.1;
/// The least plausibility of a range of counts that is preferred to round ends (ours).
const LEAST_PLAUSIBILITY: f64 = 0.1;
/// A quantity rarely swings by more than this share of a span that does not begin at 0 (ours).
const SWING: f64 = 0.2;

/// The range of OP or VP, with notes for the user. `given` takes precedence over the range in the file, `told`, and
/// that over unit and values. A signal that is certainly in percent needs no range.
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
    let unit = channel.unit.as_deref().unwrap_or("").trim();
    if let Some((low, high)) = told.or_else(|| unit::range(unit)) {
        return Ok((Some(Range::new(low, high, RangeSource::Metadata)?), None));
    }
    let values = Values::of(&channel.values);
    let guess = match (unit::of(unit), values) {
        // Values that move within 0 to 1 are rather fractions. A signal that rests at an end shows nothing.
        (Unit::Share(full), Some(values)) if full > 1.0 && values.move_within_one() => {
            let sure = wording.of(Remedy::Range { signal: name, ends: Some((0.0, 1.0)) });
            let why = format!(
                "{name} is in {unit}, but is between 0 and 1 and is interpreted as a fraction ({sure} confirms this) with the range"
            );
            let guess = Guess::estimated((0.0, 1.0), why).or(&[(0.0, full)]);
            Some(Guess { example: Some((0.0, full)), ..guess })
        }
        // Values far outside contradict the unit.
        (Unit::Share(full), values)
            if values.is_none_or(|values| values.within((-full, 2.0 * full), STATED)) =>
        {
            return Ok((Some(Range::new(0.0, full, RangeSource::Metadata)?), None));
        }
        // Its usual range is certain.
        (Unit::Signal([(4.0, 20.0), ..]), values)
            if values.is_none_or(|values| values.within((4.0, 20.0), STATED)) =>
        {
            return Ok((Some(Range::new(4.0, 20.0, RangeSource::Metadata)?), None));
        }
        (_, None) => return Ok((None, None)),
        (Unit::Signal(usual), Some(values)) => {
            let place = usual.iter().position(|range| values.within(*range, STATED));
            place.map(|place| {
                let why = format!("{name} is in {unit}, and its range is assumed as the usual");
                Guess::assumed(usual[place], why).or(&usual[..place])
            })
        }
        (Unit::AnySignal(usual), Some(values)) => {
            let fits: Vec<(f64, f64)> =
                usual.iter().copied().filter(|range| values.within(*range, STATED)).collect();
            fits.first().map(|range| {
                let why = format!("{name} is in {unit}, and its range is assumed as");
                Guess::assumed(*range, why).or(&fits[1..])
            })
        }
        (Unit::Counts, Some(values)) => {
            Some(Guess::scaled(&values, format!("{name} is in counts, with a range estimated as")))
        }
        (Unit::Temperature | Unit::Quantity, Some(_)) => None,
        (Unit::None | Unit::Share(_), Some(values)) => match unstated(name, channel, &values) {
            Unstated::Percent => return Ok((None, None)),
            Unstated::Guess(guess) => Some(guess),
        },
    };
    let Some(values) = values else { return Ok((None, None)) };
    let is_temperature = unit::of(unit) == Unit::Temperature;
    let guess = guess.unwrap_or_else(|| Guess::quantity(name, unit, is_temperature, &values));
    let note = guess.note(name, wording);
    let (low, high) = guess.range;
    Ok((Some(Range::among(low, high, guess.source, guess.spans)?), Some(note)))
}

/// A range that neither the user nor the file states.
struct Guess {
    range: (f64, f64),
    source: RangeSource,
    /// The narrowest and the widest plausible span.
    spans: (f64, f64),
    /// Other ranges that fit.
    others: Vec<(f64, f64)>,
    /// The beginning of the note, before the range.
    why: String,
    /// The range that the remedy shows, if one stands out.
    example: Option<(f64, f64)>,
}

/// The meaning of values without a unit.
enum Unstated {
    /// They are certainly percent.
    Percent,
    /// They may be something else.
    Guess(Guess),
}

fn unstated(name: &'static str, channel: &Channel, values: &Values) -> Unstated {
    let usable = channel.values.iter().filter(|value| value.is_finite());
    let (low, high) = (values.low, values.high);
    let between = || usable.clone().any(|value| (0.0..1.0).contains(value) && *value > 0.0);
    if low >= 0.0 && high <= 1.0 && between() {
        let why =
            format!("{name} is between 0 and 1 and is interpreted as a fraction with the range");
        let guess = Guess::estimated((0.0, 1.0), why);
        return Unstated::Guess(Guess { example: Some((0.0, 100.0)), ..guess });
    }
    if !(low >= -SLACK && high <= 100.0 + SLACK) {
        let why = format!("{name} is not in percent and has no unit, so its range is estimated as");
        return Unstated::Guess(Guess::scaled(values, why));
    }
    let fits: Vec<(f64, f64)> = ANALOGUE.into_iter().filter(|range| values.fit(*range)).collect();
    if high > low
        && let Some(first) = fits.first()
    {
        let why = format!(
            "{name} is between {} and {}, has no unit, and is interpreted as percent with the range",
            spoken::number(low),
            spoken::number(high)
        );
        let guess = Guess::estimated((0.0, 100.0), why).or(&fits);
        return Unstated::Guess(Guess { example: Some(*first), ..guess });
    }
    let negative = usable.clone().filter(|value| **value < 0.0).count();
    if negative * 10 > usable.count() {
        let why = format!(
            "{name} is often below 0, like a deviation from its mean, and is interpreted as percent with the range"
        );
        return Unstated::Guess(Guess::estimated((0.0, 100.0), why));
    }
    Unstated::Percent
}

impl Guess {
    /// A range without alternatives.
    fn assumed(range: (f64, f64), why: String) -> Self {
        let span = range.1 - range.0;
        Self {
            range,
            source: RangeSource::Assumed,
            spans: (span, span),
            others: vec![],
            why,
            example: None,
        }
    }

    /// The range, estimated from the values alone.
    fn estimated(range: (f64, f64), why: String) -> Self {
        Self { source: RangeSource::Estimated, ..Self::assumed(range, why) }
    }

    /// The same with alternatives.
    fn or(mut self, others: &[(f64, f64)]) -> Self {
        for (low, high) in others {
            let span = high - low;
            self.spans = (self.spans.0.min(span), self.spans.1.max(span));
        }
        self.others.extend(others);
        self
    }

    /// A range of counts or scaled integers, else round ends.
    fn scaled(values: &Values, why: String) -> Self {
        let round = outward(values.low, values.high);
        let fits: Vec<_> = SCALED.into_iter().filter(|(range, _)| values.fit(*range)).collect();
        // The first of equally plausible ones counts.
        let best = fits
            .iter()
            .rev()
            .map(|each| (each.0, values.plausibility(*each)))
            .max_by(|(_, a), (_, b)| a.total_cmp(b))
            .filter(|(_, plausibility)| *plausibility >= LEAST_PLAUSIBILITY);
        let range = best.map_or(round, |(range, _)| range);
        let others: Vec<(f64, f64)> = fits
            .iter()
            .map(|(range, _)| *range)
            .chain([round])
            .filter(|each| *each != range)
            .collect();
        let guess = Self::estimated(range, why);
        match fits.is_empty() {
            true => Self { spans: (guess.spans.0, WIDEST * guess.spans.1), ..guess },
            false => guess.or(&others),
        }
    }

    /// The range of a quantity, as in the output of a master controller.
    fn quantity(name: &str, unit: &str, is_temperature: bool, values: &Values) -> Self {
        let range = outward(values.low, values.high);
        // Values that rest at 0.
        let range = if range.1 > range.0 { range } else { (range.0, range.0 + 1.0) };
        let master = if name == "OP" { ", as the output of a master controller" } else { "" };
        let why =
            format!("{name} is in {unit}{master}, so its range is unknown and is estimated as");
        let guess = Self::estimated(range, why);
        let (span, swing) = (guess.spans.0, values.high - values.low);
        let narrowest = if is_temperature { swing } else { swing / SWING };
        let narrowest = if narrowest > 0.0 { narrowest.min(span) } else { span };
        Self { spans: (narrowest, WIDEST * span), ..guess }
    }

    fn note(&self, name: &'static str, wording: Wording) -> String {
        /// Number of other ranges in a note.
        const MOST: usize = 4;
        let shown = |(low, high): &(f64, f64)| format!("{low} to {high}");
        let mut others: Vec<String> = self.others.iter().take(MOST).map(shown).collect();
        if self.others.len() > MOST {
            others.push("and others".to_owned());
        }
        let others = match &others[..] {
            [] => String::new(),
            some => format!(" ({} would fit, too)", some.join(", ")),
        };
        format!(
            "{} {}{others}; if the range is different, give {}",
            self.why,
            shown(&self.range),
            wording.of(Remedy::Range { signal: name, ends: self.example })
        )
    }
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
            (&[0.78, 1.23], Some((0.0, 100.0)), true),
            (&[0.0, 0.0], None, false),
            (&[4.2, 19.0], Some((0.0, 100.0)), true),
            (&[-1.0, 0.9], Some((0.0, 100.0)), true),
            (&[391.2, 380.0], Some((0.0, 1000.0)), true),
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
