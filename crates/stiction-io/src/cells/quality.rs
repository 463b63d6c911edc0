//! Words and codes for the quality of samples.

use crate::cells::mode::{self, Codes};
use crate::cells::number::{self, DecimalMark};
use crate::remedy::{Remedy, Wording};
use crate::sheet::{Cells, Viewed};
use Quality::{Bad, Good, Missing, Uncertain};
use stiction_recording::recording::Quality;

/// The qualities that a mapping file can name.
pub const NAMES: [(&str, Quality); 3] = [("good", Good), ("uncertain", Uncertain), ("bad", Bad)];

/// The word or code and its quality in `text`, such as `0=good`.
///
/// # Errors
/// If the text is not of this form. The message lists the qualities.
pub fn of_option(text: &str) -> Result<(String, Quality), String> {
    super::meaning(text, &NAMES, "0=good")
}

/// The meaning of the numbers in a column of qualities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// OPC DA: the highest two of eight bits are 11 for good, 01 for uncertain, 00 for bad.
    OpcDa,
    /// OPC UA: the highest two of 32 bits are 00 for good, 01 for uncertain, else bad.
    OpcUa,
    /// 100 is good, 0 is bad.
    Confidence,
    /// 1 is good, 0 is bad.
    Validity,
    /// 1 is bad, 0 is good.
    Fault,
    /// 1 is uncertain, 0 is good.
    Doubt,
}

impl Code {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpcDa => "OPC DA codes",
            Self::OpcUa => "OPC UA status codes",
            Self::Confidence => "percent of confidence",
            Self::Validity => "1 or true for good, 0 or false for bad",
            Self::Fault => "1 or true for bad, 0 or false for good",
            Self::Doubt => "1 or true for uncertain, 0 or false for good",
        }
    }

    /// The code of a column of 1 and 0, or of true and false, from its name.
    fn of_flags(name: &str) -> Option<Self> {
        let ends = |ends: &[&str]| ends.iter().any(|end| ends_with(name, end));
        if ends(&["bad", "invalid", "badpvfl"]) {
            Some(Self::Fault)
        } else if ends(&["good", "valid", "validity"]) {
            Some(Self::Validity)
        } else {
            // PI Web API writes the last two beside it, which alone are no qualities.
            ends(&["questionable", "substituted", "annotated"]).then_some(Self::Doubt)
        }
    }

    /// The code of true and false in a column called `name`.
    fn of_truth(name: &str) -> Option<Self> {
        Self::of_flags(name).or_else(|| ends_with(name, "quality").then_some(Self::Validity))
    }

    /// The code of a column, from its name and all its numbers; `None` if several codes are possible. Between OPC UA
    /// and OPC DA, the larger number of codes decides. Numbers that OPC DA would all call bad may have another meaning:
    /// Wonderware writes 0 for good.
    fn of(name: &str, numbers: &[f64]) -> Option<Self> {
        let name = name.to_lowercase().replace(['_', ' '], "");
        let count = |of: &dyn Fn(f64) -> bool| numbers.iter().filter(|n| of(**n)).count();
        let ua = count(&|n| n != 0.0 && Self::OpcUa.has(n));
        let hundred = count(&|n| n == 100.0);
        let da = count(&|n| Self::OpcDa.has(n) && Self::OpcDa.quality(n) != Bad);
        let percent = count(&|n| Self::Confidence.has(n)) == numbers.len();
        let flags = Self::of_flags(&name);
        if flags.is_some() && count(&|n| Self::Validity.has(n)) == numbers.len() {
            flags
        } else if percent && (name.contains("conf") || hundred > 0) {
            Some(Self::Confidence)
        } else if ua > da || (da == 0 && name.contains("statuscode")) {
            Some(Self::OpcUa)
        } else if da > 0 {
            Some(Self::OpcDa)
        } else {
            None
        }
    }

    /// Whether a number is one of its codes.
    fn has(self, number: f64) -> bool {
        match self {
            Self::OpcDa => number.fract() == 0.0 && (0.0..=255.0).contains(&number),
            // The upper half is the code; the lower one has flags, of a value only where bit 10 says so.
            Self::OpcUa => {
                let is_value = |flags: f64| (flags as u32) & 0x3C00 == 0x0400;
                number.fract() == 0.0
                    && (0.0..=f64::from(u32::MAX)).contains(&number)
                    && (number == 0.0 || number >= 65_536.0 || is_value(number))
            }
            Self::Confidence => (0.0..=100.0).contains(&number),
            Self::Validity | Self::Fault | Self::Doubt => matches!(number, 0.0 | 1.0),
        }
    }

    fn quality(self, number: f64) -> Quality {
        let bits = number as u32;
        match self {
            Self::OpcDa => match bits & 0xc0 {
                0xc0 => Good,
                0x40 => Uncertain,
                _ => Bad,
            },
            Self::OpcUa => match bits >> 30 {
                0 => Good,
                1 => Uncertain,
                _ => Bad,
            },
            Self::Validity if number == 0.0 => Bad,
            Self::Fault if number != 0.0 => Bad,
            Self::Doubt if number != 0.0 => Uncertain,
            Self::Validity | Self::Fault | Self::Doubt => Good,
            Self::Confidence if number >= 100.0 => Good,
            Self::Confidence if number <= 0.0 => Bad,
            Self::Confidence => Uncertain,
        }
    }
}

