//! Words and codes for a controller's mode.

use crate::cells::number::{self, DecimalMark};
use stiction_recording::recording::Mode;

/// The modes that a mapping file can name.
pub const NAMES: [(&str, Mode); 4] = [
    ("auto", Mode::Automatic),
    ("cascade", Mode::Cascade),
    ("manual", Mode::Manual),
    ("other", Mode::Other),
];

/// The content of a mode cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ModeCell {
    /// A mode.
    Mode(Mode),
    /// A mode by the common code of 0, 1 and 2, which some systems do not use.
    Code(Mode),
    /// Nothing: the cell is empty or bad.
    Nothing,
}

/// The codes of modes in a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Codes {
    /// 0 manual, 1 automatic, 2 cascade.
    #[default]
    Common,
    /// The code of DeltaV: one bit for each mode.
    DeltaV,
}

impl Codes {
    /// The codes in a column called `name`. The name of DeltaV, or one of its codes that no common code equals,
    /// identifies this code. Other field bus devices use the same bits in the reverse order, under different names.
    pub fn of(name: &str, mut numbers: impl Iterator<Item = f64>) -> Self {
        let name = name.to_ascii_lowercase();
        let end = name.trim_end_matches(".cv").trim_end_matches(".f_cv");
        let named = ["mode.actual", "mode.target", "mode/actual", "mode/target"];
        let is_named = named.iter().any(|named| end.ends_with(named));
        match is_named && numbers.any(|n| n >= 8.0 && Self::DeltaV.mode(n).is_some()) {
            true => Self::DeltaV,
            false => Self::Common,
        }
    }

    /// The meaning of the codes, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Common => "0 manual, 1 automatic, 2 cascade",
            Self::DeltaV => "those of DeltaV, such as 8 manual, 16 automatic, 32 cascade",
        }
    }

    /// The mode of a code.
    pub fn mode(self, number: f64) -> Option<Mode> {
        let codes: &[(f64, Mode)] = match self {
            Self::Common => &[(0.0, Mode::Manual), (1.0, Mode::Automatic), (2.0, Mode::Cascade)],
            // The target of the last three also has the bit of automatic.
            Self::DeltaV => &[
                (1.0, Mode::Other),
                (2.0, Mode::Other),
                (4.0, Mode::Other),
                (8.0, Mode::Manual),
                (16.0, Mode::Automatic),
                (32.0, Mode::Cascade),
                (48.0, Mode::Cascade),
                (64.0, Mode::Cascade),
                (80.0, Mode::Cascade),
                (128.0, Mode::Other),
                (144.0, Mode::Other),
            ],
        };
        codes.iter().find(|(code, _)| *code == number).map(|(_, mode)| *mode)
    }
}

/// The word or code and its mode in `text`, such as `16=auto`.
///
/// # Errors
/// If the text is not of this form. The message lists the modes.
pub fn of_option(text: &str) -> Result<(String, Mode), String> {
    super::meaning(text, &NAMES, "16=auto")
}

/// The content of `cell`, where the user's `words` take precedence; `None` if unknown.
pub fn of_cell(
    cell: &str,
    words: &[(String, Mode)],
    codes: Codes,
    mark: DecimalMark,
) -> Option<ModeCell> {
    let number = number::parse(cell, mark);
    let same = |word: &str| {
        word.eq_ignore_ascii_case(cell)
            || number.is_some_and(|n| number::parse(word, DecimalMark::Point) == Some(n))
    };
    if let Some((_, mode)) = words.iter().find(|(word, _)| same(word)) {
        return Some(ModeCell::Mode(*mode));
    }
    if let Some(number) = number {
        return codes.mode(number).map(ModeCell::Code);
    }
    if number::word(cell).is_some() {
        return Some(ModeCell::Nothing);
    }
    let word = cell.to_uppercase().replace('Á', "A");
    // Honeywell writes who set the mode in front of it. Foxboro and others write possible modes behind it.
    let word = word.trim_start_matches("B-").trim_start_matches("P-").trim();
    Some(ModeCell::Mode(match word {
        "AUTO" | "AUT" | "A" | "AUTOMATIC" | "AUTOMATIK" | "AUTOMATISCH" | "AUTOMATIKBETRIEB"
        | "AUTOMATIQUE" | "AUTOMATICO" | "AUTOMATISK" | "AUTOMAATTI" | "AUTOMATYCZNY" => {
            Mode::Automatic
        }
        "CAS" | "CASC" | "CASCADE" | "C" | "RCAS" | "REMOTE" | "R" | "RSP" | "RCASCADE"
        | "REMOTE CASCADE" | "BCAS" | "KASKADE" | "KASK" | "EXTERN" | "CASCATA" | "CASCADA"
        | "KASKAD" | "BACKUP CASCADE" | "BACKUPCASCADE" | "PRD" => Mode::Cascade,
        "MAN" | "MANUAL" | "M" | "HAND" | "MANUELL" | "HANDBETRIEB" | "MANUEL" | "MANUELLE"
        | "MANUALE" | "MANU" => Mode::Manual,
        "IMAN" | "INIT" | "LO" | "ROUT" | "OOS" | "O/S" | "TRACK" | "TRK" | "TRACKING" | "OFF"
        | "NACHFÜHREN" | "AUS" | "NONE" => Mode::Other,
        _ => return None,
    }))
}

