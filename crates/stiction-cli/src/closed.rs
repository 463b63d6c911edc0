//! Whether standard output was closed when the program began, as by `>&-`.
//!
//! Rust opens the null device in its place before `main`, so that what is written there is lost without a word. Only who
//! looks earlier can tell that from a user's own `> /dev/null`.

use std::sync::atomic::{AtomicBool, Ordering};

static CLOSED: AtomicBool = AtomicBool::new(false);

/// Whether it was; where no one could look, it was not.
pub fn standard_output() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

#[cfg(unix)]
extern "C" fn look() {
    use std::os::fd::AsFd;
    CLOSED.store(std::io::stdout().as_fd().try_clone_to_owned().is_err(), Ordering::Relaxed);
}

/// What the system runs before `main`.
// SAFETY: a function of this type is what the section holds, and it neither unwinds nor needs what `main` sets up.
#[cfg(unix)]
#[used]
#[cfg_attr(not(target_vendor = "apple"), unsafe(link_section = ".init_array"))]
#[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__mod_init_func"))]
static BEFORE_MAIN: extern "C" fn() = look;
