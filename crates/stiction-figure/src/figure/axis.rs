//! Ranges, ticks and tick labels.

use super::{Scale, clock};

/// One axis with its ends, ticks, and the factor or offset of its tick labels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub lo: f64,
    pub hi: f64,
    pub ticks: Vec<Tick>,
    /// Such as `×10⁶`, `+1000000` or the date of the first tick; mostly empty.
    pub note: String,
    pub scale: Scale,
}

/// A labelled place on an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub at: f64,
    pub label: String,
}

/// Smallest and largest of some values; the values of a checked figure are never empty.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)))
}

/// Whether two ends are too close for tick labels of a reasonable length.
pub(super) fn is_constant(lo: f64, hi: f64) -> bool {
    !(hi - lo > 1e-9 * lo.abs().max(hi.abs())) || hi - lo < 1e-290
}

/// Ends of an axis from `lo` to `hi`, with a margin of `pad` of the range on both sides.
///
/// A constant gets an axis around it with a size like its value.
pub(super) fn widened((lo, hi): (f64, f64), pad: f64) -> (f64, f64) {
    let margin = if is_constant(lo, hi) {
        let size = lo.abs().max(hi.abs());
        if size < 1e-280 { 1.0 } else { 0.1 * size }
    } else {
        pad * (hi - lo)
    };
    (lo - margin, hi + margin)
}

/// The ends, moved outwards to nearby round numbers, so that a record of 199.9 s gets a tick at 200 s.
pub(super) fn snapped((lo, hi): (f64, f64)) -> (f64, f64) {
    let near = 0.01 * (hi - lo);
    let step = Step::at_least((hi - lo) / 10.0).size();
    let (below, above) = ((lo / step).floor() * step, (hi / step).ceil() * step);
    (if lo - below <= near { below } else { lo }, if above - hi <= near { above } else { hi })
}

impl Axis {
    /// An axis from `lo` to `hi` with about `count` ticks at most.
    pub fn new((lo, hi): (f64, f64), count: usize, scale: Scale) -> Self {
        let special = match scale {
            Scale::Linear => None,
            Scale::Log => log_ticks(lo, hi, count).map(|ticks| (ticks, String::new())),
            Scale::Clock => clock::ticks(lo, hi, count),
            Scale::Names(names) => Some((named_ticks(lo, hi, names), String::new())),
        };
        let (ticks, note) = special.unwrap_or_else(|| ticks(lo, hi, count));
        Self { lo, hi, ticks, note, scale }
    }

    /// The position of `value`, 0 at the lower end and 1 at the upper one.
    pub fn fraction(&self, value: f64) -> f64 {
        if self.scale == Scale::Log {
            return (logarithm(value) - logarithm(self.lo))
                / (logarithm(self.hi) - logarithm(self.lo));
        }
        (value - self.lo) / (self.hi - self.lo)
    }
}

/// The logarithm of a value, also of values below the axis.
pub(super) fn logarithm(value: f64) -> f64 {
    value.max(f64::MIN_POSITIVE).log10()
}

/// A tick for each name between two ends.
fn named_ticks(lo: f64, hi: f64, names: &[&str]) -> Vec<Tick> {
    let tick = |(i, name): (usize, &&str)| Tick { at: i as f64, label: (*name).to_owned() };
    names.iter().enumerate().map(tick).filter(|tick| (lo..=hi).contains(&tick.at)).collect()
}

