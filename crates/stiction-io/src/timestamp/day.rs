//! The day of times that have none.

use jiff::civil::Date;
use std::fmt;
use std::str::FromStr;

/// A day of the calendar, such as 2025-03-14.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Day(pub(super) Date);

impl fmt::Display for Day {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for Day {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let day = text.parse::<Date>();
        day.map(Self).map_err(|_| format!("\"{text}\" is not a day such as 2025-03-14"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days() {
        assert_eq!("2025-03-14".parse::<Day>().unwrap().0.to_string(), "2025-03-14");
        for wrong in ["", "14/03/2025", "2025-13-01", "noon"] {
            assert!(wrong.parse::<Day>().unwrap_err().contains("is not a day such as"), "{wrong}");
        }
    }
}
