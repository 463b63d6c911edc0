//! The clock on the plant's wall.

/// How the instants of a recording are written: by the clock of the plant, as it went at the beginning. A recording that
/// lasts beyond a change to or from summer time keeps it, so that its times have one order.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct PlantTime {
    /// What the clock is called, such as `CET`, `+05:30` or `UTC`; empty where it was not recorded.
    pub name: String,
    /// How far it goes before UTC, s; where its name is not known, times were taken as if it were UTC.
    pub offset_s: i32,
}

impl Default for PlantTime {
    fn default() -> Self {
        Self { name: "UTC".to_owned(), offset_s: 0 }
    }
}

impl PlantTime {
    /// A clock that nobody named.
    pub fn unnamed() -> Self {
        Self { name: String::new(), offset_s: 0 }
    }

    /// What the clock shows at an instant, s since 1970-01-01 UTC: that many s after 1970-01-01 on it.
    pub fn shows(&self, instant: f64) -> f64 {
        instant + f64::from(self.offset_s)
    }
}
