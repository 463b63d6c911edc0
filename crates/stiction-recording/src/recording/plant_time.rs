//! The plant's clock.

/// The clock for the times of a recording: the plant's clock at the beginning. The offset stays unchanged across a
/// change to or from summer time, so that the times stay in order.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct PlantTime {
    /// Name of the clock, such as `CET`, `+05:30` or `UTC`; empty if the name was not recorded.
    pub name: String,
    /// Offset of the clock from UTC, s. If the name is unknown, times were interpreted as UTC.
    pub offset_s: i32,
}

impl Default for PlantTime {
    fn default() -> Self {
        Self { name: "UTC".to_owned(), offset_s: 0 }
    }
}

impl PlantTime {
    /// A clock without a name.
    pub fn unnamed() -> Self {
        Self { name: String::new(), offset_s: 0 }
    }

    /// The clock's time at an instant, s since 1970-01-01 UTC, as s since 1970-01-01 on the clock.
    pub fn shows(&self, instant: f64) -> f64 {
        instant + f64::from(self.offset_s)
    }
}
