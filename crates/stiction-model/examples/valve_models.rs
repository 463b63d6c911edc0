//! All models on one slow ramp up and down: where each stem ends, and how often it jumped.
//!
//! `cargo run -p stiction-model --example valve_models`
use stiction_model::valve::{Model, Start, Valve};
use stiction_model::{Bands, Result};

fn main() -> Result<()> {
    let op: Vec<f64> = (0..=800).map(|k| 50.0 + 10.0 - 0.05 * f64::from(k - 400).abs()).collect();
    let bands = Bands::from_s_j(5.0, 2.0)?;
    println!("S = {} %, J = {} %; input 40 to 60 and back to 40 %\n", bands.s(), bands.j());
    println!("model        top     end   jumps");
    for model in Model::ALL {
        let mut valve = model.build(bands)?;
        valve.restart(Start::at_rest(op[0]));
        let mut vp = vec![0.0; op.len()];
        valve.run(&op, &mut vp)?;
        let top = vp.iter().copied().fold(f64::MIN, f64::max);
        let jumps = vp.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > 1.0).count();
        println!("{:10} {top:6.2}  {:6.2}  {jumps:4}", model.describe().name, vp[op.len() - 1]);
    }
    Ok(())
}
