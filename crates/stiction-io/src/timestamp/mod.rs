//! Columns of times: dates and times of day, epochs, days of spreadsheets and MATLAB, and plain seconds.

mod clock;
mod column;
mod context;
mod day;
mod format;
mod plausible;
mod rounded;
mod scan;
mod time_of_day;
mod zone;

pub use clock::Clock;
pub use context::Times;
pub use day::Day;
pub use format::{DateOrder, TimeFormat};
pub use zone::{Zone, instant};

pub(crate) use column::{read, unchecked};
pub(crate) use context::Context;
pub(crate) use plausible::{
    MOST_COLLAPSED, StatedBy, check_sample_time, is_epoch, mean_step_of_all,
};
pub(crate) use scan::{looks_like, scan};
pub(crate) use time_of_day::scan as time_of_day;
