//! Time along an axis.

use crate::recording::PlantTime;
use stiction_figure::figure::Scale;

/// A time axis, from seconds to its labels.
#[derive(Debug, Clone)]
pub struct TimeAxis {
    /// Name with its unit.
    pub label: String,
    /// Format of its values.
    pub scale: Scale,
    /// Seconds per unit.
    size: f64,
    /// Added before the division, s.
    offset: f64,
}

impl TimeAxis {
    /// Lags and durations of up to `longest` s.
    pub fn of_lags(name: &str, longest: f64) -> Self {
        let (unit, size) = match longest {
            t if t <= 600.0 => ("s", 1.0),
            t if t <= 6.0 * 3600.0 => ("min", 60.0),
            t if t <= 5.0 * 86_400.0 => ("h", 3600.0),
            _ => ("d", 86_400.0),
        };
        let label = format!("{name} ({unit})");
        Self { label, scale: Scale::Linear, size, offset: 0.0 }
    }

    /// Times of a recording that ends after `longest` s.
    pub fn of_times(start: Option<f64>, clock: &PlantTime, longest: f64) -> Self {
        match start.map(|start| clock.shows(start)).filter(|s| s.abs() < 5e10) {
            Some(start) => Self {
                label: match &*clock.name {
                    "" => "plant time".to_owned(),
                    name => format!("time ({name})"),
                },
                scale: Scale::Clock,
                size: 1.0,
                offset: start,
            },
            None => Self::of_lags("time", longest),
        }
    }

    /// Position of a time in s along the axis.
    pub fn at(&self, seconds: f64) -> f64 {
        (seconds + self.offset) / self.size
    }
}
