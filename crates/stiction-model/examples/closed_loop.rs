//! A flow loop with a sticking valve, noise and a load step: what stiction does to it.
//!
//! `cargo run -p stiction-model --example closed_loop`
use stiction_model::closed_loop::{AntiWindup, ClosedLoop, Controller, Process, Signal};
use stiction_model::valve::{Assembly, Model, StemLag};
use stiction_model::{Bands, Result};

fn main() -> Result<()> {
    println!("S and J (%)    period (s)   PV half p-p   valve travel (%/s)");
    for (s, j) in [(0.0, 0.0), (2.0, 1.0), (5.0, 1.0), (5.0, 3.0), (8.0, 6.0)] {
        let model = Model::TwoPhase.build(Bands::from_s_j(s, j)?)?;
        let valve = Assembly::new(model).with_limits(0.0, 100.0)?.with_lag(StemLag::new(0.3, 0.1)?);
        let mut flow = ClosedLoop::new(
            Controller::pi(0.8, 4.0)?.with_limits(0.0, 100.0, AntiWindup::Clamping)?,
            valve,
            Process::first_order(1.0, 3.0, 0.8)?,
        );
        (flow.op_rest, flow.pv_rest) = (50.0, 50.0);
        flow.set_point = 50.0.into();
        flow.load = vec![Signal::step(0.0, 4.0, 60.0)];
        flow.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: 1 }];
        let result = flow.statistics()?;
        let period = result.period_s.map_or("none".to_owned(), |t| format!("{t:.1}"));
        println!(
            "{s:4.1} {j:4.1} {period:>14} {:13.3} {:14.3}",
            result.pv_half_pp, result.travel_per_s
        );
    }
    Ok(())
}
