//! Turns of calls: how many are worked on at a time, and for how long.
//!
//! A turn belongs to the work, not to its connection: the next call begins when the work has ended. If the caller has gone,
//! the work ends at its next check of [`Wanted`].

use crate::calls::{Answer, Wrong};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use stiction_diagnose::diagnose::{DiagnoseOptions, Diagnosis, diagnose_with_progress};
use stiction_diagnose::recording::Recording;
use stiction_model::Error;
use tokio::sync::Semaphore;

/// What a call costs. Calls of one cost take turns only among themselves, so a costly call delays no cheap call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cost {
    /// A list, an entry, some samples of a loop that runs.
    Low,
    /// A recording is read, simulated or judged.
    Medium,
    /// A map: every point of it is a search for a cycle.
    High,
}

impl Cost {
    /// How many calls of this cost run at a time. The others wait.
    pub fn at_once(self) -> usize {
        match self {
            Self::Low => 8,
            Self::Medium => 4,
            Self::High => 2,
        }
    }

    /// How long the work on one call may take.
    fn limit(self) -> Duration {
        match self {
            Self::Low | Self::High => Duration::from_secs(20),
            Self::Medium => Duration::from_secs(120),
        }
    }
}

/// The turns of all calls.
#[derive(Debug)]
pub struct Turns {
    gates: [Arc<Semaphore>; 3],
    begun: [AtomicUsize; 3],
}

impl Default for Turns {
    fn default() -> Self {
        let gate = |cost: Cost| Arc::new(Semaphore::new(cost.at_once()));
        Self { gates: [Cost::Low, Cost::Medium, Cost::High].map(gate), begun: Default::default() }
    }
}

impl Turns {
    /// How many turns of a cost are free.
    pub fn free(&self, cost: Cost) -> usize {
        self.gates[cost as usize].available_permits()
    }

    /// How many calls of a cost have been begun so far.
    pub fn begun(&self, cost: Cost) -> usize {
        self.begun[cost as usize].load(Ordering::Relaxed)
    }

    /// Runs some work on a separate thread as soon as its turn comes. If the caller leaves, the work is not begun, or
    /// ends early.
    pub(crate) async fn take<R: Send + 'static>(
        &self,
        cost: Cost,
        work: impl FnOnce(&Wanted) -> Answer<R> + Send + 'static,
    ) -> Answer<R> {
        let gate = Arc::clone(&self.gates[cost as usize]);
        let turn = gate.acquire_owned().await.map_err(Wrong::own)?;
        self.begun[cost as usize].fetch_add(1, Ordering::Relaxed);
        let wanted = Wanted::for_at_most(cost.limit());
        let _here = Here(Arc::clone(&wanted.gone));
        let done = tokio::task::spawn_blocking(move || {
            let _turn = turn;
            work(&wanted)
        });
        done.await.unwrap_or_else(|e| Err(Wrong::own(format!("internal error of the lab: {e}"))))
    }
}

/// Reports, when it is dropped, that the caller has gone.
struct Here(Arc<AtomicBool>);

impl Drop for Here {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Whether a client still waits for an answer, and the time limit is not over.
#[derive(Debug)]
pub struct Wanted {
    gone: Arc<AtomicBool>,
    limit: Duration,
    until: Instant,
}

impl Wanted {
    pub(crate) fn for_at_most(limit: Duration) -> Self {
        Self { gone: Arc::default(), limit, until: Instant::now() + limit }
    }

    /// Whether the work should go on.
    pub fn goes_on(&self) -> bool {
        !self.gone.load(Ordering::Relaxed) && Instant::now() < self.until
    }

    /// Stops work that should not continue.
    ///
    /// # Errors
    /// If the work should stop.
    pub fn check(&self) -> Answer<()> {
        if self.goes_on() { Ok(()) } else { Err(self.over()) }
    }

    /// Diagnoses a recording, as long as the work should go on.
    ///
    /// # Errors
    /// As for [`diagnose_with_progress`], or if the work should stop.
    pub(crate) fn diagnose(
        &self,
        recording: &Recording,
        options: &DiagnoseOptions,
    ) -> Answer<Diagnosis> {
        diagnose_with_progress(recording, options, || self.goes_on()).map_err(|e| match e {
            Error::Cancelled => self.over(),
            other => other.into(),
        })
    }

    /// Why the work ended early.
    pub(crate) fn over(&self) -> Wrong {
        Wrong::own(format!(
            "the computation took longer than {} s, so the lab has stopped it; ask for fewer points or samples",
            self.limit.as_secs()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_ends_when_its_caller_has_gone_or_its_time_is_over() {
        let wanted = Wanted::for_at_most(Duration::from_secs(3600));
        let here = Here(Arc::clone(&wanted.gone));
        assert!(wanted.goes_on() && wanted.check().is_ok());
        drop(here);
        assert!(!wanted.goes_on() && wanted.check().is_err());
        let late = Wanted::for_at_most(Duration::ZERO).check().unwrap_err();
        assert!(late.error.contains("longer than 0 s"), "{late:?}");
    }

    #[test]
    fn a_diagnosis_ends_with_its_time() {
        let op: Vec<f64> = (0..600).map(|k| 50.0 + (0.1 * f64::from(k)).sin()).collect();
        let recording = Recording::regular("A", 1.0, &op, Some(&op), None).unwrap();
        let asked =
            |limit| Wanted::for_at_most(limit).diagnose(&recording, &DiagnoseOptions::default());
        assert!(asked(Duration::from_secs(3600)).is_ok());
        assert!(asked(Duration::ZERO).unwrap_err().error.contains("longer than 0 s"));
    }
}