/// Whether the name of a column, without brackets, ends with `word`.
fn ends_with(name: &str, word: &str) -> bool {
    name.split('(').next().is_some_and(|name| name.trim_end().to_lowercase().ends_with(word))
}

/// The content of a column of qualities.
#[derive(Debug)]
pub struct Column {
    /// One quality for each requested row.
    pub qualities: Vec<Quality>,
    /// The code of its numbers, if it has any.
    pub code: Option<Code>,
}

/// Reads the `rows` of a column of qualities called `name`. The user's `words` take precedence.
///
/// # Errors
/// The first cell that is not understood, with its row and the fault.
pub fn read(
    name: &str,
    cells: &Cells,
    rows: &[usize],
    words: &[(String, Quality)],
    mark: DecimalMark,
    wording: Wording,
) -> Result<Column, (usize, String)> {
    // Successive cells are mostly the same.
    let mut last: Option<(&str, QualityCell)> = None;
    let view = cells.view();
    let (flags, mut has_flags) = (Code::of_truth(name), false);
    let mut said = |row: usize| match &view {
        Viewed::Numbers(numbers) | Viewed::Times(numbers) => of_number(numbers[row], words),
        Viewed::Text(cells) => {
            let cell = &cells[row];
            let said = match last {
                Some((before, said)) if before == cell => said,
                _ => of_cell(cell, words, mark, flags),
            };
            has_flags |= is_flag(cell);
            last = Some((cell, said));
            said
        }
    };
    let said: Vec<QualityCell> = rows.iter().map(|row| said(*row)).collect();
    let numbers: Vec<f64> = said
        .iter()
        .filter_map(|s| if let QualityCell::Number(n) = s { Some(*n) } else { None })
        .collect();
    let code = if numbers.is_empty() { None } else { Code::of(name, &numbers) };
    let remedy = |word: &str| {
        format!(
            "give its meaning, as in {}, or leave the column out, as in {}",
            wording.of(Remedy::Quality { word: word.to_owned(), qualities: vec!["good", "bad"] }),
            wording.of(Remedy::map("ignore", name))
        )
    };
    let quality = |(row, said): (&usize, &QualityCell)| match (said, code) {
        (QualityCell::Quality(quality), _) => Ok(*quality),
        (QualityCell::Number(number), Some(code)) if code.has(*number) => Ok(code.quality(*number)),
        (QualityCell::Number(number), code) => {
            let other = numbers.iter().find(|other| *other != number);
            let number = number.to_string();
            let why = match (code, other) {
                (Some(code), _) => format!("is not one of the {} in the other rows", code.name()),
                (None, Some(other)) => format!("is an ambiguous quality code, like {other}"),
                (None, None) => "is an ambiguous quality code".to_owned(),
            };
            Err((*row, format!("{number} {why}; {}", remedy(&number))))
        }
        (QualityCell::Unknown, _) => {
            let cell = if let Viewed::Text(cells) = &view {
                number::shown(&cells[*row])
            } else {
                String::new()
            };
            let is_mode = mode::of_cell(&cell, &[], Codes::Common, mark).is_some();
            let offer = match is_mode {
                true => format!(
                    "if the column holds modes, give {}; otherwise ",
                    wording.of(Remedy::map("mode", name))
                ),
                false => String::new(),
            };
            Err((*row, format!("\"{cell}\" is not a known quality; {offer}{}", remedy(&cell))))
        }
    };
    let qualities = rows.iter().zip(&said).map(quality).collect::<Result<_, _>>()?;
    Ok(Column { qualities, code: code.or(flags.filter(|_| has_flags)) })
}

/// The quality that a text in a column called `name` says; uncertain for true and false of unknown meaning.
pub fn of_text(name: &str, cell: &str) -> Option<Quality> {
    match of_cell(cell, &[], DecimalMark::Point, Code::of_truth(name)) {
        QualityCell::Quality(quality) => Some(quality),
        _ => is_flag(cell).then_some(Uncertain),
    }
}

