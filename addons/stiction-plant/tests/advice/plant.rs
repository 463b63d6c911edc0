//! What a plant's report asks for, followed: in the next week the loop is its sibling without the fault.

use std::ops::ControlFlow;
use stiction_plant::action::Action;
use stiction_plant::log::Log;
use stiction_plant::plant_file::Plant;
use stiction_plant::ranking::{LoopRow, rank};
use stiction_plant::{ScanOptions, Store, scan};
use stiction_population::LoopKind;

/// 2026-03-02 and a week later, both 06:00 UTC.
const MONDAYS: [f64; 2] = [1_772_431_200.0, 1_773_036_000.0];
/// The siblings of a seed share process, noise and loads, so the ordinary one is the loop after the work: its valve repaired, its
/// controller retuned, the loop upstream calmed.
const KINDS: [LoopKind; 4] =
    [LoopKind::Sticky, LoopKind::AggressiveTuning, LoopKind::Sine, LoopKind::Stuck];
const SEEDS: std::ops::Range<u64> = 512..519;

/// The loop of this kind and seed in the first week, and its ordinary sibling in the second.
fn file(kind: LoopKind, seed: u64) -> String {
    let mut text = "time,PV,OP\n".to_owned();
    for (kind, from) in [kind, LoopKind::Normal].into_iter().zip(MONDAYS) {
        let of = kind.simulate(seed).unwrap().recording;
        let pv = of.pv.unwrap().values;
        for (k, t) in of.op.time.iter().enumerate() {
            text += &format!("{},{},{}\n", from + t, pv[k], of.op.values[k]);
        }
    }
    text
}

#[test]
fn each_action_leaves_a_loop_that_needs_none() {
    let folder = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("advice-plant");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let head = "name = \"N\"\nzone = \"UTC\"\ndata = [\"*.csv\"]\n";
    std::fs::write(folder.join("plant.toml"), head).unwrap();
    for (k, kind) in KINDS.into_iter().enumerate() {
        for seed in SEEDS {
            std::fs::write(folder.join(format!("F{k}{seed}.csv")), file(kind, seed)).unwrap();
        }
    }
    let plant = Plant::read(&folder).unwrap();
    scan(&folder, &plant, &ScanOptions::default(), |_| ControlFlow::Continue(())).unwrap();
    let rows = Store::of(&folder).rows().unwrap();
    let of_week = |week: &str| -> Vec<LoopRow> {
        let ranking = rank(&plant, &Log::default(), &rows, &[], week.parse().unwrap());
        ranking.loops.into_iter().map(|ranked| ranked.row).collect()
    };
    let (before, after) = (of_week("2026-W10"), of_week("2026-W11"));
    for row in &before {
        let next = after.iter().find(|next| next.name == row.name).unwrap();
        assert_eq!(next.action, Action::Leave, "{} after {:?}", row.name, row.action);
    }
    for action in Action::ALL {
        assert!(before.iter().any(|row| row.action == action), "{action:?} is not advised");
    }
}
