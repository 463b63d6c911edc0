//! The kind of a recording's clock.

use super::zone::Zone;
use jiff::tz::Offset;

/// The kind of a clock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Clock {
    /// UTC, or times with an offset from it.
    Utc,
    /// Local times in the named zone.
    Zone(String),
    /// Local times in an unknown zone, treated as UTC.
    Local,
    /// Time since an unknown start.
    Elapsed,
}

impl Clock {
    /// Name, in words.
    pub fn name(&self) -> &str {
        match self {
            Self::Utc => "UTC",
            Self::Zone(zone) => zone,
            Self::Local => "no zone, interpreted as UTC",
            Self::Elapsed => "no date",
        }
    }

    /// The time `seconds` after `start` as text: in UTC or with its offset, without an offset if the zone is unknown,
    /// and as plain seconds if the start is unknown.
    pub fn show(&self, start: Option<f64>, seconds: f64) -> String {
        let plain = || format!("{seconds} s");
        let Some(start) = start else { return plain() };
        // To the millisecond, because a start in seconds since 1970 has only microsecond precision.
        let millis = ((start + seconds) * 1e3).round();
        let Ok(timestamp) = jiff::Timestamp::from_millisecond(millis as i64) else {
            return plain();
        };
        match self {
            Self::Utc => timestamp.to_string(),
            Self::Local | Self::Elapsed => Offset::UTC.to_datetime(timestamp).to_string(),
            Self::Zone(name) => match name.parse::<Zone>() {
                Ok(zone) => {
                    let offset = zone.zone.to_offset(timestamp);
                    timestamp.display_with_offset(offset).to_string()
                }
                Err(_) => timestamp.to_string(),
            },
        }
    }
}
