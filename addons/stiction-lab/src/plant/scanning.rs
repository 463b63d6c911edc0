//! A scan in the background, at most one; the store keeps two programs from scanning at a time.

use super::locked;
use crate::calls::{Answer, Wrong};
use crate::lab::Lab;
use crate::loops::Nothing;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use stiction_plant::plant_file::Plant;
use stiction_plant::scan::{Manifest, Progress};
use stiction_plant::{ScanOptions, inputs, scan};

/// The scan of a lab.
#[derive(Debug, Default)]
pub(super) struct Scanning {
    now: Mutex<ScanNow>,
    is_to_stop: AtomicBool,
}

/// How far the scan is, or how the last one ended.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct ScanNow {
    /// Whether one runs.
    running: bool,
    /// Whether it will stop after the present batch.
    stopping: bool,
    /// Files checked so far.
    looked: usize,
    /// Number of files.
    files: usize,
    /// Loop days judged in this run; none while files are checked.
    done: Option<usize>,
    /// Estimated number of loop days.
    of: usize,
    /// The result of the last one.
    ended: Option<Manifest>,
    /// Whether the last one was stopped before its end.
    stopped: bool,
    /// Why the last one failed.
    failed: Option<String>,
}

impl Scanning {
    pub fn now(&self) -> ScanNow {
        locked(&self.now).clone()
    }

    pub fn stop(&self) {
        self.is_to_stop.store(true, Ordering::Relaxed);
        let mut now = locked(&self.now);
        now.stopping = now.running;
    }

    fn run(&self, folder: &Path, plant: &Plant, options: &ScanOptions) {
        let scanned = scan(folder, plant, options, |progress| {
            let mut now = locked(&self.now);
            match progress {
                Progress::Looked(_) => now.looked += 1,
                Progress::Written { done, of } => (now.done, now.of) = (Some(done), of),
            }
            match self.is_to_stop.load(Ordering::Relaxed) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        let mut now = locked(&self.now);
        match scanned {
            Ok(manifest) => now.ended = Some(manifest),
            Err(e) => now.failed = Some(e.to_string()),
        }
    }
}

/// The options of a scan.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScanRequest {
    /// Whether to judge finished windows again.
    #[serde(default)]
    again: bool,
}

/// Begins a scan of new files and windows.
///
/// # Errors
/// If a scan is running, or the plant's file cannot be read.
pub fn begin_scan(lab: &Lab, asked: ScanRequest) -> Answer<ScanNow> {
    let folder = lab.plant.folder()?.to_owned();
    let plant = Plant::read(&folder)?;
    let files = inputs::paths(&folder, &plant).len();
    if files == 0 {
        return Err(Wrong::request("no file matches the data entry of plant.toml"));
    }
    let scanning = Arc::clone(&lab.plant.scanning);
    {
        let mut now = locked(&scanning.now);
        if now.running {
            return Err(Wrong::request("a scan is already running"));
        }
        *now = ScanNow { running: true, files, ..ScanNow::default() };
        scanning.is_to_stop.store(false, Ordering::Relaxed);
    }
    // One processor is left for the page.
    let machine = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = Some((machine - 1).max(1));
    let options = ScanOptions { threads, again: asked.again, ..ScanOptions::default() };
    let own = Arc::clone(&scanning);
    let ran = std::thread::Builder::new().name("scan".to_owned()).spawn(move || {
        let run = || own.run(&folder, &plant, &options);
        let held = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
        let mut now = locked(&own.now);
        if held.is_err() {
            now.failed = Some("internal error of the scan; please report it".to_owned());
        }
        now.stopped = own.is_to_stop.load(Ordering::Relaxed);
        (now.running, now.stopping) = (false, false);
    });
    if let Err(e) = ran {
        locked(&scanning.now).running = false;
        return Err(Wrong::own(e));
    }
    Ok(scanning.now())
}

/// Ends the scan after the present batch. Written results stay.
///
/// # Errors
/// Never.
pub fn stop_scan(lab: &Lab, _: Nothing) -> Answer<ScanNow> {
    lab.plant.scanning.stop();
    Ok(lab.plant.scanning.now())
}