/// Ticks at powers of ten, or also at 2 and 5 times those if the range has few. `None` if there are fewer than two.
fn log_ticks(lo: f64, hi: f64, count: usize) -> Option<Vec<Tick>> {
    let (from, to) = (logarithm(lo) - 1e-9, logarithm(hi) + 1e-9);
    let powers = from.floor() as i32..=to.ceil() as i32;
    let inside = |tick: &Tick| (from..=to).contains(&logarithm(tick.at));
    let tick = |digit: i32, power: i32| {
        let at = times_ten_to(f64::from(digit), power);
        let label = if (-3..=4).contains(&power) {
            number(at, (-power).max(0) as usize)
        } else {
            let times = if digit == 1 { String::new() } else { format!("{digit}·") };
            format!("{times}10{}", power.to_string().chars().map(superscript).collect::<String>())
        };
        Tick { at, label }
    };
    let fine = powers.clone().flat_map(|p| [1, 2, 5].map(|digit| tick(digit, p)));
    let fine: Vec<Tick> = fine.filter(inside).collect();
    if (2..=count.max(4)).contains(&fine.len()) {
        return Some(fine);
    }
    let coarse: Vec<Tick> = powers.map(|p| tick(1, p)).filter(inside).collect();
    let stride = coarse.len().div_ceil(count.max(2));
    let coarse: Vec<Tick> = coarse.into_iter().step_by(stride.max(1)).collect();
    (coarse.len() >= 2).then_some(coarse)
}

/// A tick distance: 1, 2 or 5 times a power of ten.
#[derive(Clone, Copy)]
struct Step {
    digit: i64,
    exponent: i32,
}

impl Step {
    fn size(self) -> f64 {
        times_ten_to(self.digit as f64, self.exponent)
    }

    /// The smallest step that is at least `size`.
    fn at_least(size: f64) -> Self {
        let exponent = size.log10().floor() as i32;
        [(1, exponent), (2, exponent), (5, exponent)]
            .map(|(digit, exponent)| Self { digit, exponent })
            .into_iter()
            .find(|step| step.size() >= size * (1.0 - 1e-9))
            .unwrap_or(Self { digit: 1, exponent: exponent + 1 })
    }

    fn finer(self) -> Self {
        match self.digit {
            1 => Self { digit: 5, exponent: self.exponent - 1 },
            2 => Self { digit: 1, exponent: self.exponent },
            _ => Self { digit: 2, exponent: self.exponent },
        }
    }
}

/// `value` times a power of ten, exactly rounded for the small powers that labels need.
fn times_ten_to(value: f64, exponent: i32) -> f64 {
    if exponent < 0 { value / 10f64.powi(-exponent) } else { value * 10f64.powi(exponent) }
}

/// The ticks between `lo` and `hi`, and the note for their labels.
fn ticks(lo: f64, hi: f64, count: usize) -> (Vec<Tick>, String) {
    let mut step = Step::at_least((hi - lo) / count.max(1) as f64);
    let (first, last) = loop {
        let first = (lo / step.size() - 1e-6).ceil() as i64;
        let last = (hi / step.size() + 1e-6).floor() as i64;
        if last > first {
            break (first, last);
        }
        step = step.finer();
    };

    // All arithmetic of labels is in whole multiples of 10^exponent, so rounding is invisible.
    let e = step.exponent;
    let units: Vec<i64> = (first..=last).map(|i| i * step.digit).collect();
    let largest = units.iter().map(|u| u.abs()).max().unwrap_or(0);
    let offset = if largest >= 10_000_000 {
        let span = (last - first) * step.digit;
        let round = 10i64.pow(span.ilog10() + 1);
        units[0].div_euclid(round) * round
    } else {
        0
    };
    let rest = units.iter().map(|u| (u - offset).abs()).max().unwrap_or(0);
    let power = common_power(times_ten_to(rest as f64, e));
    let decimals = (power - e).max(0) as usize;
    let tick = |unit: &i64| Tick {
        at: times_ten_to(*unit as f64, e),
        label: number(times_ten_to((unit - offset) as f64, e - power), decimals),
    };
    (units.iter().map(tick).collect(), note(power, offset, e))
}

/// The power of ten (a multiple of 3) that labels up to `largest` leave out.
fn common_power(largest: f64) -> i32 {
    if largest == 0.0 || (1e-2..1e5).contains(&largest) {
        0
    } else {
        (largest.log10() / 3.0).floor() as i32 * 3
    }
}

