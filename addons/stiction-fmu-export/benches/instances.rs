//! 1,000 valves, or as many as are asked for (`-- 10`), 10,000 samples each: what FMI costs beside the library itself.
//!
//! An importer loads the library, the one that FMUs hold, and, sample by sample and valve by valve, sets OP, takes a step and
//! gets VP. Its peers: the same valves in a vector, stepped directly; and three C functions that do the
//! same and check nothing. The machine is shared: rounds alternate, and the best of each is printed.
#![allow(unsafe_code)]

#[path = "../../stiction-fmu/tests/common/library.rs"]
mod library;

use std::ffi::c_int;
use std::hint::black_box;
use std::time::Instant;

use library::{C, Importer, Library, Three, Two};
use stiction_fmu::Fmu;
use stiction_model::Bands;
use stiction_model::valve::{Assembly, Model, Start, Valve};

const SAMPLES: usize = 10_000;
const ROUNDS: usize = 7;

/// What three calls cost that do the same and check nothing.
struct Bare {
    op: f64,
    vp: f64,
    valve: Assembly,
}

unsafe extern "C" fn bare_set(c: C, _: *const u32, _: usize, value: *const f64) -> c_int {
    // SAFETY: this program calls it with a `Bare` and a value.
    unsafe { (*c.cast::<Bare>()).op = *value };
    0
}

unsafe extern "C" fn bare_step(c: C, _: f64, _: f64, _: c_int) -> c_int {
    // SAFETY: see above.
    let bare = unsafe { &mut *c.cast::<Bare>() };
    bare.vp = bare.valve.step(bare.op);
    0
}

unsafe extern "C" fn bare_get(c: C, _: *const u32, _: usize, value: *mut f64) -> c_int {
    // SAFETY: see above.
    unsafe { *value = (*c.cast::<Bare>()).vp };
    0
}

/// Seconds that all steps take, and the sum of all VP.
fn imported(importer: &impl Importer, instances: &[C], op: &[f64]) -> (f64, f64) {
    let began = Instant::now();
    let mut sum = 0.0;
    for (k, op) in op.iter().enumerate() {
        for instance in instances {
            sum += importer.step(*instance, k as f64, 1.0, *op);
        }
    }
    (began.elapsed().as_secs_f64(), sum)
}

fn valve() -> Assembly {
    let bands = Bands::from_s_j(5.0, 2.0).unwrap();
    let mut valve = Assembly::new(Model::TwoPhase.build(bands).unwrap());
    valve.restart(Start::at_rest(0.0));
    valve
}

/// The same by the library itself.
fn direct(instances: usize, op: &[f64]) -> (f64, f64) {
    let mut valves = vec![valve(); instances];
    let began = Instant::now();
    let mut sum = 0.0;
    for op in op {
        for valve in &mut valves {
            sum += valve.step(black_box(*op));
        }
    }
    (began.elapsed().as_secs_f64(), sum)
}

fn main() {
    // Cargo adds an option of its own.
    let asked = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let instances = asked.map_or(1_000, |count| count.parse().expect("a number of valves"));
    let mut op = 50.0;
    // About 50 %, with reversals and pauses.
    let wandering = |k: usize| {
        op += if k.is_multiple_of(7) { 0.0 } else { (0.05 * k as f64).sin() - 0.01 * (op - 50.0) };
        op
    };
    let op: Vec<f64> = (0..SAMPLES).map(wandering).collect();

    let fmu = Fmu::new("valve", "two-phase").unwrap();
    let token = fmu.token();
    let resources = std::env::temp_dir().join(format!("stiction-fmu-{}", std::process::id()));
    std::fs::create_dir_all(&resources).unwrap();
    std::fs::write(resources.join("stiction.json"), fmu.json()).unwrap();
    let file = resources.join("library");
    std::fs::write(&file, &stiction_fmu_export::Library::own().unwrap()[0].bytes).unwrap();
    let library = Library::open(file);
    let two = black_box(Two::of(&library));
    let three = black_box(Three::of(&library));
    let unchecked =
        black_box(Two { set: bare_set, step: bare_step, get: bare_get, ..Two::of(&library) });

    let mut best = [f64::INFINITY; 4];
    for _ in 0..ROUNDS {
        let twos: Vec<C> = (0..instances).map(|_| two.start(&resources, &token)).collect();
        let threes: Vec<C> = (0..instances).map(|_| three.start(&resources, &token)).collect();
        let mut bares: Vec<_> =
            (0..instances).map(|_| Bare { op: 0.0, vp: 0.0, valve: valve() }).collect();
        let bares: Vec<C> = bares.iter_mut().map(|bare| std::ptr::from_mut(bare).cast()).collect();
        let found = [
            direct(instances, &op),
            imported(&unchecked, &bares, &op),
            imported(&two, &twos, &op),
            imported(&three, &threes, &op),
        ];
        for (best, (seconds, sum)) in best.iter_mut().zip(found) {
            assert_eq!(sum, found[0].1);
            *best = best.min(seconds);
        }
        twos.into_iter().for_each(|c| two.free(c));
        threes.into_iter().for_each(|c| three.free(c));
    }
    std::fs::remove_dir_all(&resources).unwrap();
    let each = 1e9 / (instances * SAMPLES) as f64;
    for (name, seconds) in ["library", "3 C calls", "FMI 2.0", "FMI 3.0"].into_iter().zip(best) {
        println!("{name:9} {:5.1} ns a step, {:.2} times", seconds * each, seconds / best[0]);
    }
}
