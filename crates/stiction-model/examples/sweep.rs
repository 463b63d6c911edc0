//! How period and amplitude of the paper's loop depend on S and J: 10,000 loops at once.
//!
//! `cargo run --release -p stiction-model --example sweep`
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, sweep};
use stiction_model::valve::{Assembly, Model};
use stiction_model::{Bands, Result};

fn main() -> Result<()> {
    let mut loops = vec![];
    for s in 1..=100 {
        for j in 1..=100 {
            let s = 0.1 * f64::from(s);
            let bands = Bands::from_s_j(s, s * f64::from(j) / 100.0)?;
            let mut sticky = ClosedLoop::new(
                Controller::pi(1.1, 2.5)?,
                Assembly::new(Model::TwoPhase.build(bands)?),
                Process::first_order(1.5, 5.93, 1.07)?,
            );
            sticky.set_point = 5.0.into();
            sticky.samples = 10_000;
            loops.push(sticky);
        }
    }
    let statistics = sweep(&loops)?;
    println!("S = 10 %; J in %, period in s, half peak-to-peak of the PV");
    for j in [20, 40, 60, 80, 100] {
        let row = &statistics[99 * 100 + j - 1];
        let period = row.period_s.map_or("none".to_owned(), |t| format!("{t:6.2}"));
        println!("J = {:4.1}   {period}   {:.3}", 0.1 * j as f64, row.pv_half_pp);
    }
    Ok(())
}
