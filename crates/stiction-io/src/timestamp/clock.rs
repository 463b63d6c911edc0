//! What the clock of a recording shows.

use super::zone::Zone;
use jiff::tz::Offset;

/// What a clock shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Clock {
    /// UTC, or times with an offset from it.
    Utc,
    /// Local times in the named zone.
    Zone(String),
    /// Local times in a zone that is not known; taken as if they were UTC.
    Local,
    /// Time since some start that is not known.
    Elapsed,
}

impl Clock {
    /// The time `seconds` after `start`, as people write it: in UTC or with its offset, without one
    /// where no zone is known, and as plain seconds where no start is.
    pub fn show(&self, start: Option<f64>, seconds: f64) -> String {
        let plain = || format!("{seconds} s");
        let Some(start) = start else { return plain() };
        // To the millisecond: a start in seconds since 1970 has no more digits than microseconds.
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
