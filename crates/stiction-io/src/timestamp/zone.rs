//! Time zones by name, from the built-in database.

use jiff::Timestamp;
use jiff::tz::{Offset, TimeZone, TimeZoneDatabase};
use std::str::FromStr;
use stiction_recording::recording::PlantTime;

/// The zone of local times, such as `Europe/Berlin`, or an offset, such as `+01:00`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Zone {
    name: String,
    pub(super) zone: TimeZone,
}

impl Zone {
    /// The zone as the user wrote it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Clock at an instant, s since 1970-01-01 UTC.
    pub fn plant_time(&self, instant: f64) -> PlantTime {
        let Ok(at) = Timestamp::from_millisecond((1e3 * instant).round() as i64) else {
            return PlantTime::default();
        };
        let info = self.zone.to_offset_info(at);
        PlantTime { name: info.abbreviation().to_owned(), offset_s: info.offset().seconds() }
    }
}

/// Reads a date and time such as `2026-03-01T08:00` as seconds since 1970-01-01 UTC. Without an offset it is
/// interpreted as local time of `zone`, or as UTC.
///
/// # Errors
/// If the text is not a date, or the order of day and month is ambiguous, as in `01/02/2026`.
pub fn instant(text: &str, zone: Option<&Zone>) -> Result<f64, String> {
    let wrong = || format!("\"{text}\" is not a date and time such as 2026-03-01T08:00");
    let stamp = super::scan::scan(text).filter(|stamp| !stamp.is_abbreviated).ok_or_else(wrong)?;
    let orders: Vec<_> = stamp.orders().collect();
    let [order] = orders[..] else { return Err(wrong()) };
    let civil = stamp.civil(order).ok_or_else(wrong)?;
    let zone = match stamp.offset {
        Some(offset) => TimeZone::fixed(offset),
        None => zone.map_or(TimeZone::UTC, |zone| zone.zone.clone()),
    };
    let at = civil.to_zoned(zone).map_err(|_| wrong())?.timestamp();
    Ok(at.as_millisecond() as f64 / 1e3)
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
                "\"{name}\" is not a time zone; give a name such as Europe/Berlin or America/Chicago, or an offset \
                 such as +01:00"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants() {
        let berlin: Zone = "Europe/Berlin".parse().unwrap();
        // 2026-03-01 is day 20513 since 1970.
        let day = 20_513.0 * 86_400.0;
        assert_eq!(instant("2026-03-01", None), Ok(day));
        assert_eq!(instant("2026-03-01T08:00", None), Ok(day + 28_800.0));
        assert_eq!(instant("2026-03-01 08:00", Some(&berlin)), Ok(day + 25_200.0));
        assert_eq!(instant("2026-03-01T08:00Z", Some(&berlin)), Ok(day + 28_800.0));
        for wrong in ["", "noon", "03/04/2026", "2026-13-01", "2026-03-01T"] {
            assert!(
                instant(wrong, None).unwrap_err().contains("is not a date and time"),
                "{wrong}"
            );
        }
    }

    #[test]
    fn names_and_offsets() {
        for name in
            ["Europe/Berlin", "america/chicago", "UTC", "Etc/GMT-1", "+01:00", "-5", "+05:30"]
        {
            assert_eq!(name.parse::<Zone>().unwrap().name(), name);
        }
        for name in ["", "Berlin", "+25:00", "+1:99", "+-1", "é", "CEST"] {
            assert!(name.parse::<Zone>().unwrap_err().contains("is not a time zone"), "{name}");
        }
    }
}