/// The mode that a switch called `word`, without separators and in lower case, turns on. Ambiguous words count only
/// `behind_a_tag`.
pub fn of_switch(word: &str, behind_a_tag: bool) -> Option<Mode> {
    match word {
        "auto" | "aut" | "automatic" | "inauto" | "automatik" => Some(Mode::Automatic),
        "man" | "manual" | "inman" | "hand" => Some(Mode::Manual),
        "cas" | "casc" | "cascade" | "rcas" => Some(Mode::Cascade),
        // The word for 1 may stand first or last, as in A/M, where 0 is mostly manual.
        "am" | "automan" | "automanual" | "manualauto" | "manauto" | "manaut" | "qmanaut" => {
            Some(Mode::Automatic)
        }
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
        let said = |cell| of_cell(cell, &own, Codes::Common, DecimalMark::Point);
        for (cell, expected) in [
            ("AUTO", Some(ModeCell::Mode(Mode::Automatic))),
            ("b-auto", Some(ModeCell::Mode(Mode::Automatic))),
            ("Man", Some(ModeCell::Mode(Mode::Manual))),
            ("rcas", Some(ModeCell::Mode(Mode::Cascade))),
            ("IMAN", Some(ModeCell::Mode(Mode::Other))),
            ("0", Some(ModeCell::Code(Mode::Manual))),
            ("1.0", Some(ModeCell::Code(Mode::Automatic))),
            ("2", Some(ModeCell::Code(Mode::Cascade))),
            ("3.0", Some(ModeCell::Mode(Mode::Automatic))),
            ("rechner", Some(ModeCell::Mode(Mode::Cascade))),
            ("", Some(ModeCell::Nothing)),
            ("I/O Timeout", Some(ModeCell::Nothing)),
            ("Kaskade", Some(ModeCell::Mode(Mode::Cascade))),
            ("manuel", Some(ModeCell::Mode(Mode::Manual))),
            ("Automático", Some(ModeCell::Mode(Mode::Automatic))),
            ("16", None),
            ("warp", None),
        ] {
            assert_eq!(said(cell), expected, "{cell}");
        }
    }

    #[test]
    fn codes_of_delta_v_only_by_its_name() {
        let of = |name: &str, codes: &[f64]| Codes::of(name, codes.iter().copied());
        for (name, codes, expected) in [
            ("FIC-1/PID1/MODE.ACTUAL", &[8.0, 16.0][..], Codes::DeltaV),
            ("FIC-1/PID1/MODE.TARGET.CV", &[48.0], Codes::DeltaV),
            ("mode.actual", &[1.0, 32.0], Codes::DeltaV),
            ("FIC-1/PID1/MODE.ACTUAL", &[0.0, 1.0, 2.0], Codes::Common),
            ("FIC-1/PID1/MODE_BLK.ACTUAL", &[8.0, 16.0], Codes::Common),
            ("FIC-1.MODE", &[8.0, 16.0], Codes::Common),
            ("FIC-1/PID1/MODE.ACTUAL", &[17.0], Codes::Common),
        ] {
            assert_eq!(of(name, codes), expected, "{name} {codes:?}");
        }
        assert_eq!(Codes::DeltaV.mode(1.0), Some(Mode::Other));
        assert_eq!(Codes::DeltaV.mode(16.0), Some(Mode::Automatic));
    }

    #[test]
    fn options_give_a_meaning() {
        assert_eq!(of_option("16=auto"), Ok(("16".to_owned(), Mode::Automatic)));
        assert_eq!(of_option("a=b = manual"), Ok(("a=b".to_owned(), Mode::Manual)));
        assert!(of_option("16").unwrap_err().contains("16=auto"));
        assert!(of_option("16=car").unwrap_err().contains("auto, cascade, manual, other"));
    }
}
