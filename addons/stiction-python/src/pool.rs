//! The thread pool of parallel calls, which survives a fork.
//!
//! The global pool of rayon does not survive. A child of `fork`, as in `multiprocessing`, inherits the pool but none
//! of its threads, so work for the pool never finishes. Each process therefore has its own pool.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::{Arc, Mutex};

/// The pool, and the process that created it.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The pool of this process.
///
/// # Errors
/// If no threads can be started.
pub fn pool() -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    let process = std::process::id();
    // Never waits, because the owner of the lock at the time of a fork does not exist in the child.
    let Ok(mut known) = POOL.try_lock() else { return build() };
    if let Some((owner, pool)) = &*known
        && *owner == process
    {
        return Ok(Arc::clone(pool));
    }
    let pool = build()?;
    // Ending the parent's pool here would wait for threads that do not exist.
    std::mem::forget(known.replace((process, Arc::clone(&pool))));
    Ok(pool)
}

fn build() -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    let named = ThreadPoolBuilder::new().thread_name(|k| format!("stiction-{k}"));
    named.build().map(Arc::new)
}
