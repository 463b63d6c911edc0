//! The Rust side of the comparison in `python/benchmarks/overhead.py`, with the same two computations. Prints the
//! best times in s of a valve over a million samples, with a newly allocated result each time, and of a diagnosis.
use std::hint::black_box;
use std::time::Instant;
use stiction::Bands;
use stiction::diagnose::{DiagnoseOptions, diagnose};
use stiction::io::{ReadOptions, reading};
use stiction::valve::{Assembly, Model, Start, Valve};

fn best(mut run: impl FnMut(), times: usize) -> f64 {
    let timed = |_| {
        let begin = Instant::now();
        run();
        begin.elapsed().as_secs_f64()
    };
    (0..times).map(timed).fold(f64::INFINITY, f64::min)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let op: Vec<f64> = (0..1_000_000).map(|k| 50.0 + 12.0 * (f64::from(k) * 0.011).sin()).collect();
    // The compiler must not know the model, because Python's does not know it either.
    let mut valve = black_box(Assembly::new(Model::TwoPhase.build(Bands::from_s_j(5.0, 2.0)?)?));
    let follow = best(
        || {
            valve.restart(Start::at_rest(50.0));
            let mut vp = vec![0.0; op.len()];
            valve.run(black_box(&op), &mut vp).expect("the OP is finite");
            black_box(vp);
        },
        50,
    );
    let path = std::env::args().nth(1).ok_or("which recording?")?;
    let recordings = reading::read(path.as_ref(), &ReadOptions::default())?.recordings;
    let options = DiagnoseOptions::default();
    let diagnosis = best(
        || _ = black_box(diagnose(black_box(&recordings[0]), &options).expect("it has a grid")),
        100,
    );
    println!("{follow:e} {diagnosis:e}");
    Ok(())
}
