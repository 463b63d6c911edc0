//! Writes a plant of many loops, to try the lab on: `cargo run -p stiction-lab --example big_plant -- FOLDER [LOOPS]`.
//!
//! Twenty loops are copied from `stiction plant demo`, with two judged days of data. The windows of the other loops, of
//! four weeks, are invented.

#[path = "../../stiction-plant/tests/made_up/mod.rs"]
mod made_up;

use made_up::{DAYS, MadeUp};
use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use stiction_plant::plant_file::{self, Plant};
use stiction_plant::{ScanOptions, demo, scan, take};

/// Loops with data, and their days.
const REAL: (usize, usize) = (20, 2);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("name a folder")?;
    let loops: usize = arguments.next().map_or(Ok(1000), |text| text.parse())?;
    let folder = Path::new(&folder);
    demo::write(folder, REAL.0, REAL.1, 1, || {})?;
    let path = folder.join(plant_file::NAME);
    let mut text = std::fs::read_to_string(&path)?.replacen("Demo", "North refinery", 1);
    let made_up = MadeUp {
        loops: loops.saturating_sub(REAL.0),
        first_number: 2001,
        // The last days are those of the demo.
        first_day: demo::FIRST_DAY + REAL.1 as i64 - DAYS,
        late_days: REAL.1 as i64,
    };
    text += &made_up.plant_toml();
    std::fs::write(&path, text)?;
    let plant = Plant::read(folder)?;
    let rows = made_up.rows();
    take(folder, &plant, &rows, &[])?;
    let done = scan(folder, &plant, &ScanOptions::default(), |_| ControlFlow::Continue(()))?;
    println!("{} windows made up, {} judged; {loops} loops", rows.len(), done.windows);
    Ok(())
}
