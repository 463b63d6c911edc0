//! Numeric cells, and the words that historians write instead of numbers.

use crate::names::list;
use crate::remedy::{Remedy, Wording};
use crate::sheet::{Cells, Column};
use stiction_recording::recording::Quality;

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

    /// Name, as an option gives it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Comma => "comma",
        }
    }

    /// The opposite mark, which then separates thousands.
    pub fn other(self) -> Self {
        match self {
            Self::Point => Self::Comma,
            Self::Comma => Self::Point,
        }
    }
}

impl std::str::FromStr for DecimalMark {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "." | "point" => Ok(Self::Point),
            "," | "comma" => Ok(Self::Comma),
            _ => Err(format!("\"{text}\" is not a decimal mark; give point or comma")),
        }
    }
}

/// Separators of thousands in addition to the mark that is not the decimal mark: blanks of all widths and apostrophes.
const SEPARATORS: [char; 6] = [' ', '\u{a0}', '\u{202f}', '\u{2009}', '\'', '\u{2019}'];

/// The finite number in `cell`, written with the decimal mark `mark` and possibly with separators of thousands.
pub fn parse(cell: &str, mark: DecimalMark) -> Option<f64> {
    // The standard library also reads "inf" and "nan".
    if !cell.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | ',')) {
        return parse(&plain(cell)?, mark);
    }
    let number: f64 = match mark {
        DecimalMark::Point => cell.parse().ok(),
        DecimalMark::Comma if cell.contains('.') => None,
        DecimalMark::Comma if cell.contains(',') => cell.replacen(',', ".", 1).parse().ok(),
        DecimalMark::Comma => cell.parse().ok(),
    }
    .or_else(|| grouped(cell, mark))?;
    number.is_finite().then_some(number)
}

/// Dashes that programs for texts write instead of a minus.
const MINUS: [char; 5] = ['\u{2212}', '\u{2013}', '\u{2010}', '\u{2011}', '\u{ff0d}'];

/// `cell` with a hyphen for a minus sign or for the brackets around a negative amount, and without the apostrophe before
/// a text of a spreadsheet. `None` if the text has none of these marks.
fn plain(cell: &str) -> Option<String> {
    let negative = cell.strip_prefix(MINUS);
    let negative = negative.or_else(|| cell.strip_prefix('(')?.strip_suffix(')'));
    let negative = negative.map(|digits| format!("-{digits}"));
    negative.or_else(|| cell.starts_with('\'').then(|| cell.trim_start_matches('\'').to_owned()))
}

/// The number in `cell`, if its digits before the decimal mark stand in groups of three.
fn grouped(cell: &str, mark: DecimalMark) -> Option<f64> {
    let (sign, digits) = match cell.strip_prefix(['+', '-']) {
        Some(digits) => (&cell[..1], digits),
        None => ("", cell),
    };
    let (whole, decimals) = match digits.split_once(mark.mark()) {
        Some((_, "")) => return None,
        Some((whole, decimals)) => (whole, decimals),
        None => (digits, "0"),
    };
    let only_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let separator = whole.chars().find(|c| !c.is_ascii_digit())?;
    if separator != mark.other().mark() && !SEPARATORS.contains(&separator) {
        return None;
    }
    let mut groups = whole.split(separator);
    let first = groups.next()?;
    if !matches!(first.len(), 1..=3) || first.starts_with('0') || !only_digits(decimals) {
        return None;
    }
    if !groups.all(|group| group.len() == 3 && only_digits(group)) {
        return None;
    }
    format!("{sign}{}.{decimals}", whole.replace(separator, "")).parse().ok()
}

/// Whether `cell` is a number in any notation.
pub fn looks_like(cell: &str) -> bool {
    parse(cell, DecimalMark::Point).or_else(|| parse(cell, DecimalMark::Comma)).is_some()
}

/// What a cell shows about the decimal mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shows {
    /// It is not a number.
    NoNumber,
    /// The number is the same with either mark.
    Nothing,
    /// It is a number only with this mark.
    Mark(DecimalMark),
    /// This is its only mark, with three digits behind it: the decimal mark, or a separator of thousands.
    Either(DecimalMark),
}