fn is_flag(cell: &str) -> bool {
    cell.eq_ignore_ascii_case("true") || cell.eq_ignore_ascii_case("false")
}

/// The content of one cell.
#[derive(Debug, Clone, Copy)]
enum QualityCell {
    Quality(Quality),
    Number(f64),
    Unknown,
}

fn of_number(number: f64, words: &[(String, Quality)]) -> QualityCell {
    let own =
        words.iter().find(|(word, _)| number::parse(word, DecimalMark::Point) == Some(number));
    match own {
        Some((_, quality)) => QualityCell::Quality(*quality),
        None if number.is_nan() => QualityCell::Quality(Missing),
        None => QualityCell::Number(number),
    }
}

fn of_cell(
    cell: &str,
    words: &[(String, Quality)],
    mark: DecimalMark,
    flags: Option<Code>,
) -> QualityCell {
    if let Some((_, quality)) = words.iter().find(|(word, _)| word.eq_ignore_ascii_case(cell)) {
        return QualityCell::Quality(*quality);
    }
    if let Some(code) = flags.filter(|_| is_flag(cell)) {
        let is_true = cell.eq_ignore_ascii_case("true");
        return QualityCell::Quality(code.quality(f64::from(u8::from(is_true))));
    }
    // In brackets it is no negative amount.
    if let Some(number) = number::parse(cell, mark).filter(|_| !cell.starts_with('(')) {
        return of_number(number, words);
    }
    let word = cell.to_lowercase();
    match (hexadecimal(&word), of_word(&word)) {
        (Some(said), _) => said,
        (None, Some(quality)) => QualityCell::Quality(quality),
        (None, None) => of_parts(&word, mark),
    }
}

/// The quality of a flag beside a number. PI marks questionable values. Of a flag of one or two letters, which may be a
/// unit, only the user knows the meaning.
pub fn of_flag(flag: &str, words: &[(String, Quality)]) -> Option<Quality> {
    match words.iter().find(|(word, _)| word.eq_ignore_ascii_case(flag)) {
        Some((_, quality)) => Some(*quality),
        None if flag == "?" => Some(Uncertain),
        None => of_word(&flag.to_lowercase()).filter(|_| flag.len() > 2),
    }
}

/// A hexadecimal code. Those of OPC UA have eight digits.
fn hexadecimal(word: &str) -> Option<QualityCell> {
    let digits = word.strip_prefix("0x")?;
    let code = u32::from_str_radix(digits, 16).ok()?;
    Some(match digits.len() {
        0..=4 => QualityCell::Number(f64::from(code)),
        _ => QualityCell::Quality(Code::OpcUa.quality(f64::from(code))),
    })
}

/// The parts of a cell such as `StatusCode(Good)`, `0x00000000 (Good)` or `192 [Good]`. A part in words counts more
/// than a number. Parts that contradict each other have no meaning.
fn of_parts(word: &str, mark: DecimalMark) -> QualityCell {
    let parts = || {
        word.split(['(', ')', '[', ']', ':', '=', ';'])
            .map(str::trim)
            .filter(|part| !part.is_empty())
    };
    if parts().count() < 2 && !word.starts_with(['(', '[']) {
        return QualityCell::Unknown;
    }
    let mut words = parts().filter_map(of_word);
    if let Some(first) = words.next() {
        return if words.all(|other| other == first) {
            QualityCell::Quality(first)
        } else {
            QualityCell::Unknown
        };
    }
    let mut codes = parts().filter_map(|part| {
        hexadecimal(part).or_else(|| number::parse(part, mark).map(QualityCell::Number))
    });
    codes.next().unwrap_or(QualityCell::Unknown)
}

