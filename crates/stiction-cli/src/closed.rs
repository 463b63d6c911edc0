//! Whether standard output was closed when the program began, as by `>&-`.
//!
//! Rust opens the null device in place of a closed descriptor before `main`, and what is written there is lost without a
//! word. Afterwards nothing distinguishes it from a null device that the caller gave, such as Python's
//! `subprocess.DEVNULL`. So the system's loader calls a function that looks earlier.

use anyhow::{Result, bail};
use std::sync::atomic::{AtomicBool, Ordering};

static CLOSED: AtomicBool = AtomicBool::new(false);

/// Refuses to run if standard output was closed, before a command does anything: its result would be lost.
pub fn refuse() -> Result<()> {
    if CLOSED.load(Ordering::Relaxed) {
        bail!(
            "standard output is closed, and the result has no other place to go; give it one, such as > FILE or > /dev/null"
        );
    }
    Ok(())
}

#[cfg(unix)]
mod at_load {
    use std::sync::atomic::Ordering;

    /// The loader of these systems calls what this section lists, before the runtime of Rust.
    // Unsafe, as the linker trusts the section's name, and as `look` may rely on nothing of Rust's runtime. It does not: it
    // asks the system once and stores a flag.
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
