//! Words and codes for the quality of samples.

use crate::cells::number::{self, DecimalMark};
use crate::remedy::{Remedy, Wording};
use crate::sheet::Cells;
use Quality::{Bad, Good, Missing, Uncertain};
use stiction_diagnose::recording::Quality;

/// The qualities that a mapping file can name.
pub const NAMES: [(&str, Quality); 3] = [("good", Good), ("uncertain", Uncertain), ("bad", Bad)];

/// The meaning of the numbers in a column of qualities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// OPC DA: the highest two of eight bits are 11 for good, 01 for uncertain, 00 for bad.
    OpcDa,
    /// OPC UA: the highest two of 32 bits are 00 for good, 01 for uncertain, else bad.
    OpcUa,
    /// 100 is good, 0 is bad.
    Confidence,
}

impl Code {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpcDa => "OPC DA codes",
            Self::OpcUa => "OPC UA status codes",
            Self::Confidence => "percent of confidence",
        }
    }

    /// The code of a column, from its name and all its numbers; `None` if they are ambiguous.
    fn of(name: &str, numbers: &[f64]) -> Option<Self> {
        let name = name.to_lowercase();
        let all = |of: &dyn Fn(f64) -> bool| numbers.iter().all(|number| of(*number));
        let any = |of: &dyn Fn(f64) -> bool| numbers.iter().any(|number| of(*number));
        if !all(&|n| n >= 0.0 && n.fract() == 0.0 && n <= f64::from(u32::MAX)) {
            // An OPC UA code in 32 bits with a sign.
            return None;
        }
        if any(&|n| n >= f64::from(0x4000_0000))
            || name.replace(['_', ' '], "").contains("statuscode")
        {
            Some(Self::OpcUa)
        } else if all(&|n| n <= 100.0) && (name.contains("confidence") || any(&|n| n == 100.0)) {
            Some(Self::Confidence)
        } else if all(&|n| n <= 255.0) && any(&|n| n >= 64.0) {
            Some(Self::OpcDa)
        } else {
            None
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
            Self::Confidence if number >= 100.0 => Good,
            Self::Confidence if number <= 0.0 => Bad,
            Self::Confidence => Uncertain,
        }
    }
}

/// The content of a column of qualities.
#[derive(Debug)]
pub struct Column {
    /// One for each requested row.
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
    let said = |row: usize| match cells {
        Cells::Numbers(numbers) | Cells::Times { seconds: numbers, .. } => {
            of_number(numbers[row], words)
        }
        Cells::Text(cells) => of_cell(&cells[row], words, mark),
    };
    let said: Vec<Said> = rows.iter().map(|row| said(*row)).collect();
    let numbers: Vec<f64> =
        said.iter().filter_map(|s| if let Said::Number(n) = s { Some(*n) } else { None }).collect();
    let code = if numbers.is_empty() { None } else { Code::of(name, &numbers) };
    let quality = |(row, said): (&usize, &Said)| match (said, code) {
        (Said::Quality(quality), _) => Ok(*quality),
        (Said::Number(number), Some(code)) => Ok(code.quality(*number)),
        (Said::Number(number), None) => Err((
            *row,
            format!(
                "{number} is an ambiguous quality code; define it in a mapping file, as in [quality] \"{number}\" = \
                 \"good\""
            ),
        )),
        (Said::Unknown, _) => {
            let cell = if let Cells::Text(cells) = cells {
                number::shown(&cells[*row])
            } else {
                String::new()
            };
            Err((
                *row,
                format!(
                    "\"{cell}\" is not a known quality; define it in a mapping file, as in [quality] \"{cell}\" = \
                     \"bad\", or leave the column out, as in {}",
                    wording.of(Remedy::map("ignore", name))
                ),
            ))
        }
    };
    let qualities = rows.iter().zip(&said).map(quality).collect::<Result<_, _>>()?;
    Ok(Column { qualities, code })
}

/// The content of one cell.
enum Said {
    Quality(Quality),
    Number(f64),
    Unknown,
}

fn of_number(number: f64, words: &[(String, Quality)]) -> Said {
    let own =
        words.iter().find(|(word, _)| number::parse(word, DecimalMark::Point) == Some(number));
    match own {
        Some((_, quality)) => Said::Quality(*quality),
        None if number.is_nan() => Said::Quality(Missing),
        None => Said::Number(number),
    }
}

fn of_cell(cell: &str, words: &[(String, Quality)], mark: DecimalMark) -> Said {
    if let Some((_, quality)) = words.iter().find(|(word, _)| word.eq_ignore_ascii_case(cell)) {
        return Said::Quality(*quality);
    }
    if let Some(number) = number::parse(cell, mark) {
        return of_number(number, words);
    }
    let word = cell.to_ascii_lowercase();
    if let Some(code) = word.strip_prefix("0x").and_then(|hex| u32::from_str_radix(hex, 16).ok()) {
        return Said::Quality(Code::OpcUa.quality(f64::from(code)));
    }
    // Such as "Good, non-specific", "Bad (Comm Fail)" or "UncertainLastUsableValue".
    let starts = |starts: &[&str]| starts.iter().any(|start| word.starts_with(start));
    if starts(&["good"]) || matches!(&*word, "ok" | "g" | "normal" | "valid" | "raw") {
        Said::Quality(Good)
    } else if starts(&["uncertain", "questionable", "doubtful", "suspect"]) || word == "u" {
        Said::Quality(Uncertain)
    } else if starts(&["bad", "invalid"]) || word == "b" {
        Said::Quality(Bad)
    } else {
        number::word(cell).map_or(Said::Unknown, Said::Quality)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(name: &str, cells: &[&str]) -> Result<Vec<Quality>, (usize, String)> {
        let own = [("Handwert".to_owned(), Uncertain)];
        let cells = Cells::Text(cells.iter().map(|cell| (*cell).into()).collect());
        let rows: Vec<usize> = (0..cells.len()).collect();
        read(name, &cells, &rows, &own, DecimalMark::Point, Wording::default())
            .map(|column| column.qualities)
    }

    #[test]
    fn words_and_codes() {
        let cases: [(&str, &[&str], &[Quality]); 9] = [
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
        ];
        for (name, cells, expected) in cases {
            assert_eq!(told(name, cells).unwrap(), expected, "{name}: {cells:?}");
        }
    }

    #[test]
    fn what_is_not_decided_is_an_error() {
        for (cells, row, expected) in [
            (&["0", "0"][..], 0, "[quality] \"0\" = \"good\""),
            (&["1", "0"], 0, "1 is an ambiguous quality code"),
            (&["good", "purple"], 1, "\"purple\" is not a known quality"),
            (&["good", "-5"], 1, "-5 is an ambiguous"),
        ] {
            let (at, message) = told("quality", cells).unwrap_err();
            assert_eq!(at, row, "{cells:?}");
            assert!(message.contains(expected), "{message}");
        }
    }
}
