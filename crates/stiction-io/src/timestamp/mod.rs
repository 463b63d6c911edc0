//! Columns of times: dates and times of day, epochs, days of spreadsheets and MATLAB, and plain seconds.

mod clock;
mod column;
mod context;
mod format;
mod plausible;
mod scan;
mod zone;

pub use clock::Clock;
pub use context::Times;
pub use format::{DateOrder, TimeFormat};
pub use zone::{Zone, instant};

pub(crate) use column::read;
pub(crate) use context::Context;
pub(crate) use plausible::{Told, check_told};
pub(crate) use scan::looks_like;
