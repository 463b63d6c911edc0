//! Words and codes for a controller's mode.

use crate::cells::number::{self, DecimalMark};
use stiction_diagnose::recording::Mode;

/// The modes that a mapping file can name.
pub const NAMES: [(&str, Mode); 4] = [
    ("auto", Mode::Automatic),
    ("cascade", Mode::Cascade),
    ("manual", Mode::Manual),
    ("other", Mode::Other),
];

/// The content of a mode cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Said {
    /// A mode.
    Mode(Mode),
    /// A mode by the common code of 0, 1 and 2, which some systems do not use.
    Code(Mode),
    /// Nothing: the cell is empty or bad.
    Nothing,
}

/// The content of `cell`, where the user's `words` take precedence; `None` if unknown.
pub fn of_cell(cell: &str, words: &[(String, Mode)], mark: DecimalMark) -> Option<Said> {
    let number = number::parse(cell, mark);
    let same = |word: &str| {
        word.eq_ignore_ascii_case(cell)
            || number.is_some_and(|n| number::parse(word, DecimalMark::Point) == Some(n))
    };
    if let Some((_, mode)) = words.iter().find(|(word, _)| same(word)) {
        return Some(Said::Mode(*mode));
    }
    if let Some(number) = number {
        return of_code(number);
    }
    if number::word(cell).is_some() {
        return Some(Said::Nothing);
    }
    let word = cell.to_ascii_uppercase();
    // Honeywell writes who set the mode in front of it. Foxboro and others write possible modes behind it.
    let word = word.trim_start_matches("B-").trim_start_matches("P-").trim();
    Some(Said::Mode(match word {
        "AUTO" | "AUT" | "A" | "AUTOMATIC" | "AUTOMATIK" => Mode::Automatic,
        "CAS" | "CASC" | "CASCADE" | "C" | "RCAS" | "REMOTE" | "R" | "RSP" | "RCASCADE"
        | "REMOTE CASCADE" | "BCAS" => Mode::Cascade,
        "MAN" | "MANUAL" | "M" | "HAND" | "MANUELL" => Mode::Manual,
        "IMAN" | "INIT" | "LO" | "ROUT" | "OOS" | "O/S" | "TRACK" | "TRK" | "TRACKING" | "OFF" => {
            Mode::Other
        }
        _ => return None,
    }))
}

/// The mode of the code `number`.
pub fn of_code(number: f64) -> Option<Said> {
    [(0.0, Mode::Manual), (1.0, Mode::Automatic), (2.0, Mode::Cascade)]
        .into_iter()
        .find(|(code, _)| *code == number)
        .map(|(_, mode)| Said::Code(mode))
}

/// The mode that a switch called `word`, without separators and in lower case, turns on. Ambiguous words count only
/// `behind_a_tag`.
pub fn of_switch(word: &str, behind_a_tag: bool) -> Option<Mode> {
    match word {
        "auto" | "aut" | "automatic" | "inauto" | "automatik" => Some(Mode::Automatic),
        "man" | "manual" | "inman" | "hand" => Some(Mode::Manual),
        "cas" | "casc" | "cascade" | "rcas" => Some(Mode::Cascade),
        // Foxboro, where 1 is automatic.
        "ma" if behind_a_tag => Some(Mode::Automatic),
        _ => None,
    }
}

/// The mode in the other position of a switch of `mode`.
pub fn switched_off(mode: Mode) -> Mode {
    if mode == Mode::Manual { Mode::Automatic } else { Mode::Manual }
}

/// Whether a switch is on, if `cell` is a switch position.
pub fn is_on(cell: &str) -> Option<bool> {
    match &*cell.to_ascii_lowercase() {
        "true" | "on" => Some(true),
        "false" | "off" => Some(false),
        // A whole number reads the same with either decimal mark.
        _ => match number::parse(cell, DecimalMark::Point) {
            Some(1.0) => Some(true),
            Some(0.0) => Some(false),
            _ => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_codes_and_what_the_user_says() {
        let own = [("3".to_owned(), Mode::Automatic), ("Rechner".to_owned(), Mode::Cascade)];
        let said = |cell| of_cell(cell, &own, DecimalMark::Point);
        for (cell, expected) in [
            ("AUTO", Some(Said::Mode(Mode::Automatic))),
            ("b-auto", Some(Said::Mode(Mode::Automatic))),
            ("Man", Some(Said::Mode(Mode::Manual))),
            ("rcas", Some(Said::Mode(Mode::Cascade))),
            ("IMAN", Some(Said::Mode(Mode::Other))),
            ("0", Some(Said::Code(Mode::Manual))),
            ("1.0", Some(Said::Code(Mode::Automatic))),
            ("2", Some(Said::Code(Mode::Cascade))),
            ("3.0", Some(Said::Mode(Mode::Automatic))),
            ("rechner", Some(Said::Mode(Mode::Cascade))),
            ("", Some(Said::Nothing)),
            ("I/O Timeout", Some(Said::Nothing)),
            ("16", None),
            ("warp", None),
        ] {
            assert_eq!(said(cell), expected, "{cell}");
        }
    }
}
