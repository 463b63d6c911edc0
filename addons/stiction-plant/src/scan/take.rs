//! Stores rows that were judged elsewhere, for the reports of a plant.

use crate::error::{Result, store};
use crate::plant_file::Plant;
use crate::scan::inputs::Changes;
use crate::scan::{Manifest, PART};
use crate::store::Store;
use crate::store::trace::{STEP_S, Trace};
use crate::store::window::{ENGINE_VERSION, WindowRow, model_version};
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

/// Writes rows and their traces as one run to the store of the plant in `folder`; nothing without a row. From the traces a report
/// finds the loops that swing together.
///
/// # Errors
/// If the store cannot be written, or another process writes to it.
pub fn take(
    folder: &Path,
    plant: &Plant,
    rows: &[WindowRow],
    traces: &[Trace],
) -> Result<Manifest> {
    let of_window = |trace: &'_ Trace| (trace.name.clone(), trace.start);
    let mut by_window: HashMap<(String, i64), &Trace> =
        traces.iter().map(|trace| (of_window(trace), trace)).collect();
    let store_of = Store::of(folder);
    let mut run = store_of.begin()?;
    for part in rows.chunks(PART) {
        let key =
            |row: &WindowRow| (row.name.clone(), row.window_start.div_euclid(STEP_S) * STEP_S);
        let own: Vec<Trace> =
            part.iter().filter_map(|row| by_window.remove(&key(row)).cloned()).collect();
        run.write_traces(&own)?;
        run.write(part)?;
    }
    let loops: BTreeSet<&str> = rows.iter().map(|row| &*row.name).collect();
    let manifest = Manifest {
        plant: plant.file.name.clone(),
        run: (run.parts() > 0).then(|| run.name.clone()),
        engine_version: ENGINE_VERSION.to_owned(),
        model_version: model_version(),
        files: 0,
        loops: loops.len(),
        windows: rows.len(),
        errors: rows.iter().filter(|row| row.error.is_some()).count(),
        parts: run.parts(),
        problems: vec![],
        unknown: vec![],
        no_recordings: vec![],
        damaged: store_of.damaged(),
        changes: Changes::default(),
    };
    let text =
        serde_json::to_string_pretty(&manifest).map_err(|e| store(&store_of.path("runs"), e))?;
    run.end(&text)?;
    Ok(manifest)
}
