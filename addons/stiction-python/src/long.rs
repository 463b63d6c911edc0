//! Long calls, which run without the interpreter's lock and end on Ctrl-C.

use crate::pool::pool;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Interval of checks for signals and of progress reports.
const TICK: Duration = Duration::from_millis(50);

/// The progress of a long call, and whether a caller still waits for it.
#[derive(Debug, Default)]
pub struct Progress {
    done: AtomicUsize,
    cancelled: AtomicBool,
}

impl Progress {
    /// Counts one more item as done.
    pub fn one(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Sets the number of finished items.
    pub fn reached(&self, done: usize) {
        self.done.store(done, Ordering::Relaxed);
    }

    /// Counts one more item as done, and returns whether to continue.
    pub fn goes_on(&self) -> bool {
        self.one();
        !self.is_cancelled()
    }

    /// Whether to stop, because the caller was interrupted.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Computes on the threads of this process, without the interpreter's lock. `told` is called with the number of
/// finished items whenever it has grown. An interrupt, or an exception in `told`, ends the call at once. The
/// computation then ends when it next checks [`Progress::is_cancelled`], or with its present item.
pub fn long<T: Send + 'static>(
    py: Python<'_>,
    told: Option<&Bound<'_, PyAny>>,
    compute: impl FnOnce(&Progress) -> T + Send + 'static,
) -> PyResult<T> {
    let progress = Arc::new(Progress::default());
    let (sender, mut receiver) = channel();
    let theirs = Arc::clone(&progress);
    let unstarted = |e: &dyn std::fmt::Display| {
        PyRuntimeError::new_err(format!("no thread could be started: {e}"))
    };
    let pool = pool().map_err(|e| unstarted(&e))?;
    std::thread::Builder::new()
        .name("stiction".to_owned())
        .spawn(move || _ = sender.send(pool.install(|| compute(&theirs))))
        .map_err(|e| unstarted(&e))?;
    let mut before = 0;
    loop {
        let waiting = &mut receiver;
        let received = py.detach(move || waiting.recv_timeout(TICK));
        let done = progress.done.load(Ordering::Relaxed);
        let result = match told {
            Some(told) if done > before => told.call1((done,)).map(|_| ()),
            _ => Ok(()),
        }
        .and_then(|()| py.check_signals());
        before = done;
        if let Err(error) = result {
            progress.cancelled.store(true, Ordering::Relaxed);
            return Err(error);
        }
        match received {
            Ok(value) => return Ok(value),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err(
                    "the computation ended by an internal error; please report it",
                ));
            }
        }
    }
}
