//! Writes a plant of many loops, to try the lab on: `cargo run -p stiction-lab --example big_plant -- FOLDER [LOOPS]`.
//!
//! Twenty loops are those of `stiction plant demo`, with two days of data, and judged; the windows of the others, of four
//! weeks, are made up.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use stiction_plant::plant_file::{self, Plant};
use stiction_plant::{ScanOptions, WindowRow, demo, scan, take};

/// Loops with data, and their days.
const REAL: (usize, usize) = (20, 2);
const DAYS: i64 = 28;
const AREAS: [&str; 5] = ["Crude", "Vacuum", "Reformer", "Utilities", "Tank farm"];

/// A number from 0 to 1 that looks like chance, the same for the same `k`.
fn chance(k: usize) -> f64 {
    let mixed = (k as u64)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .rotate_left(29)
        .wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 11) as f64 / (1u64 << 53) as f64
}

fn name(k: usize) -> String {
    format!("{}IC{}", ["F", "L", "P", "T"][k % 4], 2001 + k)
}

/// Windows of a loop that is made up.
fn rows(k: usize) -> Vec<WindowRow> {
    let window = |day: i64| {
        let late = day >= DAYS - 2;
        let sticks = match k % 14 {
            0 | 1 => true,
            2 if k.is_multiple_of(5) => late,
            3 if k.is_multiple_of(5) => !late,
            _ => false,
        };
        let chance = |n: usize| chance(1000 * k + 10 * day as usize + n);
        let p = if sticks { 0.9 + 0.09 * chance(0) } else { 0.05 + 0.2 * chance(0) };
        let (class, grade) = match p {
            p if p > 0.92 => ("sticks", "sticks"),
            p if p > 0.5 => ("cannot tell", "probably sticks"),
            p if p < 0.1 => ("does not stick", "fine"),
            _ => ("cannot tell", "probably fine"),
        };
        let s = sticks.then(|| {
            (1.0 + (k % 9) as f64) * (1.0 + 0.008 * day as f64) * (1.0 + 0.05 * chance(1))
        });
        let identity = WindowRow {
            name: name(k),
            loop_type: ["flow", "level", "pressure", "temperature"][k % 4].to_owned(),
            // The last days are those of the demo.
            window_start: (demo::FIRST_DAY + REAL.1 as i64 - DAYS + day) * 86_400,
            window_s: 86_400,
            error: (k % 97 == 11).then(|| "its PV has no sample that can be used".to_owned()),
            ..WindowRow::default()
        };
        if identity.error.is_some() {
            return identity;
        }
        let other = ["aggressive tuning", "external oscillation", "normal operation"][k % 3];
        WindowRow {
            samples: Some(8640),
            auto_share: Some(if k % 89 == 7 { 0.0 } else { 100.0 - 9.0 * chance(2) }),
            stretch_start_s: Some(0.0),
            stretch_s: Some(86_400.0),
            fitness: Some("fit".to_owned()),
            oscillates: Some(!k.is_multiple_of(3) || sticks),
            period_s: Some(60.0 + (k % 50) as f64 * 17.0),
            amplitude: Some(1.0 + chance(3)),
            travel_per_hour: Some(30.0 + 300.0 * chance(4)),
            reversals_per_hour: Some(20.0 + 80.0 * chance(5)),
            at_limit_share: Some(3.0 * chance(6)),
            verdict: Some(class.to_owned()),
            grade: Some(grade.to_owned()),
            probability: Some(p),
            evidence_windows: Some(4.0),
            s,
            s_low: s.map(|s| 0.9 * s),
            s_high: s.map(|s| 1.1 * s),
            j: s.map(|s| 0.4 * s),
            j_low: s.map(|s| 0.2 * s),
            j_high: s.map(|s| 0.6 * s),
            s_below: (!sticks).then_some(1.2),
            alternative: Some(other.to_owned()),
            alternative_likelihood: Some(0.4 + 0.3 * chance(7)),
            ..identity
        }
    };
    (0..DAYS).map(window).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("name a folder")?;
    let loops: usize = arguments.next().map_or(Ok(1000), |text| text.parse())?;
    let folder = Path::new(&folder);
    demo::write(folder, REAL.0, REAL.1, 1, || {})?;
    let path = folder.join(plant_file::NAME);
    let mut text = std::fs::read_to_string(&path)?.replacen("Demo", "North refinery", 1);
    for (k, area) in AREAS.iter().enumerate() {
        text += &format!("[area.\"{area}\"]\nweight = {}\n", 1 + k % 3);
    }
    let made_up = loops.saturating_sub(REAL.0);
    for k in 0..made_up {
        let (area, unit, weight) = (AREAS[k * 7 % 31 % 5], 100 + k % 6, 1 + k % 5);
        text += &format!(
            "[loop.{}]\narea = \"{area}\"\nunit = \"C-{unit}\"\nweight = {weight}\nwatch = {}\n",
            name(k),
            k % 50 == 3
        );
    }
    std::fs::write(&path, text)?;
    let plant = Plant::read(folder)?;
    let rows: Vec<WindowRow> = (0..made_up).filter(|k| k % 97 != 5).flat_map(rows).collect();
    take(folder, &plant, &rows, &[])?;
    let done = scan(folder, &plant, &ScanOptions::default(), |_| ControlFlow::Continue(()))?;
    println!("{} windows made up, {} judged; {loops} loops", rows.len(), done.windows);
    Ok(())
}
