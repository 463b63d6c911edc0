//! Which records look stuck and have too few slips to say so.

use stiction_diagnose::diagnose::few_slips::LOOKS_STUCK_FROM;
use stiction_diagnose::diagnose::{Weighing, few_slips};
use stiction_diagnose::recording::{Grid, GridOptions};
use stiction_population::LoopKind;

#[test]
fn only_what_looks_stuck_misses_slips() {
    let mut told = 0;
    for seed in 1..=40 {
        let recording = LoopKind::Sticky.simulate(seed).unwrap().recording;
        let grid = Grid::of(&recording, &GridOptions::default()).unwrap();
        let segment = grid.longest().unwrap();
        let weighing = Weighing::of(segment).unwrap();
        if let Some(few) = few_slips(&weighing, segment.duration()) {
            assert!(few.seen < few.needed && few.step > 0.0);
            assert!(weighing.probability >= LOOKS_STUCK_FROM);
            told += 1;
        }
    }
    assert!((3..30).contains(&told), "{told} of 40");
}
