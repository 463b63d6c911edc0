//! Numbers and times as text: the same in every sentence, on every page.

/// Largest reported certainty, percent: beyond it only "more than" and "less than" are reported.
const SUREST: f64 = 99.0;

/// The least probability, percent, of the graded word "probably sticks".
const PROBABLY: f64 = 80.0;

/// A share of one in percent, without claims of certainty. A smaller one is not rounded to the 80 % from which a valve
/// "probably sticks".
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p < PROBABLY && p.round() >= PROBABLY => format!("{:.0} %", p.floor()),
        p if p > SUREST => format!("more than {SUREST:.0} %"),
        p if p < 100.0 - SUREST => format!("less than {:.0} %", 100.0 - SUREST),
        p => format!("{p:.0} %"),
    }
}

/// A number with an uncertainty: two digits, because the third of an estimate is meaningless.
pub fn rough(value: f64) -> String {
    digits(value, 2)
}

/// A number that is set, such as a tuning: three digits.
pub fn set(value: f64) -> String {
    digits(value, 3)
}

/// The largest factor between two simulations that is reported. Beyond this factor, the loop counts as unstable.
pub const LARGEST_FACTOR: f64 = 20.0;

/// A factor: two digits, without an end beyond [`LARGEST_FACTOR`].
pub fn factor(value: f64) -> String {
    match value {
        large if large >= LARGEST_FACTOR => format!("{LARGEST_FACTOR} or more"),
        value => rough(value),
    }
}

/// A number for a spreadsheet: three significant digits, and all digits before the point.
pub fn cell(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() || size == 0.0 {
        return (value + 0.0).to_string();
    }
    if size < 1e-4 {
        return format!("{value:.2e}");
    }
    let decimals = (2 - size.log10().floor() as i32).max(0) as usize;
    without_zeros(&format!("{value:.decimals$}")).to_owned()
}

fn digits(value: f64, digits: i32) -> String {
    // Smaller values are rounding of a difference.
    if !value.is_finite() || value.abs() < 1e-12 {
        return if value.is_finite() { "0" } else { "unbounded" }.to_owned();
    }
    let unit = 10f64.powi(value.abs().log10().floor() as i32 + 1 - digits);
    let rounded = (value / unit).round() * unit;
    if !(1e-4..1e7).contains(&rounded.abs()) {
        let text = format!("{value:.*e}", digits as usize - 1);
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", without_zeros(mantissa));
    }
    let decimals = (digits - 1 - rounded.abs().log10().floor() as i32).max(0) as usize;
    without_zeros(&format!("{rounded:.decimals$}")).to_owned()
}

