//! A dataset as CSV: kept between two trainings, and for other tools.
//!
//! The first line names the loops of the file. The file is refused if other loops are needed. A header follows, and a
//! row for each loop: the truth, then the features. A feature that could not be measured is empty. Numbers keep their
//! bits.

use crate::dataset::{Column, Dataset, Truth};
use anyhow::{Context, Result, bail, ensure};
use rayon::prelude::*;
use std::fmt::Write;
use std::path::Path;
use stiction_diagnose::fusion::Cause;

/// The columns of truth.
const TRUTH: [&str; 14] = [
    "index", "kind", "cause", "visible", "slips", "nats", "swing", "S", "J", "model", "process",
    "steps", "op_span", "families",
];

/// The content of a file, as in its first line.
pub fn key(population: u32, seed: u64, members: u64) -> String {
    format!("# stiction: population {population}, seed {seed}, members 0 to {members}")
}

/// The key for recordings with a mistake in their columns.
pub fn key_of_mistaken(population: u32, seed: u64, recordings: u64) -> String {
    format!("# stiction: population {population}, seed {seed}, mistaken 0 to {recordings}")
}

/// Writes a dataset.
pub fn write(path: &Path, key: &str, data: &Dataset) -> Result<()> {
    let lines: Vec<String> = (0..data.truth.len())
        .into_par_iter()
        .map(|row| {
            let Truth { index, kind, cause, visible, slips, nats, swing, s, j, .. } = &data.truth[row];
            let Truth { model, process, steps, op_span, families, .. } = &data.truth[row];
            let mut line = format!(
                "{index},{kind},{},{visible},{slips},{nats},{swing},{s},{j},{model},{process},{steps},{op_span},{}",
                cause.name(),
                families.join(";")
            );
            for column in &data.values {
                let value = column[row];
                line.push(',');
                if !value.is_nan() {
                    let _ = write!(line, "{value}");
                }
            }
            line
        })
        .collect();
    let mut text = format!("{key}\n#");
    for (kind, count) in &data.abstained {
        let _ = write!(text, " without evidence: {count} of {kind};");
    }
    let names = TRUTH.into_iter().chain(data.columns.iter().map(|column| &column.name[..]));
    let header: Vec<&str> = names.collect();
    text += &format!("\n{}\n{}\n", header.join(","), lines.join("\n"));
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// Reads a dataset of these columns.
///
/// # Errors
/// If the dataset contains different loops or features, or is damaged.
pub fn read(path: &Path, wanted: &str, columns: Vec<Column>) -> Result<Dataset> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let other = "; remove it, or name a different folder";
    let mut lines = text.lines();
    let (key, abstained) = (lines.next().unwrap_or(""), lines.next().unwrap_or(""));
    ensure!(key == wanted, "{} contains \"{key}\", not \"{wanted}\"{other}", path.display());
    let header: Vec<&str> = lines.next().unwrap_or("").split(',').collect();
    let names: Vec<&str> =
        TRUTH.into_iter().chain(columns.iter().map(|column| &column.name[..])).collect();
    if let Some(k) = (0..header.len().max(names.len())).find(|k| header.get(*k) != names.get(*k)) {
        let at = |names: &[&str]| names.get(k).copied().unwrap_or("nothing").to_owned();
        bail!(
            "{} has {} in column {}, not {}{other}",
            path.display(),
            at(&header),
            k + 1,
            at(&names)
        );
    }
    let lines: Vec<&str> = lines.collect();
    let rows: Vec<(Truth, Vec<f32>)> = lines
        .par_iter()
        .enumerate()
        .map(|(k, line)| {
            row(line, names.len()).with_context(|| format!("{}, line {}", path.display(), k + 4))
        })
        .collect::<Result<_>>()?;
    let mut data = Dataset::new(columns, rows);
    for part in abstained.split(';').filter_map(|part| part.split_once("evidence: ")) {
        let (count, kind) = part.1.split_once(" of ").context("the second line is damaged")?;
        data.abstained.insert(kind.to_owned(), count.parse()?);
    }
    Ok(data)
}

fn row(line: &str, fields: usize) -> Result<(Truth, Vec<f32>)> {
    let cells: Vec<&str> = line.split(',').collect();
    ensure!(cells.len() == fields, "{} cells instead of {fields}", cells.len());
    let cause = Cause::ALL.into_iter().find(|cause| cause.name() == cells[2]);
    let truth = Truth {
        index: cells[0].parse()?,
        kind: cells[1].to_owned(),
        cause: cause.with_context(|| format!("there is no cause \"{}\"", cells[2]))?,
        visible: cells[3].parse()?,
        slips: cells[4].parse()?,
        nats: cells[5].parse()?,
        swing: cells[6].parse()?,
        s: cells[7].parse()?,
        j: cells[8].parse()?,
        model: cells[9].to_owned(),
        process: cells[10].to_owned(),
        steps: cells[11].parse()?,
        op_span: cells[12].parse()?,
        families: cells[13].split(';').filter(|name| !name.is_empty()).map(str::to_owned).collect(),
    };
    let values = cells[TRUTH.len()..].iter().map(|cell| match *cell {
        "" => Ok(f32::NAN),
        cell => cell.parse(),
    });
    Ok((truth, values.collect::<Result<_, _>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn a_file_gives_back_what_was_written() {
        let mut data = synthetic::dataset(1, 200);
        data.abstained.insert("saturation".into(), 3);
        data.abstained.insert("normal operation".into(), 12);
        let folder = std::env::temp_dir().join(format!("stiction-train-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("matrix.csv");
        let key = key(2, 1, 200);
        write(&path, &key, &data).unwrap();
        let back = read(&path, &key, data.columns.clone()).unwrap();
        assert_eq!((&back.truth, &back.abstained), (&data.truth, &data.abstained));
        let bits = |data: &Dataset| -> Vec<u32> {
            data.values.iter().flatten().map(|x| if x.is_nan() { 1 } else { x.to_bits() }).collect()
        };
        assert_eq!(bits(&back), bits(&data));

        let said =
            |key: &str, columns: Vec<Column>| read(&path, key, columns).unwrap_err().to_string();
        assert!(said("# other", data.columns.clone()).contains("not \"# other\""));
        let mut other = data.columns.clone();
        other[1].name = "renamed".into();
        assert!(said(&key, other).contains("not renamed"));
        other = data.columns[..1].to_vec();
        assert!(said(&key, other).contains("not nothing"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
