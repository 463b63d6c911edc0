//! Instrument tags by ISA-5.1, with area, letters and loop number.

use crate::columns::role::SEPARATORS;

/// An instrument tag in parts, such as `10FIC101`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instrument {
    /// The part before the letters, such as `10`.
    area: String,
    /// The letters of the measured quantity, such as `F`, or `PD` for a differential pressure.
    measured: String,
    /// The number of the loop, and any suffix.
    number: String,
    kind: Kind,
}

/// The meaning of the letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Controller,
    Transmitter,
    Valve,
}

impl Instrument {
    /// The instrument in `name`: the last of its parts that is a tag of a controller, transmitter or valve.
    pub fn of(name: &str) -> Option<Self> {
        name.rsplit(['/', '\\', ':', '|', '#', '.', ' ', ']', '[', '_']).find_map(Self::of_part)
    }

    /// The beginning of `name` up to its tag, if only words follow: `Area A: FIC2106` of `Area A: FIC2106 Flow`.
    pub fn before_words(name: &str) -> Option<&str> {
        let is_end = |c: char| matches!(c, ' ' | '_');
        let mut ends = name.match_indices(is_end).map(|(at, _)| at).chain([name.len()]);
        let between = ['/', '\\', ':', '|', '#', '.', ' ', ']', '[', '_'];
        let after = |end: usize| name[..end].rfind(between).map_or(0, |at| at + 1);
        // The letters may stand before the number, as in TIC 300.
        let start = |end: usize| match after(end) {
            from if from > 1 && name[from..end].chars().all(|c| c.is_ascii_digit()) => {
                after(from - 1)
            }
            from => from,
        };
        let end = ends.rfind(|end| {
            Self::of_part(&name[start(*end)..*end]).is_some_and(|tag| tag.kind != Kind::Valve)
        })?;
        let is_word = |c: char| c.is_alphabetic() || matches!(c, ' ' | '_' | '-');
        name[end..].chars().all(is_word).then_some(&name[..end])
    }

    fn of_part(part: &str) -> Option<Self> {
        let part = part.to_uppercase();
        let end = part.rfind(|c: char| c.is_ascii_digit())? + 1;
        let before = part[..end].trim_end_matches(|c: char| c.is_ascii_digit());
        let number = &part[before.len()..];
        let tag = before.trim_end_matches(SEPARATORS);
        let area = tag.trim_end_matches(|c: char| c.is_ascii_uppercase());
        let letters = &tag[area.len()..];
        let kind = match letters.chars().last()? {
            'C' => Kind::Controller,
            'T' | 'I' => Kind::Transmitter,
            'V' => Kind::Valve,
            _ => return None,
        };
        let measured = &letters[..letters.len() - 1];
        let measured =
            measured.strip_suffix('C').filter(|_| kind == Kind::Valve).unwrap_or(measured);
        let measured = measured.strip_suffix('I').unwrap_or(measured);
        ((1..=2).contains(&measured.len())).then(|| Self {
            area: area.to_owned(),
            measured: measured.to_owned(),
            number: number.to_owned(),
            kind,
        })
    }

    /// The common key of the transmitter and the controller of a loop: area, measured quantity, number.
    pub fn loop_key(&self) -> (&str, &str, &str) {
        (&self.area, &self.measured, &self.number)
    }

    /// The area and number of the loop, which the position of its valve has, too.
    pub fn place(&self) -> (String, String) {
        (self.area.clone(), self.number.clone())
    }

    /// Whether this transmitter and that `controller` belong to one loop.
    pub fn measures_for(&self, controller: &Self) -> bool {
        self.kind == Kind::Transmitter
            && controller.kind == Kind::Controller
            && self.loop_key() == controller.loop_key()
    }

    /// Whether this is the valve of that `controller`.
    pub fn is_driven_by(&self, controller: &Self) -> bool {
        self.kind == Kind::Valve
            && controller.kind == Kind::Controller
            && self.loop_key() == controller.loop_key()
    }

    /// Whether this transmits the position of the valve of that `controller`.
    pub fn is_position_for(&self, controller: &Self) -> bool {
        self.kind == Kind::Transmitter
            && controller.kind == Kind::Controller
            && self.place() == controller.place()
            && self
                .measured
                .strip_suffix('Z')
                .is_some_and(|of| of.is_empty() || of == controller.measured)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transmitters_and_controllers_of_one_loop() {
        for (transmitter, controller, expected) in [
            ("10FT101.DACA", "10FC101.PIDA", true),
            ("U1/FIT-101A", "U1/FIC-101A", true),
            ("PDT7", "PDIC7", true),
            ("TT5", "TIC5", true),
            ("TI5", "TC5", true),
            ("10FT101", "20FC101", false),
            ("10FT101", "10LC101", false),
            ("10FT101", "10FC102", false),
            ("10FT101A", "10FC101B", false),
            ("10FC101", "10FC101", false),
            ("10FV101", "10FC101", false),
            ("10ZT101", "10FC101", false),
        ] {
            let pair = Instrument::of(transmitter).zip(Instrument::of(controller));
            let found = pair.as_ref().is_some_and(|(t, c)| t.measures_for(c));
            assert_eq!(found, expected, "{transmitter} and {controller}: {pair:?}");
        }
        for (tag, driven, position) in [
            ("FV101", true, false),
            ("FCV-101", true, false),
            ("FIC101/AO1", false, false),
            ("ZT101", false, true),
            ("FZI101", false, true),
            ("LZT101", false, false),
            ("ZT102", false, false),
            ("LV101", false, false),
            ("FT101", false, false),
        ] {
            let controller = Instrument::of("FIC101/PID1").unwrap();
            let tag = Instrument::of(tag).unwrap();
            let found = (tag.is_driven_by(&controller), tag.is_position_for(&controller));
            assert_eq!(found, (driven, position), "{tag:?}");
        }
        for (name, expected) in [
            ("Area A: FIC2106 Flow", Some("Area A: FIC2106")),
            ("FIC-2106", Some("FIC-2106")),
            ("U1/FIC2106_Valve", Some("U1/FIC2106")),
            ("FIC2106/PID1", None),
            ("FIC2106 Flow 2", None),
            ("Room Flow", None),
        ] {
            assert_eq!(Instrument::before_words(name), expected, "{name}");
        }
        for name in ["", "Room", "101", "PID1", "ü1", "10"] {
            assert_eq!(Instrument::of(name), None, "{name}");
        }
    }
}