fn without_zeros(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// A number with four digits, without zeros at its end, and with a true minus sign.
pub fn number(value: f64) -> String {
    let size = value.abs();
    let text = if !value.is_finite() {
        return "–".to_owned();
    } else if size < 1e-12 {
        // Smaller values are rounding of a difference.
        "0".to_owned()
    } else if !(1e-4..1e7).contains(&size) {
        let text = format!("{value:.3e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        format!("{}e{exponent}", mantissa.trim_end_matches('0').trim_end_matches('.'))
    } else {
        let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.decimals$}");
        if decimals > 0 {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    };
    text.replace('-', "−")
}

/// Two limits, with as many digits as their distance justifies: `213 to 221`.
pub fn range(low: f64, high: f64) -> String {
    let width = high - low;
    if !(width.is_finite() && width > 0.0) {
        return format!("{} to {}", rough(low), rough(high));
    }
    let decimals = (1.0 - width.log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{low:.decimals$} to {high:.decimals$}")
}

/// A time in s as text: `74 s`, `12 min 30 s`, `4 h 20 min`, `2 d 3 h`.
pub fn time(seconds: f64) -> String {
    // The unit, the one below it, and the number of the upper unit from which the lower one is dropped.
    const UNITS: [(&str, f64, &str, f64, f64); 3] = [
        ("d", 86_400.0, "h", 3_600.0, 10.0),
        ("h", 3_600.0, "min", 60.0, 24.0),
        ("min", 60.0, "s", 1.0, 10.0),
    ];
    if seconds < 0.0 {
        return format!("-{}", time(-seconds));
    }
    let unit = UNITS.iter().find(|unit| seconds >= 1.999 * unit.1);
    let Some((name, size, small, part, most)) = unit else {
        return format!("{} s", rough(seconds));
    };
    let parts = (seconds / part).round();
    let whole = (parts * part / size).floor();
    let rest = parts - whole * size / part;
    if rest < 0.5 || whole >= *most {
        return format!("{} {name}", (seconds / size).round());
    }
    format!("{whole} {name} {rest} {small}")
}

/// The time with a true minus sign and non-breaking spaces.
pub fn unparted(seconds: f64) -> String {
    time(seconds).replace(' ', "\u{a0}").replace('-', "\u{2212}")
}

/// How often: `once`, `3 times`.
pub fn times(count: usize) -> String {
    if count == 1 { "once".to_owned() } else { format!("{count} times") }
}

/// A cardinal and its noun: `1 sample`, `3 samples`.
pub fn counted(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_or_three_digits() {
        for (value, text) in [
            (0.01234, "0.012"),
            (3.456, "3.5"),
            (456.7, "460"),
            (0.0, "0"),
            (99.7, "100"),
            (0.0996, "0.1"),
            (-3.96, "-4"),
            (4e-6, "4e-6"),
            (3e-14, "0"),
            (f64::INFINITY, "unbounded"),
        ] {
            assert_eq!(rough(value), text);
        }
        assert_eq!(
            (set(1.2345), set(378.4), set(0.25)),
            ("1.23".into(), "378".into(), "0.25".into())
        );
        assert_eq!(range(213.04, 221.3), "213.0 to 221.3");
        assert_eq!(range(-94.2, 462.0), "-94 to 462");
        assert_eq!((counted(1, "slip"), counted(2, "slip")), ("1 slip".into(), "2 slips".into()));
        assert_eq!([1.456, 19.6, 5580.0].map(factor), ["1.5", "20", "20 or more"]);
    }

    #[test]
    fn cells_have_three_digits_and_keep_whole_numbers() {
        for (value, text) in [
            (0.123_456_789, "0.123"),
            (0.999_7, "1"),
            (-2.345_6, "-2.35"),
            (86_412.7, "86413"),
            (1_772_409_600.0, "1772409600"),
            (100.0, "100"),
            (-0.0, "0"),
            (0.5, "0.5"),
            (0.000_012_345, "1.23e-5"),
        ] {
            assert_eq!(cell(value), text);
            assert!((text.parse::<f64>().unwrap() - value).abs() <= 0.005 * value.abs());
        }
    }

    #[test]
    fn numbers_have_four_digits_at_most() {
        for (value, want) in [
            (0.0, "0"),
            (100.0, "100"),
            (2.5, "2.5"),
            (59.999_99, "60"),
            (-6.543_21, "−6.543"),
            (123_456.0, "123456"),
            (0.012_345, "0.01235"),
            (1e-9, "1e−9"),
            (3e-14, "0"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(number(value), want);
        }
    }

    #[test]
    fn probabilities_are_never_certain() {
        for (p, text) in [
            (0.0, "less than 1 %"),
            (0.004, "less than 1 %"),
            (0.5, "50 %"),
            (0.796, "79 %"),
            (0.8, "80 %"),
            (0.934, "93 %"),
            (0.9999, "more than 99 %"),
        ] {
            assert_eq!(percent(p), text);
        }
    }

    #[test]
    fn times_are_as_people_say_them() {
        for (seconds, text) in [
            (0.35, "0.35 s"),
            (74.2, "74 s"),
            (750.0, "13 min"),
            (186.0, "3 min 6 s"),
            (15_600.0, "4 h 20 min"),
            (302_400.0, "3 d 12 h"),
            (-120.0, "-2 min"),
            (0.0, "0 s"),
        ] {
            assert_eq!(time(seconds), text);
        }
    }
}
