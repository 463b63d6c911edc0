//! Progress of long work: a bar on a terminal, nothing in a pipe.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A bar that counts up to `total` pieces of work. Whoever calls it clears it.
pub fn bar(what: &'static str, total: usize) -> ProgressBar {
    // One piece needs no bar; and indicatif draws on terminals only.
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

/// A sign that work goes on whose pieces are not known. Whoever calls it clears it.
pub fn spinner(what: &'static str) -> ProgressBar {
    if crate::output::is_quiet() {
        return ProgressBar::hidden();
    }
    let spinner = ProgressBar::new_spinner().with_message(what);
    spinner.enable_steady_tick(Duration::from_millis(100));
    spinner
}
