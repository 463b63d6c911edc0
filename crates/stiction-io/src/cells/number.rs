//! Numeric cells, and the words that historians write instead of numbers.

use crate::remedy::{Remedy, Wording};
use crate::sheet::{Cells, Column};
use stiction_diagnose::recording::Quality;

/// The decimal mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DecimalMark {
    /// As in 1.5.
    #[default]
    Point,
    /// As in 1,5.
    Comma,
}

impl DecimalMark {
    /// The mark itself.
    pub fn mark(self) -> char {
        match self {
            Self::Point => '.',
            Self::Comma => ',',
        }
    }
}

/// The finite number in `cell`, written with `mark`.
pub fn parse(cell: &str, mark: DecimalMark) -> Option<f64> {
    // The standard library also reads "inf" and "nan".
    if !cell.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | ',')) {
        return None;
    }
    let number: f64 = match mark {
        DecimalMark::Point => cell.parse().ok()?,
        DecimalMark::Comma if cell.contains('.') => return None,
        DecimalMark::Comma if cell.contains(',') => cell.replacen(',', ".", 1).parse().ok()?,
        DecimalMark::Comma => cell.parse().ok()?,
    };
    number.is_finite().then_some(number)
}

/// Whether `cell` is a number in any notation.
pub fn looks_like(cell: &str) -> bool {
    parse(cell, DecimalMark::Point).or_else(|| parse(cell, DecimalMark::Comma)).is_some()
}

/// The decimal mark of a table. It is a comma if some cell is a number only with a comma, and none only with a point.
/// If both occur, it is the point, and cells with a comma are refused when they are read.
pub fn decimal_mark(columns: &[Column]) -> DecimalMark {
    let mut comma = false;
    for column in columns {
        let Cells::Text(cells) = &column.cells else { continue };
        for cell in cells {
            if cell.contains('.') && parse(cell, DecimalMark::Point).is_some() {
                return DecimalMark::Point;
            }
            comma = comma || (cell.contains(',') && parse(cell, DecimalMark::Comma).is_some());
        }
    }
    if comma { DecimalMark::Comma } else { DecimalMark::Point }
}

/// Words for a missing value, in lower case.
const MISSING: [&str; 27] = [
    "",
    "null",
    "nan",
    "n/a",
    "na",
    "#n/a",
    "#na",
    "none",
    "nil",
    "-",
    "--",
    "---",
    "?",
    "no data",
    "nodata",
    "no sample",
    "no value",
    "missing",
    "not available",
    "pt created",
    "point created",
    "scan off",
    "configure",
    "1.#qnan",
    "-1.#ind",
    "#value!",
    "#ref!",
];

/// Words for a bad value, in lower case.
const BAD: [&str; 29] = [
    "bad",
    "bad input",
    "bad quality",
    "bad value",
    "bad_value",
    "badval",
    "i/o timeout",
    "io timeout",
    "timeout",
    "shutdown",
    "comm fail",
    "comm failure",
    "comm error",
    "no comm",
    "not connect",
    "not connected",
    "over range",
    "overrange",
    "under range",
    "underrange",
    "out of range",
    "intf shut",
    "out of serv",
    "out of service",
    "calc failed",
    "error",
    "#div/0!",
    "#num!",
    "failed",
];

/// The quality of a word instead of a number, if historians write it. The data archive of PI writes its errors as
/// `[-11059] No Good Data For Calculation`.
pub fn word(cell: &str) -> Option<Quality> {
    let word = cell.trim().to_ascii_lowercase();
    let is_code = || {
        let code = word.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        code.is_some_and(|(code, _)| code.parse::<i64>().is_ok())
    };
    if MISSING.contains(&word.as_str()) {
        Some(Quality::Missing)
    } else if BAD.contains(&word.as_str()) || is_code() {
        Some(Quality::Bad)
    } else {
        None
    }
}

/// A cell for messages, on one line and shortened, because a cell with an unclosed quote may be very long.
pub fn shown(cell: &str) -> String {
    const MOST: usize = 60;
    let mut shown: String =
        cell.chars().take(MOST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if cell.chars().nth(MOST).is_some() {
        shown.push('…');
    }
    shown
}

/// The fault of a `cell` that is neither a number nor a known word, and the remedy.
pub fn refusal(cell: &str, mark: DecimalMark, wording: Wording) -> String {
    let other = match mark {
        DecimalMark::Point => DecimalMark::Comma,
        DecimalMark::Comma => DecimalMark::Point,
    };
    let (cell, raw) = (&*shown(cell), cell);
    let digits = cell.trim_start_matches(['+', '-', '.', ',']);
    if parse(raw, other).is_some() {
        format!(
            "\"{cell}\" has a decimal \"{}\", but the other numbers of the file have \"{}\"; write all numbers \
             alike, without thousands separators",
            other.mark(),
            mark.mark()
        )
    } else if digits.starts_with(|c: char| c.is_ascii_digit()) {
        format!(
            "\"{cell}\" is not a finite number; write numbers like 1{}5 or 2e-3, without units or \
             thousands separators",
            mark.mark()
        )
    } else {
        let remedy = wording.of(Remedy::BadText(cell.to_owned()));
        format!(
            "\"{cell}\" is neither a number nor a known word for a bad or missing value; if it is such a word, give \
             {remedy}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_both_ways_of_writing() {
        for (cell, point, comma) in [
            ("1.5", Some(1.5), None),
            ("1,5", None, Some(1.5)),
            ("-2e-3", Some(-2e-3), Some(-2e-3)),
            ("+.5", Some(0.5), None),
            ("-,5", None, Some(-0.5)),
            ("1,234.5", None, None),
            ("1.234,5", None, None),
            ("1 234", None, None),
            ("inf", None, None),
            ("1e999", None, None),
            ("NaN", None, None),
            ("0x10", None, None),
            ("", None, None),
        ] {
            assert_eq!(parse(cell, DecimalMark::Point), point, "{cell}");
            assert_eq!(parse(cell, DecimalMark::Comma), comma, "{cell}");
        }
    }

    #[test]
    fn words_are_bad_or_missing_and_never_numbers() {
        for cell in MISSING {
            assert_eq!(word(&cell.to_uppercase()), Some(Quality::Missing), "{cell}");
            assert!(!looks_like(cell), "{cell}");
        }
        for cell in BAD.into_iter().chain(["[-11059] No Good Data For Calculation"]) {
            assert_eq!(word(&cell.to_uppercase()), Some(Quality::Bad), "{cell}");
            assert!(!looks_like(cell), "{cell}");
        }
        for cell in ["auto", "12", "[x] y", "good"] {
            assert_eq!(word(cell), None, "{cell}");
        }
    }
}