/// The quality of a word in lower case, such as "good, non-specific", "uncertainlastusablevalue" or "opcgood".
fn of_word(word: &str) -> Option<Quality> {
    let bare = ["statuscode", "opcquality", "opc_quality", "opc", "quality", "status", "ua", "da"]
        .into_iter()
        .find_map(|start| word.strip_prefix(start))
        .map_or(word, |rest| rest.trim_start_matches(['.', '_', ' ', ':', '-']));
    let starts = |starts: &[&str]| starts.iter().any(|start| bare.starts_with(start));
    Some(match bare {
        "ok" | "g" | "normal" | "valid" | "raw" | "bon" | "valide" | "buena" | "bueno"
        | "buono" | "valido" | "goed" => Good,
        "u" => Uncertain,
        "b" => Bad,
        _ if starts(&["good", "gut", "gültig", "gueltig", "bonne"]) => Good,
        _ if starts(&["uncertain", "questionable", "doubtful", "suspect"]) => Uncertain,
        _ if starts(&["unsicher", "incertain", "substituted", "stale"]) => Uncertain,
        _ if starts(&["bad", "invalid", "not good", "notgood", "no good"]) => Bad,
        _ if starts(&["schlecht", "ungültig", "ungueltig", "mauvais", "nok"]) => Bad,
        _ => return number::word(word),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(name: &str, cells: &[&str]) -> Result<Vec<Quality>, (usize, String)> {
        let own = [("Handwert".to_owned(), Uncertain)];
        let cells = Cells::Text(cells.iter().copied().collect());
        let rows: Vec<usize> = (0..cells.len()).collect();
        read(name, &cells, &rows, &own, DecimalMark::Point, Wording::default())
            .map(|column| column.qualities)
    }

    #[test]
    fn words_and_codes() {
        let cases: [(&str, &[&str], &[Quality]); 25] = [
            ("q", &["StatusCode(Good)", "StatusCode(BadNoData)"], &[Good, Bad]),
            ("q", &["0x00000000 (Good)", "0x80050000 (BadCommunicationError)"], &[Good, Bad]),
            ("q", &["Good (0x0)", "192 (Good)", "[Good]", "OpcQuality.Good"], &[Good; 4]),
            (
                "q",
                &["StatusCode(0x40920000)", "Bad (Comm Fail)", "not good"],
                &[Uncertain, Bad, Bad],
            ),
            ("status", &["0", "3145728", "3145728"], &[Good, Good, Good]),
            // The flags of a value that a server calculated.
            ("status", &["0", "1026", "1073742850"], &[Good, Good, Uncertain]),
            ("status", &["1026"], &[Good]),
            ("q", &["0xC0", "0x40", "0x00"], &[Good, Uncertain, Bad]),
            ("Validity", &["1", "0"], &[Good, Bad]),
            ("quality", &["Good", "Bad", "uncertain", ""], &[Good, Bad, Uncertain, Missing]),
            (
                "quality",
                &["Good, non-specific", "I/O Timeout", "Handwert"],
                &[Good, Bad, Uncertain],
            ),
            ("quality", &["192", "0", "64", "216"], &[Good, Bad, Uncertain, Good]),
            ("quality", &["100", "0", "50"], &[Good, Bad, Uncertain]),
            ("confidence", &["0", "0"], &[Bad, Bad]),
            ("StatusCode", &["0", "0"], &[Good, Good]),
            ("status", &["0", "2147483648", "1073741824"], &[Good, Bad, Uncertain]),
            ("status", &["0x00000000", "0x80050000", "0x40920000"], &[Good, Bad, Uncertain]),
            ("quality", &["192", "192"], &[Good, Good]),
            ("Good", &["True", "false", ""], &[Good, Bad, Missing]),
            ("FIC1.PV.IsGood (column 3)", &["1", "0"], &[Good, Bad]),
            ("Quality (column 3)", &["TRUE", "FALSE"], &[Good, Bad]),
            ("FIC1.PV_BAD", &["FALSE", "TRUE"], &[Good, Bad]),
            ("PV invalid", &["0", "1"], &[Good, Bad]),
            ("Questionable", &["False", "True"], &[Good, Uncertain]),
            ("Good", &["Good", "Bad"], &[Good, Bad]),
        ];
        for (name, cells, expected) in cases {
            assert_eq!(told(name, cells).unwrap(), expected, "{name}: {cells:?}");
        }
    }

    #[test]
    fn what_is_not_decided_is_an_error() {
        for (cells, row, expected) in [
            (&["0", "0"][..], 0, "quality 0=good or bad"),
            (&["1", "0"], 0, "1 is an ambiguous quality code"),
            (&["0", "133", "0"], 0, "like 133; give its meaning, as in quality 0=good"),
            (
                &["good", "purple"],
                1,
                "\"purple\" is not a known quality; give its meaning, as in quality purple=good",
            ),
            (&["192", "192", "999"], 2, "999 is not one of the OPC DA codes"),
            (&["192", "192", "3145728"], 2, "3145728 is not one of the OPC DA codes"),
            (&["(Good) (Bad)"], 0, "is not a known quality"),
            (&["good", "-5"], 1, "-5 is an ambiguous"),
            (&["True"], 0, "\"True\" is not a known quality"),
        ] {
            let name = if cells == ["True"] { "status" } else { "quality" };
            let (at, message) = told(name, cells).unwrap_err();
            assert_eq!(at, row, "{cells:?}");
            assert!(message.contains(expected), "{message}");
        }
    }
}
