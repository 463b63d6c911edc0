//! Units of signals to a valve, and the ranges in which instruments send them.

/// The meaning of a unit for the range of a signal to a valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unit {
    /// There is none.
    None,
    /// The values are shares of the span, with this value at 100 %.
    Share(f64),
    /// The unit of a signal of instruments, with its usual ranges. The first that holds the values is assumed.
    Signal(&'static [(f64, f64)]),
    /// The first range that contains the values is assumed, if any of these ranges may be meant.
    AnySignal(&'static [(f64, f64)]),
    /// Counts of a converter.
    Counts,
    /// A temperature, whose range rarely begins at 0.
    Temperature,
    /// A different quantity, as in the output of a master controller.
    Quantity,
}

/// A unit in lower case without spaces, raised digits and the Greek micro.
fn plain(text: &str) -> String {
    text.to_lowercase()
        .chars()
        .filter(|c| !c.is_whitespace())
        .map(|c| match c {
            '²' => '2',
            '³' => '3',
            'µ' | 'μ' => 'u',
            c => c,
        })
        .collect()
}

/// Whether two texts are different units, and not two spellings of one unit.
pub fn differ(a: &str, b: &str) -> bool {
    let bare = |text| plain(text).replace("deg", "").replace('°', "");
    match (of(a), of(b)) {
        (Unit::None, _) | (_, Unit::None) => false,
        (Unit::Quantity | Unit::Temperature, _) => bare(a) != bare(b),
        (a, b) => a != b,
    }
}

/// The meaning of a unit in a file.
pub fn of(text: &str) -> Unit {
    match &*plain(text) {
        "" | "-" | "--" | "none" | "n/a" | "eu" | "unit" | "units" => Unit::None,
        "%" | "pct" | "pct." | "percent" | "prozent" | "perc" | "%open" | "%span" | "%auf"
        | "percentopen" | "percentofspan" | "%ofspan" | "pourcent" => Unit::Share(100.0),
        "‰" | "permille" | "promille" | "permil" => Unit::Share(1000.0),
        "fraction" | "frac" | "p.u." | "pu" | "perunit" | "1" | "0..1" | "0-1" => Unit::Share(1.0),
        "ma" | "madc" | "milliamp" | "milliamps" => Unit::Signal(&[(4.0, 20.0), (0.0, 20.0)]),
        "ua" => Unit::Signal(&[(4_000.0, 20_000.0), (0.0, 20_000.0)]),
        "psi" | "psig" | "lb/in2" | "lbf/in2" | "#" => {
            Unit::Signal(&[(3.0, 15.0), (6.0, 30.0), (3.0, 27.0)])
        }
        "bar" | "barg" | "bar(g)" => Unit::Signal(&[(0.2, 1.0), (0.4, 2.0)]),
        "mbar" | "mbarg" | "hpa" => Unit::Signal(&[(200.0, 1_000.0), (400.0, 2_000.0)]),
        "kpa" | "kpag" | "kpa(g)" => Unit::Signal(&[(20.0, 100.0), (40.0, 200.0)]),
        "mpa" | "mpag" => Unit::Signal(&[(0.02, 0.1), (0.04, 0.2)]),
        "pa" => Unit::Signal(&[(20_000.0, 100_000.0)]),
        "kg/cm2" | "kgf/cm2" | "kg/cm2g" | "kgf/cm2g" | "kg/cm2(g)" | "kp/cm2" => {
            Unit::Signal(&[(0.2, 1.0), (0.4, 2.0)])
        }
        "v" | "vdc" | "volt" | "volts" => {
            Unit::AnySignal(&[(1.0, 5.0), (0.0, 5.0), (0.0, 10.0), (2.0, 10.0)])
        }
        "mv" => Unit::AnySignal(&[
            (1_000.0, 5_000.0),
            (0.0, 5_000.0),
            (0.0, 10_000.0),
            (2_000.0, 10_000.0),
        ]),
        "deg" | "°" | "degree" | "degrees" | "grad" => Unit::Signal(&[(0.0, 90.0)]),
        "count" | "counts" | "cnt" | "cnts" | "cts" | "raw" | "digit" | "digits" | "int"
        | "bit" | "bits" | "lsb" | "adc" | "dac" | "rohwert" | "inkr" | "incr" => Unit::Counts,
        "°c" | "degc" | "c" | "°f" | "degf" | "f" | "k" | "kelvin" | "celsius" => {
            Unit::Temperature
        }
        _ => Unit::Quantity,
    }
}

/// The range and its unit in a text such as `3-15 psi`, `4..20mA` or `0..27648`.
pub fn range(text: &str) -> Option<(f64, f64)> {
    const BETWEEN: [&str; 8] = ["...", "..", "…", " to ", " bis ", "–", "-", "÷"];
    let text = text.trim();
    BETWEEN.iter().find_map(|between| {
        text.match_indices(between).find_map(|(at, _)| {
            let low: f64 = text[..at].trim().parse().ok()?;
            let rest = text[at + between.len()..].trim_start();
            let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
            let high: f64 = rest[..end].parse().ok()?;
            let unit = rest[end..].trim();
            let is_known = !matches!(of(unit), Unit::None | Unit::Quantity);
            // A name such as "OUT (1-2)" gives no range.
            let is_range = is_known || (unit.is_empty() && between.contains(['.', '…', 'o', 'i']));
            (low.is_finite() && high.is_finite() && high > low && is_range).then_some((low, high))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_in_their_spellings() {
        for (text, expected) in [
            ("", Unit::None),
            ("% open", Unit::Share(100.0)),
            ("Prozent", Unit::Share(100.0)),
            ("‰", Unit::Share(1000.0)),
            ("m3/h", Unit::Quantity),
            ("°C", Unit::Temperature),
            ("Counts", Unit::Counts),
        ] {
            assert_eq!(of(text), expected, "{text}");
        }
        for (text, usual) in [
            ("mA DC", (4.0, 20.0)),
            ("PSIG", (3.0, 15.0)),
            ("barg", (0.2, 1.0)),
            ("kPa", (20.0, 100.0)),
            ("kg/cm²", (0.2, 1.0)),
        ] {
            assert!(matches!(of(text), Unit::Signal([first, ..]) if *first == usual), "{text}");
        }
    }

    #[test]
    fn ranges_with_a_unit() {
        for (text, expected) in [
            ("3-15 psi", Some((3.0, 15.0))),
            ("4..20mA", Some((4.0, 20.0))),
            ("0..27648", Some((0.0, 27_648.0))),
            ("-100 to 100 %", Some((-100.0, 100.0))),
            ("0.2–1 bar", Some((0.2, 1.0))),
            ("1-2", None),
            ("20-4 mA", None),
            ("psi", None),
            ("m3/h", None),
            ("", None),
        ] {
            assert_eq!(range(text), expected, "{text}");
        }
    }
}
