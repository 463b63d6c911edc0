//! Any bytes are recordings or an error, with any of a few options; what was read is consistent.
#![no_main]

use libfuzzer_sys::fuzz_target;
use stiction_io::{ReadOptions, reading};

/// Mapping files, one of which the first byte chooses.
const MAPPINGS: [&str; 6] = [
    "",
    "zone = \"Europe/Berlin\"",
    "time_format = \"day-first\"\nzone = \"America/St_Johns\"",
    "time_format = \"%d.%m.%Y %H:%M:%S\"\nbad_text = [\"x\"]",
    "sample_time = 0.5\n[loop.A]\nop = \"a\"\npv = \"b\"\nop_range = [4, 20]",
    "time_format = \"excel\"\npattern = \"{signal}>{loop}\"\n[signals]\nop = [\"y\"]\n[quality]\n\"0\" = \"good\"",
];

fuzz_target!(|bytes: &[u8]| {
    let Some((choice, bytes)) = bytes.split_first() else { return };
    let mapping = MAPPINGS[usize::from(*choice) % MAPPINGS.len()];
    let options = ReadOptions::parse(mapping, "map.toml").expect("a well-formed mapping");
    let Ok(reading) = reading::parse(bytes, "fuzz.csv", &options) else { return };
    assert!(!reading.recordings.is_empty());
    for recording in &reading.recordings {
        assert!(recording.op.time.iter().all(|time| time.is_finite()));
        for (value, quality) in recording.op.values.iter().zip(&recording.op.quality) {
            assert_eq!(value.is_finite(), quality.is_usable());
        }
    }
});
