//! A real valve's parameters, a slow triangle of air pressure, and what the stem does with it.
//!
//! Run with `cargo run --example physical_stem`.

use stiction_model::stem::{EventKind, PressureSignal, Stem, StemStart};

fn main() -> stiction_model::Result<()> {
    let stem = Stem::named("cts-stribeck")?;
    let valve = stem.equivalent()?;
    println!(
        "S = {:.2} %, J = {:.2} % of stroke; slow ramps make a {:?}",
        valve.bands.s(),
        valve.bands.j(),
        valve.sliding
    );

    let low = stem.parameters().pressure_pa(0.0);
    let high = stem.parameters().pressure_pa(100.0);
    let triangle = PressureSignal::from_points(vec![(0.0, low), (100.0, high), (200.0, low)])?;
    let times: Vec<f64> = (0..=10).map(|i| 20.0 * f64::from(i)).collect();
    let response = stem.simulate(&triangle, StemStart::at_rest(0.0), &times)?;

    println!("\n   t, s   pressure, kPa   position, %   friction, N");
    for sample in &response.samples {
        println!(
            "{:7.1} {:15.3} {:13.4} {:13.2}",
            sample.time_s,
            sample.pressure_pa / 1e3,
            stem.parameters().percent(sample.position_m),
            sample.friction_n
        );
    }

    println!("\nfirst events");
    for event in response.events.iter().take(6) {
        let what = match event.kind {
            EventKind::Slip => "slips from",
            EventKind::Stop => "stops at",
            EventKind::Reversal => "turns at",
            EventKind::EndStop => "meets the end stop at",
        };
        let percent = stem.parameters().percent(event.position_m);
        println!("{:12.6} s  {what} {percent:.4} %", event.time_s);
    }
    Ok(())
}
