//! Progress of long work, shown as a bar on a terminal and not in a pipe.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A bar that counts up to `total` pieces of work. The caller clears it.
pub fn bar(what: &'static str, total: usize) -> ProgressBar {
    // One piece needs no bar, and indicatif draws only on terminals.
    let bar = if total < 2 || crate::output::is_quiet() {
        ProgressBar::hidden()
    } else {
        ProgressBar::new(total as u64)
    };
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.with_message(what)
}

/// A spinner for work with an unknown number of pieces. The caller clears it.
pub fn spinner(what: &'static str) -> ProgressBar {
    if crate::output::is_quiet() {
        return ProgressBar::hidden();
    }
    let spinner = ProgressBar::new_spinner().with_message(what);
    spinner.enable_steady_tick(Duration::from_millis(100));
    spinner
}
