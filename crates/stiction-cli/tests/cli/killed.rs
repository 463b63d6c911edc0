//! Scans that are killed at any moment.

use crate::{folder, run};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Kills in the usual test; a longer one takes its number from `STICTION_KILLS`.
const KILLS: usize = 6;

/// The index of the store, by file.
fn index(plant: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(plant.join(".stiction/index")).unwrap().map(|entry| {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name, std::fs::read(path).unwrap())
    });
    files.filter(|(name, _)| name != "through").collect()
}

#[test]
fn a_scan_that_is_killed_goes_on_where_it_was() {
    let folder = folder("killed");
    run(&folder, &["plant", "demo", "--loops", "12", "--days", "2", "-o", "p"]).quiet_success();
    let plant = folder.join("p");
    let scan = ["plant", "-C", "p", "scan", "--json"];
    let begin = Instant::now();
    let whole = run(&folder, &scan).json()["windows"].as_u64().unwrap();
    let lasts = begin.elapsed().as_secs_f64();
    let undisturbed = index(&plant);
    let store = plant.join(".stiction");

    let kills = std::env::var("STICTION_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(KILLS);
    let (mut seed, mut cut_short, mut finished) = (12_345_u64, 0, 0);
    std::fs::remove_dir_all(&store).unwrap();
    for _ in 0..kills {
        // Knuth's generator: any moments will do, as long as they differ.
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let share = (seed >> 33) as f64 / 2f64.powi(31);
        let mut child = Command::new(env!("CARGO_BIN_EXE_stiction"))
            .args(scan)
            .current_dir(&folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs_f64(share * lasts));
        child.kill().unwrap();
        cut_short += usize::from(!child.wait().unwrap().success());
        if share > 0.7 {
            // It goes on, and then there is nothing to do.
            let rest = run(&folder, &scan).json()["windows"].as_u64().unwrap();
            assert!(rest <= whole);
            assert_eq!(run(&folder, &scan).json()["windows"], 0);
            assert!(index(&plant) == undisturbed, "after {cut_short} kills");
            std::fs::remove_dir_all(&store).unwrap();
            finished += 1;
        }
    }
    run(&folder, &scan).json();
    assert!(index(&plant) == undisturbed);
    eprintln!("{kills} scans, {cut_short} killed, {} stores compared", finished + 1);
    assert!(cut_short > 0);
}
