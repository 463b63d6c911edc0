//! The threads of parallel calls, which survive a fork.
//!
//! The global pool of rayon does not: a child of `fork`, as `multiprocessing` makes them, inherits the pool but none
//! of its threads, and whoever hands it work waits for ever. So each process has a pool of its own.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::{Arc, Mutex};

/// The pool, and the process that made it.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The pool of this process.
///
/// # Errors
/// If no threads can be started.
pub fn pool() -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    let process = std::process::id();
    // Never waited for: whoever held it at the time of a fork is not in the child to let go.
    let Ok(mut known) = POOL.try_lock() else { return build() };
    if let Some((owner, pool)) = &*known
        && *owner == process
    {
        return Ok(Arc::clone(pool));
    }
    let pool = build()?;
    // To end the parent's pool here would be to wait for threads that are not there.
    std::mem::forget(known.replace((process, Arc::clone(&pool))));
    Ok(pool)
}

fn build() -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    let named = ThreadPoolBuilder::new().thread_name(|k| format!("stiction-{k}"));
    named.build().map(Arc::new)
}