/// What `cell` shows about the decimal mark.
pub fn shows(cell: &str) -> Shows {
    if let Some(cell) = plain(cell) {
        return shows(&cell);
    }
    let digits = cell.strip_prefix(['+', '-']).unwrap_or(cell).as_bytes();
    let all = |digits: &[u8]| digits.iter().all(u8::is_ascii_digit);
    if let Some(at @ 1..=3) = digits.len().checked_sub(4)
        && let Some(mark) = [DecimalMark::Point, DecimalMark::Comma]
            .into_iter()
            .find(|mark| digits[at] == mark.mark() as u8)
        && digits[0] != b'0'
        && all(&digits[..at])
        && all(&digits[at + 1..])
    {
        return Shows::Either(mark);
    }
    if !digits.is_empty() && all(digits) {
        return Shows::Nothing;
    }
    match (parse(cell, DecimalMark::Point), parse(cell, DecimalMark::Comma)) {
        (None, None) => Shows::NoNumber,
        (Some(_), None) => Shows::Mark(DecimalMark::Point),
        (None, Some(_)) => Shows::Mark(DecimalMark::Comma),
        (Some(_), Some(_)) => Shows::Nothing,
    }
}

/// Whether a cell begins like a number but is none, such as a date. Its column holds no numbers.
pub fn starts_otherwise(cell: &str) -> bool {
    cell.starts_with(|c: char| c.is_ascii_digit()) && shows(cell) == Shows::NoNumber
}

/// The decimal mark of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Found {
    /// The mark.
    pub mark: DecimalMark,
    /// Whether some cell is a number only with this mark.
    pub is_sure: bool,
}

/// The decimal mark of a table. It is a comma if some cell is a number only with a comma, and none only with a point.
/// If both occur, it is the point, and other cells with a comma are refused when they are read. Without such a cell,
/// it is the first mark behind which all numbers have three digits.
pub fn decimal_mark(columns: &[Column]) -> Found {
    let (mut comma, mut either) = (false, None);
    for column in columns {
        let Cells::Text(cells) = &column.cells else { continue };
        let cells = cells.view();
        if cells.first().is_some_and(starts_otherwise) {
            continue;
        }
        for cell in cells.iter().filter(|cell| cell.contains(['.', ','])) {
            match shows(cell) {
                Shows::Mark(mark @ DecimalMark::Point) => return Found { mark, is_sure: true },
                Shows::Mark(DecimalMark::Comma) => comma = true,
                Shows::Either(mark) => either = either.or(Some(mark)),
                Shows::Nothing | Shows::NoNumber => {}
            }
        }
    }
    match comma {
        true => Found { mark: DecimalMark::Comma, is_sure: true },
        false => Found { mark: either.unwrap_or_default(), is_sure: false },
    }
}

