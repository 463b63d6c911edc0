//! Detects that standard output was closed when the program began, as by `>&-`.
//!
//! Before `main`, Rust opens the null device for a closed descriptor, and all output is lost without a message.
//! Afterwards it cannot be distinguished from a null device that the caller gave, such as Python's
//! `subprocess.DEVNULL`. So the system's loader calls a function that checks earlier.

use anyhow::{Result, bail};
use std::sync::atomic::{AtomicBool, Ordering};

static CLOSED: AtomicBool = AtomicBool::new(false);

/// Refuses to run with closed standard output, before a command does anything, because its result would be lost.
pub fn refuse() -> Result<()> {
    if CLOSED.load(Ordering::Relaxed) {
        bail!(
            "standard output is closed, so the result would be lost; redirect it, such as > FILE or > /dev/null"
        );
    }
    Ok(())
}

#[cfg(unix)]
mod at_load {
    use std::sync::atomic::Ordering;

    /// The loader of these systems calls the functions of this section before the runtime of Rust starts.
    // Unsafe, because the linker trusts the section's name, and because `look` must not rely on Rust's runtime. It
    // does not. It asks the system once and stores a flag.
    #[allow(unsafe_code)]
    #[used]
    #[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__mod_init_func"))]
    #[cfg_attr(not(target_vendor = "apple"), unsafe(link_section = ".init_array"))]
    static LOOK: extern "C" fn() = look;

    extern "C" fn look() {
        let closed = rustix::io::fcntl_getfd(rustix::stdio::stdout()).is_err();
        super::CLOSED.store(closed, Ordering::Relaxed);
    }
}