fn note(power: i32, offset: i64, exponent: i32) -> String {
    let mut note = String::new();
    if power != 0 {
        note.push_str("×10");
        note.extend(power.to_string().chars().map(superscript));
    }
    if offset != 0 {
        let value = times_ten_to(offset as f64, exponent);
        let sign = if offset > 0 { "+" } else { "" };
        let gap = if note.is_empty() { "" } else { " " };
        let magnitude = value.abs();
        let text = if (1e-3..1e12).contains(&magnitude) {
            number(value, (-exponent).max(0) as usize)
        } else {
            format!("{value:e}").replace('-', "−")
        };
        let text = if text.contains('.') && !text.contains('e') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        };
        note.push_str(&format!("{gap}{sign}{text}"));
    }
    note
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32('⁰' as u32 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    }
}

/// A number with a true minus sign.
fn number(value: f64, decimals: usize) -> String {
    let value = if value == 0.0 { 0.0 } else { value };
    format!("{value:.decimals$}").replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(lo: f64, hi: f64, count: usize) -> (Vec<String>, String) {
        let axis = Axis::new((lo, hi), count, Scale::Linear);
        (axis.ticks.into_iter().map(|t| t.label).collect(), axis.note)
    }

    #[test]
    fn labels_are_what_one_would_write() {
        for (lo, hi, count, want, note) in [
            (0.0, 200.0, 6, &["0", "50", "100", "150", "200"][..], ""),
            (-1.05, 1.05, 5, &["−1.0", "−0.5", "0.0", "0.5", "1.0"], ""),
            (0.0, 2.5e6, 3, &["0", "1", "2"], "×10⁶"),
            (-3e-7, 0.0, 4, &["−300", "−200", "−100", "0"], "×10⁻⁹"),
            (0.93, 1.06, 2, &["0.95", "1.00", "1.05"], ""),
            (1e7, 1e7 + 0.4, 3, &["0.0", "0.2", "0.4"], "+10000000"),
            (-5e4, 5e4, 2, &["−50000", "0", "50000"], ""),
        ] {
            let (got, got_note) = labels(lo, hi, count);
            assert_eq!(
                (got, got_note.as_str()),
                (want.iter().map(|s| s.to_string()).collect(), note),
                "{lo} to {hi}"
            );
        }
    }

    #[test]
    fn any_range_has_at_least_two_short_labels() {
        for exponent in -280..=299 {
            for (a, b) in [(0.0, 1.0), (-0.3, 0.7), (9.999, 10.0), (1.0, 1.000_001), (-3.3, -1.1)] {
                let scale = 10f64.powi(exponent);
                let axis = Axis::new((a * scale, b * scale), 5, Scale::Linear);
                assert!(axis.ticks.len() >= 2, "{a} {b} e{exponent}");
                assert!(axis.ticks.len() <= 12, "{a} {b} e{exponent}");
                for tick in &axis.ticks {
                    assert!(tick.label.chars().count() <= 9, "{tick:?} {}", axis.note);
                    assert!((-1e-3..=1.001).contains(&axis.fraction(tick.at)));
                }
            }
        }
    }

    #[test]
    fn decades_are_labelled() {
        for (lo, hi, count, want) in [
            (0.5, 2000.0, 6, &["1", "10", "100", "1000"][..]),
            (3.0, 60.0, 6, &["5", "10", "20", "50"]),
            (1e-7, 2e6, 5, &["10⁻⁷", "10⁻⁴", "0.1", "100", "10⁵"]),
        ] {
            let axis = Axis::new((lo, hi), count, Scale::Log);
            let labels: Vec<&str> = axis.ticks.iter().map(|t| t.label.as_str()).collect();
            assert_eq!(labels, want);
            assert_eq!((axis.fraction(lo), axis.fraction(hi)), (0.0, 1.0));
            assert!(axis.fraction(-1.0).is_finite());
        }
    }

    #[test]
    fn constants_get_room() {
        for value in [0.0, 50.0, -3e-9, 1e299, -1e-300] {
            let (lo, hi) = widened((value, value), 0.05);
            assert!(lo < value && value < hi && !is_constant(lo, hi));
        }
    }
}
