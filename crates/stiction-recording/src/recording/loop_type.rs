//! The quantity that a loop controls.

use crate::error::{Error, Result};

/// The quantity that a loop controls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LoopType {
    /// Flow.
    Flow,
    /// Level.
    Level,
    /// Pressure.
    Pressure,
    /// Temperature.
    Temperature,
    /// Composition, pH, or any quality from an analyser.
    Analysis,
    /// Something else that is self-regulating.
    OtherSelfRegulating,
    /// Something else that integrates.
    OtherIntegrating,
    /// Unknown.
    #[default]
    Unknown,
}

/// Whether a process settles by itself under a constant input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dynamics {
    /// It settles.
    SelfRegulating,
    /// It continues to rise or fall.
    Integrating,
    /// Unknown.
    Unknown,
}

impl LoopType {
    /// All types, with the names that users write.
    pub const NAMES: [(&'static str, Self); 8] = [
        ("flow", Self::Flow),
        ("level", Self::Level),
        ("pressure", Self::Pressure),
        ("temperature", Self::Temperature),
        ("analysis", Self::Analysis),
        ("self-regulating", Self::OtherSelfRegulating),
        ("integrating", Self::OtherIntegrating),
        ("unknown", Self::Unknown),
    ];

    /// The type of that name; `analyser`, `concentration` and `composition` are names of analysis.
    ///
    /// # Errors
    /// If no type has this name.
    pub fn by_name(name: &str) -> Result<Self> {
        let lower = match &name.to_ascii_lowercase()[..] {
            "analyser" | "analyzer" | "concentration" | "composition" => "analysis".to_owned(),
            other => other.to_owned(),
        };
        Self::NAMES.iter().find(|(known, _)| *known == lower).map(|(_, found)| *found).ok_or_else(
            || Error::UnknownName {
                family: "loop type",
                name: name.to_owned(),
                known: Self::NAMES.map(|(name, _)| name).join(", "),
            },
        )
    }

    /// Name.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, each)| *each == self).map_or("unknown", |(name, _)| name)
    }

    /// The type by the letters of a tag after ISA-5.1, such as flow for `10FIC101`; unknown if the letters give
    /// none.
    ///
    /// The letters before the number of the loop count: the first is the measured quantity, and the remaining letters
    /// include a C.
    pub fn of_tag(tag: &str) -> Self {
        let words = tag.split(|c: char| !c.is_ascii_alphabetic()).filter(|word| word.len() >= 2);
        for word in words {
            let word = word.to_ascii_uppercase();
            let mut letters = word.chars();
            let first = letters.next();
            if word.len() > 4 || !letters.as_str().contains('C') {
                continue;
            }
            match first {
                Some('F') => return Self::Flow,
                Some('L') => return Self::Level,
                Some('P') => return Self::Pressure,
                Some('T') => return Self::Temperature,
                Some('A') => return Self::Analysis,
                _ => {}
            }
        }
        Self::Unknown
    }

    /// Whether such a process settles by itself. Most levels integrate. A pressure counts as self-regulating,
    /// although a large gas volume is not.
    pub fn dynamics(self) -> Dynamics {
        match self {
            Self::Level | Self::OtherIntegrating => Dynamics::Integrating,
            Self::Unknown => Dynamics::Unknown,
            _ => Dynamics::SelfRegulating,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_tell_types() {
        for (tag, expected) in [
            ("FIC101", LoopType::Flow),
            ("2111LIC31102B", LoopType::Level),
            ("LYCDU.RHT.7050-342_PIC112.PV", LoopType::Pressure),
            ("10-TRC-7", LoopType::Temperature),
            ("unit2/AIC90201", LoopType::Analysis),
            ("FI101", LoopType::Unknown),
            ("FACTORY", LoopType::Unknown),
            ("CHEM10", LoopType::Unknown),
            ("", LoopType::Unknown),
        ] {
            assert_eq!(LoopType::of_tag(tag), expected, "{tag}");
        }
    }

    #[test]
    fn names_lead_back() {
        for (name, each) in LoopType::NAMES {
            assert_eq!(LoopType::by_name(name).unwrap(), each);
            assert_eq!(each.name(), name);
        }
        assert!(LoopType::by_name("flo").unwrap_err().to_string().contains("flow, level"));
    }
}
