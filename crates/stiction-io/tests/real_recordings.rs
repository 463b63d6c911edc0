//! Recordings of real plants, kept outside the project; skipped where they are missing.

use std::path::{Path, PathBuf};
use stiction_io::ReadOptions;
use stiction_io::layout::Layout;
use stiction_io::reading;
use stiction_recording::recording::{ByHand, Recording};

fn csv_files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return vec![] };
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "csv"))
        .filter(|path| path.file_stem().is_some_and(|stem| stem != "index"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_real_recording_is_read() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    if !data.is_dir() {
        println!("skipped: there are no real recordings beside the project");
        return;
    }
    let mut read = 0;
    for (folder, has_pv, has_vp, has_mode) in [
        ("isdb", None, false, false),
        ("plant", Some(true), false, true),
        ("damadics", Some(true), true, false),
        ("week", Some(true), false, false),
    ] {
        for path in csv_files(&data.join(folder)) {
            let reading =
                reading::read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
            let name = path.display();
            assert_eq!((reading.layout, reading.recordings.len()), (Layout::OneLoop, 1), "{name}");
            let recording = &reading.recordings[0];
            assert_eq!(Some(&*recording.name), path.file_stem().and_then(|s| s.to_str()));
            assert!(recording.op.usable_share() > 0.9, "{name}");
            assert!(has_pv.is_none_or(|has| recording.pv.is_some() == has), "{name}");
            assert_eq!(recording.vp.is_some(), has_vp, "{name}");
            assert_eq!(recording.mode.is_some(), has_mode, "{name}");
            // Operation is no test, even where the mode is not recorded.
            let without = Recording { mode: None, ..recording.clone() };
            assert!(ByHand::of(&without).is_none_or(|by_hand| !by_hand.is_test()), "{name}");
            read += 1;
        }
    }
    println!("read {read} recordings");
}
