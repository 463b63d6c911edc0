//! Time zones by name, from the database that comes with the program.

use jiff::tz::{Offset, TimeZone, TimeZoneDatabase};
use std::str::FromStr;

/// The zone of local times, such as `Europe/Berlin`, or an offset, such as `+01:00`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Zone {
    name: String,
    pub(super) zone: TimeZone,
}

impl Zone {
    /// As the user wrote it.
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl FromStr for Zone {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let fixed = || {
            let (sign, rest) = match name.split_at_checked(1)? {
                ("+", rest) => (1, rest),
                ("-", rest) => (-1, rest),
                _ => return None,
            };
            let (hours, minutes) = rest.split_once(':').unwrap_or((rest, "0"));
            let (hours, minutes): (i32, i32) = (hours.parse().ok()?, minutes.parse().ok()?);
            let fits = (0..24).contains(&hours) && (0..60).contains(&minutes);
            let offset = Offset::from_seconds(sign * (hours * 60 + minutes) * 60).ok();
            Some(TimeZone::fixed(offset.filter(|_| fits)?))
        };
        let zone = fixed().or_else(|| TimeZoneDatabase::bundled().get(name).ok());
        zone.map(|zone| Self { name: name.to_owned(), zone }).ok_or_else(|| {
            format!(
                "\"{name}\" is no time zone; give a name such as Europe/Berlin or America/Chicago, \
                 or an offset such as +01:00"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_offsets() {
        for name in
            ["Europe/Berlin", "america/chicago", "UTC", "Etc/GMT-1", "+01:00", "-5", "+05:30"]
        {
            assert_eq!(name.parse::<Zone>().unwrap().name(), name);
        }
        for name in ["", "Berlin", "+25:00", "+1:99", "+-1", "é", "CEST"] {
            assert!(name.parse::<Zone>().unwrap_err().contains("is no time zone"), "{name}");
        }
    }
}