/// The quality of a word instead of a number, if historians write it. The data archive of PI writes its errors as
/// `[-11059] No Good Data For Calculation`.
pub fn word(cell: &str) -> Option<Quality> {
    let word = cell.trim().to_ascii_lowercase();
    let is_code = || {
        let code = word.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        code.is_some_and(|(code, _)| code.parse::<i64>().is_ok())
    };
    Some(match &*word {
        "" | "null" | "nan" | "n/a" | "na" | "#n/a" | "#na" | "none" | "nil" | "?" | "no data"
        | "nodata" | "no sample" | "no value" | "missing" | "not available" | "pt created"
        | "point created" | "scan off" | "configure" | "1.#qnan" | "1.#ind" | "-1.#ind"
        | "-nan" | "nan(ind)" | "-nan(ind)" | "\\n" | "(null)" | "<null>" | "arc off-line"
        | "no result" | "#value!" | "#ref!" | "#name?" => Quality::Missing,
        "bad" | "bad input" | "bad quality" | "bad value" | "bad_value" | "badval"
        | "i/o timeout" | "io timeout" | "timeout" | "shutdown" | "comm fail" | "comm failure"
        | "comm error" | "no comm" | "not connect" | "not connected" | "over range"
        | "overrange" | "under range" | "underrange" | "out of range" | "intf shut"
        | "out of serv" | "out of service" | "calc failed" | "error" | "#div/0!" | "#num!"
        | "failed" | "bad data" | "calc off" | "inp outrange" | "dcs failed" | "invalid data"
        | "invalid float" | "equip fail" | "unit down" | "sample bad" | "access denied"
        | "1.#inf" | "-1.#inf" | "iop" | "oop" | "badpv" | "fehler" | "ausfall" => Quality::Bad,
        // Yokogawa writes seven dashes, and spreadsheets fill a narrow column.
        fill if fill.bytes().all(|b| b == b'-') => Quality::Missing,
        fill if fill.len() > 1 && fill.bytes().all(|b| b == b'#') => Quality::Missing,
        _ if is_code() => Quality::Bad,
        _ => return None,
    })
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

/// The number in `cell` and the flag beside it, as in `60.08 *`, `*60.08` or `60.08 (Bad)`. A flag in front has no letters:
/// `Digital State 254` is a word.
pub fn flagged(cell: &str, mark: DecimalMark) -> Option<(f64, &str)> {
    let behind = cell.trim_end_matches(|c: char| !c.is_ascii_digit());
    let before = cell.trim_start_matches(|c: char| !c.is_alphanumeric() && !"+-.,".contains(c));
    let (number, flag) = match behind.len() < cell.len() {
        true => (behind, &cell[behind.len()..]),
        false => (before, &cell[..cell.len() - before.len()]),
    };
    let flag = flag.trim_matches([' ', '(', ')', '[', ']']);
    let is_flag = !flag.is_empty() && !flag.starts_with(['.', ',', '#', '-']);
    parse(number, mark).filter(|_| is_flag).map(|number| (number, flag))
}

/// Whether `cell` may be a word for a bad or missing value that is not known.
pub fn is_unknown_word(cell: &str, mark: DecimalMark) -> bool {
    let digits = cell.trim_start_matches(['+', '-', '.', ',']);
    word(cell).is_none()
        && !looks_like(cell)
        && flagged(cell, mark).is_none()
        && !digits.starts_with(|c: char| c.is_ascii_digit())
}

/// The fault of a `cell` that is neither a number nor a known word, and the remedy. `unknown` are all such words of the
/// file.
pub fn refusal(cell: &str, mark: DecimalMark, unknown: Vec<String>, wording: Wording) -> String {
    let (cell, raw) = (&*shown(cell), cell);
    let plain = format!("write numbers like 1{}5 or 2e-3, without units", mark.mark());
    if parse(raw, mark.other()).is_some() {
        format!(
            "\"{cell}\" has a decimal \"{}\", but the other numbers of the file have \"{}\"; write all numbers \
             alike",
            mark.other().mark(),
            mark.mark()
        )
    } else if let Some((number, flag)) = flagged(raw, mark) {
        let (word, qualities) = (flag.to_owned(), vec!["good", "bad"]);
        let remedy = wording.of(Remedy::Quality { word, qualities });
        format!(
            "\"{cell}\" is not a finite number, but {number} with \"{flag}\"; {plain}, or give the meaning of this \
             flag, as in {remedy}"
        )
    } else if !is_unknown_word(raw, mark) {
        format!("\"{cell}\" is not a finite number; {plain}")
    } else {
        let others: Vec<&str> = unknown.iter().map(|word| &**word).filter(|w| *w != cell).collect();
        let (such, others) = match others.len() {
            0 => ("it is such a word", String::new()),
            _ => ("they are such words", format!(", like {} in other rows", list(&others))),
        };
        let remedy = wording.of(Remedy::BadText(unknown));
        format!(
            "\"{cell}\" is neither a number nor a known word for a bad or missing value{others}; if {such}, give \
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
            ("1,234.5", Some(1234.5), None),
            ("1.234,5", None, Some(1234.5)),
            ("-1.234.567,25", None, Some(-1_234_567.25)),
            ("12,345", Some(12_345.0), Some(12.345)),
            ("0.999", Some(0.999), None),
            ("1 234", Some(1234.0), Some(1234.0)),
            ("1\u{a0}234,5", None, Some(1234.5)),
            ("1\u{202f}234,5", None, Some(1234.5)),
            ("1'234.5", Some(1234.5), None),
            ("1\u{2019}234.5", Some(1234.5), None),
            ("1.23.456", None, None),
            ("1 23", None, None),
            ("1 234'567", None, None),
            ("1234,567.5", None, None),
            ("0,123.5", None, None),
            ("1,234.", None, None),
            ("1.234e3,5", None, None),
            ("inf", None, None),
            ("1e999", None, None),
            ("NaN", None, None),
            ("0x10", None, None),
            ("\u{2212}0.5", Some(-0.5), None),
            ("\u{2013}1\u{a0}234,5", None, Some(-1234.5)),
            ("'44.97", Some(44.97), None),
            ("(0.04)", Some(-0.04), None),
            ("(1,234.5)", Some(-1234.5), None),
            ("(-5)", None, None),
            ("(5", None, None),
            ("-(5)", None, None),
            ("\u{2212}", None, None),
            ("(0-100)", None, None),
            ("(Bad)", None, None),
            ("", None, None),
        ] {
            assert_eq!(parse(cell, DecimalMark::Point), point, "{cell}");
            assert_eq!(parse(cell, DecimalMark::Comma), comma, "{cell}");
        }
    }

    #[test]
    fn cells_show_their_mark_or_leave_it_open() {
        use DecimalMark::{Comma, Point};
        for (cell, expected) in [
            ("999", Shows::Nothing),
            ("1 000", Shows::Nothing),
            ("\u{2212}1.001", Shows::Either(Point)),
            ("2e-3", Shows::Nothing),
            ("1.001", Shows::Either(Point)),
            ("-999,000", Shows::Either(Comma)),
            ("0.001", Shows::Mark(Point)),
            ("60.06", Shows::Mark(Point)),
            ("1234.567", Shows::Mark(Point)),
            ("1.234.567", Shows::Mark(Comma)),
            ("1.234,5", Shows::Mark(Comma)),
            ("1,234.5", Shows::Mark(Point)),
            ("1 234,567", Shows::Mark(Comma)),
            ("1.2a4", Shows::NoNumber),
            ("", Shows::NoNumber),
            (".", Shows::NoNumber),
            ("\u{b0}.123", Shows::NoNumber),
        ] {
            assert_eq!(shows(cell), expected, "{cell}");
        }
    }

    #[test]
    fn words_are_bad_or_missing_and_never_numbers() {
        let missing = "|null|nan|n/a|na|#n/a|#na|none|nil|?|no data|nodata|no sample|no value|missing|\
                       not available|pt created|point created|scan off|configure|1.#qnan|-1.#ind|\
                       #value!|#ref!|#name?|1.#ind|-nan|nan(ind)|-nan(ind)|\\n|(null)|<null>|arc off-line|\
                       no result|####";
        let bad = "bad|bad input|bad quality|bad value|bad_value|badval|i/o timeout|io timeout|timeout|\
                   shutdown|comm fail|comm failure|comm error|no comm|not connect|not connected|\
                   over range|overrange|under range|underrange|out of range|intf shut|out of serv|\
                   out of service|calc failed|error|#div/0!|#num!|failed|bad data|calc off|inp outrange|\
                   dcs failed|invalid data|invalid float|equip fail|unit down|sample bad|access denied|\
                   1.#inf|-1.#inf|iop|oop|badpv|fehler|ausfall|\
                   [-11059] No Good Data For Calculation";
        for cell in missing.split('|') {
            assert_eq!(word(&cell.to_uppercase()), Some(Quality::Missing), "{cell}");
            assert!(!looks_like(cell), "{cell}");
        }
        for cell in bad.split('|') {
            assert_eq!(word(&cell.to_uppercase()), Some(Quality::Bad), "{cell}");
            assert!(!looks_like(cell), "{cell}");
        }
        for cell in ["-", "---", "-------"] {
            assert_eq!(word(cell), Some(Quality::Missing), "{cell}");
        }
        for cell in ["auto", "12", "[x] y", "good", "-a", "#", "info", "fail"] {
            assert_eq!(word(cell), None, "{cell}");
        }
    }

    #[test]
    fn flags_are_beside_a_number() {
        for (cell, expected) in [
            ("60.08 *", Some((60.08, "*"))),
            ("*60.08", Some((60.08, "*"))),
            ("? -60.08", Some((-60.08, "?"))),
            ("60.08 S", Some((60.08, "S"))),
            ("(0.5) (Bad)", None),
            ("60.08 (Bad)", Some((60.08, "Bad"))),
            ("1,234.5 [Good]", Some((1234.5, "Good"))),
            ("60.08", None),
            ("1.#IND", None),
            ("Digital State 254", None),
            ("Set 12", None),
            ("60.08 60.09", None),
            ("2025-03-14", None),
            ("12:30 PM", None),
            ("60.08 (192)", None),
            ("51 2,52 3", None),
            ("12.5-", None),
            ("", None),
        ] {
            assert_eq!(flagged(cell, DecimalMark::Point), expected, "{cell}");
        }
    }
}
