//! Exports of whole plants are read in a time that grows with their width, not with its square.
//!
//! A clock decides, so the limit is wide for a busy machine: each takes seconds, and took from half a minute to many when
//! every column was compared with every other.

use std::fmt::Write as _;
use std::time::{Duration, Instant};
use stiction_io::{ReadOptions, Reading, reading};

const LIMIT: Duration = Duration::from_secs(60);

/// Loops in a file.
const LOOPS: usize = 20_000;

fn read(bytes: &[u8], mapping: &str) -> Reading {
    let options = ReadOptions::parse(mapping, "plant.toml").expect("a mapping");
    let start = Instant::now();
    let reading = reading::parse(bytes, "plant", &options).expect("a file that is read");
    assert!(start.elapsed() < LIMIT, "{:?}", start.elapsed());
    reading
}

/// Two rows of columns of loops.
fn csv(columns: impl Fn(usize) -> Vec<String>) -> String {
    let mut text = "t".to_owned();
    let names: Vec<String> = (0..LOOPS).flat_map(columns).collect();
    names.iter().for_each(|name| text += &format!(",{name}"));
    for row in 0..2 {
        write!(text, "\n{row}").expect("text");
        (0..names.len()).for_each(|k| text += [",50", ",51"][(row + k) % 2]);
    }
    text
}

#[test]
fn many_columns() {
    let text = csv(|k| ["SP", "PV", "OP", "X"].map(|signal| format!("FIC{k}.{signal}")).to_vec());
    assert_eq!(read(text.as_bytes(), "").recordings.len(), LOOPS);
}

#[test]
fn many_loops_of_a_mapping() {
    let text = csv(|k| vec![format!("A{k}"), format!("B{k}")]);
    let mut mapping = String::new();
    for k in 0..LOOPS {
        // One in a hundred is in another file.
        let op = if k % 100 == 0 { "elsewhere" } else { "A" };
        writeln!(mapping, "[loop.FIC{k}]\nop = \"{op}{k}\"\npv = \"B{k}\"\ntype = \"flow\"")
            .expect("text");
    }
    let reading = read(text.as_bytes(), &mapping);
    assert_eq!((reading.recordings.len(), reading.missing.len()), (LOOPS / 100 * 99, LOOPS / 100));
}

#[test]
fn many_pairs_that_are_sought() {
    let text = csv(|k| vec![format!("FC{k}.PIDA.OP"), format!("FC{k}.DACA.PV")]);
    assert!(read(text.as_bytes(), "").recordings.iter().all(|read| read.pv.is_some()));
    let text = csv(|k| vec![format!("10FC{k}.OP"), format!("10FT{k}.DACA.PV")]);
    let reading = read(text.as_bytes(), "");
    assert!(reading.recordings.iter().all(|read| read.notes[0].starts_with("by its tag, \"")));
}

/// What is said of one loop of many is not said of all.
#[test]
fn many_loops_whose_op_is_mv() {
    let text = csv(|k| vec![format!("FIC{k}.MV"), format!("FIC{k}.PV")]);
    let reading = read(text.as_bytes(), "");
    assert!(reading.recordings.iter().all(|read| read.notes.len() == 1));
    assert!(reading.notes.is_empty(), "{:?}", reading.notes.len());
}

#[cfg(feature = "matlab")]
#[test]
fn many_variables() {
    let mut file = hdf5_pure::FileBuilder::new();
    for k in 0..LOOPS {
        let signal = ["op", "pv"][k % 2];
        file.create_dataset(&format!("FIC{}_{signal}", k / 2)).with_f64_data(&[50.0, 51.0, 52.0]);
    }
    file.create_dataset("t").with_f64_data(&[0.0, 1.0, 2.0]);
    let bytes = file.finish().expect("a file");
    assert_eq!(read(&bytes, "").recordings.len(), LOOPS / 2);
}
