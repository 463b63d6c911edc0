//! Rows that were judged elsewhere, taken into the store of a plant, where reports find them.

use crate::error::{Result, store};
use crate::plant_file::Plant;
use crate::scan::{Manifest, PART};
use crate::store::Store;
use crate::window::{ENGINE_VERSION, WindowRow, model_version};
use std::collections::BTreeSet;
use std::path::Path;

/// Writes rows as one run to the store of the plant in `folder`; without a row there is none.
///
/// # Errors
/// If the store cannot be written, or somebody else is writing.
pub fn take(folder: &Path, plant: &Plant, rows: &[WindowRow]) -> Result<Manifest> {
    let store_of = Store::of(folder);
    let mut run = store_of.begin()?;
    for part in rows.chunks(PART) {
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
    };
    let text =
        serde_json::to_string_pretty(&manifest).map_err(|e| store(&store_of.path("runs"), e))?;
    run.end(&text)?;
    Ok(manifest)
}
