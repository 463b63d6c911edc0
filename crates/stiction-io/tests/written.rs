//! The mapping file of a recording, by which it is read again without any guess.

use crate::corpus::CASES;
use std::path::Path;
use stiction_io::ReadOptions;
use stiction_io::reading::{self, Reading, mapping_of, same};

/// The file is read by its own mapping to the same recordings, with no more notes, and the mapping stays the same.
fn check(bytes: &[u8], origin: &str, options: &ReadOptions) -> Option<(Reading, Reading)> {
    let before = reading::parse(bytes, origin, options).ok()?;
    let text = mapping_of(bytes, origin, options).unwrap_or_else(|e| panic!("{origin}: {e}"));
    let said = ReadOptions::parse(&text, "map.toml").unwrap_or_else(|e| panic!("{e}\n{text}"));
    let after = reading::parse(bytes, origin, &said).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert!(same(&before, &after), "{origin}\n{text}");
    let notes = |reading: &Reading| {
        let of_loops = reading.recordings.iter().flat_map(|each| each.notes.clone());
        reading.notes.iter().cloned().chain(of_loops).collect::<Vec<_>>()
    };
    let (old, new) = (notes(&before), notes(&after));
    assert!(new.iter().all(|note| old.contains(note)), "{origin}: {new:?}\n{old:?}\n{text}");
    let again = mapping_of(bytes, origin, &said).unwrap_or_else(|e| panic!("{origin}: {e}"));
    let lines = |text: &str| {
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        let mut lines: Vec<_> = lines.filter_map(|line| line.split("  #").next()).collect();
        // Tables of words may have another order.
        lines.sort_unstable();
        lines.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(lines(&again), lines(&text), "{origin}");
    Some((before, after))
}

#[test]
fn every_odd_file_is_read_by_its_own_mapping() {
    let mut read = 0;
    for case in CASES {
        let options = ReadOptions::parse(case.mapping, "map.toml").unwrap();
        read += usize::from(check(case.bytes, "f.csv", &options).is_some());
    }
    assert!(read > 80, "{read}");
}

#[test]
fn every_sample_and_fixture_is_read_by_its_own_mapping() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut read = 0;
    for folder in ["tests/fixtures", "../../samples", "../../samples/test"] {
        for file in std::fs::read_dir(here.join(folder)).unwrap() {
            let path = file.unwrap().path();
            let Ok(bytes) = std::fs::read(&path) else { continue };
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            read += usize::from(check(&bytes, &name, &ReadOptions::default()).is_some());
        }
    }
    assert!(read > 15, "{read}");
}

#[test]
fn guesses_become_lines_with_their_reasons() {
    let text = "Time;FIC1.PV [m3/h];FIC1.OP;FIC1.MODE;FIC1.PV.Quality;Room\n\
                27.10.2024 02:30:00;1,5;8,5;1;192;21\n\
                27.10.2024 02:45:00;1,6;9,5;0;0;21\n";
    let options = ReadOptions::default();
    let (before, after) = check(text.as_bytes(), "wide.csv", &options).unwrap();
    let mapping = mapping_of(text.as_bytes(), "wide.csv", &options).unwrap();
    for line in [
        "zone = \"UTC\"  # the times have no zone; name the zone of the plant",
        "time_format = \"day-first\"  # date and time, day first",
        "\"FIC1.PV [m3/h]\" = \"FIC1.pv\"  # it ends with PV, a word for PV",
        "Room = \"ignore\"  # it is not the name of a signal of a loop",
        "1 = \"auto\"  # a common mode code or switch",
        "0 = \"manual\"  # a common mode code or switch",
        "192 = \"good\"  # OPC DA codes",
        "0 = \"bad\"  # OPC DA codes",
        "[loop.\"FIC1\"]",
        "type = \"flow\"  # by the letters of its tag, by the file, or given",
        "op_range = [0, 100]  # estimated; 8 to 100 wide is plausible",
        "# Note: OP is between 8.5 and 9.5, has no unit, and is interpreted as percent with the range 0 to 100 (4 to 20, 3 to 15, 0 to 10, \
         2 to 10 would fit, too); if the range is different, give op_range 4,20",
    ] {
        assert!(mapping.lines().any(|each| each == line), "{line}\n{mapping}");
    }
    let notes = |reading: &Reading| reading.notes.len() + reading.recordings[0].notes.len();
    assert!(notes(&before) >= 4 && notes(&after) == 0, "{:?}", after.notes);
}

/// One meaning for a whole file would be wrong for one of its loops, so the file decides again.
#[test]
fn a_code_with_two_meanings_is_left_to_the_file() {
    let text = "t,A.OP,A.AUTO,B.OP,B.MAN\n0,50,1,50,1\n1,51,0,50,1\n2,52,1,51,0\n";
    let mapping = mapping_of(text.as_bytes(), "two.csv", &ReadOptions::default()).unwrap();
    assert!(mapping.contains("# 1 has several meanings in this file"), "{mapping}");
    assert!(!mapping.contains("= \"auto\""), "{mapping}");
    check(text.as_bytes(), "two.csv", &ReadOptions::default()).unwrap();
}
